#include "geometry/mesh_repair.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "geometry/mesh_topology.h"
#include "geometry/polygon_triangulation.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using Kind = MeshDefect::Kind;

// Mending one thing may bring another to light; more rounds than this are going in circles.
constexpr int kMaxRounds = 20;

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

std::string Count(std::size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

class Mender {
 public:
  Mender(TriangleMesh* mesh, const MeshDoctorOptions& options, int max_hole_edges)
      : mesh_(*mesh), options_(options), closed_(options.closed), max_hole_edges_(max_hole_edges) {
    options_.closed = false;
    options_.check_self_intersections = false;  // Nothing here depends on them.
  }

  std::vector<std::string> Run() {
    MendInRounds();
    if (max_hole_edges_ > 0 && FillHoles()) MendInRounds();  // Now there may be an outside.
    DropUnusedVertices();
    return std::move(mended_);
  }

 private:
  void MendInRounds() {
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!MendOnce()) return;
    }
  }

  // One pass over what the doctor finds. Triangles keep their numbers until its end.
  bool MendOnce() {
    const std::vector<MeshDefect> defects = FindMeshDefects(mesh_, options_);
    const std::size_t lines_before = mended_.size();
    drop_.assign(mesh_.triangles.size(), 0);
    std::vector<int> degenerate;
    for (const MeshDefect& defect : defects) {
      switch (defect.kind) {
        case Kind::kFlippedTriangle:
        case Kind::kInsideOut:
          for (const int t : defect.triangles) {
            std::swap(mesh_.triangles[Index(t)][1], mesh_.triangles[Index(t)][2]);
          }
          mended_.push_back("turned over " + defect.text);
          break;
        case Kind::kOpenSeam:
          Sew(defect.vertices);
          mended_.push_back("sewed " + defect.text);
          break;
        case Kind::kIndexOutOfRange:
        case Kind::kDuplicateTriangle:
          for (const int t : defect.triangles) drop_[Index(t)] = 1;
          mended_.push_back("dropped " + defect.text);
          break;
        case Kind::kNonFiniteVertex:
          DropAt(defect.vertices);
          break;
        case Kind::kDegenerateTriangle:
          degenerate = defect.triangles;
          break;
        default:
          break;
      }
    }
    if (!degenerate.empty()) Flatten(degenerate);
    DropTriangles();
    return mended_.size() > lines_before;
  }

  void Sew(const std::vector<int>& pairs) {
    std::vector<int> target(mesh_.vertices.size());
    std::iota(target.begin(), target.end(), 0);
    for (std::size_t k = 0; k < pairs.size(); k += 2) target[Index(pairs[k])] = pairs[k + 1];
    for (std::array<int, 3>& t : mesh_.triangles) {
      for (int& v : t) {
        if (v >= 0 && v < static_cast<int>(target.size())) v = target[Index(v)];
      }
    }
  }

  void DropAt(const std::vector<int>& vertices) {
    const std::set<int> bad(vertices.begin(), vertices.end());
    std::vector<int> dropped;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const std::array<int, 3>& t = mesh_.triangles[i];
      if (bad.count(t[0]) + bad.count(t[1]) + bad.count(t[2]) == 0) continue;
      drop_[i] = 1;
      dropped.push_back(static_cast<int>(i));
    }
    if (dropped.empty()) return;
    mended_.push_back("dropped " + Count(dropped.size(), "triangle", "triangles") +
                      " with vertices that are not finite: " + ListIds(dropped));
  }

  static bool HasRepeats(const std::array<int, 3>& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  }

  // Triangles without area. Those next to one that is mended wait for the next round.
  void Flatten(const std::vector<int>& degenerate) {
    std::vector<int> dropped, shrunk, cut;
    std::vector<std::array<int, 3>> sound;
    std::vector<int> number;                                  // Of sound triangles in the mesh.
    std::vector<int> place(mesh_.triangles.size(), -1);       // And back.
    std::vector<std::vector<int>> at(mesh_.vertices.size());  // Sound triangles at vertices.
    for (const int t : degenerate) {
      if (drop_[Index(t)] != 0 || !HasRepeats(mesh_.triangles[Index(t)])) continue;
      drop_[Index(t)] = 1;
      dropped.push_back(t);
    }
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (drop_[i] != 0 || HasRepeats(mesh_.triangles[i])) continue;
      place[i] = static_cast<int>(sound.size());
      for (const int v : mesh_.triangles[i]) at[Index(v)].push_back(static_cast<int>(i));
      sound.push_back(mesh_.triangles[i]);
      number.push_back(static_cast<int>(i));
    }
    const EdgeTable edges(sound);
    const double tolerance = options_.tolerance * Diagonal();
    std::vector<char> is_touched(mesh_.vertices.size(), 0);
    const auto touch = [&](int vertex) {
      for (const int t : at[Index(vertex)]) {
        for (const int v : mesh_.triangles[Index(t)]) is_touched[Index(v)] = 1;
      }
    };
    for (const int t : degenerate) {
      if (place[Index(t)] < 0) continue;
      const std::array<int, 3> corner = mesh_.triangles[Index(t)];
      if (is_touched[Index(corner[0])] + is_touched[Index(corner[1])] +
              is_touched[Index(corner[2])] >
          0) {
        continue;
      }
      std::array<double, 3> length{};
      for (std::size_t k = 0; k < 3; ++k) {
        length[k] = (mesh_.vertices[Index(corner[(k + 1) % 3])] - mesh_.vertices[Index(corner[k])])
                        .stableNorm();
      }
      const std::size_t shortest =
          static_cast<std::size_t>(std::min_element(length.begin(), length.end()) - length.begin());
      if (length[shortest] <= tolerance) {
        const int keep = std::min(corner[shortest], corner[(shortest + 1) % 3]);
        const int lose = std::max(corner[shortest], corner[(shortest + 1) % 3]);
        if (!CanShrink(edges, place[Index(t)], static_cast<int>(shortest), at)) continue;
        touch(keep);
        touch(lose);
        for (const int u : at[Index(lose)]) {
          std::array<int, 3>& moved = mesh_.triangles[Index(u)];
          std::replace(moved.begin(), moved.end(), lose, keep);
          if (HasRepeats(moved)) drop_[Index(u)] = 1;
        }
        shrunk.push_back(t);
        continue;
      }
      const std::size_t longest =
          static_cast<std::size_t>(std::max_element(length.begin(), length.end()) - length.begin());
      const int side = static_cast<int>(longest);
      const int count = edges.edges()[Index(edges.EdgeOf(place[Index(t)], side))].count;
      if (count == 1) {  // On the boundary nothing holds it.
        for (const int v : corner) touch(v);
        drop_[Index(t)] = 1;
        dropped.push_back(t);
        continue;
      }
      const EdgeTable::Side* const across = edges.Across(place[Index(t)], side);
      if (across == nullptr) continue;
      const std::size_t other = Index(number[Index(across->triangle)]);
      const int p = corner[longest], q = corner[(longest + 1) % 3], r = corner[(longest + 2) % 3];
      const std::array<int, 3> neighbour = mesh_.triangles[other];
      const int d = neighbour[Index((across->corner + 2) % 3)];
      const bool is_wound_alike = neighbour[Index(across->corner)] == q;
      if (!is_wound_alike || is_touched[Index(d)] != 0 || edges.HasEdge(r, d)) continue;
      for (const int v : {p, q, r, d}) touch(v);
      mesh_.triangles[Index(t)] = {r, p, d};
      mesh_.triangles[other] = {d, q, r};
      cut.push_back(t);
    }
    std::sort(dropped.begin(), dropped.end());
    const auto report = [&](const std::vector<int>& which, const std::string& done) {
      if (which.empty()) return;
      mended_.push_back(done + Count(which.size(), "triangle", "triangles") +
                        " without area: " + ListIds(which));
    };
    report(dropped, "dropped ");
    report(shrunk, "shrunk to a point ");
    report(cut, "merged with neighbours ");
  }

  // Whether the surface stays one when a side shrinks to a point: its ends have no common
  // neighbours but the third corners of the triangles there (link condition).
  bool CanShrink(const EdgeTable& edges,
                 int triangle,
                 int side,
                 const std::vector<std::vector<int>>& at) const {
    const EdgeTable::Edge& edge = edges.edges()[Index(edges.EdgeOf(triangle, side))];
    if (edge.count > 2) return false;
    std::array<std::set<int>, 2> near;
    for (std::size_t k = 0; k < 2; ++k) {
      for (const int t : at[Index(edge.vertices[k])]) {
        near[k].insert(mesh_.triangles[Index(t)].begin(), mesh_.triangles[Index(t)].end());
      }
      near[k].erase(edge.vertices[0]);
      near[k].erase(edge.vertices[1]);
    }
    int num_common = 0;
    for (const int v : near[0]) num_common += static_cast<int>(near[1].count(v));
    return num_common == edge.count;
  }

  double Diagonal() const {
    Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
    bool is_first = true;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (drop_[i] != 0) continue;
      for (const int v : mesh_.triangles[i]) {
        const Vector3d& x = mesh_.vertices[Index(v)];
        low = is_first ? x : Vector3d(low.cwiseMin(x));
        high = is_first ? x : Vector3d(high.cwiseMax(x));
        is_first = false;
      }
    }
    return (high - low).stableNorm();
  }

  void DropTriangles() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (drop_[i] == 0) mesh_.triangles[kept++] = mesh_.triangles[i];
    }
    mesh_.triangles.resize(kept);
  }

  double LengthOf(const std::vector<int>& loop) const {
    double length = 0.0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      length +=
          (mesh_.vertices[Index(loop[(k + 1) % loop.size()])] - mesh_.vertices[Index(loop[k])])
              .stableNorm();
    }
    return length;
  }

  bool FillHoles() {
    std::vector<std::vector<int>> loops = BoundaryLoops(mesh_);
    if (!closed_) RemoveRims(&loops);
    const EdgeTable edges(mesh_.triangles);
    std::vector<std::string> filled;
    std::set<std::array<int, 2>> added;  // Edges across holes.
    for (const std::vector<int>& loop : loops) {
      if (loop.size() < 3 || Index(max_hole_edges_) < loop.size()) continue;
      std::vector<int> hole(loop.rbegin(), loop.rend());  // Seen from the hole.
      if (!Fill(hole, edges, &added)) continue;
      filled.push_back(std::to_string(hole.size()) + " edges along vertices " + ListIds(loop));
    }
    if (filled.empty()) return false;
    for (const std::string& text : filled) mended_.push_back("filled a hole of " + text);
    return true;
  }

  // The longest loop of each piece is no hole.
  void RemoveRims(std::vector<std::vector<int>>* loops) const {
    DisjointSets pieces(mesh_.vertices.size());
    for (const std::array<int, 3>& t : mesh_.triangles) {
      pieces.Unite(t[0], t[1]);
      pieces.Unite(t[1], t[2]);
    }
    std::map<int, std::pair<double, std::size_t>> rims;
    for (std::size_t i = 0; i < loops->size(); ++i) {
      const double length = LengthOf((*loops)[i]);
      const auto [rim, is_first] =
          rims.emplace(pieces.Find((*loops)[i][0]), std::make_pair(length, i));
      if (!is_first && length > rim->second.first) rim->second = {length, i};
    }
    for (const auto& [piece, rim] : rims) (*loops)[rim.second].clear();
  }

  bool Fill(const std::vector<int>& hole,
            const EdgeTable& edges,
            std::set<std::array<int, 2>>* added) {
    const std::size_t n = hole.size();
    if (std::set<int>(hole.begin(), hole.end()).size() < n) return false;  // It touches itself.
    std::vector<Vector3d> corners;
    PolygonSurroundings around;
    std::set<int> opposite;
    double size = 0.0;  // Products of very small or large lengths are no numbers.
    for (const int v : hole) {
      size =
          std::max(size, (mesh_.vertices[Index(v)] - mesh_.vertices[Index(hole[0])]).stableNorm());
    }
    if (!(size > 0.0)) return false;
    const auto scaled = [&](int v) -> Vector3d {
      return (mesh_.vertices[Index(v)] - mesh_.vertices[Index(hole[0])]) / size;
    };
    const auto edge_between = [](int a, int b) -> std::array<int, 2> {
      return {std::min(a, b), std::max(a, b)};
    };
    for (std::size_t k = 0; k < n; ++k) {
      const std::array<int, 2> ends = edge_between(hole[k], hole[(k + 1) % n]);
      const auto edge = std::lower_bound(
          edges.edges().begin(),
          edges.edges().end(),
          ends,
          [](const EdgeTable::Edge& e, const std::array<int, 2>& v) { return e.vertices < v; });
      // Not closed, or broken off at a non-manifold edge.
      if (edge == edges.edges().end() || edge->vertices != ends || edge->count != 1) return false;
      const EdgeTable::Side& side = edges.sides()[Index(edge->first)];
      const int third = mesh_.triangles[Index(side.triangle)][Index((side.corner + 2) % 3)];
      corners.push_back(scaled(hole[k]));
      around.opposite.push_back(scaled(third));
      opposite.insert(side.triangle);
    }
    if (opposite.size() == 1) return false;  // Around a single triangle: its back.
    around.is_forbidden = [&](int i, int k) {
      const std::array<int, 2> ends = edge_between(hole[Index(i)], hole[Index(k)]);
      return edges.HasEdge(ends[0], ends[1]) || added->count(ends) > 0;
    };
    const std::vector<std::array<int, 3>> triangles = TriangulatePolygon(corners, around);
    for (const std::array<int, 3>& t : triangles) {
      const std::array<int, 3> cover = {hole[Index(t[0])], hole[Index(t[1])], hole[Index(t[2])]};
      mesh_.triangles.push_back(cover);
      for (std::size_t k = 0; k < 3; ++k) added->insert(edge_between(cover[k], cover[(k + 1) % 3]));
    }
    return !triangles.empty();
  }

  void DropUnusedVertices() {
    std::vector<int> renumbered(mesh_.vertices.size(), -1);
    for (const std::array<int, 3>& t : mesh_.triangles) {
      for (const int v : t) renumbered[Index(v)] = 0;
    }
    std::vector<int> dropped;
    int kept = 0;
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      if (renumbered[v] < 0) {
        dropped.push_back(static_cast<int>(v));
      } else {
        mesh_.vertices[Index(kept)] = mesh_.vertices[v];
        renumbered[v] = kept++;
      }
    }
    if (dropped.empty()) return;
    mesh_.vertices.resize(Index(kept));
    for (std::array<int, 3>& t : mesh_.triangles) {
      for (int& v : t) v = renumbered[Index(v)];
    }
    mended_.push_back("dropped " + Count(dropped.size(), "vertex", "vertices") +
                      " without triangles and numbered the other " + std::to_string(kept) +
                      " anew: " + ListIds(dropped));
  }

  TriangleMesh& mesh_;
  MeshDoctorOptions options_;
  bool closed_;
  int max_hole_edges_;
  std::vector<std::string> mended_;
  std::vector<char> drop_;  // Triangles.
};

}  // namespace

MeshReport RepairMesh(TriangleMesh* mesh,
                      const MeshDoctorOptions& options,
                      const MeshRepairOptions& repair_options) {
  CHECK(repair_options.max_hole_edges >= 0 && repair_options.max_hole_edges <= 500)
      << repair_options.max_hole_edges;
  MeshReport report;
  report.mended = Mender(mesh, options, repair_options.max_hole_edges).Run();
  report.defects = FindMeshDefects(*mesh, options);
  return report;
}

}  // namespace darboux
