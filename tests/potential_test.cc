#include "costs/potential.h"

#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// U = exp(a.x) - offset + (b.y)^2 / 2 of x (3) and y (2): neither a square nor positive. Undefined
// where y_0 > 10.
class Sample : public Potential {
 public:
  Sample(double offset, double s) : Potential(s), offset_(offset) {
    *mutable_parameter_block_sizes() = {3, 2};
  }

 protected:
  bool EvaluateEnergy(double const* const* parameters,
                      double* energy,
                      double** gradients) const override {
    const Eigen::Map<const Vector3d> x(parameters[0]);
    const Eigen::Map<const Vector2d> y(parameters[1]);
    if (y[0] > 10.0) return false;
    const Vector3d a(0.3, -1.0, 0.5);
    const Vector2d b(2.0, -3.0);
    *energy = std::exp(a.dot(x)) - offset_ + 0.5 * b.dot(y) * b.dot(y);
    if (gradients == nullptr) return true;
    if (gradients[0] != nullptr) {
      Eigen::Map<Vector3d>{gradients[0]} = std::exp(a.dot(x)) * a;
    }
    if (gradients[1] != nullptr) {
      Eigen::Map<Vector2d>{gradients[1]} = b.dot(y) * b;
    }
    return true;
  }

 private:
  double offset_;
};

double SampleEnergy(const VectorXd& x, double offset) {
  const double by = 2.0 * x[3] - 3.0 * x[4];
  return std::exp(0.3 * x[0] - x[1] + 0.5 * x[2]) - offset + 0.5 * by * by;
}

VectorXd SampleGradient(const VectorXd& x) {
  const double growth = std::exp(0.3 * x[0] - x[1] + 0.5 * x[2]);
  const double by = 2.0 * x[3] - 3.0 * x[4];
  VectorXd gradient(5);
  gradient << 0.3 * growth, -growth, 0.5 * growth, 2.0 * by, -3.0 * by;
  return gradient;
}

class PotentialTest : public ::testing::TestWithParam<double> {};  // s

TEST_P(PotentialTest, CostAndGradientAreExact) {
  for (const double size : {0.0, 1e-8, 1.0, 5.0}) {
    const VectorXd x = SeededUniform(5, size);
    const Sample potential(7.0, GetParam());
    const Evaluation e = EvaluateAt(potential, x);
    ASSERT_TRUE(e.ok);
    EXPECT_DOUBLE_EQ(e.residuals[0], SampleEnergy(x, 7.0));
    EXPECT_LT((e.jacobian.transpose() - SampleGradient(x)).norm(),
              4e-16 * SampleGradient(x).norm());
  }
}

TEST_P(PotentialTest, GradientIsThatOfTheCost) {
  const auto potential = std::make_unique<Sample>(7.0, GetParam());
  for (const double size : {0.0, 1e-8, 1e-2, 1.0}) {
    EXPECT_THAT(potential, HasCorrectJacobianAt(SeededUniform(5, size), 1e-8));
  }
}

// All the curvature that the solver sees is g g^T / s^2.
TEST_P(PotentialTest, CurvatureFallsWithS) {
  VectorXd x = SeededUniform(5, 1.0);
  ceres::Problem problem;
  Potential::AddTo(&problem, new Sample(0.0, GetParam()), {x.data(), x.data() + 3});
  ceres::CRSMatrix jacobian;
  ASSERT_TRUE(problem.Evaluate({}, nullptr, nullptr, nullptr, &jacobian));
  ASSERT_EQ(jacobian.num_rows, 1);
  double squared = 0.0;
  for (const double value : jacobian.values) squared += value * value;
  EXPECT_NEAR(squared * GetParam() * GetParam() / SampleGradient(x).squaredNorm(), 1.0, 1e-14);
}

