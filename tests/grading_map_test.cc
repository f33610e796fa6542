#include "geometry/grading_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace darboux {
namespace {

struct Sample {
  std::vector<double> log_sizes;
  bool periodic;
};

std::vector<Sample> Samples() {
  std::mt19937 generator(9173);
  std::uniform_real_distribution<double> value(-2.0, 2.0);
  std::vector<Sample> samples = {{{0.0, 0.0, 0.0}, false},
                                 {{3.0, 2.0, 1.0, 0.0, -1.0}, false},
                                 {{0.0, -0.1, -0.3, -0.9, -2.0, -4.0, -6.0}, false},
                                 {{1.0, 0.0, -2.0, 0.0, 1.0}, true}};
  for (const int size : {3, 5, 9}) {
    for (const bool periodic : {false, true}) {
      std::vector<double> random(size);
      std::generate(random.begin(), random.end(), [&] { return value(generator); });
      samples.push_back({random, periodic});
    }
  }
  return samples;
}

class GradingMapTest : public ::testing::TestWithParam<Sample> {
 protected:
  const GradingMap map_{GetParam().log_sizes, GetParam().periodic};
};

TEST_P(GradingMapTest, MapsTheUnitIntervalOntoItselfMonotonically) {
  EXPECT_EQ(map_.Evaluate(0.0)[0], 0.0);
  EXPECT_NEAR(map_.Evaluate(1.0)[0], 1.0, 1e-15);
  double last = 0.0;
  for (int k = 1; k <= 200; ++k) {
    const auto x = map_.Evaluate(k / 200.0);
    EXPECT_GT(x[0], last);
    EXPECT_GT(x[1], 0.0);
    last = x[0];
  }
}

TEST_P(GradingMapTest, DerivativesAreThoseOfDifferences) {
  // Away from the knots, where the third derivative has kinks.
  const int knots = static_cast<int>(GetParam().log_sizes.size()) - 1;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < knots; ++k) {
    for (const double t : {0.2, 0.5, 0.9}) {
      const double f = (k + t) / knots;
      const auto at = map_.Evaluate(f);
      const auto up = map_.Evaluate(f + kStep), down = map_.Evaluate(f - kStep);
      for (int i = 0; i < 3; ++i) {
        const double difference = (up[i] - down[i]) / (2.0 * kStep);
        EXPECT_NEAR(at[i + 1], difference, 1e-6 * (std::abs(at[i + 1]) + at[1] * knots * knots));
      }
    }
  }
}

TEST_P(GradingMapTest, ThirdDerivativeIsContinuousAcrossKnots) {
  const int knots = static_cast<int>(GetParam().log_sizes.size()) - 1;
  for (int k = 1; k < knots; ++k) {
    const double f = static_cast<double>(k) / knots;
    const auto left = map_.Evaluate(f - 1e-9), right = map_.Evaluate(f + 1e-9);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(left[i], right[i], 1e-5 * (left[1] + std::abs(left[i]))) << i;
    }
  }
}

TEST_P(GradingMapTest, InverseUndoesTheMap) {
  for (int k = 0; k <= 50; ++k) {
    const double f = k / 50.0;
    EXPECT_NEAR(map_.Inverse(map_.Evaluate(f)[0]), f, 1e-13);
  }
}

TEST_P(GradingMapTest, SizesAreThoseAskedFor) {
  const std::vector<double>& s = GetParam().log_sizes;
  const int knots = static_cast<int>(s.size()) - 1;
  for (int k = 0; k < knots; ++k) {
    const double f = static_cast<double>(k) / knots;
    EXPECT_NEAR(std::log(map_.Size(f) / map_.Size(0.0)), s[k] - s[0], 1e-12);
  }
}

TEST_P(GradingMapTest, PeriodicMapsCloseSmoothly) {
  if (!GetParam().periodic) return;
  const auto begin = map_.Evaluate(0.0), end = map_.Evaluate(1.0);
  for (int i = 1; i < 4; ++i) {
    EXPECT_NEAR(begin[i], end[i], 1e-11 * (begin[1] + std::abs(begin[i])));
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, GradingMapTest, ::testing::ValuesIn(Samples()));

TEST(GradingMapTest, StraightLogarithmIsGeometric) {
  // Sizes fall from one end to the other by the factor e^-s: x = (1 - e^(-s f)) / (1 - e^-s).
  const double s = 3.0;
  const GradingMap map({s, 0.75 * s, 0.5 * s, 0.25 * s, 0.0}, false);
  for (const double f : {0.1, 0.37, 0.5, 0.93}) {
    EXPECT_NEAR(map.Evaluate(f)[0], (1.0 - std::exp(-s * f)) / (1.0 - std::exp(-s)), 1e-14);
  }
}

TEST(GradingMapTest, ConstantAddedToLogarithmsChangesNothing) {
  const GradingMap a({0.0, 1.0, -1.0, 0.5}, false), b({700.0, 701.0, 699.0, 700.5}, false);
  EXPECT_NEAR(a.Evaluate(0.4)[0], b.Evaluate(0.4)[0], 1e-13);
}

TEST(GradingMapTest, DefaultIsTheIdentity) {
  const GradingMap map;
  EXPECT_TRUE(map.is_identity());
  EXPECT_EQ(map.Evaluate(0.3)[0], 0.3);
  EXPECT_EQ(map.Inverse(0.3), 0.3);
}

}  // namespace
}  // namespace darboux
