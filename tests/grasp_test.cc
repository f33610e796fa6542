// Shells between rigid fingers: forces against reference values, penetration, balance, theories,
// minimisers, units.
#include "solver/grasp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

// The tennis ball between two spheres, everything of length times `unit`.
Scene Ball(int frequency, double travel, const std::string& model = "", double unit = 1.0) {
  std::ostringstream text;
  text.precision(17);
  text << "name: ball\nsurface: {kind: icosphere, radius: " << 31.25 * unit
       << ", frequency: " << frequency << "}\nshell: {thickness: " << 2.5 * unit
       << ", young_modulus: " << 1.0 / (unit * unit) << ", poisson_ratio: 0.5}\n"
       << model << "supports:\n";
  for (const char* sign : {"", "-"}) {
    text << "  - {on: {near: [0, 0, " << sign << 31.25 * unit << "], radius: 0}, fix: [x, y]}\n";
  }
  text << "fingers:\n";
  for (const bool top : {true, false}) {
    text << "  - {name: " << (top ? "top" : "bottom")
         << ", shape: {kind: sphere, radius: " << 2.0 * unit << "}, position: [0, 0, "
         << (top ? 40.0 : -40.0) * unit << "], direction: [0, 0, " << (top ? -1 : 1)
         << "], motion: {travel: " << travel * unit << "}}\n";
  }
  return SceneFromText(text.str());
}

const FingerReport& Top(const Solution& solution) {
  return solution.summary.steps.back().fingers.at(0);
}

struct Squeeze {
  double travel, force;
};

class BallBetweenSpheresTest : public ::testing::TestWithParam<Squeeze> {};

// One call each, straight to the travel; N at E = 1 MPa. The reference is a prototype that let the
// spheres in by 1.4e-2 h at a travel of 1 mm, and less than that of a percent of the force later:
// its shell has been squeezed by so much less.
TEST_P(BallBetweenSpheresTest, HasTheReferenceForce) {
  const double penetration = 1.4e-2 * 2.5;
  const Solution solution = SolveScene(Ball(12, GetParam().travel - penetration));
  EXPECT_NEAR(Top(solution).normal_force, GetParam().force, 0.02 * GetParam().force);
  EXPECT_LE(Top(solution).penetration, 1e-3 * 2.5);
  EXPECT_LE(solution.summary.force_balance, 1e-6);
  EXPECT_LE(solution.summary.gradient_norm, 1e-7);
  EXPECT_NEAR(Top(solution).shift, 40.0 - 31.25 - 1.25 - 2.0, 1e-3);
  const FingerReport& bottom = solution.summary.steps.back().fingers.at(1);
  EXPECT_NEAR(bottom.normal_force, Top(solution).normal_force, 1e-6 * bottom.normal_force);
}

INSTANTIATE_TEST_SUITE_P(TravelMm,
                         BallBetweenSpheresTest,
                         ::testing::Values(Squeeze{1.0, 0.407},
                                           Squeeze{4.0, 1.025},
                                           Squeeze{8.0, 1.335},
                                           Squeeze{10.27, 1.501}),
                         [](const auto& info) {
                           return std::to_string(static_cast<int>(100 * info.param.travel));
                         });

TEST(GraspTest, LinearTheoryIsFarOff) {
  const Solution nonlinear = SolveScene(Ball(6, 4.0));
  const Solution linear = SolveScene(Ball(6, 4.0, "model: {theory: linear}\n"));
  EXPECT_EQ(linear.summary.theory, Theory::kLinear);
  EXPECT_GT(Top(linear).normal_force, 1.5 * Top(nonlinear).normal_force);
}

TEST(GraspTest, CeresFindsTheSameEnergy) {
  const Solution mixed = SolveScene(Ball(4, 1.0));
  const Solution ceres = SolveScene(Ball(4, 1.0, "model: {minimizer: ceres}\n"));
  EXPECT_NEAR(
      ceres.summary.energy_total, mixed.summary.energy_total, 1e-3 * mixed.summary.energy_total);
  EXPECT_NEAR(Top(ceres).normal_force, Top(mixed).normal_force, 2e-3 * Top(mixed).normal_force);
}

TEST(GraspTest, MillimetresAndMetresAgree) {
  SolverOptions options;
  options.gradient_tolerance = 1e-11;
  const Solution mm = SolveScene(Ball(4, 2.0), options);
  const Solution m = SolveScene(Ball(4, 2.0, "", 1e-3), options);
  EXPECT_NEAR(Top(m).normal_force, Top(mm).normal_force, 1e-9 * Top(mm).normal_force);
}

TEST(GraspTest, FlattenedBallFollowsThePublishedForce) {
  const Solution solution = SolveScene(SceneFromData("ping_pong.yaml"));
  const double expected[] = {1.08, 2.34, 3.89, 5.72};
  ASSERT_EQ(solution.summary.steps.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const FingerReport& top = solution.summary.steps[i].fingers.at(0);
    const double force = 0.02 * top.normal_force / (2.2e9 * std::pow(0.0004, 3));
    EXPECT_NEAR(force, expected[i], 0.05 * expected[i]) << i;
    EXPECT_LE(top.penetration, 1e-3 * 0.0004);
  }
}

