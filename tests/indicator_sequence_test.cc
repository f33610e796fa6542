#include "solver/indicator_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

namespace darboux {
namespace {

using Eigen::Vector3d;

Vector3d Answer(double error) { return (1.0 + error) * Vector3d(0.6, 0.0, 0.8); }

class IndicatorSequenceTest : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(IndicatorSequenceTest, ErrorsInProportionToIndicatorsAreFoundHoweverSmallTheSteps) {
  const auto [factor, fall] = GetParam();
  IndicatorSequence sequence;
  double indicator = 0.3;
  for (int k = 0; k < 4; ++k, indicator *= 1.0 - fall) {
    sequence.Add(indicator, {Answer(factor * indicator)}, {1.0});
    if (k == 0) {
      EXPECT_FALSE(sequence.Estimate().has_value());
    } else {
      EXPECT_NEAR(*sequence.Estimate(), std::abs(factor) * indicator, 1e-12);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Factors,
                         IndicatorSequenceTest,
                         ::testing::Combine(::testing::Values(-0.5, 0.1, 1.0),
                                            ::testing::Values(0.2, 0.5, 0.95)));

TEST(IndicatorSequenceTest, TheWorstQuantityRelativeToItsSizeDecides) {
  IndicatorSequence sequence;
  sequence.Add(1.0, {Vector3d(1.0, 0.0, 0.0), Vector3d(50.0, 0.0, 0.0)}, {1.0, 40.0});
  sequence.Add(0.5, {Vector3d(1.1, 0.0, 0.0), Vector3d(52.0, 0.0, 0.0)}, {1.0, 40.0});
  EXPECT_NEAR(*sequence.Estimate(), 0.1, 1e-12);
}

TEST(IndicatorSequenceTest, AnAnswerThatMeetsItsPredecessorByChanceIsNotExact) {
  IndicatorSequence sequence;
  sequence.Add(0.4, {Answer(0.4)}, {1.0});
  sequence.Add(0.2, {Answer(0.2)}, {1.0});
  sequence.Add(0.1, {Answer(0.2)}, {1.0});
  EXPECT_NEAR(*sequence.Estimate(), 0.05, 1e-12);
}

TEST(IndicatorSequenceTest, WhereTheIndicatorHardlyFallsTheErrorIsFourTimesTheChange) {
  for (const double next : {0.39, 0.4, 0.5}) {
    IndicatorSequence sequence;
    sequence.Add(0.4, {Answer(0.01)}, {1.0});
    sequence.Add(next, {Answer(0.0)}, {1.0});
    EXPECT_GT(*sequence.Estimate(), 0.01 * 3.8) << next;
    EXPECT_LT(*sequence.Estimate(), 0.01 * 8.0) << next;
  }
}

TEST(IndicatorSequenceTest, ReplacedAnswersAreWhatTheNextOnesAreComparedWith) {
  IndicatorSequence sequence;
  sequence.Add(0.4, {Answer(0.4)}, {1.0});
  sequence.Add(0.2, {Answer(0.2)}, {1.0});
  sequence.ReplaceLast({Answer(0.3)});
  EXPECT_NEAR(*sequence.Estimate(), 0.2, 1e-12);  // as before
  sequence.Add(0.1, {Answer(0.2)}, {1.0});
  EXPECT_NEAR(*sequence.Estimate(), 0.1, 1e-12);
}

TEST(IndicatorSequenceTest, WithoutIndicatorsThereIsNoError) {
  IndicatorSequence sequence;
  EXPECT_FALSE(sequence.Estimate().has_value());
  sequence.Add(0.0, {Vector3d::Zero()}, {1.0});
  EXPECT_EQ(*sequence.Estimate(), 0.0);
}

}  // namespace
}  // namespace darboux
