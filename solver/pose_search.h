#ifndef DARBOUX_SOLVER_POSE_SEARCH_H_
#define DARBOUX_SOLVER_POSE_SEARCH_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"
#include "solver/registration.h"

namespace darboux {

// Where a scan about is: many poses on trial. Inside of the solver.

// Centre, spread and axes of points most of which belong to a body, and of the sphere through them.
struct CloudShape {
  Eigen::Vector3d center, sphere_center;
  double radius;         // median distance from the centre
  Eigen::Matrix3d axes;  // columns, right-handed, ascending variance
};

CloudShape MakeCloudShape(const std::vector<Eigen::Vector3d>& points);

// The best pose of many starts, refined with some of the points. Sets num_starts and
// equivalent_poses.
RigidPose SearchPose(const ShellFace& face,
                     const std::vector<Eigen::Vector3d>& scan,
                     const CloudShape& of_face,
                     const CloudShape& of_scan,
                     const RegistrationOptions& options,
                     RegistrationSummary* summary);

// `count` of the numbers 0 .. n - 1, ascending; all of them where count is 0.
std::vector<int> DrawNumbers(int n, int count, std::uint64_t seed);
std::vector<Eigen::Vector3d> PickPoints(const std::vector<Eigen::Vector3d>& points,
                                        const std::vector<int>& chosen);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_POSE_SEARCH_H_
