// Fits the deformation of a scene's shell to a scan of it, or only registers the scan.
// Sample runs:
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_fit
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_fit --fingers=none
//   darboux_fit data/duck.yaml --scan=duck_scan.csv --out=duck_error --mode=register
//
// Exit status: 0 done; 1 no match or not converged (what there is is written and marked), or the
// results could not be written; 2 bad input, with nothing written. SIGINT and SIGTERM stop it.

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "geometry/point_cloud.h"
#include "solver/exports.h"
#include "solver/results.h"
#include "solver/scan_results.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/scan_fit.h"
#include "tools/solver_flags.h"

DEFINE_string(
    export,
    "",
    "output | FORMATS | csv or npz, joined by commas; default: none | Fields besides: csv "
    "(fields.csv), npz (fields.npz, for NumPy).");
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

constexpr HelpItem kArguments[] = {
    {"SCENE.yaml", "The scene, as of darboux_deform, whose shell was scanned."}};

constexpr HelpItem kFiles[] = {
    {"fit.json", "pose, verdict, weight, misfit and statistics of the distances"},
    {"shell.vtu", "the fitted shell with the error map scan_distance, and scan_coverage"},
    {"deformed.ply", "the fitted surface as a triangle mesh"},
    {"scan_registered.ply", "the scan in the shell's frame, with a distance at each point"},
    {"fields.csv, fields.npz", "with --export: the fields of the fitted shell"},
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

bool OptionsFromFlags(ScanFitOptions* options, std::string* error) {
  if (FLAGS_scan.empty()) {
    *error = "--scan: found no file; allowed the file of a scan";
    return false;
  }
  options->mode = FLAGS_mode;
  options->fingers = FLAGS_fingers;
  options->against = FLAGS_against;
  options->method = FLAGS_method;
  options->undeformed_part = FLAGS_undeformed_part;
  options->face = FLAGS_face;
  options->noise = FLAGS_noise;
  options->weight = FLAGS_weight;
  options->seed = static_cast<std::uint64_t>(FLAGS_seed);
  if (options->IsValid(error)) return true;
  *error = "--" + *error;
  return false;
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
  std::vector<std::string> arguments, overridden;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  Scene scene;
  ScanFitOptions options;
  PointCloud scan;
  std::string error;
  ExportOptions exports;
  exports.numbered = false;
  if (!ParseExports(FLAGS_export, false, &exports, &error)) return BadInput("--export: " + error);
  if (!OptionsFromFlags(&options, &error) || !SolverOptionsFromFlags(&options.solver, &error) ||
      !ReadSceneWithFlags(arguments[0], &scene, &overridden, &error) ||
      !ReadPointCloud(FLAGS_scan, &scan, &error) || !CheckOut(&error)) {
    return BadInput(error);
  }
  options.solver.stop = StopOnSignal();
  progress::Watch(false, "", &options.solver);
  options.on_iteration = SayIteration;
  ScanFit fit;
  if (!FitScan(scene, scan.points, FLAGS_scan, options, &fit, &error)) return BadInput(error);
  std::vector<NamedFile> files = ScanFitFiles(fit, scan.points);
  if (FLAGS_report) {
    const Report page = MakeFitReport(fit, scan.points);
    files.push_back({kReportFile, MakeReportHtml(page)});
  }
  if (!fit.distances.empty()) {
    ShellFace face(fit.shell->surface(), fit.face_offset);
    face.SetDisplacements(fit.displacements);
    const std::vector<ExtraField> fields =
        MakeScanFields(face, fit.feet, fit.distances, fit.counts);
    if (!MakeFieldExports(*fit.shell,
                          exports,
                          {{1.0, fit.converged, &fit.displacements}},
                          fields,
                          &files,
                          &error)) {
      return NotDone(error);
    }
  }
  if (!WriteFiles(FLAGS_out, files, &error)) return NotDone(error);
  if (!FLAGS_quiet) {
    std::printf("%s: %s", scene.name.c_str(), fit.report.c_str());
    std::printf("results in %s: %zu files, fit.json%s\n",
                FLAGS_out.c_str(),
                files.size(),
                FLAGS_report ? ", report.html" : "");
    std::fflush(stdout);
  }
  if (fit.converged) return kExitDone;
  return NotDone(fit.verdict);
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
