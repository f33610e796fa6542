#include "solver/stability.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace darboux {
namespace {

// Iterations of the power method with the inverse: modes need to be told apart, not measured.
constexpr int kIterations = 12;

// The eigenvector to the eigenvalue nearest to zero of the matrix that `cholesky` has factorised.
Eigen::VectorXd InverseIteration(SparseCholesky* cholesky, Eigen::VectorXd vector) {
  for (int i = 0; i < kIterations; ++i) {
    vector = cholesky->Solve(vector);
    const double norm = vector.norm();
    if (!(norm > 0.0) || !std::isfinite(norm)) break;
    vector /= norm;
  }
  return vector;
}

}  // namespace

Stability CheckStability(MixedIteration* mixed) {
  Stability result;
  result.negative_modes = mixed->FactorizeHessian();
  if (result.negative_modes < 0) return result;
  const Eigen::SparseMatrix<double> hessian = mixed->tangent().matrix();
  SparseCholesky& cholesky = mixed->cholesky();

  // No symmetry of the shell may hide the mode from the first vector.
  std::mt19937 generator(7321);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd mode(hessian.cols());
  for (Eigen::Index i = 0; i < mode.size(); ++i) mode[i] = uniform(generator);
  mode = InverseIteration(&cholesky, mode.normalized());
  const auto rayleigh = [&](const Eigen::SparseMatrix<double>& matrix) {
    const Eigen::VectorXd along = mixed->tangent().update_vectors().transpose() * mode;
    return (mode.dot(matrix.selfadjointView<Eigen::Lower>() * mode) +
            along.cwiseAbs2().dot(mixed->tangent().update_weights())) /
           mode.squaredNorm();
  };
  if (result.negative_modes > 0) {
    // The lowest eigenvalue, not the one nearest to zero: shifted until all are positive.
    Eigen::SparseMatrix<double> shifted = hessian;
    double shift = 2.0 * std::abs(rayleigh(hessian));
    bool positive = false;
    for (int i = 0; i < 60 && shift > 0.0 && !positive; ++i, shift *= 4.0) {
      for (Eigen::Index k = 0; k < hessian.cols(); ++k) {
        // The diagonal comes first in each column of a lower triangle.
        shifted.valuePtr()[shifted.outerIndexPtr()[k]] =
            hessian.valuePtr()[hessian.outerIndexPtr()[k]] + shift;
      }
      positive = cholesky.Factorize(shifted);
    }
    // Modes that lie close together take longer; a negative one is there to be found.
    constexpr int kRounds = 30;
    for (int i = 0; i < kRounds && positive; ++i) {
      mode = InverseIteration(&cholesky, mode);
      if (rayleigh(hessian) < 0.0) break;
    }
  }
  const double stiffness = rayleigh(hessian);
  TangentStiffness::Request request;
  request.matrix = true;
  request.stress_factor = 0.0;
  mixed->tangent().Evaluate(request);
  const double unstressed = rayleigh(mixed->tangent().matrix());
  result.softness = unstressed > 0.0 ? stiffness / unstressed : 1.0;
  if (result.negative_modes > 0 || result.softness < kNearlyUnstable) {
    result.mode = mixed->tangent().Expand(mode);
    const double size = result.mode.colwise().norm().maxCoeff();
    if (size > 0.0) result.mode /= size;
  }
  return result;
}

}  // namespace darboux
