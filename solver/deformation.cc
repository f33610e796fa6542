#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "solver/registration.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Where a point of the middle surface was at rest, and where it is.
std::array<Vector3d, 2> RestAndNow(const ShellSurface& surface,
                                   const StrainPoint& point,
                                   int element,
                                   const Eigen::Matrix3Xd& displacements) {
  std::array<Vector3d, 2> x = {point.position, point.position};
  const std::vector<int>& vertices = surface.control_vertices(element);
  for (size_t i = 0; i < vertices.size(); ++i) {
    x[1] += point.weights(kRowValue, static_cast<int>(i)) * displacements.col(vertices[i]);
  }
  return x;
}

// min over g  sum w |now - g rest|^2, by Kabsch.
RigidPose RigidMotionOf(const std::vector<std::array<Vector3d, 2>>& points,
                        const std::vector<double>& weights) {
  std::array<Vector3d, 2> center = {Vector3d::Zero(), Vector3d::Zero()};
  double sum = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t k = 0; k < 2; ++k) center[k] += weights[i] * points[i][k];
    sum += weights[i];
  }
  for (Vector3d& c : center) c /= sum;
  Matrix3d covariance = Matrix3d::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    covariance += weights[i] * (points[i][1] - center[1]) * (points[i][0] - center[0]).transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) = -u.col(2);
  const Matrix3d rotation = u * svd.matrixV().transpose();
  return {Quaterniond(rotation), center[1] - rotation * center[0]};
}

}  // namespace

Deformation::Deformation(const ShellSurface& surface, const Eigen::Matrix3Xd& displacements)
    : surface_(surface), displacements_(displacements) {
  if (displacements.isZero(0.0)) return;
  std::vector<std::array<Vector3d, 2>> points;
  std::vector<double> areas, weights, left;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const StrainPoint point = surface.MakePoint({e, 1.0 / 3.0, 1.0 / 3.0}, 0.5);
    points.push_back(RestAndNow(surface, point, e, displacements));
    areas.push_back(point.area);
  }
  // By iteratively reweighted least squares; |x| is rounded off to sqrt(x^2 + rounding^2), with
  // less and less of it: from the start the mean decides, in the end the median.
  constexpr double kExact = 1e-9;  // of the largest of what the mean leaves
  constexpr double kLess = 0.5;
  constexpr int kIterations = 60;
  weights = areas;
  double rounding = 0.0, least = 0.0;
  for (int i = 0; i <= kIterations; ++i) {
    motion_ = RigidMotionOf(points, weights);
    left.clear();
    for (const auto& [rest, now] : points) left.push_back((now - motion_ * rest).norm());
    if (i == 0) {
      rounding = *std::max_element(left.begin(), left.end());
      least = kExact * rounding;
      // Nothing but rounding is left of a rigid motion.
      if (rounding <= 1e-14 * surface.size()) break;
    }
    rounding = std::max(kLess * rounding, least);
    for (size_t k = 0; k < left.size(); ++k) weights[k] = areas[k] / std::hypot(left[k], rounding);
  }
  for (const ElementPoint& at : surface.vertex_points()) largest_ = std::max(largest_, At(at));
}

double Deformation::At(const ElementPoint& at) const {
  const auto [rest, now] = RestAndNow(surface_, surface_.MakePoint(at), at.element, displacements_);
  return (now - motion_ * rest).norm();
}

}  // namespace darboux
