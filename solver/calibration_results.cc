#include "solver/calibration_results.h"

#include <cmath>

#include "solver/results.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json Interval(const std::array<double, 2>& interval) {
  return {Number(interval[0]), Number(interval[1])};
}

Json Pose(const RigidPose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {{"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"translation", {t.x(), t.y(), t.z()}}};
}

Json Distances(const DistanceStatistics& d) {
  return {{"count", d.count},
          {"mean", Number(d.mean)},
          {"mean_abs", Number(d.mean_abs)},
          {"rms", Number(d.rms)},
          {"median_abs", Number(d.median_abs)},
          {"max", Number(d.max)},
          {"histogram", {{"bin_width", Number(d.bin_width)}, {"counts", d.histogram}}}};
}

const char* Name(CalibrationSummary::Termination termination) {
  switch (termination) {
    case CalibrationSummary::Termination::kNotRun:
      return "not_run";
    case CalibrationSummary::Termination::kConverged:
      return "converged";
    case CalibrationSummary::Termination::kNotConverged:
      return "not_converged";
    case CalibrationSummary::Termination::kNoMatch:
      return "no_match";
    case CalibrationSummary::Termination::kStopped:
      return "stopped";
    case CalibrationSummary::Termination::kFailed:
      break;
  }
  return "failed";
}

}  // namespace

Json MakeCalibrationJson(const CalibrationSpec& spec, const CalibrationSummary& summary) {
  Json json;
  json["name"] = spec.name;
  json["converged"] = summary.IsConverged();
  json["termination"] = Name(summary.termination);
  json["message"] = summary.message;
  Json parameters = Json::object();
  for (int k = 0; k < 4; ++k) {
    if (!spec.parameters[k].asked) continue;
    const StateParameter which = static_cast<StateParameter>(k);
    Json& entry = parameters[ToString(which)];
    const CalibrationSummary::Estimate* const estimate = summary.Find(which);
    if (estimate == nullptr) {
      entry = {{"value", nullptr}, {"identifiable", false}, {"verdict", summary.message}};
      continue;
    }
    entry["value"] = Number(estimate->value);
    entry["identifiable"] = estimate->identifiable;
    entry["verdict"] = estimate->verdict;
    entry[k < 2 ? "deviation_of_logarithm" : "deviation"] = Number(estimate->deviation);
    entry["interval_95"] = Interval(estimate->interval);
    entry["bootstrap_95"] = estimate->bootstrap ? Interval(*estimate->bootstrap) : Json(nullptr);
  }
  json["parameters"] = parameters;
  Json names = Json::array(), rows = Json::array();
  for (Eigen::Index i = 0; i < summary.correlation.rows(); ++i) {
    names.push_back(ToString(summary.estimates[i].parameter));
    Json row = Json::array();
    for (Eigen::Index j = 0; j < summary.correlation.cols(); ++j) {
      row.push_back(Number(summary.correlation(i, j)));
    }
    rows.push_back(row);
  }
  json["correlation"] = {{"of", names}, {"matrix", rows}};
  Json sensitivities = Json::object();
  for (const CalibrationSummary::Sensitivity& s : summary.sensitivities) {
    // Of Poisson's ratio: its change per relative change.
    sensitivities[s.of][(s.relative ? "relative_to_" : "by_relative_") + s.to] = Number(s.value);
  }
  json["sensitivities"] = sensitivities;
  json["linear_theory"] = {
      {"young_modulus",
       summary.linear_young_modulus ? Number(*summary.linear_young_modulus) : Json(nullptr)}};
  json["errors"] = {{"model", spec.model_error},
                    {"shape", spec.shape_error},
                    {"force_drift", spec.force_drift},
                    {"model_bias", Number(summary.model_bias)},
                    {"drift", Number(summary.drift)},
                    {"rest_offset", Number(summary.rest_offset)}};
  Json grasps = Json::array();
  for (const CalibrationSummary::Grasp& grasp : summary.grasps) {
    Json forces = Json::array(), scans = Json::array(), fields = Json::array();
    for (const CalibrationSummary::Force& force : grasp.forces) {
      forces.push_back({{"finger", force.finger},
                        {"reading", Number(force.reading)},
                        {"computed", Number(force.model)},
                        {"error", Number(force.error)}});
    }
    for (const CalibrationSummary::Scan& scan : grasp.scans) {
      scans.push_back({{"file", scan.file},
                       {"points", scan.points},
                       {"inliers", Number(scan.inliers)},
                       {"deviation", Number(scan.deviation)},
                       {"distances", Distances(scan.distances)},
                       {"pose", Pose(scan.pose)}});
    }
    for (const CalibrationSummary::Field& field : grasp.fields) {
      fields.push_back({{"file", field.file},
                        {"points", field.points},
                        {"beside", field.beside},
                        {"rms", Number(field.rms)},
                        {"inliers", Number(field.inliers)},
                        {"deviation", Number(field.deviation)},
                        {"independent_points", Number(field.independent)},
                        {"deformation", Number(field.deformation)},
                        {"rotation", Number(field.rotation)}});
    }
    grasps.push_back({{"scene", grasp.scene},
                      {"theory", ToString(grasp.theory)},
                      {"max_displacement", Number(grasp.max_displacement)},
                      {"travel_change", Number(grasp.travel_change)},
                      {"travel_deviation", Number(grasp.travel_deviation)},
                      {"forces", forces},
                      {"scans", scans},
                      {"fields", fields}});
  }
  json["grasps"] = grasps;
  json["notes"] = summary.notes;
  json["iterations"] = summary.iterations;
  json["solutions"] = summary.work.solutions;
  json["time_s"] = {{"solutions", Number(summary.work.solve_s)},
                    {"derivatives", Number(summary.work.derivative_s)},
                    {"total", Number(summary.seconds)}};
  return json;
}

bool WriteCalibration(const std::string& folder,
                      const CalibrationSpec& spec,
                      const CalibrationSummary& summary,
                      const std::vector<std::unique_ptr<StateModel>>& models,
                      const ExportOptions& exports,
                      std::string* error,
                      const MoreFiles& more) {
  if (!MakeFolder(folder, error)) return false;
  for (size_t g = 0; g < models.size(); ++g) {
    const std::string part = folder + "/grasp_" + std::to_string(g + 1);
    Results results;
    std::vector<NamedFile> exported;
    const auto add_exported = [&exported](const Json&) { return exported; };
    if (!MakeFieldExports(models[g]->problem(),
                          exports,
                          ExportStatesOf(models[g]->summary()),
                          {},
                          &exported,
                          error) ||
        !WriteResults(part,
                      models[g]->problem(),
                      models[g]->summary(),
                      nullptr,
                      &results,
                      error,
                      add_exported)) {
      return false;
    }
    if (g >= summary.grasps.size()) continue;
    for (size_t s = 0; s < summary.grasps[g].scans.size(); ++s) {
      PointCloud cloud;
      for (const Eigen::Vector3d& x : spec.grasps[g].scans[s].cloud.points) {
        cloud.points.push_back(summary.grasps[g].scans[s].pose * x);
      }
      const std::string name = part + "/scan_" + std::to_string(s + 1) + ".ply";
      if (!WritePointCloud(name, cloud, {"registered by darboux_calibrate"}, error)) return false;
    }
  }
  const Json json = MakeCalibrationJson(spec, summary);
  std::vector<NamedFile> files;
  if (more) files = more(json);
  files.push_back({"calibration.json", json.dump(2) + "\n"});
  return WriteFiles(folder, files, error);
}

}  // namespace darboux
