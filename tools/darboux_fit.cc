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
#include "solver/report_view.h"
#include "solver/results.h"
#include "solver/scan_results.h"
#include "solver/shape_fit.h"
#include "solver/shell_solver.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(scan,
              "",
              "input | FILE | .csv, .txt, .xyz, .ply, .obj, .stl or .off; required | The scan, in "
              "the scene's unit of length.");
DEFINE_string(face,
              "outer",
              "input | FACE | outer, inner or middle | The scanned face; outer is along the "
              "normals.");
DEFINE_double(noise,
              0.0,
              "input | LENGTH | >= 0, the scene's unit; default: 0, estimated | Standard deviation "
              "of the scan along normals.");

DEFINE_string(mode,
              "fit",
              "fit | MODE | fit or register | fit: deforms the shell; register: only finds the "
              "pose and the distances.");
DEFINE_string(fingers,
              "",
              "fit | FINGERS | scene or none; default: scene where it has any | scene: the start, "
              "and what fills holes, is the scene's own equilibrium; none: the shell at rest, "
              "fingers and loads are not known.");
DEFINE_double(weight,
              0.0,
              "fit | W | >= 0, no unit; default: 0, by the discrepancy principle | Weight of the "
              "elastic energy.");

DEFINE_string(against,
              "deformed",
              "registration | SHAPE | deformed or rest | With --mode=register: the scene's "
              "equilibrium, or its shell at rest.");
DEFINE_string(method,
              "robust",
              "registration | METHOD | robust or undeformed_first | With --mode=register; "
              "undeformed_first: the pose is from where the shell hardly moved.");
DEFINE_double(undeformed_part,
              0.05,
              "registration | PART | in (0, 1], no unit | Of undeformed_first: what moved by less "
              "than this part of the largest displacement.");
DEFINE_int32(seed,
             1,
             "registration | SEED | any integer | Of the points drawn for the search of the pose.");

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

constexpr HelpItem kArguments[] = {
    {"SCENE.yaml", "The scene, as of darboux_deform, whose shell was scanned."}};

constexpr HelpItem kFiles[] = {
    {"fit.json", "pose, verdict, weight, misfit and statistics of the distances"},
    {"shell.vtu", "the fitted shell with the error map scan_distance, and scan_coverage"},
    {"deformed.ply", "the fitted surface as a triangle mesh"},
    {"scan_registered.ply", "the scan in the shell's frame, with a distance at each point"},
    {"report.html", "with --report: shapes, numbers and plots in one file, for any browser"}};

constexpr HelpItem kExitStatuses[] = {
    {"0", "done"},
    {"1",
     "the scan does not match, not converged or interrupted (what there is is written and "
     "marked), or results cannot be written"},
    {"2", "bad input: one line on stderr says where and what is allowed; nothing is written"}};

constexpr HelpItem kExamples[] = {
    {"darboux_fit data/calibration/ball.yaml \\\n"
     "  --scan=data/calibration/ball_4mm_scan.csv --fingers=none --out=fit",
     "A squeezed ball from a scan alone, its fingers not known:"},
    {"darboux_fit data/calibration/ball.yaml \\\n"
     "  --scan=data/calibration/ball_4mm_scan.csv --mode=register --out=error",
     "How far the computed shape is from the scan:"}};

constexpr Tool kTool = {
    "darboux_fit",
    "SCENE.yaml --scan=FILE --out=DIR [flags]",
    "Fits the deformation of a scene's shell to a scan of it, registration included: distances to "
    "the scan and elastic energy, which fills what the scan does not show. --mode=register only "
    "finds the pose and the distances.\n\n"
    "Options of the solver are those of the scene's own equilibrium, but for --threads and "
    "--sparse_backend, which the fit shares.",
    1,
    "fits the deformation of a shell to a scan of it",
    kArguments,
    kFiles,
    kExitStatuses,
    "The first SIGINT (Ctrl-C) or SIGTERM stops the fit; what there is is written, marked as not "
    "converged, and the exit status is 1. The second one ends the process.",
    kExamples};

void PrintError(const std::string& message) { progress::Error(message); }

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

void SayIteration(const ShapeFitIteration& iteration) {
  char line[200];
  std::snprintf(line,
                sizeof(line),
                "weight %.3g  misfit %.4g  iteration %d  %s",
                iteration.weight,
                iteration.misfit,
                iteration.iteration,
                progress::FormatDuration(iteration.seconds).c_str());
  progress::Json fields = {{"trial", iteration.trial},
                           {"weight", iteration.weight},
                           {"iteration", iteration.iteration},
                           {"misfit", iteration.misfit},
                           {"seconds", iteration.seconds}};
  if (iteration.is_end) {
    fields["seconds_left_at_most"] = iteration.seconds_left_at_most;
    const std::string left =
        ", at most about " + progress::FormatDuration(iteration.seconds_left_at_most) + " left";
    progress::Say("weight", fields, line + left);
  } else if (FLAGS_log == "json") {
    progress::Say("fit_iteration", fields, "");
  } else {
    progress::Live(line);
  }
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
  progress::Watch(false, "", &options);

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
  fit_options.on_iteration = SayIteration;
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
    const std::vector<ExtraField> scan_fields = MakeScanFields(face, feet, distances, counts);
    files.push_back({"shell.vtu", MakeVtu(*shell, displacements, scan_fields)});
    files.push_back({"deformed.ply", MakeDeformedPly(*shell, displacements)});
    files.push_back(
        {"scan_registered.ply", MakeRegisteredPly(scan.points, pose, distances, counts)});
  }
  json["time_s"] = std::chrono::duration<double>(Clock::now() - start).count();
  if (FLAGS_report) {
    Report page = MakeReport(kTool.name, scene.name);
    ReportShape shape;
    shape.title = scene.name;
    shape.problem = shell.get();
    shape.scene = &scene;
    if (solves) shape.states = StatesOf(solver_summary);
    for (ReportState& state : shape.states) state.label = "computed, " + state.label;
    if (!distances.empty()) {
      // What is held against the scan; a shape that is not fitted is the last one there, or the
      // shell at rest.
      if (fits || shape.states.empty()) {
        ReportState state;
        state.label = fits ? "fitted to the scan" : "held against the scan";
        state.displacements = &displacements;
        shape.states.push_back(state);
      }
      ShellFace face(shell->surface(), offset);
      face.SetDisplacements(displacements);
      shape.distances = {CoveredDistance(MakeScanFields(face, feet, distances, counts))};
      std::vector<Eigen::Vector3d> points;
      for (const Eigen::Vector3d& x : scan.points) points.push_back(pose * x);
      shape.clouds = {MakeCloud("scan, registered", "distance from the face", points, distances)};
    }
    AddShellView(shape, &page);
    if (solves) {
      AddHistory(scene, solver_summary, &page);
      page.header["documents"]["summary"] = MakeSummaryJson(scene, solver_summary, nullptr);
    }
    page.header["documents"]["fit"] = json;
    files.push_back({kReportFile, MakeReportHtml(page)});
  }
  files.push_back({"fit.json", json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"});
  if (!WriteFiles(FLAGS_out, files, &error)) {
    PrintError(error);
    return kExitNotConverged;
  }
  if (!FLAGS_quiet) {
    std::printf("%s: %s", scene.name.c_str(), report.c_str());
    std::printf("results in %s: %zu files, fit.json%s\n",
                FLAGS_out.c_str(),
                files.size(),
                FLAGS_report ? ", report.html" : "");
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
