#include "solver/support_conditions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "geometry/quadrature.h"

namespace darboux {
namespace {

// Support springs relative to the stiffness of the membrane over one element; rotations are held by
// the same springs at the arm of one element height. Alone they would give way by strain * element
// / kStiffness; multipliers take that up (ShellProblem::UpdateMultipliers), each update gaining
// about kStiffness in accuracy. Stiffer springs turn rounding of the displacements into forces (a
// thin hemisphere's relative gradient ends at 7e-8 with 1e4, at 2e-8 with 3e3); softer ones let the
// multipliers of conditions that all but depend on each other settle slowly (an inflated sphere
// takes 5 mixed iterations with 1e4, 8 with 3e3, 17 with 1e3).
constexpr double kStiffness = 3e3;

// Gauss points per element edge in the weighted means.
constexpr int kPointsPerEdge = 4;

std::string Where(const SceneLocation& location) {
  return location.file + ":" + std::to_string(location.line) + ": " + location.key + ": ";
}

// What a condition holds at a point.
struct Row {
  Eigen::Vector3d direction;
  bool derivative;        // of the displacement along `along`, otherwise the displacement itself
  Eigen::Vector2d along;  // in the frame's components
  double stiffness;       // per point, or per length and height of the element on a side
  double target;
  double arm = 1.0;  // at which a rotation is held
};

// Adds weight * row to a condition.
void Accumulate(const Row& row,
                const std::vector<int>& vertices,
                const StrainPoint& point,
                const RigidFrame& frame,
                double weight,
                PlacedCondition* condition) {
  Eigen::RowVectorXd factors;
  if (row.derivative) {
    factors = row.along.x() * point.weights.row(kRowD1) + row.along.y() * point.weights.row(kRowD2);
    condition->rigid_row +=
        weight *
        frame.DerivativeRow(row.along.x() * point.t1 + row.along.y() * point.t2, row.direction);
  } else {
    factors = point.weights.row(kRowValue);
    condition->direction += weight * row.direction;
    condition->rigid_row += weight * frame.DisplacementRow(point.position, row.direction);
  }
  condition->target += weight * row.target;
  for (size_t i = 0; i < vertices.size(); ++i) {
    size_t column = 0;
    while (column < condition->vertices.size() && condition->vertices[column] != vertices[i]) {
      ++column;
    }
    if (column == condition->vertices.size()) {
      condition->vertices.push_back(vertices[i]);
      condition->coefficients.conservativeResize(3, column + 1);
      condition->coefficients.col(column).setZero();
    }
    condition->coefficients.col(column) += weight * factors[i] * row.direction;
  }
}

PlacedCondition Place(const Row& row,
                      const std::vector<int>& vertices,
                      const StrainPoint& point,
                      const RigidFrame& frame) {
  PlacedCondition condition;
  condition.stiffness = row.stiffness;
  condition.arm = row.arm;
  Accumulate(row, vertices, point, frame, 1.0, &condition);
  return condition;
}

// Components that a support holds, as unit vectors with targets.
void AddDisplacementRows(const SupportSpec& support,
                         const Eigen::Vector3d& target,
                         double stiffness,
                         std::vector<Row>* rows) {
  if (support.kind == SupportSpec::Kind::kSymmetry) {
    const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
    rows->push_back({normal, false, {0.0, 0.0}, stiffness, 0.0});
    return;
  }
  for (int c = 0; c < 3; ++c) {
    if (support.kind == SupportSpec::Kind::kFix && !support.fix[c]) continue;
    rows->push_back({Eigen::Vector3d::Unit(c), false, {0.0, 0.0}, stiffness, target[c]});
  }
}

// Rows of a support at a point of a side; stiffness per unit of length / height of the element.
// `height` of the element over its edge is the arm at which rotations are held.
std::vector<Row> SideRows(const SupportSpec& support,
                          const ShellSurface::CurvePoint& edge,
                          const Eigen::Vector3d& target,
                          double height,
                          const Material& material) {
  std::vector<Row> rows;
  AddDisplacementRows(support, target, kStiffness * material.MembraneStiffness(), &rows);
  const double rotation = kStiffness * material.MembraneStiffness() * height * height;
  if (support.kind == SupportSpec::Kind::kClamped) {
    // With the edge held, x_v . n = 0 keeps the normal; linear in d_v for any rotation.
    rows.push_back({edge.point.n, true, edge.conormal, rotation, 0.0, height});
  } else if (support.kind == SupportSpec::Kind::kSymmetry) {
    // The mirrored field is smooth: the derivative across has no part within the plane.
    const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
    rows.push_back({edge.point.n, true, edge.conormal, rotation, 0.0, height});
    rows.push_back({normal.cross(edge.point.n), true, edge.conormal, rotation, 0.0, height});
  }
  return rows;
}

void AddSide(const SupportSpec& support,
             Side side,
             const ShellSurface& surface,
             const Material& material,
             const RigidFrame& frame,
             SupportConditions* result) {
  const auto points = surface.SidePoints(side, kPointsPerEdge);
  const auto& rule = LineQuadrature(kPointsPerEdge);
  const int num_edges = static_cast<int>(points.size()) / kPointsPerEdge;
  const bool closed = surface.IsClosed(side);
  const int num_vertices = closed ? num_edges : num_edges + 1;
  std::vector<std::vector<PlacedCondition>> conditions(num_vertices);
  std::vector<double> lengths(num_vertices, 0.0);
  for (int e = 0; e < num_edges; ++e) {
    for (int q = 0; q < kPointsPerEdge; ++q) {
      const auto& edge = points[e * kPointsPerEdge + q];
      // Height of the element over this edge, from its area element.
      const double edge_speed = edge.point.area / rule[q].weight;
      const double height = surface.MakePoint(edge.at, 1.0).area / edge_speed;
      const auto rows = SideRows(
          support, edge, EvaluateAt(support.displacement, surface, edge.at), height, material);
      const auto& vertices = surface.control_vertices(edge.at.element);
      for (int end = 0; end < 2; ++end) {
        const int k = (e + end) % num_vertices;
        const double hat = end == 0 ? 1.0 - rule[q].x : rule[q].x;
        const double weight = hat * edge.point.area;
        if (conditions[k].empty()) conditions[k].resize(rows.size());
        for (size_t r = 0; r < rows.size(); ++r) {
          Accumulate(rows[r], vertices, edge.point, frame, weight, &conditions[k][r]);
          conditions[k][r].stiffness += rows[r].stiffness * weight / height;
          conditions[k][r].arm = rows[r].arm;
        }
        lengths[k] += weight;
      }
    }
  }
  for (int k = 0; k < num_vertices; ++k) {
    for (PlacedCondition& condition : conditions[k]) {
      // The mean, not the integral.
      condition.coefficients /= lengths[k];
      condition.direction /= lengths[k];
      condition.rigid_row /= lengths[k];
      condition.target /= lengths[k];
      result->conditions.push_back(std::move(condition));
    }
  }
  if (closed) return;
  // A corner carries a concentrated reaction (Kirchhoff's corner force), which no mean along the
  // side can represent: the displacement itself is held there too.
  for (const bool first : {true, false}) {
    const auto boundary = surface.BoundaryEdges(side);
    const ElementPoint at = first ? boundary.front().begin : boundary.back().end;
    const StrainPoint point = surface.MakePoint(at);
    std::vector<Row> rows;
    AddDisplacementRows(support,
                        EvaluateAt(support.displacement, surface, at),
                        kStiffness * material.MembraneStiffness(),
                        &rows);
    for (const Row& row : rows) {
      result->conditions.push_back(Place(row, surface.control_vertices(at.element), point, frame));
    }
  }
}

// Surface points of a lattice with `parts` points on each edge of an element.
std::vector<ElementPoint> LatticePoints(const ShellSurface& surface, int parts) {
  if (parts == 1) return surface.vertex_points();
  std::vector<ElementPoint> points;
  // What elements share: the ends of the edge and the number on it, from the lower end.
  std::set<std::array<int, 3>> seen;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto is_new = [&](int edge, int number) {
      int a = surface.Corner(e, edge), b = surface.Corner(e, (edge + 1) % 3);
      const int middle = surface.HangingCorner(e, edge);
      if (middle >= 0) {  // On one of the edges of the elements across.
        number *= 2;
        if (number < parts) {
          b = middle;
        } else {
          a = middle;
          number -= parts;
        }
      }
      if (a > b) {
        std::swap(a, b);
        number = parts - number;
      }
      if (number == 0) b = a;
      if (number == parts) {
        a = b;
        number = 0;
      }
      return seen.insert({a, b, number}).second;
    };
    for (int j = 0; j <= parts; ++j) {
      for (int i = 0; i + j <= parts; ++i) {
        bool own = true;  // AB, BC, CA
        if (j == 0) {
          own = is_new(0, i);
        } else if (i + j == parts) {
          own = is_new(1, j);
        } else if (i == 0) {
          own = is_new(2, parts - j);
        }
        if (own) {
          points.push_back({e, static_cast<double>(i) / parts, static_cast<double>(j) / parts});
        }
      }
    }
  }
  return points;
}

void AddNeighbourhood(const SupportSpec& support,
                      const ShellSurface& surface,
                      const Material& material,
                      const RigidFrame& frame,
                      SupportConditions* result) {
  const Eigen::Vector3d center(support.on.center[0], support.on.center[1], support.on.center[2]);
  std::vector<ElementPoint> points;
  if (support.on.radius > 0.0) {
    // Lattice vertices, or a finer lattice until the neighbourhood is more than a few points, so
    // that one smaller than a cell still holds as an area does.
    constexpr size_t kFewest = 7;
    for (int parts = 1; parts <= 16 && points.size() < kFewest; parts *= 2) {
      points.clear();
      if (!surface.is_parametric()) {
        for (const ElementPoint& point : LatticePoints(surface, parts)) {
          if ((surface.Position(point) - center).norm() <= support.on.radius) {
            points.push_back(point);
          }
        }
        continue;
      }
      const auto& options = surface.domain().options();
      const int last[2] = {parts * options.divisions[0] - (options.periodic[0] ? 1 : 0),
                           parts * options.divisions[1] - (options.periodic[1] ? 1 : 0)};
      for (int j = 0; j <= last[1]; ++j) {
        for (int i = 0; i <= last[0]; ++i) {
          const ElementPoint point = surface.domain().LocateLattice(static_cast<double>(i) / parts,
                                                                    static_cast<double>(j) / parts);
          if ((surface.Position(point) - center).norm() <= support.on.radius) {
            points.push_back(point);
          }
        }
      }
    }
  }
  if (points.empty()) points.push_back(surface.ClosestPoint(center));
  for (const ElementPoint& at : points) {
    const StrainPoint point = surface.MakePoint(at);
    std::vector<Row> rows;
    AddDisplacementRows(support,
                        EvaluateAt(support.displacement, surface, at),
                        kStiffness * material.MembraneStiffness(),
                        &rows);
    const double element_area = 0.5 * surface.MakePoint(at, 1.0).area;
    const double arm = std::sqrt(element_area);
    const double rotation = kStiffness * material.MembraneStiffness() * element_area;
    const bool holds_normal =
        support.kind == SupportSpec::Kind::kClamped || support.kind == SupportSpec::Kind::kSymmetry;
    if (support.kind == SupportSpec::Kind::kClamped) {
      rows.push_back({point.n, true, {1.0, 0.0}, rotation, 0.0, arm});
      rows.push_back({point.n, true, {0.0, 1.0}, rotation, 0.0, arm});
      if (points.size() == 1) {  // Otherwise the held points already stop the spin about n.
        rows.push_back({point.t2, true, {1.0, 0.0}, rotation, 0.0, arm});
      }
    } else if (holds_normal) {
      const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
      const Eigen::Vector2d along(normal.dot(point.t1), normal.dot(point.t2));
      rows.push_back({point.n, true, along, rotation, 0.0, arm});
      rows.push_back({normal.cross(point.n), true, along, rotation, 0.0, arm});
    }
    for (const Row& row : rows) {
      result->conditions.push_back(Place(row, surface.control_vertices(at.element), point, frame));
    }
  }
}

// A mirror plane must contain the side, and the shell must meet it at a right angle.
bool CheckSymmetry(const SupportSpec& support,
                   Side side,
                   const ShellSurface& surface,
                   std::string* error) {
  const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
  const auto points = surface.SidePoints(side, 2);
  for (const auto& edge : points) {
    const double off = (edge.point.position - points.front().point.position).dot(normal);
    const double tilt = edge.point.n.dot(normal);
    if (std::abs(off) > 1e-6 * surface.size() || std::abs(tilt) > 1e-6) {
      *error = Where(support.location) +
               "found a side that does not lie in one plane with this normal and meet it at a "
               "right angle; allowed is a plane of mirror symmetry of the shell";
      return false;
    }
  }
  return true;
}

// The same for a neighbourhood, at its middle.
bool CheckNearSymmetry(const SupportSpec& support,
                       const ShellSurface& surface,
                       std::string* error) {
  const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
  const Eigen::Vector3d center(support.on.center[0], support.on.center[1], support.on.center[2]);
  if (std::abs(surface.MakePoint(surface.ClosestPoint(center)).n.dot(normal)) <= 1e-6) return true;
  *error = Where(support.location) +
           "found a mirror plane that does not meet the shell at a right angle there; allowed is a "
           "plane of mirror symmetry of the shell";
  return false;
}

// boundary_rule seed_ghosts: the boundary ring (and for a clamped side the ring inside it) is zero.
void AddFixedRings(const SupportSpec& support,
                   Side side,
                   const ShellSurface& surface,
                   SupportConditions* result) {
  const auto& domain = surface.domain();
  const int m = domain.options().divisions[0], n = domain.options().divisions[1];
  const int rings = support.kind == SupportSpec::Kind::kClamped ? 2 : 1;
  for (int ring = 0; ring < rings; ++ring) {
    const bool along_v = side == Side::kUMin || side == Side::kUMax;
    for (int k = 0; k <= (along_v ? n : m); ++k) {
      const int i = side == Side::kUMin ? ring : side == Side::kUMax ? m - ring : k;
      const int j = side == Side::kVMin ? ring : side == Side::kVMax ? n - ring : k;
      if (i >= 0 && i <= m && j >= 0 && j <= n) {
        result->fixed_vertices.push_back(domain.VertexIndex(i, j));
      }
    }
  }
}

bool IsZero(const SceneVector& value) {
  const double zeros[5] = {};
  for (const SceneValue& c : value.component) {
    if (!c.expression.IsConstant() || c.expression.Evaluate(zeros) != 0.0) return false;
  }
  return true;
}

}  // namespace

