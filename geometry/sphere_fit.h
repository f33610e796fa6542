#ifndef DARBOUX_GEOMETRY_SPHERE_FIT_H_
#define DARBOUX_GEOMETRY_SPHERE_FIT_H_

#include "geometry/loop_mesh.h"

namespace darboux {

// Moves the control points of a closed Loop surface, which may be refined locally, so that it is
// the nearest that its unknowns allow to the sphere about the origin: with x(p) the surface and
// T(p) = radius x(p) / |x(p)| its projection, the new points minimise
//
//   integral of |sum_i N_i(p) c_i - T(p)|^2 dA,
//
// one sparse solve. Distances from the sphere fall like the fourth power of the edges, also where
// these are shorter by local refinement. False where the system is singular or the surface passes
// through the origin.
bool FitToSphere(double radius, LoopMesh* mesh);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SPHERE_FIT_H_
