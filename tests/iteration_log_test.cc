#include "solver/iteration_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

using Method = IterationReport::Method;

// A plate that bends by two thicknesses: far from linear, no follower forces.
std::string Plate(const std::string& model) {
  return R"(
name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [6, 6]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: )" +
         model + R"(
supports:
  - {on: rim, clamped: true}
loads:
  - {kind: normal_traction, value: 20}
steps: 2
probes:
  - {name: centre, at: {uv: [50, 50]}}
)";
}

struct Case {
  const char* name;
  const char* model;
  Method method;
};

class IterationLogTest : public ::testing::TestWithParam<Case> {};

TEST_P(IterationLogTest, EveryIterationIsThereOnceAndInOrder) {
  SolverOptions options;
  std::vector<IterationReport> told;
  options.on_iteration = [&told](const IterationReport& report) { told.push_back(report); };
  const Solution solution = SolveScene(SceneFromText(Plate(GetParam().model)), options);
  ASSERT_TRUE(solution.summary.IsConverged()) << solution.summary.message;
  const std::vector<IterationReport>& history = solution.summary.iteration_history;
  ASSERT_EQ(told.size(), history.size());
  ASSERT_FALSE(history.empty());
  double seconds = 0.0;
  int step = 1;
  for (size_t i = 0; i < history.size(); ++i) {
    EXPECT_EQ(history[i].method, GetParam().method);
    EXPECT_EQ(history[i].total, static_cast<int>(i));
    EXPECT_EQ(told[i].total, static_cast<int>(i));
    EXPECT_EQ(history[i].steps, 2);
    EXPECT_GE(history[i].step, step);
    EXPECT_GE(history[i].seconds, seconds);
    EXPECT_TRUE(std::isfinite(history[i].energy) && std::isfinite(history[i].relative_gradient));
    step = history[i].step;
    seconds = history[i].seconds;
  }
  const IterationReport& last = history.back();
  EXPECT_EQ(last.load_factor, solution.summary.steps.back().factor);
  EXPECT_LE(last.relative_gradient, 10.0 * options.gradient_tolerance);
  EXPECT_NEAR(last.energy,
              solution.summary.steps.back().energy,
              1e-6 * std::abs(solution.summary.steps.back().energy));
}

TEST_P(IterationLogTest, WatchingChangesNoBit) {
  const Scene scene = SceneFromText(Plate(GetParam().model));
  SolverOptions options;
  options.num_threads = 1;
  const Solution alone = SolveScene(scene, options);
  int watched = 0;
  options.on_iteration = [&watched](const IterationReport&) { ++watched; };
  const Solution seen = SolveScene(scene, options);
  EXPECT_GT(watched, 0);
  EXPECT_EQ(alone.problem->displacements(), seen.problem->displacements());
}

INSTANTIATE_TEST_SUITE_P(
    Minimisers,
    IterationLogTest,
    ::testing::Values(Case{"linear", "{theory: linear}", Method::kLinear},
                      Case{"mip", "{theory: nonlinear, minimizer: mip}", Method::kMixed},
                      Case{"ceres", "{theory: nonlinear, minimizer: ceres}", Method::kCeres},
                      Case{"path",
                           "{theory: nonlinear}\npath: {control: displacement, probe: centre, "
                           "component: z, to: 1.5}",
                           Method::kPath}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace darboux
