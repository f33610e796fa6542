#include "geometry/shell_surface.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "geometry/quadrature.h"

namespace darboux {
namespace {

// The triangle (a, b, c) in element coordinates; the rule on it, nested towards the corners of
// `mask`.
void AddNested(const std::vector<TrianglePoint>& rule,
               const std::array<Eigen::Vector2d, 3>& corner,
               unsigned mask,
               int rings,
               std::vector<TrianglePoint>* points) {
  if (mask == 0 || rings == 0) {
    const Eigen::Vector2d a = corner[1] - corner[0], b = corner[2] - corner[0];
    const double area = std::abs(a.x() * b.y() - a.y() * b.x());
    for (const TrianglePoint& p : rule) {
      const Eigen::Vector2d x = corner[0] + p.s * a + p.t * b;
      points->push_back({x.x(), x.y(), p.weight * area});
    }
    return;
  }
  std::array<Eigen::Vector2d, 3> middle;  // opposite to corner k
  for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (corner[(k + 1) % 3] + corner[(k + 2) % 3]);
  AddNested(rule, middle, 0, 0, points);
  for (int k = 0; k < 3; ++k) {
    std::array<Eigen::Vector2d, 3> part;
    part[k] = corner[k];
    part[(k + 1) % 3] = middle[(k + 2) % 3];
    part[(k + 2) % 3] = middle[(k + 1) % 3];
    AddNested(rule, part, mask & (1u << k), rings - 1, points);
  }
}

// The rule of `num_points` for elements whose corners in `mask` are extraordinary vertices.
const std::vector<TrianglePoint>& NestedRule(int num_points, unsigned mask) {
  static const auto* const rules = [] {
    auto* result = new std::map<std::pair<int, unsigned>, std::vector<TrianglePoint>>;
    for (const int n : {1, 3, 6, 12}) {
      for (unsigned m = 1; m < 8; ++m) {
        AddNested(TriangleQuadrature(n),
                  {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0)},
                  m,
                  ShellSurface::kRings,
                  &(*result)[{n, m}]);
      }
    }
    return result;
  }();
  return rules->at({num_points, mask});
}

// Regular elements share one table of basis values per rule.
const std::vector<BasisMatrix>& RegularTable(int num_points) {
  static const auto* const tables = [] {
    auto* result = new std::map<int, std::vector<BasisMatrix>>;
    for (const int n : {1, 3, 6, 12}) {
      for (const TrianglePoint& p : TriangleQuadrature(n)) {
        (*result)[n].push_back(EvaluateRegularLoopBasis(p.s, p.t));
      }
    }
    return result;
  }();
  return tables->at(num_points);
}

}  // namespace

ShellSurface::ShellSurface(std::shared_ptr<const ParametricSurface> surface,
                           const ParameterDomain::Options& domain,
                           Ghosts ghosts)
    : surface_(std::move(surface)), domain_(domain), basis_(domain_->mesh()) {
  if (ghosts == Ghosts::kFolded) folded_ = domain_->FoldedGhosts();
  MakeFolds();
  active_.assign(mesh().num_vertices, 0);
  FindSizes();
}

ShellSurface::ShellSurface(LoopMesh mesh)
    : loop_(std::move(mesh)), basis_(loop_.mesh), folded_(loop_.folds) {
  MakeFolds();
  active_.assign(loop_.mesh.num_vertices, 0);
  std::vector<int> valence(loop_.mesh.num_vertices, 0);
  for (const auto& triangle : loop_.mesh.triangles) {
    for (const int vertex : triangle) ++valence[vertex];
  }
  extraordinary_.assign(num_elements(), 0);
  for (int e = 0; e < num_elements(); ++e) {
    for (int k = 0; k < 3; ++k) {
      if (valence[loop_.mesh.triangles[e][k]] != 6) extraordinary_[e] |= 1u << k;
    }
  }
  FindSizes();
}

