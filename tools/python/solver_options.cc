#include "tools/python/solver_options.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <thread>

#include "solver/yaml_reader.h"
#include "tools/python/convert.h"

namespace py = pybind11;

namespace darboux {
namespace {

[[noreturn]] void Fail(const char* name, const py::handle& found, const char* allowed) {
  throw InputError(std::string(name) + ": " +
                   Problem(Clean(py::cast<std::string>(py::repr(found))), allowed));
}

}  // namespace

template <typename T>
bool Get(const py::dict& options, const char* name, const char* allowed, T* value) {
  if (!options.contains(name)) return false;
  const py::object found = options[name];
  if (found.is_none()) return false;
  // Python takes True for 1, and texts for nothing else; numpy's numbers count as Python's.
  const bool is_bool = PyBool_Check(found.ptr()) != 0;
  if (is_bool != std::is_same_v<T, bool>) Fail(name, found, allowed);
  try {
    *value = found.cast<T>();
  } catch (const py::cast_error&) {
    Fail(name, found, allowed);
  }
  return true;
}
template bool Get(const py::dict&, const char*, const char*, bool*);
template bool Get(const py::dict&, const char*, const char*, int*);
template bool Get(const py::dict&, const char*, const char*, std::uint64_t*);
template bool Get(const py::dict&, const char*, const char*, double*);
template bool Get(const py::dict&, const char*, const char*, std::string*);

SolverOptions SolverOptionsOf(const py::dict& options) {
  SolverOptions solver;
  int threads = 0;
  constexpr char kThreads[] = "an integer in [0, 1024]";
  if (Get(options, "threads", kThreads, &threads) && (threads < 0 || threads > 1024)) {
    Fail("threads", options["threads"], kThreads);
  }
  solver.num_threads =
      threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  constexpr char kSeconds[] = "a number of seconds >= 0";
  if (Get(options, "time_limit", kSeconds, &solver.time_limit_s) &&
      !(solver.time_limit_s >= 0.0 && std::isfinite(solver.time_limit_s))) {
    Fail("time_limit", options["time_limit"], kSeconds);
  }
  constexpr char kFraction[] = "a number in (0, 1)";
  if (Get(options, "gradient_tolerance", kFraction, &solver.gradient_tolerance) &&
      !(solver.gradient_tolerance > 0.0 && solver.gradient_tolerance < 1.0)) {
    Fail("gradient_tolerance", options["gradient_tolerance"], kFraction);
  }
  constexpr char kCount[] = "an integer >= 1";
  if (Get(options, "max_iterations", kCount, &solver.max_iterations) && solver.max_iterations < 1) {
    Fail("max_iterations", options["max_iterations"], kCount);
  }
  constexpr char kBackends[] = "auto | suite_sparse | eigen";
  std::string backend = "auto";
  Get(options, "sparse_backend", kBackends, &backend);
  if (backend == "suite_sparse") {
    solver.backend = SparseBackend::kSuiteSparse;
  } else if (backend == "eigen") {
    solver.backend = SparseBackend::kEigen;
  } else if (backend != "auto") {
    Fail("sparse_backend", options["sparse_backend"], kBackends);
  }
  std::string error;
  if (!solver.IsValid(&error)) throw InputError(error);
  return solver;
}

void Override(const py::dict& options, Scene* scene) {
  SceneOverrides overrides;
  std::string text;
  if (Get(options, "theory", "auto | linear | nonlinear", &text)) overrides.theory = text;
  if (Get(options, "strains", "koiter | seed", &text)) overrides.strains = text;
  if (Get(options, "minimizer", "auto | mip | ceres | cg", &text)) overrides.minimizer = text;
  int quadrature = 0;
  if (Get(options, "quadrature", "1, 3, 6 or 12 points per triangle", &quadrature)) {
    overrides.quadrature = quadrature;
  }
  if (options.contains("divisions") && !options["divisions"].is_none()) {
    const py::object divisions = options["divisions"];
    try {
      const auto pair = divisions.cast<std::array<int, 2>>();
      overrides.divisions = std::to_string(pair[0]) + "," + std::to_string(pair[1]);
    } catch (const py::cast_error&) {
      Fail("divisions", divisions, "a pair of integers > 0");
    }
  }
  std::string error;
  if (ApplyOverrides(overrides, scene, &error)) return;
  constexpr std::size_t kDashes = 2;  // It speaks of flags.
  throw InputError(error.substr(std::min(kDashes, error.size())));
}

}  // namespace darboux
