#include "costs/friction.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace darboux {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Tangents = Eigen::Matrix<double, 3, 2>;

// Any two: the energy depends on the length of the slip alone.
Tangents TangentsOf(const Vector3d& normal) {
  Tangents tangents;
  tangents.col(0) = normal.unitOrthogonal();
  tangents.col(1) = normal.cross(tangents.col(0));
  return tangents;
}

Matrix3d Projector(const Vector3d& normal) {
  return Matrix3d::Identity() - normal * normal.transpose();
}

}  // namespace

Friction::Friction(std::shared_ptr<const ContactPoints> points,
                   const ContactFinger* finger,
                   const FrictionPoint* state,
                   bool with_travel)
    : points_(std::move(points)), finger_(finger), state_(state), with_travel_(with_travel) {
  CHECK_GT(points_->size(), 0);
  for (int i = 0; i < points_->num_vertices(); ++i) mutable_parameter_block_sizes()->push_back(3);
  if (with_travel_) mutable_parameter_block_sizes()->push_back(1);
  set_num_residuals(2 * points_->size());
}

Vector3d Friction::FingerPosition(double const* const* parameters) const {
  return finger_->PoseAt(with_travel_ ? parameters[points_->num_vertices()][0] : 0.0).position;
}

bool Friction::Evaluate(double const* const* parameters,
                        double* residuals,
                        double** jacobians) const {
  const int n = points_->num_vertices();
  const double e = finger_->stick_length;
  const Vector3d finger = FingerPosition(parameters);
  for (int q = 0; q < points_->size(); ++q) {
    const FrictionPoint& state = state_[q];
    const Tangents tangents = TangentsOf(state.normal);
    const Vector2d s =
        tangents.transpose() * (points_->Deformed(q, parameters) - finger - state.anchor);
    const double length = s.norm();
    const double scale = std::sqrt(2.0 * finger_->friction * std::max(0.0, state.normal_force));
    // root = sqrt(f) / s, finite at s = 0, and its derivative by s.
    double root, slope;
    if (length < e) {
      root = std::sqrt((1.0 - length / (3.0 * e)) / e);
      slope = -1.0 / (6.0 * e * e * root);
    } else {
      root = std::sqrt(length - e / 3.0) / length;
      slope = (0.5 / root - root * length) / (length * length);
    }
    Eigen::Map<Vector2d>(residuals + 2 * q) = scale * root * s;
    if (jacobians == nullptr) continue;
    Eigen::Matrix2d by_s = root * Eigen::Matrix2d::Identity();
    if (length > 0.0) by_s += slope / length * s * s.transpose();
    const Eigen::Matrix<double, 2, 3> by_x = scale * by_s * tangents.transpose();
    for (int i = 0; i < n; ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(jacobians[i] + 6 * q) =
          points_->weights(q, i) * by_x;
    }
    if (with_travel_ && jacobians[n] != nullptr) {
      Eigen::Map<Vector2d>(jacobians[n] + 2 * q) = -by_x * finger_->direction;
    }
  }
  return true;
}

Friction::Slip Friction::SlipOf(int q,
                                const Vector3d& finger,
                                double const* const* parameters) const {
  const FrictionPoint& state = state_[q];
  const double e = finger_->stick_length;
  Slip slip;
  slip.vector =
      Projector(state.normal) * (points_->Deformed(q, parameters) - finger - state.anchor);
  slip.length = slip.vector.norm();
  slip.normal_force = std::max(0.0, state.normal_force);
  if (slip.length < e) {
    slip.slope_over_length = (2.0 - slip.length / e) / e;
    slip.curvature = 2.0 * (1.0 - slip.length / e) / e;
  } else {
    slip.slope_over_length = 1.0 / slip.length;
    slip.curvature = 0.0;
  }
  return slip;
}

Matrix3d Friction::Stiffness(int q, const Slip& slip) const {
  Matrix3d result = slip.slope_over_length * Projector(state_[q].normal);
  if (slip.length > 0.0) {
    const Vector3d along = slip.vector / slip.length;
    result += (slip.curvature - slip.slope_over_length) * along * along.transpose();
  }
  return finger_->friction * slip.normal_force * result;
}

bool Friction::Linearise(double const* const* parameters,
                         Matrix3Xd* force,
                         MatrixXd* stiffness) const {
  const int n = points_->num_vertices();
  force->setZero(3, n);
  if (stiffness != nullptr) stiffness->setZero(3 * n, 3 * n);
  const Vector3d finger = FingerPosition(parameters);
  for (int q = 0; q < points_->size(); ++q) {
    const Slip slip = SlipOf(q, finger, parameters);
    if (slip.normal_force == 0.0) continue;
    *force -= finger_->friction * slip.normal_force * slip.slope_over_length * slip.vector *
              points_->weights.row(q);
    if (stiffness == nullptr) continue;
    const Matrix3d at_point = Stiffness(q, slip);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        stiffness->block<3, 3>(3 * i, 3 * j) +=
            points_->weights(q, i) * points_->weights(q, j) * at_point;
      }
    }
  }
  return true;
}

bool Friction::LineariseTravel(double const* const* parameters,
                               TravelDerivatives* by_travel) const {
  *by_travel = TravelDerivatives();
  by_travel->force.setZero(3, points_->num_vertices());
  const Vector3d finger = FingerPosition(parameters);
  for (int q = 0; q < points_->size(); ++q) {
    const Slip slip = SlipOf(q, finger, parameters);
    if (slip.normal_force == 0.0) continue;
    const Vector3d by_t = Stiffness(q, slip) * finger_->direction;
    by_travel->energy -= finger_->friction * slip.normal_force * slip.slope_over_length *
                         slip.vector.dot(finger_->direction);
    by_travel->stiffness += by_t.dot(finger_->direction);
    by_travel->force += by_t * points_->weights.row(q);
  }
  return true;
}

std::vector<FrictionState> Friction::States(double const* const* parameters) const {
  std::vector<FrictionState> states(points_->size());
  const Vector3d finger = FingerPosition(parameters);
  for (int q = 0; q < points_->size(); ++q) {
    const Slip slip = SlipOf(q, finger, parameters);
    states[q].slip = slip.vector;
    states[q].force_on_finger =
        finger_->friction * slip.normal_force * slip.slope_over_length * slip.vector;
    // Anchors follow a sliding point at the distance itself.
    constexpr double kSlides = 1.0 - 1e-6;
    states[q].sticks = slip.length < kSlides * finger_->stick_length;
  }
  return states;
}

void Friction::AdvanceAnchors(double const* const* parameters, FrictionPoint* state) const {
  const Vector3d finger = FingerPosition(parameters);
  for (int q = 0; q < points_->size(); ++q) {
    const Vector3d relative = points_->Deformed(q, parameters) - finger;
    Vector3d kept = Vector3d::Zero();
    if (state_[q].normal_force > 0.0) {
      const Slip slip = SlipOf(q, finger, parameters);
      kept = slip.vector;
      if (slip.length > finger_->stick_length) kept *= finger_->stick_length / slip.length;
    }
    state[q].anchor = relative - kept;
  }
}

void LagFriction(const std::vector<ContactState>& contact, FrictionPoint* state) {
  for (size_t q = 0; q < contact.size(); ++q) {
    state[q].normal_force = contact[q].force_on_finger.norm();
    if (state[q].normal_force > 0.0) state[q].normal = contact[q].normal;
  }
}

}  // namespace darboux
