#include "geometry/isotropic_remesher.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

namespace darboux {
namespace {

// Lengths of edges that are split and collapsed, relative to the target: an edge just too long
// becomes two that are not too short, and the other way round.
constexpr double kTooLong = 4.0 / 3.0;
constexpr double kTooShort = 4.0 / 5.0;

// Changes must not turn a triangle further from the surface than this cosine, unless it is
// already.
constexpr double kMinAlignment = 0.6;

int CountSides(IsotropicRemesher::Sides sides) {
  int count = 0;
  for (; sides != 0; sides &= sides - 1) ++count;
  return count;
}

}  // namespace

IsotropicRemesher::IsotropicRemesher(const TriangleMesh& mesh,
                                     std::vector<Sides> sides,
                                     double target_edge_length,
                                     Projector projector)
    : target_(target_edge_length),
      projector_(std::move(projector)),
      position_(mesh.vertices),
      sides_(std::move(sides)) {
  CHECK_EQ(position_.size(), sides_.size());
  const int num_vertices = static_cast<int>(position_.size());
  origin_.reserve(3 * mesh.triangles.size());
  for (const std::array<int, 3>& t : mesh.triangles) {
    origin_.insert(origin_.end(), t.begin(), t.end());
  }
  twin_.assign(origin_.size(), -1);
  leaving_.assign(num_vertices, -1);
  std::unordered_map<std::uint64_t, int> half_edges;
  half_edges.reserve(origin_.size());
  const auto key = [num_vertices](int a, int b) {
    return static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(num_vertices) +
           static_cast<std::uint64_t>(b);
  };
  for (int h = 0; h < NumHalfEdges(); ++h) {
    CHECK(half_edges.insert({key(origin_[h], Target(h)), h}).second) << "not an oriented manifold";
  }
  for (int h = 0; h < NumHalfEdges(); ++h) {
    const auto twin = half_edges.find(key(Target(h), origin_[h]));
    if (twin != half_edges.end()) {
      twin_[h] = twin->second;
    } else {
      CHECK_NE(sides_[origin_[h]] & sides_[Target(h)], 0) << "a boundary edge inside the box";
    }
  }
  normal_.assign(num_vertices, Eigen::Vector3d::Zero());
  for (int h = 0; h < NumHalfEdges(); ++h) {
    if (leaving_[origin_[h]] < 0 || twin_[h] < 0) leaving_[origin_[h]] = h;
    const Eigen::Vector3d& p = position_[origin_[h]];
    normal_[origin_[h]] += (position_[Target(h)] - p).cross(position_[origin_[Previous(h)]] - p);
  }
  for (int v = 0; v < num_vertices; ++v) {
    CHECK_GE(leaving_[v], 0) << "a vertex without triangle";
    normal_[v].normalize();
    projector_(sides_[v], &position_[v], &normal_[v]);
  }
}

TriangleMesh IsotropicRemesher::Result(std::vector<Eigen::Vector3d>* normals) const {
  TriangleMesh mesh;
  normals->clear();
  std::vector<int> number(position_.size(), -1);
  for (size_t v = 0; v < position_.size(); ++v) {
    if (leaving_[v] < 0) continue;
    number[v] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(position_[v]);
    normals->push_back(normal_[v]);
  }
  for (int h = 0; h < NumHalfEdges(); h += 3) {
    if (!IsAlive(h)) continue;
    mesh.triangles.push_back({number[origin_[h]], number[origin_[h + 1]], number[origin_[h + 2]]});
  }
  return mesh;
}

// ---- Connectivity ----

void IsotropicRemesher::Pair(int g, int h) {
  if (g >= 0) twin_[g] = h;
  if (h >= 0) twin_[h] = g;
}

// The vertex is left by h among others.
void IsotropicRemesher::Leave(int vertex, int h) {
  const int first = h;
  while (twin_[h] >= 0) {  // Clockwise.
    h = Next(twin_[h]);
    if (h == first) break;
  }
  leaving_[vertex] = h;
}

void IsotropicRemesher::Fan(int vertex, std::vector<int>* half_edges) const {
  half_edges->clear();
  const int first = leaving_[vertex];
  int h = first;
  do {
    half_edges->push_back(h);
    h = twin_[Previous(h)];
  } while (h >= 0 && h != first);
}

void IsotropicRemesher::Neighbours(int vertex, std::vector<int>* vertices) const {
  vertices->clear();
  const int first = leaving_[vertex];
  int h = first;
  for (;;) {
    vertices->push_back(Target(h));
    const int previous = Previous(h);
    h = twin_[previous];
    if (h < 0) vertices->push_back(origin_[previous]);
    if (h < 0 || h == first) return;
  }
}

bool IsotropicRemesher::AreNeighbours(int a, int b) const {
  Neighbours(a, &neighbours_);
  return std::find(neighbours_.begin(), neighbours_.end(), b) != neighbours_.end();
}

int IsotropicRemesher::Valence(int vertex) const {
  Neighbours(vertex, &neighbours_);
  return static_cast<int>(neighbours_.size());
}

// ---- Shape ----

double IsotropicRemesher::Alignment(const Eigen::Vector3d (&p)[3],
                                    const Eigen::Vector3d (&n)[3]) const {
  const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
  const double norm = normal.norm();
  if (!(norm > 0.0)) return -1.0;
  return std::min({normal.dot(n[0]), normal.dot(n[1]), normal.dot(n[2])}) / norm;
}

double IsotropicRemesher::MinAngle(int a, int b, int c) const {
  const int corner[3] = {a, b, c};
  double min_angle = M_PI;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d& p = position_[corner[k]];
    const Eigen::Vector3d u = position_[corner[(k + 1) % 3]] - p;
    const Eigen::Vector3d v = position_[corner[(k + 2) % 3]] - p;
    min_angle = std::min(min_angle, std::atan2(u.cross(v).norm(), u.dot(v)));
  }
  return min_angle;
}

