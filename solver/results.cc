#include "solver/results.h"

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>
#include <system_error>
#include <utility>

#include "solver/base64.h"
#include "solver/contact_pressure.h"
#include "solver/field_table.h"
#include "solver/fields.h"
#include "solver/file_set.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

// The shortest text that reads back as the same number.
std::string FormatNumber(double value) {
  char buffer[40];
  const std::to_chars_result end = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, end.ptr);
}

// ---- Files ----------------------------------------------------------------------------------

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

// ---- VTK ------------------------------------------------------------------------------------

bool IsLittleEndian() {
  const std::uint16_t one = 1;
  unsigned char first;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

template <typename T>
void Append(const T& value, std::string* bytes) {
  char buffer[sizeof(T)];
  std::memcpy(buffer, &value, sizeof(T));
  bytes->append(buffer, sizeof(T));
}

// One DataArray element: attributes and the data with its length in front, in base64.
template <typename T>
std::string DataArray(const std::string& type,
                      const std::string& attributes,
                      const std::vector<T>& values) {
  std::string bytes;
  bytes.reserve(8 + values.size() * sizeof(T));
  Append<std::uint64_t>(values.size() * sizeof(T), &bytes);
  for (const T& value : values) Append(value, &bytes);
  return "<DataArray type=\"" + type + "\" " + attributes + " format=\"binary\">" + Base64(bytes) +
         "</DataArray>\n";
}

std::string ToXml(const Field& field) {
  std::string attributes =
      "Name=\"" + field.name + "\" NumberOfComponents=\"" + std::to_string(field.width()) + "\"";
  for (size_t i = 0; i < field.components.size(); ++i) {
    attributes += " ComponentName" + std::to_string(i) + "=\"" + field.components[i] + "\"";
  }
  return DataArray("Float64", attributes, field.values);
}

// Writes states of one problem; what no displacement changes is encoded once.
class StateWriter {
 public:
  explicit StateWriter(const ShellProblem& problem) : table_(problem) {
    std::vector<std::int32_t> connectivity, offsets;
    for (const std::array<int, 3>& triangle : table_.mesh().triangles) {
      connectivity.insert(connectivity.end(), triangle.begin(), triangle.end());
      offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
    }
    constexpr std::uint8_t kVtkTriangle = 5;
    const std::vector<std::uint8_t> types(table_.mesh().triangles.size(), kVtkTriangle);
    geometry_ = "<Points>\n" + ToXml(table_.points()) + "</Points>\n<Cells>\n" +
                DataArray("Int32", "Name=\"connectivity\"", connectivity) +
                DataArray("Int32", "Name=\"offsets\"", offsets) +
                DataArray("UInt8", "Name=\"types\"", types) + "</Cells>\n";
    for (const Field& field : table_.rest_fields()) rest_fields_ += ToXml(field);
  }

  // The contents of a .vtu file. Adds the number of values that are not finite.
  // mode: written as lowest_mode where it is not empty.
  std::string Vtu(const Eigen::Matrix3Xd& displacements,
                  const Eigen::Matrix3Xd& mode,
                  double time,
                  size_t* num_not_finite,
                  const std::vector<ExtraField>& extra = {}) const {
    const size_t n = table_.num_points();
    std::string arrays;
    if (mode.size() > 0) {
      Field lowest_mode("lowest_mode", {"x", "y", "z"}, n);
      for (const FieldSite& site : table_.sites()) {
        const auto& vertices = table_.problem().surface().control_vertices(site.element);
        Eigen::Vector3d moved = Eigen::Vector3d::Zero();
        for (size_t i = 0; i < vertices.size(); ++i) {
          moved += site.point.weights(kRowValue, i) * mode.col(vertices[i]);
        }
        lowest_mode.Add(moved);
      }
      arrays += ToXml(lowest_mode);
    }
    for (const ExtraField& field : extra) {
      Field array(field.name, {}, n);
      for (const double value : field.values) array.Add(value);
      arrays += ToXml(array);
    }
    for (const Field& field : table_.StateFields(displacements)) {
      *num_not_finite += field.num_not_finite;
      arrays += ToXml(field);
    }
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
           "byte_order=\"" +
           std::string(IsLittleEndian() ? "LittleEndian" : "BigEndian") +
           "\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n" +
           DataArray("Float64",
                     "Name=\"TimeValue\" NumberOfTuples=\"1\"",
                     std::vector<double>{std::isfinite(time) ? time : 0.0}) +
           "</FieldData>\n<Piece NumberOfPoints=\"" + std::to_string(n) + "\" NumberOfCells=\"" +
           std::to_string(table_.mesh().triangles.size()) + "\">\n" + geometry_ +
           "<PointData Vectors=\"displacement\" Normals=\"normal\">\n" + arrays + rest_fields_ +
           "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  }

  const OutputMesh& mesh() const { return table_.mesh(); }

  // The contents of deformed.ply.
  std::string Ply(const Eigen::Matrix3Xd& displacements) const {
    std::string text = std::string("ply\nformat ") +
                       (IsLittleEndian() ? "binary_little_endian" : "binary_big_endian") +
                       " 1.0\ncomment deformed middle surface\nelement vertex " +
                       std::to_string(table_.num_points()) + "\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
      text += std::string("property double ") + name + "\n";
    }
    text += "element face " + std::to_string(table_.mesh().triangles.size()) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const FieldSite& site : table_.sites()) {
      const ShellFields fields = EvaluateFields(table_.problem(), displacements, site);
      const Eigen::Vector3d x = fields.position + fields.displacement;
      for (int i = 0; i < 3; ++i) Append(std::isfinite(x[i]) ? x[i] : 0.0, &text);
      for (int i = 0; i < 3; ++i) Append(fields.normal[i], &text);
    }
    for (const std::array<int, 3>& triangle : table_.mesh().triangles) {
      Append<std::uint8_t>(3, &text);
      for (const int vertex : triangle) Append<std::int32_t>(vertex, &text);
    }
    return text;
  }

 private:
  FieldTable table_;
  std::string geometry_, rest_fields_;
};

