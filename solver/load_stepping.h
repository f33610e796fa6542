#ifndef DARBOUX_SOLVER_LOAD_STEPPING_H_
#define DARBOUX_SOLVER_LOAD_STEPPING_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/grasp_quality.h"
#include "solver/minimisation.h"
#include "solver/mixed_iteration.h"
#include "solver/shell_problem.h"

namespace darboux {

// Takes a nonlinear problem from one load factor to the next: the mixed iteration with load steps
// that it chooses and cuts back itself, then Ceres, which certifies the state or goes on by
// descent. Keeps the last good state. Inside of the solver.
class LoadStepping {
 public:
  // How a step ended.
  struct Result {
    bool converged = false;
    int iterations = 0;
    Equilibrium equilibrium;
    std::string message;
  };

  // `decisions` gets one line for each choice. Both must outlive this.
  LoadStepping(ShellProblem* problem,
               const SolverOptions& options,
               const Deadline& deadline,
               std::vector<std::string>* decisions);

  // To the given load factor. Not converged: the problem is left in the last good state, at its
  // load factor, or where none is on the way, in the state that was nearest.
  Result Advance(double factor);

  // Where minimizer ceres starts from: a multiple of the linear theory's answer.
  void SetLinearSolution(const Eigen::Matrix3Xd& displacements,
                         const std::vector<double>& multipliers) {
    linear_displacements_ = displacements;
    linear_multipliers_ = multipliers;
  }
  // Control displacements to start from instead of rest. Where they lead to no equilibrium, or to
  // one that is unstable or (without fingers) has more energy than the undeformed shell, that is
  // noted, and the answer is what is found from rest. contact: multipliers of contact there, or
  // none.
  void SetStart(const Eigen::Matrix3Xd& displacements, const std::vector<double>& contact) {
    start_ = displacements;
    start_contact_ = contact;
  }

  // From an unstable equilibrium, which must be the last good state: pushed a little along the
  // mode, either way, and down in energy by Ceres. The lower of the two is the new good state.
  Result LeaveUnstable(const Eigen::Matrix3Xd& mode);

  // Where the last Advance has left a limit point of the forces that drive fingers behind: its load
  // factor.
  const std::optional<double>& limit_factor() const { return limit_factor_; }

  // Steps that took a factor at hand, and about how many seconds that has saved: what as many
  // iterations with matrices of their own would have taken more.
  int chords() const { return chords_; }
  double saved_s() const { return saved_s_; }

  // Load factor of the last good state.
  double good_factor() const { return good_.factor; }
  MixedIteration& mixed() { return *mixed_; }
  // Null without fingers; has all good states recorded.
  const GraspQuality* quality() const { return quality_.get(); }

 private:
  struct State {
    double factor = 0.0;
    Eigen::Matrix3Xd displacements;
    std::vector<double> multipliers;
    TangentStiffness::StressField stresses;
    Grasp::State grasp;
    double travel_rate = -1.0;  // DrivenTravelRate; < 0: not known
  };
  MixedIteration::Options MixedOptions() const;
  State Present() const;
  // The present state is the next good one. is_result: one that was asked for.
  void Accept(bool is_result = true);
  void Restore(const State& state);
  bool AdvanceMixed(double factor, Result* result);
  void CountChords(const MixedIteration::Summary& summary);
  // Multipliers of contact and lagged friction, with as many more iterations as they need, after
  // the first solution at a load factor.
  void SettleGrasp(const MixedIteration::Options& options,
                   bool fine,
                   MixedIteration::Summary* summary);
  // Fingers driven by forces: whether the shell has given way between the last good state and the
  // present one, so that no path of equilibria on which the forces grow leads from one to the
  // other: tells where.
  void LookForSnap(const MixedIteration::Options& options, MixedIteration::Summary* summary);
  // Sum of force at full load * travel, and of the present state its rate by the load factor:
  // infinite where it is unstable.
  double DrivenTravel(const State& state) const;
  double DrivenTravelRate();
  // Ceres' descent at the present load factor, with multipliers of contact and lagged friction.
  void DescendAndSettle(Result* result);
  bool AdvanceFromStart(double factor, Result* result);
  Result AdvanceByConjugateGradients(double factor);
  Result AdvanceByDescent(double factor);
  bool FillByDescent(Result* result);
  void Note(const std::string& decision) { decisions_->push_back(decision); }

  ShellProblem* problem_;
  SolverOptions options_;
  Deadline deadline_;
  std::vector<std::string>* decisions_;
  std::unique_ptr<MixedIteration> mixed_;
  int chords_ = 0;
  double saved_s_ = 0.0;
  double travel_rate_ = -1.0;  // DrivenTravelRate after LookForSnap
  std::optional<double> limit_factor_;
  std::unique_ptr<GraspQuality> quality_;
  State good_;
  State before_good_;  // the one before it; no displacements: there is none
  Eigen::Matrix3Xd start_;
  std::vector<double> start_contact_;
  Eigen::Matrix3Xd linear_displacements_;
  std::vector<double> linear_multipliers_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_LOAD_STEPPING_H_
