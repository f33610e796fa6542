#include "geometry/quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace darboux {
namespace {

double Factorial(int n) { return n < 2 ? 1.0 : n * Factorial(n - 1); }

// Integral of s^a t^b over the triangle (0,0), (1,0), (0,1).
double ExactMonomial(int a, int b) { return Factorial(a) * Factorial(b) / Factorial(a + b + 2); }

double Integrate(const std::vector<TrianglePoint>& rule, int a, int b) {
  double sum = 0.0;
  for (const TrianglePoint& p : rule) sum += p.weight * std::pow(p.s, a) * std::pow(p.t, b);
  return sum;
}

struct RuleDegree {
  int num_points;
  int degree;  // Dunavant (1985), the table of the header.
};

class TriangleQuadratureTest : public ::testing::TestWithParam<RuleDegree> {
 protected:
  const std::vector<TrianglePoint>& rule_ = TriangleQuadrature(GetParam().num_points);
};

TEST_P(TriangleQuadratureTest, HasTheStatedNumberOfPoints) {
  EXPECT_TRUE(IsTriangleQuadrature(GetParam().num_points));
  EXPECT_EQ(rule_.size(), static_cast<size_t>(GetParam().num_points));
}

TEST_P(TriangleQuadratureTest, IsExactToTheStatedDegree) {
  for (int a = 0; a <= GetParam().degree; ++a) {
    for (int b = 0; a + b <= GetParam().degree; ++b) {
      EXPECT_NEAR(Integrate(rule_, a, b), ExactMonomial(a, b), 2e-16) << "s^" << a << " t^" << b;
    }
  }
}

TEST_P(TriangleQuadratureTest, IsNotExactOneDegreeAbove) {
  const int degree = GetParam().degree + 1;
  double largest = 0.0;
  for (int a = 0; a <= degree; ++a) {
    const double exact = ExactMonomial(a, degree - a);
    largest = std::max(largest, std::abs(Integrate(rule_, a, degree - a) - exact) / exact);
  }
  EXPECT_GT(largest, 5e-4);
}

// A negative weight would give a strain energy that is not positive.
TEST_P(TriangleQuadratureTest, HasPositiveWeightsAndInnerPoints) {
  for (const TrianglePoint& p : rule_) {
    EXPECT_GT(p.weight, 0.0);
    EXPECT_GT(p.s, 0.01);
    EXPECT_GT(p.t, 0.01);
    EXPECT_GT(1.0 - p.s - p.t, 0.01);
  }
}

// The result must not depend on which corner of an element comes first.
TEST_P(TriangleQuadratureTest, IsUnchangedByPermutationsOfTheCorners) {
  constexpr int kPermutations[5][3] = {{1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (const TrianglePoint& p : rule_) {
    const std::array<double, 3> corner = {1.0 - p.s - p.t, p.s, p.t};
    for (const auto& permutation : kPermutations) {
      const double s = corner[permutation[1]], t = corner[permutation[2]];
      const bool found = std::any_of(rule_.begin(), rule_.end(), [&](const TrianglePoint& other) {
        return std::abs(other.s - s) < 1e-14 && std::abs(other.t - t) < 1e-14 &&
               other.weight == p.weight;
      });
      EXPECT_TRUE(found) << "(" << s << ", " << t << ") is not a point of the rule";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Points,
    TriangleQuadratureTest,
    ::testing::Values(RuleDegree{1, 1}, RuleDegree{3, 2}, RuleDegree{6, 4}, RuleDegree{12, 6}),
    [](const auto& info) { return std::to_string(info.param.num_points); });

TEST(TriangleQuadratureDeathTest, OtherNumbersOfPointsAreABrokenInvariant) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // A BLAS may have started threads.
  for (const int n : {-1, 0, 2, 4, 5, 7, 13}) EXPECT_FALSE(IsTriangleQuadrature(n)) << n;
  EXPECT_DEATH(TriangleQuadrature(4), "no triangle rule of 4 points");
}

class LineQuadratureTest : public ::testing::TestWithParam<int> {
 protected:
  double Integrate(int power) const {
    double sum = 0.0;
    for (const LinePoint& p : LineQuadrature(GetParam())) sum += p.weight * std::pow(p.x, power);
    return sum;
  }
};

TEST_P(LineQuadratureTest, IsExactToDegreeTwiceThePointsLessOne) {
  EXPECT_EQ(LineQuadrature(GetParam()).size(), static_cast<size_t>(GetParam()));
  for (int k = 0; k < 2 * GetParam(); ++k) EXPECT_NEAR(Integrate(k), 1.0 / (k + 1.0), 4e-16) << k;
}

// The remainder for x^(2n) is (n!)^4 / ((2n+1) ((2n)!)^2) (Abramowitz & Stegun 25.4.30).
TEST_P(LineQuadratureTest, HasTheGaussianRemainderOneDegreeAbove) {
  const int n = GetParam();
  const double remainder =
      std::pow(Factorial(n), 4) / ((2.0 * n + 1.0) * std::pow(Factorial(2 * n), 2));
  EXPECT_NEAR((1.0 / (2.0 * n + 1.0) - Integrate(2 * n)) / remainder, 1.0, 1e-8);
}

TEST_P(LineQuadratureTest, AscendsWithinTheIntervalAndIsSymmetric) {
  const std::vector<LinePoint>& rule = LineQuadrature(GetParam());
  double last = 0.0;
  for (size_t i = 0; i < rule.size(); ++i) {
    EXPECT_GT(rule[i].x, last);
    EXPECT_LT(rule[i].x, 1.0);
    EXPECT_GT(rule[i].weight, 0.0);
    last = rule[i].x;
    const LinePoint& mirror = rule[rule.size() - 1 - i];
    EXPECT_NEAR(rule[i].x + mirror.x, 1.0, 4e-16);
    EXPECT_NEAR(rule[i].weight, mirror.weight, 4e-16);
  }
}

INSTANTIATE_TEST_SUITE_P(Points, LineQuadratureTest, ::testing::Range(1, 6));

TEST(LineQuadratureDeathTest, OtherNumbersOfPointsAreABrokenInvariant) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // A BLAS may have started threads.
  EXPECT_DEATH(LineQuadrature(0), "no line rule of 0 points");
  EXPECT_DEATH(LineQuadrature(6), "no line rule of 6 points");
}

}  // namespace
}  // namespace darboux
