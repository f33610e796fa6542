#include "geometry/mesh_doctor.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>
#include <utility>

#include "geometry/mesh_topology.h"
#include "geometry/triangle_intersection.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using Kind = MeshDefect::Kind;
using Triangles = std::vector<std::array<int, 3>>;

constexpr std::size_t kMaxListed = 8;
constexpr std::size_t kMaxIntersections = 1000;

std::string List(std::size_t n, const std::function<std::string(std::size_t)>& item) {
  std::string text;
  for (std::size_t i = 0; i < std::min(n, kMaxListed); ++i) text += (i > 0 ? ", " : "") + item(i);
  return n <= kMaxListed ? text : text + ", ... and " + std::to_string(n - kMaxListed) + " more";
}

// "1 hole" or "3 holes".
std::string Count(std::size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

// Sets of points, each within a distance of the first of its set or of one that was there before.
class PointClusters {
 public:
  PointClusters(const std::vector<Vector3d>& points, const std::vector<int>& which, double distance)
      : sets_(points.size()) {
    const auto cell = [distance](const Vector3d& x) -> Cell {
      return {static_cast<std::int64_t>(std::floor(x[0] / distance)),
              static_cast<std::int64_t>(std::floor(x[1] / distance)),
              static_cast<std::int64_t>(std::floor(x[2] / distance))};
    };
    // Points that have none near yet. They are more than the distance apart, so only few of them
    // share a cell, however many points there are.
    std::unordered_map<Cell, std::vector<int>, Hash> cells;
    for (const int i : which) {
      const Vector3d& x = points[Index(i)];
      const Cell own = cell(x);
      bool is_known = false;
      for (std::int64_t a = -1; a <= 1; ++a) {
        for (std::int64_t b = -1; b <= 1; ++b) {
          for (std::int64_t c = -1; c <= 1; ++c) {
            const auto found = cells.find({own[0] + a, own[1] + b, own[2] + c});
            if (found == cells.end()) continue;
            for (const int j : found->second) {
              if ((points[Index(j)] - x).norm() > distance) continue;
              sets_.Unite(i, j);
              is_known = true;
            }
          }
        }
      }
      if (!is_known) cells[own].push_back(i);
    }
  }

  int Find(int i) { return sets_.Find(i); }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& cell) const {
      std::uint64_t hash = 0;
      for (const std::int64_t c : cell) {
        hash = (hash ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
      }
      return static_cast<std::size_t>(hash);
    }
  };

  DisjointSets sets_;
};

class Doctor {
 public:
  Doctor(const TriangleMesh& mesh, const MeshDoctorOptions& options)
      : mesh_(mesh), options_(options) {}

  std::vector<MeshDefect> Run() {
    if (mesh_.triangles.empty()) Add(Kind::kNoTriangles, {}, {}, "no triangles");
    FindNonFinite();
    FindSoundTriangles();
    Normalise();
    FindDegenerate();
    std::vector<int> repeats;
    DropRepeats(&repeats);
    std::vector<int> seams;
    if (!options_.allow_seams) seams = SewSeams();
    if (!seams.empty()) DropRepeats(&repeats);
    AddRepeats(repeats);
    AddSeams(seams);
    const EdgeTable edges(sewn_.triangles);
    FindNonManifoldEdges(edges);
    FindMisorientation(edges);
    FindNonManifoldVertices(edges);
    FindLowValence(edges);
    FindIsolated();
    FindComponents();
    if (options_.closed) FindHoles();
    if (options_.check_self_intersections) FindSelfIntersections();
    return std::move(defects_);
  }

 private:
  void Add(Kind kind, std::vector<int> vertices, std::vector<int> triangles, std::string text) {
    defects_.push_back({kind, std::move(vertices), std::move(triangles), std::move(text)});
  }

  bool IsFinite(int vertex) const { return mesh_.vertices[Index(vertex)].allFinite(); }
  bool IsFinite(const std::array<int, 3>& t) const {
    return IsFinite(t[0]) && IsFinite(t[1]) && IsFinite(t[2]);
  }

