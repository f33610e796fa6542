#include "costs/follower_force.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "costs/edge_moment.h"
#include "costs/follower_pressure.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

const double kFactor = 0.8;

std::vector<const double*> Blocks(const VectorXd& x) {
  std::vector<const double*> blocks;
  for (int i = 0; i < x.size(); i += 3) blocks.push_back(x.data() + i);
  return blocks;
}

class FollowerForceTest : public ::testing::TestWithParam<double> {  // size of the displacement
 protected:
  // The stiffness against differences of the force.
  static void ExpectConsistent(const FollowerForce& cost, const VectorXd& x) {
    Matrix3Xd force;
    MatrixXd stiffness;
    ASSERT_TRUE(cost.Linearise(Blocks(x).data(), &force, &stiffness));
    MatrixXd expected(x.size(), x.size());
    constexpr double kStep = 1e-4;
    for (int j = 0; j < x.size(); ++j) {
      const auto at = [&](double step) -> VectorXd {
        const VectorXd moved = x + step * VectorXd::Unit(x.size(), j);
        Matrix3Xd result;
        EXPECT_TRUE(cost.Linearise(Blocks(moved).data(), &result, nullptr));
        return Eigen::Map<const VectorXd>(result.data(), result.size());
      };
      expected.col(j) =
          -(8.0 * (at(kStep) - at(-kStep)) - at(2.0 * kStep) + at(-2.0 * kStep)) / (12.0 * kStep);
    }
    EXPECT_LE((stiffness - expected).norm(), 1e-8 * (1.0 + expected.norm()));
  }
};

TEST_P(FollowerForceTest, Pressure) {
  for (const StrainPoint& point : SamplePoints()) {
    const auto points = std::make_shared<const std::vector<StrainPoint>>(1, point);
    const FollowerPressure cost(points, {1.7}, Vector3d(0.1, 0.2, -0.3), &kFactor, 1e6);
    const VectorXd x = SeededUniform(NumParameters(cost), GetParam(), 11);
    Matrix3Xd force;
    ASSERT_TRUE(cost.Linearise(Blocks(x).data(), &force, nullptr));
    EXPECT_EQ(force, cost.ExactForce(Blocks(x).data()));
    ExpectConsistent(cost, x);
  }
}

TEST_P(FollowerForceTest, Moment) {
  for (const StrainPoint& sample : SamplePoints()) {
    StrainPoint point = sample;
    point.area = 0.7;
    // About all three axes at once, an edge at an angle to the frame.
    const EdgeMoment cost(
        point, Eigen::Vector2d(0.6, 0.8), Vector3d(0.3, -1.1, 0.6), &kFactor, 1e6);
    const VectorXd x = SeededUniform(NumParameters(cost), GetParam(), 12);
    Matrix3Xd force;
    MatrixXd stiffness;
    ASSERT_TRUE(cost.Linearise(Blocks(x).data(), &force, &stiffness));
    const VectorXd gradient = Gradient(cost, x);
    EXPECT_LE((Eigen::Map<const VectorXd>(force.data(), force.size()) + gradient).norm(),
              1e-12 * gradient.norm());
    EXPECT_LE((stiffness - stiffness.transpose()).norm(), 1e-12 * (1.0 + stiffness.norm()));
    ExpectConsistent(cost, x);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, FollowerForceTest, ::testing::Values(0.0, 1e-2, 0.2));

// A strip's end wound up: with references taken on the way the work grows turn by turn.
TEST(EdgeMomentWindingTest, WorkGrowsBeyondOneTurn) {
  StrainPoint point = PlanePoint();
  point.area = 2.0;
  const Eigen::Vector2d tangent(0.0, 1.0);  // edge along t2: bending about it turns t1 and n
  EdgeMoment cost(point, tangent, 3.0 * point.t2, &kFactor, 1e6);
  const int n = NumParameters(cost) / 3;
  const auto turned = [&](double angle) {
    // d_1 = R t1 - t1 with the weights of one control vertex; the rest stays.
    const Eigen::AngleAxisd r(angle, point.t2);
    const Vector3d d1 = r * point.t1 - point.t1;
    // Least norm solution of sum w_i u_i = d_1, sum v_i u_i = 0.
    MatrixXd rows(2, n);
    rows << point.weights.row(kRowD1), point.weights.row(kRowD2);
    const MatrixXd inverse = rows.completeOrthogonalDecomposition().pseudoInverse();
    VectorXd x(3 * n);
    for (int i = 0; i < n; ++i) x.segment<3>(3 * i) = inverse(i, 0) * d1;
    return x;
  };
  for (double angle = 0.5; angle < 15.0; angle += 0.5) {
    const VectorXd x = turned(angle);
    EXPECT_NEAR(Energy(cost, x), -kFactor * 2.0 * 3.0 * angle, 1e-10 * angle) << angle;
    cost.SetReference(Blocks(x).data());
  }
}

}  // namespace
}  // namespace darboux
