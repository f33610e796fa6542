#include "geometry/shell_face.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "geometry/point_tree.h"

namespace darboux {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Barycentric coordinates of an element point, of the corners A, B, C.
using Barycentric = std::array<double, 3>;

Barycentric ToBarycentric(const ElementPoint& at) { return {1.0 - at.s - at.t, at.s, at.t}; }

}  // namespace

struct ShellFace::Search {
  // Of the face at a point; _s and _t are derivatives in the coordinates of the element.
  struct Jet {
    Vector3d f, f_s, f_t;                 // the face
    Vector3d n, n_s, n_t;                 // its normal
    Vector3d m_s, m_t, m_ss, m_st, m_tt;  // the middle surface

    // Along a direction of the element.
    Vector3d Face(const Vector2d& d) const { return d.x() * f_s + d.y() * f_t; }
    Vector3d Normal(const Vector2d& d) const { return d.x() * n_s + d.y() * n_t; }
    Vector3d Second(const Vector2d& d) const {
      return d.x() * d.x() * m_ss + 2.0 * d.x() * d.y() * m_st + d.y() * d.y() * m_tt;
    }
  };
  // Across an edge, or across half of one where the elements there are half as large.
  struct Neighbour {
    int element = -1;  // none: a boundary of the shell
    int corner = 0;    // of the neighbour, opposite to the common edge
    // 1: the neighbour is half as large, and has the corner of the edge that is its corner `end`;
    // -1: it is twice as large, and this element has its corner `end`.
    int finer = 0, end = 0;
  };
  // The side of an element opposite to `corner`, on the boundary of the shell.
  struct BoundaryEdge {
    int element = 0, corner = 0;
    int next = -1, last = -1;  // along the boundary
  };
  // Where a descent ended.
  struct Candidate {
    ElementPoint at;
    double squared = std::numeric_limits<double>::infinity();
    int boundary_edge = -1;
  };

  Search(const ShellSurface& s, double o) : surface(s), offset(o) { FindNeighbours(); }

  void FindNeighbours();
  void SetDisplacements(const Eigen::Matrix3Xd& u);
  Jet Evaluate(const ElementPoint& at) const;
  ElementPoint Walk(ElementPoint at, const Vector2d& step, int* boundary_edge) const;
  Candidate Descend(const Vector3d& x, const ElementPoint& start) const;
  Candidate DescendInterior(const Vector3d& x, ElementPoint at, int* boundary_edge) const;
  Candidate DescendBoundary(const Vector3d& x, ElementPoint at, int edge, bool* inward) const;
  Foot MakeFoot(const Vector3d& x, const Candidate& candidate) const;

  // A point of a boundary edge, 0 <= u <= 1 along it, and the direction of u in the element.
  ElementPoint OnEdge(int edge, double u) const;
  Vector2d AlongEdge(int edge) const;

  const ShellSurface& surface;
  const double offset;
  Eigen::Matrix3Xd displacements;
  // What the full Loop basis weighs: control points of the deformed shell, of a parametric surface
  // its displacements, with those of what is folded.
  Eigen::Matrix3Xd control;
  // Of each element, opposite to its corner k: on the side of corners k + 1 and k + 2.
  std::vector<std::array<std::array<Neighbour, 2>, 3>> neighbours;
  std::vector<std::array<int, 3>> boundary_of;  // of each element's sides; -1: none
  std::vector<BoundaryEdge> boundary;

  // Corners, middles of edges and centroids of the elements.
  std::vector<ElementPoint> samples;
  std::vector<Vector3d> sample_normals;
  std::vector<double> reach;  // no point of the face is farther from the nearest of the samples
  PointTree tree;
  double size = 0.0;
};

