#include "geometry/scan_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/loop_mesh.h"
#include "geometry/mesh_finger.h"
#include "tests/mesh_util.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

Scan Simulate(const ScanSurface& surface,
              const ScanOptions& options,
              const std::vector<Occluder>& occluders = {}) {
  Scan scan;
  std::string error;
  EXPECT_TRUE(SimulateScan(surface, occluders, options, &scan, &error)) << error;
  EXPECT_EQ(scan.truth.size(), scan.cloud.points.size());
  return scan;
}

std::string Error(const ScanSurface& surface, const ScanOptions& options) {
  Scan scan;
  std::string error;
  EXPECT_FALSE(SimulateScan(surface, {}, options, &scan, &error));
  EXPECT_TRUE(scan.cloud.empty());
  return error;
}

bool IsSame(const PointCloud& a, const PointCloud& b) {
  const auto same = [](const std::vector<Vector3d>& p, const std::vector<Vector3d>& q) {
    return p.size() == q.size() &&
           (p.empty() || std::memcmp(p.data(), q.data(), p.size() * sizeof(p[0])) == 0);
  };
  return same(a.points, b.points) && same(a.normals, b.normals);
}

// Exactly a sphere.
ScanSurface Sphere(double radius, int frequency = 16) {
  ScanSurface sphere;
  sphere.mesh = MakeIcosphere(radius, frequency);
  const TriangleMesh mesh = sphere.mesh;
  sphere.evaluate = [mesh, radius](int t, double b1, double b2) {
    const auto corner = [&](std::size_t k) {
      return mesh
          .vertices[static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(t)][k])];
    };
    const Vector3d x = corner(0) + b1 * (corner(1) - corner(0)) + b2 * (corner(2) - corner(0));
    return FacePoint{radius * x.normalized(), x.normalized()};
  };
  return sphere;
}

// The square |x|, |y| <= half_size at the height z, facing up or down.
void AddSquare(double half_size, double z, bool up, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  for (const double y : {-half_size, half_size}) {
    for (const double x : {-half_size, half_size}) mesh->vertices.emplace_back(x, y, z);
  }
  for (const std::array<int, 3>& t : {std::array<int, 3>{0, 1, 3}, std::array<int, 3>{0, 3, 2}}) {
    mesh->triangles.push_back(
        {first + t[0], first + (up ? t[1] : t[2]), first + (up ? t[2] : t[1])});
  }
}

ScanSurface Square(double half_size) {
  ScanSurface square;
  AddSquare(half_size, 0.0, true, &square.mesh);
  return square;
}

// Away from the viewpoint it was measured from.
Vector3d Ray(const ScanTruth& truth, const ScanOptions& options) {
  return (truth.face.position - options.viewpoints[static_cast<std::size_t>(truth.view)])
      .normalized();
}

// --- Where points lie
// -----------------------------------------------------------------------------

TEST(ScanSimulatorTest, WithoutNoisePointsLieOnTheOuterFaceOfTheExactSurface) {
  ParameterDomain::Options domain;
  domain.u_range = {0.0, 2.0};
  domain.v_range = {0.0, 2.0 * M_PI};
  domain.divisions = {4, 9};
  domain.periodic = {false, true};
  const ShellSurface tube(MakeCylinder(0.7), domain);
  // Moved as a whole.
  const Vector3d shift(0.3, -0.2, 0.1);
  Eigen::Matrix3Xd displacements(3, tube.mesh().num_vertices);
  displacements.colwise() = shift;
  const ScanSurface face = ScanSurfaceOf(tube, displacements, 0.05);
  ScanOptions options;
  options.num_points = 2000;
  options.viewpoints = ViewpointsAround(face, 8, 5.0);
  const Scan scan = Simulate(face, options);
  ASSERT_EQ(scan.cloud.points.size(), 2000u);
  const double size = tube.size();
  for (std::size_t i = 0; i < scan.cloud.points.size(); ++i) {
    const Vector3d x = scan.model_from_scan * scan.cloud.points[i] - shift;
    EXPECT_NEAR(std::hypot(x.y(), x.z()), 0.75, 1e-12 * size);
    const Vector3d n = scan.model_from_scan.rotation * scan.cloud.normals[i];
    EXPECT_NEAR(n.dot(Vector3d(0, x.y(), x.z())), 0.75, 1e-12);
  }
}

