#include "solver/calibration_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "geometry/text_file.h"
#include "solver/scene_reader.h"
#include "solver/yaml_reader.h"

namespace darboux {
namespace {

constexpr NumberRule kPart{"a number in [0, 1)", [](double x) { return x >= 0.0 && x < 1.0; }};
constexpr NumberRule kPoissonNumber{"a number in (-1, 0.5]",
                                    [](double x) { return x > -1.0 && x <= 0.5; }};

class CalibrationParser : public YamlReader {
 public:
  CalibrationParser(const std::string& file, const std::string& folder, const NamedData* data)
      : YamlReader(file), folder_(folder), data_(data) {}

  bool Parse(const std::string& text, CalibrationSpec* spec) {
    return ReadDocument(text, "what to calibrate, in YAML", [&](const YamlField& root) {
      return ReadRoot(root, spec);
    });
  }

 private:
  std::string PathOf(const std::string& file) const {
    return (std::filesystem::path(folder_) / file).string();
  }

  bool ReadRoot(const YamlField& root, CalibrationSpec* spec) {
    YamlMap map;
    if (!OpenMap(root, "a map", &map)) return false;
    if (!CheckKeys(map,
                   {"name",
                    "parameters",
                    "theory",
                    "noise",
                    "model_error",
                    "shape_error",
                    "rest_error",
                    "force_drift",
                    "max_points",
                    "bootstrap",
                    "seed",
                    "compare_linear",
                    "grasps"})) {
      return false;
    }
    YamlField field;
    if (!Require(map, "name", "text of one line", &field) ||
        !ReadText(field, "text of one line", &spec->name)) {
      return false;
    }
    if (!Require(map, "parameters", "a map of what is asked for", &field) ||
        !ReadParameters(field, spec)) {
      return false;
    }
    if (const YamlField* theory = map.Find("theory")) {
      std::string name;
      if (!ReadChoice(*theory, {"auto", "linear", "nonlinear"}, {}, &name)) return false;
      spec->theory = name == "linear"      ? Theory::kLinear
                     : name == "nonlinear" ? Theory::kNonlinear
                                           : Theory::kAuto;
    }
    if (!Optional(map, "noise", kPositiveNumber, &spec->noise) ||
        !Optional(map, "model_error", kPart, &spec->model_error) ||
        !Optional(map, "shape_error", kPart, &spec->shape_error) ||
        !Optional(map, "rest_error", kNotNegativeNumber, &spec->rest_error) ||
        !Optional(map, "force_drift", kNotNegativeNumber, &spec->force_drift)) {
      return false;
    }
    int seed = static_cast<int>(spec->seed);
    if (!ReadMaxPoints(map, &spec->max_points) ||
        !OptionalInteger(map, "bootstrap", 0, &spec->bootstrap) ||
        !OptionalInteger(map, "seed", 0, &seed)) {
      return false;
    }
    spec->seed = static_cast<unsigned>(seed);
    if (const YamlField* compare = map.Find("compare_linear")) {
      if (!ReadBool(*compare, &spec->compare_linear)) return false;
    }
    if (!Require(map, "grasps", "a list of measured scenes", &field)) return false;
    std::vector<YamlField> items;
    if (!OpenList(field, -1, "a list of measured scenes", &items)) return false;
    if (items.empty()) return Fail(field, "an empty list", "at least one grasp");
    for (const YamlField& item : items) {
      CalibrationSpec::Grasp grasp;
      if (!ReadGrasp(item, &grasp)) return false;
      spec->grasps.push_back(std::move(grasp));
    }
    return CheckGas(map, *spec);
  }

  bool Optional(const YamlMap& map, const std::string& key, const NumberRule& rule, double* value) {
    const YamlField* const field = map.Find(key);
    return field == nullptr || ReadNumber(*field, rule, value);
  }

  bool OptionalInteger(const YamlMap& map, const std::string& key, int least, int* value) {
    const YamlField* const field = map.Find(key);
    if (field == nullptr) return true;
    const std::string allowed = "an integer >= " + std::to_string(least);
    int read = 0;
    if (!ReadInteger(*field, allowed, &read)) return false;
    if (read < least) return Fail(*field, std::to_string(read), allowed);
    *value = read;
    return true;
  }

