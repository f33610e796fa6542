#ifndef DARBOUX_SOLVER_ROBUST_STATISTICS_H_
#define DARBOUX_SOLVER_ROBUST_STATISTICS_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace darboux {

// Of a normal distribution: standard deviation over the median of |d|.
inline constexpr double kSigmaOverMedian = 1.482602218505602;
// Outliers are farther than this many standard deviations.
inline constexpr double kRobustSigmas = 3.0;

inline double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

inline double MedianAbsolute(const std::vector<double>& values) {
  std::vector<double> absolute(values.size());
  std::transform(
      values.begin(), values.end(), absolute.begin(), [](double d) { return std::abs(d); });
  return Median(std::move(absolute));
}

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ROBUST_STATISTICS_H_
