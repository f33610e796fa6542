#ifndef DARBOUX_COSTS_POTENTIAL_H_
#define DARBOUX_COSTS_POTENTIAL_H_

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <vector>

namespace darboux {

// An energy that is not a sum of squares, carried exactly through a least-squares solver.
//
// The block has the constant residual r = s and the Jacobian dU/dx / s, and a LossFunction of its
// own that returns rho = {2 U, 1, 0}. Ceres takes rho[0] / 2 = U as the cost and, as rho' = 1 and
// rho'' = 0, leaves r and J alone: the gradient J^T r is dU/dx exactly, and J^T J =
// (dU/dx)(dU/dx)^T / s^2 is as small as s is large. s only has to keep that curvature far below the
// stiffness of the shell; results do not depend on it over many orders of magnitude.
//
// Ceres evaluates cost and loss of a block back to back in one thread; the pair shares the energy
// through energy_. Never share the loss between blocks.
class Potential : public ceres::CostFunction {
 public:
  // `curvature_scale` s: energy / force * (stiffness / energy)^(1/2); see ShellProblem.
  explicit Potential(double s) : s_(s) { set_num_residuals(1); }

  // Adds the block with its loss; the problem owns both. Returns Ceres' id.
  static ceres::ResidualBlockId AddTo(ceres::Problem* problem,
                                      Potential* potential,
                                      const std::vector<double*>& parameters);

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const final;

 protected:
  // U and, where gradients != nullptr and gradients[i] != nullptr, dU/d(parameter block i).
  virtual bool EvaluateEnergy(double const* const* parameters,
                              double* energy,
                              double** gradients) const = 0;

 private:
  class Loss;

  double s_;
  mutable double energy_ = 0.0;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_POTENTIAL_H_
