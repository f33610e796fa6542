#include "geometry/mesh_topology.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace darboux {
namespace {

using Triangles = std::vector<std::array<int, 3>>;

bool IsSound(const std::array<int, 3>& t, int num_vertices) {
  for (const int v : t) {
    if (v < 0 || v >= num_vertices) return false;
  }
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

// Triangles that have edges, and their numbers in the mesh.
Triangles SoundTriangles(const TriangleMesh& mesh, std::vector<int>* numbers) {
  Triangles sound;
  numbers->clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!IsSound(mesh.triangles[t], static_cast<int>(mesh.vertices.size()))) continue;
    sound.push_back(mesh.triangles[t]);
    numbers->push_back(static_cast<int>(t));
  }
  return sound;
}

struct Loop {
  std::vector<int> vertices;
  int triangle = 0;  // One of those along it.
};

// Each edge of the boundary has two ends, 2 * k (where its triangle begins it) and 2 * k + 1.
class BoundaryWalker {
 public:
  BoundaryWalker(const Triangles& triangles, const EdgeTable& edges)
      : triangles_(triangles), edges_(edges) {
    for (std::size_t e = 0; e < edges.edges().size(); ++e) {
      if (edges.edges()[e].count == 1) boundary_.push_back(static_cast<int>(e));
    }
    PairEnds();
  }

  std::vector<Loop> Walk() {
    std::vector<Loop> loops;
    is_used_.assign(boundary_.size(), 0);
    for (std::size_t end = 0; end < mate_.size(); ++end) {  // Open ones from their ends.
      if (mate_[end] < 0 && !is_used_[end / 2]) loops.push_back(WalkFrom(static_cast<int>(end)));
    }
    for (std::size_t k = 0; k < boundary_.size(); ++k) {
      if (is_used_[k]) continue;
      loops.push_back(WalkFrom(static_cast<int>(2 * k)));
      std::vector<int>& v = loops.back().vertices;
      v.pop_back();  // The first one again.
      std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    }
    std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
      return a.vertices < b.vertices;
    });
    return loops;
  }

 private:
  const EdgeTable::Side& SideOf(int k) const {
    const EdgeTable::Edge& edge =
        edges_.edges()[static_cast<std::size_t>(boundary_[static_cast<std::size_t>(k)])];
    return edges_.sides()[static_cast<std::size_t>(edge.first)];
  }
  int CornerOf(int end) const {  // As 3 * triangle + corner.
    const EdgeTable::Side& side = SideOf(end / 2);
    return 3 * side.triangle + (end % 2 == 0 ? side.corner : (side.corner + 1) % 3);
  }
  int VertexOf(int end) const {
    const int corner = CornerOf(end);
    return triangles_[static_cast<std::size_t>(corner / 3)][static_cast<std::size_t>(corner % 3)];
  }

  // Ends of the same fan; what is left over at a vertex with each other.
  void PairEnds() {
    const int num_ends = 2 * static_cast<int>(boundary_.size());
    mate_.assign(static_cast<std::size_t>(num_ends), -1);
    DisjointSets fans = VertexFans(triangles_, edges_);
    std::map<int, int> waiting_in_fan, waiting_at_vertex;
    const auto pair = [this](std::map<int, int>* waiting, int key, int end) {
      const auto [found, is_new] = waiting->emplace(key, end);
      if (is_new) return;
      mate_[static_cast<std::size_t>(end)] = found->second;
      mate_[static_cast<std::size_t>(found->second)] = end;
      waiting->erase(found);
    };
    for (int end = 0; end < num_ends; ++end) pair(&waiting_in_fan, fans.Find(CornerOf(end)), end);
    for (int end = 0; end < num_ends; ++end) {
      if (mate_[static_cast<std::size_t>(end)] < 0) pair(&waiting_at_vertex, VertexOf(end), end);
    }
  }

  Loop WalkFrom(int end) {
    Loop loop;
    loop.triangle = SideOf(end / 2).triangle;
    loop.vertices.push_back(VertexOf(end));
    while (end >= 0 && !is_used_[static_cast<std::size_t>(end / 2)]) {
      is_used_[static_cast<std::size_t>(end / 2)] = 1;
      const int other = end ^ 1;
      loop.vertices.push_back(VertexOf(other));
      end = mate_[static_cast<std::size_t>(other)];
    }
    return loop;
  }

  const Triangles& triangles_;
  const EdgeTable& edges_;
  std::vector<int> boundary_;  // Edges.
  std::vector<int> mate_;      // Of each end, the end where the walk goes on; -1: none.
  std::vector<char> is_used_;
};

}  // namespace