void ShellSurface::FindSizes() {
  for (int e = 0; e < num_elements(); ++e) {
    for (const int vertex : control_vertices(e)) active_[vertex] = 1;
  }
  num_active_ = static_cast<int>(std::count(active_.begin(), active_.end(), 1));
  constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  // Numbers in the order of the elements, for all vertices of the same place.
  std::vector<int> number(mesh().num_vertices, -1);
  const auto place = [this](int vertex) {
    return loop_.places.empty() ? vertex : loop_.places[vertex];
  };
  Eigen::AlignedBox3d box;
  for (int e = 0; e < num_elements(); ++e) {
    const RestJet jet = Rest({e, 1.0 / 3.0, 1.0 / 3.0});
    area_ += 0.5 * jet.x_s.cross(jet.x_t).norm();
    for (int k = 0; k < 3; ++k) {
      int& corner = number[place(mesh().triangles[e][k])];
      if (corner >= 0) continue;
      corner = static_cast<int>(vertex_points_.size());
      vertex_points_.push_back({e, kCorner[k][0], kCorner[k][1]});
      box.extend(Position(vertex_points_.back()));
    }
  }
  corners_.resize(mesh().num_vertices);
  for (int i = 0; i < mesh().num_vertices; ++i) corners_[i] = number[place(i)];
  size_ = box.diagonal().norm();
}

void ShellSurface::MakeFolds() {
  if (folded_.empty()) return;
  folds_.resize(num_elements());
  for (int e = 0; e < num_elements(); ++e) {
    const std::vector<int>& ring = basis_.control_vertices(e);
    bool is_plain = true;
    for (const int vertex : ring) {
      is_plain = is_plain && folded_[vertex].size() == 1 && folded_[vertex][0].first == vertex;
    }
    if (is_plain) continue;
    std::vector<int>& vertices = folds_[e].vertices;
    for (const int vertex : ring) {
      for (const auto& term : folded_[vertex]) vertices.push_back(term.first);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    folds_[e].matrix = Eigen::MatrixXd::Zero(ring.size(), vertices.size());
    for (size_t i = 0; i < ring.size(); ++i) {
      for (const auto& term : folded_[ring[i]]) {
        const auto column = std::lower_bound(vertices.begin(), vertices.end(), term.first);
        folds_[e].matrix(i, column - vertices.begin()) += term.second;
      }
    }
  }
}

std::array<double, 2> ShellSurface::Parameters(const ElementPoint& point) const {
  if (!is_parametric()) return {0.0, 0.0};
  const auto q = domain_->Lattice(point);
  return {domain_->Parameter(0, q[0])[0], domain_->Parameter(1, q[1])[0]};
}

Eigen::Vector3d ShellSurface::Position(const ElementPoint& point) const {
  if (is_parametric()) return ParametricJet(point).x;
  const BasisMatrix basis = basis_.Evaluate(point.element, point.s, point.t);
  const std::vector<int>& vertices = basis_.control_vertices(point.element);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < vertices.size(); ++i)
    x += basis(kValue, i) * loop_.points.col(vertices[i]);
  return x;
}

SurfaceJet ShellSurface::ParametricJet(const ElementPoint& point) const {
  CHECK(is_parametric());
  const auto uv = Parameters(point);
  return surface_->Evaluate(uv[0], uv[1]);
}

RestJet ShellSurface::Rest(int element, const BasisMatrix& basis) const {
  Eigen::Matrix<double, 3, 6> jet = Eigen::Matrix<double, 3, 6>::Zero();
  const std::vector<int>& vertices = basis_.control_vertices(element);
  for (size_t i = 0; i < vertices.size(); ++i) {
    jet += loop_.points.col(vertices[i]) * basis.col(i).transpose();
  }
  return {jet.col(kValue), jet.col(kDs), jet.col(kDt), jet.col(kDss), jet.col(kDst), jet.col(kDtt)};
}

RestJet ShellSurface::Rest(const ElementPoint& point) const {
  if (!is_parametric()) {
    return Rest(point.element, basis_.Evaluate(point.element, point.s, point.t));
  }
  const auto q = domain_->Lattice(point);
  const auto u = domain_->Parameter(0, q[0]);
  const auto v = domain_->Parameter(1, q[1]);
  const SurfaceJet jet = surface_->Evaluate(u[0], v[0]);
  // Grading: sigma as a function of the lattice coordinates.
  const Eigen::Vector3d x_1 = jet.x_u * u[1];
  const Eigen::Vector3d x_2 = jet.x_v * v[1];
  const Eigen::Vector3d x_11 = jet.x_uu * (u[1] * u[1]) + jet.x_u * u[2];
  const Eigen::Vector3d x_12 = jet.x_uv * (u[1] * v[1]);
  const Eigen::Vector3d x_22 = jet.x_vv * (v[1] * v[1]) + jet.x_v * v[2];
  // Element axes are (1,0), (1,1) or (1,1), (0,1) in the lattice.
  const auto axes = ParameterDomain::ElementAxes(point.element);
  const auto first = [&](int k) -> Eigen::Vector3d { return axes[k][0] * x_1 + axes[k][1] * x_2; };
  const auto second = [&](int k, int l) -> Eigen::Vector3d {
    return (axes[k][0] * axes[l][0]) * x_11 +
           (axes[k][0] * axes[l][1] + axes[k][1] * axes[l][0]) * x_12 +
           (axes[k][1] * axes[l][1]) * x_22;
  };
  return {jet.x, first(0), first(1), second(0, 0), second(0, 1), second(1, 1)};
}

