#include "costs/gas.h"

#include <cmath>

namespace darboux {

Gas::Gas(double gauge, double ambient, double gamma, double rest_volume)
    : gauge_(gauge), ambient_(ambient), gamma_(gamma), rest_volume_(rest_volume) {}

double Gas::GaugePressure(double change) const {
  // (A + P) (V / V_0)^-gamma - A
  return gauge_ + (ambient_ + gauge_) * std::expm1(-gamma_ * std::log1p(change / rest_volume_));
}

double Gas::PressureDerivative(double change) const {
  return -gamma_ * (ambient_ + GaugePressure(change)) / (rest_volume_ + change);
}

double Gas::Energy(double change) const {
  const double logarithm = std::log1p(change / rest_volume_);
  const double work =
      gamma_ == 1.0 ? -logarithm : std::expm1((1.0 - gamma_) * logarithm) / (gamma_ - 1.0);
  return (ambient_ + gauge_) * rest_volume_ * work + ambient_ * change;
}

}  // namespace darboux
