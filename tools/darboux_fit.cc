// Fits the deformation of a scene's shell to a scan of it, or only registers the scan.
// Sample runs:
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_fit
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_fit --fingers=none
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_error --mode=register
//
// Exit status: 0 done; 1 no match or not converged (what there is is written and marked), or the
// results could not be written; 2 bad input, with nothing written. SIGINT and SIGTERM stop it.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/shell_face.h"
#include "solver/exports.h"
#include "solver/results.h"
#include "solver/scan_results.h"
#include "solver/shape_fit.h"
#include "solver/shell_solver.h"
#include "tools/solver_flags.h"

DEFINE_string(export,
              "",
              "Formats besides, joined by commas: csv (fields.csv), npz (fields.npz, for NumPy).");
DEFINE_string(scan, "", "The scan: .csv, .ply, .obj, .stl or .off, in the scene's unit of length.");
DEFINE_string(mode,
              "fit",
              "fit: deforms the shell; register: only finds the pose and the distances.");
DEFINE_string(
    fingers,
    "",
    "fit: scene, the start and what fills holes is the scene's own equilibrium; none, the "
    "shell at rest, fingers and loads are not known. Default: scene where it has any.");
DEFINE_string(against, "deformed", "register: deformed, the scene's equilibrium, or rest.");
DEFINE_string(method,
              "robust",
              "register: robust, or undeformed_first, the pose from where the shell hardly moved.");
DEFINE_double(undeformed_part,
              0.05,
              "undeformed_first: what moved by less than this part of the largest displacement.");
DEFINE_string(face, "outer", "The scanned face: outer (along normals), inner or middle.");
DEFINE_double(noise, 0.0, "Standard deviation of the scan along normals; 0: estimated.");
DEFINE_double(weight, 0.0, "Of the energy, without unit; 0: by the discrepancy principle.");
DEFINE_int32(seed, 1, "Of the points drawn for the search of the pose.");

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

constexpr Tool kTool = {
    "darboux_fit",
    "SCENE.yaml --scan=FILE --out=DIR [flags]",
    "Fits the deformation of a scene's shell to a scan of it, registration included: distances to\n"
    "the scan and elastic energy, which fills what the scan does not show. Writes fit.json,\n"
    "shell.vtu (with the error map scan_distance), deformed.ply and scan_registered.ply into DIR.\n"
    "\n"
    "exit status: 0 done\n"
    "             1 the scan does not match, or not converged (results are written and marked)\n"
    "             2 bad input, nothing written",
    1};

void PrintError(const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", kTool.name, message.c_str());
}

bool OneOf(const char* flag,
           const std::string& value,
           const std::vector<std::string>& allowed,
           std::string* error) {
  std::string list;
  for (const std::string& word : allowed) {
    if (word == value) return true;
    list += (list.empty() ? "" : " | ") + word;
  }
  *error = std::string("--") + flag + ": found '" + value + "'; allowed " + list;
  return false;
}

bool CheckFlags(std::string* error) {
  if (FLAGS_scan.empty()) {
    *error = "--scan: found no file; allowed the file of a scan";
    return false;
  }
  if (!std::isfinite(FLAGS_noise) || FLAGS_noise < 0.0) {
    *error = "--noise: found " + std::to_string(FLAGS_noise) + "; allowed >= 0";
    return false;
  }
  if (!std::isfinite(FLAGS_weight) || FLAGS_weight < 0.0) {
    *error = "--weight: found " + std::to_string(FLAGS_weight) + "; allowed >= 0";
    return false;
  }
  if (!(FLAGS_undeformed_part > 0.0 && FLAGS_undeformed_part <= 1.0)) {
    *error = "--undeformed_part: found " + std::to_string(FLAGS_undeformed_part) +
             "; allowed 0 < part <= 1";
    return false;
  }
  return OneOf("mode", FLAGS_mode, {"fit", "register"}, error) &&
         (FLAGS_fingers.empty() || OneOf("fingers", FLAGS_fingers, {"scene", "none"}, error)) &&
         OneOf("against", FLAGS_against, {"deformed", "rest"}, error) &&
         OneOf("method", FLAGS_method, {"robust", "undeformed_first"}, error) &&
         OneOf("face", FLAGS_face, {"outer", "inner", "middle"}, error);
}

