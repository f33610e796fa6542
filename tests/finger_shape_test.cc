#include "geometry/finger_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "tests/finger_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class FingerShapeTest : public ::testing::TestWithParam<NamedShape> {
 protected:
  const FingerShape& shape_ = *GetParam().shape;
  const FingerPose pose_ = SkewPose();
};

TEST_P(FingerShapeTest, DerivativesMatchRiddersDifferences) {
  const auto cost = std::make_unique<DistanceAndNormal>(shape_, pose_);
  int checked = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Vector3d x = SeededUniform(3, seed < 40 ? 1.5 : 8.0, seed);
    // Differences need a neighbourhood without a ridge or an edge of a feature in it.
    Distance d;
    ASSERT_TRUE(pose_.Evaluate(shape_, x, &d));
    bool smooth = true;
    for (int k = 0; k < 40 && smooth; ++k) {
      Distance near;
      const Vector3d step = 0.02 * SeededUniform(3, 1.0, 1000 + k);
      smooth = pose_.Evaluate(shape_, x + step, &near) &&
               (near.normal - d.normal - d.hessian * step).norm() < 0.02 &&
               (near.hessian - d.hessian).norm() < 0.2 * d.hessian.norm() + 1e-12;
    }
    if (!smooth) continue;
    ++checked;
    EXPECT_THAT(cost, HasCorrectJacobianAt(x, 1e-6)) << x.transpose();
  }
  EXPECT_GE(checked, 20);
}

TEST_P(FingerShapeTest, NormalsAreUnitAndStayUnit) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Distance d = DistanceAt(shape_, SeededUniform(3, 2.0, seed), pose_);
    EXPECT_NEAR(d.normal.norm(), 1.0, 1e-13);
    EXPECT_LE((d.hessian * d.normal).norm(), 1e-12 * (1.0 + d.hessian.norm()));
    EXPECT_LE((d.hessian - d.hessian.transpose()).norm(), 1e-13 * d.hessian.norm());
  }
}

// The foot of x lies on the surface, and has the same normal.
TEST_P(FingerShapeTest, NormalLeadsToTheSurface) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Vector3d x = SeededUniform(3, 2.0, seed);
    const Distance d = DistanceAt(shape_, x, pose_);
    for (const double part : {0.5, 0.999}) {
      const Distance near = DistanceAt(shape_, x - part * d.value * d.normal, pose_);
      EXPECT_NEAR(near.value, (1.0 - part) * d.value, 1e-12);
      EXPECT_LE((near.normal - d.normal).norm(), 1e-8);
    }
  }
}

TEST_P(FingerShapeTest, IsLipschitzWithConstantOne) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Vector3d x = SeededUniform(3, 2.0, seed), y = SeededUniform(3, 2.0, seed + 500);
    EXPECT_LE(std::abs(DistanceAt(shape_, x, pose_).value - DistanceAt(shape_, y, pose_).value),
              (x - y).norm() * (1.0 + 1e-14));
  }
}

TEST_P(FingerShapeTest, MovesWithItsPose) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Vector3d x = SeededUniform(3, 2.0, seed);
    const Distance at_rest = DistanceAt(shape_, x);
    const Distance moved = DistanceAt(shape_, pose_.position + pose_.rotation * x, pose_);
    EXPECT_NEAR(moved.value, at_rest.value, 1e-14);
    EXPECT_LE((moved.normal - pose_.rotation * at_rest.normal).norm(), 1e-12);
    EXPECT_LE(
        (moved.hessian - pose_.rotation * at_rest.hessian * pose_.rotation.transpose()).norm(),
        1e-11 * (1.0 + at_rest.hessian.norm()));
  }
}

