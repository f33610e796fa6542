#include "geometry/loop_mesh.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <cmath>
#include <map>
#include <utility>

namespace darboux {
namespace {

// Corner k of an element in its coordinates.
ElementPoint Corner(int element, int k) {
  return {element, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
}

// Opposite corner and triangle of each directed edge.
using Edges = std::map<std::pair<int, int>, std::pair<int, int>>;  // -> triangle, corner of begin

Edges DirectedEdges(const std::vector<std::array<int, 3>>& triangles) {
  Edges edges;
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const bool is_new =
          edges.insert({{triangles[t][k], triangles[t][(k + 1) % 3]}, {static_cast<int>(t), k}})
              .second;
      CHECK(is_new) << "edge " << triangles[t][k] << ", " << triangles[t][(k + 1) % 3]
                    << " has two triangles on one side";
    }
  }
  return edges;
}

// A vertex of one or two triangles between the boundary edges (from, vertex) and (vertex, to) would
// have valence 4 or 5 with the ghosts of these edges alone, and the limit surface is rounded there
// or, through given points, has waves along its rim. Where it is a corner of a lattice, ghosts
// opposite to these neighbours make the valence 6 and the limit point the vertex itself. Nothing
// where that would leave the limit point farther away, as on a straight rim.
std::vector<int> CornerNeighbours(
    const TriangleMesh& mesh, const Edges& edges, int from, int vertex, int to) {
  const auto third = [&](int neighbour) {
    const auto [triangle, corner] = edges.at({vertex, neighbour});
    return mesh.triangles[triangle][(corner + 2) % 3];
  };
  const int middle = third(to);
  if (middle == from) return {to, from};
  if (third(middle) != from) return {};
  const auto at = [&](int i) { return mesh.vertices[i]; };
  const Eigen::Vector3d both = at(from) + at(to);
  // Limit points without and with, from the vertex: weight * (ring - valence * vertex).
  const double weight = 1.0 / (5.0 + 0.375 / LoopVertexWeight(5));
  const Eigen::Vector3d without = weight * (2.0 * both - 3.0 * at(vertex) - at(middle));
  const Eigen::Vector3d with = (both - at(vertex) - at(middle)) / 6.0;
  if (with.squaredNorm() < without.squaredNorm()) return {middle};
  return {};
}

}  // namespace

double LoopVertexWeight(int n) {
  const double c = 0.375 + 0.25 * std::cos(2.0 * M_PI / n);
  return (0.625 - c * c) / n;
}

LoopMesh MakeLoopMesh(const TriangleMesh& source) {
  LoopMesh result;
  ControlMesh& mesh = result.mesh;
  const int num_vertices = static_cast<int>(source.vertices.size());
  mesh.num_elements = static_cast<int>(source.triangles.size());
  mesh.triangles = source.triangles;
  const Edges edges = DirectedEdges(source.triangles);

  // Boundary edges by their first vertex, each with its ghost.
  struct Open {
    int to, triangle, corner, ghost;
  };
  std::map<int, Open> open;
  for (const auto& [edge, place] : edges) {
    if (edges.count({edge.second, edge.first}) > 0) continue;
    const auto [triangle, corner] = place;
    const int ghost = num_vertices + static_cast<int>(result.ghosts.size());
    const bool is_new = open.insert({edge.first, {edge.second, triangle, corner, ghost}}).second;
    CHECK(is_new) << "vertex " << edge.first << " lies on two boundary loops";
    const int opposite = source.triangles[triangle][(corner + 2) % 3];
    result.ghosts.push_back({edge.first, edge.second, opposite});
    mesh.triangles.push_back({edge.second, edge.first, ghost});
  }
  // Between the ghosts of consecutive edges: around the vertex that they share, which in a corner
  // gets further ones opposite to its neighbours.
  for (const auto& [from, edge] : open) {
    int last = edge.ghost;
    for (const int neighbour :
         CornerNeighbours(source, edges, from, edge.to, open.at(edge.to).to)) {
      const int ghost = num_vertices + static_cast<int>(result.ghosts.size());
      result.ghosts.push_back({edge.to, edge.to, neighbour});
      mesh.triangles.push_back({edge.to, last, ghost});
      last = ghost;
    }
    mesh.triangles.push_back({edge.to, last, open.at(edge.to).ghost});
  }
  std::map<int, Open> left = open;
  while (!left.empty()) {
    result.loops.emplace_back();
    int at = left.begin()->first;
    for (auto edge = left.find(at); edge != left.end(); edge = left.find(at)) {
      const Open& e = edge->second;
      result.loops.back().push_back(
          {e.triangle, Corner(e.triangle, e.corner), Corner(e.triangle, (e.corner + 1) % 3)});
      at = e.to;
      left.erase(edge);
    }
  }

  mesh.num_vertices = num_vertices + static_cast<int>(result.ghosts.size());
  result.points.resize(3, mesh.num_vertices);
  for (int i = 0; i < num_vertices; ++i) result.points.col(i) = source.vertices[i];
  for (size_t g = 0; g < result.ghosts.size(); ++g) {
    const LoopMesh::Ghost& ghost = result.ghosts[g];
    result.points.col(num_vertices + g) =
        result.points.col(ghost.a) + result.points.col(ghost.b) - result.points.col(ghost.c);
  }
  return result;
}

