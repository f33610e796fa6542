// Hard cases: interruption. A time limit or Ctrl-C in the middle ends the run with exit status 1
// and the last good state, complete and marked as what it is.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "tests/deform_util.h"
#include "tests/hard_util.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;

struct Case {
  const char* name;
  const char* text;
  bool has_steps;  // Some are finished before the time is up.
};

// Each would take far longer than the test gives it.
constexpr Case kCases[] = {{"linear",
                            R"(name: linear
surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [150, 150]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: u_min, fix: [y, z]}
  - {on: u_max, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, symmetry: z}
loads: [{kind: point, at: {uv: [300, 0]}, force: [0, 0, -0.25]}]
)",
                            false},
                           {"nonlinear",
                            R"(name: nonlinear
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 50}]
steps: 5000
)",
                            true},
                           {"descent",
                            R"(name: descent
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [48, 6]}
shell: {thickness: 0.001, young_modulus: 1.2e12, poisson_ratio: 0}
model: {theory: nonlinear, minimizer: ceres}
supports: [{on: u_min, clamped: true}]
loads: [{kind: edge, on: u_max, force: [0, 0, 4]}]
)",
                            false},
                           {"arc_length",
                            R"(name: arc-length
surface: {kind: cylinder, radius: 2540, u: [0, 254], v: [0, 0.1], divisions: [24, 24]}
shell: {thickness: 6.35, young_modulus: 3102.75, poisson_ratio: 0.3}
model: {theory: nonlinear}
path: {control: arc_length}
steps: 200
supports:
  - {on: u_min, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, fix: [x, y, z]}
loads: [{kind: point, at: {uv: [0, 0]}, force: [0, 0, -750]}]
)",
                            true},
                           {"fingers",
                            R"(name: fingers
surface: {kind: plane, u: [0, 100], v: [0, 80], divisions: [16, 12]}
shell: {thickness: 1, young_modulus: 1e7, poisson_ratio: 0.3}
supports: [{on: rim, clamped: true}]
fingers:
  - {name: top, shape: {kind: sphere, radius: 20}, position: [45, 37, 40],
     direction: [0.1, 0.05, -1], motion: {travel: 20}, friction: 0.5}
steps: 1000
)",
                            true},
                           {"gas",
                            R"(name: gas
surface: {kind: icosphere, radius: 31.25, frequency: 6}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
loads:
  - {kind: gas, gauge_pressure: 0.02, ambient_pressure: 0.101325}
  - {kind: traction, force: [0, 0, "-0.004*z/31.25"]}
steps: 5000
)",
                            true}};

class HardInterruptionTest : public DeformTest, public ::testing::WithParamInterface<Case> {
 protected:
  void ExpectMarkedResults(const std::string& reason) const {
    const Json summary = Summary();
    ASSERT_TRUE(summary.is_object()) << "no valid JSON";
    EXPECT_EQ(summary["converged"], false);
    EXPECT_THAT(summary["message"].get<std::string>(), HasSubstr(reason));
    EXPECT_THAT(Stderr(), HasSubstr("not converged: "));
    const Json& steps = summary["load_steps"];
    ASSERT_GE(steps.size(), 1u);
    // All but the last are done; the last is a state on the way.
    for (size_t i = 0; i + 1 < steps.size(); ++i) EXPECT_EQ(steps[i]["converged"], true) << i;
    if (GetParam().has_steps) {
      EXPECT_LT(steps.back()["factor"].get<double>(), 1.0);
    }
    ExpectCompleteResults(steps.size());
    ReadVtu(Out() / "shell.vtu");  // expects finite numbers
  }
};

TEST_P(HardInterruptionTest, TimeLimitLeavesTheLastGoodState) {
  const std::string scene = Write("scene.yaml", GetParam().text);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(
      Run({scene, OutFlag(), GetParam().has_steps ? "--time_limit=0.4" : "--time_limit=0.05"}), 1)
      << Stderr();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  ExpectMarkedResults("time limit");
}

TEST_P(HardInterruptionTest, InterruptLeavesTheLastGoodState) {
  const pid_t pid = Start({Write("scene.yaml", GetParam().text), OutFlag()});
  if (GetParam().has_steps) {
    for (int i = 0; i < 6000 && Stderr().find("step ") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  } else {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
  }
  kill(pid, SIGINT);
  EXPECT_EQ(Wait(pid), 1) << Stderr();
  ExpectMarkedResults("stopped by the user");
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         HardInterruptionTest,
                         ::testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace darboux
