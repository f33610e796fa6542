#include "solver/accuracy_reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/accuracy_util.h"

namespace darboux {
namespace {

TEST(RoundingUncertaintyTest, IsHalfAUnitInTheLastDigitThatIsPrinted) {
  EXPECT_NEAR(RoundingUncertainty(4.067), 0.0005 / 4.067, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(-1.8248e-5), 0.00005 / 1.8248, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(13.891), 0.0005 / 13.891, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(7.0), 0.5 / 7.0, 1e-12);
  EXPECT_LT(RoundingUncertainty(1.0 / 3.0), 1e-15);
  EXPECT_EQ(RoundingUncertainty(0.0), 0.0);
}

TEST(ExpectedQuantitiesTest, AreThoseThatMeasureAccuracy) {
  const Scene scene = Plate(
      "probes: [{name: p, at: {uv: [1, 0.5]}}]\n"
      "expect:\n"
      "  - {quantity: probes.p.displacement.z, value: 4.067, relative_tolerance: 0.1}\n"
      "  - {quantity: iterations, value: 3, absolute_tolerance: 2}\n"
      "  - {quantity: equilibrium.force_balance, value: 1e-9, absolute_tolerance: 1e-9}\n"
      "  - {quantity: fingers.top.penetration, value: 1e-9, absolute_tolerance: 1e-9}\n"
      "  - {quantity: probes.p.displacement.x, value: 0, absolute_tolerance: 1e-9}\n");
  std::vector<std::string> notes;
  const std::vector<StudyQuantity> quantities = ExpectedQuantities(scene, &notes);
  ASSERT_EQ(quantities.size(), 1u);
  EXPECT_EQ(quantities[0].path, "probes.p.displacement.z");
  EXPECT_NEAR(quantities[0].uncertainty, 1.23e-4, 1e-6);
  EXPECT_EQ(notes.size(), 4u);
}

class ExtrapolateTest : public ::testing::TestWithParam<double> {};
TEST_P(ExtrapolateTest, FindsLimitAndOrderOfAPowerForAnyRatioOfSizes) {
  const double order = GetParam();
  for (const std::vector<double>& h :
       {std::vector<double>{1.0, 0.5, 0.25, 0.125}, std::vector<double>{1.0, 0.6, 0.25, 0.2}}) {
    std::vector<double> values;
    for (const double size : h) values.push_back(-3.0 + 0.7 * std::pow(size, order));
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    ASSERT_TRUE(limit->order.has_value());
    EXPECT_NEAR(*limit->order, order, 1e-6);
    EXPECT_NEAR(limit->value, -3.0, 1e-9);
    // Where the power is exact the uncertainty is a third of the last distance.
    EXPECT_NEAR(limit->uncertainty, std::abs(values.back() + 3.0) / 3.0, 1e-6);
  }
}
INSTANTIATE_TEST_SUITE_P(Orders, ExtrapolateTest, ::testing::Values(0.6, 1.0, 2.0, 3.3, 4.0, 4.9));

TEST(ExtrapolateTest, TheUncertaintyCoversTheErrorOfMixedPowers) {
  std::vector<double> h, values;
  for (int k = 0; k < 5; ++k) {
    h.push_back(std::ldexp(1.0, -k));
    values.push_back(1.0 + 0.3 * std::pow(h.back(), 2.0) - 0.5 * std::pow(h.back(), 3.0));
    if (k < 2) continue;
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    EXPECT_LE(std::abs(limit->value - 1.0), limit->uncertainty) << k;
  }
}

TEST(ExtrapolateTest, PromisesNothingWhereValuesSwingStallOrLeap) {
  const std::vector<double> h{1.0, 0.5, 0.25};
  for (const std::vector<double>& values : {std::vector<double>{1.0, 2.0, 1.5},
                                            std::vector<double>{1.0, 2.0, 3.0},
                                            std::vector<double>{1.0, 1.5, 2.5},
                                            std::vector<double>{1.0, 2.0, 2.01}}) {
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    EXPECT_FALSE(limit->order.has_value());
    EXPECT_EQ(limit->value, values[2]);
    EXPECT_GE(limit->uncertainty, std::abs(values[2] - values[1]));
  }
  EXPECT_FALSE(Extrapolate({1.0, 0.5}, {1.0, 1.1}).has_value());
  EXPECT_FALSE(Extrapolate(h, {1.0, std::nan(""), 1.1}).has_value());
}

StudyQuantity Quantity(const std::string& path, const std::string& group) {
  StudyQuantity quantity;
  quantity.path = path;
  quantity.group = group;
  return quantity;
}

TEST(ExtrapolateFamiliesTest, TakesTheBestAndHeedsTheOthers) {
  const std::vector<StudyQuantity> quantities{Quantity("energy.total", "energy.total")};
  const auto family = [](const std::string& name, double limit, double order) {
    FamilyValues values;
    values.name = name;
    for (const double h : {1.0, 0.5, 0.25, 0.125}) {
      values.h.push_back(h);
      values.values.push_back({limit + std::pow(h, order)});
    }
    return values;
  };
  const auto agree =
      ExtrapolateFamilies(quantities, {family("slow", 5.0, 1.0), family("fast", 5.0, 4.0)});
  ASSERT_TRUE(agree.has_value());
  EXPECT_EQ(agree->family, "fast");
  EXPECT_NEAR(agree->quantities[0].reference, 5.0, 1e-9);
  EXPECT_LT(agree->uncertainty, 1e-4);
  // Another limit: the uncertainty says so.
  const auto differ =
      ExtrapolateFamilies(quantities, {family("other", 5.5, 3.0), family("fast", 5.0, 4.0)});
  ASSERT_TRUE(differ.has_value());
  EXPECT_NEAR(differ->uncertainty, 0.1, 1e-3);
}

TEST(ExtrapolateFamiliesTest, AHeldProbeIsMeasuredAgainstTheOthers) {
  const std::vector<StudyQuantity> quantities{
      Quantity("probes.a.displacement.z", "probes.a.displacement"),
      Quantity("probes.b.displacement.z", "probes.b.displacement"),
      Quantity("gas.absolute_pressure", "gas.absolute_pressure")};
  FamilyValues family;
  for (const double h : {1.0, 0.5, 0.25}) {
    family.h.push_back(h);
    family.values.push_back({2.0 + h * h, 1e-17 * h, 0.0});
  }
  const auto reference = ExtrapolateFamilies(quantities, {family});
  ASSERT_TRUE(reference.has_value());
  // The pressure, zero for all, is gone.
  ASSERT_EQ(reference->quantities.size(), 2u);
  EXPECT_NEAR(reference->quantities[1].scale, 2e-4, 1e-10);
  const auto error = ErrorOf(reference->quantities,
                             {{"probes.a.displacement.z", 2.5}, {"probes.b.displacement.z", 0.0}});
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->error, 0.25, 1e-6);
  EXPECT_FALSE(ErrorOf(reference->quantities, {{"probes.a.displacement.z", 2.5}}).has_value());
}

}  // namespace
}  // namespace darboux
