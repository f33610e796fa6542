#include "geometry/shell_face.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/loop_mesh.h"
#include "geometry/shell_surface.h"
#include "tests/mesh_util.h"
#include "tests/sanitizer_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Vector3d Uniform(std::mt19937_64* generator, double size = 1.0) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const double x = uniform(*generator), y = uniform(*generator), z = uniform(*generator);
  return {x, y, z};
}

ElementPoint RandomElementPoint(const ShellSurface& surface, std::mt19937_64* generator) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const int e = std::uniform_int_distribution<int>(0, surface.num_elements() - 1)(*generator);
  double s = uniform(*generator), t = uniform(*generator);
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  return {e, s, t};
}

// A pebble of valences 5 and 6, semi-axes 1, 0.8 and 0.6 times scale.
ShellSurface Ellipsoid(int frequency, double scale = 1.0) {
  TriangleMesh mesh = MakeIcosphere(scale, frequency);
  SmoothOnSphere(10, &mesh);
  for (Vector3d& x : mesh.vertices) x = x.cwiseProduct(Vector3d(1.0, 0.8, 0.6));
  return ShellSurface(MakeLoopMesh(mesh));
}

// A dent 0.15 deep, at the side, and a shift of all.
Matrix3Xd Dent(const ShellSurface& surface, double scale = 1.0) {
  Matrix3Xd u(3, surface.mesh().num_vertices);
  const Vector3d tip(1.0, 0.1, 0.0);
  for (int i = 0; i < u.cols(); ++i) {
    const Vector3d x = surface.control_points().col(i) / scale;
    u.col(i) = -0.15 * std::exp(-(x - tip).squaredNorm() / 0.08) * Vector3d::UnitX() +
               Vector3d(0.01, 0.02, -0.01);
  }
  return scale * u;
}

double Sine(const ShellFace::Foot& foot, const Vector3d& x) {
  return (x - foot.position).cross(foot.normal).norm();
}

TEST(ShellFaceTest, DistanceToATorusIsItsClosedForm) {
  ParameterDomain::Options options;
  options.u_range = options.v_range = {0.0, 2.0 * M_PI};
  options.divisions = {24, 12};
  options.periodic = {true, true};
  const ShellSurface surface(MakeTorus(3.0, 1.0), options);
  for (const double offset : {0.0, 0.1, -0.1}) {
    const ShellFace face(surface, offset);
    std::mt19937_64 generator(17);
    for (int k = 0; k < 2000; ++k) {
      const Vector3d x = Uniform(&generator, 5.0);
      const double to_circle = std::hypot(std::hypot(x.x(), x.y()) - 3.0, x.z());
      const ShellFace::Foot foot = face.Closest(x);
      // Opposite to the circle's own axis several feet are equally near, one is enough.
      ASSERT_NEAR(foot.distance, to_circle - 1.0 - offset, 1e-13 * surface.size()) << k;
      ASSERT_FALSE(foot.on_boundary);
    }
  }
}

TEST(ShellFaceTest, DistanceToASphereOfTrianglesIsThatOfTheSphere) {
  TriangleMesh mesh = MakeIcosphere(2.0, 8);
  SmoothOnSphere(10, &mesh);
  LoopMesh loop = MakeLoopMesh(mesh);
  ASSERT_TRUE(InterpolatePoints(&loop));
  const ShellSurface surface(std::move(loop));
  const ShellFace face(surface, 0.05);
  std::mt19937_64 generator(18);
  double roughness = 0.0;  // of the surface itself
  for (int k = 0; k < 20000; ++k) {
    const Vector3d x = face.Evaluate(RandomElementPoint(surface, &generator)).position;
    roughness = std::max(roughness, std::abs(x.norm() - 2.05));
  }
  EXPECT_LT(roughness, 2e-3);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d x = Uniform(&generator, 3.0);
    const ShellFace::Foot foot = face.Closest(x);
    ASSERT_NEAR(foot.distance, x.norm() - 2.05, 1.1 * roughness) << k;
    ASSERT_LT(Sine(foot, x), 1e-9);
  }
}

