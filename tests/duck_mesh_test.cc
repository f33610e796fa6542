#include "geometry/duck_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/expression.h"
#include "geometry/icosphere.h"
#include "geometry/implicit_function.h"
#include "geometry/implicit_mesh.h"
#include "geometry/triangle_mesh.h"
#include "tests/mesh_quality.h"

namespace darboux {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

TriangleMesh ReadData(const std::string& name) {
  TriangleMesh mesh;
  std::ifstream in(std::string(DARBOUX_DATA_DIR) + "/" + name);
  EXPECT_TRUE(in.good()) << name;
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Eigen::Vector3d p;
      words >> p.x() >> p.y() >> p.z();
      mesh.vertices.push_back(p);
    } else if (kind == "f") {
      std::array<int, 3> t{};
      words >> t[0] >> t[1] >> t[2];
      for (int& v : t) --v;
      mesh.triangles.push_back(t);
    }
  }
  return mesh;
}

Expression DuckExpression() {
  std::string error;
  const std::optional<Expression> e = Expression::Parse(DuckFormula(), {"x", "y", "z"}, &error);
  EXPECT_TRUE(e.has_value()) << error;
  return e.value_or(Expression::Constant(0.0));
}

// Nearest point of the triangle a, b, c to p (Ericson, Real-Time Collision Detection, 5.1.5, by
// projection and clamping to the edges).
double DistanceToTriangle(const Eigen::Vector3d& p,
                          const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b,
                          const Eigen::Vector3d& c) {
  const Eigen::Vector3d n = (b - a).cross(c - a).normalized();
  const std::array<Eigen::Vector3d, 3> corner = {a, b, c};
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d &u = corner[k], v = corner[(k + 1) % 3] - u;
    if (n.dot(v.cross(p - u)) < 0.0) inside = false;
    const double t = std::clamp((p - u).dot(v) / v.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (u + t * v - p).norm());
  }
  return inside ? std::abs(n.dot(p - a)) : nearest;
}

double LargestDistance(const TriangleMesh& points, const TriangleMesh& mesh) {
  double largest = 0.0;
  for (const Eigen::Vector3d& p : points.vertices) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::array<int, 3>& t : mesh.triangles) {
      nearest = std::min(
          nearest,
          DistanceToTriangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
    }
    largest = std::max(largest, nearest);
  }
  return largest;
}

// Whether the segment p q passes through the inside of the triangle.
bool Crosses(const Eigen::Vector3d& p,
             const Eigen::Vector3d& q,
             const std::array<Eigen::Vector3d, 3>& t) {
  const auto side = [](const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d) { return (b - a).cross(c - a).dot(d - a); };
  if (side(t[0], t[1], t[2], p) * side(t[0], t[1], t[2], q) >= 0.0) return false;
  const double s0 = side(p, q, t[0], t[1]), s1 = side(p, q, t[1], t[2]),
               s2 = side(p, q, t[2], t[0]);
  return (s0 > 0.0 && s1 > 0.0 && s2 > 0.0) || (s0 < 0.0 && s1 < 0.0 && s2 < 0.0);
}

struct DuckFile {
  const char* name;
  int frequency;
};

class DuckMeshTest : public ::testing::TestWithParam<DuckFile> {
 protected:
  const int n_ = GetParam().frequency;
  const TriangleMesh mesh_ = ReadData(GetParam().name);
  const MeshQuality quality_ = MeasureMesh(mesh_);
};

TEST_P(DuckMeshTest, IsAClosedSphereWithTheIcospheresConnectivity) {
  ASSERT_EQ(mesh_.vertices.size(), static_cast<size_t>(10 * n_ * n_ + 2));
  EXPECT_EQ(mesh_.triangles, MakeIcosphere(1.0, n_).triangles);
  EXPECT_TRUE(quality_.is_manifold);
  EXPECT_EQ(quality_.num_boundary_edges, 0);
  EXPECT_EQ(quality_.num_components, 1);
  EXPECT_EQ(quality_.euler_characteristic, 2);
  EXPECT_THAT(quality_.valences, UnorderedElementsAre(Pair(5, 12), Pair(6, 10 * n_ * n_ - 10)));
}

