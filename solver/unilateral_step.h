#ifndef DARBOUX_SOLVER_UNILATERAL_STEP_H_
#define DARBOUX_SOLVER_UNILATERAL_STEP_H_

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "solver/grasp.h"
#include "solver/sparse_cholesky.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

// A Newton step between fingers that push and do not pull. With c_q the derivative of contact's
// residual r_q (costs/finger_contact.h) at point q, less its sign, the quadratic model of the
// energy
//
//   g.s + 1/2 s^T K s,   K with c c^T of the points that are in contact,
//
// lets them pull as soon as s opens their gap, and the others through. Step of
//
//   g.s + 1/2 s^T K0 s + sum 1/2 max(0, r_q - c_q.s)^2,   K0 = K without contact
//
// instead: points are let go and taken up until the signs agree with the step (the primal-dual
// active set method; M. Hintermueller, K. Ito, K. Kunisch, 2002), with the factor of K and one pair
// of triangular solves per point that changes (Woodbury). Without it contact points come and go
// from one iteration to the next, a finger loses the shell altogether, and the next step throws it
// back.
class UnilateralStep {
 public:
  // cholesky: has factorised K, at the present state of the grasp or, where given, with the points
  // `in_matrix` in contact (by their index in the grasp's state, ascending). All must outlive this.
  // reach: of points without contact, those as near to a finger as this can be taken up.
  UnilateralStep(const Grasp& grasp,
                 const TangentStiffness& tangent,
                 SparseCholesky* cholesky,
                 double reach,
                 const std::vector<int>* in_matrix = nullptr);

  // Points in contact now, as in_matrix.
  std::vector<int> Contact() const;
  // False where a point of in_matrix has gone beyond the reach: the factor does not serve.
  bool is_valid() const { return is_valid_; }

  // *step: of K; becomes that of the model above. Returns the number of points that changed.
  int Correct(Eigen::VectorXd* step);

  // Normal forces, by the index of their point in the grasp's state, that the model above has at
  // the end of its step, and the normals they act along.
  std::vector<Grasp::NormalForce> Forces(const Eigen::VectorXd& step) const;

  // Solves with K as the points of the corrected step have it.
  Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;

 private:
  struct Point {
    Grasp::ContactRow row;
    bool on, in_matrix, pushes;  // in the step's model, in K, at the present state
    int column = -1;             // of solved_; -1: none
  };
  double Along(const Point& point, const Eigen::Matrix3Xd& displacements) const;
  // Columns for all points that are not as in K or not as at the present state, and the small
  // matrix of those. False where they are too many.
  bool Prepare();
  // Adds K^-1 C x to *step, x one per changed point.
  void AddColumns(const Eigen::VectorXd& x, Eigen::VectorXd* step) const;
  // (1 + D W)^-1 D x
  Eigen::VectorXd Small(Eigen::VectorXd x) const;
  // D: of a point, what the model has more of its c c^T than K.
  static double Added(const Point& point) {
    return (point.on ? 1.0 : 0.0) - (point.in_matrix ? 1.0 : 0.0);
  }

  const TangentStiffness& tangent_;
  SparseCholesky* cholesky_;
  std::vector<Point> points_;
  std::vector<int> changed_;
  Eigen::MatrixXd columns_;                     // c_q of the points that have a column
  Eigen::MatrixXd solved_;                      // K^-1 c_q
  Eigen::MatrixXd gram_;                        // columns_^T solved_
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;  // 1 + D W
  bool is_valid_ = true;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_UNILATERAL_STEP_H_
