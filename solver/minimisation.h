#ifndef DARBOUX_SOLVER_MINIMISATION_H_
#define DARBOUX_SOLVER_MINIMISATION_H_

#include <ceres/types.h>

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>

#include "solver/iteration_log.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// How a ShellProblem is minimised at one load factor, and how an equilibrium is judged. Inside of
// the solver.

using Clock = std::chrono::steady_clock;

inline double Since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// When to stop: at a time, or when told to.
struct Deadline {
  Clock::time_point start;
  double limit_s;
  const std::atomic<bool>* stop;
  IterationLog* log = nullptr;  // of the solve that this limits

  bool Stopped() const { return stop != nullptr && stop->load(); }
  bool TimedOut() const { return limit_s > 0.0 && Since(start) >= limit_s; }
  // Whether it is over, and why.
  bool IsOver(std::string* message) const {
    if (!Stopped() && !TimedOut()) return false;
    *message = Stopped() ? "stopped by the user" : "time limit reached";
    return true;
  }
  double Remaining() const { return limit_s > 0.0 ? std::max(limit_s - Since(start), 0.01) : 1e9; }
};

// The force scale that gradients are measured against, and the relative gradient.
struct Equilibrium {
  double relative_gradient = 0.0;
  double reference = 0.0;  // N, loads and reactions
  double loads = 0.0;      // N, loads alone
};

Equilibrium CheckEquilibrium(ShellProblem* problem);

// Relative change of the gradient when every unknown moves by one unit of rounding: no state in
// double can be told from equilibrium below about ten times it (a residual sums a dozen terms).
// Matters for supports and membranes that are stiff against a large displacement.
constexpr double kRoundings = 10.0;

double RoundingFloor(ShellProblem* problem, double reference);

// The backend that Ceres takes.
ceres::SparseLinearAlgebraLibraryType BackendOf(SparseBackend backend);

// The linear theory: a factorisation of our own, or Ceres' Gauss-Newton steps with minimizer ceres
// and where the former fails.
bool SolveLinear(ShellProblem* problem,
                 const SolverOptions& options,
                 const Deadline& deadline,
                 int* iterations,
                 Equilibrium* equilibrium,
                 std::string* message);

// Moves the problem to the lowest energy among multiples of the linear solution; returns the
// multiple. A stretched plate lies far below the linear theory (w = 2 h where it says 7 h): from
// here Newton's steps go down at once, from rest the first one overshoots and all damping has to be
// found by failing.
double StartFromLinear(const Eigen::Matrix3Xd& linear, ShellProblem* problem);

// Ceres' Levenberg-Marquardt at the problem's present load factor, from its present state: goes
// down in energy, and certifies what it ends with.
bool Descend(ShellProblem* problem,
             const SolverOptions& options,
             const Deadline& deadline,
             int* iterations,
             Equilibrium* equilibrium,
             std::string* message);

// The procedure of Tian & Jia (2010), Sec. VI, for comparison: a cone of displacement around each
// contact, here each point load, with the height of lowest energy (returned; 0 where there is no
// point load), and nonlinear conjugate gradients, here Ceres' line search. Thousands of iterations
// where the others take tens; ends at the first that gains nothing any more.
double StartFromCones(ShellProblem* problem);
bool DescendByConjugateGradients(ShellProblem* problem,
                                 const SolverOptions& options,
                                 const Deadline& deadline,
                                 int* iterations,
                                 Equilibrium* equilibrium,
                                 std::string* message);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MINIMISATION_H_
