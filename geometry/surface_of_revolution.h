#ifndef DARBOUX_GEOMETRY_SURFACE_OF_REVOLUTION_H_
#define DARBOUX_GEOMETRY_SURFACE_OF_REVOLUTION_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// Turns a profile in the half plane y = 0, x >= 0 about the z axis: `meridians` >= 3 copies of it,
// joined by triangles that are wound counterclockwise seen from outside where the profile comes
// from above (z falls along it), else the other way round. An end that is nearer to the axis than
// the profile's next point is closed by a point on the axis, at its height. Chords leave out
// r (1 - cos(pi / meridians)).
//
// False and *error ("found ...; allowed ...") for fewer than two points, points off the half plane
// by more than 1e-9 of the size, or points on the axis between the ends.
bool Revolve(const std::vector<Eigen::Vector3d>& profile,
             int meridians,
             TriangleMesh* mesh,
             std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SURFACE_OF_REVOLUTION_H_