TEST(ScanSimulatorTest, ADisplacedMeshIsScannedAsTheMeshOfTheDisplacedPoints) {
  TriangleMesh mesh = MakeIcosphere(1.0, 3);
  const ShellSurface rest(MakeLoopMesh(mesh));
  Eigen::Matrix3Xd displacements(3, rest.mesh().num_vertices);
  for (int v = 0; v < displacements.cols(); ++v) {
    const Vector3d x = rest.control_points().col(v);
    displacements.col(v) = Vector3d(0.2 * x.z() * x.z(), -0.1 * x.x(), 0.3 * x.y() * x.x());
  }
  LoopMesh loop = MakeLoopMesh(mesh);
  loop.points += displacements;
  const ShellSurface moved(loop);
  ScanOptions options;
  options.num_points = 1000;
  options.noise = 0.01;
  const ScanSurface a = ScanSurfaceOf(rest, displacements, 0.05);
  const ScanSurface b =
      ScanSurfaceOf(moved, Eigen::Matrix3Xd::Zero(3, moved.mesh().num_vertices), 0.05);
  options.viewpoints = ViewpointsAround(a, 6, 4.0);
  const Scan first = Simulate(a, options), second = Simulate(b, options);
  ASSERT_EQ(first.cloud.points.size(), second.cloud.points.size());
  for (std::size_t i = 0; i < first.cloud.points.size(); ++i) {
    EXPECT_LT((first.cloud.points[i] - second.cloud.points[i]).norm(), 1e-12);
  }
}

TEST(ScanSimulatorTest, PointsAreUniformByArea) {
  ScanOptions options;
  options.num_points = 20000;
  options.moves = false;
  const Scan scan = Simulate(Sphere(2.0, 6), options);
  // Archimedes: z is uniform. Twenty bands and six longitudes; 99.9 % of chi squared with 119
  // degrees of freedom is 173.
  std::vector<int> counts(120, 0);
  for (const Vector3d& x : scan.cloud.points) {
    const int band = std::min(19, static_cast<int>((x.z() / 2.0 + 1.0) * 10.0));
    const int sector = std::min(5, static_cast<int>((std::atan2(x.y(), x.x()) / M_PI + 1.0) * 3.0));
    ++counts[static_cast<std::size_t>(6 * band + sector)];
  }
  double chi2 = 0.0;
  const double expected = 20000.0 / 120.0;
  for (const int count : counts) chi2 += std::pow(count - expected, 2) / expected;
  EXPECT_LT(chi2, 173.0);
  // An element of the Loop surface is cut finely enough.
  const ShellSurface sphere(MakeLoopMesh(MakeIcosphere(1.0, 2)));
  const ScanSurface face =
      ScanSurfaceOf(sphere, Eigen::Matrix3Xd::Zero(3, sphere.mesh().num_vertices), 0.1);
  std::vector<int> octants(8, 0);
  for (const Vector3d& x : Simulate(face, options).cloud.points) {
    ++octants[static_cast<std::size_t>((x.x() > 0) + 2 * (x.y() > 0) + 4 * (x.z() > 0))];
  }
  chi2 = 0.0;
  for (const int count : octants) chi2 += std::pow(count - 2500.0, 2) / 2500.0;
  EXPECT_LT(chi2, 24.3);
}

TEST(ScanSimulatorTest, AMiddleSurfaceIsOffsetAlongItsNormals) {
  const TriangleMesh mesh = MakeIcosphere(1.0, 8);
  ScanSurface face = ScanSurfaceOf(mesh, {}, 0.1);
  ScanVertices(&face);
  ScanOptions options;
  options.moves = false;
  const Scan scan = Simulate(face, options);
  ASSERT_EQ(scan.cloud.points.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_NEAR(scan.cloud.points[i].norm(), 1.1, 1e-12);
  }
  face = ScanSurfaceOf(mesh, mesh.vertices, 0.1);  // Normals of the file.
  EXPECT_LT((face.mesh.vertices[5] - 1.1 * mesh.vertices[5]).norm(), 1e-14);
}

// --- What is seen
// ---------------------------------------------------------------------------------

TEST(ScanSimulatorTest, OneViewpointSeesACapOfASphereUpToTheGrazingAngle) {
  ScanOptions options;
  options.num_points = 20000;
  options.moves = false;
  for (const double grazing : {30.0, 75.0, 90.0}) {
    options.grazing_deg = grazing;
    options.viewpoints = {{0, 0, 3}};
    const Scan scan = Simulate(Sphere(1.0), options);
    // In the triangle centre, point, viewpoint: law of sines.
    const double alpha = grazing * M_PI / 180.0;
    const double cap = std::cos(alpha - std::asin(std::sin(alpha) / 3.0));
    double lowest = 1.0;
    for (const Vector3d& x : scan.cloud.points) lowest = std::min(lowest, x.z());
    EXPECT_GE(lowest, cap - 1e-12);
    EXPECT_LT(lowest, cap + 1e-3);
    const double part = 0.5 * (1.0 - cap), n = scan.num_tried;
    EXPECT_NEAR(20000.0 / n, part, 4.0 * std::sqrt(part * (1.0 - part) / n));
  }
}

