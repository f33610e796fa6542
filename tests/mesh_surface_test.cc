// ShellSurface of a LoopMesh.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/loop_mesh.h"
#include "geometry/shell_surface.h"
#include "tests/mesh_util.h"

namespace darboux {
namespace {

ShellSurface Through(const TriangleMesh& mesh) {
  LoopMesh loop = MakeLoopMesh(mesh);
  EXPECT_TRUE(InterpolatePoints(&loop));
  return ShellSurface(std::move(loop));
}

ShellSurface Sphere(double radius, int frequency) {
  TriangleMesh mesh = MakeIcosphere(radius, frequency);
  SmoothOnSphere(10, &mesh);
  return Through(mesh);
}

// Bumps without symmetry, valences 5 and 6.
ShellSurface Pebble() {
  TriangleMesh mesh = MakeIcosphere(1.0, 4);
  for (Eigen::Vector3d& x : mesh.vertices) {
    x *= 1.0 + 0.2 * std::sin(3.0 * x.x() + 1.0) * std::cos(2.0 * x.y() - x.z());
    x.z() *= 0.7;
  }
  return ShellSurface(MakeLoopMesh(mesh));
}

// A wavy annulus.
ShellSurface WavyAnnulus() {
  TriangleMesh mesh = Annulus(14, 4);
  for (Eigen::Vector3d& x : mesh.vertices) x.z() = 0.3 * std::sin(2.0 * x.x() + x.y());
  return ShellSurface(MakeLoopMesh(mesh));
}

ElementPoint RandomElementPoint(const ShellSurface& surface, std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const int e = std::uniform_int_distribution<int>(0, surface.num_elements() - 1)(*gen);
  double s = uniform(*gen), t = uniform(*gen);
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  return {e, s, t};
}

void ForEachPoint(const ShellSurface& surface,
                  int num_points,
                  const std::function<void(int, const StrainPoint&)>& use) {
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (const StrainPoint& point : surface.QuadraturePoints(e, num_points)) use(e, point);
  }
}

// Relative errors of a sphere.
struct SphereErrors {
  double area = 0.0, volume = 0.0, curvature = 0.0;
};

SphereErrors ErrorsOfSphere(double radius, int frequency) {
  const ShellSurface sphere = Sphere(radius, frequency);
  double area = 0.0, volume = 0.0, curvature = 0.0;
  ForEachPoint(sphere, 6, [&](int, const StrainPoint& point) {
    area += point.area;
    volume += point.area * point.position.dot(point.n) / 3.0;
    curvature += point.area * 0.5 * (point.b11 + point.b22);
  });
  return {area / (4.0 * M_PI * radius * radius) - 1.0,
          volume / (4.0 / 3.0 * M_PI * std::pow(radius, 3)) - 1.0,
          curvature / area * -radius - 1.0};
}

// To fourth order. The curvature sigma_,ij . n is negative where the surface bends away from its
// normal.
TEST(MeshSphereTest, AreaVolumeAndCurvatureConverge) {
  const SphereErrors coarse = ErrorsOfSphere(2.5, 6), fine = ErrorsOfSphere(2.5, 12);
  EXPECT_LT(std::abs(coarse.area), 4e-5);
  EXPECT_LT(std::abs(coarse.volume), 6e-5);
  EXPECT_LT(std::abs(coarse.curvature), 2e-5);
  EXPECT_LT(std::abs(fine.area), std::abs(coarse.area) / 14.0);
  EXPECT_LT(std::abs(fine.volume), std::abs(coarse.volume) / 14.0);
  EXPECT_LT(std::abs(fine.curvature), std::abs(coarse.curvature) / 14.0);
}

TEST(MeshSphereTest, NormalsPointOutwards) {
  ForEachPoint(Sphere(2.5, 6), 3, [](int, const StrainPoint& point) {
    EXPECT_GT(point.n.dot(point.position.normalized()), 0.9999);
  });
}

TEST(MeshSphereTest, AreaPointsAreThoseOfStrainPoints) {
  const ShellSurface pebble = Pebble();
  for (const int n : {1, 3, 6, 12}) {
    for (int e = 0; e < pebble.num_elements(); e += 7) {
      const std::vector<StrainPoint> points = pebble.QuadraturePoints(e, n);
      size_t k = 0;
      pebble.ForEachAreaPoint(e, n, [&](const ShellSurface::AreaPoint& at) {
        ASSERT_LT(k, points.size());
        EXPECT_LT((at.position - points[k].position).norm(), 1e-14);
        EXPECT_LT((at.n - points[k].n).norm(), 1e-13);
        EXPECT_NEAR(at.area, points[k].area, 1e-15);
        EXPECT_LT((at.values - points[k].weights.row(kRowValue)).norm(), 1e-14);
        ++k;
      });
      EXPECT_EQ(k, points.size());
    }
  }
}

TEST(MeshRuleTest, WeightsAddUpToTheTriangle) {
  const ShellSurface pebble = Pebble();
  for (const int n : {1, 3, 6, 12}) {
    for (int e = 0; e < pebble.num_elements(); ++e) {
      double sum = 0.0, s = 0.0, t = 0.0;
      for (const TrianglePoint& p : pebble.Rule(e, n)) {
        EXPECT_TRUE(p.s > 0.0 && p.t > 0.0 && p.s + p.t < 1.0 && p.weight > 0.0);
        sum += p.weight;
        s += p.weight * p.s;
        t += p.weight * p.t;
      }
      EXPECT_NEAR(sum, 0.5, 1e-14);
      EXPECT_NEAR(s, 1.0 / 6.0, 1e-14);  // Linear functions are integrated exactly.
      EXPECT_NEAR(t, 1.0 / 6.0, 1e-14);
      const size_t parts = pebble.basis().IsRegular(e) ? 1 : 3 * ShellSurface::kRings + 1;
      EXPECT_EQ(pebble.Rule(e, n).size(), n * parts) << "one corner at most has valence 5";
    }
  }
}

class MeshWeightsTest : public ::testing::TestWithParam<bool> {
 protected:
  MeshWeightsTest() : surface_(GetParam() ? Pebble() : WavyAnnulus()) {}
  const ShellSurface surface_;
};
INSTANTIATE_TEST_SUITE_P(ClosedAndOpen, MeshWeightsTest, ::testing::Bool());

TEST_P(MeshWeightsTest, ReproducePositionsAndTheirDerivatives) {
  std::mt19937 gen(38403);
  for (int k = 0; k < 400; ++k) {
    const ElementPoint at = RandomElementPoint(surface_, &gen);
    const StrainPoint point = surface_.MakePoint(at, 0.25);
    const std::vector<int>& vertices = surface_.control_vertices(at.element);
    Eigen::Matrix3Xd x(3, vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
      x.col(i) = surface_.control_points().col(vertices[i]);
    }
    const auto& w = point.weights;
    const double h = w.row(kRowH11).norm();
    EXPECT_NEAR(w.row(kRowValue).sum(), 1.0, 1e-13);
    for (int row = kRowD1; row <= kRowH22; ++row)
      EXPECT_NEAR(w.row(row).sum(), 0.0, 1e-12 * (1 + h));
    EXPECT_LT((x * w.row(kRowValue).transpose() - surface_.Position(at)).norm(), 1e-14);
    EXPECT_LT((point.position - surface_.Position(at)).norm(), 1e-14);
    EXPECT_LT((surface_.ValueWeights(at).transpose() - w.row(kRowValue)).norm(), 1e-14);
    // The gradient of the position is the frame, its Hessian the curvature times the normal: linear
    // fields of x have what they should.
    EXPECT_LT((x * w.row(kRowD1).transpose() - point.t1).norm(), 1e-12);
    EXPECT_LT((x * w.row(kRowD2).transpose() - point.t2).norm(), 1e-12);
    EXPECT_LT((x * w.row(kRowH11).transpose() - point.b11 * point.n).norm(), 1e-12 * (1 + h));
    EXPECT_LT((x * w.row(kRowH12).transpose() - point.b12 * point.n).norm(), 1e-12 * (1 + h));
    EXPECT_LT((x * w.row(kRowH22).transpose() - point.b22 * point.n).norm(), 1e-12 * (1 + h));
    // An orthonormal frame.
    Eigen::Matrix3d frame;
    frame << point.t1, point.t2, point.n;
    EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-13);
    EXPECT_GT(frame.determinant(), 0.0);
  }
}

