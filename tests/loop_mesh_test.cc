#include "geometry/loop_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/loop_basis.h"
#include "geometry/shell_surface.h"
#include "tests/mesh_util.h"

namespace darboux {
namespace {

// A tube around the z axis of regular triangles, radius 1, height 2: no corners.
TriangleMesh Tube(int m, int n) {
  TriangleMesh mesh = Annulus(m, n);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const double height = 2.0 * (mesh.vertices[i].norm() - 1.0);
    mesh.vertices[i] = mesh.vertices[i].normalized();
    mesh.vertices[i].z() = height;
  }
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // outwards
  return mesh;
}

// A hole of three edges.
TriangleMesh WithHole(TriangleMesh mesh, int triangle) {
  mesh.triangles.erase(mesh.triangles.begin() + triangle);
  return mesh;
}

// Two apexes of valence k and an equator of valence 4.
TriangleMesh DoublePyramid(int k) {
  TriangleMesh mesh;
  for (int i = 0; i < k; ++i) {
    mesh.vertices.emplace_back(std::cos(2.0 * M_PI * i / k), std::sin(2.0 * M_PI * i / k), 0.0);
  }
  mesh.vertices.emplace_back(0.1, 0.0, 0.9);
  mesh.vertices.emplace_back(0.0, -0.2, -1.1);
  for (int i = 0; i < k; ++i) {
    mesh.triangles.push_back({i, (i + 1) % k, k});
    mesh.triangles.push_back({(i + 1) % k, i, k + 1});
  }
  return mesh;
}

// A fan of k triangles around one vertex.
TriangleMesh Fan(int k) {
  TriangleMesh mesh = DoublePyramid(k);
  mesh.triangles.erase(std::remove_if(mesh.triangles.begin(),
                                      mesh.triangles.end(),
                                      [k](const std::array<int, 3>& t) { return t[2] == k + 1; }),
                       mesh.triangles.end());
  mesh.vertices.pop_back();
  return mesh;
}

// Moves every vertex somewhere near: no symmetry.
TriangleMesh Shaken(TriangleMesh mesh, double size = 0.05) {
  std::mt19937 gen(38407);
  std::uniform_real_distribution<double> uniform(-size, size);
  for (Eigen::Vector3d& x : mesh.vertices) {
    for (int i = 0; i < 3; ++i) x[i] += uniform(gen);
  }
  return mesh;
}

struct Case {
  std::string name;
  TriangleMesh mesh;
  std::vector<int> loops;  // numbers of edges, ascending
};

std::vector<Case> Cases() {
  std::vector<Case> cases = {{"icosphere", Shaken(MakeIcosphere(1.0, 3)), {}},
                             {"torus", Shaken(Torus(7, 5)), {}},
                             {"sheet", Shaken(Lattice(4, 3)), {14}},
                             {"one_cell", Shaken(Lattice(1, 1)), {4}},
                             {"annulus", Shaken(Annulus(7, 2)), {7, 7}},
                             {"tube", Shaken(Tube(5, 1)), {5, 5}},
                             {"hole", Shaken(WithHole(MakeIcosphere(1.0, 2), 5)), {3}},
                             {"sheet_with_hole", Shaken(WithHole(Lattice(5, 4), 15)), {3, 18}}};
  for (int k = 3; k <= 8; ++k) {
    cases.push_back({"double_pyramid_" + std::to_string(k), Shaken(DoublePyramid(k)), {}});
    cases.push_back({"fan_" + std::to_string(k), Shaken(Fan(k)), {k}});
  }
  return cases;
}

class LoopMeshTest : public ::testing::TestWithParam<Case> {
 protected:
  LoopMeshTest() : source_(GetParam().mesh), loop_(MakeLoopMesh(source_)) {}

  int num_vertices() const { return static_cast<int>(source_.vertices.size()); }
  int num_boundary_edges() const {
    int edges = 0;
    for (const int n : GetParam().loops) edges += n;
    return edges;
  }

