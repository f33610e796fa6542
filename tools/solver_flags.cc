#include "tools/solver_flags.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <new>
#include <thread>

#include "geometry/nearest_name.h"
#include "solver/scene_reader.h"
#include "tools/progress.h"

DEFINE_string(out, "", "Folder for all results; created when missing.");
DEFINE_int32(threads, 0, "Threads, 1 to 1024; 0 for as many as the machine runs at once.");
DEFINE_string(theory, "", "auto, linear or nonlinear, in place of the scene's model.theory.");
DEFINE_string(strains, "", "koiter or seed, in place of the scene's model.strains.");
DEFINE_string(minimizer, "", "auto, mip, ceres or cg, in place of the scene's model.minimizer.");
DEFINE_int32(quadrature,
             0,
             "Points per triangle: 1, 3, 6 or 12, in place of the scene's model.quadrature.");
DEFINE_string(divisions, "", "M,N cells in u and v, in place of the scene's surface.divisions.");
DEFINE_bool(
    repair,
    false,
    "Mend the scene's mesh file before use: sew seams, drop or flatten what is no triangle, "
    "wind triangles alike and outwards. What was done is printed and kept in the results.");
DEFINE_double(time_limit,
              0.0,
              "Seconds after which the solver stops and what it has is written; 0 for no limit.");
DEFINE_bool(quiet, false, "Print nothing but errors.");
DEFINE_string(log,
              "text",
              "text, or json: every line on stderr, progress and errors, is a JSON object.");
DEFINE_string(sparse_backend,
              "auto",
              "Sparse factorisation: suite_sparse, eigen (slower, runs no GPL code), or auto: "
              "suite_sparse where Ceres has it.");
DEFINE_double(gradient_tolerance,
              1e-7,
              "A load step has converged when |gradient| is at most this, in (0, 1), times "
              "|loads| + |reactions|.");
DEFINE_int32(max_iterations, 200, "Iterations per load step, at least 1.");

