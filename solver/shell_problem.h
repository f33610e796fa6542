#ifndef DARBOUX_SOLVER_SHELL_PROBLEM_H_
#define DARBOUX_SOLVER_SHELL_PROBLEM_H_

#include <ceres/problem.h>

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "costs/edge_moment.h"
#include "costs/follower_pressure.h"
#include "costs/gas.h"
#include "costs/material.h"
#include "costs/strain_energy.h"
#include "geometry/shell_surface.h"
#include "solver/dead_loads.h"
#include "solver/grasp.h"
#include "solver/rigid_motion.h"
#include "solver/scene.h"
#include "solver/support_conditions.h"

namespace darboux {

// The effects of scene.md's summary, in its order.
enum class Effect {
  kMembrane,
  kBending,
  kGeometricNonlinearity,
  kContact,
  kFriction,
  kGas,
  kGravity,
  kSupports,
  kLoads
};
constexpr int kNumEffects = 9;
const char* ToString(Effect effect);

// Whether a scene calls for an effect, and the size of its part of the problem.
struct EffectReport {
  bool on = false;
  std::string why;
  int residual_blocks = 0;
  int residuals = 0;
};

// Which part of the displacement is unknown. A flat plate decouples in the linear theory.
enum class Unknowns { kAll, kNormalOnly, kInPlaneOnly };

// The gas in a closed shell, in the scene's units.
struct GasReport {
  double gauge_pressure = 0.0;
  double absolute_pressure = 0.0;
  double volume = 0.0;  // enclosed by the middle surface
  double volume_ratio = 1.0;
};

// A scene as a ceres::Problem: potential energy / force_unit() =
// 1/2 sum of squares + potentials, one parameter
// block of 3 per control vertex. Only effects the scene calls for add blocks.
class ShellProblem {
 public:
  // What the scene does not say of the problem.
  struct Options {
    bool nonlinear = false;
    bool tension_rows = true;  // nonlinear theory only (costs/membrane_energy.h)
    int num_threads = 1;
    // Control displacements whose strains, linear in them, are those of the shell's initial stress:
    // they are there at rest. Empty: none. For gas with rest: prestressed, see solver/gas_start.h.
    Eigen::Matrix3Xd prestress;
    // Displacements and multipliers at load factor zero, where fingers find the shell. Empty: rest.
    Eigen::Matrix3Xd start;
    std::vector<double> start_multipliers;
  };

  // Null and *error for a scene that cannot be solved as stated, e.g. a rigid motion that nothing
  // holds although the loads drive it.
  static std::unique_ptr<ShellProblem> Create(const Scene& scene,
                                              const Options& options,
                                              std::string* error);

  const Scene& scene() const { return scene_; }
  const Material& material() const { return material_; }
  // In the units of problem(): divided by force_unit().
  const Material& scaled_material() const { return scaled_material_; }
  const ShellSurface& surface() const { return *surface_; }
  StrainMeasure measure() const { return measure_; }
  bool nonlinear() const { return options_.nonlinear; }
  Unknowns unknowns() const { return unknowns_; }
  // Built at the first call in the linear theory, which factorises its own matrix meanwhile.
  ceres::Problem* problem() {
    if (problem_ == nullptr) Build();
    return problem_.get();
  }

  // Control displacements, a column per control vertex: the parameter blocks of problem(). A map,
  // because moving a matrix into them would leave the blocks behind.
  Eigen::Map<Eigen::Matrix3Xd> displacements() {
    return Eigen::Map<Eigen::Matrix3Xd>(displacements_.data(), 3, displacements_.cols());
  }
  const Eigen::Matrix3Xd& displacements() const { return displacements_; }

  // Scales dead loads, follower loads and prescribed displacements.
  void SetLoadFactor(double factor);
  double load_factor() const { return load_factor_; }
  // Energies and gradients within problem() times this are those of the scene.
  double force_unit() const { return force_unit_; }

  // Whether some force has no potential here, so that UpdateCorrection is needed.
  bool NeedsCorrection() const { return !followers_.empty(); }
  // Sets the dead correction force of the present state; returns the change of it, relative to
  // the exact follower forces (Frobenius norms).
  double UpdateCorrection();

  // All three components of every active control vertex, whether or not they are unknown.
  int dof() const { return 3 * surface_->num_active_vertices(); }
  int num_unknowns() const { return num_unknowns_; }
  int num_quadrature_points() const { return num_quadrature_points_; }
  // Counts of blocks are complete once problem() is built.
  const EffectReport& effect(Effect effect) const { return effects_[static_cast<int>(effect)]; }
  // Motions that no support removes; the loads balance on them.
  const std::vector<std::string>& free_motions() const { return free_motions_; }

