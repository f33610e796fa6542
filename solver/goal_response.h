#ifndef DARBOUX_SOLVER_GOAL_RESPONSE_H_
#define DARBOUX_SOLVER_GOAL_RESPONSE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/shell_problem.h"
#include "solver/shell_solver.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// What a scene is solved for, and what its accuracy is measured of: the displacement vectors of its
// probes and the normal forces of fingers that a travel drives (travels of those that a force
// drives); where there is none of either, the largest displacement and the total energy.
struct Goal {
  std::string name;       // "probes.tip", "fingers.left.normal_force", "energy.total", ...
  Eigen::Vector3d value;  // m, N or J; a scalar is in x
  double size = 0.0;      // what makes an error of it relative
  int probe = -1;         // index in Scene::probes
};

// In the order of the scene. A probe that moves less than 1e-4 of the largest displacement is
// measured against that: a held point has no relative error.
std::vector<Goal> GoalsOf(const Scene& scene, const SolverSummary& summary);

// How the goals of an equilibrium answer forces, which is what their errors are weighed with.
struct GoalResponse {
  // Of each goal, control displacements z, a column per control vertex, in units of length per
  // relative change: forces f in the units of the problem change the goal by z . f of its size. For
  // probes K z = (the probe's displacement functional along its own direction) / size, K the true
  // tangent; where a goal has no functional (fingers, energy) the equilibrium itself, scaled so
  // that its work on the loads is one: energy errors of first order are goal errors there.
  std::vector<Eigen::Matrix3Xd> duals;
  // |z . gradient| of the worst probe: what is left of the goal's error where iterations ended.
  double solver_error = 0.0;
};

// False where the tangent stiffness is singular.
bool EvaluateGoalResponse(ShellProblem* problem,
                          const std::vector<Goal>& goals,
                          SparseBackend backend,
                          int num_threads,
                          GoalResponse* response);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_GOAL_RESPONSE_H_
