// Fingers that forces drive: their travel is an unknown, and forces have limit points.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "solver/grasp.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Of both fingers, e.g. "travel: 4".
std::string Ball(const std::string& top,
                 const std::string& bottom,
                 const std::string& model = "",
                 double unit = 1.0) {
  std::ostringstream text;
  text.precision(17);
  text << "name: ball\nsurface: {kind: icosphere, radius: " << 31.25 * unit
       << ", frequency: 4}\nshell: {thickness: " << 2.5 * unit
       << ", young_modulus: " << 1.0 / (unit * unit) << ", poisson_ratio: 0.5}\n"
       << model << "supports:\n";
  for (const char* sign : {"", "-"}) {
    text << "  - {on: {near: [0, 0, " << sign << 31.25 * unit << "], radius: 0}, fix: [x, y]}\n";
  }
  text << "fingers:\n";
  for (const bool is_top : {true, false}) {
    text << "  - {name: " << (is_top ? "top" : "bottom")
         << ", shape: {kind: sphere, radius: " << 2.0 * unit << "}, position: [0, 0, "
         << (is_top ? 40.0 : -40.0) * unit << "], direction: [0, 0, " << (is_top ? -1 : 1)
         << "], motion: {" << (is_top ? top : bottom) << "}}\n";
  }
  return text.str();
}

std::string Motion(const std::string& what, double value) {
  std::ostringstream text;
  text.precision(17);
  text << what << ": " << value;
  return text.str();
}

// A shallow cap on a hinged rim, pushed at its top by a sphere of 20; the resistance has a maximum.
Scene Cap(const std::string& motion, int steps = 1) {
  return SceneFromText(
      "name: cap\n"
      "surface: {kind: expression, position: [\"u\", \"v\", \"8-8*(u*u+v*v)/2500\"], "
      "u: [-50, 50], v: [-50, 50], divisions: [12, 12]}\n"
      "shell: {thickness: 1, young_modulus: 1000, poisson_ratio: 0.3}\n"
      "supports: [{on: rim, simply_supported: true}]\n"
      "fingers: [{name: tip, shape: {kind: sphere, radius: 20}, position: [0, 0, 40], "
      "direction: [0, 0, -1], motion: {" +
      motion + "}}]\nsteps: " + std::to_string(steps) + "\n");
}

const FingerReport& Finger(const Solution& solution, int finger) {
  return solution.summary.steps.back().fingers.at(finger);
}

class ForceOfATravelTest : public ::testing::TestWithParam<double> {};

TEST_P(ForceOfATravelTest, LeadsToTheSameState) {
  const std::string travel = Motion("travel", GetParam());
  const Solution by_travel = SolveScene(SceneFromText(Ball(travel, travel)));
  const std::string force = Motion("force", Finger(by_travel, 0).force.norm());
  const Solution by_force = SolveScene(SceneFromText(Ball(force, force)));
  // Both fingers and the ball together may lie anywhere along their line.
  EXPECT_NEAR(0.5 * (Finger(by_force, 0).travel + Finger(by_force, 1).travel),
              GetParam(),
              1e-6 * GetParam());
  EXPECT_NEAR(Finger(by_force, 0).normal_force,
              Finger(by_travel, 0).normal_force,
              1e-6 * Finger(by_travel, 0).normal_force);
  EXPECT_LE(Finger(by_force, 0).penetration, 1e-3 * 2.5);
  EXPECT_LE(by_force.summary.force_balance, 1e-6);
  EXPECT_LE(by_force.summary.gradient_norm, 1e-7);
  EXPECT_TRUE(Finger(by_force, 0).by_force);
  // What the forces have done less is the work of the fingers.
  const double work =
      Finger(by_force, 0).force.norm() * (Finger(by_force, 0).travel + Finger(by_force, 1).travel);
  EXPECT_NEAR(by_force.summary.load_work, work, 1e-9 * work);
  EXPECT_NEAR(by_force.summary.energy_total + work,
              by_travel.summary.energy_total,
              1e-5 * by_travel.summary.energy_total);
}

INSTANTIATE_TEST_SUITE_P(Travels,
                         ForceOfATravelTest,
                         ::testing::Values(0.1, 1.0, 4.0, 10.27),
                         [](const auto& info) {
                           return std::to_string(static_cast<int>(100 * info.param));
                         });

TEST(ForceControlTest, OneFingerByForceTheOtherByTravel) {
  const Solution both = SolveScene(SceneFromText(Ball("travel: 3", "travel: 3")));
  const std::string force = Motion("force", Finger(both, 0).force.norm());
  const Solution mixed = SolveScene(SceneFromText(Ball("travel: 3", force)));
  EXPECT_NEAR(Finger(mixed, 1).travel, 3.0, 3e-6);
  EXPECT_NEAR(Finger(mixed, 0).normal_force,
              Finger(both, 0).normal_force,
              1e-6 * Finger(both, 0).normal_force);
}

