// Deforms a scene's shell under its loads and writes the result.
// Sample runs:
//   darboux_deform data/pinched_cylinder.yaml --out=pinched
//   darboux_deform data/pinched_cylinder.yaml --out=pinched --theory=nonlinear --divisions=32,32
//   darboux_deform data/pinched_cylinder.yaml --out=pinched --export=inp,csv,npz
//
// Exit status: 0 converged, and every `expect` of the scene holds; 1 not converged, an `expect`
// fails, model.accuracy is not reached, the mesh does not resolve the answer, interrupted, or the
// results could not be written; 2 bad input, with nothing written. SIGINT and SIGTERM stop the
// solver; what it has reached is written.
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
#include "solver/report_view.h"
#include "solver/results.h"
#include "solver/shell_solver.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(export,
              "",
              "output | FORMATS | csv, npz or inp, joined by commas; default: none | What to write "
              "besides: csv, fields_NNNN.csv and fields.csv; npz, fields.npz for NumPy; inp, "
              "shell.inp, the scene for CalculiX and Abaqus.");
DEFINE_bool(export_only,
            false,
            "output | | | With --export=inp: writes shell.inp and ends, without "
            "solving.");
DEFINE_string(inp_element,
              "auto",
              "output | ELEMENT | auto, S3, S4, S6, S8R, C3D15 or C3D20R | Elements of shell.inp; "
              "S4, S8R and C3D20R on parametric surfaces only. auto: solid ones, C3D20R or, on "
              "meshes, C3D15; S8R or S6 where edges have moments in the nonlinear theory.");

namespace darboux {
namespace {

constexpr HelpItem kArguments[] = {
    {"SCENE.yaml",
     "Surface, shell, supports, loads, fingers, gas, path and probes; data/README.md has all keys. "
     "Any consistent system of units. Files in it are relative to it."}};

constexpr HelpItem kFiles[] = {
    {"summary.json", "what is on and why, energies, probes, fingers, reactions, stability, times"},
    {"shell.pvd", "all load steps, for ParaView"},
    {"shell.vtu", "the last state: displacements, strains, stresses, curvatures, normals"},
    {"shell_NNNN.vtu", "the same of each load step"},
    {"deformed.ply", "the deformed surface as a triangle mesh"},
    {"history.csv", "one row per load step"},
    {"contact.csv",
     "of scenes with fingers: of each load step a row for every point in contact, its place, "
     "pressure and friction"},
    {"fields_NNNN.csv, fields.csv",
     "with --export=csv: the fields of each load step and of the last, a row per point"},
    {"fields.npz", "with --export=npz: all of them as arrays of NumPy"},
    {"shell.inp", "with --export=inp: the scene for CalculiX and Abaqus"},
    {"report.html", "with --report: shape, numbers and plots in one file, for any browser"}};

constexpr HelpItem kExitStatuses[] = {
    {"0", "converged, and every expectation of the scene holds"},
    {"1",
     "not converged or interrupted (the last state is written and marked), an expectation fails, "
     "model.accuracy is not reached, the mesh does not resolve the answer (resolution.roughness "
     "above "
     "0.25 in summary.json), or results cannot be written"},
    {"2", "bad input: one line on stderr says where and what is allowed; nothing is written"}};

constexpr HelpItem kExamples[] = {
    {"darboux_deform data/pinched_cylinder.yaml --out=pinched",
     "A pinched cylinder; open pinched/shell.pvd in ParaView:"},
    {"darboux_deform data/nonlinear_plate_p50.yaml --divisions=32,32 --out=plate",
     "A plate that bends by more than its thickness, on a finer lattice:"},
    {"darboux_deform data/tennis_ball_patches.yaml --threads=1 --time_limit=60 \\\n"
     "  --quiet --out=ball",
     "A ball under two patches of force, on one thread, for at most a minute:"}};

constexpr Tool kTool = {
    "darboux_deform",
    "SCENE.yaml --out=DIR [flags]",
    "Solves a scene: the displacements of a thin shell under its loads, fingers and gas are those "
    "of least potential energy on a Loop subdivision surface. One line per load step goes to "
    "stderr, a report to stdout.\n\n"
    "With model.accuracy in the scene the divisions are refined until the estimated error is "
    "within it. Flags that override the scene do not change its expectations: these are evaluated "
    "as they stand, and decide about the exit status.",
    1,
    "computes how a thin shell deforms",
    kArguments,
    kFiles,
    kExitStatuses,
    "The first SIGINT (Ctrl-C) or SIGTERM stops the solver; what it has reached is written, marked "
    "as not converged, and the exit status is 1. The second one ends the process.",
    kExamples};

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

void SayLevel(const AccuracyLevel& level) {
  progress::Json fields = {{"dof", level.dof}, {"seconds", level.seconds}};
  if (level.divisions[0] > 0) fields["divisions"] = level.divisions;
  if (level.estimate) fields["estimated_error"] = *level.estimate;
  progress::Say("level", fields, "level " + FormatLevel(level));
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
  for (const std::string& remark : remarks) {
    progress::Say(
        "remark", {{"text", remark}}, std::string(kTool.name) + ": shell.inp: warning: " + remark);
  }
}

int ExportOnly(const Scene& scene, const ExportOptions& exports, int num_threads) {
  std::vector<NamedFile> files;
  std::vector<std::string> remarks;
  std::string error;
  if (!ExportScene(scene, exports, num_threads, &files, &remarks, &error)) return BadInput(error);
  if (!WriteFiles(FLAGS_out, files, &error)) return NotDone(error);
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
      !ReadSceneWithFlags(arguments[0], &scene, &overridden, &error) ||
      !ExportOptionsFromFlags(scene, &exports, &error) || !CheckOut(&error)) {
    return BadInput(error);
  }

