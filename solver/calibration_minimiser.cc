#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "solver/calibration_run.h"
#include "solver/format.h"

// The outer minimum, by Ceres.

namespace darboux {

bool CalibrationRun::Minimise(std::string* message) {
  // Costs are squares of standard deviations: a change less than kNothing is nothing, in exact data
  // too; and one less than kEnough of the cost.
  constexpr double kNothing = 1e-10, kEnough = 1e-5;
  class Stop : public ceres::IterationCallback {
   public:
    Stop(const CalibrationRun* owner, int* iterations) : owner_(*owner), iterations_(iterations) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
      const ShellParameters now = owner_.problem_->Parameters();
      std::ostringstream line;
      line.precision(6);
      line << "iteration " << *iterations_ << "  cost " << step.cost << "  E " << now.young_modulus;
      CalibrationIteration report;
      report.iteration = *iterations_;
      report.cost = step.cost;
      report.parameters.emplace_back(ToString(StateParameter::kYoungModulus), now.young_modulus);
      for (int k = 1; k < 4; ++k) {
        const StateParameter p = static_cast<StateParameter>(k);
        if (!owner_.spec_.parameter(p).asked) continue;
        const double value = k == 1 ? now.thickness : k == 2 ? now.poisson_ratio : now.gas_pressure;
        line << "  " << ToString(p) << " " << value;
        report.parameters.emplace_back(ToString(p), value);
      }
      report.seconds = Since(owner_.start_);
      line << "  " << Format("%.2f s", report.seconds);
      report.text = line.str();
      if (step.iteration > 0 && step.step_is_successful) {
        const double end = kNothing + kEnough * step.cost;
        const double rate = step.cost_change / change_;  // of the changes, per iteration
        if (change_ > 0.0 && step.cost_change > end && rate < 1.0) {
          const double left = std::ceil(std::log(end / step.cost_change) / std::log(rate));
          report.seconds_left = left * (report.seconds - begun_) / step.iteration;
        }
        change_ = step.cost_change;
      } else if (step.iteration == 0) {
        begun_ = report.seconds;
      }
      if (owner_.options_.on_iteration) owner_.options_.on_iteration(report);
      ++*iterations_;
      if (step.iteration > 0 && step.step_is_successful &&
          step.cost_change <= kNothing + kEnough * step.cost) {
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      }
      // Poses that scans hardly determine creep. Half squares of standard deviations that change
      // by so little, time after time, change no estimate.
      constexpr double kCreep = 1e-3;
      constexpr int kCreeping = 5;
      const double creep = kCreep * std::min(1.0, step.cost);
      if (step.step_is_successful) creeping_ = step.cost_change <= creep ? creeping_ + 1 : 0;
      if (creeping_ >= kCreeping) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      return owner_.IsStopped() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
    }

   private:
    const CalibrationRun& owner_;
    int* iterations_;
    double change_ = 0.0, begun_ = 0.0;
    int creeping_ = 0;  // steps
  };
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = problem_.get();
  ceres::Problem problem(problem_options);
  problem_->Build(&problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = options_.max_iterations;
  options.function_tolerance = 0.0;  // Stop decides.
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 0.0;
  options.update_state_every_iteration = true;
  options.logging_type = ceres::SILENT;
  Stop stop(this, &summary_.iterations);
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary result;
  ceres::Solve(options, &problem, &result);
  summary_.cost = result.final_cost;
  // States, feet and distances belong to the last point that Ceres tried: to the one it chose now.
  problem_->PrepareForEvaluation(false, true);
  const bool converged = result.termination_type == ceres::CONVERGENCE ||
                         result.termination_type == ceres::USER_SUCCESS;
  // A state that was not found for lack of time ends Ceres in other ways.
  if (result.termination_type == ceres::USER_FAILURE ||
      (IsStopped() && (problem_->failed() || !converged))) {
    *message = kStopped;
    return false;
  }
  if (problem_->failed()) {
    *message = problem_->error();
    return false;
  }
  if (converged) return true;
  *message = result.message + (problem_->error().empty() ? "" : " (" + problem_->error() + ")");
  return false;
}

}  // namespace darboux