  bool ReadMaxPoints(const YamlMap& map, int* value) {
    if (!OptionalInteger(map, "max_points", 0, value)) return false;
    if (*value == 0 || *value >= 10) return true;
    return Fail(*map.Find("max_points"), std::to_string(*value), "0 for all, or at least 10");
  }

  bool ReadParameters(const YamlField& field, CalibrationSpec* spec) {
    YamlMap map;
    if (!OpenMap(field, "a map of what is asked for", &map)) return false;
    Names names;
    for (int k = 0; k < 4; ++k) names.push_back(ToString(static_cast<StateParameter>(k)));
    if (!CheckKeys(map, names)) return false;
    if (map.entries.empty()) return Fail(field, "an empty map", Join(names));
    for (int k = 0; k < 4; ++k) {
      const YamlField* const entry = map.Find(names[k]);
      if (entry == nullptr) continue;
      CalibrationSpec::Parameter& parameter = spec->parameters[k];
      parameter.asked = true;
      parameter.location = Location(*entry);
      const NumberRule& rule = k == 2 ? kPoissonNumber : k == 3 ? kAnyNumber : kPositiveNumber;
      YamlMap settings;
      if (!OpenMap(*entry, "a map of start and prior, {} for none", &settings) ||
          !CheckKeys(settings, {"start", "prior"})) {
        return false;
      }
      double value = 0.0;
      if (const YamlField* start = settings.Find("start")) {
        if (!ReadNumber(*start, rule, &value)) return false;
        parameter.start = value;
      }
      if (const YamlField* prior = settings.Find("prior")) {
        YamlMap parts;
        const std::string allowed = "a map of value and error, its standard deviation";
        if (!OpenMap(*prior, allowed, &parts) || !CheckKeys(parts, {"value", "error"})) {
          return false;
        }
        double error = 0.0;
        if (!RequireNumber(parts, "value", rule, &value) ||
            !RequireNumber(parts, "error", kPositiveNumber, &error)) {
          return false;
        }
        parameter.prior = value;
        parameter.prior_error = error;
      }
    }
    return true;
  }

  bool ReadFileName(const YamlField& field, const std::string& what, std::string* name) {
    if (!ReadText(field, what, name)) return false;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(PathOf(*name), ignored)) {
      return Fail(field, Quote(*name) + ", which is no file", what + " in the folder of this file");
    }
    return true;
  }

  bool ReadCloud(const YamlField& field,
                 const std::string& what,
                 std::string* name,
                 PointCloud* cloud) {
    std::string error;
    if (!ReadText(field, what, name)) return false;
    if (const PointCloud* const found = FindNamed(data_, &NamedData::clouds, *name)) {
      *cloud = *found;
      return true;
    }
    if (!ReadFileName(field, what, name)) return false;
    if (!ReadPointCloud(PathOf(*name), cloud, &error)) return FailWith(field, error);
    return true;
  }