TEST(ScanSimulatorTest, EveryPointIsMeasuredFromTheViewpointThatSeesItBest) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options;
  options.num_points = 2000;
  for (const int count : {1, 5, 6, 8, 12}) {
    options.viewpoints = ViewpointsAround(sphere, count, 5.0);
    ASSERT_EQ(static_cast<int>(options.viewpoints.size()), count);
    const double radius = Extent(sphere.mesh.vertices) / 2.0;
    for (const Vector3d& viewpoint : options.viewpoints) {
      EXPECT_NEAR(viewpoint.norm(), 5.0 * radius, 1e-12);
    }
    for (const ScanTruth& truth : Simulate(sphere, options).truth) {
      for (const Vector3d& other : options.viewpoints) {
        EXPECT_LE(truth.face.normal.dot((other - truth.face.position).normalized()),
                  -truth.face.normal.dot(Ray(truth, options)) + 1e-12);
      }
    }
  }
}

TEST(ScanSimulatorTest, WhatLiesBehindAnotherPartIsHiddenWhicheverWayThatFaces) {
  for (const bool up : {true, false}) {
    ScanSurface two = Square(1.0);
    AddSquare(0.5, 0.8, up, &two.mesh);
    ScanOptions options;
    options.num_points = 5000;
    options.moves = false;
    options.viewpoints = {{0, 0, 4}};
    // The upper square hides 0.5 * 4 / 3.2 = 0.625 of the lower one.
    int lower = 0;
    for (const Vector3d& x : Simulate(two, options).cloud.points) {
      if (x.z() > 0.4) continue;
      ++lower;
      EXPECT_GE(std::max(std::abs(x.x()), std::abs(x.y())), 0.625 - 1e-9);
    }
    const double area = 4.0 - 4.0 * 0.625 * 0.625;
    const double part = up ? area / (area + 1.0) : 1.0;
    EXPECT_NEAR(lower / 5000.0, part, 4.0 * std::sqrt(part * (1.0 - part) / 5000.0));
  }
}

// The segment from a point to a viewpoint against every triangle.
bool IsHiddenByBruteForce(const TriangleMesh& mesh, const Vector3d& x, const Vector3d& eye) {
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[static_cast<std::size_t>(t[0])] - x;
    const Vector3d b = mesh.vertices[static_cast<std::size_t>(t[1])] - x;
    const Vector3d c = mesh.vertices[static_cast<std::size_t>(t[2])] - x;
    const Vector3d d = eye - x, n = (b - a).cross(c - a);
    // Signed volumes: the line passes through the triangle, from outside to inside.
    const double u = d.dot(a.cross(b)), v = d.dot(b.cross(c)), w = d.dot(c.cross(a));
    const bool in = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const double at = n.dot(a) / n.dot(d);
    if (in && n.dot(d) < 0.0 && at > 1e-9 && at < 1.0) return true;
  }
  return false;
}

TEST(ScanSimulatorTest, TheTreeFindsWhatEveryTriangleHides) {
  ScanSurface torus;
  torus.mesh = Torus(40, 24);
  ScanOptions options;
  options.num_points = 800;
  options.moves = false;
  options.grazing_deg = 90.0;
  options.viewpoints = {{9, 2, 2}};
  const Scan scan = Simulate(torus, options);
  for (const ScanTruth& truth : scan.truth) {
    EXPECT_FALSE(IsHiddenByBruteForce(torus.mesh, truth.face.position, options.viewpoints[0]));
  }
  // And nothing else: all points that face the viewpoint, with and without the torus in between.
  ScanOptions all = options;
  all.viewpoints.clear();
  int facing = 0, hidden = 0;
  for (const ScanTruth& truth : Simulate(torus, all).truth) {
    ScanSurface one = torus;
    one.points = {truth.face};
    const Vector3d ray = options.viewpoints[0] - truth.face.position;
    if (truth.face.normal.dot(ray) <= 0.0) continue;
    ++facing;
    const bool is_hidden =
        IsHiddenByBruteForce(torus.mesh, truth.face.position, options.viewpoints[0]);
    hidden += is_hidden ? 1 : 0;
    Scan seen;
    std::string error;
    EXPECT_EQ(SimulateScan(one, {}, options, &seen, &error), !is_hidden);
  }
  EXPECT_GT(facing, 300);
  EXPECT_GT(hidden, 30);
}

