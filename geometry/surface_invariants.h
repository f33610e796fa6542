#ifndef DARBOUX_GEOMETRY_SURFACE_INVARIANTS_H_
#define DARBOUX_GEOMETRY_SURFACE_INVARIANTS_H_

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/surface_jet.h"

namespace darboux {

// Differential geometry of one surface point: fundamental forms, curvatures, an orthonormal frame
// (t1, t2, n) with its derivatives, and the covariant derivatives that the paper's strains are made
// of; Tian & Jia (2010), Sec. III, eqs. (39)-(44) and Appendix B. Lengths in the unit of sigma,
// e.g. metres, curvatures in its inverse.
//
// Conventions
//   n        = sigma_u x sigma_v / |.|; curvature is positive where the surface bends towards n
//              (a sphere with outward normals has -1/R twice)
//   kappa    kappa_1 >= kappa_2, always accurate, umbilic or not
//   frame    t_i = xi_i sigma_u + eta_i sigma_v, (t1, t2, n) right-handed; of the two unit vectors
//            along a principal direction t1 is the one whose larger component, comparing
//            xi sqrt(E) with eta sqrt(G), is positive
//   a, b     parameter indices (0 = u, 1 = v);  i, j frame indices (0 = t1, 1 = t2)
//
// Umbilics. Where kappa_1 = kappa_2 there are no principal directions, and close by they turn at
// the rate |grad II| / (kappa_1 - kappa_2), so that every formula with their derivatives loses
// digits. Both are measured without reference to the parameters (nabla II: covariant derivative of
// the second form, 1/length^2, Frobenius norm in an orthonormal frame):
//
//   umbilic  <=>  (kappa_1 - kappa_2)^2 <= tolerance^2 (kappa_1^2 + kappa_2^2 + |nabla II|)
//
// or kappa_1 - kappa_2 is below what rounding alone explains, 64 machine epsilons times
// |sigma_uu| / |sigma_u|^2 + |sigma_uv| / (|sigma_u| |sigma_v|) + |sigma_vv| / |sigma_v|^2 (the
// second form is what is left of these) plus 1 / |sigma_u| + 1 / |sigma_v| (a bend of the size of
// rounding over one unit of the parameters): a plane is flat in any parameters.
//
// |nabla II| is what decides next to flat umbilics, such as the centre of the monkey saddle. There
// the frame is handed over to t1 = sigma_u / |sigma_u|, and b_12 is no longer 0: formulas with all
// three b_ij, as those of this project, go through without a special case.
struct SurfaceInvariants {
  // First form [E F; F G], second form [L M; M N], their parametric derivatives.
  Eigen::Matrix2d first_form, second_form;
  std::array<Eigen::Matrix2d, 2> first_form_d, second_form_d;
  double area_element;  // sqrt(EG - F^2) = |sigma_u x sigma_v|
  // christoffel[c](a, b) = Gamma^c_ab
  std::array<Eigen::Matrix2d, 2> christoffel;

  double gaussian_curvature, mean_curvature;
  Eigen::Vector2d kappa;  // kappa_1 >= kappa_2

  bool umbilic;  // The frame is not principal, see above.

  // The frame, and row i = (xi_i, eta_i); then derivatives with respect to u and v.
  Eigen::Vector3d t1, t2, n;
  Eigen::Matrix2d frame;
  std::array<Eigen::Matrix2d, 2> frame_d;
  std::array<Eigen::Vector3d, 2> t1_d, t2_d, n_d;
  Eigen::Vector3d n_uu, n_uv, n_vv;

  // II(t_i, t_j) and the parametric derivatives of these components. diag(kappa_1, kappa_2) and
  // diag of the derivatives of kappa unless umbilic.
  Eigen::Matrix2d b;
  std::array<Eigen::Matrix2d, 2> b_d;

  // Parametric derivatives of (kappa_1, kappa_2), and (i, j) = t_i[kappa_j]. The two are not
  // differentiable at an umbilic: if umbilic, both entries are the derivative of their mean.
  std::array<Eigen::Vector2d, 2> kappa_d;
  Eigen::Matrix2d kappa_along_frame;

  // covariant[i][j](k) = (nabla_{t_i} t_j) . t_k, the coefficients (39)-(44). For lines of
  // curvature covariant[0][0](1) is the geodesic curvature of the first, covariant[1][1](0) that
  // of the second.
  std::array<std::array<Eigen::Vector2d, 2>, 2> covariant;

  // t_i[f] of a function with parametric derivatives f_u, f_v.
  template <typename Value>
  Value Along(int i, const Value& f_u, const Value& f_v) const {
    return frame(i, 0) * f_u + frame(i, 1) * f_v;
  }
};

// What counts as an umbilic (umbilic_tolerance of the condition above).
struct SurfaceInvariantsOptions {
  // Dimensionless, >= 0. The default keeps about twelve digits in what the derivatives of the
  // principal vectors enter into.
  double umbilic_tolerance = 1e-3;
};

// Returns nullopt where the parameters are singular: sigma_u and sigma_v are not finite or not
// independent, |sigma_u x sigma_v| <= 1e-12 |sigma_u| |sigma_v|.
std::optional<SurfaceInvariants> EvaluateSurfaceInvariants(
    const SurfaceJet& jet, const SurfaceInvariantsOptions& options = {});

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SURFACE_INVARIANTS_H_
