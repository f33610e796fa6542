#include "solver/scene_reader.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

namespace darboux {
namespace {

using Names = std::vector<std::string>;

constexpr std::size_t kMaxFileBytes = 1 << 20;
constexpr int kMaxVertices = 10000000;
constexpr int kMaxSteps = 100000;
// Samples per direction on which surface and expressions are checked.
constexpr int kSamples = 33;
// A tangent frame this small, relative to the largest on the surface, counts as degenerate: it
// stands for cells of sides 1 : 1e7. Coarse enough for a pole typed as 1.5707963.
constexpr double kDegenerate = 1e-7;
// Relative gap between the two ends of a periodic direction: 6.283185 will do for 2 pi, 6.2832
// will not.
constexpr double kPeriodicGap = 1e-6;
// Points this far outside a range, relative to its length, are rounding and moved to its end.
constexpr double kRangeRounding = 1e-9;

// ---- Words ----------------------------------------------------------------------------------

std::string Join(const Names& names, const std::string& separator = " | ") {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text;
}

// For quoting in a one-line message: control characters as '?', long texts cut.
std::string Clean(const std::string& text, std::size_t max_bytes = 60) {
  std::string clean = text;
  if (clean.size() > max_bytes) {
    std::size_t end = max_bytes;
    while (end > 0 && (static_cast<unsigned char>(clean[end]) & 0xC0) == 0x80) --end;  // UTF-8.
    clean = clean.substr(0, end) + "...";
  }
  for (char& c : clean) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return clean;
}

std::string Quote(const std::string& text) { return "'" + Clean(text) + "'"; }

// The shortest text that reads back as the same number.
std::string FormatNumber(double value) {
  char buffer[40];
  const std::to_chars_result end = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, end.ptr);
}

std::string FormatShort(double value) {
  char buffer[40];
  const std::to_chars_result end =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::general, 4);
  return std::string(buffer, end.ptr);
}

std::string FormatRange(const std::array<double, 2>& range) {
  return "[" + FormatNumber(range[0]) + ", " + FormatNumber(range[1]) + "]";
}

std::string Problem(const std::string& found,
                    const std::string& allowed,
                    const std::string& nearest = "") {
  std::string text = "found " + found + "; allowed " + allowed;
  if (!nearest.empty()) text += "; did you mean '" + nearest + "'?";
  return text;
}

// Whether `found` is one of the available names; if not, why. `missing` are names of the scene
// format that this version does not have yet.
bool IsChoice(const std::string& found,
              const Names& available,
              const Names& missing,
              std::string* problem) {
  if (std::find(available.begin(), available.end(), found) != available.end()) return true;
  const bool later = std::find(missing.begin(), missing.end(), found) != missing.end();
  *problem = later ? Problem(Quote(found) + ", which is not part of this version", Join(available))
                   : Problem(Quote(found), Join(available), NearestName(found, available));
  return false;
}

// The values of an option that this version has, and those that the scene format knows besides.
template <typename E>
struct Options {
  std::vector<E> available;
  std::vector<E> missing;
};