TEST(ScanSimulatorTest, TheFacetsOfACurvedFaceDoNotHideIt) {
  // Inside and outside of a tube: the facets lie beneath the one and above the other.
  ParameterDomain::Options domain;
  domain.u_range = {0.0, 1.0};
  domain.v_range = {0.0, M_PI};
  domain.divisions = {2, 4};
  const ShellSurface half_tube(MakeCylinder(1.0), domain);
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, half_tube.mesh().num_vertices);
  ScanOptions options;
  options.num_points = 2000;
  options.moves = false;
  options.grazing_deg = 90.0;
  const ScanSurface outside = ScanSurfaceOf(half_tube, rest, 0.0, 1);
  options.viewpoints = {{0.5, 100, 0}};
  Scan scan = Simulate(outside, options);
  EXPECT_NEAR(2000.0 / scan.num_tried, 0.5 + 0.5 * 0.99, 0.02);  // All but the ends.
  ScanSurface inside = outside;
  for (std::array<int, 3>& t : inside.mesh.triangles) std::swap(t[1], t[2]);
  inside.evaluate = [outside](int t, double b1, double b2) {
    FacePoint point = outside.evaluate(t, b2, b1);
    point.normal = -point.normal;
    return point;
  };
  options.viewpoints = {{0.5, -100, 0}};
  scan = Simulate(inside, options);
  EXPECT_NEAR(2000.0 / scan.num_tried, 1.0, 0.02);
}

// --- Fingers
// --------------------------------------------------------------------------------------

TEST(ScanSimulatorTest, AFingerHidesExactlyTheDiscThatItCovers) {
  // A ball at the height 0.5 above a plate, seen from 4: the shadow is the disc in the cone
  // around the ball.
  const Occluder ball = {MakeSphereFinger(0.3), {Vector3d(0, 0, 0.5), Eigen::Matrix3d::Identity()}};
  const double sine = 0.3 / 3.5, radius = 4.0 * sine / std::sqrt(1.0 - sine * sine);
  ScanOptions options;
  options.num_points = 20000;
  options.moves = false;
  options.viewpoints = {{0, 0, 4}};
  const Scan scan = Simulate(Square(1.0), options, {ball});
  double nearest = 1.0;
  for (const Vector3d& x : scan.cloud.points) nearest = std::min(nearest, x.norm());
  EXPECT_GE(nearest, radius - 1e-9);
  EXPECT_LT(nearest, radius + 5e-3);
  const double part = 1.0 - M_PI * radius * radius / 4.0, n = scan.num_tried;
  EXPECT_NEAR(20000.0 / n, part, 4.0 * std::sqrt(part * (1.0 - part) / n));
  for (int k = 0; k < 12; ++k) {
    const Vector3d x(radius * std::cos(k), radius * std::sin(k), 0.0);
    EXPECT_TRUE(CutsSegment(ball, x * (1.0 - 1e-8), {0, 0, 4}, 1.0));
    EXPECT_FALSE(CutsSegment(ball, x * (1.0 + 1e-8), {0, 0, 4}, 1.0));
  }
  // A finger beyond the viewpoint or below the plate hides nothing.
  EXPECT_FALSE(CutsSegment(ball, {0, 0, 1}, {0, 0, 4}, 1.0));
  EXPECT_FALSE(CutsSegment(ball, {0, 0, -1}, {0, 0, 0.1}, 1.0));
}

TEST(ScanSimulatorTest, PointsInContactAreHiddenAndThoseBesideAreNot) {
  // A flat face pressed against a half space above it, x < 0.
  const Occluder table = {MakePlaneFinger(),
                          {Vector3d::Zero(),
                           Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d::UnitX())
                               .toRotationMatrix()}};
  EXPECT_TRUE(CutsSegment(table, {-1e-7, 0, 0}, {1, 0, 1}, 1.0));  // Inside.
  EXPECT_TRUE(CutsSegment(table, {1e-3, 0, 0}, {-1, 0, 1}, 1.0));
  EXPECT_FALSE(CutsSegment(table, {1e-12, 0, 0}, {1, 0, 1}, 1.0));    // Touches, and away.
  EXPECT_FALSE(CutsSegment(table, {1e-3, 0, 0}, {1e-3, 5, 9}, 1.0));  // Along it.
}

