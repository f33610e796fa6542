#include "solver/fields.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "costs/strain_measures.h"
#include "geometry/surface_invariants.h"

namespace darboux {
namespace {

// stiffness ((1 - nu) e + nu tr(e) I) of e = (11, 22, 12).
Eigen::Vector3d PlaneStress(double stiffness, double nu, const Eigen::Vector3d& e) {
  return stiffness * Eigen::Vector3d(e[0] + nu * e[1], e[1] + nu * e[0], (1.0 - nu) * e[2]);
}

double Contract(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a[0] * b[0] + a[1] * b[1] + 2.0 * a[2] * b[2];
}

double VonMises(const Eigen::Vector3d& s) {
  // s11^2 - s11 s22 + s22^2 as a sum of squares: the root's argument is never below zero.
  const double mean = 0.5 * (s[0] + s[1]), deviation = 0.5 * (s[0] - s[1]);
  return std::sqrt(mean * mean + 3.0 * (deviation * deviation + s[2] * s[2]));
}

}  // namespace

FieldSite MakeFieldSite(const ShellSurface& surface, const ElementPoint& at) {
  FieldSite site;
  site.element = at.element;
  site.point = surface.MakePoint(at);
  site.uv = surface.Parameters(at);
  const std::optional<SurfaceInvariants> invariants =
      surface.is_parametric() ? EvaluateSurfaceInvariants(surface.ParametricJet(at)) : std::nullopt;
  if (invariants) {
    site.principal_curvatures = invariants->kappa;
    site.principal_direction_1 = invariants->t1;
    site.principal_direction_2 = invariants->t2;
  } else {
    // A mesh, or parameters all but dependent, where the directions have no digits left; the mean
    // is accurate.
    const StrainPoint& p = site.point;
    const double mean = 0.5 * (p.b11 + p.b22), half = 0.5 * (p.b11 - p.b22);
    const double radius = std::hypot(half, p.b12);
    site.principal_curvatures = Eigen::Vector2d(mean + radius, mean - radius);
    // Umbilics have no direction of their own.
    constexpr double kUmbilic = 1e-9;
    const bool umbilic = surface.is_parametric() || !(radius > kUmbilic * std::abs(mean));
    const double angle = umbilic ? 0.0 : 0.5 * std::atan2(p.b12, half);
    site.principal_direction_1 = std::cos(angle) * p.t1 + std::sin(angle) * p.t2;
    site.principal_direction_2 = std::cos(angle) * p.t2 - std::sin(angle) * p.t1;
  }
  return site;
}

ShellFields EvaluateFields(const ShellProblem& problem,
                           const Eigen::Matrix3Xd& displacements,
                           const FieldSite& site) {
  const StrainPoint& p = site.point;
  const Material& material = problem.material();
  const double h = material.thickness, nu = material.poisson_ratio;

  // Columns WeightRow: displacement, d_1, d_2, H_11, H_12, H_22.
  Eigen::Matrix<double, 3, 6> k = Eigen::Matrix<double, 3, 6>::Zero();
  const std::vector<int>& vertices = problem.surface().control_vertices(site.element);
  for (size_t i = 0; i < vertices.size(); ++i) {
    k += displacements.col(vertices[i]) * p.weights.col(i).transpose();
  }

  ShellFields fields;
  fields.position = p.position;
  fields.displacement = k.col(kRowValue);
  const Eigen::Vector3d x1 = p.t1 + k.col(kRowD1), x2 = p.t2 + k.col(kRowD2);
  const Eigen::Vector3d normal = x1.cross(x2);
  const double length = normal.norm();
  const bool has_normal = length > 0.0 && std::isfinite(length);
  fields.normal = has_normal ? Eigen::Vector3d(normal / length) : p.n;

  Eigen::Vector3d& e = fields.membrane_strain;
  EvaluateMembraneStrain(problem.measure(), p, k.col(kRowD1).data(), e.data());
  e[2] *= 0.5;  // The kernels' third component is 2 e_12.
  const double mean = 0.5 * (e[0] + e[1]), radius = std::hypot(0.5 * (e[0] - e[1]), e[2]);
  fields.principal_membrane_strain = Eigen::Vector2d(mean + radius, mean - radius);

  Eigen::Vector3d& rho = fields.bending_strain;
  if (EvaluateBendingStrain(problem.measure(), p, k.col(kRowD1).data(), rho.data())) {
    rho[2] *= 0.5;
  } else {
    rho.setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  fields.membrane_force = PlaneStress(material.MembraneStiffness(), nu, e);
  fields.moment = PlaneStress(material.BendingStiffness(), nu, rho);
  fields.membrane_energy_density = 0.5 * Contract(fields.membrane_force, e);
  fields.bending_energy_density = 0.5 * Contract(fields.moment, rho);
  if (!problem.initial_strains().empty()) {
    const Eigen::Matrix<double, 6, 1> initial = problem.InitialStrain(site.element, p);
    const Eigen::Vector3d e0(initial[0], initial[1], 0.5 * initial[2]);
    const Eigen::Vector3d rho0(initial[3], initial[4], 0.5 * initial[5]);
    const Eigen::Vector3d force = PlaneStress(material.MembraneStiffness(), nu, e0);
    const Eigen::Vector3d moment = PlaneStress(material.BendingStiffness(), nu, rho0);
    fields.membrane_force += force;
    fields.moment += moment;
    fields.membrane_energy_density += Contract(force, e);
    fields.bending_energy_density += Contract(moment, rho);
  }
  // The strain at the height z along n is e - z rho: b grows where the surface curls towards n,
  // and what lies on that side gets shorter.
  const Eigen::Vector3d stretching = fields.membrane_force / h;
  const Eigen::Vector3d bending = 6.0 / (h * h) * fields.moment;
  fields.von_mises_top = VonMises(stretching - bending);
  fields.von_mises_bottom = VonMises(stretching + bending);
  return fields;
}

ShellFields EvaluateFields(const ShellProblem& problem, const ElementPoint& at) {
  return EvaluateFields(problem, problem.displacements(), MakeFieldSite(problem.surface(), at));
}

OutputMesh MakeOutputMesh(const ShellSurface& surface) {
  constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  OutputMesh mesh;
  // A corner is the pair of its number with itself, the middle of an edge that of its two ends: the
  // surface knows what a seam joins, and which elements are half as large as their neighbours.
  std::map<std::pair<int, int>, int> index;
  struct Node {
    int point = -1;  // -1: there is none
    std::array<double, 2> place{};
  };
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto add = [&](int from, int to, double s, double t) {
      const auto [it, is_new] =
          index.insert({std::minmax({from, to}), static_cast<int>(mesh.points.size())});
      if (is_new) mesh.points.push_back({e, s, t});
      return Node{it->second, {s, t}};
    };
    std::array<Node, 3> corner, middle;
    // In the middle of the first and second half of an edge, where the edge is cut there.
    std::array<std::array<Node, 2>, 3> quarter;
    for (int k = 0; k < 3; ++k) {
      corner[k] = add(surface.Corner(e, k), surface.Corner(e, k), kCorner[k][0], kCorner[k][1]);
    }
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const int a = surface.Corner(e, k), b = surface.Corner(e, l);
      const int hanging = surface.HangingCorner(e, k);
      const auto at = [&](double f, int from, int to) {
        return add(from,
                   to,
                   (1.0 - f) * kCorner[k][0] + f * kCorner[l][0],
                   (1.0 - f) * kCorner[k][1] + f * kCorner[l][1]);
      };
      if (hanging < 0) {
        middle[k] = at(0.5, a, b);
      } else {
        middle[k] = at(0.5, hanging, hanging);
        quarter[k] = {at(0.25, a, hanging), at(0.75, hanging, b)};
      }
    }
    const auto push = [&](const Node& a, const Node& b, const Node& c) {
      mesh.triangles.push_back({a.point, b.point, c.point});
      mesh.elements.push_back(e);
      mesh.places.push_back({a.place, b.place, c.place});
    };
    for (int k = 0; k < 3; ++k) {
      // The part at a corner: corner, p, middle, other middle, q.
      const int last = (k + 2) % 3;
      const Node &a = corner[k], &b = middle[k], &c = middle[last];
      const Node &p = quarter[k][0], &q = quarter[last][1];
      if (p.point < 0 && q.point < 0) {
        push(a, b, c);
      } else if (q.point < 0) {
        push(a, p, c);
        push(p, b, c);
      } else if (p.point < 0) {
        push(a, b, q);
        push(b, c, q);
      } else {
        push(a, p, q);
        push(p, b, q);
        push(b, c, q);
      }
    }
    push(middle[0], middle[1], middle[2]);
  }
  return mesh;
}

}  // namespace darboux
