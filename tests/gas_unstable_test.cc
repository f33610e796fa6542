// A sphere that gas holds round beyond its critical pressure, and what it becomes.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "tests/solve_util.h"

namespace darboux {
namespace {

// Pre-stressed by a suction of 2.4 times 2 E (h/R)^2 / sqrt(3 (1 - nu^2)): in equilibrium on paper
// only. The gas limits the dent.
Scene SuckedBall(const std::string& unstable) {
  return SceneFromText(
      "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: 3}\n"
      "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\n"
      "model: {theory: nonlinear, unstable: " +
      unstable +
      "}\nsupports:\n  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y, z]}\n"
      "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
      "  - {on: {near: [31.25, 0, 0], radius: 0}, fix: [y]}\nloads:\n"
      "  - {kind: gas, gauge_pressure: -0.003, ambient_pressure: 0.02, rest: prestressed}\n");
}

TEST(GasUnstableTest, StateIsReportedAndLeft) {
  const Solution round = SolveScene(SuckedBall("report"));
  EXPECT_LE(round.summary.max_displacement, 1e-10);
  EXPECT_GT(round.summary.steps.back().negative_modes.value_or(0), 0);
  const Solution dented = SolveScene(SuckedBall("leave"));
  const LoadStep& state = dented.summary.steps.back();
  std::printf("  energy %.4f, volume ratio %.4f, gauge pressure %.6f\n",
              dented.summary.energy_total,
              state.gas->volume_ratio,
              state.gas->gauge_pressure);
  EXPECT_EQ(state.negative_modes.value_or(-1), 0);
  EXPECT_LT(dented.summary.energy_total, -10.0);
  EXPECT_NEAR((0.02 + state.gas->gauge_pressure) * state.gas->volume_ratio, 0.017, 1e-9);
}

}  // namespace
}  // namespace darboux
