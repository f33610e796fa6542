#include "solver/equilibrium_sensitivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

// A ball of 486 dof between two spheres, as data/tennis_ball.yaml.
constexpr char kBall[] = R"(
name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 4}
shell: {thickness: 2.5, young_modulus: 14.2, poisson_ratio: 0.45}
supports:
  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 8}, position: [0, 0, 45], direction: [0, 0, -1], motion: {travel: 4}}
  - {name: bottom, shape: {kind: sphere, radius: 8}, position: [0, 0, -45], direction: [0, 0, 1], motion: {travel: 4}}
)";
constexpr char kGas[] =
    "loads:\n  - {kind: gas, gauge_pressure: 0.05, ambient_pressure: 0.101325, law: adiabatic}\n";
constexpr char kPrestressed[] =
    "loads:\n  - {kind: gas, gauge_pressure: 0.05, ambient_pressure: 0.101325, rest: "
    "prestressed}\n";
constexpr char kLinear[] = "model: {theory: linear}\n";
constexpr char kPlate[] = R"(
name: strip
surface: {kind: plane, u: [0, 2], v: [0, 1], divisions: [8, 4]}
shell: {thickness: 0.05, young_modulus: 1000, poisson_ratio: 0.3}
supports: [{on: u_min, clamped: true}]
loads:
  - {kind: edge, on: u_max, force: [0, 3, 0.05]}
)";

struct State {
  std::unique_ptr<ShellProblem> problem;
  Eigen::Matrix3Xd displacements;
  Eigen::VectorXd forces;
};

SolverOptions Options() {
  SolverOptions options;
  options.num_threads = 1;
  options.gradient_tolerance = 1e-10;
  return options;
}

State StateOf(const Scene& scene) {
  State state;
  Solution solution = SolveScene(scene, Options());
  state.problem = std::move(solution.problem);
  state.displacements = state.problem->displacements();
  const auto& fingers = solution.summary.steps.back().fingers;
  state.forces.resize(fingers.size());
  for (size_t i = 0; i < fingers.size(); ++i) {
    const auto& way = scene.fingers[i].direction;
    state.forces[i] = -fingers[i].force.dot(Eigen::Vector3d(way[0], way[1], way[2]));
  }
  return state;
}

void Change(Scene* scene, StateParameter parameter, double by) {
  switch (parameter) {
    case StateParameter::kYoungModulus:
      scene->shell.young_modulus *= std::exp(by);
      break;
    case StateParameter::kThickness:
      scene->shell.thickness *= std::exp(by);
      break;
    case StateParameter::kPoissonRatio:
      scene->shell.poisson_ratio += by;
      break;
    case StateParameter::kGasPressure:
      scene->loads[0].gauge_pressure += by;
      break;
    case StateParameter::kTravel:
      for (FingerSpec& finger : scene->fingers) finger.travel += by;
      break;
  }
}

// The scene as gas has inflated it, before the fingers come.
Scene Bare(Scene scene) {
  scene.fingers.clear();
  return scene;
}

// A ball may turn about the line between its fingers, where nothing holds it: of two states only
// what no such turn explains can be compared.
Eigen::Matrix3Xd WithoutTurn(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& motion) {
  Eigen::Matrix3Xd turn(3, motion.cols());
  for (Eigen::Index i = 0; i < motion.cols(); ++i) {
    turn.col(i) = Eigen::Vector3d::UnitZ().cross(points.col(i));
  }
  return motion - turn.cwiseProduct(motion).sum() / turn.squaredNorm() * turn;
}

struct Step {
  StateParameter parameter;
  double size, tolerance;  // of displacements and forces, relative
};