Options<Minimizer> Minimizers() {
  return {{Minimizer::kAuto, Minimizer::kCeres}, {Minimizer::kMip, Minimizer::kCg}};
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

enum class NumberSyntax { kNumber, kNonFinite, kNoNumber };

// Decimal numbers as in YAML 1.2, independent of the locale.
NumberSyntax ParseNumber(const std::string& text, double* value) {
  const std::size_t sign = !text.empty() && (text[0] == '+' || text[0] == '-') ? 1 : 0;
  const std::string rest = text.substr(sign);
  for (const char* name : {".inf", ".Inf", ".INF", ".nan", ".NaN", ".NAN"}) {
    if (rest == name) return NumberSyntax::kNonFinite;
  }
  const auto is_digit = [&rest](std::size_t i) {
    return i < rest.size() && rest[i] >= '0' && rest[i] <= '9';
  };
  // from_chars would also take "inf", "nan" and a second sign.
  if (!is_digit(0) && !(rest[0] == '.' && is_digit(1))) return NumberSyntax::kNoNumber;
  const char* const end = rest.data() + rest.size();
  const std::from_chars_result result = std::from_chars(rest.data(), end, *value);
  if (result.ptr != end) return NumberSyntax::kNoNumber;
  if (result.ec != std::errc() || !std::isfinite(*value)) return NumberSyntax::kNonFinite;
  if (text[0] == '-') *value = -*value;
  return NumberSyntax::kNumber;
}

bool ParseInteger(const std::string& text, int* value) {
  const std::size_t plus = text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0;
  const char* const end = text.data() + text.size();
  const std::from_chars_result result = std::from_chars(text.data() + plus, end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

// Letters, digits and _, no digit first.
bool IsIdentifier(const std::string& text) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  if (text.empty() || !is_letter(text[0])) return false;
  return std::all_of(text.begin(), text.end(), [&is_letter](char c) {
    return is_letter(c) || (c >= '0' && c <= '9');
  });
}

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

// Empty, or what is allowed in place of these divisions.
std::string DivisionsAllowed(const std::array<int, 2>& divisions,
                             const std::array<bool, 2>& periodic) {
  for (int i = 0; i < 2; ++i) {
    const int least = periodic[i] ? 4 : 1;
    if (divisions[i] < least) {
      return "an integer >= " + std::to_string(least) + " for " + (i == 0 ? "u" : "v") +
             (periodic[i] ? ", which is periodic" : "");
    }
  }
  const double vertices = (divisions[0] + 1.0) * (divisions[1] + 1.0);
  if (vertices > kMaxVertices) return "at most " + std::to_string(kMaxVertices) + " vertices";
  return "";
}

// Empty, or why yaml-cpp shall not see the text: it would stop at some control characters without
// a word and let directives pass. Sets *line (1-based).
std::string TextProblem(const std::string& text, int* line) {
  if (text.size() > kMaxFileBytes) {
    *line = 1;
    return Problem("more than " + std::to_string(kMaxFileBytes) + " bytes",
                   "a scene of at most " + std::to_string(kMaxFileBytes) + " bytes");
  }
  *line = 1;
  bool indentation = true;  // Only blanks since the line began.
  bool tab = false;         // A tab among them.
  int continuation = 0;     // Bytes of this UTF-8 character that are still to come.
  for (std::size_t i = 0; i < text.size(); ++i) {
    const unsigned char c = static_cast<unsigned char>(text[i]);
    const bool is_continuation = (c & 0xC0) == 0x80;
    if (is_continuation != (continuation > 0) || c >= 0xF8) {
      return Problem("a byte that is not UTF-8 text", "UTF-8 text");
    }
    continuation = is_continuation ? continuation - 1
                   : c >= 0xF0     ? 3
                   : c >= 0xE0     ? 2
                   : c >= 0xC0     ? 1
                                   : 0;
    if (c == '\n') {
      ++*line;
      indentation = true;
      tab = false;
    } else if (c == '\t') {
      tab = tab || indentation;
    } else if (c != ' ' && c != '\r') {
      if (c < 0x20 || c == 0x7F) {
        return Problem("a control character (code " + std::to_string(c) + ")", "UTF-8 text");
      }
      if (indentation && tab && c != '#') {
        return Problem("a tab in the indentation", "spaces");
      }
      if (c == '%' && (i == 0 || text[i - 1] == '\n')) {
        return Problem("a YAML directive (%)", "one document without directives");
      }
      indentation = false;
    }
  }
  if (continuation > 0) return Problem("a byte that is not UTF-8 text", "UTF-8 text");
  return "";
}

// ---- The surface ----------------------------------------------------------------------------

struct SurfaceSample {
  double u, v;
  Eigen::Vector3d x;
};

double Interpolate(const std::array<double, 2>& range, int i) {
  if (i == kSamples - 1) return range[1];
  return range[0] + (range[1] - range[0]) * i / (kSamples - 1);
}

std::string At(double u, double v) { return "u = " + FormatShort(u) + ", v = " + FormatShort(v); }

// Looks at a surface on a grid of samples and, for points without tangent plane, between them.
class SurfaceCheck {
 public:
  explicit SurfaceCheck(const SurfaceSpec& spec)
      : surface_(*spec.surface), range_{spec.u_range, spec.v_range} {}

  // False where position, first or second derivatives are not finite; sets u, v.
  bool IsFinite(double* u, double* v) {
    Eigen::AlignedBox3d box;
    samples_.clear();
    normal_.clear();
    for (int j = 0; j < kSamples; ++j) {
      for (int i = 0; i < kSamples; ++i) {
        *u = Interpolate(range_[0], i);
        *v = Interpolate(range_[1], j);
        const SurfaceJet jet = surface_.Evaluate(*u, *v);
        const Eigen::Vector3d normal = jet.x_u.cross(jet.x_v);
        if (!jet.x.allFinite() || !jet.x_u.allFinite() || !jet.x_v.allFinite() ||
            !jet.x_uu.allFinite() || !jet.x_uv.allFinite() || !jet.x_vv.allFinite() ||
            !std::isfinite(normal.squaredNorm())) {
          return false;
        }
        box.extend(jet.x);
        largest_[0] = std::max(largest_[0], jet.x_u.norm());
        largest_[1] = std::max(largest_[1], jet.x_v.norm());
        samples_.push_back({*u, *v, jet.x});
        normal_.push_back(normal.norm());
      }
    }
    size_ = box.diagonal().norm();
    return true;
  }

  // False where sigma_u x sigma_v vanishes; sets u, v. After IsFinite.
  bool IsRegular(double* u, double* v) const {
    const double scale = largest_[0] * largest_[1];
    for (int j = 0; j < kSamples; ++j) {
      for (int i = 0; i < kSamples; ++i) {
        const double here = normal_[j * kSamples + i];
        *u = Interpolate(range_[0], i);
        *v = Interpolate(range_[1], j);
        if (!(here > kDegenerate * scale)) return false;
        if (here < 0.5 * scale && IsLowest(i, j) && Descend(kDegenerate * scale, u, v)) {
          return false;
        }
      }
    }
    return true;
  }

  // Whether the line at this end (0 or 1) of a direction shrinks to a point.
  bool IsPole(int direction, int end) const {
    const int other = 1 - direction;
    if (!(largest_[other] > 0.0)) return false;  // So do all lines.
    for (int i = 0; i < kSamples; ++i) {
      double p[2];
      p[direction] = range_[direction][end];
      p[other] = Interpolate(range_[other], i);
      const SurfaceJet jet = surface_.Evaluate(p[0], p[1]);
      const Eigen::Vector3d& tangent = other == 0 ? jet.x_u : jet.x_v;
      if (!(tangent.norm() <= 2.0 * kDegenerate * largest_[other])) return false;
    }
    return true;
  }

  // False where positions or first derivatives differ between the ends of a direction; says how.
  bool IsPeriodic(int direction, std::string* difference) const {
    const int other = 1 - direction;
    const std::string name = direction == 0 ? "u" : "v";
    for (int k = 0; k < kSamples; ++k) {
      SurfaceJet end[2];
      double p[2];
      p[other] = Interpolate(range_[other], k);
      for (int i = 0; i < 2; ++i) {
        p[direction] = range_[direction][i];
        end[i] = surface_.Evaluate(p[0], p[1]);
      }
      const auto differ = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double scale) {
        return !((a - b).norm() <= kPeriodicGap * scale);
      };
      std::string what;
      if (differ(end[0].x, end[1].x, size_)) {
        what = "surface points " + FormatShort((end[0].x - end[1].x).norm()) + " apart";
      } else if (differ(end[0].x_u, end[1].x_u, largest_[0])) {
        what = "different sigma_u";
      } else if (differ(end[0].x_v, end[1].x_v, largest_[1])) {
        what = "different sigma_v";
      }
      if (!what.empty()) {
        *difference = what + " at the two ends of " + name + " (" + (other == 0 ? "u" : "v") +
                      " = " + FormatShort(p[other]) + ")";
        return false;
      }
    }
    return true;
  }

  const std::vector<SurfaceSample>& samples() const { return samples_; }

 private:
  bool IsLowest(int i, int j) const {
    const double here = normal_[j * kSamples + i];
    for (int l = std::max(j - 1, 0); l <= std::min(j + 1, kSamples - 1); ++l) {
      for (int k = std::max(i - 1, 0); k <= std::min(i + 1, kSamples - 1); ++k) {
        if (normal_[l * kSamples + k] < here) return false;
      }
    }
    return true;
  }

  // Compass search for a smaller |sigma_u x sigma_v|; true when it gets down to the limit.
  bool Descend(double limit, double* u, double* v) const {
    const auto norm = [this](double p, double q) {
      const SurfaceJet jet = surface_.Evaluate(p, q);
      return jet.x_u.cross(jet.x_v).norm();
    };
    double lowest = norm(*u, *v);
    double step = 1.0 / (kSamples - 1);
    for (int round = 0; round < 200 && step > 1e-12 && lowest > limit; ++round) {
      double best_u = *u, best_v = *v, best = lowest;
      for (int a = -1; a <= 1; ++a) {
        for (int b = -1; b <= 1; ++b) {
          const double p = Move(range_[0], *u, a * step);
          const double q = Move(range_[1], *v, b * step);
          const double value = norm(p, q);
          if (value < best * (1.0 - 1e-6)) {  // More than rounding.
            best = value;
            best_u = p;
            best_v = q;
          }
        }
      }
      if (best < lowest) {
        lowest = best;
        *u = best_u;
        *v = best_v;
        step *= 2.0;  // Shortened too early, in a narrow valley.
      } else {
        step *= 0.5;
      }
    }
    return lowest <= limit;
  }

  static double Move(const std::array<double, 2>& range, double value, double fraction) {
    return std::clamp(value + fraction * (range[1] - range[0]), range[0], range[1]);
  }

  const ParametricSurface& surface_;
  const std::array<std::array<double, 2>, 2> range_;
  std::vector<SurfaceSample> samples_;
  std::vector<double> normal_;      // |sigma_u x sigma_v| of each sample.
  double largest_[2] = {0.0, 0.0};  // |sigma_u|, |sigma_v|.
  double size_ = 0.0;               // Diagonal of the bounding box.
};

// ---- The reader -----------------------------------------------------------------------------

// A value of the file and where it stands.
struct Field {
  Field() = default;
  Field(const Field&) = default;
  // YAML::Node's own assignment would change the tree: whatever refers to the node assigned to
  // would from then on refer to the other one.
  Field& operator=(const Field& other) {
    path = other.path;
    node.reset(other.node);
    line = other.line;
    return *this;
  }

  std::string path;
  YAML::Node node;
  int line = 1;
};

struct Map {
  Field self;
  std::vector<std::pair<std::string, Field>> entries;

  const Field* Find(const std::string& key) const {
    for (const auto& [name, field] : entries) {
      if (name == key) return &field;
    }
    return nullptr;
  }
};

struct NumberRule {
  const char* allowed;
  bool (*holds)(double);
};

const NumberRule kAny{"a number", [](double) { return true; }};
const NumberRule kPositive{"a number > 0", [](double x) { return x > 0.0; }};
const NumberRule kNotNegative{"a number >= 0", [](double x) { return x >= 0.0; }};
const NumberRule kPoisson{"a number in (-1, 0.5]", [](double x) { return x > -1.0 && x <= 0.5; }};
const NumberRule kGrading{"a number in (-1, 1)", [](double x) { return x > -1.0 && x < 1.0; }};
const NumberRule kFraction{"a number in (0, 1)", [](double x) { return x > 0.0 && x < 1.0; }};

constexpr char kVectorAllowed[] = "a list of three numbers, [x, y, z]";
constexpr char kValueAllowed[] = "a number or an expression of u, v, x, y, z";

// The keys that each kind has besides the common ones.
using KindKeys = std::vector<std::pair<std::string, Names>>;

const KindKeys& SurfaceKeys() {
  static const KindKeys& keys = *new KindKeys{{"plane", {}},
                                              {"cylinder", {"radius"}},
                                              {"sphere", {"radius"}},
                                              {"ellipsoid", {"semi_axes"}},
                                              {"torus", {"radii"}},
                                              {"monkey_saddle", {"scale"}},
                                              {"expression", {"position"}}};
  return keys;
}

const KindKeys& LoadKeys() {
  static const KindKeys& keys = *new KindKeys{{"point", {"at", "force"}},
                                              {"pressure", {"value", "follower"}},
                                              {"traction", {"force"}},
                                              {"normal_traction", {"value"}},
                                              {"edge", {"on", "force", "moment"}},
                                              {"line", {"along", "force"}},
                                              {"gravity", {"acceleration"}}};
  return keys;
}

Names Kinds(const KindKeys& keys) {
  Names kinds;
  for (const auto& entry : keys) kinds.push_back(entry.first);
  return kinds;
}

const char* const kSideNames[] = {"u_min", "u_max", "v_min", "v_max", "rim"};
const char* const kAxisNames[] = {"x", "y", "z"};
const char* const kParameterNames[] = {"u", "v"};

class SceneParser {
 public:
  explicit SceneParser(const std::string& file) : file_(file) {}

  bool Parse(const std::string& text);

  const Scene& scene() const { return scene_; }
  const std::string& error() const { return error_; }

 private:
  // Messages; all return false.
  bool FailWith(const Field& field, const std::string& problem);
  bool Fail(const Field& field,
            const std::string& found,
            const std::string& allowed,
            const std::string& nearest = "") {
    return FailWith(field, Problem(found, allowed, nearest));
  }

  SceneLocation Location(const Field& field) const { return {file_, field.line, field.path}; }

  // Building blocks: each checks the type of a field and gives its content.
  static std::string Describe(const Field& field);
  bool CheckTag(const Field& field);
  bool OpenMap(const Field& field, const std::string& allowed, Map* map);
  bool CheckKeys(const Map& map, const Names& known);
  bool CheckKindKeys(const Map& map,
                     const KindKeys& table,
                     const Names& common,
                     const std::string& kind);
  bool Require(const Map& map, const std::string& key, const std::string& allowed, Field* field);
  bool OpenList(const Field& field,
                int size,  // -1: any
                const std::string& allowed,
                std::vector<Field>* items);
  bool ReadScalar(const Field& field, const std::string& allowed, std::string* text);
  bool ReadText(const Field& field, const std::string& allowed, std::string* text);
  bool ReadChoice(const Field& field,
                  const Names& available,
                  const Names& missing,
                  std::string* text);
  template <typename E>
  bool ReadOption(const Field& field, const Options<E>& options, E* value);
  bool ReadBool(const Field& field, bool* value);
  bool ReadInteger(const Field& field, const std::string& allowed, int* value);
  bool ReadNumber(const Field& field, const NumberRule& rule, double* value);
  bool ReadNumbers(const Field& field,
                   int size,
                   const std::string& allowed,
                   const NumberRule& rule,
                   double* values);
  bool RequireNumber(const Map& map, const std::string& key, const NumberRule& rule, double* value);
  bool ReadValue(const Field& field, const std::vector<SurfaceSample>& where, SceneValue* value);
  bool ReadVector(const Field& field, const std::vector<SurfaceSample>& where, SceneVector* value);

  // Places on the surface; these need the surface.
  bool HasSide(int side) const;  // Of kSideNames.
  std::vector<SurfaceSample> SamplesOn(const Region& region) const;
  std::vector<SurfaceSample> SamplesOnLine(int parameter, double value) const;
  const std::array<double, 2>& Range(int parameter) const {
    return parameter == 0 ? scene_.surface.u_range : scene_.surface.v_range;
  }
  bool ReadParameter(const Field& field, int parameter, double* value);
  bool ReadRegion(const Field& field, bool near_allowed, Region* region);
  bool ReadPoint(const Field& field, SurfacePoint* point);

  // The sections.
  bool ReadRoot(const Field& field);
  bool ReadSurface(const Field& field);
  bool ReadShape(const Map& map);
  bool ReadGrid(const Map& map);
  bool CheckSurface(const Map& map);
  bool ReadShell(const Field& field);
  bool ReadModel(const Field& field);
  bool ReadSupport(const Field& field, SupportSpec* support);
  bool ReadFix(const Field& field, SupportSpec* support);
  bool ReadSymmetry(const Field& field, SupportSpec* support);
  bool ReadLoad(const Field& field, LoadSpec* load);
  bool ReadAlong(const Field& field, LoadSpec* load);
  bool ReadSteps(const Field& field);
  bool ReadProbe(const Field& field, ProbeSpec* probe);
  bool ReadExpect(const Field& field, ExpectSpec* expect);

  template <typename Spec>
  bool ReadSection(const Map& map,
                   const std::string& key,
                   bool (SceneParser::*read)(const Field&, Spec*),
                   std::vector<Spec>* specs);

  const std::string file_;
  Scene scene_;
  std::string error_;
  std::vector<SurfaceSample> samples_;
};

bool SceneParser::FailWith(const Field& field, const std::string& problem) {
  error_ = file_ + ":" + std::to_string(field.line) + ": " + field.path + ": " + problem;
  return false;
}

std::string SceneParser::Describe(const Field& field) {
  const YAML::Node& node = field.node;
  if (node.IsScalar()) {
    if (node.Tag() == "!") return "\"" + Clean(node.Scalar()) + "\"";  // Quoted in the file.
    double value;
    const bool number = ParseNumber(node.Scalar(), &value) != NumberSyntax::kNoNumber;
    return number ? Clean(node.Scalar()) : Quote(node.Scalar());
  }
  if (node.IsSequence()) {
    return node.size() == 0 ? "an empty list" : "a list of " + std::to_string(node.size());
  }
  return node.IsMap() ? "a map" : "nothing";
}

bool SceneParser::CheckTag(const Field& field) {
  const std::string& tag = field.node.Tag();
  if (tag.empty() || tag == "?" || tag == "!") return true;
  return Fail(field, "the tag " + Quote(tag), "values without YAML tags");
}

bool SceneParser::OpenMap(const Field& field, const std::string& allowed, Map* map) {
  if (!field.node.IsMap()) return Fail(field, Describe(field), allowed);
  if (!CheckTag(field)) return false;
  map->self = field;
  map->entries.clear();
  std::map<std::string, int> seen;  // Line of each key.
  for (const auto& entry : field.node) {
    Field key = field;
    key.node.reset(entry.first);
    key.line = std::max(entry.first.Mark().line + 1, 1);
    if (!entry.first.IsScalar()) {
      return Fail(key, Describe(key) + " as a key", "names as keys");
    }
    const std::string& name = entry.first.Scalar();
    if (field.path == "scene") {
      key.path = Clean(name);
    } else {
      key.path += "." + Clean(name);
    }
    if (name == "<<") return Fail(key, "a YAML merge key", "keys written out");
    const auto [first, is_new] = seen.emplace(name, key.line);
    if (!is_new) {
      return Fail(key,
                  "the key a second time (first in line " + std::to_string(first->second) + ")",
                  "every key once");
    }
    key.node.reset(entry.second);
    // The mark of an alias is that of its anchor, further up: stay with the key.
    if (entry.second.IsScalar()) key.line = std::max(key.line, entry.second.Mark().line + 1);
    map->entries.emplace_back(name, key);
  }
  return true;
}

bool SceneParser::CheckKeys(const Map& map, const Names& known) {
  for (const auto& [name, field] : map.entries) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    return Fail(field, "an unknown key", Join(known), NearestName(name, known));
  }
  return true;
}

