#include <algorithm>
#include <array>
#include <cmath>

#include "solver/calibration_run.h"
#include "solver/robust_statistics.h"

// Standard deviations of scans and fields, from what is known of them and what the fit leaves.

namespace darboux {
namespace {

double Length(const std::array<double, 3>& vector) {
  return std::hypot(vector[0], vector[1], vector[2]);
}

}  // namespace

// Standard deviations of the points: what is known of the noise, or what is left now; and the
// model's own errors, which neighbours share. Whether one has changed by more than 2 %.
bool CalibrationRun::SetDeviations() {
  constexpr double kNormal = 1.4826;  // standard deviation / median of absolute values
  constexpr double kChange = 0.02;
  bool changed = false;
  const auto set =
      [&](bool estimated, double noise, double left, int grasp, size_t count, auto* points) {
        const StateModel& state = *(*models_)[grasp];
        const double model =
            spec_.shape_error *
            Deformation(state.problem().surface(), state.displacements()).largest();
        // Exact data of our own model have no noise; rounding is the least.
        const double least = 1e-9 * problem_->size();
        // What is left has the model's errors in it.
        const double now = estimated ? std::max(left, least) : std::hypot(noise, model);
        const double random = estimated ? now : noise;
        const double shared =
            model * std::sqrt(std::max(1.0, static_cast<double>(count) / kRegions));
        const double share = now * now / (random * random + shared * shared);
        if (std::abs(now - points->deviation) > kChange * points->deviation ||
            std::abs(share - points->share) > kChange * points->share) {
          changed = true;
        }
        points->deviation = now;
        points->share = share;
      };
  size_t s = 0;
  for (auto& scan : problem_->scans()) {
    std::vector<double> distances;
    for (const ShellFace::Foot& foot : scan.feet) distances.push_back(std::abs(foot.distance));
    set(estimate_scan_[s],
        spec_.noise,
        kNormal * Median(distances),
        scan.grasp,
        scan.points.size(),
        &scan);
    ++s;
  }
  return SetFieldDeviations() || changed;
}

// What the means of regions and of pairs of them vary by, the more of both, as a multiple of what
// they would if errors were independent and had the field's deviation.
double CalibrationRun::RegionVariance(const CalibrationProblem::Field& field,
                                      const std::vector<std::array<double, 3>>& left) const {
  const FieldPlan& plan = fields_[&field - problem_->fields().data()];
  if (plan.num_regions == 0) return 1.0;
  const int components = field.components[0] + field.components[1] + field.components[2];
  std::vector<std::array<double, 3>> sums(plan.num_regions, {0.0, 0.0, 0.0});
  std::vector<double> counts(plan.num_regions, 0.0);
  // Outliers are not what regions share.
  const double most = CalibrationProblem::kRobust * field.deviation;
  for (size_t i = 0; i < left.size(); ++i) {
    const double factor = std::min(1.0, most / std::max(Length(left[i]), 1e-3 * most));
    counts[plan.regions[i]] += 1.0;
    for (int c = 0; c < 3; ++c) sums[plan.regions[i]][c] += factor * left[i][c];
  }
  // Each unknown that was fitted has taken one degree of freedom.
  const double fitted =
      static_cast<double>(problem_->Interest().size()) + (!field.free_motion ? 0.0
                                                          : components == 3  ? 6.0
                                                          : components == 2  ? 3.0
                                                                             : 1.0);
  // Errors that are smooth over more than one region show in pairs of them.
  double largest = 0.0;
  for (int parts = plan.num_regions; parts >= plan.num_regions / 2; parts /= 2) {
    double sum = 0.0;
    for (int r = 0; r < parts; ++r) {
      for (int c = 0; c < 3; ++c) sum += sums[r][c] * sums[r][c] / counts[r];
    }
    const double freedom = std::max(1.0, components * parts - fitted);
    largest = std::max(largest, sum / (field.deviation * field.deviation * freedom));
    for (int r = 0; r < parts / 2; ++r) {
      counts[r] = counts[2 * r] + counts[2 * r + 1];
      for (int c = 0; c < 3; ++c) sums[r][c] = sums[2 * r][c] + sums[2 * r + 1][c];
    }
  }
  return largest;
}

bool CalibrationRun::SetFieldDeviations() {
  // Median length of a vector of so many components of unit deviation: lengths do not depend on how
  // the strip was turned in front of the camera.
  constexpr double kMedianLength[] = {1.0, 0.67449, 1.17741, 1.53817};
  constexpr double kChange = 0.02;
  bool changed = false;
  for (size_t f = 0; f < fields_.size(); ++f) {
    CalibrationProblem::Field& field = problem_->fields()[f];
    FieldPlan& plan = fields_[f];
    plan.deformation = problem_->Deformation(field);
    std::vector<std::array<double, 3>> left(field.points.size());
    std::vector<double> lengths;
    const double before = field.deviation, share_before = field.share;
    for (size_t i = 0; i < field.points.size(); ++i) {
      problem_->FieldResidual(field, static_cast<int>(i), left[i].data(), nullptr);
      for (double& component : left[i]) component *= before;
      lengths.push_back(Length(left[i]));
    }
    const double error = plan.spec->shape_error * plan.deformation;
    // Exact data of our own model have no noise; rounding is the least.
    const int components = field.components[0] + field.components[1] + field.components[2];
    const double spread =
        std::max(Median(lengths) / kMedianLength[components], 1e-9 * problem_->size());
    const double known = std::hypot(plan.spec->noise, error);
    const bool estimated = !(plan.spec->noise > 0.0);
    // Far from the minimum what is left is more than noise, and a robust loss of the noise alone
    // would take all points for outliers.
    field.deviation = estimated  ? std::max(spread, error)
                      : started_ ? known
                                 : std::max(known, spread);
    field.share = 1.0;
    if (started_) {
      const double count = static_cast<double>(field.points.size());
      const double variance = field.deviation * field.deviation;
      const double random = estimated ? variance : plan.spec->noise * plan.spec->noise;
      const double shared = error * error * std::max(1.0, count / kRegions);
      field.share = std::min(
          {1.0, 1.0 / std::max(1.0, RegionVariance(field, left)), variance / (random + shared)});
    }
    changed = changed || std::abs(field.deviation - before) > kChange * before ||
              std::abs(field.share - share_before) > kChange * share_before;
  }
  return changed;
}

}  // namespace darboux
