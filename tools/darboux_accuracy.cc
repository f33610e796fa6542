// What accuracy costs: solves one scene with many settings and sets errors against times.
// Sample runs:
//   darboux_accuracy data/pinched_cylinder.yaml --out=cost
//   darboux_accuracy data/pinched_cylinder.yaml --out=cost --sweep=resolution,grading --product
//   darboux_accuracy data/tennis_ball.yaml --out=cost --max_dof=5000 --time_limit=300 --target=0.02
//
// Exit status: 0 done; 1 no reference could be established, nothing converged, or interrupted (what
// there is is written), or the results could not be written; 2 bad input, with nothing written.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "solver/accuracy_results.h"
#include "solver/accuracy_study.h"
#include "solver/file_set.h"
#include "solver/report_view.h"
#include "solver/results.h"
#include "solver/shell_solver.h"
#include "tools/html_report.h"
#include "tools/progress.h"
#include "tools/solver_flags.h"

DEFINE_string(sweep,
              "",
              "study | LIST | some of resolution, grading, quadrature, boundary_rule, strains, "
              "theory, solver; default: all | What is varied, joined by commas.");
DEFINE_bool(product, false, "study | | | All combinations of what is varied, not each by itself.");
DEFINE_int32(levels,
             0,
             "study | N | 1 to 12; default: 5, meshes 3 | Resolutions: from a quarter of the "
             "scene's divisions (or frequency of an icosphere) upwards by factors of 2, of other "
             "meshes from their own.");
DEFINE_double(max_dof,
              30000,
              "study | DOF | >= 1 | Runs with more degrees of freedom are left out.");
DEFINE_int32(repeats, 1, "study | K | 1 to 1000 | Runs of each setting; the least times count.");
DEFINE_string(clock,
              "wall",
              "study | CLOCK | wall or cpu | Seconds that count in plot and verdicts: on the wall, "
              "or of all processors, which a busy machine changes less.");
DEFINE_double(target,
              0.0,
              "study | ERROR | relative, in (0, 1); default: the scene's model.accuracy, if any | "
              "An error of your own, besides 0.1, 0.01 and 0.001.");
DEFINE_string(reference,
              "auto",
              "study | REFERENCE | auto or richardson | auto: the scene's expectations, or where "
              "there are none richardson: extrapolated from the runs.");