double EvaluateAt(const SceneValue& value, const ShellSurface& surface, const ElementPoint& point) {
  const auto uv = surface.Parameters(point);
  const Eigen::Vector3d x =
      value.expression.IsConstant() ? Eigen::Vector3d::Zero().eval() : surface.Position(point);
  const double variables[5] = {uv[0], uv[1], x[0], x[1], x[2]};
  return value.expression.Evaluate(variables);
}

Eigen::Vector3d EvaluateAt(const SceneVector& value,
                           const ShellSurface& surface,
                           const ElementPoint& point) {
  return {EvaluateAt(value.component[0], surface, point),
          EvaluateAt(value.component[1], surface, point),
          EvaluateAt(value.component[2], surface, point)};
}

ElementPoint Resolve(const SurfacePoint& point, const ShellSurface& surface) {
  if (point.kind == SurfacePoint::Kind::kUv) {
    return surface.domain().Locate(point.uv[0], point.uv[1]);
  }
  return surface.ClosestPoint({point.nearest[0], point.nearest[1], point.nearest[2]});
}

std::vector<Side> SidesOf(const Region& region, const ShellSurface& surface) {
  std::vector<Side> sides;
  const auto add = [&](Region::Kind kind, Side side) {
    if ((region.kind == kind || region.kind == Region::Kind::kRim) && surface.HasSide(side)) {
      sides.push_back(side);
    }
  };
  add(Region::Kind::kUMin, Side::kUMin);
  add(Region::Kind::kUMax, Side::kUMax);
  add(Region::Kind::kVMin, Side::kVMin);
  add(Region::Kind::kVMax, Side::kVMax);
  for (int k = 0; k < surface.num_loops(); ++k) add(Region::Kind::kRim, ShellSurface::Loop(k));
  return sides;
}

