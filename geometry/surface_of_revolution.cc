#include "geometry/surface_of_revolution.h"

#include <algorithm>
#include <cmath>

namespace darboux {

bool Revolve(const std::vector<Eigen::Vector3d>& profile,
             int meridians,
             TriangleMesh* mesh,
             std::string* error) {
  constexpr double kOff = 1e-9, kPi = 3.14159265358979323846;
  double size = 0.0;
  for (const Eigen::Vector3d& x : profile) size = std::max(size, x.cwiseAbs().maxCoeff());
  const int n = static_cast<int>(profile.size());
  if (n < 2) {
    *error = "found " + std::to_string(n) + " points; allowed a profile of at least two";
    return false;
  }
  if (meridians < 3) {
    *error = "found " + std::to_string(meridians) + " meridians; allowed at least 3";
    return false;
  }
  for (int k = 0; k < n; ++k) {
    const Eigen::Vector3d& x = profile[k];
    const bool end = k == 0 || k == n - 1;
    if (std::abs(x.y()) > kOff * size || x.x() < -kOff * size || (!end && x.x() <= kOff * size)) {
      *error = "found point " + std::to_string(k) +
               " off the half plane y = 0, x > 0; allowed a profile within it, its ends on the axis"
               " or not";
      return false;
    }
  }
  TriangleMesh turned;
  // Rings of vertices; an end on the axis is a ring of one, and so is the cap of one beside it.
  std::vector<std::vector<int>> rings;
  const auto add_point = [&](double z) {
    rings.push_back({static_cast<int>(turned.vertices.size())});
    turned.vertices.push_back({0.0, 0.0, z});
  };
  const auto closes = [&](int end, int next) {
    return profile[end].x() > kOff * size && profile[end].x() < profile[next].x();
  };
  if (closes(0, 1)) add_point(profile[0].z());
  for (int k = 0; k < n; ++k) {
    if (profile[k].x() <= kOff * size) {
      add_point(profile[k].z());
      continue;
    }
    std::vector<int> ring;
    for (int m = 0; m < meridians; ++m) {
      const double angle = 2.0 * kPi * m / meridians;
      ring.push_back(static_cast<int>(turned.vertices.size()));
      turned.vertices.push_back(
          {profile[k].x() * std::cos(angle), profile[k].x() * std::sin(angle), profile[k].z()});
    }
    rings.push_back(std::move(ring));
  }
  if (closes(n - 1, n - 2)) add_point(profile[n - 1].z());
  for (size_t k = 0; k + 1 < rings.size(); ++k) {
    const std::vector<int>&upper = rings[k], &lower = rings[k + 1];
    for (int m = 0; m < meridians; ++m) {
      const int next = (m + 1) % meridians;
      const auto at = [](const std::vector<int>& ring, int i) {
        return ring.size() == 1 ? ring[0] : ring[i];
      };
      if (lower.size() > 1) {
        turned.triangles.push_back({at(upper, m), lower[m], lower[next]});
      }
      if (upper.size() > 1) {
        turned.triangles.push_back({upper[m], at(lower, next), upper[next]});
      }
    }
  }
  *mesh = std::move(turned);
  return true;
}

}  // namespace darboux
