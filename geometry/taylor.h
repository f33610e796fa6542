#ifndef DARBOUX_GEOMETRY_TAYLOR_H_
#define DARBOUX_GEOMETRY_TAYLOR_H_

#include <array>
#include <cmath>

namespace darboux {

// A function of two variables (u, v) known by its Taylor polynomial of total degree 3 about a
// point: f(u0 + p, v0 + q) = sum c[k] p^i q^j. Arithmetic on such polynomials, truncated at
// degree 3, is exact differentiation through third order (forward mode).
//
//   const Taylor3 u = Taylor3::U(0.3), v = Taylor3::V(-1.2);
//   const Taylor3 f = sin(u) * pow(v, 3);
//   f.Derivative(1, 2);  // d^3 f / du dv^2 at (0.3, -1.2)
//
// The value c[0] is always the one that the same formula gives in double. Where a derivative does
// not exist, the coefficients are as follows:
//  - sqrt, pow, log, asin, acos at the end of their domain, division by zero, atan2(0, 0): infinite
//    or NaN, unless the argument is constant: then the result is constant;
//  - abs at 0: zero, the mean of both sides; min and max at a tie: those of the first argument;
//  - sign and comparisons: piecewise constant, so zero everywhere, also at the jump.
//
// All functions are hidden friends: they are found by argument and never capture a call on double.
struct Taylor3 {
  // Coefficients of 1, p, q, p^2, p q, q^2, p^3, p^2 q, p q^2, q^3.
  std::array<double, 10> c{};

  Taylor3() = default;
  Taylor3(double value) { c[0] = value; }  // NOLINT: a constant is a function.

  // The variables themselves, at the given point.
  static Taylor3 U(double u) {
    Taylor3 t(u);
    t.c[1] = 1.0;
    return t;
  }
  static Taylor3 V(double v) {
    Taylor3 t(v);
    t.c[2] = 1.0;
    return t;
  }

  double value() const { return c[0]; }

  // d^(i+j) f / du^i dv^j; requires i, j >= 0 and i + j <= 3.
  double Derivative(int i, int j) const {
    constexpr std::array<double, 4> kFactorial = {1.0, 1.0, 2.0, 6.0};
    const int degree = i + j;
    return kFactorial[i] * kFactorial[j] * c[degree * (degree + 1) / 2 + j];
  }

  // Whether all derivatives vanish.
  bool IsConstant() const {
    for (int k = 1; k < 10; ++k) {
      if (c[k] != 0.0) return false;
    }
    return true;
  }

  Taylor3& operator+=(const Taylor3& b) {
    for (int k = 0; k < 10; ++k) c[k] += b.c[k];
    return *this;
  }
  Taylor3& operator-=(const Taylor3& b) {
    for (int k = 0; k < 10; ++k) c[k] -= b.c[k];
    return *this;
  }
  Taylor3& operator+=(double b) {
    c[0] += b;
    return *this;
  }
  Taylor3& operator-=(double b) {
    c[0] -= b;
    return *this;
  }
  Taylor3& operator*=(double b) {
    for (double& ck : c) ck *= b;
    return *this;
  }
  Taylor3& operator/=(double b) {
    for (double& ck : c) ck /= b;
    return *this;
  }
  Taylor3& operator*=(const Taylor3& b) { return *this = *this * b; }
  Taylor3& operator/=(const Taylor3& b) { return *this = *this / b; }

  friend Taylor3 operator+(const Taylor3& a) { return a; }
  friend Taylor3 operator-(const Taylor3& a) {
    Taylor3 r;
    for (int k = 0; k < 10; ++k) r.c[k] = -a.c[k];
    return r;
  }

  friend Taylor3 operator+(Taylor3 a, const Taylor3& b) { return a += b; }
  friend Taylor3 operator+(Taylor3 a, double b) { return a += b; }
  friend Taylor3 operator+(double a, Taylor3 b) { return b += a; }

