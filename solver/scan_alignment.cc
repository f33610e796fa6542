#include "solver/scan_alignment.h"

#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solver/parallel_for.h"
#include "solver/robust_statistics.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

constexpr double kTukey = 4.685;  // 95 % efficient for normal noise

}  // namespace

FaceSamples::FaceSamples(const ShellFace& face) {
  constexpr double kAt[4][2] = {{1.0 / 3.0, 1.0 / 3.0},
                                {1.0 / 6.0, 1.0 / 6.0},
                                {2.0 / 3.0, 1.0 / 6.0},
                                {1.0 / 6.0, 2.0 / 3.0}};
  std::vector<Vector3d> points;
  for (int e = 0; e < face.surface().num_elements(); ++e) {
    for (const auto& at : kAt) {
      feet.push_back(face.Evaluate({e, at[0], at[1]}));
      points.push_back(feet.back().position);
    }
  }
  tree.Build(std::move(points));
  for (const ShellFace::Foot& foot : feet) {
    const PointTree::Neighbours near = tree.Nearest(foot.position, 7);
    reach.push_back(std::sqrt(near.squared[near.count - 1]));
  }
}

ShellFace::Foot FaceSamples::Nearest(const Vector3d& x) const {
  const int i = tree.Nearest(x, 1).index[0];
  ShellFace::Foot foot = feet[i];
  const Vector3d gap = x - foot.position;
  const double along = foot.normal.dot(gap);
  const double lateral = (gap - along * foot.normal).norm();
  foot.distance = std::copysign(std::hypot(along, std::max(0.0, lateral - reach[i])), along);
  return foot;
}

ScanAligner::ScanAligner(const ShellFace& face,
                         const std::vector<Vector3d>& points,
                         int num_threads,
                         const FaceSamples* samples)
    : face_(face), points_(points), num_threads_(num_threads), samples_(samples) {
  size_ = face.surface().size();
}

void ScanAligner::FindFeet(PoseTrial* trial) const {
  const int n = static_cast<int>(points_.size());
  const bool has_hints = trial->feet.size() == points_.size();
  trial->feet.resize(points_.size());
  trial->distances.resize(points_.size());
  const auto work = [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Vector3d x = trial->pose * points_[i];
      const ShellFace::Foot hint = trial->feet[i];
      trial->feet[i] = samples_ != nullptr ? samples_->Nearest(x)
                                           : face_.Closest(x, has_hints ? &hint : nullptr);
      trial->distances[i] = trial->feet[i].distance;
    }
  };
  ParallelFor(ThreadsFor(n, num_threads_), n, work);
}

void ScanAligner::Align(const Schedule& schedule,
                        const std::vector<double>& weights,
                        const Motions& kept,
                        PoseTrial* trial) const {
  double factor = schedule.first_factor;
  double sigma = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < schedule.iterations; ++iteration) {
    FindFeet(trial);
    // A scale that follows the median up and down would keep poses from settling: it keeps to
    // steps of 2 %, and stays where it is after a while.
    constexpr int kSettled = 10;
    constexpr double kSteps = 50.0;
    const double relative = std::max(Sigma(trial->distances, weights) / size_, 1e-15);
    const double now = size_ * std::exp(std::round(kSteps * std::log(relative)) / kSteps);
    if (iteration < kSettled || now < 0.5 * sigma) sigma = now;
    const double length = Step(factor * sigma, schedule.prior, weights, kept, trial);
    ++trial->iterations;
    const bool at_last = factor <= 1.0;
    factor = std::max(1.0, 0.5 * factor);
    if (at_last && length <= schedule.tolerance * size_) break;
  }
  FindFeet(trial);
}

ScanDistance::Frame ScanAligner::MakeFrame(const PoseTrial& trial) const {
  ScanDistance::Frame frame;
  frame.center.setZero();
  const double n = static_cast<double>(points_.size());
  for (const Vector3d& x : points_) frame.center += (trial.pose * x) / n;
  double squared = 0.0;
  for (const Vector3d& x : points_) squared += (trial.pose * x - frame.center).squaredNorm() / n;
  frame.length = std::max(std::sqrt(squared), 1e-9 * size_);
  return frame;
}

Vector3d ScanAligner::Direction(const Vector3d& x, const ShellFace::Foot& foot) {
  if (!foot.on_boundary || foot.distance == 0.0) return foot.normal;
  return (x - foot.position) / foot.distance;
}

double ScanAligner::Sigma(const std::vector<double>& distances,
                          const std::vector<double>& weights) {
  if (weights.empty()) return kSigmaOverMedian * MedianAbsolute(distances);
  std::vector<double> chosen;
  for (size_t i = 0; i < distances.size(); ++i) {
    if (weights[i] > 0.0) chosen.push_back(distances[i]);
  }
  return kSigmaOverMedian * MedianAbsolute(chosen);
}

double ScanAligner::Step(double sigma,
                         double prior,
                         const std::vector<double>& weights,
                         const Motions& kept,
                         PoseTrial* trial) const {
  const ScanDistance::Frame frame = MakeFrame(*trial);
  Motion motion = Motion::Zero();
  ceres::Problem problem;
  problem.AddParameterBlock(motion.data(), 6);
  double total = 0.0;
  for (size_t i = 0; i < points_.size(); ++i) {
    const double r = trial->distances[i] / (kTukey * sigma);
    double weight = weights.empty() ? 1.0 : weights[i];
    if (!(std::abs(r) < 1.0) || weight <= 0.0) continue;
    weight *= (1.0 - r * r) * (1.0 - r * r);
    total += weight;
    ScanDistance::Foot foot;
    foot.point = trial->pose * points_[i];
    foot.position = trial->feet[i].position;
    foot.normal = Direction(foot.point, trial->feet[i]);
    problem.AddResidualBlock(new ScanDistance(std::move(foot), frame, std::sqrt(weight) / sigma),
                             nullptr,
                             motion.data());
  }
  if (total == 0.0) return 0.0;
  constexpr double kRigid = 1e6;
  ceres::Matrix hold = std::sqrt(prior * total) / sigma * ceres::Matrix::Identity(6, 6);
  if (kept.cols() > 0) hold += kRigid * std::sqrt(total) / sigma * kept * kept.transpose();
  problem.AddResidualBlock(
      new ceres::NormalPrior(hold, ceres::Vector::Zero(6)), nullptr, motion.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.initial_trust_region_radius = 1e16;
  options.max_trust_region_radius = 1e20;
  options.max_num_iterations = 2;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 1e-15;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  // Feet are near for small angles alone.
  constexpr double kMostAngle = 0.5;
  const double turn = motion.tail<3>().norm() / (kMostAngle * frame.length);
  if (turn > 1.0) motion /= turn;
  trial->pose = frame.Pose(motion) * trial->pose;
  return motion.norm();
}

}  // namespace darboux