namespace darboux {
namespace {

// Of glog's flags those that cannot write a file.
constexpr const char* kLoggingFlags[] = {
    "v", "vmodule", "minloglevel", "logtostderr", "stderrthreshold", "colorlogtostderr"};

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// Flags defined here or in the tool's own file, by name.
std::vector<gflags::CommandLineFlagInfo> OwnFlags(const Tool& tool) {
  std::vector<gflags::CommandLineFlagInfo> all, own;
  gflags::GetAllFlags(&all);
  for (const gflags::CommandLineFlagInfo& flag : all) {
    if (EndsWith(flag.filename, "tools/solver_flags.cc") ||
        EndsWith(flag.filename, "tools/" + std::string(tool.name) + ".cc")) {
      own.push_back(flag);
    }
  }
  std::sort(own.begin(), own.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return own;
}

std::string Allowed(const std::string& type) {
  if (type == "bool") return "true or false";
  if (type == "double") return "a number";
  if (type == "string") return "a text";
  return "an integer";
}

// Empty where the flag says all there is to say: nothing, or 0 with a meaning of its own.
std::string DefaultOf(const gflags::CommandLineFlagInfo& flag) {
  if (flag.type == "bool" || flag.default_value.empty() || flag.default_value == "0") return "";
  if (flag.type != "double") return flag.default_value;
  char text[32];  // gflags prints 17 digits.
  std::snprintf(text, sizeof(text), "%g", std::strtod(flag.default_value.c_str(), nullptr));
  return text;
}

void PrintUsage(const Tool& tool, std::FILE* to) {
  std::fprintf(to, "usage: %s %s\n", tool.name, tool.usage);
}

void PrintHelp(const Tool& tool) {
  PrintUsage(tool, stdout);
  std::printf("\n%s\n\nflags:\n", tool.description);
  for (const gflags::CommandLineFlagInfo& flag : OwnFlags(tool)) {
    std::string left = "  --" + flag.name;
    if (flag.type == "string") left += "=TEXT";
    if (flag.type == "double") left += "=NUMBER";
    if (flag.type == "int32") left += "=INTEGER";
    std::printf("%s\n", left.c_str());
    // Words in lines of at most 96 columns.
    std::string text = flag.description;
    const std::string default_value = DefaultOf(flag);
    if (!default_value.empty()) text += " Default: " + default_value + ".";
    size_t column = 0;
    for (size_t begin = 0; begin < text.size();) {
      const size_t end = std::min(text.find(' ', begin), text.size());
      const size_t width = end - begin;
      if (column > 0 && column + 1 + width > 96) {
        std::printf("\n");
        column = 0;
      }
      column += std::printf(
          "%s%.*s", column == 0 ? "      " : " ", static_cast<int>(width), text.c_str() + begin);
      begin = end + 1;
    }
    std::printf("\n");
  }
  std::printf("  --help, --version\n");
}

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

std::atomic<bool> stop_flag(false);
static_assert(std::atomic<bool>::is_always_lock_free, "signal handlers may touch nothing else");

void OnSignal(int) {
  stop_flag.store(true);
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

bool ParseCommandLine(const Tool& tool,
                      int argc,
                      char** argv,
                      std::vector<std::string>* arguments,
                      int* exit_status) {
  const std::vector<gflags::CommandLineFlagInfo> own = OwnFlags(tool);
  std::vector<std::string> own_names, known;
  for (const gflags::CommandLineFlagInfo& flag : own) own_names.push_back(flag.name);
  known = own_names;
  known.insert(known.end(), std::begin(kLoggingFlags), std::end(kLoggingFlags));
  const auto is_known = [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const auto fail = [&](const std::string& message) {
    *exit_status = kExitBadInput;
    const bool json = progress::AsksForJson(words);
    progress::Error(tool.name, message, json);
    if (json) return false;
    PrintUsage(tool, stderr);
    std::fprintf(stderr, "(--help lists the flags)\n");
    return false;
  };

  // Help is given whatever else the line says.
  for (const std::string& word : words) {
    if (word == "--") break;
    if (word == "--help" || word == "-help" || word == "--h" || word == "-h") {
      PrintHelp(tool);
      *exit_status = kExitDone;
      return false;
    }
    if (word == "--version" || word == "-version") {
      std::printf("%s %s\n", tool.name, DARBOUX_VERSION);
      *exit_status = kExitDone;
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
      const std::string nearest = NearestName(name, known);
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

  // glog, and no file of its: it would write to the folder for temporary files.
  if (!IsGiven("minloglevel")) {
    FLAGS_minloglevel = FLAGS_quiet   ? google::GLOG_ERROR
                        : FLAGS_v > 0 ? google::GLOG_INFO
                                      : google::GLOG_WARNING;
  }
  FLAGS_logtostderr = true;
  google::InitGoogleLogging(tool.name);
  if (FLAGS_log != "text" && FLAGS_log != "json") {
    return fail("--log: found '" + FLAGS_log + "'; allowed text | json");
  }

  if (static_cast<int>(arguments->size()) != tool.num_arguments) {
    std::string found = arguments->empty() ? "no argument" : "the arguments";
    for (const std::string& argument : *arguments) found += " '" + argument + "'";
    return fail("found " + found + "; allowed exactly " + std::to_string(tool.num_arguments));
  }
  if (FLAGS_out.empty()) return fail("--out: found no folder; allowed the name of a folder");
  progress::Start(tool.name, DARBOUX_VERSION, words);
  return true;
}

int RunTool(const Tool& tool, int (*run)(int argc, char** argv), int argc, char** argv) {
  try {
    return progress::Done(run(argc, argv));
  } catch (const std::bad_alloc&) {
    progress::Error(
        tool.name, "out of memory; fewer divisions or points need less", progress::IsJson());
  } catch (const std::exception& exception) {
    progress::Error(
        tool.name, std::string("internal error: ") + exception.what(), progress::IsJson());
  }
  return progress::Done(kExitNotConverged);
}

bool ReadSceneWithFlags(const std::string& file, Scene* scene, std::string* error) {
  ReadOptions options;
  options.repair = FLAGS_repair;
  if (!ReadScene(file, scene, error, options)) return false;
  if (!FLAGS_quiet) {
    for (const std::string& line : scene->surface.mended) {
      progress::Say("repair", {{"text", line}}, line);
    }
  }
  return true;
}

bool ApplyFlags(Scene* scene, std::vector<std::string>* overridden, std::string* error) {
  SceneOverrides overrides;
  overridden->clear();
  const auto is_given = [overridden](const char* flag) {
    if (!IsGiven(flag)) return false;
    overridden->push_back("--" + std::string(flag));
    return true;
  };
  if (is_given("divisions")) overrides.divisions = FLAGS_divisions;
  if (is_given("theory")) overrides.theory = FLAGS_theory;
  if (is_given("strains")) overrides.strains = FLAGS_strains;
  if (is_given("quadrature")) overrides.quadrature = FLAGS_quadrature;
  if (is_given("minimizer")) overrides.minimizer = FLAGS_minimizer;
  return ApplyOverrides(overrides, scene, error);
}

bool SolverOptionsFromFlags(SolverOptions* options, std::string* error) {
  const auto fail = [error](const char* flag, const char* allowed) {
    *error = "--" + std::string(flag) + ": found '" +
             gflags::GetCommandLineFlagInfoOrDie(flag).current_value + "'; allowed " + allowed;
    return false;
  };
  if (FLAGS_threads < 0 || FLAGS_threads > 1024) return fail("threads", "an integer in [0, 1024]");
  if (!(FLAGS_time_limit >= 0.0) || !std::isfinite(FLAGS_time_limit)) {
    return fail("time_limit", "a number of seconds >= 0");
  }
  if (!(FLAGS_gradient_tolerance > 0.0 && FLAGS_gradient_tolerance < 1.0)) {
    return fail("gradient_tolerance", "a number in (0, 1)");
  }
  if (FLAGS_max_iterations < 1) return fail("max_iterations", "an integer >= 1");
  if (FLAGS_sparse_backend == "auto") {
    options->backend = SparseBackend::kAuto;
  } else if (FLAGS_sparse_backend == "suite_sparse") {
    options->backend = SparseBackend::kSuiteSparse;
  } else if (FLAGS_sparse_backend == "eigen") {
    options->backend = SparseBackend::kEigen;
  } else {
    return fail("sparse_backend", "auto | suite_sparse | eigen");
  }
  options->num_threads = FLAGS_threads > 0
                             ? FLAGS_threads
                             : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options->time_limit_s = FLAGS_time_limit;
  options->gradient_tolerance = FLAGS_gradient_tolerance;
  options->max_iterations = FLAGS_max_iterations;
  return options->IsValid(error);
}

const std::atomic<bool>* StopOnSignal() {
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  return &stop_flag;
}

}  // namespace darboux