// ---- Changes ----

bool IsotropicRemesher::Split(int h) {
  const int a = origin_[h];
  const int b = Target(h);
  const int t = twin_[h];
  const Sides sides = t < 0 ? sides_[a] & sides_[b] : 0;
  Eigen::Vector3d middle = 0.5 * (position_[a] + position_[b]);
  Eigen::Vector3d normal = (normal_[a] + normal_[b]).normalized();
  if (!projector_(sides, &middle, &normal)) return false;

  const int m = static_cast<int>(position_.size());
  position_.push_back(middle);
  normal_.push_back(normal);
  sides_.push_back(sides);
  leaving_.push_back(-1);

  // (a, b, c) becomes (a, m, c), and (m, b, c) is new.
  const int hn = Next(h);
  const int c = origin_[Previous(h)];
  const int n = NumHalfEdges();
  origin_.insert(origin_.end(), {m, b, c});
  twin_.insert(twin_.end(), {-1, -1, -1});
  origin_[hn] = m;
  Pair(n + 1, twin_[hn]);
  Pair(n + 2, hn);
  if (t >= 0) {
    // (b, a, d) becomes (m, a, d), and (b, m, d) is new.
    const int tp = Previous(t);
    const int d = origin_[tp];
    const int q = NumHalfEdges();
    origin_.insert(origin_.end(), {b, m, d});
    twin_.insert(twin_.end(), {-1, -1, -1});
    origin_[t] = m;
    Pair(q + 2, twin_[tp]);
    Pair(q, n);
    Pair(q + 1, tp);
    Leave(d, q + 2);
  }
  Leave(b, n + 1);
  Leave(m, n);
  return true;
}

