#include "solver/scene_reader.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "geometry/nearest_name.h"
#include "solver/scene_finger_reader.h"
#include "solver/yaml_reader.h"

namespace darboux {
namespace {

constexpr int kMaxSteps = 100000;

const NumberRule kPoisson{"a number in (-1, 0.5]", [](double x) { return x > -1.0 && x <= 0.5; }};
const NumberRule kSpacing{"a number from 0.02 to 1",
                          [](double x) { return x >= 0.02 && x <= 1.0; }};
const NumberRule kFraction{"a number in (0, 1)", [](double x) { return x > 0.0 && x < 1.0; }};

// The values of an option that this version has, and those that the scene format knows besides.
template <typename E>
struct Options {
  std::vector<E> available;
  std::vector<E> missing;
};

Options<Minimizer> Minimizers() {
  return {{Minimizer::kAuto, Minimizer::kMip, Minimizer::kCeres, Minimizer::kCg}, {}};
}
Options<Unstable> UnstableChoices() { return {{Unstable::kReport, Unstable::kLeave}, {}}; }
Options<GasLaw> GasLaws() { return {{GasLaw::kIsothermal, GasLaw::kAdiabatic}, {}}; }
Options<PathControl> PathControls() {
  return {{PathControl::kLoad, PathControl::kDisplacement, PathControl::kArcLength}, {}};
}
Options<Theory> Theories() { return {{Theory::kAuto, Theory::kLinear, Theory::kNonlinear}, {}}; }
Options<Strains> StrainMeasures() { return {{Strains::kKoiter, Strains::kSeed}, {}}; }
Options<BoundaryRule> BoundaryRules() {
  return {{BoundaryRule::kIndependent, BoundaryRule::kSeedGhosts}, {}};
}

template <typename E>
Names NamesOf(const std::vector<E>& values) {
  Names names;
  for (const E value : values) names.push_back(ToString(value));
  return names;
}

template <typename E>
bool ParseOption(const std::string& text,
                 const Options<E>& options,
                 E* value,
                 std::string* problem) {
  for (const E candidate : options.available) {
    if (text == ToString(candidate)) *value = candidate;
  }
  return IsChoice(text, NamesOf(options.available), NamesOf(options.missing), problem);
}

constexpr char kQuadratureAllowed[] = "1, 3, 6 or 12 points per triangle";

bool IsQuadrature(int points) { return points == 1 || points == 3 || points == 6 || points == 12; }

// A path into summary.json: identifiers joined by dots, each with an optional [index].
bool IsQuantity(const std::string& text) {
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = std::min(text.find('.', begin), text.size());
    std::string name = text.substr(begin, end - begin);
    if (!name.empty() && name.back() == ']') {
      const std::size_t bracket = name.find('[');
      if (bracket == std::string::npos) return false;
      const std::string index = name.substr(bracket + 1, name.size() - bracket - 2);
      if (index.empty() || index.find_first_not_of("0123456789") != std::string::npos) {
        return false;
      }
      name.resize(bracket);
    }
    if (!IsIdentifier(name)) return false;
    if (end == text.size()) return true;
    begin = end + 1;
  }
}

const KindKeys& LoadKeys() {
  static const KindKeys& keys =
      *new KindKeys{{"point", {"at", "force"}},
                    {"pressure", {"value", "follower"}},
                    {"traction", {"force"}},
                    {"normal_traction", {"value"}},
                    {"edge", {"on", "force", "moment"}},
                    {"line", {"along", "force"}},
                    {"gravity", {"acceleration"}},
                    {"gas", {"gauge_pressure", "ambient_pressure", "law", "rest"}}};
  return keys;
}

const char* const kAxisNames[] = {"x", "y", "z"};

constexpr char kRootAllowed[] = "a map with the keys name, surface, shell, ...";

class SceneParser : public FingerReader {
 public:
  SceneParser(const std::string& file, const std::string& folder, const ReadOptions& options)
      : FingerReader(file, folder, options) {}

  bool Parse(const std::string& text) {
    return ReadDocument(
        text, kRootAllowed, [this](const YamlField& root) { return ReadRoot(root); });
  }

  const Scene& scene() const { return scene_; }

 private:
  template <typename E>
  bool ReadOption(const YamlField& field, const Options<E>& options, E* value);

