#ifndef DARBOUX_COSTS_FINGER_CONTACT_H_
#define DARBOUX_COSTS_FINGER_CONTACT_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "costs/contact_points.h"
#include "costs/follower_force.h"
#include "costs/potential.h"
#include "geometry/finger_shape.h"

namespace darboux {

// A rigid finger as its contact blocks see it. They keep a pointer to it and read all of it at
// every evaluation, so the solver moves fingers and stiffens contact by writing here.
struct ContactFinger {
  std::shared_ptr<const FingerShape> shape;
  FingerPose pose;                                        // before it closes
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  // prescribed, from the pose
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();  // unit; the way its travel counts
  double offset = 0.0;     // h / 2: the shell's face touches where the middle surface is this near
  double stiffness = 0.0;  // k > 0 of the penalty, pressure per penetration, Pa/m
  double friction = 0.0;   // Coulomb's coefficient (costs/friction.h)
  double stick_length = 0.0;  // > 0 with friction: slip below which a point counts as sticking

  // travel: value of the travel block, 0 where there is none.
  FingerPose PoseAt(double travel) const {
    return {pose.position + translation + travel * direction, pose.rotation};
  }
};

// What contact does at one point.
struct ContactState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // x, deformed middle surface
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // of the finger, towards the shell
  double gap = 0.0;                                    // g < 0: the face is inside the finger
  double pressure = 0.0;                               // max(0, lambda - k g), Pa
  Eigen::Vector3d force_on_finger = Eigen::Vector3d::Zero();  // -pressure * area * normal, N
};

// Derivatives of an energy U by a finger's travel t.
struct TravelDerivatives {
  double energy = 0.0;     // dU/dt = force on the finger against its direction, N
  double stiffness = 0.0;  // d2U/dt2
  Eigen::Matrix3Xd force;  // d(force on the control vertices)/dt = -d2U/du dt
};

// Frictionless contact of one element with one finger. At each point, with the gap between the
// shell's face and the finger
//
//   g = phi(x) - offset,   x = X + sum_i N_i u_i,
//
// phi the signed distance to the finger (the surface at the distance h/2 of a rigid body touches
// the middle surface exactly where the body touches the face), the augmented Lagrangian of g >= 0
// (R. T. Rockafellar, 1973; P. Alart and A. Curnier, 1991, without friction) is
//
//   U = dA / (2 k) (p^2 - lambda^2),   p = max(0, lambda - k g)   [J]
//
// whose first term is the square of
//
//   r = sqrt(dA / k) max(0, lambda - k g)   [sqrt(J)]
//
// and whose second is constant; U is C1 in u. p is the pressure, the force on the shell p n dA.
// lambda >= 0 is a multiplier that the caller keeps, per point: 0 makes it a plain penalty, whose
// penetration is p/k; repeating lambda <- p and solving again drives penetration to zero at any k.
//
// Parameters: one block of 3 per control vertex, then, with_travel, one of 1: the travel t of a
// finger that is driven by a force, which is then at pose + translation + t direction. Its force F
// enters as FingerForce, and equilibrium in t is sum p n.direction dA = F.
class FingerContact : public ceres::CostFunction, public FollowerForce {
 public:
  // multipliers: one per point, Pa, read at every evaluation; null: all 0. Finger and multipliers
  // must outlive the block.
  FingerContact(std::shared_ptr<const ContactPoints> points,
                const ContactFinger* finger,
                const double* multipliers,
                bool with_travel);

  // False where a point in contact is where phi has no normal.
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

  // Force on the control vertices and its exact stiffness, symmetric,
  //   sum N_i N_j (k n n^T - p hessian) dA   over the points with p > 0,
  // of which Ceres' J^T J is the first term. The second softens.
  bool Linearise(double const* const* parameters,
                 Eigen::Matrix3Xd* force,
                 Eigen::MatrixXd* stiffness) const override {
    return LineariseSoftened(parameters, 1.0, force, stiffness);
  }
  // part: of the second term.
  bool LineariseSoftened(double const* const* parameters,
                         double part,
                         Eigen::Matrix3Xd* force,
                         Eigen::MatrixXd* stiffness) const override;

  // By the travel; also where it is no parameter, as the derivatives by a prescribed motion.
  bool LineariseTravel(double const* const* parameters, TravelDerivatives* by_travel) const;

  // One per point. Points that are neither in contact nor nearer than `reach` keep normal 0, and as
  // gap a lower bound.
  bool States(double const* const* parameters,
              std::vector<ContactState>* states,
              double reach = 0.0) const;

  // U with its constant term: 0 apart if lambda is 0; has the derivatives of 1/2 |r|^2.
  bool Energy(double const* const* parameters, double* energy) const;

  const ContactPoints& points() const { return *points_; }
  const ContactFinger& finger() const { return *finger_; }
  bool with_travel() const { return with_travel_; }

 private:
  struct Contact {
    double gap, pressure;
    Distance distance;
  };
  double Travel(double const* const* parameters) const {
    return with_travel_ ? parameters[points_->num_vertices()][0] : 0.0;
  }
  double Multiplier(int q) const { return multipliers_ == nullptr ? 0.0 : multipliers_[q]; }
  // Calls on_point(q, x, contact) for all points.
  template <typename OnPoint>
  bool ForEachPoint(double const* const* parameters, OnPoint on_point, double reach = 0.0) const;

  std::shared_ptr<const ContactPoints> points_;
  const ContactFinger* finger_;
  const double* multipliers_;
  bool with_travel_;
};

// The force that drives a finger along its direction: U = -F t. Parameters: its travel (1).
class FingerForce : public Potential {
 public:
  // force: N, read at every evaluation; must outlive the block.
  FingerForce(const double* force, double s) : Potential(s), force_(force) {
    mutable_parameter_block_sizes()->push_back(1);
  }

 protected:
  bool EvaluateEnergy(double const* const* travel,
                      double* energy,
                      double** gradients) const override {
    *energy = -*force_ * travel[0][0];
    if (gradients != nullptr && gradients[0] != nullptr) gradients[0][0] = -*force_;
    return true;
  }

 private:
  const double* force_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_FINGER_CONTACT_H_