bool SceneParser::CheckKindKeys(const Map& map,
                                const KindKeys& table,
                                const Names& common,
                                const std::string& kind) {
  Names known;
  for (const auto& [name, keys] : table) {
    if (name == kind) known = keys;
  }
  known.insert(known.end(), common.begin(), common.end());
  for (const auto& [name, field] : map.entries) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    Names owners;
    for (const auto& [owner, keys] : table) {
      if (std::find(keys.begin(), keys.end(), name) != keys.end()) owners.push_back(owner);
    }
    if (owners.empty()) {
      return Fail(field, "an unknown key", Join(known), NearestName(name, known));
    }
    return Fail(
        field, "a key of kind " + Join(owners, ", "), "with kind " + kind + ": " + Join(known));
  }
  return true;
}

bool SceneParser::Require(const Map& map,
                          const std::string& key,
                          const std::string& allowed,
                          Field* field) {
  if (const Field* found = map.Find(key)) {
    *field = *found;
    return true;
  }
  field->path = map.self.path == "scene" ? key : map.self.path + "." + key;
  field->line = map.self.line;
  return Fail(*field, "no such key, which is required", allowed);
}

bool SceneParser::OpenList(const Field& field,
                           int size,
                           const std::string& allowed,
                           std::vector<Field>* items) {
  if (!field.node.IsSequence() || (size >= 0 && static_cast<int>(field.node.size()) != size)) {
    return Fail(field, Describe(field), allowed);
  }
  if (!CheckTag(field)) return false;
  items->clear();
  for (const auto& node : field.node) {
    Field item;
    item.path = field.path + "[" + std::to_string(items->size()) + "]";
    item.node.reset(node);
    item.line = node.IsNull() ? field.line : std::max(field.line, node.Mark().line + 1);
    items->push_back(item);
  }
  return true;
}

