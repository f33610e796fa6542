#include "costs/scan_distance.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "costs/cross_matrix.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// exp([a]), and d(exp([a]) y) = [exp([a]) y]^T J da with the left Jacobian of rotations
//
//   J = 1 + (1 - cos|a|) / |a|^2 [a] + (|a| - sin|a|) / |a|^3 [a]^2.
void Rotate(const Vector3d& a, Matrix3d* rotation, Matrix3d* left_jacobian) {
  const double squared = a.squaredNorm(), angle = std::sqrt(squared);
  const Matrix3d cross = CrossMatrix(a);
  // Series where the quotients cancel; the first terms left out are below rounding.
  const bool is_small = angle < 1e-2;
  const double sine = is_small ? 1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1 - squared / 42.0))
                               : std::sin(angle) / angle;
  const double half = std::sin(0.5 * angle);
  const double versine =
      is_small ? 0.5 - squared / 24.0 * (1.0 - squared / 30.0) : 2.0 * half * half / squared;
  const double third =
      is_small ? 1.0 / 6.0 - squared / 120.0 * (1.0 - squared / 42.0) : (1.0 - sine) / squared;
  *rotation = Matrix3d::Identity() + sine * cross + versine * cross * cross;
  *left_jacobian = Matrix3d::Identity() + versine * cross + third * cross * cross;
}

}  // namespace

RigidPose ScanDistance::Frame::Pose(const Eigen::Matrix<double, 6, 1>& motion) const {
  const Vector3d a = motion.tail<3>() / length;
  const double angle = a.norm();
  RigidPose pose;
  if (angle > 0.0) pose.rotation = Eigen::AngleAxisd(angle, a / angle);
  pose.translation = center + motion.head<3>() - pose.rotation * center;
  return pose;
}

ScanDistance::ScanDistance(Foot foot, const Frame& frame, double s)
    : foot_(std::move(foot)), frame_(frame), s_(s) {
  set_num_residuals(1);
  mutable_parameter_block_sizes()->assign(1 + foot_.weights.size(), 3);
  mutable_parameter_block_sizes()->front() = 6;
}

bool ScanDistance::Evaluate(double const* const* parameters,
                            double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Vector3d> translation(parameters[0]), rotation(parameters[0] + 3);
  Matrix3d turn, left;
  Rotate(rotation / frame_.length, &turn, &left);
  const Vector3d arm = turn * (foot_.point - frame_.center);
  Vector3d gap = frame_.center + arm + translation - foot_.position;
  for (int i = 0; i < foot_.weights.size(); ++i) {
    gap -= foot_.weights[i] * Eigen::Map<const Vector3d>(parameters[1 + i]);
  }
  residuals[0] = s_ * foot_.normal.dot(gap);
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) {
    Eigen::Map<Vector3d>{jacobians[0]} = s_ * foot_.normal;
    // n . (J da x arm) = da . J^T (arm x n)
    Eigen::Map<Vector3d>{jacobians[0] + 3} =
        s_ / frame_.length * left.transpose() * arm.cross(foot_.normal);
  }
  for (int i = 0; i < foot_.weights.size(); ++i) {
    if (jacobians[1 + i] == nullptr) continue;
    Eigen::Map<Vector3d>{jacobians[1 + i]} = -s_ * foot_.weights[i] * foot_.normal;
  }
  return true;
}

}  // namespace darboux