TEST_P(DuckMeshTest, HasTheSizeOfABathDuck) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh_.vertices) box.extend(p);
  EXPECT_NEAR(box.sizes().x(), 0.090, 0.001);
  EXPECT_NEAR(box.sizes().y(), 0.070, 0.001);
  EXPECT_NEAR(box.sizes().z(), 0.080, 0.001);
  EXPECT_NEAR(quality_.volume, 181e-6, 3e-6);  // m^3; positive: seen from outside.
}

TEST_P(DuckMeshTest, HasWideAngles) { EXPECT_GT(quality_.min_angle_deg, 22.0); }

TEST_P(DuckMeshTest, LiesOnItsSurfaceWithoutFolds) {
  const Expression expression = DuckExpression();
  const ImplicitFunction function(expression);
  const double size = DuckBounds().diagonal().norm();
  std::vector<Eigen::Vector3d> gradients;
  for (const Eigen::Vector3d& p : mesh_.vertices) {
    Eigen::Vector3d gradient;
    const double f = function.Value(p, &gradient);
    EXPECT_LE(std::abs(f), 1e-12 * size * gradient.norm());
    gradients.push_back(gradient.normalized());
  }
  for (const std::array<int, 3>& t : mesh_.triangles) {
    const Eigen::Vector3d& a = mesh_.vertices[t[0]];
    const Eigen::Vector3d normal =
        (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a).normalized();
    for (const int v : t) EXPECT_GT(normal.dot(gradients[v]), 0.2);
  }
}

TEST_P(DuckMeshTest, DoesNotIntersectItself) {
  const double longest = quality_.max_edge;
  for (const std::array<int, 3>& t : mesh_.triangles) {
    for (const std::array<int, 3>& s : mesh_.triangles) {
      if ((mesh_.vertices[s[0]] - mesh_.vertices[t[0]]).norm() > 2.0 * longest) continue;
      for (int k = 0; k < 3; ++k) {
        const int p = t[k], q = t[(k + 1) % 3];
        if (p > q || std::count(s.begin(), s.end(), p) + std::count(s.begin(), s.end(), q) > 0) {
          continue;
        }
        EXPECT_FALSE(Crosses(mesh_.vertices[p],
                             mesh_.vertices[q],
                             {mesh_.vertices[s[0]], mesh_.vertices[s[1]], mesh_.vertices[s[2]]}));
      }
    }
  }
}

TEST_P(DuckMeshTest, MirrorsInItsPlane) {
  for (const Eigen::Vector3d& p : mesh_.vertices) {
    const Eigen::Vector3d image = p.cwiseProduct(Eigen::Vector3d(1.0, -1.0, 1.0));
    EXPECT_TRUE(std::any_of(mesh_.vertices.begin(),
                            mesh_.vertices.end(),
                            [&image](const Eigen::Vector3d& q) { return q == image; }));
  }
}

INSTANTIATE_TEST_SUITE_P(Files,
                         DuckMeshTest,
                         ::testing::Values(DuckFile{"duck_642.obj", 8},
                                           DuckFile{"duck_2562.obj", 16}));

TEST(DuckFilesTest, ShowTheSameDuck) {
  const TriangleMesh coarse = ReadData("duck_642.obj");
  const TriangleMesh fine = ReadData("duck_2562.obj");
  EXPECT_LT(LargestDistance(fine, coarse), 2.5e-3);  // m: sagitta of edges of up to 12 mm.
  EXPECT_LT(LargestDistance(coarse, fine), 0.6e-3);
}

TEST(DuckFilesTest, AreWhatTheGeneratorMakes) {  // Up to the rounding of exp.
  const TriangleMesh file = ReadData("duck_642.obj");
  const TriangleMesh made = MakeDuckMesh(8);
  ASSERT_EQ(made.triangles, file.triangles);
  for (size_t i = 0; i < made.vertices.size(); ++i) {
    EXPECT_LT((made.vertices[i] - file.vertices[i]).norm(), 1e-5);
  }
}

TEST(DuckFormulaTest, IsAnImplicitSurfaceLikeAnyOther) {
  TriangleMesh mesh;
  std::string error;
  ASSERT_TRUE(MeshImplicitSurface(DuckExpression(), DuckBounds(), 0.0025, {}, &mesh, &error))
      << error;
  const MeshQuality q = MeasureMesh(mesh);
  EXPECT_EQ(q.euler_characteristic, 2);
  EXPECT_GT(q.min_angle_deg, 30.0);
  EXPECT_LT(LargestDistance(ReadData("duck_642.obj"), mesh), 0.6e-3);
}

}  // namespace
}  // namespace darboux
