#include "geometry/implicit_function.h"

#include <cmath>

#include "geometry/taylor.h"

namespace darboux {

// Taylor polynomials have two variables; the coordinates take turns.

double ImplicitFunction::Value(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const {
  const Taylor3 along_xy[3] = {Taylor3::U(p.x()), Taylor3::V(p.y()), Taylor3(p.z())};
  const Taylor3 along_z[3] = {Taylor3(p.x()), Taylor3(p.y()), Taylor3::U(p.z())};
  const Taylor3 xy = expression_.Evaluate(along_xy);
  const Taylor3 z = expression_.Evaluate(along_z);
  *gradient << xy.Derivative(1, 0), xy.Derivative(0, 1), z.Derivative(1, 0);
  return xy.value();
}

double ImplicitFunction::Value(const Eigen::Vector3d& p,
                               Eigen::Vector3d* gradient,
                               Eigen::Matrix3d* second_derivatives) const {
  double value = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    Taylor3 x[3] = {Taylor3(p.x()), Taylor3(p.y()), Taylor3(p.z())};
    x[i] = Taylor3::U(p[i]);
    x[j] = Taylor3::V(p[j]);
    const Taylor3 f = expression_.Evaluate(x);
    value = f.value();
    (*gradient)[i] = f.Derivative(1, 0);
    (*second_derivatives)(i, i) = f.Derivative(2, 0);
    (*second_derivatives)(i, j) = (*second_derivatives)(j, i) = f.Derivative(1, 1);
  }
  return value;
}

ImplicitFunction::Projection ImplicitFunction::Project(double size,
                                                       double reach,
                                                       const Eigen::Vector3d& is_free,
                                                       Eigen::Vector3d* p,
                                                       Eigen::Vector3d* gradient) const {
  constexpr int kMaxIterations = 60;
  constexpr int kMaxHalvings = 12;
  constexpr double kRounding = 1e-15;
  constexpr double kSettled = 1e-9;
  Eigen::Vector3d q = *p;
  double last_length = reach;
  double f = Value(q, gradient);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (!std::isfinite(f) || !gradient->allFinite()) return Projection::kNotFinite;
    const Eigen::Vector3d g = gradient->cwiseProduct(is_free);
    // Scaled, since the square of a small gradient may underflow.
    const double scale = g.lpNorm<Eigen::Infinity>();
    if (scale == 0.0) return Projection::kNoGradient;
    const Eigen::Vector3d direction = g / scale;
    Eigen::Vector3d step = -(f / scale) / direction.squaredNorm() * direction;
    double length = step.norm();
    if (!std::isfinite(length)) return Projection::kTooFar;
    if (length <= kSettled * size && (length <= kRounding * size || length > 0.5 * last_length)) {
      if (length < last_length) {
        q += step;
        Value(q, gradient);
      }
      *p = q;
      return Projection::kOnSurface;
    }
    if (length > 0.5 * reach) {
      step *= 0.5 * reach / length;
      length = 0.5 * reach;
    }
    double f_new = Value(q + step, gradient);
    for (int i = 0; i < kMaxHalvings && !(std::abs(f_new) < std::abs(f)); ++i) {
      if (length <= kSettled * size) break;
      step *= 0.5;
      length *= 0.5;
      f_new = Value(q + step, gradient);
    }
    q += step;
    if ((q - *p).norm() > reach) return Projection::kTooFar;
    f = f_new;
    last_length = length;
  }
  return Projection::kTooFar;
}

}  // namespace darboux
