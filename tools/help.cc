#include "tools/help.h"

#include <opensubdiv/version.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "tools/manual.h"

namespace darboux {
namespace {

struct Group {
  const char* name;   // in the flags' texts
  const char* title;  // in the help
  const char* intro;  // what all of its flags have in common; may be empty
};

// In the order of the help.
constexpr Group kGroups[] = {
    {"input", "Input", ""},
    {"model", "Model", "In place of what the scene says; its file stays as it is."},
    {"mesh", "Mesh", ""},
    {"sampling", "Points and viewpoints", ""},
    {"errors", "Errors of the scanner", ""},
    {"frame", "Frame of the scanner", ""},
    {"registration", "Registration", ""},
    {"fit", "Fit", ""},
    {"study", "Study", ""},
    {"solver", "Solver", ""},
    {"output", "Output", ""},
};

constexpr const char* kTools[] = {"darboux_accuracy",
                                  "darboux_calibrate",
                                  "darboux_deform",
                                  "darboux_duck",
                                  "darboux_fit",
                                  "darboux_scan"};

// The four parts of a flag's text.
struct FlagText {
  std::string group, value, range, text;
};

FlagText Split(const std::string& description) {
  std::array<std::string, 4> parts;
  size_t begin = 0;
  for (size_t i = 0; i < 4; ++i) {
    // Of two bars in a row the space between belongs to both: "group | | | text".
    const size_t end = i < 3 ? description.find(" | ", begin) : description.size();
    if (end == std::string::npos) return {"", "", "", description};
    const size_t first = begin == 0 ? 0 : begin + 1;
    if (end > first) parts[i] = description.substr(first, end - first);
    begin = end + 2;
  }
  return {parts[0], parts[1], parts[2], parts[3]};
}

bool Contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

std::string DefaultOf(const gflags::CommandLineFlagInfo& flag) {
  if (flag.type == "bool") return flag.default_value == "true" ? "on" : "off";
  if (flag.type != "double") return flag.default_value;
  char text[32];  // gflags prints 17 digits.
  std::snprintf(text, sizeof(text), "%g", std::strtod(flag.default_value.c_str(), nullptr));
  return text;
}

// "integer, 0 to 12; default: 5"
std::string TypeLine(const gflags::CommandLineFlagInfo& flag, const std::string& range) {
  std::string line = flag.type == "bool"     ? "switch"
                     : flag.type == "double" ? "number"
                     : flag.type == "int32"  ? "integer"
                     : range.empty()         ? "text"
                                             : "";
  if (!range.empty()) line += (line.empty() ? "" : ", ") + range;
  const std::string value = DefaultOf(flag);
  if (!value.empty() && !Contains(range, "default") && !Contains(range, "required")) {
    line += "; default: " + value;
  }
  return line;
}

void AddItems(const char* title, const HelpItems& items, Manual* manual) {
  if (items.begin() == items.end()) return;
  manual->Section(title);
  for (const HelpItem& item : items) manual->Item(item.term, "", "", item.text);
}

void AddFlags(const Tool& tool, Manual* manual) {
  manual->Section("OPTIONS");
  manual->Paragraph(
      "--flag=VALUE or --flag VALUE; a switch is --flag, or --noflag to turn it off. After -- all "
      "are arguments.");
  const std::vector<gflags::CommandLineFlagInfo> flags = OwnFlags(tool);
  const auto add = [&](const char* title, const char* intro, const auto& belongs) {
    bool first = true;
    for (const gflags::CommandLineFlagInfo& flag : flags) {
      FlagText text = Split(flag.description);
      if (!belongs(text.group)) continue;
      if (first) {
        manual->Subsection(title);
        manual->Paragraph(intro);
        first = false;
      }
      if (text.value.empty() && flag.type != "bool") {
        text.value = flag.type == "double" ? "NUMBER" : flag.type == "int32" ? "INTEGER" : "TEXT";
      }
      manual->Item("--" + flag.name, text.value, TypeLine(flag, text.range), text.text);
    }
  };
  for (const Group& group : kGroups) {
    add(group.title, group.intro, [&](const std::string& name) { return name == group.name; });
  }
  add("Other", "", [](const std::string& name) {
    return std::none_of(std::begin(kGroups), std::end(kGroups), [&](const Group& group) {
      return name == group.name;
    });
  });
  manual->Subsection("General");
  manual->Item("--help", "", "", "Prints this manual; -h as well. --help=man: as a page for man.");
  manual->Item("--version", "", "", "Prints the version, and those of the libraries in use.");
}

Manual MakeManual(const Tool& tool) {
  Manual manual;
  manual.Section("NAME");
  manual.Name(tool.name, tool.purpose);
  manual.Section("SYNOPSIS");
  manual.Synopsis(tool.name, tool.usage);
  manual.Synopsis(tool.name, "--help | --help=man | --version");
  manual.Section("DESCRIPTION");
  manual.Paragraph(tool.description);
  AddItems("ARGUMENTS", tool.arguments, &manual);
  AddFlags(tool, &manual);
  AddItems("FILES", tool.files, &manual);
  AddItems("EXIT STATUS", tool.exit_statuses, &manual);
  if (tool.signals[0] != '\0') {
    manual.Section("SIGNALS");
    manual.Paragraph(tool.signals);
  }
  manual.Section("ENVIRONMENT");
  manual.Item("NO_COLOR", "", "", "Where it is set, this manual has no bold letters.");
  if (std::strcmp(tool.name, "darboux_duck") != 0) {
    manual.Item("OPENBLAS_NUM_THREADS",
                "",
                "",
                "Threads of OpenBLAS within a factorisation. 1 makes runs side by side, and times, "
                "steadier.");
  }
  if (tool.examples.begin() != tool.examples.end()) {
    manual.Section("EXAMPLES");
    manual.Paragraph(
        "In the folder of the project, with build/tools, or where it is installed, on the PATH:");
    for (const HelpItem& example : tool.examples) manual.Command(example.term, example.text);
  }
  manual.Section("SEE ALSO");
  std::string others;
  for (const char* name : kTools) {
    if (std::strcmp(name, tool.name) == 0) continue;
    others += (others.empty() ? "" : ", ") + std::string(name) + "(1)";
  }
  manual.Paragraph(others);
  manual.Paragraph(
      "README.md: methods, accuracy, times. data/README.md: every key of the files that are read "
      "and of those that are written.");
  return manual;
}

}  // namespace

std::vector<gflags::CommandLineFlagInfo> OwnFlags(const Tool& tool) {
  std::vector<gflags::CommandLineFlagInfo> all, own;
  gflags::GetAllFlags(&all);
  const std::string without = "," + std::string(tool.without_flags) + ",";
  for (const gflags::CommandLineFlagInfo& flag : all) {
    // ".../tools/solver_flags.cc"; flags of glog and gflags are in folders called src.
    const size_t slash = flag.filename.rfind('/');
    if (slash == std::string::npos || Contains(without, ("," + flag.name + ",").c_str())) continue;
    const std::string folder = "/" + flag.filename.substr(0, slash);
    if (folder.size() >= 6 && folder.compare(folder.size() - 6, 6, "/tools") == 0) {
      own.push_back(flag);
    }
  }
  std::sort(own.begin(), own.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return own;
}

std::string HelpText(const Tool& tool, bool bold) { return MakeManual(tool).Text(bold); }

std::string ManPage(const Tool& tool) { return MakeManual(tool).Roff(tool.name, DARBOUX_VERSION); }

bool WantsBold(std::FILE* to) {
  const char* const no_color = std::getenv("NO_COLOR");
  if (no_color != nullptr && no_color[0] != '\0') return false;
  const char* const terminal = std::getenv("TERM");
  return isatty(fileno(to)) == 1 && terminal != nullptr && std::strcmp(terminal, "dumb") != 0;
}

std::string VersionText(const Tool& tool) {
  char text[160];
  std::snprintf(text,
                sizeof(text),
                "%s %s\nEigen %d.%d.%d, OpenSubdiv %d.%d.%d",
                tool.name,
                DARBOUX_VERSION,
                EIGEN_WORLD_VERSION,
                EIGEN_MAJOR_VERSION,
                EIGEN_MINOR_VERSION,
                OPENSUBDIV_VERSION_MAJOR,
                OPENSUBDIV_VERSION_MINOR,
                OPENSUBDIV_VERSION_PATCH);
  return text;
}

}  // namespace darboux