EdgeTable::EdgeTable(const Triangles& triangles) {
  struct Entry {
    std::array<int, 2> vertices;
    Side side;
  };
  std::vector<Entry> entries;
  entries.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
      entries.push_back(
          {{std::min(a, b), std::max(a, b)}, {static_cast<int>(t), static_cast<int>(c), a < b}});
    }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.vertices < b.vertices;
  });
  edge_of_.resize(entries.size());
  sides_.reserve(entries.size());
  for (const Entry& entry : entries) {
    if (edges_.empty() || edges_.back().vertices != entry.vertices) {
      edges_.push_back({entry.vertices, static_cast<int>(sides_.size()), 0});
    }
    ++edges_.back().count;
    sides_.push_back(entry.side);
    edge_of_[static_cast<std::size_t>(3 * entry.side.triangle + entry.side.corner)] =
        static_cast<int>(edges_.size()) - 1;
  }
}

const EdgeTable::Side* EdgeTable::Across(int triangle, int corner) const {
  const Edge& edge = edges_[static_cast<std::size_t>(EdgeOf(triangle, corner))];
  if (edge.count != 2) return nullptr;
  const Side* const sides = &sides_[static_cast<std::size_t>(edge.first)];
  return &sides[sides[0].triangle == triangle ? 1 : 0];
}

bool EdgeTable::HasEdge(int a, int b) const {
  const std::array<int, 2> vertices = {std::min(a, b), std::max(a, b)};
  const auto found = std::lower_bound(
      edges_.begin(), edges_.end(), vertices, [](const Edge& edge, const std::array<int, 2>& v) {
        return edge.vertices < v;
      });
  return found != edges_.end() && found->vertices == vertices;
}

DisjointSets::DisjointSets(std::size_t n) : parent_(n) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::Find(int i) {
  int root = i;
  while (parent_[static_cast<std::size_t>(root)] != root) {
    root = parent_[static_cast<std::size_t>(root)];
  }
  while (i != root) {
    const int next = parent_[static_cast<std::size_t>(i)];
    parent_[static_cast<std::size_t>(i)] = root;
    i = next;
  }
  return root;
}

void DisjointSets::Unite(int i, int j) {
  const int a = Find(i), b = Find(j);
  parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

DisjointSets VertexFans(const Triangles& triangles, const EdgeTable& edges) {
  DisjointSets fans(3 * triangles.size());
  for (const EdgeTable::Edge& edge : edges.edges()) {
    const EdgeTable::Side* const sides = &edges.sides()[static_cast<std::size_t>(edge.first)];
    // Corners of a side at the lower and the higher vertex of the edge.
    const auto corner = [](const EdgeTable::Side& side, bool low) {
      return 3 * side.triangle + (side.is_forward == low ? side.corner : (side.corner + 1) % 3);
    };
    for (int k = 1; k < edge.count; ++k) {
      fans.Unite(corner(sides[0], true), corner(sides[k], true));
      fans.Unite(corner(sides[0], false), corner(sides[k], false));
    }
  }
  return fans;
}

Orientation CompareWindings(const Triangles& triangles, const EdgeTable& edges) {
  Orientation result;
  result.patch.assign(triangles.size(), -1);
  result.is_against.assign(triangles.size(), 0);
  std::vector<int> open;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    if (result.patch[seed] >= 0) continue;
    result.patch[seed] = result.num_patches++;
    open.assign(1, static_cast<int>(seed));
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      for (int c = 0; c < 3; ++c) {
        const EdgeTable::Side* const other = edges.Across(t, c);
        if (other == nullptr) continue;
        const EdgeTable::Edge& edge = edges.edges()[static_cast<std::size_t>(edges.EdgeOf(t, c))];
        const EdgeTable::Side* const sides = &edges.sides()[static_cast<std::size_t>(edge.first)];
        // Neighbours that agree run along their edge in opposite directions.
        const bool is_same = sides[0].is_forward != sides[1].is_forward;
        const char expected = static_cast<char>(
            result.is_against[static_cast<std::size_t>(t)] != 0 ? is_same : !is_same);
        const std::size_t u = static_cast<std::size_t>(other->triangle);
        if (result.patch[u] < 0) {
          result.patch[u] = result.patch[seed];
          result.is_against[u] = expected;
          open.push_back(other->triangle);
        } else if (result.is_against[u] != expected) {
          result.contradictory_edges.push_back(edges.EdgeOf(t, c));
        }
      }
    }
  }
  std::vector<int>& bad = result.contradictory_edges;
  std::sort(bad.begin(), bad.end());
  bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
  return result;
}

