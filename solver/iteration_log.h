#ifndef DARBOUX_SOLVER_ITERATION_LOG_H_
#define DARBOUX_SOLVER_ITERATION_LOG_H_

#include <chrono>
#include <functional>
#include <vector>

namespace darboux {

// One iteration on the way to an equilibrium: what progress displays and convergence plots show.
struct IterationReport {
  enum class Method {
    kLinear,             // factorisation of the linear theory, one entry a solution
    kMixed,              // the mixed iteration, solver/mixed_iteration.h
    kCeres,              // Ceres' trust region
    kConjugateGradient,  // Ceres' line search
    kPath                // correctors of an equilibrium path, solver/path_following.h
  };
  Method method = Method::kMixed;
  int step = 1;  // load step under way, 1-based; of `steps`
  int steps = 1;
  double load_factor = 0.0;  // under way to it
  int iteration = 0;         // counts from 0 in every solution at a load factor
  int total = 0;             // since Solve began
  double energy = 0.0;       // J, of the state the iteration starts from; contact as Ceres has it
  double relative_gradient = 0.0;  // |g| / (|f| + |reactions|) there
  double seconds = 0.0;            // since Solve began
};

// "linear", "mixed", "ceres", "cg", "path".
const char* ToString(IterationReport::Method method);

// Collects the reports of one Solve and passes each on. Inside of the solver.
class IterationLog {
 public:
  IterationLog(std::chrono::steady_clock::time_point start,
               int steps,
               std::function<void(const IterationReport&)> on_iteration,
               std::vector<IterationReport>* history)
      : start_(start), on_iteration_(std::move(on_iteration)), history_(history) {
    report_.steps = steps;
  }

  void BeginStep(int step) { report_.step = step; }
  void Record(IterationReport::Method method,
              double load_factor,
              int iteration,
              double energy,
              double relative_gradient);

 private:
  std::chrono::steady_clock::time_point start_;
  std::function<void(const IterationReport&)> on_iteration_;
  std::vector<IterationReport>* history_;
  IterationReport report_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ITERATION_LOG_H_
