#ifndef DARBOUX_SOLVER_GRASP_H_
#define DARBOUX_SOLVER_GRASP_H_

#include <ceres/problem.h>

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "costs/finger_contact.h"
#include "costs/friction.h"
#include "costs/material.h"
#include "geometry/shell_surface.h"
#include "solver/scene.h"

namespace darboux {

// What a finger does to the shell in an equilibrium. In the units of whoever asks (see Report).
struct FingerReport {
  std::string name;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // on the finger
  double normal_force = 0.0;                        // sum of pressure * area
  double travel = 0.0;                              // from first touch, along its direction
  double shift = 0.0;                               // from the scene's position to first touch
  double contact_area = 0.0;                        // of the rest surface, where pressure acts
  double largest_pressure = 0.0;
  double penetration = 0.0;                                 // the largest
  Eigen::Vector3d normal_before = Eigen::Vector3d::Zero();  // of the shell at first touch, inwards
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();         // mean of the contact pressure
  Eigen::Vector3d center = Eigen::Vector3d::Zero();         // centre of the contact pressure
  int contact_points = 0, sticking = 0, slipping = 0;
};

// The fingers of a scene against its shell: contact blocks on the elements that they can reach,
// multipliers of contact, friction. Fingers travel with the load factor; travel counts from first
// touch. Works in the units of the ShellProblem's blocks (energies / force unit).
class Grasp {
 public:
  // Null and *error where a finger never touches the shell. The displacements (a column per control
  // vertex) must outlive this and stay where they are.
  static std::unique_ptr<Grasp> Create(const Scene& scene,
                                       const ShellSurface& surface,
                                       const Material& scaled_material,
                                       double* displacements,
                                       std::string* error);

  // Contact, and friction, of one finger with one element.
  struct Block {
    int element = 0;
    int finger = 0;
    FingerContact* contact = nullptr;
    Friction* friction = nullptr;  // null: frictionless
    int first = 0;                 // of its points in the state
  };
  const std::vector<Block>& blocks() const { return blocks_; }
  // Hands the blocks over to a problem (which owns them from then on).
  void AddTo(
      ceres::Problem* problem,
      const std::function<void(ceres::ResidualBlockId, bool friction, int residuals)>& added);

  // Moves the fingers to their travel at this load factor.
  void SetLoadFactor(double factor);
  // The largest change of the load factor in one step that no point of the shell can be tunnelled
  // through by.
  double LargestStep() const;

  // Multipliers and friction, what one load step hands to the next.
  struct State {
    std::vector<double> multipliers;
    std::vector<FrictionPoint> friction;
  };
  const State& state() const { return state_; }
  void SetState(const State& state);

  // Multipliers <- pressures, friction <- present normal forces. Returns whether that changed
  // anything that matters: penetration above what is allowed, or friction not settled.
  bool Update();
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
  // force_unit: of the problem; results are in the scene's units.
  std::vector<FingerReport> Report(double force_unit) const;

 private:
  struct Finger {
    ContactFinger contact;
    const FingerSpec* spec = nullptr;
    double travel = 0.0;  // at full load
    double shift = 0.0;
    double gap = 0.0;  // at first touch, of the contact point nearest to it
    Eigen::Vector3d normal_before = Eigen::Vector3d::Zero();
  };
  Grasp() = default;
  std::vector<const double*> Parameters(int element) const;
  bool FindTouch(const ShellSurface& surface, Finger* finger, std::string* error) const;
  struct Patch {
    int element, finger;
    std::shared_ptr<const ContactPoints> points;
  };
  void AddPatches(const ShellSurface& surface, int finger, std::vector<Patch>* patches) const;
  std::vector<ContactState> States(const Block& block) const;
  // Per finger: has friction, but no normal force for it yet.
  std::vector<bool> WithoutNormalForces() const;

  std::vector<FingerSpec> specs_;
  const ShellSurface* surface_ = nullptr;
  double* displacements_ = nullptr;
  double thickness_ = 0.0;
  double factor_ = 0.0;
  std::deque<Finger> fingers_;
  std::vector<Block> blocks_;
  State state_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_GRASP_H_