  // The sections; the surface comes first, for the others refer to it.
  bool ReadRoot(const YamlField& field);
  bool ReadShell(const YamlField& field);
  bool ReadModel(const YamlField& field);
  bool ReadSupport(const YamlField& field, SupportSpec* support);
  bool ReadFix(const YamlField& field, SupportSpec* support);
  bool ReadSymmetry(const YamlField& field, SupportSpec* support);
  bool ReadLoad(const YamlField& field, LoadSpec* load);
  bool ReadGas(const YamlMap& map, const YamlField& kind, LoadSpec* load);
  bool ReadAlong(const YamlField& field, LoadSpec* load);
  bool ReadOneFinger(const YamlField& field, FingerSpec* finger) {
    return ReadFinger(field, scene_.fingers, finger);
  }
  bool ReadSteps(const YamlField& field);
  bool ReadProbe(const YamlField& field, ProbeSpec* probe);
  bool ReadPath(const YamlField& field);
  bool ReadExpect(const YamlField& field, ExpectSpec* expect);

  template <typename Spec>
  bool ReadSection(const YamlMap& map,
                   const std::string& key,
                   bool (SceneParser::*read)(const YamlField&, Spec*),
                   std::vector<Spec>* specs);

  Scene scene_;
};

template <typename E>
bool SceneParser::ReadOption(const YamlField& field, const Options<E>& options, E* value) {
  std::string text, problem;
  return ReadScalar(field, Join(NamesOf(options.available)), &text) &&
         (ParseOption(text, options, value, &problem) || FailWith(field, problem));
}

template <typename Spec>
bool SceneParser::ReadSection(const YamlMap& map,
                              const std::string& key,
                              bool (SceneParser::*read)(const YamlField&, Spec*),
                              std::vector<Spec>* specs) {
  const YamlField* const field = map.Find(key);
  if (field == nullptr) return true;
  std::vector<YamlField> items;
  if (!OpenList(*field, -1, "a list", &items)) return false;
  for (const YamlField& item : items) {
    specs->emplace_back();
    if (!(this->*read)(item, &specs->back())) return false;
  }
  return true;
}

bool SceneParser::ReadRoot(const YamlField& root) {
  YamlMap map;
  if (!OpenMap(root, kRootAllowed, &map)) return false;
  YamlField name, surface_section, shell;
  if (!CheckKeys(map,
                 {"name",
                  "surface",
                  "shell",
                  "model",
                  "supports",
                  "loads",
                  "hand",
                  "fingers",
                  "steps",
                  "path",
                  "probes",
                  "expect"}) ||
      !Require(map, "name", "a text of one line", &name) ||
      !ReadText(name, "a text of one line", &scene_.name) ||
      !Require(map, "surface", "a map with the key kind", &surface_section) ||
      !ReadSurface(surface_section) ||
      !Require(map, "shell", "a map with thickness, young_modulus, poisson_ratio", &shell) ||
      !ReadShell(shell)) {
    return false;
  }
  scene_.surface = surface();
  if (const YamlField* model = map.Find("model")) {
    if (!ReadModel(*model)) return false;
  }
  if (const YamlField* steps = map.Find("steps")) {
    if (!ReadSteps(*steps)) return false;
  }
  if (const YamlField* hand = map.Find("hand")) {
    if (!ReadHand(*hand)) return false;
  }
  return ReadSection(map, "supports", &SceneParser::ReadSupport, &scene_.supports) &&
         ReadSection(map, "loads", &SceneParser::ReadLoad, &scene_.loads) &&
         ReadSection(map, "fingers", &SceneParser::ReadOneFinger, &scene_.fingers) &&
         ReadSection(map, "probes", &SceneParser::ReadProbe, &scene_.probes) &&
         (map.Find("path") == nullptr || ReadPath(*map.Find("path"))) &&
         ReadSection(map, "expect", &SceneParser::ReadExpect, &scene_.expect);
}

bool SceneParser::ReadShell(const YamlField& field) {
  ShellSpec& shell = scene_.shell;
  shell.location = Location(field);
  YamlMap map;
  if (!OpenMap(field, "a map with thickness, young_modulus, poisson_ratio", &map) ||
      !CheckKeys(map, {"thickness", "young_modulus", "poisson_ratio", "density"}) ||
      !RequireNumber(map, "thickness", kPositiveNumber, &shell.thickness) ||
      !RequireNumber(map, "young_modulus", kPositiveNumber, &shell.young_modulus) ||
      !RequireNumber(map, "poisson_ratio", kPoisson, &shell.poisson_ratio)) {
    return false;
  }
  const YamlField* const density = map.Find("density");
  return density == nullptr || ReadNumber(*density, kNotNegativeNumber, &shell.density);
}

bool SceneParser::ReadModel(const YamlField& field) {
  ModelSpec& model = scene_.model;
  YamlMap map;
  if (!OpenMap(field, "a map", &map) || !CheckKeys(map,
                                                   {"minimizer",
                                                    "theory",
                                                    "strains",
                                                    "quadrature",
                                                    "contact_spacing",
                                                    "boundary_rule",
                                                    "unstable",
                                                    "accuracy"})) {
    return false;
  }
  for (const auto& [key, entry] : map.entries) {
    bool valid = true;
    if (key == "minimizer") {
      valid = ReadOption(entry, Minimizers(), &model.minimizer);
    } else if (key == "theory") {
      valid = ReadOption(entry, Theories(), &model.theory);
    } else if (key == "strains") {
      valid = ReadOption(entry, StrainMeasures(), &model.strains);
    } else if (key == "boundary_rule") {
      valid = ReadOption(entry, BoundaryRules(), &model.boundary_rule);
      if (valid && model.boundary_rule == BoundaryRule::kSeedGhosts && surface().mesh != nullptr) {
        valid = Fail(entry, Describe(entry) + " on a mesh", "independent, or a parametric surface");
      }
    } else if (key == "unstable") {
      valid = ReadOption(entry, UnstableChoices(), &model.unstable);
    } else if (key == "quadrature") {
      model.quadrature_given = true;
      valid = ReadInteger(entry, kQuadratureAllowed, &model.quadrature) &&
              (IsQuadrature(model.quadrature) || Fail(entry, Describe(entry), kQuadratureAllowed));
    } else if (key == "contact_spacing") {
      model.contact_spacing_given = true;
      valid = ReadNumber(entry, kSpacing, &model.contact_spacing);
    } else {
      valid = ReadNumber(entry, kFraction, &model.accuracy.emplace());
    }
    if (!valid) return false;
  }
  return true;
}

bool SceneParser::ReadSteps(const YamlField& field) {
  const std::string allowed = "an integer from 1 to " + std::to_string(kMaxSteps);
  if (!ReadInteger(field, allowed, &scene_.steps)) return false;
  if (scene_.steps >= 1 && scene_.steps <= kMaxSteps) return true;
  return Fail(field, Describe(field), allowed);
}

bool SceneParser::ReadSupport(const YamlField& field, SupportSpec* support) {
  const Names kinds = {"fix", "clamped", "simply_supported", "symmetry"};
  YamlMap map;
  YamlField on;
  support->location = Location(field);
  if (!OpenMap(field, "a map with on and one of " + Join(kinds), &map) ||
      !CheckKeys(map, {"on", "fix", "clamped", "simply_supported", "symmetry", "displacement"}) ||
      !Require(map, "on", "a side, rim or {near: [x, y, z], radius: r}", &on) ||
      !ReadRegion(on, /*near_allowed=*/true, &support->on)) {
    return false;
  }
  Names given;
  for (const std::string& kind : kinds) {
    if (map.Find(kind) != nullptr) given.push_back(kind);
  }
  if (given.size() != 1) {
    return Fail(field,
                given.empty() ? "no kind of support" : Join(given, ", "),
                "exactly one of " + Join(kinds));
  }
  const YamlField& kind = *map.Find(given[0]);
  std::array<bool, 3> fixed{true, true, true};
  if (given[0] == "fix") {
    support->kind = SupportSpec::Kind::kFix;
    if (!ReadFix(kind, support)) return false;
    fixed = support->fix;
  } else if (given[0] == "symmetry") {
    support->kind = SupportSpec::Kind::kSymmetry;
    if (!ReadSymmetry(kind, support)) return false;
  } else {
    support->kind =
        given[0] == "clamped" ? SupportSpec::Kind::kClamped : SupportSpec::Kind::kSimplySupported;
    bool value;
    if (!ReadBool(kind, &value)) return false;
    if (!value) return Fail(kind, "false", "true (leave the support out otherwise)");
  }

  const YamlField* const displacement = map.Find("displacement");
  if (displacement == nullptr) return true;
  if (support->kind == SupportSpec::Kind::kSymmetry) {
    return Fail(*displacement,
                "prescribed values on a symmetry plane",
                "with fix, clamped or simply_supported");
  }
  std::vector<YamlField> items;
  if (!ReadVector(
          *displacement, SamplesOn(surface(), samples(), support->on), &support->displacement) ||
      !OpenList(*displacement, 3, "", &items)) {
    return false;
  }
  for (int i = 0; i < 3; ++i) {
    const Expression& value = support->displacement.component[i].expression;
    const double zeros[5] = {};
    if (fixed[i] || (value.IsConstant() && value.Evaluate(zeros) == 0.0)) continue;
    return Fail(items[i],
                Describe(items[i]) + " for " + kAxisNames[i] + ", which fix does not list",
                "0 for free components");
  }
  return true;
}

bool SceneParser::ReadFix(const YamlField& field, SupportSpec* support) {
  const Names axes(std::begin(kAxisNames), std::end(kAxisNames));
  constexpr char kAllowed[] = "a list of one to three of x, y, z";
  std::vector<YamlField> items;
  if (!OpenList(field, -1, kAllowed, &items)) return false;
  if (items.empty()) return Fail(field, Describe(field), kAllowed);
  for (const YamlField& item : items) {
    std::string text;
    if (!ReadChoice(item, axes, {}, &text)) return false;
    bool& fixed = support->fix[text[0] - 'x'];
    if (fixed) return Fail(item, Quote(text) + " a second time", "every component once");
    fixed = true;
  }
  return true;
}

bool SceneParser::ReadSymmetry(const YamlField& field, SupportSpec* support) {
  constexpr char kAllowed[] = "the normal of the mirror plane: x | y | z | [nx, ny, nz]";
  std::array<double, 3>& normal = support->normal;
  if (field.node.IsScalar()) {
    std::string text;
    if (!ReadScalar(field, kAllowed, &text)) return false;
    for (int i = 0; i < 3; ++i) {
      if (text != kAxisNames[i]) continue;
      normal[i] = 1.0;
      return true;
    }
    return Fail(field, Describe(field), kAllowed);
  }
  if (!ReadNumbers(field, 3, kAllowed, kAnyNumber, normal.data())) return false;
  const Eigen::Map<Eigen::Vector3d> vector(normal.data());
  if (vector.isZero(0.0)) return Fail(field, "a vector of length zero", kAllowed);
  Eigen::Map<Eigen::Vector3d>(normal.data()).stableNormalize();
  return true;
}

bool SceneParser::ReadAlong(const YamlField& field, LoadSpec* load) {
  constexpr char kAllowed[] = "{u: number} | {v: number}";
  YamlMap map;
  if (!OpenMap(field, kAllowed, &map) || !CheckKeys(map, {"u", "v"})) return false;
  if (map.entries.size() != 1) {
    return Fail(field, map.entries.empty() ? "an empty map" : "u and v", kAllowed);
  }
  load->line_parameter = map.entries[0].first == "u" ? 0 : 1;
  return ReadParameter(map.entries[0].second, load->line_parameter, &load->line_value);
}

bool SceneParser::ReadLoad(const YamlField& field, LoadSpec* load) {
  constexpr char kForceAllowed[] = "a list of three numbers or expressions, [x, y, z]";
  const Names kinds = Kinds(LoadKeys());
  YamlMap map;
  YamlField kind, entry;
  std::string name;
  load->location = Location(field);
  if (!OpenMap(field, "a map with the key kind", &map) ||
      !Require(map, "kind", Join(kinds), &kind) || !ReadChoice(kind, kinds, {}, &name) ||
      !CheckKindKeys(map, LoadKeys(), {"kind"}, name)) {
    return false;
  }
  load->kind =
      static_cast<LoadSpec::Kind>(std::find(kinds.begin(), kinds.end(), name) - kinds.begin());
  switch (load->kind) {
    case LoadSpec::Kind::kPoint: {
      std::array<double, 3> force;
      if (!Require(map, "at", "{uv: [u, v]} | {nearest: [x, y, z]}", &entry) ||
          !ReadPoint(entry, &load->at) || !Require(map, "force", kVectorAllowed, &entry) ||
          !ReadNumbers(entry, 3, kVectorAllowed, kAnyNumber, force.data())) {
        return false;
      }
      for (int i = 0; i < 3; ++i) {
        load->force.component[i].expression = Expression::Constant(force[i]);
      }
      return true;
    }
    case LoadSpec::Kind::kPressure: {
      const YamlField* const follower = map.Find("follower");
      return Require(map, "value", kValueAllowed, &entry) &&
             ReadValue(entry, samples(), &load->value) &&
             (follower == nullptr || ReadBool(*follower, &load->follower));
    }
    case LoadSpec::Kind::kTraction:
      return Require(map, "force", kForceAllowed, &entry) &&
             ReadVector(entry, samples(), &load->force);
    case LoadSpec::Kind::kNormalTraction:
      return Require(map, "value", kValueAllowed, &entry) &&
             ReadValue(entry, samples(), &load->value);
    case LoadSpec::Kind::kEdge: {
      if (!Require(map, "on", "a side or rim", &entry) ||
          !ReadRegion(entry, /*near_allowed=*/false, &load->on)) {
        return false;
      }
      const YamlField* const force = map.Find("force");
      const YamlField* const moment = map.Find("moment");
      if (force == nullptr && moment == nullptr) {
        return Fail(field, "neither force nor moment", "one of them or both");
      }
      const std::vector<SurfaceSample> where = SamplesOn(surface(), samples(), load->on);
      return (force == nullptr || ReadVector(*force, where, &load->force)) &&
             (moment == nullptr || ReadVector(*moment, where, &load->moment));
    }
    case LoadSpec::Kind::kLine:
      return Require(map, "along", "{u: number} | {v: number}", &entry) && ReadAlong(entry, load) &&
             Require(map, "force", kForceAllowed, &entry) &&
             ReadVector(entry,
                        SamplesOnLine(surface(), load->line_parameter, load->line_value),
                        &load->force);
    case LoadSpec::Kind::kGravity:
      if (!(scene_.shell.density > 0.0)) {
        return Fail(kind,
                    "gravity with shell.density " + FormatNumber(scene_.shell.density),
                    "gravity only with shell.density > 0");
      }
      return Require(map, "acceleration", kVectorAllowed, &entry) &&
             ReadNumbers(entry, 3, kVectorAllowed, kAnyNumber, load->acceleration.data());
    case LoadSpec::Kind::kGas:
      return ReadGas(map, kind, load);
  }
  return true;
}

bool SceneParser::ReadGas(const YamlMap& map, const YamlField& kind, LoadSpec* load) {
  constexpr char kClosed[] =
      "gas in a closed surface only: icosphere, implicit or a mesh without rim";
  if (surface().mesh == nullptr) {
    return Fail(kind, "gas in a surface of kind " + surface().kind, kClosed);
  }
  if (surface().is_open) return Fail(kind, "gas in a mesh with a rim", kClosed);
  const auto is_gas = [](const LoadSpec& other) { return other.kind == LoadSpec::Kind::kGas; };
  if (std::count_if(scene_.loads.begin(), scene_.loads.end(), is_gas) > 1) {
    return Fail(kind, "gas a second time", "one gas");
  }
  if (!RequireNumber(map, "gauge_pressure", kAnyNumber, &load->gauge_pressure) ||
      !RequireNumber(map, "ambient_pressure", kNotNegativeNumber, &load->ambient_pressure)) {
    return false;
  }
  if (!(load->ambient_pressure + load->gauge_pressure > 0.0)) {
    const YamlField& gauge = *map.Find("gauge_pressure");
    return Fail(gauge,
                Describe(gauge) + " at ambient_pressure " + FormatNumber(load->ambient_pressure),
                "gauge_pressure + ambient_pressure > 0, the absolute pressure");
  }
  if (const YamlField* law = map.Find("law")) {
    if (!ReadOption(*law, GasLaws(), &load->law)) return false;
  }
  std::string rest;
  const YamlField* const field = map.Find("rest");
  if (field == nullptr) return true;
  if (!ReadChoice(*field, {"stress_free", "prestressed"}, {}, &rest)) return false;
  load->prestressed = rest == "prestressed";
  return true;
}

bool SceneParser::ReadProbe(const YamlField& field, ProbeSpec* probe) {
  constexpr char kAllowed[] = "a name of letters, digits and _ that begins with no digit";
  YamlMap map;
  YamlField name, at;
  if (!OpenMap(field, "a map with name and at", &map) || !CheckKeys(map, {"name", "at"}) ||
      !Require(map, "name", kAllowed, &name) || !ReadScalar(name, kAllowed, &probe->name)) {
    return false;
  }
  if (!IsIdentifier(probe->name)) return Fail(name, Describe(name), kAllowed);
  const auto same_name = [probe](const ProbeSpec& other) { return other.name == probe->name; };
  if (std::count_if(scene_.probes.begin(), scene_.probes.end(), same_name) > 1) {
    return Fail(name, Quote(probe->name) + " a second time", "a different name for each probe");
  }
  return Require(map, "at", "{uv: [u, v]} | {nearest: [x, y, z]}", &at) &&
         ReadPoint(at, &probe->at);
}

bool SceneParser::ReadPath(const YamlField& field) {
  PathSpec& path = scene_.path;
  YamlMap map;
  YamlField control;
  path.location = Location(field);
  const std::string allowed_steps = "an integer from 1 to " + std::to_string(kMaxSteps);
  if (!OpenMap(field, "a map with control", &map) ||
      !Require(map, "control", "load | displacement | arc_length", &control) ||
      !ReadOption(control, PathControls(), &path.control)) {
    return false;
  }
  if (path.control != PathControl::kLoad && !scene_.fingers.empty()) {
    return Fail(control,
                Describe(control) + " with fingers",
                "load, which moves the fingers: their travel is the controlled displacement");
  }
  if (path.control != PathControl::kLoad && scene_.model.theory == Theory::kLinear) {
    return Fail(control,
                Describe(control) + " with theory: linear",
                "theory: nonlinear | auto, as the linear theory has no path to follow");
  }
  switch (path.control) {
    case PathControl::kLoad:
      return CheckKeys(map, {"control"});
    case PathControl::kArcLength: {
      if (!CheckKeys(map, {"control", "max_steps"})) return false;
      const YamlField* const steps = map.Find("max_steps");
      if (steps == nullptr) return true;
      if (!ReadInteger(*steps, allowed_steps, &path.max_steps)) return false;
      if (path.max_steps >= 1 && path.max_steps <= kMaxSteps) return true;
      return Fail(*steps, Describe(*steps), allowed_steps);
    }
    case PathControl::kDisplacement:
      break;
  }
  YamlField probe, component, to;
  std::string probe_name, component_name;
  Names probes;
  for (const ProbeSpec& spec : scene_.probes) probes.push_back(spec.name);
  if (!CheckKeys(map, {"control", "probe", "component", "to"}) ||
      !Require(map, "probe", "the name of a probe", &probe) ||
      !ReadScalar(probe, "the name of a probe", &probe_name)) {
    return false;
  }
  const auto found = std::find(probes.begin(), probes.end(), probe_name);
  if (found == probes.end()) {
    return Fail(probe,
                "the probe " + Quote(probe_name),
                probes.empty() ? "no probes, as the scene has none" : Join(probes),
                NearestName(probe_name, probes));
  }
  path.probe = static_cast<int>(found - probes.begin());
  const Names components = {"x", "y", "z"};
  if (!Require(map, "component", Join(components), &component) ||
      !ReadChoice(component, components, {}, &component_name)) {
    return false;
  }
  path.component = static_cast<int>(
      std::find(components.begin(), components.end(), component_name) - components.begin());
  constexpr NumberRule kNotZero{"a number other than 0", [](double x) { return x != 0.0; }};
  return RequireNumber(map, "to", kNotZero, &path.to);
}

bool SceneParser::ReadExpect(const YamlField& field, ExpectSpec* expect) {
  constexpr char kAllowed[] = "a path into summary.json, such as probes.NAME.displacement.z";
  YamlMap map;
  YamlField quantity;
  expect->location = Location(field);
  if (!OpenMap(field, "a map with quantity, value and a tolerance", &map) ||
      !CheckKeys(map,
                 {"quantity", "value", "relative_tolerance", "absolute_tolerance", "source"}) ||
      !Require(map, "quantity", kAllowed, &quantity) ||
      !ReadScalar(quantity, kAllowed, &expect->quantity)) {
    return false;
  }
  if (!IsQuantity(expect->quantity)) return Fail(quantity, Describe(quantity), kAllowed);
  const std::string prefix = "probes.";
  if (expect->quantity.compare(0, prefix.size(), prefix) == 0) {
    const std::string rest = expect->quantity.substr(prefix.size());
    const std::string name = rest.substr(0, rest.find('.'));
    Names probes;
    for (const ProbeSpec& probe : scene_.probes) probes.push_back(probe.name);
    if (std::find(probes.begin(), probes.end(), name) == probes.end()) {
      return Fail(quantity,
                  "the probe " + Quote(name),
                  probes.empty() ? "no probes, as the scene has none" : Join(probes),
                  NearestName(name, probes));
    }
  }
  if (!RequireNumber(map, "value", kAnyNumber, &expect->value)) return false;

  const YamlField* const relative = map.Find("relative_tolerance");
  const YamlField* const absolute = map.Find("absolute_tolerance");
  if ((relative != nullptr) == (absolute != nullptr)) {
    return Fail(field,
                relative != nullptr ? "two tolerances" : "no tolerance",
                "exactly one of relative_tolerance | absolute_tolerance");
  }
  double tolerance;
  if (!ReadNumber(relative != nullptr ? *relative : *absolute, kPositiveNumber, &tolerance)) {
    return false;
  }
  (relative != nullptr ? expect->relative_tolerance : expect->absolute_tolerance) = tolerance;
  if (relative != nullptr && expect->value == 0.0) {
    return Fail(*relative, "a relative tolerance of the value 0", "absolute_tolerance");
  }
  const YamlField* const source = map.Find("source");
  return source == nullptr || ReadText(*source, "a text of one line", &expect->source);
}

}  // namespace

