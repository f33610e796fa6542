#include "tools/scan_target.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <map>
#include <utility>

#include "geometry/first_touch.h"
#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/surface_of_revolution.h"
#include "solver/accuracy.h"
#include "solver/results.h"
#include "solver/scanned_state.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

std::string Ending(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return ending;
}

// Twice the number of triangles is that of directed edges; each has its opposite, once.
bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> count;
  for (const std::array<int, 3>& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
  }
  return std::all_of(count.begin(), count.end(), [&](const auto& edge) {
    const auto opposite = count.find({edge.first.second, edge.first.first});
    return edge.second == 1 && opposite != count.end() && opposite->second == 1;
  });
}

double Volume(const TriangleMesh& mesh) {
  double volume = 0.0;
  const Eigen::Vector3d origin = mesh.vertices[0];
  for (const std::array<int, 3>& t : mesh.triangles) {
    std::array<Eigen::Vector3d, 3> x;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = mesh.vertices[static_cast<std::size_t>(t[k])] - origin;
    }
    volume += x[0].dot(x[1].cross(x[2])) / 6.0;
  }
  return volume;
}

}  // namespace

bool IsSceneFile(const std::string& file) {
  const std::string ending = Ending(file);
  return ending == ".yaml" || ending == ".yml";
}

int SolveScanScene(const std::string& file,
                   const ScanTargetOptions& options,
                   ScanTarget* target,
                   std::string* error) {
  Scene scene;
  SolverOptions solver;
  std::vector<std::string> overridden;
  if (!SolverOptionsFromFlags(&solver, error) ||
      !ReadSceneWithFlags(file, &scene, &overridden, error)) {
    return kExitBadInput;
  }
  solver.stop = StopOnSignal();
  progress::Watch(!scene.model.accuracy.has_value(), "", &solver);
  SolverSummary summary;
  AccuracyReport accuracy;
  const bool posed =
      scene.model.accuracy
          ? SolveToAccuracy(
                scene, solver, AccuracyOptions(), &target->problem, &summary, &accuracy, error)
          : Solve(scene, solver, &target->problem, &summary, error);
  // From here on the first signal ends the tool: nothing is written until all is there.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (!posed) return kExitBadInput;
  if (solver.stop->load()) {
    *error = "interrupted, nothing is scanned";
    return kExitNotConverged;
  }
  if (!summary.IsConverged() || summary.steps.empty()) {
    *error = "not converged, nothing is scanned: " + summary.message;
    return kExitNotConverged;
  }
  if (scene.model.accuracy && !accuracy.reached) {
    *error = "model.accuracy is not reached, nothing is scanned: " + accuracy.message;
    return kExitNotConverged;
  }
  const int num_steps = static_cast<int>(summary.steps.size());
  if (options.state > num_steps) {
    FailFlag("state", "1 to " + std::to_string(num_steps) + ", or 0 for the last", error);
    return kExitBadInput;
  }
  // The summary of this state.
  if (options.state > 0) summary.steps.resize(static_cast<std::size_t>(options.state));
  const LoadStep& step = summary.steps.back();
  if (!step.converged || !step.displacements.allFinite()) {
    *error = "load step " + std::to_string(summary.steps.size()) +
             " has not converged, nothing is scanned";
    return kExitNotConverged;
  }
  target->thickness = scene.shell.thickness;
  target->surface = ScannedFace(
      *target->problem, step, options.vertices ? ScanSampling::kVertices : ScanSampling::kArea);
  if (!FingersOf(scene, step, &target->occluders, error)) return kExitBadInput;
  target->summary = summary;
  const Json all = MakeSummaryJson(scene, summary, nullptr);
  Json& solution = target->solution = Json::object();
  solution["name"] = scene.name;
  solution["state"] = num_steps == 0 ? 0 : static_cast<int>(summary.steps.size());
  solution["states"] = num_steps;
  solution["load_factor"] = step.factor;
  solution["young_modulus"] = scene.shell.young_modulus;
  solution["poisson_ratio"] = scene.shell.poisson_ratio;
  solution["max_displacement"] = step.max_displacement;
  for (const char* key : {"theory", "dof", "fingers", "gas"}) solution[key] = all[key];
  solution["overridden"] = overridden;
  return kExitDone;
}

