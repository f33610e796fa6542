// Hard cases: Poisson's ratio from -0.9 to 1/2. Plane stress has nothing that breaks at 1/2, and
// every answer depends on it as its closed form says.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/hard_util.h"

namespace darboux {
namespace {

class PoissonTest : public ::testing::TestWithParam<double> {
 protected:
  double nu() const { return GetParam(); }
  void Report(const std::string& what, double error) const {
    Measured("poisson: " + what + ", nu = " + Text(nu()), error);
  }
};

// Bending of a clamped plate knows Poisson's ratio only by D: w D / (p L^4) = 0.00126531908, from
// 0.13817284435 at L = 100, h = 1, E = 1e7, nu = 0.3 (Legendre-Galerkin series, data/README.md).
TEST_P(PoissonTest, ClampedPlateBendsByItsStiffness) {
  const double constant = 0.13817284435 * 1e7 / (12.0 * (1.0 - 0.09)) / 1e8;
  const Solution solution = SolveScene(SceneFromText(Fill(R"(
name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [24, 24]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: $nu}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
)",
                                                          {{"nu", nu()}})));
  const double expected = constant * 1e8 * 12.0 * (1.0 - nu() * nu()) / 1e7;
  const double error = std::abs(solution.Probe().z() / expected - 1.0);
  EXPECT_LE(error, 1e-4);
  Report("clamped plate", error);
}

// w = p R^2 (1 - nu) / (2 E h) in the membrane theory; uniform growth changes curvatures of
// Koiter's theory by w / R^2, whose energy adds a part h^2 / (12 R^2) of the same form.
TEST_P(PoissonTest, SphereGrowsByItsClosedForm) {
  const double radius = 31.25, thickness = 2.5, pressure = 1e-3;
  const Solution solution = SolveScene(SceneFromText(Fill(R"(
name: sphere
surface: {kind: icosphere, radius: 31.25, frequency: 8}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: $nu}
model: {theory: linear, strains: koiter}
loads: [{kind: pressure, value: 1.0e-3}]
probes: [{name: pole, at: {nearest: [0, 0, 31.25]}}, {name: side, at: {nearest: [30, 8, 1]}}]
)",
                                                          {{"nu", nu()}})));
  const double expected = pressure * radius * radius * (1.0 - nu()) / (2.0 * thickness) /
                          (1.0 + std::pow(thickness / radius, 2) / 12.0);
  double error = 0.0;
  for (const ProbeSummary& probe : solution.summary.probes) {
    const double radial = probe.displacement.dot(probe.position.normalized());
    error = std::max(error, std::abs(radial / expected - 1.0));
  }
  EXPECT_LE(error, 2e-4);
  Report("sphere under pressure", error);
}

// Pulled along its length, free across: u = F L / (E h), and it narrows by nu of that.
TEST_P(PoissonTest, PulledStripNarrowsByIt) {
  const Solution solution = SolveScene(SceneFromText(Fill(R"(
name: strip
surface: {kind: plane, u: [0, 10], v: [0, 2], divisions: [10, 4]}
shell: {thickness: 0.1, young_modulus: 1000, poisson_ratio: $nu}
model: {theory: linear, quadrature: 6}
supports: [{on: u_min, fix: [x]}, {on: v_min, fix: [y]}, {on: u_min, fix: [z]}, {on: u_max, fix: [z]}]
loads: [{kind: edge, on: u_max, force: [1, 0, 0]}]
probes: [{name: corner, at: {uv: [10, 2]}}]
)",
                                                          {{"nu", nu()}})));
  const double along = 10.0 / 100.0, across = -nu() * 2.0 / 100.0;
  const double error =
      std::max(std::abs(solution.Probe().x() - along), std::abs(solution.Probe().y() - across)) /
      along;
  EXPECT_LE(error, 1e-9);
  Report("pulled strip", error);
}

// A strip of length 10 bent by a moment m at its free end, cylindrically (its sides held from
// turning about its length): a circle of radius D / m.
TEST_P(PoissonTest, CantileverBendsToACircleOfItsStiffness) {
  const double d = 1.2e6 * 1e-3 / (12.0 * (1.0 - nu() * nu()));
  const double moment = 0.1 * d;  // curvature 0.1: one radian at the end
  const Solution solution = SolveScene(SceneFromText(Fill(R"(
name: cantilever
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [24, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: $nu}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
  - {on: v_min, symmetry: y}
  - {on: v_max, symmetry: y}
loads: [{kind: edge, on: u_max, moment: [0, -$m, 0]}]
probes: [{name: tip, at: {uv: [10, 0.5]}}]
)",
                                                          {{"nu", nu()}, {"m", moment}})));
  const Eigen::Vector3d circle = KoiterCircle(10.0, 0.1, 0.1);
  const double error = (solution.Probe() - circle).norm() / 10.0;
  EXPECT_LE(error, 1e-5);
  Report("cantilever to one radian", error);
}

// Nothing is special at 1/2: answers go there smoothly.
TEST(PoissonLimitTest, HalfIsTheLimitOfNearlyHalf) {
  const auto solve = [](double nu) {
    return SolveScene(SceneFromText(Fill(R"(
name: torus
surface: {kind: torus, radii: [50, 20], u: [0, 2], v: [-1, 1.5], divisions: [8, 8]}
shell: {thickness: 1, young_modulus: 20, poisson_ratio: $nu}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}]
loads: [{kind: point, at: {uv: [2, 1.5]}, force: [0.002, 0.001, -0.003]}]
probes: [{name: tip, at: {uv: [2, 1.5]}}]
)",
                                         {{"nu", nu}})))
        .Probe();
  };
  const Eigen::Vector3d half = solve(0.5);
  const double far = (solve(0.4999) - half).norm() / half.norm();
  const double near = (solve(0.49999999) - half).norm() / half.norm();
  EXPECT_LE(far, 2e-4);
  EXPECT_NEAR(near / far, 1e-4, 2e-5);
  Measured("poisson: torus, 0.4999 against 0.5", far);
}

INSTANTIATE_TEST_SUITE_P(Ratios,
                         PoissonTest,
                         ::testing::Values(-0.9, -0.5, 0.0, 0.3, 0.45, 0.4999, 0.5),
                         [](const auto& info) {
                           std::string name = std::to_string(std::abs(info.param)).substr(2);
                           return (info.param < 0.0 ? "minus_0" : "0") + ("_" + name);
                         });

}  // namespace
}  // namespace darboux
