#include "solver/scan_results.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/point_tree.h"
#include "geometry/text_file.h"
#include "solver/fields.h"
#include "solver/robust_statistics.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

Json ToJson(const DistanceStatistics& statistics, double percent_of) {
  Json json = {{"count", statistics.count},
               {"mean", Number(statistics.mean)},
               {"mean_absolute", Number(statistics.mean_abs)},
               {"rms", Number(statistics.rms)},
               {"median_absolute", Number(statistics.median_abs)},
               {"max", Number(statistics.max)}};
  json["percent_of_max_displacement"] = nullptr;
  if (percent_of > 0.0) {
    const double factor = 100.0 / percent_of;
    json["percent_of_max_displacement"] = {{"mean_absolute", Number(factor * statistics.mean_abs)},
                                           {"rms", Number(factor * statistics.rms)},
                                           {"max", Number(factor * statistics.max)}};
  }
  json["histogram"] = {{"bin_width", Number(statistics.bin_width)},
                       {"counts", statistics.histogram}};
  return json;
}

Json ToJson(const RigidPose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Vector3d& t = pose.translation;
  return {{"rotation_wxyz", {Number(q.w()), Number(q.x()), Number(q.y()), Number(q.z())}},
          {"translation", {Number(t.x()), Number(t.y()), Number(t.z())}}};
}

Json ToJson(const RegistrationSummary& summary) {
  Json eigenvalues = Json::array();
  for (int k = 0; k < 6; ++k) eigenvalues.push_back(Number(summary.eigenvalues[k]));
  return {{"matched", summary.matched},
          {"verdict", summary.verdict},
          {"pose", ToJson(summary.pose)},
          {"iterations", summary.iterations},
          {"starts", summary.num_starts},
          {"sigma", Number(summary.sigma)},
          {"noise", Number(summary.noise)},
          {"inlier_fraction", Number(summary.inlier_fraction)},
          {"outliers", summary.outliers.size()},
          {"undetermined", summary.undetermined},
          {"equivalent_poses", summary.equivalent_poses},
          {"eigenvalues", eigenvalues}};
}

std::vector<ExtraField> MakeScanFields(const ShellFace& face,
                                       const std::vector<ShellFace::Foot>& feet,
                                       const std::vector<double>& distances,
                                       const std::vector<char>& counts) {
  const OutputMesh mesh = MakeOutputMesh(face.surface());
  ExtraField map{"scan_distance", std::vector<double>(mesh.points.size(), 0.0)};
  ExtraField coverage{"scan_coverage", std::vector<double>(mesh.points.size(), 0.0)};
  std::vector<Vector3d> positions;
  std::vector<double> values;
  for (size_t i = 0; i < feet.size(); ++i) {
    if (!counts.empty() && counts[i] == 0) continue;
    positions.push_back(feet[i].position);
    values.push_back(distances[i]);
  }
  if (positions.empty()) return {map, coverage};
  PointTree tree;
  tree.Build(positions);
  // Distance to the last of the nearest few: gaps of random points are not wider than twice it.
  constexpr int kNearest = 4;
  std::vector<double> spacing;
  for (const Vector3d& x : positions) {
    const PointTree::Neighbours near = tree.Nearest(x, kNearest + 1);
    spacing.push_back(std::sqrt(near.squared[near.count - 1]));
  }
  const double reach = 2.0 * Median(std::move(spacing));
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const PointTree::Neighbours near =
        tree.Nearest(face.Evaluate(mesh.points[i]).position, kNearest);
    int within = 0;
    double sum = 0.0;
    for (int k = 0; k < near.count; ++k) {
      if (near.squared[k] > reach * reach) continue;
      sum += values[near.index[k]];
      ++within;
    }
    coverage.values[i] = within > 0 ? 1.0 : 0.0;
    map.values[i] = within > 0 ? sum / within : values[near.index[0]];
  }
  return {map, coverage};
}

std::string MakeRegisteredPly(const std::vector<Vector3d>& scan,
                              const RigidPose& pose,
                              const std::vector<double>& distances,
                              const std::vector<char>& counts) {
  std::string text =
      "ply\nformat ascii 1.0\ncomment scan in the frame of the shell, distance > 0 outside\n"
      "element vertex " +
      std::to_string(scan.size()) + "\n";
  for (const char* name : {"x", "y", "z", "distance"}) {
    text += std::string("property double ") + name + "\n";
  }
  text += "property uchar inlier\nend_header\n";
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vector3d x = pose * scan[i];
    for (const double value : {x.x(), x.y(), x.z(), distances[i]}) {
      AppendNumber(value, &text);
      text += " ";
    }
    text += counts.empty() || counts[i] != 0 ? "1\n" : "0\n";
  }
  return text;
}

}  // namespace darboux