bool IsotropicRemesher::Collapse(int h, double max_length) {
  const int a = origin_[h];
  const int b = Target(h);
  const int t = twin_[h];
  const int hn = Next(h);
  const int hp = Previous(h);
  const int c = origin_[hp];
  const int d = t < 0 ? -1 : origin_[Previous(t)];

  // The boundary may only be shortened along itself, and not through a corner of the box.
  if (IsBoundary(a) && (t >= 0 || (sides_[a] & ~sides_[b]) != 0)) return false;
  if (CountSides(sides_[a]) > 1) return false;
  // No triangle may hang by one edge.
  if (twin_[hn] < 0 && twin_[hp] < 0) return false;
  if (t >= 0 && twin_[Next(t)] < 0 && twin_[Previous(t)] < 0) return false;

  // Common neighbours are those opposite to the edge: else the surface would be pinched.
  Neighbours(a, &neighbours_);
  Neighbours(b, &other_neighbours_);
  for (const int v : neighbours_) {
    if (v == c || v == d) continue;
    if (std::find(other_neighbours_.begin(), other_neighbours_.end(), v) !=
        other_neighbours_.end()) {
      return false;
    }
  }
  const int valence_b =
      static_cast<int>(neighbours_.size() + other_neighbours_.size()) - (t < 0 ? 3 : 4);
  if (valence_b < (IsBoundary(b) ? 3 : 4) || valence_b > (IsBoundary(b) ? 6 : 8)) return false;
  for (const int v : {c, d}) {
    if (v >= 0 && Valence(v) - 1 < (IsBoundary(v) ? 3 : 4)) return false;
  }

  Eigen::Vector3d position = position_[b];
  Eigen::Vector3d normal = normal_[b];
  if (sides_[a] == sides_[b]) {
    Eigen::Vector3d p = 0.5 * (position_[a] + position_[b]);
    Eigen::Vector3d n = (normal_[a] + normal_[b]).normalized();
    if (projector_(sides_[b], &p, &n)) {
      position = p;
      normal = n;
    }
  }
  for (const int v : {a, b}) {
    Fan(v, &fan_);
    for (const int g : fan_) {
      const int q = Target(g);
      const int r = origin_[Previous(g)];
      if (q == a || q == b || r == a || r == b) continue;
      if ((position_[q] - position).norm() > max_length) return false;
      if ((position_[r] - position).norm() > max_length) return false;
      const double after =
          Alignment({position, position_[q], position_[r]}, {normal, normal_[q], normal_[r]});
      if (after > kMinAlignment) continue;
      const double before = Alignment({position_[v], position_[q], position_[r]},
                                      {normal_[v], normal_[q], normal_[r]});
      if (after < before) return false;
    }
  }

  Fan(a, &fan_);
  for (const int g : fan_) origin_[g] = b;
  position_[b] = position;
  normal_[b] = normal;
  const int to_b = twin_[hn];
  const int from_b = twin_[hp];
  Pair(to_b, from_b);
  int leaving_d = -1;
  if (t >= 0) {
    const int from_d = twin_[Next(t)];
    const int to_d = twin_[Previous(t)];
    Pair(from_d, to_d);
    leaving_d = from_d >= 0 ? from_d : Next(to_d);
  }
  const int first = 3 * (h / 3);
  origin_[first] = origin_[first + 1] = origin_[first + 2] = -1;
  if (t >= 0) {
    const int other = 3 * (t / 3);
    origin_[other] = origin_[other + 1] = origin_[other + 2] = -1;
  }
  leaving_[a] = -1;
  Leave(b, from_b >= 0 ? from_b : Next(to_b));
  Leave(c, to_b >= 0 ? to_b : Next(from_b));
  if (d >= 0) Leave(d, leaving_d);
  return true;
}

