#ifndef DARBOUX_COSTS_FRICTION_H_
#define DARBOUX_COSTS_FRICTION_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "costs/contact_points.h"
#include "costs/finger_contact.h"
#include "costs/follower_force.h"

namespace darboux {

// What friction at one contact point remembers; kept by the caller, read at every evaluation.
struct FrictionPoint {
  double normal_force = 0.0;                          // N, lagged; 0: no contact, no friction
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // lagged; slip is across it
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();   // x - finger position that has no slip
};

// What friction does at one point.
struct FrictionState {
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();             // of the shell along the finger
  Eigen::Vector3d force_on_finger = Eigen::Vector3d::Zero();  // N, along the slip
  bool sticks = true;                                         // |slip| < stick_length, but for 1e-6
};

// Coulomb friction between the points of one element and one finger, as the potential
//
//   U = sum mu N f(|s|),   s = T^T (x - y - anchor)   [J]
//
// of the slip s in the tangent plane T of the finger, y the finger's position. N and T are lagged:
// those of the last iteration or step, so that U is a function of displacements alone and has a
// minimum, and the force, at most mu N, is against the slip; repeated until N settles it is
// Coulomb's law. f smooths |s|, whose gradient jumps where a point sticks, over the length e =
// stick_length (M. Li et al., "Incremental Potential Contact", 2020, (14)-(15), less its constant):
//
//   f = s^2/e - s^3/(3 e^2) for s < e,   s - e/3 from there on;   f' = 2 s/e - (s/e)^2,  1
//
// f' goes from 0 to 1 and f'' down from 2/e to 0: f is C2 and convex. A sticking point moves by
// less than e before it carries its force.
//
// Friction is a robust loss on slip, and could be had as residuals s with a LossFunction; but f is
// also a square, of a vector along s that needs no loss and lets one block carry many points:
//
//   r = sqrt(2 mu N f(|s|)) s/|s|   [sqrt(J)],   two residuals per point.
//
// J^T J is the exact curvature where s -> 0; at large slip it is 2 mu N/s across the slip, where mu
// N/s is exact, and mu N/(2 s) along it, where 0 is. Ceres would make mu N/s in all directions of
// the loss (its corrector leaves rho'' < 0 out); cost and gradient are the same
// (tests/friction_test.cc).
//
// Parameters: as FingerContact. Fingers move without turning.
class Friction : public ceres::CostFunction, public FollowerForce {
 public:
  // state: one per point. Finger (friction mu >= 0, stick_length e > 0) and state must outlive the
  // block.
  Friction(std::shared_ptr<const ContactPoints> points,
           const ContactFinger* finger,
           const FrictionPoint* state,
           bool with_travel);

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

  // With the exact stiffness of U at fixed N and T: symmetric, positive semidefinite, 0 along the
  // slip of a sliding point.
  bool Linearise(double const* const* parameters,
                 Eigen::Matrix3Xd* force,
                 Eigen::MatrixXd* stiffness) const override;

  // Nothing in it softens.
  bool LineariseSoftened(double const* const* parameters,
                         double,
                         Eigen::Matrix3Xd* force,
                         Eigen::MatrixXd* stiffness) const override {
    return Linearise(parameters, force, stiffness);
  }

  bool LineariseTravel(double const* const* parameters, TravelDerivatives* by_travel) const;

  std::vector<FrictionState> States(double const* const* parameters) const;

  // Anchors for the next step, from the state that ended this one; also before the first. Points
  // that are not in contact begin without slip, sticking ones keep theirs, and with it their force,
  // and sliding ones drag the anchor behind them at the distance e (the return mapping of
  // plasticity). `state` is what the block reads, or a copy.
  void AdvanceAnchors(double const* const* parameters, FrictionPoint* state) const;

  const ContactPoints& points() const { return *points_; }

 private:
  // Slip, as a vector, and derivatives f'/s and f'' of f at one point that has friction.
  struct Slip {
    Eigen::Vector3d vector;
    double length, normal_force, slope_over_length, curvature;
  };
  Eigen::Vector3d FingerPosition(double const* const* parameters) const;
  Slip SlipOf(int q, const Eigen::Vector3d& finger, double const* const* parameters) const;
  // d2U/dx2 at the point.
  Eigen::Matrix3d Stiffness(int q, const Slip& slip) const;

  std::shared_ptr<const ContactPoints> points_;
  const ContactFinger* finger_;
  const FrictionPoint* state_;
  bool with_travel_;
};

// Takes over normal force and normal from contact; anchors stay. Points that have lost contact keep
// their normal.
void LagFriction(const std::vector<ContactState>& contact, FrictionPoint* state);

}  // namespace darboux

#endif  // DARBOUX_COSTS_FRICTION_H_
