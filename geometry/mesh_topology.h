#ifndef DARBOUX_GEOMETRY_MESH_TOPOLOGY_H_
#define DARBOUX_GEOMETRY_MESH_TOPOLOGY_H_

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// The edges of triangles with three different vertices each, wound any way, manifold or not.
class EdgeTable {
 public:
  // Side `corner` of a triangle runs from its corner `corner` to the next one.
  struct Side {
    int triangle = 0;
    int corner = 0;
    bool is_forward = true;  // From the lower to the higher vertex.
  };
  // An edge with the triangles at it, whichever way these are wound.
  struct Edge {
    std::array<int, 2> vertices{};  // Ascending.
    int first = 0;                  // Its sides are sides()[first] to sides()[first + count - 1],
    int count = 0;                  // in the order of the triangles.
  };

  explicit EdgeTable(const std::vector<std::array<int, 3>>& triangles);

  const std::vector<Edge>& edges() const { return edges_; }  // Ascending.
  const std::vector<Side>& sides() const { return sides_; }
  int EdgeOf(int triangle, int corner) const {
    return edge_of_[static_cast<std::size_t>(3 * triangle + corner)];
  }
  // The side across an edge with two triangles; null at any other edge.
  const Side* Across(int triangle, int corner) const;
  // Whether some triangle has this side, in either direction.
  bool HasEdge(int a, int b) const;

 private:
  std::vector<Edge> edges_;
  std::vector<Side> sides_;
  std::vector<int> edge_of_;  // Of side 3 * triangle + corner.
};

// A forest of sets of 0 ... n - 1 (union-find).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n);
  int Find(int i);  // The same number for all of a set: its lowest.
  void Unite(int i, int j);

 private:
  std::vector<int> parent_;
};

// Fans of triangles around vertices: corners (3 * triangle + corner) in the same set belong to the
// same vertex and hang together by triangles that share an edge there. A vertex of a manifold has
// one fan.
DisjointSets VertexFans(const std::vector<std::array<int, 3>>& triangles, const EdgeTable& edges);

// Windings compared across edges with two triangles.
struct Orientation {
  int num_patches = 0;           // Sets of triangles that hang together by such edges.
  std::vector<int> patch;        // Of each triangle.
  std::vector<char> is_against;  // Whether each is wound against the first triangle of its patch.
  std::vector<int> contradictory_edges;  // That no choice of windings agrees with.
};
Orientation CompareWindings(const std::vector<std::array<int, 3>>& triangles,
                            const EdgeTable& edges);

// The functions below skip triangles with repeated vertices or with ones that do not exist.

// The closed loops of edges with one triangle, as vertices in order: each starts with its lowest
// vertex and runs as its first triangle does, so that the surface lies to the left. At a vertex
// where several fans meet a loop stays with its fan. Sorted by first vertices. Loops that end at an
// edge with three or more triangles are left open, from one end to the other.
std::vector<std::vector<int>> BoundaryLoops(const TriangleMesh& mesh);

// A set of triangles that hang together by vertices.
struct MeshComponent {
  std::vector<int> triangles;  // Ascending.
  int num_vertices = 0;
  int num_edges = 0;
  int num_boundary_loops = 0;
  bool is_manifold = true;    // One or two triangles at each edge and one fan at each vertex.
  bool is_orientable = true;  // Windings can be made to agree.

  bool is_closed() const { return num_boundary_loops == 0; }
  int EulerCharacteristic() const {
    return num_vertices - num_edges + static_cast<int>(triangles.size());
  }
  // Number of handles (torus: 1) or, where not orientable, of cross-caps (Moebius strip: 1) once
  // the boundary loops are filled; -1 where not manifold.
  int Genus() const;
};
// Sorted by first triangles.
std::vector<MeshComponent> MeshComponents(const TriangleMesh& mesh);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_TOPOLOGY_H_