bool IsotropicRemesher::CanFlip(int h) const {
  const int t = twin_[h];
  if (t < 0) return false;
  const int a = origin_[h];
  const int b = Target(h);
  const int c = origin_[Previous(h)];
  const int d = origin_[Previous(t)];
  if (Valence(a) - 1 < (IsBoundary(a) ? 3 : 4)) return false;
  if (Valence(b) - 1 < (IsBoundary(b) ? 3 : 4)) return false;
  if (c == d || AreNeighbours(c, d)) return false;
  // An edge between two points of the boundary would not be in it.
  if (IsBoundary(c) && IsBoundary(d)) return false;
  const Eigen::Vector3d &pa = position_[a], &pb = position_[b], &pc = position_[c],
                        &pd = position_[d];
  const Eigen::Vector3d &na = normal_[a], &nb = normal_[b], &nc = normal_[c], &nd = normal_[d];
  const double after =
      std::min(Alignment({pc, pd, pb}, {nc, nd, nb}), Alignment({pd, pc, pa}, {nd, nc, na}));
  if (after > kMinAlignment) return true;
  return after >
         std::min(Alignment({pa, pb, pc}, {na, nb, nc}), Alignment({pb, pa, pd}, {nb, na, nd}));
}

void IsotropicRemesher::Flip(int h) {
  const int t = twin_[h];
  const int hn = Next(h), hp = Previous(h), tn = Next(t), tp = Previous(t);
  const int a = origin_[h], b = origin_[t], c = origin_[hp], d = origin_[tp];
  const int bc = twin_[hn], ca = twin_[hp], ad = twin_[tn], db = twin_[tp];
  origin_[h] = c;
  origin_[hn] = d;
  origin_[hp] = b;
  origin_[t] = d;
  origin_[tn] = c;
  origin_[tp] = a;
  Pair(hn, db);
  Pair(hp, bc);
  Pair(tn, ca);
  Pair(tp, ad);
  Leave(a, tp);
  Leave(b, hp);
  Leave(c, h);
  Leave(d, t);
}

// ---- Passes ----

void IsotropicRemesher::SplitLongEdges(double max_length) {
  for (int h = 0; h < NumHalfEdges(); ++h) {
    if (!IsAlive(h) || (twin_[h] >= 0 && twin_[h] < h)) continue;
    // Its halves may still be too long; a projection that stretches them without end is no surface.
    for (int i = 0; i < 8 && Length(h) > max_length && Split(h); ++i) {
    }
  }
}

void IsotropicRemesher::CollapseShortEdges(double min_length, double max_length) {
  for (int h = 0; h < NumHalfEdges(); ++h) {
    if (!IsAlive(h) || Length(h) >= min_length) continue;
    Collapse(h, max_length);  // Its twin has its own turn.
  }
}

void IsotropicRemesher::FlipTowardsEvenValences() {
  for (int h = 0; h < NumHalfEdges(); ++h) {
    if (!IsFirst(h) || twin_[h] < 0) continue;
    const int a = ValenceExcess(origin_[h]);
    const int b = ValenceExcess(Target(h));
    const int c = ValenceExcess(origin_[Previous(h)]);
    const int d = ValenceExcess(origin_[Previous(twin_[h])]);
    // Squares: (a - 1)^2 + (b - 1)^2 + (c + 1)^2 + (d + 1)^2 against those before.
    if (c + d - a - b + 2 < 0 && CanFlip(h)) Flip(h);
  }
}

void IsotropicRemesher::FlipTowardsWideAngles() {
  for (int h = 0; h < NumHalfEdges(); ++h) {
    if (!IsFirst(h) || twin_[h] < 0) continue;
    const int a = origin_[h], b = Target(h);
    const int c = origin_[Previous(h)], d = origin_[Previous(twin_[h])];
    const int excess[4] = {
        ValenceExcess(a) - 1, ValenceExcess(b) - 1, ValenceExcess(c) + 1, ValenceExcess(d) + 1};
    if (*std::min_element(excess, excess + 4) < -1 || *std::max_element(excess, excess + 4) > 1) {
      continue;
    }
    const double before = std::min(MinAngle(a, b, c), MinAngle(b, a, d));
    const double after = std::min(MinAngle(c, d, b), MinAngle(d, c, a));
    if (after > 1.01 * before && CanFlip(h)) Flip(h);
  }
}

