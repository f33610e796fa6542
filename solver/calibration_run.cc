#include "solver/calibration_run.h"

#include <algorithm>
#include <cmath>

#include "solver/calibration_estimates.h"

namespace darboux {

Scene CalibrationRun::SceneOf(const CalibrationSpec::Grasp& grasp) const {
  Scene scene = grasp.scene;
  if (spec_.theory != Theory::kAuto) scene.model.theory = spec_.theory;
  scene.probes.clear();
  scene.expect.clear();
  const auto set = [&](StateParameter which, double* value) {
    const CalibrationSpec::Parameter& p = spec_.parameter(which);
    if (p.start) *value = *p.start;
  };
  set(StateParameter::kYoungModulus, &scene.shell.young_modulus);
  set(StateParameter::kThickness, &scene.shell.thickness);
  set(StateParameter::kPoissonRatio, &scene.shell.poisson_ratio);
  for (LoadSpec& load : scene.loads) {
    if (load.kind == LoadSpec::Kind::kGas) {
      set(StateParameter::kGasPressure, &load.gauge_pressure);
    }
  }
  return scene;
}

// Forces are nearly proportional to Young's modulus: Newton's first step in its logarithm would
// overshoot by orders of magnitude from a bad start.
void CalibrationRun::ScaleModulus() {
  if (!spec_.parameter(StateParameter::kYoungModulus).asked) return;
  double readings = 0.0, models = 0.0;
  for (const CalibrationProblem::Force& force : problem_->forces()) {
    if (FindGas((*models_)[force.grasp]->scene()) != nullptr) return;
    readings += force.reading;
    models += problem_->BareForceOf(force);
  }
  if (!(readings > 0.0) || !(models > 0.0)) return;
  ShellParameters parameters = problem_->Parameters();
  parameters.young_modulus *= readings / models;
  problem_->SetParameters(parameters);
}

void CalibrationRun::Report() {
  summary_.grasps.clear();
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const StateModel& model = *(*models_)[g];
    CalibrationSummary::Grasp grasp;
    grasp.scene = spec_.grasps[g].scene_file;
    grasp.theory = model.summary().theory;
    grasp.travel_change = problem_->TravelChange(static_cast<int>(g));
    grasp.max_displacement = model.max_displacement();
    for (const CalibrationProblem::Force& force : problem_->forces()) {
      if (force.grasp != static_cast<int>(g)) continue;
      grasp.forces.push_back({model.scene().fingers[force.finger].name,
                              force.reading,
                              problem_->ForceOf(force),
                              force.error});
    }
    size_t used = 0;
    for (size_t s = 0; s < problem_->scans().size(); ++s) {
      const CalibrationProblem::Scan& scan = problem_->scans()[s];
      if (scan.grasp != static_cast<int>(g)) continue;
      CalibrationSummary::Scan report;
      report.file = spec_.grasps[g].scans[used++].file;
      report.pose = problem_->PoseOf(static_cast<int>(s));
      report.deviation = scan.deviation;
      report.points = static_cast<int>(scan.points.size());
      std::vector<double> inliers;
      for (const ShellFace::Foot& foot : scan.feet) {
        if (std::abs(foot.distance) <= 3.0 * scan.deviation) inliers.push_back(foot.distance);
      }
      report.distances = MakeDistanceStatistics(inliers);
      report.inliers = static_cast<double>(inliers.size()) / std::max(1, report.points);
      CheckRegions(static_cast<int>(s), report);
      grasp.scans.push_back(report);
    }
    for (size_t f = 0; f < fields_.size(); ++f) {
      const CalibrationProblem::Field& field = problem_->fields()[f];
      if (field.grasp != static_cast<int>(g)) continue;
      CalibrationSummary::Field report;
      report.file = fields_[f].spec->file;
      report.points = static_cast<int>(field.points.size());
      report.beside = fields_[f].beside;
      report.deviation = field.deviation;
      report.independent = field.share * report.points;
      report.deformation = fields_[f].deformation;
      report.rotation = Eigen::Vector3d(field.motion.data()).norm();
      const int components = field.components[0] + field.components[1] + field.components[2];
      double sum = 0.0;
      int inliers = 0;
      for (size_t i = 0; i < field.points.size(); ++i) {
        double residuals[3];  // zero where not measured
        problem_->FieldResidual(field, static_cast<int>(i), residuals, nullptr);
        const Eigen::Map<Eigen::Vector3d> left(residuals);
        if (left.norm() > 3.0) continue;
        sum += left.squaredNorm();
        ++inliers;
      }
      report.rms = field.deviation * std::sqrt(sum / std::max(1, components * inliers));
      report.inliers = static_cast<double>(inliers) / std::max(1, report.points);
      grasp.fields.push_back(report);
    }
    summary_.grasps.push_back(std::move(grasp));
  }
  summary_.model_bias = problem_->bias();
  summary_.drift = problem_->drift();
  summary_.rest_offset = problem_->rest_offset();
}

bool CalibrationRun::Run(std::vector<std::unique_ptr<StateModel>>* models, std::string* error) {
  models_ = models;
  models->clear();
  for (const CalibrationSpec::Grasp& grasp : spec_.grasps) {
    Progress("solving " + grasp.scene_file);
    auto model = StateModel::Create(SceneOf(grasp), options_.solver, error);
    if (model == nullptr) {
      if (IsStopped()) return End(Termination::kStopped, kStopped);
      // A scene that cannot be posed is bad input; one without solution is trouble.
      return error->find("has no solution") != std::string::npos ? End(Termination::kFailed, *error)
                                                                 : false;
    }
    models->push_back(std::move(model));
  }
  problem_ = std::make_unique<CalibrationProblem>(spec_, options_.solver.num_threads, models);
  if (!AddScans(error) || !AddFields(error)) return false;
  if (summary_.termination != Termination::kNotRun) return true;  // Without match, or stopped.
  problem_->Finish();
  ScaleModulus();
  problem_->PrepareForEvaluation(false, true);
  if (problem_->failed()) return EndWithoutState();
  AlignFields();
  problem_->PrepareForEvaluation(false, true);
  if (problem_->failed()) return EndWithoutState();
  SetDeviations();
  std::string message;
  bool converged = false;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    converged = Minimise(&message);
    if (!converged) break;
    started_ = true;
    const bool estimated =
        std::find(estimate_scan_.begin(), estimate_scan_.end(), true) != estimate_scan_.end() ||
        !fields_.empty();
    if (!SetDeviations() || (!estimated && round > 0)) break;
  }
  Report();
  for (const auto& model : *models) {
    summary_.work.solutions += model->work().solutions;
    summary_.work.factorisations += model->work().factorisations;
    summary_.work.iterations += model->work().iterations;
    summary_.work.solve_s += model->work().solve_s;
    summary_.work.derivative_s += model->work().derivative_s;
  }
  summary_.seconds = Since(start_);
  if (!converged) {
    return End(message == kStopped ? Termination::kStopped : Termination::kNotConverged, message);
  }
  if (contradictions_end_ && !contradiction_.empty())
    return End(Termination::kNoMatch, "no match: " + contradiction_);
  CalibrationEstimates(spec_, problem_.get(), models_, &summary_).Report();
  summary_.seconds = Since(start_);
  return End(Termination::kConverged, "converged");
}

}  // namespace darboux
