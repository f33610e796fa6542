#ifndef DARBOUX_SOLVER_STABILITY_H_
#define DARBOUX_SOLVER_STABILITY_H_

#include <Eigen/Core>
#include <limits>

#include "solver/mixed_iteration.h"

namespace darboux {

// Whether an equilibrium of the nonlinear theory is a minimum of the energy.
struct Stability {
  // Negative eigenvalues of the Hessian; 0 = stable, -1 = the matrix is singular.
  int negative_modes = -1;
  // Of the softest mode m: m^T K m / m^T K_0 m, K the Hessian and K_0 the same without the stresses
  // and the forces that follow. 1 where they do not matter, 0 at a critical point, negative beyond.
  // NaN where it was not computed.
  double softness = std::numeric_limits<double>::quiet_NaN();
  // Control displacements of the softest mode; its largest is 1. Empty where the state is stable
  // and softness above kNearlyUnstable.
  Eigen::Matrix3Xd mode;
};

constexpr double kNearlyUnstable = 0.05;

// In the present state of the problem that `mixed` solves. Leaves a factor of the Hessian in
// mixed->cholesky(), shifted where the state is unstable.
Stability CheckStability(MixedIteration* mixed);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_STABILITY_H_
