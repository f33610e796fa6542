// Hard cases: conditioning. At 1e5 dof errors still fall or stay at rounding, and gradients are
// small.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/hard_util.h"

namespace darboux {
namespace {

struct Case {
  const char* name;
  const char* file;
  double exact;  // z of the first probe; data/README.md
  double floor;  // relative error at which rounding may take over
};

class ConditioningTest : public ::testing::TestWithParam<Case> {};

TEST_P(ConditioningTest, ErrorsFallUpToAHundredThousandDof) {
  Scene scene = SceneFromData(GetParam().file);
  double previous = INFINITY;
  for (const int n : {32, 64, 128, 182}) {
    scene.surface.divisions = {n, n};
    const Solution solution = SolveScene(scene);
    const double error = std::abs(solution.Probe().z() / GetParam().exact - 1.0);
    EXPECT_LE(solution.summary.gradient_norm, 1e-7) << n;
    EXPECT_LE(solution.summary.force_balance, 1e-7) << n;
    EXPECT_TRUE(error < previous || error <= GetParam().floor) << n << ": " << error;
    previous = std::max(error, GetParam().floor);
    Measured("conditioning: " + std::string(GetParam().name) + ", error at dof " +
                 std::to_string(solution.summary.dof),
             error);
    if (n == 182) {
      EXPECT_GE(solution.summary.dof, 100000);
      Measured("conditioning: " + std::string(GetParam().name) + ", gradient",
               solution.summary.gradient_norm);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    ConditioningTest,
    ::testing::Values(Case{"clamped_plate", "clamped_plate.yaml", 0.13817284435, 1e-8},
                      Case{"supported_plate", "simply_supported_plate.yaml", 0.44360891054, 1e-8},
                      Case{"pinched_cylinder", "pinched_cylinder.yaml", -1.828195199e-5, 1e-8}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace darboux