void ShellFace::Search::FindNeighbours() {
  const int num_elements = surface.num_elements();
  // -> element, opposite corner
  std::map<std::pair<int, int>, std::pair<int, int>> halfedges;
  for (int e = 0; e < num_elements; ++e) {
    for (int k = 0; k < 3; ++k) {
      halfedges[{surface.Corner(e, (k + 1) % 3), surface.Corner(e, (k + 2) % 3)}] = {e, k};
    }
  }
  neighbours.resize(num_elements);
  boundary_of.assign(num_elements, {-1, -1, -1});
  for (int e = 0; e < num_elements; ++e) {
    for (int k = 0; k < 3; ++k) {
      const int middle = surface.HangingCorner(e, (k + 1) % 3);
      if (middle < 0) continue;
      for (int half = 0; half < 2; ++half) {
        // The neighbour runs the other way: (middle, a) and (b, middle) for the edge (a, b).
        const int end = (k + 1 + half) % 3;
        const int corner = surface.Corner(e, end);
        const auto [f, j] = halfedges.at(half == 0 ? std::make_pair(middle, corner)
                                                   : std::make_pair(corner, middle));
        neighbours[e][k][half] = {f, j, 1, half == 0 ? (j + 2) % 3 : (j + 1) % 3};
        neighbours[f][j].fill({e, k, -1, end});
      }
    }
  }
  std::map<int, int> begins, ends;  // corner -> boundary edge
  std::vector<char> seen(surface.num_corners(), 0);
  for (int e = 0; e < num_elements; ++e) {
    for (int k = 0; k < 3; ++k) {
      const int a = surface.Corner(e, (k + 1) % 3), b = surface.Corner(e, (k + 2) % 3);
      // The middle of an edge is a sample of one of its elements, of the smaller ones where they
      // differ: that of the larger one is a corner there.
      bool is_own = neighbours[e][k][0].finer < 0;
      if (neighbours[e][k][0].element < 0) {
        const auto across = halfedges.find({b, a});
        if (across != halfedges.end()) {
          neighbours[e][k].fill({across->second.first, across->second.second, 0, 0});
          is_own = a < b;
        } else {
          boundary_of[e][k] = static_cast<int>(boundary.size());
          begins[a] = ends[b] = boundary_of[e][k];
          boundary.push_back({e, k, -1, -1});
          is_own = true;
        }
      }
      constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
      constexpr double kMiddle[3][2] = {{0.5, 0.5}, {0.0, 0.5}, {0.5, 0.0}};
      if (is_own) samples.push_back({e, kMiddle[k][0], kMiddle[k][1]});
      char& known = seen[surface.Corner(e, k)];
      if (!known) samples.push_back({e, kCorner[k][0], kCorner[k][1]});
      known = 1;
    }
    samples.push_back({e, 1.0 / 3.0, 1.0 / 3.0});
  }
  for (BoundaryEdge& edge : boundary) {
    const auto next = begins.find(surface.Corner(edge.element, (edge.corner + 2) % 3));
    const auto last = ends.find(surface.Corner(edge.element, (edge.corner + 1) % 3));
    if (next != begins.end()) edge.next = next->second;
    if (last != ends.end()) edge.last = last->second;
  }
}

void ShellFace::Search::SetDisplacements(const Eigen::Matrix3Xd& u) {
  displacements = u;
  const auto& folded = surface.folds();
  if (folded.empty()) {
    control = u;
  } else {
    control.setZero(3, u.cols());
    for (int i = 0; i < u.cols(); ++i) {
      for (const auto& [vertex, factor] : folded[i]) control.col(i) += factor * u.col(vertex);
    }
  }
  if (!surface.is_parametric()) control += surface.control_points();

  std::vector<Vector3d> points;
  points.reserve(samples.size());
  sample_normals.clear();
  Eigen::AlignedBox3d box;
  for (const ElementPoint& at : samples) {
    const Jet jet = Evaluate(at);
    points.push_back(jet.f);
    sample_normals.push_back(jet.n);
    box.extend(jet.f);
  }
  size = box.diagonal().norm();
  // Half the longest edge around will do for the samples of an element: they cut it into triangles
  // that are smaller by far.
  std::vector<double> longest(surface.mesh().num_elements, 0.0);
  std::vector<std::array<Vector3d, 3>> corners(surface.mesh().num_elements);
  std::vector<Vector3d> of_corner(surface.num_corners());
  for (size_t i = 0; i < samples.size(); ++i) {
    const Barycentric b = ToBarycentric(samples[i]);
    for (int k = 0; k < 3; ++k) {
      if (b[k] == 1.0) of_corner[surface.Corner(samples[i].element, k)] = points[i];
    }
  }
  for (int e = 0; e < surface.mesh().num_elements; ++e) {
    for (int k = 0; k < 3; ++k) {
      const double length =
          (of_corner[surface.Corner(e, k)] - of_corner[surface.Corner(e, (k + 1) % 3)]).norm();
      longest[e] = std::max(longest[e], length);
    }
  }
  reach.resize(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) reach[i] = 0.5 * longest[samples[i].element];
  tree.Build(std::move(points));
}

