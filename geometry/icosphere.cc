#include "geometry/icosphere.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

namespace darboux {
namespace {

constexpr int kNumCorners = 12;
constexpr int kNumEdges = 30;
constexpr int kNumFaces = 20;

std::array<Eigen::Vector3d, kNumCorners> Corners() {
  const double golden_ratio = 0.5 * (1.0 + std::sqrt(5.0));
  const double scale = 1.0 / std::sqrt(1.0 + golden_ratio * golden_ratio);
  std::array<Eigen::Vector3d, kNumCorners> corners;
  int i = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-golden_ratio, golden_ratio}) {
        Eigen::Vector3d corner = Eigen::Vector3d::Zero();
        corner[(axis + 1) % 3] = a * scale;
        corner[(axis + 2) % 3] = b * scale;
        corners[i++] = corner;
      }
    }
  }
  return corners;
}

}  // namespace

TriangleMesh MakeIcosphere(double radius, int frequency) {
  CHECK(std::isfinite(radius) && radius > 0.0) << radius;
  CHECK(frequency >= 1 && frequency <= kMaxIcosphereFrequency) << frequency;
  const int n = frequency;
  const std::array<Eigen::Vector3d, kNumCorners> corners = Corners();
  const double theta = std::acos(1.0 / std::sqrt(5.0));
  const auto weight = [n, theta](int i) { return std::sin(i * theta / n); };

  TriangleMesh mesh;
  mesh.vertices.reserve(10 * n * n + 2);
  mesh.triangles.reserve(kNumFaces * n * n);
  for (const Eigen::Vector3d& corner : corners) mesh.vertices.push_back(radius * corner);

  // Neighbours are at the angle theta, all others at more than a right angle.
  const auto are_neighbours = [&corners](int a, int b) { return corners[a].dot(corners[b]) > 0.0; };

  // edge_start[a][b], a < b: number of the first inner point, counted from a.
  std::array<std::array<int, kNumCorners>, kNumCorners> edge_start{};
  for (int a = 0; a < kNumCorners; ++a) {
    for (int b = a + 1; b < kNumCorners; ++b) {
      if (!are_neighbours(a, b)) continue;
      edge_start[a][b] = static_cast<int>(mesh.vertices.size());
      for (int i = 1; i < n; ++i) {
        const Eigen::Vector3d p = weight(n - i) * corners[a] + weight(i) * corners[b];
        mesh.vertices.push_back(radius * p.normalized());
      }
    }
  }
  CHECK_EQ(mesh.vertices.size(), static_cast<size_t>(kNumCorners + kNumEdges * (n - 1)));

  // The vertex i steps from a to b.
  const auto on_edge = [&edge_start, n](int a, int b, int i) {
    if (i == 0) return a;
    if (i == n) return b;
    return a < b ? edge_start[a][b] + i - 1 : edge_start[b][a] + n - i - 1;
  };

  for (int a = 0; a < kNumCorners; ++a) {
    for (int b = a + 1; b < kNumCorners; ++b) {
      for (int c = b + 1; c < kNumCorners; ++c) {
        if (!are_neighbours(a, b) || !are_neighbours(b, c) || !are_neighbours(c, a)) continue;
        std::array<int, 3> face = {a, b, c};
        if (corners[a].dot(corners[b].cross(corners[c])) < 0.0) face = {a, c, b};

        const int start = static_cast<int>(mesh.vertices.size());
        for (int j = 1; j < n; ++j) {
          for (int i = 1; i + j < n; ++i) {
            const Eigen::Vector3d p = weight(n - i - j) * corners[face[0]] +
                                      weight(i) * corners[face[1]] + weight(j) * corners[face[2]];
            mesh.vertices.push_back(radius * p.normalized());
          }
        }

        // i steps towards the second corner, j towards the third.
        const auto vertex = [&](int i, int j) {
          if (j == 0) return on_edge(face[0], face[1], i);
          if (i == 0) return on_edge(face[0], face[2], j);
          if (i + j == n) return on_edge(face[1], face[2], j);
          // Rows 1 to j - 1 have n - 2, n - 3, ... points.
          return start + (j - 1) * (n - 1) - (j - 1) * j / 2 + i - 1;
        };
        for (int j = 0; j < n; ++j) {
          for (int i = 0; i + j < n; ++i) {
            mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)});
            if (i + j + 1 == n) continue;
            mesh.triangles.push_back({vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
          }
        }
      }
    }
  }
  CHECK_EQ(mesh.vertices.size(), static_cast<size_t>(10 * n * n + 2));
  CHECK_EQ(mesh.triangles.size(), static_cast<size_t>(kNumFaces * n * n));
  return mesh;
}

void SmoothOnSphere(int iterations, TriangleMesh* mesh) {
  std::vector<std::vector<int>> neighbours(mesh->vertices.size());
  for (const auto& triangle : mesh->triangles) {
    for (int k = 0; k < 3; ++k) neighbours[triangle[k]].push_back(triangle[(k + 1) % 3]);
  }
  for (int i = 0; i < iterations; ++i) {
    const std::vector<Eigen::Vector3d> before = mesh->vertices;
    for (size_t v = 0; v < before.size(); ++v) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int j : neighbours[v]) sum += before[j];
      if (sum.isZero(0.0)) continue;
      mesh->vertices[v] = before[v].norm() * sum.normalized();
    }
  }
}

TriangleMesh MakeSmoothIcosphere(double radius, int frequency) {
  constexpr int kSmoothings = 10;
  TriangleMesh mesh = MakeIcosphere(radius, frequency);
  SmoothOnSphere(kSmoothings, &mesh);
  return mesh;
}

}  // namespace darboux
