#include "geometry/mesh_finger.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/finger_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(MeshFingerTest, CuboidIsABox) {
  const Vector3d half(0.5, 0.7, 0.9);
  const auto mesh = MeshShape(CuboidMesh(half));
  const auto box = MakeBoxFinger(half, 0.0);
  for (unsigned seed = 0; seed < 500; ++seed) {
    const Vector3d x = SeededUniform(3, 2.0, seed);
    const Distance a = DistanceAt(*mesh, x), b = DistanceAt(*box, x);
    EXPECT_NEAR(a.value, b.value, 1e-14);
    EXPECT_LE((a.normal - b.normal).norm(), 1e-13);
    EXPECT_LE((a.hessian - b.hessian).norm(), 1e-12 * (1.0 + b.hessian.norm()));
  }
  EXPECT_NEAR(mesh->MaxStep(), 0.5, 1e-15);
  EXPECT_NEAR(mesh->Reach(), half.norm(), 1e-15);
}

// Triangles with edges l are up to l^2 / (6 R) inside the sphere; here l <= 1.25 R / 2^splits.
TEST(MeshFingerTest, FineSphereIsASphere) {
  const double radius = 0.7;
  double last = std::numeric_limits<double>::infinity();
  for (const int splits : {2, 3, 4}) {
    const auto mesh = MeshShape(SphereMesh(radius, splits));
    double worst = 0.0, worst_normal = 0.0;
    for (unsigned seed = 0; seed < 500; ++seed) {
      const Vector3d x = SeededUniform(3, 1.5, seed);
      if (x.norm() < 0.1) continue;
      const Distance d = DistanceAt(*mesh, x);
      worst = std::max(worst, std::abs(d.value - (x.norm() - radius)));
      if (x.norm() > radius) {
        worst_normal = std::max(worst_normal, (d.normal - x.normalized()).norm());
      }
    }
    const double edge = 1.25 * radius / (1 << splits);
    EXPECT_LE(worst, edge * edge / (5.0 * radius));
    EXPECT_LE(worst_normal, edge / radius);
    EXPECT_LT(worst, 0.3 * last);  // second order
    last = worst;
    EXPECT_NEAR(mesh->MaxStep(), radius, 0.05 * radius);
  }
}

// The curvature sits in edges and vertices, but is a sphere's on average.
TEST(MeshFingerTest, MeanCurvatureIsThatOfTheSphere) {
  const auto mesh = MeshShape(SphereMesh(1.0, 3));
  double trace = 0.0;
  constexpr int kSamples = 20000;
  for (unsigned seed = 0; seed < kSamples; ++seed) {
    trace += DistanceAt(*mesh, 1.3 * SeededUniform(3, 1.0, seed).normalized()).hessian.trace();
  }
  EXPECT_NEAR(trace / kSamples, 2.0 / 1.3, 0.05);
}

// Against the nearest of many points on every triangle.
TEST(MeshFingerTest, TreeFindsTheNearestTriangle) {
  const TriangleMesh mesh = SphereMesh(1.0, 2);
  const auto shape = MeshShape(mesh);
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Vector3d x = SeededUniform(3, 2.0, seed);
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles) {
      constexpr int kSteps = 20;
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
          const double a = double(i) / kSteps, b = double(j) / kSteps;
          const Vector3d p = (1.0 - a - b) * mesh.vertices[t[0]] + a * mesh.vertices[t[1]] +
                             b * mesh.vertices[t[2]];
          nearest = std::min(nearest, (x - p).norm());
        }
      }
    }
    const double distance = std::abs(DistanceAt(*shape, x).value);
    EXPECT_LE(distance, nearest + 1e-14);
    EXPECT_GE(distance, nearest - 0.02);
  }
}

TEST(MeshFingerTest, DentIsOutside) {
  const auto shape = MeshShape(CuboidMesh({1.0, 1.0, 1.0}, true));
  const auto whole = MeshShape(CuboidMesh({1.0, 1.0, 1.0}));
  EXPECT_LT(DistanceAt(*whole, {0.5, 0.5, 0.5}).value, 0.0);
  EXPECT_GT(DistanceAt(*shape, {0.5, 0.5, 0.5}).value, 0.0);
  EXPECT_GT(DistanceAt(*shape, {-0.15, -0.15, -0.15}).value, 0.0);
  EXPECT_LT(DistanceAt(*shape, {-0.3, -0.3, -0.3}).value, 0.0);
}