bool SceneParser::ReadScalar(const Field& field, const std::string& allowed, std::string* text) {
  if (!field.node.IsScalar()) return Fail(field, Describe(field), allowed);
  if (!CheckTag(field)) return false;
  *text = field.node.Scalar();
  return true;
}

bool SceneParser::ReadText(const Field& field, const std::string& allowed, std::string* text) {
  if (!ReadScalar(field, allowed, text)) return false;
  const bool control = std::any_of(
      text->begin(), text->end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; });
  return text->empty() || control ? Fail(field, Describe(field), allowed) : true;
}

bool SceneParser::ReadChoice(const Field& field,
                             const Names& available,
                             const Names& missing,
                             std::string* text) {
  std::string problem;
  return ReadScalar(field, Join(available), text) &&
         (IsChoice(*text, available, missing, &problem) || FailWith(field, problem));
}

template <typename E>
bool SceneParser::ReadOption(const Field& field, const Options<E>& options, E* value) {
  std::string text, problem;
  return ReadScalar(field, Join(NamesOf(options.available)), &text) &&
         (ParseOption(text, options, value, &problem) || FailWith(field, problem));
}

bool SceneParser::ReadBool(const Field& field, bool* value) {
  std::string text;
  if (!ReadScalar(field, "true | false", &text)) return false;
  *value = text == "true";
  if (field.node.Tag() != "!" && (*value || text == "false")) return true;
  return Fail(field, Describe(field), "true | false");
}

bool SceneParser::ReadInteger(const Field& field, const std::string& allowed, int* value) {
  std::string text;
  if (!ReadScalar(field, allowed, &text)) return false;
  if (field.node.Tag() != "!" && ParseInteger(text, value)) return true;
  return Fail(field, Describe(field), allowed);
}

bool SceneParser::ReadNumber(const Field& field, const NumberRule& rule, double* value) {
  std::string text;
  if (!ReadScalar(field, rule.allowed, &text)) return false;
  const NumberSyntax syntax = ParseNumber(text, value);
  if (syntax == NumberSyntax::kNonFinite) {
    return Fail(field, Describe(field) + ", which is not finite", rule.allowed);
  }
  if (syntax == NumberSyntax::kNoNumber) {
    std::string mistake;
    const std::optional<Expression> expression = Expression::Parse(text, {}, &mistake);
    if (!expression) {
      return Fail(field,
                  Describe(field) + " (" + Clean(mistake, 300) + ")",
                  std::string(rule.allowed) + " or a constant expression such as pi/2");
    }
    *value = expression->Evaluate(static_cast<const double*>(nullptr));
    if (!std::isfinite(*value)) {
      return Fail(field, Describe(field) + ", which is not finite", rule.allowed);
    }
  }
  return rule.holds(*value) ? true : Fail(field, Describe(field), rule.allowed);
}

