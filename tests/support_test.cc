#include "costs/support.h"

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

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Support::Condition MakeCondition(const Matrix3Xd& coefficients,
                                 double stiffness,
                                 const double* target = nullptr) {
  Support::Condition condition;
  condition.coefficients = coefficients;
  condition.stiffness = stiffness;
  condition.target = target;
  return condition;
}

// A displacement component and a slope of a limit point.
class SupportTest : public ::testing::TestWithParam<double> {  // size of u, m
 protected:
  const LoopPatch patch_ = MakeLoopPatch(TorusPatch());
  const StrainPoint point_ = (*patch_.Points(0))[1];
  const Vector3d direction_ = Vector3d(2.0, -1.0, 2.0) / 3.0;
  const Matrix3Xd displacement_ = direction_ * point_.weights.row(kRowValue);
  const Matrix3Xd slope_ = point_.n * point_.weights.row(kRowD1);
  const double target_ = 0.3, k_ = 2e4;
  const std::unique_ptr<Support> support_ =
      std::make_unique<Support>(std::vector<Support::Condition>{
          MakeCondition(displacement_, k_, &target_), MakeCondition(slope_, 5.0)});
};

TEST_P(SupportTest, StoresTheSpringsEnergy) {
  const VectorXd x = SeededUniform(36, GetParam());
  double displacement = 0.0, slope = 0.0;
  for (int i = 0; i < 12; ++i) {
    displacement += point_.weights(kRowValue, i) * direction_.dot(x.segment<3>(3 * i));
    slope += point_.weights(kRowD1, i) * point_.n.dot(x.segment<3>(3 * i));
  }
  const double expected =
      0.5 * k_ * std::pow(displacement - target_, 2) + 0.5 * 5.0 * slope * slope;
  EXPECT_NEAR(Energy(*support_, x), expected, 1e-14 * expected);
}

TEST_P(SupportTest, GradientIsMinusTheReaction) {
  const VectorXd x = SeededUniform(36, GetParam());
  double displacement = -target_, slope = 0.0;
  for (int i = 0; i < 12; ++i) {
    displacement += displacement_.col(i).dot(x.segment<3>(3 * i));
    slope += slope_.col(i).dot(x.segment<3>(3 * i));
  }
  const VectorXd gradient = Gradient(*support_, x);
  for (int i = 0; i < 12; ++i) {
    const Vector3d expected =
        k_ * displacement * displacement_.col(i) + 5.0 * slope * slope_.col(i);
    EXPECT_LT((gradient.segment<3>(3 * i) - expected).norm(), 1e-13 * gradient.norm());
  }
}

TEST_P(SupportTest, JacobianMatchesRiddersDifferences) {
  EXPECT_THAT(support_, HasCorrectJacobianAt(SeededUniform(36, GetParam()), 1e-9));
}

INSTANTIATE_TEST_SUITE_P(DisplacementM, SupportTest, ::testing::Values(0, 1e-8, 1e-2, 1, 1e2));

// The weights add up to 1 and to 0: a translation moves a point by itself and turns nothing.
TEST_P(SupportTest, TranslationMovesTheDisplacementOnly) {
  const Vector3d shift = SeededUniform(3, 1.0 + GetParam());
  const Evaluation e =
      EvaluateAt(*support_, patch_.Parameters(0, patch_.Affine(Matrix3d::Zero(), shift)));
  EXPECT_NEAR(
      e.residuals[0], std::sqrt(k_) * (direction_.dot(shift) - target_), 1e-12 * shift.norm());
  EXPECT_NEAR(e.residuals[1], 0.0, 1e-13 * shift.norm());
}

TEST(SupportConditionTest, NoTargetIsZero) {
  const Support support({MakeCondition(Vector3d(0.0, 1.0, 0.0), 4.0)});
  EXPECT_EQ(Energy(support, Vector3d::Zero()), 0.0);
  EXPECT_EQ(Energy(support, Vector3d(5.0, 3.0, 7.0)), 18.0);
}

TEST(SupportConditionTest, ReadsTheTargetAtEveryEvaluation) {
  double target = 0.0;
  const Support support({MakeCondition(Vector3d(0.0, 1.0, 0.0), 4.0, &target)});
  const Vector3d u(1.0, 3.0, 2.0);
  EXPECT_EQ(Energy(support, u), 18.0);
  target = 3.0;
  EXPECT_EQ(Energy(support, u), 0.0);
  EXPECT_EQ(Gradient(support, u).norm(), 0.0);
}

TEST(SupportConditionTest, SkipsTheJacobiansThatNobodyAsksFor) {
  Matrix3Xd a(3, 2);
  a << 1, 4, 2, 5, 3, 6;
  const Support support({MakeCondition(a, 4.0), MakeCondition(-a, 9.0)});
  const double u[6] = {1, 1, 1, 0, 0, 0};
  const double* parameters[2] = {u, u + 3};
  double residuals[2], jacobian[6];
  double* jacobians[2] = {nullptr, jacobian};
  ASSERT_TRUE(support.Evaluate(parameters, residuals, jacobians));
  EXPECT_EQ(residuals[0], 12.0);
  EXPECT_EQ(residuals[1], -18.0);
  EXPECT_EQ(std::vector<double>(jacobian, jacobian + 6),
            (std::vector<double>{8, 10, 12, -12, -15, -18}));
}

// Held by a support of stiffness K and pulled back by a spring k: the target is missed by
// k / (k + K), and the reaction is what the spring pulls.
TEST(SupportConditionTest, StiffSupportReachesItsTarget) {
  const Vector3d direction = Vector3d(2.0, -1.0, 2.0) / 3.0;
  double target = 0.0;
  Vector3d u = Vector3d::Zero();
  const double spring = 3.0;
  for (const double stiffness : {1.0, 1e6, 1e12}) {
    ceres::Problem problem;
    problem.AddResidualBlock(
        new Support({MakeCondition(direction, stiffness, &target)}), nullptr, u.data());
    std::vector<Support::Condition> springs;
    for (int i = 0; i < 3; ++i) springs.push_back(MakeCondition(Vector3d::Unit(i), spring));
    problem.AddResidualBlock(new Support(springs), nullptr, u.data());
    ceres::Solver::Options options;
    options.function_tolerance = options.parameter_tolerance = 0.0;
    options.gradient_tolerance = 1e-14;
    options.linear_solver_type = ceres::DENSE_QR;  // Normal equations would lose twice the digits.
    options.max_num_iterations = 30;
    options.initial_trust_region_radius = 1e16;  // Undamped: one step settles springs.
    options.logging_type = ceres::SILENT;
    for (const double prescribed : {0.5, -2.0, 0.0}) {
      target = prescribed;
      ceres::Solver::Summary summary;
      ceres::Solve(options, &problem, &summary);
      const double reached = target * stiffness / (spring + stiffness);
      EXPECT_LT((u - reached * direction).norm(), 1e-10) << summary.FullReport();
      EXPECT_NEAR(-stiffness * (direction.dot(u) - target), spring * reached, 1e-3 * spring);
    }
  }
}

}  // namespace
}  // namespace darboux
