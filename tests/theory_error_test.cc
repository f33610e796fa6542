#include "solver/theory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "tests/solve_util.h"

namespace darboux {
namespace {

// The estimate, and what the nonlinear theory really changes, both relative to the linear answer.
std::pair<double, double> Compare(Scene scene, double softness) {
  scene.shell.young_modulus /= softness;
  scene.steps = 1;
  scene.path = PathSpec();
  scene.model.theory = Theory::kLinear;
  const Solution linear = SolveScene(scene);
  const std::vector<Goal> goals = GoalsOf(scene, linear.summary);
  TheoryError estimate;
  std::string error;
  EXPECT_TRUE(
      EstimateTheoryError(*linear.problem, goals, SparseBackend::kAuto, 1, &estimate, &error))
      << error;
  scene.model.theory = Theory::kNonlinear;
  const Solution nonlinear = SolveScene(scene);
  const std::vector<Goal> moved = GoalsOf(scene, nonlinear.summary);
  double change = 0.0;
  for (size_t i = 0; i < goals.size(); ++i) {
    change = std::max(change, (goals[i].value - moved[i].value).norm() / goals[i].size);
  }
  return {estimate.value, change};
}

class TheoryErrorTest : public ::testing::TestWithParam<std::tuple<const char*, double>> {};

TEST_P(TheoryErrorTest, NewtonStepTellsWhatTheNonlinearTheoryChanges) {
  const auto [name, softness] = GetParam();
  Scene scene = SceneFromData(name);
  scene.surface.divisions = {12, 12};
  const auto [estimate, change] = Compare(scene, softness);
  // Exact to second order of the change; short of large ones, which need no digits.
  EXPECT_LE(std::abs(estimate - change), 2.0 * change * change + 1e-6 * change)
      << estimate << " " << change;
  EXPECT_GE(estimate / change, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         TheoryErrorTest,
                         ::testing::Combine(::testing::Values("nonlinear_plate_p10.yaml",
                                                              "monkey_saddle.yaml",
                                                              "cylinder_harmonic.yaml",
                                                              "pinched_cylinder.yaml"),
                                            ::testing::Values(0.05, 0.2, 1.0, 5.0)));

TEST(TheoryErrorTest, StateThatWouldBuckleIsNoAnswerOfTheLinearTheory) {
  // A strip under twice its Euler load along its axis; the linear theory only shortens it.
  const double load = 2.0 * M_PI * M_PI / 4.0 * 1e6 * 0.1 * 0.1 * 0.1 / 12.0 / (10.0 * 10.0);
  Scene scene = SceneFromText(
      "name: column\n"
      "surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [16, 2]}\n"
      "shell: {thickness: 0.1, young_modulus: 1.0e6, poisson_ratio: 0}\n"
      "model: {theory: linear}\n"
      "supports: [{on: u_min, clamped: true}]\n"
      "loads: [{kind: edge, on: u_max, force: [" +
      std::to_string(-load) +
      ", 0, 0]}]\n"
      "probes: [{name: end, at: {uv: [10, 0.5]}}]\n");
  const Solution linear = SolveScene(scene);
  TheoryError estimate;
  std::string error;
  ASSERT_TRUE(EstimateTheoryError(
      *linear.problem, GoalsOf(scene, linear.summary), SparseBackend::kAuto, 1, &estimate, &error));
  EXPECT_EQ(estimate.value, std::numeric_limits<double>::infinity());
}

TEST(TheoryErrorTest, ShellAtRestHasNone) {
  Scene scene = SceneFromData("clamped_plate.yaml");
  scene.loads.clear();
  scene.surface.divisions = {4, 4};
  const Solution linear = SolveScene(scene);
  TheoryError estimate;
  std::string error;
  ASSERT_TRUE(EstimateTheoryError(
      *linear.problem, GoalsOf(scene, linear.summary), SparseBackend::kAuto, 1, &estimate, &error));
  EXPECT_EQ(estimate.value, 0.0);
}

}  // namespace
}  // namespace darboux
