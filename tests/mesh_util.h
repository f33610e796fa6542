#ifndef DARBOUX_TESTS_MESH_UTIL_H_
#define DARBOUX_TESTS_MESH_UTIL_H_

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <utility>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// Sample triangle meshes, without defects.

inline TriangleMesh Octahedron() {
  return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{{0, 2, 4}},
           {{2, 1, 4}},
           {{1, 3, 4}},
           {{3, 0, 4}},
           {{2, 0, 5}},
           {{1, 2, 5}},
           {{3, 1, 5}},
           {{0, 3, 5}}}};
}

// Unit cells in the plane z = 0, two triangles each; vertex (i, j) is j * (m + 1) + i.
inline TriangleMesh Lattice(int m, int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= m; ++i) mesh.vertices.emplace_back(i, j, 0.0);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const int a = j * (m + 1) + i, b = a + 1, c = a + m + 2, d = a + m + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

// m x n cells around an axis and around the tube, 2 m n triangles, wound outwards.
inline TriangleMesh Torus(int m, int n, double major_radius = 3.0, double minor_radius = 1.0) {
  TriangleMesh mesh;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const double u = 2.0 * M_PI * i / m, v = 2.0 * M_PI * j / n;
      const double r = major_radius + minor_radius * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor_radius * std::sin(v));
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const int k = (i + 1) % m, l = (j + 1) % n;
      const int a = j * m + i, b = j * m + k, c = l * m + k, d = l * m + i;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

inline double Area(const TriangleMesh& mesh, std::size_t t) {
  const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][0])];
  const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][1])];
  const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][2])];
  return 0.5 * (b - a).cross(c - a).norm();
}

inline double Area(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += Area(mesh, t);
  return area;
}

// Enclosed, positive where triangles are wound outwards.
inline double Volume(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(t[1])];
    volume += a.dot(b.cross(mesh.vertices[static_cast<std::size_t>(t[2])])) / 6.0;
  }
  return volume;
}

// Of this process; a busy machine does not count.
inline double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// m cells around, n across, radii 1 to 2 in the plane z = 0: two boundary loops.
inline TriangleMesh Annulus(int m, int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i < m; ++i) {
      const double angle = 2.0 * M_PI * i / m, r = 1.0 + static_cast<double>(j) / n;
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const int k = (i + 1) % m;
      const int a = j * m + i, b = (j + 1) * m + i, c = (j + 1) * m + k, d = j * m + k;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_MESH_UTIL_H_
