#ifndef DARBOUX_SOLVER_RIGID_MOTION_H_
#define DARBOUX_SOLVER_RIGID_MOTION_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace darboux {

// An infinitesimal rigid motion: the point x moves by translation + rotation x (x - center).
// Columns of a 6 x k matrix of motions are (translation, rotation * length), so that all entries
// have the unit of a length; center and length come from the shell.
struct RigidFrame {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double length = 1.0;

  // Row vectors r with r * motion = direction . (displacement of x), and = direction . (derivative
  // of the displacement along the unit tangent), times length.
  Eigen::Matrix<double, 1, 6> DisplacementRow(const Eigen::Vector3d& x,
                                              const Eigen::Vector3d& direction) const;
  Eigen::Matrix<double, 1, 6> DerivativeRow(const Eigen::Vector3d& tangent,
                                            const Eigen::Vector3d& direction) const;
};

// Orthonormal basis (6 x k) of the motions within span(allowed) that leave all rows zero. Rows are
// scaled to unit length first; a motion counts as held when it moves a row by more than 1e-6.
Eigen::MatrixXd FreeMotions(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& allowed);

// One name per independent free motion: "translation along z", "rotation about the axis through
// (0, 0, 0) along x", or a screw. Pure translations are split off first.
std::vector<std::string> NameMotions(const Eigen::MatrixXd& motions, const RigidFrame& frame);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_RIGID_MOTION_H_
