#include "solver/adaptive_grading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "solver/goal_response.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

LatticeAdvice Advise(const Scene& scene) {
  Solution solution = SolveScene(scene);
  GoalResponse response;
  EXPECT_TRUE(EvaluateGoalResponse(solution.problem.get(),
                                   GoalsOf(scene, solution.summary),
                                   SparseBackend::kAuto,
                                   1,
                                   &response));
  return AdviseLattice(*solution.problem, response.duals);
}

Scene PinchedCylinder(int cells) {
  Scene scene = SceneFromData("pinched_cylinder.yaml");
  scene.surface.grading = {0.0, 0.0};
  scene.surface.divisions = {cells, cells};
  return scene;
}

TEST(AdaptiveGradingTest, CellsMoveTowardsAPointForce) {
  // The force is at the upper end of u and the lower end of v.
  const LatticeAdvice advice = Advise(PinchedCylinder(16));
  EXPECT_LT(advice.maps[0].Size(0.95), 0.4 * advice.maps[0].Size(0.05));
  EXPECT_LT(advice.maps[1].Size(0.05), 0.5 * advice.maps[1].Size(0.95));
  EXPECT_GT(advice.gain, 2.0);
}

TEST(AdaptiveGradingTest, EqualCellsAlongAnIsotropicProblemStayInProportion) {
  const LatticeAdvice advice = Advise([] {
    Scene scene = SceneFromData("clamped_plate.yaml");
    scene.surface.divisions = {12, 12};
    return scene;
  }());
  EXPECT_NEAR(advice.proportion, 1.0, 0.02);
  EXPECT_LT(advice.gain, 1.5);
  EXPECT_NEAR(advice.totals[0], advice.totals[1], 0.02 * advice.totals[0]);
}

TEST(AdaptiveGradingTest, RowsAreTakenFromTheDirectionThatNeedsNone) {
  // A wave of cos(2 v) around, half a wave along: twice as many cells around.
  Scene scene = SceneFromData("cylinder_harmonic.yaml");
  scene.surface.divisions = {12, 12};
  EXPECT_LT(Advise(scene).proportion, 0.7);
}

TEST(AdaptiveGradingTest, RepeatedAdviceSettlesAndCutsTheError) {
  Scene scene = PinchedCylinder(12);
  const double exact = -1.828195198757057e-5;  // as in convergence_test.cc
  const double uniform = std::abs(SolveScene(scene).Probe()[2] / exact - 1.0);
  double change = 0.0;
  for (int k = 0; k < 5; ++k) {
    const LatticeAdvice advice = Advise(scene);
    scene.surface.grading_maps = advice.maps;
    change = advice.change;
  }
  EXPECT_LT(change, 0.1);
  EXPECT_LT(std::abs(SolveScene(scene).Probe()[2] / exact - 1.0), 0.25 * uniform);
}

TEST(AdaptiveGradingTest, UnitsOfTheSceneDoNotMatter) {
  Scene small = PinchedCylinder(8);
  const LatticeAdvice a = Advise(small);
  // Forces and moduli by a factor: the same displacements.
  small.shell.young_modulus *= 1e6;
  for (int i = 0; i < 3; ++i) {
    auto& force = small.loads[0].force.component[i].expression;
    const double none[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
    force = Expression::Constant(1e6 * force.Evaluate(none));
  }
  const LatticeAdvice b = Advise(small);
  EXPECT_NEAR(a.proportion, b.proportion, 1e-9);
  for (const double f : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(a.maps[0].Size(f), b.maps[0].Size(f), 1e-9 * a.maps[0].Size(f));
  }
}

TEST(AdaptiveGradingTest, FewCellsAreLeftAsTheyAre) {
  Scene scene = PinchedCylinder(8);
  scene.surface.divisions = {2, 8};
  const LatticeAdvice advice = Advise(scene);
  EXPECT_TRUE(advice.maps[0].is_identity());
  EXPECT_EQ(advice.proportion, 0.25);
}

struct DivisionsCase {
  double cells, proportion;
  std::array<int, 2> least, multiple, expected;
};

class DivisionsForTest : public ::testing::TestWithParam<DivisionsCase> {};

TEST_P(DivisionsForTest, KeepsNumberProportionAndMultiples) {
  const DivisionsCase& c = GetParam();
  EXPECT_EQ(DivisionsFor(c.cells, c.proportion, c.least, c.multiple), c.expected);
}

INSTANTIATE_TEST_SUITE_P(Lattices,
                         DivisionsForTest,
                         ::testing::Values(DivisionsCase{64.0, 1.0, {2, 2}, {2, 2}, {8, 8}},
                                           DivisionsCase{64.0, 1.0, {2, 2}, {1, 1}, {8, 8}},
                                           DivisionsCase{128.0, 1.0, {2, 2}, {2, 2}, {12, 12}},
                                           DivisionsCase{128.0, 1.0, {2, 2}, {1, 1}, {11, 11}},
                                           DivisionsCase{64.0, 100.0, {2, 2}, {2, 2}, {32, 2}},
                                           DivisionsCase{64.0, 0.01, {6, 2}, {2, 2}, {6, 10}}));

TEST(LargestDivisionsTest, UsesTheRoomInTheProportion) {
  std::array<int, 2> divisions;
  ASSERT_TRUE(LargestDivisions(1100, 0.54, {2, 2}, {1, 1}, &divisions));
  EXPECT_LE(3 * (divisions[0] + 3) * (divisions[1] + 3), 1100);
  EXPECT_GT(3 * (divisions[0] + 3) * (divisions[1] + 3), 1060);
  EXPECT_NEAR(divisions[0] / (0.54 * divisions[1]), 1.0, 0.2);
  ASSERT_TRUE(LargestDivisions(1100, 1.0, {2, 2}, {2, 2}, &divisions));
  EXPECT_EQ(divisions[0] % 2 + divisions[1] % 2, 0);
  EXPECT_FALSE(LargestDivisions(50, 1.0, {2, 2}, {1, 1}, &divisions));
}

}  // namespace
}  // namespace darboux
