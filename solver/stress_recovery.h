#ifndef DARBOUX_SOLVER_STRESS_RECOVERY_H_
#define DARBOUX_SOLVER_STRESS_RECOVERY_H_

#include <vector>

#include "solver/shell_problem.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// How far stresses are from smooth: around each element its stress resultants N, M and those of its
// neighbours are fitted by one polynomial N*, M* in its tangent plane (recovery: O. C. Zienkiewicz
// & J. Z. Zhu, "The superconvergent patch recovery and a posteriori error estimates", 1992), and
//
//   e_K^2 = integral over K of (N - N*) : A^-1 (N - N*) + (M - M*) : D^-1 (M - M*)  dA.
//
// A spline's stresses are wrong by what is not smooth in them: on a mesh that resolves the answer
// the sum of e_K^2 / 2 is a small part of the strain energy. Of any surface, parametric or mesh.
class StressRecovery {
 public:
  // The problem must outlive this.
  explicit StressRecovery(const ShellProblem& problem);

  // e_K of each element, for stress resultants times the area of each quadrature point, in the
  // units of the problem.
  std::vector<double> Norms(const TangentStiffness::StressField& stresses, int num_threads) const;

 private:
  double Norm(int element, const TangentStiffness::StressField& stresses) const;

  const ShellProblem& problem_;
  std::vector<std::vector<int>> neighbourhoods_;
  std::vector<int> first_;  // point of each element
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_STRESS_RECOVERY_H_