ShellFace::Search::Jet ShellFace::Search::Evaluate(const ElementPoint& at) const {
  const LoopBasis& basis = surface.basis();
  const std::vector<int>& vertices = basis.control_vertices(at.element);
  Eigen::Matrix<double, 3, 6> jet = Eigen::Matrix<double, 3, 6>::Zero();
  if (basis.IsRegular(at.element)) {
    const Eigen::Matrix<double, 6, 12> rows = EvaluateRegularLoopBasis(at.s, at.t);
    for (int i = 0; i < 12; ++i) {
      jet.noalias() += control.col(vertices[i]) * rows.col(i).transpose();
    }
  } else {
    const BasisMatrix rows = basis.Evaluate(at.element, at.s, at.t);
    for (size_t i = 0; i < vertices.size(); ++i) {
      jet.noalias() += control.col(vertices[i]) * rows.col(i).transpose();
    }
  }
  if (surface.is_parametric()) {
    const RestJet rest = surface.Rest(at);
    jet.col(kValue) += rest.x;
    jet.col(kDs) += rest.x_s;
    jet.col(kDt) += rest.x_t;
    jet.col(kDss) += rest.x_ss;
    jet.col(kDst) += rest.x_st;
    jet.col(kDtt) += rest.x_tt;
  }
  Jet result;
  result.m_s = jet.col(kDs);
  result.m_t = jet.col(kDt);
  result.m_ss = jet.col(kDss);
  result.m_st = jet.col(kDst);
  result.m_tt = jet.col(kDtt);
  result.n = result.m_s.cross(result.m_t).normalized();
  // Weingarten: n_,a = -b_a^c m_,c.
  Matrix2d metric, b;
  metric(0, 0) = result.m_s.squaredNorm();
  metric(0, 1) = metric(1, 0) = result.m_s.dot(result.m_t);
  metric(1, 1) = result.m_t.squaredNorm();
  b(0, 0) = result.m_ss.dot(result.n);
  b(0, 1) = b(1, 0) = result.m_st.dot(result.n);
  b(1, 1) = result.m_tt.dot(result.n);
  const double determinant = metric.determinant();
  Matrix2d mixed = Matrix2d::Zero();
  if (determinant > 0.0 && b.allFinite()) mixed = b * metric.inverse();
  result.n_s = -mixed(0, 0) * result.m_s - mixed(0, 1) * result.m_t;
  result.n_t = -mixed(1, 0) * result.m_s - mixed(1, 1) * result.m_t;
  result.f = jet.col(kValue) + offset * result.n;
  result.f_s = result.m_s + offset * result.n_s;
  result.f_t = result.m_t + offset * result.n_t;
  return result;
}