TEST_P(PotentialTest, BlocksKeepTheirEnergiesApart) {
  const int kBlocks = 50;
  std::vector<VectorXd> x;
  ceres::Problem problem;
  double expected = 0.0;
  for (int i = 0; i < kBlocks; ++i) x.push_back(SeededUniform(5, 1.0, 100 + i));
  for (int i = 0; i < kBlocks; ++i) {
    Potential::AddTo(&problem, new Sample(i, GetParam()), {x[i].data(), x[i].data() + 3});
    expected += SampleEnergy(x[i], i);
  }
  for (const int threads : {1, 4}) {
    ceres::Problem::EvaluateOptions options;
    options.num_threads = threads;
    for (int repetition = 0; repetition < 20; ++repetition) {
      double cost = 0.0;
      std::vector<double> gradient;
      ASSERT_TRUE(problem.Evaluate(options, &cost, nullptr, &gradient, nullptr));
      EXPECT_NEAR(cost, expected, 1e-13 * std::abs(expected));
      for (int i = 0; i < kBlocks; ++i) {
        const Eigen::Map<const VectorXd> part(gradient.data() + 5 * i, 5);
        EXPECT_LT((part - SampleGradient(x[i])).norm(), 4e-16 * SampleGradient(x[i]).norm());
      }
    }
  }
}

TEST_P(PotentialTest, ConstantBlocksAreSkipped) {
  VectorXd x = SeededUniform(5, 1.0);
  ceres::Problem problem;
  Potential::AddTo(&problem, new Sample(7.0, GetParam()), {x.data(), x.data() + 3});
  problem.SetParameterBlockConstant(x.data());
  double cost = 0.0;
  std::vector<double> gradient;
  ASSERT_TRUE(problem.Evaluate({}, &cost, nullptr, &gradient, nullptr));
  EXPECT_DOUBLE_EQ(cost, SampleEnergy(x, 7.0));
  ASSERT_EQ(gradient.size(), 5u);
  EXPECT_EQ(gradient[0], 0.0);
  EXPECT_NEAR(gradient[4], SampleGradient(x)[4], 1e-15 * SampleGradient(x).norm());
}

TEST_P(PotentialTest, UndefinedEnergyIsReported) {
  VectorXd x = VectorXd::Zero(5);
  x[3] = 11.0;
  EXPECT_FALSE(EvaluateAt(Sample(0.0, GetParam()), x).ok);
}

INSTANTIATE_TEST_SUITE_P(S, PotentialTest, ::testing::Values(1.0, 1e2, 1e4, 1e6, 1e8));

// |z|^2 / 2
class Spring : public ceres::CostFunction {
 public:
  explicit Spring(int size) {
    set_num_residuals(size);
    mutable_parameter_block_sizes()->push_back(size);
  }
  bool Evaluate(double const* const* z, double* r, double** jacobians) const override {
    const int n = num_residuals();
    for (int i = 0; i < n; ++i) r[i] = z[0][i];
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::MatrixXd>(jacobians[0], n, n).setIdentity();
    }
    return true;
  }
};

// Sample and springs: at the minimum y = 0 and x = c a with c = -exp(c |a|^2).
TEST(PotentialMinimumTest, DoesNotDependOnS) {
  const Vector3d a(0.3, -1.0, 0.5);
  double c = 0.0;
  for (int i = 0; i < 200; ++i) c += 0.3 * (-std::exp(c * a.squaredNorm()) - c);
  for (const double s : {1e1, 1e4, 1e8}) {
    VectorXd x = VectorXd::Constant(5, 0.5);
    ceres::Problem problem;
    Potential::AddTo(&problem, new Sample(1e3, s), {x.data(), x.data() + 3});
    problem.AddResidualBlock(new Spring(3), nullptr, x.data());
    problem.AddResidualBlock(new Spring(2), nullptr, x.data() + 3);
    ceres::Solver::Options options;
    options.function_tolerance = options.parameter_tolerance = 0.0;
    options.gradient_tolerance = 1e-12;
    options.max_num_iterations = 500;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    // Descent ends where steps no longer lower the cost, whose offset is 1e3: sqrt(epsilon 1e3).
    EXPECT_LT((x.head<3>() - c * a).norm(), 1e-5) << summary.FullReport();
    EXPECT_LT(x.tail<2>().norm(), 1e-5);
    const double minimum = std::exp(c * a.squaredNorm()) - 1e3 + 0.5 * c * c * a.squaredNorm();
    EXPECT_NEAR(summary.final_cost, minimum, 1e-9);
  }
}

}  // namespace
}  // namespace darboux