StrainPoint ShellSurface::MakePoint(const ElementPoint& point,
                                    const BasisMatrix& basis,
                                    double quadrature_weight) const {
  if (!is_parametric()) {
    // t1 along a coordinate axis as the tangent plane sees it: the same from all elements around.
    const RestJet rest = Rest(point.element, basis);
    const Eigen::Vector3d normal = rest.x_s.cross(rest.x_t);
    constexpr double kSteep = 0.9;
    const bool steep = std::abs(normal.x()) > kSteep * normal.norm();
    const Eigen::Vector3d axis = steep ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    StrainPoint result = MakeStrainPoint(
        rest,
        basis,
        Eigen::Vector2d(rest.x_t.cross(normal).dot(axis), normal.cross(rest.x_s).dot(axis)),
        quadrature_weight);
    if (IsFolded(point.element)) {
      result.weights = (result.weights * folds_[point.element].matrix).eval();
    }
    return result;
  }
  // t1 along the u-line: (1, 0) in the lattice is s for even elements, s - t for odd ones.
  const Eigen::Vector2d u_line =
      point.element % 2 == 0 ? Eigen::Vector2d(1.0, 0.0) : Eigen::Vector2d(1.0, -1.0);
  StrainPoint result = MakeStrainPoint(Rest(point), basis, u_line, quadrature_weight);
  if (IsFolded(point.element))
    result.weights = (result.weights * folds_[point.element].matrix).eval();
  return result;
}

StrainPoint ShellSurface::MakePoint(const ElementPoint& point, double quadrature_weight) const {
  return MakePoint(point, basis_.Evaluate(point.element, point.s, point.t), quadrature_weight);
}

Eigen::VectorXd ShellSurface::ValueWeights(const ElementPoint& point) const {
  const BasisMatrix basis = basis_.Evaluate(point.element, point.s, point.t);
  if (!IsFolded(point.element)) return basis.row(kValue).transpose();
  return folds_[point.element].matrix.transpose() * basis.row(kValue).transpose();
}

const std::vector<TrianglePoint>& ShellSurface::Rule(int element, int num_points) const {
  if (extraordinary_.empty() || extraordinary_[element] == 0) return TriangleQuadrature(num_points);
  return NestedRule(num_points, extraordinary_[element]);
}

std::vector<StrainPoint> ShellSurface::QuadraturePoints(int element, int num_points) const {
  const auto& rule = Rule(element, num_points);
  std::vector<StrainPoint> points;
  points.reserve(rule.size());
  for (size_t k = 0; k < rule.size(); ++k) {
    const ElementPoint at{element, rule[k].s, rule[k].t};
    points.push_back(basis_.IsRegular(element)
                         ? MakePoint(at, RegularTable(num_points)[k], rule[k].weight)
                         : MakePoint(at, rule[k].weight));
  }
  return points;
}

void ShellSurface::EvaluateAreaPoint(int element, int num_points, int k, AreaPoint* point) const {
  const TrianglePoint& rule = Rule(element, num_points)[k];
  point->at = {element, rule.s, rule.t};
  if (!is_parametric()) {
    const BasisMatrix basis = basis_.IsRegular(element) ? RegularTable(num_points)[k]
                                                        : basis_.Evaluate(element, rule.s, rule.t);
    const RestJet rest = Rest(element, basis);
    const Eigen::Vector3d normal = rest.x_s.cross(rest.x_t);
    point->position = rest.x;
    point->n = normal.normalized();
    point->area = rule.weight * normal.norm();
    point->values = basis.row(kValue);
    if (IsFolded(element)) point->values = (point->values * folds_[element].matrix).eval();
    return;
  }
  const auto q = domain_->Lattice(point->at);
  const auto u = domain_->Parameter(0, q[0]);
  const auto v = domain_->Parameter(1, q[1]);
  const SurfaceJet jet = surface_->Evaluate(u[0], v[0]);
  // Both kinds of elements are half a lattice cell with its orientation.
  const Eigen::Vector3d normal = jet.x_u.cross(jet.x_v) * (u[1] * v[1]);
  const double area_element = normal.norm();
  point->position = jet.x;
  point->n = normal / area_element;
  point->area = rule.weight * area_element;
  if (!IsFolded(element) && basis_.IsRegular(element)) {
    point->values = RegularTable(num_points)[k].row(kValue);
  } else {
    point->values = ValueWeights(point->at).transpose();
  }
}

