#include "solver/accuracy.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "geometry/icosphere.h"
#include "solver/goal_response.h"
#include "tests/refine_util.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr char kPlate[] = R"(
name: clamped-plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}, {name: quarter, at: {uv: [25, 50]}}]
)";

// A scene of data/ without what its author chose for accuracy.
Scene Unrefined(const char* name, double accuracy) {
  Scene scene = SceneFromData(name);
  scene.surface.grading = {0.0, 0.0};
  scene.surface.grading_given = false;
  scene.model.quadrature = 3;
  scene.model.quadrature_given = false;
  scene.model.accuracy = accuracy;
  return scene;
}

// Of the quantities that the scene expects, relative to the size of the goal they belong to.
double TrueError(const Scene& scene, const SolverSummary& summary) {
  double largest = -1.0;
  for (const Goal& goal : GoalsOf(scene, summary)) {
    for (const ExpectSpec& expect : scene.expect) {
      for (int i = 0; i < 3; ++i) {
        if (expect.quantity != goal.name + ".displacement." + "xyz"[i]) continue;
        largest = std::max(largest, std::abs(goal.value[i] - expect.value) / goal.size);
      }
    }
  }
  EXPECT_GE(largest, 0.0) << "no expectation of " << scene.name;
  return largest;
}

class EffectivityTest : public ::testing::TestWithParam<std::tuple<const char*, double>> {};

TEST_P(EffectivityTest, EstimateIsTheErrorWithinAFactor) {
  const auto [name, accuracy] = GetParam();
  const Scene scene = Unrefined(name, accuracy);
  const Refined refined = Refine(scene);
  ASSERT_TRUE(refined.report.reached) << refined.report.message;
  const double error = TrueError(scene, refined.summary);
  const double effectivity = *refined.report.discretisation / error;
  std::printf("  %-22s accuracy %.0e: %6d dof, error %.2e, estimate %.2e, effectivity %.2f\n",
              scene.name.c_str(),
              accuracy,
              refined.summary.dof,
              error,
              *refined.report.discretisation,
              effectivity);
  EXPECT_GE(effectivity, 0.3);
  EXPECT_LE(error, accuracy);
  // Where the error changes its sign on the way it is smaller than any estimate by chance.
  const std::string which = name;
  const bool by_chance = accuracy < 1e-3 && which == "expression_cylinder.yaml";
  EXPECT_TRUE(by_chance || effectivity <= 5.0) << effectivity;
}

INSTANTIATE_TEST_SUITE_P(Benchmarks,
                         EffectivityTest,
                         ::testing::Combine(::testing::Values("clamped_plate.yaml",
                                                              "simply_supported_plate.yaml",
                                                              "pinched_cylinder.yaml",
                                                              "cylinder_harmonic.yaml",
                                                              "expression_cylinder.yaml",
                                                              "nonlinear_plate_p10.yaml",
                                                              "nonlinear_plate_p50.yaml",
                                                              "inflated_sphere.yaml",
                                                              "monkey_saddle.yaml"),
                                            ::testing::Values(1e-2, 1e-3, 1e-4)));
INSTANTIATE_TEST_SUITE_P(Stretched,
                         EffectivityTest,
                         ::testing::Combine(::testing::Values("nonlinear_plate_p1000.yaml"),
                                            ::testing::Values(1e-2, 1e-3)));

struct Budget {
  int dof;
  double error;
};

class BudgetTest : public ::testing::TestWithParam<Budget> {};

TEST_P(BudgetTest, PinchedCylinderReachesItWithoutGradingByHand) {
  const Scene scene = Unrefined("pinched_cylinder.yaml", 1e-9);
  AccuracyOptions options;
  options.max_dof = GetParam().dof;
  const Refined refined = Refine(scene, options);
  EXPECT_LE(refined.summary.dof, GetParam().dof);
  const double error = TrueError(scene, refined.summary);
  std::printf("  %d dof: error %.2e, estimate %.2e\n",
              refined.summary.dof,
              error,
              *refined.report.discretisation);
  EXPECT_LE(error, GetParam().error);
}

INSTANTIATE_TEST_SUITE_P(Dof,
                         BudgetTest,
                         ::testing::Values(Budget{1100, 1e-3}, Budget{4000, 1e-4}));

