#ifndef DARBOUX_SOLVER_STATE_MODEL_H_
#define DARBOUX_SOLVER_STATE_MODEL_H_

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/equilibrium_sensitivity.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What calibration asks for, in the scene's units.
struct ShellParameters {
  double young_modulus = 0.0;
  double thickness = 0.0;
  double poisson_ratio = 0.0;
  double gas_pressure = 0.0;  // gauge, at the rest volume; without meaning where there is no gas
};
ShellParameters ParametersOf(const Scene& scene);

// The final state of a scene as a function of its parameters and of a change of the fingers'
// travel, with derivatives. Solves no more than it has to: where nothing but fingers and supports
// act on a shell without gas, its shape does not depend on Young's modulus, and its forces are
// proportional to it; states and derivatives are kept until something changes.
//
// A finger that the scene drives by a force is driven by travel here, by that which the force leads
// to with the scene's own parameters: a measured force is data, and the travel is then what the
// scans have to tell.
class StateModel {
 public:
  // What the states have cost so far.
  struct Work {
    int solutions = 0, factorisations = 0, iterations = 0;
    double solve_s = 0.0, derivative_s = 0.0;
  };

  // Null and *error where the scene cannot be posed or a force leads to no equilibrium.
  static std::unique_ptr<StateModel> Create(const Scene& scene,
                                            const SolverOptions& options,
                                            std::string* error);

  // False and *error where there is no equilibrium; then the state is the last one.
  bool Solve(const ShellParameters& parameters, double travel_change, std::string* error);

  // Of the state. Derivatives are by EquilibriumSensitivity; with friction, where the state depends
  // on the way, by differences of two solutions.
  const Eigen::Matrix3Xd& displacements() const { return displacements_; }
  // Of each finger along its direction, positive where the shell resists.
  const Eigen::VectorXd& forces() const { return forces_; }
  const ShellParameters& parameters() const { return parameters_; }
  double travel_change() const { return travel_change_; }
  double max_displacement() const { return max_displacement_; }
  // False and *error where there is no such derivative.
  bool Derivative(StateParameter parameter, const StateDerivative** derivative, std::string* error);

  // After the last derivative: problem() and summary() are those of the present state, as Solve
  // leaves them, whatever was known without solving. False and *error where there is none.
  bool Settle(std::string* error);

  const Scene& scene() const { return scene_; }
  // The scene at the state's parameters.
  Scene StateScene() const;
  const ShellProblem& problem() const { return *problem_; }
  // Of the last solution; forces and energies in it are those of Young's modulus at that time.
  const SolverSummary& summary() const { return summary_; }
  const Work& work() const { return work_; }
  // Whether a finger is driven by a force in the scene: its travel is not known.
  bool by_force() const { return by_force_; }

 private:
  StateModel(const Scene& scene, const SolverOptions& options) : scene_(scene), options_(options) {}
  Scene At(const ShellParameters& parameters, double travel_change) const;
  Eigen::Matrix3Xd Guess(const ShellParameters& parameters, double travel_change) const;
  // guess: where to start from; empty: from rest.
  bool SolveAnew(const Scene& scene, const Eigen::Matrix3Xd& guess, std::string* error);
  bool DeriveImplicitly(StateParameter parameter, StateDerivative* derivative, std::string* error);
  bool DeriveByDifferences(StateParameter parameter,
                           StateDerivative* derivative,
                           std::string* error);

  Scene scene_;
  SolverOptions options_;
  bool by_force_ = false;
  bool scales_with_modulus_ = false;  // shape independent of E, forces proportional to it
  bool has_friction_ = false;
  ShellParameters parameters_;
  double travel_change_ = 0.0;
  double solved_modulus_ = 0.0;  // that of *problem_
  std::unique_ptr<ShellProblem> problem_;
  SolverSummary summary_;
  Eigen::Matrix3Xd displacements_;
  std::vector<double> contact_;  // multipliers, as SolverOptions::initial_contact
  Eigen::VectorXd forces_;
  double max_displacement_ = 0.0;
  std::array<std::optional<StateDerivative>, kNumStateParameters> derivatives_;
  std::unique_ptr<ShellProblem> bare_;  // as gas has inflated it before the fingers come
  std::unique_ptr<EquilibriumSensitivity> sensitivity_, bare_sensitivity_;  // of both problems
  Work work_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_STATE_MODEL_H_