  const TriangleMesh source_;
  const LoopMesh loop_;
};

INSTANTIATE_TEST_SUITE_P(Meshes, LoopMeshTest, ::testing::ValuesIn(Cases()), [](const auto& info) {
  return info.param.name;
});

// A ghost and two ghost triangles per boundary edge, one of each more per neighbour of a corner;
// the mesh itself comes first.
TEST_P(LoopMeshTest, AddsOneGhostPerBoundaryEdgeAndSomeInCorners) {
  const int edges = num_boundary_edges();
  const int ghosts = static_cast<int>(loop_.ghosts.size());
  EXPECT_GE(ghosts, edges);
  EXPECT_EQ(loop_.mesh.num_vertices, num_vertices() + ghosts);
  EXPECT_EQ(loop_.points.cols(), loop_.mesh.num_vertices);
  EXPECT_EQ(loop_.mesh.num_elements, static_cast<int>(source_.triangles.size()));
  EXPECT_EQ(loop_.mesh.triangles.size(), source_.triangles.size() + edges + ghosts);
  EXPECT_TRUE(
      std::equal(source_.triangles.begin(), source_.triangles.end(), loop_.mesh.triangles.begin()));
  for (int i = 0; i < num_vertices(); ++i) EXPECT_EQ(loop_.points.col(i), source_.vertices[i]);
}

// An oriented manifold whose boundary is made of ghosts alone, with one fan around every vertex.
TEST_P(LoopMeshTest, EveryVertexOfAnElementIsInterior) {
  std::map<int, std::map<int, int>> next;  // around each vertex, counterclockwise
  for (const auto& t : loop_.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(next[t[k]].insert({t[(k + 1) % 3], t[(k + 2) % 3]}).second);
    }
  }
  for (int i = 0; i < num_vertices(); ++i) {
    ASSERT_GE(next[i].size(), 3u) << i;
    const int first = next[i].begin()->first;
    int at = first;
    for (size_t k = 0; k < next[i].size(); ++k) {
      ASSERT_EQ(next[i].count(at), 1u) << "vertex " << i;
      at = next[i].at(at);
      EXPECT_EQ(at == first, k + 1 == next[i].size()) << "vertex " << i;
    }
  }
  LoopBasis basis(loop_.mesh);  // CHECKs the same.
}

TEST_P(LoopMeshTest, GhostsMirrorTheTriangleAtTheBoundary) {
  std::set<std::pair<int, int>> edges;
  for (const auto& t : source_.triangles) {
    for (int k = 0; k < 3; ++k) edges.insert({t[k], t[(k + 1) % 3]});
  }
  std::set<std::array<int, 3>> triangles(source_.triangles.begin(), source_.triangles.end());
  std::map<int, std::set<int>> neighbours;
  std::map<int, int> num_triangles;
  for (const auto& t : loop_.mesh.triangles) {
    for (int k = 0; k < 3; ++k) neighbours[t[k]].insert(t[(k + 1) % 3]);
  }
  for (const auto& t : source_.triangles) {
    for (const int vertex : t) ++num_triangles[vertex];
  }
  for (size_t g = 0; g < loop_.ghosts.size(); ++g) {
    const auto [a, b, c] = loop_.ghosts[g];
    if (a == b) {  // of a corner
      EXPECT_GE(static_cast<int>(g), num_boundary_edges());
      EXPECT_LE(num_triangles[a], 2);
      EXPECT_EQ(neighbours[a].size(), 6u);
      EXPECT_EQ(edges.count({a, c}) + edges.count({c, a}) > 0, true);
      EXPECT_EQ(loop_.points.col(num_vertices() + g),
                loop_.points.col(a) + loop_.points.col(a) - loop_.points.col(c));
      continue;
    }
    EXPECT_LT(static_cast<int>(g), num_boundary_edges());
    EXPECT_TRUE(edges.count({a, b}) == 1 && edges.count({b, a}) == 0) << a << ", " << b;
    EXPECT_EQ(triangles.count({a, b, c}) + triangles.count({b, c, a}) + triangles.count({c, a, b}),
              1u);
    EXPECT_EQ(loop_.points.col(num_vertices() + g),
              loop_.points.col(a) + loop_.points.col(b) - loop_.points.col(c));
  }
}

TEST_P(LoopMeshTest, LoopsAreClosedAndLieToTheRightOfTheirElements) {
  const auto vertex = [this](const ElementPoint& p) {
    EXPECT_TRUE((p.s == 0.0 || p.s == 1.0) && (p.t == 0.0 || p.t == 1.0) && p.s + p.t <= 1.0);
    return source_.triangles[p.element][p.s == 1.0 ? 1 : p.t == 1.0 ? 2 : 0];
  };
  std::vector<int> sizes;
  std::set<std::pair<int, int>> seen;
  for (const auto& loop : loop_.loops) {
    sizes.push_back(static_cast<int>(loop.size()));
    for (size_t i = 0; i < loop.size(); ++i) {
      const auto& edge = loop[i];
      EXPECT_EQ(edge.begin.element, edge.element);
      EXPECT_EQ(edge.end.element, edge.element);
      const int a = vertex(edge.begin), b = vertex(edge.end);
      EXPECT_EQ(b, vertex(loop[(i + 1) % loop.size()].begin));
      EXPECT_TRUE(seen.insert({a, b}).second);
      // Counterclockwise in its element: the element is to the left.
      const auto& t = source_.triangles[edge.element];
      EXPECT_TRUE((t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b));
    }
  }
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(sizes, GetParam().loops);
  EXPECT_EQ(static_cast<int>(seen.size()), num_boundary_edges());
}