TEST(ShellFaceTest, NothingIsNearerToADentedEllipsoidThanTheFoot) {
  const ShellSurface surface = Ellipsoid(8);
  ShellFace face(surface, 0.02);
  face.SetDisplacements(Dent(surface));
  EXPECT_EQ(face.displacements(), Dent(surface));
  std::vector<Vector3d> dense;
  const int n = 12;
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        dense.push_back(
            face.Evaluate({e, static_cast<double>(i) / n, static_cast<double>(j) / n}).position);
      }
    }
  }
  const double spacing = 1.2 / 8 / n;  // longest edge of the mesh over n
  std::mt19937_64 generator(19);
  for (int k = 0; k < 300; ++k) {
    const Vector3d x = Uniform(&generator, 1.3);
    double squared = std::numeric_limits<double>::infinity();
    for (const Vector3d& y : dense) squared = std::min(squared, (x - y).squaredNorm());
    const ShellFace::Foot foot = face.Closest(x);
    const double d = std::abs(foot.distance);
    ASSERT_LE(d, std::sqrt(squared) * (1.0 + 1e-12) + 1e-13) << k << " " << x.transpose();
    ASSERT_GE(d * d, squared - 2.0 * d * spacing - spacing * spacing) << k;
    ASSERT_LT(Sine(foot, x), 1e-9) << k << " " << x.transpose();
    ASSERT_NEAR((x - foot.position).norm(), d, 1e-15);
  }
}

TEST(ShellFaceTest, PointsAlongNormalsFindTheirFeetBack) {
  const ShellSurface surface =
      Ellipsoid(4);  // of the elements 60 have an extraordinary vertex, 260 none
  ShellFace face(surface, -0.01);
  face.SetDisplacements(Dent(surface));
  std::mt19937_64 generator(20);
  int irregular = 0;
  for (int k = 0; k < 3000; ++k) {
    const ElementPoint at = RandomElementPoint(surface, &generator);
    irregular += surface.basis().IsRegular(at.element) ? 0 : 1;
    const ShellFace::Foot on = face.Evaluate(at);
    const double d = 0.03 * Uniform(&generator).x();
    const Vector3d x = on.position + d * on.normal;
    const ShellFace::Foot foot = face.Closest(x);
    ASSERT_NEAR(foot.distance, d, 1e-12) << k;
    ASSERT_LT((foot.position - on.position).norm(), 1e-8) << k;
    ASSERT_GT(foot.normal.dot(on.normal), 1.0 - 1e-9) << k;
  }
  EXPECT_GT(irregular, 500);
}

// The plate [0, 2] x [0, 1], whose upper face is at z = 0.1.
TEST(ShellFaceTest, PointsBeyondAPlateHaveFeetOnItsBoundary) {
  for (const bool folded : {false, true}) {
    ParameterDomain::Options options;
    options.u_range = {0.0, 2.0};
    options.divisions = {8, 4};
    const ShellSurface surface(
        MakePlane(),
        options,
        folded ? ShellSurface::Ghosts::kFolded : ShellSurface::Ghosts::kIndependent);
    const ShellFace face(surface, 0.1);
    std::mt19937_64 generator(21);
    int beyond = 0;
    for (int k = 0; k < 2000; ++k) {
      const Vector3d x = Uniform(&generator, 3.0);
      const Vector3d foot_there(std::clamp(x.x(), 0.0, 2.0), std::clamp(x.y(), 0.0, 1.0), 0.1);
      const ShellFace::Foot foot = face.Closest(x);
      ASSERT_LT((foot.position - foot_there).norm(), 1e-12) << k << " " << x.transpose();
      ASSERT_NEAR(foot.distance, std::copysign((x - foot_there).norm(), x.z() - 0.1), 1e-13);
      const bool outside = x.x() < 0.0 || x.x() > 2.0 || x.y() < 0.0 || x.y() > 1.0;
      ASSERT_EQ(foot.on_boundary, outside) << k << " " << x.transpose();
      beyond += outside ? 1 : 0;
    }
    EXPECT_GT(beyond, 500);
  }
}

// Ghosts that are folded move with the vertices that they are made of.
TEST(ShellFaceTest, FoldedGhostsFollowTheShell) {
  ParameterDomain::Options options;
  options.divisions = {4, 4};
  const ShellSurface surface(MakePlane(), options, ShellSurface::Ghosts::kFolded);
  ShellFace face(surface, 0.0);
  Matrix3Xd u = Matrix3Xd::Zero(3, surface.mesh().num_vertices);
  for (int i = 0; i < u.cols(); ++i) {
    if (surface.IsActive(i)) u.col(i) << 0.1, -0.2, 0.3;
  }
  face.SetDisplacements(u);
  std::mt19937_64 generator(22);
  for (int k = 0; k < 200; ++k) {
    const ElementPoint at = RandomElementPoint(surface, &generator);
    const Vector3d moved = surface.Position(at) + Vector3d(0.1, -0.2, 0.3);
    ASSERT_LT((face.Evaluate(at).position - moved).norm(), 1e-14);
  }
}

