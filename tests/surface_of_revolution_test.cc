#include "geometry/surface_of_revolution.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

namespace darboux {
namespace {

double Volume(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6.0;
  }
  return volume;
}

TEST(SurfaceOfRevolutionTest, AHalfCircleFromAboveBecomesABallWoundOutwards) {
  for (const double from : {0.0, 0.002}) {  // ends on the axis, and closed beside it
    std::vector<Eigen::Vector3d> profile;
    for (int k = 0; k <= 90; ++k) {
      const double angle = from + (M_PI - 2.0 * from) * k / 90;
      profile.push_back({2.0 * std::sin(angle), 0.0, 2.0 * std::cos(angle)});
    }
    profile.front().x() = std::abs(profile.front().x());
    profile.back().x() = std::abs(profile.back().x());
    if (from == 0.0) profile.front().x() = profile.back().x() = 0.0;
    TriangleMesh mesh;
    std::string error;
    ASSERT_TRUE(Revolve(profile, 180, &mesh, &error)) << error;
    const double exact = 4.0 / 3.0 * M_PI * 8.0;
    EXPECT_NEAR(Volume(mesh), exact, 1e-3 * exact);
    // Closed: V - E + F = 2 with two triangles at every edge.
    EXPECT_EQ(static_cast<int>(mesh.vertices.size()) - static_cast<int>(mesh.triangles.size()) / 2,
              2);
  }
}

TEST(SurfaceOfRevolutionTest, ProfilesThatAreNoneAreNamed) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_FALSE(Revolve({{1, 0, 1}}, 10, &mesh, &error));
  EXPECT_FALSE(Revolve({{1, 0, 1}, {1, 0.5, 0}}, 10, &mesh, &error));
  EXPECT_NE(error.find("point 1"), std::string::npos) << error;
  EXPECT_FALSE(Revolve({{1, 0, 1}, {0, 0, 0}, {1, 0, -1}}, 10, &mesh, &error));
  EXPECT_FALSE(Revolve({{1, 0, 1}, {1, 0, 0}}, 2, &mesh, &error));
}

}  // namespace
}  // namespace darboux