namespace darboux {
namespace {

constexpr HelpItem kArguments[] = {
    {"SCENE.yaml",
     "A scene as of darboux_deform, parametric or a mesh. Errors are those of its expect entries; "
     "where it has none, of its probes and fingers against an extrapolation."}};

constexpr HelpItem kFiles[] = {
    {"accuracy.csv",
     "a row for each run: settings, dof, errors, seconds, memory, whether cheapest"},
    {"accuracy.json", "the same, with the reference, its uncertainty, and the cheapest settings"},
    {"accuracy.svg", "errors over degrees of freedom and over seconds"},
    {"report.html", "with --report: plots, table and verdicts in one file, for any browser"}};

constexpr HelpItem kExitStatuses[] = {
    {"0", "done"},
    {"1",
     "no reference, nothing converged or interrupted (what there is is written), or results cannot "
     "be written"},
    {"2", "bad input: one line on stderr says where and what is allowed; nothing is written"}};

constexpr HelpItem kExamples[] = {
    {"darboux_accuracy data/clamped_plate.yaml --max_dof=1500 --out=cost",
     "A plate over resolutions, and with everything else varied one at a time:"},
    {"darboux_accuracy data/pinched_cylinder.yaml --sweep=resolution,grading \\\n"
     "  --product --levels=3 --clock=cpu --repeats=2 --target=0.02 --out=cost",
     "All combinations of resolutions and gradings, in seconds of the processor, with an error of "
     "one's own:"}};

constexpr Tool kTool = {
    "darboux_accuracy",
    "SCENE.yaml --out=DIR [flags]",
    "Solves a scene over resolutions, and with each of the other settings varied one at a time "
    "over the resolutions. Errors are against the scene's expectations or a Richardson "
    "extrapolation. Prints a table and the cheapest settings for 10 %, 1 % and 0.1 %.\n\n"
    "--time_limit is that of the whole study; what does not fit is left out, and said so. Each "
    "run has a process of its own.",
    1,
    "shows what accuracy costs in time",
    kArguments,
    kFiles,
    kExitStatuses,
    "The first SIGINT (Ctrl-C) or SIGTERM ends the study; the runs done are written, and the exit "
    "status is 1. The second one ends the process.",
    kExamples};

bool StudyOptionsFromFlags(StudyOptions* options, std::string* error) {
  const auto fail = [error](const char* flag, const std::string& allowed) {
    return FailFlag(flag, allowed, error);
  };
  if (!SolverOptionsFromFlags(&options->solver, error)) return false;
  if (!FLAGS_sweep.empty() && !ParseStudyAxes(FLAGS_sweep, &options->plan.axes, error)) {
    *error = "--sweep: " + *error;
    return false;
  }
  if (FLAGS_levels < 0 || FLAGS_levels > 12) return fail("levels", "an integer from 1 to 12");
  if (FLAGS_repeats < 1 || FLAGS_repeats > 1000) {
    return fail("repeats", "an integer from 1 to 1000");
  }
  if (!(FLAGS_max_dof >= 1.0) || !std::isfinite(FLAGS_max_dof)) {
    return fail("max_dof", "a number >= 1");
  }
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

// The study and, to be looked at, the shape: the runs were processes of their own, so that one is
// solved again. That is the scene's own, or else the one with the least error.
Report MakeStudyReport(const Scene& scene, const StudyOptions& options, const Study& study) {
  Report report = MakeReport(kTool.name, scene.name);
  report.header["documents"]["accuracy"] = MakeAccuracyJson(study);
  const StudyRun* chosen = nullptr;
  for (const StudyRun& run : study.runs) {
    if (run.outcome.status != RunOutcome::Status::kConverged || run.other_model) continue;
    const bool is_own = run.plan.family == 0 && run.plan.settings.refinement == 1.0;
    const bool is_better = chosen == nullptr ||
                           (run.error && chosen->error && run.error->error < chosen->error->error);
    if (is_own || is_better) chosen = &run;
    if (is_own) break;
  }
  Scene chosen_scene = scene;
  std::string ignored;
  if (chosen == nullptr || options.solver.stop->load() ||
      !ApplySettings(chosen->plan.settings, &chosen_scene, &ignored)) {
    return report;
  }
  SolverOptions solver = options.solver;
  solver.backend = chosen->plan.settings.backend;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  if (!Solve(chosen_scene, solver, &problem, &summary, &ignored)) return report;
  ReportShape shape;
  shape.title = chosen->label;
  shape.problem = problem.get();
  shape.states = StatesOf(summary);
  AddShellView(shape, &report);
  AddHistory(chosen_scene, summary, &report);
  report.header["documents"]["summary"] = MakeSummaryJson(chosen_scene, summary, nullptr);
  return report;
}

int Run(int argc, char** argv) {
  std::vector<std::string> arguments, overridden;
  int exit_status = kExitBadInput;
  if (!ParseCommandLine(kTool, argc, argv, &arguments, &exit_status)) return exit_status;
  Scene scene;
  StudyOptions options;
  std::string error;
  if (!StudyOptionsFromFlags(&options, &error) ||
      !ReadSceneWithFlags(arguments[0], &scene, &overridden, &error) || !CheckOut(&error)) {
    return BadInput(error);
  }
  const double target = FLAGS_target > 0.0 ? FLAGS_target : scene.model.accuracy.value_or(0.0);
  std::vector<double>& targets = options.targets;
  if (target > 0.0 && std::find(targets.begin(), targets.end(), target) == targets.end()) {
    targets.push_back(target);
    std::sort(targets.rbegin(), targets.rend());
  }
  options.solver.stop = StopOnSignal();
  // The table at the end has all of it: lines are for who waits, and for machines.
  const bool tells = progress::IsJson() || isatty(STDERR_FILENO) != 0;
  options.on_run = [tells](const StudyRun& run, int done, int planned, double seconds_left) {
    if (!tells) return;
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
  if (!RunStudy(scene, options, &study, &error)) return BadInput(error);
  std::vector<NamedFile> more;
  if (FLAGS_report)
    more.push_back({kReportFile, MakeReportHtml(MakeStudyReport(scene, options, study))});
  if (!WriteStudy(FLAGS_out, study, &error, more)) return NotDone(error);
  if (!FLAGS_quiet) {
    std::printf("%s", StudyReport(study).c_str());
    std::printf("results in %s: accuracy.csv, accuracy.json, accuracy.svg%s\n",
                FLAGS_out.c_str(),
                FLAGS_report ? ", report.html" : "");
    std::fflush(stdout);
  }
  if (study.stopped) return NotDone("interrupted");
  if (!study.established) return NotDone("no errors: reference " + study.reference.method);
  return kExitDone;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  return darboux::RunTool(darboux::kTool, darboux::Run, argc, argv);
}