// A ball on a rough floor, a fingertip on it; nothing else holds it.
Scene BallOnFloor(const std::string& gas) {
  return SceneFromText(
      "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: 4}\n"
      "shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n" +
      gas +
      "fingers:\n"
      "  - {name: top, shape: {kind: sphere, radius: 4}, position: [0, 0, 45], "
      "direction: [0, 0, -1], motion: {travel: 2}, friction: 0.5}\n"
      "  - {name: floor, shape: {kind: plane}, position: [0, 0, -45], direction: [0, 0, 1], "
      "motion: {travel: 0}, friction: 0.5}\n");
}

TEST(GraspTest, ATipSmallerThanTheTrianglesIsInTheWayOfTheShell) {
  // On this mesh no corner and no centroid lies within the tip's way along the axis.
  const Scene scene = SceneFromText(
      "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: 3}\n"
      "shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
      "supports:\n  - {on: {near: [0, 0, -31.25], radius: 12}, fix: [x, y, z]}\n"
      "fingers:\n  - {name: top, shape: {kind: sphere, radius: 2}, position: [0, 0, 40], "
      "direction: [0, 0, -1], motion: {travel: 1}}\n");
  std::string error;
  const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
  ASSERT_NE(problem, nullptr) << error;
  // From 40 to where the tip's centre is half the wall and its radius above the pole.
  const double shift = problem->grasp()->Report(1.0).at(0).shift;
  EXPECT_NEAR(shift, 40.0 - 31.25 - 1.25 - 2.0, 0.05);
}

TEST(GraspTest, FrictionHoldsABallEmptyOrFull) {
  double empty = 0.0;
  for (const char* gas :
       {"", "loads:\n  - {kind: gas, gauge_pressure: 0, ambient_pressure: 0.101325}\n"}) {
    const Solution solution = SolveScene(BallOnFloor(gas));
    const FingerReport& top = Top(solution);
    const FingerReport& floor = solution.summary.steps.back().fingers.at(1);
    EXPECT_GT(top.sticking, 0);
    EXPECT_EQ(top.sticking + top.slipping, top.contact_points);
    EXPECT_GT(floor.sticking, 0);
    EXPECT_LE(solution.summary.force_balance, 1e-6);
    EXPECT_LE((top.force + floor.force).norm(), 1e-5 * top.force.norm());
    EXPECT_LE(top.penetration, 5e-4 * 2.5);
    EXPECT_LE(solution.summary.iterations, 100);
    EXPECT_GT(top.normal_force, empty);
    empty = top.normal_force;
  }
}

TEST(GraspTest, SlidingFollowsCoulombsLaw) {
  // Pressed beside the pole: the contact's normal is 0.28 off the direction of travel.
  const double friction = 0.05;
  const Solution solution = SolveScene(SceneFromText(
      "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: 4}\n"
      "shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
      "supports:\n  - {on: {near: [0, 0, -31.25], radius: 12}, fix: [x, y, z]}\n"
      "fingers:\n  - {name: top, shape: {kind: sphere, radius: 4}, position: [10, 0, 45], "
      "direction: [0, 0, -1], motion: {travel: 0.7}, friction: 0.05}\n"));
  EXPECT_GT(Top(solution).slipping, 0);
  const Eigen::Matrix3Xd& displacements = solution.problem->displacements();
  for (const Grasp::Block& block : solution.problem->grasp()->blocks()) {
    std::vector<const double*> parameters;
    for (const int vertex : solution.problem->surface().control_vertices(block.element)) {
      parameters.push_back(displacements.col(vertex).data());
    }
    std::vector<ContactState> contact;
    ASSERT_TRUE(block.contact->States(parameters.data(), &contact));
    const std::vector<FrictionState> states = block.friction->States(parameters.data());
    for (size_t q = 0; q < states.size(); ++q) {
      if (!(contact[q].pressure > 0.0)) continue;
      const double limit = friction * contact[q].force_on_finger.norm();
      const double tangential = states[q].force_on_finger.norm();
      EXPECT_LE(tangential, 1.005 * limit);
      if (states[q].sticks) continue;
      EXPECT_NEAR(tangential, limit, 5e-3 * limit);
      // The finger is dragged along by the slip of the shell.
      EXPECT_NEAR(states[q].force_on_finger.dot(states[q].slip),
                  tangential * states[q].slip.norm(),
                  1e-9 * limit * states[q].slip.norm());
    }
  }
}

TEST(GraspTest, FingerThatMissesIsAnError) {
  Scene scene = Ball(4, 1.0);
  scene.fingers[0].direction = {1.0, 0.0, 0.0};
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  EXPECT_FALSE(Solve(scene, SolverOptions(), &problem, &summary, &error));
  EXPECT_THAT(error, HasSubstr("fingers[0]"));
  EXPECT_THAT(error, HasSubstr("never touches"));
}

TEST(GraspTest, SceneWithoutFingersHasNoContact) {
  const Solution solution = SolveScene(SceneFromData("clamped_plate.yaml"));
  EXPECT_EQ(solution.problem->grasp(), nullptr);
  EXPECT_FALSE(solution.problem->effect(Effect::kContact).on);
  EXPECT_EQ(solution.problem->effect(Effect::kContact).residual_blocks, 0);
}

}  // namespace
}  // namespace darboux