TEST_P(LoopMeshTest, InterpolationPassesThroughThePoints) {
  LoopMesh mesh = loop_;
  ASSERT_TRUE(InterpolatePoints(&mesh));
  const LoopBasis basis(mesh.mesh);
  constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const double tolerance = 1e-12 * (1.0 + mesh.points.cwiseAbs().maxCoeff());
  for (int e = 0; e < basis.num_elements(); ++e) {
    for (int k = 0; k < 3; ++k) {
      const BasisMatrix rows = basis.Evaluate(e, kCorner[k][0], kCorner[k][1]);
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (int i = 0; i < rows.cols(); ++i) {
        x += rows(kValue, i) * mesh.points.col(basis.control_vertices(e)[i]);
      }
      EXPECT_LT((x - source_.vertices[source_.triangles[e][k]]).norm(), tolerance)
          << "element " << e << ", corner " << k;
    }
  }
  // Ghosts still mirror.
  for (size_t g = 0; g < mesh.ghosts.size(); ++g) {
    const auto [a, b, c] = mesh.ghosts[g];
    EXPECT_EQ(mesh.points.col(num_vertices() + g),
              mesh.points.col(a) + mesh.points.col(b) - mesh.points.col(c));
  }
}

TEST_P(LoopMeshTest, SubdivisionHasFourTrianglesForOneAndAVertexPerEdge) {
  const TriangleMesh fine = SubdivideLoop(source_);
  std::set<std::pair<int, int>> edges;
  for (const auto& t : source_.triangles) {
    for (int k = 0; k < 3; ++k) edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
  }
  EXPECT_EQ(fine.vertices.size(), source_.vertices.size() + edges.size());
  EXPECT_EQ(fine.triangles.size(), 4 * source_.triangles.size());
  std::vector<int> fine_loops;
  for (const auto& loop : MakeLoopMesh(fine).loops) {
    fine_loops.push_back(static_cast<int>(loop.size()));
  }
  std::sort(fine_loops.begin(), fine_loops.end());
  std::vector<int> twice = GetParam().loops;
  for (int& n : twice) n *= 2;
  EXPECT_EQ(fine_loops, twice);
}

// Of closed meshes, and of open ones where elements do not touch the boundary. Children of element
// e: 4 e + k at its corner k and 4 e + 3 in the middle.
TEST_P(LoopMeshTest, SubdivisionKeepsTheLimitSurface) {
  const LoopMesh fine = MakeLoopMesh(SubdivideLoop(source_));
  const ShellSurface before(loop_), after(fine);
  const std::set<int> boundary = [this] {
    std::set<int> result;
    for (const auto& ghost : loop_.ghosts) result.insert({ghost.a, ghost.b});
    return result;
  }();
  double largest = 0.0;
  for (int e = 0; e < before.num_elements(); ++e) {
    const auto& t = source_.triangles[e];
    const bool touches = std::any_of(
        t.begin(), t.end(), [&boundary](int vertex) { return boundary.count(vertex) > 0; });
    if (touches) continue;
    for (const double s : {0.05, 0.3, 0.6}) {
      for (const double u : {0.03, 0.35}) {
        const Eigen::Vector3d x = before.Position({e, 0.5 * s, 0.5 * u});
        largest = std::max(largest, (after.Position({4 * e, s, u}) - x).norm());
        const Eigen::Vector3d y = before.Position({e, 0.5 + 0.5 * s, 0.5 * u});
        largest = std::max(largest, (after.Position({4 * e + 1, s, u}) - y).norm());
        const Eigen::Vector3d z = before.Position({e, 0.5 * s, 0.5 + 0.5 * u});
        largest = std::max(largest, (after.Position({4 * e + 2, s, u}) - z).norm());
        // (ab, bc, ca) = (1/2, 0), (1/2, 1/2), (0, 1/2).
        const Eigen::Vector3d m = before.Position({e, 0.5 - 0.5 * u, 0.5 * (s + u)});
        largest = std::max(largest, (after.Position({4 * e + 3, s, u}) - m).norm());
      }
    }
  }
  EXPECT_LT(largest, 1e-12);
}

