#include "costs/edge_moment.h"

#include <ceres/jet.h>

#include <Eigen/Geometry>
#include <cmath>

#include "costs/cross_matrix.h"

namespace darboux {

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// d_1 and d_2 as columns.
Eigen::Matrix<double, 3, 2> Inputs(const StrainPoint& point, double const* const* displacements) {
  Eigen::Matrix<double, 3, 2> d = Eigen::Matrix<double, 3, 2>::Zero();
  for (int i = 0; i < point.weights.cols(); ++i) {
    d += Eigen::Map<const Eigen::Vector3d>(displacements[i]) *
         point.weights.col(i).segment<2>(kRowD1).transpose();
  }
  return d;
}

// Whether a vector of components (sine, cosine) across an axis has a direction there, up to
// rounding, also where the whole vector is long.
bool HasDirection(double sine, double cosine, double squared_length) {
  return sine * sine + cosine * cosine > 1e-24 * (1.0 + squared_length);
}

// The representative of an angle that is nearest to the reference.
double Nearest(double angle, double reference) {
  return angle + 2.0 * M_PI * std::round((reference - angle) / (2.0 * M_PI));
}

}  // namespace

EdgeMoment::EdgeMoment(const StrainPoint& point,
                       const Eigen::Vector2d& tangent,
                       const Eigen::Vector3d& moment,
                       const double* factor,
                       double s)
    : Potential(s), point_(point), tangent_(tangent), factor_(factor) {
  for (int i = 0; i < point_.weights.cols(); ++i) mutable_parameter_block_sizes()->push_back(3);
  const Eigen::Vector3d e = tangent.x() * point.t1 + tangent.y() * point.t2;
  const Eigen::Vector3d v = e.cross(point.n);
  // A component of the moment that is exactly or by rounding zero asks for no angle.
  const auto add =
      [&](double share, const Eigen::Vector3d& axis, const Eigen::Vector3d& rest, Follows follows) {
        const double component = moment.dot(axis);
        if (std::abs(component) > 1e-14 * moment.norm()) {
          turns_.push_back({share * component, axis, rest, follows});
        }
      };
  add(1.0, e, point.n, Follows::kNormal);
  add(1.0, v, point.n, Follows::kNormal);
  add(0.5, point.n, e, Follows::kTangent);
  add(0.5, point.n, v, Follows::kConormal);
}

bool EdgeMoment::EvaluateEnergy(double const* const* displacements,
                                double* energy,
                                double** gradients) const {
  using Jet = ceres::Jet<double, 6>;
  using Vector = Eigen::Matrix<Jet, 3, 1>;
  const Eigen::Matrix<double, 3, 2> d = Inputs(point_, displacements);
  Vector x1, x2;
  for (int k = 0; k < 3; ++k) {
    x1[k] = Jet(point_.t1[k]) + Jet(d(k, 0), k);
    x2[k] = Jet(point_.t2[k]) + Jet(d(k, 1), 3 + k);
  }
  Jet work(0.0);
  for (const Turn& turn : turns_) {
    Vector deformed;
    switch (turn.follows) {
      case Follows::kNormal:
        deformed = x1.cross(x2);
        break;
      case Follows::kTangent:
        deformed = x1 * Jet(tangent_.x()) + x2 * Jet(tangent_.y());
        break;
      case Follows::kConormal:
        deformed = x1 * Jet(tangent_.y()) - x2 * Jet(tangent_.x());
        break;
    }
    const Eigen::Vector3d across = turn.axis.cross(turn.rest);
    const Jet sine = deformed.dot(across.cast<Jet>());
    const Jet cosine = deformed.dot(turn.rest.cast<Jet>());
    if (!HasDirection(sine.a, cosine.a, deformed.dot(deformed).a)) return false;
    Jet angle = atan2(sine, cosine);
    angle.a = Nearest(angle.a, turn.reference);
    work += turn.moment * angle;
  }
  const double scale = -*factor_ * point_.area;
  *energy = scale * work.a;
  if (gradients != nullptr) {
    for (int i = 0; i < point_.weights.cols(); ++i) {
      if (gradients[i] == nullptr) continue;
      Eigen::Map<Eigen::Vector3d>{gradients[i]} =
          scale * (point_.weights(kRowD1, i) * work.v.head<3>() +
                   point_.weights(kRowD2, i) * work.v.tail<3>());
    }
  }
  return true;
}