  void FindNonFinite() {
    std::vector<int> vertices;
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      if (!mesh_.vertices[v].allFinite()) vertices.push_back(static_cast<int>(v));
    }
    if (vertices.empty()) return;
    const std::string text = Count(vertices.size(), "vertex", "vertices") +
                             " not finite (nan or inf): " + ListIds(vertices);
    Add(Kind::kNonFiniteVertex, vertices, {}, text);
  }

  // Fills sewn_ with the triangles that have three different vertices; nothing is sewn yet.
  void FindSoundTriangles() {
    const int n = static_cast<int>(mesh_.vertices.size());
    std::vector<int> outside;
    is_used_.assign(mesh_.vertices.size(), 0);
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const std::array<int, 3>& t = mesh_.triangles[i];
      const auto [low, high] = std::minmax_element(t.begin(), t.end());
      for (const int v : t) {
        if (v >= 0 && v < n) is_used_[Index(v)] = 1;
      }
      if (*low < 0 || *high >= n) {
        outside.push_back(static_cast<int>(i));
      } else if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        degenerate_.push_back(static_cast<int>(i));
      } else {
        sewn_.triangles.push_back(t);
        numbers_.push_back(static_cast<int>(i));
      }
    }
    if (outside.empty()) return;
    const std::string text = Count(outside.size(), "triangle", "triangles") +
                             " with vertices that do not exist (there are " + std::to_string(n) +
                             ", from 0): " + ListIds(outside);
    Add(Kind::kIndexOutOfRange, {}, outside, text);
  }

  // Moves the mesh to the origin and makes its diagonal 1, so that lengths below are fractions.
  void Normalise() {
    double largest = 0.0;  // First, so that nothing overflows.
    for (const std::array<int, 3>& t : sewn_.triangles) {
      for (const int v : t) {
        if (IsFinite(v))
          largest = std::max(largest, mesh_.vertices[Index(v)].cwiseAbs().maxCoeff());
      }
    }
    if (largest == 0.0) largest = 1.0;
    sewn_.vertices.resize(mesh_.vertices.size());
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      sewn_.vertices[v] = mesh_.vertices[v] / largest;
    }
    Eigen::AlignedBox3d box;
    for (const std::array<int, 3>& t : sewn_.triangles) {
      for (const int v : t) {
        if (IsFinite(v)) box.extend(sewn_.vertices[Index(v)]);
      }
    }
    if (box.isEmpty()) return;
    const Vector3d center = box.center();
    const double diagonal = box.diagonal().norm() > 0.0 ? box.diagonal().norm() : 1.0;
    for (Vector3d& x : sewn_.vertices) x = (x - center) / diagonal;
  }

  void FindDegenerate() {
    has_no_area_.assign(mesh_.triangles.size(), 0);
    for (std::size_t i = 0; i < sewn_.triangles.size(); ++i) {
      const std::array<int, 3>& t = sewn_.triangles[i];
      if (!IsFinite(t)) continue;
      const Vector3d a = sewn_.vertices[Index(t[1])] - sewn_.vertices[Index(t[0])];
      const Vector3d b = sewn_.vertices[Index(t[2])] - sewn_.vertices[Index(t[0])];
      const double area = 0.5 * a.cross(b).norm();
      const double longest = std::max({a.norm(), b.norm(), (b - a).norm()});
      if (area > options_.min_area && 2.0 * area > options_.tolerance * longest) continue;
      has_no_area_[Index(numbers_[i])] = 1;
      degenerate_.push_back(numbers_[i]);
    }
    if (degenerate_.empty()) return;
    std::sort(degenerate_.begin(), degenerate_.end());
    const std::string text = Count(degenerate_.size(), "triangle", "triangles") +
                             " without area: " + ListIds(degenerate_);
    Add(Kind::kDegenerateTriangle, {}, degenerate_, text);
  }

  // Takes triangles with the same vertices as an earlier one, or (after sewing) a vertex twice, out
  // of sewn_ and appends them and the earlier one to `repeats`.
  void DropRepeats(std::vector<int>* repeats) {
    std::vector<std::pair<std::array<int, 3>, int>> sorted;
    for (std::size_t i = 0; i < sewn_.triangles.size(); ++i) {
      std::array<int, 3> t = sewn_.triangles[i];
      std::sort(t.begin(), t.end());
      sorted.emplace_back(t, static_cast<int>(i));
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<char> drop(sewn_.triangles.size(), 0);
    std::size_t first = 0;  // Of those with the same vertices.
    for (std::size_t k = 0; k < sorted.size(); ++k) {
      const std::array<int, 3>& t = sorted[k].first;
      if (t != sorted[first].first) first = k;
      if (k != first) {
        repeats->push_back(numbers_[Index(sorted[k].second)]);
        repeats->push_back(numbers_[Index(sorted[first].second)]);
      }
      drop[Index(sorted[k].second)] = k != first || t[0] == t[1] || t[1] == t[2];
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sewn_.triangles.size(); ++i) {
      if (drop[i] != 0) continue;
      sewn_.triangles[kept] = sewn_.triangles[i];
      numbers_[kept++] = numbers_[i];
    }
    sewn_.triangles.resize(kept);
    numbers_.resize(kept);
  }

  void AddRepeats(const std::vector<int>& repeats) {
    if (repeats.empty()) return;
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t k = 0; k < repeats.size(); k += 2)
      pairs.emplace_back(repeats[k], repeats[k + 1]);
    std::sort(pairs.begin(), pairs.end());
    std::vector<int> triangles;
    for (const std::pair<int, int>& pair : pairs) triangles.push_back(pair.first);
    const std::string text = Count(pairs.size(), "triangle that repeats", "triangles that repeat") +
                             (pairs.size() == 1 ? " another: " : " others: ") +
                             List(pairs.size(), [&](std::size_t i) {
                               return std::to_string(pairs[i].first) + " (same vertices as " +
                                      std::to_string(pairs[i].second) + ")";
                             });
    Add(Kind::kDuplicateTriangle, {}, triangles, text);
  }

  // Where two edges of the boundary coincide their ends become one vertex. Returns pairs: a vertex
  // and the lower one that it is sewn to.
  std::vector<int> SewSeams() {
    const EdgeTable edges(sewn_.triangles);
    std::vector<int> rim;  // Vertices of the boundary.
    std::vector<std::array<int, 2>> boundary;
    for (const EdgeTable::Edge& edge : edges.edges()) {
      if (edge.count != 1 || !IsFinite(edge.vertices[0]) || !IsFinite(edge.vertices[1])) continue;
      boundary.push_back(edge.vertices);
      rim.insert(rim.end(), edge.vertices.begin(), edge.vertices.end());
    }
    std::sort(rim.begin(), rim.end());
    rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
    PointClusters clusters(sewn_.vertices, rim, options_.tolerance);
    std::map<std::array<int, 2>, std::array<int, 2>> seen;  // Clusters at the ends -> first edge.
    DisjointSets sewn(mesh_.vertices.size());
    for (std::array<int, 2> edge : boundary) {
      std::array<int, 2> ends = {clusters.Find(edge[0]), clusters.Find(edge[1])};
      if (ends[0] == ends[1]) continue;
      if (ends[0] > ends[1]) {
        std::swap(ends[0], ends[1]);
        std::swap(edge[0], edge[1]);
      }
      const auto [other, is_first] = seen.emplace(ends, edge);
      if (is_first) continue;
      sewn.Unite(edge[0], other->second[0]);
      sewn.Unite(edge[1], other->second[1]);
    }
    std::vector<int> pairs;
    for (const int v : rim) {
      if (sewn.Find(v) == v) continue;
      pairs.push_back(v);
      pairs.push_back(sewn.Find(v));
    }
    for (std::array<int, 3>& t : sewn_.triangles) {
      for (int& v : t) v = sewn.Find(v);
    }
    return pairs;
  }

  void AddSeams(const std::vector<int>& pairs) {
    if (pairs.empty()) return;
    const std::string text =
        Count(pairs.size() / 2,
              "vertex that coincides with another and leaves",
              "vertices that coincide with others and leave") +
        " a seam open: " + List(pairs.size() / 2, [&](std::size_t i) {
          return std::to_string(pairs[2 * i]) + " (at " + std::to_string(pairs[2 * i + 1]) + ")";
        });
    Add(Kind::kOpenSeam, pairs, {}, text);
  }

  void FindNonManifoldEdges(const EdgeTable& edges) {
    std::vector<const EdgeTable::Edge*> bad;
    std::vector<int> vertices, triangles;
    const auto triangles_at = [&](const EdgeTable::Edge& edge) {
      std::vector<int> at;
      for (int k = 0; k < edge.count; ++k) {
        at.push_back(numbers_[Index(edges.sides()[Index(edge.first + k)].triangle)]);
      }
      return at;
    };
    for (const EdgeTable::Edge& edge : edges.edges()) {
      if (edge.count < 3) continue;
      bad.push_back(&edge);
      vertices.insert(vertices.end(), edge.vertices.begin(), edge.vertices.end());
      const std::vector<int> at = triangles_at(edge);
      triangles.insert(triangles.end(), at.begin(), at.end());
    }
    if (bad.empty()) return;
    const std::string text =
        Count(bad.size(), "edge", "edges") +
        " with more than two triangles: " + List(bad.size(), [&](std::size_t i) {
          return std::to_string(bad[i]->vertices[0]) + "-" + std::to_string(bad[i]->vertices[1]) +
                 " (triangles " + ListIds(triangles_at(*bad[i])) + ")";
        });
    Add(Kind::kNonManifoldEdge, vertices, triangles, text);
  }

  // Six times the signed volume under a triangle, seen from the origin.
  double Volume(std::size_t t) const {
    const std::array<int, 3>& corner = sewn_.triangles[t];
    return sewn_.vertices[Index(corner[0])].dot(
        sewn_.vertices[Index(corner[1])].cross(sewn_.vertices[Index(corner[2])]));
  }

  void FindMisorientation(const EdgeTable& edges) {
    const Orientation orientation = CompareWindings(sewn_.triangles, edges);
    struct Patch {
      std::vector<std::size_t> triangles;
      double volume = 0.0;  // With the first triangle's winding, times 6.
      double size = 0.0;    // Sum of absolute values.
      bool is_closed = true;
      bool is_orientable = true;
    };
    std::vector<Patch> patches(Index(orientation.num_patches));
    for (std::size_t t = 0; t < sewn_.triangles.size(); ++t) {
      Patch& patch = patches[Index(orientation.patch[t])];
      patch.triangles.push_back(t);
      patch.volume += orientation.is_against[t] != 0 ? -Volume(t) : Volume(t);
      patch.size += std::abs(Volume(t));
      for (int c = 0; c < 3; ++c) {
        if (edges.Across(static_cast<int>(t), c) == nullptr) patch.is_closed = false;
      }
    }
    std::vector<int> on_either_side;
    for (const int e : orientation.contradictory_edges) {
      const EdgeTable::Edge& edge = edges.edges()[Index(e)];
      for (int k = 0; k < edge.count; ++k) {
        const int t = edges.sides()[Index(edge.first + k)].triangle;
        on_either_side.push_back(numbers_[Index(t)]);
        patches[Index(orientation.patch[Index(t)])].is_orientable = false;
      }
    }
    std::vector<int> flipped, inside_out;
    std::vector<const Patch*> inside_out_patches;
    for (const Patch& patch : patches) {
      if (!patch.is_orientable) continue;
      std::vector<int> with, against;
      for (const std::size_t t : patch.triangles) {
        (orientation.is_against[t] != 0 ? against : with).push_back(numbers_[t]);
      }
      // Outwards is right where there is an outside, the majority elsewhere.
      const bool has_inside = patch.is_closed && std::abs(patch.volume) > 1e-9 * patch.size;
      if (has_inside ? patch.volume < 0.0 : with.size() < against.size()) std::swap(with, against);
      if (with.empty()) {
        inside_out.insert(inside_out.end(), against.begin(), against.end());
        inside_out_patches.push_back(&patch);
      } else {
        flipped.insert(flipped.end(), against.begin(), against.end());
      }
    }
    if (!on_either_side.empty()) {
      const std::size_t n = orientation.contradictory_edges.size();
      const std::string text =
          "a surface with one side only, like a Moebius strip; whatever way triangles are wound, "
          "some disagree, here across " +
          Count(n, "edge", "edges") + ": " + List(n, [&](std::size_t i) {
            const EdgeTable::Edge& edge = edges.edges()[Index(orientation.contradictory_edges[i])];
            return std::to_string(edge.vertices[0]) + "-" + std::to_string(edge.vertices[1]);
          });
      std::sort(on_either_side.begin(), on_either_side.end());
      on_either_side.erase(std::unique(on_either_side.begin(), on_either_side.end()),
                           on_either_side.end());
      Add(Kind::kNonOrientable, {}, on_either_side, text);
    }
    if (!flipped.empty()) {
      std::sort(flipped.begin(), flipped.end());
      const std::string text = Count(flipped.size(), "triangle", "triangles") +
                               " wound against the others: " + ListIds(flipped);
      Add(Kind::kFlippedTriangle, {}, flipped, text);
    }
    if (!inside_out.empty()) {
      std::sort(inside_out.begin(), inside_out.end());
      const std::string text = Count(inside_out_patches.size(), "closed piece", "closed pieces") +
                               " inside out, with normals that point inwards: " +
                               List(inside_out_patches.size(), [&](std::size_t i) {
                                 const std::vector<std::size_t>& t =
                                     inside_out_patches[i]->triangles;
                                 return Count(t.size(), "triangle", "triangles") +
                                        " from triangle " + std::to_string(numbers_[t[0]]);
                               });
      Add(Kind::kInsideOut, {}, inside_out, text);
    }
  }

  void FindNonManifoldVertices(const EdgeTable& edges) {
    DisjointSets fans = VertexFans(sewn_.triangles, edges);
    std::vector<int> fan_of(mesh_.vertices.size(), -1);
    std::vector<int> vertices;
    for (std::size_t t = 0; t < sewn_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int vertex = sewn_.triangles[t][k];
        const int fan = fans.Find(static_cast<int>(3 * t + k));
        if (fan_of[Index(vertex)] < 0) fan_of[Index(vertex)] = fan;
        if (fan_of[Index(vertex)] != fan) vertices.push_back(vertex);
      }
    }
    if (vertices.empty()) return;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const std::string text =
        Count(vertices.size(), "vertex", "vertices") +
        " where several fans of triangles meet in a point: " + ListIds(vertices);
    Add(Kind::kNonManifoldVertex, vertices, {}, text);
  }

  // Of the boundary only: an inner vertex has three edges at least, unless two triangles lie back
  // to back, and then one of them repeats the other.
  void FindLowValence(const EdgeTable& edges) {
    std::vector<int> valence(mesh_.vertices.size(), 0);
    std::vector<char> is_on_boundary(mesh_.vertices.size(), 0);
    for (const EdgeTable::Edge& edge : edges.edges()) {
      for (const int v : edge.vertices) {
        ++valence[Index(v)];
        if (edge.count == 1) is_on_boundary[Index(v)] = 1;
      }
    }
    std::vector<int> vertices;
    for (std::size_t v = 0; v < valence.size(); ++v) {
      if (is_on_boundary[v] != 0 && valence[v] < options_.min_boundary_valence) {
        vertices.push_back(static_cast<int>(v));
      }
    }
    if (vertices.empty()) return;
    const std::string text =
        Count(vertices.size(), "vertex", "vertices") + " of the boundary with less than " +
        std::to_string(options_.min_boundary_valence) + " edges: " + ListIds(vertices);
    Add(Kind::kLowValence, vertices, {}, text);
  }

  void FindIsolated() {
    std::vector<int> vertices;
    for (std::size_t v = 0; v < is_used_.size(); ++v) {
      if (is_used_[v] == 0) vertices.push_back(static_cast<int>(v));
    }
    if (vertices.empty()) return;
    const std::string text = Count(vertices.size(), "vertex", "vertices") +
                             " that no triangle uses: " + ListIds(vertices);
    Add(Kind::kIsolatedVertex, vertices, {}, text);
  }

  void FindComponents() {
    const std::vector<MeshComponent> components = MeshComponents(sewn_);
    if (components.size() <= Index(options_.max_components)) return;
    std::vector<int> triangles;
    for (const MeshComponent& c : components) triangles.push_back(numbers_[Index(c.triangles[0])]);
    const std::string text =
        std::to_string(components.size()) + " separate pieces instead of " +
        (options_.max_components > 1 ? "at most " : "") + std::to_string(options_.max_components) +
        ": " + List(components.size(), [&](std::size_t i) {
          return Count(components[i].triangles.size(), "triangle", "triangles") +
                 " from triangle " + std::to_string(triangles[i]);
        });
    Add(Kind::kSeveralComponents, {}, triangles, text);
  }

  void FindHoles() {
    const std::vector<std::vector<int>> loops = BoundaryLoops(sewn_);
    if (loops.empty()) return;
    std::vector<int> vertices;
    for (const std::vector<int>& l : loops) vertices.insert(vertices.end(), l.begin(), l.end());
    const std::string text =
        Count(loops.size(), "hole", "holes") + " in a mesh that has to be closed: " +
        (loops.size() == 1
             ? std::to_string(loops[0].size()) + " edges along vertices " + ListIds(loops[0])
             : List(loops.size(), [&](std::size_t i) {
                 return std::to_string(loops[i].size()) + " edges from vertex " +
                        std::to_string(loops[i][0]);
               }));
    Add(Kind::kHole, vertices, {}, text);
  }

  void FindSelfIntersections() {
    Triangles triangles;
    std::vector<int> numbers;
    for (std::size_t i = 0; i < sewn_.triangles.size(); ++i) {
      if (has_no_area_[Index(numbers_[i])] != 0 || !IsFinite(sewn_.triangles[i])) continue;
      triangles.push_back(sewn_.triangles[i]);
      numbers.push_back(numbers_[i]);
    }
    const std::vector<std::array<int, 2>> pairs =
        IntersectingTriangles(sewn_.vertices, triangles, options_.tolerance, kMaxIntersections);
    if (pairs.empty()) return;
    std::vector<int> flat;
    for (const std::array<int, 2>& pair : pairs) {
      for (const int t : pair) flat.push_back(numbers[Index(t)]);
    }
    const std::string text =
        (pairs.size() == kMaxIntersections ? "at least " : "") +
        Count(pairs.size(), "pair", "pairs") +
        " of triangles that pass through each other or lie on each other: " +
        List(pairs.size(), [&](std::size_t i) {
          return std::to_string(flat[2 * i]) + " and " + std::to_string(flat[2 * i + 1]);
        });
    Add(Kind::kSelfIntersection, {}, flat, text);
  }

  const TriangleMesh& mesh_;
  const MeshDoctorOptions& options_;
  std::vector<MeshDefect> defects_;
  std::vector<char> is_used_;      // Vertices.
  std::vector<int> degenerate_;    // Triangles of the mesh.
  std::vector<char> has_no_area_;  // Triangles of the mesh.
  // Scaled, without unsound triangles and repeats, its seams sewn with the lower vertex of each
  // pair; has all vertices under their numbers.
  TriangleMesh sewn_;
  std::vector<int> numbers_;  // Of sewn_'s triangles in the mesh.
};

}  // namespace

