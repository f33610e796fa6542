#ifndef DARBOUX_GEOMETRY_IMPLICIT_MESH_H_
#define DARBOUX_GEOMETRY_IMPLICIT_MESH_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <string>

#include "geometry/expression.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// What MeshImplicitSurface takes for a mistake, and how fine it may get.
struct ImplicitMeshOptions {
  // Cut the surface along the box where it leaves it; else that is a mistake.
  bool allow_boundary = false;
  // Mesh all pieces of the surface; else more than one is a mistake.
  bool allow_several_components = false;
  // A triangle whose normal differs by more than this from the surface's at a corner is too coarse
  // for the surface there, radians; 0 < angle < pi/2.
  double max_normal_angle = M_PI / 3.0;
  // Mistakes in the edge length are told before they fill the memory.
  int max_triangles = 2000000;
  // Points at which the function is sampled: the volume of the box over (0.8 edge lengths)^3.
  std::int64_t max_samples = 400000000;
  // Of splits, collapses, flips and relaxations, and once more of flips and relaxations alone.
  int num_remeshing_iterations = 12;

  bool IsValid(std::string* error) const;
};

// Meshes the smooth surface f(x, y, z) = 0 within the box by even triangles. The function is an
// expression of x, y and z, in this order, negative inside and positive outside: triangles are seen
// counterclockwise from where f > 0.
//
// A lattice 0.8 times as wide as the target edge length finds the surface (marching tetrahedra, so
// that it is a 2-manifold whatever f is); remeshing then makes edges 0.6 to 1.5 times the target
// and angles more than about 30 degrees, with 5 to 7 edges at all but a few vertices. These are
// what is observed on surfaces whose radii of curvature are more than two edge lengths
// (tests/implicit_mesh_test.cc). Vertices lie on the surface to 1e-12 of the size of the box, if
// rounding in f allows. The same input gives the same mesh; in another unit of length, the same
// but for rounding.
//
// With allow_boundary the surface ends at the box: vertices of the boundary lie in its faces to
// the last digit, and where the surface crosses an edge of the box there is a vertex.
//
// Returns false and says why in one line, with what was found, where, and what is allowed, if
//  - the box, the edge length or the options make no sense,
//  - f is not finite at a point of the lattice, or its gradient at one of the surface,
//  - f has no zero in the box, or the surface leaves it (see allow_boundary),
//  - f is negative outside,
//  - there are several pieces (see allow_several_components),
//  - the gradient vanishes on the surface: a cone's apex, a line where it crosses itself,
//  - the edge length is too large for the shape (max_normal_angle; pieces smaller than an edge,
//    if sampling came near them) or needs more than max_triangles or max_samples.
bool MeshImplicitSurface(const Expression& function,
                         const Eigen::AlignedBox3d& bounds,
                         double target_edge_length,
                         const ImplicitMeshOptions& options,
                         TriangleMesh* mesh,
                         std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_IMPLICIT_MESH_H_