ShellSurface::CurvePoint ShellSurface::MakeCurvePoint(const ElementPoint& at,
                                                      const Eigen::Vector2d& direction,
                                                      double weight) const {
  CurvePoint result;
  result.at = at;
  result.point = MakePoint(at);
  Eigen::Vector3d velocity;
  if (is_parametric()) {
    const auto q = domain_->Lattice(at);
    const auto u = domain_->Parameter(0, q[0]);
    const auto v = domain_->Parameter(1, q[1]);
    const SurfaceJet jet = surface_->Evaluate(u[0], v[0]);
    velocity = jet.x_u * (u[1] * direction.x()) + jet.x_v * (v[1] * direction.y());
  } else {
    const RestJet rest = Rest(at);
    velocity = direction.x() * rest.x_s + direction.y() * rest.x_t;
  }
  result.point.area = weight * velocity.norm();
  result.tangent =
      Eigen::Vector2d(velocity.dot(result.point.t1), velocity.dot(result.point.t2)).normalized();
  result.conormal = Eigen::Vector2d(result.tangent.y(), -result.tangent.x());
  return result;
}

bool ShellSurface::HasSide(Side side) const {
  const int loop = static_cast<int>(side) - static_cast<int>(Loop(0));
  return loop < 0 ? is_parametric() && domain_->HasSide(side) : loop < num_loops();
}

bool ShellSurface::IsClosed(Side side) const {
  if (!is_parametric()) return true;
  const bool along_v = side == Side::kUMin || side == Side::kUMax;
  return domain_->options().periodic[along_v ? 1 : 0];
}

std::vector<ParameterDomain::BoundaryEdge> ShellSurface::BoundaryEdges(Side side) const {
  if (is_parametric()) return domain_->BoundaryEdges(side);
  std::vector<ParameterDomain::BoundaryEdge> edges;
  for (const auto& edge : loop_.loops[static_cast<int>(side) - static_cast<int>(Loop(0))]) {
    edges.push_back({edge.element, edge.begin, edge.end, side});
  }
  return edges;
}

std::vector<ShellSurface::CurvePoint> ShellSurface::SidePoints(Side side,
                                                               int points_per_edge) const {
  std::vector<CurvePoint> points;
  for (const auto& edge : BoundaryEdges(side)) {
    const std::array<double, 2> q0 = is_parametric()
                                         ? domain_->Lattice(edge.begin)
                                         : std::array<double, 2>{edge.begin.s, edge.begin.t};
    const std::array<double, 2> q1 = is_parametric()
                                         ? domain_->Lattice(edge.end)
                                         : std::array<double, 2>{edge.end.s, edge.end.t};
    for (const LinePoint& p : LineQuadrature(points_per_edge)) {
      const ElementPoint at{edge.element,
                            edge.begin.s + p.x * (edge.end.s - edge.begin.s),
                            edge.begin.t + p.x * (edge.end.t - edge.begin.t)};
      CurvePoint point =
          MakeCurvePoint(at, Eigen::Vector2d(q1[0] - q0[0], q1[1] - q0[1]), p.weight);
      // With ascending parameter the outside is on the right at u_max and v_min.
      if (side == Side::kUMin || side == Side::kVMax) point.conormal = -point.conormal;
      points.push_back(std::move(point));
    }
  }
  return points;
}

std::vector<ShellSurface::CurvePoint> ShellSurface::ParameterLinePoints(int parameter,
                                                                        double value,
                                                                        int points_per_edge) const {
  const int along = 1 - parameter;
  const double fixed = domain_->LatticeCoordinate(parameter, value);
  const double cell = std::floor(fixed);
  // Between lattice lines the curve crosses the diagonal of every cell; both parts get a rule.
  const double crossing = fixed - cell;
  std::vector<CurvePoint> points;
  for (int k = 0; k < domain_->options().divisions[along]; ++k) {
    std::vector<double> ends = {0.0, 1.0};
    if (crossing > 1e-12 && crossing < 1.0 - 1e-12) ends.insert(ends.begin() + 1, crossing);
    for (size_t piece = 0; piece + 1 < ends.size(); ++piece) {
      const double length = ends[piece + 1] - ends[piece];
      for (const LinePoint& p : LineQuadrature(points_per_edge)) {
        const double q = k + ends[piece] + p.x * length;
        const ElementPoint at =
            parameter == 0 ? domain_->LocateLattice(fixed, q) : domain_->LocateLattice(q, fixed);
        const Eigen::Vector2d direction =
            parameter == 0 ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX();
        points.push_back(MakeCurvePoint(at, direction, p.weight * length));
      }
    }
  }
  return points;
}

