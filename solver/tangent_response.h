#ifndef DARBOUX_SOLVER_TANGENT_RESPONSE_H_
#define DARBOUX_SOLVER_TANGENT_RESPONSE_H_

#include <Eigen/Core>

#include "solver/grasp.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// How the present state of a problem changes under small forces: its supports held, its contact
// rigid where it is, its fingers still. All in the units of ShellProblem::problem().

// Contact is stiffened, and fingers that forces drive are held, as long as this lives. The grasp
// may be null.
class RigidContact {
 public:
  explicit RigidContact(Grasp* grasp);
  ~RigidContact();
  RigidContact(const RigidContact&) = delete;
  RigidContact& operator=(const RigidContact&) = delete;

 private:
  Grasp* const grasp_;
  Grasp::State state_;
};

// The matrix of the present state, with its stress stiffness. False where a strain is undefined.
bool EvaluateTangent(TangentStiffness* tangent);

// Of the matrix that tangent evaluated last, and springs of one stiffness along the columns of
// `springs`; free motions are held as softly as rounding allows. False where it is singular. The
// pattern must have been analysed.
bool FactorizeTangent(const ShellProblem& problem,
                      const TangentStiffness& tangent,
                      const Eigen::MatrixXd& springs,
                      double stiffness,
                      UpdatedCholesky* cholesky);

// The change of the unknowns under forces. The problem is left as it was.
Eigen::VectorXd Response(ShellProblem* problem,
                         const TangentStiffness& tangent,
                         SparseCholesky* cholesky,
                         const Eigen::VectorXd& forces);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_TANGENT_RESPONSE_H_