TEST(ScanSimulatorTest, BodiesOfAllShapesCutTheSegmentsThatEnterThem) {
  std::string error;
  TriangleMesh torus = Torus(24, 12, 0.6, 0.25);  // Not convex.
  const std::vector<std::shared_ptr<const FingerShape>> shapes = {
      MakeSphereFinger(0.5),
      MakeCapsuleFinger(0.3, 0.8),
      MakeBoxFinger({0.5, 0.3, 0.4}, 0.1),
      MakeBoxFinger({0.5, 0.3, 0.4}, 0.0),
      MakePlaneFinger(),
      MakeMeshFinger(torus, &error)};
  std::mt19937_64 random(5);
  const auto uniform = [&] { return 2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0; };
  for (const auto& shape : shapes) {
    ASSERT_NE(shape, nullptr) << error;
    int cuts = 0;
    for (int i = 0; i < 400; ++i) {
      const Occluder body = {
          shape,
          {0.5 * Vector3d(uniform(), uniform(), uniform()),
           Eigen::AngleAxisd(3.0 * uniform(), Vector3d(1, 2, 3).normalized()).toRotationMatrix()}};
      const Vector3d from(2 * uniform(), 2 * uniform(), 2 * uniform());
      const Vector3d to = -from + 0.5 * Vector3d(uniform(), uniform(), uniform());
      double least = std::numeric_limits<double>::infinity();
      constexpr int kSteps = 400;
      for (int k = 0; k <= kSteps; ++k) {
        Distance distance;
        body.pose.Evaluate(*shape, from + (to - from) * (1.0 * k / kSteps), &distance);
        least = std::min(least, distance.value);
      }
      const double step = (to - from).norm() / kSteps;
      const bool is_cut = CutsSegment(body, from, to, 1.0);
      cuts += is_cut ? 1 : 0;
      if (least < -1e-9) {
        EXPECT_TRUE(is_cut) << least;
      } else if (least > step) {
        EXPECT_FALSE(is_cut) << least;
      }
    }
    EXPECT_GT(cuts, 40);
    EXPECT_LT(cuts, 400);
  }
}

// --- What is added
// --------------------------------------------------------------------------------

TEST(ScanSimulatorTest, NoiseIsGaussianAlongTheRay) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options;
  options.noise = 0.004;
  options.viewpoints = ViewpointsAround(sphere, 8, 5.0);
  const Scan scan = Simulate(sphere, options);
  double sum = 0.0, squares = 0.0, within = 0.0, products = 0.0, last = 0.0;
  const double n = static_cast<double>(scan.truth.size());
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    const Vector3d ray = Ray(scan.truth[i], options);
    const Vector3d d = scan.model_from_scan * scan.cloud.points[i] - scan.truth[i].face.position;
    const double along = d.dot(ray);
    ASSERT_LT((d - along * ray).norm(), 1e-12);
    ASSERT_NEAR(along, scan.truth[i].noise, 1e-12);
    const double z = along / options.noise;
    sum += z;
    squares += z * z;
    within += std::abs(z) < 1.0 ? 1.0 : 0.0;
    products += z * last;
    last = z;
  }
  // Chi squared with n degrees of freedom, four standard deviations.
  EXPECT_NEAR(squares, n, 4.0 * std::sqrt(2.0 * n));
  EXPECT_NEAR(sum, 0.0, 4.0 * std::sqrt(n));
  EXPECT_NEAR(products, 0.0, 4.0 * std::sqrt(n));
  const double p = std::erf(std::sqrt(0.5));
  EXPECT_NEAR(within, n * p, 4.0 * std::sqrt(n * p * (1.0 - p)));
}

