#ifndef DARBOUX_COSTS_CROSS_MATRIX_H_
#define DARBOUX_COSTS_CROSS_MATRIX_H_

#include <Eigen/Core>

namespace darboux {

// The matrix of v -> a x v.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d result;
  result << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return result;
}

}  // namespace darboux

#endif  // DARBOUX_COSTS_CROSS_MATRIX_H_
