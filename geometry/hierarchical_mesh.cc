#include "geometry/hierarchical_mesh.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace darboux {
namespace {

using Numbers = std::vector<std::vector<std::int64_t>>;

void SortUnique(std::vector<std::int64_t>* numbers) {
  std::sort(numbers->begin(), numbers->end());
  numbers->erase(std::unique(numbers->begin(), numbers->end()), numbers->end());
}

// Of the child at corner k the corner k is the parent's, the others are middles of its edges.
int CornerOf(const std::array<int, 3>& corners, int vertex) {
  return corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
}

// Distance of a point from a plane triangle: C. Ericson, "Real-Time Collision Detection" (2005),
// sec. 5.1.5, by regions of the triangle.
double DistanceToTriangle(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& x) {
  const auto to_segment = [&p](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d d = b - a;
    const double f = d.squaredNorm() > 0.0 ? (p - a).dot(d) / d.squaredNorm() : 0.0;
    return (p - a - std::min(1.0, std::max(0.0, f)) * d).norm();
  };
  const Eigen::Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
  bool inside = normal.squaredNorm() > 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d &a = x[k], &b = x[(k + 1) % 3];
    inside = inside && (b - a).cross(p - a).dot(normal) >= 0.0;
    nearest = std::min(nearest, to_segment(a, b));
  }
  return inside ? std::abs((p - x[0]).dot(normal.normalized())) : nearest;
}

}  // namespace

bool MeshRefinement::Contains(const MeshRefinement& other) const {
  if (other.refined.size() > refined.size()) return false;
  for (size_t l = 0; l < other.refined.size(); ++l) {
    if (!std::includes(refined[l].begin(),
                       refined[l].end(),
                       other.refined[l].begin(),
                       other.refined[l].end())) {
      return false;
    }
  }
  return true;
}

ElementPoint ParentPoint(int child, const ElementPoint& point) {
  const double s = 0.5 * point.s, t = 0.5 * point.t;
  if (child == 3) return {point.element, 0.5 - t, s + t};
  return {point.element, s + (child == 1 ? 0.5 : 0.0), t + (child == 2 ? 0.5 : 0.0)};
}

HierarchicalMesh::HierarchicalMesh(const LoopMesh& base, const MeshRefinement& refinement)
    : refinement_(refinement) {
  CHECK(base.folds.empty()) << "the base is refined itself";
  CHECK_LE(refinement.refined.size(), static_cast<size_t>(kMaxLevels));
  refinement_ = Merged({});
  Build(base);
  for (MeshRefinement more; Close(&more);) {
    refinement_ = more;
    Build(base);
  }
  MakeMesh(base);
}

MeshRefinement HierarchicalMesh::Merged(Numbers more) const {
  MeshRefinement result = refinement_;
  if (more.size() > result.refined.size()) result.refined.resize(more.size());
  for (size_t l = 0; l < result.refined.size(); ++l) {
    if (l < more.size()) {
      result.refined[l].insert(result.refined[l].end(), more[l].begin(), more[l].end());
    }
    SortUnique(&result.refined[l]);
  }
  while (!result.refined.empty() && result.refined.back().empty()) result.refined.pop_back();
  return result;
}

void HierarchicalMesh::Build(const LoopMesh& base) {
  levels_.assign(1, Level());
  Level& level = levels_[0];
  level.vertices.resize(base.mesh.num_vertices);
  for (int i = 0; i < base.mesh.num_vertices; ++i) level.vertices[i].point = base.points.col(i);
  level.triangles.resize(base.mesh.triangles.size());
  for (size_t t = 0; t < level.triangles.size(); ++t) {
    Triangle& triangle = level.triangles[t];
    triangle.corners = base.mesh.triangles[t];
    triangle.number = static_cast<std::int64_t>(t);
    triangle.is_shell = triangle.is_domain = static_cast<int>(t) < base.mesh.num_elements;
    for (const int corner : triangle.corners) {
      level.vertices[corner].triangles.push_back(static_cast<int>(t));
    }
  }
  for (size_t l = 0; l < refinement_.refined.size(); ++l) AddLevel();
  for (size_t l = 0; l < levels_.size(); ++l) {
    for (size_t v = 0; v < levels_[l].vertices.size(); ++v) {
      Vertex& vertex = levels_[l].vertices[v];
      if (!vertex.is_candidate) continue;
      bool is_dropped = true;
      ForEachInSupport(static_cast<int>(l), static_cast<int>(v), [&](int t) {
        is_dropped = is_dropped && levels_[l].triangles[t].is_refined;
      });
      vertex.is_dropped = is_dropped;
    }
  }
}