ElementPoint ShellSurface::ClosestPointOnMesh(const Eigen::Vector3d& x) const {
  // Elements by the distance of their middle; the nearest point is on one of the first few, or the
  // mesh is too coarse for its own shape.
  constexpr int kCandidates = 24;
  std::vector<std::pair<double, int>> order;
  for (int e = 0; e < num_elements(); ++e) {
    // The middle of the control triangle will do.
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int vertex : mesh().triangles[e]) middle += loop_.points.col(vertex) / 3.0;
    double distance = (middle - x).norm();
    if (!loop_.hanging.empty()) {  // Larger elements reach farther.
      distance -= (loop_.points.col(mesh().triangles[e][0]) - middle).norm();
    }
    order.push_back({distance, e});
  }
  const size_t count = std::min<size_t>(order.size(), kCandidates);
  std::partial_sort(order.begin(), order.begin() + count, order.end());
  ElementPoint best;
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t c = 0; c < count; ++c) {
    const int e = order[c].second;
    for (const Eigen::Vector2d& start : {Eigen::Vector2d(1.0 / 3.0, 1.0 / 3.0),
                                         Eigen::Vector2d(0.1, 0.1),
                                         Eigen::Vector2d(0.8, 0.1),
                                         Eigen::Vector2d(0.1, 0.8)}) {
      Eigen::Vector2d q = start;
      double value = (Position({e, q.x(), q.y()}) - x).squaredNorm();
      // Gauss-Newton with the curvature where it helps, within the triangle; along an edge once it
      // is reached.
      for (int iteration = 0; iteration < 40; ++iteration) {
        const RestJet jet = Rest({e, q.x(), q.y()});
        Eigen::Matrix<double, 3, 2> j;
        j << jet.x_s, jet.x_t;
        const Eigen::Vector3d r = jet.x - x;
        const Eigen::Vector2d gradient = j.transpose() * r;
        Eigen::Matrix2d hessian = j.transpose() * j, newton = hessian;
        newton(0, 0) += r.dot(jet.x_ss);
        newton(1, 1) += r.dot(jet.x_tt);
        newton(0, 1) += r.dot(jet.x_st);
        newton(1, 0) = newton(0, 1);
        if (newton(0, 0) > 0.0 && newton.determinant() > 1e-6 * hessian.determinant() &&
            newton.allFinite()) {
          hessian = newton;
        }
        // The whole plane, then along each edge: the first that descends within the triangle.
        bool moved = false;
        const Eigen::Vector2d edges[3] = {{1.0, 0.0}, {0.0, 1.0}, {1.0, -1.0}};
        for (int way = 0; way < 4 && !moved; ++way) {
          Eigen::Vector2d step;
          if (way == 0) {
            step = -hessian.ldlt().solve(gradient);
          } else {
            const Eigen::Vector2d& d = edges[way - 1];
            step = -(d.dot(gradient) / d.dot(hessian * d)) * d;
          }
          // Up to the boundary of the triangle.
          double part = 1.0;
          const auto limit = [&part](double at, double change) {
            if (at + change < 0.0) part = std::min(part, std::max(0.0, -at / change));
          };
          limit(q.x(), step.x());
          limit(q.y(), step.y());
          limit(1.0 - q.x() - q.y(), -step.x() - step.y());
          for (double factor = part; factor > 1e-4 * part && !moved; factor *= 0.5) {
            Eigen::Vector2d trial = (q + factor * step).cwiseMax(0.0);
            if (trial.sum() > 1.0) trial /= trial.sum();
            const double there = (Position({e, trial.x(), trial.y()}) - x).squaredNorm();
            if (there < value) {
              moved = (trial - q).norm() > 1e-14;
              q = trial;
              value = there;
            }
          }
        }
        if (!moved) break;
      }
      if (value < nearest) {
        nearest = value;
        best = {e, q.x(), q.y()};
      }
    }
  }
  return best;
}