PlacedCondition PointCondition(const ShellSurface& surface,
                               const ElementPoint& at,
                               const Eigen::Vector3d& direction,
                               const Material& material,
                               const RigidFrame& frame) {
  return Place({direction, false, {0.0, 0.0}, material.MembraneStiffness(), 0.0},
               surface.control_vertices(at.element),
               surface.MakePoint(at),
               frame);
}

bool MakeSupportConditions(const Scene& scene,
                           const ShellSurface& surface,
                           const Material& material,
                           const RigidFrame& frame,
                           SupportConditions* result,
                           std::string* error) {
  const bool seed = scene.model.boundary_rule == BoundaryRule::kSeedGhosts;
  for (size_t index = 0; index < scene.supports.size(); ++index) {
    const SupportSpec& support = scene.supports[index];
    const size_t first = result->conditions.size();
    const auto mark = [&] {
      for (size_t i = first; i < result->conditions.size(); ++i) {
        result->conditions[i].support = static_cast<int>(index);
      }
    };
    if (support.on.kind == Region::Kind::kNear) {
      if (support.kind == SupportSpec::Kind::kSymmetry &&
          !CheckNearSymmetry(support, surface, error)) {
        return false;
      }
      AddNeighbourhood(support, surface, material, frame, result);
      mark();
      continue;
    }
    for (const Side side : SidesOf(support.on, surface)) {
      if (support.kind == SupportSpec::Kind::kSymmetry &&
          !CheckSymmetry(support, side, surface, error)) {
        return false;
      }
      const bool ring_rule = seed && IsZero(support.displacement) &&
                             (support.kind == SupportSpec::Kind::kClamped ||
                              support.kind == SupportSpec::Kind::kSimplySupported);
      if (ring_rule) {
        AddFixedRings(support, side, surface, result);
        for (const auto& edge : surface.SidePoints(side, 1)) {  // for the rigid-motion check only
          std::vector<Row> rows;
          AddDisplacementRows(support, Eigen::Vector3d::Zero(), 0.0, &rows);
          if (support.kind == SupportSpec::Kind::kClamped) {
            rows.push_back({edge.point.n, true, edge.conormal, 0.0, 0.0});
          }
          for (const Row& row : rows) {
            result->conditions.push_back(
                Place(row, surface.control_vertices(edge.at.element), edge.point, frame));
          }
        }
      } else {
        AddSide(support, side, surface, material, frame, result);
      }
    }
    mark();
  }
  auto& fixed = result->fixed_vertices;
  std::sort(fixed.begin(), fixed.end());
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
  return true;
}

}  // namespace darboux
