#include "solver/summary_json.h"

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "solver/results.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

Json Components(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

// Replaces numbers that are not finite by null; returns how many there were.
size_t ReplaceNonFinite(Json* json) {
  if (json->is_number_float()) {
    if (std::isfinite(json->get<double>())) return 0;
    *json = nullptr;
    return 1;
  }
  size_t count = 0;
  if (json->is_structured()) {
    for (Json& child : *json) count += ReplaceNonFinite(&child);
  }
  return count;
}

Json EnergyOf(const SolverSummary& summary) {
  const auto energy = [&](const char* name) {
    for (const EffectSummary& effect : summary.effects) {
      if (effect.name == name) return effect.energy;
    }
    return 0.0;
  };
  return {{"membrane", energy("membrane")},
          {"bending", energy("bending")},
          {"gas", energy("gas")},
          {"contact", energy("contact")},
          {"supports", summary.support_energy},
          {"load_work", summary.load_work},
          {"total", summary.energy_total}};
}

// The cone about the mean normal that the finger's force on the shell has to stay in.
Json FrictionConeOf(const FingerReport& finger, double friction) {
  Json json = {{"axis", Components(finger.normal)},
               {"half_angle", std::atan(friction)},
               {"force_angle", nullptr},
               {"used", nullptr}};
  if (finger.contact_points == 0) return json;
  const Eigen::Vector3d force = -finger.force;
  const double across = finger.normal.cross(force).norm(), along = finger.normal.dot(force);
  json["force_angle"] = std::atan2(across, along);
  if (friction > 0.0 && along > 0.0) json["used"] = across / (along * friction);
  return json;
}

Json ToJson(const ForceClosure& closure,
            const std::vector<GraspContact>& contacts,
            const Eigen::Vector3d& center,
            double length) {
  return {{"closed", closure.closed},
          {"margin", closure.margin},
          {"least_friction", Optional(LeastFriction(contacts, center, length))},
          {"lacks", closure.lacks}};
}

Json ToJson(const GraspReport& grasp) {
  Json stiffness = Json::array();
  for (Eigen::Index i = 0; i < grasp.stiffness.rows(); ++i) {
    Json& row = stiffness.emplace_back(Json::array());
    for (Eigen::Index j = 0; j < grasp.stiffness.cols(); ++j) row.push_back(grasp.stiffness(i, j));
  }
  return {
      {"force_closure_before",
       ToJson(grasp.closure_before, grasp.before, grasp.center_before, grasp.length)},
      {"force_closure_after", ToJson(grasp.closure_after, grasp.after, grasp.center, grasp.length)},
      {"squeeze_work", grasp.squeeze_work},
      {"stored_energy", grasp.stored_energy},
      {"stiffness", std::move(stiffness)},
      {"center_before", Components(grasp.center_before)},
      {"center", Components(grasp.center)},
      {"length", grasp.length}};
}

Json ToJson(const AccuracyReport& accuracy) {
  Json levels = Json::array();
  for (const AccuracyLevel& level : accuracy.levels) {
    levels.push_back({{"divisions", level.divisions},
                      {"dof", level.dof},
                      {"elements", level.elements},
                      {"quadrature", level.quadrature},
                      {"theory", ToString(level.theory)},
                      {"solutions", level.solutions},
                      {"estimate", Optional(level.estimate)},
                      {"seconds", level.seconds}});
  }
  return {{"target", accuracy.target},
          {"estimate", Optional(accuracy.estimate)},
          {"discretisation", Optional(accuracy.discretisation)},
          {"contact", Optional(accuracy.contact)},
          {"solver", Optional(accuracy.solver)},
          {"theory", Optional(accuracy.theory)},
          {"reached", accuracy.reached},
          {"message", accuracy.message},
          {"levels", std::move(levels)}};
}

}  // namespace

