#include "solver/results.h"

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <system_error>
#include <utility>

#include "geometry/text_file.h"
#include "solver/contact_pressure.h"
#include "solver/file_set.h"
#include "solver/state_writer.h"
#include "solver/summary_json.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

std::string StepName(int step) {
  std::string number = std::to_string(step);
  if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
  return "shell_" + number + ".vtu";
}

// "shell_0012.vtu" for the parts "shell_" and ".vtu".
bool IsNumbered(const std::string& name, const std::string& begin, const std::string& end) {
  if (name.size() < begin.size() + 4 + end.size() || name.compare(0, begin.size(), begin) != 0 ||
      name.compare(name.size() - end.size(), end.size(), end) != 0) {
    return false;
  }
  const std::string number = name.substr(begin.size(), name.size() - begin.size() - end.size());
  return number.find_first_not_of("0123456789") == std::string::npos;
}

// Removes files of steps and exports of an earlier run that are not among `names`.
void RemoveOtherSteps(const fs::path& folder, const std::vector<std::string>& names) {
  const std::set<std::string> keep(names.begin(), names.end());
  const std::set<std::string> known = {"contact.csv", "fields.csv", "fields.npz", "shell.inp"};
  std::vector<fs::path> others;
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().filename().string();
    const bool ours = known.count(name) > 0 || IsNumbered(name, "shell_", ".vtu") ||
                      IsNumbered(name, "fields_", ".csv");
    if (ours && keep.count(name) == 0) others.push_back(it->path());
  }
  for (const fs::path& path : others) fs::remove(path, code);
}

std::string Pvd(const Scene& scene, const SolverSummary& summary) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"" +
      std::string(IsLittleEndian() ? "LittleEndian" : "BigEndian") + "\">\n<Collection>\n";
  // Time is the load factor, or along a path, where that turns back, the number of the point.
  const bool path = scene.path.control != PathControl::kLoad;
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const double time = path ? static_cast<double>(i + 1) : summary.steps[i].factor;
    std::string number;
    AppendNumber(time, &number);
    text += "<DataSet timestep=\"" + number + "\" group=\"\" part=\"0\" file=\"" +
            StepName(static_cast<int>(i) + 1) + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

// The distribution of the fingers' pressure: a row per point in contact of every step.
std::string Contact(const Scene& scene, const SolverSummary& summary) {
  std::string text =
      "step,finger,element,x,y,z,normal.x,normal.y,normal.z,gap,pressure,area,friction.x,friction."
      "y,"
      "friction.z,sticks\n";
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    for (const ContactPointReport& point : summary.steps[i].contact_points) {
      text += std::to_string(i + 1) + "," + scene.fingers[point.finger].name + "," +
              std::to_string(point.element);
      const auto add = [&](double value) {
        text += ",";
        if (std::isfinite(value)) AppendNumber(value, &text);
      };
      for (int k = 0; k < 3; ++k) add(point.position[k]);
      for (int k = 0; k < 3; ++k) add(point.normal[k]);
      add(point.gap);
      add(point.pressure);
      add(point.area);
      for (int k = 0; k < 3; ++k) add(point.friction[k]);
      const bool has_friction = scene.fingers[point.finger].friction > 0.0;
      text += has_friction && point.sticks ? ",1\n" : ",0\n";
    }
  }
  return text;
}

}  // namespace

