#ifndef DARBOUX_GEOMETRY_MESH_FINGER_H_
#define DARBOUX_GEOMETRY_MESH_FINGER_H_

#include <memory>
#include <string>

#include "geometry/finger_shape.h"
#include "geometry/triangle_mesh.h"

namespace darboux {

// The body inside a closed triangle mesh, in the mesh's own coordinates.
//
// The distance is exact, to the nearest face, edge or vertex, found in a tree of boxes. Its sign
// is that of the (angle-weighted) pseudo-normal of this feature: J. A. Baerentzen and H. Aanaes,
// "Signed distance computation using the angle weighted pseudonormal" (2005). The Hessian is the
// feature's: 0 for a face, a cylinder's for an edge, a sphere's for a vertex. So the curvature of a
// finely triangulated sphere sits in its edges and vertices, and only its average is a sphere's;
// at a distance, e.g. half the shell's thickness, forces vary continuously if the body is convex.
//
// Null and a message where the mesh is not a closed surface with all normals outward: indices out
// of range, non-finite coordinates, triangles without area, edges that do not have two triangles
// wound alike, a negative volume. Intersections of the surface with itself are not looked for.
// O(n log n) for n triangles; O(log n) per evaluation close to the surface. Thread-safe.
std::shared_ptr<const FingerShape> MakeMeshFinger(const TriangleMesh& mesh, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_FINGER_H_
