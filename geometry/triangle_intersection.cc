#include "geometry/triangle_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "geometry/mesh_topology.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;

// Boxes around sets of triangles, halved by their middles along the longest side.
class BoxTree {
 public:
  struct Node {
    Box box;
    int first = 0;  // Leaf: its triangles are order()[first] to order()[first + count - 1].
    int count = 0;  // 0: the children are `first` and first + 1.
  };

  explicit BoxTree(const std::vector<Box>& boxes) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (boxes.empty()) return;
    nodes_.emplace_back();
    Build(boxes);
  }

  const std::vector<Node>& nodes() const { return nodes_; }
  int triangle(int i) const { return order_[static_cast<std::size_t>(i)]; }

 private:
  static constexpr int kLeafSize = 4;

  void Build(const std::vector<Box>& boxes) {
    struct Range {
      int node, begin, end;
    };
    std::vector<Range> open = {{0, 0, static_cast<int>(boxes.size())}};
    while (!open.empty()) {
      const Range range = open.back();
      open.pop_back();
      Box box, middles;
      for (int i = range.begin; i < range.end; ++i) {
        const Box& b = boxes[static_cast<std::size_t>(triangle(i))];
        box.extend(b);
        middles.extend(b.center());
      }
      Node& node = nodes_[static_cast<std::size_t>(range.node)];
      node.box = box;
      node.first = range.begin;
      node.count = range.end - range.begin;
      if (node.count <= kLeafSize) continue;
      Eigen::Index axis = 0;
      middles.sizes().maxCoeff(&axis);
      const int half = range.begin + node.count / 2;
      std::nth_element(order_.begin() + range.begin,
                       order_.begin() + half,
                       order_.begin() + range.end,
                       [&](int a, int b) {
                         return boxes[static_cast<std::size_t>(a)].center()[axis] <
                                boxes[static_cast<std::size_t>(b)].center()[axis];
                       });
      const int child = static_cast<int>(nodes_.size());
      node.first = child;
      node.count = 0;
      nodes_.emplace_back();  // `node` is gone.
      nodes_.emplace_back();
      open.push_back({child, range.begin, half});
      open.push_back({child + 1, half, range.end});
    }
  }

  std::vector<int> order_;
  std::vector<Node> nodes_;
};

