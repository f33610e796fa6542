#include "solver/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

#include "geometry/expression.h"
#include "geometry/nearest_name.h"

namespace darboux {
namespace {

// Empty, or why yaml-cpp shall not see the text: it would stop at some control characters without
// a word and let directives pass. Sets *line (1-based).
std::string TextProblem(const std::string& text, int* line) {
  if (text.size() > kMaxSceneBytes) {
    *line = 1;
    return Problem("more than " + std::to_string(kMaxSceneBytes) + " bytes",
                   "a scene of at most " + std::to_string(kMaxSceneBytes) + " bytes");
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

}  // namespace

// ---- Words ----------------------------------------------------------------------------------

std::string Join(const Names& names, const std::string& separator) {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text;
}

std::string Clean(const std::string& text, std::size_t max_bytes) {
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
                    const std::string& nearest) {
  std::string text = "found " + found + "; allowed " + allowed;
  if (!nearest.empty()) text += "; did you mean '" + nearest + "'?";
  return text;
}

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

namespace {

// Where the documents of a text begin; the parts of a document do not matter.
class DocumentStarts : public YAML::EventHandler {
 public:
  const std::vector<YAML::Mark>& marks() const { return marks_; }

  void OnDocumentStart(const YAML::Mark&) override { begins_ = true; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { Note(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { Note(mark); }
  void OnScalar(const YAML::Mark& mark,
                const std::string&,
                YAML::anchor_t,
                const std::string&) override {
    Note(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string&,
                       YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    Note(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark,
                  const std::string&,
                  YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    Note(mark);
  }
  void OnMapEnd() override {}

 private:
  void Note(const YAML::Mark& mark) {
    if (begins_) marks_.push_back(mark);
    begins_ = false;
  }

  bool begins_ = false;
  std::vector<YAML::Mark> marks_;
};

}  // namespace

// ---- The reader -----------------------------------------------------------------------------

Names Kinds(const KindKeys& keys) {
  Names kinds;
  for (const auto& entry : keys) kinds.push_back(entry.first);
  return kinds;
}

bool YamlReader::ReadDocument(const std::string& text,
                              const std::string& allowed,
                              const std::function<bool(const YamlField&)>& read) {
  YamlField root;
  root.path = "scene";
  const std::string problem = TextProblem(text, &root.line);
  if (!problem.empty()) return FailWith(root, problem);
  root.line = 1;
  // The end mark makes yaml-cpp notice a quote that is never closed.
  const std::string marked = text + "\n...\n";
  // yaml-cpp reports by exceptions; none may leave this function.
  try {
    // Not LoadAll: some texts, as one that begins with a comma, are empty documents without end to
    // it. Two are enough to know.
    DocumentStarts starts;
    std::istringstream stream(marked);
    YAML::Parser parser(stream);
    for (int i = 0; i < 2 && parser.HandleNextDocument(starts); ++i) {
    }
    const std::vector<YAML::Mark>& marks = starts.marks();
    if (marks.size() > 1) {
      root.line = std::max(marks[1].line + 1, 1);
      if (marks[1].pos == marks[0].pos) {
        return Fail(root, "a YAML mistake (text that is part of nothing)", "valid YAML");
      }
      return Fail(root, "a second YAML document", "one document");
    }
    const YAML::Node document = marks.empty() ? YAML::Node() : YAML::Load(marked);
    if (document.IsNull()) return Fail(root, "an empty file", allowed);
    root.node.reset(document);
    root.line = std::max(root.node.Mark().line + 1, 1);
    return read(root);
  } catch (const YAML::Exception& exception) {
    const int lines = static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 1;
    root.line = std::clamp(exception.mark.line + 1, 1, lines);
    return Fail(root, "a YAML mistake (" + Clean(exception.msg) + ")", "valid YAML");
  }
}

bool YamlReader::FailWith(const YamlField& field, const std::string& problem) {
  error_ = file_ + ":" + std::to_string(field.line) + ": " + field.path + ": " + problem;
  return false;
}

std::string YamlReader::Describe(const YamlField& field) {
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

bool YamlReader::CheckTag(const YamlField& field) {
  const std::string& tag = field.node.Tag();
  if (tag.empty() || tag == "?" || tag == "!") return true;
  return Fail(field, "the tag " + Quote(tag), "values without YAML tags");
}

bool YamlReader::OpenMap(const YamlField& field, const std::string& allowed, YamlMap* map) {
  if (!field.node.IsMap()) return Fail(field, Describe(field), allowed);
  if (!CheckTag(field)) return false;
  map->self = field;
  map->entries.clear();
  std::map<std::string, int> seen;  // Line of each key.
  for (const auto& entry : field.node) {
    YamlField key = field;
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

bool YamlReader::CheckKeys(const YamlMap& map, const Names& known) {
  for (const auto& [name, field] : map.entries) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    return Fail(field, "an unknown key", Join(known), NearestName(name, known));
  }
  return true;
}

bool YamlReader::CheckKindKeys(const YamlMap& map,
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

bool YamlReader::Require(const YamlMap& map,
                         const std::string& key,
                         const std::string& allowed,
                         YamlField* field) {
  if (const YamlField* found = map.Find(key)) {
    *field = *found;
    return true;
  }
  field->path = map.self.path == "scene" ? key : map.self.path + "." + key;
  field->line = map.self.line;
  return Fail(*field, "no such key, which is required", allowed);
}

bool YamlReader::OpenList(const YamlField& field,
                          int size,
                          const std::string& allowed,
                          std::vector<YamlField>* items) {
  if (!field.node.IsSequence() || (size >= 0 && static_cast<int>(field.node.size()) != size)) {
    return Fail(field, Describe(field), allowed);
  }
  if (!CheckTag(field)) return false;
  items->clear();
  for (const auto& node : field.node) {
    YamlField item;
    item.path = field.path + "[" + std::to_string(items->size()) + "]";
    item.node.reset(node);
    item.line = node.IsNull() ? field.line : std::max(field.line, node.Mark().line + 1);
    items->push_back(item);
  }
  return true;
}

bool YamlReader::ReadScalar(const YamlField& field, const std::string& allowed, std::string* text) {
  if (!field.node.IsScalar()) return Fail(field, Describe(field), allowed);
  if (!CheckTag(field)) return false;
  *text = field.node.Scalar();
  return true;
}

bool YamlReader::ReadText(const YamlField& field, const std::string& allowed, std::string* text) {
  if (!ReadScalar(field, allowed, text)) return false;
  const bool control = std::any_of(
      text->begin(), text->end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; });
  return text->empty() || control ? Fail(field, Describe(field), allowed) : true;
}

bool YamlReader::ReadChoice(const YamlField& field,
                            const Names& available,
                            const Names& missing,
                            std::string* text) {
  std::string problem;
  return ReadScalar(field, Join(available), text) &&
         (IsChoice(*text, available, missing, &problem) || FailWith(field, problem));
}

bool YamlReader::ReadBool(const YamlField& field, bool* value) {
  std::string text;
  if (!ReadScalar(field, "true | false", &text)) return false;
  *value = text == "true";
  if (field.node.Tag() != "!" && (*value || text == "false")) return true;
  return Fail(field, Describe(field), "true | false");
}

bool YamlReader::ReadInteger(const YamlField& field, const std::string& allowed, int* value) {
  std::string text;
  if (!ReadScalar(field, allowed, &text)) return false;
  if (field.node.Tag() != "!" && ParseInteger(text, value)) return true;
  return Fail(field, Describe(field), allowed);
}

bool YamlReader::ReadNumber(const YamlField& field, const NumberRule& rule, double* value) {
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

bool YamlReader::ReadNumbers(const YamlField& field,
                             int size,
                             const std::string& allowed,
                             const NumberRule& rule,
                             double* values) {
  std::vector<YamlField> items;
  if (!OpenList(field, size, allowed, &items)) return false;
  for (int i = 0; i < size; ++i) {
    if (!ReadNumber(items[i], rule, &values[i])) return false;
  }
  return true;
}

bool YamlReader::RequireNumber(const YamlMap& map,
                               const std::string& key,
                               const NumberRule& rule,
                               double* value) {
  YamlField field;
  return Require(map, key, rule.allowed, &field) && ReadNumber(field, rule, value);
}

}  // namespace darboux
