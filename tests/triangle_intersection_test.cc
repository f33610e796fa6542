#include "geometry/triangle_intersection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "tests/mesh_util.h"
#include "tests/sanitizer_util.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;
using Pairs = std::vector<std::array<int, 2>>;

constexpr double kTolerance = 1e-9;

Pairs Find(const TriangleMesh& mesh, std::size_t max_pairs = 100000) {
  return IntersectingTriangles(mesh.vertices, mesh.triangles, kTolerance, max_pairs);
}

TriangleMesh Both(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both = a;
  const int n = static_cast<int>(a.vertices.size());
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const std::array<int, 3>& t : b.triangles) {
    both.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  return both;
}

TriangleMesh Moved(TriangleMesh mesh, const Eigen::Matrix3d& matrix, const Vector3d& shift) {
  for (Vector3d& v : mesh.vertices) v = matrix * v + shift;
  return mesh;
}

Eigen::Matrix3d Skew() {
  return Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
}

// Another way to say it: some side of one triangle goes through the inside of the other, by
// Cramer's rule.
bool SidePierces(const std::array<Vector3d, 3>& s, const std::array<Vector3d, 3>& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    Eigen::Matrix3d a;
    a << t[1] - t[0], t[2] - t[0], s[k] - s[(k + 1) % 3];
    const Vector3d x = a.inverse() * (s[k] - t[0]);
    if (x[0] > 0 && x[1] > 0 && x[0] + x[1] < 1 && x[2] > 0 && x[2] < 1) return true;
  }
  return false;
}

TEST(TriangleIntersectionTest, AgreesWithSegmentsThroughTrianglesOnRandomTriangles) {
  std::mt19937 gen(38401);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TriangleMesh mesh;
  for (int i = 0; i < 300; ++i) {
    const Vector3d middle(uniform(gen), uniform(gen), uniform(gen));
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.push_back(middle + 0.3 * Vector3d(uniform(gen), uniform(gen), uniform(gen)));
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  Pairs expected;
  const auto corners = [&](int t) -> std::array<Vector3d, 3> {
    const std::size_t first = static_cast<std::size_t>(3 * t);
    return {mesh.vertices[first], mesh.vertices[first + 1], mesh.vertices[first + 2]};
  };
  for (int i = 0; i < 300; ++i) {
    for (int j = i + 1; j < 300; ++j) {
      if (SidePierces(corners(i), corners(j)) || SidePierces(corners(j), corners(i))) {
        expected.push_back({i, j});
      }
    }
  }
  EXPECT_GT(expected.size(), 100u);
  EXPECT_EQ(Find(mesh), expected);
}

TEST(TriangleIntersectionTest, SharingAVertexAgreesWithSegmentsThroughTriangles) {
  std::mt19937 gen(38402);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int num_intersecting = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    TriangleMesh mesh = {std::vector<Vector3d>(5), {{{0, 1, 2}}, {{3, 4, 0}}}};
    for (Vector3d& v : mesh.vertices) v = Vector3d(uniform(gen), uniform(gen), uniform(gen));
    const std::vector<Vector3d>& v = mesh.vertices;
    // Only the sides across from the vertex can pierce; the others only touch, in it.
    const auto pierces = [&](int a, int b, int c, int d) {
      Eigen::Matrix3d m;
      m << v[c] - v[0], v[d] - v[0], v[a] - v[b];
      const Vector3d x = m.inverse() * (v[a] - v[0]);
      return x[0] > 0 && x[1] > 0 && x[0] + x[1] < 1 && x[2] > 0 && x[2] < 1;
    };
    const bool expected = pierces(1, 2, 3, 4) || pierces(3, 4, 1, 2);
    num_intersecting += expected;
    EXPECT_EQ(Find(mesh).size(), expected ? 1u : 0u) << trial;
  }
  EXPECT_GT(num_intersecting, 200);
}

TEST(TriangleIntersectionTest, CleanSurfacesHaveNone) {
  EXPECT_THAT(Find(Octahedron()), IsEmpty());
  EXPECT_THAT(Find(Moved(Octahedron(), Skew(), {0.1, 0.2, 0.3})), IsEmpty());
  EXPECT_THAT(Find(Lattice(9, 7)), IsEmpty());
  EXPECT_THAT(Find(Moved(Lattice(9, 7), Skew(), {0.1, 0.2, 0.3})), IsEmpty());
  EXPECT_THAT(Find(Moved(Torus(40, 30), Skew(), {0.1, 0.2, 0.3})), IsEmpty());
  EXPECT_THAT(Find({}), IsEmpty());
}

class TouchTest : public ::testing::TestWithParam<double> {};  // Depth, within rounding or not.

