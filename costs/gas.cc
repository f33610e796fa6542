#include "costs/gas.h"

#include <cmath>

namespace darboux {

Gas::Gas(double gauge, double ambient, double gamma, double rest_volume, bool linear)
    : gauge_(gauge), ambient_(ambient), gamma_(gamma), rest_volume_(rest_volume), linear_(linear) {}

double Gas::GaugePressure(double change) const {
  if (linear_) return gauge_ + PressureDerivative(change) * change;
  // (A + P) (V / V_0)^-gamma - A
  return gauge_ + (ambient_ + gauge_) * std::expm1(-gamma_ * std::log1p(change / rest_volume_));
}

double Gas::PressureDerivative(double change) const {
  if (linear_) return -gamma_ * (ambient_ + gauge_) / rest_volume_;
  return -gamma_ * (ambient_ + GaugePressure(change)) / (rest_volume_ + change);
}

double Gas::Energy(double change) const {
  if (linear_) return -(gauge_ + 0.5 * PressureDerivative(change) * change) * change;
  const double logarithm = std::log1p(change / rest_volume_);
  const double work =
      gamma_ == 1.0 ? -logarithm : std::expm1((1.0 - gamma_) * logarithm) / (gamma_ - 1.0);
  return (ambient_ + gauge_) * rest_volume_ * work + ambient_ * change;
}

double Gas::Divergence(double change, double more) const {
  const double stiffness = -PressureDerivative(change);
  if (linear_) return 0.5 * stiffness * more * more;
  const double volume = rest_volume_ + change;
  const double t = more / volume;
  // d^2U/dV^2 = gamma p / V (1 + t)^-(gamma + 1) as a power series, integrated twice.
  constexpr double kSmall = 0.2;
  if (std::abs(t) <= kSmall) {
    double sum = 0.0, term = 1.0;
    for (int n = 0; n < 28; ++n) {
      sum += term / ((n + 1.0) * (n + 2.0));
      term *= -(gamma_ + 1.0 + n) / (n + 1.0) * t;
    }
    return stiffness * more * more * sum;
  }
  const double logarithm = std::log1p(t);
  const double work =
      gamma_ == 1.0 ? -logarithm : std::expm1((1.0 - gamma_) * logarithm) / (gamma_ - 1.0);
  return (ambient_ + GaugePressure(change)) * volume * (work + t);
}

double Gas::DivergenceSlope(double change, double more) const {
  if (linear_) return -PressureDerivative(change) * more;
  const double t = more / (rest_volume_ + change);
  return -(ambient_ + GaugePressure(change)) * std::expm1(-gamma_ * std::log1p(t));
}

}  // namespace darboux
