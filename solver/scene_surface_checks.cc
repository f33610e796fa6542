#include "solver/scene_surface_checks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "solver/yaml_reader.h"

namespace darboux {
namespace {

// Samples per direction on which surface and expressions are checked.
constexpr int kSamples = 33;
// A tangent frame this small, relative to the largest on the surface, counts as degenerate: it
// stands for cells of sides 1 : 1e7. Coarse enough for a pole typed as 1.5707963.
constexpr double kDegenerate = 1e-7;
// Relative gap between the two ends of a periodic direction: 6.283185 will do for 2 pi, 6.2832
// will not.
constexpr double kPeriodicGap = 1e-6;

double Interpolate(const std::array<double, 2>& range, int i) {
  if (i == kSamples - 1) return range[1];
  return range[0] + (range[1] - range[0]) * i / (kSamples - 1);
}

double Move(const std::array<double, 2>& range, double value, double fraction) {
  return std::clamp(value + fraction * (range[1] - range[0]), range[0], range[1]);
}

}  // namespace

std::string FormatParameters(double u, double v) {
  return "u = " + FormatShort(u) + ", v = " + FormatShort(v);
}

bool HasSide(const SurfaceSpec& surface, int side) {
  if (surface.mesh != nullptr) return side == 4 && surface.is_open;
  const std::array<bool, 2>& periodic = surface.periodic;
  return side < 4 ? !periodic[side / 2] : !(periodic[0] && periodic[1]);
}

std::vector<SurfaceSample> SamplesOn(const SurfaceSpec& surface,
                                     const std::vector<SurfaceSample>& samples,
                                     const Region& region) {
  const Eigen::Vector3d center(region.center[0], region.center[1], region.center[2]);
  const std::array<double, 2>& u = surface.u_range;
  const std::array<double, 2>& v = surface.v_range;
  const auto contains = [&](const SurfaceSample& sample) {
    switch (region.kind) {
      case Region::Kind::kUMin:
        return sample.u == u[0];
      case Region::Kind::kUMax:
        return sample.u == u[1];
      case Region::Kind::kVMin:
        return sample.v == v[0];
      case Region::Kind::kVMax:
        return sample.v == v[1];
      case Region::Kind::kRim:
        if (surface.mesh != nullptr) return true;
        return (HasSide(surface, 0) && (sample.u == u[0] || sample.u == u[1])) ||
               (HasSide(surface, 2) && (sample.v == v[0] || sample.v == v[1]));
      case Region::Kind::kNear:
        return (sample.x - center).norm() <= region.radius;
    }
    return false;
  };
  std::vector<SurfaceSample> found;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(found), contains);
  return found;
}

std::vector<SurfaceSample> SamplesOnLine(const SurfaceSpec& surface, int parameter, double value) {
  const std::array<double, 2>& range = parameter == 0 ? surface.v_range : surface.u_range;
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < kSamples; ++i) {
    double p[2];
    p[parameter] = value;
    p[1 - parameter] = Interpolate(range, i);
    samples.push_back({p[0], p[1], surface.surface->Evaluate(p[0], p[1]).x});
  }
  return samples;
}

const SurfaceSample* FirstNonFinite(const Expression& expression,
                                    const std::vector<SurfaceSample>& where) {
  for (const SurfaceSample& at : where) {
    const double variables[5] = {at.u, at.v, at.x[0], at.x[1], at.x[2]};
    if (!std::isfinite(expression.Evaluate(variables))) return &at;
  }
  return nullptr;
}

SurfaceCheck::SurfaceCheck(const SurfaceSpec& spec)
    : surface_(*spec.surface), range_{spec.u_range, spec.v_range} {}

bool SurfaceCheck::IsFinite(double* u, double* v) {
  Eigen::AlignedBox3d box;
  samples_.clear();
  normal_.clear();
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      *u = Interpolate(range_[0], i);
      *v = Interpolate(range_[1], j);
      const SurfaceJet jet = surface_.Evaluate(*u, *v);
      const Eigen::Vector3d normal = jet.x_u.cross(jet.x_v);
      if (!jet.x.allFinite() || !jet.x_u.allFinite() || !jet.x_v.allFinite() ||
          !jet.x_uu.allFinite() || !jet.x_uv.allFinite() || !jet.x_vv.allFinite() ||
          !std::isfinite(normal.squaredNorm())) {
        return false;
      }
      box.extend(jet.x);
      largest_[0] = std::max(largest_[0], jet.x_u.norm());
      largest_[1] = std::max(largest_[1], jet.x_v.norm());
      samples_.push_back({*u, *v, jet.x});
      normal_.push_back(normal.norm());
    }
  }
  size_ = box.diagonal().norm();
  return true;
}

double SurfaceCheck::Mismatch(int direction, double fixed, double from, double to) const {
  const bool along_u = direction == 0;
  const SurfaceJet a = along_u ? surface_.Evaluate(from, fixed) : surface_.Evaluate(fixed, from);
  const SurfaceJet b = along_u ? surface_.Evaluate(to, fixed) : surface_.Evaluate(fixed, to);
  const double half = 0.5 * (to - from);
  const Eigen::Vector3d &a1 = along_u ? a.x_u : a.x_v, &b1 = along_u ? b.x_u : b.x_v;
  const Eigen::Vector3d &a2 = along_u ? a.x_uu : a.x_vv, &b2 = along_u ? b.x_uu : b.x_vv;
  // The trapezoidal rule is wrong by the third power of the interval on a smooth line.
  const double position = (b.x - a.x - half * (a1 + b1)).norm() / size_;
  const double derivative = (b1 - a1 - half * (a2 + b2)).norm() / largest_[direction];
  const double mismatch = std::max(position, derivative);
  return std::isfinite(mismatch) ? mismatch : std::numeric_limits<double>::infinity();
}

