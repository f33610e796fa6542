#ifndef DARBOUX_SOLVER_ACCURACY_STUDY_H_
#define DARBOUX_SOLVER_ACCURACY_STUDY_H_

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "solver/accuracy_plan.h"
#include "solver/accuracy_reference.h"
#include "solver/scene.h"
#include "solver/shell_solver.h"

namespace darboux {

// What accuracy costs: one scene, solved with many settings, its errors against the time taken.

// How one run came out.
struct RunOutcome {
  enum class Status {
    kConverged,
    kNotConverged,
    kImpossible,  // these settings make no problem; `reason` is what a tool would say
    kSkipped,     // not tried: too large, or no time left
    kStopped,
    kCrashed
  };
  Status status = Status::kSkipped;
  std::string reason;  // where not converged
  Theory theory = Theory::kAuto;
  std::string backend;
  int dof = -1, elements = -1, quadrature_points = -1, iterations = -1;
  std::map<std::string, double> values;  // of the quantities, by path; finite ones only
  // Seconds of wall clock: assembling, solving, all of Solve; and of all threads' processors.
  double setup_s = -1.0, solve_s = -1.0, total_s = -1.0, cpu_s = -1.0;
  double memory_mb = -1.0;  // peak resident memory of a process that does this alone; -1 unknown
};
const char* ToString(RunOutcome::Status status);

// Solves `scene`, whose `expect` names the quantities asked for.
using Runner = std::function<RunOutcome(const Scene& scene, const SolverOptions& options)>;
// In this process; no memory is told.
RunOutcome RunHere(const Scene& scene, const SolverOptions& options);
// In a process of its own (solver/forked_run.h): a crash is an outcome, memory is told.
RunOutcome RunInChild(const Scene& scene, const SolverOptions& options);

// A run with its outcome, and what it is worth.
struct StudyRun {
  PlannedRun plan;
  std::array<int, 2> divisions{0, 0};  // parametric kinds
  std::string label;                   // DescribeRun
  RunOutcome outcome;
  std::optional<StudyError> error;  // none where not converged
  double cost_s = -1.0;             // seconds that count, wall clock or processor
  // Another theory or other strains than the scene's: the error has that of the model in it.
  bool other_model = false;
  // Among the runs of the scene's own model:
  bool on_front = false;      // none is both faster and more accurate
  bool on_dof_front = false;  // ... has both fewer dof and less error
  // An error below what is known of the reference counts as that.
  double CountedError() const { return std::max(error->error, error->uncertainty); }
};

// What errors are measured against.
struct StudyReference {
  enum class Kind { kNone, kExpect, kRichardson };
  Kind kind = Kind::kNone;
  std::vector<StudyQuantity> quantities;
  double uncertainty = 0.0;  // the largest of the quantities
  std::string method;        // in words
};

// The least seconds that reach an error.
struct CheapestRun {
  double target = 0.0;
  int run = -1;  // of the scene's own model, index into Study::runs; -1: not reached
  std::string text;
};

// Everything that a study has found.
struct Study {
  std::string name;  // of the scene
  bool count_cpu = false;
  std::vector<std::string> families;
  std::vector<StudyRun> runs;
  StudyReference reference;
  std::optional<RichardsonReference> richardson;  // also beside an expectation
  std::vector<CheapestRun> cheapest;
  std::vector<std::string> notes;
  bool stopped = false;
  bool established = false;  // there is a reference and a run with an error
};

// What a study varies, and what it may cost.
struct StudyOptions {
  PlanOptions plan;
  SolverOptions solver;     // its time limit is that of the whole study; 0 = none
  double max_dof = 30000;   // of one run
  int repeats = 1;          // of each run; the least time of each phase counts
  bool count_cpu = false;   // the processors' seconds count, not those of the wall clock
  bool richardson = false;  // the reference even where the scene expects something
  std::vector<double> targets{0.1, 0.01, 0.001};  // relative errors
  Runner runner = RunInChild;
  // After each run: how many of the plan are done, and about how long the others will take, by
  // their dof and what those before have taken.
  std::function<void(const StudyRun&, int done, int planned, double seconds_left)> on_run;
};

// False and *error (bad input) where the scene cannot be posed with its own settings at any level.
bool RunStudy(const Scene& scene, const StudyOptions& options, Study* study, std::string* error);

// The steps of RunStudy after solving, for a study whose runs are there.
void EvaluateStudy(const Scene& scene, const StudyOptions& options, Study* study);

// Indices of the points that no other point beats in both, by rising cost. Points of equal error
// and cost: the first. Less error is less by a thousandth at least: solvers differ in the last
// digits.
std::vector<int> ParetoFront(const std::vector<double>& costs, const std::vector<double>& errors);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_STUDY_H_
