#ifndef DARBOUX_SOLVER_THEORY_ERROR_H_
#define DARBOUX_SOLVER_THEORY_ERROR_H_

#include <string>
#include <vector>

#include "solver/goal_response.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// What the nonlinear theory would change in a solution of the linear one, to first order: one
// Newton step of the nonlinear energy from the linear displacements u,
//
//   K(u) du = -g(u),   K and g the nonlinear theory's second derivative and gradient,
//
// seen in the goals. Costs a factorisation.
struct TheoryError {
  // Relative, of the worst goal; infinite where the linear displacements are no state of the
  // nonlinear theory, or one that its tangent stiffness does not hold (buckled).
  double value = 0.0;
  std::string goal;  // the worst
};

// Of a solved problem of the linear theory without fingers or gas. False and *error where the
// scene is no nonlinear problem.
bool EstimateTheoryError(const ShellProblem& linear,
                         const std::vector<Goal>& goals,
                         SparseBackend backend,
                         int num_threads,
                         TheoryError* result,
                         std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_THEORY_ERROR_H_
