#include "solver/unilateral_step.h"

namespace darboux {

UnilateralStep::UnilateralStep(const Grasp& grasp,
                               const TangentStiffness& tangent,
                               SparseCholesky* cholesky,
                               double reach)
    : tangent_(tangent), cholesky_(cholesky) {
  for (Grasp::ContactRow& row : grasp.ContactRows(reach)) {
    const bool on = row.residual > 0.0;
    points_.push_back({std::move(row), on, on});
  }
}

double UnilateralStep::Along(const Point& point, const Eigen::Matrix3Xd& displacements) const {
  double sum = 0.0;
  for (size_t i = 0; i < point.row.vertices->size(); ++i) {
    sum += point.row.coefficients.col(i).dot(displacements.col((*point.row.vertices)[i]));
  }
  return sum;
}

bool UnilateralStep::Prepare() {
  changed_.clear();
  std::vector<int> without;
  for (size_t p = 0; p < points_.size(); ++p) {
    if (points_[p].on == points_[p].was_on) continue;
    changed_.push_back(static_cast<int>(p));
    if (points_[p].column < 0) without.push_back(static_cast<int>(p));
  }
  const int first = static_cast<int>(columns_.cols()), added = static_cast<int>(without.size());
  constexpr int kMostColumns = 500;
  if (first + added > kMostColumns) return false;
  if (added > 0) {
    columns_.conservativeResize(tangent_.num_unknowns(), first + added);
    solved_.conservativeResize(tangent_.num_unknowns(), first + added);
    for (int k = 0; k < added; ++k) {
      Point& point = points_[without[k]];
      point.column = first + k;
      columns_.col(first + k) = tangent_.Reduce(*point.row.vertices, point.row.coefficients);
    }
    solved_.rightCols(added) = cholesky_->SolveMany(columns_.rightCols(added));
    gram_.conservativeResize(first + added, first + added);
    gram_.rightCols(added).noalias() = columns_.transpose() * solved_.rightCols(added);
    gram_.bottomLeftCorner(added, first) = gram_.topRightCorner(first, added).transpose();
  }
  // 1 - C^T K^-1 C sign, sign of a point: 1 let go, -1 taken up.
  const int n = static_cast<int>(changed_.size());
  Eigen::MatrixXd small = Eigen::MatrixXd::Identity(n, n);
  for (int j = 0; j < n; ++j) {
    const Point& b = points_[changed_[j]];
    for (int i = 0; i < n; ++i) {
      const double w = gram_(points_[changed_[i]].column, b.column);
      small(i, j) -= b.was_on ? w : -w;
    }
  }
  if (n > 0) small_.compute(small);
  return true;
}

void UnilateralStep::AddColumns(const Eigen::VectorXd& x, Eigen::VectorXd* step) const {
  for (size_t k = 0; k < changed_.size(); ++k) {
    const Point& point = points_[changed_[k]];
    *step += (point.was_on ? x[k] : -x[k]) * solved_.col(point.column);
  }
}

int UnilateralStep::Correct(Eigen::VectorXd* step) {
  const Eigen::VectorXd plain = *step;
  constexpr int kMaxPasses = 30;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const Eigen::Matrix3Xd displacements = tangent_.Expand(*step);
    bool agree = true;
    for (Point& point : points_) {
      const bool on = point.row.residual - Along(point, displacements) > 0.0;
      agree = agree && on == point.on;
      point.on = on;
    }
    if (agree) break;
    if (!Prepare()) {
      changed_.clear();
      *step = plain;
      return 0;
    }
    // K' s = -g - C sign r, K' = K - C sign C^T.
    Eigen::VectorXd x(changed_.size());
    for (size_t k = 0; k < changed_.size(); ++k) {
      const Point& point = points_[changed_[k]];
      x[k] = point.row.residual - columns_.col(point.column).dot(plain);
    }
    *step = plain;
    if (!changed_.empty()) AddColumns(-small_.solve(x), step);
    if (!step->allFinite()) {
      changed_.clear();
      *step = plain;
      return 0;
    }
  }
  return static_cast<int>(changed_.size());
}

std::vector<Grasp::NormalForce> UnilateralStep::Forces(const Eigen::VectorXd& step) const {
  const Eigen::Matrix3Xd displacements = tangent_.Expand(step);
  std::vector<Grasp::NormalForce> forces;
  for (const Point& point : points_) {
    const double residual = point.row.residual - Along(point, displacements);
    if (residual <= 0.0) continue;
    forces.push_back({point.row.point, point.row.scale * residual, point.row.normal});
  }
  return forces;
}

Eigen::VectorXd UnilateralStep::Solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd result = cholesky_->Solve(b);
  if (changed_.empty()) return result;
  Eigen::VectorXd x(changed_.size());
  for (size_t k = 0; k < changed_.size(); ++k) {
    x[k] = columns_.col(points_[changed_[k]].column).dot(result);
  }
  AddColumns(small_.solve(x), &result);
  return result;
}

}  // namespace darboux