// The bounds contain every point of the surface, and no much smaller ball would.
TEST_P(FingerShapeTest, BoundsAreAroundIt) {
  const Ball ball = pose_.Bounds(shape_);
  if (!std::isfinite(ball.radius)) {
    EXPECT_EQ(GetParam().name, "plane");
    EXPECT_EQ(shape_.Reach(), kInfinity);
    return;
  }
  double farthest = 0.0, reach = 0.0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    const Vector3d x = SeededUniform(3, 1.2, seed);
    Distance d;
    if (!pose_.Evaluate(shape_, x, &d)) continue;
    const Vector3d foot = x - d.value * d.normal;
    farthest = std::max(farthest, (foot - ball.center).norm());
    reach = std::max(reach, (foot - pose_.position).norm());
  }
  EXPECT_LE(farthest, ball.radius * (1.0 + 1e-12) + 1e-14);
  EXPECT_GE(farthest, 0.9 * ball.radius);
  EXPECT_LE(reach, shape_.Reach() * (1.0 + 1e-12) + 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Shapes, FingerShapeTest, ::testing::ValuesIn(SampleShapes()), ShapeName);

TEST(FingerShapeClosedFormTest, PinIsTheDistanceFromAPoint) {
  const auto pin = MakePinFinger();
  const Distance d = DistanceAt(*pin, {2.0, -3.0, 6.0});
  EXPECT_EQ(d.value, 7.0);
  EXPECT_LE((d.normal - Vector3d(2.0, -3.0, 6.0) / 7.0).norm(), 1e-15);
  EXPECT_NEAR(d.hessian.trace(), 2.0 / 7.0, 1e-15);
  Distance at_the_point;
  EXPECT_FALSE(pin->Evaluate(Vector3d::Zero(), &at_the_point));
  EXPECT_EQ(at_the_point.value, 0.0);
  EXPECT_EQ(pin->MaxStep(), 0.0);
  EXPECT_EQ(pin->Reach(), 0.0);
}

TEST(FingerShapeClosedFormTest, SphereIsThatLessTheRadius) {
  const auto sphere = MakeSphereFinger(2.0);
  EXPECT_EQ(DistanceAt(*sphere, {2.0, -3.0, 6.0}).value, 5.0);
  EXPECT_EQ(DistanceAt(*sphere, {0.0, -0.5, 0.0}).value, -1.5);
  EXPECT_EQ(DistanceAt(*sphere, {0.0, -0.5, 0.0}).normal, -Vector3d::UnitY());
  Distance at_the_center;
  EXPECT_FALSE(sphere->Evaluate(Vector3d::Zero(), &at_the_center));
  EXPECT_EQ(at_the_center.value, -2.0);
  EXPECT_EQ(sphere->MaxStep(), 2.0);
  EXPECT_EQ(sphere->Reach(), 2.0);
}

TEST(FingerShapeClosedFormTest, CapsuleIsACylinderWithCaps) {
  const auto capsule = MakeCapsuleFinger(0.5, 2.0);
  const Distance side = DistanceAt(*capsule, {3.0, -4.0, 0.9});
  EXPECT_EQ(side.value, 4.5);
  EXPECT_NEAR(side.hessian.trace(), 1.0 / 5.0, 1e-15);  // one curvature
  EXPECT_EQ(side.hessian.col(2), Vector3d::Zero());
  const Distance cap = DistanceAt(*capsule, {2.0, -3.0, -7.0});
  EXPECT_EQ(cap.value, 6.5);
  EXPECT_NEAR(cap.hessian.trace(), 2.0 / 7.0, 1e-15);
  Distance axis;
  EXPECT_FALSE(capsule->Evaluate({0.0, 0.0, 0.3}, &axis));
  EXPECT_EQ(axis.value, -0.5);
  EXPECT_EQ(capsule->Reach(), 1.5);
  EXPECT_EQ(capsule->MaxStep(), 0.5);
}

