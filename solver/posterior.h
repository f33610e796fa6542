#ifndef DARBOUX_SOLVER_POSTERIOR_H_
#define DARBOUX_SOLVER_POSTERIOR_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace darboux {

// What measurements say about a few parameters among many unknowns: the Laplace approximation of
// the posterior of a least-squares problem around its minimum.
//
// Rows r + J dx of unit standard deviation, weights of a robust loss included, sum up to an
// information matrix H = J^T J and a gradient J^T r. With t the parameters of interest and n the
// nuisances,
//
//   S = H_tt - H_tn H_nn^+ H_nt  (Schur complement),     covariance of t = S^-1
//
// A nuisance that nothing determines (the rotation of a scanned ball about its axis) is left where
// it is: H_nn^+ is the pseudo-inverse. A combination of parameters of interest that nothing
// determines has infinite variance; nothing is inverted that is singular.
class Posterior {
 public:
  // interest: columns of t.
  Posterior(int unknowns, std::vector<int> interest);

  // A row that stands for `weight` of them. Coefficients of all unknowns.
  void Add(const Eigen::VectorXd& row, double residual, double weight = 1.0);
  // The same for a row that has only some columns.
  void Add(const std::vector<int>& columns,
           const Eigen::VectorXd& row,
           double residual,
           double weight = 1.0);
  // Only these unknowns may change, besides those of interest; all others are constants.
  void SetFree(const std::vector<int>& nuisances) { nuisances_ = nuisances; }

  const Eigen::MatrixXd& information() const { return information_; }
  const Eigen::VectorXd& gradient() const { return gradient_; }

  // Of the parameters of interest: standard deviations (infinity: not determined), and correlations
  // (empty where one is infinite).
  struct Spread {
    Eigen::VectorXd deviations;
    Eigen::MatrixXd covariance;   // of those combinations that are determined
    Eigen::MatrixXd correlation;  // empty: some are not
    // The direction in t that is determined least, unit in the scaled sense of `scales`.
    Eigen::VectorXd weakest;
  };
  // scales: a change of each parameter that matters, for comparing directions.
  Spread Find(const Eigen::VectorXd& scales) const;

  // The change of the parameters of interest (and of the free nuisances with them) when rows J_c of
  // a constant c change by dc = 1, given J^T J_c of it: a column of information().
  Eigen::VectorXd ChangeBy(const Eigen::VectorXd& product) const;

 private:
  Eigen::MatrixXd Schur() const;

  std::vector<int> interest_, nuisances_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_;
};

// B with B^+ = pseudo-inverse of a symmetric positive semidefinite matrix whose rows and columns
// are first scaled to a unit diagonal; eigenvalues below `cut` of the largest count as nothing.
Eigen::MatrixXd ScaledPseudoInverse(const Eigen::MatrixXd& matrix, double cut);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_POSTERIOR_H_
