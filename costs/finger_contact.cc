#include "costs/finger_contact.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace darboux {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

FingerContact::FingerContact(std::shared_ptr<const ContactPoints> points,
                             const ContactFinger* finger,
                             const double* multipliers,
                             bool with_travel)
    : points_(std::move(points)),
      finger_(finger),
      multipliers_(multipliers),
      with_travel_(with_travel) {
  CHECK_GT(points_->size(), 0);
  for (int i = 0; i < points_->num_vertices(); ++i) mutable_parameter_block_sizes()->push_back(3);
  if (with_travel_) mutable_parameter_block_sizes()->push_back(1);
  set_num_residuals(points_->size());
}

template <typename OnPoint>
bool FingerContact::ForEachPoint(double const* const* parameters,
                                 OnPoint on_point,
                                 double reach) const {
  const FingerPose pose = finger_->PoseAt(Travel(parameters));
  const Ball ball = pose.Bounds(*finger_->shape);
  for (int q = 0; q < points_->size(); ++q) {
    const Vector3d x = points_->Deformed(q, parameters);
    Contact contact;
    // Most points are far away; a mesh's distance is not for them.
    contact.gap = (x - ball.center).norm() - ball.radius - finger_->offset;
    contact.pressure = Multiplier(q) - finger_->stiffness * contact.gap;
    if (contact.pressure > 0.0 || contact.gap < reach) {
      const bool has_normal = pose.Evaluate(*finger_->shape, x, &contact.distance);
      contact.gap = contact.distance.value - finger_->offset;
      contact.pressure = Multiplier(q) - finger_->stiffness * contact.gap;
      if (!has_normal && contact.pressure > 0.0) return false;
    }
    contact.pressure = std::max(0.0, contact.pressure);
    on_point(q, x, contact);
  }
  return true;
}

bool FingerContact::Evaluate(double const* const* parameters,
                             double* residuals,
                             double** jacobians) const {
  const int n = points_->num_vertices();
  return ForEachPoint(parameters, [&](int q, const Vector3d&, const Contact& contact) {
    residuals[q] = std::sqrt(points_->areas[q] / finger_->stiffness) * contact.pressure;
    if (jacobians == nullptr) return;
    // dr/dx = -sqrt(k dA) n, and the finger's travel moves x back.
    const double scale =
        contact.pressure > 0.0 ? std::sqrt(points_->areas[q] * finger_->stiffness) : 0.0;
    const Vector3d by_x = -scale * contact.distance.normal;
    for (int i = 0; i < n; ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Vector3d>(jacobians[i] + 3 * q) = points_->weights(q, i) * by_x;
    }
    if (with_travel_ && jacobians[n] != nullptr) jacobians[n][q] = -by_x.dot(finger_->direction);
  });
}

bool FingerContact::LineariseSoftened(double const* const* parameters,
                                      double part,
                                      Matrix3Xd* force,
                                      MatrixXd* stiffness) const {
  const int n = points_->num_vertices();
  force->setZero(3, n);
  if (stiffness != nullptr) stiffness->setZero(3 * n, 3 * n);
  return ForEachPoint(parameters, [&](int q, const Vector3d&, const Contact& contact) {
    if (!(contact.pressure > 0.0)) return;
    const Vector3d& normal = contact.distance.normal;
    const double area = points_->areas[q];
    *force += area * contact.pressure * normal * points_->weights.row(q);
    if (stiffness == nullptr) return;
    const Matrix3d at_point = area * (finger_->stiffness * normal * normal.transpose() -
                                      part * contact.pressure * contact.distance.hessian);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        stiffness->block<3, 3>(3 * i, 3 * j) +=
            points_->weights(q, i) * points_->weights(q, j) * at_point;
      }
    }
  });
}

bool FingerContact::LineariseTravel(double const* const* parameters,
                                    TravelDerivatives* by_travel) const {
  *by_travel = TravelDerivatives();
  by_travel->force.setZero(3, points_->num_vertices());
  const Vector3d& direction = finger_->direction;
  return ForEachPoint(parameters, [&](int q, const Vector3d&, const Contact& contact) {
    if (!(contact.pressure > 0.0)) return;
    const Vector3d& normal = contact.distance.normal;
    const double area = points_->areas[q];
    const Vector3d by_t = area * (finger_->stiffness * normal.dot(direction) * normal -
                                  contact.pressure * contact.distance.hessian * direction);
    by_travel->energy += area * contact.pressure * normal.dot(direction);
    by_travel->stiffness += by_t.dot(direction);
    by_travel->force += by_t * points_->weights.row(q);
  });
}

bool FingerContact::States(double const* const* parameters,
                           std::vector<ContactState>* states,
                           double reach) const {
  states->assign(points_->size(), ContactState());
  const auto set = [&](int q, const Vector3d& x, const Contact& contact) {
    ContactState& state = (*states)[q];
    state.position = x;
    state.normal = contact.distance.normal;
    state.gap = contact.gap;
    state.pressure = contact.pressure;
    state.force_on_finger = -contact.pressure * points_->areas[q] * contact.distance.normal;
  };
  return ForEachPoint(parameters, set, reach);
}

bool FingerContact::Energy(double const* const* parameters, double* energy) const {
  *energy = 0.0;
  return ForEachPoint(parameters, [&](int q, const Vector3d&, const Contact& contact) {
    const double p = contact.pressure, multiplier = Multiplier(q);
    *energy += points_->areas[q] / (2.0 * finger_->stiffness) * (p - multiplier) * (p + multiplier);
  });
}

}  // namespace darboux