// A triangle that comes down on another, in a skew frame.
TEST_P(TouchTest, VertexEdgeAndFaceOnAFaceOnlyCountWhenDeep) {
  const double depth = GetParam();
  const std::size_t expected = depth > kTolerance ? 1 : 0;
  const TriangleMesh ground = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{{0, 1, 2}}}};
  const std::vector<std::vector<Vector3d>> shapes = {
      {{1, 1, 0}, {2, 1, 1}, {1, 2, 1}},     // Stands on a vertex,
      {{1, 1, 0}, {2, 1, 0}, {1, 2, 1}},     // on an edge,
      {{-1, 1, 0}, {9, 1.5, 0}, {1, 2, 1}},  // on an edge longer than the face,
      {{0, 0, 0}, {1, 1, 0}, {0, 0, 1}},     // on an edge that starts from its corner.
  };
  for (const std::vector<Vector3d>& shape : shapes) {
    TriangleMesh mesh = Both(ground, {shape, {{{0, 1, 2}}}});
    for (std::size_t v = 3; v < 6; ++v) mesh.vertices[v].z() -= depth;
    EXPECT_EQ(Find(Moved(mesh, Skew(), {0.1, 0.2, 0.3})).size(), expected) << shape[1].transpose();
  }
}
INSTANTIATE_TEST_SUITE_P(Depths, TouchTest, ::testing::Values(-1e-3, -1e-12, 0.0, 1e-12, 1e-3));

TEST(TriangleIntersectionTest, CoplanarTrianglesIntersectWhereTheyOverlap) {
  const TriangleMesh a = {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {{{0, 1, 2}}}};
  const auto overlaps = [&](const Vector3d& shift) {
    return !Find(Moved(Both(a, Moved(a, Eigen::Matrix3d::Identity(), shift)), Skew(), {1, 2, 3}))
                .empty();
  };
  EXPECT_TRUE(overlaps({0, 0, 0}));
  EXPECT_TRUE(overlaps({0.5, 0.5, 0}));
  EXPECT_TRUE(overlaps({1.999, 0, 0}));
  EXPECT_FALSE(overlaps({2, 0, 0}));  // Vertex on vertex,
  EXPECT_FALSE(overlaps({1, 1, 0}));  // on a side.
  EXPECT_FALSE(overlaps({0.5, 0.5, 1e-3}));
}

TEST(TriangleIntersectionTest, NeighboursIntersectWhereTheyAreFolded) {
  for (const double height : {0.5, 1e-3, -1e-3}) {  // Of the fourth vertex; folded back, but open.
    EXPECT_THAT(
        Find({{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {0.5, 0.8, height}}, {{{0, 1, 2}}, {{1, 0, 3}}}}),
        IsEmpty());
  }
  EXPECT_EQ(Find({{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {0.5, 0.8, 0}}, {{{0, 1, 2}}, {{1, 0, 3}}}}),
            (Pairs{{0, 1}}));
}

TEST(TriangleIntersectionTest, SheetsThatCrossAlongTheirOwnEdgesAreFound) {
  const Eigen::Matrix3d upright =
      Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitY()).toRotationMatrix();
  const TriangleMesh sheet = Lattice(2, 2);
  // Across the middle line x = 1: the edges of both lie on it.
  const Vector3d to_the_middle(1, 0, 1);
  EXPECT_FALSE(
      Find(Moved(Both(sheet, Moved(sheet, upright, to_the_middle)), Skew(), {1, 2, 3})).empty());
  // The same with vertices of one between those of the other.
  EXPECT_FALSE(
      Find(Both(sheet, Moved(sheet, upright, to_the_middle + Vector3d(0, 0.5, 0)))).empty());
  // Edges of one in the triangles of the other.
  EXPECT_FALSE(Find(Both(sheet, Moved(sheet, upright, Vector3d(0.75, 0, 1)))).empty());
  // Standing on it along its edge.
  EXPECT_THAT(Find(Both(sheet, Moved(sheet, upright, Vector3d(1, 0, 2)))), IsEmpty());
  EXPECT_THAT(Find(Both(sheet, Moved(sheet, upright, Vector3d(0.75, 0, 2)))), IsEmpty());
}

TEST(TriangleIntersectionTest, TwoRidgesThatKissDoNotCross) {
  const TriangleMesh ridge = {{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 1}, {0.5, -1, 1}},
                              {{{0, 1, 2}}, {{1, 0, 3}}}};
  Eigen::Matrix3d turn = Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_THAT(Find(Both(ridge, Moved(ridge, turn, Vector3d::Zero()))), IsEmpty());
  turn = Eigen::AngleAxisd(0.4 * M_PI, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_FALSE(Find(Both(ridge, Moved(ridge, turn, Vector3d::Zero()))).empty());
}

TEST(TriangleIntersectionTest, StopsAtTheLimit) {
  TriangleMesh mesh;
  for (int k = 0; k < 20000; ++k) {  // All through all.
    const double angle = M_PI * k / 20000;
    const Vector3d across(std::cos(angle), std::sin(angle), 0.0);
    mesh.vertices.insert(mesh.vertices.end(),
                         {Vector3d(-across), Vector3d(across), Vector3d(0, 0, 1)});
    mesh.triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  EXPECT_EQ(Find(mesh, 1000).size(), 1000u);
}

TEST(TriangleIntersectionTest, TwentyThousandTrianglesTakeMuchLessThanASecond) {
  const TriangleMesh torus = Moved(Torus(100, 50), Skew(), {1, 2, 3});
  const TriangleMesh mesh =
      Both(torus, Moved(torus, Eigen::Matrix3d::Identity(), {0.01, 0.5, 0.2}));
  ASSERT_EQ(mesh.triangles.size(), 20000u);
  const double start = CpuSeconds();
  EXPECT_GT(Find(mesh).size(), 500u);
  EXPECT_LT(CpuSeconds() - start, 1.0 * kSlowdown);  // 0.03 s
}

}  // namespace
}  // namespace darboux
