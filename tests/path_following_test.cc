// Equilibrium paths with limit points: what the solver reports against what it must be.
#include "solver/path_following.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

// A shallow roof that snaps through, coarse.
const char kRoof[] = R"(
name: roof
surface: {kind: cylinder, radius: 2540, u: [0, 254], v: [0, 0.1], divisions: [8, 8]}
shell: {thickness: 12.7, young_modulus: 3102.75, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: u_min, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, fix: [x, y, z]}
loads:
  - {kind: point, at: {uv: [0, 0]}, force: [0, 0, -750]}
probes:
  - {name: centre, at: {uv: [0, 0]}}
)";

Scene Roof(const std::string& path, double thickness = 12.7) {
  Scene scene = SceneFromText(std::string(kRoof) + path);
  scene.shell.thickness = thickness;
  return scene;
}

std::vector<LoadStep> LimitPoints(const Solution& solution) {
  std::vector<LoadStep> points;
  for (const LoadStep& step : solution.summary.steps) {
    if (step.limit_point) points.push_back(step);
  }
  return points;
}

// Load factor at a controlled displacement, by linear interpolation along the path.
double FactorAt(const Solution& solution, double z) {
  const auto& steps = solution.summary.steps;
  for (size_t i = 1; i < steps.size(); ++i) {
    const double a = steps[i - 1].probe_displacements[0].z(),
                 b = steps[i].probe_displacements[0].z();
    if ((a - z) * (b - z) <= 0.0 && a != b) {
      return steps[i - 1].factor + (steps[i].factor - steps[i - 1].factor) * (z - a) / (b - a);
    }
  }
  ADD_FAILURE() << "the path does not pass " << z;
  return 0.0;
}

TEST(PathFollowingTest, ArcLengthAndDisplacementControlFindOnePath) {
  const Solution arc = SolveScene(Roof("path: {control: arc_length}\n"));
  const Solution controlled =
      SolveScene(Roof("steps: 56\n"
                      "path: {control: displacement, probe: centre, component: z, to: -28}\n"));
  ASSERT_EQ(controlled.summary.steps.size(), 56u);
  EXPECT_NEAR(controlled.Probe().z(), -28.0, 1e-6);
  for (size_t i = 1; i < 55; i += 3) {
    const LoadStep& step = controlled.summary.steps[i];
    EXPECT_NEAR(step.probe_displacements[0].z(), -0.5 * (i + 1.0), 1e-6);
    // The arc's points are chords apart.
    EXPECT_NEAR(FactorAt(arc, step.probe_displacements[0].z()), step.factor, 0.01);
    EXPECT_LE(step.relative_gradient, 1e-7);
  }
}

TEST(PathFollowingTest, LimitPointsAreExtremaAndChangeStability) {
  const Solution solution = SolveScene(Roof("path: {control: arc_length}\n"));
  const auto limits = LimitPoints(solution);
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(solution.summary.steps.back().factor, 1.0);
  // Extrema: displacement control on either side finds less, or more, load.
  for (const size_t k : {size_t{0}, size_t{1}}) {
    const double z = limits[k].probe_displacements[0].z();
    const Solution fine = SolveScene(
        Roof("steps: 40\npath: {control: displacement, probe: centre, component: z, to: " +
             std::to_string(z * 1.05) + "}\n"));
    double extremum = fine.summary.steps.back().factor;
    for (size_t i = 32; i < 40; ++i) {
      const double factor = fine.summary.steps[i].factor;
      extremum = k == 0 ? std::max(extremum, factor) : std::min(extremum, factor);
    }
    EXPECT_NEAR(limits[k].factor, extremum, 2e-3);
    EXPECT_GE((k == 0 ? 1.0 : -1.0) * (limits[k].factor - extremum), -1e-6);
  }
  // One mode turns unstable between the two, none before and after.
  int passed = 0;
  for (const LoadStep& step : solution.summary.steps) {
    if (step.limit_point) {
      ++passed;
      continue;
    }
    ASSERT_TRUE(step.negative_modes.has_value());
    EXPECT_EQ(*step.negative_modes, passed == 1 ? 1 : 0);
  }
}

TEST(PathFollowingTest, SnapBackIsFollowed) {
  const Solution solution = SolveScene(Roof("path: {control: arc_length}\n", 6.35));
  EXPECT_EQ(LimitPoints(solution).size(), 2u);
  // The centre moves back on the way.
  double lowest = 0.0, back = 0.0;
  for (const LoadStep& step : solution.summary.steps) {
    lowest = std::min(lowest, step.probe_displacements[0].z());
    back = std::max(back, step.probe_displacements[0].z() - lowest);
  }
  EXPECT_GT(back, 1.0);
  EXPECT_LT(LimitPoints(solution)[1].factor, 0.0);
  // Displacement control cannot: it says so and keeps what it has.
  Solution stopped;
  std::string error;
  ASSERT_TRUE(Solve(Roof("steps: 10\n"
                         "path: {control: displacement, probe: centre, component: z, to: -30}\n",
                         6.35),
                    SolverOptions(),
                    &stopped.problem,
                    &stopped.summary,
                    &error));
  if (!stopped.summary.IsConverged()) {
    EXPECT_THAT(stopped.summary.message, HasSubstr("arc_length may go on"));
    EXPECT_TRUE(stopped.summary.IsSolutionUsable());
  }
}

TEST(PathFollowingTest, EndsAtTheStateThatLoadControlFinds) {
  const Solution arc = SolveScene(Roof("path: {control: arc_length}\n"));
  const Solution load = SolveScene(Roof(""));
  EXPECT_LE((arc.Probe() - load.Probe()).norm(), 1e-6 * load.Probe().norm());
  EXPECT_NEAR(arc.summary.energy_total,
              load.summary.energy_total,
              1e-8 * std::abs(load.summary.energy_total));
}

TEST(PathFollowingTest, TooFewStepsAreAnHonestEnd) {
  Solution solution;
  std::string error;
  ASSERT_TRUE(Solve(Roof("path: {control: arc_length, max_steps: 3}\n"),
                    SolverOptions(),
                    &solution.problem,
                    &solution.summary,
                    &error));
  EXPECT_FALSE(solution.summary.IsConverged());
  EXPECT_THAT(solution.summary.message, HasSubstr("3 steps"));
  EXPECT_EQ(solution.summary.steps.size(), 3u);
}

// In another system of units the path has the same points.
TEST(PathFollowingTest, IsScaleFree) {
  const Solution mm = SolveScene(Roof("path: {control: arc_length}\n"));
  Scene scene = Roof("path: {control: arc_length}\n");
  std::string text = kRoof;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("radius: 2540, u: [0, 254]", "radius: 2.54, u: [0, 0.254]");
  replace("thickness: 12.7, young_modulus: 3102.75", "thickness: 0.0127, young_modulus: 3102.75e6");
  const Solution m = SolveScene(SceneFromText(text + "path: {control: arc_length}\n"));
  ASSERT_EQ(m.summary.steps.size(), mm.summary.steps.size());
  for (size_t i = 0; i < m.summary.steps.size(); ++i) {
    EXPECT_NEAR(m.summary.steps[i].factor, mm.summary.steps[i].factor, 1e-6);
    EXPECT_EQ(m.summary.steps[i].iterations, mm.summary.steps[i].iterations);
  }
}

}  // namespace
}  // namespace darboux
