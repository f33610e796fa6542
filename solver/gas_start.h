#ifndef DARBOUX_SOLVER_GAS_START_H_
#define DARBOUX_SOLVER_GAS_START_H_

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "solver/load_stepping.h"
#include "solver/minimisation.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"

namespace darboux {

// What gas has made of a shell before the loads and the fingers of its scene come.

// The initial stress of gas with rest: prestressed. On the rest shape the gauge pressure P has to
// be in equilibrium with it, B^T S_0 = P grad V, which on a closed shell of general shape has many
// solutions. This is the one of least complementary energy, S_0 = C B u of the free shell under P,
// B the first derivative of the strains at rest: on a sphere N_0 = P R / 2 and moments (h/R)^2
// smaller. Sets *displacements to that u, which ShellProblem::Options::prestress takes; empty where
// P is zero. False and *error where the matrix is singular.
bool FindPrestress(const Scene& scene,
                   const ShellProblem::Options& problem_options,
                   SparseBackend backend,
                   Eigen::Matrix3Xd* displacements,
                   std::string* error);

// The scene without fingers and loads, in equilibrium with its gas: the shell that fingers find.
// Null and *error as ShellProblem::Create; *result says how it went.
std::unique_ptr<ShellProblem> InflateBare(const Scene& scene,
                                          const ShellProblem::Options& problem_options,
                                          const SolverOptions& options,
                                          const Deadline& deadline,
                                          std::vector<std::string>* decisions,
                                          LoadStepping::Result* result,
                                          std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_GAS_START_H_
