#include "solver/inp_loads.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "solver/support_conditions.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

// As solver/dead_loads.cc has them.
constexpr int kAreaPoints = 6;
constexpr int kEdgePoints = 3;

class Gatherer {
 public:
  Gatherer(const InpMesh& mesh, InpLoads* loads) : mesh_(mesh), loads_(loads) {}

  // A force of the middle surface that is spread over an area, or along a curve or at a point.
  void AddForce(const ElementPoint& at, const Vector3d& force, bool over_area) {
    if (force.isZero(0.0)) return;
    const int element = mesh_.Locate(at, &values_);
    for (size_t i = 0; i < values_.size(); ++i) {
      if (values_[i] == 0.0) continue;
      const InpMesh::Column& column = mesh_.columns()[mesh_.elements()[element][i]];
      const Vector3d part = values_[i] * force;
      if (!mesh_.is_solid()) {
        Add(column.nodes[0], part, &loads_->forces);
      } else if (over_area || !column.is_corner) {
        Add(column.nodes[0], 0.5 * part, &loads_->forces);
        Add(column.nodes[2], 0.5 * part, &loads_->forces);
      } else {
        Add(column.nodes[0], part / 6.0, &loads_->forces);
        Add(column.nodes[1], part * (4.0 / 6.0), &loads_->forces);
        Add(column.nodes[2], part / 6.0, &loads_->forces);
      }
    }
  }

  void AddMoment(const ElementPoint& at, const Vector3d& moment) {
    if (moment.isZero(0.0)) return;
    const int element = mesh_.Locate(at, &values_);
    for (size_t i = 0; i < values_.size(); ++i) {
      if (values_[i] == 0.0) continue;
      const InpMesh::Column& column = mesh_.columns()[mesh_.elements()[element][i]];
      const Vector3d part = values_[i] * moment;
      const Vector3d& n = column.normal;
      if (std::abs(part.dot(n)) > 1e-6 * part.norm()) has_drilling_ = true;
      if (mesh_.is_solid()) {
        // n h/2 x f + (-n h/2) x (-f) = the tangential part of the moment.
        const Vector3d couple = part.cross(n) / mesh_.thickness();
        Add(column.nodes[2], couple, &loads_->forces);
        Add(column.nodes[0], -couple, &loads_->forces);
      } else {
        Add(column.nodes[0], part - n * n.dot(part), &loads_->moments);
      }
    }
  }

  // Whether moments had a part about the normal, since the last ForgetDrilling.
  bool has_drilling() const { return has_drilling_; }
  void ForgetDrilling() { has_drilling_ = false; }

 private:
  static void Add(int node, const Vector3d& force, std::map<int, Vector3d>* forces) {
    forces->emplace(node, Vector3d::Zero()).first->second += force;
  }

  const InpMesh& mesh_;
  InpLoads* loads_;
  std::vector<double> values_;
  bool has_drilling_ = false;
};

bool HasMoment(const LoadSpec& load) {
  if (load.kind != LoadSpec::Kind::kEdge) return false;
  const std::array<double, 5> zeros{};
  for (const SceneValue& moment : load.moment.component) {
    const bool constant = moment.expression.IsConstant();
    if (!constant || moment.expression.Evaluate(zeros.data()) != 0.0) return true;
  }
  return false;
}

}  // namespace

bool HasEdgeMoments(const Scene& scene) {
  return std::any_of(scene.loads.begin(), scene.loads.end(), HasMoment);
}

