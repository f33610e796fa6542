#include "geometry/polygon_triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "tests/mesh_util.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

// A star-shaped polygon with corners at seeded distances from the centre, in a skew plane.
std::vector<Vector3d> Star(int n, unsigned seed) {
  std::mt19937 gen(seed);
  std::uniform_real_distribution<double> distance(0.2, 1.0);
  std::vector<Vector3d> corners;
  for (int k = 0; k < n; ++k) {
    const double angle = 2.0 * M_PI * k / n, r = distance(gen);
    corners.push_back(r * (std::cos(angle) * Vector3d(1, 2, 2) / 3.0 +
                           std::sin(angle) * Vector3d(2, 1, -2) / 3.0));
  }
  return corners;
}

Vector3d AreaVector(const std::vector<Vector3d>& corners) {
  Vector3d area = Vector3d::Zero();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    area += 0.5 * corners[k].cross(corners[(k + 1) % corners.size()]);
  }
  return area;
}

class PolygonOfSizeTest : public ::testing::TestWithParam<double> {};  // Size.

TEST_P(PolygonOfSizeTest, CoversAnyPlanarPolygonOnce) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::vector<Vector3d> corners = Star(3 + static_cast<int>(seed % 20), seed);
    for (Vector3d& corner : corners) corner *= GetParam();
    const double area = AreaVector(corners).norm();
    const std::vector<std::array<int, 3>> triangles = TriangulatePolygon(corners);
    ASSERT_EQ(triangles.size(), corners.size() - 2);
    // The sum of areas is the area, so nothing is covered twice or from behind.
    EXPECT_NEAR(Area(TriangleMesh{corners, triangles}), area, 1e-12 * area) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, PolygonOfSizeTest, ::testing::Values(1e-9, 1.0, 1e9));

TEST(TriangulatePolygonTest, LeavesNoTriangleWithoutAreaWhereThereIsAWay) {
  // A square with corners on the middles of its sides as well; a fan about (0, 0) has two flat
  // ones.
  const std::vector<Vector3d> corners = {
      {0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  EXPECT_FALSE(IsFan(corners));
  const TriangleMesh mesh = {corners, TriangulatePolygon(corners)};
  ASSERT_EQ(mesh.triangles.size(), 6u);
  for (std::size_t t = 0; t < 6; ++t) EXPECT_GE(Area(mesh, t), 0.5);
}

TEST(TriangulatePolygonTest, GoesOnSmoothlyFromItsSurroundings) {
  // A square with two opposite corners lifted: a ridge between these or a valley between the others
  // are equally good, until the land around falls or rises away from it.
  const std::vector<Vector3d> corners = {{0, -1, 0}, {1, 0, 0.1}, {0, 1, 0}, {-1, 0, 0.1}};
  for (const bool is_ridge : {true, false}) {
    PolygonSurroundings around;
    const double z = is_ridge ? -0.1 : 0.2;
    around.opposite = {{1, -1, z}, {1, 1, z}, {-1, 1, z}, {-1, -1, z}};
    const std::vector<std::array<int, 3>> triangles = TriangulatePolygon(corners, around);
    ASSERT_EQ(triangles.size(), 2u);
    for (std::array<int, 3> t : triangles) {
      std::sort(t.begin(), t.end());
      EXPECT_TRUE(is_ridge ? t[2] == 3 && (t[0] == 1 || t[1] == 1)
                           : t[0] == 0 && (t[1] == 2 || t[2] == 2))
          << t[0] << t[1] << t[2];
    }
  }
}

TEST(TriangulatePolygonTest, ForbiddenSidesAreNotUsed) {
  const std::vector<Vector3d> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  PolygonSurroundings around;
  for (int first = 0; first < 2; ++first) {
    around.is_forbidden = [first](int i, int k) { return i == first && k == first + 2; };
    for (const std::array<int, 3>& t : TriangulatePolygon(square, around)) {
      int num_ends = 0;
      for (const int corner : t) num_ends += corner == first || corner == first + 2;
      EXPECT_EQ(num_ends, 1);
    }
  }
  around.is_forbidden = [](int, int) { return true; };
  EXPECT_TRUE(TriangulatePolygon(square, around).empty());
}

TEST(TriangulatePolygonTest, TakesAnythingForAPolygon) {
  const double nan = std::nan("");
  EXPECT_TRUE(TriangulatePolygon({}).empty());
  EXPECT_TRUE(TriangulatePolygon({{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_EQ(TriangulatePolygon(std::vector<Vector3d>(6, Vector3d::Zero())).size(), 4u);
  EXPECT_EQ(TriangulatePolygon(std::vector<Vector3d>(6, Vector3d(nan, 0, 1e308))).size(), 4u);
  EXPECT_FALSE(IsFan(std::vector<Vector3d>(6, Vector3d(nan, 0, 1e308))));
}

}  // namespace
}  // namespace darboux
