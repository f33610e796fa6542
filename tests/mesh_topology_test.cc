#include "geometry/mesh_topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/mesh_util.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// The only component.
MeshComponent Component(const TriangleMesh& mesh) {
  const std::vector<MeshComponent> components = MeshComponents(mesh);
  EXPECT_EQ(components.size(), 1u);
  return components.empty() ? MeshComponent() : components[0];
}

// A strip of n quadrilaterals, closed with or without a twist; every boundary edge has vertices
// k and k + 2, or closes.
TriangleMesh Ring(int n, bool twisted) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::size_t>(2 * n), Eigen::Vector3d::Zero());
  for (int k = 0; k < n; ++k) {
    const int a = 2 * k, b = a + 1;
    const int c = k + 1 < n ? a + 2 : (twisted ? 1 : 0), d = k + 1 < n ? a + 3 : (twisted ? 0 : 1);
    mesh.triangles.push_back({a, c, d});
    mesh.triangles.push_back({a, d, b});
  }
  return mesh;
}

TEST(MeshComponentsTest, SphereTorusDiskTubeAndMoebiusStripHaveTheirGenus) {
  const MeshComponent sphere = Component(Octahedron());
  EXPECT_EQ(sphere.EulerCharacteristic(), 2);
  EXPECT_EQ(sphere.Genus(), 0);
  EXPECT_TRUE(sphere.is_closed() && sphere.is_manifold && sphere.is_orientable);
  const MeshComponent torus = Component(Torus(5, 4));
  EXPECT_EQ(torus.EulerCharacteristic(), 0);
  EXPECT_EQ(torus.Genus(), 1);
  const MeshComponent disk = Component(Lattice(3, 2));
  EXPECT_EQ(disk.num_vertices, 12);
  EXPECT_EQ(disk.num_edges, 23);
  EXPECT_EQ(disk.EulerCharacteristic(), 1);
  EXPECT_EQ(disk.num_boundary_loops, 1);
  EXPECT_EQ(disk.Genus(), 0);
  const MeshComponent tube = Component(Ring(7, /*twisted=*/false));
  EXPECT_EQ(tube.num_boundary_loops, 2);
  EXPECT_EQ(tube.Genus(), 0);
  const MeshComponent moebius = Component(Ring(7, /*twisted=*/true));
  EXPECT_EQ(moebius.num_boundary_loops, 1);
  EXPECT_FALSE(moebius.is_orientable);
  EXPECT_EQ(moebius.Genus(), 1);
}

TEST(MeshComponentsTest, PiecesAreSortedByTheirFirstTriangles) {
  TriangleMesh mesh = Octahedron();
  mesh.vertices.resize(12);
  mesh.triangles.insert(mesh.triangles.begin() + 1, {{6, 7, 8}});
  mesh.triangles.push_back({8, 9, 10});
  mesh.triangles.push_back({0, 1, 12});  // No such vertex.
  mesh.triangles.push_back({9, 9, 11});  // No triangle.
  const std::vector<MeshComponent> components = MeshComponents(mesh);
  ASSERT_EQ(components.size(), 2u);
  EXPECT_THAT(components[0].triangles, ElementsAre(0, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(components[1].triangles, ElementsAre(1, 9));
  EXPECT_FALSE(components[1].is_manifold);  // They meet in vertex 8.
  EXPECT_EQ(components[1].Genus(), -1);
  EXPECT_EQ(components[1].num_boundary_loops, 2);
}

TEST(BoundaryLoopsTest, RunWithTheSurfaceOnTheirLeft) {
  EXPECT_THAT(BoundaryLoops(Octahedron()), IsEmpty());
  EXPECT_THAT(BoundaryLoops({}), IsEmpty());
  EXPECT_THAT(BoundaryLoops(Lattice(2, 2)), ElementsAre(ElementsAre(0, 1, 2, 5, 8, 7, 6, 3)));
  TriangleMesh mesh = Lattice(3, 3);  // Without the cell in the middle.
  mesh.triangles.erase(mesh.triangles.begin() + 8, mesh.triangles.begin() + 10);
  EXPECT_THAT(
      BoundaryLoops(mesh),
      ElementsAre(ElementsAre(0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4), ElementsAre(5, 9, 10, 6)));
}

TEST(BoundaryLoopsTest, StayWithTheirFanWhereSeveralMeet) {
  // Three triangles around a vertex.
  const TriangleMesh mesh = {std::vector<Eigen::Vector3d>(7, Eigen::Vector3d::Zero()),
                             {{{0, 1, 2}}, {{3, 0, 4}}, {{5, 6, 0}}}};
  EXPECT_THAT(BoundaryLoops(mesh),
              ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 4, 3), ElementsAre(0, 5, 6)));
}

TEST(BoundaryLoopsTest, EndAtNonManifoldEdges) {
  // Three fins on the edge 0-1: each has two edges of boundary; at either end three fans' worth of
  // boundary meet, of which two are joined.
  const TriangleMesh mesh = {std::vector<Eigen::Vector3d>(5, Eigen::Vector3d::Zero()),
                             {{{0, 1, 2}}, {{1, 0, 3}}, {{0, 1, 4}}}};
  std::size_t num_edges = 0;
  for (const std::vector<int>& loop : BoundaryLoops(mesh)) {
    num_edges += loop.size() - (loop.front() != loop.back() && loop[0] <= 1 && loop.back() <= 1);
  }
  EXPECT_GE(num_edges, 6u);
  EXPECT_LE(num_edges, 7u);
}

TEST(EdgeTableTest, KnowsWhatLiesAcross) {
  const std::vector<std::array<int, 3>> triangles = Octahedron().triangles;
  const EdgeTable edges(triangles);
  EXPECT_EQ(edges.edges().size(), 12u);
  for (int t = 0; t < 8; ++t) {
    for (int c = 0; c < 3; ++c) {
      const EdgeTable::Side* const across = edges.Across(t, c);
      ASSERT_NE(across, nullptr);
      const EdgeTable::Side* const back = edges.Across(across->triangle, across->corner);
      EXPECT_EQ(back->triangle, t);
      EXPECT_EQ(back->corner, c);
      EXPECT_NE(back->is_forward, across->is_forward);
    }
  }
  EXPECT_TRUE(edges.HasEdge(5, 0));
  EXPECT_FALSE(edges.HasEdge(4, 5));
}

}  // namespace
}  // namespace darboux