InpLoads MakeInpLoads(const Scene& scene, const InpMesh& mesh, bool nonlinear) {
  InpLoads loads;
  const ShellSurface& surface = mesh.surface();
  Gatherer gatherer(mesh, &loads);
  const auto add_area = [&](const auto& per_area) {
    for (int e = 0; e < surface.num_elements(); ++e) {
      surface.ForEachAreaPoint(e, kAreaPoints, [&](const ShellSurface::AreaPoint& point) {
        gatherer.AddForce(point.at, point.area * per_area(point), true);
      });
    }
  };
  for (const LoadSpec& load : scene.loads) {
    const std::string& key = load.location.key;
    switch (load.kind) {
      case LoadSpec::Kind::kPoint: {
        // Shared by the nodes around where there is none at the point itself.
        const ElementPoint at = Resolve(load.at, surface);
        const Vector3d x = surface.Position(at);
        const int nearest = mesh.Nearest(x, false);
        const double off = (mesh.columns()[nearest].position - x).norm();
        if (off > 1e-6 * surface.size()) {
          loads.remarks.push_back(key +
                                  ": no node at the point; its force is shared by the nodes "
                                  "of the element there");
        }
        gatherer.AddForce(at, EvaluateAt(load.force, surface, at), false);
        break;
      }
      case LoadSpec::Kind::kPressure:
        if (!nonlinear || !load.follower) {
          add_area([&](const ShellSurface::AreaPoint& point) {
            return Vector3d(EvaluateAt(load.value, surface, point.at) * point.n);
          });
          break;
        }
        if (!load.value.expression.IsConstant()) {
          loads.remarks.push_back(key + ": a pressure that varies is its mean in each element");
        }
        loads.pressures.resize(mesh.elements().size(), 0.0);
        {
          std::vector<double> force(loads.pressures.size(), 0.0), area = force, values;
          for (int e = 0; e < surface.num_elements(); ++e) {
            surface.ForEachAreaPoint(e, kAreaPoints, [&](const ShellSurface::AreaPoint& point) {
              const int element = mesh.Locate(point.at, &values);
              force[element] += point.area * EvaluateAt(load.value, surface, point.at);
              area[element] += point.area;
            });
          }
          for (size_t i = 0; i < area.size(); ++i) {
            if (area[i] > 0.0) loads.pressures[i] += force[i] / area[i];
          }
        }
        break;
      case LoadSpec::Kind::kNormalTraction:
        add_area([&](const ShellSurface::AreaPoint& point) {
          return Vector3d(EvaluateAt(load.value, surface, point.at) * point.n);
        });
        break;
      case LoadSpec::Kind::kTraction:
        add_area([&](const ShellSurface::AreaPoint& point) {
          return EvaluateAt(load.force, surface, point.at);
        });
        break;
      case LoadSpec::Kind::kEdge:
        for (const Side side : SidesOf(load.on, surface)) {
          for (const auto& edge : surface.SidePoints(side, kEdgePoints)) {
            const double length = edge.point.area;
            gatherer.AddForce(edge.at, length * EvaluateAt(load.force, surface, edge.at), false);
            gatherer.AddMoment(edge.at, length * EvaluateAt(load.moment, surface, edge.at));
          }
        }
        break;
      case LoadSpec::Kind::kLine:
        for (const auto& p :
             surface.ParameterLinePoints(load.line_parameter, load.line_value, kEdgePoints)) {
          gatherer.AddForce(p.at, p.point.area * EvaluateAt(load.force, surface, p.at), false);
        }
        break;
      case LoadSpec::Kind::kGravity:
        loads.gravity.emplace_back(
            load.acceleration[0], load.acceleration[1], load.acceleration[2]);
        break;
      case LoadSpec::Kind::kGas:
        break;
    }
    if (gatherer.has_drilling()) {
      loads.remarks.push_back(key +
                              ": the part of the moment about the shell's normal is left "
                              "out; no shell bears it");
      gatherer.ForgetDrilling();
    }
  }
  if (nonlinear && mesh.is_solid() && HasEdgeMoments(scene)) {
    loads.remarks.push_back(
        "edge moments: couples of dead forces, which lose their arm as the edge "
        "turns; shell elements take moments");
  }
  return loads;
}

std::vector<double> FaceRatios(const InpMesh& mesh, int side) {
  const ShellSurface& surface = mesh.surface();
  std::vector<double> middle(mesh.elements().size(), 0.0), face = middle, values;
  const double height = 0.5 * side * mesh.thickness();
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (const TrianglePoint& rule : surface.Rule(e, 3)) {
      const ElementPoint at{e, rule.s, rule.t};
      const StrainPoint point = surface.MakePoint(at, rule.weight);
      // Offset surfaces: dA (1 - z tr b + z^2 det b), b positive where the shell curls towards n.
      const double z = height, trace = point.b11 + point.b22;
      const double determinant = point.b11 * point.b22 - point.b12 * point.b12;
      const int element = mesh.Locate(at, &values);
      middle[element] += point.area;
      face[element] += point.area * (1.0 - z * trace + z * z * determinant);
    }
  }
  for (size_t i = 0; i < middle.size(); ++i) {
    middle[i] = face[i] > 0.0 ? middle[i] / face[i] : 1.0;
  }
  return middle;
}

}  // namespace darboux
