#include "solver/state_model.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/solve_util.h"

namespace darboux {
namespace {

std::string Ball(const std::string& finger, const std::string& more = "") {
  return "name: ball\n"
         "surface: {kind: icosphere, radius: 31.25, frequency: 4}\n"
         "shell: {thickness: 2.5, young_modulus: 10, poisson_ratio: 0.45}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: {kind: sphere, radius: 8}, position: [0, 0, 45], "
         "direction: [0, 0, -1], " +
         finger +
         "}\n"
         "  - {name: bottom, shape: {kind: sphere, radius: 8}, position: [0, 0, -45], "
         "direction: [0, 0, 1], " +
         finger + "}\n" + more;
}

std::unique_ptr<StateModel> ModelOf(const std::string& text) {
  SolverOptions options;
  options.num_threads = 1;
  std::string error;
  auto model = StateModel::Create(SceneFromText(text), options, &error);
  EXPECT_NE(model, nullptr) << error;
  return model;
}

TEST(StateModelTest, FingersAloneGiveAShapeThatNoModulusChanges) {
  const auto model = ModelOf(Ball("motion: {travel: 3}"));
  ASSERT_NE(model, nullptr);
  const Eigen::VectorXd forces = model->forces();
  ShellParameters parameters = model->parameters();
  parameters.young_modulus *= 2.5;
  std::string error;
  ASSERT_TRUE(model->Solve(parameters, 0.0, &error)) << error;
  EXPECT_EQ(model->work().solutions, 1);
  EXPECT_LT((model->forces() - 2.5 * forces).norm(), 1e-12 * forces.norm());
  // What has not been solved is that which a solution gives.
  ASSERT_TRUE(model->Settle(&error)) << error;
  EXPECT_EQ(model->work().solutions, 2);
  EXPECT_LT((model->forces() - 2.5 * forces).norm(), 1e-6 * forces.norm());
}

TEST(StateModelTest, AForceBecomesTheTravelThatItLeadsTo) {
  const auto by_travel = ModelOf(Ball("motion: {travel: 3}"));
  ASSERT_NE(by_travel, nullptr);
  const auto by_force =
      ModelOf(Ball("motion: {force: " + std::to_string(by_travel->forces()[0]) + "}"));
  ASSERT_NE(by_force, nullptr);
  EXPECT_TRUE(by_force->by_force());
  EXPECT_NEAR(by_force->scene().fingers[0].travel, 3.0, 1e-4);
  EXPECT_NEAR(by_force->forces()[0], by_travel->forces()[0], 1e-4 * by_travel->forces()[0]);
}

TEST(StateModelTest, ANearStateIsFoundFromTheLastOne) {
  const auto model = ModelOf(Ball("motion: {travel: 3}"));
  ASSERT_NE(model, nullptr);
  const int from_rest = model->work().iterations;
  const StateDerivative* by = nullptr;
  std::string error;
  ASSERT_TRUE(model->Derivative(StateParameter::kTravel, &by, &error)) << error;
  ASSERT_TRUE(model->Solve(model->parameters(), 0.05, &error)) << error;
  EXPECT_LT(model->work().iterations - from_rest, from_rest / 2);
  const auto anew = ModelOf(Ball("motion: {travel: 3.05}"));
  EXPECT_NEAR(model->forces()[0], anew->forces()[0], 1e-6 * anew->forces()[0]);
}

// Where the way counts derivatives are differences of solutions.
TEST(StateModelTest, WithFrictionDerivativesAreThoseOfSolutions) {
  const auto model = ModelOf(Ball("motion: {travel: 2}, friction: 0.3"));
  ASSERT_NE(model, nullptr);
  const StateDerivative* by = nullptr;
  std::string error;
  ASSERT_TRUE(model->Derivative(StateParameter::kTravel, &by, &error)) << error;
  const auto more = ModelOf(Ball("motion: {travel: 2.02}, friction: 0.3"));
  const auto less = ModelOf(Ball("motion: {travel: 1.98}, friction: 0.3"));
  const double slope = (more->forces()[0] - less->forces()[0]) / 0.04;
  EXPECT_NEAR(by->force[0], slope, 0.02 * slope);
  EXPECT_FALSE(model->Derivative(StateParameter::kGasPressure, &by, &error));
  EXPECT_NE(error.find("gas"), std::string::npos);
}

}  // namespace
}  // namespace darboux
