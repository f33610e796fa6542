// What accuracy costs: solves one scene with many settings and sets errors against times.
// Sample runs:
//   darboux_accuracy data/pinched_cylinder.yaml --out=cost
//   darboux_accuracy data/pinched_cylinder.yaml --out=cost --sweep=resolution,grading --product
//   darboux_accuracy data/tennis_ball.yaml --out=cost --max_dof=5000 --time_limit=300 --target=0.02
//
// Exit status: 0 done; 1 no reference could be established, nothing converged, or interrupted (what
// there is is written), or the results could not be written; 2 bad input, with nothing written.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "solver/accuracy_results.h"
#include "solver/accuracy_study.h"
#include "solver/file_set.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(sweep,
              "",
              "What is varied, joined by commas: resolution, grading, quadrature, boundary_rule, "
              "strains, theory, solver. Default: all of them.");
DEFINE_bool(product, false, "All combinations of what is varied, not each by itself.");
DEFINE_int32(levels,
             0,
             "Resolutions, 1 to 12: from a quarter of the scene's divisions (or frequency of an "
             "icosphere) upwards by factors of 2, of other meshes from their own. Default: 5, "
             "meshes 3.");
DEFINE_double(max_dof, 30000, "Runs with more degrees of freedom are left out.");
DEFINE_int32(repeats, 1, "Runs of each setting, 1 to 1000, of which the least times count.");
DEFINE_string(clock,
              "wall",
              "Seconds that count in plot and verdicts: wall, or cpu, those of all processors, "
              "which a busy machine changes less.");
DEFINE_double(target,
              0.0,
              "A relative error in (0, 1) of your own, besides 0.1, 0.01 and 0.001. Default: the "
              "scene's model.accuracy, if any.");
DEFINE_string(reference,
              "auto",
              "auto: the scene's expectations, or where there are none richardson; richardson: "
              "extrapolated from the runs.");

namespace darboux {
namespace {

constexpr Tool kTool = {
    "darboux_accuracy",
    "SCENE.yaml --out=DIR [flags]",
    "What accuracy costs in time: solves a scene over resolutions, and with each of the other\n"
    "settings varied one at a time over the resolutions. Errors are against the scene's\n"
    "expectations or a Richardson extrapolation. Writes accuracy.csv, accuracy.json and\n"
    "accuracy.svg into DIR, prints a table and the cheapest settings for 10 %, 1 % and 0.1 %.\n"
    "--time_limit is that of the whole study. Each run has a process of its own.\n"
    "\n"
    "exit status: 0 done\n"
    "             1 no reference, nothing converged or interrupted (what there is is written)\n"
    "             2 bad input, nothing written",
    1};

void PrintError(const std::string& message) { progress::Error(message); }

bool StudyOptionsFromFlags(StudyOptions* options, std::string* error) {
  const auto fail = [error](const char* flag, const std::string& allowed) {
    *error = "--" + std::string(flag) + ": found '" +
             gflags::GetCommandLineFlagInfoOrDie(flag).current_value + "'; allowed " + allowed;
    return false;
  };
  if (!SolverOptionsFromFlags(&options->solver, error)) return false;
  if (!FLAGS_sweep.empty() && !ParseStudyAxes(FLAGS_sweep, &options->plan.axes, error)) {
    *error = "--sweep: " + *error;
    return false;
  }
  if (FLAGS_levels < 0 || FLAGS_levels > 12) return fail("levels", "an integer from 1 to 12");
  if (FLAGS_repeats < 1 || FLAGS_repeats > 1000)
    return fail("repeats", "an integer from 1 to 1000");
  if (!(FLAGS_max_dof >= 1.0) || !std::isfinite(FLAGS_max_dof))
    return fail("max_dof", "a number >= 1");
  if (!(FLAGS_target >= 0.0 && FLAGS_target < 1.0)) return fail("target", "a number in (0, 1)");
  if (FLAGS_reference != "auto" && FLAGS_reference != "richardson") {
    return fail("reference", "auto | richardson");
  }
  if (FLAGS_clock != "wall" && FLAGS_clock != "cpu") return fail("clock", "wall | cpu");
  options->count_cpu = FLAGS_clock == "cpu";
  options->plan.product = FLAGS_product;
  options->plan.levels = FLAGS_levels;
  options->plan.backend = options->solver.backend;
  options->max_dof = FLAGS_max_dof;
  options->repeats = FLAGS_repeats;
  options->richardson = FLAGS_reference == "richardson";
  return true;
}

int Run(int argc, char** argv) {
  std::vector<std::string> arguments, overridden;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  Scene scene;
  StudyOptions options;
  std::string error;
  if (!StudyOptionsFromFlags(&options, &error) ||
      !ReadSceneWithFlags(arguments[0], &scene, &error) ||
      !ApplyFlags(&scene, &overridden, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  if (!IsWritableFolder(FLAGS_out, &error)) {
    PrintError("--out: found " + error + "; allowed a folder that can be written to");
    return kExitBadInput;
  }
  const double target = FLAGS_target > 0.0 ? FLAGS_target : scene.model.accuracy.value_or(0.0);
  std::vector<double>& targets = options.targets;
  if (target > 0.0 && std::find(targets.begin(), targets.end(), target) == targets.end()) {
    targets.push_back(target);
    std::sort(targets.rbegin(), targets.rend());
  }
  options.solver.stop = StopOnSignal();
  options.on_run = [](const StudyRun& run, int done, int planned, double seconds_left) {
    const RunOutcome& outcome = run.outcome;
    progress::Json fields = {{"run", done},
                             {"runs", planned},
                             {"settings", run.label},
                             {"status", ToString(outcome.status)}};
    if (outcome.dof >= 0) fields["dof"] = outcome.dof;
    if (outcome.total_s >= 0.0) fields["seconds"] = outcome.total_s;
    fields["seconds_left"] = seconds_left;
    std::string line = std::to_string(done) + "/" + std::to_string(planned) + " " + RunLine(run);
    if (done < planned && seconds_left >= 1.0) {
      line += ", about " + progress::FormatDuration(seconds_left) + " left";
    }
    progress::Say("run", fields, line);
  };
  Study study;
  if (!RunStudy(scene, options, &study, &error)) {
    PrintError(error);
    return kExitBadInput;
  }
  if (!WriteStudy(FLAGS_out, study, &error)) {
    PrintError(error);
    return kExitNotConverged;
  }
  if (!FLAGS_quiet) {
    std::printf("%s", StudyReport(study).c_str());
    std::printf("results in %s: accuracy.csv, accuracy.json, accuracy.svg\n", FLAGS_out.c_str());
    std::fflush(stdout);
  }
  if (study.stopped) {
    PrintError("interrupted");
    return kExitNotConverged;
  }
  if (!study.established) {
    PrintError("no errors: reference " + study.reference.method);
    return kExitNotConverged;
  }
  return kExitDone;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