class Search {
 public:
  Search(const std::vector<Vector3d>& vertices,
         const std::vector<std::array<int, 3>>& triangles,
         double tolerance)
      : vertices_(vertices), triangles_(triangles), tolerance_(tolerance), edges_(triangles) {
    normals_.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Vector3d a = Corner(t, 0), b = Corner(t, 1), c = Corner(t, 2);
      const Vector3d n = (b - a).cross(c - a);
      const double longest =
          std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
      const double norm = n.norm();  // Below, its direction is rounding.
      normals_.push_back(norm > 1e-12 * longest ? Vector3d(n / norm) : Vector3d(Vector3d::Zero()));
    }
  }

  std::vector<std::array<int, 2>> Pairs(std::size_t max_pairs) const {
    std::vector<std::array<int, 2>> pairs;
    std::vector<Box> boxes(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) boxes[t].extend(Corner(t, k));
      boxes[t].min().array() -= tolerance_;
      boxes[t].max().array() += tolerance_;
    }
    const BoxTree tree(boxes);
    if (tree.nodes().empty()) return pairs;
    std::vector<std::pair<int, int>> open = {{0, 0}};
    while (!open.empty() && pairs.size() < max_pairs) {
      const auto [i, j] = open.back();
      open.pop_back();
      const BoxTree::Node& a = tree.nodes()[static_cast<std::size_t>(i)];
      const BoxTree::Node& b = tree.nodes()[static_cast<std::size_t>(j)];
      if (i != j && !a.box.intersects(b.box)) continue;
      if (a.count > 0 && b.count > 0) {
        for (int k = 0; k < a.count; ++k) {
          for (int l = i == j ? k + 1 : 0; l < b.count; ++l) {
            const int s = tree.triangle(a.first + k), t = tree.triangle(b.first + l);
            const std::array<int, 2> pair = {std::min(s, t), std::max(s, t)};
            if (pairs.size() < max_pairs && Intersect(pair, boxes)) pairs.push_back(pair);
          }
        }
      } else if (i == j) {
        open.emplace_back(a.first, a.first);
        open.emplace_back(a.first, a.first + 1);
        open.emplace_back(a.first + 1, a.first + 1);
      } else if (a.count == 0 && (b.count > 0 || a.box.volume() >= b.box.volume())) {
        open.emplace_back(a.first, j);
        open.emplace_back(a.first + 1, j);
      } else {
        open.emplace_back(i, b.first);
        open.emplace_back(i, b.first + 1);
      }
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

 private:
  using Distances = std::array<double, 3>;

  const Vector3d& Corner(std::size_t t, std::size_t k) const {
    return vertices_[static_cast<std::size_t>(triangles_[t][k])];
  }
  bool HasVertex(std::size_t t, int vertex) const {
    return std::find(triangles_[t].begin(), triangles_[t].end(), vertex) != triangles_[t].end();
  }

  // Of a vertex to the plane of triangle t; zero within the tolerance.
  double Distance(std::size_t t, int vertex) const {
    if (HasVertex(t, vertex)) return 0.0;
    const double d = normals_[t].dot(vertices_[static_cast<std::size_t>(vertex)] - Corner(t, 0));
    return std::abs(d) <= tolerance_ ? 0.0 : d;
  }
  Distances DistancesTo(std::size_t t, std::size_t other) const {
    Distances d{};
    for (std::size_t k = 0; k < 3; ++k) d[k] = Distance(t, triangles_[other][k]);
    return d;
  }
  static bool IsOnBothSides(const Distances& d) {
    return *std::min_element(d.begin(), d.end()) < 0.0 &&
           *std::max_element(d.begin(), d.end()) > 0.0;
  }
  static bool IsInPlane(const Distances& d) { return d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0; }

  bool Intersect(const std::array<int, 2>& pair, const std::vector<Box>& boxes) const {
    const std::size_t s = static_cast<std::size_t>(pair[0]);
    const std::size_t t = static_cast<std::size_t>(pair[1]);
    if (normals_[s].isZero(0.0) || normals_[t].isZero(0.0)) return false;
    if (!boxes[s].intersects(boxes[t])) return false;
    const Distances of_t = DistancesTo(s, t);
    if (of_t[0] * of_t[1] > 0.0 && of_t[1] * of_t[2] > 0.0) return false;  // All on one side.
    const Distances of_s = DistancesTo(t, s);
    if (of_s[0] * of_s[1] > 0.0 && of_s[1] * of_s[2] > 0.0) return false;
    if (IsInPlane(of_s) && IsInPlane(of_t)) return !AreParted(s, t) && !AreParted(t, s);
    if (IsOnBothSides(of_s) && IsOnBothSides(of_t)) {
      const Vector3d line = normals_[s].cross(normals_[t]).normalized();
      const std::array<double, 2> a = Interval(s, of_s, line), b = Interval(t, of_t, line);
      return std::min(a[1], b[1]) - std::max(a[0], b[0]) > tolerance_;
    }
    return PassesAlongEdge(s, of_s, t) || PassesAlongEdge(t, of_t, s) ||
           CrossAtEdges(s, of_s, t, of_t);
  }

  // Where triangle t crosses the plane that its corners have these distances to.
  std::array<double, 2> Interval(std::size_t t, const Distances& d, const Vector3d& line) const {
    std::array<double, 2> interval = {std::numeric_limits<double>::infinity(),
                                      -std::numeric_limits<double>::infinity()};
    const auto extend = [&](const Vector3d& x) {
      interval[0] = std::min(interval[0], line.dot(x));
      interval[1] = std::max(interval[1], line.dot(x));
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t l = (k + 1) % 3;
      if (d[k] == 0.0) extend(Corner(t, k));
      if (d[k] * d[l] < 0.0) {
        extend(Corner(t, k) + d[k] / (d[k] - d[l]) * (Corner(t, l) - Corner(t, k)));
      }
    }
    return interval;
  }

  // Points into triangle t from its side k, in its plane.
  Vector3d Inward(std::size_t t, std::size_t k) const {
    return normals_[t].cross(Corner(t, (k + 1) % 3) - Corner(t, k)).normalized();
  }

  // In the common plane, whether a side of s has all of t beyond it (separating axis).
  bool AreParted(std::size_t s, std::size_t t) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d inward = Inward(s, k);
      double depth = -std::numeric_limits<double>::infinity();
      for (std::size_t l = 0; l < 3; ++l) {
        depth = std::max(depth, inward.dot(Corner(t, l) - Corner(s, k)));
      }
      if (depth <= tolerance_) return true;
    }
    return false;
  }

  // The only side with both ends in a plane and the third corner off it; -1: none.
  static int SideInPlane(const Distances& d) {
    for (int k = 0; k < 3; ++k) {
      const std::size_t i = static_cast<std::size_t>(k);
      if (d[i] == 0.0 && d[(i + 1) % 3] == 0.0 && d[(i + 2) % 3] != 0.0) return k;
    }
    return -1;
  }

  // The corner across side k that t does not share; -1 where there is none or more than one.
  int CornerAcross(std::size_t t, int k) const {
    const EdgeTable::Side* const across = edges_.Across(static_cast<int>(t), k);
    if (across == nullptr) return -1;
    return triangles_[static_cast<std::size_t>(across->triangle)]
                     [static_cast<std::size_t>((across->corner + 2) % 3)];
  }

  // Whether a side of s lies in triangle t, with s and its neighbour there on either side of it.
  bool PassesAlongEdge(std::size_t s, const Distances& of_s, std::size_t t) const {
    const int side = SideInPlane(of_s);
    const int beyond = side < 0 ? -1 : CornerAcross(s, side);
    if (beyond < 0) return false;
    const std::size_t k = static_cast<std::size_t>(side), next = (k + 1) % 3;
    if (!(Distance(t, beyond) * of_s[(k + 2) % 3] < 0.0)) return false;
    double begin = 0.0, end = 1.0;  // The part of the side that is within t.
    for (std::size_t l = 0; l < 3; ++l) {
      const Vector3d inward = Inward(t, l);
      const double a = inward.dot(Corner(s, k) - Corner(t, l)) - tolerance_;
      const double b = inward.dot(Corner(s, next) - Corner(t, l)) - tolerance_;
      if (a <= 0.0 && b <= 0.0) return false;
      if (a < 0.0) begin = std::max(begin, a / (a - b));
      if (b < 0.0) end = std::min(end, a / (a - b));
    }
    return (end - begin) * (Corner(s, next) - Corner(s, k)).norm() > tolerance_;
  }

  // Whether sides of s and t lie on each other, and around their line triangles of the one surface
  // and of the other take turns.
  bool CrossAtEdges(std::size_t s,
                    const Distances& of_s,
                    std::size_t t,
                    const Distances& of_t) const {
    const std::array<int, 2> side = {SideInPlane(of_s), SideInPlane(of_t)};
    if (side[0] < 0 || side[1] < 0) return false;
    const std::array<int, 2> beyond = {CornerAcross(s, side[0]), CornerAcross(t, side[1])};
    if (beyond[0] < 0 || beyond[1] < 0) return false;
    const std::size_t k = static_cast<std::size_t>(side[0]), l = static_cast<std::size_t>(side[1]);
    const Vector3d origin = Corner(s, k);
    const Vector3d length = Corner(s, (k + 1) % 3) - origin;
    const Vector3d axis = length.normalized();
    std::array<double, 2> other{};
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector3d x = Corner(t, (l + i) % 3) - origin;
      other[i] = axis.dot(x);
      if ((x - other[i] * axis).norm() > tolerance_) return false;
    }
    if (std::min(length.norm(), std::max(other[0], other[1])) -
            std::max(0.0, std::min(other[0], other[1])) <=
        tolerance_) {
      return false;
    }
    // Angles about the axis, from triangle s on.
    const Vector3d first = Inward(s, k);
    const Vector3d second = axis.cross(first);
    const auto angle = [&](const Vector3d& corner) {
      const double a = std::atan2(second.dot(corner - origin), first.dot(corner - origin));
      return a < 0.0 ? a + 2.0 * M_PI : a;
    };
    const double own = angle(vertices_[static_cast<std::size_t>(beyond[0])]);
    const double a = angle(Corner(t, (l + 2) % 3));
    const double b = angle(vertices_[static_cast<std::size_t>(beyond[1])]);
    constexpr double kSmallAngle = 1e-6;  // rad; less is touching.
    for (const double x : {a, b}) {
      if (x < kSmallAngle || std::abs(x - own) < kSmallAngle || x > 2.0 * M_PI - kSmallAngle) {
        return false;
      }
    }
    return (a < own) != (b < own);
  }

  const std::vector<Vector3d>& vertices_;
  const std::vector<std::array<int, 3>>& triangles_;
  double tolerance_;
  EdgeTable edges_;
  std::vector<Vector3d> normals_;  // Zero for triangles without area.
};

}  // namespace

std::vector<std::array<int, 2>> IntersectingTriangles(
    const std::vector<Vector3d>& vertices,
    const std::vector<std::array<int, 3>>& triangles,
    double tolerance,
    std::size_t max_pairs) {
  return Search(vertices, triangles, tolerance).Pairs(max_pairs);
}

}  // namespace darboux
