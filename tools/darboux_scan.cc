// Scans a deformed surface that needs no scanner: a scene, which is solved, or a file of anybody's.
// Sample runs:
//   darboux_scan data/tennis_ball.yaml --unit=mm --out=scan
//   darboux_scan deformed.ply --thickness=2.5 --scene=data/tennis_ball.yaml --unit=mm --out=scan
//   darboux_scan bunny.obj --noise=0.1 --outliers=0.02 --views=12 --points=50000 --out=scan
//   darboux_scan field.csv --faces=rest.obj --noise=0.1 --out=scan
//   darboux_scan data/solids/ball_4mm.csv --revolve=360 --unit=mm --digits=6 --out=scan
//
// Exit status: 0 written; 1 the scene's solution has not converged or was interrupted, or files
// cannot be written; 2 bad input. Nothing is written unless all is.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "geometry/first_touch.h"
#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/scan_simulator.h"
#include "geometry/shell_face.h"
#include "geometry/surface_of_revolution.h"
#include "geometry/text_file.h"
#include "solver/accuracy.h"
#include "solver/file_set.h"
#include "solver/report_view.h"
#include "solver/results.h"
#include "solver/scan_results.h"
#include "solver/scanned_state.h"
#include "solver/shell_solver.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(unit,
              "",
              "input | UNIT | um, mm, cm, m or in; required without --noise | Unit of length of "
              "the scene or file. Only the default of --noise depends on it.");
DEFINE_int32(state, 0, "input | K | >= 1; default: 0, the last | Load step of the scene to scan.");
DEFINE_double(thickness,
              -1.0,
              "input | LENGTH | >= 0, the file's unit; default: that of --scene, or 0 | Says that "
              "a file holds the middle surface of a shell this thick, whose outer face lies half "
              "of it outside; 0: the file is the face.");
DEFINE_string(scene,
              "",
              "input | FILE | .yaml; default: none | With a file: the scene it belongs to. Gives "
              "fingers, each moved along its direction until it touches the face, and the "
              "thickness.");
DEFINE_string(faces,
              "",
              "input | FILE | .ply, .obj, .stl or .off; default: none | With a file of points: a "
              "mesh whose vertices are these points, in their order, wherever it has them itself. "
              "Gives the triangles.");
DEFINE_int32(revolve,
             0,
             "input | N | 3 to 10000 meridians; default: 0, off | With a .csv, .txt or .xyz file "
             "of points in the half plane y = 0, x >= 0, in order along a profile: turns it about "
             "the z axis into a mesh. Of an open one the outside is away from the axis where z "
             "falls along it.");

DEFINE_int32(points,
             20000,
             "sampling | N | 1 to 10000000 | Points of the scan, outliers included; of given "
             "points at most.");
DEFINE_string(sampling,
              "area",
              "sampling | SAMPLING | area or vertices | area: random points, uniform by area; "
              "vertices: those of a mesh file, or of the mesh of deformed.ply for a scene, seen "
              "ones. Such a scan.ply has faces.");
DEFINE_int32(views,
             8,
             "sampling | N | 0 to 1000 | Viewpoints around the surface; 0: everything is seen, and "
             "rays are normals.");
DEFINE_string(views_file,
              "",
              "sampling | FILE | a point file; default: none | Viewpoints, in the model's frame, "
              "in place of --views.");
DEFINE_double(view_distance,
              5.0,
              "sampling | FACTOR | > 0, in halves of the bounding box's diagonal | Of --views from "
              "the centre of the bounding box.");
DEFINE_double(grazing,
              75.0,
              "sampling | ANGLE | in (0, 90] degrees | Largest angle between normal and ray at "
              "which a point is seen.");
DEFINE_int32(seed, 1, "sampling | SEED | >= 0 | Of all that is random.");

DEFINE_double(noise,
              -1.0,
              "errors | LENGTH | >= 0, unit of the scene or file; default: 0.127 mm | Standard "
              "deviation of Gaussian noise along the view ray.");