// A tangent: the position moves along t1 and not along n.
TEST_P(MeshWeightsTest, FrameIsTangentToTheSurface) {
  std::mt19937 gen(38404);
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 100; ++k) {
    ElementPoint at = RandomElementPoint(surface_, &gen);
    at.s = 0.1 + 0.7 * at.s, at.t = 0.1 + 0.7 * at.t;  // Steps stay within.
    const StrainPoint point = surface_.MakePoint(at);
    for (const auto& [ds, dt] : {std::make_pair(kStep, 0.0), std::make_pair(0.0, kStep)}) {
      const Eigen::Vector3d d = surface_.Position({at.element, at.s + ds, at.t + dt}) -
                                surface_.Position({at.element, at.s - ds, at.t - dt});
      EXPECT_LT(std::abs(d.dot(point.n)), 1e-8 * d.norm());
      EXPECT_LT((d.dot(point.t1) * point.t1 + d.dot(point.t2) * point.t2 - d).norm(),
                1e-7 * d.norm());
    }
  }
}

// Both elements at an edge see one surface: frame, curvature and weights.
TEST_P(MeshWeightsTest, AgreeAcrossEdges) {
  constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const auto& triangles = surface_.mesh().triangles;
  std::map<std::pair<int, int>, ElementPoint> middle;
  int compared = 0;
  for (int e = 0; e < surface_.num_elements(); ++e) {
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const ElementPoint at{
          e, 0.5 * (kCorner[k][0] + kCorner[l][0]), 0.5 * (kCorner[k][1] + kCorner[l][1])};
      const auto [other, is_new] =
          middle.insert({std::minmax(triangles[e][k], triangles[e][l]), at});
      if (is_new) continue;
      ++compared;
      const StrainPoint a = surface_.MakePoint(at), b = surface_.MakePoint(other->second);
      EXPECT_LT((a.position - b.position).norm(), 1e-13);
      EXPECT_LT((a.t1 - b.t1).norm(), 1e-12);
      EXPECT_LT((a.n - b.n).norm(), 1e-12);
      EXPECT_NEAR(a.b11, b.b11, 1e-9);
      EXPECT_NEAR(a.b12, b.b12, 1e-9);
      EXPECT_NEAR(a.b22, b.b22, 1e-9);
      std::map<int, Eigen::Matrix<double, 6, 1>> difference;
      for (const auto& [point, sign] : {std::make_pair(&a, 1.0), std::make_pair(&b, -1.0)}) {
        const auto& vertices = surface_.control_vertices(sign > 0.0 ? e : other->second.element);
        for (size_t i = 0; i < vertices.size(); ++i) {
          auto& d =
              difference.insert({vertices[i], Eigen::Matrix<double, 6, 1>::Zero()}).first->second;
          d += sign * point->weights.col(i);
        }
      }
      for (const auto& [vertex, d] : difference) EXPECT_LT(d.norm(), 1e-8) << vertex;
    }
  }
  EXPECT_GT(compared, surface_.num_elements());
}