std::string Name(Kind kind) {
  switch (kind) {
    case Kind::kNoTriangles:
      return "no triangles";
    case Kind::kNonFiniteVertex:
      return "non-finite vertex";
    case Kind::kIndexOutOfRange:
      return "index out of range";
    case Kind::kDegenerateTriangle:
      return "degenerate triangle";
    case Kind::kDuplicateTriangle:
      return "duplicate triangle";
    case Kind::kOpenSeam:
      return "open seam";
    case Kind::kNonManifoldEdge:
      return "non-manifold edge";
    case Kind::kNonOrientable:
      return "non-orientable surface";
    case Kind::kFlippedTriangle:
      return "flipped triangle";
    case Kind::kInsideOut:
      return "inside out";
    case Kind::kNonManifoldVertex:
      return "non-manifold vertex";
    case Kind::kLowValence:
      return "low valence";
    case Kind::kIsolatedVertex:
      return "isolated vertex";
    case Kind::kSeveralComponents:
      return "several components";
    case Kind::kHole:
      return "hole";
    case Kind::kSelfIntersection:
      return "self-intersection";
  }
  LOG(FATAL) << "Not a MeshDefect::Kind: " << static_cast<int>(kind);
  return "";
}

std::string ListIds(const std::vector<int>& ids) {
  return List(ids.size(), [&](std::size_t i) { return std::to_string(ids[i]); });
}

std::vector<MeshDefect> FindMeshDefects(const TriangleMesh& mesh,
                                        const MeshDoctorOptions& options) {
  CHECK_GE(options.max_components, 1);
  CHECK_GE(options.min_boundary_valence, 2);
  CHECK(options.tolerance >= 1e-15 && options.tolerance <= 1e-3) << options.tolerance;
  CHECK_GE(options.min_area, 0.0);
  return Doctor(mesh, options).Run();
}

}  // namespace darboux