TEST(FingerShapeClosedFormTest, BoxHasFacesEdgesAndCorners) {
  for (const double rounding : {0.0, 0.5}) {
    const auto box = MakeBoxFinger({1.0, 2.0, 3.0}, rounding);
    const Distance face = DistanceAt(*box, {0.2, -5.0, 1.0});
    EXPECT_EQ(face.value, 3.0);
    EXPECT_EQ(face.normal, -Vector3d::UnitY());
    EXPECT_EQ(face.hessian, Matrix3d::Zero());
    const Distance edge = DistanceAt(*box, {-1.0 - 3.0 + rounding, 2.0 + 4.0 - rounding, 0.3});
    EXPECT_NEAR(edge.value, 5.0 - rounding, 1e-15);
    EXPECT_LE((edge.normal - Vector3d(-0.6, 0.8, 0.0)).norm(), 1e-15);
    EXPECT_NEAR(edge.hessian.trace(), 1.0 / 5.0, 1e-15);
    const Distance corner =
        DistanceAt(*box, {1.0 + 2.0 - rounding, -2.0 - 3.0 + rounding, 3.0 + 6.0 - rounding});
    EXPECT_NEAR(corner.value, 7.0 - rounding, 1e-15);
    EXPECT_NEAR(corner.hessian.trace(), 2.0 / 7.0, 1e-15);
    const Distance inside = DistanceAt(*box, {0.3, -0.4, 2.5});
    EXPECT_NEAR(inside.value, -0.5, 1e-15);
    EXPECT_EQ(inside.normal, Vector3d::UnitZ());
    EXPECT_EQ(box->MaxStep(), 1.0);
  }
  EXPECT_NEAR(MakeBoxFinger({1.0, 2.0, 2.0}, 0.0)->Reach(), 3.0, 1e-15);
}

TEST(FingerShapeClosedFormTest, RoundedBoxesOffsetIsSmooth) {
  const auto box = MakeBoxFinger({1.0, 2.0, 3.0}, 0.5);
  const auto sharp = MakeBoxFinger({0.5, 1.5, 2.5}, 0.0);
  for (unsigned seed = 0; seed < 100; ++seed) {  // It is the offset of a sharp box.
    const Vector3d x = SeededUniform(3, 5.0, seed);
    EXPECT_NEAR(DistanceAt(*box, x).value, DistanceAt(*sharp, x).value - 0.5, 1e-14);
  }
}

TEST(FingerShapeClosedFormTest, BoxOfRoundingAloneIsASphere) {
  const auto box = MakeBoxFinger({0.5, 0.5, 0.5}, 0.5);
  const auto sphere = MakeSphereFinger(0.5);
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Vector3d x = SeededUniform(3, 1.0, seed);
    const Distance a = DistanceAt(*box, x), b = DistanceAt(*sphere, x);
    EXPECT_NEAR(a.value, b.value, 1e-15);
    EXPECT_LE((a.normal - b.normal).norm(), 1e-15);
    EXPECT_LE((a.hessian - b.hessian).norm(), 1e-13 * b.hessian.norm());
  }
}

TEST(FingerShapeClosedFormTest, CapsuleWithoutLengthIsASphere) {
  const auto capsule = MakeCapsuleFinger(0.5, 0.0);
  const auto sphere = MakeSphereFinger(0.5);
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Vector3d x = SeededUniform(3, 1.0, seed);
    const Distance a = DistanceAt(*capsule, x), b = DistanceAt(*sphere, x);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.hessian, b.hessian);
  }
}

TEST(FingerShapeClosedFormTest, PlaneIsTheHeight) {
  const auto plane = MakePlaneFinger();
  const Distance d = DistanceAt(*plane, {4.0, 5.0, -2.5});
  EXPECT_EQ(d.value, -2.5);
  EXPECT_EQ(d.normal, Vector3d::UnitZ());
  EXPECT_EQ(d.hessian, Matrix3d::Zero());
  EXPECT_EQ(plane->MaxStep(), kInfinity);
}

TEST(FingerShapeDeathTest, ImpossibleSizes) {
  EXPECT_DEATH(MakeSphereFinger(0.0), "");
  EXPECT_DEATH(MakeCapsuleFinger(1.0, -1.0), "");
  EXPECT_DEATH(MakeBoxFinger({1.0, 2.0, 3.0}, 1.1), "");
}

}  // namespace
}  // namespace darboux
