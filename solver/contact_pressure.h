#ifndef DARBOUX_SOLVER_CONTACT_PRESSURE_H_
#define DARBOUX_SOLVER_CONTACT_PRESSURE_H_

#include <Eigen/Core>
#include <vector>

#include "geometry/shell_surface.h"
#include "solver/fields.h"
#include "solver/grasp.h"

namespace darboux {

// The pressure of fingers as a field, Pa (force per area of the rest surface), from the contact
// points, each of which has a pressure p_q and stands for an area a_q: the lumped projection onto
// the functions phi_i that are linear on the triangles of the output mesh,
//
//   p_i = sum_q p_q a_q phi_i(x_q) / A_i,   A_i = a third of the rest triangles around point i.
//
// It is nowhere negative, and keeps what counts: sum p_i A_i, which is the integral of the linear
// field over the rest triangles, is the sum of the fingers' normal forces. Contact that is smaller
// than a triangle is spread over it: the largest value is then below the largest pressure of a
// contact point (fingers.NAME.largest_pressure). A pin's force acts at one point; here it is spread
// over the triangles around it, a pressure that grows as the mesh gets finer.
//
// One value per point of the mesh; zeros where nothing touches.
std::vector<double> MakeContactPressure(const ShellSurface& surface,
                                        const OutputMesh& mesh,
                                        const std::vector<ContactPointReport>& contact);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CONTACT_PRESSURE_H_
