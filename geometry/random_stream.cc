#include "geometry/random_stream.h"

#include <algorithm>
#include <cmath>

namespace darboux {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLog2 = 0.69314718055994530942;
constexpr std::uint64_t kGamma = 0x9E3779B97F4A7C15u;

std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index)
    : state_(Mix(Mix(Mix(seed + kGamma) + purpose * kGamma + 1) + index * kGamma + 2)) {}

std::uint64_t RandomStream::Bits() { return Mix(state_ += kGamma); }

double RandomStream::Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }

double RandomStream::Normal() {
  for (;;) {
    const double u = 2.0 * Uniform() - 1.0, v = 2.0 * Uniform() - 1.0;
    const double s = u * u + v * v;
    if (s > 0.0 && s < 1.0) return u * std::sqrt(-2.0 * PortableLog(s) / s);
  }
}

Eigen::Vector3d RandomStream::Direction() {  // G. Marsaglia (1972).
  for (;;) {
    const double u = 2.0 * Uniform() - 1.0, v = 2.0 * Uniform() - 1.0;
    const double s = u * u + v * v;
    if (s >= 1.0) continue;
    const double w = 2.0 * std::sqrt(1.0 - s);
    return {u * w, v * w, 1.0 - 2.0 * s};
  }
}

Eigen::Vector3d RandomStream::InBall() {
  const Eigen::Vector3d direction = Direction();
  // The largest of three has the distribution of a radius, r^3.
  const double a = Uniform(), b = Uniform(), c = Uniform();
  return std::max({a, b, c}) * direction;
}

double PortableLog(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // [1/2, 1)
  if (m < 0.70710678118654752440) {
    m *= 2.0;
    --exponent;
  }
  // log m = 2 artanh s, |s| < 0.172.
  const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
  double series = 0.0;
  for (int k = 12; k >= 0; --k) series = series * s2 + 1.0 / (2 * k + 1);
  return exponent * kLog2 + 2.0 * s * series;
}

void PortableSinCos(double turns, double* sine, double* cosine) {
  const double quarters = std::floor(4.0 * turns + 0.5);
  const double x = 2.0 * kPi * (turns - 0.25 * quarters);  // within pi / 4
  const double x2 = x * x;
  double s = 1.0, c = 1.0;
  for (int k = 9; k >= 1; --k) {
    s = 1.0 - s * x2 / ((2 * k) * (2 * k + 1));
    c = 1.0 - c * x2 / ((2 * k - 1) * (2 * k));
  }
  s *= x;
  const double turned = quarters - 4.0 * std::floor(0.25 * quarters);
  *sine = turned == 0.0 ? s : turned == 1.0 ? c : turned == 2.0 ? -s : -c;
  *cosine = turned == 0.0 ? c : turned == 1.0 ? -s : turned == 2.0 ? -c : s;
}

}  // namespace darboux