  friend Taylor3 operator-(Taylor3 a, const Taylor3& b) { return a -= b; }
  friend Taylor3 operator-(Taylor3 a, double b) { return a -= b; }
  friend Taylor3 operator-(double a, const Taylor3& b) {
    Taylor3 r = -b;
    r.c[0] = a - b.c[0];  // Not -b + a, which has the wrong sign of zero.
    return r;
  }

  friend Taylor3 operator*(const Taylor3& a, const Taylor3& b) {
    const auto& x = a.c;
    const auto& y = b.c;
    Taylor3 r;
    r.c[0] = x[0] * y[0];
    r.c[1] = x[0] * y[1] + x[1] * y[0];
    r.c[2] = x[0] * y[2] + x[2] * y[0];
    r.c[3] = x[0] * y[3] + x[1] * y[1] + x[3] * y[0];
    r.c[4] = x[0] * y[4] + x[1] * y[2] + x[2] * y[1] + x[4] * y[0];
    r.c[5] = x[0] * y[5] + x[2] * y[2] + x[5] * y[0];
    r.c[6] = x[0] * y[6] + x[1] * y[3] + x[3] * y[1] + x[6] * y[0];
    r.c[7] = x[0] * y[7] + x[1] * y[4] + x[2] * y[3] + x[3] * y[2] + x[4] * y[1] + x[7] * y[0];
    r.c[8] = x[0] * y[8] + x[1] * y[5] + x[2] * y[4] + x[4] * y[2] + x[5] * y[1] + x[8] * y[0];
    r.c[9] = x[0] * y[9] + x[2] * y[5] + x[5] * y[2] + x[9] * y[0];
    return r;
  }
  friend Taylor3 operator*(Taylor3 a, double b) { return a *= b; }
  friend Taylor3 operator*(double a, Taylor3 b) { return b *= a; }

  // Solves r b = a, lowest degree first; one rounding in the value, as in double.
  friend Taylor3 operator/(const Taylor3& a, const Taylor3& b) {
    const auto& x = a.c;
    const auto& y = b.c;
    const double inverse = 1.0 / y[0];
    Taylor3 result;
    auto& r = result.c;
    r[0] = x[0] / y[0];
    r[1] = (x[1] - r[0] * y[1]) * inverse;
    r[2] = (x[2] - r[0] * y[2]) * inverse;
    r[3] = (x[3] - r[0] * y[3] - r[1] * y[1]) * inverse;
    r[4] = (x[4] - r[0] * y[4] - r[1] * y[2] - r[2] * y[1]) * inverse;
    r[5] = (x[5] - r[0] * y[5] - r[2] * y[2]) * inverse;
    r[6] = (x[6] - r[0] * y[6] - r[1] * y[3] - r[3] * y[1]) * inverse;
    r[7] = (x[7] - r[0] * y[7] - r[1] * y[4] - r[2] * y[3] - r[3] * y[2] - r[4] * y[1]) * inverse;
    r[8] = (x[8] - r[0] * y[8] - r[1] * y[5] - r[2] * y[4] - r[4] * y[2] - r[5] * y[1]) * inverse;
    r[9] = (x[9] - r[0] * y[9] - r[2] * y[5] - r[5] * y[2]) * inverse;
    return result;
  }
  friend Taylor3 operator/(Taylor3 a, double b) { return a /= b; }
  friend Taylor3 operator/(double a, const Taylor3& b) { return Taylor3(a) / b; }

