#include "costs/edge_moment.h"

#include <ceres/jet.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace darboux {

EdgeMoment::EdgeMoment(const StrainPoint& point,
                       const Eigen::Vector2d& tangent,
                       const Eigen::Vector3d& moment,
                       const double* factor,
                       double s)
    : Potential(s), point_(point), tangent_(tangent), moment_(moment), factor_(factor) {
  for (int i = 0; i < point_.weights.cols(); ++i) mutable_parameter_block_sizes()->push_back(3);
}

bool EdgeMoment::EvaluateEnergy(double const* const* displacements,
                                double* energy,
                                double** gradients) const {
  using Jet = ceres::Jet<double, 6>;
  using Vector = Eigen::Matrix<Jet, 3, 1>;
  Eigen::Matrix<double, 3, 2> d = Eigen::Matrix<double, 3, 2>::Zero();
  for (int i = 0; i < point_.weights.cols(); ++i) {
    d += Eigen::Map<const Eigen::Vector3d>(displacements[i]) *
         point_.weights.col(i).segment<2>(kRowD1).transpose();
  }
  Vector x1, x2;
  for (int k = 0; k < 3; ++k) {
    x1[k] = Jet(point_.t1[k]) + Jet(d(k, 0), k);
    x2[k] = Jet(point_.t2[k]) + Jet(d(k, 1), 3 + k);
  }
  const Vector normal = x1.cross(x2);
  const Eigen::Vector3d e = tangent_.x() * point_.t1 + tangent_.y() * point_.t2;
  const Eigen::Vector3d v = e.cross(point_.n);
  const Vector xe = x1 * Jet(tangent_.x()) + x2 * Jet(tangent_.y());
  const Vector xv = x1 * Jet(tangent_.y()) - x2 * Jet(tangent_.x());

  bool defined = true;
  // Angle from `rest` to `deformed` about `axis`; rest is normal to the axis.
  const auto turned =
      [&](const Eigen::Vector3d& axis, const Eigen::Vector3d& rest, const Vector& deformed) {
        const Eigen::Vector3d across = axis.cross(rest);
        const Jet sine = deformed.dot(across.cast<Jet>());
        const Jet cosine = deformed.dot(rest.cast<Jet>());
        // Up to rounding, also of a vector that is long itself.
        const double size = 1.0 + deformed[0].a * deformed[0].a + deformed[1].a * deformed[1].a +
                            deformed[2].a * deformed[2].a;
        if (!(sine.a * sine.a + cosine.a * cosine.a > 1e-24 * size)) {
          defined = false;
          return Jet(0.0);
        }
        return atan2(sine, cosine);
      };
  Jet work(0.0);
  // A component of the moment that is exactly or by rounding zero asks for no angle.
  const double negligible = 1e-14 * moment_.norm();
  const double about_e = moment_.dot(e), about_v = moment_.dot(v), about_n = moment_.dot(point_.n);
  if (std::abs(about_e) > negligible) work += about_e * turned(e, point_.n, normal);
  if (std::abs(about_v) > negligible) work += about_v * turned(v, point_.n, normal);
  if (std::abs(about_n) > negligible) {
    work += 0.5 * about_n * (turned(point_.n, e, xe) + turned(point_.n, v, xv));
  }
  if (!defined) return false;
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

Eigen::Matrix3Xd MomentWork(const StrainPoint& point, const Eigen::Vector3d& moment) {
  const double m1 = moment.dot(point.t1), m2 = moment.dot(point.t2), mn = moment.dot(point.n);
  const Eigen::Vector3d by_d1 = -m2 * point.n + 0.5 * mn * point.t2;
  const Eigen::Vector3d by_d2 = m1 * point.n - 0.5 * mn * point.t1;
  return by_d1 * point.weights.row(kRowD1) + by_d2 * point.weights.row(kRowD2);
}

}  // namespace darboux
