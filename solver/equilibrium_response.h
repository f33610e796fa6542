#ifndef DARBOUX_SOLVER_EQUILIBRIUM_RESPONSE_H_
#define DARBOUX_SOLVER_EQUILIBRIUM_RESPONSE_H_

#include <Eigen/Core>

#include "solver/grasp.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// How an equilibrium answers small forces: K du = f with the true second derivative K of the
// energy, the points in contact as they are, rigid contact, supports that hold. In the units of the
// problem. Inside of the solver.

// Contact is stiffened, and fingers that forces drive are held, as long as this lives: what the
// give of contact adds to a travel is then about 1e-6 of what the shell's does.
class RigidContact {
 public:
  RigidContact(Grasp* grasp, double factor);
  ~RigidContact();
  RigidContact(const RigidContact&) = delete;
  RigidContact& operator=(const RigidContact&) = delete;

 private:
  Grasp& grasp_;
  const double factor_;
  const Grasp::State state_;
};

// K in the present state. False where it is undefined.
bool EvaluateTrueTangent(TangentStiffness* tangent);

// Factorises the matrix that tangent evaluated last, and springs of one stiffness along the columns
// of `springs`, which may be none. Where fingers hold the shell, means that stand for missing
// supports are weighted down to nothing, or as far as rounding allows; without fingers they are
// conditions. cholesky has analysed the matrix. False where it is singular.
bool FactorizeTangent(const ShellProblem& problem,
                      const TangentStiffness& tangent,
                      const Eigen::MatrixXd& springs,
                      double stiffness,
                      UpdatedCholesky* cholesky);

// The change of the unknowns under forces, with the last factor; supports are given the multipliers
// that hold them. The problem is left as it was.
Eigen::VectorXd Response(ShellProblem* problem,
                         const TangentStiffness& tangent,
                         SparseCholesky* cholesky,
                         const Eigen::VectorXd& forces);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_EQUILIBRIUM_RESPONSE_H_
