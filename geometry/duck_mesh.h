#ifndef DARBOUX_GEOMETRY_DUCK_MESH_H_
#define DARBOUX_GEOMETRY_DUCK_MESH_H_

#include <Eigen/Geometry>
#include <string>

#include "geometry/triangle_mesh.h"

namespace darboux {

// A bath duck, 90 mm long (x, the beak ahead), 70 mm wide (y) and 80 mm tall (z), in metres: the
// smooth union of ellipsoids q_i <= 0 for body, neck, head, beak and tail,
//
//   f = -k log sum_i exp(-q_i / k),  q_i = r_i / 2 (|S_i (p - c_i)|^2 - 1),
//
// a formula of x, y, z for Expression, smooth everywhere, negative inside; f is about the distance
// from the surface near it. y = 0 is its plane of symmetry. Made for this project.
std::string DuckFormula();

// A box around it.
Eigen::AlignedBox3d DuckBounds();

// The duck as a closed mesh of 10 n^2 + 2 vertices with the connectivity of MakeIcosphere(., n):
// valence 5 at twelve vertices and 6 elsewhere. The icosphere follows the surface while the duck's
// parts grow out of one sphere, and is evened within it. Vertices lie on the surface; y = 0 is
// a plane of symmetry of the mesh. Requires n >= 4; fewer vertices do not make a duck.
TriangleMesh MakeDuckMesh(int frequency);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_DUCK_MESH_H_
