#ifndef DARBOUX_COSTS_SUPPORT_H_
#define DARBOUX_COSTS_SUPPORT_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

namespace darboux {

// One linear condition on the limit displacement or its derivatives at a surface point,
//
//   c = sum_i a_i . u_i - target = 0     (u_i control displacements of the point's element)
//
// held by a spring of stiffness k: r = sqrt(k) c, energy k c^2 / 2, reaction -k c. Displacement
// components have a_i = N_i * direction, rotations a_i = (t[N])_i * direction.
//
// One condition per element edge and component is all that the three control rows next to a side
// can follow; more, at a large stiffness, lock them (theory.md, erratum 3). With one, the stiffness
// can be high enough for its error to vanish, because it acts like a Lagrange multiplier that is
// constant along the edge.
// Parameters: one block of 3 per control vertex.
class Support : public ceres::CostFunction {
 public:
  // One linear condition, sum_i a_i . u_i = target, in the notation above.
  struct Condition {
    Eigen::Matrix3Xd coefficients;   // column i: a_i
    double stiffness = 0.0;          // k, > 0
    const double* target = nullptr;  // read at every evaluation; null = 0. Must outlive the block.
  };

  // All conditions of one block act on the same control vertices.
  explicit Support(std::vector<Condition> conditions);

  bool Evaluate(double const* const* displacements,
                double* residuals,
                double** jacobians) const override;

 private:
  std::vector<Condition> conditions_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_SUPPORT_H_
