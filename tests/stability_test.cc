#include "solver/stability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/solve_util.h"

namespace darboux {
namespace {

// A strip pressed at its end, clamped at the other and guided in between: Euler's column of length
// 2 L, P = pi^2 E I / (4 L^2) per width with E I = E h^3 / 12 (nu = 0).
constexpr double kLength = 10.0, kThickness = 0.1, kYoung = 1.2e6;
const double kCritical =
    M_PI * M_PI * kYoung * std::pow(kThickness, 3) / 12.0 / (4.0 * kLength * kLength);

Scene Column(double load, const std::string& model = "") {
  return SceneFromText(R"(
name: column
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [24, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear)" +
                       model +
                       R"(}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, force: [)" +
                       std::to_string(-load * kCritical) + R"(, 0, 0]}
probes:
  - {name: tip, at: {uv: [10, 0.5]}}
)");
}

TEST(StabilityTest, ColumnIsStableUpToEulersLoad) {
  const LoadStep below = SolveScene(Column(0.99)).summary.steps.back();
  EXPECT_EQ(below.negative_modes, 0);
  EXPECT_GT(*below.softness, 0.0);
  EXPECT_LT(*below.softness, 0.02);
  // One part in a hundred from buckling: nearly unstable, so the mode is there.
  EXPECT_GT(below.mode.size(), 0);
  const Solution above = SolveScene(Column(1.01));
  EXPECT_EQ(above.summary.steps.back().negative_modes, 1);
  EXPECT_LT(*above.summary.steps.back().softness, 0.0);
  EXPECT_NEAR(above.Probe().z(), 0.0, 1e-9);  // still straight
}

// m^T K m / m^T K_0 m of the buckling mode is 1 - P / P_c; the softest mode is that one when P is
// near P_c.
TEST(StabilityTest, SoftnessIsTheDistanceToTheCriticalLoad) {
  for (const double load : {0.8, 0.95, 0.99}) {
    EXPECT_NEAR(*SolveScene(Column(load)).summary.steps.back().softness, 1.0 - load, 5e-3);
  }
}

TEST(StabilityTest, LowestModeIsTheQuarterWave) {
  const Solution solution = SolveScene(Column(1.01));
  const LoadStep& step = solution.summary.steps.back();
  ASSERT_GT(step.mode.size(), 0);
  solution.problem->displacements() = step.mode;
  const auto at = [&](double u) {
    return solution.problem->Displacement(solution.problem->surface().domain().Locate(u, 0.5)).z();
  };
  for (const double u : {2.5, 5.0, 7.5}) {
    EXPECT_NEAR(at(u) / at(kLength), 1.0 - std::cos(M_PI * u / (2.0 * kLength)), 2e-3);
  }
}

TEST(StabilityTest, HigherLoadsHaveMoreNegativeModes) {
  // The second bending load of a cantilever is nine times the first.
  EXPECT_EQ(SolveScene(Column(8.5)).summary.steps.back().negative_modes, 1);
  EXPECT_EQ(SolveScene(Column(9.5)).summary.steps.back().negative_modes, 2);
}

TEST(StabilityTest, LeavesTheUnstableBranchWhenAsked) {
  const Solution straight = SolveScene(Column(1.2));
  const Solution buckled = SolveScene(Column(1.2, ", unstable: leave"));
  EXPECT_EQ(straight.summary.steps.back().negative_modes, 1);
  EXPECT_EQ(buckled.summary.steps.back().negative_modes, 0);
  EXPECT_LT(buckled.summary.energy_total, straight.summary.energy_total);
  // Elastica at 1.2 of the critical load: the tip deflects by 0.63 of the length.
  EXPECT_NEAR(std::abs(buckled.Probe().z()) / kLength, 0.63, 0.02);
}

// data/cantilever_moment.yaml at its whole width. An end moment that works on the turn of the end
// about the fixed axis -y makes the strip buckle sideways. Inextensible rod of torsional stiffness
// GJ = 2 EI (a thin strip of nu = 0), stiff in its plane, clamped at one end, bent by t radians:
//
//   sqrt2 cos(t / sqrt2) cos t + sin(t / sqrt2) sin t = 0,  t = 4.9962 = 0.795 of a circle;
//
// 0.8065 with the in-plane stiffness of b / h = 10 and warping held at the clamp. Measured: 0.8056.
Scene WholeStrip(double factor) {
  return SceneFromText(R"(
name: whole-strip
surface: {kind: plane, u: [0, 12], v: [-0.5, 0.5], divisions: [48, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, moment: [0, )" +
                       std::to_string(-factor * 50.0 * M_PI / 3.0) + R"(, 0]}
probes:
  - {name: tip, at: {uv: [12, 0]}}
steps: 20
path: {control: arc_length}
)");
}

TEST(StabilityTest, StripUnderAnEndMomentBucklesSidewaysAtFourFifthsOfACircle) {
  const Solution below = SolveScene(WholeStrip(0.804)), above = SolveScene(WholeStrip(0.808));
  EXPECT_EQ(below.summary.steps.back().negative_modes, 0);
  EXPECT_EQ(above.summary.steps.back().negative_modes, 1);
  // Still in its plane, but for what the one-sided diagonals of the cells do near a critical load.
  EXPECT_NEAR(above.Probe().y(), 0.0, 0.02);
  // The mode that the strip is about to take moves the tip sideways, out of that plane.
  ASSERT_GT(above.summary.steps.back().mode.size(), 0);
  above.problem->displacements() = above.summary.steps.back().mode;
  const Eigen::Vector3d mode =
      above.problem->Displacement(above.problem->surface().domain().Locate(12.0, 0.0));
  EXPECT_GT(std::abs(mode.y()), 10.0 * std::hypot(mode.x(), mode.z()));
}

}  // namespace
}  // namespace darboux
