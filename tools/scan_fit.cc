#include "tools/scan_fit.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "solver/scan_results.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

bool OneOf(const char* name,
           const std::string& value,
           const std::vector<std::string>& allowed,
           std::string* error) {
  std::string list;
  for (const std::string& word : allowed) {
    if (word == value) return true;
    list += (list.empty() ? "" : " | ") + word;
  }
  *error = std::string(name) + ": found '" + value + "'; allowed " + list;
  return false;
}

bool IsNotNegative(const char* name, double value, std::string* error) {
  if (std::isfinite(value) && value >= 0.0) return true;
  *error = std::string(name) + ": found " + std::to_string(value) + "; allowed >= 0";
  return false;
}

void RecordFit(const ShapeFitSummary& summary, ScanFit* fit) {
  fit->converged = summary.converged;
  fit->verdict = summary.verdict;
  fit->report = summary.FullReport();
  Json& json = fit->json;
  json["registration"] = ToJson(summary.registration);
  if (!summary.registration.matched) return;
  fit->displacements = summary.displacements;
  fit->pose = summary.pose;
  fit->feet = summary.feet;
  fit->distances = summary.distances;
  fit->counts = summary.counts;
  const double largest = summary.max_displacement;
  json["pose"] = ToJson(fit->pose);
  json["noise"] = summary.noise;
  json["weight"] = summary.weight;
  json["misfit"] = summary.misfit;
  json["energy"] = summary.energy;
  json["iterations"] = summary.iterations;
  Json trials = Json::array();
  for (const ShapeFitSummary::Trial& trial : summary.trials) {
    trials.push_back(
        {{"weight", trial.weight}, {"misfit", trial.misfit}, {"iterations", trial.iterations}});
  }
  json["weights"] = trials;
  json["max_displacement"] = largest;
  json["outliers"] = summary.num_outliers;
  json["beyond_boundary"] = summary.num_beyond_boundary;
  json["inliers"] = ToJson(summary.inliers, largest);
  json["all"] = ToJson(summary.all, largest);
}

void RecordRegistration(const RegistrationSummary& summary,
                        double max_relative_sigma,
                        ScanFit* fit) {
  fit->converged = summary.matched;
  fit->verdict = summary.verdict;
  fit->report = summary.FullReport();
  Json& json = fit->json;
  json["registration"] = ToJson(summary);
  fit->pose = summary.pose;
  fit->feet = summary.feet;
  fit->distances = summary.distances;
  if (fit->distances.empty()) return;
  const ShellSurface& surface = fit->shell->surface();
  const double largest = Deformation(surface, fit->displacements).largest();
  json["pose"] = ToJson(fit->pose);
  json["max_displacement"] = largest;
  json["outliers"] = summary.outliers.size();
  json["inliers"] = ToJson(summary.inliers, largest);
  json["all"] = ToJson(summary.all, largest);
  // The error of a computed shape is no outlier: the map shows all but what is far away.
  const double far = 3.0 * max_relative_sigma * surface.size();
  for (const double distance : fit->distances) fit->counts.push_back(std::abs(distance) <= far);
}

}  // namespace

bool ScanFitOptions::IsValid(std::string* error) const {
  if (!IsNotNegative("noise", noise, error) || !IsNotNegative("weight", weight, error)) {
    return false;
  }
  if (!(undeformed_part > 0.0 && undeformed_part <= 1.0)) {
    *error =
        "undeformed_part: found " + std::to_string(undeformed_part) + "; allowed 0 < part <= 1";
    return false;
  }
  return OneOf("mode", mode, {"fit", "register"}, error) &&
         (fingers.empty() || OneOf("fingers", fingers, {"scene", "none"}, error)) &&
         OneOf("against", against, {"deformed", "rest"}, error) &&
         OneOf("method", method, {"robust", "undeformed_first"}, error) &&
         OneOf("face", face, {"outer", "inner", "middle"}, error) && solver.IsValid(error);
}

