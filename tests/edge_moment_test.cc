#include "costs/edge_moment.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

const double kOne = 1.0;  // load factor
constexpr double kLength = 0.7;

StrainPoint EdgePoint(StrainPoint point) {
  point.area = kLength;
  return point;
}

// Edge tangent, conormal and normal.
struct EdgeFrame {
  EdgeFrame(const StrainPoint& point, const Vector2d& tangent)
      : e(tangent.x() * point.t1 + tangent.y() * point.t2), v(e.cross(point.n)), n(point.n) {}
  Vector3d e, v, n;
};

Vector2d Tangent(double angle) { return {std::cos(angle), std::sin(angle)}; }

class EdgeMomentTest : public ::testing::TestWithParam<double> {  // direction of the edge, rad
 protected:
  std::vector<StrainPoint> Points() const {
    std::vector<StrainPoint> points;
    for (const StrainPoint& point : SamplePoints()) points.push_back(EdgePoint(point));
    return points;
  }
  EdgeMoment Cost(const StrainPoint& point, const Vector3d& moment) const {
    return EdgeMoment(point, tangent_, moment, &kOne, 1e6);
  }

  const Vector2d tangent_ = Tangent(GetParam());
  const Vector3d moment_ = Vector3d(0.3, -1.1, 0.6);  // N m / m
};

TEST_P(EdgeMomentTest, RestHasNoEnergy) {
  for (const StrainPoint& point : Points()) {
    EXPECT_NEAR(Energy(Cost(point, moment_), Fifteen::Zero()), 0.0, 1e-15);
  }
}

// Bending about the edge, twisting about the conormal, turning about the normal: work is moment
// times angle, also of large angles.
TEST_P(EdgeMomentTest, WorkIsMomentTimesAngleAboutEachAxis) {
  for (const StrainPoint& point : Points()) {
    const EdgeFrame frame(point, tangent_);
    for (const Vector3d& axis : {frame.e, frame.v, frame.n}) {
      for (const double angle : {-3.0, -1.6, -1e-9, 1e-3, 0.5, 1.6, 3.0}) {
        const Fifteen k =
            AffineInputs(point, AngleAxisd(angle, axis).toRotationMatrix() - Matrix3d::Identity());
        EXPECT_NEAR(Energy(Cost(point, 2.5 * axis), k), -kLength * 2.5 * angle, 1e-14);
        // The gradient does the work of a further turn: dU = -L m d(angle).
        const Fifteen spin =
            AffineInputs(point, CrossMatrix(axis) * AngleAxisd(angle, axis).toRotationMatrix());
        EXPECT_NEAR(Gradient(Cost(point, 2.5 * axis), k).dot(spin), -kLength * 2.5, 1e-13);
      }
    }
  }
}

TEST_P(EdgeMomentTest, StretchingDoesNoWork) {
  for (const StrainPoint& point : Points()) {
    const EdgeFrame frame(point, tangent_);
    for (const Vector3d& axis : {frame.e, frame.v, frame.n}) {
      const EdgeMoment cost = Cost(point, 2.5 * axis);
      EXPECT_NEAR(Energy(cost, AffineInputs(point, 0.4 * Matrix3d::Identity())), 0.0, 1e-15);
    }
    // After a bend about the edge, stretching changes nothing either.
    const Matrix3d bend = AngleAxisd(1.2, frame.e).toRotationMatrix();
    const Matrix3d stretch = Matrix3d::Identity() + 0.5 * frame.e * frame.e.transpose();
    EXPECT_NEAR(Energy(Cost(point, 2.5 * frame.e),
                       AffineInputs(point, bend * stretch - Matrix3d::Identity())),
                -kLength * 2.5 * 1.2,
                1e-14);
  }
}

// To first order the angles are the components of the rotation vector, whatever its axis.
TEST_P(EdgeMomentTest, InfinitesimalRotationDoesTheWorkOfTheRotationVector) {
  const Vector3d w(0.3, -0.5, 0.7);
  for (const StrainPoint& point : Points()) {
    const VectorXd gradient = Gradient(Cost(point, moment_), Fifteen::Zero());
    EXPECT_NEAR(
        gradient.dot(AffineInputs(point, CrossMatrix(w))), -kLength * moment_.dot(w), 1e-14);
  }
}