  // Whether the displacement of a control vertex is unknown, and the directions (orthonormal
  // columns) that it is unknown in.
  bool IsFree(int vertex) const { return is_free_[vertex] != 0; }
  Eigen::MatrixXd unknown_basis() const;
  // Dead forces at the present load factor, and those that follow the deformation, in the units of
  // problem().
  Eigen::Matrix3Xd DeadForce() const { return load_factor_ * dead_loads_.force; }
  // A force that follows the deformation, and the element whose vertices it acts on.
  struct PlacedForce {
    int element;
    const FollowerForce* force;
    const double* last = nullptr;  // parameter behind those of the element's control vertices
  };
  const std::vector<PlacedForce>& follower_forces() const { return follower_forces_; }
  bool has_moments() const { return !moments_.empty(); }
  // The fingers; null where the scene has none.
  Grasp* grasp() { return grasp_.get(); }
  const Grasp* grasp() const { return grasp_.get(); }
  // The gas shut in by a closed shell: pressure by the enclosed volume, whatever the load factor;
  // in the linear theory to first order in the displacements, on the rest surface. Newton's method
  // has it whole. problem(), whose blocks are sparse, has it from the state of the last UpdateGas
  // on, see costs/gas_blocks.h: gradients are exact there.
  bool has_gas() const { return gas_ != nullptr; }
  // Part of the gauge pressure at rest that the amount of gas is for, 0 .. 1; 1 from the start.
  void SetGasCharge(double part);
  // Pressure, volume and forces of the present displacements; free where these have not changed.
  // False where the volume is not positive. True without gas.
  bool UpdateGas() const;
  // After UpdateGas, in the units of problem(): force = gauge pressure * gradient of the volume;
  // stiffness = that of a follower pressure gas_pressure() + weight * vector * vector^T, dense.
  double gas_pressure() const { return gas_ == nullptr ? 0.0 : gas_->pressure / force_unit_; }
  const Eigen::Matrix3Xd& gas_vector() const { return gas_->gradient; }
  double gas_weight() const;
  GasReport ReportGas() const;

  // Angles that edge moments do work on are counted from the present state on.
  void SetAngleReferences();

  // What holds the shell: supports. Those of stiffness zero only
  // tell which rigid motions are held. The springs carry multipliers (augmented Lagrangian): energy
  // k c^2 / 2 + lambda c, so that with the right lambda nothing gives way. All in the units of
  // problem().
  const std::vector<PlacedCondition>& conditions() const { return conditions_; }
  // Free motions are held on the average over the shell, not at points: condition k is that the
  // mean of (motion k) . displacement vanishes, with a multiplier as well, behind those of
  // conditions(). Where the loads turn with the shell its force is nil. Dense: no part of
  // problem(), which sees its force as a dead load, and a low-rank update of the tangent stiffness.
  // Fingers hold the shell as they touch it: there the means are no conditions, their stiffness
  // only bounds the steps of a shell that is not held yet, and they never have any force.
  struct MeanCondition {
    Eigen::Matrix3Xd coefficients;  // a column per control vertex
    double stiffness = 0.0;
  };
  const std::vector<MeanCondition>& mean_conditions() const { return mean_conditions_; }
  // As many springs at points, statically determinate, that only keep matrices from being singular:
  // the tangent stiffness takes them away again, and in problem() they hold the shell where it is.
  const std::vector<PlacedCondition>& pins() const { return pins_; }
  // Makes problem() hold the shell here: pins without force, means with the force they have now.
  void HoldHere();
  // After problem() has been minimised, which keeps pins but no means: multipliers that leave the
  // forces of the means as HoldHere had them.
  void KeepMeanForces();
  const std::vector<double>& multipliers() const { return multipliers_; }
  void SetMultipliers(const std::vector<double>& multipliers);
  void UpdateMultipliers();  // lambda += k c
  // arm * |c| over the largest displacement, the largest of all conditions.
  double LargestViolation() const;
  double SupportEnergy() const;
  Eigen::Matrix3Xd SupportGradient() const;

  // The largest violation of a held displacement component, relative to the largest displacement,
  // and the support it belongs to (-1: none). Far above rounding where supports contradict.
  double LargestViolation(int* support) const;

  // Energy of an effect in the present state, J.
  double Energy(Effect effect);
  // Gradient of the whole energy (3 x vertices), and of a part of it.
  Eigen::Matrix3Xd Gradient();
  Eigen::Matrix3Xd Gradient(Effect effect);
  // Net force of the supports on the shell; force of all loads on it.
  Eigen::Vector3d Reaction();
  Eigen::Vector3d AppliedForce() const;

  // Limit displacement at a point.
  Eigen::Vector3d Displacement(const ElementPoint& point) const;

