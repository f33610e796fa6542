// Hard cases: bifurcations. A perfect column, plate or sphere stays in its fundamental state when
// it is pressed beyond its critical load; that state is then said to be unstable, just below it is
// not.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "solver/results.h"
#include "tests/hard_util.h"
#include "tests/temporary_folder.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

// Negative modes at a load of `factor` times `load`.
Solution Pressed(const std::string& scene, double load, double factor) {
  Solution solution = SolveScene(SceneFromText(Fill(scene, {{"p", factor * load}})));
  EXPECT_TRUE(solution.summary.steps.back().negative_modes.has_value());
  return solution;
}

int NegativeModes(const Solution& solution) {
  return solution.summary.steps.back().negative_modes.value_or(-1);
}

// The fundamental state is stable at (1 - width) of the critical load, and above (1 + width) it is
// reported to have this many negative modes.
Solution ExpectBracket(const std::string& name,
                       const std::string& scene,
                       double critical,
                       double width,
                       int modes = 1) {
  const Solution below = Pressed(scene, critical, 1.0 - width);
  EXPECT_EQ(NegativeModes(below), 0) << name;
  EXPECT_GT(below.summary.steps.back().softness.value_or(1.0), 0.0) << name;
  Solution above = Pressed(scene, critical, 1.0 + width);
  EXPECT_GE(NegativeModes(above), modes) << name;
  EXPECT_LT(above.summary.steps.back().softness.value_or(1.0), 0.0) << name;
  EXPECT_GT(above.summary.steps.back().mode.size(), 0) << name;
  Measured("buckling: " + name + ", bracket of the classical load", width);
  return above;
}

// Euler's column, hinged at both ends: P = pi^2 E I / L^2.
TEST(HardBucklingTest, HingedColumnAtEulersLoad) {
  const double critical = M_PI * M_PI * 1.2e6 * 1e-3 / 12.0 / 100.0;
  ExpectBracket("hinged column",
                R"(
name: column
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [24, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports: [{on: u_min, fix: [x, z]}, {on: u_max, fix: [z]}, {on: v_min, fix: [y]}]
loads: [{kind: edge, on: u_max, force: [-$p, 0, 0]}]
)",
                critical,
                2e-3);
}

std::string Plate(int length) {
  return "name: plate\nsurface: {kind: plane, u: [0, " + std::to_string(length) +
         "], v: [0, 1], divisions: [" + std::to_string(12 * length) + ", 12]}\n" + R"(
shell: {thickness: 0.002, young_modulus: 1, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: rim, fix: [z]}
  - {on: u_min, fix: [x]}
  - {on: {near: [0, 0.5, 0], radius: 0}, fix: [y]}
loads: [{kind: edge, on: u_max, force: [-$p, 0, 0]}]
)";
}

// A simply supported plate of width b, as long as it is wide or twice as long: 4 pi^2 D / b^2, in
// one half wave and in two.
TEST(HardBucklingTest, SimplySupportedPlateAtItsClassicalLoad) {
  const double d = std::pow(0.002, 3) / (12.0 * (1.0 - 0.09));
  for (const int length : {1, 2}) {
    const Solution above = ExpectBracket(
        "plate " + std::to_string(length) + ":1", Plate(length), 4.0 * M_PI * M_PI * d, 2e-3);
    EXPECT_EQ(NegativeModes(above), 1);
    above.problem->displacements() = above.summary.steps.back().mode;
    const auto at = [&](double u) {
      return above.problem->Displacement(above.problem->surface().domain().Locate(u, 0.5)).z();
    };
    const double half = at(0.5);
    EXPECT_GT(std::abs(half), 0.9);  // 1 is the largest control value
    if (length == 2) {
      EXPECT_NEAR(at(1.5) / half, -1.0, 0.01);
      EXPECT_NEAR(at(1.0) / half, 0.0, 0.01);
    }
    EXPECT_NEAR(at(0.25) / half, std::sin(M_PI / 4.0), 0.01);
  }
}

// A closed sphere under pressure from outside: p = 2 E (h/R)^2 / sqrt(3 (1 - nu^2)), many modes at
// once. At R/h = 20 it has shrunk by 2 % there, which the classical load does not know. Arc length
// keeps to the fundamental path.
TEST(HardBucklingTest, SphereUnderExternalPressure) {
  const double critical = 2.0 * 0.05 * 0.05 / std::sqrt(3.0 * (1.0 - 0.09));
  const Solution above = ExpectBracket("sphere",
                                       R"(
name: sphere
surface: {kind: icosphere, radius: 1, frequency: 8}
shell: {thickness: 0.05, young_modulus: 1, poisson_ratio: 0.3}
model: {theory: nonlinear}
loads: [{kind: pressure, value: -$p}]
path: {control: arc_length}
)",
                                       critical,
                                       0.04,
                                       2);
  EXPECT_EQ(above.summary.steps.front().negative_modes.value_or(-1), 0);
}

// The lowest mode is in the file that people look at, where the state is unstable.
TEST(HardBucklingTest, ModeIsWrittenToTheResults) {
  const double d = std::pow(0.002, 3) / (12.0 * (1.0 - 0.09));
  const TemporaryFolder temporary("hard_buckling");
  const std::filesystem::path& folder = temporary.path();
  for (const double factor : {0.5, 1.01}) {
    const Solution solution = Pressed(Plate(1), 4.0 * M_PI * M_PI * d, factor);
    Results results;
    std::string error;
    ASSERT_TRUE(WriteResults(
        folder.string(), *solution.problem, solution.summary, nullptr, &results, &error))
        << error;
    const Vtu vtu = ReadVtu(folder / "shell.vtu");
    EXPECT_EQ(vtu.arrays.count("lowest_mode"), factor > 1.0 ? 1u : 0u);
    EXPECT_EQ(results.summary["stability"]["negative_modes"], factor > 1.0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace darboux