bool SurfaceCheck::IsSmooth(double* u, double* v) const {
  // Kinks of a thousandth of the largest derivative; bisected down to 1e-8 of the range.
  constexpr double kJump = 1e-3;
  constexpr double kShortest = 1e-8;
  for (const int direction : {0, 1}) {
    const double length = range_[direction][1] - range_[direction][0];
    for (int line = 0; line < kSamples; ++line) {
      const double fixed = Interpolate(range_[1 - direction], line);
      for (int i = 0; i + 1 < kSamples; ++i) {
        double from = Interpolate(range_[direction], i);
        double to = Interpolate(range_[direction], i + 1);
        while (Mismatch(direction, fixed, from, to) > kJump) {
          if (to - from <= kShortest * length) {
            *u = direction == 0 ? 0.5 * (from + to) : fixed;
            *v = direction == 0 ? fixed : 0.5 * (from + to);
            return false;
          }
          const double middle = 0.5 * (from + to);
          if (Mismatch(direction, fixed, from, middle) >= Mismatch(direction, fixed, middle, to)) {
            to = middle;
          } else {
            from = middle;
          }
        }
      }
    }
  }
  return true;
}

bool SurfaceCheck::IsRegular(double* u, double* v) const {
  const double scale = largest_[0] * largest_[1];
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      const double here = normal_[j * kSamples + i];
      *u = Interpolate(range_[0], i);
      *v = Interpolate(range_[1], j);
      if (!(here > kDegenerate * scale)) return false;
      if (here < 0.5 * scale && IsLowest(i, j) && Descend(kDegenerate * scale, u, v)) {
        return false;
      }
    }
  }
  return true;
}

bool SurfaceCheck::IsPole(int direction, int end) const {
  const int other = 1 - direction;
  if (!(largest_[other] > 0.0)) return false;  // So do all lines.
  for (int i = 0; i < kSamples; ++i) {
    double p[2];
    p[direction] = range_[direction][end];
    p[other] = Interpolate(range_[other], i);
    const SurfaceJet jet = surface_.Evaluate(p[0], p[1]);
    const Eigen::Vector3d& tangent = other == 0 ? jet.x_u : jet.x_v;
    if (!(tangent.norm() <= 2.0 * kDegenerate * largest_[other])) return false;
  }
  return true;
}

bool SurfaceCheck::IsPeriodic(int direction, std::string* difference) const {
  const int other = 1 - direction;
  const std::string name = direction == 0 ? "u" : "v";
  for (int k = 0; k < kSamples; ++k) {
    SurfaceJet end[2];
    double p[2];
    p[other] = Interpolate(range_[other], k);
    for (int i = 0; i < 2; ++i) {
      p[direction] = range_[direction][i];
      end[i] = surface_.Evaluate(p[0], p[1]);
    }
    const auto differ = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double scale) {
      return !((a - b).norm() <= kPeriodicGap * scale);
    };
    std::string what;
    if (differ(end[0].x, end[1].x, size_)) {
      what = "surface points " + FormatShort((end[0].x - end[1].x).norm()) + " apart";
    } else if (differ(end[0].x_u, end[1].x_u, largest_[0])) {
      what = "different sigma_u";
    } else if (differ(end[0].x_v, end[1].x_v, largest_[1])) {
      what = "different sigma_v";
    }
    if (!what.empty()) {
      *difference = what + " at the two ends of " + name + " (" + (other == 0 ? "u" : "v") + " = " +
                    FormatShort(p[other]) + ")";
      return false;
    }
  }
  return true;
}

bool SurfaceCheck::IsLowest(int i, int j) const {
  const double here = normal_[j * kSamples + i];
  for (int l = std::max(j - 1, 0); l <= std::min(j + 1, kSamples - 1); ++l) {
    for (int k = std::max(i - 1, 0); k <= std::min(i + 1, kSamples - 1); ++k) {
      if (normal_[l * kSamples + k] < here) return false;
    }
  }
  return true;
}

bool SurfaceCheck::Descend(double limit, double* u, double* v) const {
  const auto norm = [this](double p, double q) {
    const SurfaceJet jet = surface_.Evaluate(p, q);
    return jet.x_u.cross(jet.x_v).norm();
  };
  double lowest = norm(*u, *v);
  double step = 1.0 / (kSamples - 1);
  for (int round = 0; round < 200 && step > 1e-12 && lowest > limit; ++round) {
    double best_u = *u, best_v = *v, best = lowest;
    for (int a = -1; a <= 1; ++a) {
      for (int b = -1; b <= 1; ++b) {
        const double p = Move(range_[0], *u, a * step);
        const double q = Move(range_[1], *v, b * step);
        const double value = norm(p, q);
        if (value < best * (1.0 - 1e-6)) {  // More than rounding.
          best = value;
          best_u = p;
          best_v = q;
        }
      }
    }
    if (best < lowest) {
      lowest = best;
      *u = best_u;
      *v = best_v;
      step *= 2.0;  // Shortened too early, in a narrow valley.
    } else {
      step *= 0.5;
    }
  }
  return lowest <= limit;
}

}  // namespace darboux