int Run(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  std::vector<std::string> arguments, overridden;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  Scene scene;
  SolverOptions options;
  PointCloud scan;
  std::string error;
  ExportOptions exports;
  exports.numbered = false;
  if (!ParseExports(FLAGS_export, false, &exports, &error)) {
    PrintError("--export: " + error);
    return kExitBadInput;
  }
  if (!CheckFlags(&error) || !SolverOptionsFromFlags(&options, &error) ||
      !ReadSceneWithFlags(arguments[0], &scene, &error) ||
      !ApplyFlags(&scene, &overridden, &error) || !ReadPointCloud(FLAGS_scan, &scan, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  if (!IsWritableFolder(FLAGS_out, &error)) {
    PrintError("--out: found " + error + "; allowed a folder that can be written to");
    return kExitBadInput;
  }
  options.stop = StopOnSignal();

  // The shape that the scan is held against.
  const bool fits = FLAGS_mode == "fit";
  const bool has_causes = !scene.fingers.empty() || !scene.loads.empty();
  const bool solves = fits ? FLAGS_fingers == "scene" || (FLAGS_fingers.empty() && has_causes)
                           : FLAGS_against == "deformed";
  std::unique_ptr<ShellProblem> solved, shell;
  SolverSummary solver_summary;
  if (solves && !Solve(scene, options, &solved, &solver_summary, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  ShellProblem::Options shell_options;
  shell_options.nonlinear = true;
  shell_options.num_threads = options.num_threads;
  shell = ShellProblem::Create(WithoutLoads(scene), shell_options, &error);
  if (shell == nullptr) {
    PrintError(error);
    return kExitBadInput;
  }
  const double half = 0.5 * shell->material().thickness;
  const double offset = FLAGS_face == "outer" ? half : FLAGS_face == "inner" ? -half : 0.0;

  ShapeFitOptions fit_options;
  fit_options.noise = FLAGS_noise;
  fit_options.weight = FLAGS_weight;
  fit_options.num_threads = options.num_threads;
  fit_options.backend = options.backend;
  fit_options.stop = options.stop;
  RegistrationOptions& registration_options = fit_options.registration;
  registration_options.seed = static_cast<std::uint64_t>(FLAGS_seed);
  registration_options.num_threads = options.num_threads;
  // A shape that is not fitted yet, or one that was computed and not measured, is off by more than
  // the noise.
  constexpr double kUnfitted = 0.03;
  registration_options.max_relative_sigma = kUnfitted;

  Json json = {{"tool", kTool.name},
               {"scene", scene.name},
               {"scan", FLAGS_scan},
               {"points", scan.points.size()},
               {"mode", FLAGS_mode},
               {"converged", false},
               {"verdict", ""}};
  Eigen::Matrix3Xd displacements = Eigen::Matrix3Xd::Zero(3, shell->surface().mesh().num_vertices);
  if (solves) displacements = solved->displacements();
  RigidPose pose;
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
  std::vector<char> counts;
  bool done = false;
  std::string verdict, report;
  if (fits) {
    ShapeFitSummary summary;
    if (!FitShape(shell.get(),
                  solves ? displacements : Eigen::Matrix3Xd(),
                  offset,
                  scan.points,
                  fit_options,
                  &summary,
                  &error)) {
      PrintError(FLAGS_scan + ":0: " + error);
      return kExitBadInput;
    }
    done = summary.converged;
    verdict = summary.verdict;
    report = summary.FullReport();
    json["fingers"] = solves ? "scene" : "none";
    json["registration"] = ToJson(summary.registration);
    if (summary.registration.matched) {
      displacements = summary.displacements;
      pose = summary.pose;
      feet = summary.feet;
      distances = summary.distances;
      counts = summary.counts;
      const double largest = summary.max_displacement;
      json["pose"] = ToJson(pose);
      json["noise"] = summary.noise;
      json["weight"] = summary.weight;
      json["misfit"] = summary.misfit;
      json["energy"] = summary.energy;
      json["iterations"] = summary.iterations;
      Json trials = Json::array();
      for (const ShapeFitSummary::Trial& trial : summary.trials) {
        trials.push_back(
            {{"weight", trial.weight}, {"misfit", trial.misfit}, {"iterations", trial.iterations}});
      }
      json["weights"] = trials;
      json["max_displacement"] = largest;
      json["outliers"] = summary.num_outliers;
      json["beyond_boundary"] = summary.num_beyond_boundary;
      json["inliers"] = ToJson(summary.inliers, largest);
      json["all"] = ToJson(summary.all, largest);
    }
  } else {
    ShellFace face(shell->surface(), offset);
    face.SetDisplacements(displacements);
    registration_options.undeformed_part = FLAGS_undeformed_part;
    if (FLAGS_method == "undeformed_first") {
      registration_options.method = RegistrationOptions::Method::kUndeformedFirst;
    }
    RegistrationSummary summary;
    if (!Register(face, scan.points, registration_options, &summary, &error)) {
      PrintError(FLAGS_scan + ":0: " + error);
      return kExitBadInput;
    }
    done = summary.matched;
    verdict = summary.verdict;
    report = summary.FullReport();
    json["against"] = FLAGS_against;
    json["method"] = FLAGS_method;
    json["registration"] = ToJson(summary);
    pose = summary.pose;
    feet = summary.feet;
    distances = summary.distances;
    if (!distances.empty()) {
      const double largest = Deformation(shell->surface(), displacements).largest();
      counts.assign(distances.size(), 1);
      for (const int i : summary.outliers) counts[static_cast<size_t>(i)] = 0;
      json["pose"] = ToJson(pose);
      json["max_displacement"] = largest;
      json["outliers"] = summary.outliers.size();
      json["inliers"] = ToJson(summary.inliers, largest);
      json["all"] = ToJson(summary.all, largest);
      // The error of a computed shape is no outlier: the map shows all but what is far away.
      const double far = 3.0 * registration_options.max_relative_sigma * shell->surface().size();
      for (size_t i = 0; i < counts.size(); ++i) counts[i] = std::abs(distances[i]) <= far ? 1 : 0;
    }
  }
  if (solves && !solver_summary.IsConverged()) {
    done = false;
    verdict += "; the scene's own equilibrium is not converged: " + solver_summary.message;
  }
  json["converged"] = done;
  json["verdict"] = verdict;

  std::vector<NamedFile> files;
  if (!distances.empty()) {
    ShellFace face(shell->surface(), offset);
    face.SetDisplacements(displacements);
    const std::vector<ExtraField> fields = MakeScanFields(face, feet, distances, counts);
    files.push_back({"shell.vtu", MakeVtu(*shell, displacements, fields)});
    if (!MakeFieldExports(*shell, exports, {{1.0, done, &displacements}}, fields, &files, &error)) {
      PrintError(error);
      return kExitNotConverged;
    }
    files.push_back({"deformed.ply", MakeDeformedPly(*shell, displacements)});
    files.push_back(
        {"scan_registered.ply", MakeRegisteredPly(scan.points, pose, distances, counts)});
  }
  json["time_s"] = std::chrono::duration<double>(Clock::now() - start).count();
  files.push_back({"fit.json", json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"});
  if (!WriteFiles(FLAGS_out, files, &error)) {
    PrintError(error);
    return kExitNotConverged;
  }
  if (!FLAGS_quiet) {
    std::printf("%s: %s", scene.name.c_str(), report.c_str());
    std::printf("results in %s: %zu files, fit.json\n", FLAGS_out.c_str(), files.size());
    std::fflush(stdout);
  }
  if (done) return kExitDone;
  PrintError(verdict);
  return kExitNotConverged;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
