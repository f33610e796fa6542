#include <algorithm>
#include <cmath>

#include "geometry/point_tree.h"
#include "solver/calibration_run.h"
#include "solver/format.h"
#include "solver/grasp.h"
#include "solver/robust_statistics.h"

// Whether scans are of the states that they are held against.

namespace darboux {
namespace {

// Numbers of points off by more than `least` and less than `most`, together with most of their
// neighbours, on the same side. Outliers so near to a surface have points of it beside them.
std::vector<size_t> BeyondTogether(const std::vector<Eigen::Vector3d>& points,
                                   const std::vector<ShellFace::Foot>& feet,
                                   double least,
                                   double most) {
  constexpr int kNeighbours = 9;  // itself is one
  PointTree tree;
  tree.Build(points);
  std::vector<size_t> together;
  for (size_t i = 0; i < points.size(); ++i) {
    const double distance = feet[i].distance;
    if (!(std::abs(distance) > least && std::abs(distance) < most)) continue;
    const PointTree::Neighbours near = tree.Nearest(points[i], kNeighbours);
    int same = 0;
    for (int k = 0; k < near.count; ++k) {
      const double other = feet[near.index[k]].distance;
      same +=
          std::abs(other) > least && std::abs(other) < most && (other > 0.0) == (distance > 0.0);
    }
    if (2 * same > near.count) together.push_back(i);
  }
  return together;
}

}  // namespace

// Where the scan is of something else than the computed state. Points inside of a closed body, or
// where a finger is, cannot be in this state at all; others may be of what was scanned as well.
void CalibrationRun::CheckRegions(int number, const CalibrationSummary::Scan& report) {
  constexpr double kRegion = 0.005;  // part of the points
  constexpr size_t kFewest = 5;
  const CalibrationProblem::Scan& scan = problem_->scans()[number];
  const StateModel& model = *(*models_)[scan.grasp];
  const double limit = 3.0 * scan.deviation;
  const size_t least = std::max(kFewest, static_cast<size_t>(kRegion * report.points));
  std::vector<double> inside, pierced, outside;
  // As far as states differ, or a match is found at all.
  const double farthest =
      std::max(2.0 * model.max_displacement(), kFarthest * model.problem().surface().size());
  for (const size_t i : BeyondTogether(scan.points, scan.feet, limit, farthest)) {
    const double distance = scan.feet[i].distance;
    if (distance < 0.0) {
      inside.push_back(-distance);
      continue;
    }
    double depth = 0.0;
    const Eigen::Vector3d x = report.pose * scan.points[i];
    for (size_t f = 0; f < model.scene().fingers.size(); ++f) {
      const FingerSpec& spec = model.scene().fingers[f];
      FingerPose pose;
      std::string ignored;
      if (spec.shape == FingerSpec::Shape::kPin) continue;
      const auto shape = MakeFinger(spec, &pose, &ignored);
      if (shape == nullptr) continue;
      const FingerReport& now = model.summary().steps.back().fingers[f];
      pose.position += (now.shift + now.travel) *
                       Eigen::Vector3d(spec.direction[0], spec.direction[1], spec.direction[2]);
      Distance to;
      pose.Evaluate(*shape, x, &to);
      depth = std::max(depth, -to.value);
    }
    (depth > limit ? pierced : outside).push_back(depth > limit ? depth : distance);
  }
  const auto words = [&](const std::vector<double>& which, const std::string& where) {
    return report.file + ": " + std::to_string(which.size()) + " of " +
           std::to_string(report.points) + " points lie together, " + Number(Median(which)) + " " +
           where;
  };
  const std::string reasons =
      ": the scan is of another state than its scene, with another travel of the fingers (a "
      "travel_error lets the scan tell it), or of another object";
  // What has a rim may be seen from behind.
  bool closed = true;
  for (int k = 0; k < 4 + model.problem().surface().num_loops(); ++k) {
    closed = closed && !model.problem().surface().HasSide(static_cast<Side>(k));
  }
  if (pierced.size() > least) {
    contradiction_ = words(pierced, "deep in a finger of the computed state") + reasons;
  } else if (inside.size() > least && closed) {
    contradiction_ = words(inside, "inside of the computed state") + reasons;
  } else if (inside.size() > least) {
    summary_.notes.push_back(words(inside, "behind the computed state; they hardly count"));
  }
  if (outside.size() > least && contradiction_.empty()) {
    summary_.notes.push_back(
        words(outside,
              "outside of the computed state: of another state, or of a finger or holder "
              "that was scanned as well; they hardly count"));
  }
}

}  // namespace darboux
