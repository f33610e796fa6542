#include "geometry/quadrature.h"

#include <glog/logging.h>

#include <cmath>

namespace darboux {
namespace {

// The three points with barycentric coordinates (a, a, 1 - 2a); weights as fractions of the area.
void AddOrbit3(double a, double weight, std::vector<TrianglePoint>* rule) {
  rule->push_back({a, a, 0.5 * weight});
  rule->push_back({1.0 - 2.0 * a, a, 0.5 * weight});
  rule->push_back({a, 1.0 - 2.0 * a, 0.5 * weight});
}

// The six points with barycentric coordinates (a, b, 1 - a - b).
void AddOrbit6(double a, double b, double weight, std::vector<TrianglePoint>* rule) {
  const double c = 1.0 - a - b;
  const double st[6][2] = {{a, b}, {b, a}, {b, c}, {c, b}, {c, a}, {a, c}};
  for (const auto& p : st) rule->push_back({p[0], p[1], 0.5 * weight});
}

std::vector<TrianglePoint> MakeTriangleRule(int num_points) {
  std::vector<TrianglePoint> rule;
  switch (num_points) {
    case 1:
      rule.push_back({1.0 / 3.0, 1.0 / 3.0, 0.5});
      break;
    case 3:
      AddOrbit3(1.0 / 6.0, 1.0 / 3.0, &rule);
      break;
    case 6: {
      const double root = std::sqrt(38.0 - 44.0 * std::sqrt(0.4));
      const double weight_root = std::sqrt(213125.0 - 53320.0 * std::sqrt(10.0));
      AddOrbit3((8.0 - std::sqrt(10.0) + root) / 18.0, (620.0 + weight_root) / 3720.0, &rule);
      AddOrbit3((8.0 - std::sqrt(10.0) - root) / 18.0, (620.0 - weight_root) / 3720.0, &rule);
      break;
    }
    case 12:
      AddOrbit3(0.249286745170910421, 0.116786275726379366, &rule);
      AddOrbit3(0.063089014491502227, 0.050844906370206817, &rule);
      AddOrbit6(0.053145049844816947, 0.310352451033784405, 0.082851075618373575, &rule);
      break;
    default:
      LOG(FATAL) << "no triangle rule of " << num_points << " points; there are 1, 3, 6, 12";
  }
  return rule;
}

std::vector<LinePoint> MakeLineRule(int n) {
  CHECK(n >= 1 && n <= 5) << "line rules have 1 to 5 points, not " << n;
  std::vector<LinePoint> rule;
  for (int i = 0; i < n; ++i) {
    // Newton's method on the Legendre polynomial of degree n from Chebyshev's abscissa.
    double x = std::cos(M_PI * (n - i - 0.25) / (n + 0.5));
    double derivative = 1.0;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double p0 = 1.0, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = n * (x * p1 - p0) / (x * x - 1.0);
      const double step = p1 / derivative;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative)});
  }
  return rule;
}

}  // namespace

bool IsTriangleQuadrature(int num_points) {
  return num_points == 1 || num_points == 3 || num_points == 6 || num_points == 12;
}

const std::vector<TrianglePoint>& TriangleQuadrature(int num_points) {
  static const auto* const rules = new std::vector<std::vector<TrianglePoint>>{
      MakeTriangleRule(1), MakeTriangleRule(3), MakeTriangleRule(6), MakeTriangleRule(12)};
  CHECK(IsTriangleQuadrature(num_points)) << "no triangle rule of " << num_points << " points";
  return (*rules)[num_points == 1 ? 0 : num_points == 3 ? 1 : num_points == 6 ? 2 : 3];
}

const std::vector<LinePoint>& LineQuadrature(int num_points) {
  static const auto* const rules = new std::vector<std::vector<LinePoint>>{
      MakeLineRule(1), MakeLineRule(2), MakeLineRule(3), MakeLineRule(4), MakeLineRule(5)};
  CHECK(num_points >= 1 && num_points <= 5) << "no line rule of " << num_points << " points";
  return (*rules)[num_points - 1];
}

}  // namespace darboux