void HierarchicalMesh::AddLevel() {
  const int coarse = static_cast<int>(levels_.size()) - 1;
  levels_.emplace_back();
  std::vector<int> refined;
  for (const std::int64_t number : refinement_.refined[coarse]) {
    int t = static_cast<int>(number >> (2 * coarse));
    CHECK(t >= 0 && t < static_cast<int>(levels_[0].triangles.size())) << "no triangle " << number;
    for (int l = 0; l < coarse && t >= 0; ++l) {
      t = levels_[l].triangles[t].children[(number >> (2 * (coarse - 1 - l))) & 3];
    }
    CHECK(t >= 0 && levels_[coarse].triangles[t].is_domain)
        << "triangle " << number << " of level " << coarse << " is not part of the shell there";
    levels_[coarse].triangles[t].is_refined = true;
    refined.push_back(t);
  }
  // The children of what is refined, and all that touch these.
  for (const int t : refined) {
    for (int child = 0; child < 4; ++child) MakeChild(coarse, t, child);
    const std::array<int, 3> corners = levels_[coarse].triangles[t].corners;
    for (const int corner : corners) {
      const std::vector<int>& around = levels_[coarse].vertices[corner].triangles;
      for (const int u : around) {
        const std::array<int, 3> other = levels_[coarse].triangles[u].corners;
        int shared = 0;
        for (const int vertex : other) {
          shared += std::count(corners.begin(), corners.end(), vertex) > 0 ? 1 : 0;
        }
        MakeChild(coarse, u, CornerOf(other, corner));
        if (shared == 2) MakeChild(coarse, u, 3);
      }
    }
  }
  const Level& below = levels_[coarse];
  for (Vertex& vertex : levels_.back().vertices) {
    // The support of a child of vertex a are the children of the triangles around a, that of a
    // child of edge (a, b) those of the triangles around both.
    int count = 0;
    bool all = true;
    for (const int end : {vertex.a, vertex.b}) {
      for (const int t : below.vertices[end].triangles) {
        if (!below.triangles[t].is_shell) continue;
        ++count;
        all = all && below.triangles[t].is_refined;
      }
    }
    vertex.is_candidate = all && count > 0;
  }
}

int HierarchicalMesh::AddVertex(int level, int a, int b) {
  const int index = static_cast<int>(levels_[level].vertices.size());
  levels_[level].vertices.emplace_back();
  levels_[level].vertices[index].a = a;
  levels_[level].vertices[index].b = b;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  ForEachInMask(level, index, [&](int vertex, double factor) {
    point += factor * levels_[level - 1].vertices[vertex].point;
  });
  levels_[level].vertices[index].point = point;
  return index;
}

int HierarchicalMesh::ChildOfVertex(int level, int a) {
  if (levels_[level].vertices[a].child < 0) {
    levels_[level].vertices[a].child = AddVertex(level + 1, a, a);
  }
  return levels_[level].vertices[a].child;
}

int HierarchicalMesh::FindEdgeChild(int level, int a, int b) const {
  for (const auto& [end, child] : levels_[level].vertices[std::min(a, b)].edge_children) {
    if (end == std::max(a, b)) return child;
  }
  return -1;
}

int HierarchicalMesh::ChildOfEdge(int level, int a, int b) {
  int child = FindEdgeChild(level, a, b);
  if (child < 0) {
    const auto [low, high] = std::minmax({a, b});
    child = AddVertex(level + 1, low, high);
    levels_[level].vertices[low].edge_children.push_back({high, child});
  }
  return child;
}

