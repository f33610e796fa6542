#include "solver/time_left.h"

#include <algorithm>
#include <cmath>

namespace darboux {

std::optional<double> TimeLeft::Update(const IterationReport& report) {
  if (report.total == 0) {
    reached_ = target_ = first_gradient_ = part_ = 0.0;
    smooth_ = -1.0;
  }
  // A target beyond the last one: that has been reached. One before it: the step was cut.
  if (report.load_factor != target_) {
    reached_ = report.load_factor > target_ ? target_ : std::min(reached_, report.load_factor);
    target_ = report.load_factor;
    first_gradient_ = 0.0;
  }
  const double gradient = report.relative_gradient;
  first_gradient_ = std::max(first_gradient_, gradient);
  double local = 0.0;
  if (gradient > 0.0 && first_gradient_ > gradient_tolerance_) {
    local = std::log(first_gradient_ / gradient) / std::log(first_gradient_ / gradient_tolerance_);
  }
  local = std::clamp(local, 0.0, 1.0);
  double part;
  if (report.method == IterationReport::Method::kPath) {
    part = (report.step - 1 + local) / std::max(report.step, report.steps);
  } else {
    part = reached_ + (target_ - reached_) * local;
  }
  part_ = std::clamp(std::max(part_, part), 0.0, 1.0);
  constexpr double kSoon = 1.0, kLittle = 0.01;
  if (report.seconds < kSoon || part_ < kLittle) return std::nullopt;
  const double now = report.seconds * (1.0 - part_) / part_;
  // Iterations jump; the mean over the last few does less.
  constexpr double kNew = 0.3;
  const double before = std::max(0.0, smooth_ - (report.seconds - smooth_at_));
  smooth_ = smooth_ < 0.0 ? now : kNew * now + (1.0 - kNew) * before;
  smooth_at_ = report.seconds;
  return smooth_;
}

}  // namespace darboux
