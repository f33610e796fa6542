#include "geometry/finger_shape.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Distance to the ball of `radius` about d = 0 in the subspace onto which `projector` projects: a
// sphere, a cylinder or, in one dimension, a pair of planes.
bool DistanceToRound(const Vector3d& d, double radius, const Matrix3d& projector, Distance* out) {
  const double length = d.norm();
  out->value = length - radius;
  if (!(length > 0.0)) {
    out->normal.setZero();
    out->hessian.setZero();
    return false;
  }
  out->normal = d / length;
  out->hessian = (projector - out->normal * out->normal.transpose()) / length;
  return true;
}

// Capsules and their limits: spheres (length 0) and the pin (radius 0 too).
class Capsule : public FingerShape {
 public:
  Capsule(double radius, double length) : radius_(radius), half_(0.5 * length) {}

  bool Evaluate(const Vector3d& x, Distance* out) const override {
    const double z = std::min(std::max(x.z(), -half_), half_);
    const Vector3d d(x.x(), x.y(), x.z() - z);
    const bool side = std::abs(x.z()) < half_;
    return DistanceToRound(d, radius_, Vector3d(1.0, 1.0, side ? 0.0 : 1.0).asDiagonal(), out);
  }
  Ball Bounds() const override { return {Vector3d::Zero(), half_ + radius_}; }
  double MaxStep() const override { return radius_; }

 private:
  double radius_, half_;
};

// A box of half sizes core_ and everything within rounding_ of it.
class Box : public FingerShape {
 public:
  Box(const Vector3d& half_sizes, double rounding)
      : core_(half_sizes.array() - rounding), rounding_(rounding) {}

  bool Evaluate(const Vector3d& x, Distance* out) const override {
    const Vector3d beyond = x.cwiseAbs() - core_;
    const Vector3d sign = x.unaryExpr([](double c) { return c < 0.0 ? -1.0 : 1.0; });
    int axis;
    const double largest = beyond.maxCoeff(&axis);
    if (largest > 0.0) {
      const Vector3d active = beyond.unaryExpr([](double c) { return c > 0.0 ? 1.0 : 0.0; });
      const Vector3d d = beyond.cwiseProduct(active).cwiseProduct(sign);
      return DistanceToRound(d, rounding_, active.asDiagonal(), out);
    }
    out->value = largest - rounding_;
    out->normal = sign[axis] * Vector3d::Unit(axis);
    out->hessian.setZero();
    return true;
  }
  Ball Bounds() const override { return {Vector3d::Zero(), core_.norm() + rounding_}; }
  double MaxStep() const override { return core_.minCoeff() + rounding_; }

 private:
  Vector3d core_;
  double rounding_;
};

class Plane : public FingerShape {
 public:
  bool Evaluate(const Vector3d& x, Distance* out) const override {
    out->value = x.z();
    out->normal = Vector3d::UnitZ();
    out->hessian.setZero();
    return true;
  }
  Ball Bounds() const override {
    return {Vector3d::Zero(), std::numeric_limits<double>::infinity()};
  }
  double MaxStep() const override { return std::numeric_limits<double>::infinity(); }
};

}  // namespace

double FingerShape::Reach() const {
  const Ball ball = Bounds();
  return ball.center.norm() + ball.radius;
}

std::shared_ptr<const FingerShape> MakePinFinger() { return std::make_shared<Capsule>(0.0, 0.0); }

std::shared_ptr<const FingerShape> MakeSphereFinger(double radius) {
  CHECK_GT(radius, 0.0);
  return std::make_shared<Capsule>(radius, 0.0);
}

std::shared_ptr<const FingerShape> MakeCapsuleFinger(double radius, double length) {
  CHECK_GT(radius, 0.0);
  CHECK_GE(length, 0.0);
  return std::make_shared<Capsule>(radius, length);
}

std::shared_ptr<const FingerShape> MakeBoxFinger(const Vector3d& half_sizes, double rounding) {
  CHECK_GT(half_sizes.minCoeff(), 0.0);
  CHECK(rounding >= 0.0 && rounding <= half_sizes.minCoeff()) << rounding;
  return std::make_shared<Box>(half_sizes, rounding);
}

std::shared_ptr<const FingerShape> MakePlaneFinger() { return std::make_shared<Plane>(); }

bool FingerPose::Evaluate(const FingerShape& shape, const Vector3d& x, Distance* out) const {
  const bool ok = shape.Evaluate(rotation.transpose() * (x - position), out);
  out->normal = rotation * out->normal;
  out->hessian = rotation * out->hessian * rotation.transpose();
  return ok;
}

Ball FingerPose::Bounds(const FingerShape& shape) const {
  const Ball ball = shape.Bounds();
  return {position + rotation * ball.center, ball.radius};
}

}  // namespace darboux