TEST_P(MeshWeightsTest, VertexPointsAreTheVerticesOfElements) {
  std::set<int> seen;
  for (const ElementPoint& p : surface_.vertex_points()) {
    const auto& t = surface_.mesh().triangles[p.element];
    EXPECT_TRUE(seen.insert(t[p.s == 1.0 ? 1 : p.t == 1.0 ? 2 : 0]).second);
  }
  std::set<int> expected;
  for (int e = 0; e < surface_.num_elements(); ++e) {
    for (const int vertex : surface_.mesh().triangles[e]) expected.insert(vertex);
  }
  EXPECT_EQ(seen, expected);
}

TEST_P(MeshWeightsTest, ClosestPointIsNoFartherThanAnyOther) {
  std::mt19937 gen(38405);
  std::vector<Eigen::Vector3d> samples;
  for (int k = 0; k < 2000; ++k)
    samples.push_back(surface_.Position(RandomElementPoint(surface_, &gen)));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 40; ++k) {
    Eigen::Vector3d x = Eigen::Vector3d::NullaryExpr([&] { return 1.5 * uniform(gen); });
    if (k % 2 == 0) {  // Near the surface, on either side.
      const StrainPoint p = surface_.MakePoint(RandomElementPoint(surface_, &gen));
      x = p.position + 0.1 * uniform(gen) * p.n;
    }
    const ElementPoint at = surface_.ClosestPoint(x);
    const StrainPoint point = surface_.MakePoint(at);
    const Eigen::Vector3d offset = x - point.position;
    for (const Eigen::Vector3d& y : samples) ASSERT_LE(offset.norm(), (x - y).norm() + 1e-12);
    const double tangential = std::hypot(offset.dot(point.t1), offset.dot(point.t2));
    if (surface_.num_loops() == 0) {
      EXPECT_LT(tangential, 1e-6 * surface_.size()) << k << ": " << x.transpose();
    } else if (tangential > 1e-6 * surface_.size()) {
      // On the rim, and x lies beyond it.
      double nearest = std::numeric_limits<double>::infinity();
      Eigen::Vector3d outward = Eigen::Vector3d::Zero();
      for (int loop = 0; loop < surface_.num_loops(); ++loop) {
        for (const auto& p : surface_.SidePoints(ShellSurface::Loop(loop), 5)) {
          const double distance = (p.point.position - point.position).norm();
          if (distance >= nearest) continue;
          nearest = distance;
          outward = p.conormal.x() * p.point.t1 + p.conormal.y() * p.point.t2;
        }
      }
      EXPECT_LT(nearest, 0.1) << k << ": " << x.transpose();
      EXPECT_GT(offset.dot(outward), 0.0) << k << ": " << x.transpose();
    }
  }
}

