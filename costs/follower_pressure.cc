#include "costs/follower_pressure.h"

#include <Eigen/Geometry>
#include <utility>

#include "costs/cross_matrix.h"

namespace darboux {
namespace {

// Displacement, d_1 and d_2 at a point as columns.
Eigen::Matrix3d Inputs(const StrainPoint& point, double const* const* displacements) {
  Eigen::Matrix3d inputs = Eigen::Matrix3d::Zero();
  for (int i = 0; i < point.weights.cols(); ++i) {
    inputs += Eigen::Map<const Eigen::Vector3d>(displacements[i]) *
              point.weights.col(i).head<3>().transpose();
  }
  return inputs;
}

// x_1 x x_2 - n
Eigen::Vector3d NormalChange(const StrainPoint& point, const Eigen::Matrix3d& inputs) {
  const Eigen::Vector3d d1 = inputs.col(1), d2 = inputs.col(2);
  return point.t1.cross(d2) + d1.cross(point.t2) + d1.cross(d2);
}

}  // namespace

FollowerPressure::FollowerPressure(StrainPoints points,
                                   std::vector<double> pressure,
                                   const Eigen::Vector3d& origin,
                                   const double* factor,
                                   double s,
                                   bool linear)
    : Potential(s),
      points_(std::move(points)),
      pressure_(std::move(pressure)),
      origin_(origin),
      factor_(factor),
      linear_(linear) {
  const int n = static_cast<int>(points_->front().weights.cols());
  for (int i = 0; i < n; ++i) mutable_parameter_block_sizes()->push_back(3);
}

template <typename Weight>
double FollowerPressure::Sum(double const* const* displacements,
                             const Weight& weight,
                             double** gradients) const {
  const int n = static_cast<int>(parameter_block_sizes().size());
  double sum = 0.0;
  if (gradients != nullptr) {
    for (int i = 0; i < n; ++i) {
      if (gradients[i] != nullptr) Eigen::Map<Eigen::Vector3d>(gradients[i]).setZero();
    }
  }
  for (size_t q = 0; q < points_->size(); ++q) {
    const StrainPoint& point = (*points_)[q];
    const double scale = weight(q) * point.area / 3.0;
    const Eigen::Matrix3d inputs = Inputs(point, displacements);
    const Eigen::Vector3d u = inputs.col(0);
    Eigen::Matrix3d derivative = Eigen::Matrix3d::Zero();
    if (linear_) {
      sum += 3.0 * scale * u.dot(point.n);
      derivative.col(0) = 3.0 * point.n;
    } else {
      const Eigen::Vector3d change = NormalChange(point, inputs);
      const Eigen::Vector3d arm = point.position - origin_ + u;
      sum += scale * (u.dot(point.n) + arm.dot(change));
      // d(arm.N): by u: N; by d_1: x_2 x arm; by d_2: arm x x_1.
      derivative.col(0) = point.n + change;
      derivative.col(1) = (point.t2 + inputs.col(2)).cross(arm);
      derivative.col(2) = arm.cross(point.t1 + inputs.col(1));
    }
    if (gradients == nullptr) continue;
    derivative *= scale;
    for (int i = 0; i < n; ++i) {
      if (gradients[i] == nullptr) continue;
      Eigen::Map<Eigen::Vector3d>(gradients[i]) += derivative * point.weights.col(i).head<3>();
    }
  }
  return sum;
}

bool FollowerPressure::EvaluateEnergy(double const* const* displacements,
                                      double* energy,
                                      double** gradients) const {
  *energy = Sum(
      displacements, [this](size_t q) { return -*factor_ * pressure_[q]; }, gradients);
  return true;
}

Eigen::Matrix3Xd FollowerPressure::ExactForce(double const* const* displacements) const {
  Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, parameter_block_sizes().size());
  for (size_t q = 0; q < points_->size(); ++q) {
    const StrainPoint& point = (*points_)[q];
    Eigen::Vector3d normal = point.n;
    if (!linear_) normal += NormalChange(point, Inputs(point, displacements));
    force += (*factor_ * pressure_[q] * point.area) * normal * point.weights.row(kRowValue);
  }
  return force;
}

double FollowerPressure::RestVolume() const {
  double volume = 0.0;
  for (const StrainPoint& point : *points_) {
    volume += point.area / 3.0 * (point.position - origin_).dot(point.n);
  }
  return volume;
}

double FollowerPressure::SweptVolume(double const* const* displacements, double** gradients) const {
  return Sum(
      displacements, [](size_t) { return 1.0; }, gradients);
}

bool FollowerPressure::Linearise(double const* const* displacements,
                                 Eigen::Matrix3Xd* force,
                                 Eigen::MatrixXd* stiffness) const {
  *force = ExactForce(displacements);
  if (stiffness == nullptr) return true;
  const int n = static_cast<int>(parameter_block_sizes().size());
  stiffness->setZero(3 * n, 3 * n);
  if (linear_) return true;
  for (size_t q = 0; q < points_->size(); ++q) {
    const StrainPoint& point = (*points_)[q];
    const Eigen::Matrix3d inputs = Inputs(point, displacements);
    const double scale = *factor_ * pressure_[q] * point.area;
    // dN = dx_1 x x_2 + x_1 x dx_2
    const Eigen::Matrix3d by_d1 = scale * CrossMatrix(point.t2 + inputs.col(2));
    const Eigen::Matrix3d by_d2 = -scale * CrossMatrix(point.t1 + inputs.col(1));
    for (int j = 0; j < n; ++j) {
      const Eigen::Matrix3d derivative =
          point.weights(kRowD1, j) * by_d1 + point.weights(kRowD2, j) * by_d2;
      for (int i = 0; i < n; ++i) {
        stiffness->block<3, 3>(3 * i, 3 * j) += point.weights(kRowValue, i) * derivative;
      }
    }
  }
  return true;
}

}  // namespace darboux
