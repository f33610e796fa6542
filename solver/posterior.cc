#include "solver/posterior.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace darboux {
namespace {

// Information below this part of a parameter's own, in units where each has 1, is rounding.
constexpr double kCut = 1e-11;

Eigen::MatrixXd Pick(const Eigen::MatrixXd& matrix,
                     const std::vector<int>& rows,
                     const std::vector<int>& columns) {
  Eigen::MatrixXd picked(rows.size(), columns.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t j = 0; j < columns.size(); ++j) picked(i, j) = matrix(rows[i], columns[j]);
  }
  return picked;
}

Eigen::VectorXd UnitScales(const Eigen::MatrixXd& matrix) {
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(matrix.rows());
  for (Eigen::Index i = 0; i < scales.size(); ++i) {
    if (matrix(i, i) > 0.0) scales[i] = 1.0 / std::sqrt(matrix(i, i));
  }
  return scales;
}

}  // namespace

Eigen::MatrixXd ScaledPseudoInverse(const Eigen::MatrixXd& matrix, double cut) {
  if (matrix.size() == 0) return matrix;
  const Eigen::VectorXd scales = UnitScales(matrix);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scales.asDiagonal() * matrix *
                                                             scales.asDiagonal());
  Eigen::VectorXd inverse = eigen.eigenvalues();
  const double largest = inverse.cwiseAbs().maxCoeff();
  for (double& value : inverse) value = value > cut * largest && value > 0.0 ? 1.0 / value : 0.0;
  return scales.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
         eigen.eigenvectors().transpose() * scales.asDiagonal();
}

Posterior::Posterior(int unknowns, std::vector<int> interest)
    : interest_(std::move(interest)),
      information_(Eigen::MatrixXd::Zero(unknowns, unknowns)),
      gradient_(Eigen::VectorXd::Zero(unknowns)) {}

void Posterior::Add(const Eigen::VectorXd& row, double residual, double weight) {
  information_.noalias() += weight * row * row.transpose();
  gradient_.noalias() += weight * residual * row;
}

void Posterior::Add(const std::vector<int>& columns,
                    const Eigen::VectorXd& row,
                    double residual,
                    double weight) {
  for (size_t i = 0; i < columns.size(); ++i) {
    gradient_[columns[i]] += weight * residual * row[i];
    for (size_t j = 0; j < columns.size(); ++j) {
      information_(columns[i], columns[j]) += weight * row[i] * row[j];
    }
  }
}

Eigen::MatrixXd Posterior::Schur() const {
  const Eigen::MatrixXd cross = Pick(information_, interest_, nuisances_);
  return Pick(information_, interest_, interest_) -
         cross * ScaledPseudoInverse(Pick(information_, nuisances_, nuisances_), kCut) *
             cross.transpose();
}

Posterior::Spread Posterior::Find(const Eigen::VectorXd& scales) const {
  Spread spread;
  const Eigen::Index n = static_cast<Eigen::Index>(interest_.size());
  const Eigen::MatrixXd own = Pick(information_, interest_, interest_);
  const Eigen::MatrixXd scaled = scales.asDiagonal() * Schur() * scales.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  // What cancels in the Schur complement is known to rounding of what it was taken from.
  const double rounding = kCut * scales.cwiseAbs2().dot(own.diagonal());
  spread.deviations = Eigen::VectorXd::Zero(n);
  spread.covariance = Eigen::MatrixXd::Zero(n, n);
  bool all = true;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double value = eigen.eigenvalues()[k];
    const Eigen::VectorXd direction = scales.asDiagonal() * eigen.eigenvectors().col(k);
    if (value > rounding && value > 0.0) {
      spread.covariance += direction * direction.transpose() / value;
      continue;
    }
    all = false;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (std::abs(eigen.eigenvectors()(j, k)) > 1e-6) {
        spread.deviations[j] = std::numeric_limits<double>::infinity();
      }
    }
  }
  for (Eigen::Index j = 0; j < n; ++j) spread.deviations[j] += std::sqrt(spread.covariance(j, j));
  if (n > 0) spread.weakest = eigen.eigenvectors().col(0);
  if (all) {
    const Eigen::VectorXd inverse = spread.deviations.cwiseInverse();
    spread.correlation = inverse.asDiagonal() * spread.covariance * inverse.asDiagonal();
  }
  return spread;
}

Eigen::VectorXd Posterior::ChangeBy(const Eigen::VectorXd& product) const {
  std::vector<int> free = interest_;
  free.insert(free.end(), nuisances_.begin(), nuisances_.end());
  Eigen::VectorXd right(free.size());
  for (size_t i = 0; i < free.size(); ++i) right[i] = product[free[i]];
  const Eigen::VectorXd change = -ScaledPseudoInverse(Pick(information_, free, free), kCut) * right;
  return change.head(interest_.size());
}

}  // namespace darboux
