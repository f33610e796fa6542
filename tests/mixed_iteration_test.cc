// How many iterations large deformations take, and that it does not matter where they start.
#include "solver/mixed_iteration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "geometry/icosphere.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Budget {
  const char* file;
  int iterations;
};

class IterationsTest : public ::testing::TestWithParam<Budget> {};

// Full load at once, certified by Ceres' gradient.
TEST_P(IterationsTest, FullLoadAtOnceWithin) {
  Scene scene = SceneFromData(GetParam().file);
  scene.steps = 1;
  const Solution solution = SolveScene(scene);
  EXPECT_LE(solution.summary.iterations, GetParam().iterations);
  EXPECT_LE(solution.summary.gradient_norm, 1e-7);
  EXPECT_EQ(solution.summary.steps.back().negative_modes, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         IterationsTest,
                         ::testing::Values(Budget{"cantilever_shear.yaml", 12},
                                           Budget{"cantilever_shear_thin.yaml", 12},
                                           Budget{"cantilever_moment.yaml", 15},
                                           Budget{"cantilever_moment_two_circles.yaml", 30},
                                           Budget{"slit_annulus.yaml", 15},
                                           Budget{"pinched_hemisphere.yaml", 15},
                                           Budget{"inflated_sphere.yaml", 12},
                                           Budget{"nonlinear_plate_p10.yaml", 12},
                                           Budget{"nonlinear_plate_p50.yaml", 12},
                                           Budget{"nonlinear_plate_p1000.yaml", 12}),
                         [](const auto& info) {
                           const std::string name = info.param.file;
                           return name.substr(0, name.find('.'));
                         });

Scene Strip(double thickness) {
  // The bending stiffness, and with it the elastica, stays.
  Scene scene = SceneFromText(R"(
name: strip
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [62, 1], grading: [-0.3, 0]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, force: [0, 0, 4]}
probes:
  - {name: tip, at: {uv: [10, 0.5]}}
)");
  scene.shell.thickness = thickness;
  scene.shell.young_modulus = 1.2e6 * std::pow(0.1 / thickness, 3);
  return scene;
}

TEST(MixedIterationTest, IterationsDoNotDependOnTheThickness) {
  for (const double thickness : {0.1, 0.01, 0.001}) {
    const Solution solution = SolveScene(Strip(thickness));
    EXPECT_LE(solution.summary.iterations, 12) << thickness;
    // Inextensible elastica (6.69964181); at h = 0.1 stretching adds 4e-5.
    EXPECT_NEAR(solution.Probe().z(), 6.6996, 1e-3) << thickness;
  }
}

TEST(MixedIterationTest, ConvergesQuadraticallyToTheStateOfDescent) {
  Scene scene = Strip(0.1);
  const Solution mixed = SolveScene(scene);
  SolverOptions tight;
  tight.gradient_tolerance = 1e-11;
  const Solution tighter = SolveScene(scene, tight);
  EXPECT_LE(tighter.summary.iterations, mixed.summary.iterations + 1);
  EXPECT_LE((tighter.Probe() - mixed.Probe()).norm(), 1e-8 * mixed.Probe().norm());
}

Eigen::Matrix3Xd RandomState(const Scene& scene, double part, unsigned seed) {
  ShellProblem::Options options;
  options.nonlinear = true;
  std::string error;
  const auto problem = ShellProblem::Create(scene, options, &error);
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::Matrix3Xd state = problem->displacements();
  for (int i = 0; i < state.cols(); ++i) {
    if (!problem->IsFree(i)) continue;
    for (int c = 0; c < 3; ++c) state(c, i) = part * problem->surface().size() * uniform(generator);
  }
  return state;
}

// Control vertices thrown about by 5 % of the size: the shell starts crumpled.
TEST(MixedIterationTest, RandomStartsReachTheSameEnergy) {
  Scene plate = SceneFromData("nonlinear_plate_p50.yaml");
  plate.surface.divisions = {10, 10};
  Scene strip = Strip(0.1);
  strip.surface.divisions = {32, 2};
  Scene annulus = SceneFromData("slit_annulus.yaml");
  annulus.surface.divisions = {4, 32};
  for (const Scene& scene : {plate, strip, annulus}) {
    const Solution from_rest = SolveScene(scene);
    int same = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SolverOptions options;
      options.initial_displacements = RandomState(scene, 0.05, seed);
      const Solution solution = SolveScene(scene, options);
      const double difference =
          std::abs(solution.summary.energy_total - from_rest.summary.energy_total);
      if (difference <= 1e-6 * std::abs(from_rest.summary.energy_total)) ++same;
    }
    EXPECT_GE(same, 9) << scene.name;
  }
}

TEST(MixedIterationTest, StartThatLeadsElsewhereIsNamed) {
  Scene strip = Strip(0.1);
  strip.surface.divisions = {32, 2};
  SolverOptions options;
  options.initial_displacements = RandomState(strip, 0.05, 1);
  const Solution solution = SolveScene(strip, options);
  ASSERT_FALSE(solution.summary.decisions.empty());
  EXPECT_THAT(solution.summary.decisions.front(), HasSubstr("from the given start"));
}

// Between fingers the undeformed shell has no energy, as nothing touches it.
TEST(MixedIterationTest, AGraspStartsFromItsAnswer) {
  Scene scene = SceneFromData("tennis_ball.yaml");
  scene.surface.mesh = std::make_shared<const TriangleMesh>(MakeSmoothIcosphere(31.25, 4));
  const Solution from_rest = SolveScene(scene);
  SolverOptions options;
  options.initial_displacements = from_rest.problem->displacements();
  const Solution again = SolveScene(scene, options);
  EXPECT_THAT(again.summary.decisions.front(),
              AllOf(HasSubstr("from the given start"), Not(HasSubstr("from rest instead"))));
  EXPECT_LT(again.summary.iterations, 0.5 * from_rest.summary.iterations);
  const double force = from_rest.summary.steps.back().fingers[0].force.norm();
  EXPECT_NEAR(again.summary.steps.back().fingers[0].force.norm(), force, 1e-5 * force);
}

TEST(MixedIterationTest, StartOfTheWrongSizeIsRefused) {
  const Scene scene = Strip(0.1);
  SolverOptions options;
  options.initial_displacements = Eigen::Matrix3Xd::Zero(3, 7);
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  EXPECT_FALSE(Solve(scene, options, &problem, &summary, &error));
  EXPECT_THAT(error, HasSubstr("initial_displacements"));
}

TEST(MixedIterationTest, StepsAreCountedAndExplained) {
  const Solution solution = SolveScene(Strip(0.1));
  ASSERT_EQ(solution.summary.decisions.size(), 1u);
  EXPECT_THAT(solution.summary.decisions[0], HasSubstr("mixed iteration to load factor 1"));
  EXPECT_THAT(solution.summary.decisions[0],
              HasSubstr(std::to_string(solution.summary.iterations) + " iterations"));
}

}  // namespace
}  // namespace darboux