void ExpectMatchesDifferences(const std::string& text, const std::vector<Step>& steps) {
  SCOPED_TRACE(text);
  const Scene scene = SceneFromText(text);
  std::string error;
  const LoadSpec* const gas = FindGas(scene);
  const bool inflated = gas != nullptr && !gas->prestressed;
  State bare;
  if (inflated) bare = StateOf(Bare(scene));
  const State state = StateOf(scene);
  const bool turns = !scene.fingers.empty();
  for (const Step& step : steps) {
    SCOPED_TRACE(ToString(step.parameter));
    StateDerivative start, derivative;
    if (inflated) {
      auto sensitivity =
          EquilibriumSensitivity::Create(bare.problem.get(), SparseBackend::kAuto, 1, &error);
      ASSERT_NE(sensitivity, nullptr) << error;
      ASSERT_TRUE(sensitivity->Evaluate(step.parameter, nullptr, &start, &error)) << error;
    }
    {
      auto sensitivity =
          EquilibriumSensitivity::Create(state.problem.get(), SparseBackend::kAuto, 1, &error);
      ASSERT_NE(sensitivity, nullptr) << error;
      ASSERT_TRUE(sensitivity->Evaluate(
          step.parameter, inflated ? &start.displacement : nullptr, &derivative, &error))
          << error;
      EXPECT_LE((sensitivity->Forces() - state.forces).norm(), 1e-9 * state.forces.norm());
    }
    EXPECT_EQ(state.problem->displacements(), state.displacements);  // left as it was
    Scene more = scene, less = scene;
    Change(&more, step.parameter, step.size);
    Change(&less, step.parameter, -step.size);
    const State plus = StateOf(more), minus = StateOf(less);
    Eigen::Matrix3Xd moved = (plus.displacements - minus.displacements) / (2.0 * step.size);
    if (turns) {
      const Eigen::Matrix3Xd& points = state.problem->surface().control_points();
      moved = WithoutTurn(points, moved);
      derivative.displacement = WithoutTurn(points, derivative.displacement);
    }
    const double error_of_states = 1e-8 / step.size * state.displacements.norm();
    EXPECT_LE((derivative.displacement - moved).norm(),
              step.tolerance * moved.norm() + error_of_states);
    const Eigen::VectorXd harder = (plus.forces - minus.forces) / (2.0 * step.size);
    EXPECT_LE((derivative.force - harder).norm(), step.tolerance * harder.norm())
        << derivative.force.transpose() << " against " << harder.transpose();
  }
}

TEST(EquilibriumSensitivityTest, OfAGraspMatchesDifferencesOfSolutions) {
  ExpectMatchesDifferences(kBall,
                           {{StateParameter::kYoungModulus, 1e-3, 1e-5},
                            {StateParameter::kThickness, 1e-3, 1e-4},
                            {StateParameter::kPoissonRatio, 1e-3, 1e-4},
                            {StateParameter::kTravel, 1e-3, 1e-4}});
}

TEST(EquilibriumSensitivityTest, WithGasMatchesDifferencesOfSolutions) {
  ExpectMatchesDifferences(std::string(kBall) + kGas,
                           {{StateParameter::kYoungModulus, 1e-3, 1e-4},
                            {StateParameter::kThickness, 1e-3, 1e-4},
                            {StateParameter::kGasPressure, 1e-4, 1e-4}});
}

TEST(EquilibriumSensitivityTest, WithPrestressedGasMatchesDifferencesOfSolutions) {
  const std::string ball = std::string(kBall) + kPrestressed;
  ExpectMatchesDifferences(
      ball,
      {{StateParameter::kYoungModulus, 1e-3, 1e-4}, {StateParameter::kGasPressure, 1e-4, 1e-4}});
  // The stress that other parameters would have begun with is not known.
  const State state = StateOf(SceneFromText(ball));
  std::string error;
  StateDerivative derivative;
  auto sensitivity =
      EquilibriumSensitivity::Create(state.problem.get(), SparseBackend::kAuto, 1, &error);
  ASSERT_NE(sensitivity, nullptr) << error;
  EXPECT_FALSE(sensitivity->Evaluate(StateParameter::kThickness, nullptr, &derivative, &error));
  EXPECT_NE(error.find("prestressed"), std::string::npos) << error;
}

TEST(EquilibriumSensitivityTest, OfTheLinearTheoryMatchesDifferencesOfSolutions) {
  ExpectMatchesDifferences(
      std::string(kBall) + kLinear,
      {{StateParameter::kYoungModulus, 1e-3, 1e-5}, {StateParameter::kThickness, 1e-3, 1e-4}});
}

TEST(EquilibriumSensitivityTest, OfALoadedStripMatchesDifferencesOfSolutions) {
  for (const std::string& theory : {std::string("linear"), std::string("nonlinear")}) {
    ExpectMatchesDifferences(std::string(kPlate) + "model: {theory: " + theory + "}\n",
                             {{StateParameter::kYoungModulus, 1e-3, 1e-5},
                              {StateParameter::kThickness, 1e-3, 1e-4},
                              {StateParameter::kPoissonRatio, 1e-3, 1e-5}});
  }
}

}  // namespace
}  // namespace darboux
