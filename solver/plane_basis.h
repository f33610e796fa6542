#ifndef DARBOUX_SOLVER_PLANE_BASIS_H_
#define DARBOUX_SOLVER_PLANE_BASIS_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace darboux {

// Two unit vectors that complete n to an orthonormal frame.
inline Eigen::Matrix<double, 3, 2> PlaneBasis(const Eigen::Vector3d& n) {
  int smallest;
  n.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = n.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

}  // namespace darboux

#endif  // DARBOUX_SOLVER_PLANE_BASIS_H_
