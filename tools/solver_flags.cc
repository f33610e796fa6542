#include "tools/solver_flags.h"

#include <ceres/version.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "solver/file_set.h"
#include "solver/scene_reader.h"
#include "tools/html_report.h"
#include "tools/progress.h"

// The form of their texts is that of tools/help.h.
DEFINE_string(out,
              "",
              "output | DIR | folder; required | For all results; created when missing. Nothing is "
              "written anywhere else.");
DEFINE_bool(quiet, false, "output | | | Prints nothing but errors.");
DEFINE_bool(report,
            false,
            "output | | | Writes report.html as well: the deformed shape to turn and colour, all "
            "numbers, plots, in one file that any browser opens.");
DEFINE_string(
    log,
    "text",
    "output | FORMAT | text or json | json: every line on stderr, progress and errors, is "
    "a JSON object.");

DEFINE_bool(repair,
            false,
            "input | | | Mends the scene's mesh file before use: sews seams, drops or flattens "
            "what is no triangle, winds triangles alike and outwards. What was done is printed "
            "and kept in the results.");

DEFINE_string(theory,
              "",
              "model | THEORY | auto, linear or nonlinear; default: the scene's model.theory | "
              "Strains that are linear in the displacements, for small ones, or not. auto: "
              "nonlinear where the linear solution needs it.");
DEFINE_string(strains,
              "",
              "model | STRAINS | koiter or seed; default: the scene's model.strains | koiter: "
              "zero under any rotation; seed: those of the paper.");
DEFINE_string(minimizer,
              "",
              "model | MINIMIZER | auto, mip, ceres or cg; default: the scene's model.minimizer | "
              "The mixed iteration (mip), Ceres, or conjugate gradients for comparison. auto: mip, "
              "and Ceres where that fails.");
DEFINE_int32(quadrature,
             0,
             "model | POINTS | 1, 3, 6 or 12; default: the scene's model.quadrature | Quadrature "
             "points per triangle.");
DEFINE_string(divisions,
              "",
              "model | M,N | two integers > 0; default: the scene's surface.divisions | Cells of a "
              "parametric surface in u and in v.");

DEFINE_int32(
    threads,
    0,
    "solver | N | 0 to 1024; default: 0, as many as the machine runs at once | Threads of the "
    "solver.");
DEFINE_double(time_limit,
              0.0,
              "solver | SECONDS | >= 0 s; default: 0, none | Stops the solver after this time; "
              "what it has is written.");
DEFINE_string(sparse_backend,
              "auto",
              "solver | BACKEND | auto, suite_sparse or eigen | Sparse factorisation. eigen is "
              "slower and runs no GPL code; auto: suite_sparse where Ceres has it.");
DEFINE_double(gradient_tolerance,
              1e-7,
              "solver | PART | in (0, 1), no unit | A load step has converged when |gradient| is "
              "at most this part of |loads| + |reactions|.");
DEFINE_int32(max_iterations, 200, "solver | N | >= 1 | Iterations per load step.");

namespace darboux {
namespace {

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
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const auto fail = [&](const std::string& message) {
    *exit_status = kExitBadInput;
    const bool json = progress::AsksForJson(words);
    progress::Error(tool.name, message, json);
    if (!json) PrintUsage(tool);
    return false;
  };
  std::string error;
  if (!ParseWords(tool, ", Ceres " CERES_VERSION_STRING, words, arguments, &error)) {
    *exit_status = kExitDone;
    return error.empty() ? false : fail(error);
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

  if (FLAGS_out.empty()) return fail("--out: found no folder; allowed the name of a folder");
  if (FLAGS_report && !HasReportPage()) return fail(NoReportPage());
  progress::Start(tool.name, DARBOUX_VERSION, words);
  return true;
}

int RunTool(const Tool& tool, int (*run)(int argc, char** argv), int argc, char** argv) {
  std::string error;
  const int exit_status = RunAndCatch(run, argc, argv, &error);
  if (!error.empty()) progress::Error(tool.name, error, progress::IsJson());
  return progress::Done(exit_status);
}

int BadInput(const std::string& message) {
  progress::Error(message);
  return kExitBadInput;
}

int NotDone(const std::string& message) {
  progress::Error(message);
  return kExitNotConverged;
}

bool FailFlag(const char* flag, const std::string& allowed, std::string* error) {
  *error = "--" + std::string(flag) + ": found '" +
           gflags::GetCommandLineFlagInfoOrDie(flag).current_value + "'; allowed " + allowed;
  return false;
}

bool CheckOut(std::string* error) {
  if (IsWritableFolder(FLAGS_out, error)) return true;
  *error = "--out: found " + *error + "; allowed a folder that can be written to";
  return false;
}

bool ReadSceneToMend(const std::string& file, Scene* scene, std::string* error) {
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

bool ReadSceneWithFlags(const std::string& file,
                        Scene* scene,
                        std::vector<std::string>* overridden,
                        std::string* error) {
  return ReadSceneToMend(file, scene, error) && ApplyFlags(scene, overridden, error);
}

bool SolverOptionsFromFlags(SolverOptions* options, std::string* error) {
  const auto fail = [error](const char* flag, const char* allowed) {
    return FailFlag(flag, allowed, error);
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
