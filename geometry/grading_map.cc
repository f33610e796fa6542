#include "geometry/grading_map.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace darboux {
namespace {

// Gauss-Legendre, eight points on [0, 1]: exact to rounding for exp of a cubic that varies by less
// than three over an interval.
constexpr double kNodes[4] = {
    0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr double kWeights[4] = {
    0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

}  // namespace

GradingMap::GradingMap(const std::vector<double>& log_sizes, bool periodic) : values_(log_sizes) {
  CHECK_GE(values_.size(), 3u);
  // Sizes relative to the largest: exp does not overflow.
  if (periodic) values_.back() = values_.front();
  const double largest = *std::max_element(values_.begin(), values_.end());
  for (double& value : values_) value -= largest;
  const int n = static_cast<int>(values_.size()) - 1;
  const double step = 1.0 / n;

  // Continuity of the first derivative at the knots; dense, there are few.
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n + 1, n + 1);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + 1);
  const auto at = [&](int k) { return periodic ? (k + n) % n : k; };
  for (int k = periodic ? 0 : 1; k < n; ++k) {
    matrix(k, at(k - 1)) += step / 6.0;
    matrix(k, k) += 2.0 * step / 3.0;
    matrix(k, at(k + 1)) += step / 6.0;
    right[k] = (values_[at(k + 1)] - 2.0 * values_[k] + values_[at(k - 1)]) / step;
  }
  matrix(n, n) = 1.0;
  if (periodic) {
    matrix(n, 0) = -1.0;
  } else {
    matrix(0, 0) = 1.0;
  }
  const Eigen::VectorXd solution = matrix.partialPivLu().solve(right);
  curvatures_.assign(solution.data(), solution.data() + solution.size());

  reached_.assign(n + 1, 0.0);
  for (int k = 0; k < n; ++k) reached_[k + 1] = reached_[k] + Integral(k, 1.0);
  scale_ = 1.0 / reached_[n];
  for (double& x : reached_) x *= scale_;
  reached_[n] = 1.0;
}

GradingMap::Spline GradingMap::EvaluateSpline(int k, double t) const {
  const double step = 1.0 / (values_.size() - 1);
  const double a = 1.0 - t, b = t;
  const double m0 = curvatures_[k], m1 = curvatures_[k + 1];
  Spline result;
  result.s = a * values_[k] + b * values_[k + 1] +
             ((a * a * a - a) * m0 + (b * b * b - b) * m1) * step * step / 6.0;
  result.s_1 = (values_[k + 1] - values_[k]) / step +
               ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1) * step / 6.0;
  result.s_2 = a * m0 + b * m1;
  return result;
}

double GradingMap::Integral(int k, double t) const {
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (const double node : {0.5 * (1.0 - kNodes[i]), 0.5 * (1.0 + kNodes[i])}) {
      sum += 0.5 * kWeights[i] * std::exp(EvaluateSpline(k, t * node).s);
    }
  }
  return sum * t / (values_.size() - 1);
}

std::array<double, 4> GradingMap::Evaluate(double f) const {
  if (is_identity()) return {f, 1.0, 0.0, 0.0};
  const int n = static_cast<int>(values_.size()) - 1;
  const int k = std::clamp(static_cast<int>(f * n), 0, n - 1);
  const double t = std::clamp(f * n - k, 0.0, 1.0);
  const Spline s = EvaluateSpline(k, t);
  const double size = scale_ * std::exp(s.s);
  return {
      reached_[k] + scale_ * Integral(k, t), size, size * s.s_1, size * (s.s_2 + s.s_1 * s.s_1)};
}

double GradingMap::Inverse(double x) const {
  if (is_identity()) return x;
  const int n = static_cast<int>(values_.size()) - 1;
  const auto above = std::upper_bound(reached_.begin(), reached_.end(), x);
  const int k = std::clamp(static_cast<int>(above - reached_.begin()) - 1, 0, n - 1);
  // Newton's method between bounds that close in: x rises with f.
  double low = static_cast<double>(k) / n, high = static_cast<double>(k + 1) / n;
  const double width = reached_[k + 1] - reached_[k];
  double f = low + (high - low) * std::clamp((x - reached_[k]) / width, 0.0, 1.0);
  constexpr int kSteps = 60;
  for (int step = 0; step < kSteps; ++step) {
    const auto at = Evaluate(f);
    (at[0] < x ? low : high) = f;
    double next = f + (x - at[0]) / at[1];
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::abs(next - f) < 1e-16) return next;
    f = next;
  }
  return f;
}

}  // namespace darboux
