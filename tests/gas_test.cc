// Gas in closed shells: the law, the enclosed volume, a sphere blown up, a tennis ball squeezed.
#include "costs/gas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "solver/mixed_iteration.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

constexpr double kPi = 3.14159265358979323846;

class GasLawTest : public ::testing::TestWithParam<double> {};

TEST_P(GasLawTest, PressureTimesVolumeToTheGammaStays) {
  const double gamma = GetParam(), ambient = 101325.0, rest = 0.7;
  const Gas gas(8000.0, ambient, gamma, rest);
  EXPECT_NEAR(gas.GaugePressure(0.0), 8000.0, 1e-9);
  for (const double change : {-0.4, -1e-3, 0.2, 3.0}) {
    const double expected = (ambient + 8000.0) * std::pow(rest / (rest + change), gamma) - ambient;
    EXPECT_NEAR(gas.GaugePressure(change), expected, 1e-9 * (ambient + std::abs(expected)));
  }
}

TEST_P(GasLawTest, DerivativesMatchDifferences) {
  const Gas gas(8000.0, 101325.0, GetParam(), 0.7);
  EXPECT_EQ(gas.Energy(0.0), 0.0);
  const double step = 1e-6;
  for (const double change : {-0.4, 0.0, 0.2, 3.0}) {
    const double slope = (gas.GaugePressure(change + step) - gas.GaugePressure(change - step));
    EXPECT_NEAR(slope / (2.0 * step) / gas.PressureDerivative(change), 1.0, 1e-7);
    const double fall = (gas.Energy(change - step) - gas.Energy(change + step)) / (2.0 * step);
    EXPECT_NEAR(fall, gas.GaugePressure(change), 1e-4 * 101325.0 * step / 1e-6);
  }
}

TEST_P(GasLawTest, DivergenceIsWhatTheEnergyHasBeyondItsTangent) {
  const double rest = 0.7;
  for (const bool linear : {false, true}) {
    const Gas gas(8000.0, 101325.0, GetParam(), rest, linear);
    for (const double at : {-0.2, 0.0, 0.4}) {
      for (const double more : {-0.3, -0.08, 0.05, 0.13, 2.0}) {
        const double expected =
            gas.Energy(at + more) - gas.Energy(at) + gas.GaugePressure(at) * more;
        EXPECT_NEAR(gas.Divergence(at, more) / expected, 1.0, 1e-11);
        const double slope = gas.GaugePressure(at) - gas.GaugePressure(at + more);
        EXPECT_NEAR(gas.DivergenceSlope(at, more) / slope, 1.0, 1e-12);
      }
      const double tiny = 1e-9, stiffness = -gas.PressureDerivative(at);
      EXPECT_NEAR(gas.Divergence(at, tiny) / (0.5 * stiffness * tiny * tiny), 1.0, 1e-8);
    }
  }
}

