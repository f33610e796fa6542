#ifndef DARBOUX_COSTS_GAS_BLOCKS_H_
#define DARBOUX_COSTS_GAS_BLOCKS_H_

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include "costs/follower_pressure.h"
#include "costs/gas.h"

namespace darboux {

// The energy U(V) of a gas (costs/gas.h) couples all control vertices of a shell, because V does.
// As residual blocks that stay sparse: from a state V_k on,
//
//   U = U(V_k) - p_k (V - V_k) + D(S),   S = V - V_k,   D the part of U beyond its tangent
//
// where the first part is FollowerPressure with the pressure p_k frozen, and S is summed over a
// binary tree whose leaves are the elements: an unknown share s of every node, S = unit * s, and
// one spring of stiffness k per node between its share and what it should be,
//
//   leaf      r = sqrt(k) (V_e - V_e,k - unit s_e)         GasShare, k in Pa/m^3
//   branch    r = sqrt(k) unit (s_left + s_right - s)      GasSum
//   root      r = sqrt(2 D(unit s)), with the sign of s    GasSpring, sqrt(J)
//
// Shares in units of `unit`, an area, are lengths, as the other unknowns are. The N springs are one
// behind the other: where the gas is as stiff as K, they leave K N / k of the pressure's change
// behind, which the next V_k takes up.

// Parameters: one block of 3 per control vertex of the element, then the share.
class GasShare : public ceres::CostFunction {
 public:
  // *element, *reference (V_e - its rest volume in the state V_k, m^3) must outlive this.
  GasShare(const FollowerPressure* element, const double* reference, double stiffness, double unit);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const FollowerPressure* element_;
  const double* reference_;
  double scale_, unit_;
};

// Parameters: shares of the left and the right branch, and of the node.
class GasSum : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  GasSum(double stiffness, double unit);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  double scale_;
};

// Parameter: the share of the root. Evaluation fails (Ceres rejects the step) where no volume is
// left.
class GasSpring : public ceres::SizedCostFunction<1, 1> {
 public:
  // *gas, and *change (V_k - V_0), must outlive this. scale: of the energy.
  GasSpring(const Gas* gas, const double* change, double unit, double scale);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const Gas* gas_;
  const double* change_;
  double unit_, scale_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_GAS_BLOCKS_H_