bool SceneParser::ReadNumbers(const Field& field,
                              int size,
                              const std::string& allowed,
                              const NumberRule& rule,
                              double* values) {
  std::vector<Field> items;
  if (!OpenList(field, size, allowed, &items)) return false;
  for (int i = 0; i < size; ++i) {
    if (!ReadNumber(items[i], rule, &values[i])) return false;
  }
  return true;
}

bool SceneParser::RequireNumber(const Map& map,
                                const std::string& key,
                                const NumberRule& rule,
                                double* value) {
  Field field;
  return Require(map, key, rule.allowed, &field) && ReadNumber(field, rule, value);
}

bool SceneParser::ReadValue(const Field& field,
                            const std::vector<SurfaceSample>& where,
                            SceneValue* value) {
  std::string text;
  if (!ReadScalar(field, kValueAllowed, &text)) return false;
  double number;
  const NumberSyntax syntax = ParseNumber(text, &number);
  if (syntax == NumberSyntax::kNonFinite) {
    return Fail(field, Describe(field) + ", which is not finite", kValueAllowed);
  }
  if (syntax == NumberSyntax::kNumber) {
    value->expression = Expression::Constant(number);
    return true;
  }
  std::string mistake;
  const std::optional<Expression> expression =
      Expression::Parse(text, {"u", "v", "x", "y", "z"}, &mistake);
  if (!expression) {
    return Fail(field, Describe(field) + " (" + Clean(mistake, 300) + ")", kValueAllowed);
  }
  value->expression = *expression;
  if (expression->IsConstant()) {
    const double zeros[5] = {};
    if (std::isfinite(expression->Evaluate(zeros))) return true;
    return Fail(field, Describe(field) + ", which is not finite", kValueAllowed);
  }
  for (const SurfaceSample& at : where) {
    const double variables[5] = {at.u, at.v, at.x[0], at.x[1], at.x[2]};
    if (!std::isfinite(expression->Evaluate(variables))) {
      return Fail(field,
                  Describe(field) + ", which is not finite at " + At(at.u, at.v),
                  "an expression that is finite wherever it acts");
    }
  }
  return true;
}

bool SceneParser::ReadVector(const Field& field,
                             const std::vector<SurfaceSample>& where,
                             SceneVector* value) {
  std::vector<Field> items;
  if (!OpenList(field, 3, "a list of three numbers or expressions, [x, y, z]", &items)) {
    return false;
  }
  for (int i = 0; i < 3; ++i) {
    if (!ReadValue(items[i], where, &value->component[i])) return false;
  }
  return true;
}

// ---- Places ---------------------------------------------------------------------------------

bool SceneParser::HasSide(int side) const {
  const std::array<bool, 2>& periodic = scene_.surface.periodic;
  return side < 4 ? !periodic[side / 2] : !(periodic[0] && periodic[1]);
}

std::vector<SurfaceSample> SceneParser::SamplesOn(const Region& region) const {
  const Eigen::Vector3d center(region.center[0], region.center[1], region.center[2]);
  const std::array<double, 2>& u = scene_.surface.u_range;
  const std::array<double, 2>& v = scene_.surface.v_range;
  const auto contains = [&](const SurfaceSample& sample) {
    switch (region.kind) {
      case Region::Kind::kUMin:
        return sample.u == u[0];
      case Region::Kind::kUMax:
        return sample.u == u[1];
      case Region::Kind::kVMin:
        return sample.v == v[0];
      case Region::Kind::kVMax:
        return sample.v == v[1];
      case Region::Kind::kRim:
        return (HasSide(0) && (sample.u == u[0] || sample.u == u[1])) ||
               (HasSide(2) && (sample.v == v[0] || sample.v == v[1]));
      case Region::Kind::kNear:
        return (sample.x - center).norm() <= region.radius;
    }
    return false;
  };
  std::vector<SurfaceSample> samples;
  std::copy_if(samples_.begin(), samples_.end(), std::back_inserter(samples), contains);
  return samples;
}

std::vector<SurfaceSample> SceneParser::SamplesOnLine(int parameter, double value) const {
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < kSamples; ++i) {
    double p[2];
    p[parameter] = value;
    p[1 - parameter] = Interpolate(Range(1 - parameter), i);
    samples.push_back({p[0], p[1], scene_.surface.surface->Evaluate(p[0], p[1]).x});
  }
  return samples;
}

bool SceneParser::ReadParameter(const Field& field, int parameter, double* value) {
  if (!ReadNumber(field, kAny, value)) return false;
  const std::array<double, 2>& range = Range(parameter);
  const double rounding = kRangeRounding * (range[1] - range[0]);
  if (*value < range[0] - rounding || *value > range[1] + rounding) {
    return Fail(field,
                Describe(field),
                std::string(kParameterNames[parameter]) + " in " + FormatRange(range));
  }
  *value = std::clamp(*value, range[0], range[1]);
  return true;
}

bool SceneParser::ReadRegion(const Field& field, bool near_allowed, Region* region) {
  Names sides;
  for (int i = 0; i < 5; ++i) {
    if (HasSide(i)) sides.push_back(kSideNames[i]);
  }
  Names allowed = sides;
  if (near_allowed) allowed.push_back("{near: [x, y, z], radius: r}");
  if (near_allowed && field.node.IsMap()) {
    Map map;
    Field near;
    region->kind = Region::Kind::kNear;
    return OpenMap(field, Join(allowed), &map) && CheckKeys(map, {"near", "radius"}) &&
           Require(map, "near", kVectorAllowed, &near) &&
           ReadNumbers(near, 3, kVectorAllowed, kAny, region->center.data()) &&
           RequireNumber(map, "radius", kNotNegative, &region->radius);
  }
  const std::string allowed_text =
      allowed.empty() ? "no edge, as the surface is closed" : Join(allowed);
  std::string text;
  if (!ReadScalar(field, allowed_text, &text)) return false;
  for (int i = 0; i < 5; ++i) {
    if (text != kSideNames[i]) continue;
    region->kind = static_cast<Region::Kind>(i);
    if (HasSide(i)) return true;
    const std::string why = i == 4 ? "u and v are" : std::string(kParameterNames[i / 2]) + " is";
    return Fail(
        field, Quote(text) + ", which does not exist because " + why + " periodic", allowed_text);
  }
  return Fail(field, Describe(field), allowed_text, NearestName(text, sides));
}

bool SceneParser::ReadPoint(const Field& field, SurfacePoint* point) {
  constexpr char kAllowed[] = "{uv: [u, v]} | {nearest: [x, y, z]}";
  Map map;
  if (!OpenMap(field, kAllowed, &map) || !CheckKeys(map, {"uv", "nearest"})) return false;
  const Field* const uv = map.Find("uv");
  const Field* const nearest = map.Find("nearest");
  if ((uv != nullptr) == (nearest != nullptr)) {
    return Fail(field, uv != nullptr ? "uv and nearest" : "an empty map", kAllowed);
  }
  point->location = Location(uv != nullptr ? *uv : *nearest);
  if (nearest != nullptr) {
    point->kind = SurfacePoint::Kind::kNearest;
    return ReadNumbers(*nearest, 3, kVectorAllowed, kAny, point->nearest.data());
  }
  point->kind = SurfacePoint::Kind::kUv;
  std::vector<Field> items;
  return OpenList(*uv, 2, "a list of two numbers, [u, v]", &items) &&
         ReadParameter(items[0], 0, &point->uv[0]) && ReadParameter(items[1], 1, &point->uv[1]);
}

