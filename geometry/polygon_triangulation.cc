#include "geometry/polygon_triangulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace darboux {
namespace {

using Eigen::Vector3d;

constexpr double kAngleStep = 0.01;   // rad; smaller differences are no reason for worse shapes.
constexpr int kNoAreaAngle = 1000;    // Steps; beyond pi, so only where nothing else is left.
constexpr double kNoArea = 1e-9;      // Of the squared longest side.
constexpr int kImpossible = 1000000;  // Steps.

struct Weight {
  int angle = 0;       // Largest, in steps.
  double shape = 0.0;  // Sum of squared lengths.
  bool operator<(const Weight& other) const {
    return angle != other.angle ? angle < other.angle : shape < other.shape;
  }
};

// The best triangulation of the part of the polygon from corner i to corner k.
struct Part {
  Weight weight;
  int split = -1;                      // Third corner of the triangle at the side (i, k).
  Vector3d normal = Vector3d::Zero();  // Its unit normal; zero where it has no area.
};

int AngleSteps(const Vector3d& a, const Vector3d& b) {
  if (a.isZero(0.0) || b.isZero(0.0)) return 0;
  return static_cast<int>(std::lround(std::atan2(a.cross(b).norm(), a.dot(b)) / kAngleStep));
}

Vector3d UnitNormal(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  if (!(longest > 0.0)) return Vector3d::Zero();
  const Vector3d n = ((b - a) / longest).cross((c - a) / longest);
  const double norm = n.norm();
  return norm > kNoArea ? Vector3d(n / norm) : Vector3d(Vector3d::Zero());
}

}  // namespace

bool IsFan(const std::vector<Vector3d>& corners) {
  const std::size_t n = corners.size();
  if (n <= 3) return true;
  double size = 0.0;  // Products of very small or large lengths are no numbers.
  for (const Vector3d& corner : corners) size = std::max(size, (corner - corners[0]).norm());
  if (!(size > 0.0)) return false;
  const auto part = [&](std::size_t k) -> Vector3d {
    return ((corners[k] - corners[0]) / size).cross((corners[k + 1] - corners[0]) / size);
  };
  Vector3d whole = Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < n; ++k) whole += part(k);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    if (!(part(k).dot(whole) > 0.0)) return false;
  }
  return true;
}

std::vector<std::array<int, 3>> TriangulatePolygon(const std::vector<Vector3d>& corners,
                                                   const PolygonSurroundings& surroundings) {
  const int n = static_cast<int>(corners.size());
  if (n < 3) return {};
  std::vector<Part> parts(static_cast<std::size_t>(n) * n);
  const auto part = [&parts, n](int i, int k) -> Part& {
    return parts[static_cast<std::size_t>(i) * n + k];
  };
  if (!surroundings.opposite.empty()) {
    for (int i = 0; i + 1 < n; ++i) {  // Seen from the polygon, the other side runs backwards.
      part(i, i + 1).normal = UnitNormal(corners[i + 1], corners[i], surroundings.opposite[i]);
    }
  }
  for (int length = 2; length < n; ++length) {
    for (int i = 0; i + length < n; ++i) {
      const int k = i + length;
      const bool is_whole = length == n - 1;
      Part& best = part(i, k);
      best.weight.angle = kImpossible;
      if (!is_whole && surroundings.is_forbidden && surroundings.is_forbidden(i, k)) continue;
      for (int m = i + 1; m < k; ++m) {
        const Part& left = part(i, m);
        const Part& right = part(m, k);
        Weight weight;
        weight.angle = std::max(left.weight.angle, right.weight.angle);
        if (weight.angle >= kImpossible) continue;
        const Vector3d normal = UnitNormal(corners[i], corners[m], corners[k]);
        if (normal.isZero(0.0)) weight.angle = std::max(weight.angle, kNoAreaAngle);
        weight.angle = std::max(
            {weight.angle, AngleSteps(normal, left.normal), AngleSteps(normal, right.normal)});
        if (is_whole && !surroundings.opposite.empty()) {
          const Vector3d beyond =
              UnitNormal(corners[0], corners[n - 1], surroundings.opposite[n - 1]);
          weight.angle = std::max(weight.angle, AngleSteps(normal, beyond));
        }
        weight.shape =
            left.weight.shape + right.weight.shape + (corners[m] - corners[i]).squaredNorm() +
            (corners[k] - corners[m]).squaredNorm() + (corners[i] - corners[k]).squaredNorm();
        if (best.split >= 0 && !(weight < best.weight)) continue;
        best.weight = weight;
        best.split = m;
        best.normal = normal;
      }
    }
  }
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::pair<int, int>> open = {{0, n - 1}};
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (k - i < 2) continue;
    const int m = part(i, k).split;
    if (m < 0) return {};
    triangles.push_back({i, m, k});
    open.emplace_back(i, m);
    open.emplace_back(m, k);
  }
  return triangles;
}

}  // namespace darboux
