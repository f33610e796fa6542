#include "solver/support_conditions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace darboux {
namespace {

// Support springs relative to the shell's own stiffness over one element. The error they leave
// falls like 1 / kStiffness and h^2 or faster; the digits they cost in the factorisation grow with
// it. Measured flat between 1e3 and 1e9 (tests/support_test.cc).
constexpr double kStiffness = 1e6;

// Gauss points per element edge; see costs/support.h for why not more.
constexpr int kPointsPerEdge = 1;

std::string Where(const SceneLocation& location) {
  return location.file + ":" + std::to_string(location.line) + ": " + location.key + ": ";
}

// What a condition holds at a point.
struct Row {
  Eigen::Vector3d direction;
  bool derivative;          // of the displacement along `along`, otherwise the displacement itself
  Eigen::Vector2d along;    // in the frame's components
  double stiffness;
  double target;
};

PlacedCondition Place(const Row& row,
                      int element,
                      const StrainPoint& point,
                      const RigidFrame& frame) {
  PlacedCondition condition;
  condition.element = element;
  condition.stiffness = row.stiffness;
  condition.target = row.target;
  if (row.derivative) {
    condition.coefficients =
        row.direction * (row.along.x() * point.weights.row(kRowD1) +
                         row.along.y() * point.weights.row(kRowD2));
    condition.rigid_row = frame.DerivativeRow(row.along.x() * point.t1 + row.along.y() * point.t2,
                                              row.direction);
  } else {
    condition.coefficients = row.direction * point.weights.row(kRowValue);
    condition.direction = row.direction;
    condition.rigid_row = frame.DisplacementRow(point.position, row.direction);
  }
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

void AddSide(const SupportSpec& support,
             Side side,
             const ShellSurface& surface,
             const Material& material,
             const RigidFrame& frame,
             SupportConditions* result) {
  const double membrane = material.MembraneStiffness(), bending = material.BendingStiffness();
  for (const auto& edge : surface.SidePoints(side, kPointsPerEdge)) {
    const StrainPoint& point = edge.point;
    const double length = point.area;
    // Height of the element over this edge.
    const auto element_area =
        0.5 * surface.MakePoint({edge.at.element, 1.0 / 3.0, 1.0 / 3.0}, 1.0).area;
    const double height = 2.0 * element_area / (length * kPointsPerEdge);
    std::vector<Row> rows;
    AddDisplacementRows(support,
                        EvaluateAt(support.displacement, surface, edge.at),
                        kStiffness * membrane * length / height,
                        &rows);
    const double rotation = kStiffness * bending * length / height;
    if (support.kind == SupportSpec::Kind::kClamped) {
      // With the edge held, x_v . n = 0 keeps the normal; linear in d_v for any rotation.
      rows.push_back({point.n, true, edge.conormal, rotation, 0.0});
    } else if (support.kind == SupportSpec::Kind::kSymmetry) {
      // The mirrored field is smooth: the derivative across has no part within the plane.
      const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
      rows.push_back({point.n, true, edge.conormal, rotation, 0.0});
      rows.push_back({normal.cross(point.n), true, edge.conormal, rotation, 0.0});
    }
    for (const Row& row : rows) {
      result->conditions.push_back(Place(row, edge.at.element, point, frame));
    }
  }
}

void AddNeighbourhood(const SupportSpec& support,
                      const ShellSurface& surface,
                      const Material& material,
                      const RigidFrame& frame,
                      SupportConditions* result) {
  const Eigen::Vector3d center(support.on.center[0], support.on.center[1], support.on.center[2]);
  std::vector<ElementPoint> points;
  const auto& options = surface.domain().options();
  if (support.on.radius > 0.0) {
    const int last[2] = {options.divisions[0] - (options.periodic[0] ? 1 : 0),
                         options.divisions[1] - (options.periodic[1] ? 1 : 0)};
    for (int j = 0; j <= last[1]; ++j) {
      for (int i = 0; i <= last[0]; ++i) {
        const ElementPoint point = surface.domain().LocateLattice(i, j);
        if ((surface.Position(point) - center).norm() <= support.on.radius) {
          points.push_back(point);
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
    const double rotation = kStiffness * material.BendingStiffness();
    const bool holds_normal = support.kind == SupportSpec::Kind::kClamped ||
                              support.kind == SupportSpec::Kind::kSymmetry;
    if (support.kind == SupportSpec::Kind::kClamped) {
      rows.push_back({point.n, true, {1.0, 0.0}, rotation, 0.0});
      rows.push_back({point.n, true, {0.0, 1.0}, rotation, 0.0});
      if (points.size() == 1) {  // Otherwise the held points already stop the spin about n.
        rows.push_back({point.t2, true, {1.0, 0.0}, rotation, 0.0});
      }
    } else if (holds_normal) {
      const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
      const Eigen::Vector2d along(normal.dot(point.t1), normal.dot(point.t2));
      rows.push_back({point.n, true, along, rotation, 0.0});
      rows.push_back({normal.cross(point.n), true, along, rotation, 0.0});
    }
    for (const Row& row : rows) result->conditions.push_back(Place(row, at.element, point, frame));
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
  const Eigen::Vector3d x = value.expression.IsConstant() ? Eigen::Vector3d::Zero().eval()
                                                          : surface.Position(point);
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
    if ((region.kind == kind || region.kind == Region::Kind::kRim) &&
        surface.domain().HasSide(side)) {
      sides.push_back(side);
    }
  };
  add(Region::Kind::kUMin, Side::kUMin);
  add(Region::Kind::kUMax, Side::kUMax);
  add(Region::Kind::kVMin, Side::kVMin);
  add(Region::Kind::kVMax, Side::kVMax);
  return sides;
}

PlacedCondition PointCondition(const ShellSurface& surface,
                               const ElementPoint& at,
                               const Eigen::Vector3d& direction,
                               const Material& material,
                               const RigidFrame& frame) {
  return Place({direction, false, {0.0, 0.0}, material.MembraneStiffness(), 0.0},
               at.element,
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
  for (const SupportSpec& support : scene.supports) {
    if (support.on.kind == Region::Kind::kNear) {
      AddNeighbourhood(support, surface, material, frame, result);
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
          for (int c = 0; c < 3; ++c) {
            PlacedCondition held = Place({Eigen::Vector3d::Unit(c), false, {0.0, 0.0}, 0.0, 0.0},
                                         edge.at.element,
                                         edge.point,
                                         frame);
            result->conditions.push_back(held);
          }
        }
      } else {
        AddSide(support, side, surface, material, frame, result);
      }
    }
  }
  auto& fixed = result->fixed_vertices;
  std::sort(fixed.begin(), fixed.end());
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
  return true;
}

}  // namespace darboux
