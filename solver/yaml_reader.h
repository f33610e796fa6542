#ifndef DARBOUX_SOLVER_YAML_READER_H_
#define DARBOUX_SOLVER_YAML_READER_H_

#include <yaml-cpp/yaml.h>

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "solver/scene.h"

// Strict access to the YAML of a scene: unknown and repeated keys, types, numbers, and the form of
// messages. Part of the scene reader, not installed.

namespace darboux {

using Names = std::vector<std::string>;

constexpr std::size_t kMaxSceneBytes = 1 << 20;

// ---- Words of messages ----------------------------------------------------------------------

std::string Join(const Names& names, const std::string& separator = " | ");

// For quoting in a one-line message: control characters as '?', long texts cut.
std::string Clean(const std::string& text, std::size_t max_bytes = 60);
std::string Quote(const std::string& text);

// The shortest text that reads back as the same number.
std::string FormatNumber(double value);
// Four significant digits.
std::string FormatShort(double value);
std::string FormatRange(const std::array<double, 2>& range);

// What was found; what is allowed [; did you mean 'NEAREST'?]
std::string Problem(const std::string& found,
                    const std::string& allowed,
                    const std::string& nearest = "");

// Whether `found` is one of the available names; if not, why. `missing` are names of the scene
// format that this version does not have yet.
bool IsChoice(const std::string& found,
              const Names& available,
              const Names& missing,
              std::string* problem);

enum class NumberSyntax { kNumber, kNonFinite, kNoNumber };

// Decimal numbers as in YAML 1.2, independent of the locale.
NumberSyntax ParseNumber(const std::string& text, double* value);
bool ParseInteger(const std::string& text, int* value);

// ---- The file -------------------------------------------------------------------------------

// A value of the file and where it stands.
struct YamlField {
  YamlField() = default;
  YamlField(const YamlField&) = default;
  // YAML::Node's own assignment would change the tree: whatever refers to the node assigned to
  // would from then on refer to the other one.
  YamlField& operator=(const YamlField& other) {
    path = other.path;
    node.reset(other.node);
    line = other.line;
    return *this;
  }

  std::string path;
  YAML::Node node;
  int line = 1;
};

struct YamlMap {
  YamlField self;
  std::vector<std::pair<std::string, YamlField>> entries;

  const YamlField* Find(const std::string& key) const {
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

inline constexpr NumberRule kAnyNumber{"a number", [](double) { return true; }};
inline constexpr NumberRule kPositiveNumber{"a number > 0", [](double x) { return x > 0.0; }};
inline constexpr NumberRule kNotNegativeNumber{"a number >= 0", [](double x) { return x >= 0.0; }};

// The keys that each kind has besides the common ones.
using KindKeys = std::vector<std::pair<std::string, Names>>;

Names Kinds(const KindKeys& keys);

// Building blocks of a reader of one file: each checks the type of a field and gives its content;
// on a mistake it returns false and sets the message, FILE:LINE: KEY: problem.
class YamlReader {
 public:
  const std::string& error() const { return error_; }

 protected:
  explicit YamlReader(const std::string& file) : file_(file) {}
  ~YamlReader() = default;

  // Checks the text, parses it and hands its root to `read`, from which yaml-cpp may throw.
  bool ReadDocument(const std::string& text,
                    const std::string& allowed,
                    const std::function<bool(const YamlField& root)>& read);

  // Both return false.
  bool FailWith(const YamlField& field, const std::string& problem);
  bool Fail(const YamlField& field,
            const std::string& found,
            const std::string& allowed,
            const std::string& nearest = "") {
    return FailWith(field, Problem(found, allowed, nearest));
  }

  SceneLocation Location(const YamlField& field) const { return {file_, field.line, field.path}; }

  // The field in the words of a message.
  static std::string Describe(const YamlField& field);

  bool CheckTag(const YamlField& field);
  bool OpenMap(const YamlField& field, const std::string& allowed, YamlMap* map);
  bool CheckKeys(const YamlMap& map, const Names& known);
  bool CheckKindKeys(const YamlMap& map,
                     const KindKeys& table,
                     const Names& common,
                     const std::string& kind);
  bool Require(const YamlMap& map,
               const std::string& key,
               const std::string& allowed,
               YamlField* field);
  bool OpenList(const YamlField& field,
                int size,  // -1: any
                const std::string& allowed,
                std::vector<YamlField>* items);
  bool ReadScalar(const YamlField& field, const std::string& allowed, std::string* text);
  bool ReadText(const YamlField& field, const std::string& allowed, std::string* text);
  bool ReadChoice(const YamlField& field,
                  const Names& available,
                  const Names& missing,
                  std::string* text);
  bool ReadBool(const YamlField& field, bool* value);
  bool ReadInteger(const YamlField& field, const std::string& allowed, int* value);
  // A number or a constant expression.
  bool ReadNumber(const YamlField& field, const NumberRule& rule, double* value);
  bool ReadNumbers(const YamlField& field,
                   int size,
                   const std::string& allowed,
                   const NumberRule& rule,
                   double* values);
  bool RequireNumber(const YamlMap& map,
                     const std::string& key,
                     const NumberRule& rule,
                     double* value);

 private:
  const std::string file_;
  std::string error_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_YAML_READER_H_
