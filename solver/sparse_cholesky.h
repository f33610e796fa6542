#ifndef DARBOUX_SOLVER_SPARSE_CHOLESKY_H_
#define DARBOUX_SOLVER_SPARSE_CHOLESKY_H_

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <memory>
#include <utility>
#include <vector>

namespace darboux {

// Who factorises.
enum class SparseBackend {
  kAuto,         // SuiteSparse where it is there, else Eigen
  kSuiteSparse,  // CHOLMOD; its supernodal factorisation is GPL
  kEigen         // Eigen::SimplicialLDLT; slower, no GPL code runs
};

// Whether this build has CHOLMOD. Ceres may have it all the same.
bool HasCholmod();

// Factorises symmetric matrices of one pattern, over and over: the symbolic analysis is made once.
class SparseCholesky {
 public:
  // kAuto and kSuiteSparse take CHOLMOD where HasCholmod().
  static std::unique_ptr<SparseCholesky> Create(SparseBackend backend);
  virtual ~SparseCholesky() = default;

  // Lower triangle, compressed, rows ascending in each column; columns are eliminated in the order
  // given, up to a postorder that adds no fill. Only the pattern is read.
  virtual void Analyze(const Eigen::SparseMatrix<double>& lower) = 0;

  // A of the analysed pattern = L L^T. False where A is not positive definite.
  virtual bool Factorize(const Eigen::SparseMatrix<double>& lower) = 0;

  // A = L D L^T without pivoting, D of either sign. Slower than Factorize. Returns the number of
  // negative eigenvalues (Sylvester's law of inertia), or -1 where a pivot vanishes.
  virtual int FactorizeIndefinite(const Eigen::SparseMatrix<double>& lower) = 0;

  // X = A^-1 B with the last successful factor of either kind, a right-hand side per column.
  virtual Eigen::MatrixXd SolveMany(const Eigen::MatrixXd& b) = 0;
  Eigen::VectorXd Solve(const Eigen::VectorXd& b) { return SolveMany(b); }
};

// The same for A + U diag(d) U^T with few columns U, dense ones that would fill A (Sherman,
// Morrison, Woodbury). Weights d of either sign and not zero: a negative one takes away what A has
// only so that it can be factorised.
//
//   (A + U D U^T)^-1 b = x - V M^-1 V^T b,   x = A^-1 b,  V = A^-1 U,  M = D^-1 + U^T V
//
// Negative eigenvalues of the sum: those of A + those of -M - those of -D^-1 (Haynsworth).
class UpdatedCholesky : public SparseCholesky {
 public:
  explicit UpdatedCholesky(std::unique_ptr<SparseCholesky> base) : base_(std::move(base)) {}

  // For the factorisations to come. None: A alone.
  void SetUpdate(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& weights) {
    vectors_ = vectors;
    weights_ = weights;
  }

  void Analyze(const Eigen::SparseMatrix<double>& lower) override { base_->Analyze(lower); }
  // True where both A and the sum are positive definite.
  bool Factorize(const Eigen::SparseMatrix<double>& lower) override;
  int FactorizeIndefinite(const Eigen::SparseMatrix<double>& lower) override;
  Eigen::MatrixXd SolveMany(const Eigen::MatrixXd& b) override;

 private:
  // Of the sum, given those of A; -1 where it is singular.
  int NegativeEigenvalues(int negative_of_base);

  std::unique_ptr<SparseCholesky> base_;
  Eigen::MatrixXd vectors_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd solved_;                   // V, columns scaled
  Eigen::FullPivLU<Eigen::MatrixXd> small_;  // M, rows and columns scaled
};

// A fill-reducing order of the vertices of a graph: order[k] is the vertex eliminated k-th.
// rows[begin[j]] .. rows[begin[j + 1] - 1], in any order: j and its neighbours of greater number.
// Nested dissection where the build has it and the graph is large enough for it to pay, minimum
// degree otherwise.
Eigen::VectorXi FillReducingOrder(const std::vector<int>& begin,
                                  const std::vector<int>& rows,
                                  SparseBackend backend);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SPARSE_CHOLESKY_H_