TEST_P(LoopMeshTest, HasATangentPlaneEverywhere) { EXPECT_EQ(FindSingularVertex(loop_), -1); }

TEST(FindSingularVertexTest, FindsACollapsedNeighbourhood) {
  TriangleMesh mesh = MakeIcosphere(1.0, 3);
  // All neighbours of vertex 0 on a line.
  std::set<int> neighbours;
  for (const auto& t : mesh.triangles) {
    if (std::count(t.begin(), t.end(), 0) > 0) neighbours.insert(t.begin(), t.end());
  }
  for (const int i : neighbours) mesh.vertices[i] = {0.1 * i, 0.0, 1.0};
  EXPECT_EQ(FindSingularVertex(MakeLoopMesh(mesh)), 0);
}

double LimitArea(const ShellSurface& surface) {
  double area = 0.0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (const StrainPoint& point : surface.QuadraturePoints(e, 12)) area += point.area;
  }
  return area;
}

// Ghosts continue the lattice along a straight rim and around corners, those of one triangle and
// those of two, also where cells are no squares.
TEST(FlatSheetTest, LimitIsTheSheetUpToItsCorners) {
  const int m = 6, n = 5;
  TriangleMesh mesh = Lattice(m, n);
  for (auto& x : mesh.vertices) x = Eigen::Vector3d(x.x() + 0.3 * x.y(), 0.4 * x.y(), 0.0);
  LoopMesh loop = MakeLoopMesh(mesh);
  EXPECT_EQ(loop.ghosts.size(), 2u * (m + n) + 2 * 2 + 2 * 1);
  for (const bool interpolated : {false, true}) {
    if (interpolated) {
      ASSERT_TRUE(InterpolatePoints(&loop));
    }
    const ShellSurface sheet(loop);
    for (int e = 0; e < sheet.num_elements(); ++e) {
      const auto& t = mesh.triangles[e];
      for (const auto& [s, u] : std::vector<std::pair<double, double>>{
               {0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0, 0.5}, {0.5, 0.5}, {0.2, 0.3}, {0.7, 0.2}}) {
        const Eigen::Vector3d expected =
            (1.0 - s - u) * mesh.vertices[t[0]] + s * mesh.vertices[t[1]] + u * mesh.vertices[t[2]];
        EXPECT_LT((sheet.Position({e, s, u}) - expected).norm(), 1e-13)
            << e << ": " << s << ", " << u;
      }
    }
    EXPECT_NEAR(LimitArea(sheet), 0.4 * m * n, 1e-12 * m * n);
  }
}

// Two triangles at a vertex of a straight rim are no corner.
TEST(FlatSheetTest, AStraightRimHasNoCorners) {
  // Diagonals that meet no vertex in the middle of the lower rim.
  TriangleMesh mesh;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 3; ++i) mesh.vertices.emplace_back(i, j, 0.0);
  }
  mesh.triangles = {{0, 1, 3}, {1, 4, 3}, {1, 5, 4}, {1, 2, 5}};
  const auto corners = [](const LoopMesh& loop) {
    std::multiset<int> result;
    for (const auto& ghost : loop.ghosts) {
      if (ghost.a == ghost.b) result.insert(ghost.a);
    }
    return result;
  };
  EXPECT_EQ(corners(MakeLoopMesh(mesh)), (std::multiset<int>{0, 0, 2, 2, 3, 5}));
}

// No corners: the rims of a tube are where its vertices are, at every point and not only there.
TEST(TubeTest, RimsAreWhereTheVerticesAre) {
  const ShellSurface tube(MakeLoopMesh(Tube(8, 3)));
  ASSERT_EQ(tube.num_loops(), 2);
  for (int k = 0; k < 2; ++k) {
    const auto points = tube.SidePoints(ShellSurface::Loop(k), 5);
    ASSERT_EQ(points.size(), 8u * 5u);
    const double z = points.front().point.position.z() > 1.0 ? 2.0 : 0.0;
    for (const auto& p : points) EXPECT_NEAR(p.point.position.z(), z, 1e-14);
  }
}

}  // namespace
}  // namespace darboux