// Signs at points whose nearest feature is a vertex or an edge, where a face's normal may be wrong.
TEST(MeshFingerTest, SignAgreesWithTheSolidAngle) {
  for (const TriangleMesh& mesh :
       {CuboidMesh({0.5, 0.7, 0.9}, true), SphereMesh(0.8, 1), CuboidMesh({0.1, 1.0, 1.0})}) {
    const auto shape = MeshShape(mesh);
    for (unsigned seed = 0; seed < 1000; ++seed) {
      const Vector3d x = SeededUniform(3, 1.2, seed);
      double solid_angle = 0.0;  // A. van Oosterom and J. Strackee (1983)
      for (const auto& t : mesh.triangles) {
        const Vector3d a = mesh.vertices[t[0]] - x, b = mesh.vertices[t[1]] - x,
                       c = mesh.vertices[t[2]] - x;
        solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                                        a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                            b.dot(c) * a.norm() + c.dot(a) * b.norm());
      }
      EXPECT_EQ(solid_angle > 2.0 * M_PI, DistanceAt(*shape, x).value < 0.0);
    }
  }
}

TEST(MeshFingerTest, HasANormalOnTheSurfaceToo) {
  const TriangleMesh mesh = CuboidMesh({1.0, 1.0, 1.0});
  const auto shape = MeshShape(mesh);
  const Distance face = DistanceAt(*shape, {1.0, 0.3, 0.2});
  EXPECT_NEAR(face.value, 0.0, 1e-16);
  EXPECT_EQ(face.normal, Vector3d::UnitX());
  const Distance edge = DistanceAt(*shape, {1.0, 1.0, 0.2});
  EXPECT_EQ(edge.value, 0.0);
  EXPECT_LE((edge.normal - Vector3d(1.0, 1.0, 0.0).normalized()).norm(), 1e-15);
  // Weighted by angles all three faces count alike, however they are cut into triangles.
  const Distance corner = DistanceAt(*shape, {1.0, 1.0, 1.0});
  EXPECT_EQ(corner.value, 0.0);
  EXPECT_LE((corner.normal - Vector3d(1.0, 1.0, 1.0).normalized()).norm(), 1e-15);
  EXPECT_TRUE(corner.hessian.allFinite());
}

TEST(MeshFingerTest, ThinnestPlaceLimitsTheStep) {
  EXPECT_NEAR(MeshShape(CuboidMesh({0.5, 0.03, 0.9}))->MaxStep(), 0.03, 1e-15);
  TriangleMesh tetrahedron;  // Only edges, no opposite walls.
  tetrahedron.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  tetrahedron.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  const double step = MeshShape(tetrahedron)->MaxStep();
  EXPECT_GT(step, 0.3);
  EXPECT_LT(step, 1.2);
}

// Lengths in other units: the same distances but for the unit.
TEST(MeshFingerTest, IsScaleFree) {
  for (const double scale : {1e-6, 1e6}) {
    TriangleMesh mesh = SphereMesh(0.7, 1);
    const auto shape = MeshShape(mesh);
    for (Vector3d& vertex : mesh.vertices) vertex *= scale;
    const auto scaled = MeshShape(mesh);
    for (unsigned seed = 0; seed < 50; ++seed) {
      const Vector3d x = SeededUniform(3, 1.5, seed);
      EXPECT_NEAR(DistanceAt(*scaled, scale * x).value / scale, DistanceAt(*shape, x).value, 1e-13);
    }
    EXPECT_NEAR(scaled->MaxStep() / scale, shape->MaxStep(), 1e-13);
  }
}

TEST(MeshFingerTest, NamesWhatIsWrongWithAMesh) {
  const auto error_of = [](const TriangleMesh& mesh) {
    std::string error;
    EXPECT_EQ(MakeMeshFinger(mesh, &error), nullptr);
    return error;
  };
  using ::testing::HasSubstr;
  const TriangleMesh good = CuboidMesh({1.0, 1.0, 1.0});
  TriangleMesh bad = good;
  bad.triangles.pop_back();
  EXPECT_THAT(error_of(bad), HasSubstr("not closed"));
  bad = good;
  std::swap(bad.triangles[0][0], bad.triangles[0][1]);
  EXPECT_THAT(error_of(bad), HasSubstr("wound alike"));
  bad = good;
  for (auto& t : bad.triangles) std::swap(t[0], t[1]);
  EXPECT_THAT(error_of(bad), HasSubstr("volume is negative"));
  bad = good;
  bad.triangles[3][1] = 8;
  EXPECT_THAT(error_of(bad), HasSubstr("triangle 3 has vertex 8 of 8"));
  bad = good;
  bad.triangles[3][1] = bad.triangles[3][0];
  EXPECT_THAT(error_of(bad), HasSubstr("triangle 3 has no area"));
  bad = good;
  bad.vertices[2].y() = std::nan("");
  EXPECT_THAT(error_of(bad), HasSubstr("vertex 2 is not finite"));
  EXPECT_THAT(error_of(TriangleMesh()), HasSubstr("no triangles"));
}

}  // namespace
}  // namespace darboux