DEFINE_double(bias,
              0.0,
              "errors | LENGTH | >= 0, unit of the scene or file | Root mean square of a smooth "
              "error.");
DEFINE_double(bias_length,
              0.0,
              "errors | LENGTH | > 0, the same unit; default: 0, a quarter of the extent | "
              "Correlation length of the smooth error.");
DEFINE_string(bias_along,
              "normal",
              "errors | WAY | normal or ray | The way the smooth error shifts points.");
DEFINE_double(outliers, 0.0, "errors | PART | in [0, 1] | Part of the points that is wrong.");
DEFINE_double(spike_share,
              0.5,
              "errors | PART | in [0, 1] | Part of these that are spikes, shifted along their "
              "rays; the others are strays, anywhere in an enlarged bounding box.");
DEFINE_double(spike_size,
              0.05,
              "errors | PART | >= 0, in extents: diagonals of the bounding box | Longest spike.");
DEFINE_double(outlier_box,
              1.5,
              "errors | FACTOR | >= 0 | Enlargement of the bounding box for strays.");

DEFINE_string(motion,
              "random",
              "frame | MOTION | random or none | Whether the scanner's frame is another one than "
              "the model's.");
DEFINE_double(max_angle,
              180.0,
              "frame | ANGLE | in [0, 180] degrees | Largest rotation of a random motion.");
DEFINE_double(max_translation,
              1.0,
              "frame | PART | >= 0, in extents | Largest shift of a random motion.");

DEFINE_int32(digits,
             0,
             "output | N | 3 to 17; default: 0, as many as it takes | Significant digits of the "
             "scan's coordinates, for small files.");
DEFINE_string(format, "csv", "output | FORMAT | csv or ply | Of the scan.");
DEFINE_bool(normals, false, "output | | | Writes the face's normals into the scan.");

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr HelpItem kArguments[] = {
    {"SCENE.yaml", "A scene as of darboux_deform, which is solved; or"},
    {"SURFACE",
     "a file with the deformed surface: a mesh (.ply, .obj, .stl, .off), or points (.csv, .txt, "
     ".xyz, or such files without faces; columns x y z, nx ny nz, ux uy uz: then deformed = x + "
     "u). Points without faces hide nothing, those without normals never turn away from a "
     "viewpoint; --faces gives them triangles."}};

constexpr HelpItem kFiles[] = {
    {"scan.csv", "(or .ply) the scan, in the scanner's frame"},
    {"truth.json", "what a user of the scan must not know: pose, options, fingers' forces"},
    {"truth.csv",
     "for each point, in the model's frame: the point of the face, its outlier flag (1 spike, 2 "
     "stray), view (from 0; -1 none), noise and bias"},
    {"report.html",
     "with --report: the surface, the scan on it and its errors; it knows the truth as well"}};

constexpr HelpItem kExitStatuses[] = {
    {"0", "written"},
    {"1", "the scene's solution has not converged or was interrupted, or files cannot be written"},
    {"2", "bad input: one line on stderr says where and what is allowed"}};

constexpr HelpItem kExamples[] = {
    {"darboux_scan data/tennis_ball_patches.yaml --unit=mm --out=scan",
     "A dented ball, scanned with the default noise of 0.127 mm:"},
    {"darboux_scan data/duck_642.obj --noise=1e-4 --outliers=0.02 --views=4 \\\n"
     "  --points=5000 --format=ply --out=scan",
     "Anybody's mesh (here in metres), from four viewpoints, two points of a hundred wrong:"},
    {"darboux_scan data/solids/ball_4mm.csv --revolve=360 --unit=mm --digits=6 \\\n"
     "  --out=scan",
     "A profile of displaced points, turned about the z axis:"}};

