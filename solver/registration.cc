#include "solver/registration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "costs/scan_distance.h"
#include "solver/format.h"
#include "solver/pose_search.h"
#include "solver/rigid_motion.h"
#include "solver/robust_statistics.h"
#include "solver/scan_alignment.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

constexpr int kFewestPoints = 10;

// Eigenvalues of the normal equations of the inliers, per point; motions that they leave free.
Motions FreeOf(const ScanAligner& aligner,
               const PoseTrial& trial,
               double sigma,
               double threshold,
               Motion* eigenvalues,
               ScanDistance::Frame* frame) {
  *frame = aligner.MakeFrame(trial);
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  double count = 0.0;
  for (size_t i = 0; i < trial.feet.size(); ++i) {
    if (std::abs(trial.distances[i]) > threshold) continue;
    const Vector3d x = trial.pose * aligner.points()[i];
    const Vector3d n = ScanAligner::Direction(x, trial.feet[i]);
    Motion row;
    row << n, (x - frame->center).cross(n) / frame->length;
    normal += row * row.transpose();
    count += 1.0;
  }
  if (count == 0.0) return Motions(6, 0);
  normal /= count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(normal);
  *eigenvalues = solver.eigenvalues();
  // A triangulated sphere has normals that are off by some 1e-3; and no motion counts as known
  // whose standard deviation is a degree or so.
  constexpr double kSmall = 4e-6, kUncertain = 0.02;
  int free = 0;
  for (int k = 0; k < 6; ++k) {
    const double lambda = (*eigenvalues)[k];
    if (lambda < kSmall * (*eigenvalues)[5] ||
        sigma > kUncertain * frame->length * std::sqrt(count * std::max(lambda, 0.0))) {
      ++free;
    }
  }
  return solver.eigenvectors().leftCols(free);
}