TEST(ScanSimulatorTest, ExactlyTheAskedPartOfThePointsIsWrong) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options;
  options.num_points = 5000;
  options.viewpoints = ViewpointsAround(sphere, 6, 5.0);
  options.outliers = 0.031;
  options.spike_share = 0.4;
  options.spike_size = 0.1;
  options.outlier_box = 2.0;
  const Scan scan = Simulate(sphere, options);
  EXPECT_EQ(scan.num_spikes, 62);
  EXPECT_EQ(scan.num_strays, 93);
  int spikes = 0, strays = 0, away = 0;
  double longest = 0.0, farthest = 0.0;
  const double extent = Extent(sphere.mesh.vertices);
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    const ScanTruth& truth = scan.truth[i];
    const Vector3d x = scan.model_from_scan * scan.cloud.points[i];
    const Vector3d d = x - truth.face.position;
    switch (truth.outlier) {
      case OutlierKind::kNone:
        EXPECT_LT(d.norm(), 1e-12);
        break;
      case OutlierKind::kSpike: {
        ++spikes;
        const Vector3d ray = Ray(truth, options);
        EXPECT_LT((d - d.dot(ray) * ray).norm(), 1e-12);
        EXPECT_LE(d.norm(), 0.1 * extent + 1e-12);
        longest = std::max(longest, d.norm());
        away += d.dot(ray) > 0.0 ? 1 : 0;
        EXPECT_NEAR(truth.face.position.norm(), 1.0, 1e-12);
        break;
      }
      case OutlierKind::kStray:
        ++strays;
        EXPECT_LT(d.norm(), 1e-12);
        EXPECT_EQ(truth.view, -1);
        EXPECT_LE(x.lpNorm<Eigen::Infinity>(), 2.0 + 1e-12);
        farthest = std::max(farthest, x.lpNorm<Eigen::Infinity>());
        break;
    }
  }
  EXPECT_EQ(spikes, 62);
  EXPECT_EQ(strays, 93);
  EXPECT_GT(longest, 0.08 * extent);
  EXPECT_GT(farthest, 1.8);
  EXPECT_NEAR(away, 31, 4.0 * std::sqrt(62 * 0.25));
}

TEST(ScanSimulatorTest, TheBiasIsSmoothAndHasTheSizeAsked) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options;
  options.num_points = 4000;
  options.viewpoints = ViewpointsAround(sphere, 8, 5.0);
  options.bias = 0.02;
  options.bias_length = 0.15;
  for (const bool along_ray : {false, true}) {
    options.bias_along_ray = along_ray;
    const Scan scan = Simulate(sphere, options);
    double squares = 0.0;
    for (std::size_t i = 0; i < scan.truth.size(); ++i) {
      const ScanTruth& truth = scan.truth[i];
      const Vector3d direction = along_ray ? Ray(truth, options) : truth.face.normal;
      const Vector3d d = scan.model_from_scan * scan.cloud.points[i] - truth.face.position;
      EXPECT_LT((d - truth.bias * direction).norm(), 1e-12);
      squares += truth.bias * truth.bias;
    }
    EXPECT_NEAR(std::sqrt(squares / 4000.0), 0.02, 1e-12);
    // Correlation by distance, over all pairs: exp(-r^2 / (2 length^2)) within what a field of some
    // hundred independent patches leaves open.
    std::vector<double> products(8, 0.0), expected(8, 0.0);
    std::vector<int> counts(8, 0);
    for (std::size_t i = 0; i < scan.truth.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double r = (scan.truth[i].face.position - scan.truth[j].face.position).norm() / 0.15;
        if (r >= 4.0) continue;
        const auto bin = static_cast<std::size_t>(2.0 * r);
        ++counts[bin];
        products[bin] += scan.truth[i].bias * scan.truth[j].bias / (0.02 * 0.02);
        expected[bin] += std::exp(-0.5 * r * r);
      }
    }
    for (std::size_t bin = 0; bin < 8; ++bin) {
      EXPECT_NEAR(products[bin] / counts[bin], expected[bin] / counts[bin], 0.15) << bin;
    }
    EXPECT_GT(products[0] / counts[0], 0.85);
  }
}

// --- Frames, seeds, units
// ---------------------------------------------------------------------------

TEST(ScanSimulatorTest, TheInverseMotionBringsTheScanBack) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options;
  options.num_points = 100;
  options.max_angle_deg = 20.0;
  options.max_translation = 0.1;
  double largest_angle = 0.0, largest_shift = 0.0;
  const double extent = Extent(sphere.mesh.vertices);
  for (int seed = 1; seed <= 60; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const Scan scan = Simulate(sphere, options);
    for (std::size_t i = 0; i < 100; ++i) {
      EXPECT_LT((scan.model_from_scan * scan.cloud.points[i] - scan.truth[i].face.position).norm(),
                1e-13);
    }
    const double angle = Eigen::AngleAxisd(scan.model_from_scan.rotation).angle() * 180.0 / M_PI;
    EXPECT_LE(angle, 20.0 + 1e-9);
    largest_angle = std::max(largest_angle, angle);
    const double shift = scan.model_from_scan.Inverse().translation.norm();  // The centre is 0.
    EXPECT_LE(shift, 0.1 * extent + 1e-12);
    largest_shift = std::max(largest_shift, shift);
  }
  EXPECT_GT(largest_angle, 18.0);
  EXPECT_GT(largest_shift, 0.09 * extent);
  options.moves = false;
  const Scan still = Simulate(sphere, options);
  EXPECT_EQ(still.model_from_scan.translation, Vector3d::Zero());
  EXPECT_EQ(still.model_from_scan.rotation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  EXPECT_EQ(still.cloud.points[7], still.truth[7].face.position);
}