TEST_P(GasLawTest, SmallChangesLoseNoDigits) {
  const double gamma = GetParam();
  const Gas gas(0.0, 1.0, gamma, 1.0);
  EXPECT_NEAR(gas.GaugePressure(1e-12) / (-gamma * 1e-12), 1.0, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Gamma, GasLawTest, ::testing::Values(1.0, 1.4));

// A ball of radius 31.25 units of length, of which `mm` make 31.25 mm, and units of force.
std::string Ball(int frequency,
                 double gauge,
                 double ambient,
                 const std::string& rest,
                 double length = 1.0,
                 double force = 1.0,
                 double nu = 0.5) {
  const double pressure = force / (length * length);
  return "name: ball\nsurface: {kind: icosphere, radius: " + std::to_string(31.25 * length) +
         ", frequency: " + std::to_string(frequency) +
         "}\nshell: {thickness: " + std::to_string(2.5 * length) +
         ", young_modulus: " + std::to_string(pressure) + ", poisson_ratio: " + std::to_string(nu) +
         "}\nloads:\n  - {kind: gas, gauge_pressure: " + std::to_string(gauge * pressure) +
         ", ambient_pressure: " + std::to_string(ambient * pressure) + rest;
}

TEST(GasTest, SphereUnderLowPressureGrowsAsInTheLinearTheory) {
  // w = p R^2 (1 - nu) / (2 E h) and little else: V/V0 - 1 = 3 w / R; the gas loses 3 w / R of it.
  const double gauge = 1e-4;
  for (const double nu : {0.3, 0.5}) {
    const Solution solution =
        SolveScene(SceneFromText(Ball(6, gauge, 0.101325, "}\n", 1.0, 1.0, nu)));
    const GasReport& gas = *solution.summary.steps.back().gas;
    const double growth = gas.gauge_pressure * 31.25 * (1.0 - nu) / (2.0 * 2.5);
    EXPECT_NEAR(std::cbrt(gas.volume_ratio) - 1.0, growth, 5e-3 * growth);
    EXPECT_NEAR(gas.absolute_pressure * gas.volume_ratio, 0.101325 + gauge, 1e-12);
    EXPECT_NEAR(gas.volume / gas.volume_ratio, 4.0 / 3.0 * kPi * std::pow(31.25, 3), 100.0);
  }
}

TEST(GasTest, StrongPressureInflatesAndTheGasThins) {
  // Membrane of St. Venant-Kirchhoff material: p (absolute - A) of a sphere stretched by l is
  // 2 E h (l^2 - 1) / (2 (1 - nu) R l); bending adds (h/R)^2 of it.
  const Solution solution =
      SolveScene(SceneFromText(Ball(6, 0.083, 0.101325, ", law: adiabatic}\n")));
  const GasReport& gas = *solution.summary.steps.back().gas;
  const double stretch = std::cbrt(gas.volume_ratio);
  const double expected = 2.5 * (stretch * stretch - 1.0) / (0.5 * 31.25 * stretch);
  EXPECT_NEAR(gas.gauge_pressure, expected, 0.01 * expected);
  EXPECT_NEAR(gas.absolute_pressure, 0.184325 * std::pow(gas.volume_ratio, -1.4), 1e-9);
  EXPECT_EQ(solution.summary.effects[static_cast<int>(Effect::kGas)].report.on, true);
  EXPECT_LT(solution.summary.effects[static_cast<int>(Effect::kGas)].energy, 0.0);
}

TEST(GasTest, ResultsDoNotDependOnTheUnits) {
  const Solution mm = SolveScene(SceneFromText(Ball(4, 0.02, 0.101325, "}\n")));
  const Solution m = SolveScene(SceneFromText(Ball(4, 0.02, 0.101325, "}\n", 1e-3, 1.0)));
  const GasReport& a = *mm.summary.steps.back().gas;
  const GasReport& b = *m.summary.steps.back().gas;
  EXPECT_NEAR(b.volume_ratio, a.volume_ratio, 1e-9);
  EXPECT_NEAR(b.gauge_pressure, 1e6 * a.gauge_pressure, 1e-2);
  EXPECT_EQ(mm.summary.iterations, m.summary.iterations);
  EXPECT_NEAR(m.summary.energy_total,
              1e-3 * mm.summary.energy_total,
              1e-9 * std::abs(mm.summary.energy_total));
}

std::unique_ptr<ShellProblem> Bent(int frequency, const char* quadrature) {
  Scene scene = SceneFromText(
      Ball(frequency, 0.02, 0.101325, std::string("}\nmodel: {quadrature: ") + quadrature + "}\n"));
  ShellProblem::Options options;
  options.nonlinear = true;
  std::string error;
  std::unique_ptr<ShellProblem> problem = ShellProblem::Create(scene, options, &error);
  EXPECT_NE(problem, nullptr) << error;
  std::mt19937 generator(40127);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::Matrix3d a;
  for (int i = 0; i < 9; ++i) a.data()[i] = 0.1 * uniform(generator);
  Eigen::Matrix3Xd& u =
      const_cast<Eigen::Matrix3Xd&>(static_cast<const ShellProblem&>(*problem).displacements());
  const auto& points = problem->scene().surface.mesh->vertices;
  for (int i = 0; i < u.cols(); ++i) {
    const Eigen::Vector3d x = points[i];
    u.col(i) = a * x + 0.1 * x.cwiseProduct(x) / 31.25;
  }
  return problem;
}

TEST(GasTest, ForcesAreTheGradientOfTheEnergyUpToQuadrature) {
  double error[2];
  for (const int fine : {0, 1}) {
    const std::unique_ptr<ShellProblem> problem = Bent(4, fine == 0 ? "3" : "12");
    const Eigen::Matrix3Xd state = problem->displacements();
    Eigen::Matrix3Xd direction(3, state.cols());
    for (int i = 0; i < state.cols(); ++i) {
      direction.col(i) << std::sin(0.1 * state(0, i)), std::cos(0.2 * state(1, i)),
          1.0 + state(2, i);
    }
    ASSERT_TRUE(problem->UpdateGas());
    const double slope = -problem->force_unit() * problem->force_unit() * problem->gas_pressure() *
                         problem->gas_vector().cwiseProduct(direction).sum();
    const double step = 1e-4;
    problem->displacements() = state + step * direction;
    const double above = problem->Energy(Effect::kGas);
    problem->displacements() = state - step * direction;
    const double below = problem->Energy(Effect::kGas);
    error[fine] = std::abs((above - below) / (2.0 * step) / slope - 1.0);
    // Ceres' problem, with the pressure frozen and corrected, has the same forces.
    problem->displacements() = state;
    problem->UpdateCorrection();
    const Eigen::Matrix3Xd gas = problem->force_unit() * problem->force_unit() *
                                 problem->gas_pressure() * problem->gas_vector();
    const Eigen::Matrix3Xd loads =
        problem->Gradient(Effect::kGas) + problem->Gradient(Effect::kLoads);
    EXPECT_LE((gas + loads).norm(), 1e-10 * gas.norm());
  }
  std::printf("  energy against force: %.1e, better quadrature %.1e\n", error[0], error[1]);
  EXPECT_LE(error[0], 2e-3);
  EXPECT_LE(error[1], 1e-5);
}

TEST(GasTest, TangentIsTheDerivativeOfTheForces) {
  const std::unique_ptr<ShellProblem> problem = Bent(4, "12");
  TangentStiffness tangent(problem.get(), SparseBackend::kAuto, 1);
  TangentStiffness::StressField stresses(tangent.num_points());
  Eigen::VectorXd gradient, above, below;
  TangentStiffness::Request request;
  request.stresses = &stresses;
  ASSERT_TRUE(tangent.Evaluate(request));
  request.stresses = nullptr;
  request.initial_stresses = &stresses;
  request.gradient = &gradient;
  request.matrix = true;
  ASSERT_TRUE(tangent.Evaluate(request));
  Eigen::VectorXd direction(tangent.num_unknowns());
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (Eigen::Index i = 0; i < direction.size(); ++i) direction[i] = uniform(generator);
  const Eigen::Index last = tangent.update_vectors().cols() - 1;
  const Eigen::VectorXd vector = tangent.update_vectors().col(last);
  // Mean conditions push as well in this state; pins do not.
  Eigen::VectorXd expected = tangent.matrix().selfadjointView<Eigen::Lower>() * direction;
  expected +=
      tangent.update_vectors() *
      (tangent.update_weights().cwiseProduct(tangent.update_vectors().transpose() * direction));
  TangentStiffness::Request only;
  const double step = 1e-6;
  const Eigen::Matrix3Xd state = problem->displacements();
  problem->displacements() = state + tangent.Expand(step * direction);
  only.gradient = &above;
  ASSERT_TRUE(tangent.Evaluate(only));
  problem->displacements() = state - tangent.Expand(step * direction);
  only.gradient = &below;
  ASSERT_TRUE(tangent.Evaluate(only));
  const Eigen::VectorXd difference = (above - below) / (2.0 * step);
  EXPECT_LE((difference - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT(tangent.update_weights()[last], 0.0);
}

TEST(GasTest, TennisBallSqueezedAtItsPolesKeepsItsAir) {
  const Solution solution = SolveScene(SceneFromData("tennis_ball_gas.yaml"));
  const LoadStep& state = solution.summary.steps.back();
  EXPECT_NEAR(state.factor, 2.9488037527, 0.005 * 2.9488037527);
  EXPECT_NEAR(state.gas->volume_ratio, 0.9763021, 1e-3);
  EXPECT_NEAR(state.gas->absolute_pressure, 0.1037845, 1e-4);
  EXPECT_LE(solution.summary.gradient_norm, 1e-7);
}

TEST(GasTest, IsRefusedWhereItHasNoMeaning) {
  struct Case {
    std::string text, message;
  };
  const std::string open =
      "name: a\nsurface: {kind: plane, u: [0, 1], v: [0, 1], divisions: [2, 2]}\n"
      "shell: {thickness: 0.1, young_modulus: 1, poisson_ratio: 0}\n"
      "loads:\n  - {kind: gas, gauge_pressure: 1, ambient_pressure: 1}\n";
  for (const Case& c :
       {Case{open, "test.yaml:5: loads[0].kind: found gas in a surface of kind plane"},
        Case{Ball(2, -0.2, 0.1, "}\n"), "loads[0].gauge_pressure"},
        Case{Ball(2, 0.2, 0.1, ", rest: deflated}\n"), "loads[0].rest"},
        Case{Ball(2, 0.2, 0.1, ", law: isobaric}\n"), "loads[0].law"},
        Case{Ball(2, 0.2, 0.1, "}\n  - {kind: gas, gauge_pressure: 1, ambient_pressure: 1}\n"),
             "loads[1].kind: found gas a second time"}}) {
    Scene scene;
    std::string error;
    EXPECT_FALSE(ParseScene(c.text, "test.yaml", &scene, &error));
    EXPECT_NE(error.find(c.message), std::string::npos) << error;
  }
  const Scene scene = SceneFromText(Ball(2, 0.01, 0.1, "}\nmodel: {minimizer: cg}\n"));
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  EXPECT_FALSE(Solve(scene, SolverOptions(), &problem, &summary, &error));
  EXPECT_NE(error.find("loads[0]: found gas with minimizer cg"), std::string::npos) << error;
}

// Held without reactions, pressed by P_2 dead tractions.
std::string Held(double gauge, const std::string& model) {
  return Ball(4,
              gauge,
              0.101325,
              "}\n  - {kind: normal_traction, value: \"0.003*(1.5*z^2/31.25^2-0.5)\"}\n"
              "supports:\n  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y, z]}\n"
              "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
              "  - {on: {near: [31.25, 0, 0], radius: 0}, fix: [y]}\n"
              "probes:\n  - {name: pole, at: {nearest: [0, 0, -31.25]}}\nmodel: {" +
                  model + "}\n",
              1.0,
              1.0,
              0.3);
}

TEST(GasTest, CeresFindsTheEnergyThatNewtonsMethodFinds) {
  for (const char* theory : {"theory: linear", "theory: nonlinear"}) {
    const std::string model = theory;
    const Solution mip = SolveScene(SceneFromText(Held(0.02, model + ", minimizer: mip")));
    const Solution ceres = SolveScene(SceneFromText(Held(0.02, model + ", minimizer: ceres")));
    const double energy = mip.summary.energy_total;
    std::printf("  %s: energy %.9e, Ceres differs by %.1e, %d iterations instead of %d\n",
                theory,
                energy,
                std::abs(ceres.summary.energy_total / energy - 1.0),
                ceres.summary.iterations,
                mip.summary.iterations);
    EXPECT_NEAR(ceres.summary.energy_total / energy, 1.0, 1e-8);
    EXPECT_NEAR(ceres.Probe().z() / mip.Probe().z(), 1.0, 1e-6);
    EXPECT_NEAR(ceres.summary.steps.back().gas->gauge_pressure /
                    mip.summary.steps.back().gas->gauge_pressure,
                1.0,
                1e-6);
    EXPECT_LE(ceres.summary.gradient_norm, 1e-7);
  }
}

TEST(GasTest, LinearTheoryHasTheGasToFirstOrder) {
  // w = p R^2 (1 - nu) / (2 E h), p = P - (A + P) 3 w / R
  const Solution solution =
      SolveScene(SceneFromText(Ball(6, 0.02, 0.101325, "}\nmodel: {theory: linear}\n")));
  const GasReport& gas = *solution.summary.steps.back().gas;
  const double compliance = 31.25 * 0.5 / (2.0 * 2.5);  // w / (R p)
  const double growth = compliance * 0.02 / (1.0 + 3.0 * compliance * 0.121325);
  EXPECT_NEAR(gas.volume_ratio, 1.0 + 3.0 * growth, 2e-3 * growth);
  EXPECT_NEAR(gas.gauge_pressure, 0.02 - 0.121325 * (gas.volume_ratio - 1.0), 1e-12);
  // The gas is there before the loads: displacements are those of the gas and a part of the rest.
  std::string steps = Held(0.02, "theory: linear") + "steps: 2\n";
  const Solution two = SolveScene(SceneFromText(steps));
  const Solution none = SolveScene(
      SceneFromText(Ball(4, 0.02, 0.101325, "}\nmodel: {theory: linear}\n", 1.0, 1.0, 0.3)));
  const double w = none.summary.max_displacement, half = two.summary.steps[0].max_displacement;
  EXPECT_NEAR(
      two.summary.steps[0].gas->volume_ratio, none.summary.steps[0].gas->volume_ratio, 1e-3);
  EXPECT_GT(half, 1.5 * w);  // the pole that is not held
}

TEST(GasTest, FingersTouchTheInflatedShell) {
  const auto scene = [](double travel, const char* shape, const char* theory) {
    std::string fingers;
    for (const int side : {1, -1}) {
      fingers += std::string("  - {name: ") + (side > 0 ? "top" : "bottom") + ", shape: " + shape +
                 ", position: [0, 0, " + std::to_string(60 * side) + "], direction: [0, 0, " +
                 std::to_string(-side) + "], motion: {travel: " + std::to_string(travel) + "}}\n";
    }
    return SceneFromText(Ball(5,
                              0.02,
                              0.101325,
                              std::string("}\nmodel: {theory: ") + theory + "}\nfingers:\n" +
                                  fingers +
                                  "probes:\n  - {name: pole, at: {nearest: [0, 0, 31.25]}}\n"));
  };
  for (const char* theory : {"nonlinear", "linear"}) {
    const Solution zero = SolveScene(scene(0.0, "{kind: sphere, radius: 10}", theory));
    for (const FingerReport& finger : zero.summary.steps.back().fingers) {
      // 60 minus the finger, the shell and half its thickness.
      const double pole = zero.summary.probes[0].position.z() + zero.Probe().z();
      EXPECT_NEAR(finger.shift, 60.0 - 10.0 - 1.25 - pole, 1e-4);
      EXPECT_EQ(finger.normal_force, 0.0);
    }
    EXPECT_GT(zero.Probe().z(), 0.5);
  }
  const Solution bare = SolveScene(SceneFromText(Ball(4, 0.02, 0.101325, "}\n")));
  const Solution squeezed = SolveScene(scene(1.5, "{kind: sphere, radius: 10}", "nonlinear"));
  const LoadStep& state = squeezed.summary.steps.back();
  EXPECT_NEAR(squeezed.Probe().z(), bare.summary.max_displacement - 1.5, 0.04);
  EXPECT_GT(state.fingers[0].normal_force, 0.1);
  EXPECT_NEAR(state.fingers[0].normal_force / state.fingers[1].normal_force, 1.0, 1e-4);
  EXPECT_LT(state.gas->volume_ratio, bare.summary.steps.back().gas->volume_ratio);
}

}  // namespace
}  // namespace darboux
