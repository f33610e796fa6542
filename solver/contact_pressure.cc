#include "solver/contact_pressure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace darboux {
namespace {

using Place = std::array<double, 2>;

double Cross(const Place& a, const Place& b, const Place& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Barycentric coordinates of p.
std::array<double, 3> Barycentric(const std::array<Place, 3>& triangle, const Place& p) {
  const double all = Cross(triangle[0], triangle[1], triangle[2]);
  const double b0 = Cross(p, triangle[1], triangle[2]) / all;
  const double b1 = Cross(triangle[0], p, triangle[2]) / all;
  return {b0, b1, 1.0 - b0 - b1};
}

}  // namespace

std::vector<double> MakeContactPressure(const ShellSurface& surface,
                                        const OutputMesh& mesh,
                                        const std::vector<ContactPointReport>& contact) {
  std::vector<double> pressure(mesh.points.size(), 0.0);
  if (contact.empty()) return pressure;
  for (const ContactPointReport& point : contact) {
    const Place p = {point.at.s, point.at.t};
    // The triangle of its element that it is most inside of.
    const auto range =
        std::equal_range(mesh.elements.begin(), mesh.elements.end(), point.at.element);
    double best = 0.0;
    size_t triangle = 0;
    std::array<double, 3> share{};
    for (auto it = range.first; it != range.second; ++it) {
      const size_t t = static_cast<size_t>(it - mesh.elements.begin());
      const std::array<double, 3> b = Barycentric(mesh.places[t], p);
      const double least = *std::min_element(b.begin(), b.end());
      if (it != range.first && least <= best) continue;
      best = least;
      triangle = t;
      share = b;
    }
    for (size_t k = 0; k < 3; ++k) {
      // Rounding on an edge; the shares still add up to 1 but for that.
      pressure[mesh.triangles[triangle][k]] +=
          point.pressure * point.area * std::max(0.0, share[k]);
    }
  }
  // Areas where there is any force.
  std::vector<double> area(mesh.points.size(), 0.0);
  for (const std::array<int, 3>& t : mesh.triangles) {
    if (pressure[t[0]] == 0.0 && pressure[t[1]] == 0.0 && pressure[t[2]] == 0.0) continue;
    const Eigen::Vector3d x = surface.Position(mesh.points[t[0]]);
    const Eigen::Vector3d a = surface.Position(mesh.points[t[1]]) - x;
    const Eigen::Vector3d b = surface.Position(mesh.points[t[2]]) - x;
    for (const int v : t) area[v] += a.cross(b).norm() / 6.0;
  }
  for (size_t i = 0; i < pressure.size(); ++i) {
    if (pressure[i] > 0.0) pressure[i] /= area[i];
  }
  return pressure;
}

}  // namespace darboux
