// What an effect costs: nothing where a scene does not name it, and its own blocks where it does.

#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

// What Ceres gets, and the state that comes out.
struct Price {
  std::array<int, kNumEffects> blocks{}, residuals{};
  std::array<bool, kNumEffects> on{};
  int all_blocks = 0, all_residuals = 0, parameter_blocks = 0, unknowns = 0, iterations = 0;
  Eigen::Matrix3Xd displacements;

  int Blocks(Effect effect) const { return blocks[static_cast<int>(effect)]; }
  bool On(Effect effect) const { return on[static_cast<int>(effect)]; }
};

Price PriceOf(const std::string& scene) {
  SolverOptions options;
  options.num_threads = 1;
  const Solution solution = SolveScene(SceneFromText(scene), options);
  Price price;
  for (int e = 0; e < kNumEffects; ++e) {
    const EffectReport& report = solution.summary.effects.at(e).report;
    price.blocks[e] = report.residual_blocks;
    price.residuals[e] = report.residuals;
    price.on[e] = report.on;
  }
  const ceres::Problem* const problem = solution.problem->problem();
  price.all_blocks = problem->NumResidualBlocks();
  price.all_residuals = problem->NumResiduals();
  price.parameter_blocks = problem->NumParameterBlocks();
  price.unknowns = solution.summary.unknowns;
  price.iterations = solution.summary.iterations;
  price.displacements = solution.problem->displacements();
  return price;
}

// ---- Absent and empty ---------------------------------------------------------------------------

class AbsentEffectTest : public ::testing::TestWithParam<const char*> {};

TEST_P(AbsentEffectTest, CostsNothingMoreThanAnEmptyOne) {
  const std::string plate = std::string(R"(
name: plate
surface: {kind: cylinder, radius: 100, u: [0, 100], v: [0, 1], divisions: [6, 6]}
supports: [{on: u_min, clamped: true, displacement: [0, 0, 0.1]}, {on: u_max, clamped: true}]
model: {theory: )") + GetParam();
  const Price absent = PriceOf(plate + R"(}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
)");
  const Price empty = PriceOf(plate + R"(, unstable: report}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3, density: 0}
loads: []
fingers: []
probes: []
expect: []
steps: 1
path: {control: load}
)");
  EXPECT_EQ(empty.blocks, absent.blocks);
  EXPECT_EQ(empty.residuals, absent.residuals);
  EXPECT_EQ(empty.on, absent.on);
  EXPECT_EQ(empty.all_blocks, absent.all_blocks);
  EXPECT_EQ(empty.all_residuals, absent.all_residuals);
  EXPECT_EQ(empty.parameter_blocks, absent.parameter_blocks);
  EXPECT_EQ(empty.unknowns, absent.unknowns);
  EXPECT_EQ(empty.iterations, absent.iterations);
  EXPECT_EQ(empty.displacements, absent.displacements);  // every bit
  EXPECT_GT(absent.displacements.norm(), 0.0);
  for (const Effect effect :
       {Effect::kContact, Effect::kFriction, Effect::kGas, Effect::kGravity, Effect::kLoads}) {
    EXPECT_FALSE(absent.On(effect)) << ToString(effect);
    EXPECT_EQ(absent.Blocks(effect), 0) << ToString(effect);
  }
}

INSTANTIATE_TEST_SUITE_P(Theories,
                         AbsentEffectTest,
                         ::testing::Values("linear", "nonlinear", "auto"),
                         [](const auto& info) { return std::string(info.param); });

// ---- What each adds -----------------------------------------------------------------------------

// A ball held at three points: with a load, so that nothing is off because nothing happens.
struct Switches {
  bool finger = false, friction = false, gas = false, gravity = false, load = true;
  const char* theory = "nonlinear";
};

Price Ball(const Switches& s) {
  std::string text = std::string(R"(
name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 3}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5, density: 1.0e-9}
supports:
  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y, z]}
  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}
  - {on: {near: [31.25, 0, 0], radius: 0}, fix: [y]}
model: {theory: )") + s.theory +
                     "}\nloads:\n";
  if (s.load) text += "  - {kind: point, at: {nearest: [31, 0, 0]}, force: [0, 0, 1.0e-4]}\n";
  if (s.gas) text += "  - {kind: gas, gauge_pressure: 0, ambient_pressure: 0.101325}\n";
  if (s.gravity) text += "  - {kind: gravity, acceleration: [0, 0, -9810]}\n";
  if (!s.load && !s.gas && !s.gravity) text += "  []\n";
  if (s.finger) {
    text +=
        "fingers:\n  - {name: top, shape: {kind: sphere, radius: 6}, position: [0, 0, 60], "
        "direction: [0, 0, -1], motion: {travel: 0.5}";
    if (s.friction) text += ", friction: 0.5";
    text += "}\n";
  }
  return PriceOf(text);
}

