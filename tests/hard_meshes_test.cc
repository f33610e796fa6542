// Hard cases: meshes. Vertices of valence 3 to 16, slivers of one degree, collapsed triangles.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/mesh_io.h"
#include "tests/hard_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

class HardMeshTest : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  // A scene of this mesh; false and *error where it is refused.
  bool Read(const TriangleMesh& mesh, const std::string& rest, Scene* scene, std::string* error) {
    EXPECT_TRUE(WriteObj(path_, mesh, error)) << *error;
    return ParseScene(
        "name: mesh\nsurface: {kind: mesh, file: " + path_ + ", fit: " + fit_ + "}\n" + rest,
        "test.yaml",
        scene,
        error);
  }
  Solution SolveMesh(const TriangleMesh& mesh, const std::string& rest) {
    Scene scene;
    std::string error;
    EXPECT_TRUE(Read(mesh, rest, &scene, &error)) << error;
    return SolveScene(scene);
  }

  std::string fit_ = "control";
  std::string path_ = (std::filesystem::path(::testing::TempDir()) /
                       ("hard_mesh_" + std::to_string(getpid()) + ".obj"))
                          .string();
};

// A disc of radius 1 of `rings` rings about a vertex of the given valence: ring k has k * valence
// vertices.
TriangleMesh Disc(int valence, int rings) {
  TriangleMesh mesh;
  const auto index = [&](int ring, int i) {
    if (ring == 0) return 0;
    const int count = ring * valence;
    return 1 + valence * ring * (ring - 1) / 2 + (i % count + count) % count;
  };
  mesh.vertices.push_back(Eigen::Vector3d::Zero());
  for (int ring = 1; ring <= rings; ++ring) {
    for (int i = 0; i < ring * valence; ++i) {
      const double angle = 2.0 * M_PI * i / (ring * valence), r = 1.0 * ring / rings;
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
    }
  }
  for (int ring = 1; ring <= rings; ++ring) {
    for (int sector = 0; sector < valence; ++sector) {
      for (int k = 0; k < ring; ++k) {
        const int outer = sector * ring + k, inner = sector * (ring - 1) + k;
        mesh.triangles.push_back(
            {index(ring, outer), index(ring, outer + 1), index(ring - 1, inner)});
        if (k + 1 < ring) {
          mesh.triangles.push_back(
              {index(ring - 1, inner), index(ring, outer + 1), index(ring - 1, inner + 1)});
        }
      }
    }
  }
  return mesh;
}

class ValenceTest : public HardMeshTest, public ::testing::WithParamInterface<int> {};

// With a linear field prescribed at the rim the displacement is that field everywhere. It is in the
// space; the rim is held at points, whose reactions are not quite its traction, which leaves 1e-4
// on a regular mesh of this size as well: valence adds no more than that.
TEST_P(ValenceTest, LinearFieldIsReproducedAsOnARegularMesh) {
  const Solution solution = SolveMesh(Disc(GetParam(), 4), R"(
shell: {thickness: 0.01, young_modulus: 1000, poisson_ratio: 0.3}
model: {theory: linear, quadrature: 12}
supports:
  - {on: rim, simply_supported: true, displacement: ["0.01*x + 0.003*y", "-0.002*x + 0.004*y", "0.02*x - 0.01*y"]}
probes:
  - {name: centre, at: {nearest: [0, 0, 0]}}
  - {name: near, at: {nearest: [0.1, 0.07, 0]}}
  - {name: far, at: {nearest: [-0.5, 0.3, 0]}}
)");
  double worst = 0.0;
  for (const ProbeSummary& probe : solution.summary.probes) {
    const double x = probe.position.x(), y = probe.position.y();
    const Eigen::Vector3d exact(0.01 * x + 0.003 * y, -0.002 * x + 0.004 * y, 0.02 * x - 0.01 * y);
    worst = std::max(worst, (probe.displacement - exact).norm() / 0.02);
  }
  EXPECT_LE(worst, 5e-4);
  Measured("meshes: valence " + std::to_string(GetParam()) + ", patch test", worst);
}

// A clamped disc under pressure: w = p a^4 / (64 D) in its centre, which is the extraordinary
// vertex.
TEST_P(ValenceTest, ClampedDiscBendsByItsClosedForm) {
  const auto error = [&](int rings) {
    const Solution solution = SolveMesh(Disc(GetParam(), rings), R"(
shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1.0e-3}]
probes: [{name: centre, at: {nearest: [0, 0, 0]}}]
)");
    const double d = 1e6 * 1e-6 / (12.0 * (1.0 - 0.09));
    return std::abs(std::abs(solution.Probe().z()) / (1e-3 / (64.0 * d)) - 1.0);
  };
  const double coarse = error(6), fine = error(12);
  EXPECT_LE(fine, GetParam() <= 8 ? 0.03 : 0.07);
  EXPECT_LT(fine, 0.6 * coarse);
  Measured("meshes: valence " + std::to_string(GetParam()) + ", clamped disc, 12 rings", fine);
}

INSTANTIATE_TEST_SUITE_P(Valences, ValenceTest, ::testing::Values(3, 4, 5, 6, 7, 8, 10, 12, 16));

// A lattice of 1 x 1 with cells so flat that its triangles have an angle of one degree.
TriangleMesh Slivers(int columns, int rows) {
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      mesh.vertices.emplace_back(1.0 * i / columns, 1.0 * j / rows, 0.0);
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

TEST_F(HardMeshTest, SliversOfOneDegreeReproduceALinearField) {
  const Solution solution = SolveMesh(Slivers(2, 115), R"(
shell: {thickness: 0.01, young_modulus: 1000, poisson_ratio: 0.3}
model: {theory: linear, quadrature: 6}
supports: [{on: rim, simply_supported: true, displacement: [0.01*x + 0.003*y, 0.004*y - 0.002*x, 0]}]
probes: [{name: inside, at: {nearest: [0.4, 0.3, 0]}}]
)");
  const ProbeSummary& probe = solution.summary.probes[0];
  const double x = probe.position.x(), y = probe.position.y();
  const Eigen::Vector3d exact(0.01 * x + 0.003 * y, -0.002 * x + 0.004 * y, 0.0);
  const double error = (probe.displacement - exact).norm() / 0.01;
  EXPECT_NEAR(std::atan2(1.0 / 115, 0.5) * 180.0 / M_PI, 1.0, 0.01);
  // Not rounding: between its points a rim support lets the rim give way. A lattice of equal sides
  // is 7e-5 off.
  EXPECT_LE(error, 5e-5);
  Measured("meshes: slivers of 1 degree, patch test", error);
}

TEST_F(HardMeshTest, CollapsedTrianglesAreErrors) {
  const std::string rest =
      "shell: {thickness: 0.01, young_modulus: 1000, poisson_ratio: 0.3}\n"
      "supports: [{on: rim, clamped: true}]\n";
  for (const bool to_a_point : {true, false}) {
    TriangleMesh mesh = Slivers(4, 4);
    // A vertex inside moves onto its neighbour, or onto the line between two of a triangle.
    mesh.vertices[12] = to_a_point ? mesh.vertices[13]
                                   : Eigen::Vector3d(0.5 * (mesh.vertices[13] + mesh.vertices[7]));
    Scene scene;
    std::string error;
    EXPECT_FALSE(Read(mesh, rest, &scene, &error));
    EXPECT_THAT(error, HasSubstr("test.yaml:2: surface.file: "));
    EXPECT_THAT(error, HasSubstr("allowed"));
  }
}

}  // namespace
}  // namespace darboux
