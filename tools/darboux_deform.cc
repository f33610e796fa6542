// Deforms a scene's shell under its loads and writes the result.
// Sample runs:
//   darboux_deform data/pinched_cylinder.yaml --out=pinched
//   darboux_deform data/pinched_cylinder.yaml --out=pinched --theory=nonlinear --divisions=32,32
//   darboux_deform data/pinched_cylinder.yaml --out=pinched --export=inp,csv,npz
//
// Exit status: 0 converged, and every `expect` of the scene holds; 1 not converged, an `expect`
// fails, model.accuracy is not reached, interrupted, or the results could not be written; 2 bad
// input, with nothing written. SIGINT and SIGTERM stop the solver; what it has reached is written.
//
// The expectations of a scene are stated for its own settings. Where flags override these, they
// are evaluated all the same and decide about the exit status; the report says so.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "solver/accuracy.h"
#include "solver/exports.h"
#include "solver/results.h"
#include "solver/shell_solver.h"
#include "tools/solver_flags.h"

DEFINE_string(export,
              "",
              "Formats besides, joined by commas: csv (fields_NNNN.csv, fields.csv), npz "
              "(fields.npz, for NumPy), inp (shell.inp, the scene for CalculiX and Abaqus).");
DEFINE_bool(export_only, false, "Write shell.inp and end, without solving; with --export=inp.");
DEFINE_string(inp_element,
              "auto",
              "Elements of shell.inp: S3, S4, S6, S8R, C3D15 or C3D20R; S4, S8R and C3D20R on "
              "parametric surfaces only. auto: solid ones, C3D20R or, on meshes, C3D15; S8R or S6 "
              "where edges have moments in the nonlinear theory.");