TEST_P(EdgeMomentTest, MomentWorkIsTheLimitOfSmallRotations) {
  for (const Patch& patch : SamplePatches()) {
    const LoopPatch loop = MakeLoopPatch(patch);
    const StrainPoint point = EdgePoint(loop.Points(1, 3, 0.6)->front());
    const EdgeMoment cost(point, tangent_, moment_, &kOne, 1e6);
    const Matrix3Xd work = MomentWork(point, moment_);
    const VectorXd gradient = Gradient(cost, VectorXd::Zero(36));
    EXPECT_LT((gradient + kLength * Eigen::Map<const VectorXd>(work.data(), 36)).norm(),
              1e-14 * gradient.norm());
    // Exact for a spin, whose rotation vector it contains.
    const Vector3d w(0.3, -0.5, 0.7);
    const VectorXd spin = loop.Parameters(1, loop.Affine(CrossMatrix(w), {1, 2, 3}));
    EXPECT_NEAR(Eigen::Map<const VectorXd>(work.data(), 36).dot(spin), moment_.dot(w), 1e-13);
    // Energy: the remainder is of second order.
    const VectorXd u = SeededUniform(36, 1.0);
    const double linear = gradient.dot(u);
    const auto remainder = [&](double size) { return Energy(cost, size * u) - size * linear; };
    EXPECT_NEAR(std::log10(std::abs(remainder(1e-3) / remainder(1e-4))), 2.0, 0.3);
  }
}

TEST_P(EdgeMomentTest, ReadsTheFactorAtEveryEvaluation) {
  const StrainPoint point = EdgePoint(RandomPoint(4));
  double factor = 1.0;
  const EdgeMoment cost(point, tangent_, moment_, &factor, 1e6);
  const VectorXd k = SeededUniform(15, 0.3);
  const double energy = Energy(cost, k);
  const VectorXd gradient = Gradient(cost, k);
  factor = -0.25;
  EXPECT_NEAR(Energy(cost, k) / energy, -0.25, 1e-14);
  EXPECT_LT((Gradient(cost, k) + 0.25 * gradient).norm(), 1e-14 * gradient.norm());
}

TEST_P(EdgeMomentTest, DoesNotDependOnTheFrameOfThePoint) {
  const StrainPoint point = EdgePoint(RandomPoint(4));
  const Fifteen k = SeededUniform(15, 0.3);
  const double turn = 1.1, c = std::cos(turn), s = std::sin(turn);
  StrainPoint turned = point;
  turned.t1 = c * point.t1 + s * point.t2;
  turned.t2 = c * point.t2 - s * point.t1;
  Fifteen l = k;
  l.segment<3>(0) = c * k.segment<3>(0) + s * k.segment<3>(3);
  l.segment<3>(3) = c * k.segment<3>(3) - s * k.segment<3>(0);
  const EdgeMoment other(turned, Tangent(GetParam() - turn), moment_, &kOne, 1e6);
  EXPECT_NEAR(Energy(other, l), Energy(Cost(point, moment_), k), 1e-14);
}

TEST_P(EdgeMomentTest, IsRefusedWhereAnAngleIsUndefined) {
  for (const StrainPoint& point : Points()) {
    const EdgeFrame frame(point, tangent_);
    // A quarter turn about v lays the normal along the edge: no angle about the edge.
    const Fifteen quarter = AffineInputs(
        point, AngleAxisd(M_PI / 2.0, frame.v).toRotationMatrix() - Matrix3d::Identity());
    EXPECT_FALSE(EvaluateAt(Cost(point, frame.e), quarter).ok);
    EXPECT_FALSE(EvaluateAt(Cost(point, frame.e), quarter, false).ok);
    EXPECT_TRUE(EvaluateAt(Cost(point, frame.v), quarter).ok);
    // A collapsed shell has no normal, and its edge no direction.
    const Fifteen collapsed = AffineInputs(point, -Matrix3d::Identity());
    for (const Vector3d& axis : {frame.e, frame.v, frame.n}) {
      EXPECT_FALSE(EvaluateAt(Cost(point, axis), collapsed).ok);
    }
    // No moment asks for no angle.
    EXPECT_TRUE(EvaluateAt(Cost(point, Vector3d::Zero()), collapsed).ok);
    EXPECT_EQ(Energy(Cost(point, Vector3d::Zero()), collapsed), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(EdgeDirectionRad, EdgeMomentTest, ::testing::Values(0.0, 0.8, 2.0, -2.5));

// Large displacements fold the normal back and forth; only away from half turns has the energy a
// derivative, and random states are.
class EdgeMomentJacobianTest : public ::testing::TestWithParam<double> {};  // size of u, m

TEST_P(EdgeMomentJacobianTest, MatchesRiddersDifferences) {
  for (const Patch& patch : {TorusPatch(), PlanePatch()}) {
    const StrainPoint point = EdgePoint(MakeLoopPatch(patch).Points(1)->front());
    for (const Vector3d& moment : {Vector3d(0.3, -1.1, 0.6), Vector3d(point.n)}) {
      const auto cost = std::make_unique<EdgeMoment>(point, Tangent(0.8), moment, &kOne, 1e6);
      EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(36, GetParam()), 1e-6));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(DisplacementM,
                         EdgeMomentJacobianTest,
                         ::testing::Values(0, 1e-8, 1e-2, 0.3, 1e2));

}  // namespace
}  // namespace darboux
