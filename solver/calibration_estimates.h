#ifndef DARBOUX_SOLVER_CALIBRATION_ESTIMATES_H_
#define DARBOUX_SOLVER_CALIBRATION_ESTIMATES_H_

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "solver/calibration_problem.h"
#include "solver/posterior.h"
#include "solver/state_model.h"

namespace darboux {

// What the minimum of a CalibrationProblem says about its parameters: intervals, correlations,
// sensitivities, and verdicts in words. Inside of the solver.
//
// A parameter is identified where its 95 % interval is within a factor of 1.65 (Young's modulus,
// thickness) or +-0.2 (Poisson's ratio), a pressure where it is within that factor or changes no
// force by more than 5 %. What is not is told with the parameter that it trades against, along the
// direction that is determined least, and with the grasp that would tell them apart: of travels of
// 0.25, 0.5, 1.5 and 2 times the present one, solved for, that which leaves the smallest interval.
class CalibrationEstimates {
 public:
  // Everything must outlive this; models are in the states of the problem, and are so again.
  CalibrationEstimates(const CalibrationSpec& spec,
                       CalibrationProblem* problem,
                       std::vector<std::unique_ptr<StateModel>>* models,
                       CalibrationSummary* summary)
      : spec_(spec), problem_(problem), models_(models), summary_(*summary) {}

  // Fills estimates, correlation, sensitivities and the deviations of travels.
  void Report();

 private:
  void Sensitivities(const Posterior& posterior);
  void Bootstrap(const std::vector<CalibrationProblem::Row>& rows);
  std::string SeparatingGrasp(const Posterior& posterior,
                              const Eigen::VectorXd& scales,
                              size_t which);
  Eigen::VectorXd Scales() const;
  double ToUnits(int column, double value) const;
  bool IsIdentified(StateParameter parameter, double deviation) const;
  double PressureEffect(double pressure) const;

  const CalibrationSpec& spec_;
  CalibrationProblem* problem_;
  std::vector<std::unique_ptr<StateModel>>* models_;
  CalibrationSummary& summary_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_ESTIMATES_H_
