#ifndef DARBOUX_GEOMETRY_HIERARCHICAL_MESH_H_
#define DARBOUX_GEOMETRY_HIERARCHICAL_MESH_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/loop_mesh.h"

namespace darboux {

// Local refinement of a Loop surface by truncated hierarchical Loop splines: C. Giannelli,
// B. Juettler & H. Speleers, "THB-splines" (Computer Aided Geometric Design 29, 2012), with the
// subdivision masks of C. Loop (1987) in place of those of B-splines.
//
// Level l + 1 is the Loop subdivision of level l, ghost ring included: every mask that a vertex of
// the shell or of its first ring needs exists there, so that the limit surface stays exactly the
// same, at boundaries too (SubdivideLoop makes the ring anew instead). Omega_(l+1), within
// Omega_l, is the union of the level-l triangles that are refined; what is not refined of Omega_l
// are leaves, the elements of the shell. A vertex of level l is
//
//   an unknown    where its support (the triangles of the shell with a corner at it or at one of
//                 its neighbours) lies in Omega_l but not in Omega_(l+1); Omega_0 is everything
//   made of others  elsewhere: the sum of the vertices of level l - 1 in its mask, which are
//                 unknowns or made of others again.
//
// The second line is the truncation. The basis is a partition of unity, linearly independent,
// spans a space that grows with Omega, and keeps coefficients: the control point of an unknown of
// level l is the one that l steps of subdivision would give, so that a motion of control points is
// the same motion of the surface. Between leaves of different levels displacements are as smooth as
// within a level (twice differentiable but for vertices of a valence other than 6).

// Which triangles are refined, in numbers that do not depend on what else is: level 0 has the
// numbers of the mesh refined, and the children of triangle (A, B, C) number t have the numbers
//
//   4 t: (A, AB, CA),  4 t + 1: (AB, B, BC),  4 t + 2: (CA, BC, C),  4 t + 3: (AB, BC, CA)
//
// with AB the vertex on the edge from A to B.
struct MeshRefinement {
  std::vector<std::vector<std::int64_t>> refined;  // per level, ascending; the last not empty

  bool empty() const { return refined.empty(); }
  bool operator==(const MeshRefinement& other) const { return refined == other.refined; }
  // Whether all that the other refines is refined.
  bool Contains(const MeshRefinement& other) const;
};

// Point of a child in its parent, point of a triangle in the child that has it.
ElementPoint ParentPoint(int child, const ElementPoint& point);

// The displacement space of a locally refined mesh, as ShellSurface takes it.
class HierarchicalMesh {
 public:
  static constexpr int kMaxLevels = 20;

  // `base` as MakeLoopMesh makes it. Refines besides what has to be so that the vertices that a
  // leaf of level l depends on are unknowns of levels l and l - 1 (an admissible mesh of class 2:
  // A. Buffa & C. Giannelli, "Adaptive isogeometric methods with hierarchical splines", 2016); then
  // leaves that share an edge differ by a level at most. Cost in proportion to the base and to what
  // is refined. Triangles that do not exist in `refinement` are an error of the caller (CHECK).
  HierarchicalMesh(const LoopMesh& base, const MeshRefinement& refinement);

  int num_levels() const { return static_cast<int>(levels_.size()); }
  const MeshRefinement& refinement() const { return refinement_; }

  // For ShellSurface: the leaves of all levels are its elements, depth first, the vertices of all
  // levels that leaves depend on its vertices, those made of others with LoopMesh::folds.
  const LoopMesh& mesh() const { return mesh_; }

  // A leaf: its triangle by its number among those of its level.
  struct Cell {
    int level = 0;
    std::int64_t triangle = 0;
  };
  const Cell& cell(int element) const { return cells_[element]; }
  // The element that has a point of a triangle of level 0.
  ElementPoint Locate(const ElementPoint& base_point) const;
  // Inverse.
  ElementPoint BasePoint(const ElementPoint& point) const;
  // Level of a vertex of mesh().
  int level(int vertex) const { return places_[vertex].level; }
  bool IsUnknown(int vertex) const;

  // The refinement with more: these elements; the whole support of these unknowns (its triangles of
  // their own level), which makes them give way to unknowns of the next level.
  MeshRefinement RefineElements(const std::vector<int>& elements) const;
  MeshRefinement RefineSupports(const std::vector<int>& unknowns) const;
  // Whether `more`, which contains this refinement, refines all of an unknown's support: it is no
  // unknown there.
  bool GivesWay(int unknown, const MeshRefinement& more) const;
  // The supports of all vertices at corners of triangles of level `level` that have a point within
  // a ball (as plane triangles through limit points), for each ball of the nearest triangle at
  // least. *beyond (may be null): of each ball the distance by which the nearest triangle lies
  // farther from its surface than that triangle's longest edge; infinite without triangles.
  struct Ball {
    Eigen::Vector3d center;
    double radius = 0.0;
  };
  MeshRefinement RefineNear(const std::vector<Ball>& balls,
                            int level,
                            std::vector<double>* beyond) const;

  // A column per vertex of mesh() -> the same field on a finer mesh (finer.refinement() contains
  // this one, same base), a column per vertex of its mesh(): exact, as the spaces are nested. Zero
  // where a vertex is no unknown.
  Eigen::Matrix3Xd Prolong(const Eigen::Matrix3Xd& values, const HierarchicalMesh& finer) const;

 private:
  struct Triangle {
    std::array<int, 3> corners{};
    std::int64_t number = 0;
    int parent = -1;  // on the level below
    std::array<int, 4> children{-1, -1, -1, -1};
    bool is_shell = false;    // no ghost
    bool is_domain = false;   // in Omega of its level
    bool is_refined = false;  // in Omega of the next
    int element = -1;
  };
  struct Vertex {
    int a = -1, b = -1;          // of the level below: it descends from vertex a = b or edge (a, b)
    std::vector<int> triangles;  // around it, those that exist
    int child = -1;
    std::vector<std::pair<int, int>> edge_children;  // (other end, child), of edges to higher ones
    bool is_candidate = true;                        // support in Omega of its level
    bool is_dropped = false;                         // and in that of the next
    Eigen::Vector3d point;
    int number = -1;  // in mesh_
  };
  struct Level {
    std::vector<Triangle> triangles;
    std::vector<Vertex> vertices;
  };
  struct Place {
    int level = 0, vertex = 0;
  };

  void Build(const LoopMesh& base);
  void AddLevel();
  int AddVertex(int level, int a, int b);
  int ChildOfVertex(int level, int a);
  int ChildOfEdge(int level, int a, int b);
  int FindEdgeChild(int level, int a, int b) const;
  int MakeChild(int level, int triangle, int child);
  // Calls use(vertex of the level below, factor).
  template <typename Use>
  void ForEachInMask(int level, int vertex, const Use& use) const;
  template <typename Use>
  void ForEachInSupport(int level, int vertex, const Use& use) const;  // triangles of the shell
  bool Close(MeshRefinement* more) const;
  void MakeMesh(const LoopMesh& base);
  void AddLeaves(int level, int triangle);
  Eigen::Vector3d LimitPoint(int level, int vertex) const;
  void AddSupport(int level, int vertex, std::vector<std::vector<std::int64_t>>* refined) const;
  MeshRefinement Merged(std::vector<std::vector<std::int64_t>> more) const;

  MeshRefinement refinement_;
  std::vector<Level> levels_;
  LoopMesh mesh_;
  std::vector<Cell> cells_;
  std::vector<Place> places_, leaves_;  // of vertices and elements of mesh_; leaves_: triangle
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_HIERARCHICAL_MESH_H_
