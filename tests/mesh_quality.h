#ifndef DARBOUX_TESTS_MESH_QUALITY_H_
#define DARBOUX_TESTS_MESH_QUALITY_H_

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "geometry/triangle_mesh.h"

// What the tests of mesh generators measure.
namespace darboux {

struct MeshQuality {
  // Every directed edge occurs at most once, every undirected one at most twice, and the triangles
  // about every vertex form one fan: an oriented 2-manifold, possibly with boundary.
  bool is_manifold = true;
  int num_boundary_edges = 0;
  int euler_characteristic = 0;
  int num_components = 0;
  double area = 0.0;
  double volume = 0.0;  // Signed: positive where triangles are seen counterclockwise from outside.
  double min_edge = std::numeric_limits<double>::infinity();
  double max_edge = 0.0;
  double min_area = std::numeric_limits<double>::infinity();
  double max_area = 0.0;
  double min_angle_deg = 180.0;
  std::map<int, int> valences;  // Of inner vertices -> how many.
  std::map<int, int> boundary_valences;
};

inline MeshQuality MeasureMesh(const TriangleMesh& mesh) {
  MeshQuality q;
  const int num_vertices = static_cast<int>(mesh.vertices.size());
  std::map<std::pair<int, int>, int> directed;  // Edge -> the triangle to its left.
  std::vector<std::vector<int>> triangles_at(num_vertices);
  std::vector<int> parent(num_vertices);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<int, 3>& triangle = mesh.triangles[t];
    std::array<Eigen::Vector3d, 3> p;
    for (int k = 0; k < 3; ++k) {
      p[k] = mesh.vertices[triangle[k]];
      triangles_at[triangle[k]].push_back(static_cast<int>(t));
      const int next = triangle[(k + 1) % 3];
      if (!directed.insert({{triangle[k], next}, static_cast<int>(t)}).second) {
        q.is_manifold = false;
      }
      parent[root(triangle[k])] = root(next);
    }
    const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
    q.area += area;
    q.min_area = std::min(q.min_area, area);
    q.max_area = std::max(q.max_area, area);
    q.volume += p[0].dot(p[1].cross(p[2])) / 6.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d a = p[(k + 1) % 3] - p[k];
      const Eigen::Vector3d b = p[(k + 2) % 3] - p[k];
      q.min_edge = std::min(q.min_edge, a.norm());
      q.max_edge = std::max(q.max_edge, a.norm());
      const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
      q.min_angle_deg = std::min(q.min_angle_deg, angle * 180.0 / M_PI);
    }
  }

  std::set<int> on_boundary;
  int num_edges = 0;
  for (const auto& [edge, t] : directed) {
    const bool has_twin = directed.count({edge.second, edge.first}) > 0;
    if (!has_twin) {
      ++q.num_boundary_edges;
      on_boundary.insert(edge.first);
      on_boundary.insert(edge.second);
    }
    if (!has_twin || edge.first < edge.second) ++num_edges;
  }
  q.euler_characteristic = num_vertices - num_edges + static_cast<int>(mesh.triangles.size());

  std::set<int> roots;
  for (int v = 0; v < num_vertices; ++v) {
    roots.insert(root(v));
    if (triangles_at[v].empty()) {
      q.is_manifold = false;
      continue;
    }
    // One fan: triangles joined by the edges at v hang together.
    std::set<int> reached = {triangles_at[v][0]};
    std::vector<int> open = {triangles_at[v][0]};
    while (!open.empty()) {
      const std::array<int, 3>& triangle = mesh.triangles[open.back()];
      open.pop_back();
      for (const int other : triangle) {
        for (const auto& edge : {std::make_pair(v, other), std::make_pair(other, v)}) {
          const auto it = directed.find(edge);
          if (it != directed.end() && reached.insert(it->second).second) open.push_back(it->second);
        }
      }
    }
    if (reached.size() != triangles_at[v].size()) q.is_manifold = false;
    const int valence = static_cast<int>(triangles_at[v].size());
    if (on_boundary.count(v) > 0) {
      ++q.boundary_valences[valence + 1];
    } else {
      ++q.valences[valence];
    }
  }
  q.num_components = static_cast<int>(roots.size());
  return q;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_MESH_QUALITY_H_
