// Hard cases: large rotations. A strip wound up by an end moment, to ten turns.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/hard_util.h"

namespace darboux {
namespace {

struct Roll {
  const char* name;
  int turns, divisions, steps;
  double thickness;
};

class RollTest : public ::testing::TestWithParam<Roll> {};

// The strip may lie on itself: nothing keeps it from doing so, and nothing has to. Half of its
// width is modelled; the whole strip would buckle sideways (tests/stability_test.cc).
TEST_P(RollTest, IsTheCircleOfItsClosedForm) {
  const Roll& roll = GetParam();
  const double length = 12.0, curvature = 2.0 * M_PI * roll.turns / length;
  const double stiffness = 100.0;  // D of data/cantilever_moment.yaml, at any thickness
  const Solution solution =
      SolveScene(SceneFromText(Fill(R"(
name: roll
surface: {kind: plane, u: [0, 12], v: [0, 0.5], divisions: [$n, 1]}
shell: {thickness: $h, young_modulus: $E, poisson_ratio: 0}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}, {on: v_min, symmetry: y}]
loads: [{kind: edge, on: u_max, moment: [0, -$m, 0]}]
steps: $steps
probes: [{name: tip, at: {uv: [12, 0]}}]
)",
                                    {{"steps", 1.0 * roll.steps},
                                     {"n", 1.0 * roll.divisions},
                                     {"h", roll.thickness},
                                     {"E", 12.0 * stiffness / std::pow(roll.thickness, 3)},
                                     {"m", stiffness * curvature}})));
  const double error =
      (solution.Probe() - KoiterCircle(length, roll.thickness, curvature)).norm() / length;
  EXPECT_LE(error, 1e-5);
  const std::string name = "rotations: " + std::string(roll.name);
  Measured(name + ", divisions", roll.divisions);
  Measured(name + ", load steps", roll.steps);
  Measured(name + ", iterations", solution.summary.iterations);
  Measured(name + ", error / length", error);
}

// One and two turns are data/cantilever_moment*.yaml.
INSTANTIATE_TEST_SUITE_P(Turns,
                         RollTest,
                         ::testing::Values(Roll{"three", 3, 144, 1, 0.1},
                                           Roll{"five", 5, 240, 5, 0.1},
                                           Roll{"ten", 10, 480, 10, 0.03}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace darboux
