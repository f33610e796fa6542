#include "solver/sparse_cholesky.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <mutex>

#ifdef DARBOUX_HAVE_CHOLMOD
#include <cholmod.h>
#include <dlfcn.h>

// Of OpenBLAS; null where another BLAS serves CHOLMOD.
extern "C" void openblas_set_num_threads(int num_threads) __attribute__((weak));
extern "C" int openblas_get_num_threads() __attribute__((weak));
extern "C" int openblas_get_parallel() __attribute__((weak));
#endif

namespace darboux {
namespace {

class EigenCholesky : public SparseCholesky {
 public:
  void Analyze(const Eigen::SparseMatrix<double>& lower) override { solver_.analyzePattern(lower); }
  bool Factorize(const Eigen::SparseMatrix<double>& lower) override {
    return FactorizeIndefinite(lower) == 0;
  }
  int FactorizeIndefinite(const Eigen::SparseMatrix<double>& lower) override {
    solver_.factorize(lower);
    if (solver_.info() != Eigen::Success) return -1;
    return static_cast<int>((solver_.vectorD().array() < 0.0).count());
  }
  Eigen::MatrixXd SolveMany(const Eigen::MatrixXd& b) override { return solver_.solve(b); }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
      solver_;
};

#ifdef DARBOUX_HAVE_CHOLMOD
// A matrix of Eigen as CHOLMOD sees it; the memory stays Eigen's.
cholmod_sparse View(const Eigen::SparseMatrix<double>& m, int stype) {
  cholmod_sparse view = {};
  view.nrow = m.rows();
  view.ncol = m.cols();
  view.nzmax = m.nonZeros();
  view.p = const_cast<int*>(m.outerIndexPtr());
  view.i = const_cast<int*>(m.innerIndexPtr());
  view.x = const_cast<double*>(m.valuePtr());
  view.stype = stype;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

// OpenMP's library, which CHOLMOD brings along where it was built with it.
struct OpenMp {
  OpenMp()
      : get_max_active_levels(
            reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"))),
        set_max_active_levels(
            reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"))) {}
  int (*get_max_active_levels)();
  void (*set_max_active_levels)(int);
};

// How many threads serve CHOLMOD while this lives. OpenBLAS' threads wait for their next task in a
// busy loop that takes the processor from everything else: for small factorisations that costs more
// than it gives. CHOLMOD's own, four of OpenMP woken for every supernode, never pay.
class FactorThreads {
 public:
  explicit FactorThreads(double flops) {
    constexpr double kWorthwhile = 3e9;
    Shared& shared = TheShared();
    const std::lock_guard<std::mutex> lock(shared.mutex);
    if (flops < kWorthwhile && openblas_set_num_threads != nullptr &&
        openblas_get_num_threads != nullptr) {
      limits_blas_ = true;
      if (shared.num_blas++ == 0) {
        shared.blas_threads = openblas_get_num_threads();
        if (shared.blas_threads > 1) openblas_set_num_threads(1);
      }
    }
    // An OpenBLAS that takes its threads from OpenMP keeps them.
    constexpr int kOpenMp = 2;
    if (flops >= kWorthwhile && openblas_get_parallel != nullptr &&
        openblas_get_parallel() == kOpenMp) {
      return;
    }
    if (Omp().get_max_active_levels != nullptr && Omp().set_max_active_levels != nullptr) {
      limits_omp_ = true;
      if (shared.num_omp++ == 0) {
        shared.omp_levels = Omp().get_max_active_levels();
        if (shared.omp_levels > 0) Omp().set_max_active_levels(0);
      }
    }
  }
  ~FactorThreads() {
    Shared& shared = TheShared();
    const std::lock_guard<std::mutex> lock(shared.mutex);
    if (limits_blas_ && --shared.num_blas == 0 && shared.blas_threads > 1) {
      openblas_set_num_threads(shared.blas_threads);
    }
    if (limits_omp_ && --shared.num_omp == 0 && shared.omp_levels > 0) {
      Omp().set_max_active_levels(shared.omp_levels);
    }
  }
  FactorThreads(const FactorThreads&) = delete;
  FactorThreads& operator=(const FactorThreads&) = delete;

 private:
  static const OpenMp& Omp() {
    static const OpenMp omp;
    return omp;
  }

  // Both settings are the process': solvers in several threads share them, the last one that is
  // done puts back what the first one found.
  struct Shared {
    std::mutex mutex;
    int num_blas = 0, num_omp = 0;  // that live and limit
    int blas_threads = 0, omp_levels = 0;
  };
  static Shared& TheShared() {
    static Shared& shared = *new Shared;
    return shared;
  }

  bool limits_blas_ = false, limits_omp_ = false;
};

class Cholmod : public SparseCholesky {
 public:
  Cholmod() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_NATURAL;
    common_.postorder = 1;
  }
  ~Cholmod() override {
    Free();
    cholmod_finish(&common_);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  void Analyze(const Eigen::SparseMatrix<double>& lower) override {
    Free();
    cholmod_sparse matrix = View(lower, -1);
    factor_ = cholmod_analyze(&matrix, &common_);
    CHECK(factor_ != nullptr) << "CHOLMOD's analysis failed, status " << common_.status;
    flops_ = common_.fl;
  }
  bool Factorize(const Eigen::SparseMatrix<double>& lower) override {
    cholmod_sparse matrix = View(lower, -1);
    common_.final_ll = 1;
    const FactorThreads threads(flops_);
    cholmod_factorize(&matrix, factor_, &common_);
    if (common_.status != CHOLMOD_OK) return false;
    solves_ = factor_;
    return true;
  }
  Eigen::MatrixXd SolveMany(const Eigen::MatrixXd& b) override {
    cholmod_dense right = {};
    right.nrow = right.d = b.rows();
    right.ncol = b.cols();
    right.nzmax = b.size();
    right.x = const_cast<double*>(b.data());
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    const FactorThreads threads(flops_);
    cholmod_dense* x = cholmod_solve(CHOLMOD_A, solves_, &right, &common_);
    CHECK(x != nullptr) << "CHOLMOD's solve failed, status " << common_.status;
    const Eigen::MatrixXd result =
        Eigen::Map<const Eigen::MatrixXd>(static_cast<double*>(x->x), b.rows(), b.cols());
    cholmod_free_dense(&x, &common_);
    return result;
  }
  int FactorizeIndefinite(const Eigen::SparseMatrix<double>& lower) override {
    cholmod_sparse matrix = View(lower, -1);
    const int supernodal = common_.supernodal;
    common_.supernodal = CHOLMOD_SIMPLICIAL;
    common_.final_ll = 0;
    if (indefinite_ == nullptr) indefinite_ = cholmod_analyze(&matrix, &common_);
    CHECK(indefinite_ != nullptr) << "CHOLMOD's analysis failed, status " << common_.status;
    cholmod_factorize(&matrix, indefinite_, &common_);
    common_.supernodal = supernodal;
    if (common_.status != CHOLMOD_OK) return -1;
    solves_ = indefinite_;
    const auto* const p = static_cast<const int*>(indefinite_->p);
    const auto* const x = static_cast<const double*>(indefinite_->x);
    int negative = 0;
    for (size_t j = 0; j < indefinite_->n; ++j) {
      if (x[p[j]] < 0.0) ++negative;  // D stands on the diagonal of L.
    }
    return negative;
  }

 private:
  void Free() {
    if (factor_ != nullptr) cholmod_free_factor(&factor_, &common_);
    if (indefinite_ != nullptr) cholmod_free_factor(&indefinite_, &common_);
    solves_ = nullptr;
  }

  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;      // L L^T, supernodal where that pays
  cholmod_factor* indefinite_ = nullptr;  // L D L^T
  double flops_ = 0.0;                    // of a factorisation
  cholmod_factor* solves_ = nullptr;      // the last of them that succeeded
};
#endif

[[maybe_unused]] bool UsesCholmod(SparseBackend backend) {
  return HasCholmod() && backend != SparseBackend::kEigen;
}

}  // namespace

bool HasCholmod() {
#ifdef DARBOUX_HAVE_CHOLMOD
  return true;
#else
  return false;
#endif
}

std::unique_ptr<SparseCholesky> SparseCholesky::Create([[maybe_unused]] SparseBackend backend) {
#ifdef DARBOUX_HAVE_CHOLMOD
  if (UsesCholmod(backend)) return std::make_unique<Cholmod>();
#endif
  return std::make_unique<EigenCholesky>();
}

int UpdatedCholesky::NegativeEigenvalues(int negative_of_base) {
  if (weights_.size() == 0) return negative_of_base;
  const Eigen::MatrixXd solved = base_->SolveMany(vectors_);
  Eigen::MatrixXd m = vectors_.transpose() * solved;
  m = (0.5 * (m + m.transpose())).eval();
  // With S = diag(scale) instead of M and V: S M S, V S. What is left of a diagonal entry of M is
  // then compared with its two terms, whatever the sizes of the weights.
  const Eigen::VectorXd inverse = weights_.cwiseInverse();
  const Eigen::VectorXd scale =
      (inverse.cwiseAbs() + m.diagonal().cwiseAbs()).cwiseSqrt().cwiseInverse();
  m.diagonal() += inverse;
  m = (scale.asDiagonal() * m * scale.asDiagonal()).eval();
  solved_ = solved * scale.asDiagonal();
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues();
  constexpr double kRounding = 1e-12;
  const Eigen::VectorXd sizes = eigenvalues.cwiseAbs();
  if (!(sizes.minCoeff() > kRounding * std::max(1.0, sizes.maxCoeff()))) return -1;
  small_.compute(m);
  const auto positive = (eigenvalues.array() > 0.0).count();
  const auto added = (weights_.array() > 0.0).count();
  return negative_of_base + static_cast<int>(positive - added);
}

bool UpdatedCholesky::Factorize(const Eigen::SparseMatrix<double>& lower) {
  return base_->Factorize(lower) && NegativeEigenvalues(0) == 0;
}

int UpdatedCholesky::FactorizeIndefinite(const Eigen::SparseMatrix<double>& lower) {
  const int negative = base_->FactorizeIndefinite(lower);
  return negative < 0 ? -1 : NegativeEigenvalues(negative);
}

Eigen::MatrixXd UpdatedCholesky::SolveMany(const Eigen::MatrixXd& b) {
  if (weights_.size() == 0) return base_->SolveMany(b);
  return base_->SolveMany(b) - solved_ * small_.solve(solved_.transpose() * b);
}

Eigen::VectorXi FillReducingOrder(const std::vector<int>& begin,
                                  const std::vector<int>& rows,
                                  [[maybe_unused]] SparseBackend backend) {
  const int n = static_cast<int>(begin.size()) - 1;
#ifdef DARBOUX_HAVE_CHOLMOD
  if (UsesCholmod(backend)) {
    cholmod_common common;
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    // Nested dissection saves a fifth of the factorisation of large meshes and costs more than
    // minimum degree to find.
    constexpr int kLarge = 10000;
    common.method[0].ordering = n >= kLarge ? CHOLMOD_METIS : CHOLMOD_AMD;
    common.supernodal = CHOLMOD_SIMPLICIAL;
    // METIS seeds C's rand and draws from it: one at a time, so that orders do not depend on what
    // other threads do.
    static std::mutex& metis = *new std::mutex;
    std::unique_lock<std::mutex> lock(metis, std::defer_lock);
    if (n >= kLarge) lock.lock();
    cholmod_sparse pattern = {};
    pattern.nrow = pattern.ncol = n;
    pattern.nzmax = rows.size();
    pattern.p = const_cast<int*>(begin.data());
    pattern.i = const_cast<int*>(rows.data());
    pattern.stype = -1;
    pattern.itype = CHOLMOD_INT;
    pattern.xtype = CHOLMOD_PATTERN;
    pattern.dtype = CHOLMOD_DOUBLE;
    pattern.packed = 1;
    cholmod_factor* factor = cholmod_analyze(&pattern, &common);
    Eigen::VectorXi order;
    if (factor != nullptr && common.status >= CHOLMOD_OK) {
      order = Eigen::Map<const Eigen::VectorXi>(static_cast<int*>(factor->Perm), n);
    }
    if (factor != nullptr) cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
    if (order.size() > 0) return order;
  }
#endif
  std::vector<Eigen::Triplet<double, int>> entries;
  for (int j = 0; j < n; ++j) {
    for (int k = begin[j]; k < begin[j + 1]; ++k) {
      entries.emplace_back(rows[k], j, 1.0);
      if (rows[k] != j) entries.emplace_back(j, rows[k], 1.0);
    }
  }
  Eigen::SparseMatrix<double> adjacency(n, n);
  adjacency.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int> amd;
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  amd(adjacency, permutation);
  return permutation.indices();
}

}  // namespace darboux