bool InterpolatePoints(LoopMesh* mesh) {
  const int num_ghosts = static_cast<int>(mesh->ghosts.size());
  const int n = mesh->mesh.num_vertices - num_ghosts;
  std::vector<std::vector<int>> neighbours(mesh->mesh.num_vertices);
  for (const auto& triangle : mesh->mesh.triangles) {
    for (int k = 0; k < 3; ++k) neighbours[triangle[k]].push_back(triangle[(k + 1) % 3]);
  }
  // Limit point (1 - n w) x + w * sum of neighbours, w = 1 / (n + 3 / (8 beta)).
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    const int valence = static_cast<int>(neighbours[i].size());
    const double w = 1.0 / (valence + 0.375 / LoopVertexWeight(valence));
    entries.emplace_back(i, i, 1.0 - valence * w);
    for (const int j : neighbours[i]) {
      if (j < n) {
        entries.emplace_back(i, j, w);
        continue;
      }
      const LoopMesh::Ghost& ghost = mesh->ghosts[j - n];
      entries.emplace_back(i, ghost.a, w);
      entries.emplace_back(i, ghost.b, w);
      entries.emplace_back(i, ghost.c, -w);
    }
  }
  Eigen::SparseMatrix<double> limit(n, n);
  limit.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(limit);
  if (lu.info() != Eigen::Success) return false;
  const Eigen::MatrixXd target = mesh->points.leftCols(n).transpose();
  Eigen::MatrixXd x = lu.solve(target);
  x += lu.solve(target - limit * x);  // Positions carry the rest shape's curvature: all digits.
  if (lu.info() != Eigen::Success || !x.allFinite()) return false;
  mesh->points.leftCols(n) = x.transpose();
  for (int g = 0; g < num_ghosts; ++g) {
    const LoopMesh::Ghost& ghost = mesh->ghosts[g];
    mesh->points.col(n + g) =
        mesh->points.col(ghost.a) + mesh->points.col(ghost.b) - mesh->points.col(ghost.c);
  }
  return true;
}

int FindSingularVertex(const LoopMesh& mesh) {
  constexpr double kRounding = 1e-10;
  const int n = mesh.mesh.num_vertices - static_cast<int>(mesh.ghosts.size());
  std::vector<std::vector<std::pair<int, int>>> sides(n);  // Opposite to each vertex.
  for (const auto& triangle : mesh.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (triangle[k] >= n) continue;
      sides[triangle[k]].push_back({triangle[(k + 1) % 3], triangle[(k + 2) % 3]});
    }
  }
  for (int v = 0; v < n; ++v) {
    // Tangents by Loop's masks: cosines and sines once around the vertex.
    Eigen::Vector3d tangent[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    double size = 0.0;
    const double step = 2.0 * M_PI / static_cast<double>(sides[v].size());
    int at = sides[v].empty() ? -1 : sides[v].front().first;
    for (size_t k = 0; k < sides[v].size(); ++k) {
      const Eigen::Vector3d edge = mesh.points.col(at) - mesh.points.col(v);
      tangent[0] += std::cos(step * k) * edge;
      tangent[1] += std::sin(step * k) * edge;
      size += edge.squaredNorm();
      for (const auto& [from, to] : sides[v]) {
        if (from != at) continue;
        at = to;
        break;
      }
    }
    const double area = tangent[0].cross(tangent[1]).norm();
    if (!(area > kRounding * size && std::isfinite(area))) return v;
  }
  return -1;
}

TriangleMesh SubdivideLoop(const TriangleMesh& source) {
  const LoopMesh loop = MakeLoopMesh(source);
  const int num_vertices = static_cast<int>(source.vertices.size());
  std::vector<std::vector<int>> neighbours(loop.mesh.num_vertices);
  for (const auto& triangle : loop.mesh.triangles) {
    for (int k = 0; k < 3; ++k) neighbours[triangle[k]].push_back(triangle[(k + 1) % 3]);
  }
  TriangleMesh result;
  for (int i = 0; i < num_vertices; ++i) {
    const double w = LoopVertexWeight(static_cast<int>(neighbours[i].size()));
    Eigen::Vector3d x = (1.0 - neighbours[i].size() * w) * loop.points.col(i);
    for (const int j : neighbours[i]) x += w * loop.points.col(j);
    result.vertices.push_back(x);
  }
  const Edges edges = DirectedEdges(loop.mesh.triangles);
  std::map<std::pair<int, int>, int> middle;
  const auto corner = [&](int a, int b) {
    const auto [it, is_new] =
        middle.insert({std::minmax(a, b), static_cast<int>(result.vertices.size())});
    if (is_new) {
      Eigen::Vector3d x = 0.375 * (loop.points.col(a) + loop.points.col(b));
      for (const auto& edge : {std::make_pair(a, b), std::make_pair(b, a)}) {
        const auto [triangle, k] = edges.at(edge);
        x += 0.125 * loop.points.col(loop.mesh.triangles[triangle][(k + 2) % 3]);
      }
      result.vertices.push_back(x);
    }
    return it->second;
  };
  for (const auto& [a, b, c] : source.triangles) {
    const int ab = corner(a, b), bc = corner(b, c), ca = corner(c, a);
    result.triangles.push_back({a, ab, ca});
    result.triangles.push_back({ab, b, bc});
    result.triangles.push_back({ca, bc, c});
    result.triangles.push_back({ab, bc, ca});
  }
  return result;
}

}  // namespace darboux
