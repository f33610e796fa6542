#ifndef DARBOUX_GEOMETRY_MESH_DOCTOR_H_
#define DARBOUX_GEOMETRY_MESH_DOCTOR_H_

#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// What makes a triangle mesh unfit for a shell or a finger. All vertices and triangles of a kind
// are one defect.
struct MeshDefect {
  enum class Kind {       // vertices | triangles below
    kNoTriangles,         // |
    kNonFiniteVertex,     // those vertices |
    kIndexOutOfRange,     // | triangles with a vertex that does not exist
    kDegenerateTriangle,  // | a repeated vertex or no area
    kDuplicateTriangle,   // | those with the vertices of an earlier one, wound any way
    kOpenSeam,            // pairs: a vertex, and the lower one that it coincides with |
    kNonManifoldEdge,     // pairs: ends of edges | all triangles at these, 3 or more each
    kNonOrientable,       // | on either side of the edges where the windings disagree
    kFlippedTriangle,     // | those to turn over
    kInsideOut,           // | all of closed pieces whose normals point inwards
    kNonManifoldVertex,   // where several fans of triangles meet (bow-tie) |
    kLowValence,          // of the boundary with too few edges |
    kIsolatedVertex,      // that no triangle uses |
    kSeveralComponents,   // | the first one of each piece
    kHole,                // all loops, one after the other | (MeshDoctorOptions::closed)
    kSelfIntersection,    // | pairs that pass through or lie on each other
  };
  Kind kind;
  std::vector<int> vertices;
  std::vector<int> triangles;
  // One line for people: how many of what, and which; at most 8, then "... and N more". Vertices
  // and triangles count from 0.
  std::string text;
};

// "open seam" and so on.
std::string Name(MeshDefect::Kind kind);

// "3, 7, 9"; after eight "... and 12 more".
std::string ListIds(const std::vector<int>& ids);

// What a mesh is to be, and how closely it is looked at.
struct MeshDoctorOptions {
  bool closed = false;       // Boundary loops are holes.
  bool allow_seams = false;  // A slit may lie open, as in a slit ring.
  int max_components = 1;    // >= 1
  // Edges that a vertex of the boundary needs, >= 2; with 3 no triangle may have two sides on the
  // boundary. (An inner vertex with less than 3 shows as a duplicate triangle.)
  int min_boundary_valence = 2;
  bool check_self_intersections = true;
  // Fraction of the bounding box' diagonal, below which points coincide and surfaces touch: the
  // rounding of coordinates that once were floats. 1e-15 to 1e-3
  double tolerance = 1e-7;
  // Fraction of the diagonal squared below which a triangle has no area; neither has one that is
  // lower than the tolerance. >= 0
  double min_area = 1e-12;
};

// Everything that is wrong with the mesh, most basic kinds first; empty: nothing. No mesh is too
// broken: what one defect makes meaningless is left out of the later checks (triangles without
// vertices of all, duplicates of the topological ones, triangles without area of the geometric
// ones, and seams count as sewn, so that a soup of triangles is one defect and not one for each).
// Independent of size and position of the mesh up to rounding (of positions far off as well). At
// most 1000 pairs of intersecting triangles are looked for.
std::vector<MeshDefect> FindMeshDefects(const TriangleMesh& mesh, const MeshDoctorOptions& options);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_DOCTOR_H_
