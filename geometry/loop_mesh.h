#ifndef DARBOUX_GEOMETRY_LOOP_MESH_H_
#define DARBOUX_GEOMETRY_LOOP_MESH_H_

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "geometry/control_mesh.h"
#include "geometry/parameter_domain.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// Control mesh of a Loop surface of any topology: closed, or open with any number of boundary
// loops, each surrounded by a ring of ghost triangles (see ControlMesh), so that the limit surface
// of the elements is all of the shell.
struct LoopMesh {
  ControlMesh mesh;
  Eigen::Matrix3Xd points;  // a column per vertex of `mesh`, ghosts last

  // Edge of an element on the boundary, the element to its left.
  struct BoundaryEdge {
    int element = 0;
    ElementPoint begin, end;
  };
  // One closed list of edges per boundary loop, each edge beginning where the last one ends.
  std::vector<std::vector<BoundaryEdge>> loops;

  // Of every ghost, in order: it lies at points[a] + points[b] - points[c] when made, across the
  // boundary edge (a, b) from c. Those of edges come first; then those of corners, a == b the
  // corner, opposite to a neighbour c: they make six neighbours of a vertex with one triangle, or
  // with two where that brings the limit point nearer to it, as in a corner of a lattice.
  struct Ghost {
    int a = 0, b = 0, c = 0;
  };
  std::vector<Ghost> ghosts;

  // The rest are for meshes refined locally (hierarchical_mesh.h), which have vertices and
  // triangles of several levels; empty otherwise.
  //
  // The vertex stands for this sum of (unknown, factor); an unknown for itself alone. Points are
  // those of the vertices, not to be summed.
  std::vector<std::vector<std::pair<int, double>>> folds;
  // Of each vertex: number of the place on the surface that it is the corner of; vertices of
  // different levels share it.
  std::vector<int> places;
  // Of each element, of its edges from corner k to corner k + 1: the vertex in the middle where the
  // elements across are half as large; else -1.
  std::vector<std::array<int, 3>> hanging;
};

// C. Loop (1987): weight of each of n neighbours in the subdivision rule of a vertex, which itself
// has the rest of 1.
double LoopVertexWeight(int n);

// Vertices of the mesh are control points; vertex and triangle numbers stay. Precondition (see
// mesh_doctor): an oriented 2-manifold, every vertex on at most one boundary loop.
LoopMesh MakeLoopMesh(const TriangleMesh& mesh);

// Moves the control points so that the limit surface passes through the present ones (one sparse
// solve). False where the system is singular.
bool InterpolatePoints(LoopMesh* mesh);

// The first vertex where the limit surface has no tangent plane (or none that doubles can tell:
// sizes beyond 1e75 or below 1e-75), -1 where there is none.
int FindSingularVertex(const LoopMesh& mesh);

// One step of Loop subdivision: the same limit surface of a closed mesh with four times the
// elements; along boundaries the ghost ring is made anew, which changes the surface there.
TriangleMesh SubdivideLoop(const TriangleMesh& mesh);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_LOOP_MESH_H_
