#include "solver/unilateral_step.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "solver/mixed_iteration.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

// Planes: curved fingers put into K, besides c c^T, what the pressure makes of their curvature.
constexpr char kBall[] = R"(
name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 6}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.3}
supports:
  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: plane}, position: [0, 0, 50], direction: [0, 0, -1],
     motion: {travel: 3}}
  - {name: bottom, shape: {kind: plane}, position: [0, 0, -50], direction: [0, 0, 1],
     motion: {travel: 3}}
)";

class UnilateralStepTest : public ::testing::Test {
 protected:
  void SetUp() override {
    solution_ = SolveScene(SceneFromText(kBall));
    problem_ = solution_.problem.get();
    mixed_ = std::make_unique<MixedIteration>(problem_, SparseBackend::kAuto, 1);
    ASSERT_TRUE(mixed_->SetStresses());
  }

  // The step of the model at the present state; K with the points `in_matrix` in contact, which the
  // factor has, or with those of the state, factorised here.
  Eigen::VectorXd Step(const std::vector<int>* in_matrix, std::vector<int>* contact, bool* valid) {
    Eigen::VectorXd gradient;
    TangentStiffness::Request request;
    request.gradient = &gradient;
    request.matrix = in_matrix == nullptr;
    request.initial_stresses = &mixed_->stresses();
    EXPECT_TRUE(mixed_->tangent().Evaluate(request));
    if (in_matrix == nullptr) {
      EXPECT_TRUE(mixed_->FactorizePositive());
    }
    UnilateralStep step(*problem_->grasp(),
                        mixed_->tangent(),
                        &mixed_->cholesky(),
                        problem_->material().thickness,
                        in_matrix);
    *contact = step.Contact();
    *valid = step.is_valid();
    Eigen::VectorXd x = mixed_->cholesky().Solve(-gradient);
    step.Correct(&x);
    return x;
  }

  Solution solution_;
  ShellProblem* problem_ = nullptr;
  std::unique_ptr<MixedIteration> mixed_;
};

// Which points the factor has in contact makes no difference to the step: as many are taken out of
// it or put into it as the model has. The displacements stay, so that nothing else of K changes.
TEST_F(UnilateralStepTest, AFactorWithOtherPointsInContactServesAsWell) {
  std::vector<int> at_rest, fewer, ignored;
  bool valid = false;
  Step(nullptr, &at_rest, &valid);
  ASSERT_GT(at_rest.size(), 8u);
  // Every seventh of them stops to push, by its multiplier; others push harder. Of more, hundreds
  // of points would change, which is no step that a factor at hand is meant for.
  Grasp::State state = problem_->grasp()->state();
  for (size_t k = 0; k < at_rest.size(); ++k) {
    double& multiplier = state.multipliers[at_rest[k]];
    multiplier = k % 7 == 0 ? -10.0 * (1.0 + multiplier) : 1.1 * multiplier;
  }
  problem_->grasp()->SetState(state);
  const Eigen::VectorXd chord = Step(&at_rest, &fewer, &valid);
  EXPECT_TRUE(valid);
  EXPECT_LT(fewer.size(), at_rest.size());
  const Eigen::VectorXd fresh = Step(nullptr, &ignored, &valid);
  EXPECT_GT(fresh.norm(), 0.0);
  EXPECT_LE((chord - fresh).norm(), 1e-8 * fresh.norm());

  // And the other way round: the factor has fewer.
  for (const int point : at_rest) state.multipliers[point] = std::abs(state.multipliers[point]);
  problem_->grasp()->SetState(state);
  const Eigen::VectorXd more = Step(&fewer, &ignored, &valid);
  EXPECT_TRUE(valid);
  const Eigen::VectorXd fresh_more = Step(nullptr, &ignored, &valid);
  EXPECT_LE((more - fresh_more).norm(), 1e-8 * fresh_more.norm());
}

TEST_F(UnilateralStepTest, AFactorWithPointsThatAreFarAwayDoesNotServe) {
  std::vector<int> contact, ignored;
  bool valid = false;
  Step(nullptr, &contact, &valid);
  EXPECT_TRUE(valid);
  contact.push_back(1000000);
  Step(&contact, &ignored, &valid);
  EXPECT_FALSE(valid);
}

// A solve with contact makes many of its steps with factors at hand, and ends as well.
TEST_F(UnilateralStepTest, ManyStepsOfAGraspAreChords) {
  EXPECT_GE(2 * solution_.summary.kept_factors, solution_.summary.iterations);
  EXPECT_GT(solution_.summary.kept_factors_saved_s, 0.0);
  EXPECT_LE(solution_.summary.gradient_norm, 1e-7);
}

}  // namespace
}  // namespace darboux
