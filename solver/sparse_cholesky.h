#ifndef DARBOUX_SOLVER_SPARSE_CHOLESKY_H_
#define DARBOUX_SOLVER_SPARSE_CHOLESKY_H_

#include <Eigen/SparseCore>
#include <memory>

namespace darboux {

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

  // x = A^-1 b with the last successful factor of either kind.
  virtual Eigen::VectorXd Solve(const Eigen::VectorXd& b) = 0;
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
