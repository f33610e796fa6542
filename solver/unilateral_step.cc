#include "solver/unilateral_step.h"

#include <algorithm>

namespace darboux {

UnilateralStep::UnilateralStep(const Grasp& grasp,
                               const TangentStiffness& tangent,
                               SparseCholesky* cholesky,
                               double reach,
                               const std::vector<int>* in_matrix)
    : tangent_(tangent), cholesky_(cholesky) {
  size_t found = 0;
  for (Grasp::ContactRow& row : grasp.ContactRows(reach)) {
    const bool pushes = row.residual > 0.0;
    const bool in = in_matrix != nullptr
                        ? std::binary_search(in_matrix->begin(), in_matrix->end(), row.point)
                        : pushes;
    if (in) ++found;
    points_.push_back({std::move(row), in, in, pushes});
  }
  is_valid_ = in_matrix == nullptr || found == in_matrix->size();
}

std::vector<int> UnilateralStep::Contact() const {
  std::vector<int> contact;
  for (const Point& point : points_) {
    if (point.pushes) contact.push_back(point.row.point);
  }
  std::sort(contact.begin(), contact.end());
  return contact;
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
    if (points_[p].on == points_[p].in_matrix && points_[p].on == points_[p].pushes) continue;
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
  // 1 + D W, W = C^T K^-1 C.
  const int n = static_cast<int>(changed_.size());
  Eigen::MatrixXd small = Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < n; ++i) {
    const Point& a = points_[changed_[i]];
    for (int j = 0; j < n; ++j) {
      small(i, j) += Added(a) * gram_(a.column, points_[changed_[j]].column);
    }
  }
  if (n > 0) small_.compute(small);
  return true;
}

void UnilateralStep::AddColumns(const Eigen::VectorXd& x, Eigen::VectorXd* step) const {
  for (size_t k = 0; k < changed_.size(); ++k) {
    *step += x[k] * solved_.col(points_[changed_[k]].column);
  }
}

Eigen::VectorXd UnilateralStep::Small(Eigen::VectorXd x) const {
  for (size_t k = 0; k < changed_.size(); ++k) x[k] *= Added(points_[changed_[k]]);
  return small_.solve(x);
}

int UnilateralStep::Correct(Eigen::VectorXd* step) {
  const Eigen::VectorXd plain = *step;
  constexpr int kMaxPasses = 30;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const Eigen::Matrix3Xd displacements = tangent_.Expand(*step);
    // Points that do not push any more, and those that do not yet, have forces in the gradient and
    // a part in K that do not belong together.
    bool agree = pass > 0 || std::all_of(points_.begin(), points_.end(), [](const Point& point) {
                   return point.on == point.pushes;
                 });
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
    // K' s = -g + C r, r of points that the model has and the gradient has not, and minus those it
    // is the other way round with; K' = K + C D C^T.
    Eigen::VectorXd forces(changed_.size()), along(changed_.size());
    for (size_t k = 0; k < changed_.size(); ++k) {
      const Point& point = points_[changed_[k]];
      forces[k] = point.on == point.pushes ? 0.0
                  : point.on               ? point.row.residual
                                           : -point.row.residual;
    }
    for (size_t k = 0; k < changed_.size(); ++k) {
      const int column = points_[changed_[k]].column;
      along[k] = columns_.col(column).dot(plain);
      for (size_t j = 0; j < changed_.size(); ++j) {
        along[k] += gram_(column, points_[changed_[j]].column) * forces[j];
      }
    }
    *step = plain;
    if (!changed_.empty()) AddColumns(forces - Small(along), step);
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
  AddColumns(-Small(x), &result);
  return result;
}

}  // namespace darboux