  if (FLAGS_export_only) return ExportOnly(scene, exports, options.num_threads);

  options.stop = StopOnSignal();
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  AccuracyReport accuracy;
  const bool refines = scene.model.accuracy.has_value();
  progress::Watch(!refines, "", &options);
  bool posed;
  if (refines) {
    AccuracyOptions accuracy_options;
    accuracy_options.on_level = SayLevel;
    posed =
        SolveToAccuracy(scene, options, accuracy_options, &problem, &summary, &accuracy, &error);
  } else {
    posed = Solve(scene, options, &problem, &summary, &error);
  }
  if (!posed) return BadInput(error);

  Results results;
  std::vector<NamedFile> exported;
  std::vector<std::string> remarks;
  if (!MakeFieldExports(*problem, exports, ExportStatesOf(summary), {}, &exported, &error) ||
      !MakeInpExport(*problem, exports, &summary, &exported, &remarks, &error)) {
    return NotDone(error);
  }
  const MoreFiles more = [&](const nlohmann::ordered_json& json) {
    if (FLAGS_report) {
      exported.push_back(
          {kReportFile, MakeReportHtml(MakeSceneReport(kTool.name, *problem, summary, json))});
    }
    return exported;
  };
  if (!WriteResults(
          FLAGS_out, *problem, summary, refines ? &accuracy : nullptr, &results, &error, more)) {
    return NotDone(error);
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
    std::printf("results in %s: %zu files, summary.json, shell.pvd (ParaView)%s\n",
                FLAGS_out.c_str(),
                results.files.size(),
                FLAGS_report ? ", report.html (browser)" : "");
    std::fflush(stdout);
  }

  // What is wrong, in one line each; these are all that --quiet lets through.
  exit_status = kExitDone;
  const auto complain = [&exit_status](const std::string& message) {
    progress::Error(message);
    exit_status = kExitNotConverged;
  };
  if (!results.converged) {
    complain("not converged: " + results.summary["message"].get<std::string>());
  }
  if (refines && !accuracy.reached) complain("warning: " + accuracy.message);
  if (results.converged && summary.resolution && !summary.resolution->IsSufficient()) {
    complain("warning: " + summary.resolution->Complaint());
  }
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