TEST(ForceControlTest, CeresFindsTheSameState) {
  const Solution mixed = SolveScene(SceneFromText(Ball("force: 0.5", "force: 0.5")));
  const Solution ceres =
      SolveScene(SceneFromText(Ball("force: 0.5", "force: 0.5", "model: {minimizer: ceres}\n")));
  EXPECT_NEAR(ceres.summary.energy_total,
              mixed.summary.energy_total,
              1e-3 * std::abs(mixed.summary.energy_total));
  EXPECT_NEAR(Finger(ceres, 0).force.norm(), 0.5, 1e-6);
}

TEST(ForceControlTest, LinearTheory) {
  const std::string model = "model: {theory: linear}\n";
  const Solution travel = SolveScene(SceneFromText(Ball("travel: 0.5", "travel: 0.5", model)));
  const std::string motion = Motion("force", Finger(travel, 0).force.norm());
  const Solution force = SolveScene(SceneFromText(Ball(motion, motion, model)));
  EXPECT_NEAR(Finger(force, 0).travel + Finger(force, 1).travel, 1.0, 1e-6);
}

TEST(ForceControlTest, MillimetresAndMetresAgree) {
  SolverOptions options;
  options.gradient_tolerance = 1e-11;
  const Solution mm = SolveScene(SceneFromText(Ball("force: 0.8", "force: 0.8")), options);
  const Solution m = SolveScene(SceneFromText(Ball("force: 0.8", "force: 0.8", "", 1e-3)), options);
  const double travel = Finger(mm, 0).travel + Finger(mm, 1).travel;
  EXPECT_NEAR(1e3 * (Finger(m, 0).travel + Finger(m, 1).travel), travel, 1e-9 * travel);
}

TEST(ForceControlTest, LimitPointIsNamed) {
  const Solution sweep = SolveScene(Cap("travel: 14", 28));
  double largest = 0.0;
  for (const LoadStep& step : sweep.summary.steps) {
    largest = std::max(largest, step.fingers.at(0).force.norm());
  }
  const Solution below = SolveScene(Cap(Motion("force", 0.97 * largest)));
  EXPECT_FALSE(below.summary.steps.back().limit_point);
  const Solution beyond = SolveScene(Cap(Motion("force", 1.2 * largest)));
  ASSERT_TRUE(beyond.summary.steps.back().limit_factor.has_value());
  EXPECT_NEAR(*beyond.summary.steps.back().limit_factor, 1.0 / 1.2, 5e-3);
  EXPECT_THAT(beyond.summary.decisions, Contains(HasSubstr("limit point")));
  // Behind the snap: the cap is inside out.
  EXPECT_GT(Finger(beyond, 0).travel, 16.0);
}

TEST(ForceControlTest, ForcesThatDoNotBalanceAreAnError) {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  const Scene scene = SceneFromText(Ball("force: 0.8", "force: 0.5"));
  EXPECT_FALSE(Solve(scene, SolverOptions(), &problem, &summary, &error));
  EXPECT_THAT(error, HasSubstr("fingers[1]"));
  EXPECT_THAT(error, HasSubstr("do not balance"));
  // One of them with a travel takes what the other leaves.
  EXPECT_TRUE(Solve(SceneFromText(Ball("force: 0.8", "travel: 0.5")),
                    SolverOptions(),
                    &problem,
                    &summary,
                    &error));
}

// Without a support: friction holds the ball between a finger and a plane.
TEST(ForceControlTest, FrictionHoldsWhatForcesSqueeze) {
  std::string text = Ball("force: 0.8", "travel: 0");
  const size_t begin = text.find("supports:"), end = text.find("fingers:");
  text.erase(begin, end - begin);
  const std::string sphere = "{kind: sphere, radius: 2}";
  text.replace(text.rfind(sphere), sphere.size(), "{kind: plane}");
  for (const std::string motion : {"motion: {force: 0.8}", "motion: {travel: 0}"}) {
    text.replace(text.find(motion), motion.size(), motion + ", friction: 0.5");
  }
  const Solution solution = SolveScene(SceneFromText(text));
  EXPECT_NEAR(Finger(solution, 1).force.norm(), 0.8, 1e-6);
  EXPECT_GT(Finger(solution, 0).sticking, 0);
  EXPECT_LE(solution.summary.force_balance, 1e-6);
}

// Resistance that grows with the travel is no snap.
TEST(ForceControlTest, StiffeningPlateHasNoLimitPoint) {
  const Solution plate = SolveScene(SceneFromText(
      "name: plate\n"
      "surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [12, 12]}\n"
      "shell: {thickness: 1, young_modulus: 1000, poisson_ratio: 0.3}\n"
      "supports: [{on: rim, clamped: true}]\n"
      "fingers: [{name: tip, shape: {kind: sphere, radius: 20}, position: [50, 50, 40], "
      "direction: [0, 0, -1], motion: {force: 200}}]\n"));
  EXPECT_FALSE(plate.summary.steps.back().limit_point);
  EXPECT_GT(Finger(plate, 0).travel, 4.0);
  EXPECT_NEAR(plate.summary.reaction.z(), 200.0, 1e-4);
}

}  // namespace
}  // namespace darboux