int HierarchicalMesh::MakeChild(int level, int triangle, int child) {
  const Triangle parent = levels_[level].triangles[triangle];
  if (parent.children[child] >= 0) return parent.children[child];
  Triangle made;
  made.number = 4 * parent.number + child;
  made.parent = triangle;
  made.is_shell = parent.is_shell;
  made.is_domain = parent.is_refined;
  const auto& c = parent.corners;
  for (int k = 0; k < 3; ++k) {
    if (child == 3) {
      made.corners[k] = ChildOfEdge(level, c[k], c[(k + 1) % 3]);
    } else {
      made.corners[k] =
          k == child ? ChildOfVertex(level, c[k]) : ChildOfEdge(level, c[child], c[k]);
    }
  }
  const int index = static_cast<int>(levels_[level + 1].triangles.size());
  levels_[level].triangles[triangle].children[child] = index;
  for (const int corner : made.corners) {
    levels_[level + 1].vertices[corner].triangles.push_back(index);
  }
  levels_[level + 1].triangles.push_back(made);
  return index;
}

template <typename Use>
void HierarchicalMesh::ForEachInMask(int level, int vertex, const Use& use) const {
  const Level& below = levels_[level - 1];
  const int a = levels_[level].vertices[vertex].a, b = levels_[level].vertices[vertex].b;
  if (a == b) {
    const std::vector<int>& around = below.vertices[a].triangles;
    const int n = static_cast<int>(around.size());
    const double w = LoopVertexWeight(n);
    use(a, 1.0 - n * w);
    for (const int t : around) {
      const auto& corners = below.triangles[t].corners;
      use(corners[(CornerOf(corners, a) + 1) % 3], w);
    }
    return;
  }
  use(a, 0.375);
  use(b, 0.375);
  int sides = 0;
  for (const int t : below.vertices[a].triangles) {
    const auto& corners = below.triangles[t].corners;
    const int k = CornerOf(corners, a);
    if (corners[(k + 1) % 3] == b || corners[(k + 2) % 3] == b) {
      use(corners[(k + 1) % 3] == b ? corners[(k + 2) % 3] : corners[(k + 1) % 3], 0.125);
      ++sides;
    }
  }
  CHECK_EQ(sides, 2) << "an edge beyond the first ring";
}

