// What a linear run costs against the factorisation it cannot do without.
//
// For each scene and resolution: the whole of Solve (set-up to solution, no output) against
// CHOLMOD's analyse + factorise + solve of the same normal matrix, in the same process, the best
// of `repeats` of each, alternating. Prints a table; asserts nothing (times belong to machines).
//
// Sample run: tests/linear_solve_benchmark data/pinched_cylinder.yaml data/clamped_plate.yaml
#include <ceres/crs_matrix.h>
#include <cholmod.h>
#include <dlfcn.h>
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

DEFINE_string(divisions, "16,32,64", "Cells per side, ascending; the scene's own are replaced.");
DEFINE_int32(repeats, 5, "Runs of each; the fastest counts.");
DEFINE_int32(threads, 2, "Threads for Ceres; the BLAS takes its own number.");

namespace darboux {
namespace {

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// CHOLMOD on J^T J of the problem, right-hand side the negative gradient.
class DirectSolve {
 public:
  explicit DirectSolve(ShellProblem* problem) {
    cholmod_start(&common_);
    ceres::Problem::EvaluateOptions options;
    std::vector<double> gradient;
    ceres::CRSMatrix j;
    double cost;
    CHECK(problem->problem()->Evaluate(options, &cost, nullptr, &gradient, &j));
    // The rows of J are the columns of J^T, compressed by column: what cholmod_aat takes.
    cholmod_sparse* jt = cholmod_allocate_sparse(
        j.num_cols, j.num_rows, j.values.size(), 1, 1, 0, CHOLMOD_REAL, &common_);
    std::copy(j.rows.begin(), j.rows.end(), static_cast<int*>(jt->p));
    std::copy(j.cols.begin(), j.cols.end(), static_cast<int*>(jt->i));
    std::copy(j.values.begin(), j.values.end(), static_cast<double*>(jt->x));
    cholmod_sparse* product = cholmod_aat(jt, nullptr, 0, 1, &common_);
    matrix_ = cholmod_copy(product, 1, 1, &common_);  // upper triangle, symmetric
    cholmod_free_sparse(&product, &common_);
    cholmod_free_sparse(&jt, &common_);
    right_ = cholmod_allocate_dense(gradient.size(), 1, gradient.size(), CHOLMOD_REAL, &common_);
    std::transform(
        gradient.begin(), gradient.end(), static_cast<double*>(right_->x), std::negate<double>());
  }
  ~DirectSolve() {
    cholmod_free_sparse(&matrix_, &common_);
    cholmod_free_dense(&right_, &common_);
    cholmod_finish(&common_);
  }
  DirectSolve(const DirectSolve&) = delete;
  DirectSolve& operator=(const DirectSolve&) = delete;

  double Time() {
    const double start = Seconds();
    cholmod_factor* factor = cholmod_analyze(matrix_, &common_);
    cholmod_factorize(matrix_, factor, &common_);
    cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor, right_, &common_);
    const double seconds = Seconds() - start;
    CHECK_EQ(common_.status, CHOLMOD_OK);
    cholmod_free_dense(&x, &common_);
    cholmod_free_factor(&factor, &common_);
    return seconds;
  }

 private:
  cholmod_common common_;
  cholmod_sparse* matrix_ = nullptr;
  cholmod_dense* right_ = nullptr;
};

bool Run(const std::string& file, int divisions) {
  Scene scene;
  std::string error;
  if (!ReadScene(file, &scene, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return false;
  }
  scene.surface.divisions = {divisions, divisions};
  scene.model.theory = Theory::kLinear;
  SolverOptions options;
  options.num_threads = FLAGS_threads;
  double whole = std::numeric_limits<double>::infinity(), setup = whole, direct = whole;
  SolverSummary summary;
  std::unique_ptr<ShellProblem> problem;
  for (int i = 0; i < FLAGS_repeats; ++i) {
    problem.reset();  // What a run leaves behind is not part of the next one.
    const double start = Seconds();
    if (!Solve(scene, options, &problem, &summary, &error)) {
      std::fprintf(stderr, "%s\n", error.c_str());
      return false;
    }
    const double seconds = Seconds() - start;
    if (seconds < whole) {
      whole = seconds;
      setup = summary.setup_s;
    }
    problem->displacements().setZero();
    DirectSolve solver(problem.get());
    direct = std::min(direct, solver.Time());
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%-22s %8d %8d %10.4f %10.4f %10.4f %10.4f %7.2f %9.2f\n",
              scene.name.c_str(),
              summary.dof,
              summary.unknowns,
              setup,
              summary.solve_s,
              whole,
              direct,
              whole / direct,
              usage.ru_maxrss / 1048576.0);
  std::fflush(stdout);
  return true;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s SCENE.yaml...\n", argv[0]);
    return 2;
  }
  // The BLAS that serves CHOLMOD: OpenBLAS must stand in front of what Ceres brings along.
  using Config = char* (*)();
  const auto openblas = reinterpret_cast<Config>(dlsym(RTLD_DEFAULT, "openblas_get_config"));
  Dl_info blas = {};
  void* const dgemm = dlsym(RTLD_DEFAULT, "dgemm_");
  std::printf("BLAS: %s, dgemm from %s\n",
              openblas != nullptr ? openblas() : "not OpenBLAS",
              dgemm != nullptr && dladdr(dgemm, &blas) != 0 ? blas.dli_fname : "?");
  std::printf("%-22s %8s %8s %10s %10s %10s %10s %7s %9s\n",
              "scene",
              "dof",
              "unknowns",
              "set-up s",
              "solve s",
              "whole s",
              "CHOLMOD s",
              "ratio",
              "peak GiB");
  for (int i = 1; i < argc; ++i) {
    std::stringstream list(FLAGS_divisions);
    for (std::string item; std::getline(list, item, ',');) {
      if (!darboux::Run(argv[i], std::stoi(item))) return 2;
    }
  }
  return 0;
}
