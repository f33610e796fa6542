#ifndef DARBOUX_SOLVER_SUPPORT_CONDITIONS_H_
#define DARBOUX_SOLVER_SUPPORT_CONDITIONS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/material.h"
#include "geometry/shell_surface.h"
#include "solver/rigid_motion.h"
#include "solver/scene.h"

namespace darboux {

// One linear condition on the displacement field (costs/support.h) and where it acts.
struct PlacedCondition {
  int support = -1;               // index in scene.supports; -1: none of them
  std::vector<int> vertices;      // control vertices
  Eigen::Matrix3Xd coefficients;  // one column per control vertex
  double stiffness = 0.0;
  double target = 0.0;  // at full load
  // What turns a violation into a length: 1 for a displacement component, the height of the element
  // for a rotation.
  double arm = 1.0;
  // Force of the reaction per unit of -stiffness * c: the direction of a displacement component,
  // zero for a rotation.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  // What a rigid motion does to it.
  Eigen::Matrix<double, 1, 6> rigid_row = Eigen::Matrix<double, 1, 6>::Zero();
};

// The supports of a scene, as conditions on control vertices.
struct SupportConditions {
  std::vector<PlacedCondition> conditions;
  // Control vertices held at zero one and all: boundary_rule seed_ghosts only.
  std::vector<int> fixed_vertices;
};

// Turns the supports of a scene into conditions. In neighbourhoods: one per lattice vertex and
// component (the nearest surface point where the neighbourhood holds none). On sides: one per
// lattice vertex and component, the mean of the component weighted with the hat function of the
// vertex. That many, and no more, the three control rows next to a side can follow without
// locking; and hats can represent the reaction, so that what the conditions leave free between the
// vertices does work against its second-order remainder only. Values at single points (one, two or
// three per edge) either lock or converge at first order (tests/support_conditions_test.cc). False
// and *error where a support contradicts the surface, e.g. a mirror plane that the side does not
// lie in.
bool MakeSupportConditions(const Scene& scene,
                           const ShellSurface& surface,
                           const Material& material,
                           const RigidFrame& frame,
                           SupportConditions* result,
                           std::string* error);

// Value of a scene expression at a surface point.
double EvaluateAt(const SceneValue& value, const ShellSurface& surface, const ElementPoint& point);
Eigen::Vector3d EvaluateAt(const SceneVector& value,
                           const ShellSurface& surface,
                           const ElementPoint& point);

// The point a scene means by uv or nearest.
ElementPoint Resolve(const SurfacePoint& point, const ShellSurface& surface);

// The sides of the domain that a region names; none for a neighbourhood.
std::vector<Side> SidesOf(const Region& region, const ShellSurface& surface);

// A condition that holds one displacement component at a point: also what takes up rigid motions.
PlacedCondition PointCondition(const ShellSurface& surface,
                               const ElementPoint& at,
                               const Eigen::Vector3d& direction,
                               const Material& material,
                               const RigidFrame& frame);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SUPPORT_CONDITIONS_H_