std::string MakeHistoryCsv(const Scene& scene, const SolverSummary& summary) {
  std::string text = "step,factor,iterations,converged,energy,relative_gradient,max_displacement";
  for (const ProbeSpec& probe : scene.probes) {
    for (const char* axis : {"x", "y", "z"}) {
      text += ",probes." + probe.name + ".displacement." + axis;
    }
  }
  for (const FingerSpec& finger : scene.fingers) {
    for (const char* what :
         {"travel", "normal_force", "stiffness", "contact_area", "penetration"}) {
      text += ",fingers." + finger.name + "." + what;
    }
  }
  if (!scene.fingers.empty()) text += ",grasp.squeeze_work,grasp.force_closure_after.margin";
  const bool has_gas = !summary.steps.empty() && summary.steps.front().gas.has_value();
  if (has_gas) text += ",gas.gauge_pressure,gas.volume_ratio";
  text +=
      ",supports.reaction.x,supports.reaction.y,supports.reaction.z,negative_modes,limit_point\n";
  const auto add = [&](double value) {
    text += ",";
    if (std::isfinite(value)) AppendNumber(value, &text);
  };
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const LoadStep& step = summary.steps[i];
    text += std::to_string(i + 1);
    add(step.factor);
    text += "," + std::to_string(step.iterations) + "," + (step.converged ? "1" : "0");
    add(step.energy);
    add(step.relative_gradient);
    add(step.max_displacement);
    for (const Eigen::Vector3d& displacement : step.probe_displacements) {
      for (int k = 0; k < 3; ++k) add(displacement[k]);
    }
    const double none = std::numeric_limits<double>::quiet_NaN();
    for (size_t f = 0; f < step.fingers.size(); ++f) {
      const FingerReport& finger = step.fingers[f];
      add(finger.travel);
      add(finger.normal_force);
      add(HasStiffness(step) ? step.grasp->stiffness(f, f) : none);
      add(finger.contact_area);
      add(finger.penetration);
    }
    if (!scene.fingers.empty()) {
      add(step.grasp ? step.grasp->squeeze_work : none);
      add(step.grasp ? step.grasp->closure_after.margin : none);
    }
    if (has_gas) {
      add(step.gas->gauge_pressure);
      add(step.gas->volume_ratio);
    }
    for (int k = 0; k < 3; ++k) add(step.reaction[k]);
    text += ",";
    if (step.negative_modes) text += std::to_string(*step.negative_modes);
    text += step.limit_point ? ",1\n" : ",0\n";
  }
  return text;
}

bool WriteFiles(const std::string& folder,
                const std::vector<NamedFile>& files,
                std::string* error) {
  if (!MakeFolder(folder, error)) return false;
  FileSet set(folder);
  set.Outdate("report.html");  // of an earlier run
  for (const NamedFile& file : files) {
    if (!set.Add(file.name, file.content, error)) return false;
  }
  return set.Commit(error);
}

bool WriteResults(const std::string& folder,
                  const ShellProblem& problem,
                  const SolverSummary& summary,
                  const AccuracyReport* accuracy,
                  Results* results,
                  std::string* error,
                  const MoreFiles& more) {
  const Clock::time_point start = Clock::now();
  *results = Results();
  if (!MakeFolder(folder, error)) return false;

  const Scene& scene = problem.scene();
  FileSet files(folder);
  const StateWriter writer(problem);
  size_t num_not_finite = 0;
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, problem.displacements().cols());
  const Eigen::Matrix3Xd* final_state = &rest;
  std::string final_vtu;
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const LoadStep& step = summary.steps[i];
    std::vector<ExtraField> extra;
    if (!scene.fingers.empty()) {
      extra.push_back({"contact_pressure",
                       MakeContactPressure(problem.surface(), writer.mesh(), step.contact_points)});
    }
    std::string vtu =
        writer.Vtu(step.displacements, step.mode, step.factor, &num_not_finite, extra);
    if (!files.Add(StepName(static_cast<int>(i) + 1), vtu, error)) return false;
    if (step.displacements.allFinite()) {
      final_state = &step.displacements;
      final_vtu = std::move(vtu);
    }
  }
  if (final_state == &rest) final_vtu = writer.Vtu(rest, Eigen::Matrix3Xd(), 0.0, &num_not_finite);
  if (!files.Add("shell.vtu", final_vtu, error) ||
      !files.Add("shell.pvd", Pvd(scene, summary), error) ||
      !files.Add("deformed.ply", writer.Ply(*final_state), error) ||
      !files.Add("history.csv", MakeHistoryCsv(scene, summary), error) ||
      (!scene.fingers.empty() && !files.Add("contact.csv", Contact(scene, summary), error))) {
    return false;
  }

  Json& json = results->summary;
  json = MakeSummaryJson(scene, summary, accuracy);
  MarkNotFinite(num_not_finite, " field values are not finite and written as 0", &json);
  const double output_s = std::chrono::duration<double>(Clock::now() - start).count();
  json["time_s"]["output"] = output_s;
  json["time_s"]["total"] = summary.setup_s + summary.solve_s + output_s;
  results->expectations_hold = EvaluateExpectations(scene, json, &results->expectations);
  results->converged = json["converged"].get<bool>();
  json["expect"] = MakeExpectJson(results->expectations);
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  files.Outdate("report.html");  // of an earlier run
  if (more) {
    for (const NamedFile& file : more(json)) {
      if (!files.Add(file.name, file.content, error)) return false;
    }
  }
  // Last, so that whoever waits for it finds the others complete.
  if (!files.Add("summary.json", text, error) || !files.Commit(error)) return false;
  RemoveOtherSteps(folder, files.names());
  results->files = files.names();
  return true;
}

}  // namespace darboux
