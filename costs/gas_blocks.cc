#include "costs/gas_blocks.h"

#include <cmath>

namespace darboux {

GasShare::GasShare(const FollowerPressure* element,
                   const double* reference,
                   double stiffness,
                   double unit)
    : element_(element), reference_(reference), scale_(std::sqrt(stiffness)), unit_(unit) {
  *mutable_parameter_block_sizes() = element->parameter_block_sizes();
  mutable_parameter_block_sizes()->push_back(1);
  set_num_residuals(1);
}

bool GasShare::Evaluate(double const* const* parameters,
                        double* residuals,
                        double** jacobians) const {
  const size_t n = parameter_block_sizes().size() - 1;
  const double volume = element_->SweptVolume(parameters, jacobians);
  residuals[0] = scale_ * (volume - *reference_ - unit_ * parameters[n][0]);
  if (jacobians == nullptr) return true;
  for (size_t i = 0; i < n; ++i) {
    for (int a = 0; jacobians[i] != nullptr && a < 3; ++a) jacobians[i][a] *= scale_;
  }
  if (jacobians[n] != nullptr) jacobians[n][0] = -scale_ * unit_;
  return true;
}

GasSum::GasSum(double stiffness, double unit) : scale_(std::sqrt(stiffness) * unit) {}

bool GasSum::Evaluate(double const* const* parameters,
                      double* residuals,
                      double** jacobians) const {
  residuals[0] = scale_ * (parameters[0][0] + parameters[1][0] - parameters[2][0]);
  if (jacobians == nullptr) return true;
  for (int i = 0; i < 3; ++i) {
    if (jacobians[i] != nullptr) jacobians[i][0] = i < 2 ? scale_ : -scale_;
  }
  return true;
}

GasSpring::GasSpring(const Gas* gas, const double* change, double unit, double scale)
    : gas_(gas), change_(change), unit_(unit), scale_(scale) {}

bool GasSpring::Evaluate(double const* const* parameters,
                         double* residuals,
                         double** jacobians) const {
  const double more = unit_ * parameters[0][0];
  if (!gas_->IsDefined(*change_) || !gas_->IsDefined(*change_ + more)) return false;
  const double size = std::sqrt(2.0 * scale_ * gas_->Divergence(*change_, more));
  residuals[0] = more < 0.0 ? -size : size;
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  // r r' = D'; as S -> 0, r'^2 = D'' = -dp/dV.
  jacobians[0][0] =
      unit_ * (size > 0.0 ? scale_ * gas_->DivergenceSlope(*change_, more) / residuals[0]
                          : std::sqrt(-scale_ * gas_->PressureDerivative(*change_)));
  return true;
}

}  // namespace darboux