// A vertex of valence 4 goes into a neighbour, which then has at most 7; the longest edge of one of
// valence 8 or more is split.
void IsotropicRemesher::RemoveExtremeValences(double max_length) {
  const int num_vertices = static_cast<int>(position_.size());
  std::vector<std::pair<double, int>> candidates;
  for (int v = 0; v < num_vertices; ++v) {
    if (leaving_[v] < 0 || IsBoundary(v)) continue;
    Fan(v, &fan_);
    if (fan_.size() > 4 && fan_.size() < 8) continue;
    candidates.clear();
    for (const int h : fan_) candidates.push_back({Length(h), h});
    std::sort(candidates.begin(), candidates.end());
    if (fan_.size() >= 8) {
      Split(candidates.back().second);
      continue;
    }
    for (const auto& [length, h] : candidates) {
      if (Valence(Target(h)) <= 7 && Collapse(h, max_length)) break;
    }
  }
}

void IsotropicRemesher::Relax(bool weighted_by_area) {
  std::vector<double> area(position_.size(), 0.0);
  if (weighted_by_area) {
    for (int h = 0; h < NumHalfEdges(); ++h) {
      if (!IsAlive(h)) continue;
      const Eigen::Vector3d& p = position_[origin_[h]];
      area[origin_[h]] +=
          (position_[Target(h)] - p).cross(position_[origin_[Previous(h)]] - p).norm();
    }
  }
  const int num_vertices = static_cast<int>(position_.size());
  for (int v = 0; v < num_vertices; ++v) {
    if (leaving_[v] < 0 || CountSides(sides_[v]) > 1) continue;
    Neighbours(v, &neighbours_);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double weight = 0.0;
    const auto add = [&](int other, double w) {
      centre += w * position_[other];
      weight += w;
    };
    if (IsBoundary(v)) {
      add(neighbours_.front(), 1.0);
      add(neighbours_.back(), 1.0);
    } else {
      for (const int other : neighbours_) add(other, weighted_by_area ? area[other] : 1.0);
    }
    Eigen::Vector3d step = centre / weight - position_[v];
    if (!IsBoundary(v)) step -= step.dot(normal_[v]) * normal_[v];

    // No further than all triangles allow.
    Fan(v, &fan_);
    double factor = 0.8;
    for (int attempt = 0; attempt < 3; ++attempt, factor *= 0.5) {
      Eigen::Vector3d p = position_[v] + factor * step;
      Eigen::Vector3d n = normal_[v];
      if (!projector_(sides_[v], &p, &n)) continue;
      bool is_aligned = true;
      for (const int h : fan_) {
        const int q = Target(h), r = origin_[Previous(h)];
        const Eigen::Vector3d &pq = position_[q], &pr = position_[r];
        const Eigen::Vector3d &nq = normal_[q], &nr = normal_[r];
        const double after = Alignment({p, pq, pr}, {n, nq, nr});
        if (after > kMinAlignment) continue;
        if (after > Alignment({position_[v], pq, pr}, {normal_[v], nq, nr})) continue;
        is_aligned = false;
        break;
      }
      if (!is_aligned) continue;
      position_[v] = p;
      normal_[v] = n;
      break;
    }
  }
}

void IsotropicRemesher::Run(int num_iterations) {
  const double max_length = kTooLong * target_;
  const double min_length = kTooShort * target_;
  for (int i = 0; i < num_iterations; ++i) {
    SplitLongEdges(max_length);
    CollapseShortEdges(min_length, max_length);
    FlipTowardsEvenValences();
    Relax(true);
  }
  // Now without the pulse of splitting and collapsing: only what is really off is changed.
  for (int i = 0; i < num_iterations; ++i) {
    if (i < num_iterations / 2) {
      RemoveExtremeValences(1.45 * target_);
      CollapseShortEdges(0.65 * target_, 1.45 * target_);
      SplitLongEdges(1.45 * target_);
      FlipTowardsEvenValences();
    }
    FlipTowardsWideAngles();
    Relax(i % 2 == 0);
  }
}

}  // namespace darboux
