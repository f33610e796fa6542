#include "solver/posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace darboux {
namespace {

// y = a + b x, a of interest: the textbook's variance of an intercept.
TEST(PosteriorTest, OfAnInterceptIsTheTextbooks) {
  const std::vector<double> x = {1.0, 2.0, 4.0, 5.0, 8.0};
  Posterior posterior(2, {0});
  posterior.SetFree({1});
  double sum = 0.0, squares = 0.0;
  const double error = 0.3;
  for (const double at : x) {
    posterior.Add(Eigen::Vector2d(1.0, at) / error, 0.0);
    sum += at;
    squares += at * at;
  }
  const double n = x.size();
  const double variance = error * error * squares / (n * squares - sum * sum);
  const auto spread = posterior.Find(Eigen::VectorXd::Ones(1));
  EXPECT_NEAR(spread.deviations[0], std::sqrt(variance), 1e-12);
  // With the slope known, that of a mean.
  posterior.SetFree({});
  EXPECT_NEAR(posterior.Find(Eigen::VectorXd::Ones(1)).deviations[0], error / std::sqrt(n), 1e-12);
}

TEST(PosteriorTest, WhatOnlyASumIsKnownOfHasNoDeviation) {
  Posterior posterior(2, {0, 1});
  posterior.SetFree({});
  posterior.Add(Eigen::Vector2d(2.0, 3.0), 0.0);
  auto spread = posterior.Find(Eigen::VectorXd::Ones(2));
  EXPECT_TRUE(std::isinf(spread.deviations[0]));
  EXPECT_TRUE(std::isinf(spread.deviations[1]));
  EXPECT_EQ(spread.correlation.size(), 0);
  EXPECT_LT(spread.weakest[0] * spread.weakest[1], 0.0);  // More of one, less of the other.
  EXPECT_NEAR(std::abs(spread.weakest[0] / spread.weakest[1]), 1.5, 1e-12);
  // A second, independent measurement tells them apart.
  posterior.Add(Eigen::Vector2d(1.0, -1.0), 0.0);
  spread = posterior.Find(Eigen::VectorXd::Ones(2));
  const Eigen::Matrix2d covariance =
      (Eigen::Matrix2d() << 2.0, 3.0, 1.0, -1.0).finished().inverse() *
      (Eigen::Matrix2d() << 2.0, 3.0, 1.0, -1.0).finished().inverse().transpose();
  EXPECT_NEAR(spread.deviations[0], std::sqrt(covariance(0, 0)), 1e-12);
  EXPECT_NEAR(spread.correlation(0, 1),
              covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)),
              1e-12);
}

TEST(PosteriorTest, ANuisanceThatNothingDeterminesDoesNoHarm) {
  Posterior posterior(3, {0});
  posterior.SetFree({1, 2});  // 2 appears nowhere
  posterior.Add(Eigen::Vector3d(1.0, 1.0, 0.0), 0.0);
  posterior.Add(Eigen::Vector3d(1.0, -1.0, 0.0), 0.0);
  EXPECT_NEAR(posterior.Find(Eigen::VectorXd::Ones(1)).deviations[0], std::sqrt(0.5), 1e-12);
}

// The same problem in other units of a nuisance and of the parameter.
TEST(PosteriorTest, DoesNotDependOnUnits) {
  const auto deviation = [](double unit, double nuisance_unit) {
    Posterior posterior(2, {0});
    posterior.SetFree({1});
    for (int k = 0; k < 6; ++k) {
      posterior.Add(Eigen::Vector2d(std::cos(k) * unit, k * nuisance_unit), 0.0);
    }
    return posterior.Find(Eigen::VectorXd::Constant(1, 1.0 / unit)).deviations[0] * unit;
  };
  const double one = deviation(1.0, 1.0);
  EXPECT_NEAR(deviation(1e6, 1e-9), one, 1e-10 * one);
  EXPECT_NEAR(deviation(1e-6, 1e9), one, 1e-10 * one);
}

// The estimate follows a constant that was taken to be known as least squares has it.
TEST(PosteriorTest, AChangeOfAConstantMovesTheEstimate) {
  // r_k = a + c x_k - y_k with c a constant: da/dc = -mean of x.
  Posterior posterior(2, {0});
  posterior.SetFree({});
  double sum = 0.0;
  for (const double x : {1.0, 2.0, 6.0}) {
    posterior.Add(Eigen::Vector2d(1.0, x), 0.0);
    sum += x;
  }
  EXPECT_NEAR(posterior.ChangeBy(posterior.information().col(1))[0], -sum / 3.0, 1e-12);
}

}  // namespace
}  // namespace darboux
