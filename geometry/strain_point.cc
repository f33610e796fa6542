#include "geometry/strain_point.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace darboux {

StrainPoint MakeStrainPoint(const RestJet& rest,
                            const BasisMatrix& basis,
                            const Eigen::Vector2d& direction,
                            double quadrature_weight) {
  StrainPoint point;
  point.position = rest.x;
  const Eigen::Vector3d normal = rest.x_s.cross(rest.x_t);
  const double area_element = normal.norm();
  CHECK_GT(area_element, 0.0) << "the rest surface degenerates at (" << rest.x.transpose() << ")";
  point.n = normal / area_element;
  point.t1 = (direction.x() * rest.x_s + direction.y() * rest.x_t).normalized();
  point.t2 = point.n.cross(point.t1);
  point.area = quadrature_weight * area_element;

  // Contravariant basis x^a, x^a . x_b = delta^a_b; then t_i = T_i^a x_a with T_i^a = t_i . x^a.
  const Eigen::Vector3d dual_s = rest.x_t.cross(point.n) / area_element;
  const Eigen::Vector3d dual_t = point.n.cross(rest.x_s) / area_element;
  Eigen::Matrix2d to_frame;  // row i: T_i^s, T_i^t
  to_frame << point.t1.dot(dual_s), point.t1.dot(dual_t), point.t2.dot(dual_s),
      point.t2.dot(dual_t);

  // Christoffel symbols of the second kind, Gamma^c_ab = x_,ab . x^c, for ab = ss, st, tt.
  const Eigen::Vector3d* second[3] = {&rest.x_ss, &rest.x_st, &rest.x_tt};
  const Eigen::Index n = basis.cols();
  point.weights.resize(6, n);
  point.weights.row(kRowValue) = basis.row(kValue);
  point.weights.row(kRowD1) = to_frame(0, 0) * basis.row(kDs) + to_frame(0, 1) * basis.row(kDt);
  point.weights.row(kRowD2) = to_frame(1, 0) * basis.row(kDs) + to_frame(1, 1) * basis.row(kDt);
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 64> hessian(3, n);
  Eigen::Vector3d b;
  for (int k = 0; k < 3; ++k) {
    hessian.row(k) = basis.row(kDss + k) - second[k]->dot(dual_s) * basis.row(kDs) -
                     second[k]->dot(dual_t) * basis.row(kDt);
    b[k] = second[k]->dot(point.n);
  }
  // Symmetric bilinear forms in (s, t) -> in the frame.
  Eigen::Matrix3d rotate;
  const int pairs[3][2] = {{0, 0}, {0, 1}, {1, 1}};
  for (int row = 0; row < 3; ++row) {
    const int i = pairs[row][0], j = pairs[row][1];
    rotate.row(row) << to_frame(i, 0) * to_frame(j, 0),
        to_frame(i, 0) * to_frame(j, 1) + to_frame(i, 1) * to_frame(j, 0),
        to_frame(i, 1) * to_frame(j, 1);
  }
  point.weights.bottomRows<3>().noalias() = rotate * hessian;
  b = rotate * b;
  point.b11 = b[0];
  point.b12 = b[1];
  point.b22 = b[2];
  return point;
}

}  // namespace darboux