// ---- Sections -------------------------------------------------------------------------------

bool SceneParser::Parse(const std::string& text) {
  Field root;
  root.path = "scene";
  const std::string problem = TextProblem(text, &root.line);
  if (!problem.empty()) return FailWith(root, problem);
  root.line = 1;
  std::vector<YAML::Node> documents;
  // yaml-cpp reports by exceptions; none may leave this function.
  try {
    // The end mark makes yaml-cpp notice a quote that is never closed.
    documents = YAML::LoadAll(text + "\n...\n");
    if (documents.size() > 1) {
      root.line = std::max(documents[1].Mark().line + 1, 1);
      return Fail(root, "a second YAML document", "one document");
    }
    if (documents.empty() || documents[0].IsNull()) {
      return Fail(root, "an empty file", "a map with the keys name, surface, shell, ...");
    }
    root.node.reset(documents[0]);
    root.line = std::max(root.node.Mark().line + 1, 1);
    return ReadRoot(root);
  } catch (const YAML::Exception& exception) {
    const int lines = static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 1;
    root.line = std::clamp(exception.mark.line + 1, 1, lines);
    return Fail(root, "a YAML mistake (" + Clean(exception.msg) + ")", "valid YAML");
  }
}

template <typename Spec>
bool SceneParser::ReadSection(const Map& map,
                              const std::string& key,
                              bool (SceneParser::*read)(const Field&, Spec*),
                              std::vector<Spec>* specs) {
  const Field* const field = map.Find(key);
  if (field == nullptr) return true;
  std::vector<Field> items;
  if (!OpenList(*field, -1, "a list", &items)) return false;
  for (const Field& item : items) {
    specs->emplace_back();
    if (!(this->*read)(item, &specs->back())) return false;
  }
  return true;
}

bool SceneParser::ReadRoot(const Field& root) {
  Map map;
  if (!OpenMap(root, "a map with the keys name, surface, shell, ...", &map)) return false;
  if (const Field* fingers = map.Find("fingers")) {
    return FailWith(*fingers,
                    "found contact, which is not part of this version; allowed supports and "
                    "loads: " +
                        Join(Kinds(LoadKeys())));
  }
  Field name, surface, shell;
  if (!CheckKeys(map,
                 {"name",
                  "surface",
                  "shell",
                  "model",
                  "supports",
                  "loads",
                  "steps",
                  "probes",
                  "expect"}) ||
      !Require(map, "name", "a text of one line", &name) ||
      !ReadText(name, "a text of one line", &scene_.name) ||
      !Require(map, "surface", "a map with the key kind", &surface) || !ReadSurface(surface) ||
      !Require(map, "shell", "a map with thickness, young_modulus, poisson_ratio", &shell) ||
      !ReadShell(shell)) {
    return false;
  }
  if (const Field* model = map.Find("model")) {
    if (!ReadModel(*model)) return false;
  }
  if (const Field* steps = map.Find("steps")) {
    if (!ReadSteps(*steps)) return false;
  }
  return ReadSection(map, "supports", &SceneParser::ReadSupport, &scene_.supports) &&
         ReadSection(map, "loads", &SceneParser::ReadLoad, &scene_.loads) &&
         ReadSection(map, "probes", &SceneParser::ReadProbe, &scene_.probes) &&
         ReadSection(map, "expect", &SceneParser::ReadExpect, &scene_.expect);
}

bool SceneParser::ReadSurface(const Field& field) {
  const Names kinds = Kinds(SurfaceKeys());
  Map map;
  Field kind;
  scene_.surface.location = Location(field);
  return OpenMap(field, "a map with the key kind", &map) &&
         Require(map, "kind", Join(kinds), &kind) &&
         ReadChoice(kind, kinds, {"implicit", "mesh", "icosphere"}, &scene_.surface.kind) &&
         CheckKindKeys(map,
                       SurfaceKeys(),
                       {"kind", "u", "v", "divisions", "periodic", "grading"},
                       scene_.surface.kind) &&
         ReadShape(map) && ReadGrid(map) && CheckSurface(map);
}

bool SceneParser::ReadShape(const Map& map) {
  const std::string& kind = scene_.surface.kind;
  std::shared_ptr<const ParametricSurface>& surface = scene_.surface.surface;
  if (kind == "plane") {
    surface = MakePlane();
  } else if (kind == "cylinder" || kind == "sphere") {
    double radius;
    if (!RequireNumber(map, "radius", kPositive, &radius)) return false;
    surface = kind == "cylinder" ? MakeCylinder(radius) : MakeSphere(radius);
  } else if (kind == "ellipsoid") {
    constexpr char kAllowed[] = "a list of three numbers > 0, [a, b, c]";
    Field field;
    double axes[3];
    if (!Require(map, "semi_axes", kAllowed, &field) ||
        !ReadNumbers(field, 3, kAllowed, kPositive, axes)) {
      return false;
    }
    surface = MakeEllipsoid(axes[0], axes[1], axes[2]);
  } else if (kind == "torus") {
    constexpr char kAllowed[] = "a list of two numbers, [R, r] with R > r > 0";
    Field field;
    double radii[2];
    if (!Require(map, "radii", kAllowed, &field) ||
        !ReadNumbers(field, 2, kAllowed, kPositive, radii)) {
      return false;
    }
    if (radii[1] >= radii[0]) {
      return Fail(
          field, "R = " + FormatNumber(radii[0]) + ", r = " + FormatNumber(radii[1]), kAllowed);
    }
    surface = MakeTorus(radii[0], radii[1]);
  } else if (kind == "monkey_saddle") {
    double scale;
    if (!RequireNumber(map, "scale", kAny, &scale)) return false;
    surface = MakeMonkeySaddle(scale);
  } else {
    constexpr char kAllowed[] = "a list of three expressions of u and v, [x, y, z]";
    Field field;
    std::vector<Field> items;
    if (!Require(map, "position", kAllowed, &field) || !OpenList(field, 3, kAllowed, &items)) {
      return false;
    }
    std::array<std::string, 3> position;
    std::string mistake;
    for (int i = 0; i < 3; ++i) {
      // Parsed once more below; here each mistake has its own line and key.
      if (!ReadScalar(items[i], "an expression of u and v", &position[i])) return false;
      if (!Expression::Parse(position[i], {"u", "v"}, &mistake)) {
        return Fail(items[i],
                    Describe(items[i]) + " (" + Clean(mistake, 300) + ")",
                    "an expression of u and v");
      }
    }
    surface = MakeExpressionSurface(position, &mistake);
    if (surface == nullptr) return Fail(field, Clean(mistake, 300), kAllowed);
  }
  return true;
}