constexpr Tool kTool = {
    "darboux_scan",
    "SCENE.yaml|SURFACE --out=DIR [flags]",
    "Simulates a scan of the outer face of a deformed shell: visible points with noise, bias and "
    "outliers, in a frame of their own. The same seed gives the same scan from the same "
    "surface.\n\n"
    "Options of the model and of the solver are those of a scene's solution. All files are written "
    "together or not at all.",
    1,
    "scans a deformed shell that needs no scanner",
    kArguments,
    kFiles,
    kExitStatuses,
    "SIGINT (Ctrl-C) or SIGTERM ends the tool with status 1, or by the signal once the scene is "
    "solved; nothing is written.",
    kExamples};

std::string Ending(const std::string& file) {
  std::string ending = fs::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return ending;
}

bool IsScene(const std::string& file) {
  const std::string ending = Ending(file);
  return ending == ".yaml" || ending == ".yml";
}

bool CheckChoice(const char* flag, const std::vector<std::string>& allowed, std::string* error) {
  const std::string value = gflags::GetCommandLineFlagInfoOrDie(flag).current_value;
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return true;
  std::string list;
  for (const std::string& name : allowed) list += (list.empty() ? "" : " | ") + name;
  return FailFlag(flag, list, error);
}

// Options but for the viewpoints, which need the surface.
bool OptionsFromFlags(bool is_scene, ScanOptions* options, std::string* error) {
  static const std::map<std::string, double> kMillimetre = {
      {"um", 1000.0}, {"mm", 1.0}, {"cm", 0.1}, {"m", 1e-3}, {"in", 1.0 / 25.4}};
  constexpr double kNoiseMm = 0.127;
  constexpr char kUnits[] = "um | mm | cm | m | in";
  const auto unit = kMillimetre.find(FLAGS_unit);
  if (!FLAGS_unit.empty() && unit == kMillimetre.end()) return FailFlag("unit", kUnits, error);
  if (!IsGiven("noise") && FLAGS_unit.empty()) {
    *error = std::string(
                 "--unit: found no unit of length, which the default noise of 0.127 mm "
                 "needs; allowed --unit=") +
             kUnits + ", or --noise=LENGTH";
    return false;
  }
  if (!CheckChoice("bias_along", {"normal", "ray"}, error) ||
      !CheckChoice("motion", {"random", "none"}, error) ||
      !CheckChoice("sampling", {"area", "vertices"}, error) ||
      !CheckChoice("format", {"csv", "ply"}, error)) {
    return false;
  }
  if (FLAGS_seed < 0) return FailFlag("seed", "an integer >= 0", error);
  if (FLAGS_state < 0) return FailFlag("state", "the number of a load step, or 0", error);
  if (IsGiven("revolve") && (FLAGS_revolve < 3 || FLAGS_revolve > 10000)) {
    return FailFlag("revolve", "3 to 10000 meridians", error);
  }
  if (IsGiven("digits") && FLAGS_digits != 0 && (FLAGS_digits < 3 || FLAGS_digits > 17)) {
    return FailFlag("digits", "3 to 17, or 0", error);
  }
  if (FLAGS_views < 0 || FLAGS_views > 1000) return FailFlag("views", "0 to 1000", error);
  if (!(FLAGS_view_distance > 0.0 && std::isfinite(FLAGS_view_distance))) {
    return FailFlag("view_distance", "a factor > 0", error);
  }
  if (IsGiven("thickness") && !(FLAGS_thickness >= 0.0 && std::isfinite(FLAGS_thickness))) {
    return FailFlag("thickness", "a length >= 0", error);
  }
  const auto none_with_scenes = [&](const char* flag, const char* why) {
    return FailFlag(flag, std::string("with a file; ") + why, error);
  };
  if (is_scene) {
    if (IsGiven("thickness")) {
      return none_with_scenes("thickness", "a scene has shell.thickness");
    }
    if (!FLAGS_scene.empty()) return none_with_scenes("scene", "the argument is a scene");
    if (!FLAGS_faces.empty()) return none_with_scenes("faces", "the argument is a scene");
    if (IsGiven("revolve")) return none_with_scenes("revolve", "the argument is a scene");
  } else if (FLAGS_state != 0) {
    return FailFlag("state", "with a scene; a file has one state", error);
  }
  options->seed = static_cast<std::uint64_t>(FLAGS_seed);
  options->num_points = FLAGS_points;
  options->grazing_deg = FLAGS_grazing;
  options->noise = IsGiven("noise") ? FLAGS_noise : kNoiseMm * unit->second;
  options->bias = FLAGS_bias;
  options->bias_length = FLAGS_bias_length;
  options->bias_along_ray = FLAGS_bias_along == "ray";
  options->outliers = FLAGS_outliers;
  options->spike_share = FLAGS_spike_share;
  options->spike_size = FLAGS_spike_size;
  options->outlier_box = FLAGS_outlier_box;
  options->moves = FLAGS_motion == "random";
  options->max_angle_deg = FLAGS_max_angle;
  options->max_translation = FLAGS_max_translation;
  if (options->IsValid(error)) return true;
  // Flags have shorter names.
  static const std::map<std::string, std::string> kFlags = {
      {"num_points", "points"}, {"grazing_deg", "grazing"}, {"max_angle_deg", "max_angle"}};
  const std::size_t colon = error->find(':');
  const auto flag = kFlags.find(error->substr(0, colon));
  *error =
      "--" + (flag == kFlags.end() ? error->substr(0, colon) : flag->second) + error->substr(colon);
  return false;
}

