#ifndef DARBOUX_GEOMETRY_INVARIANT_STRAINS_H_
#define DARBOUX_GEOMETRY_INVARIANT_STRAINS_H_

#include <Eigen/Core>

#include "geometry/surface_invariants.h"

namespace darboux {

// The strains of Tian & Jia (2010) the way the paper writes them: from the components of the
// displacement in the Darboux frame, directional derivatives t_i[.] and covariant derivatives
// nabla_{t_i} t_j. The solver does not use them (its kernels need no derivative of the principal
// vectors, costs/strain_measures.h); they are the independent check, and they are what the paper's
// readers will look for.
//
// One generalisation: b_12 is carried along, so the same formulas hold in the non-principal frame
// that SurfaceInvariants hands out near umbilics. With b_12 = 0 and b_ii = kappa_i they are the
// printed ones. Energies do not depend on the frame; single components do.

// A displacement field delta(u, v) at one point with its parametric derivatives, unit of length.
struct DisplacementJet {
  Eigen::Vector3d d, d_u, d_v, d_uu, d_uv, d_vv;
};

// delta = alpha t1 + beta t2 + gamma n: the components as functions of (u, v).
struct DisplacementComponents {
  double alpha, alpha_u, alpha_v;
  double beta, beta_u, beta_v;
  double gamma, gamma_u, gamma_v, gamma_uu, gamma_uv, gamma_vv;
};

DisplacementComponents EvaluateComponents(const SurfaceInvariants& surface,
                                          const DisplacementJet& displacement);

// Linear theory, (28)-(37). Nabla is short for the covariant derivatives (39)-(44).
//
//   (28)-(29)  eps_1   = t1[alpha] + (nabla_t1 t2 . t1) beta - kappa_1 gamma
//              eps_2   = t2[beta] + (nabla_t2 t1 . t2) alpha - kappa_2 gamma
//   (30)-(31)  omega_1 = t2[alpha] + (nabla_t2 t2 . t1) beta                 as printed
//              omega_2 = t1[beta] + (nabla_t1 t1 . t2) alpha                 as printed
//   (32)-(33)  phi_1   = -t1[gamma] - kappa_1 alpha
//              phi_2   = -t2[gamma] - kappa_2 beta
//   (34)-(37)  zeta_1  = t1[phi_1] + (nabla_t1 t2 . t1) phi_2
//              zeta_2  = t2[phi_2] + (nabla_t2 t1 . t2) phi_1
//              tau     = t1[phi_2] + t2[phi_1] + (nabla_t1 t1 . t2) phi_1
//                        + (nabla_t2 t2 . t1) phi_2
//
// The bending strains zeta_1, zeta_2, tau (1/length; tau is engineering) are minus the change of
// the second form, to first order and up to products kappa times eps and omega.
//
// Mind the omegas: omega_1 as printed is the t1-component of the derivative of delta along t2. The
// linear theory sees only omega_1 + omega_2 and cannot tell; the nonlinear one can, see below.
struct LinearInvariantStrains {
  double eps_1, eps_2, omega_1, omega_2, phi_1, phi_2, zeta_1, zeta_2, tau;
};

LinearInvariantStrains EvaluateLinearInvariantStrains(const SurfaceInvariants& surface,
                                                      const DisplacementComponents& displacement);

// Which of (30), (31) is called omega_1 in (46)-(54).
enum class OmegaConvention {
  // As the paper numbers them. Wrong: a rigid rotation about a skew axis then strains the shell.
  kAsPrinted,
  // omega_1 = t1[delta] . t2, omega_2 = t2[delta] . t1, the meaning (46)-(54) need.
  kExchanged,
};

// Nonlinear theory after Novozhilov, (46)-(54):
//
//   (46)-(48)  eps_11 = eps_1 + (eps_1^2 + omega_1^2 + phi_1^2) / 2
//              eps_22 = eps_2 + (eps_2^2 + omega_2^2 + phi_2^2) / 2
//              eps_12 = omega_1 + omega_2 + eps_1 omega_2 + eps_2 omega_1 + phi_1 phi_2
//
// and, with theta_1 t1 + theta_2 t2 + chi n the displacement of the end of the normal,
//
//   (49)-(51)  theta_1 = phi_1 (1 + eps_2) - phi_2 omega_1
//              theta_2 = phi_2 (1 + eps_1) - phi_1 omega_2
//              chi     = eps_1 + eps_2 + eps_1 eps_2 - omega_1 omega_2
//
//   (52)-(54)  zeta_ii = (t_i + t_i[delta]) . t_i[theta_1 t1 + theta_2 t2 + chi n]
//              zeta_12 = the same for (1, 2) plus (2, 1)
//
// written out in components with nabla and kappa. The normal (49)-(51) is not normalised: it is
// x_1 x x_2 of the deformed tangents x_i, longer than 1 where the surface has been stretched.
//
// Limits (tests/invariant_strains_test.cc): eps_ij vanishes under every rigid motion, zeta_ij does
// not; what does is zeta_11 - kappa_1 eps_1, zeta_22 - kappa_2 eps_2 and
// zeta_12 - kappa_2 omega_1 - kappa_1 omega_2 (omegas exchanged). To first order in the
// displacement zeta_ii is zeta_i - kappa_i (eps_1 + eps_2), not zeta_i.
//
// A deviation: in (52)-(54) t_i[eps_1] and its like would need derivatives of nabla, hence fourth
// derivatives of sigma, which cancel in the end. They are taken from t_i[delta] as a vector, e.g.
// t_i[eps_1] = t_i[t1[delta]] . t1 + t1[delta] . t_i[t1], which needs third derivatives only.
struct NonlinearInvariantStrains {
  double eps_11, eps_22, eps_12;     // eps_12 engineering
  double zeta_11, zeta_22, zeta_12;  // 1/length, zeta_12 engineering
};

NonlinearInvariantStrains EvaluateNonlinearInvariantStrains(
    const SurfaceInvariants& surface,
    const DisplacementJet& displacement,
    OmegaConvention convention = OmegaConvention::kExchanged);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_INVARIANT_STRAINS_H_