template <typename Use>
void HierarchicalMesh::ForEachInSupport(int level, int vertex, const Use& use) const {
  const Level& here = levels_[level];
  std::vector<int> triangles;
  for (const int t : here.vertices[vertex].triangles) {
    for (const int corner : here.triangles[t].corners) {
      const std::vector<int>& around = here.vertices[corner].triangles;
      triangles.insert(triangles.end(), around.begin(), around.end());
    }
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  for (const int t : triangles) {
    if (here.triangles[t].is_shell) use(t);
  }
}

bool HierarchicalMesh::Close(MeshRefinement* more) const {
  Numbers missing(levels_.size());
  bool any = false;
  for (size_t l = 1; l + 1 < levels_.size(); ++l) {
    const Level& here = levels_[l];
    const Level& below = levels_[l - 1];
    std::vector<char> seen(here.vertices.size(), 0);
    for (const Triangle& triangle : here.triangles) {
      if (!triangle.is_refined) continue;
      for (const int corner : triangle.corners) {
        for (const int t : here.vertices[corner].triangles) {
          for (const int v : here.triangles[t].corners) {
            if (seen[v] || here.vertices[v].is_candidate) continue;
            seen[v] = 1;
            for (const int end : {here.vertices[v].a, here.vertices[v].b}) {
              for (const int u : below.vertices[end].triangles) {
                const Triangle& needed = below.triangles[u];
                if (!needed.is_shell || needed.is_refined) continue;
                any = true;
                if (needed.is_domain) {
                  missing[l - 1].push_back(needed.number);
                } else {
                  missing[l - 2].push_back(below.triangles[u].number >> 2);
                }
              }
            }
          }
        }
      }
    }
  }
  if (any) *more = Merged(std::move(missing));
  return any;
}

void HierarchicalMesh::AddLeaves(int level, int triangle) {
  Triangle& t = levels_[level].triangles[triangle];
  if (t.is_refined) {
    for (const int child : t.children) AddLeaves(level + 1, child);
    return;
  }
  t.element = static_cast<int>(leaves_.size());
  leaves_.push_back({level, triangle});
  cells_.push_back({level, t.number});
}

void HierarchicalMesh::MakeMesh(const LoopMesh& base) {
  for (int t = 0; t < base.mesh.num_elements; ++t) AddLeaves(0, t);
  // What leaves depend on: the triangles around their corners.
  std::vector<std::vector<char>> needed(levels_.size());
  for (size_t l = 0; l < levels_.size(); ++l) needed[l].assign(levels_[l].triangles.size(), 0);
  for (const Place& leaf : leaves_) {
    const Level& level = levels_[leaf.level];
    for (const int corner : level.triangles[leaf.vertex].corners) {
      for (const int t : level.vertices[corner].triangles) needed[leaf.level][t] = 1;
    }
  }
  for (size_t l = 0; l < levels_.size(); ++l) {
    for (size_t t = 0; t < needed[l].size(); ++t) {
      if (!needed[l][t]) continue;
      for (const int corner : levels_[l].triangles[t].corners)
        levels_[l].vertices[corner].number = 0;
    }
    for (size_t v = 0; v < levels_[l].vertices.size(); ++v) {
      int& number = levels_[l].vertices[v].number;
      if (number < 0) continue;
      number = static_cast<int>(places_.size());
      places_.push_back({static_cast<int>(l), static_cast<int>(v)});
    }
  }
  const auto add = [this](int level, int triangle) {
    std::array<int, 3> corners = levels_[level].triangles[triangle].corners;
    for (int& corner : corners) corner = levels_[level].vertices[corner].number;
    mesh_.mesh.triangles.push_back(corners);
  };
  for (const Place& leaf : leaves_) add(leaf.level, leaf.vertex);
  mesh_.mesh.num_elements = static_cast<int>(leaves_.size());
  mesh_.mesh.num_vertices = static_cast<int>(places_.size());
  for (size_t l = 0; l < levels_.size(); ++l) {
    for (size_t t = 0; t < needed[l].size(); ++t) {
      if (needed[l][t] && levels_[l].triangles[t].element < 0) {
        add(static_cast<int>(l), static_cast<int>(t));
      }
    }
  }

  mesh_.points.resize(3, mesh_.mesh.num_vertices);
  mesh_.folds.resize(places_.size());
  mesh_.places.resize(places_.size());
  for (size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    const Vertex& vertex = levels_[place.level].vertices[place.vertex];
    mesh_.points.col(i) = vertex.point;
    // Coarser levels come first: what the place and the sum refer to is known.
    const bool is_same = place.level > 0 && vertex.a == vertex.b;
    int known = is_same ? levels_[place.level - 1].vertices[vertex.a].number : -1;
    if (is_same && known < 0) {
      // None of the coarser vertex in mesh_: no leaf has it, but the ones below may.
      Place at{place.level - 1, vertex.a};
      while (known < 0 && at.level > 0) {
        const Vertex& coarser = levels_[at.level].vertices[at.vertex];
        if (coarser.a != coarser.b) break;
        at = {at.level - 1, coarser.a};
        known = levels_[at.level].vertices[at.vertex].number;
      }
    }
    mesh_.places[i] = known < 0 ? static_cast<int>(i) : mesh_.places[known];
    if (vertex.is_candidate) {
      mesh_.folds[i] = {{static_cast<int>(i), 1.0}};
      continue;
    }
    ForEachInMask(place.level, place.vertex, [&](int v, double factor) {
      const int number = levels_[place.level - 1].vertices[v].number;
      CHECK(number >= 0 && IsUnknown(number)) << "not admissible";
      mesh_.folds[i].push_back({number, factor});
    });
  }

  mesh_.hanging.assign(leaves_.size(), {-1, -1, -1});
  for (size_t e = 0; e < leaves_.size(); ++e) {
    const Place& leaf = leaves_[e];
    const auto& corners = levels_[leaf.level].triangles[leaf.vertex].corners;
    for (int k = 0; k < 3; ++k) {
      const int a = corners[k], b = corners[(k + 1) % 3];
      for (const int t : levels_[leaf.level].vertices[a].triangles) {
        const Triangle& across = levels_[leaf.level].triangles[t];
        if (!across.is_refined) continue;
        if (std::count(across.corners.begin(), across.corners.end(), b) == 0) continue;
        mesh_.hanging[e][k] =
            levels_[leaf.level + 1].vertices[FindEdgeChild(leaf.level, a, b)].number;
      }
    }
  }

  // Boundary edges, those of what is refined in two.
  struct Edge {
    int level, triangle, corner;
  };
  for (const auto& loop : base.loops) {
    mesh_.loops.emplace_back();
    for (const auto& edge : loop) {
      const int corner = edge.begin.s == 1.0 ? 1 : edge.begin.t == 1.0 ? 2 : 0;
      std::vector<Edge> left = {{0, edge.element, corner}};
      while (!left.empty()) {
        const Edge at = left.back();
        left.pop_back();
        const Triangle& triangle = levels_[at.level].triangles[at.triangle];
        const int next = (at.corner + 1) % 3;
        if (triangle.is_refined) {
          left.push_back({at.level + 1, triangle.children[next], at.corner});
          left.push_back({at.level + 1, triangle.children[at.corner], at.corner});
          continue;
        }
        const auto point = [&](int k) -> ElementPoint {
          return {triangle.element, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
        };
        mesh_.loops.back().push_back({triangle.element, point(at.corner), point(next)});
      }
    }
  }
}

bool HierarchicalMesh::IsUnknown(int vertex) const {
  const Place& place = places_[vertex];
  const Vertex& v = levels_[place.level].vertices[place.vertex];
  return v.is_candidate && !v.is_dropped;
}

ElementPoint HierarchicalMesh::Locate(const ElementPoint& base_point) const {
  int level = 0, triangle = base_point.element;
  double s = base_point.s, t = base_point.t;
  while (levels_[level].triangles[triangle].is_refined) {
    int child = 3;
    if (s + t <= 0.5) {
      child = 0;
    } else if (s >= 0.5) {
      child = 1;
    } else if (t >= 0.5) {
      child = 2;
    }
    if (child == 3) {
      // Inverse of (1/2 - t/2, s/2 + t/2).
      const double t0 = 1.0 - 2.0 * s;
      s = 2.0 * t - t0;
      t = t0;
    } else {
      s = 2.0 * s - (child == 1 ? 1.0 : 0.0);
      t = 2.0 * t - (child == 2 ? 1.0 : 0.0);
    }
    triangle = levels_[level].triangles[triangle].children[child];
    ++level;
  }
  return {levels_[level].triangles[triangle].element, s, t};
}

ElementPoint HierarchicalMesh::BasePoint(const ElementPoint& point) const {
  const Cell& cell = cells_[point.element];
  ElementPoint result = point;
  for (int l = 0; l < cell.level; ++l) {
    result = ParentPoint(static_cast<int>((cell.triangle >> (2 * l)) & 3), result);
  }
  result.element = static_cast<int>(cell.triangle >> (2 * cell.level));
  return result;
}

MeshRefinement HierarchicalMesh::RefineElements(const std::vector<int>& elements) const {
  Numbers more(levels_.size());
  for (const int e : elements) more[cells_[e].level].push_back(cells_[e].triangle);
  return Merged(std::move(more));
}

void HierarchicalMesh::AddSupport(int level, int vertex, Numbers* refined) const {
  ForEachInSupport(level, vertex, [&](int t) {
    const Triangle& triangle = levels_[level].triangles[t];
    if (triangle.is_domain) {
      (*refined)[level].push_back(triangle.number);
      return;
    }
    // The levels below must have it first.
    for (int l = level - 1; l >= 0; --l) {
      (*refined)[l].push_back(triangle.number >> (2 * (level - l)));
    }
    (*refined)[level].push_back(triangle.number);
  });
}

MeshRefinement HierarchicalMesh::RefineSupports(const std::vector<int>& unknowns) const {
  Numbers more(levels_.size());
  for (const int i : unknowns) AddSupport(places_[i].level, places_[i].vertex, &more);
  return Merged(std::move(more));
}

bool HierarchicalMesh::GivesWay(int unknown, const MeshRefinement& more) const {
  const int level = places_[unknown].level;
  if (level >= static_cast<int>(more.refined.size())) return false;
  const std::vector<std::int64_t>& refined = more.refined[level];
  bool all = true;
  ForEachInSupport(level, places_[unknown].vertex, [&](int t) {
    all = all &&
          std::binary_search(refined.begin(), refined.end(), levels_[level].triangles[t].number);
  });
  return all;
}

Eigen::Vector3d HierarchicalMesh::LimitPoint(int level, int vertex) const {
  const Level& here = levels_[level];
  const std::vector<int>& around = here.vertices[vertex].triangles;
  const int n = static_cast<int>(around.size());
  const double w = 1.0 / (n + 0.375 / LoopVertexWeight(n));
  Eigen::Vector3d x = (1.0 - n * w) * here.vertices[vertex].point;
  for (const int t : around) {
    const auto& corners = here.triangles[t].corners;
    x += w * here.vertices[corners[(CornerOf(corners, vertex) + 1) % 3]].point;
  }
  return x;
}

MeshRefinement HierarchicalMesh::RefineNear(const std::vector<Ball>& balls,
                                            int level,
                                            std::vector<double>* beyond) const {
  Numbers more(levels_.size());
  if (beyond != nullptr) beyond->assign(balls.size(), std::numeric_limits<double>::infinity());
  if (level >= num_levels()) return Merged({});
  const Level& here = levels_[level];
  std::vector<Eigen::Vector3d> limit(here.vertices.size());
  std::vector<char> known(here.vertices.size(), 0), marked(here.vertices.size(), 0);
  std::vector<double> least(balls.size(), std::numeric_limits<double>::infinity());
  std::vector<int> nearest(balls.size(), -1);
  const auto mark = [&](int triangle) {
    for (const int corner : here.triangles[triangle].corners) marked[corner] = 1;
  };
  for (size_t t = 0; t < here.triangles.size(); ++t) {
    if (!here.triangles[t].is_domain) continue;
    std::array<Eigen::Vector3d, 3> x;
    for (int k = 0; k < 3; ++k) {
      const int v = here.triangles[t].corners[k];
      if (!known[v]) limit[v] = LimitPoint(level, v);
      known[v] = 1;
      x[k] = limit[v];
    }
    for (size_t i = 0; i < balls.size(); ++i) {
      const double distance = DistanceToTriangle(balls[i].center, x);
      if (distance <= balls[i].radius) mark(static_cast<int>(t));
      if (!(distance < least[i])) continue;
      least[i] = distance;
      nearest[i] = static_cast<int>(t);
      if (beyond == nullptr) continue;
      double longest = 0.0;
      for (int k = 0; k < 3; ++k) longest = std::max(longest, (x[k] - x[(k + 1) % 3]).norm());
      (*beyond)[i] = distance - balls[i].radius - longest;
    }
  }
  for (const int t : nearest) {
    if (t >= 0) mark(t);
  }
  for (size_t v = 0; v < marked.size(); ++v) {
    if (marked[v]) AddSupport(level, static_cast<int>(v), &more);
  }
  return Merged(std::move(more));
}

Eigen::Matrix3Xd HierarchicalMesh::Prolong(const Eigen::Matrix3Xd& values,
                                           const HierarchicalMesh& finer) const {
  CHECK_EQ(values.cols(), mesh_.mesh.num_vertices);
  CHECK(finer.refinement_.Contains(refinement_));
  Eigen::Matrix3Xd result = Eigen::Matrix3Xd::Zero(3, finer.mesh_.mesh.num_vertices);
  std::vector<int> mine, below_mine;  // vertices of a level of `finer` -> of this, -1: none
  Eigen::Matrix3Xd field, below;      // their values
  for (int l = 0; l < finer.num_levels(); ++l) {
    const std::vector<Vertex>& vertices = finer.levels_[l].vertices;
    below_mine.swap(mine);
    below.swap(field);
    mine.assign(vertices.size(), -1);
    field.setZero(3, vertices.size());
    for (size_t v = 0; v < vertices.size(); ++v) {
      if (l == 0) {
        mine[v] = static_cast<int>(v);
      } else if (l < num_levels()) {
        const int a = below_mine[vertices[v].a], b = below_mine[vertices[v].b];
        if (a >= 0 && b >= 0) {
          mine[v] = a == b ? levels_[l - 1].vertices[a].child : FindEdgeChild(l - 1, a, b);
        }
      }
      const Vertex* const own = mine[v] < 0 ? nullptr : &levels_[l].vertices[mine[v]];
      if (own != nullptr && own->is_candidate) {
        // One that is dropped is nowhere needed.
        if (!own->is_dropped) field.col(v) = values.col(own->number);
      } else {
        finer.ForEachInMask(l, static_cast<int>(v), [&](int vertex, double factor) {
          field.col(v) += factor * below.col(vertex);
        });
      }
      if (vertices[v].number >= 0 && finer.IsUnknown(vertices[v].number)) {
        result.col(vertices[v].number) = field.col(v);
      }
    }
  }
  return result;
}

}  // namespace darboux