// Only the effects named have other blocks; the strain energies have theirs, one an element.
void ExpectOnlyChanged(const Price& base, const Price& with, const std::vector<Effect>& changed) {
  constexpr int kElements = 20 * 3 * 3;
  for (int e = 0; e < kNumEffects; ++e) {
    const Effect effect = static_cast<Effect>(e);
    const bool is_changed = std::count(changed.begin(), changed.end(), effect) > 0;
    if (is_changed) {
      EXPECT_GT(with.blocks[e], base.blocks[e]) << ToString(effect);
    } else {
      EXPECT_EQ(with.blocks[e], base.blocks[e]) << ToString(effect);
      EXPECT_EQ(with.residuals[e], base.residuals[e]) << ToString(effect);
    }
  }
  EXPECT_EQ(with.Blocks(Effect::kMembrane), kElements);
  EXPECT_EQ(with.Blocks(Effect::kBending), kElements);
  EXPECT_EQ(with.unknowns, base.unknowns);
  EXPECT_EQ(with.parameter_blocks, base.parameter_blocks);
  // Ceres has what the reports say: membrane and bending of an element share a block.
  for (const Price* price : {&base, &with}) {
    int blocks = -kElements, residuals = 0;
    for (int e = 0; e < kNumEffects; ++e) {
      blocks += price->blocks[e];
      residuals += price->residuals[e];
    }
    EXPECT_EQ(price->all_blocks, blocks);
    EXPECT_EQ(price->all_residuals, residuals);
  }
}

TEST(EffectPriceTest, FingerAddsContactBlocks) {
  Switches with;
  with.finger = true;
  const Price base = Ball({}), price = Ball(with);
  ExpectOnlyChanged(base, price, {Effect::kContact});
  EXPECT_TRUE(price.On(Effect::kContact));
  EXPECT_FALSE(price.On(Effect::kFriction));
}

TEST(EffectPriceTest, FrictionAddsABlockForEachContactPoint) {
  Switches base, with;
  base.finger = with.finger = with.friction = true;
  const Price without = Ball(base), price = Ball(with);
  ExpectOnlyChanged(without, price, {Effect::kFriction});
  EXPECT_TRUE(price.On(Effect::kFriction));
  EXPECT_EQ(price.Blocks(Effect::kFriction), price.Blocks(Effect::kContact));
}

TEST(EffectPriceTest, GasAddsItsBlocks) {
  Switches with;
  with.gas = true;
  const Price base = Ball({}), price = Ball(with);
  EXPECT_TRUE(price.On(Effect::kGas));
  // Shares of the volume, summed over a binary tree, have unknowns of their own in Ceres' problem,
  // but none in Newton's.
  EXPECT_EQ(price.unknowns, base.unknowns);
  EXPECT_GT(price.Blocks(Effect::kGas), 0);
  // What makes the gas's resultant exact acts on every vertex, through the load vector.
  EXPECT_EQ(price.Blocks(Effect::kLoads), 10 * 3 * 3 + 2);
  for (int e = 0; e < kNumEffects; ++e) {
    const Effect effect = static_cast<Effect>(e);
    if (effect == Effect::kGas || effect == Effect::kLoads) continue;
    EXPECT_EQ(price.blocks[e], base.blocks[e]) << ToString(effect);
    EXPECT_EQ(price.residuals[e], base.residuals[e]) << ToString(effect);
  }
}

TEST(EffectPriceTest, GravityIsPartOfTheLoads) {
  Switches base, with;
  with.gravity = true;
  const Price price = Ball(with);
  ExpectOnlyChanged(Ball(base), price, {Effect::kLoads});
  EXPECT_TRUE(price.On(Effect::kGravity));
  EXPECT_EQ(price.Blocks(Effect::kGravity), 0);
}

TEST(EffectPriceTest, GeometricNonlinearityAddsNoBlockAndNoUnknown) {
  Switches linear;
  linear.theory = "linear";
  const Price base = Ball(linear), price = Ball({});
  EXPECT_FALSE(base.On(Effect::kGeometricNonlinearity));
  EXPECT_TRUE(price.On(Effect::kGeometricNonlinearity));
  EXPECT_EQ(price.blocks, base.blocks);
  EXPECT_EQ(price.unknowns, base.unknowns);
  EXPECT_EQ(price.parameter_blocks, base.parameter_blocks);
}

TEST(EffectPriceTest, AllTogetherAreTheSumOfEach) {
  Switches all, finger, gas, gravity;
  all.finger = all.friction = all.gas = all.gravity = true;
  finger.finger = finger.friction = gas.gas = gravity.gravity = true;
  const Price price = Ball(all), with_finger = Ball(finger), with_gas = Ball(gas),
              with_gravity = Ball(gravity);
  EXPECT_EQ(price.Blocks(Effect::kContact), with_finger.Blocks(Effect::kContact));
  EXPECT_EQ(price.Blocks(Effect::kFriction), with_finger.Blocks(Effect::kFriction));
  EXPECT_EQ(price.Blocks(Effect::kGas), with_gas.Blocks(Effect::kGas));
  EXPECT_EQ(price.Blocks(Effect::kLoads), with_gravity.Blocks(Effect::kLoads));
  EXPECT_EQ(price.Blocks(Effect::kSupports), with_gas.Blocks(Effect::kSupports));
  EXPECT_EQ(price.unknowns, with_gas.unknowns);
}

}  // namespace
}  // namespace darboux