ElementPoint ShellSurface::ClosestPoint(const Eigen::Vector3d& x) const {
  if (!is_parametric()) return ClosestPointOnMesh(x);
  const int m = domain_->options().divisions[0], n = domain_->options().divisions[1];
  const auto distance = [&](double q1, double q2) {
    return (Position(domain_->LocateLattice(q1, q2)) - x).squaredNorm();
  };
  // Candidates: lattice points at half steps that are no farther than their neighbours.
  const int rows = 2 * n + 1, columns = 2 * m + 1;
  Eigen::MatrixXd d(columns, rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) d(i, j) = distance(0.5 * i, 0.5 * j);
  }
  std::vector<std::pair<double, std::pair<int, int>>> candidates;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      bool lowest = true;
      for (int dj = -1; dj <= 1 && lowest; ++dj) {
        for (int di = -1; di <= 1 && lowest; ++di) {
          const int k = i + di, l = j + dj;
          if (k >= 0 && k < columns && l >= 0 && l < rows) lowest = d(i, j) <= d(k, l);
        }
      }
      if (lowest) candidates.push_back({d(i, j), {i, j}});
    }
  }
  std::sort(candidates.begin(), candidates.end());
  if (candidates.size() > 16) candidates.resize(16);

  double best = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best_q(0.0, 0.0);
  for (const auto& candidate : candidates) {
    Eigen::Vector2d q(0.5 * candidate.second.first, 0.5 * candidate.second.second);
    double value = candidate.first;
    // Damped Newton within the rectangle, Gauss-Newton where the distance is not convex. A
    // coordinate at its bound is free to come back.
    for (int iteration = 0; iteration < 50; ++iteration) {
      const auto u = domain_->Parameter(0, q.x());
      const auto v = domain_->Parameter(1, q.y());
      const SurfaceJet jet = surface_->Evaluate(u[0], v[0]);
      Eigen::Matrix<double, 3, 2> j;
      j << jet.x_u * u[1], jet.x_v * v[1];
      const Eigen::Vector3d r = jet.x - x;
      Eigen::Vector2d gradient = j.transpose() * r;
      Eigen::Matrix2d hessian = j.transpose() * j;
      Eigen::Matrix2d newton = hessian;
      newton(0, 0) += r.dot(jet.x_uu * (u[1] * u[1]) + jet.x_u * u[2]);
      newton(1, 1) += r.dot(jet.x_vv * (v[1] * v[1]) + jet.x_v * v[2]);
      newton(0, 1) += r.dot(jet.x_uv * (u[1] * v[1]));
      newton(1, 0) = newton(0, 1);
      const double upper[2] = {static_cast<double>(m), static_cast<double>(n)};
      for (int k = 0; k < 2; ++k) {
        if ((q[k] <= 0.0 && gradient[k] > 0.0) || (q[k] >= upper[k] && gradient[k] < 0.0)) {
          hessian(k, 1 - k) = hessian(1 - k, k) = 0.0;
          newton(k, 1 - k) = newton(1 - k, k) = 0.0;
          newton(k, k) = hessian(k, k);
          gradient[k] = 0.0;
        }
      }
      // Close to a centre of curvature it is small but right: Gauss-Newton would creep.
      if (newton(0, 0) > 0.0 && newton.determinant() > 1e-12 * hessian.determinant()) {
        hessian = newton;
      }
      // What the rectangle cuts off the step can leave one that does not descend; the coordinates
      // taken one by one always do.
      bool moved = false;
      for (const bool coupled : {true, false}) {
        Eigen::Vector2d step = -hessian.ldlt().solve(gradient);
        if (!coupled) {
          for (int k = 0; k < 2; ++k) {
            step[k] = hessian(k, k) > 0.0 ? -gradient[k] / hessian(k, k) : 0.0;
          }
        }
        for (double factor = 1.0; factor > 1e-4 && !moved; factor *= 0.5) {
          const Eigen::Vector2d trial = (q + factor * step)
                                            .cwiseMax(Eigen::Vector2d::Zero())
                                            .cwiseMin(Eigen::Vector2d(upper[0], upper[1]));
          const double trial_value = distance(trial.x(), trial.y());
          if (trial_value < value) {
            moved = (trial - q).norm() > 1e-14 * (m + n);
            q = trial;
            value = trial_value;
          }
        }
        if (moved) break;
      }
      if (!moved) break;
    }
    if (value < best) {
      best = value;
      best_q = q;
    }
  }
  return domain_->LocateLattice(best_q.x(), best_q.y());
}

}  // namespace darboux