// Follows a step from element to element, as if neighbours lay in one plane and were parallelograms
// (which is what a regular control mesh has); ends at the boundary of the shell, *boundary_edge.
ElementPoint ShellFace::Search::Walk(ElementPoint at,
                                     const Vector2d& step,
                                     int* boundary_edge) const {
  *boundary_edge = -1;
  constexpr int kMostElements = 16;
  Barycentric b = ToBarycentric(at);
  Barycentric d = {-step.x() - step.y(), step.x(), step.y()};
  int element = at.element;
  for (int count = 0; count < kMostElements; ++count) {
    double part = 1.0;
    int side = -1;
    for (int k = 0; k < 3; ++k) {
      if (d[k] < 0.0 && b[k] + d[k] < 0.0) {
        const double limit = std::max(0.0, -b[k] / d[k]);
        if (limit < part) {
          part = limit;
          side = k;
        }
      }
    }
    for (int k = 0; k < 3; ++k) b[k] = std::max(0.0, b[k] + part * d[k]);
    if (side < 0) break;
    b[side] = 0.0;
    const int k1 = (side + 1) % 3, k2 = (side + 2) % 3;
    const Neighbour& next = neighbours[element][side][b[k1] >= b[k2] ? 0 : 1];
    if (next.element < 0) {
      *boundary_edge = boundary_of[element][side];
      break;
    }
    const int j = next.corner;
    for (double& x : d) x *= 1.0 - part;
    Barycentric moved, turned;
    moved[j] = 0.0;
    moved[(j + 1) % 3] = b[k2];
    moved[(j + 2) % 3] = b[k1];
    turned[j] = -d[side];
    turned[(j + 1) % 3] = d[k2] + d[side];
    turned[(j + 2) % 3] = d[k1] + d[side];
    // Into the part of the element of the same size that has its corner `end`, or out of it.
    if (next.finer != 0) {
      const double factor = next.finer > 0 ? 2.0 : 0.5;
      for (int k = 0; k < 3; ++k) {
        moved[k] *= factor;
        turned[k] *= factor;
      }
      moved[next.end] += 1.0 - factor;
      moved[next.end] = std::max(0.0, moved[next.end]);
    }
    b = moved;
    d = turned;
    element = next.element;
  }
  const double sum = b[0] + b[1] + b[2];
  return {element, b[1] / sum, b[2] / sum};
}

// Newton's method for phi = |f - x|^2 / 2, r = f - x:
//
//   phi_,a = r . f_,a,   phi_,ab = f_,a . f_,b + r . f_,ab,
//
// and where r is along the normal, as at the foot, r . f_,ab = -(r . n) n_,b . f_,a: no third
// derivative of the middle surface is needed for quadratic convergence. Gauss-Newton where that is
// not convex, halved steps where phi does not descend. *boundary_edge: where the step leaves the
// shell.
ShellFace::Search::Candidate ShellFace::Search::DescendInterior(const Vector3d& x,
                                                                ElementPoint at,
                                                                int* boundary_edge) const {
  constexpr int kMostIterations = 60;
  *boundary_edge = -1;
  Jet jet = Evaluate(at);
  Vector3d r = jet.f - x;
  double value = r.squaredNorm();
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Vector2d gradient(r.dot(jet.f_s), r.dot(jet.f_t));
    Matrix2d hessian;
    hessian(0, 0) = jet.f_s.squaredNorm();
    hessian(0, 1) = hessian(1, 0) = jet.f_s.dot(jet.f_t);
    hessian(1, 1) = jet.f_t.squaredNorm();
    const double along = r.dot(jet.n);
    Matrix2d newton = hessian;
    newton(0, 0) -= along * jet.n_s.dot(jet.f_s);
    newton(0, 1) -= along * jet.n_s.dot(jet.f_t);
    newton(1, 0) = newton(0, 1);
    newton(1, 1) -= along * jet.n_t.dot(jet.f_t);
    if (newton(0, 0) > 0.0 && newton.determinant() > 1e-4 * hessian.determinant()) hessian = newton;
    const double determinant = hessian.determinant();
    if (!(determinant > 0.0)) break;
    const Vector2d step = -Vector2d(hessian(1, 1) * gradient.x() - hessian(0, 1) * gradient.y(),
                                    hessian(0, 0) * gradient.y() - hessian(1, 0) * gradient.x()) /
                          determinant;
    if (!step.allFinite()) break;
    const double length = jet.Face(step).norm();
    if (length <= 1e-15 * size) break;
    bool moved = false;
    for (double factor = 1.0; factor > 1e-6 && !moved; factor *= 0.25) {
      int beyond;
      const ElementPoint trial = Walk(at, factor * step, &beyond);
      const Jet there = Evaluate(trial);
      const Vector3d r_there = there.f - x;
      const double value_there = r_there.squaredNorm();
      // Close to the foot phi is constant to rounding.
      const double slack = length < 1e-6 * size ? 1e-14 * value + 1e-30 * size * size : 0.0;
      if (value_there < value + slack) {
        moved = true;
        at = trial;
        jet = there;
        r = r_there;
        value = value_there;
        if (beyond >= 0) {
          *boundary_edge = beyond;
          return {at, value, -1};
        }
      } else if (beyond >= 0 && factor < 1e-5) {  // At the boundary already.
        *boundary_edge = beyond;
        return {trial, value_there, -1};
      }
    }
    if (!moved || length <= 1e-11 * size) break;
  }
  return {at, value, -1};
}