Json Optional(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

bool HasStiffness(const LoadStep& step) { return step.grasp && step.grasp->stiffness.size() > 0; }

void MarkNotFinite(size_t count, const std::string& what, Json* json) {
  if (count == 0) return;
  (*json)["converged"] = false;
  std::string message = (*json)["message"].get<std::string>();
  if (!message.empty()) message += "; ";
  (*json)["message"] = message + std::to_string(count) + what;
}

nlohmann::ordered_json MakeSummaryJson(const Scene& scene,
                                       const SolverSummary& summary,
                                       const AccuracyReport* accuracy) {
  Json json;
  json["name"] = scene.name;
  json["converged"] = summary.IsConverged();
  json["message"] = summary.message;
  json["theory"] = ToString(summary.theory);
  json["theory_reason"] = summary.theory_reason;
  json["nonlinearity_estimate"] = summary.nonlinearity_estimate >= 0.0
                                      ? Optional(summary.nonlinearity_estimate)
                                      : Json(nullptr);
  json["strains"] = ToString(scene.model.strains);
  json["backend"] = summary.backend;
  json["dof"] = summary.dof;
  json["unknowns"] = summary.unknowns;
  json["elements"] = summary.elements;
  json["quadrature_points"] = summary.quadrature_points;

  // The contract's effects are there even if the solver never came to name them.
  Json& effects = json["effects"] = Json::object();
  for (int i = 0; i < kNumEffects; ++i) {
    effects[ToString(static_cast<Effect>(i))] = {
        {"on", false}, {"why", "not run"}, {"residual_blocks", 0}, {"residuals", 0}};
  }
  for (const EffectSummary& effect : summary.effects) {
    effects[effect.name] = {{"on", effect.report.on},
                            {"why", effect.report.why},
                            {"residual_blocks", effect.report.residual_blocks},
                            {"residuals", effect.report.residuals}};
  }
  json["energy"] = EnergyOf(summary);
  Json& probes = json["probes"] = Json::object();
  for (const ProbeSummary& probe : summary.probes) {
    const Eigen::Vector3d& x = probe.position;
    probes[probe.name] = {{"position", {x.x(), x.y(), x.z()}},
                          {"displacement", Components(probe.displacement)}};
  }
  Json& fingers = json["fingers"] = Json::object();
  if (!summary.steps.empty()) {
    const LoadStep& last = summary.steps.back();
    for (size_t i = 0; i < last.fingers.size(); ++i) {
      const FingerReport& finger = last.fingers[i];
      Json& entry = fingers[finger.name];
      entry = {{"force", Components(finger.force)},
               {"normal_force", finger.normal_force},
               {"travel", finger.travel},
               {"contact_area", finger.contact_area},
               {"largest_pressure", finger.largest_pressure},
               {"penetration", finger.penetration},
               {"shift", finger.shift},
               {"indentation", finger.indentation},
               {"driven_by", finger.by_force ? "force" : "travel"},
               {"normal_before", Components(finger.normal_before)},
               {"normal", Components(finger.normal)},
               {"center_before", Components(finger.center_before)},
               {"center", Components(finger.center)},
               {"spin_arm", finger.spin_arm},
               {"friction_cone", FrictionConeOf(finger, scene.fingers[i].friction)},
               {"stiffness", nullptr},
               {"contact_points", finger.contact_points},
               {"sticking", finger.sticking},
               {"slipping", finger.slipping}};
      if (HasStiffness(last)) entry["stiffness"] = last.grasp->stiffness(i, i);
    }
  }
  Json& grasp = json["grasp"] = Json::object();
  if (!summary.steps.empty() && summary.steps.back().grasp) {
    grasp = ToJson(*summary.steps.back().grasp);
  }
  json["supports"] = {{"reaction", Components(summary.reaction)}};
  json["gas"] = {{"gauge_pressure", 0.0}, {"volume", 0.0}, {"volume_ratio", 1.0}};
  for (const LoadSpec& load : scene.loads) {
    if (load.kind != LoadSpec::Kind::kGas || summary.steps.empty()) continue;
    if (!summary.steps.back().gas) continue;
    const GasReport& gas = *summary.steps.back().gas;
    json["gas"] = {{"gauge_pressure", gas.gauge_pressure},
                   {"volume", gas.volume},
                   {"volume_ratio", gas.volume_ratio},
                   {"absolute_pressure", gas.absolute_pressure},
                   {"law", ToString(load.law)}};
  }
  json["max_displacement"] = summary.max_displacement;
  json["max_membrane_strain"] = summary.max_membrane_strain;
  json["max_rotation"] = summary.max_rotation;
  json["equilibrium"] = {{"gradient_norm", summary.gradient_norm},
                         {"force_balance", summary.force_balance}};
  json["iterations"] = summary.iterations;
  Json limits = Json::array();
  Json& steps = json["load_steps"] = Json::array();
  for (const LoadStep& step : summary.steps) {
    steps.push_back({{"factor", step.factor},
                     {"iterations", step.iterations},
                     {"converged", step.converged},
                     {"energy", step.energy},
                     {"relative_gradient", step.relative_gradient},
                     {"max_displacement", step.max_displacement},
                     {"negative_modes", nullptr},
                     {"limit_point", step.limit_point}});
    if (step.negative_modes) steps.back()["negative_modes"] = *step.negative_modes;
    if (!step.limit_point) continue;
    if (step.limit_factor) {  // The state there is no step.
      limits.push_back({{"factor", *step.limit_factor}});
      continue;
    }
    Json limit = {{"factor", step.factor}, {"energy", step.energy}, {"probes", Json::object()}};
    for (size_t i = 0; i < scene.probes.size(); ++i) {
      limit["probes"][scene.probes[i].name]["displacement"] =
          Components(step.probe_displacements[i]);
    }
    limits.push_back(std::move(limit));
  }
  json["limit_points"] = limits;
  Json& stability = json["stability"] = {{"negative_modes", nullptr}, {"softness", nullptr}};
  if (!summary.steps.empty()) {
    const LoadStep& last = summary.steps.back();
    if (last.negative_modes) stability["negative_modes"] = *last.negative_modes;
    if (last.softness) stability["softness"] = *last.softness;
  }
  json["resolution"] = {{"roughness", nullptr}, {"turn", nullptr}};
  if (summary.resolution) {
    json["resolution"] = {{"roughness", summary.resolution->roughness},
                          {"turn", summary.resolution->turn}};
  }
  json["free_motions"] = summary.free_motions;
  json["decisions"] = summary.decisions;
  json["kept_factors"] = summary.kept_factors;
  if (accuracy != nullptr) json["accuracy"] = ToJson(*accuracy);
  json["time_s"] = {{"setup", summary.setup_s},
                    {"solve", summary.solve_s},
                    {"output", 0.0},
                    {"saved_by_kept_factors", summary.kept_factors_saved_s},
                    {"total", summary.setup_s + summary.solve_s}};
  MarkNotFinite(ReplaceNonFinite(&json), " numbers of summary.json are not finite", &json);
  return json;
}

}  // namespace darboux