TEST(AccuracyTest, AnswersThatLockAreNotTakenForConverged) {
  // Parameter lines 5 degrees apart: on 30 x 8 cells a tenth of the displacement, estimated to be
  // right to 8 %. 6.857928392136e-2: closed form of data/cylinder_harmonic.yaml.
  const Refined refined = Refine(SceneFromText(R"yaml(
name: sheared
surface: {kind: expression, position: ["u", "300*sin(v + 11.43*u/300)", "300*cos(v + 11.43*u/300)"],
          u: [0, 600], v: [0, 2*pi], divisions: [16, 48], periodic: [false, true]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear, quadrature: 6, accuracy: 0.1}
supports: [{on: u_min, fix: [y, z]}, {on: u_max, fix: [y, z]}]
loads: [{kind: normal_traction, value: "cos(2*(v + 11.43*u/300))*sin(pi*u/600)"}]
probes: [{name: top, at: {nearest: [300, 0, 300]}}]
)yaml"));
  EXPECT_TRUE(refined.report.reached) << refined.report.message;
  const double error =
      std::abs(refined.summary.probes[0].displacement.z() / 6.857928392136e-2 - 1.0);
  EXPECT_LE(error, 0.1);
}

TEST(AccuracyTest, LevelsGrowUntilTheEstimateIsReached) {
  Scene scene = SceneFromText(kPlate);
  scene.model.accuracy = 1e-4;
  int num_calls = 0;
  AccuracyOptions options;
  options.on_level = [&](const AccuracyLevel&) { ++num_calls; };
  const Refined refined = Refine(scene, options);
  const AccuracyReport& report = refined.report;
  EXPECT_TRUE(report.reached);
  ASSERT_GE(report.levels.size(), 3u);
  EXPECT_EQ(num_calls, static_cast<int>(report.levels.size()));
  EXPECT_FALSE(report.levels[0].estimate.has_value());
  EXPECT_LE(*report.estimate, 1e-4);
  EXPECT_EQ(report.discretisation, report.levels.back().estimate);
  for (size_t i = 1; i < report.levels.size(); ++i) {
    EXPECT_GT(report.levels[i].elements, 1.2 * report.levels[i - 1].elements);
    for (const int divisions : report.levels[i].divisions) EXPECT_EQ(divisions % 2, 0);
  }
  EXPECT_EQ(refined.problem->scene().surface.divisions, report.levels.back().divisions);
  EXPECT_EQ(refined.summary.dof, report.levels.back().dof);
  EXPECT_TRUE(refined.summary.IsConverged());
  EXPECT_THAT(refined.summary.decisions, Contains(HasSubstr("accuracy 0.0001 reached")));
}

TEST(AccuracyTest, UnreachableAccuracyEndsAtTheDofLimitAndStaysConverged) {
  Scene scene = SceneFromText(kPlate);
  scene.model.accuracy = 1e-14;
  AccuracyOptions options;
  options.max_dof = 1500;
  const Refined refined = Refine(scene, options);
  EXPECT_FALSE(refined.report.reached);
  EXPECT_TRUE(refined.summary.IsConverged());
  EXPECT_LE(refined.summary.dof, 1500);
  EXPECT_GE(refined.summary.dof, 1200);  // what room there is is used
  EXPECT_THAT(refined.report.message, HasSubstr("not reached"));
  EXPECT_THAT(refined.report.message, HasSubstr("1500 dof"));
}

TEST(AccuracyTest, NextLevelThatDoesNotFitIntoTheTimeIsNotBegun) {
  Scene scene = SceneFromText(kPlate);
  scene.model.accuracy = 1e-14;
  SolverOptions solver;
  solver.time_limit_s = 1e-3;
  solver.gradient_tolerance = 1e-3;
  const Refined refined = Refine(scene, {}, solver);
  EXPECT_LE(refined.report.levels.size(), 1u);
  EXPECT_FALSE(refined.report.reached);
  EXPECT_FALSE(refined.report.estimate.has_value());
}

TEST(AccuracyTest, WithoutProbesDisplacementAndEnergyDecide) {
  Scene scene = SceneFromText(kPlate);
  scene.probes.clear();
  scene.model.accuracy = 0.01;
  const Refined refined = Refine(scene);
  EXPECT_TRUE(refined.report.reached);
  EXPECT_GT(*refined.report.estimate, 0.0);
}

TEST(AccuracyTest, NothingThatMovesHasNoError) {
  Scene scene = SceneFromText(kPlate);
  scene.loads.clear();
  scene.surface.divisions = {2, 2};
  scene.model.accuracy = 0.01;
  const Refined refined = Refine(scene);
  EXPECT_TRUE(refined.report.reached);
  EXPECT_EQ(*refined.report.estimate, 0.0);
}

TEST(AccuracyTest, HeldProbeIsMeasuredAgainstTheLargestDisplacement) {
  Scene scene = SceneFromText(kPlate);
  ProbeSpec held = scene.probes[0];
  held.name = "held";
  held.at.uv = {0.0, 50.0};
  scene.probes.push_back(held);
  scene.model.accuracy = 0.01;
  EXPECT_TRUE(Refine(scene).report.reached);
}

TEST(AccuracyTest, GradingThatTheSceneNamesIsKept) {
  Scene scene = SceneFromData("pinched_cylinder.yaml");
  scene.model.accuracy = 0.01;
  const Refined refined = Refine(scene);
  const SurfaceSpec& surface = refined.problem->scene().surface;
  EXPECT_EQ(surface.grading, scene.surface.grading);
  EXPECT_TRUE(surface.grading_maps[0].is_identity());
  EXPECT_EQ(surface.divisions[0], surface.divisions[1]);  // in the scene's proportions
}

TEST(AccuracyTest, SmoothShellsGetSixPointsAndPointForcesKeepThree) {
  EXPECT_EQ(Refine(Unrefined("cylinder_harmonic.yaml", 1e-4)).report.levels.back().quadrature, 6);
  EXPECT_EQ(Refine(Unrefined("pinched_cylinder.yaml", 1e-3)).report.levels.back().quadrature, 3);
  Scene scene = Unrefined("cylinder_harmonic.yaml", 1e-4);
  scene.model.quadrature_given = true;
  EXPECT_EQ(Refine(scene).report.levels.back().quadrature, 3);
}

// The plate of kPlate under a load times `factor`, theory auto; the nonlinear terms change the
// centre of an eighth of the load by 1.2e-4 of it.
Refined RefineAuto(double factor, double accuracy) {
  std::string text = kPlate;
  text.replace(text.find("value: 1"), 8, "value: " + std::to_string(factor));
  Scene scene = SceneFromText(text);
  scene.model.theory = Theory::kAuto;
  scene.model.accuracy = accuracy;
  return Refine(scene);
}

TEST(AccuracyTest, TheoryIsLinearWhereTheNonlinearOneWouldChangeLittle) {
  const Refined refined = RefineAuto(0.125, 1e-3);
  EXPECT_TRUE(refined.report.reached);
  EXPECT_EQ(refined.summary.theory, Theory::kLinear);
  EXPECT_THAT(refined.summary.theory_reason, HasSubstr("would change the goals by"));
  ASSERT_TRUE(refined.report.theory.has_value());
  EXPECT_GT(*refined.report.theory, 0.0);
  EXPECT_LE(*refined.report.theory, 5e-4);
  EXPECT_NEAR(*refined.report.estimate,
              *refined.report.discretisation + *refined.report.solver + *refined.report.theory,
              1e-15);
}

TEST(AccuracyTest, TheoryIsNonlinearWhereItChangesMoreThanHalfOfTheAccuracy) {
  const Refined refined = RefineAuto(4.0, 1e-3);
  EXPECT_TRUE(refined.report.reached);
  EXPECT_EQ(refined.summary.theory, Theory::kNonlinear);
  EXPECT_THAT(refined.summary.theory_reason, HasSubstr("it changes the goals by"));
  EXPECT_FALSE(refined.report.theory.has_value());
}

TEST(AccuracyTest, LinearTheoryThatTheSceneAsksForIsNotCountedAgainstIt) {
  Scene scene = SceneFromText(kPlate);
  scene.loads[0].value.expression = Expression::Constant(8.0);
  scene.model.accuracy = 1e-3;
  const Refined refined = Refine(scene);
  EXPECT_TRUE(refined.report.reached);
  EXPECT_GT(*refined.report.theory, 1e-2);
  EXPECT_THAT(refined.report.message, HasSubstr("not counted"));
}

TEST(AccuracyTest, SolverErrorIsThatOfTheDigitsOfANonlinearSolve) {
  Scene scene = Unrefined("nonlinear_plate_p10.yaml", 1e-2);
  SolverOptions loose;
  loose.gradient_tolerance = 1e-3;
  const Refined rough = Refine(scene, {}, loose);
  scene.model.accuracy.reset();
  scene.surface = rough.problem->scene().surface;
  const Solution exact = SolveScene(scene);
  const double error =
      (exact.Probe() - rough.summary.probes[0].displacement).norm() / exact.Probe().norm();
  ASSERT_TRUE(rough.report.solver.has_value());
  EXPECT_LE(error, 5.0 * *rough.report.solver + 1e-11);
}

TEST(AccuracyTest, MeshesAreRefinedWhereFingersTouch) {
  Scene scene;
  std::string error;
  ASSERT_TRUE(ParseScene(R"(
name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 6}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
model: {accuracy: 0.01}
supports:
  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 6}, position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 2}}
  - {name: bottom, shape: {kind: sphere, radius: 6}, position: [0, 0, -60], direction: [0, 0, 1], motion: {travel: 2}}
)",
                         "ball.yaml",
                         &scene,
                         &error))
      << error;
  const Refined refined = Refine(scene);
  ASSERT_TRUE(refined.report.reached) << refined.report.message;
  ASSERT_GE(refined.report.levels.size(), 2u);
  EXPECT_EQ(refined.report.levels[0].divisions[0], 0);
  EXPECT_GT(refined.report.levels[1].dof, refined.report.levels[0].dof);
  EXPECT_FALSE(refined.report.theory.has_value());  // not known of fingers
  // A finer ball has the same force within the accuracy and what its other shape does.
  Scene fine = scene;
  fine.model.accuracy.reset();
  fine.surface.mesh = std::make_shared<const TriangleMesh>(MakeIcosphere(31.25, 12));
  const double expected = SolveScene(fine).summary.steps.back().fingers[0].normal_force;
  EXPECT_NEAR(refined.summary.steps.back().fingers[0].normal_force, expected, 0.012 * expected);
}

}  // namespace
}  // namespace darboux