struct Target {
  ScanSurface surface;
  std::vector<Occluder> occluders;
  double thickness = 0.0;                 // 0: the file is the face
  Json solution = nullptr;                // of a scene: what was solved
  std::unique_ptr<ShellProblem> problem;  // whose surface is scanned
  SolverSummary summary;                  // up to the state that is scanned
  Scene scene;                            // of a file: that of --scene
  std::vector<PlacedFinger> fingers;      // of it
};

// The exit status.
int SolveScene(const std::string& file, Target* target, std::string* error) {
  Scene scene;
  SolverOptions options;
  std::vector<std::string> overridden;
  if (!SolverOptionsFromFlags(&options, error) ||
      !ReadSceneWithFlags(file, &scene, &overridden, error)) {
    return kExitBadInput;
  }
  options.stop = StopOnSignal();
  progress::Watch(!scene.model.accuracy.has_value(), "", &options);
  SolverSummary summary;
  AccuracyReport accuracy;
  const bool posed =
      scene.model.accuracy
          ? SolveToAccuracy(
                scene, options, AccuracyOptions(), &target->problem, &summary, &accuracy, error)
          : Solve(scene, options, &target->problem, &summary, error);
  // From here on the first signal ends the tool: nothing is written until all is there.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (!posed) return kExitBadInput;
  if (options.stop->load()) {
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
  if (FLAGS_state > num_steps) {
    FailFlag("state", "1 to " + std::to_string(num_steps) + ", or 0 for the last", error);
    return kExitBadInput;
  }
  // The summary of this state.
  if (FLAGS_state > 0) summary.steps.resize(static_cast<std::size_t>(FLAGS_state));
  const LoadStep& step = summary.steps.back();
  if (!step.converged || !step.displacements.allFinite()) {
    *error = "load step " + std::to_string(summary.steps.size()) +
             " has not converged, nothing is scanned";
    return kExitNotConverged;
  }
  target->thickness = scene.shell.thickness;
  target->surface =
      ScannedFace(*target->problem,
                  step,
                  FLAGS_sampling == "vertices" ? ScanSampling::kVertices : ScanSampling::kArea);
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

bool ReadSurface(const std::string& file, Target* target, std::string* error) {
  const auto fail = [&](const std::string& what) {
    *error = file + ":0: found " + what;
    return false;
  };
  Scene& scene = target->scene;
  if (!FLAGS_scene.empty()) {
    if (!ReadSceneToMend(FLAGS_scene, &scene, error)) return false;
    target->thickness = scene.shell.thickness;
  }
  if (IsGiven("thickness")) target->thickness = FLAGS_thickness;
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
  if (FLAGS_revolve > 0) {
    if (!is_table) {
      return FailFlag("revolve", "with the points of a .csv, .txt or .xyz file", error);
    }
    std::string trouble;
    if (!Revolve(cloud.points, FLAGS_revolve, &mesh, &trouble)) {
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
  if (!FLAGS_faces.empty()) {
    if (!mesh.triangles.empty()) {
      return FailFlag("faces", "with points; " + file + " has faces", error);
    }
    if (!ReadVertices(FLAGS_faces, &mesh, &unused, error)) {
      *error = "--faces: " + *error;
      return false;
    }
    if (mesh.triangles.empty() || mesh.vertices.size() != cloud.points.size()) {
      *error = "--faces: " + FLAGS_faces + ":0: found " + std::to_string(mesh.triangles.size()) +
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
    if (FLAGS_sampling == "vertices") ScanVertices(&target->surface);
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

Json ToJson(const Eigen::Vector3d& x) { return {x.x(), x.y(), x.z()}; }

Json PoseToJson(const RigidPose& pose) {
  Json matrix = Json::array();
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) matrix.push_back(ToJson(Eigen::Vector3d(rotation.row(i))));
  return {{"rotation", matrix},
          {"quaternion_wxyz",
           {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}},
          {"translation", ToJson(pose.translation)}};
}

void RoundTo(int digits, PointCloud* cloud) {
  for (Eigen::Vector3d& x : cloud->points) {
    for (double& value : x) {
      char text[40];
      std::snprintf(text, sizeof(text), "%.*g", digits, value);
      value = std::strtod(text, nullptr);
    }
  }
}

// Everything that the scan was made with, but the viewpoints.
Json SettingsJson(const ScanOptions& options, const Scan& scan) {
  return {{"seed", options.seed},
          {"points", options.num_points},
          {"unit", FLAGS_unit.empty() ? Json(nullptr) : Json(FLAGS_unit)},
          {"noise", options.noise},
          {"bias", options.bias},
          {"bias_length", scan.bias_length},
          {"bias_along", FLAGS_bias_along},
          {"outliers", options.outliers},
          {"spike_share", options.spike_share},
          {"spike_size", options.spike_size},
          {"outlier_box", options.outlier_box},
          {"motion", FLAGS_motion},
          {"max_angle", options.max_angle_deg},
          {"max_translation", options.max_translation},
          {"views", options.viewpoints.size()},
          {"view_distance", FLAGS_views_file.empty() ? Json(FLAGS_view_distance) : Json(nullptr)},
          {"grazing", options.grazing_deg},
          {"sampling", FLAGS_sampling},
          {"revolve", FLAGS_revolve},
          {"digits", FLAGS_digits},
          {"state", FLAGS_state}};
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

// Triangles of which all vertices are scanned, and none is a stray.
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

// The surface with the scan beside it, in the frame of the surface, and what is wrong about each
// point: its distance from where it should be, along the normal where there is one.
Report MakeScanReport(const std::string& name,
                      const Target& target,
                      const Scan& scan,
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
  Report report = MakeReport(kTool.name, name);
  report.header["documents"]["truth"] = truth;
  if (!FLAGS_unit.empty()) report.header["units"] = {{"length", FLAGS_unit}};
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

int Run(int argc, char** argv) {
  std::vector<std::string> arguments;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  const std::string& file = arguments[0];
  const bool is_scene = IsScene(file);
  ScanOptions options;
  std::string error;
  if (!OptionsFromFlags(is_scene, &options, &error)) return BadInput(error);
  PointCloud viewpoints;
  if (!FLAGS_views_file.empty() && !ReadPointCloud(FLAGS_views_file, &viewpoints, &error)) {
    return BadInput("--views_file: " + error);
  }
  if (!CheckOut(&error)) return BadInput(error);

  Target target;
  exit_status = is_scene                             ? SolveScene(file, &target, &error)
                : ReadSurface(file, &target, &error) ? kExitDone
                                                     : kExitBadInput;
  if (exit_status != kExitDone) {
    progress::Error(error);
    return exit_status;
  }
  options.viewpoints = FLAGS_views_file.empty()
                           ? ViewpointsAround(target.surface, FLAGS_views, FLAGS_view_distance)
                           : viewpoints.points;
  Scan scan;
  if (!SimulateScan(target.surface, target.occluders, options, &scan, &error)) {
    return BadInput(file + ":0: " + error);
  }
  if (FLAGS_normals && scan.cloud.normals.empty()) {
    return BadInput(
        "--normals: found a surface without normals; allowed a mesh, or points with them");
  }
  if (!FLAGS_normals) scan.cloud.normals.clear();
  if (FLAGS_digits > 0) RoundTo(FLAGS_digits, &scan.cloud);

  const std::string name = fs::path(file).filename().string();
  Json settings = SettingsJson(options, scan);
  if (!FLAGS_faces.empty()) settings["faces"] = fs::path(FLAGS_faces).filename().string();
  std::vector<std::string> comment = {"synthetic scan of the outer face of " + name +
                                      ", in the scanner's frame; darboux_scan"};
  for (const auto& [key, value] : settings.items()) comment.push_back(key + ": " + value.dump());
  Json truth = {{"surface", name},
                {"thickness", target.thickness},
                {"model_from_scan", PoseToJson(scan.model_from_scan)},
                {"scan_from_model", PoseToJson(scan.model_from_scan.Inverse())},
                {"points", scan.cloud.points.size()},
                {"spikes", scan.num_spikes},
                {"strays", scan.num_strays},
                {"extent", scan.extent},
                {"tried", scan.num_tried},
                {"options", settings},
                {"viewpoints", Json::array()},
                {"solution", target.solution}};
  for (const Eigen::Vector3d& viewpoint : options.viewpoints) {
    truth["viewpoints"].push_back(ToJson(viewpoint));
  }
  const std::string scan_name = "scan." + FLAGS_format;
  std::string text;
  if (!FormatPointCloud(
          scan_name, scan.cloud, FacesOf(target.surface, scan), comment, &text, &error) ||
      !MakeFolder(FLAGS_out, &error)) {
    return NotDone(error);
  }
  FileSet files(FLAGS_out);
  files.Outdate(kReportFile);
  if (!files.Add(scan_name, text, &error) || !files.Add("truth.csv", TruthCsv(scan), &error) ||
      !files.Add(
          "truth.json", truth.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", &error) ||
      (FLAGS_report &&
       !files.Add(
           kReportFile, MakeReportHtml(MakeScanReport(name, target, scan, truth)), &error)) ||
      !files.Commit(&error)) {
    return NotDone(error);
  }
  // An earlier scan in the other format would not belong to this truth.
  std::error_code ignored;
  fs::remove(fs::path(FLAGS_out) / (FLAGS_format == "csv" ? "scan.ply" : "scan.csv"), ignored);
  if (!FLAGS_quiet) {
    std::printf(
        "%s: %zu points, %.1f %% of those tried, from %zu viewpoints, %d spikes, %d strays\n",
        name.c_str(),
        scan.cloud.points.size(),
        100.0 * static_cast<double>(scan.cloud.points.size()) / scan.num_tried,
        options.viewpoints.size(),
        scan.num_spikes,
        scan.num_strays);
    std::printf("scan in %s: %s, truth.csv, truth.json%s\n",
                FLAGS_out.c_str(),
                scan_name.c_str(),
                FLAGS_report ? ", report.html" : "");
  }
  return kExitDone;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
