#ifndef DARBOUX_SOLVER_INP_FINGER_H_
#define DARBOUX_SOLVER_INP_FINGER_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"
#include "solver/scene.h"

namespace darboux {

// Rigid fingers as a layer of solid elements (solver/inp_export.h).

// The surface of a finger, placed in the scene: triangles with corners on it, seen counterclockwise
// from outside. Arcs have `arc` divisions to 45 degrees. A plane is a square about `center` of the
// half width `reach`; a mesh is itself. Precondition: no pin.
TriangleMesh MakeFingerSurface(const FingerSpec& finger,
                               const Eigen::Vector3d& position,
                               const Eigen::Matrix3d& rotation,
                               const Eigen::Vector3d& center,
                               double reach,
                               int arc);

// Wedges of six nodes beneath the triangles: `inner` has a point per vertex of the surface, `depth`
// below it. The outer nodes are the last three of each.
std::vector<Eigen::Vector3d> InnerPoints(const TriangleMesh& surface, double depth);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_FINGER_H_
