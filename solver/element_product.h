#ifndef DARBOUX_SOLVER_ELEMENT_PRODUCT_H_
#define DARBOUX_SOLVER_ELEMENT_PRODUCT_H_

#include <Eigen/Core>
#include <vector>

#include "geometry/strain_point.h"

namespace darboux {

// The matrix of an element from those of its quadrature points: with M_q the second derivatives of
// a point's energy by its fifteen kinematic numbers (d_1, d_2, H_11, H_12, H_22) and w_q,ic the
// weight of control vertex i in the kinematic vector c, the block of vertices i and j is
//
//   K_ij = sum_q sum_c,d w_q,ic w_q,jd M_q,cd      (3 x 3)
//
// The greater part of an assembly's time. The loops are compiled for processors with AVX2 and FMA
// and for any other, and the program asks which it runs on: only plain doubles pass through them,
// so that Eigen's alignment, which must be that of the packaged Ceres, does not change.
class ElementProduct {
 public:
  using PointMatrix = Eigen::Matrix<double, 15, 15>;

  // For an element of this many control vertices and points; all sums start at zero.
  void Begin(int num_vertices, int num_points);
  // `matrix` is symmetric. Each point of [0, num_points) once.
  void SetPoint(int q, const StrainPoint& point, const PointMatrix& matrix);
  void Multiply();

  // Of vertices i >= j, after Multiply.
  Eigen::Matrix3d Block(int i, int j) const {
    Eigen::Matrix3d block;
    const double* from = result_.data() + static_cast<size_t>(9 * j) * stride_ + i;
    for (int k = 0; k < 9; ++k, from += stride_) block.data()[k] = *from;
    return block;
  }

 private:
  int num_vertices_ = 0, num_points_ = 0;
  int stride_ = 0;               // control vertices, rounded up
  std::vector<double> weights_;  // [q][c][i], zero behind the last i
  std::vector<double> points_;   // [q], column by column, with room behind
  std::vector<double> half_;     // times the weights of one vertex: [q][j][b][d][a]
  std::vector<double> result_;   // [j][b][a][i]
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ELEMENT_PRODUCT_H_