bool ReadScanSurface(const std::string& file,
                     const ScanTargetOptions& options,
                     ScanTarget* target,
                     std::string* error) {
  const auto fail = [&](const std::string& what) {
    *error = file + ":0: found " + what;
    return false;
  };
  Scene& scene = target->scene;
  if (!options.scene.empty()) {
    if (!ReadSceneToMend(options.scene, &scene, error)) return false;
    target->thickness = scene.shell.thickness;
  }
  if (options.thickness >= 0.0) target->thickness = options.thickness;
  const double offset = 0.5 * target->thickness;

  // As points first, which checks that they are finite and normals that they are unit.
  PointCloud cloud;
  if (!ReadPointCloud(file, &cloud, error)) return false;
  const bool moves = !cloud.displacements.empty();
  for (std::size_t i = 0; i < cloud.displacements.size(); ++i) {
    cloud.points[i] += cloud.displacements[i];
  }
  if (moves) cloud.normals.clear();  // Those are at rest.
  TriangleMesh mesh;
  VertexVectors unused;
  const std::string ending = Ending(file);
  const bool is_table = ending == ".csv" || ending == ".txt" || ending == ".xyz";
  if (!is_table && !ReadVertices(file, &mesh, &unused, error)) return false;
  if (options.revolve > 0) {
    if (!is_table) {
      return FailFlag("revolve", "with the points of a .csv, .txt or .xyz file", error);
    }
    std::string trouble;
    if (!Revolve(cloud.points, options.revolve, &mesh, &trouble)) {
      *error = file + ":0: " + trouble;
      return false;
    }
    // A profile may be written from either end.
    if (IsClosed(mesh) && Volume(mesh) < 0.0) {
      for (std::array<int, 3>& t : mesh.triangles) std::swap(t[1], t[2]);
    }
    cloud = PointCloud();
    cloud.points = mesh.vertices;
  }
  if (!options.faces.empty()) {
    if (!mesh.triangles.empty()) {
      return FailFlag("faces", "with points; " + file + " has faces", error);
    }
    if (!ReadVertices(options.faces, &mesh, &unused, error)) {
      *error = "--faces: " + *error;
      return false;
    }
    if (mesh.triangles.empty() || mesh.vertices.size() != cloud.points.size()) {
      *error = "--faces: " + options.faces + ":0: found " + std::to_string(mesh.triangles.size()) +
               " triangles and " + std::to_string(mesh.vertices.size()) +
               " vertices; allowed a mesh with as many vertices as " + file + " has points, " +
               std::to_string(cloud.points.size());
      return false;
    }
  }
  if (!mesh.triangles.empty()) {
    mesh.vertices = cloud.points;
    // Vertices of no face would count for the extent.
    std::vector<int> index(mesh.vertices.size(), -1);
    for (const std::array<int, 3>& t : mesh.triangles) {
      for (const int v : t) index[static_cast<std::size_t>(v)] = 0;
    }
    TriangleMesh used;
    std::vector<Eigen::Vector3d> normals;
    for (std::size_t v = 0; v < index.size(); ++v) {
      if (index[v] < 0) continue;
      index[v] = static_cast<int>(used.vertices.size());
      used.vertices.push_back(mesh.vertices[v]);
      if (!cloud.normals.empty()) normals.push_back(cloud.normals[v]);
    }
    used.triangles = std::move(mesh.triangles);
    for (std::array<int, 3>& t : used.triangles) {
      for (int& v : t) v = index[static_cast<std::size_t>(v)];
    }
    if (IsClosed(used) && Volume(used) < 0.0) {
      return fail(
          "a closed mesh wound inwards; allowed triangles that are counterclockwise seen "
          "from outside");
    }
    target->surface = ScanSurfaceOf(std::move(used), std::move(normals), offset);
    if (options.vertices) ScanVertices(&target->surface);
  } else {
    if (offset > 0.0 && cloud.normals.empty()) {
      return fail(moves ? "displaced points without faces and a thickness; allowed a mesh, or "
                          "--thickness=0"
                        : "points without normals or faces and a thickness; allowed normals, a "
                          "mesh, or --thickness=0");
    }
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      FacePoint point{cloud.points[i], Eigen::Vector3d::Zero()};
      if (!cloud.normals.empty()) point.normal = cloud.normals[i];
      point.position += offset * point.normal;
      target->surface.points.push_back(point);
    }
  }

  std::vector<Eigen::Vector3d> face = target->surface.mesh.vertices;
  for (const FacePoint& point : target->surface.points) face.push_back(point.position);
  for (const FingerSpec& spec : scene.fingers) {
    if (spec.shape == FingerSpec::Shape::kPin) continue;
    Occluder body;
    body.shape = MakeFinger(spec, &body.pose, error);
    if (body.shape == nullptr) return false;
    const Eigen::Vector3d direction(spec.direction[0], spec.direction[1], spec.direction[2]);
    Touch touch;
    if (!FirstTouch(*body.shape, body.pose, direction, face, 0.0, &touch)) {
      *error = spec.location.file + ":" + std::to_string(spec.location.line) + ": " +
               spec.location.key + ": found a finger that never touches " + file +
               " along its direction; allowed is the scene that the file belongs to";
      return false;
    }
    body.pose.position += touch.shift * direction;
    target->occluders.push_back(std::move(body));
    target->fingers.push_back({&spec, touch.shift});
  }
  return true;
}

}  // namespace darboux
