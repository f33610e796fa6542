#ifndef DARBOUX_COSTS_STACKED_COST_H_
#define DARBOUX_COSTS_STACKED_COST_H_

#include <ceres/cost_function.h>

#include <memory>
#include <vector>

namespace darboux {

// Several cost functions on the same parameter blocks as one residual block, their residuals one
// below the other. Ceres' normal equations pay per block and pair of parameter blocks, so membrane
// and bending energy of an element together cost little more than either alone.
class StackedCost : public ceres::CostFunction {
 public:
  // All parts have the same parameter block sizes.
  explicit StackedCost(std::vector<std::unique_ptr<ceres::CostFunction>> parts);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

  const std::vector<std::unique_ptr<ceres::CostFunction>>& parts() const { return parts_; }

 private:
  std::vector<std::unique_ptr<ceres::CostFunction>> parts_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_STACKED_COST_H_
