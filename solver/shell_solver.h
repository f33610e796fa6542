#ifndef DARBOUX_SOLVER_SHELL_SOLVER_H_
#define DARBOUX_SOLVER_SHELL_SOLVER_H_

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/grasp_quality.h"
#include "solver/iteration_log.h"
#include "solver/resolution.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// One line of progress.
struct StepReport {
  int step = 0;  // 1-based; of `steps`
  int steps = 1;
  double load_factor = 0.0;
  int iterations = 0;
  double energy = 0.0;             // J
  double relative_gradient = 0.0;  // |g| / (|f| + |reactions|)
  double max_displacement = 0.0;   // m
  double seconds = 0.0;            // since Solve began
  bool converged = false;
};

// How a scene is solved; the scene says what.
struct SolverOptions {
  SparseBackend backend = SparseBackend::kAuto;
  int num_threads = 2;
  int max_iterations = 200;  // per load step
  // Converged when |gradient| <= tolerance * (|loads| + |reactions|), Euclidean norms.
  double gradient_tolerance = 1e-7;
  double time_limit_s = 0.0;  // 0 = none
  // The relative error that `theory: auto` accepts from the linear theory before it switches to
  // the nonlinear one; scene.model.accuracy where given.
  double theory_tolerance = 0.01;
  // Nonlinear theory: control displacements to start from, 3 x control vertices; empty = rest.
  Eigen::Matrix3Xd initial_displacements;
  // With it, where fingers have as many contact points: their multipliers (Grasp::State) in that
  // state, so that contact need not be found anew. Empty: none.
  std::vector<double> initial_contact;
  const std::atomic<bool>* stop = nullptr;  // set from elsewhere (Ctrl-C): stop at the next chance
  std::function<void(const StepReport&)> on_step;  // after each load step
  // In every iteration, on the thread of Solve; what it takes is added to the solve.
  std::function<void(const IterationReport&)> on_iteration;

  bool IsValid(std::string* error) const;
};

// An effect, and the energy that is in it at the end.
struct EffectSummary {
  std::string name;
  EffectReport report;
  double energy = 0.0;
};

// A probe at the end.
struct ProbeSummary {
  std::string name;
  Eigen::Vector3d position;  // rest position of the surface point
  Eigen::Vector3d displacement;
};

// State at the end of a load step.
struct LoadStep {
  double factor = 0.0;
  int iterations = 0;
  bool converged = false;
  double energy = 0.0;
  std::array<double, kNumEffects> energies = {};  // of each effect, J
  double relative_gradient = 0.0;
  double max_displacement = 0.0;
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> probe_displacements;  // in the order of scene.probes
  Eigen::Matrix3Xd displacements;                    // control displacements
  // Nonlinear theory only (solver/stability.h); no number of modes where the matrix is singular.
  std::optional<int> negative_modes;  // of the Hessian: 0 = stable
  std::optional<double> softness;
  Eigen::Matrix3Xd mode;     // the softest, where unstable or nearly so; else empty
  bool limit_point = false;  // the load factor has an extremum here (path following), or
  // at this factor on the way, where the shell gave way to the forces that drive fingers.
  std::optional<double> limit_factor;
  std::vector<FingerReport> fingers;
  std::vector<ContactPointReport> contact_points;
  std::optional<GraspReport> grasp;
  std::optional<GasReport> gas;
};

// What Solve has found and done; starts as "not run".
struct SolverSummary {
  enum class Termination { kNotRun, kConverged, kNotConverged, kTimeLimit, kStopped, kFailed };
  Termination termination = Termination::kNotRun;
  std::string message = "not run";

  Theory theory = Theory::kAuto;  // the one used
  std::string theory_reason;
  // Estimate of what the linear theory leaves out, relative; -1 where not made.
  double nonlinearity_estimate = -1.0;
  std::string backend;
  int dof = -1;
  int unknowns = -1;
  int elements = -1;
  int quadrature_points = -1;
  int iterations = -1;
  std::vector<EffectSummary> effects;
  std::vector<std::string> free_motions;
  double energy_total = 0.0, load_work = 0.0, support_energy = 0.0;
  std::vector<ProbeSummary> probes;
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();
  Eigen::Vector3d applied_force = Eigen::Vector3d::Zero();
  double max_displacement = 0.0;
  double max_membrane_strain = 0.0;  // largest principal, absolute
  double max_rotation = 0.0;         // rad, of the normal
  double gradient_norm = 0.0;        // relative, see SolverOptions
  double force_balance = 0.0;        // resultant of loads and reactions, relative
  // Whether the mesh can show this state; what is wrong with it is one of the decisions.
  std::optional<Resolution> resolution;
  std::vector<LoadStep> steps;
  std::vector<IterationReport> iteration_history;  // all of them, those of failed steps too
  std::vector<std::string> decisions;              // what the solver chose and why, one line each
  double setup_s = 0.0, solve_s = 0.0;
  // Steps of the nonlinear theory that took the matrix and factor of the one before, and about how
  // much time that has saved.
  int kept_factors = 0;
  double kept_factors_saved_s = 0.0;

  bool IsConverged() const { return termination == Termination::kConverged; }
  bool IsSolutionUsable() const { return !steps.empty(); }
  std::string BriefReport() const;
  std::string FullReport() const;
};

// Where a scene is solved: keeps the problem of the final theory for whoever writes results.
// False and *error (bad input) when the scene cannot be posed; solver trouble is in *summary.
bool Solve(const Scene& scene,
           const SolverOptions& options,
           std::unique_ptr<ShellProblem>* problem,
           SolverSummary* summary,
           std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SHELL_SOLVER_H_
