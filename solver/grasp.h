#ifndef DARBOUX_SOLVER_GRASP_H_
#define DARBOUX_SOLVER_GRASP_H_

#include <ceres/problem.h>

#include <Eigen/Core>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "costs/finger_contact.h"
#include "costs/friction.h"
#include "costs/material.h"
#include "geometry/finger_shape.h"
#include "geometry/shell_surface.h"
#include "solver/scene.h"

namespace darboux {

// What a finger does to the shell in an equilibrium. In the units of whoever asks (see Report).
struct FingerReport {
  std::string name;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // on the finger
  double normal_force = 0.0;                        // sum of pressure * area
  double travel = 0.0;                              // from first touch, along its direction
  bool by_force = false;                            // what drives it: a force, else a travel
  double shift = 0.0;                               // from the scene's position to first touch
  double indentation = 0.0;  // of the point touched first along the direction, since then
  double gap = 0.0;  // at first touch, of the contact point nearest to it: contact begins as late
  double contact_area = 0.0;  // of the rest surface, where pressure acts
  double largest_pressure = 0.0;
  double penetration = 0.0;                                 // the largest
  Eigen::Vector3d center_before = Eigen::Vector3d::Zero();  // first touch, on the middle surface
  ElementPoint touched;                                     // the point there
  Eigen::Vector3d normal_before = Eigen::Vector3d::Zero();  // of the shell at first touch, inwards
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();         // mean of the contact pressure
  Eigen::Vector3d center = Eigen::Vector3d::Zero();         // centre of the contact pressure
  // Moment of friction about the normal per friction coefficient and normal force: the mean
  // distance of the pressure from its centre. What a contact point stands for counts as a disc.
  double spin_arm = 0.0;
  int contact_points = 0, sticking = 0, slipping = 0;
};

// A point of the middle surface in contact. In the units of whoever asks.
struct ContactPointReport {
  int finger = 0;
  int element = 0;
  ElementPoint at;                                     // of the middle surface
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // deformed
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // of the finger, towards the shell
  double gap = 0.0;
  double pressure = 0.0;                               // per area of the rest surface
  double area = 0.0;                                   // of the rest surface, that it stands for
  Eigen::Vector3d friction = Eigen::Vector3d::Zero();  // force on the finger
  bool sticks = true;
};

// The rigid body of a finger in a frame of its own, and the pose that the scene gives it, before it
// closes. A pin, which pushes a point whatever lies beside it, is a half space. Null and *error
// where its mesh is no closed one.
std::shared_ptr<const FingerShape> MakeFinger(const FingerSpec& spec,
                                              FingerPose* pose,
                                              std::string* error);

// The fingers of a scene against its shell: contact blocks on the elements that they can reach,
// multipliers of contact, friction. Fingers travel with the load factor, or are driven by a force
// that grows with it: then their travel is an unknown, in which equilibrium is
//
//   dU/dt - F = sum of p n.direction dA + friction - F = 0.
//
// Travel counts from first touch. Works in the units of the ShellProblem's blocks (energies / force
// unit).
class Grasp {
 public:
  // Null and *error where a finger never touches the shell as the present displacements (a column
  // per control vertex) have it. These must outlive this and stay where they are.
  static std::unique_ptr<Grasp> Create(const Scene& scene,
                                       const ShellSurface& surface,
                                       const Material& scaled_material,
                                       double force_unit,
                                       double* displacements,
                                       std::string* error);

  ~Grasp();
  Grasp(const Grasp&) = delete;
  Grasp& operator=(const Grasp&) = delete;

  // Contact, and friction, of one finger with one element.
  struct Block {
    int element = 0;
    int finger = 0;
    FingerContact* contact = nullptr;
    Friction* friction = nullptr;      // null: frictionless
    int first = 0;                     // of its points in the state
    double* travel = nullptr;          // last parameter of both, of a finger that a force drives
    std::vector<ElementPoint> places;  // of the contact's points
  };
  const std::vector<Block>& blocks() const { return blocks_; }
  // At the points of a block, in the present state; none of friction without friction.
  std::vector<ContactState> States(const Block& block) const;
  std::vector<FrictionState> FrictionStates(const Block& block) const;
  // Hands the blocks over to a problem (which owns them from then on). curvature_scale: costs/
  // potential.h, of a force; called for those that drive fingers.
  enum class Part { kContact, kFriction, kForce };
  void AddTo(ceres::Problem* problem,
             const std::function<double(double force)>& curvature_scale,
             const std::function<void(ceres::ResidualBlockId, Part, int residuals)>& added);

  // Moves the fingers to their travel, and sets the forces that drive them, at this load factor.
  void SetLoadFactor(double factor);

  // Fingers that a force drives, in the order of what follows.
  int num_driven() const { return static_cast<int>(state_.travels.size()); }
  // Held, they stay where they are and are not counted among the unknowns.
  void HoldTravels(bool held) { held_ = held; }
  bool has_unknown_travels() const { return num_driven() > 0 && !held_; }
  // Sets each unknown travel t to where dU/dt = F at the present displacements, so that a finger is
  // never without contact and dU/dt - F never part of a residual. False and *error where there is
  // no such place.
  bool Close(std::string* error);
  // Second derivatives by the unknown travels, of the energy.
  struct Travel {
    double imbalance = 0.0;     // dU/dt - F
    double stiffness = 0.0;     // d2U/dt2
    Eigen::Matrix3Xd coupling;  // d2U/du dt, on the control vertices
  };
  bool LineariseTravels(std::vector<Travel>* travels) const;
  // The part of a step with these changes of the unknown travels that tunnels through nothing.
  double SafePart(const Eigen::VectorXd& changes) const;
  // The forces at full load.
  Eigen::VectorXd DrivingForces() const;
  // Their norm now.
  double DrivingForce() const { return std::abs(factor_) * DrivingForces().norm(); }
  // Whether forces that drive all the fingers, along one line, balance with a dead force where the
  // shell is free to move along that line: nothing else could. False and *error where they do not.
  bool CheckBalance(const std::function<bool(const Eigen::Vector3d& direction)>& is_free,
                    const Eigen::Vector3d& dead_force,
                    std::string* error) const;
  // Norm of dU/dt - F; 0 where no travel is unknown.
  double Imbalance() const;
  // The largest change of the load factor in one step that no point of the shell can be tunnelled
  // through by.
  double LargestStep() const;

