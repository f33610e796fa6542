// Where the time of a nonlinear solve goes: the parts of one mixed iteration in the scene's final
// state, against the whole of Solve and against one Ceres iteration's Jacobian. Prints a table.
//
// Sample run: tests/nonlinear_solve_benchmark data/slit_annulus.yaml data/pinched_hemisphere.yaml
#include <ceres/crs_matrix.h>
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "solver/mixed_iteration.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

DEFINE_int32(repeats, 5, "Runs of each; the fastest counts.");
DEFINE_int32(threads, 2, "Threads; the BLAS takes its own number.");

namespace darboux {
namespace {

double Best(const std::function<void()>& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < FLAGS_repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return 1e3 * best;
}

bool Run(const std::string& file) {
  Scene scene;
  std::string error;
  SolverOptions options;
  options.num_threads = FLAGS_threads;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  if (!ReadScene(file, &scene, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return false;
  }
  scene.model.theory = Theory::kNonlinear;
  scene.steps = 1;
  scene.path = PathSpec();
  bool solved = true;
  const double whole =
      Best([&] { solved = solved && Solve(scene, options, &problem, &summary, &error); });
  if (!solved) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return false;
  }
  std::unique_ptr<MixedIteration> mixed;
  const double pattern = Best([&] {
    mixed = std::make_unique<MixedIteration>(problem.get(), options.backend, FLAGS_threads);
  });
  CHECK(mixed->SetStresses());
  TangentStiffness& tangent = mixed->tangent();
  Eigen::VectorXd gradient, step;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  const double residual = Best([&] { tangent.Evaluate(request); });
  request.matrix = true;
  request.initial_stresses = &mixed->stresses();
  const double assemble = Best([&] { tangent.Evaluate(request); });
  mixed->Factorize();  // with its analysis
  const double factorise = Best([&] { mixed->Factorize(); });
  const double solve = Best([&] { step = mixed->cholesky().Solve(gradient); });
  TangentStiffness::StressField stresses;
  const double extrapolate = Best([&] { tangent.LinearisedStresses(step, &stresses); });
  const double rotation = Best([&] { tangent.LargestRotation(step); });
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.num_threads = FLAGS_threads;
  const double by_ceres = Best([&] {
    double cost;
    ceres::CRSMatrix jacobian;
    problem->problem()->Evaluate(evaluate, &cost, nullptr, nullptr, &jacobian);
  });
  std::printf("%-24s %6d %5d %9.1f %8.1f %9.2f %9.2f %9.2f %7.2f %9.2f %9.2f %9.2f\n",
              scene.name.c_str(),
              summary.dof,
              summary.iterations,
              whole,
              pattern,
              residual,
              assemble,
              factorise,
              solve,
              extrapolate,
              rotation,
              by_ceres);
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
  std::printf("milliseconds\n%-24s %6s %5s %9s %8s %9s %9s %9s %7s %9s %9s %9s\n",
              "scene",
              "dof",
              "its",
              "whole",
              "pattern",
              "gradient",
              "+ matrix",
              "factor",
              "solve",
              "stresses",
              "rotation",
              "Ceres J");
  for (int i = 1; i < argc; ++i) {
    if (!darboux::Run(argv[i])) return 2;
  }
  return 0;
}
