#include "costs/support.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

namespace darboux {

Support::Support(std::vector<Condition> conditions) : conditions_(std::move(conditions)) {
  CHECK(!conditions_.empty());
  for (int i = 0; i < conditions_.front().coefficients.cols(); ++i) {
    mutable_parameter_block_sizes()->push_back(3);
  }
  set_num_residuals(static_cast<int>(conditions_.size()));
}

bool Support::Evaluate(double const* const* displacements,
                       double* residuals,
                       double** jacobians) const {
  for (size_t row = 0; row < conditions_.size(); ++row) {
    const Condition& condition = conditions_[row];
    const double scale = std::sqrt(condition.stiffness);
    double c = condition.target == nullptr ? 0.0 : -*condition.target;
    for (int i = 0; i < condition.coefficients.cols(); ++i) {
      const Eigen::Map<const Eigen::Vector3d> u(displacements[i]);
      c += condition.coefficients.col(i).dot(u);
      if (jacobians != nullptr && jacobians[i] != nullptr) {
        Eigen::Map<Eigen::Vector3d>(jacobians[i] + 3 * row) = scale * condition.coefficients.col(i);
      }
    }
    residuals[row] = scale * c;
  }
  return true;
}

}  // namespace darboux