bool EdgeMoment::Linearise(double const* const* displacements,
                           Eigen::Matrix3Xd* force,
                           Eigen::MatrixXd* stiffness) const {
  const Eigen::Matrix<double, 3, 2> d = Inputs(point_, displacements);
  const Eigen::Vector3d x1 = point_.t1 + d.col(0), x2 = point_.t2 + d.col(1);
  // A component a . w of the followed vector, its gradient and second derivative by (d_1, d_2).
  struct Component {
    double value;
    Vector6d gradient;
    Matrix6d second;
  };
  const auto component = [&](Follows follows, const Eigen::Vector3d& a) {
    Component c;
    c.second.setZero();
    if (follows == Follows::kNormal) {
      c.value = x1.cross(x2).dot(a);
      c.gradient << x2.cross(a), a.cross(x1);
      c.second.topRightCorner<3, 3>() = -CrossMatrix(a);
      c.second.bottomLeftCorner<3, 3>() = CrossMatrix(a);
      return c;
    }
    const Eigen::Vector2d along =
        follows == Follows::kTangent ? tangent_ : Eigen::Vector2d(tangent_.y(), -tangent_.x());
    c.value = a.dot(along.x() * x1 + along.y() * x2);
    c.gradient << along.x() * a, along.y() * a;
    return c;
  };
  Vector6d gradient = Vector6d::Zero();
  Matrix6d second = Matrix6d::Zero();
  for (const Turn& turn : turns_) {
    const Component s = component(turn.follows, turn.axis.cross(turn.rest));
    const Component c = component(turn.follows, turn.rest);
    const double length = turn.follows == Follows::kNormal ? x1.squaredNorm() * x2.squaredNorm()
                                                           : x1.squaredNorm() + x2.squaredNorm();
    if (!HasDirection(s.value, c.value, length)) return false;
    const double squared = s.value * s.value + c.value * c.value;
    // phi = atan2(s, c): d phi = (c ds - s dc) / squared
    const Vector6d by_angle = (c.value * s.gradient - s.value * c.gradient) / squared;
    const Vector6d by_length = 2.0 * (s.value * s.gradient + c.value * c.gradient) / squared;
    gradient += turn.moment * by_angle;
    second +=
        turn.moment * ((c.value * s.second - s.value * c.second +
                        s.gradient * c.gradient.transpose() - c.gradient * s.gradient.transpose()) /
                           squared -
                       by_angle * by_length.transpose());
  }
  const double scale = *factor_ * point_.area;
  const int n = static_cast<int>(point_.weights.cols());
  *force = scale * (gradient.head<3>() * point_.weights.row(kRowD1) +
                    gradient.tail<3>() * point_.weights.row(kRowD2));
  if (stiffness == nullptr) return true;
  stiffness->resize(3 * n, 3 * n);
  for (int j = 0; j < n; ++j) {
    const Eigen::Matrix<double, 6, 3> half = second.leftCols<3>() * point_.weights(kRowD1, j) +
                                             second.rightCols<3>() * point_.weights(kRowD2, j);
    for (int i = 0; i < n; ++i) {
      stiffness->block<3, 3>(3 * i, 3 * j) =
          -scale * (point_.weights(kRowD1, i) * half.topRows<3>() +
                    point_.weights(kRowD2, i) * half.bottomRows<3>());
    }
  }
  return true;
}

void EdgeMoment::SetReference(double const* const* displacements) {
  const Eigen::Matrix<double, 3, 2> d = Inputs(point_, displacements);
  const Eigen::Vector3d x1 = point_.t1 + d.col(0), x2 = point_.t2 + d.col(1);
  for (Turn& turn : turns_) {
    const Eigen::Vector3d deformed = turn.follows == Follows::kNormal
                                         ? Eigen::Vector3d(x1.cross(x2))
                                     : turn.follows == Follows::kTangent
                                         ? Eigen::Vector3d(tangent_.x() * x1 + tangent_.y() * x2)
                                         : Eigen::Vector3d(tangent_.y() * x1 - tangent_.x() * x2);
    const double angle =
        std::atan2(deformed.dot(turn.axis.cross(turn.rest)), deformed.dot(turn.rest));
    turn.reference = Nearest(angle, turn.reference);
  }
}

Eigen::Matrix3Xd MomentWork(const StrainPoint& point, const Eigen::Vector3d& moment) {
  const double m1 = moment.dot(point.t1), m2 = moment.dot(point.t2), mn = moment.dot(point.n);
  const Eigen::Vector3d by_d1 = -m2 * point.n + 0.5 * mn * point.t2;
  const Eigen::Vector3d by_d2 = m1 * point.n - 0.5 * mn * point.t1;
  return by_d1 * point.weights.row(kRowD1) + by_d2 * point.weights.row(kRowD2);
}

}  // namespace darboux
