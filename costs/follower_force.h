#ifndef DARBOUX_COSTS_FOLLOWER_FORCE_H_
#define DARBOUX_COSTS_FOLLOWER_FORCE_H_

#include <Eigen/Core>

namespace darboux {

// A force that depends on the deformation, as Newton's method needs it.
class FollowerForce {
 public:
  virtual ~FollowerForce() = default;

  // Force on the control vertices, column i on vertex i, in the order of the block's parameters;
  // and, where stiffness is not null, minus its derivative by their displacements, 3 n x 3 n, row 3
  // i + a the component a on vertex i. Not symmetric where the force has no potential. False where
  // the force is undefined.
  virtual bool Linearise(double const* const* displacements,
                         Eigen::Matrix3Xd* force,
                         Eigen::MatrixXd* stiffness) const = 0;

  // The same with only a part (0 .. 1) of the stiffness that may soften. What holds the shell like
  // a support, contact's penalty, stays whole.
  virtual bool LineariseSoftened(double const* const* displacements,
                                 double part,
                                 Eigen::Matrix3Xd* force,
                                 Eigen::MatrixXd* stiffness) const {
    if (!Linearise(displacements, force, stiffness)) return false;
    if (stiffness != nullptr) *stiffness *= part;
    return true;
  }
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_FOLLOWER_FORCE_H_