std::vector<std::vector<int>> BoundaryLoops(const TriangleMesh& mesh) {
  std::vector<int> numbers;
  const Triangles triangles = SoundTriangles(mesh, &numbers);
  const EdgeTable edges(triangles);
  std::vector<std::vector<int>> loops;
  for (Loop& loop : BoundaryWalker(triangles, edges).Walk()) {
    loops.push_back(std::move(loop.vertices));
  }
  return loops;
}

int MeshComponent::Genus() const {
  if (!is_manifold) return -1;
  const int missing = 2 - num_boundary_loops - EulerCharacteristic();
  return is_orientable ? missing / 2 : missing;
}

std::vector<MeshComponent> MeshComponents(const TriangleMesh& mesh) {
  std::vector<int> numbers;
  const Triangles triangles = SoundTriangles(mesh, &numbers);
  const EdgeTable edges(triangles);
  DisjointSets sets(mesh.vertices.size());
  for (const std::array<int, 3>& t : triangles) {
    sets.Unite(t[0], t[1]);
    sets.Unite(t[1], t[2]);
  }
  std::vector<MeshComponent> components;
  std::vector<int> component_of(mesh.vertices.size(), -1);  // Of each set's lowest vertex.
  const auto at = [&](int vertex) -> MeshComponent& {
    return components[static_cast<std::size_t>(
        component_of[static_cast<std::size_t>(sets.Find(vertex))])];
  };
  std::vector<int> fan_of(mesh.vertices.size(), -1);
  DisjointSets fans = VertexFans(triangles, edges);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    int& component = component_of[static_cast<std::size_t>(sets.Find(triangles[t][0]))];
    if (component < 0) {
      component = static_cast<int>(components.size());
      components.emplace_back();
    }
    MeshComponent& c = components[static_cast<std::size_t>(component)];
    c.triangles.push_back(numbers[t]);
    for (std::size_t k = 0; k < 3; ++k) {
      int& fan = fan_of[static_cast<std::size_t>(triangles[t][k])];
      const int found = fans.Find(static_cast<int>(3 * t + k));
      if (fan < 0) {
        ++c.num_vertices;
        fan = found;
      } else if (fan != found) {
        c.is_manifold = false;
      }
    }
  }
  for (const EdgeTable::Edge& edge : edges.edges()) {
    MeshComponent& c = at(edge.vertices[0]);
    ++c.num_edges;
    if (edge.count > 2) c.is_manifold = false;
  }
  for (const int e : CompareWindings(triangles, edges).contradictory_edges) {
    at(edges.edges()[static_cast<std::size_t>(e)].vertices[0]).is_orientable = false;
  }
  for (const Loop& loop : BoundaryWalker(triangles, edges).Walk()) {
    ++at(loop.vertices[0]).num_boundary_loops;
  }
  return components;
}

}  // namespace darboux