  const std::vector<StrainPoints>& strain_points() const { return points_; }
  // Membrane and bending strain of the initial stress at each quadrature point, elements in order.
  // Empty: there is none.
  const std::vector<Eigen::Matrix<double, 6, 1>>& initial_strains() const {
    return initial_strains_;
  }
  // At any point of an element. Precondition: there is an initial stress.
  Eigen::Matrix<double, 6, 1> InitialStrain(int element, const StrainPoint& point) const;

 private:
  ShellProblem(const Scene& scene,
               const Material& material,
               const Options& options,
               std::unique_ptr<ShellSurface> surface);

  void AddGas(const LoadSpec& load, double scale);
  void AddGasShares(double stiffness);
  bool HoldRigidMotions(std::string* error);
  void ChooseUnknowns();
  void ListUnknowns();
  void Build();
  void AddParameters();
  void AddStrainEnergies();
  void AddSupports();
  void AddLoads();
  void AddFingers(const std::function<double(double force)>& curvature_scale);
  std::vector<double*> Blocks(const std::vector<int>& vertices);
  double Violation(const PlacedCondition& condition) const;
  // Force of mean condition k per unit of its coefficients.
  double MeanForce(size_t k) const;
  void SetTargets();
  ceres::ResidualBlockId Record(Effect effect, ceres::ResidualBlockId id, int residuals);
  double StrainEnergyOf(const std::vector<const ceres::CostFunction*>& costs) const;
  Eigen::Matrix3Xd EvaluateGradient(const std::vector<ceres::ResidualBlockId>* blocks);

  Scene scene_;
  Options options_;
  Material material_;
  // Blocks hold energies divided by force_unit_ = D / size^2, N/m, the stiffness of the shell's
  // bending, so that gradients are of the order of the displacements or larger in any system of
  // units: Ceres' damping, column scaling and gradient norm have absolute constants in them.
  // Everything public but problem() is in the scene's units.
  double force_unit_ = 1.0;
  Material scaled_material_;
  StrainMeasure measure_;
  std::unique_ptr<ShellSurface> surface_;
  RigidFrame frame_;
  std::vector<StrainPoints> points_;  // per element
  int num_quadrature_points_ = 0;
  std::vector<Eigen::Matrix<double, 6, 1>> initial_strains_;
  std::vector<PlacedCondition> conditions_;
  std::vector<MeanCondition> mean_conditions_;
  std::vector<PlacedCondition> pins_;
  std::deque<double> pin_targets_;
  std::vector<double> multipliers_;  // of conditions_, then of mean_conditions_
  std::vector<int> fixed_vertices_;  // boundary_rule seed_ghosts
  std::vector<char> is_free_;
  std::vector<std::string> free_motions_;
  DeadLoads dead_loads_;
  Unknowns unknowns_ = Unknowns::kAll;
  Eigen::Vector3d plate_normal_ = Eigen::Vector3d::UnitZ();
  int num_unknowns_ = 0;

  Eigen::Matrix3Xd displacements_;
  double load_factor_ = 1.0;
  Eigen::Matrix3Xd force_;           // load_factor * dead + correction
  Eigen::Matrix3Xd correction_;      // follower forces that their potential lacks
  std::vector<double> held_forces_;  // of the mean conditions, see HoldHere
  Eigen::Matrix3Xd held_;            // all of them
  std::deque<double> targets_;       // of the springs: load_factor * target - lambda / k
  std::vector<std::pair<int, const FollowerPressure*>> followers_;  // element, block
  std::vector<std::pair<int, EdgeMoment*>> moments_;                // element, block
  std::vector<PlacedForce> follower_forces_;                        // both, and those of fingers
  std::unique_ptr<Grasp> grasp_;
  struct GasState {
    explicit GasState(const LoadSpec& load)
        : law(load.gauge_pressure, load.ambient_pressure, 1.0, 1.0), gauge(load.gauge_pressure) {}
    Gas law;
    double gauge;
    std::vector<std::pair<int, const FollowerPressure*>> blocks;  // element, block
    Eigen::Matrix3Xd at;          // displacements that what follows belongs to
    double change = 0.0;          // of the volume
    double pressure = 0.0;        // gauge; the blocks read it
    Eigen::Matrix3Xd gradient;    // of the volume, / force unit
    std::vector<double> volumes;  // change of each block's
    std::vector<double> shares;   // unknowns of problem(), zero wherever the rest belongs to
  };
  std::unique_ptr<GasState> gas_;

  EffectReport effects_[kNumEffects];
  // Membrane and bending energy of each element, within the problem's blocks.
  std::vector<const ceres::CostFunction*> strain_energies_[2];
  std::vector<ceres::ResidualBlockId> blocks_[kNumEffects];
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SHELL_PROBLEM_H_
