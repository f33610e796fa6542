#include "solver/error_sequence.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace darboux {
namespace {

constexpr double kWorstOrder = 0.25, kBestOrder = 2.0, kAssumedOrder = 1.5;
// Where the order is that of the answers themselves, as usual for a grid convergence index.
constexpr double kSafety = 1.25;

// q of the changes `first` and `second` where the numbers of elements grow by the factors a and b.
double OrderOf(double first, double second, double a, double b) {
  // (1 - a^-q) / (a^-q (1 - b^-q)) rises with q.
  const auto ratio = [&](double q) { return (std::pow(a, q) - 1.0) / (1.0 - std::pow(b, -q)); };
  double low = kWorstOrder, high = kBestOrder;
  if (first <= ratio(low) * second) return low;
  if (first >= ratio(high) * second) return high;
  constexpr int kHalvings = 50;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) * second < first ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

void ErrorSequence::Add(double elements,
                        const std::vector<Eigen::Vector3d>& values,
                        const std::vector<double>& sizes) {
  CHECK_EQ(values.size(), sizes.size());
  Level level{elements, values, sizes, {}, {}, 0.0};
  if (!levels_.empty()) {
    const Level& last = levels_.back();
    CHECK_EQ(values.size(), last.values.size());
    CHECK_GT(elements, last.elements);
    const double growth = elements / last.elements;
    double largest = -1.0;
    for (size_t i = 0; i < values.size(); ++i) {
      const double change = (values[i] - last.values[i]).norm();
      double order = kAssumedOrder;
      if (levels_.size() >= 2 && change > 0.0) {
        const Level& first = levels_[levels_.size() - 2];
        order = OrderOf((last.values[i] - first.values[i]).norm(),
                        change,
                        last.elements / first.elements,
                        growth);
      }
      double error = 0.0;
      if (change > 0.0) error = change / ((std::pow(growth, order) - 1.0) * sizes[i]);
      if (levels_.size() >= 2) error *= kSafety;
      const double best = std::pow(growth, kBestOrder);
      if (!last.least.empty()) error = std::max(error, last.least[i] / best);
      level.errors.push_back(error);
      level.least.push_back(change > 0.0 ? change / ((best - 1.0) * sizes[i]) : 0.0);
      if (error > largest) {
        largest = error;
        level.order = order;
      }
    }
  }
  levels_.push_back(std::move(level));
}

std::optional<double> ErrorSequence::Estimate() const {
  if (levels_.size() < 2) return std::nullopt;
  const std::vector<double>& errors = levels_.back().errors;
  return *std::max_element(errors.begin(), errors.end());
}

std::optional<double> ErrorSequence::Order() const {
  if (levels_.size() < 3) return std::nullopt;
  return levels_.back().order;
}

}  // namespace darboux
