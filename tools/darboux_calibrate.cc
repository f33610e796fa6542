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
#include "solver/calibration_results.h"
#include "solver/exports.h"
#include "solver/file_set.h"
#include "tools/solver_flags.h"

DEFINE_string(
    export,
    "",
    "Formats besides in each grasp_K, joined by commas: csv (fields_NNNN.csv, fields.csv), "
    "npz (fields.npz, for NumPy).");
DEFINE_int32(bootstrap, -1, "Resamples for bootstrap intervals; -1: as the file says.");

namespace darboux {
namespace {

constexpr Tool kTool = {
    "darboux_calibrate",
    "CALIBRATION.yaml --out=DIR [flags]",
    "Young's modulus and, where asked, gas pressure, thickness and Poisson's ratio of a shell "
    "from\n"
    "scans, force readings and fields of displacements of its measured states. Writes\n"
    "calibration.json into DIR, and a folder grasp_K with the results of each scene in the\n"
    "calibrated state.\n"
    "\n"
    "exit status: 0 converged, every parameter that is asked for is identified\n"
    "             1 not converged or interrupted, a scan that matches nothing, or a parameter "
    "that\n"
    "               the measurements do not tell; calibration.json says which\n"
    "             2 bad input, nothing written",
    1};

void PrintError(const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", kTool.name, message.c_str());
}

int Run(int argc, char** argv) {
  std::vector<std::string> arguments;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  CalibrationSpec spec;
  CalibrationOptions options;
  ExportOptions exports;
  std::string error;
  if (!ParseExports(FLAGS_export, false, &exports, &error)) {
    PrintError("--export: " + error);
    return kExitBadInput;
  }
  if (!SolverOptionsFromFlags(&options.solver, &error) ||
      !ReadCalibration(arguments[0], &spec, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  if (FLAGS_bootstrap >= 0) spec.bootstrap = FLAGS_bootstrap;
  for (CalibrationSpec::Grasp& grasp : spec.grasps) {
    std::vector<std::string> overridden;
    if (!ApplyFlags(&grasp.scene, &overridden, &error)) {
      PrintError(error);
      return kExitBadInput;
    }
    for (const std::string& flag : overridden) {
      if (flag == "--theory") spec.theory = Theory::kAuto;  // now that of the scenes
    }
  }
  if (!IsWritableFolder(FLAGS_out, &error)) {
    PrintError("--out: found " + error + "; allowed a folder that can be written to");
    return kExitBadInput;
  }
  options.solver.stop = StopOnSignal();
  if (!FLAGS_quiet) {
    options.on_progress = [](const std::string& line) {
      std::fprintf(stderr, "%s\n", line.c_str());
    };
  }
  CalibrationSummary summary;
  std::vector<std::unique_ptr<StateModel>> models;
  if (!Calibrate(spec, options, &summary, &models, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  for (const std::unique_ptr<StateModel>& model : models) {
    if (!model->Settle(&error)) PrintError(error);
  }
  if (!WriteCalibration(FLAGS_out, spec, summary, models, exports, &error)) {
    PrintError(error);
    return kExitNotConverged;
  }
  if (!FLAGS_quiet) {
    std::printf("%s: %s", spec.name.c_str(), summary.FullReport().c_str());
    std::printf("results in %s: calibration.json\n", FLAGS_out.c_str());
    std::fflush(stdout);
  }
  exit_status = kExitDone;
  const auto complain = [&exit_status](const std::string& message) {
    PrintError(message);
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
