// Hard cases: determinism. The same input gives the same bits on one thread, and the same answer on
// two.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/deform_util.h"
#include "tests/hard_util.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

struct Case {
  const char* name;
  const char* text;
};

constexpr Case kCases[] = {{"linear", R"(name: cylinder
surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [24, 24]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: u_min, fix: [y, z]}
  - {on: u_max, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, symmetry: z}
loads: [{kind: point, at: {uv: [300, 0]}, force: [0, 0, -0.25]}]
)"},
                           {"nonlinear", R"(name: strip
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [32, 4]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}]
loads: [{kind: edge, on: u_max, force: [0, 0, 4]}]
steps: 2
)"},
                           {"fingers", R"(name: fingers
surface: {kind: plane, u: [0, 100], v: [0, 80], divisions: [16, 12]}
shell: {thickness: 1, young_modulus: 1e7, poisson_ratio: 0.3}
supports: [{on: rim, clamped: true}]
fingers:
  - {name: top, shape: {kind: sphere, radius: 20}, position: [45, 37, 40],
     direction: [0.1, 0.05, -1], motion: {travel: 2}, friction: 0.5}
)"},
                           {"gas", R"(name: gas
surface: {kind: icosphere, radius: 31.25, frequency: 4}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
loads:
  - {kind: gas, gauge_pressure: 0.02, ambient_pressure: 0.101325}
  - {kind: traction, force: [0, 0, "-0.004*z/31.25"]}
)"}};

class HardDeterminismTest : public DeformTest, public ::testing::WithParamInterface<Case> {
 protected:
  // All files of a run; the summary without its times.
  std::map<std::string, std::string> Results(const std::string& threads) {
    EXPECT_EQ(Run({Write("scene.yaml", GetParam().text), OutFlag(), "--threads=" + threads}), 0)
        << Stderr();
    std::map<std::string, std::string> results;
    for (const std::string& name : FilesIn(Out())) results[name] = ReadFile(Out() / name);
    Json summary = Summary();
    EXPECT_EQ(summary.erase("time_s"), 1u);
    results["summary.json"] = summary.dump();
    return results;
  }
};

TEST_P(HardDeterminismTest, OneThreadGivesTheSameBitsTwice) {
  const auto first = Results("1"), second = Results("1");
  ASSERT_GE(first.size(), 5u);
  ASSERT_EQ(second.size(), first.size());
  for (const auto& [name, text] : first) EXPECT_EQ(second.at(name), text) << name;
}

TEST_P(HardDeterminismTest, TwoThreadsGiveTheAnswerOfOne) {
  Results("1");
  const Vtu one = ReadVtu(Out() / "shell.vtu");
  const Json summary = Summary();
  Results("2");
  const Vtu two = ReadVtu(Out() / "shell.vtu");
  double worst = 0.0;
  ASSERT_EQ(two.arrays.size(), one.arrays.size());
  for (const auto& [name, values] : one.arrays) {
    if (name == "mode") continue;  // defined up to its sign
    const std::vector<double>& other = two.arrays.at(name);
    ASSERT_EQ(other.size(), values.size()) << name;
    double largest = 0.0, change = 0.0;
    for (size_t i = 0; i < values.size(); ++i) {
      largest = std::max(largest, std::abs(values[i]));
      change = std::max(change, std::abs(other[i] - values[i]));
    }
    EXPECT_LE(change, 1e-10 * largest) << name;
    if (largest > 0.0) worst = std::max(worst, change / largest);
  }
  EXPECT_EQ(Summary()["iterations"], summary["iterations"]);
  const double energy = summary["energy"]["total"].get<double>();
  EXPECT_NEAR(Summary()["energy"]["total"].get<double>(), energy, 1e-10 * std::abs(energy));
  Measured(std::string("determinism, ") + GetParam().name + ": two threads against one", worst);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         HardDeterminismTest,
                         ::testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace darboux
