#ifndef DARBOUX_SOLVER_CALIBRATION_RUN_H_
#define DARBOUX_SOLVER_CALIBRATION_RUN_H_

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "solver/calibration_problem.h"
#include "solver/minimisation.h"

namespace darboux {

// What Calibrate does for one theory: states, scans registered with them and fields aligned, and in
// turns the outer minimum and the deviations of points. Inside of the solver.
class CalibrationRun {
 public:
  CalibrationRun(const CalibrationSpec& spec,
                 const CalibrationOptions& options,
                 CalibrationSummary* summary)
      : spec_(spec), options_(options), summary_(*summary), start_(Clock::now()) {}

  void IgnoreContradictions() { contradictions_end_ = false; }
  bool Run(std::vector<std::unique_ptr<StateModel>>* models, std::string* error);

 private:
  static constexpr char kStopped[] =
      "stopped before there was a result: interrupted, or out of time";
  // Robust distances of a scan to the state of its scene, in sizes of the shell, before anything is
  // fitted.
  static constexpr double kFarthest = 0.04;

  using Termination = CalibrationSummary::Termination;

  void Progress(const std::string& line) const {
    if (options_.on_progress) options_.on_progress(line);
  }
  bool End(Termination termination, const std::string& message) {
    summary_.termination = termination;
    summary_.message = message;
    return true;
  }
  bool EndWithoutState() {
    return IsStopped() ? End(Termination::kStopped, kStopped)
                       : End(Termination::kFailed, problem_->error());
  }
  bool IsStopped() const {
    const SolverOptions& solver = options_.solver;
    return (solver.time_limit_s > 0.0 && Since(start_) > solver.time_limit_s) ||
           (solver.stop != nullptr && solver.stop->load());
  }
  Scene SceneOf(const CalibrationSpec::Grasp& grasp) const;
  bool AddScans(std::string* error);
  bool AddFields(std::string* error);
  bool SetDeviations();
  bool SetFieldDeviations();
  double RegionVariance(const CalibrationProblem::Field& field,
                        const std::vector<std::array<double, 3>>& left) const;
  void AlignFields();
  void ScaleModulus();
  bool Minimise(std::string* message);
  void CheckRegions(int number, const CalibrationSummary::Scan& report);
  void Report();

  const CalibrationSpec& spec_;
  const CalibrationOptions& options_;
  CalibrationSummary& summary_;
  const Clock::time_point start_;
  std::vector<std::unique_ptr<StateModel>>* models_ = nullptr;
  std::unique_ptr<CalibrationProblem> problem_;
  bool contradictions_end_ = true;
  std::string contradiction_;        // of a scan to its state; empty: none
  std::vector<bool> estimate_scan_;  // deviations
  struct FieldPlan {
    const CalibrationSpec::Field* spec = nullptr;
    std::vector<int> regions;  // of each point; empty: too few points to tell
    int num_regions = 0, beside = 0;
    double deformation = 0.0;
  };
  std::vector<FieldPlan> fields_;  // of the problem's
  bool started_ = false;           // something has been minimised
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_RUN_H_
