#include "solver/indicator_sequence.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace darboux {
namespace {

constexpr double kLeastFall = 0.2;  // of the indicator
constexpr double kByChance = 0.5;
constexpr double kMostFactor = 1.0;

}  // namespace

void IndicatorSequence::Add(double indicator,
                            const std::vector<Eigen::Vector3d>& values,
                            const std::vector<double>& sizes) {
  CHECK_EQ(values.size(), sizes.size());
  CHECK_GE(indicator, 0.0);
  Level level{indicator, values, {}};
  if (!levels_.empty()) {
    const Level& last = levels_.back();
    CHECK_EQ(values.size(), last.values.size());
    const double fall = std::max(last.indicator - indicator, kLeastFall * last.indicator);
    for (size_t i = 0; i < values.size(); ++i) {
      const double change = (values[i] - last.values[i]).norm();
      double factor = change > 0.0 && fall > 0.0 ? change / (sizes[i] * fall) : 0.0;
      if (!last.factors.empty()) factor = std::max(factor, kByChance * last.factors[i]);
      level.factors.push_back(std::min(factor, kMostFactor));
    }
  }
  levels_.push_back(std::move(level));
}

void IndicatorSequence::ReplaceLast(const std::vector<Eigen::Vector3d>& values) {
  CHECK(!levels_.empty());
  CHECK_EQ(values.size(), levels_.back().values.size());
  levels_.back().values = values;
}

std::optional<double> IndicatorSequence::Estimate() const {
  if (levels_.empty()) return std::nullopt;
  const Level& last = levels_.back();
  if (last.indicator == 0.0) return 0.0;
  if (last.factors.empty()) return std::nullopt;
  return last.indicator * *std::max_element(last.factors.begin(), last.factors.end());
}

}  // namespace darboux