bool FitScan(const Scene& scene,
             const std::vector<Eigen::Vector3d>& scan,
             const std::string& scan_name,
             const ScanFitOptions& options,
             ScanFit* fit,
             std::string* error) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  *fit = ScanFit();
  fit->scene = scene;

  // The shape that the scan is held against.
  const bool fits = fit->is_fitted = options.mode == "fit";
  const bool has_causes = !scene.fingers.empty() || !scene.loads.empty();
  const bool solves = fits ? options.fingers == "scene" || (options.fingers.empty() && has_causes)
                           : options.against == "deformed";
  std::unique_ptr<ShellProblem> solved;
  if (solves && !Solve(scene, options.solver, &solved, &fit->equilibrium.emplace(), error)) {
    return false;
  }
  ShellProblem::Options shell_options;
  shell_options.nonlinear = true;
  shell_options.num_threads = options.solver.num_threads;
  fit->shell = ShellProblem::Create(WithoutLoads(scene), shell_options, error);
  if (fit->shell == nullptr) return false;
  const double half = 0.5 * fit->shell->material().thickness;
  fit->face_offset = options.face == "outer" ? half : options.face == "inner" ? -half : 0.0;

  ShapeFitOptions fit_options;
  fit_options.noise = options.noise;
  fit_options.weight = options.weight;
  fit_options.num_threads = options.solver.num_threads;
  fit_options.backend = options.solver.backend;
  fit_options.stop = options.solver.stop;
  fit_options.on_iteration = options.on_iteration;
  RegistrationOptions& registration_options = fit_options.registration;
  registration_options.seed = options.seed;
  registration_options.num_threads = options.solver.num_threads;
  // A shape that is not fitted yet, or one that was computed and not measured, is off by more than
  // the noise.
  constexpr double kUnfitted = 0.03;
  registration_options.max_relative_sigma = kUnfitted;

  fit->json = {{"tool", "darboux_fit"},
               {"scene", scene.name},
               {"scan", scan_name},
               {"points", scan.size()},
               {"mode", options.mode},
               {"converged", false},
               {"verdict", ""}};
  fit->displacements = Eigen::Matrix3Xd::Zero(3, fit->shell->surface().mesh().num_vertices);
  if (solves) fit->displacements = solved->displacements();
  if (fits) {
    ShapeFitSummary summary;
    if (!FitShape(fit->shell.get(),
                  solves ? fit->displacements : Eigen::Matrix3Xd(),
                  fit->face_offset,
                  scan,
                  fit_options,
                  &summary,
                  error)) {
      *error = scan_name + ":0: " + *error;
      return false;
    }
    fit->json["fingers"] = solves ? "scene" : "none";
    RecordFit(summary, fit);
  } else {
    ShellFace face(fit->shell->surface(), fit->face_offset);
    face.SetDisplacements(fit->displacements);
    registration_options.undeformed_part = options.undeformed_part;
    if (options.method == "undeformed_first") {
      registration_options.method = RegistrationOptions::Method::kUndeformedFirst;
    }
    RegistrationSummary summary;
    if (!Register(face, scan, registration_options, &summary, error)) {
      *error = scan_name + ":0: " + *error;
      return false;
    }
    fit->json["against"] = options.against;
    fit->json["method"] = options.method;
    RecordRegistration(summary, registration_options.max_relative_sigma, fit);
  }
  if (solves && !fit->equilibrium->IsConverged()) {
    fit->converged = false;
    fit->verdict += "; the scene's own equilibrium is not converged: " + fit->equilibrium->message;
  }
  fit->json["converged"] = fit->converged;
  fit->json["verdict"] = fit->verdict;
  fit->json["time_s"] = std::chrono::duration<double>(Clock::now() - start).count();
  return true;
}

std::vector<NamedFile> ScanFitFiles(const ScanFit& fit, const std::vector<Eigen::Vector3d>& scan) {
  std::vector<NamedFile> files;
  if (!fit.distances.empty()) {
    ShellFace face(fit.shell->surface(), fit.face_offset);
    face.SetDisplacements(fit.displacements);
    files.push_back({"shell.vtu",
                     MakeVtu(*fit.shell,
                             fit.displacements,
                             MakeScanFields(face, fit.feet, fit.distances, fit.counts))});
    files.push_back({"deformed.ply", MakeDeformedPly(*fit.shell, fit.displacements)});
    files.push_back(
        {"scan_registered.ply", MakeRegisteredPly(scan, fit.pose, fit.distances, fit.counts)});
  }
  files.push_back(
      {"fit.json", fit.json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"});
  return files;
}

Report MakeFitReport(const ScanFit& fit, const std::vector<Eigen::Vector3d>& scan) {
  Report page = MakeReport("darboux_fit", fit.scene.name);
  ReportShape shape;
  shape.title = fit.scene.name;
  shape.problem = fit.shell.get();
  shape.scene = &fit.scene;
  if (fit.equilibrium) shape.states = StatesOf(*fit.equilibrium);
  for (ReportState& state : shape.states) state.label = "computed, " + state.label;
  if (!fit.distances.empty()) {
    // What is held against the scan; a shape that is not fitted is the last one there, or the shell
    // at rest.
    if (fit.is_fitted || shape.states.empty()) {
      ReportState state;
      state.label = fit.is_fitted ? "fitted to the scan" : "held against the scan";
      state.displacements = &fit.displacements;
      shape.states.push_back(state);
    }
    ShellFace face(fit.shell->surface(), fit.face_offset);
    face.SetDisplacements(fit.displacements);
    shape.distances = {CoveredDistance(MakeScanFields(face, fit.feet, fit.distances, fit.counts))};
    std::vector<Eigen::Vector3d> points;
    for (const Eigen::Vector3d& x : scan) points.push_back(fit.pose * x);
    shape.clouds = {MakeCloud("scan, registered", "distance from the face", points, fit.distances)};
  }
  AddShellView(shape, &page);
  if (fit.equilibrium) {
    AddHistory(fit.scene, *fit.equilibrium, &page);
    page.header["documents"]["summary"] = MakeSummaryJson(fit.scene, *fit.equilibrium, nullptr);
  }
  page.header["documents"]["fit"] = fit.json;
  return page;
}

}  // namespace darboux
