#include "geometry/occlusion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace darboux {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kDepths = 4.0;  // of a triangle's own bulge

// Slabs; a nan (0 * inf, the ray in a side of the box) loses every comparison and cuts nothing
// off.
bool Meets(const AlignedBox3d& box, const Vector3d& from, const Vector3d& inverse, double length) {
  double first = 0.0, last = length;
  for (int k = 0; k < 3; ++k) {
    double a = (box.min()[k] - from[k]) * inverse[k], b = (box.max()[k] - from[k]) * inverse[k];
    if (a > b) std::swap(a, b);
    if (a > first) first = a;
    if (b < last) last = b;
  }
  // Rounding of the slabs is relative to what they are made of.
  return first <= last + 1e-12 * std::max(std::abs(first), std::abs(last));
}

}  // namespace

Occlusion::Occlusion(const ScanSurface& surface, double tolerance)
    : mesh_(surface.mesh), tolerance_(tolerance), tree_(surface.mesh) {
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    depths_.push_back(surface.evaluate ? kDepths * Bulge(surface, t) : 0.0);
  }
}

bool Occlusion::IsCut(const Vector3d& from, const Vector3d& direction, double length) const {
  if (tree_.nodes().empty()) return false;
  const Vector3d inverse = (direction.array() + 0.0).inverse();  // -0 is 0
  int stack[64];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const TriangleTree::Node& node = tree_.nodes()[static_cast<std::size_t>(stack[--size])];
    if (!Meets(node.box, from, inverse, length)) continue;
    if (node.left >= 0) {
      stack[size++] = node.left;
      stack[size++] = node.right;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const auto t = static_cast<std::size_t>(tree_.order()[static_cast<std::size_t>(i)]);
      bool from_outside = false;
      const double distance = RayDistance(t, from, direction, &from_outside);
      if (!(distance > tolerance_ && distance < length)) continue;
      if (from_outside || Depth(t, from) > depths_[t]) return true;
    }
  }
  return false;
}

// Distance of a point from the plane of a triangle.
double Occlusion::Depth(std::size_t t, const Vector3d& x) const {
  const Vector3d normal = (Corner(t, 1) - Corner(t, 0)).cross(Corner(t, 2) - Corner(t, 0));
  return std::abs((x - Corner(t, 0)).dot(normal.stableNormalized()));
}

// How far the exact face leaves the triangle, about.
double Occlusion::Bulge(const ScanSurface& surface, std::size_t t) const {
  constexpr double kPlaces[4][2] = {{1.0 / 3.0, 1.0 / 3.0}, {0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}};
  double bulge = 0.0;
  for (const auto& at : kPlaces) {
    const FacePoint point = surface.evaluate(static_cast<int>(t), at[0], at[1]);
    bulge = std::max(bulge, Depth(t, point.position));
  }
  return bulge;
}

// T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection" (1997). Negative
// where it misses.
double Occlusion::RayDistance(std::size_t t,
                              const Vector3d& from,
                              const Vector3d& direction,
                              bool* from_outside) const {
  constexpr double kSlack = 1e-12;  // A ray along an edge slips through between no two triangles.
  const Vector3d ab = Corner(t, 1) - Corner(t, 0), ac = Corner(t, 2) - Corner(t, 0);
  const Vector3d p = direction.cross(ac);
  const double determinant = ab.dot(p);  // -direction . (ab x ac)
  if (determinant == 0.0) return -1.0;
  *from_outside = determinant > 0.0;
  const Vector3d ax = from - Corner(t, 0);
  const double u = ax.dot(p) / determinant;
  const Vector3d q = ax.cross(ab);
  const double v = direction.dot(q) / determinant;
  if (u < -kSlack || v < -kSlack || u + v > 1.0 + kSlack) return -1.0;
  return ac.dot(q) / determinant;
}

}  // namespace darboux