ElementPoint ShellFace::Search::OnEdge(int edge, double u) const {
  const BoundaryEdge& side = boundary[edge];
  Barycentric b;
  b[side.corner] = 0.0;
  b[(side.corner + 1) % 3] = 1.0 - u;
  b[(side.corner + 2) % 3] = u;
  return {side.element, b[1], b[2]};
}

Vector2d ShellFace::Search::AlongEdge(int edge) const {
  Barycentric d;
  const int corner = boundary[edge].corner;
  d[corner] = 0.0;
  d[(corner + 1) % 3] = -1.0;
  d[(corner + 2) % 3] = 1.0;
  return {d[1], d[2]};
}

// The same along the boundary. *inward: the way on leads into the shell.
ShellFace::Search::Candidate ShellFace::Search::DescendBoundary(const Vector3d& x,
                                                                ElementPoint at,
                                                                int edge,
                                                                bool* inward) const {
  constexpr int kMostIterations = 200;
  *inward = false;
  double u = ToBarycentric(at)[(boundary[edge].corner + 2) % 3];
  u = std::min(1.0, std::max(0.0, u));
  at = OnEdge(edge, u);
  Jet jet = Evaluate(at);
  Vector3d r = jet.f - x;
  double value = r.squaredNorm();
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Vector2d d = AlongEdge(edge);
    double slope = r.dot(jet.Face(d));
    // Over a corner of the boundary: where it goes down on the next edge as well.
    const bool forward = slope < 0.0;
    if ((forward && u >= 1.0) || (!forward && u <= 0.0)) {
      const int other = forward ? boundary[edge].next : boundary[edge].last;
      if (other < 0) break;
      const double v = forward ? 0.0 : 1.0;
      const ElementPoint there = OnEdge(other, v);
      const Jet jet_there = Evaluate(there);
      const Vector2d d_there = AlongEdge(other);
      const double slope_there = (jet_there.f - x).dot(jet_there.Face(d_there));
      if (forward ? slope_there >= 0.0 : slope_there <= 0.0) break;
      edge = other;
      u = v;
      at = there;
      jet = jet_there;
      r = jet.f - x;
      value = r.squaredNorm();
      d = d_there;
      slope = slope_there;
    }
    const Vector3d f_d = jet.Face(d);
    const double speed = f_d.squaredNorm();
    const double along = r.dot(jet.n);
    double curvature =
        speed - along * jet.Normal(d).dot(f_d) + (r - along * jet.n).dot(jet.Second(d));
    if (!(curvature > 1e-3 * speed)) curvature = speed;
    if (!(curvature > 0.0)) break;
    const double step = -slope / curvature;
    const double length = std::abs(step) * std::sqrt(speed);
    if (length <= 1e-15 * size) break;
    bool moved = false;
    for (double factor = 1.0; factor > 1e-6 && !moved; factor *= 0.25) {
      const double v = std::min(1.0, std::max(0.0, u + factor * step));
      const ElementPoint trial = OnEdge(edge, v);
      const Jet there = Evaluate(trial);
      const double value_there = (there.f - x).squaredNorm();
      const double slack = length < 1e-6 * size ? 1e-14 * value + 1e-30 * size * size : 0.0;
      if (value_there < value + slack) {
        moved = true;
        u = v;
        at = trial;
        jet = there;
        r = jet.f - x;
        value = value_there;
      }
    }
    if (!moved || length <= 1e-13 * size) break;
  }
  const Vector2d d = AlongEdge(edge);
  const Vector3d f_d = jet.Face(d).normalized();
  const Vector2d in = std::array<Vector2d, 3>{
      Vector2d(-1.0, -1.0), Vector2d(1.0, 0.0), Vector2d(0.0, 1.0)}[boundary[edge].corner];
  Vector3d w = jet.Face(in);
  w -= w.dot(f_d) * f_d;
  *inward = r.dot(w) < -1e-13 * size * w.norm();
  return {at, value, edge};
}