bool ParseSceneIn(const std::string& folder,
                  const std::string& text,
                  const std::string& file,
                  Scene* scene,
                  std::string* error,
                  const ReadOptions& options) {
  SceneParser parser(file, folder, options);
  if (!parser.Parse(text)) {
    *error = parser.error();
    return false;
  }
  *scene = parser.scene();
  return true;
}

bool ReadScene(const std::string& file,
               Scene* scene,
               std::string* error,
               const ReadOptions& options) {
  const auto fail = [&](const std::string& reason) {
    *error = file + ":0: scene: " +
             Problem("a file that cannot be read (" + reason + ")", "a scene in YAML");
    return false;
  };
  std::error_code ignored;  // A path that cannot be examined fails to open below.
  if (std::filesystem::is_directory(file, ignored)) return fail("it is a directory");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fail(errno != 0 ? std::generic_category().message(errno) : "no reason given");
  // One byte more than allowed tells a file that is too long, even an endless one.
  std::string text(kMaxSceneBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return fail("reading failed");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return ParseSceneIn(folder, text, file, scene, error, options);
}

bool ParseScene(const std::string& text,
                const std::string& file,
                Scene* scene,
                std::string* error,
                const ReadOptions& options) {
  return ParseSceneIn("", text, file, scene, error, options);
}

bool ApplyOverrides(const SceneOverrides& overrides, Scene* scene, std::string* error) {
  ModelSpec model = scene->model;
  std::array<int, 2> divisions = scene->surface.divisions;
  std::string problem;
  const auto fail = [&](const std::string& flag, const std::string& text) {
    *error = "--" + flag + ": " + text;
    return false;
  };
  if (overrides.theory && !ParseOption(*overrides.theory, Theories(), &model.theory, &problem)) {
    return fail("theory", problem);
  }
  if (overrides.strains &&
      !ParseOption(*overrides.strains, StrainMeasures(), &model.strains, &problem)) {
    return fail("strains", problem);
  }
  if (overrides.minimizer &&
      !ParseOption(*overrides.minimizer, Minimizers(), &model.minimizer, &problem)) {
    return fail("minimizer", problem);
  }
  if (overrides.quadrature) {
    model.quadrature = *overrides.quadrature;
    if (!IsQuadrature(model.quadrature)) {
      return fail("quadrature", Problem(std::to_string(model.quadrature), kQuadratureAllowed));
    }
  }
  if (overrides.divisions) {
    if (scene->surface.mesh != nullptr) {
      return fail("divisions",
                  Problem("a surface of kind " + scene->surface.kind,
                          "a parametric surface, or surface.refine in the scene"));
    }
    const std::string& text = *overrides.divisions;
    const std::size_t comma = std::min(text.find(','), text.size());
    if (!ParseInteger(text.substr(0, comma), &divisions[0]) || comma == text.size() ||
        !ParseInteger(text.substr(comma + 1), &divisions[1])) {
      return fail("divisions", Problem(Quote(text), "M,N with two integers > 0"));
    }
    const std::string allowed = DivisionsAllowed(divisions, scene->surface.periodic);
    if (!allowed.empty()) return fail("divisions", Problem(Quote(text), allowed));
  }
  scene->model = model;
  scene->surface.divisions = divisions;
  return true;
}

}  // namespace darboux