  // f(a) for a univariate f with the Taylor coefficients f0 = f, f1 = f', f2 = f''/2, f3 = f'''/6
  // at a.value().
  static Taylor3 Compose(const Taylor3& a, double f0, double f1, double f2, double f3) {
    // A function of a constant is constant even where f' is infinite; 0 * infinity is not.
    if (!std::isfinite(f1 + f2 + f3) && a.IsConstant()) return Taylor3(f0);
    const auto& x = a.c;
    const double pp = x[1] * x[1];
    const double pq = 2.0 * x[1] * x[2];
    const double qq = x[2] * x[2];
    Taylor3 r;
    r.c[0] = f0;
    r.c[1] = f1 * x[1];
    r.c[2] = f1 * x[2];
    r.c[3] = f1 * x[3] + f2 * pp;
    r.c[4] = f1 * x[4] + f2 * pq;
    r.c[5] = f1 * x[5] + f2 * qq;
    r.c[6] = f1 * x[6] + 2.0 * f2 * x[1] * x[3] + f3 * pp * x[1];
    r.c[7] = f1 * x[7] + 2.0 * f2 * (x[1] * x[4] + x[2] * x[3]) + 3.0 * f3 * pp * x[2];
    r.c[8] = f1 * x[8] + 2.0 * f2 * (x[1] * x[5] + x[2] * x[4]) + 3.0 * f3 * x[1] * qq;
    r.c[9] = f1 * x[9] + 2.0 * f2 * x[2] * x[5] + f3 * qq * x[2];
    return r;
  }

  // std::pow, but exactly rounded squares: the value of pow on Taylor3.
  static double Power(double base, double exponent) {
    return exponent == 2.0 ? base * base : std::pow(base, exponent);
  }

  friend Taylor3 sin(const Taylor3& a) {
    const double s = std::sin(a.c[0]), c = std::cos(a.c[0]);
    return Compose(a, s, c, -s / 2.0, -c / 6.0);
  }
  friend Taylor3 cos(const Taylor3& a) {
    const double s = std::sin(a.c[0]), c = std::cos(a.c[0]);
    return Compose(a, c, -s, -c / 2.0, s / 6.0);
  }
  friend Taylor3 tan(const Taylor3& a) {
    const double t = std::tan(a.c[0]), d = 1.0 + t * t;
    return Compose(a, t, d, t * d, d * (1.0 + 3.0 * t * t) / 3.0);
  }
  friend Taylor3 asin(const Taylor3& a) { return ArcSine(a, std::asin(a.c[0]), 1.0); }
  friend Taylor3 acos(const Taylor3& a) { return ArcSine(a, std::acos(a.c[0]), -1.0); }
  friend Taylor3 atan(const Taylor3& a) {
    // In g = 1 / (1 + x^2), so that a huge x gives 0 and not infinity * 0.
    const double x = a.c[0], g = 1.0 / (1.0 + x * x);
    return Compose(a, std::atan(x), g, -(x * g) * g, g * g * (1.0 - 4.0 / 3.0 * g));
  }
  // atan2(y, x) is the angle of (x0, y0) plus the atan of what remains after turning by it.
  friend Taylor3 atan2(const Taylor3& y, const Taylor3& x) {
    const double angle = std::atan2(y.c[0], x.c[0]);
    if (y.IsConstant() && x.IsConstant()) return Taylor3(angle);
    const double radius = std::hypot(x.c[0], y.c[0]);
    const double c = x.c[0] / radius, s = y.c[0] / radius;
    Taylor3 t = (y * c - x * s) / (x * c + y * s);
    return Compose(t, angle, 1.0, 0.0, -1.0 / 3.0);
  }
  friend Taylor3 sinh(const Taylor3& a) {
    const double s = std::sinh(a.c[0]), c = std::cosh(a.c[0]);
    return Compose(a, s, c, s / 2.0, c / 6.0);
  }
  friend Taylor3 cosh(const Taylor3& a) {
    const double s = std::sinh(a.c[0]), c = std::cosh(a.c[0]);
    return Compose(a, c, s, c / 2.0, s / 6.0);
  }
  friend Taylor3 tanh(const Taylor3& a) {
    // 1 - t^2 would cancel for a large argument.
    const double t = std::tanh(a.c[0]), g = 1.0 / std::cosh(a.c[0]), d = g * g;
    return Compose(a, t, d, -t * d, d * (3.0 * t * t - 1.0) / 3.0);
  }
  friend Taylor3 exp(const Taylor3& a) {
    const double e = std::exp(a.c[0]);
    return Compose(a, e, e, e / 2.0, e / 6.0);
  }
  friend Taylor3 log(const Taylor3& a) {
    const double g = 1.0 / a.c[0];
    return Compose(a, std::log(a.c[0]), g, -g * g / 2.0, g * g * g / 3.0);
  }
  friend Taylor3 sqrt(const Taylor3& a) {
    const double r = std::sqrt(a.c[0]), g = 1.0 / a.c[0];
    const double f1 = 0.5 / r, f2 = -0.25 * f1 * g;
    return Compose(a, r, f1, f2, -0.5 * f2 * g);
  }
  friend Taylor3 abs(const Taylor3& a) {
    if (a.c[0] > 0.0) return a;
    if (a.c[0] < 0.0) return -a;
    return Taylor3(std::abs(a.c[0]));  // Zero or NaN.
  }
  friend Taylor3 sign(const Taylor3& a) {
    if (std::isnan(a.c[0])) return Taylor3(a.c[0]);
    return Taylor3(static_cast<double>((a.c[0] > 0.0) - (a.c[0] < 0.0)));
  }
  // Unlike std::min and std::max these never hide a NaN.
  friend Taylor3 min(const Taylor3& a, const Taylor3& b) {
    return b.c[0] < a.c[0] || std::isnan(b.c[0]) ? b : a;
  }
  friend Taylor3 max(const Taylor3& a, const Taylor3& b) {
    return b.c[0] > a.c[0] || std::isnan(b.c[0]) ? b : a;
  }