  // Multipliers, friction and travels, what one load step hands to the next.
  struct State {
    std::vector<double> multipliers;
    std::vector<FrictionPoint> friction;
    std::vector<double> travels;  // of driven fingers
    double penalty = 1.0;         // times that of the first iteration, see Update
  };
  const State& state() const { return state_; }
  void SetState(const State& state);

  // Multipliers <- pressures, friction <- present normal forces. Returns whether that changed
  // anything that matters: penetration above what is allowed, or friction not settled. fine: gaps
  // in contact must be nil on the average as well. Where the points in contact stay the same,
  // updates that gain little make the penalty `stiffer` times as large.
  bool Update(bool fine, double stiffer = 10.0);
  // After the last update: the penalty is as at first, pressures stay.
  void Settle();
  // Friction <- present normal forces, whatever they are.
  void LagFriction();
  // A normal force at a point of the state.
  struct NormalForce {
    int point = 0;
    double force = 0.0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  };
  // Friction <- these normal forces, at fingers whose friction has none yet. Whether there are
  // such.
  bool BeginFriction(const std::vector<NormalForce>& forces);
  // The slip that counts as sticking is this many times what it is in the end.
  void SetStickFactor(double factor);
  // After a load step: anchors of friction.
  void Advance();
  // The largest penetration, in units of length.
  double LargestPenetration() const;
  // Empty, or why the present state is none that fingers can have brought about: a finger that has
  // travelled without any contact, or that has come through the shell.
  std::string Fault() const;
  // The same at full load, where also a finger that has only come near is no success.
  std::string FaultAtTheEnd() const;

  // Contact's residuals r near the present state, linear in the displacements: r - c.du, of the
  // points in contact (r > 0) and of those nearer to a finger than `reach`. Not of fingers whose
  // travel is unknown: r depends on it.
  struct ContactRow {
    const std::vector<int>* vertices = nullptr;
    Eigen::Matrix3Xd coefficients;  // c, a column per vertex
    double residual = 0.0;
    int point = 0;       // in the state
    double scale = 0.0;  // normal force / r
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  };
  std::vector<ContactRow> ContactRows(double reach) const;

  double Energy() const;
  Eigen::Matrix3Xd Force() const;  // on the control vertices
  // Of contact and friction, by the travel of each finger; forces on all control vertices. False
  // where a point in contact has no normal.
  bool ByTravel(std::vector<TravelDerivatives>* by_travel) const;
  // Penalties of contact times `factor`, and multipliers that leave the pressures what they are:
  // for derivatives as of rigid contact. A power of two and its inverse leave no trace but in the
  // multipliers.
  void Stiffen(double factor);
  // force_unit: of the problem; results are in the scene's units.
  std::vector<FingerReport> Report(double force_unit) const;
  // The pressure's distribution: points that have any.
  std::vector<ContactPointReport> ReportPoints(double force_unit) const;

 private:
  struct Finger {
    ContactFinger contact;
    const FingerSpec* spec = nullptr;
    double travel = 0.0;     // at full load
    double reach = 0.0;      // the largest travel that contact points are there for
    int driven = -1;         // its number among those that a force drives
    double force = 0.0;      // that drives it at full load
    double force_now = 0.0;  // and at the present load factor
    double shift = 0.0;
    double gap = 0.0;  // at first touch, of the contact point nearest to it
    Eigen::Vector3d touch = Eigen::Vector3d::Zero();
    ElementPoint touched;  // the point there
    Eigen::Vector3d normal_before = Eigen::Vector3d::Zero();
  };
  Grasp() = default;
  std::vector<const double*> Parameters(const Block& block) const;
  void SetPenalty(double factor);
  double TravelOf(const Finger& finger) const;
  // dU/dt of one finger, and its derivative; distance: to the shell, along its direction, at least.
  bool Resistance(int finger, double* force, double* stiffness, double* distance) const;
  // Of the shell under the present displacements.
  Eigen::Vector3d Position(const ElementPoint& at) const;
  Eigen::Vector3d Normal(const ElementPoint& at) const;
  double ElementSize(int element) const;
  bool FindTouch(const ShellSurface& surface, Finger* finger, std::string* error) const;
  struct Patch {
    int element, finger;
    std::shared_ptr<const ContactPoints> points;
    std::vector<ElementPoint> places;
  };
  void AddPatches(const ShellSurface& surface, int finger, std::vector<Patch>* patches) const;
  // Per finger: has friction, but no normal force for it yet.
  std::vector<bool> WithoutNormalForces() const;

  std::vector<FingerSpec> specs_;
  const ShellSurface* surface_ = nullptr;
  double* displacements_ = nullptr;
  bool inflated_ = false;  // displaced before the fingers come
  double thickness_ = 0.0;
  double spacing_ = 0.0;  // of contact points, in radii of a finger
  double factor_ = 0.0;
  bool held_ = false;
  bool handed_over_ = false;  // blocks belong to a problem
  std::vector<char> touching_;
  double violation_ = std::numeric_limits<double>::infinity();  // at the last update
  std::deque<Finger> fingers_;
  std::vector<Block> blocks_;
  State state_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_GRASP_H_
