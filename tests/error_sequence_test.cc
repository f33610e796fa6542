#include "solver/error_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

namespace darboux {
namespace {

using Eigen::Vector3d;

// Answers 1 + c N^-q along a direction.
Vector3d Answer(double elements, double order, double factor) {
  return (1.0 + factor * std::pow(elements, -order)) * Vector3d(0.6, 0.0, 0.8);
}

class ErrorSequenceTest : public ::testing::TestWithParam<std::tuple<double, double, double>> {};

TEST_P(ErrorSequenceTest, OrderAndErrorOfPowersAreFound) {
  const auto [order, growth, factor] = GetParam();
  ErrorSequence sequence;
  double elements = 100.0;
  for (int k = 0; k < 3; ++k, elements *= growth) {
    sequence.Add(elements, {Answer(elements, order, factor)}, {1.0});
  }
  const double error = std::abs(factor) * std::pow(elements / growth, -order);
  ASSERT_TRUE(sequence.Order().has_value());
  EXPECT_NEAR(*sequence.Order(), order, 1e-6);
  EXPECT_NEAR(*sequence.Estimate(), 1.25 * error, 1e-6 * error);  // with its safety factor
}

INSTANTIATE_TEST_SUITE_P(Powers,
                         ErrorSequenceTest,
                         ::testing::Combine(::testing::Values(0.5, 1.0, 1.7),
                                            ::testing::Values(1.3, 2.0, 4.0),
                                            ::testing::Values(-3.0, 0.5)));

TEST(ErrorSequenceTest, MixedGrowthTellsTheSameOrder) {
  ErrorSequence sequence;
  for (const double elements : {64.0, 128.0, 400.0}) {
    sequence.Add(elements, {Answer(elements, 1.3, 2.0)}, {1.0});
  }
  EXPECT_NEAR(*sequence.Order(), 1.3, 1e-6);
}

TEST(ErrorSequenceTest, FirstAnswerHasNoEstimateAndTheSecondAnAssumedOrder) {
  ErrorSequence sequence;
  sequence.Add(64.0, {Vector3d(1.0, 0.0, 0.0)}, {1.0});
  EXPECT_FALSE(sequence.Estimate().has_value());
  sequence.Add(256.0, {Vector3d(1.07, 0.0, 0.0)}, {2.0});
  EXPECT_FALSE(sequence.Order().has_value());
  EXPECT_NEAR(*sequence.Estimate(), 0.07 / (2.0 * (8.0 - 1.0)), 1e-15);
}

TEST(ErrorSequenceTest, WorstQuantityDecides) {
  ErrorSequence sequence;
  for (const double elements : {64.0, 256.0}) {
    sequence.Add(elements, {Answer(elements, 1.0, 1.0), Answer(elements, 1.0, 5.0)}, {1.0, 1.0});
  }
  ErrorSequence worst;
  for (const double elements : {64.0, 256.0}) {
    worst.Add(elements, {Answer(elements, 1.0, 5.0)}, {1.0});
  }
  EXPECT_EQ(*sequence.Estimate(), *worst.Estimate());
}

TEST(ErrorSequenceTest, AnswerThatMeetsItsPredecessorByChanceIsNotExact) {
  ErrorSequence sequence;
  sequence.Add(64.0, {Vector3d(1.0, 0.0, 0.0)}, {1.0});
  sequence.Add(128.0, {Vector3d(1.1, 0.0, 0.0)}, {1.0});
  sequence.Add(256.0, {Vector3d(1.1, 0.0, 0.0)}, {1.0});
  // |Q_1 - Q_0| / (2^2 - 1) / 2^2
  EXPECT_NEAR(*sequence.Estimate(), 0.1 / 3.0 / 4.0, 1e-12);
}

TEST(ErrorSequenceTest, WhatNeverMovesHasNoError) {
  ErrorSequence sequence;
  for (const double elements : {64.0, 128.0, 256.0}) {
    sequence.Add(elements, {Vector3d::Zero()}, {0.0});
  }
  EXPECT_EQ(*sequence.Estimate(), 0.0);
}

TEST(ErrorSequenceTest, OrdersStayWithinWhatTheoryAllows) {
  ErrorSequence fast, slow;
  for (int k = 0; k < 3; ++k) {
    const double elements = 100.0 * std::pow(2.0, k);
    fast.Add(elements, {Answer(elements, 6.0, 1e9)}, {1.0});
    slow.Add(elements, {Vector3d(k, 0.0, 0.0)}, {1.0});
  }
  EXPECT_EQ(*fast.Order(), 2.0);
  EXPECT_EQ(*slow.Order(), 0.25);
}

}  // namespace
}  // namespace darboux
