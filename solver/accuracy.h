#ifndef DARBOUX_SOLVER_ACCURACY_H_
#define DARBOUX_SOLVER_ACCURACY_H_

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/scene.h"
#include "solver/shell_solver.h"

namespace darboux {

// One mesh of a refinement.
struct AccuracyLevel {
  std::array<int, 2> divisions{};  // (0, 0) on meshes
  int dof = 0;
  int elements = 0;
  int quadrature = 0;
  Theory theory = Theory::kAuto;  // the one used
  int solutions = 1;              // on meshes of this size, the last of them the level's
  // Relative discretisation error of this level's answer; none on the first level, which has
  // nothing to be compared with.
  std::optional<double> estimate;
  double seconds = 0.0;  // of all its solutions, with what it took to choose its mesh
};

// The certificate: how far off the answer may be, and why it is no nearer.
struct AccuracyReport {
  double target = 0.0;
  // Relative errors of the goals (solver/goal_response.h), the worst of each kind, estimated:
  std::optional<double> discretisation;  // of the last level, see Error- and IndicatorSequence
  std::optional<double> solver;          // where iterations ended
  // What ever closer points of contact would change (model.contact_spacing), on meshes where
  // fingers touch and the scene does not name it; none before discretisation is within the target.
  std::optional<double> contact;
  // What the nonlinear theory would change (solver/theory_error.h), in the linear theory; none in
  // the nonlinear theory, and in the linear one with fingers or gas, where it is not known.
  std::optional<double> theory;
  // Their sum; without the theory's where the scene asks for the linear theory.
  std::optional<double> estimate;
  bool reached = false;
  std::string message;  // why the refinement ended
  std::vector<AccuracyLevel> levels;
};

// Limits of a refinement.
struct AccuracyOptions {
  int max_dof = 200000;
  std::function<void(const AccuracyLevel&)> on_level;  // after each level
};

// Solves a scene that names model.accuracy so that the estimated relative error of its goals is
// within the accuracy, at least cost as far as estimates tell, and certifies it. What the scene
// does not say is chosen, each choice a line of summary->decisions:
//
//   theory      linear first, on the first lattice; the nonlinear one where fingers, gas or a path
//               ask for it, and where TheoryError is above half of the accuracy;
//   lattice     begins with 64 cells in the proportions of `divisions`; where the scene names no
//               grading, cells are moved where the error comes from and their numbers along u and v
//               balanced (solver/adaptive_grading.h), up to three times on the first lattice and
//               once more on every other, as long as that promises something;
//   resolution  grows by what the estimate lacks to 0.75 of the accuracy: twice the cells while the
//               order is not known, up to four times after that;
//   meshes      (mesh, implicit) keep their shape, whose unknowns are refined locally where goals
//               say so, as far as the estimate lacks (solver/mesh_adaptation.h); a sphere
//               (icosphere) begins coarse and gets rounder as it is refined. Without friction each
//               starts from the answer of the one before;
//   contact     on meshes, points of contact at half the spacing once the mesh is fine enough, and
//               again as long as that moves the goals by more than a part of the accuracy;
//   quadrature  of parametric surfaces: three points a triangle, or six where on the second lattice
//               six move the goals by more than half of the estimated error.
//
// Ends early, and says so, where the next level has more than max_dof or does not fit into the
// time that is left, where a level does not converge (one that has no predecessor is tried on finer
// lattices or meshes first) and where options.stop is set; what is estimated within the accuracy
// then is reached all the same. The answer is that of the finest level
// that converged; where none did, the last one's. Times in *summary are the sums over all
// solutions.
//
// False and *error as of Solve. Requires scene.model.accuracy.
bool SolveToAccuracy(const Scene& scene,
                     const SolverOptions& solver_options,
                     const AccuracyOptions& options,
                     std::unique_ptr<ShellProblem>* problem,
                     SolverSummary* summary,
                     AccuracyReport* report,
                     std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ACCURACY_H_