// Distances in the trial's pose, and everything that follows from them. Points with a weight of 0,
// where there are weights, have no part in sigma.
void Report(const PoseTrial& trial,
            const std::vector<Vector3d>& scan,
            const std::vector<double>& weights,
            const RegistrationOptions& options,
            RegistrationSummary* summary) {
  summary->pose = trial.pose;
  summary->feet = trial.feet;
  summary->distances = trial.distances;
  std::vector<double> deciding;
  for (size_t i = 0; i < trial.distances.size(); ++i) {
    if (weights.empty() || weights[i] > 0.0) deciding.push_back(trial.distances[i]);
  }
  summary->sigma = RobustSigma(deciding);
  summary->noise = options.noise;
  if (!(options.noise > 0.0)) {
    // Distances do not change with the pose of the points.
    summary->noise = EstimateNoise(scan, trial.distances);
  }
  const double threshold = kRobustSigmas * std::max(summary->sigma, options.noise);
  summary->outliers.clear();
  std::vector<double> inliers;
  for (size_t i = 0; i < trial.distances.size(); ++i) {
    if (std::abs(trial.distances[i]) > threshold) {
      summary->outliers.push_back(static_cast<int>(i));
    } else {
      inliers.push_back(trial.distances[i]);
    }
  }
  summary->inlier_fraction =
      static_cast<double>(inliers.size()) / static_cast<double>(trial.distances.size());
  summary->all = MakeDistanceStatistics(trial.distances);
  summary->inliers = MakeDistanceStatistics(inliers);
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

bool RegistrationOptions::IsValid(std::string* error) const {
  const auto fail = [error](const char* name, double found, const char* allowed) {
    char text[160];
    std::snprintf(text, sizeof(text), "%s: found %g; allowed %s", name, found, allowed);
    *error = text;
    return false;
  };
  if (!(undeformed_part > 0.0 && undeformed_part <= 1.0)) {
    return fail("undeformed_part", undeformed_part, "0 < part <= 1");
  }
  if (!(noise >= 0.0) || !std::isfinite(noise)) return fail("noise", noise, ">= 0");
  if (max_points < 0) return fail("max_points", max_points, ">= 0");
  if (!(min_inliers >= 0.0 && min_inliers <= 1.0)) {
    return fail("min_inliers", min_inliers, "0 <= part <= 1");
  }
  if (!(max_relative_sigma > 0.0)) return fail("max_relative_sigma", max_relative_sigma, "> 0");
  if (num_threads < 1) return fail("num_threads", num_threads, ">= 1");
  return true;
}

bool Register(const ShellFace& face,
              const std::vector<Vector3d>& scan,
              const RegistrationOptions& options,
              RegistrationSummary* summary,
              std::string* error) {
  *summary = RegistrationSummary();
  if (!options.IsValid(error)) return false;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan[i].allFinite()) continue;
    *error = "point " + std::to_string(i) + ": found a coordinate that is not finite";
    return false;
  }
  summary->iterations = 0;
  const auto refuse = [summary](const std::string& verdict) {
    summary->matched = false;
    summary->verdict = "no match: " + verdict;
    return true;
  };
  if (scan.size() < kFewestPoints) {
    return refuse("too few points: found " + std::to_string(scan.size()) + "; allowed at least " +
                  std::to_string(kFewestPoints));
  }
  std::vector<Vector3d> vertices;
  for (const ElementPoint& at : face.surface().vertex_points()) {
    vertices.push_back(face.Evaluate(at).position);
  }
  const CloudShape of_face = MakeCloudShape(vertices), of_scan = MakeCloudShape(scan);
  const double size = face.surface().size();
  const double ratio = of_scan.radius / of_face.radius;
  constexpr double kSmallest = 0.05, kLargest = 3.0;
  if (!(ratio > kSmallest && ratio < kLargest)) {
    if (!(ratio > 0.0)) return refuse("all points are one");
    const bool larger = ratio > 1.0;
    const double factor = std::pow(10.0, std::abs(std::round(std::log10(ratio))));
    return refuse(Format("the scan is about %.0f times ", std::max(factor, 2.0)) +
                  (larger ? "larger" : "smaller") + " than the shell" +
                  Format(" (half of it lies within %.4g of its middle, of the shell within %.4g)",
                         of_scan.radius,
                         of_face.radius) +
                  ": another unit of length?");
  }

  // Where it about is.
  PoseTrial trial;
  if (options.initial_pose) {
    trial.pose = *options.initial_pose;
    trial.pose.rotation.normalize();
    summary->num_starts = 1;
  } else {
    trial.pose = SearchPose(face, scan, of_face, of_scan, options, summary);
  }

  // Where it is.
  const std::vector<int> chosen =
      DrawNumbers(static_cast<int>(scan.size()), options.max_points, options.seed + 3);
  const std::vector<Vector3d> points = PickPoints(scan, chosen);
  const ScanAligner aligner(face, points, options.num_threads);
  const ScanAligner::Schedule coarse{30, options.initial_pose ? 4.0 : 2.0, 1e-6, 1e-6};
  const ScanAligner::Schedule fine{50, 1.0, 1e-8, 1e-13};
  aligner.Align(coarse, {}, Motions(6, 0), &trial);
  std::vector<double> weights;
  if (options.method == RegistrationOptions::Method::kUndeformedFirst) {
    const Deformation deformation(face.surface(), face.displacements());
    weights.assign(points.size(), 1.0);
    summary->num_undeformed = static_cast<int>(points.size());
    if (deformation.largest() > 0.0) {
      summary->num_undeformed = 0;
      for (size_t i = 0; i < points.size(); ++i) {
        const double moved = deformation.At(trial.feet[i].at);
        weights[i] = moved <= options.undeformed_part * deformation.largest() ? 1.0 : 0.0;
        summary->num_undeformed += weights[i] > 0.0 ? 1 : 0;
      }
    }
    if (summary->num_undeformed < kFewestPoints) {
      Report(trial, points, {}, options, summary);
      return refuse(
          Format("only %.0f points lie where the shell deformed by less than %.3g of its "
                 "largest displacement; %.0f are needed",
                 summary->num_undeformed,
                 options.undeformed_part,
                 kFewestPoints));
    }
  }
  ScanDistance::Frame frame;
  {
    const double sigma = RobustSigma(trial.distances);
    const double threshold = kRobustSigmas * std::max(sigma, options.noise);
    const Motions free = FreeOf(aligner, trial, sigma, threshold, &summary->eigenvalues, &frame);
    if (free.cols() > 0) {
      summary->undetermined = NameMotions(free, {frame.center, frame.length});
      summary->equivalent_poses = 0;
    }
    aligner.Align(fine, weights, free, &trial);
  }
  summary->iterations = trial.iterations;
  if (points.size() < scan.size()) {
    trial.feet.clear();
    ScanAligner(face, scan, options.num_threads).FindFeet(&trial);
  }
  Report(
      trial, scan, points.size() < scan.size() ? std::vector<double>() : weights, options, summary);

  const double relative = summary->sigma / size;
  if (!(relative <= options.max_relative_sigma)) {
    return refuse(
        Format("another object, or nothing but outliers: distances have a standard "
               "deviation of %.3g, %.3g of the shell's size; allowed %.3g of it",
               summary->sigma,
               relative,
               options.max_relative_sigma));
  }
  if (options.noise > 0.0 && summary->sigma > 5.0 * options.noise) {
    return refuse(
        Format("another object, or one that is deformed: distances have a standard "
               "deviation of %.3g, %.3g times the noise",
               summary->sigma,
               summary->sigma / options.noise));
  }
  const double near = kRobustSigmas * options.max_relative_sigma * size;
  const double part =
      static_cast<double>(std::count_if(summary->distances.begin(),
                                        summary->distances.end(),
                                        [near](double d) { return std::abs(d) <= near; })) /
      static_cast<double>(summary->distances.size());
  if (part < options.min_inliers) {
    return refuse(Format("only %.3g of the points are within %.3g of the shell; allowed %.3g",
                         part,
                         near,
                         options.min_inliers));
  }
  summary->matched = true;
  summary->verdict = Format("matched: standard deviation %.3g, %.4g of the points are inliers",
                            summary->sigma,
                            summary->inlier_fraction);
  if (!summary->undetermined.empty()) {
    summary->verdict += "; not determined: " + Join(summary->undetermined);
  }
  if (summary->equivalent_poses > 0) {
    summary->verdict += "; " + std::to_string(summary->equivalent_poses) +
                        " other poses fit as well (the body, or what the scan shows of it, is "
                        "symmetric)";
  }
  constexpr double kSmooth = 3.0;
  if (summary->noise > 0.0 && summary->sigma > kSmooth * summary->noise) {
    summary->verdict += Format(
        "; the shapes differ: neighbouring points differ by a noise of %.3g "
        "only",
        summary->noise);
  }
  return true;
}

std::string RegistrationSummary::BriefReport() const { return verdict; }

std::string RegistrationSummary::FullReport() const {
  std::string text = verdict + "\n";
  const Eigen::AngleAxisd turn(pose.rotation);
  text += Format("  pose: turned by %.6g degrees", turn.angle() * 180.0 / M_PI) +
          Format(" about (%.6g, %.6g, %.6g)", turn.axis().x(), turn.axis().y(), turn.axis().z()) +
          Format(", moved by (%.6g, %.6g, %.6g)\n",
                 pose.translation.x(),
                 pose.translation.y(),
                 pose.translation.z());
  text += "  outliers: " + std::to_string(outliers.size()) + " of " + std::to_string(all.count) +
          Format("; sigma %.4g, noise %.4g\n", sigma, noise);
  text += Format("  distances of inliers: mean %.4g, mean absolute %.4g, rms %.4g",
                 inliers.mean,
                 inliers.mean_abs,
                 inliers.rms) +
          Format(", median absolute %.4g, max %.4g\n", inliers.median_abs, inliers.max);
  return text;
}

}  // namespace darboux