ScanOptions Everything(const ScanSurface& surface) {
  ScanOptions options;
  options.num_points = 1500;
  options.viewpoints = ViewpointsAround(surface, 8, 5.0);
  options.noise = 0.003;
  options.bias = 0.01;
  options.outliers = 0.02;
  return options;
}

TEST(ScanSimulatorTest, ASeedGivesTheSameScanAndAnotherOneAnother) {
  const ScanSurface sphere = Sphere(1.0);
  ScanOptions options = Everything(sphere);
  const Scan scan = Simulate(sphere, options);
  EXPECT_TRUE(IsSame(scan.cloud, Simulate(sphere, options).cloud));
  // Outliers are other points; what is not wrong stays bit for bit, however many there are.
  options.outliers = 0.0;
  const Scan right = Simulate(sphere, options);
  int same = 0;
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    if (scan.truth[i].outlier != OutlierKind::kNone) continue;
    ++same;
    EXPECT_EQ(scan.cloud.points[i], right.cloud.points[i]);
  }
  EXPECT_EQ(same, 1470);
  options.seed = 2;
  const Scan other = Simulate(sphere, options);
  EXPECT_NE(other.cloud.points[0], right.cloud.points[0]);
  EXPECT_NE(other.truth[0].face.position, right.truth[0].face.position);
  EXPECT_NE(other.truth[0].noise, right.truth[0].noise);
  EXPECT_NE(other.model_from_scan.translation, right.model_from_scan.translation);
}

TEST(ScanSimulatorTest, MillimetresGiveTheScanInMetres) {
  const Occluder ball = {MakeSphereFinger(0.3), {Vector3d(0, 0, 1.2), Eigen::Matrix3d::Identity()}};
  const Occluder ball_mm = {MakeSphereFinger(300.0),
                            {Vector3d(0, 0, 1200), Eigen::Matrix3d::Identity()}};
  const ScanSurface metres = Sphere(1.0), millimetres = Sphere(1000.0);
  ScanOptions options = Everything(metres), options_mm = Everything(millimetres);
  options_mm.noise *= 1000.0;
  options_mm.bias *= 1000.0;
  const Scan a = Simulate(metres, options, {ball});
  const Scan b = Simulate(millimetres, options_mm, {ball_mm});
  ASSERT_EQ(a.cloud.points.size(), b.cloud.points.size());
  EXPECT_EQ(a.num_tried, b.num_tried);
  for (std::size_t i = 0; i < a.cloud.points.size(); ++i) {
    EXPECT_LT((a.cloud.points[i] - b.cloud.points[i] / 1000.0).norm(), 1e-9);
    EXPECT_EQ(a.truth[i].view, b.truth[i].view);
    EXPECT_EQ(a.truth[i].outlier, b.truth[i].outlier);
  }
}

// --- Given points and errors
// ------------------------------------------------------------------------

TEST(ScanSimulatorTest, GivenPointsAreScannedWithOrWithoutNormals) {
  ScanSurface points;
  for (const Vector3d& x : MakeIcosphere(1.0, 8).vertices) points.points.push_back({x, x});
  ScanOptions options;
  options.moves = false;
  options.viewpoints = {{0, 0, 5}};
  Scan scan = Simulate(points, options);
  EXPECT_LT(scan.cloud.points.size(), points.points.size() / 2);
  EXPECT_EQ(scan.num_tried, static_cast<int>(points.points.size()));
  for (const Vector3d& x : scan.cloud.points) EXPECT_GT(x.z(), 0.2);
  const std::size_t seen = scan.cloud.points.size();
  // A part of them, in their order.
  options.num_points = 50;
  const Scan part = Simulate(points, options);
  ASSERT_EQ(part.cloud.points.size(), 50u);
  std::size_t at = 0;
  for (const Vector3d& x : part.cloud.points) {
    while (at < seen && scan.cloud.points[at] != x) ++at;
    ASSERT_LT(at++, seen);
  }
  // Without normals nothing turns away, and points belong to the nearest viewpoint.
  options.num_points = 100000;
  for (FacePoint& point : points.points) point.normal.setZero();
  options.viewpoints = {{0, 0, 5}, {0, 0, -5}};
  scan = Simulate(points, options);
  EXPECT_EQ(scan.cloud.points.size(), points.points.size());
  EXPECT_TRUE(scan.cloud.normals.empty());
  for (const ScanTruth& truth : scan.truth) {
    if (std::abs(truth.face.position.z()) < 1e-9) continue;
    EXPECT_EQ(truth.view, truth.face.position.z() > 0.0 ? 0 : 1);
  }
  options.bias = 0.1;
  EXPECT_THAT(Error(points, options),
              HasSubstr("found a bias along normals of points without any"));
  options.viewpoints.clear();
  options.noise = 0.1;
  EXPECT_THAT(Error(points, options), HasSubstr("found points without normals and no viewpoints"));
}