namespace darboux {
namespace {

constexpr Tool kTool = {
    "darboux_deform",
    "SCENE.yaml --out=DIR [flags]",
    "Solves a scene: deforms its shell under its loads. Writes summary.json, shell.vtu, "
    "shell.pvd,\n"
    "shell_NNNN.vtu (one per load step), deformed.ply and history.csv into DIR, and with --export\n"
    "the fields and the scene in other formats. With\n"
    "model.accuracy in the scene the divisions are doubled until the estimated error is within "
    "it.\n"
    "Flags that override the scene do not change its expectations: these are evaluated as they\n"
    "stand.\n"
    "\n"
    "exit status: 0 converged, every expectation of the scene holds\n"
    "             1 not converged or interrupted (the last state is written and marked), an\n"
    "               expectation fails, or the accuracy is not reached\n"
    "             2 bad input, nothing written",
    1};

void PrintError(const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", kTool.name, message.c_str());
}

void PrintStep(const StepReport& report) {
  std::fprintf(stderr,
               "step %d/%d  load %.4g  %d iterations  energy %.6e  gradient %.1e  "
               "displacement %.4e  %.2f s%s\n",
               report.step,
               report.steps,
               report.load_factor,
               report.iterations,
               report.energy,
               report.relative_gradient,
               report.max_displacement,
               report.seconds,
               report.converged ? "" : "  NOT CONVERGED");
}

std::string FormatLevel(const AccuracyLevel& level) {
  char estimate[32] = "        -";
  if (level.estimate) std::snprintf(estimate, sizeof(estimate), "%9.2e", *level.estimate);
  char lattice[32] = "";
  if (level.divisions[0] > 0) {
    std::snprintf(lattice, sizeof(lattice), "%5d x %-5d ", level.divisions[0], level.divisions[1]);
  }
  char line[128];
  std::snprintf(line,
                sizeof(line),
                "%s%8d dof  error %s  %8.2f s",
                lattice,
                level.dof,
                estimate,
                level.seconds);
  return line;
}

std::string FormatExpectation(const ExpectResult& result) {
  std::string text = std::string(result.holds ? "OK      " : "FAILED  ") + result.quantity;
  char line[160];
  if (result.value) {
    std::snprintf(line,
                  sizeof(line),
                  " = %.9g, expected %.9g: %s error %.2e, tolerance %.2e",
                  *result.value,
                  result.expected,
                  result.relative ? "relative" : "absolute",
                  result.error.value_or(0.0),
                  result.tolerance);
    return text + line;
  }
  std::snprintf(line, sizeof(line), ", expected %.9g: ", result.expected);
  return text + line + result.message;
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

bool ExportOptionsFromFlags(const Scene& scene, ExportOptions* options, std::string* error) {
  if (!ParseExports(FLAGS_export, true, options, error)) {
    *error = "--export: " + *error;
    return false;
  }
  if (!ParseInpElement(FLAGS_inp_element, options, error) ||
      !CheckExports(*options, scene, error)) {
    *error = "--inp_element: " + *error;
    return false;
  }
  if (FLAGS_export_only && (!options->inp || options->csv || options->npz)) {
    *error = "--export_only: found --export=" + FLAGS_export + "; allowed with --export=inp";
    return false;
  }
  return true;
}

// What a deck says otherwise than the scene: warnings, so that nothing is dropped in silence. The
// deck has them as well.
void PrintRemarks(const std::vector<std::string>& remarks) {
  if (FLAGS_quiet) return;
  for (const std::string& remark : remarks) {
    std::fprintf(stderr, "%s: shell.inp: warning: %s\n", kTool.name, remark.c_str());
  }
}

int ExportOnly(const Scene& scene, const ExportOptions& exports, int num_threads) {
  std::vector<NamedFile> files;
  std::vector<std::string> remarks;
  std::string error;
  if (!ExportScene(scene, exports, num_threads, &files, &remarks, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  if (!WriteFiles(FLAGS_out, files, &error)) {
    PrintError(error);
    return kExitNotConverged;
  }
  PrintRemarks(remarks);
  if (!FLAGS_quiet) std::printf("%s: shell.inp in %s\n", scene.name.c_str(), FLAGS_out.c_str());
  return kExitDone;
}

int Run(int argc, char** argv) {
  std::vector<std::string> arguments, overridden;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  Scene scene;
  SolverOptions options;
  ExportOptions exports;
  std::string error;
  if (!SolverOptionsFromFlags(&options, &error) ||
      !ReadSceneWithFlags(arguments[0], &scene, &error) ||
      !ApplyFlags(&scene, &overridden, &error) ||
      !ExportOptionsFromFlags(scene, &exports, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  // Before the time is spent on solving.
  if (!IsWritableFolder(FLAGS_out, &error)) {
    PrintError("--out: found " + error + "; allowed a folder that can be written to");
    return kExitBadInput;
  }

  if (FLAGS_export_only) return ExportOnly(scene, exports, options.num_threads);

  options.stop = StopOnSignal();
  if (!FLAGS_quiet) options.on_step = PrintStep;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  AccuracyReport accuracy;
  const bool refines = scene.model.accuracy.has_value();
  bool posed;
  if (refines) {
    AccuracyOptions accuracy_options;
    if (!FLAGS_quiet) {
      accuracy_options.on_level = [](const AccuracyLevel& level) {
        std::fprintf(stderr, "level %s\n", FormatLevel(level).c_str());
      };
    }
    posed =
        SolveToAccuracy(scene, options, accuracy_options, &problem, &summary, &accuracy, &error);
  } else {
    posed = Solve(scene, options, &problem, &summary, &error);
  }
  if (!posed) {
    PrintError(error);
    return kExitBadInput;
  }

  Results results;
  std::vector<NamedFile> exported;
  std::vector<std::string> remarks;
  if (!MakeFieldExports(*problem, exports, StatesOf(summary), {}, &exported, &error) ||
      !MakeInpExport(*problem, exports, &summary, &exported, &remarks, &error) ||
      !WriteResults(FLAGS_out,
                    *problem,
                    summary,
                    refines ? &accuracy : nullptr,
                    &results,
                    &error,
                    exported)) {
    PrintError(error);
    return kExitNotConverged;
  }
  PrintRemarks(remarks);

  if (!FLAGS_quiet) {
    std::printf("%s: %s", scene.name.c_str(), summary.FullReport().c_str());
    for (const AccuracyLevel& level : accuracy.levels) {
      std::printf("  level %s\n", FormatLevel(level).c_str());
    }
    if (!results.expectations.empty() && !overridden.empty()) {
      std::printf("  note: expectations are stated for the scene's own settings, not for %s\n",
                  Join(overridden).c_str());
    }
    for (const ExpectResult& result : results.expectations) {
      std::printf("  expect %s\n", FormatExpectation(result).c_str());
    }
    std::printf("results in %s: %zu files, summary.json, shell.pvd (ParaView)\n",
                FLAGS_out.c_str(),
                results.files.size());
    std::fflush(stdout);
  }

  // What is wrong, in one line each; these are all that --quiet lets through.
  exit_status = kExitDone;
  const auto complain = [&exit_status](const std::string& message) {
    PrintError(message);
    exit_status = kExitNotConverged;
  };
  if (!results.converged) {
    complain("not converged: " + results.summary["message"].get<std::string>());
  }
  if (refines && !accuracy.reached) complain("warning: " + accuracy.message);
  for (const ExpectResult& result : results.expectations) {
    if (!result.holds) complain("expectation " + FormatExpectation(result));
  }
  if (options.stop->load() && exit_status == kExitDone) complain("interrupted");
  return exit_status;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
