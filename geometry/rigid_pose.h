#ifndef DARBOUX_GEOMETRY_RIGID_POSE_H_
#define DARBOUX_GEOMETRY_RIGID_POSE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace darboux {

// x -> rotation * x + translation; of a scan: from its own frame into that of the shell.
struct RigidPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  RigidPose operator*(const RigidPose& other) const {
    return {(rotation * other.rotation).normalized(), (*this) * other.translation};
  }
  RigidPose Inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_RIGID_POSE_H_
