#include "geometry/first_touch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace darboux {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();

// sign * (phi - offset) at one point when the shape has moved by s, and its derivative by s.
class Gap {
 public:
  Gap(const FingerShape& shape, const FingerPose& pose, const Vector3d& direction, double offset)
      : shape_(shape), pose_(pose), direction_(direction), offset_(offset) {}

  struct Value {
    double gap, slope;
  };
  Value operator()(const Vector3d& point, double s, double sign) const {
    Distance distance;
    const bool smooth = pose_.Evaluate(shape_, point - s * direction_, &distance);
    return {sign * (distance.value - offset_),
            smooth ? -sign * distance.normal.dot(direction_) : 0.0};
  }

 private:
  const FingerShape& shape_;
  const FingerPose& pose_;
  Vector3d direction_;
  double offset_;
};

// A zero between a, where the gap is positive, and b, where it is not: Newton inside the bracket.
template <typename F>
double ZeroBetween(const F& f, double a, double b, double tiny) {
  double s = 0.5 * (a + b);
  for (int i = 0; i < 200 && std::abs(b - a) > tiny; ++i) {
    const Gap::Value value = f(s);
    if (std::abs(value.gap) <= tiny) return s;
    (value.gap > 0.0 ? a : b) = s;
    const double newton = s - value.gap / value.slope;
    const bool inside = newton > std::min(a, b) && newton < std::max(a, b);  // false if NaN
    s = inside && i % 3 != 2 ? newton : 0.5 * (a + b);  // Bisections keep it from creeping.
  }
  return s;
}

// The first zero of f after `begin` and before `end`, where f(begin) > 0 and |f'| <= 1. f is
// convex, concave or neither.
enum class Curvature { kConvex, kConcave, kUnknown };
template <typename F>
bool FirstZero(const F& f,
               Curvature curvature,
               double begin,
               double end,
               double feature_size,
               double tiny,
               double* zero) {
  double s = begin;
  Gap::Value value = f(s);
  for (int i = 0; i < 100000; ++i) {
    if (value.gap <= tiny) break;
    if (!(s <= end)) return false;
    if (curvature == Curvature::kConvex && value.slope >= 0.0) return false;
    double step = value.gap;
    if (value.slope < 0.0) {
      const double newton = -value.gap / value.slope;
      if (!std::isfinite(s + newton)) return false;
      const Gap::Value next = f(s + newton);
      if (next.gap <= 0.0) {
        if (curvature != Curvature::kUnknown || newton <= feature_size) {
          *zero = ZeroBetween(f, s, s + newton, tiny);
          return *zero <= end;
        }
      } else if (curvature == Curvature::kConvex || value.gap + next.gap >= newton) {
        step = newton;
      }
    }
    s += step;
    value = f(s);
  }
  *zero = s;
  return true;
}

// Moves backwards until no point overlaps.
bool BackOff(const FingerShape& shape,
             const FingerPose& pose,
             const Vector3d& direction,
             const std::vector<Vector3d>& points,
             double offset,
             double feature_size,
             double tiny,
             Touch* touch) {
  const Gap gap(shape, pose, -direction, offset);
  const Curvature curvature = shape.IsConvex() ? Curvature::kConcave : Curvature::kUnknown;
  const bool unbounded = !std::isfinite(feature_size);
  double s = 0.0;
  for (bool moved = true; moved;) {
    moved = false;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto overlap = [&](double at) { return gap(points[i], at, -1.0); };
      const Gap::Value value = overlap(s);
      if (value.gap <= tiny) continue;
      if (unbounded && value.slope >= 0.0) return false;
      if (!FirstZero(overlap, curvature, s, kInfinity, feature_size, tiny, &s)) return false;
      touch->point = static_cast<int>(i);
      moved = true;
    }
  }
  touch->shift = -s;
  return true;
}

}  // namespace

bool FirstTouch(const FingerShape& shape,
                const FingerPose& pose,
                const Vector3d& direction,
                const std::vector<Vector3d>& points,
                double offset,
                Touch* touch) {
  *touch = Touch();
  const Gap gap(shape, pose, direction, offset);
  const Ball ball = pose.Bounds(shape);
  double size = offset + pose.position.norm();
  if (std::isfinite(ball.radius)) size += ball.radius;
  std::vector<std::pair<double, int>> by_gap;
  for (size_t i = 0; i < points.size(); ++i) {
    by_gap.push_back({gap(points[i], 0.0, 1.0).gap, static_cast<int>(i)});
    size = std::max(size, points[i].norm());
  }
  if (by_gap.empty()) return false;
  std::sort(by_gap.begin(), by_gap.end());
  const double tiny = kRounding * size;
  const double feature_size = 1e-3 * ball.radius;
  if (by_gap.front().first < -tiny) {
    return BackOff(shape, pose, direction, points, offset, feature_size, tiny, touch);
  }
  const Curvature curvature = shape.IsConvex() ? Curvature::kConvex : Curvature::kUnknown;
  touch->shift = kInfinity;
  for (const auto& [at_rest, i] : by_gap) {
    if (at_rest >= touch->shift) break;  // Too far away to come first, as all that follow.
    double end = touch->shift;
    if (std::isfinite(ball.radius)) {
      const double reach = ball.radius + offset;
      const Vector3d arm = points[i] - ball.center;
      const double along = arm.dot(direction);
      const double squared = reach * reach - (arm - along * direction).squaredNorm();
      if (squared < 0.0) continue;
      end = std::min(end, along + std::sqrt(squared));
    }
    double zero;
    if (!FirstZero([&, point = i](double s) { return gap(points[point], s, 1.0); },
                   curvature,
                   0.0,
                   end,
                   feature_size,
                   tiny,
                   &zero)) {
      continue;
    }
    if (zero < touch->shift) *touch = {zero, i};
  }
  return touch->point >= 0;
}

}  // namespace darboux
