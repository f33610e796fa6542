#include "solver/rigid_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <sstream>

namespace darboux {
namespace {

// Relative size below which a component counts as rounding.
constexpr double kNegligible = 1e-6;

// Orthonormal basis of the null space, singular values relative to the largest possible one of a
// row. Not by a^T a: with ten thousand rows its rounding would hold what they leave free.
Eigen::MatrixXd NullSpace(const Eigen::MatrixXd& a) {
  if (a.rows() == 0) return Eigen::MatrixXd::Identity(a.cols(), a.cols());
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  const Eigen::MatrixXd r =
      qr.matrixQR().topRows(std::min(a.rows(), a.cols())).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(r, Eigen::ComputeFullV);
  const Eigen::Index held = (svd.singularValues().array() >= kNegligible).count();
  return svd.matrixV().rightCols(a.cols() - held);
}

// "x" or "(0.6, 0.8, 0)"; the sign of a direction means nothing here.
std::string DirectionName(Eigen::Vector3d direction) {
  direction.normalize();
  int largest;
  direction.cwiseAbs().maxCoeff(&largest);
  if (direction[largest] < 0.0) direction = -direction;
  if ((direction - Eigen::Vector3d::Unit(largest)).norm() < kNegligible) {
    return std::string(1, "xyz"[largest]);
  }
  std::ostringstream out;
  out.precision(4);
  out << "(";
  for (int i = 0; i < 3; ++i) {
    out << (i ? ", " : "") << (std::abs(direction[i]) < kNegligible ? 0.0 : direction[i]);
  }
  out << ")";
  return out.str();
}

// Rows in reduced echelon form from the front, so that coordinate directions show where they can.
Eigen::MatrixXd ReducedColumns(const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd a = basis.transpose();
  int row = 0;
  for (int column = 0; column < a.cols() && row < a.rows(); ++column) {
    int pivot;
    const double size = a.col(column).tail(a.rows() - row).cwiseAbs().maxCoeff(&pivot);
    if (size < kNegligible) continue;
    a.row(row).swap(a.row(row + pivot));
    a.row(row) /= a(row, column);
    for (int i = 0; i < a.rows(); ++i) {
      if (i != row) a.row(i) -= a(i, column) * a.row(row);
    }
    ++row;
  }
  return a.transpose();
}

}  // namespace

Eigen::Matrix<double, 1, 6> RigidFrame::DisplacementRow(const Eigen::Vector3d& x,
                                                        const Eigen::Vector3d& direction) const {
  Eigen::Matrix<double, 1, 6> row;
  row << direction.transpose(), ((x - center) / length).cross(direction).transpose();
  return row;
}

Eigen::Matrix<double, 1, 6> RigidFrame::DerivativeRow(const Eigen::Vector3d& tangent,
                                                      const Eigen::Vector3d& direction) const {
  Eigen::Matrix<double, 1, 6> row;
  row << Eigen::RowVector3d::Zero(), tangent.cross(direction).transpose();
  return row;
}

Eigen::MatrixXd FreeMotions(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& allowed) {
  Eigen::MatrixXd scaled = rows;
  for (int i = 0; i < scaled.rows(); ++i) {
    const double norm = scaled.row(i).norm();
    if (norm > 0.0) scaled.row(i) /= norm;
  }
  return allowed * NullSpace(scaled * allowed);
}

std::vector<std::string> NameMotions(const Eigen::MatrixXd& motions, const RigidFrame& frame) {
  std::vector<std::string> names;
  if (motions.cols() == 0) return names;
  // Translations: combinations without rotation.
  const Eigen::MatrixXd combine = NullSpace(motions.bottomRows<3>());
  const Eigen::MatrixXd translations = motions * combine;
  const Eigen::MatrixXd reduced = ReducedColumns(translations.topRows<3>());
  for (int i = 0; i < reduced.cols(); ++i) {
    names.push_back("translation along " + DirectionName(reduced.col(i)));
  }
  // The rest of the space, with its translations removed as far as they are free.
  Eigen::MatrixXd rest = motions;
  if (translations.cols() > 0) rest -= translations * (translations.transpose() * motions);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rest);
  const int k = static_cast<int>(motions.cols() - translations.cols());
  if (k == 0) return names;
  const Eigen::MatrixXd range = Eigen::MatrixXd(qr.householderQ()).leftCols(k);
  Eigen::MatrixXd turned(6, k);
  turned << range.bottomRows<3>(), range.topRows<3>();
  const Eigen::MatrixXd rotations = ReducedColumns(turned);
  for (int i = 0; i < k; ++i) {
    const Eigen::Vector3d axis = rotations.col(i).head<3>() / frame.length;
    const Eigen::Vector3d shift = rotations.col(i).tail<3>();
    Eigen::Vector3d through = frame.center + axis.cross(shift) / axis.squaredNorm();
    const double pitch = axis.dot(shift) / axis.squaredNorm();
    for (int c = 0; c < 3; ++c) {
      if (std::abs(through[c]) < kNegligible * frame.length) through[c] = 0.0;
    }
    std::ostringstream name;
    name.precision(6);
    name << "rotation about the axis through (" << through.x() << ", " << through.y() << ", "
         << through.z() << ") along " << DirectionName(axis);
    if (std::abs(pitch) > kNegligible * frame.length) {
      name << ", advancing " << pitch << " per radian";
    }
    names.push_back(name.str());
  }
  return names;
}

}  // namespace darboux