// A bowl of a mesh with a boundary: feet on the rim are nearest along it.
TEST(ShellFaceTest, FeetOnACurvedRimAreNearest) {
  TriangleMesh mesh = Lattice(8, 8);
  for (Vector3d& x : mesh.vertices) {
    x = (x - Vector3d(4.0, 4.0, 0.0)) / 4.0;
    x.z() = 0.4 * x.x() * x.x() + 0.2 * x.y() * x.y();
  }
  const ShellSurface surface(MakeLoopMesh(mesh));
  const ShellFace face(surface, 0.05);
  std::vector<Vector3d> dense;
  const int n = 30;
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        dense.push_back(
            face.Evaluate({e, static_cast<double>(i) / n, static_cast<double>(j) / n}).position);
      }
    }
  }
  std::mt19937_64 generator(23);
  int rim = 0;
  for (int k = 0; k < 300; ++k) {
    const Vector3d x = Uniform(&generator, 2.0);
    double squared = std::numeric_limits<double>::infinity();
    for (const Vector3d& y : dense) squared = std::min(squared, (x - y).squaredNorm());
    const ShellFace::Foot foot = face.Closest(x);
    const double d = std::abs(foot.distance), spacing = 0.4 / n;
    ASSERT_LE(d, std::sqrt(squared) + 1e-12) << k << " " << x.transpose();
    ASSERT_GE(d * d, squared - 2.0 * d * spacing - spacing * spacing) << k;
    if (!foot.on_boundary) {
      ASSERT_LT(Sine(foot, x), 1e-9) << k << " " << x.transpose();
    }
    rim += foot.on_boundary ? 1 : 0;
  }
  EXPECT_GT(rim, 50);
}

TEST(ShellFaceTest, AHintChangesNothing) {
  const ShellSurface surface = Ellipsoid(6);
  ShellFace face(surface, 0.02);
  face.SetDisplacements(Dent(surface));
  std::mt19937_64 generator(24);
  for (int k = 0; k < 1000; ++k) {
    const Vector3d x = Uniform(&generator, 1.2);
    const ShellFace::Foot foot = face.Closest(x);
    const Vector3d near_x = x + 0.02 * Uniform(&generator);
    for (const Vector3d& before : {near_x, Vector3d(-x)}) {
      const ShellFace::Foot hint = face.Closest(before);
      const ShellFace::Foot hinted = face.Closest(x, &hint);
      ASSERT_NEAR(hinted.distance, foot.distance, 1e-13) << k << " " << x.transpose();
    }
  }
}

TEST(ShellFaceTest, MillimetresAreMetres) {
  const ShellSurface metres = Ellipsoid(5), millimetres = Ellipsoid(5, 1000.0);
  ShellFace face(metres, 0.02), face_mm(millimetres, 20.0);
  face.SetDisplacements(Dent(metres));
  face_mm.SetDisplacements(Dent(millimetres, 1000.0));
  std::mt19937_64 generator(25);
  for (int k = 0; k < 500; ++k) {
    const Vector3d x = Uniform(&generator, 1.2);
    ASSERT_NEAR(face_mm.Closest(1000.0 * x).distance, 1000.0 * face.Closest(x).distance, 1e-9);
  }
}

TEST(ShellFaceTest, ThousandsOfPointsPerSecond) {
  const ShellSurface surface = Ellipsoid(12);
  ShellFace face(surface, 0.02);
  face.SetDisplacements(Dent(surface));
  std::mt19937_64 generator(26);
  std::vector<Vector3d> regular, irregular;
  while (regular.size() < 20000) {
    const ElementPoint at = RandomElementPoint(surface, &generator);
    const ShellFace::Foot on = face.Evaluate(at);
    const Vector3d x = on.position + 0.01 * Uniform(&generator).x() * on.normal;
    (surface.basis().IsRegular(at.element) ? regular : irregular).push_back(x);
  }
  const auto rate = [&](const std::vector<Vector3d>& points, bool with_hints, const char* name) {
    std::vector<ShellFace::Foot> hints;
    for (const Vector3d& x : points) {
      hints.push_back(face.Closest(x + 0.005 * Vector3d(std::sin(1e4 * x.x()), 0.6, -0.2)));
    }
    const double start = CpuSeconds();
    double sum = 0.0;
    for (size_t i = 0; i < points.size(); ++i) {
      sum += face.Closest(points[i], with_hints ? &hints[i] : nullptr).distance;
    }
    const double per_second = points.size() / (CpuSeconds() - start);
    testing::Test::RecordProperty(name, static_cast<int>(per_second));
    EXPECT_TRUE(std::isfinite(sum));
    return per_second;
  };
  EXPECT_GT(rate(regular, true, "hints"), 15000.0 / kSlowdown);
  EXPECT_GT(rate(regular, false, "no_hints"), 10000.0 / kSlowdown);
  EXPECT_GT(rate(irregular, false, "irregular"), 2000.0 / kSlowdown);
}

}  // namespace
}  // namespace darboux
