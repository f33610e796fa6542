#include "solver/dead_loads.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "costs/edge_moment.h"
#include "solver/parallel_for.h"
#include "solver/support_conditions.h"

namespace darboux {
namespace {

// Loads cost no Jacobian, so their integrals afford better rules than the strains'.
constexpr int kAreaPoints = 6;
constexpr int kEdgePoints = 3;

class Assembler {
 public:
  Assembler(const ShellSurface& surface, const RigidFrame& frame, DeadLoads* loads)
      : surface_(surface), frame_(frame), loads_(loads) {
    loads_->force = Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices);
  }

  // Force at a point; `dead` false: counts for balance only.
  void AddForce(int element, const StrainPoint& point, const Eigen::Vector3d& force, bool dead) {
    if (force.isZero(0.0)) return;
    AddRigid(frame_.DisplacementRow(point.position, force));
    if (dead) AddWork(element, force * point.weights.row(kRowValue));
  }
  void AddForce(const ShellSurface::AreaPoint& point, const Eigen::Vector3d& force, bool dead) {
    if (force.isZero(0.0)) return;
    AddRigid(frame_.DisplacementRow(point.position, force));
    if (dead) AddWork(point.at.element, force * point.values);
  }

  void AddMoment(int element, const StrainPoint& point, const Eigen::Vector3d& moment, bool dead) {
    if (moment.isZero(0.0)) return;
    Eigen::Matrix<double, 1, 6> row;
    row << Eigen::RowVector3d::Zero(), moment.transpose() / frame_.length;
    AddRigid(row);
    if (dead) AddWork(element, MomentWork(point, moment));
  }

 private:
  void AddRigid(const Eigen::Matrix<double, 1, 6>& row) {
    loads_->rigid_work += row.transpose();
    loads_->rigid_scale += row.stableNorm();  // Its square may be too small for a number.
  }

  template <typename Work>
  void AddWork(int element, const Work& work) {
    const auto& vertices = surface_.control_vertices(element);
    for (size_t i = 0; i < vertices.size(); ++i) loads_->force.col(vertices[i]) += work.col(i);
  }

  const ShellSurface& surface_;
  const RigidFrame& frame_;
  DeadLoads* loads_;
};

}  // namespace

DeadLoads AssembleDeadLoads(const Scene& scene,
                            const ShellSurface& surface,
                            bool nonlinear,
                            const RigidFrame& frame,
                            int num_threads) {
  DeadLoads loads;
  Assembler assembler(surface, frame, &loads);
  std::vector<const LoadSpec*> area_loads;
  for (const LoadSpec& load : scene.loads) {
    switch (load.kind) {
      case LoadSpec::Kind::kPoint: {
        const ElementPoint at = Resolve(load.at, surface);
        assembler.AddForce(
            at.element, surface.MakePoint(at), EvaluateAt(load.force, surface, at), true);
        break;
      }
      case LoadSpec::Kind::kEdge:
        for (const Side side : SidesOf(load.on, surface)) {
          for (const auto& edge : surface.SidePoints(side, kEdgePoints)) {
            const double length = edge.point.area;
            assembler.AddForce(edge.at.element,
                               edge.point,
                               length * EvaluateAt(load.force, surface, edge.at),
                               true);
            assembler.AddMoment(edge.at.element,
                                edge.point,
                                length * EvaluateAt(load.moment, surface, edge.at),
                                !nonlinear);
          }
        }
        break;
      case LoadSpec::Kind::kLine:
        for (const auto& p :
             surface.ParameterLinePoints(load.line_parameter, load.line_value, kEdgePoints)) {
          assembler.AddForce(
              p.at.element, p.point, p.point.area * EvaluateAt(load.force, surface, p.at), true);
        }
        break;
      case LoadSpec::Kind::kGas:
        break;
      default:
        area_loads.push_back(&load);
    }
  }
  if (area_loads.empty()) return loads;

  const double mass = scene.shell.density * scene.shell.thickness;
  const int threads = ThreadsFor(surface.num_elements(), num_threads);
  std::vector<DeadLoads> parts(threads);
  ParallelFor(threads, surface.num_elements(), [&](int thread, int begin, int end) {
    Assembler part(surface, frame, &parts[thread]);
    for (int e = begin; e < end; ++e) {
      surface.ForEachAreaPoint(e, kAreaPoints, [&](const ShellSurface::AreaPoint& point) {
        Eigen::Vector3d dead = Eigen::Vector3d::Zero(), follower = Eigen::Vector3d::Zero();
        for (const LoadSpec* load : area_loads) {
          switch (load->kind) {
            case LoadSpec::Kind::kPressure: {
              Eigen::Vector3d& force = nonlinear && load->follower ? follower : dead;
              force += EvaluateAt(load->value, surface, point.at) * point.n;
              break;
            }
            case LoadSpec::Kind::kNormalTraction:
              dead += EvaluateAt(load->value, surface, point.at) * point.n;
              break;
            case LoadSpec::Kind::kTraction:
              dead += EvaluateAt(load->force, surface, point.at);
              break;
            case LoadSpec::Kind::kGravity:
              dead +=
                  mass * Eigen::Vector3d(
                             load->acceleration[0], load->acceleration[1], load->acceleration[2]);
              break;
            default:
              break;
          }
        }
        part.AddForce(point, point.area * dead, true);
        part.AddForce(point, point.area * follower, false);
      });
    }
  });
  for (const DeadLoads& part : parts) {
    loads.force += part.force;
    loads.rigid_work += part.rigid_work;
    loads.rigid_scale += part.rigid_scale;
  }
  return loads;
}

}  // namespace darboux