  // Any base where the exponent is an integer: x^3 is smooth at 0, where exp(3 log(x)) is not.
  friend Taylor3 pow(const Taylor3& base, double exponent) {
    const double x = base.c[0], n = exponent;
    if (n == 2.0) return base * base;  // The most common one, and exactly rounded.
    // A vanishing factor ends the series, however singular the power that it multiplies.
    const double k2 = n * (n - 1.0) / 2.0, k3 = k2 * (n - 2.0) / 3.0;
    return Compose(base,
                   Power(x, n),
                   n == 0.0 ? 0.0 : n * std::pow(x, n - 1.0),
                   k2 == 0.0 ? 0.0 : k2 * std::pow(x, n - 2.0),
                   k3 == 0.0 ? 0.0 : k3 * std::pow(x, n - 3.0));
  }
  friend Taylor3 pow(const Taylor3& base, const Taylor3& exponent) {
    if (exponent.IsConstant()) return pow(base, exponent.c[0]);
    const double x = Power(base.c[0], exponent.c[0]);
    if (base.c[0] == 0.0 && exponent.c[0] > 0.0 && base.IsConstant()) return Taylor3(x);
    return Compose(exponent * log(base), x, x, x / 2.0, x / 6.0);
  }

  friend bool operator<(const Taylor3& a, const Taylor3& b) { return a.c[0] < b.c[0]; }
  friend bool operator<=(const Taylor3& a, const Taylor3& b) { return a.c[0] <= b.c[0]; }
  friend bool operator>(const Taylor3& a, const Taylor3& b) { return a.c[0] > b.c[0]; }
  friend bool operator>=(const Taylor3& a, const Taylor3& b) { return a.c[0] >= b.c[0]; }
  // Compare values only, as a formula's == does; not the derivatives.
  friend bool operator==(const Taylor3& a, const Taylor3& b) { return a.c[0] == b.c[0]; }
  friend bool operator!=(const Taylor3& a, const Taylor3& b) { return a.c[0] != b.c[0]; }

 private:
  // asin (sign = 1) and acos (sign = -1) differ by the value and the sign of all derivatives.
  static Taylor3 ArcSine(const Taylor3& a, double value, double sign) {
    const double x = a.c[0], g = 1.0 / ((1.0 - x) * (1.0 + x));
    const double f1 = sign * std::sqrt(g);
    return Compose(a, value, f1, 0.5 * x * g * f1, (1.0 + 2.0 * x * x) * g * g * f1 / 6.0);
  }
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_TAYLOR_H_
