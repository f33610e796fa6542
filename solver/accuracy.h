#ifndef DARBOUX_SOLVER_ACCURACY_H_
#define DARBOUX_SOLVER_ACCURACY_H_

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/scene.h"
#include "solver/shell_solver.h"

namespace darboux {

// One resolution of a refinement.
struct AccuracyLevel {
  std::array<int, 2> divisions{};
  int dof = 0;
  // Relative discretisation error of this level's answer; none on the first level, which has
  // nothing to be compared with.
  std::optional<double> estimate;
  double seconds = 0.0;
};

struct AccuracyReport {
  double target = 0.0;
  std::optional<double> estimate;  // of the last level
  bool reached = false;
  std::string message;  // why the refinement ended
  std::vector<AccuracyLevel> levels;
};

struct AccuracyOptions {
  int max_dof = 200000;
  std::function<void(const AccuracyLevel&)> on_level;  // after each level
};

// Solves a scene that names model.accuracy: at its divisions, at twice them, and so on, until the
// estimated relative error is within the accuracy. For a quantity Q with the values Q_k,
//
//   estimate_k = |Q_k - Q_(k-1)| / ((2^p - 1) |Q_k|)        (Richardson)
//
// with the order p in the mesh size seen on the last three levels, no better than 2 and no worse
// than 1/2, and 2 on the second level. The estimate of a level is the largest over the displacement
// vectors of the probes, or where there are none over the largest displacement and the total
// energy. A probe that moves less than 1e-4 of the largest displacement is measured against that:
// a held point has no relative error. Only discretisation is estimated; what the linear theory
// leaves out is weighed by `theory: auto` with the same number (SolverOptions::theory_tolerance).
//
// Ends early, and says so, where the next level has more than max_dof or does not fit into the
// time that is left (each level takes about five times as long as the one before), where a level
// does not converge and where options.stop is set. The answer is that of the finest level that
// converged; where none did, the first one's. Times in *summary are the sums over all levels.
//
// False and *error as of Solve. Requires scene.model.accuracy.
bool SolveToAccuracy(const Scene& scene,
                     const SolverOptions& solver_options,
                     const AccuracyOptions& options,
                     std::unique_ptr<ShellProblem>* problem,
                     SolverSummary* summary,
                     AccuracyReport* report,
                     std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_H_
