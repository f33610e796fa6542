#ifndef DARBOUX_SOLVER_FIELDS_H_
#define DARBOUX_SOLVER_FIELDS_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/shell_surface.h"
#include "solver/shell_problem.h"

namespace darboux {

// What people look at: strains, stresses and energy of a deformed shell at surface points.
//
// Units are those of the scene; SI in comments. Symmetric tensors are written (11, 22, 12) in the
// orthonormal frame of the rest surface: t1 along the u-line, n = sigma_u x sigma_v / |.|,
// t2 = n x t1. Component 12 is the tensor's own, e_12, half the engineering shear. Stresses of the
// nonlinear theory are second Piola-Kirchhoff: forces per rest length, rest frame.

// The part of a point's fields that no displacement changes; made once per point, for all steps.
struct FieldSite {
  int element = 0;
  StrainPoint point;  // rest position, frame, curvatures, weights
  std::array<double, 2> uv{};
  Eigen::Vector2d principal_curvatures;  // kappa_1 >= kappa_2 of the rest surface, 1/m
  // Unit tangents of the lines of curvature; at an umbilic, where every tangent is one, t1 and t2.
  Eigen::Vector3d principal_direction_1, principal_direction_2;
};

FieldSite MakeFieldSite(const ShellSurface& surface, const ElementPoint& at);

// What the results say of one point of a deformed shell.
struct ShellFields {
  Eigen::Vector3d position;      // at rest, m
  Eigen::Vector3d displacement;  // m
  // Unit normal of the deformed middle surface; the rest normal where the deformed one has none.
  Eigen::Vector3d normal;
  Eigen::Vector3d membrane_strain;            // e_ij, 1
  Eigen::Vector2d principal_membrane_strain;  // e_1 >= e_2
  // rho_ij, 1/m: positive where the curvature towards n grows. NaN where the deformed surface has
  // no normal, and with it everything below that bending enters into.
  Eigen::Vector3d bending_strain;
  Eigen::Vector3d
      membrane_force;  // n_ij = E h / (1 - nu^2) ((1 - nu) e_ij + nu e_kk delta_ij), N/m
  // m_ij = D ((1 - nu) rho_ij + nu rho_kk delta_ij), D = E h^3 / (12 (1 - nu^2)), N m/m. A positive
  // moment compresses the top face.
  Eigen::Vector3d moment;
  // Von Mises stress of the plane stress n/h -+ 6 m/h^2 at the faces +h/2 n (top) and -h/2 n, Pa.
  double von_mises_top = 0.0, von_mises_bottom = 0.0;
  // n_ij e_ij / 2 and m_ij rho_ij / 2 per rest area, J/m^2. An initial stress is part of n and m,
  // and its work n0_ij e_ij, m0_ij rho_ij of the energy.
  double membrane_energy_density = 0.0, bending_energy_density = 0.0;
};

// Fields under the given control displacements (a column per control vertex), in the strain
// measure of the problem.
ShellFields EvaluateFields(const ShellProblem& problem,
                           const Eigen::Matrix3Xd& displacements,
                           const FieldSite& site);
// The same at any point in the problem's present state.
ShellFields EvaluateFields(const ShellProblem& problem, const ElementPoint& at);

// Where fields are sampled for output: the corners of all elements and the middles of their edges,
// each once, so that the four triangles of every element close up across periodic seams.
struct OutputMesh {
  std::vector<ElementPoint> points;
  std::vector<std::array<int, 3>> triangles;  // counterclockwise seen from the side of n
  // Of each triangle: its element, elements in order, and the places (s, t) of its corners there.
  std::vector<int> elements;
  std::vector<std::array<std::array<double, 2>, 3>> places;
};
OutputMesh MakeOutputMesh(const ShellSurface& surface);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FIELDS_H_
