#ifndef DARBOUX_COSTS_STRAIN_MEASURES_H_
#define DARBOUX_COSTS_STRAIN_MEASURES_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "geometry/strain_point.h"

namespace darboux {

// The strain measures a user can choose. Every one is a function of the fifteen kinematic numbers
// of a point (d_1, d_2, H_11, H_12, H_22; geometry/strain_point.h) and of the constant frame
// (t1, t2, n) and curvatures b_ij. The frame need not be the principal one: all measures are
// tensors on the rest surface, written here in an arbitrary orthonormal frame, which is what keeps
// umbilics (every point of a sphere or plane) free of 0/0.
enum class StrainMeasure {
  kLinearKoiter,   // exact linearisation of kKoiter; blind to infinitesimal rigid motions
  kLinearSeed,     // Tian & Jia (28)-(37); twist tau feels rotations about n (Love's defect)
  kKoiter,         // frame-indifferent; St. Venant-Kirchhoff
  kNonlinearSeed,  // Tian & Jia (46)-(54) with omega_1 and omega_2 exchanged, see below
};

constexpr bool IsLinear(StrainMeasure measure) {
  return measure == StrainMeasure::kLinearKoiter || measure == StrainMeasure::kLinearSeed;
}

// Number of kinematic scalars a kernel reads: membrane strains need d_1, d_2 only.
constexpr int kMembraneInputs = 6;
constexpr int kBendingInputs = 15;

// Views of the fifteen numbers.
template <typename T>
struct Kinematics {
  explicit Kinematics(const T* k) : d1(k), d2(k + 3), h11(k + 6), h12(k + 9), h22(k + 12) {}
  Eigen::Map<const Eigen::Matrix<T, 3, 1>> d1, d2, h11, h12, h22;
};

namespace internal {

template <typename T, typename V>
T DotRest(const V& vector, const Eigen::Vector3d& rest) {
  return vector[0] * rest[0] + vector[1] * rest[1] + vector[2] * rest[2];
}

}  // namespace internal

// Membrane strain e = (e_11, e_22, 2 e_12), dimensionless, from k = (d_1, d_2). Linear measures:
// e_ij = (d_i.t_j + d_j.t_i) / 2, (28)-(31); nonlinear ones: Green's strain
// e_ij = (x_i.x_j - delta_ij) / 2 with x_i = t_i + d_i, (46)-(48). Written in displacements:
// differences of squares of positions would cost seven digits.
template <typename T>
void EvaluateMembraneStrain(StrainMeasure measure, const StrainPoint& p, const T* k, T* e) {
  using internal::DotRest;
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> d1(k), d2(k + 3);
  e[0] = DotRest<T>(d1, p.t1);
  e[1] = DotRest<T>(d2, p.t2);
  e[2] = DotRest<T>(d1, p.t2) + DotRest<T>(d2, p.t1);
  if (IsLinear(measure)) return;
  e[0] += 0.5 * d1.dot(d1);
  e[1] += 0.5 * d2.dot(d2);
  e[2] += d1.dot(d2);
}

// Bending strain (rho_11, rho_22, 2 rho_12), 1/length, from the fifteen numbers; positive where
// b_ij grows. The paper's zeta has the opposite sign, which its energy does not see.
//
//   kLinearKoiter   rho_ij = H_ij.n
//   kLinearSeed     rho_ij = H_ij.n + (d_i.n_j + d_j.n_i) / 2, n_i = -b_ij t_j, (34)-(37)
//   kKoiter         rho_ij = b'_ij - b_ij, b'_ij = (b_ij n + H_ij).n', n' = x_1 x x_2 / |.|
//   kNonlinearSeed  rho_ij = -sym(x_i.D_j Delta), Delta = N - n, N = x_1 x x_2, (49)-(54)
//
// (49)-(51) are the components of Novozhilov's Delta, whose N is not normalised. Written without
// derivatives of the frame (x_i.N = 0, so x_i.D_j N = -(b_ij n + H_ij).N) it is
//   rho_11 = (b_11 n + H_11).N - x_1.(b_11 t1 + b_12 t2), ...
// With the omegas as printed in (30)/(31) no rotation would be free of strain; they are exchanged
// here (geometry/invariant_strains.h has both). Even so it keeps what (52)-(54) drop: under a
// rigid rotation rho_11 = -kappa_1 eps_1 and so on, and near rest rho_ij tends to kLinearSeed's
// plus b_ij (eps_1 + eps_2), not to kLinearSeed's.
//
// Returns false where x_1 x x_2 vanishes up to rounding, where no normal is defined (kKoiter).
template <typename T>
bool EvaluateBendingStrain(StrainMeasure measure, const StrainPoint& p, const T* kinematics, T* e) {
  using internal::DotRest;
  const Kinematics<T> k(kinematics);
  const auto add_seed_terms = [&] {
    const Eigen::Vector3d n1 = -p.b11 * p.t1 - p.b12 * p.t2;
    const Eigen::Vector3d n2 = -p.b12 * p.t1 - p.b22 * p.t2;
    e[0] += DotRest<T>(k.d1, n1);
    e[1] += DotRest<T>(k.d2, n2);
    e[2] += DotRest<T>(k.d1, n2) + DotRest<T>(k.d2, n1);
  };
  if (IsLinear(measure)) {
    e[0] = DotRest<T>(k.h11, p.n);
    e[1] = DotRest<T>(k.h22, p.n);
    e[2] = 2.0 * DotRest<T>(k.h12, p.n);
    if (measure == StrainMeasure::kLinearSeed) add_seed_terms();
    return true;
  }
  using Vector = Eigen::Matrix<T, 3, 1>;
  // x_1 x x_2 = n + m; the change m, not the sum, carries the digits of small displacements.
  const Vector t1 = p.t1.cast<T>(), t2 = p.t2.cast<T>(), n = p.n.cast<T>();
  const Vector d1 = k.d1, d2 = k.d2;
  const Vector m = t1.cross(d2) + d1.cross(t2) + d1.cross(d2);
  const T mn = m.dot(n);
  const Vector big_n = n + m;
  if (measure == StrainMeasure::kNonlinearSeed) {
    e[0] = k.h11.dot(big_n) + p.b11 * mn;
    e[1] = k.h22.dot(big_n) + p.b22 * mn;
    e[2] = 2.0 * (k.h12.dot(big_n) + p.b12 * mn);
    add_seed_terms();
    return true;
  }
  // Not 1 + 2 mn + mm, which is all rounding where x_1 x x_2 is short.
  const T squared = big_n.dot(big_n);
  if (!(squared > 1e-28)) return false;  // A direction needs more than the last two digits of N.
  using std::sqrt;
  const T length = sqrt(squared);
  const T inverse = 1.0 / length;
  const Vector normal = big_n * inverse;
  // n.n' - 1 without cancellation.
  const T turn = (mn * (length - 1.0) - m.dot(m)) * inverse / (length + 1.0);
  e[0] = k.h11.dot(normal) + p.b11 * turn;
  e[1] = k.h22.dot(normal) + p.b22 * turn;
  e[2] = 2.0 * (k.h12.dot(normal) + p.b12 * turn);
  return true;
}

}  // namespace darboux

#endif  // DARBOUX_COSTS_STRAIN_MEASURES_H_