TEST_P(MeshWeightsTest, ClosestPointOfASurfacePointIsItself) {
  std::mt19937 gen(38406);
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3d x = surface_.Position(RandomElementPoint(surface_, &gen));
    EXPECT_LT((surface_.Position(surface_.ClosestPoint(x)) - x).norm(), 1e-7);
  }
}

Eigen::Vector3d InSpace(const ShellSurface::CurvePoint& p, const Eigen::Vector2d& v) {
  return v.x() * p.point.t1 + v.y() * p.point.t2;
}

TEST(MeshSideTest, StraightRimsAreExactAwayFromCorners) {
  const int m = 5, n = 4;
  const ShellSurface sheet(MakeLoopMesh(Lattice(m, n)));
  ASSERT_EQ(sheet.num_loops(), 1);
  ASSERT_TRUE(sheet.HasSide(ShellSurface::Loop(0)));
  EXPECT_FALSE(sheet.HasSide(ShellSurface::Loop(1)));
  EXPECT_FALSE(sheet.HasSide(Side::kUMin));
  EXPECT_TRUE(sheet.IsClosed(ShellSurface::Loop(0)));
  EXPECT_EQ(sheet.BoundaryEdges(ShellSurface::Loop(0)).size(), 18u);
  int exact = 0;
  for (const int count : {1, 3, 5}) {
    const auto points = sheet.SidePoints(ShellSurface::Loop(0), count);
    ASSERT_EQ(points.size(), 18u * count);
    for (size_t i = 0; i < points.size(); i += count) {
      double length = 0.0;
      bool at_corner = false;
      for (int k = 0; k < count; ++k) {
        const auto& p = points[i + k];
        length += p.point.area;
        for (const int vertex : sheet.mesh().triangles[p.at.element]) {
          const Eigen::Vector3d x = sheet.control_points().col(vertex);
          at_corner = at_corner || ((x.x() == 0.0 || x.x() == m) && (x.y() == 0.0 || x.y() == n));
        }
      }
      if (at_corner) continue;
      ++exact;
      EXPECT_NEAR(length, 1.0, 1e-13);
      for (int k = 0; k < count; ++k) {
        const auto& p = points[i + k];
        const Eigen::Vector3d& x = p.point.position;
        const Eigen::Vector3d outward(std::abs(x.x()) < 1e-9 ? -1.0 : std::abs(x.x() - m) < 1e-9,
                                      std::abs(x.y()) < 1e-9 ? -1.0 : std::abs(x.y() - n) < 1e-9,
                                      0.0);
        EXPECT_NEAR(outward.norm(), 1.0, 0.0);  // On the rim.
        EXPECT_LT((InSpace(p, p.conormal) - outward).norm(), 1e-12);
        // Counterclockwise around the sheet.
        EXPECT_LT((InSpace(p, p.tangent) - Eigen::Vector3d::UnitZ().cross(outward)).norm(), 1e-12);
      }
    }
  }
  EXPECT_GE(exact, 3 * 8);
}

// Rims of an annulus through points of circles: length to fourth order, conormals radial.
TEST(MeshSideTest, RimsOfAnAnnulusAreCircles) {
  double errors[2];
  for (const int level : {0, 1}) {
    const ShellSurface annulus = Through(Annulus(level == 0 ? 20 : 40, level == 0 ? 4 : 8));
    ASSERT_EQ(annulus.num_loops(), 2);
    errors[level] = 0.0;
    for (int loop = 0; loop < 2; ++loop) {
      double length = 0.0, radius = 0.0;
      for (const auto& p : annulus.SidePoints(ShellSurface::Loop(loop), 4)) {
        length += p.point.area;
        radius = p.point.position.norm() > 1.5 ? 2.0 : 1.0;
        const Eigen::Vector3d radial = p.point.position.normalized();
        EXPECT_GT(InSpace(p, p.conormal).dot(radius > 1.5 ? radial : (-radial).eval()), 0.999);
        EXPECT_NEAR(p.tangent.norm(), 1.0, 1e-14);
        EXPECT_NEAR(p.conormal.norm(), 1.0, 1e-14);
        EXPECT_NEAR(p.tangent.dot(p.conormal), 0.0, 1e-14);
      }
      errors[level] = std::max(errors[level], std::abs(length / (2.0 * M_PI * radius) - 1.0));
    }
  }
  EXPECT_LT(errors[0], 3e-5);
  EXPECT_LT(errors[1], errors[0] / 14.0);
}

}  // namespace
}  // namespace darboux
