#include "tools/command_line.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iterator>
#include <new>

#include "geometry/nearest_name.h"

namespace darboux {
namespace {

// Of glog's flags those that cannot write a file.
constexpr const char* kLoggingFlags[] = {
    "v", "vmodule", "minloglevel", "logtostderr", "stderrthreshold", "colorlogtostderr"};

std::string Allowed(const std::string& type) {
  if (type == "bool") return "true or false";
  if (type == "double") return "a number";
  if (type == "string") return "a text";
  return "an integer";
}

}  // namespace

void PrintUsage(const Tool& tool) {
  std::fprintf(stderr, "usage: %s %s\n", tool.name, tool.usage);
  std::fprintf(stderr, "(--help lists the flags)\n");
}

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

bool ParseWords(const Tool& tool,
                const std::string& versions,
                const std::vector<std::string>& words,
                std::vector<std::string>* arguments,
                std::string* error) {
  error->clear();
  const std::vector<gflags::CommandLineFlagInfo> own = OwnFlags(tool);
  std::vector<std::string> own_names, known;
  for (const gflags::CommandLineFlagInfo& flag : own) own_names.push_back(flag.name);
  known = own_names;
  known.insert(known.end(), std::begin(kLoggingFlags), std::end(kLoggingFlags));
  const auto is_known = [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  const auto fail = [&](const std::string& message) {
    *error = message;
    return false;
  };

  // Help is given whatever else the line says.
  for (const std::string& word : words) {
    if (word == "--") break;
    if (word == "--help" || word == "-help" || word == "--h" || word == "-h") {
      std::fputs(HelpText(tool, WantsBold(stdout)).c_str(), stdout);
      return false;
    }
    if (word == "--help=man" || word == "-help=man") {
      std::fputs(ManPage(tool).c_str(), stdout);
      return false;
    }
    if (word == "--version" || word == "-version") {
      std::printf("%s%s\n", VersionText(tool).c_str(), versions.c_str());
      return false;
    }
  }

  arguments->clear();
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--") {
      arguments->insert(arguments->end(), words.begin() + i + 1, words.end());
      break;
    }
    if (word.size() < 2 || word[0] != '-') {
      arguments->push_back(word);
      continue;
    }
    const size_t begin = word[1] == '-' ? 2 : 1;
    const size_t equals = std::min(word.find('='), word.size());
    std::string name = word.substr(begin, equals - begin);
    std::string value = equals < word.size() ? word.substr(equals + 1) : "";
    gflags::CommandLineFlagInfo info;
    if (!is_known(name) && name.compare(0, 2, "no") == 0 && is_known(name.substr(2)) &&
        equals == word.size() && gflags::GetCommandLineFlagInfo(name.substr(2).c_str(), &info) &&
        info.type == "bool") {
      name = name.substr(2);
      value = "false";
    } else if (!is_known(name) || !gflags::GetCommandLineFlagInfo(name.c_str(), &info)) {
      std::vector<std::string> similar = known;
      similar.insert(similar.end(), {"help", "version"});
      const std::string nearest = NearestName(name, similar);
      std::string list;
      for (const std::string& flag : own_names) list += (list.empty() ? "--" : ", --") + flag;
      return fail("found the unknown flag '" + word + "'; allowed " + list +
                  (nearest.empty() ? std::string() : "; did you mean '--" + nearest + "'?"));
    } else if (equals == word.size()) {
      if (info.type == "bool") {
        value = "true";
      } else {
        // A flag in the place of the value has swallowed it; a negative number is one.
        const bool has_value =
            i + 1 < words.size() && (words[i + 1].empty() || words[i + 1][0] != '-' ||
                                     words[i + 1].find_first_of(".0123456789") == 1);
        if (!has_value)
          return fail("--" + name + ": found no value; allowed " + Allowed(info.type));
        value = words[++i];
      }
    }
    if (gflags::SetCommandLineOption(name.c_str(), value.c_str()).empty()) {
      return fail("--" + name + ": found '" + value + "'; allowed " + Allowed(info.type));
    }
  }
  if (static_cast<int>(arguments->size()) != tool.num_arguments) {
    std::string found = arguments->empty() ? "no argument" : "the arguments";
    for (const std::string& argument : *arguments) found += " '" + argument + "'";
    return fail("found " + found + "; allowed exactly " + std::to_string(tool.num_arguments));
  }
  return true;
}

int RunAndCatch(int (*run)(int argc, char** argv), int argc, char** argv, std::string* error) {
  error->clear();
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    *error = "out of memory; fewer divisions or points need less";
  } catch (const std::exception& exception) {
    *error = std::string("internal error: ") + exception.what();
  }
  return kExitNotConverged;
}

}  // namespace darboux
