#ifndef DARBOUX_SOLVER_DEAD_LOADS_H_
#define DARBOUX_SOLVER_DEAD_LOADS_H_

#include <Eigen/Core>
#include <vector>

#include "geometry/shell_surface.h"
#include "solver/rigid_motion.h"
#include "solver/scene.h"

namespace darboux {

// Dead loads of a scene at full load, gathered on the control vertices.
struct DeadLoads {
  Eigen::Matrix3Xd force;  // generalised force on each control displacement
  // Work on a rigid motion (RigidFrame), exact positions: says whether loads balance.
  Eigen::Matrix<double, 6, 1> rigid_work = Eigen::Matrix<double, 6, 1>::Zero();
  // The same with every contribution counted positive: the scale rigid_work is small against.
  double rigid_scale = 0.0;
};

// Which loads of a scene act as dead forces in a theory, and their assembly. In the linear theory
// that is all of them; in the nonlinear one pressures with follower: true and edge moments are left
// to their own blocks (they still count in rigid_work, at rest).
DeadLoads AssembleDeadLoads(const Scene& scene,
                            const ShellSurface& surface,
                            bool nonlinear,
                            const RigidFrame& frame,
                            int num_threads = 1);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_DEAD_LOADS_H_
