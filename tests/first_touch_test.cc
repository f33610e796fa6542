#include "geometry/first_touch.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/finger_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> Cloud(int n, double size, const Vector3d& center, unsigned seed) {
  std::vector<Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(center + SeededUniform(3, size, seed + 1000 * i));
  return points;
}

double SmallestGap(const FingerShape& shape,
                   FingerPose pose,
                   const Vector3d& move,
                   const std::vector<Vector3d>& points,
                   double offset) {
  pose.position += move;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Vector3d& x : points) {
    Distance d;
    pose.Evaluate(shape, x, &d);
    smallest = std::min(smallest, d.value - offset);
  }
  return smallest;
}

class FirstTouchTest : public ::testing::TestWithParam<NamedShape> {
 protected:
  const FingerShape& shape_ = *GetParam().shape;
  const Vector3d direction_ = Vector3d(2.0, -1.0, 2.0) / 3.0;
};

TEST_P(FirstTouchTest, TouchesAndWasFreeAllTheWay) {
  int touched = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    FingerPose pose = SkewPose();
    if (GetParam().name == "plane") {  // faces where it goes
      pose.rotation =
          Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction_).toRotationMatrix() *
          SkewRotation(0.3);
    }
    const auto points = Cloud(40, 0.8, pose.position + 4.0 * direction_, seed);
    const double offset = 0.3;
    Touch touch;
    if (!FirstTouch(shape_, pose, direction_, points, offset, &touch)) {
      for (double s = 0.0; s < 10.0; s += 0.01) {
        ASSERT_GT(SmallestGap(shape_, pose, s * direction_, points, offset), 0.0);
      }
      continue;
    }
    ++touched;
    EXPECT_GT(touch.shift, 0.0);
    EXPECT_NEAR(SmallestGap(shape_, pose, touch.shift * direction_, points, offset), 0.0, 1e-13);
    EXPECT_NEAR(SmallestGap(shape_, pose, touch.shift * direction_, {points[touch.point]}, offset),
                0.0,
                1e-13);
    for (double part = 0.0; part < 0.999; part += 0.01) {
      EXPECT_GT(SmallestGap(shape_, pose, part * touch.shift * direction_, points, offset), 0.0);
    }
  }
  EXPECT_GE(touched, 10);
}

TEST_P(FirstTouchTest, BacksOffUntilNothingOverlaps) {
  int overlapped = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    FingerPose pose = SkewPose();
    if (GetParam().name == "plane") {
      pose.rotation =
          Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction_).toRotationMatrix() *
          SkewRotation(0.3);
    }
    const auto points = Cloud(40, 0.8, pose.position + 0.3 * direction_, seed);
    const double offset = 0.3;
    if (SmallestGap(shape_, pose, Vector3d::Zero(), points, offset) >= 0.0) continue;
    ++overlapped;
    Touch touch;
    ASSERT_TRUE(FirstTouch(shape_, pose, direction_, points, offset, &touch));
    EXPECT_LT(touch.shift, 0.0);
    EXPECT_NEAR(SmallestGap(shape_, pose, touch.shift * direction_, points, offset), 0.0, 1e-13);
    EXPECT_NEAR(SmallestGap(shape_, pose, touch.shift * direction_, {points[touch.point]}, offset),
                0.0,
                1e-13);
    for (double part = 0.0; part < 0.999; part += 0.01) {  // It has just left them.
      EXPECT_LT(SmallestGap(shape_, pose, part * touch.shift * direction_, points, offset), 0.0);
    }
  }
  EXPECT_GE(overlapped, 8);
}

TEST_P(FirstTouchTest, NothingToTouch) {
  if (GetParam().name == "plane") return;
  Touch touch;
  EXPECT_FALSE(FirstTouch(shape_, FingerPose(), direction_, {}, 0.1, &touch));
  // Behind, and beside the way.
  EXPECT_FALSE(FirstTouch(shape_, FingerPose(), direction_, {-5.0 * direction_}, 0.1, &touch));
  EXPECT_FALSE(FirstTouch(shape_, FingerPose(), direction_, {{3.0, 4.0, -1.0 + 2.0}}, 0.1, &touch));
}

INSTANTIATE_TEST_SUITE_P(Shapes, FirstTouchTest, ::testing::ValuesIn(SampleShapes()), ShapeName);

TEST(FirstTouchClosedFormTest, SphereOnASphere) {
  // A sphere of radius 2 above points of the unit sphere, h = 0.2, off the axis by 1.
  const auto finger = MakeSphereFinger(2.0);
  std::vector<Vector3d> points;
  for (int i = 0; i <= 2000; ++i) {
    const double angle = 2.0 * M_PI * i / 2000;
    points.push_back({std::sin(angle), 0.0, std::cos(angle)});
  }
  Touch touch;
  for (const double height : {5.0, 3.0, 2.0}) {
    ASSERT_TRUE(FirstTouch(*finger,
                           {{1.0, 0.0, height}, Eigen::Matrix3d::Identity()},
                           -Vector3d::UnitZ(),
                           points,
                           0.1,
                           &touch));
    EXPECT_NEAR(touch.shift, height - std::sqrt(3.1 * 3.1 - 1.0), 1e-5);  // spacing^2
  }
}

