// Hard cases: systems of units. Every dimensionless answer is the same whatever lengths and forces
// are counted in, from 1e-9 to 1e9 of either.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/hard_util.h"

namespace darboux {
namespace {

struct Units {
  double length, force;
};

struct Case {
  const char* name;
  const char* text;  // $l: unit of length, $f of force, $s of stress, $e of force per length
};

constexpr Case kCases[] = {{"linear", R"(
name: torus
surface: {kind: torus, radii: [50*$l, 20*$l], u: [0, 2], v: [-1, 1.5], divisions: [8, 8]}
shell: {thickness: 1*$l, young_modulus: 20*$s, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: u_min, clamped: true}]
loads:
  - {kind: point, at: {uv: [2, 1.5]}, force: [0.02*$f, 0.01*$f, -0.03*$f]}
  - {kind: pressure, value: 1e-4*$s}
probes: [{name: tip, at: {uv: [2, 1.5]}}]
)"},
                           {"nonlinear", R"(
name: strip
surface: {kind: plane, u: [0, 10*$l], v: [0, 1*$l], divisions: [16, 2]}
shell: {thickness: 0.1*$l, young_modulus: 1.2e6*$s, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}]
loads:
  - {kind: edge, on: u_max, force: [0, 0, 4*$e], moment: [0, -10*$f, 0]}
  - {kind: pressure, value: 0.1*$s}
probes: [{name: tip, at: {uv: [10*$l, 0.5*$l]}}]
)"},
                           {"fingers", R"(
name: ball
surface: {kind: icosphere, radius: 31.25*$l, frequency: 3}
shell: {thickness: 2.5*$l, young_modulus: 1*$s, poisson_ratio: 0.5}
supports:
  - {on: {near: [0, 0, 31.25*$l], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -31.25*$l], radius: 0}, fix: [x, y]}
  - {on: {near: [31.25*$l, 0, 0], radius: 0}, fix: [y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 4*$l}, position: [0, 0, 40*$l],
     direction: [0, 0, -1], motion: {travel: 2*$l}}
  - {name: bottom, shape: {kind: sphere, radius: 4*$l}, position: [0, 0, -40*$l],
     direction: [0, 0, 1], motion: {travel: 2*$l}}
probes: [{name: side, at: {nearest: [31.25*$l, 0, 0]}}]
)"},
                           {"friction", R"(
name: plate-under-a-sticking-ball
surface: {kind: plane, u: [0, 100*$l], v: [0, 80*$l], divisions: [10, 8]}
shell: {thickness: 1*$l, young_modulus: 1e7*$s, poisson_ratio: 0.3}
supports: [{on: rim, clamped: true}]
fingers:
  - {name: top, shape: {kind: sphere, radius: 20*$l}, position: [45*$l, 37*$l, 40*$l],
     direction: [0.1, 0.05, -1], motion: {travel: 2*$l}, friction: 0.5}
probes: [{name: beside, at: {uv: [50*$l, 40*$l]}}]
)"},
                           {"gas", R"(
name: gas
surface: {kind: icosphere, radius: 31.25*$l, frequency: 3}
shell: {thickness: 2.5*$l, young_modulus: 1*$s, poisson_ratio: 0.5}
loads:
  - {kind: gas, gauge_pressure: 0.02*$s, ambient_pressure: 0.101325*$s}
  - {kind: traction, force: [0, 0, "-0.004*$s*z/31.25/$l"]}
probes: [{name: pole, at: {nearest: [0, 0, 31.25*$l]}}]
)"}};

Scene InUnits(const Case& c, const Units& units) {
  std::string text = c.text;
  const auto replace = [&text](const std::string& name, double value) {
    for (size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
      text.replace(at, name.size(), Text(value));
    }
  };
  replace("$l", units.length);
  replace("$f", units.force);
  replace("$s", units.force / (units.length * units.length));
  replace("$e", units.force / units.length);
  return SceneFromText(text);
}

// What a scene answers, without a unit.
std::vector<double> Answer(const Case& c, const Units& units) {
  SolverOptions options;
  options.gradient_tolerance = 1e-11;
  const Solution solution = SolveScene(InUnits(c, units), options);
  const SolverSummary& summary = solution.summary;
  std::vector<double> answer;
  for (int i = 0; i < 3; ++i) answer.push_back(solution.Probe()[i] / units.length);
  const double work = units.force * units.length;
  answer.push_back(summary.energy_total / work);
  answer.push_back(summary.max_rotation);
  answer.push_back(summary.max_membrane_strain);
  for (const FingerReport& finger : summary.steps.back().fingers) {
    answer.push_back(finger.normal_force / units.force);
  }
  if (summary.steps.back().gas) {
    answer.push_back(summary.steps.back().gas->volume_ratio);
    answer.push_back(summary.steps.back().gas->gauge_pressure /
                     (units.force / (units.length * units.length)));
  }
  return answer;
}

// Nothing is rounded where lengths and forces are counted in powers of two: not even what friction
// makes depend on the last digit (an off-centre ball whose points slip) may change.
constexpr Case kSlipping = {"slipping", R"(
name: slipping-ball
surface: {kind: icosphere, radius: 31.25*$l, frequency: 3}
shell: {thickness: 2.5*$l, young_modulus: 1*$s, poisson_ratio: 0.5}
fingers:
  - {name: top, shape: {kind: sphere, radius: 4*$l}, position: [1*$l, 0, 40*$l],
     direction: [0, 0, -1], motion: {travel: 2*$l}, friction: 0.5}
  - {name: bottom, shape: {kind: sphere, radius: 4*$l}, position: [1*$l, 0, -40*$l],
     direction: [0, 0, 1], motion: {travel: 2*$l}, friction: 0.5}
probes: [{name: side, at: {nearest: [31.25*$l, 0, 0]}}]
)"};

class UnitsTest : public ::testing::TestWithParam<Case> {};

TEST_P(UnitsTest, FromANanoToAGigaChangeNothing) {
  const std::vector<double> expected = Answer(GetParam(), {1.0, 1.0});
  const double displacement = std::hypot(expected[0], expected[1], expected[2]);
  ASSERT_GT(displacement, 0.0);
  double worst = 0.0;
  for (const Units& units :
       {Units{1e-9, 1e-9}, Units{1e-9, 1e9}, Units{1e9, 1e-9}, Units{1e9, 1e9}}) {
    SCOPED_TRACE(Text(units.length) + ", " + Text(units.force));
    const std::vector<double> answer = Answer(GetParam(), units);
    ASSERT_EQ(answer.size(), expected.size());
    for (size_t i = 0; i < answer.size(); ++i) {
      const double scale = i < 3 ? displacement : std::abs(expected[i]);
      const double error = std::abs(answer[i] - expected[i]) / scale;
      EXPECT_LE(error, 1e-9) << i;
      worst = std::max(worst, error);
    }
  }
  Measured(std::string("units, ") + GetParam().name + ": largest relative change", worst);
}

TEST(PowersOfTwoTest, ChangeNoBit) {
  const double big = std::ldexp(1.0, 30);
  for (const Case& c : {kCases[1], kSlipping}) {
    EXPECT_EQ(Answer(c, {1.0 / big, 2.0 * big}), Answer(c, {1.0, 1.0})) << c.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, UnitsTest, ::testing::ValuesIn(kCases), [](const auto& info) {
  return std::string(info.param.name);
});

}  // namespace
}  // namespace darboux