TEST(ScanSimulatorTest, WithoutViewpointsNoiseIsAlongTheNormal) {
  ScanOptions options;
  options.num_points = 500;
  options.noise = 0.1;
  const Scan scan = Simulate(Sphere(1.0), options);
  EXPECT_EQ(scan.num_tried, 500);
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    EXPECT_EQ(scan.truth[i].view, -1);
    const Vector3d x = scan.model_from_scan * scan.cloud.points[i];
    EXPECT_LT((x - (1.0 + scan.truth[i].noise) * scan.truth[i].face.position).norm(), 1e-12);
  }
}

TEST(ScanSimulatorTest, WhatCannotBeScannedIsAnError) {
  ScanOptions options;
  EXPECT_THAT(Error(ScanSurface(), options), HasSubstr("found nothing to scan"));
  ScanSurface flat;
  flat.mesh.vertices.assign(3, Vector3d(1, 1, 1));
  flat.mesh.triangles = {{0, 1, 2}};
  EXPECT_THAT(Error(flat, options), HasSubstr("found a surface without any extent"));
  flat.mesh.vertices[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Error(flat, options), HasSubstr("found a surface without any extent"));
  options.num_points = 10;
  options.viewpoints = {{0, 0, -5}};
  EXPECT_EQ(Error(Square(1.0), options),
            "found only 0 of 3000 random points that can be seen; allowed 1 in 200");
}

TEST(ScanSimulatorTest, BadOptionsAreNamed) {
  struct Case {
    std::string begin;
    void (*set)(ScanOptions*);
  };
  const std::vector<Case> cases = {
      {"num_points: found 0; allowed", [](ScanOptions* o) { o->num_points = 0; }},
      {"grazing_deg: found 91; allowed", [](ScanOptions* o) { o->grazing_deg = 91; }},
      {"grazing_deg: found 0; allowed", [](ScanOptions* o) { o->grazing_deg = 0; }},
      {"noise: found -1; allowed", [](ScanOptions* o) { o->noise = -1; }},
      {"noise: found nan; allowed", [](ScanOptions* o) { o->noise = NAN; }},
      {"noise: found inf; allowed", [](ScanOptions* o) { o->noise = INFINITY; }},
      {"bias: found -1; allowed", [](ScanOptions* o) { o->bias = -1; }},
      {"bias_length: found -1; allowed", [](ScanOptions* o) { o->bias_length = -1; }},
      {"outliers: found 1.5; allowed", [](ScanOptions* o) { o->outliers = 1.5; }},
      {"spike_share: found 2; allowed", [](ScanOptions* o) { o->spike_share = 2; }},
      {"spike_size: found -1; allowed", [](ScanOptions* o) { o->spike_size = -1; }},
      {"outlier_box: found -1; allowed", [](ScanOptions* o) { o->outlier_box = -1; }},
      {"max_angle_deg: found 181; allowed", [](ScanOptions* o) { o->max_angle_deg = 181; }},
      {"max_translation: found -1; allowed", [](ScanOptions* o) { o->max_translation = -1; }},
      {"viewpoints: found nan; allowed", [](ScanOptions* o) {
         o->viewpoints = {{0, 0, INFINITY}};
       }}};
  for (const Case& bad : cases) {
    ScanOptions options;
    std::string error;
    EXPECT_TRUE(options.IsValid(&error));
    bad.set(&options);
    EXPECT_FALSE(options.IsValid(&error));
    EXPECT_EQ(error.substr(0, bad.begin.size()), bad.begin);
    EXPECT_EQ(Error(Sphere(1.0, 2), options), error);
  }
}

}  // namespace
}  // namespace darboux
