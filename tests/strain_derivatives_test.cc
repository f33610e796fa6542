#include "costs/strain_derivatives.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix15d = Eigen::Matrix<double, 15, 15>;
using Jet = ceres::Jet<double, 15>;

// Sizes of the fifteen numbers; at 0.3 the shell is stretched, turned and bent all at once.
class StrainDerivativesTest : public ::testing::TestWithParam<std::tuple<StrainMeasure, double>> {
 protected:
  StrainMeasure measure() const { return std::get<0>(GetParam()); }
  Fifteen State(unsigned seed) const { return SeededUniform(15, std::get<1>(GetParam()), seed); }
};

TEST_P(StrainDerivativesTest, GradientIsThatOfAutodiff) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    for (const StrainPoint& point : SamplePoints()) {
      const Fifteen k = State(seed);
      std::array<Jet, 15> jets;
      for (int i = 0; i < 15; ++i) jets[i] = Jet(k[i], i);
      std::array<Jet, 6> e;
      EvaluateMembraneStrain(measure(), point, jets.data(), e.data());
      ASSERT_TRUE(EvaluateBendingStrain(measure(), point, jets.data(), e.data() + 3));
      StrainDerivatives derivatives;
      ASSERT_TRUE(EvaluateStrainDerivatives(measure(), point, k.data(), &derivatives));
      for (int a = 0; a < 6; ++a) {
        EXPECT_NEAR(derivatives.strain[a], e[a].a, 1e-14 * k.norm());
        EXPECT_LT((derivatives.gradient.row(a).transpose() - e[a].v).norm(),
                  1e-14 * (1.0 + e[a].v.norm()));
      }
    }
  }
}

// Gradient of sum_a stress_a strain_a by autodiff, differenced once with an error of the sixth
// order.
TEST_P(StrainDerivativesTest, StressStiffnessIsTheDerivativeOfAutodiff) {
  const auto gradient = [&](const StrainPoint& point, const Vector6d& stress, const Fifteen& k) {
    std::array<Jet, 15> jets;
    for (int i = 0; i < 15; ++i) jets[i] = Jet(k[i], i);
    std::array<Jet, 6> e;
    EvaluateMembraneStrain(measure(), point, jets.data(), e.data());
    EXPECT_TRUE(EvaluateBendingStrain(measure(), point, jets.data(), e.data() + 3));
    Fifteen result = Fifteen::Zero();
    for (int a = 0; a < 6; ++a) result += stress[a] * e[a].v;
    return result;
  };
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Vector6d stress = SeededUniform(6, 1.0, seed + 100);
    for (const StrainPoint& point : SamplePoints()) {
      const Fifteen k = State(seed);
      Matrix15d expected;
      constexpr double kStep = 4e-3;
      for (int i = 0; i < 15; ++i) {
        const Fifteen unit = kStep * Fifteen::Unit(i);
        const auto central = [&](double m) -> Fifteen {
          return (gradient(point, stress, k + m * unit) - gradient(point, stress, k - m * unit)) /
                 (2.0 * m * kStep);
        };
        expected.col(i) = 1.5 * central(1.0) - 0.6 * central(2.0) + 0.1 * central(3.0);
      }
      Matrix15d stiffness = Matrix15d::Zero();
      AddStressStiffness(measure(), point, k.data(), stress, &stiffness);
      EXPECT_LT((stiffness - expected).norm(), 1e-9 * (1.0 + expected.norm()));
      EXPECT_LT((stiffness - stiffness.transpose()).norm(), 1e-14 * (1.0 + expected.norm()));
      if (IsLinear(measure())) {
        EXPECT_EQ(stiffness.norm(), 0.0);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Measures,
                         StrainDerivativesTest,
                         ::testing::Combine(::testing::ValuesIn(AllMeasures()),
                                            ::testing::Values(0.0, 1e-8, 1e-2, 0.3)),
                         [](const auto& info) {
                           return Name(std::get<0>(info.param)) + "_" +
                                  std::to_string(info.index % 4);
                         });

// A surface element crushed to a line has no normal.
TEST(StrainDerivativesDomainTest, NoNormalIsRefused) {
  const StrainPoint point = SamplePoints().front();
  Fifteen k = Fifteen::Zero();
  k.segment<3>(3) = -point.t2 + point.t1;  // x_2 = t1 = x_1
  StrainDerivatives derivatives;
  EXPECT_FALSE(EvaluateStrainDerivatives(StrainMeasure::kKoiter, point, k.data(), &derivatives));
  EXPECT_TRUE(
      EvaluateStrainDerivatives(StrainMeasure::kNonlinearSeed, point, k.data(), &derivatives));
}

}  // namespace
}  // namespace darboux