  bool ReadGrasp(const YamlField& item, CalibrationSpec::Grasp* grasp) {
    YamlMap map;
    if (!OpenMap(item, "a map: a measured scene", &map)) return false;
    if (!CheckKeys(map, {"scene", "scans", "fields", "forces", "travel", "travel_error", "time"})) {
      return false;
    }
    grasp->location = Location(item);
    YamlField field;
    if (!Require(map, "scene", "a scene file", &field) ||
        !ReadText(field, "a scene file", &grasp->scene_file)) {
      return false;
    }
    std::string error;
    if (const Scene* const found = FindNamed(data_, &NamedData::scenes, grasp->scene_file)) {
      grasp->scene = *found;
    } else if (!ReadFileName(field, "a scene file", &grasp->scene_file)) {
      return false;
    } else if (!ReadScene(PathOf(grasp->scene_file), &grasp->scene, &error)) {
      return FailWith(field, error);
    }
    if (grasp->scene.path.control != PathControl::kLoad) {
      return Fail(field, "a scene with a path", "scenes whose final state is at full load");
    }
    if (const YamlField* travel = map.Find("travel")) {
      double value = 0.0;
      if (!ReadNumber(*travel, kNotNegativeNumber, &value)) return false;
      if (grasp->scene.fingers.empty()) {
        return Fail(*travel, "a travel", "one only where the scene has fingers");
      }
      for (FingerSpec& finger : grasp->scene.fingers) {
        finger.travel = value;
        finger.force.reset();
      }
    }
    bool by_force = false;
    for (const FingerSpec& finger : grasp->scene.fingers) by_force = by_force || finger.force;
    if (by_force) grasp->travel_error = std::numeric_limits<double>::infinity();
    if (const YamlField* travel_error = map.Find("travel_error")) {
      std::string text;
      if (ReadScalar(*travel_error, "a number >= 0 or unknown", &text) && text == "unknown") {
        grasp->travel_error = std::numeric_limits<double>::infinity();
      } else if (by_force) {
        return Fail(
            *travel_error, text, "unknown, or none, where the scene drives its fingers by forces");
      } else if (!ReadNumber(*travel_error,
                             {"a number >= 0 or unknown", [](double x) { return x >= 0.0; }},
                             &grasp->travel_error)) {
        return false;
      }
    }
    if (!Optional(map, "time", kAnyNumber, &grasp->time)) return false;
    return ReadScans(map, grasp) && ReadFields(map, grasp) && ReadForces(map, grasp) &&
           CheckData(item, *grasp);
  }

  bool ReadScans(const YamlMap& map, CalibrationSpec::Grasp* grasp) {
    const YamlField* const list = map.Find("scans");
    if (list == nullptr) return true;
    std::vector<YamlField> items;
    if (!OpenList(*list, -1, "a list of scans", &items)) return false;
    for (const YamlField& item : items) {
      CalibrationSpec::Scan scan;
      scan.location = Location(item);
      YamlField file = item;
      if (item.node.IsMap()) {
        YamlMap parts;
        if (!OpenMap(item, "a file, or a map", &parts) ||
            !CheckKeys(parts, {"file", "registered"}) ||
            !Require(parts, "file", "a file of points", &file)) {
          return false;
        }
        if (const YamlField* registered = parts.Find("registered")) {
          bool known = false;
          if (!ReadBool(*registered, &known)) return false;
          if (known) scan.pose = RigidPose();
        }
      }
      if (!ReadCloud(file, "a file of points", &scan.file, &scan.cloud)) return false;
      grasp->scans.push_back(std::move(scan));
    }
    return true;
  }

  bool ReadFields(const YamlMap& map, CalibrationSpec::Grasp* grasp) {
    const YamlField* const list = map.Find("fields");
    if (list == nullptr) return true;
    std::vector<YamlField> items;
    if (!OpenList(*list, -1, "a list of measured fields", &items)) return false;
    for (const YamlField& item : items) {
      CalibrationSpec::Field field;
      field.location = Location(item);
      YamlMap parts;
      YamlField file;
      if (!OpenMap(
              item, "a map of file, components, noise, shape_error and rigid_motion", &parts) ||
          !CheckKeys(parts, {"file", "components", "noise", "shape_error", "rigid_motion"}) ||
          !Require(parts, "file", "a file of points with displacements", &file) ||
          !ReadCloud(file, "a file of points with displacements", &field.file, &field.cloud)) {
        return false;
      }
      if (field.cloud.displacements.empty()) {
        return Fail(file, "points without displacements", "columns ux, uy (and uz) beside x, y, z");
      }
      field.components[2] = field.cloud.has_uz;
      if (const YamlField* components = parts.Find("components")) {
        std::vector<YamlField> names;
        if (!OpenList(*components, -1, "a list of x, y, z", &names)) return false;
        field.components = {false, false, false};
        for (const YamlField& name : names) {
          std::string text;
          if (!ReadChoice(name, {"x", "y", "z"}, {}, &text)) return false;
          if (text == "z" && !field.cloud.has_uz) {
            return Fail(name, "z, of which the file says nothing", "x, y, or a column uz");
          }
          field.components[text[0] - 'x'] = true;
        }
        if (names.empty()) return Fail(*components, "an empty list", "some of x, y, z");
      }
      if (!Optional(parts, "noise", kPositiveNumber, &field.noise) ||
          !Optional(parts, "shape_error", kPart, &field.shape_error)) {
        return false;
      }
      if (const YamlField* motion = parts.Find("rigid_motion")) {
        std::string text;
        if (!ReadChoice(*motion, {"free", "none"}, {}, &text)) return false;
        field.free_motion = text == "free";
      }
      grasp->fields.push_back(std::move(field));
    }
    return true;
  }

