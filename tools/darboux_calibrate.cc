// Finds Young's modulus, and other parameters of a shell, from measured grasps.
// Sample run: darboux_calibrate data/calibration/ball_4mm.yaml --out=ball
//
// Exit status: 0 done, every parameter that was asked for is identified; 1 not converged, no match
// of a scan, or a parameter is not identifiable (calibration.json says which and why); 2 bad input,
// nothing written.

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "solver/calibration_reader.h"
#include "solver/calibration_report.h"
#include "solver/calibration_results.h"
#include "solver/exports.h"
#include "solver/file_set.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(export,
              "",
              "output | FORMATS | csv or npz, joined by commas; default: none | Fields in each "
              "grasp_K besides: csv (fields_NNNN.csv, fields.csv), npz (fields.npz, for NumPy).");
DEFINE_int32(bootstrap,
             -1,
             "solver | N | >= 0; default: as the file says | Resamples of points and readings for "
             "bootstrap intervals; 0: none.");

namespace darboux {
namespace {

constexpr HelpItem kArguments[] = {
    {"CALIBRATION.yaml",
     "Lists scenes, what was measured of each (scans, forces of fingers, fields of displacements) "
     "and what is asked for; data/README.md, Calibration, has all keys. Files in it are relative "
     "to it; one system of units in all of them."}};

constexpr HelpItem kFiles[] = {
    {"calibration.json",
     "values, 95 % intervals, verdicts, correlations, sensitivities, distances of the scans"},
    {"grasp_K/", "scene K in the calibrated state, with the files that darboux_deform writes"},
    {"grasp_K/scan_S.ply", "its scans, registered to the shell"},
    {"grasp_K/fields.csv, fields.npz", "with --export: fields of the grasp's scene"},
    {"report.html", "with --report: shapes, numbers and plots in one file, for any browser"}};

constexpr HelpItem kExitStatuses[] = {
    {"0", "converged, and every parameter that is asked for is identified"},
    {"1",
     "not converged or interrupted, a scan that matches nothing, or a parameter that the "
     "measurements do not tell (calibration.json says which), or results cannot be written"},
    {"2", "bad input: one line on stderr says where and what is allowed; nothing is written"}};

constexpr HelpItem kExamples[] = {
    {"darboux_calibrate data/calibration/ball_4mm.yaml --out=ball",
     "Young's modulus of a squeezed ball from a scan and one force:"},
    {"darboux_calibrate data/calibration/strip_hole_calibration.yaml \\\n"
     "  --bootstrap=20 --out=strip",
     "Young's modulus and Poisson's ratio of a pulled strip from a field of displacements, with "
     "bootstrap intervals:"}};

constexpr Tool kTool = {
    "darboux_calibrate",
    "CALIBRATION.yaml --out=DIR [flags]",
    "Finds Young's modulus and, where asked, gas pressure, thickness and Poisson's ratio of a "
    "shell from scans, force readings and fields of displacements of its measured states: values, "
    "95 % intervals, and a verdict where the measurements do not tell.\n\n"
    "Flags that override the scene hold for all scenes. Progress goes to stderr, a report to "
    "stdout.",
    1,
    "finds the material of a shell from measured grasps",
    kArguments,
    kFiles,
    kExitStatuses,
    "The first SIGINT (Ctrl-C) or SIGTERM stops the calibration; what there is is written, marked "
    "as not converged, and the exit status is 1. The second one ends the process.",
    kExamples,
    /*without_flags=*/"repair"};

int Run(int argc, char** argv) {
  std::vector<std::string> arguments;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  CalibrationSpec spec;
  CalibrationOptions options;
  ExportOptions exports;
  std::string error;
  if (!ParseExports(FLAGS_export, false, &exports, &error)) return BadInput("--export: " + error);
  if (!SolverOptionsFromFlags(&options.solver, &error) ||
      !ReadCalibration(arguments[0], &spec, &error)) {
    return BadInput(error);
  }
  if (FLAGS_bootstrap >= 0) spec.bootstrap = FLAGS_bootstrap;
  for (CalibrationSpec::Grasp& grasp : spec.grasps) {
    std::vector<std::string> overridden;
    if (!ApplyFlags(&grasp.scene, &overridden, &error)) return BadInput(error);
    for (const std::string& flag : overridden) {
      if (flag == "--theory") spec.theory = Theory::kAuto;  // now that of the scenes
    }
  }
  if (!CheckOut(&error)) return BadInput(error);
  options.solver.stop = StopOnSignal();
  progress::Watch(false, "", &options.solver);
  // A line of its own is for what the calibration does, not for each step of each of its solves.
  options.solver.on_step = nullptr;
  options.on_progress = [](const std::string& line) {
    progress::Say("progress", {{"text", line}}, line);
  };
  options.on_iteration = [](const CalibrationIteration& iteration) {
    progress::Json fields = {{"iteration", iteration.iteration},
                             {"cost", iteration.cost},
                             {"seconds", iteration.seconds}};
    for (const auto& [name, value] : iteration.parameters) fields[name] = value;
    std::string line = iteration.text;
    if (iteration.seconds_left) {
      fields["seconds_left"] = *iteration.seconds_left;
      line += ", about " + progress::FormatDuration(*iteration.seconds_left) + " left";
    }
    progress::Say("calibration_iteration", fields, line);
  };
  CalibrationSummary summary;
  std::vector<std::unique_ptr<StateModel>> models;
  if (!Calibrate(spec, options, &summary, &models, &error)) return BadInput(error);
  for (const std::unique_ptr<StateModel>& model : models) {
    if (!model->Settle(&error)) progress::Error(error);
  }
  MoreFiles more;
  if (FLAGS_report) {
    more = [&](const nlohmann::ordered_json& json) {
      return std::vector<NamedFile>{
          {kReportFile,
           MakeReportHtml(MakeCalibrationReport(kTool.name, spec, summary, models, json))}};
    };
  }
  if (!WriteCalibration(FLAGS_out, spec, summary, models, exports, &error, more)) {
    return NotDone(error);
  }
  if (!FLAGS_quiet) {
    std::printf("%s: %s", spec.name.c_str(), summary.FullReport().c_str());
    std::printf("results in %s: calibration.json%s\n",
                FLAGS_out.c_str(),
                FLAGS_report ? ", report.html" : "");
    std::fflush(stdout);
  }
  exit_status = kExitDone;
  const auto complain = [&exit_status](const std::string& message) {
    progress::Error(message);
    exit_status = kExitNotConverged;
  };
  if (!summary.IsConverged()) complain(summary.message);
  for (const CalibrationSummary::Estimate& estimate : summary.estimates) {
    if (!estimate.identifiable) {
      complain(std::string(ToString(estimate.parameter)) + ": " + estimate.verdict);
    }
  }
  return exit_status;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
