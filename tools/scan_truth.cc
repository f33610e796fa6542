#include "tools/scan_truth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "geometry/shell_face.h"
#include "geometry/text_file.h"
#include "solver/results.h"
#include "solver/scan_results.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json CoordinatesJson(const Eigen::Vector3d& x) { return {x.x(), x.y(), x.z()}; }

Json MotionJson(const RigidPose& pose) {
  Json matrix = Json::array();
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) matrix.push_back(CoordinatesJson(Eigen::Vector3d(rotation.row(i))));
  return {{"rotation", matrix},
          {"quaternion_wxyz",
           {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}},
          {"translation", CoordinatesJson(pose.translation)}};
}

std::string TruthCsv(const Scan& scan) {
  std::string text =
      "# points of the face in the model's frame; outlier: 0 none, 1 spike, 2 stray (where it "
      "is);\n"
      "# noise: along the ray from the viewpoint; bias: along the normal or the ray\n"
      "x,y,z,outlier,view,noise,bias\n";
  for (const ScanTruth& truth : scan.truth) {
    AppendNumbers(truth.face.position, ',', &text);
    text += ',' + std::to_string(static_cast<int>(truth.outlier)) + ',' +
            std::to_string(truth.view) + ',';
    AppendNumber(truth.noise, &text);
    text += ',';
    AppendNumber(truth.bias, &text);
    text += '\n';
  }
  return text;
}

std::vector<std::array<int, 3>> FacesOf(const ScanSurface& surface, const Scan& scan) {
  std::vector<std::array<int, 3>> faces;
  if (surface.points.size() != surface.mesh.vertices.size()) return faces;
  std::vector<int> index(surface.points.size(), -1);
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    if (scan.truth[i].outlier == OutlierKind::kStray) continue;
    index[static_cast<std::size_t>(scan.truth[i].number)] = static_cast<int>(i);
  }
  for (std::array<int, 3> t : surface.mesh.triangles) {
    for (int& v : t) v = index[static_cast<std::size_t>(v)];
    if (*std::min_element(t.begin(), t.end()) >= 0) faces.push_back(t);
  }
  return faces;
}

Report MakeScanReport(const std::string& tool,
                      const std::string& name,
                      const ScanTarget& target,
                      const Scan& scan,
                      const std::string& unit,
                      const Json& truth) {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> errors;
  std::vector<ShellFace::Foot> feet(scan.truth.size());
  std::vector<char> counts;
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    const ScanTruth& at = scan.truth[i];
    points.push_back(scan.model_from_scan * scan.cloud.points[i]);
    const Eigen::Vector3d way = points.back() - at.face.position;
    const bool has_normal = at.face.normal.squaredNorm() > 0.0;
    errors.push_back(has_normal ? way.dot(at.face.normal) : way.norm());
    if (at.outlier == OutlierKind::kStray) errors.back() = std::nan("");
    feet[i].position = at.face.position;
    counts.push_back(at.outlier == OutlierKind::kNone ? 1 : 0);
  }
  const ReportCloud cloud = MakeCloud("scan", "error of the scan", points, errors);
  Report report = MakeReport(tool, name);
  report.header["documents"]["truth"] = truth;
  if (!unit.empty()) report.header["units"] = {{"length", unit}};
  if (target.problem == nullptr) {
    AddMeshView(name, target.surface.mesh, target.fingers, {cloud}, &report);
    return report;
  }
  const Scene& scene = target.problem->scene();
  ReportShape shape;
  shape.title = scene.name;
  shape.problem = target.problem.get();
  shape.states = StatesOf(target.summary);
  shape.clouds = {cloud};
  ShellFace face(target.problem->surface(), 0.5 * target.thickness);
  face.SetDisplacements(target.summary.steps.back().displacements);
  shape.distances = {CoveredDistance(MakeScanFields(face, feet, errors, counts))};
  AddShellView(shape, &report);
  AddHistory(scene, target.summary, &report);
  report.header["documents"]["summary"] = MakeSummaryJson(scene, target.summary, nullptr);
  return report;
}

}  // namespace darboux
