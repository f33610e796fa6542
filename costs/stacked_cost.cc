#include "costs/stacked_cost.h"

#include <glog/logging.h>

#include <utility>

namespace darboux {

StackedCost::StackedCost(std::vector<std::unique_ptr<ceres::CostFunction>> parts)
    : parts_(std::move(parts)) {
  CHECK(!parts_.empty());
  *mutable_parameter_block_sizes() = parts_.front()->parameter_block_sizes();
  int residuals = 0;
  for (const auto& part : parts_) {
    CHECK(part->parameter_block_sizes() == parameter_block_sizes());
    residuals += part->num_residuals();
  }
  set_num_residuals(residuals);
}

bool StackedCost::Evaluate(double const* const* parameters,
                           double* residuals,
                           double** jacobians) const {
  // Jacobians are row-major, so each part's rows are contiguous in every block.
  const std::vector<int32_t>& sizes = parameter_block_sizes();
  std::vector<double*> rows;
  if (jacobians != nullptr) rows.assign(jacobians, jacobians + sizes.size());
  for (const auto& part : parts_) {
    if (!part->Evaluate(parameters, residuals, jacobians == nullptr ? nullptr : rows.data())) {
      return false;
    }
    residuals += part->num_residuals();
    for (size_t i = 0; i < rows.size(); ++i) {
      if (rows[i] != nullptr) rows[i] += part->num_residuals() * sizes[i];
    }
  }
  return true;
}

}  // namespace darboux
