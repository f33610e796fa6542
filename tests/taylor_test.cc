#include "geometry/taylor.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "gtest/gtest.h"

namespace darboux {
namespace {

using Function = std::function<long double(long double, long double)>;

// d^n f / dt^n at 0 by central differences with 9 points: order 8 (n = 1, 2) and 6 (n = 3).
long double Difference(int n, const std::function<long double(long double)>& f) {
  constexpr long double h = 0.004L;
  if (n == 0) return f(0.0L);
  const std::array<std::array<long double, 5>, 3> weights = {{
      {0.0L, 4.0L / 5.0L, -1.0L / 5.0L, 4.0L / 105.0L, -1.0L / 280.0L},
      {-205.0L / 72.0L, 8.0L / 5.0L, -1.0L / 5.0L, 8.0L / 315.0L, -1.0L / 560.0L},
      {0.0L, -61.0L / 30.0L, 169.0L / 120.0L, -3.0L / 10.0L, 7.0L / 240.0L},
  }};
  const std::array<long double, 5>& w = weights[n - 1];
  const long double mirror = n == 2 ? 1.0L : -1.0L;
  long double sum = w[0] == 0.0L ? 0.0L : w[0] * f(0.0L);
  for (int k = 1; k < 5; ++k) sum += w[k] * (f(k * h) + mirror * f(-k * h));
  return sum / std::pow(h, static_cast<long double>(n));
}

// In long double the differences keep 10 digits even of third derivatives, so the tolerance can be
// far below any wrong factor.
void ExpectDerivatives(
    const Taylor3& jet, const Function& f, double u, double v, const std::string& what) {
  double scale = 1.0;
  for (double c : jet.c) scale = std::max(scale, std::abs(c));
  for (int i = 0; i <= 3; ++i) {
    for (int j = 0; i + j <= 3; ++j) {
      const long double expected = Difference(i, [&](long double p) {
        return Difference(j, [&](long double q) { return f(u + p, v + q); });
      });
      EXPECT_NEAR(jet.Derivative(i, j), static_cast<double>(expected), 1e-8 * scale)
          << what << ": d^" << i << "/du d^" << j << "/dv at " << u << ", " << v;
    }
  }
}

struct Sample {
  const char* name;
  std::function<Taylor3(Taylor3, Taylor3)> taylor;
  Function reference;
};

// One formula, for both scalars. u and v are within [-0.6, 0.6].
template <typename F>
Sample MakeSample(const char* name, F f) {
  return {name, f, f};
}

std::vector<Sample> Samples() {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp;
  using std::log, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
  // An inner function with all derivatives, so that every term of the chain rule counts.
  const auto w = [](auto u, auto v) { return 0.5 * u + 0.3 * v + u * v * (0.4 - 0.2 * u + v * v); };
  return {
      MakeSample("sum", [=](auto u, auto v) { return 2.0 + w(u, v) + u - (v + 1.0) - -u; }),
      MakeSample("product", [=](auto u, auto v) { return w(u, v) * (1.0 - w(v, u)) * 3.0; }),
      MakeSample("quotient", [=](auto u, auto v) { return w(u, v) / (2.0 + w(v, u)) / 7.0; }),
      MakeSample("inverse", [=](auto u, auto v) { return 1.0 / (2.0 + w(u, v)); }),
      MakeSample("sin", [=](auto u, auto v) { return sin(3.0 * w(u, v)); }),
      MakeSample("cos", [=](auto u, auto v) { return cos(3.0 * w(u, v)); }),
      MakeSample("tan", [=](auto u, auto v) { return tan(w(u, v)); }),
      MakeSample("asin", [=](auto u, auto v) { return asin(w(u, v)); }),
      MakeSample("acos", [=](auto u, auto v) { return acos(w(u, v)); }),
      MakeSample("atan", [=](auto u, auto v) { return atan(2.0 * w(u, v)); }),
      MakeSample("sinh", [=](auto u, auto v) { return sinh(w(u, v)); }),
      MakeSample("cosh", [=](auto u, auto v) { return cosh(w(u, v)); }),
      MakeSample("tanh", [=](auto u, auto v) { return tanh(w(u, v)); }),
      MakeSample("exp", [=](auto u, auto v) { return exp(w(u, v)); }),
      MakeSample("log", [=](auto u, auto v) { return log(2.0 + w(u, v)); }),
      MakeSample("sqrt", [=](auto u, auto v) { return sqrt(2.0 + w(u, v)); }),
      MakeSample("abs of negative", [=](auto u, auto v) { return abs(w(u, v) - 3.0); }),
      MakeSample("abs of positive", [=](auto u, auto v) { return abs(w(u, v) + 3.0); }),
      MakeSample("atan2, right", [=](auto u, auto v) { return atan2(w(u, v), 2.0 + u); }),
      MakeSample("atan2, above", [=](auto u, auto v) { return atan2(2.0 + u, w(u, v)); }),
      MakeSample("atan2, left", [=](auto u, auto v) { return atan2(w(u, v) - 2.0, u - 2.0); }),
      MakeSample("w^2", [=](auto u, auto v) { return pow(w(u, v), 2.0); }),
      MakeSample("w^3", [=](auto u, auto v) { return pow(w(u, v), 3.0); }),
      MakeSample("w^5", [=](auto u, auto v) { return pow(w(u, v), 5.0); }),
      MakeSample("negative^-3", [=](auto u, auto v) { return pow(w(u, v) - 2.0, -3.0); }),
      MakeSample("positive^2.5", [=](auto u, auto v) { return pow(2.0 + w(u, v), 2.5); }),
      MakeSample("positive^w", [=](auto u, auto v) { return pow(2.0 + v, w(u, v)); }),
  };
}

TEST(Taylor3Test, DerivativesMatchDifferencesToEightDigits) {
  std::mt19937 gen(38401);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  for (const Sample& sample : Samples()) {
    for (int k = 0; k < 5; ++k) {
      const double u = uniform(gen), v = uniform(gen);
      const Taylor3 jet = sample.taylor(Taylor3::U(u), Taylor3::V(v));
      ExpectDerivatives(jet, sample.reference, u, v, sample.name);
    }
  }
}

TEST(Taylor3Test, DerivativesOfACubicAreItsCoefficientsTimesFactorials) {
  const Taylor3 u = Taylor3::U(0.0), v = Taylor3::V(0.0);
  const Taylor3 f = 1.0 + 2.0 * u + 3.0 * v + 4.0 * u * u + 5.0 * u * v + 6.0 * v * v +
                    7.0 * u * u * u + 8.0 * u * u * v + 9.0 * u * v * v + 10.0 * v * v * v;
  const std::array<double, 10> coefficients = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_EQ(f.c, coefficients);
  EXPECT_EQ(f.Derivative(0, 0), 1.0);
  EXPECT_EQ(f.Derivative(1, 0), 2.0);
  EXPECT_EQ(f.Derivative(0, 1), 3.0);
  EXPECT_EQ(f.Derivative(2, 0), 8.0);
  EXPECT_EQ(f.Derivative(1, 1), 5.0);
  EXPECT_EQ(f.Derivative(0, 2), 12.0);
  EXPECT_EQ(f.Derivative(3, 0), 42.0);
  EXPECT_EQ(f.Derivative(2, 1), 16.0);
  EXPECT_EQ(f.Derivative(1, 2), 18.0);
  EXPECT_EQ(f.Derivative(0, 3), 60.0);
}

TEST(Taylor3Test, ProductIsTheTruncatedProductOfPolynomials) {
  std::mt19937 gen(38402);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  constexpr std::array<std::array<int, 2>, 10> kPowers = {
      {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}, {3, 0}, {2, 1}, {1, 2}, {0, 3}}};
  for (int repetition = 0; repetition < 10; ++repetition) {
    Taylor3 a, b;
    for (double& c : a.c) c = uniform(gen);
    for (double& c : b.c) c = uniform(gen);
    std::array<double, 10> product{};
    for (int i = 0; i < 10; ++i) {
      for (int j = 0; j < 10; ++j) {
        for (int k = 0; k < 10; ++k) {
          const bool matches = kPowers[i][0] + kPowers[j][0] == kPowers[k][0] &&
                               kPowers[i][1] + kPowers[j][1] == kPowers[k][1];
          if (matches) product[k] += a.c[i] * b.c[j];
        }
      }
    }
    const Taylor3 ab = a * b;
    for (int k = 0; k < 10; ++k) EXPECT_NEAR(ab.c[k], product[k], 1e-15 * 10) << k;
    b.c[0] = 1.5;  // Away from zero.
    const Taylor3 back = a * b / b;
    for (int k = 0; k < 10; ++k) EXPECT_NEAR(back.c[k], a.c[k], 1e-13) << k;
  }
}

TEST(Taylor3Test, CompoundAssignmentMayUseItself) {
  Taylor3 a = Taylor3::U(3.0) * Taylor3::V(2.0);
  Taylor3 b = a;
  b *= b;
  EXPECT_EQ(b.c, (a * a).c);
  b = a;
  b /= b;
  EXPECT_EQ(b.c, Taylor3(1.0).c);
  b = a;
  b -= b;
  EXPECT_EQ(b.c, Taylor3().c);
}

TEST(Taylor3Test, IntegerPowerIsExactAtZero) {
  const Taylor3 u = Taylor3::U(0.0);
  for (int n = 0; n <= 6; ++n) {
    Taylor3 expected(1.0);
    for (int k = 0; k < n; ++k) expected *= u;
    EXPECT_EQ(pow(u, n).c, expected.c) << n;
    EXPECT_EQ(pow(u, Taylor3(n)).c, expected.c) << n;
  }
}

TEST(Taylor3Test, IntegerPowerIsExactForNegativeBase) {
  const Taylor3 v = Taylor3::V(-2.0);
  EXPECT_EQ(pow(v, 3).value(), -8.0);
  EXPECT_EQ(pow(v, 3).Derivative(0, 1), 12.0);
  EXPECT_EQ(pow(v, 3).Derivative(0, 2), -12.0);
  EXPECT_EQ(pow(v, 3).Derivative(0, 3), 6.0);
  EXPECT_EQ(pow(v, -1).value(), -0.5);
  EXPECT_EQ(pow(v, -1).Derivative(0, 1), -0.25);
  EXPECT_EQ(pow(v, -1).Derivative(0, 2), -0.25);
  EXPECT_EQ(pow(v, -1).Derivative(0, 3), -0.375);
}

TEST(Taylor3Test, ZeroToAVaryingPositivePowerIsZero) {
  EXPECT_EQ(pow(Taylor3(0.0), Taylor3::U(2.0)).c, Taylor3(0.0).c);
}

TEST(Taylor3Test, ConstantsStayConstantWhereTheFunctionIsSingular) {
  const Taylor3 zero(0.0), one(1.0);
  EXPECT_EQ(sqrt(zero).c, zero.c);
  EXPECT_EQ(pow(zero, 0.5).c, zero.c);
  EXPECT_EQ(acos(one).c, zero.c);
  EXPECT_EQ(asin(one).c, Taylor3(std::asin(1.0)).c);
  EXPECT_EQ(atan2(zero, zero).c, zero.c);
}

TEST(Taylor3Test, MissingDerivativesAreNotFinite) {
  EXPECT_FALSE(std::isfinite(sqrt(Taylor3::U(0.0)).c[1]));
  EXPECT_FALSE(std::isfinite(log(Taylor3::U(0.0)).c[1]));
  EXPECT_FALSE(std::isfinite(asin(Taylor3::U(1.0)).c[1]));
  EXPECT_FALSE(std::isfinite(pow(Taylor3::U(0.0), 2.5).c[6]));
  EXPECT_FALSE(std::isfinite((1.0 / Taylor3::U(0.0)).c[0]));
  EXPECT_FALSE(std::isfinite(atan2(Taylor3::U(0.0), Taylor3::V(0.0)).c[1]));
}

TEST(Taylor3Test, KinksTakeTheDocumentedSide) {
  const Taylor3 u = Taylor3::U(0.0), v = Taylor3::V(0.0);
  EXPECT_EQ(abs(u).c, Taylor3(0.0).c);
  EXPECT_EQ(min(u, v).c, u.c);
  EXPECT_EQ(max(u, v).c, u.c);
  EXPECT_EQ(min(u, v - 1.0).c, (v - 1.0).c);
  EXPECT_EQ(max(u, v + 1.0).c, (v + 1.0).c);
  EXPECT_EQ(sign(Taylor3::U(-3.0)).c, Taylor3(-1.0).c);
  EXPECT_EQ(sign(u).c, Taylor3(0.0).c);
  EXPECT_EQ(sign(Taylor3::U(3.0)).c, Taylor3(1.0).c);
}

TEST(Taylor3Test, NanIsNeverHidden) {
  const Taylor3 nan(std::numeric_limits<double>::quiet_NaN()), u = Taylor3::U(1.0);
  for (const Taylor3& t :
       {abs(nan), sign(nan), min(nan, u), min(u, nan), max(nan, u), max(u, nan)}) {
    EXPECT_TRUE(std::isnan(t.value()));
  }
}

TEST(Taylor3Test, HugeArgumentsSaturate) {
  const Taylor3 u = Taylor3::U(1e200);
  EXPECT_EQ(atan(u).c, Taylor3(std::atan(1e200)).c);
  EXPECT_EQ(tanh(u).c, Taylor3(1.0).c);
  EXPECT_EQ(tanh(-u).c, Taylor3(-1.0).c);
}

TEST(Taylor3Test, ComparisonsSeeValuesOnly) {
  const Taylor3 u = Taylor3::U(1.0), v = Taylor3::V(1.0);
  EXPECT_TRUE(u == v);
  EXPECT_FALSE(u != v);
  EXPECT_TRUE(u <= v);
  EXPECT_TRUE(u >= v);
  EXPECT_FALSE(u < v);
  EXPECT_TRUE(u > 0.5);
}

// The functions are found by argument only, so that no call on double picks them.
TEST(Taylor3Test, FunctionsOnDoubleStayFunctionsOnDouble) {
  static_assert(std::is_same_v<decltype(sqrt(2.0)), double>);
  static_assert(std::is_same_v<decltype(sin(Taylor3())), Taylor3>);
}

}  // namespace
}  // namespace darboux