std::string Pvd(const Scene& scene, const SolverSummary& summary) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"" +
      std::string(IsLittleEndian() ? "LittleEndian" : "BigEndian") + "\">\n<Collection>\n";
  // Time is the load factor, or along a path, where that turns back, the number of the point.
  const bool path = scene.path.control != PathControl::kLoad;
  for (size_t i = 0; i < summary.steps.size(); ++i) {
    const double time = path ? static_cast<double>(i + 1) : summary.steps[i].factor;
    text += "<DataSet timestep=\"" + FormatNumber(time) + "\" group=\"\" part=\"0\" file=\"" +
            StepName(static_cast<int>(i) + 1) + "\"/>\n";
  }
  return text + "</Collection>\n</VTKFile>\n";
}

bool HasStiffness(const LoadStep& step) { return step.grasp && step.grasp->stiffness.size() > 0; }

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
        if (std::isfinite(value)) text += FormatNumber(value);
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

// ---- summary.json ---------------------------------------------------------------------------

Json Components(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

Json Optional(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

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

void MarkNotFinite(size_t count, const std::string& what, Json* json) {
  if (count == 0) return;
  (*json)["converged"] = false;
  std::string message = (*json)["message"].get<std::string>();
  if (!message.empty()) message += "; ";
  (*json)["message"] = message + std::to_string(count) + what;
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

// ---- Expectations ---------------------------------------------------------------------------

std::string Describe(const Json& node) {
  if (node.is_object()) {
    std::string keys;
    for (const auto& item : node.items()) keys += (keys.empty() ? "" : ", ") + item.key();
    return keys.empty() ? "no keys" : "the keys " + keys;
  }
  if (node.is_array()) return "an array of " + std::to_string(node.size());
  if (node.is_null()) return "null (no finite number)";
  if (node.is_string()) return "a text";
  return "a number";
}

// Null and *message where the path leads nowhere.
const Json* Find(const Json& root, const std::string& path, std::string* message) {
  const Json* node = &root;
  std::string at = "summary.json";
  const auto fail = [&](const std::string& wanted) {
    *message = "no '" + wanted + "' in " + at + ", which has " + Describe(*node);
    return nullptr;
  };
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    const size_t bracket = std::min(part.find('['), part.size());
    const std::string name = part.substr(0, bracket);
    if (!node->is_object() || !node->contains(name)) return fail(name);
    node = &node->at(name);
    at = begin == 0 ? name : at + "." + name;
    for (size_t open = bracket; open < part.size();) {
      const size_t close = std::min(part.find(']', open), part.size());
      const std::string digits = part.substr(open + 1, close - std::min(close, open + 1));
      size_t index = 0;
      const std::from_chars_result read =
          std::from_chars(digits.data(), digits.data() + digits.size(), index);
      if (part[open] != '[' || close == part.size() || read.ec != std::errc() ||
          read.ptr != digits.data() + digits.size() || !node->is_array() || index >= node->size()) {
        return fail(part.substr(open));
      }
      node = &node->at(index);
      at += "[" + digits + "]";
      open = close + 1;
    }
    begin = end + 1;
  }
  if (!node->is_number() && !node->is_boolean()) {
    *message = at + " is no number, it has " + Describe(*node);
    return nullptr;
  }
  return node;
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
    if (std::isfinite(value)) text += FormatNumber(value);
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

nlohmann::ordered_json MakeExpectJson(const std::vector<ExpectResult>& results) {
  Json list = Json::array();
  for (const ExpectResult& result : results) {
    Json entry = {{"quantity", result.quantity},
                  {"value", Optional(result.value)},
                  {"expected", result.expected},
                  {"error", Optional(result.error)},
                  {"tolerance", result.tolerance},
                  {"relative", result.relative},
                  {"holds", result.holds}};
    if (!result.message.empty()) entry["message"] = result.message;
    list.push_back(std::move(entry));
  }
  return list;
}

bool EvaluateExpectations(const Scene& scene,
                          const nlohmann::ordered_json& summary,
                          std::vector<ExpectResult>* results) {
  results->clear();
  bool all_hold = true;
  for (const ExpectSpec& expect : scene.expect) {
    ExpectResult result;
    result.quantity = expect.quantity;
    result.expected = expect.value;
    result.relative = !expect.absolute_tolerance.has_value();
    result.tolerance = expect.absolute_tolerance.value_or(expect.relative_tolerance.value_or(0.0));
    const Json* node = Find(summary, expect.quantity, &result.message);
    if (node != nullptr) {
      result.value = node->is_boolean() ? (node->get<bool>() ? 1.0 : 0.0) : node->get<double>();
      const double difference = std::abs(*result.value - expect.value);
      const double scale = result.relative ? std::abs(expect.value) : 1.0;
      result.holds = difference <= result.tolerance * scale;  // False for NaN.
      // Relative to zero only zero has an error that is a number.
      result.error = scale > 0.0 ? difference / scale : difference;
    }
    all_hold = all_hold && result.holds;
    results->push_back(std::move(result));
  }
  return all_hold;
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

std::string MakeVtu(const ShellProblem& problem,
                    const Eigen::Matrix3Xd& displacements,
                    const std::vector<ExtraField>& extra) {
  size_t ignored = 0;
  return StateWriter(problem).Vtu(displacements, Eigen::Matrix3Xd(), 1.0, &ignored, extra);
}

std::string MakeDeformedPly(const ShellProblem& problem, const Eigen::Matrix3Xd& displacements) {
  return StateWriter(problem).Ply(displacements);
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