bool SceneParser::ReadGrid(const Map& map) {
  SurfaceSpec& spec = scene_.surface;
  for (int i = 0; i < 2; ++i) {
    constexpr char kAllowed[] = "a list of two ascending numbers, [lower, upper]";
    std::array<double, 2>& range = i == 0 ? spec.u_range : spec.v_range;
    Field field;
    if (!Require(map, kParameterNames[i], kAllowed, &field) ||
        !ReadNumbers(field, 2, kAllowed, kAny, range.data())) {
      return false;
    }
    const double length = range[1] - range[0];
    const double rounding = 1e-12 * std::max(std::abs(range[0]), std::abs(range[1]));
    if (!(length > rounding) || !std::isfinite(length)) {
      return Fail(field, FormatRange(range), kAllowed);
    }
  }

  Field divisions;
  std::vector<Field> items;
  constexpr char kDivisionsAllowed[] = "a list of two integers > 0, [cells along u, along v]";
  if (!Require(map, "divisions", kDivisionsAllowed, &divisions) ||
      !OpenList(divisions, 2, kDivisionsAllowed, &items) ||
      !ReadInteger(items[0], "an integer > 0", &spec.divisions[0]) ||
      !ReadInteger(items[1], "an integer > 0", &spec.divisions[1])) {
    return false;
  }

  if (const Field* periodic = map.Find("periodic")) {
    if (!OpenList(*periodic, 2, "a list of two of true | false, [u, v]", &items) ||
        !ReadBool(items[0], &spec.periodic[0]) || !ReadBool(items[1], &spec.periodic[1])) {
      return false;
    }
  }
  const std::string allowed = DivisionsAllowed(spec.divisions, spec.periodic);
  if (!allowed.empty()) {
    return Fail(
        divisions,
        "[" + std::to_string(spec.divisions[0]) + ", " + std::to_string(spec.divisions[1]) + "]",
        allowed);
  }

  if (const Field* grading = map.Find("grading")) {
    if (!ReadNumbers(*grading,
                     2,
                     "a list of two numbers in (-1, 1), [u, v]",
                     kGrading,
                     spec.grading.data()) ||
        !OpenList(*grading, 2, "", &items)) {
      return false;
    }
    for (int i = 0; i < 2; ++i) {
      if (spec.periodic[i] && spec.grading[i] != 0.0) {
        return Fail(items[i],
                    Describe(items[i]),
                    std::string("0, because ") + kParameterNames[i] + " is periodic");
      }
    }
  }
  return true;
}

bool SceneParser::CheckSurface(const Map& map) {
  const SurfaceSpec& spec = scene_.surface;
  SurfaceCheck check(spec);
  const Field& shape = *map.Find(spec.kind == "expression" ? "position" : "kind");
  double u, v;
  if (!check.IsFinite(&u, &v)) {
    return Fail(shape,
                "a surface that is not finite or not twice differentiable at " + At(u, v),
                "a smooth surface over the whole range of u and v");
  }
  if (!check.IsRegular(&u, &v)) {
    const std::string where = "sigma_u x sigma_v = 0 at " + At(u, v);
    for (int i = 1; i >= 0; --i) {
      const std::string name = kParameterNames[i];
      const std::array<double, 2>& range = Range(i);
      const bool pole[2] = {check.IsPole(i, 0), check.IsPole(i, 1)};
      if (!pole[0] && !pole[1]) continue;
      const double margin = 0.05 * (range[1] - range[0]);
      return Fail(*map.Find(name),
                  FormatRange(range) + ", which ends in a pole (" + where + ")",
                  "a smaller range that leaves a hole around the pole, e.g. [" +
                      FormatShort(range[0] + (pole[0] ? margin : 0.0)) + ", " +
                      FormatShort(range[1] - (pole[1] ? margin : 0.0)) + "]");
    }
    // Among the named kinds only those with poles in v come here.
    return Fail(spec.kind == "expression" ? shape : *map.Find("v"),
                "a point without tangent plane (" + where + ")",
                "a surface and ranges of u and v with sigma_u x sigma_v != 0 at every point");
  }
  for (int i = 0; i < 2; ++i) {
    std::string difference;
    if (!spec.periodic[i] || check.IsPeriodic(i, &difference)) continue;
    std::vector<Field> items;
    OpenList(*map.Find("periodic"), 2, "", &items);
    return Fail(items[i],
                "true, but " + difference,
                "true only where position and first derivatives agree at both ends, i.e. a range "
                "of one whole period");
  }
  samples_ = check.samples();
  return true;
}

bool SceneParser::ReadShell(const Field& field) {
  ShellSpec& shell = scene_.shell;
  Map map;
  if (!OpenMap(field, "a map with thickness, young_modulus, poisson_ratio", &map) ||
      !CheckKeys(map, {"thickness", "young_modulus", "poisson_ratio", "density"}) ||
      !RequireNumber(map, "thickness", kPositive, &shell.thickness) ||
      !RequireNumber(map, "young_modulus", kPositive, &shell.young_modulus) ||
      !RequireNumber(map, "poisson_ratio", kPoisson, &shell.poisson_ratio)) {
    return false;
  }
  const Field* const density = map.Find("density");
  return density == nullptr || ReadNumber(*density, kNotNegative, &shell.density);
}

bool SceneParser::ReadModel(const Field& field) {
  ModelSpec& model = scene_.model;
  Map map;
  if (!OpenMap(field, "a map", &map) ||
      !CheckKeys(map,
                 {"minimizer", "theory", "strains", "quadrature", "boundary_rule", "accuracy"})) {
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
    } else if (key == "quadrature") {
      valid = ReadInteger(entry, kQuadratureAllowed, &model.quadrature) &&
              (IsQuadrature(model.quadrature) || Fail(entry, Describe(entry), kQuadratureAllowed));
    } else {
      valid = ReadNumber(entry, kFraction, &model.accuracy.emplace());
    }
    if (!valid) return false;
  }
  return true;
}

bool SceneParser::ReadSteps(const Field& field) {
  const std::string allowed = "an integer from 1 to " + std::to_string(kMaxSteps);
  if (!ReadInteger(field, allowed, &scene_.steps)) return false;
  if (scene_.steps >= 1 && scene_.steps <= kMaxSteps) return true;
  return Fail(field, Describe(field), allowed);
}

