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

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/scan_simulator.h"
#include "solver/file_set.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/scan_target.h"
#include "tools/scan_truth.h"
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

int Run(int argc, char** argv) {
  std::vector<std::string> arguments;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  const std::string& file = arguments[0];
  const bool is_scene = IsSceneFile(file);
  ScanOptions options;
  std::string error;
  if (!OptionsFromFlags(is_scene, &options, &error)) return BadInput(error);
  PointCloud viewpoints;
  if (!FLAGS_views_file.empty() && !ReadPointCloud(FLAGS_views_file, &viewpoints, &error)) {
    return BadInput("--views_file: " + error);
  }
  if (!CheckOut(&error)) return BadInput(error);

  ScanTargetOptions target_options;
  target_options.state = FLAGS_state;
  target_options.vertices = FLAGS_sampling == "vertices";
  target_options.thickness = FLAGS_thickness;
  target_options.scene = FLAGS_scene;
  target_options.faces = FLAGS_faces;
  target_options.revolve = FLAGS_revolve;
  ScanTarget target;
  exit_status = is_scene ? SolveScanScene(file, target_options, &target, &error)
                : ReadScanSurface(file, target_options, &target, &error) ? kExitDone
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
                {"model_from_scan", MotionJson(scan.model_from_scan)},
                {"scan_from_model", MotionJson(scan.model_from_scan.Inverse())},
                {"points", scan.cloud.points.size()},
                {"spikes", scan.num_spikes},
                {"strays", scan.num_strays},
                {"extent", scan.extent},
                {"tried", scan.num_tried},
                {"options", settings},
                {"viewpoints", Json::array()},
                {"solution", target.solution}};
  for (const Eigen::Vector3d& viewpoint : options.viewpoints) {
    truth["viewpoints"].push_back(CoordinatesJson(viewpoint));
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
       !files.Add(kReportFile,
                  MakeReportHtml(MakeScanReport(kTool.name, name, target, scan, FLAGS_unit, truth)),
                  &error)) ||
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