TEST(FirstTouchClosedFormTest, Plane) {
  const auto plane = MakePlaneFinger();
  const Vector3d up = Vector3d::UnitZ();
  Touch touch;
  ASSERT_TRUE(FirstTouch(*plane, FingerPose(), up, {{0, 0, 5}, {7, 3, 2}}, 0.5, &touch));
  EXPECT_NEAR(touch.shift, 1.5, 1e-13);
  EXPECT_EQ(touch.point, 1);
  ASSERT_TRUE(FirstTouch(*plane, FingerPose(), up, {{0, 0, 5}, {7, 3, -2}}, 0.5, &touch));
  EXPECT_NEAR(touch.shift, -2.5, 1e-13);
  ASSERT_TRUE(FirstTouch(*plane, FingerPose(), up, {{0, 0, 0.5}}, 0.5, &touch));
  EXPECT_EQ(touch.shift, 0.0);
  const Vector3d slant(0.6, 0.0, 0.8);
  ASSERT_TRUE(FirstTouch(*plane, FingerPose(), slant, {{9, 9, 2.5}}, 0.5, &touch));
  EXPECT_NEAR(touch.shift, 2.5, 1e-13);
  // Away from all, along itself, and deeper into what it already overlaps.
  EXPECT_FALSE(FirstTouch(*plane, FingerPose(), -up, {{0, 0, 5}}, 0.5, &touch));
  EXPECT_FALSE(FirstTouch(*plane, FingerPose(), Vector3d::UnitX(), {{0, 0, 5}}, 0.5, &touch));
  EXPECT_FALSE(FirstTouch(*plane, FingerPose(), -up, {{0, 0, -5}}, 0.5, &touch));
}

// Past the sphere at a distance of just more or less than its radius.
TEST(FirstTouchClosedFormTest, GrazingTouch) {
  const auto finger = MakeSphereFinger(1.0);
  Touch touch;
  for (const double depth : {1e-2, 1e-6, 1e-10, 1e-13}) {
    const double x = 1.1 - depth;
    ASSERT_TRUE(FirstTouch(*finger, FingerPose(), Vector3d::UnitZ(), {{x, 0.0, 9.0}}, 0.1, &touch));
    EXPECT_NEAR(touch.shift, 9.0 - std::sqrt(1.1 * 1.1 - x * x), 1e-7);
    EXPECT_FALSE(FirstTouch(
        *finger, FingerPose(), Vector3d::UnitZ(), {{1.1 + depth, 0.0, 9.0}}, 0.1, &touch));
  }
}

// Fingers inside a closed shell push outwards and back off inwards.
TEST(FirstTouchClosedFormTest, InsideAClosedShell) {
  const auto finger = MakeSphereFinger(0.5);
  const auto mesh = SphereMesh(2.0, 3);
  Touch touch;
  ASSERT_TRUE(FirstTouch(*finger, FingerPose(), Vector3d::UnitZ(), mesh.vertices, 0.1, &touch));
  EXPECT_NEAR(touch.shift, 1.4, 0.01);
  ASSERT_TRUE(FirstTouch(*finger,
                         {{0.0, 0.0, 1.8}, Eigen::Matrix3d::Identity()},
                         Vector3d::UnitZ(),
                         mesh.vertices,
                         0.1,
                         &touch));
  EXPECT_NEAR(touch.shift, -0.4, 0.01);
}

TEST(FirstTouchClosedFormTest, UnitsDoNotMatter) {
  for (const double scale : {1e-7, 1e7}) {
    const auto finger = MakeBoxFinger(scale * Vector3d(0.5, 0.6, 0.7), 0.1 * scale);
    FingerPose pose = SkewPose();
    pose.position *= scale;
    std::vector<Vector3d> points = Cloud(50, 0.5, {0.0, 0.0, 5.0}, 3);
    Touch unit, scaled;
    ASSERT_TRUE(FirstTouch(*MakeBoxFinger(Vector3d(0.5, 0.6, 0.7), 0.1),
                           SkewPose(),
                           Vector3d::UnitZ(),
                           points,
                           0.05,
                           &unit));
    for (Vector3d& point : points) point *= scale;
    ASSERT_TRUE(FirstTouch(*finger, pose, Vector3d::UnitZ(), points, 0.05 * scale, &scaled));
    EXPECT_NEAR(scaled.shift / scale, unit.shift, 1e-12);
    EXPECT_EQ(scaled.point, unit.point);
  }
}

}  // namespace
}  // namespace darboux