  bool ReadForces(const YamlMap& map, CalibrationSpec::Grasp* grasp) {
    const YamlField* const list = map.Find("forces");
    if (list == nullptr) return true;
    std::vector<YamlField> items;
    if (!OpenList(*list, -1, "a list of force readings", &items)) return false;
    Names fingers;
    for (const FingerSpec& finger : grasp->scene.fingers) fingers.push_back(finger.name);
    for (const YamlField& item : items) {
      CalibrationSpec::ForceReading reading;
      reading.location = Location(item);
      YamlMap parts;
      YamlField finger;
      if (!OpenMap(item, "a map of finger, value and error", &parts) ||
          !CheckKeys(parts, {"finger", "value", "error"}) ||
          !Require(parts, "finger", "a finger of the scene", &finger)) {
        return false;
      }
      if (fingers.empty()) return Fail(finger, "a finger", "none: the scene has no fingers");
      std::string name;
      if (!ReadChoice(finger, fingers, {}, &name)) return false;
      reading.finger =
          static_cast<int>(std::find(fingers.begin(), fingers.end(), name) - fingers.begin());
      if (!RequireNumber(parts, "value", kAnyNumber, &reading.value) ||
          !RequireNumber(parts, "error", kPositiveNumber, &reading.error)) {
        return false;
      }
      grasp->forces.push_back(reading);
    }
    return true;
  }

  bool CheckData(const YamlField& item, const CalibrationSpec::Grasp& grasp) {
    const bool unknown = std::isinf(grasp.travel_error);
    if (unknown && grasp.scene.fingers.empty()) {
      return Fail(item, "travel_error: unknown without fingers", "none");
    }
    if (unknown && grasp.scans.empty() && grasp.fields.empty()) {
      return Fail(item,
                  "an unknown travel and neither scan nor field",
                  "something that tells the travel: scans, fields, or a travel_error");
    }
    if (grasp.scans.empty() && grasp.fields.empty() && grasp.forces.empty()) {
      return Fail(item, "nothing measured", "scans, fields or forces");
    }
    return true;
  }

  bool CheckGas(const YamlMap& map, const CalibrationSpec& spec) {
    if (!spec.parameter(StateParameter::kGasPressure).asked) return true;
    for (const CalibrationSpec::Grasp& grasp : spec.grasps) {
      if (FindGas(grasp.scene) != nullptr) return true;
    }
    return Fail(*map.Find("parameters"),
                "gas_pressure, but no scene has gas",
                "gas_pressure where a scene has a gas load");
  }

  const std::string folder_;
  const NamedData* const data_;
};

}  // namespace

bool ParseCalibration(const std::string& text,
                      const std::string& file,
                      const std::string& folder,
                      CalibrationSpec* spec,
                      std::string* error,
                      const NamedData* data) {
  CalibrationSpec read;
  CalibrationParser parser(file, folder, data);
  if (!parser.Parse(text, &read)) {
    *error = parser.error();
    return false;
  }
  std::string problem;
  if (!read.IsValid(&problem)) {
    *error = file + ":0: calibration: " + problem;
    return false;
  }
  *spec = std::move(read);
  return true;
}

bool ReadCalibration(const std::string& file, CalibrationSpec* spec, std::string* error) {
  std::string text;
  if (!ReadBytes(file, "what to calibrate, in YAML", &text, error)) return false;
  return ParseCalibration(
      text, file, std::filesystem::path(file).parent_path().string(), spec, error);
}

}  // namespace darboux
