#ifndef DARBOUX_COSTS_CONTACT_POINTS_H_
#define DARBOUX_COSTS_CONTACT_POINTS_H_

#include <Eigen/Core>
#include <vector>

#include "geometry/strain_point.h"

namespace darboux {

// Points of the middle surface of one element where it may touch a finger; not those of the strain
// energy, because contact wants more of them.
struct ContactPoints {
  Eigen::Matrix3Xd positions;  // at rest, column q
  Eigen::VectorXd areas;       // what each stands for
  Eigen::MatrixXd weights;     // row q: limit weights N_i of the control vertices

  int size() const { return static_cast<int>(areas.size()); }
  int num_vertices() const { return static_cast<int>(weights.cols()); }

  // x = X + sum_i N_i u_i of point q.
  Eigen::Vector3d Deformed(int q, double const* const* displacements) const {
    Eigen::Vector3d x = positions.col(q);
    for (int i = 0; i < num_vertices(); ++i) {
      x += weights(q, i) * Eigen::Map<const Eigen::Vector3d>(displacements[i]);
    }
    return x;
  }

  static ContactPoints From(const std::vector<StrainPoint>& points) {
    ContactPoints result;
    const int n = static_cast<int>(points.size());
    result.positions.resize(3, n);
    result.areas.resize(n);
    result.weights.resize(n, n > 0 ? points.front().weights.cols() : 0);
    for (int q = 0; q < n; ++q) {
      result.positions.col(q) = points[q].position;
      result.areas[q] = points[q].area;
      result.weights.row(q) = points[q].weights.row(kRowValue);
    }
    return result;
  }
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_CONTACT_POINTS_H_
