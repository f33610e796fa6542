#ifndef DARBOUX_COSTS_SCAN_DISTANCE_H_
#define DARBOUX_COSTS_SCAN_DISTANCE_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>

#include "geometry/rigid_pose.h"

namespace darboux {

// The signed distance of a scanned point y to the face of a shell, along the face's normal n at the
// point's foot f:
//
//   r = s n . (M y - f(u)),   f(u) = f_0 + sum_i N_i (u_i - u_0i)
//
//   M y = c + exp([w / l]) (y - c) + t,   M = (t, w): the pose of the scan, moved about c
//
// At the foot r and all its first derivatives are those of the distance itself: the foot moves
// along the face, which changes the distance to second order; so does the normal, and with it the
// half thickness between face and middle surface. Gauss-Newton on blocks at fixed feet, which are
// then found anew, is therefore Gauss-Newton on distances.
//
// t, w, c, y, f, l in the unit of length; w is an angle times the length l, so that all six have
// the same unit. s is 1 / (standard deviation of the scan) in a fit.
// Parameters: the motion (t, w), 6; then one block of 3 per control vertex, u_i, or none where the
// face does not deform.
class ScanDistance : public ceres::CostFunction {
 public:
  // What is fixed of one point while its block is minimised; letters as above.
  struct Foot {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();     // y
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // f_0 - sum_i N_i u_0i
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // n
    Eigen::VectorXd weights;                             // N_i; empty: a rigid face
  };
  // What the motions of all points of a scan have in common.
  struct Frame {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();  // c
    double length = 1.0;                               // l
    // The motion as a pose.
    RigidPose Pose(const Eigen::Matrix<double, 6, 1>& motion) const;
  };

  ScanDistance(Foot foot, const Frame& frame, double s);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  Foot foot_;
  Frame frame_;
  double s_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_SCAN_DISTANCE_H_