bool SceneParser::ReadSupport(const Field& field, SupportSpec* support) {
  const Names kinds = {"fix", "clamped", "simply_supported", "symmetry"};
  Map map;
  Field on;
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
  const Field& kind = *map.Find(given[0]);
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

  const Field* const displacement = map.Find("displacement");
  if (displacement == nullptr) return true;
  if (support->kind == SupportSpec::Kind::kSymmetry) {
    return Fail(*displacement,
                "prescribed values on a symmetry plane",
                "with fix, clamped or simply_supported");
  }
  std::vector<Field> items;
  if (!ReadVector(*displacement, SamplesOn(support->on), &support->displacement) ||
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

bool SceneParser::ReadFix(const Field& field, SupportSpec* support) {
  const Names axes(std::begin(kAxisNames), std::end(kAxisNames));
  constexpr char kAllowed[] = "a list of one to three of x, y, z";
  std::vector<Field> items;
  if (!OpenList(field, -1, kAllowed, &items)) return false;
  if (items.empty()) return Fail(field, Describe(field), kAllowed);
  for (const Field& item : items) {
    std::string text;
    if (!ReadChoice(item, axes, {}, &text)) return false;
    bool& fixed = support->fix[text[0] - 'x'];
    if (fixed) return Fail(item, Quote(text) + " a second time", "every component once");
    fixed = true;
  }
  return true;
}

bool SceneParser::ReadSymmetry(const Field& field, SupportSpec* support) {
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
  if (!ReadNumbers(field, 3, kAllowed, kAny, normal.data())) return false;
  const Eigen::Map<Eigen::Vector3d> vector(normal.data());
  if (vector.isZero(0.0)) return Fail(field, "a vector of length zero", kAllowed);
  Eigen::Map<Eigen::Vector3d>(normal.data()).stableNormalize();
  return true;
}

bool SceneParser::ReadAlong(const Field& field, LoadSpec* load) {
  constexpr char kAllowed[] = "{u: number} | {v: number}";
  Map map;
  if (!OpenMap(field, kAllowed, &map) || !CheckKeys(map, {"u", "v"})) return false;
  if (map.entries.size() != 1) {
    return Fail(field, map.entries.empty() ? "an empty map" : "u and v", kAllowed);
  }
  load->line_parameter = map.entries[0].first == "u" ? 0 : 1;
  return ReadParameter(map.entries[0].second, load->line_parameter, &load->line_value);
}

bool SceneParser::ReadLoad(const Field& field, LoadSpec* load) {
  constexpr char kForceAllowed[] = "a list of three numbers or expressions, [x, y, z]";
  const Names kinds = Kinds(LoadKeys());
  Map map;
  Field kind, entry;
  std::string name;
  load->location = Location(field);
  if (!OpenMap(field, "a map with the key kind", &map) ||
      !Require(map, "kind", Join(kinds), &kind) || !ReadChoice(kind, kinds, {"gas"}, &name) ||
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
          !ReadNumbers(entry, 3, kVectorAllowed, kAny, force.data())) {
        return false;
      }
      for (int i = 0; i < 3; ++i) {
        load->force.component[i].expression = Expression::Constant(force[i]);
      }
      return true;
    }
    case LoadSpec::Kind::kPressure: {
      const Field* const follower = map.Find("follower");
      return Require(map, "value", kValueAllowed, &entry) &&
             ReadValue(entry, samples_, &load->value) &&
             (follower == nullptr || ReadBool(*follower, &load->follower));
    }
    case LoadSpec::Kind::kTraction:
      return Require(map, "force", kForceAllowed, &entry) &&
             ReadVector(entry, samples_, &load->force);
    case LoadSpec::Kind::kNormalTraction:
      return Require(map, "value", kValueAllowed, &entry) &&
             ReadValue(entry, samples_, &load->value);
    case LoadSpec::Kind::kEdge: {
      if (!Require(map, "on", "a side or rim", &entry) ||
          !ReadRegion(entry, /*near_allowed=*/false, &load->on)) {
        return false;
      }
      const Field* const force = map.Find("force");
      const Field* const moment = map.Find("moment");
      if (force == nullptr && moment == nullptr) {
        return Fail(field, "neither force nor moment", "one of them or both");
      }
      const std::vector<SurfaceSample> where = SamplesOn(load->on);
      return (force == nullptr || ReadVector(*force, where, &load->force)) &&
             (moment == nullptr || ReadVector(*moment, where, &load->moment));
    }
    case LoadSpec::Kind::kLine:
      return Require(map, "along", "{u: number} | {v: number}", &entry) && ReadAlong(entry, load) &&
             Require(map, "force", kForceAllowed, &entry) &&
             ReadVector(entry, SamplesOnLine(load->line_parameter, load->line_value), &load->force);
    case LoadSpec::Kind::kGravity:
      if (!(scene_.shell.density > 0.0)) {
        return Fail(kind,
                    "gravity with shell.density " + FormatNumber(scene_.shell.density),
                    "gravity only with shell.density > 0");
      }
      return Require(map, "acceleration", kVectorAllowed, &entry) &&
             ReadNumbers(entry, 3, kVectorAllowed, kAny, load->acceleration.data());
  }
  return true;
}

bool SceneParser::ReadProbe(const Field& field, ProbeSpec* probe) {
  constexpr char kAllowed[] = "a name of letters, digits and _ that begins with no digit";
  Map map;
  Field name, at;
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

bool SceneParser::ReadExpect(const Field& field, ExpectSpec* expect) {
  constexpr char kAllowed[] = "a path into summary.json, such as probes.NAME.displacement.z";
  Map map;
  Field quantity;
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
  if (!RequireNumber(map, "value", kAny, &expect->value)) return false;

  const Field* const relative = map.Find("relative_tolerance");
  const Field* const absolute = map.Find("absolute_tolerance");
  if ((relative != nullptr) == (absolute != nullptr)) {
    return Fail(field,
                relative != nullptr ? "two tolerances" : "no tolerance",
                "exactly one of relative_tolerance | absolute_tolerance");
  }
  double tolerance;
  if (!ReadNumber(relative != nullptr ? *relative : *absolute, kPositive, &tolerance)) {
    return false;
  }
  (relative != nullptr ? expect->relative_tolerance : expect->absolute_tolerance) = tolerance;
  if (relative != nullptr && expect->value == 0.0) {
    return Fail(*relative, "a relative tolerance of the value 0", "absolute_tolerance");
  }
  const Field* const source = map.Find("source");
  return source == nullptr || ReadText(*source, "a text of one line", &expect->source);
}

}  // namespace

bool ReadScene(const std::string& file, Scene* scene, std::string* error) {
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
  std::string text(kMaxFileBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return fail("reading failed");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return ParseScene(text, file, scene, error);
}

bool ParseScene(const std::string& text,
                const std::string& file,
                Scene* scene,
                std::string* error) {
  SceneParser parser(file);
  if (!parser.Parse(text)) {
    *error = parser.error();
    return false;
  }
  *scene = parser.scene();
  return true;
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

std::string NearestName(const std::string& found, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxLength = 64;  // Nobody misspells a longer name.
  if (found.size() > kMaxLength) return "";
  std::string nearest;
  std::size_t smallest = std::min(found.size(), std::max<std::size_t>(found.size() / 3, 1) + 1);
  for (const std::string& name : known) {
    // Levenshtein's distance, one row at a time.
    std::vector<std::size_t> row(name.size() + 1);
    for (std::size_t j = 0; j <= name.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= found.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= name.size(); ++j) {
        const std::size_t substituted = diagonal + (found[i - 1] == name[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
      }
    }
    if (row.back() < smallest) {
      smallest = row.back();
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace darboux
