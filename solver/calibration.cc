#include "solver/calibration.h"

#include <algorithm>
#include <optional>

#include "solver/calibration_run.h"

namespace darboux {

bool CalibrationSpec::IsValid(std::string* error) const {
  const auto fail = [&](const std::string& what) {
    *error = what;
    return false;
  };
  bool asked = false, data = false;
  for (const Parameter& p : parameters) asked = asked || p.asked;
  if (!asked) return fail("no parameter is asked for");
  if (grasps.empty()) return fail("there are no grasps");
  for (const Grasp& grasp : grasps) {
    data = data || !grasp.scans.empty() || !grasp.fields.empty() || !grasp.forces.empty();
    for (const Field& field : grasp.fields) {
      if (!(field.noise >= 0.0) || !(field.shape_error >= 0.0)) {
        return fail("errors of a field must not be negative");
      }
      if (field.cloud.displacements.size() != field.cloud.points.size()) {
        return fail("a field has no displacements");
      }
      if (!field.components[0] && !field.components[1] &&
          !(field.components[2] && field.cloud.has_uz)) {
        return fail("a field has no component");
      }
    }
    for (const ForceReading& force : grasp.forces) {
      if (force.finger < 0 || force.finger >= static_cast<int>(grasp.scene.fingers.size())) {
        return fail("a force reading names no finger of its scene");
      }
      if (!(force.error > 0.0)) return fail("the error of a force reading must be positive");
    }
    if (!(grasp.travel_error >= 0.0)) return fail("travel_error must not be negative");
  }
  if (!data) return fail("there is nothing measured");
  if (!(noise >= 0.0)) return fail("noise must not be negative");
  if (!(model_error >= 0.0) || !(shape_error >= 0.0) || !(force_drift >= 0.0)) {
    return fail("errors must not be negative");
  }
  return true;
}

bool Calibrate(const CalibrationSpec& spec,
               const CalibrationOptions& options,
               CalibrationSummary* summary,
               std::vector<std::unique_ptr<StateModel>>* models,
               std::string* error) {
  *summary = CalibrationSummary();
  if (!spec.IsValid(error) || !options.solver.IsValid(error)) return false;
  std::vector<std::unique_ptr<StateModel>> own;
  CalibrationRun calibration(spec, options, summary);
  if (!calibration.Run(models != nullptr ? models : &own, error)) return false;
  const auto& used = models != nullptr ? *models : own;
  const bool nonlinear =
      std::any_of(used.begin(), used.end(), [](const std::unique_ptr<StateModel>& model) {
        // Gas is for the nonlinear theory: what it does before fingers come is not small.
        return model->summary().theory == Theory::kNonlinear && FindGas(model->scene()) == nullptr;
      });
  for (const std::unique_ptr<StateModel>& model : used) {
    const std::optional<Resolution>& resolution = model->summary().resolution;
    const std::string complaint = resolution ? resolution->Complaint() : "";
    if (!complaint.empty()) {
      summary->notes.push_back("scene " + model->scene().name + ": " + complaint);
    }
  }
  if (spec.compare_linear && nonlinear && summary->IsConverged() &&
      summary->Find(StateParameter::kYoungModulus) != nullptr) {
    CalibrationSpec linear = spec;
    linear.theory = Theory::kLinear;
    linear.compare_linear = false;
    linear.bootstrap = 0;
    CalibrationSummary result;
    std::string trouble;
    if (options.on_progress) options.on_progress("the same in the linear theory");
    CalibrationRun comparison(linear, options, &result);
    comparison.IgnoreContradictions();  // Its shapes are wrong, which is the point.
    std::vector<std::unique_ptr<StateModel>> linear_models;
    if (comparison.Run(&linear_models, &trouble) && result.IsConverged()) {
      summary->linear_young_modulus = result.Find(StateParameter::kYoungModulus)->value;
    } else {
      summary->notes.push_back("the linear theory has no answer: " +
                               (trouble.empty() ? result.message : trouble));
    }
  }
  return true;
}

}  // namespace darboux