ShellFace::Search::Candidate ShellFace::Search::Descend(const Vector3d& x,
                                                        const ElementPoint& start) const {
  constexpr int kMostTurns = 12;
  Candidate best;
  ElementPoint at = start;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    int edge;
    const Candidate inside = DescendInterior(x, at, &edge);
    if (inside.squared < best.squared || best.boundary_edge < 0) best = inside;
    if (edge < 0) break;
    bool inward;
    const Candidate on_edge = DescendBoundary(x, inside.at, edge, &inward);
    // No progress by going round once more.
    const bool stuck = turn > 0 && !(on_edge.squared < best.squared * (1.0 - 1e-14));
    if (on_edge.squared <= best.squared || turn == 0) best = on_edge;
    if (!inward || stuck) break;
    at = on_edge.at;
  }
  return best;
}

ShellFace::Foot ShellFace::Search::MakeFoot(const Vector3d& x, const Candidate& candidate) const {
  const Jet jet = Evaluate(candidate.at);
  Foot foot;
  foot.at = candidate.at;
  foot.position = jet.f;
  foot.normal = jet.n;
  const Vector3d d = x - jet.f;
  const double along = d.dot(jet.n);
  foot.distance = std::copysign(d.norm(), along);
  foot.on_boundary = candidate.boundary_edge >= 0 && (d - along * jet.n).norm() > 1e-10 * size;
  return foot;
}

ShellFace::ShellFace(const ShellSurface& surface, double offset)
    : search_(std::make_unique<Search>(surface, offset)) {
  SetDisplacements(Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices));
}

ShellFace::~ShellFace() = default;

void ShellFace::SetDisplacements(const Eigen::Matrix3Xd& displacements) {
  search_->SetDisplacements(displacements);
}

const Eigen::Matrix3Xd& ShellFace::displacements() const { return search_->displacements; }
const ShellSurface& ShellFace::surface() const { return search_->surface; }
double ShellFace::offset() const { return search_->offset; }

ShellFace::Foot ShellFace::Evaluate(const ElementPoint& at) const {
  const Search::Jet jet = search_->Evaluate(at);
  Foot foot;
  foot.at = at;
  foot.position = jet.f;
  foot.normal = jet.n;
  return foot;
}

ShellFace::Foot ShellFace::Closest(const Vector3d& point, const Foot* hint) const {
  constexpr int kMostDescents = 6;
  const Search& search = *search_;
  std::array<Search::Candidate, kMostDescents + 1> found;
  std::array<Vector3d, kMostDescents + 1> feet, normals;
  int count = 0;
  double nearest = std::numeric_limits<double>::infinity();
  Search::Candidate best;
  const auto descend = [&](const ElementPoint& start) {
    found[count] = search.Descend(point, start);
    const Search::Jet jet = search.Evaluate(found[count].at);
    feet[count] = jet.f;
    normals[count] = jet.n;
    if (found[count].squared < best.squared) {
      best = found[count];
      nearest = std::sqrt(best.squared);
    }
    ++count;
  };
  if (hint != nullptr) descend(hint->at);
  const PointTree::Neighbours near = search.tree.Nearest(point, PointTree::kMost);
  for (int i = 0; i < near.count && count < kMostDescents; ++i) {
    const int sample = near.index[i];
    const double reach = search.reach[sample];
    if (std::sqrt(near.squared[i]) - reach > nearest) continue;
    // A foot that has been found from next to it would be found again.
    bool known = false;
    for (int k = 0; k < count && !known; ++k) {
      known = (search.tree.points()[sample] - feet[k]).squaredNorm() < 4.0 * reach * reach &&
              search.sample_normals[sample].dot(normals[k]) > 0.5;
    }
    if (!known) descend(search.samples[sample]);
  }
  // A descent may end at a vertex that has not six neighbours, around which steps across elements
  // lead astray; then from the other samples, known or not.
  constexpr double kSettled = 1e-9;
  for (int i = 0; i < near.count && best.boundary_edge < 0; ++i) {
    const Search::Jet jet = search.Evaluate(best.at);
    const Vector3d d = point - jet.f;
    if ((d - d.dot(jet.n) * jet.n).norm() <= kSettled * search.size) break;
    const Search::Candidate other = search.Descend(point, search.samples[near.index[i]]);
    if (other.squared < best.squared) best = other;
  }
  return search.MakeFoot(point, best);
}

}  // namespace darboux
