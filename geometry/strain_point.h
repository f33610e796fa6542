#ifndef DARBOUX_GEOMETRY_STRAIN_POINT_H_
#define DARBOUX_GEOMETRY_STRAIN_POINT_H_

#include <Eigen/Core>

#include "geometry/loop_basis.h"

namespace darboux {

// Position of a rest surface and its derivatives in element coordinates (s, t).
struct RestJet {
  Eigen::Vector3d x, x_s, x_t, x_ss, x_st, x_tt;
};

// Rows of StrainPoint::weights.
enum WeightRow { kRowValue = 0, kRowD1, kRowD2, kRowH11, kRowH12, kRowH22 };

// Everything a strain energy needs to know of one quadrature point: rest geometry in an orthonormal
// tangent frame (t1, t2, n), and the rows of weights that turn control displacements into the
// fifteen kinematic numbers
//
//   d_i  = t_i[delta]                        directional derivative of the displacement
//   H_ij = (covariant Hessian of delta)(t_i, t_j)
//        = T_i^a T_j^b (delta_,ab - Gamma^c_ab delta_,c),  t_i = T_i^a sigma_,a
//
// All of it double and computed once; nothing here is ever differentiated.
struct StrainPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d t1 = Eigen::Vector3d::UnitX();
  Eigen::Vector3d t2 = Eigen::Vector3d::UnitY();
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  double b11 = 0.0, b12 = 0.0, b22 = 0.0;  // sigma_,ij . n, 1 / length
  double area = 0.0;  // quadrature weight times area element: the area this point stands for
  // Rows WeightRow, one column per control vertex of the element. Units 1, 1/length, 1/length^2.
  BasisMatrix weights;
};

// `direction`: t1 is made parallel to direction.x() x_s + direction.y() x_t, so that neighbouring
// elements can share the frame of the parameter lines. CHECKs that x_s, x_t are independent.
// area is quadrature_weight * |x_s x x_t|.
StrainPoint MakeStrainPoint(const RestJet& rest,
                            const BasisMatrix& basis,
                            const Eigen::Vector2d& direction,
                            double quadrature_weight);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_STRAIN_POINT_H_
