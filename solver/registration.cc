#include "solver/registration.h"

#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "costs/scan_distance.h"
#include "geometry/point_tree.h"
#include "solver/parallel_for.h"
#include "solver/rigid_motion.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Motion = Eigen::Matrix<double, 6, 1>;
using Motions = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr int kFewestPoints = 10;
// Of a normal distribution: standard deviation over the median of |d|; what is left of it within
// three of them.
constexpr double kSigmaOverMedian = 1.482602218505602;
constexpr double kTruncatedSigma = 0.986578;
constexpr double kRobustSigmas = 3.0;
constexpr double kTukey = 4.685;  // 95 % efficient for normal noise

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double MedianAbsolute(const std::vector<double>& values) {
  std::vector<double> absolute(values.size());
  std::transform(
      values.begin(), values.end(), absolute.begin(), [](double d) { return std::abs(d); });
  return Median(std::move(absolute));
}

Vector3d MedianPoint(const std::vector<Vector3d>& points) {
  Vector3d result;
  std::vector<double> coordinate(points.size());
  for (int k = 0; k < 3; ++k) {
    for (size_t i = 0; i < points.size(); ++i) coordinate[i] = points[i][k];
    result[k] = Median(coordinate);
  }
  return result;
}

// Centre, spread and axes of points most of which belong to a body, and of the sphere through them.
struct Shape {
  Vector3d center, sphere_center;
  double radius;  // median distance from the centre
  Matrix3d axes;  // columns, right-handed, ascending variance
};

Shape MakeShape(const std::vector<Vector3d>& points) {
  Shape shape;
  shape.center = MedianPoint(points);
  const auto distances = [&points](const Vector3d& from) {
    std::vector<double> result;
    for (const Vector3d& x : points) result.push_back((x - from).norm());
    return result;
  };
  shape.radius = Median(distances(shape.center));
  constexpr double kFar = 2.5;  // medians from the centre
  std::vector<Vector3d> near;
  for (const Vector3d& x : points) {
    if ((x - shape.center).norm() <= kFar * shape.radius) near.push_back(x);
  }
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& x : near) mean += x / static_cast<double>(near.size());
  shape.center = mean;
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& x : near) covariance += (x - mean) * (x - mean).transpose();
  shape.axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors();
  if (shape.axes.determinant() < 0.0) shape.axes.col(0) *= -1.0;

  // |x|^2 = 2 c . x + k in least squares, reweighted against outliers.
  shape.sphere_center = mean;
  std::vector<double> weights(near.size(), 1.0);
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (size_t i = 0; i < near.size(); ++i) {
      const Vector3d y = (near[i] - mean) / shape.radius;
      const Eigen::Vector4d row(2.0 * y.x(), 2.0 * y.y(), 2.0 * y.z(), 1.0);
      normal += weights[i] * row * row.transpose();
      right += weights[i] * y.squaredNorm() * row;
    }
    const Eigen::Vector4d solution = normal.ldlt().solve(right);
    if (!solution.allFinite() || solution.head<3>().norm() > 10.0) break;  // flat
    shape.sphere_center = mean + shape.radius * solution.head<3>();
    std::vector<double> residuals;
    const double radius =
        shape.radius * std::sqrt(std::max(0.0, solution[3] + solution.head<3>().squaredNorm()));
    for (const Vector3d& x : near) residuals.push_back((x - shape.sphere_center).norm() - radius);
    const double scale = std::max(MedianAbsolute(residuals), 1e-9 * shape.radius);
    for (size_t i = 0; i < near.size(); ++i) {
      const double r = residuals[i] / (2.0 * scale);
      weights[i] = 1.0 / (1.0 + r * r);
    }
  }
  return shape;
}

// The rotations of the icosahedron: none is farther than 45 degrees from one of them. The identity
// comes first.
std::vector<Quaterniond> SpreadRotations() {
  std::vector<Quaterniond> rotations = {Quaterniond::Identity()};
  const auto add = [&rotations](const Eigen::Vector4d& q) {  // w, x, y, z
    const Quaterniond candidate(q[0], q[1], q[2], q[3]);
    for (const Quaterniond& known : rotations) {
      if (std::abs(known.dot(candidate)) > 1.0 - 1e-9) return;
    }
    rotations.push_back(candidate.normalized());
  };
  for (int k = 1; k < 4; ++k) add(Eigen::Vector4d::Unit(k));
  for (int signs = 0; signs < 16; ++signs) {
    add(0.5 * Eigen::Vector4d(
                  signs & 1 ? 1 : -1, signs & 2 ? 1 : -1, signs & 4 ? 1 : -1, signs & 8 ? 1 : -1));
  }
  const double phi = 0.5 * (1.0 + std::sqrt(5.0));
  std::array<int, 4> order = {0, 1, 2, 3};
  do {
    int inversions = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j] ? 1 : 0;
    }
    if (inversions % 2 != 0) continue;
    for (int signs = 0; signs < 8; ++signs) {
      const double values[4] = {0.0,
                                signs & 1 ? 0.5 : -0.5,
                                (signs & 2 ? 0.5 : -0.5) / phi,
                                (signs & 4 ? 0.5 : -0.5) * phi};
      Eigen::Vector4d q;
      for (int i = 0; i < 4; ++i) q[order[i]] = values[i];
      add(q);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

// Rotations that take axes onto axes, with all signs and permutations.
std::vector<Quaterniond> AxisRotations(const Matrix3d& from, const Matrix3d& to) {
  std::vector<Quaterniond> rotations;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d permuted;
      for (int k = 0; k < 3; ++k)
        permuted.col(k) = (signs >> k & 1 ? -1.0 : 1.0) * to.col(order[k]);
      if (permuted.determinant() < 0.0) continue;
      rotations.emplace_back(Matrix3d(permuted * from.transpose()));
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

// A pose on trial, with the feet of the points it is tried with.
struct Trial {
  RigidPose pose;
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
  double score = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool stays = false;  // not dropped for a worse score
};

// Points of the face with their normals, in place of feet while poses are far from right.
struct Samples {
  explicit Samples(const ShellFace& face) {
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
  // To the tangent plane of the nearest sample; beyond its neighbours, to its disc.
  ShellFace::Foot Nearest(const Vector3d& x) const {
    const int i = tree.Nearest(x, 1).index[0];
    ShellFace::Foot foot = feet[i];
    const Vector3d gap = x - foot.position;
    const double along = foot.normal.dot(gap);
    const double lateral = (gap - along * foot.normal).norm();
    foot.distance = std::copysign(std::hypot(along, std::max(0.0, lateral - reach[i])), along);
    return foot;
  }

  std::vector<ShellFace::Foot> feet;
  std::vector<double> reach;
  PointTree tree;
};

class Aligner {
 public:
  // samples: in place of feet; or null.
  Aligner(const ShellFace& face,
          const std::vector<Vector3d>& points,
          int num_threads,
          const Samples* samples = nullptr)
      : face_(face), points_(points), num_threads_(num_threads), samples_(samples) {
    size_ = face.surface().size();
  }

  const std::vector<Vector3d>& points() const { return points_; }

  // Feet in the trial's pose; those it has are hints.
  void FindFeet(Trial* trial) const {
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

  struct Schedule {
    int iterations = 20;
    double first_factor = 1.0;  // of sigma, halved until it is 1: graduated non-convexity
    double prior = 1e-6;        // what keeps motions that nothing determines still
    double tolerance = 1e-5;    // of the size: a step that ends it
  };
  // Reweighted Gauss-Newton. weights: of points, or none. kept: motions that are not wanted, about
  // the frame of `MakeFrame`, orthonormal columns.
  void Align(const Schedule& schedule,
             const std::vector<double>& weights,
             const Motions& kept,
             Trial* trial) const {
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

  // About the middle of the points in the trial's pose.
  ScanDistance::Frame MakeFrame(const Trial& trial) const {
    ScanDistance::Frame frame;
    frame.center.setZero();
    const double n = static_cast<double>(points_.size());
    for (const Vector3d& x : points_) frame.center += (trial.pose * x) / n;
    double squared = 0.0;
    for (const Vector3d& x : points_) squared += (trial.pose * x - frame.center).squaredNorm() / n;
    frame.length = std::max(std::sqrt(squared), 1e-9 * size_);
    return frame;
  }

  // Direction along which the distance of a point changes: the normal, or beyond a boundary the
  // way to it.
  static Vector3d Direction(const Vector3d& x, const ShellFace::Foot& foot) {
    if (!foot.on_boundary || foot.distance == 0.0) return foot.normal;
    return (x - foot.position) / foot.distance;
  }

 private:
  static double Sigma(const std::vector<double>& distances, const std::vector<double>& weights) {
    if (weights.empty()) return kSigmaOverMedian * MedianAbsolute(distances);
    std::vector<double> chosen;
    for (size_t i = 0; i < distances.size(); ++i) {
      if (weights[i] > 0.0) chosen.push_back(distances[i]);
    }
    return kSigmaOverMedian * MedianAbsolute(chosen);
  }

  // Moves the trial's pose; returns how far.
  double Step(double sigma,
              double prior,
              const std::vector<double>& weights,
              const Motions& kept,
              Trial* trial) const {
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

  const ShellFace& face_;
  const std::vector<Vector3d>& points_;
  int num_threads_;
  const Samples* samples_;
  double size_;
};

// Mean of |d| over the nearer part: for poses that are not good yet.
double TrimmedScore(const std::vector<double>& distances) {
  constexpr double kPart = 0.7;
  std::vector<double> absolute;
  for (const double d : distances) absolute.push_back(std::abs(d));
  const size_t count = std::max<size_t>(1, static_cast<size_t>(kPart * absolute.size()));
  std::nth_element(absolute.begin(), absolute.begin() + (count - 1), absolute.end());
  return std::accumulate(absolute.begin(), absolute.begin() + count, 0.0) /
         static_cast<double>(count);
}

// Mean of min((d / sigma)^2, 9): tells a dent at the right place from one at another.
double TruncatedScore(const std::vector<double>& distances, double sigma) {
  double sum = 0.0;
  for (const double d : distances) {
    const double r = d / sigma;
    sum += std::min(r * r, kRobustSigmas * kRobustSigmas);
  }
  return sum / static_cast<double>(distances.size());
}

// Root mean square of what two poses make of the points.
double Apart(const RigidPose& a, const RigidPose& b, const std::vector<Vector3d>& points) {
  double sum = 0.0;
  for (const Vector3d& x : points) sum += (a * x - b * x).squaredNorm();
  return std::sqrt(sum / static_cast<double>(points.size()));
}

std::vector<int> Draw(int n, int count, std::uint64_t seed) {
  std::vector<int> order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  if (count <= 0 || count >= n) return order;
  std::mt19937_64 generator(seed);
  for (int i = 0; i < count; ++i) {
    const int j = i + static_cast<int>(generator() % static_cast<std::uint64_t>(n - i));
    std::swap(order[i], order[j]);
  }
  order.resize(static_cast<size_t>(count));
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<Vector3d> Pick(const std::vector<Vector3d>& points, const std::vector<int>& chosen) {
  std::vector<Vector3d> result;
  for (const int i : chosen) result.push_back(points[i]);
  return result;
}

std::string Format(const char* format, double a, double b = 0.0, double c = 0.0) {
  char text[256];
  std::snprintf(text, sizeof(text), format, a, b, c);
  return text;
}

// The best pose of many starts, refined with some of the points.
class Search {
 public:
  Search(const ShellFace& face,
         const std::vector<Vector3d>& scan,
         const RegistrationOptions& options)
      : face_(face), scan_(scan), options_(options), size_(face.surface().size()) {}

  RigidPose Run(const Shape& of_face, const Shape& of_scan, RegistrationSummary* summary) {
    const int n = static_cast<int>(scan_.size());
    std::vector<Quaterniond> rotations = SpreadRotations();
    for (const Quaterniond& q : AxisRotations(of_scan.axes, of_face.axes)) rotations.push_back(q);
    // A scan from one side has its middle on that side; the sphere through it is about where the
    // body's is.
    std::vector<std::pair<Vector3d, Vector3d>> centers = {{of_scan.center, of_face.center}};
    if ((of_scan.sphere_center - of_scan.center).norm() > 0.15 * of_scan.radius) {
      centers.push_back({of_scan.sphere_center, of_face.sphere_center});
    }
    std::vector<Trial> trials;
    for (const auto& [from, to] : centers) {
      for (const Quaterniond& q : rotations) {
        Trial trial;
        trial.pose = {q, to - q * from};
        trials.push_back(std::move(trial));
      }
    }
    summary->num_starts = static_cast<int>(trials.size());

    trials.front().stays = true;
    constexpr int kFewPoints = 120, kMorePoints = 240, kManyPoints = 600;
    constexpr size_t kSecond = 20, kThird = 6;
    const auto few = Pick(scan_, Draw(n, kFewPoints, options_.seed));
    const auto more = Pick(scan_, Draw(n, kMorePoints, options_.seed + 1));
    const auto many = Pick(scan_, Draw(n, kManyPoints, options_.seed + 2));
    const Samples samples(face_);
    Refine(few, &samples, {6, 1.0, 1e-3, 1e-3}, &trials);
    Drop(kSecond, &trials);
    Refine(more, &samples, {20, 2.0, 1e-4, 1e-4}, &trials);
    RemoveTwins(more, &trials);
    Drop(kThird, &trials);
    Refine(many, nullptr, {20, 2.0, 1e-6, 1e-10}, &trials);
    RemoveTwins(more, &trials);

    double sigma = std::max(options_.noise, 1e-13 * size_),
           lowest = RobustSigma(trials[0].distances);
    for (const Trial& trial : trials) lowest = std::min(lowest, RobustSigma(trial.distances));
    sigma = std::max(sigma, lowest);
    for (Trial& trial : trials) trial.score = TruncatedScore(trial.distances, sigma);
    double best = trials[0].score;
    for (const Trial& trial : trials) best = std::min(best, trial.score);
    // Of equals, the one that turns least.
    const auto as_good = [best](const Trial& trial) { return trial.score <= 1.03 * best + 0.02; };
    const Trial* chosen = nullptr;
    for (const Trial& trial : trials) {
      if (!as_good(trial)) continue;
      if (chosen == nullptr ||
          std::abs(trial.pose.rotation.w()) > std::abs(chosen->pose.rotation.w()) + 1e-9) {
        chosen = &trial;
      }
    }
    summary->equivalent_poses =
        static_cast<int>(std::count_if(trials.begin(), trials.end(), as_good)) - 1;
    return chosen->pose;
  }

 private:
  static void Drop(size_t most, std::vector<Trial>* trials) {
    for (size_t i = most; i < trials->size(); ++i) {
      if ((*trials)[i].stays) std::swap((*trials)[i], (*trials)[most - 1]);
    }
    trials->resize(std::min(trials->size(), most));
  }

  void Refine(const std::vector<Vector3d>& points,
              const Samples* samples,
              const Aligner::Schedule& schedule,
              std::vector<Trial>* trials) const {
    const Aligner aligner(face_, points, 1, samples);
    const int n = static_cast<int>(trials->size());
    const auto work = [&](int, int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Trial& trial = (*trials)[i];
        trial.feet.clear();
        aligner.Align(schedule, {}, Motions(6, 0), &trial);
        trial.score = TrimmedScore(trial.distances);
      }
    };
    ParallelFor(std::clamp(options_.num_threads, 1, n), n, work);
    std::stable_sort(trials->begin(), trials->end(), [](const Trial& a, const Trial& b) {
      return a.score < b.score;
    });
  }

  void RemoveTwins(const std::vector<Vector3d>& points, std::vector<Trial>* trials) const {
    constexpr double kSame = 0.02;
    std::vector<Trial> kept;
    for (Trial& trial : *trials) {
      bool is_new = true;
      for (Trial& other : kept) {
        if (Apart(trial.pose, other.pose, points) > kSame * size_) continue;
        is_new = false;
        if (!trial.stays) continue;
        other.pose = trial.pose;
        other.stays = true;
      }
      if (is_new) kept.push_back(std::move(trial));
    }
    *trials = std::move(kept);
  }

  const ShellFace& face_;
  const std::vector<Vector3d>& scan_;
  const RegistrationOptions& options_;
  double size_;
};

// Eigenvalues of the normal equations of the inliers, per point; motions that they leave free.
Motions FreeOf(const Aligner& aligner,
               const Trial& trial,
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
    const Vector3d n = Aligner::Direction(x, trial.feet[i]);
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
void Report(const Trial& trial,
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

// Where a point of the middle surface was at rest, and where it is.
std::array<Vector3d, 2> RestAndNow(const ShellSurface& surface,
                                   const StrainPoint& point,
                                   int element,
                                   const Eigen::Matrix3Xd& displacements) {
  std::array<Vector3d, 2> x = {point.position, point.position};
  const std::vector<int>& vertices = surface.control_vertices(element);
  for (size_t i = 0; i < vertices.size(); ++i) {
    x[1] += point.weights(kRowValue, static_cast<int>(i)) * displacements.col(vertices[i]);
  }
  return x;
}

// min over g  sum w |now - g rest|^2, by Kabsch.
RigidPose RigidMotionOf(const std::vector<std::array<Vector3d, 2>>& points,
                        const std::vector<double>& weights) {
  std::array<Vector3d, 2> center = {Vector3d::Zero(), Vector3d::Zero()};
  double sum = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t k = 0; k < 2; ++k) center[k] += weights[i] * points[i][k];
    sum += weights[i];
  }
  for (Vector3d& c : center) c /= sum;
  Matrix3d covariance = Matrix3d::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    covariance += weights[i] * (points[i][1] - center[1]) * (points[i][0] - center[0]).transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) = -u.col(2);
  const Matrix3d rotation = u * svd.matrixV().transpose();
  return {Quaterniond(rotation), center[1] - rotation * center[0]};
}

std::string Join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

DistanceStatistics MakeDistanceStatistics(const std::vector<double>& distances) {
  DistanceStatistics result;
  result.count = static_cast<int>(distances.size());
  result.histogram.assign(kHistogramBins, 0);
  if (distances.empty()) return result;
  const double n = result.count;
  double squares = 0.0;
  for (const double d : distances) {
    result.mean += d / n;
    result.mean_abs += std::abs(d) / n;
    result.max = std::max(result.max, std::abs(d));
  }
  for (const double d : distances) squares += (d / std::max(result.max, 1e-300)) * d;
  result.rms = std::sqrt(squares / n * result.max);
  result.median_abs = MedianAbsolute(distances);
  result.bin_width = result.max / kHistogramBins;
  for (const double d : distances) {
    const int bin = result.max > 0.0 ? static_cast<int>(std::abs(d) / result.bin_width) : 0;
    ++result.histogram[static_cast<size_t>(std::min(bin, kHistogramBins - 1))];
  }
  return result;
}

double EstimateNoise(const std::vector<Vector3d>& points, const std::vector<double>& distances) {
  constexpr size_t kFewest = 8;
  constexpr int kNeighbours = 7;  // itself is one
  if (points.size() < kFewest || points.size() != distances.size()) return 0.0;
  std::vector<int> kept(points.size());
  std::iota(kept.begin(), kept.end(), 0);
  double sigma = 0.0;
  // The second time without outliers, which spoil the means of their neighbours as well.
  for (int round = 0; round < 2 && kept.size() >= kFewest; ++round) {
    PointTree tree;
    tree.Build(Pick(points, kept));
    std::vector<double> differences;
    differences.reserve(kept.size());
    for (size_t i = 0; i < kept.size(); ++i) {
      const PointTree::Neighbours near = tree.Nearest(points[kept[i]], kNeighbours);
      double mean = 0.0;
      int count = 0;
      for (int k = 0; k < near.count; ++k) {
        if (near.index[k] == static_cast<int>(i)) continue;
        mean += distances[kept[near.index[k]]];
        ++count;
      }
      // Variance of d_i - mean of m others: (1 + 1/m) sigma^2.
      differences.push_back((distances[kept[i]] - mean / count) / std::sqrt(1.0 + 1.0 / count));
    }
    sigma = kSigmaOverMedian * MedianAbsolute(differences);
    constexpr double kFar = 4.0;
    std::vector<int> next;
    for (size_t i = 0; i < kept.size(); ++i) {
      if (std::abs(differences[i]) <= kFar * sigma) next.push_back(kept[i]);
    }
    kept = std::move(next);
  }
  return sigma;
}

double RobustSigma(const std::vector<double>& distances) {
  double sigma = kSigmaOverMedian * MedianAbsolute(distances);
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    int count = 0;
    for (const double d : distances) {
      if (std::abs(d) > kRobustSigmas * sigma) continue;
      sum += d * d;
      ++count;
    }
    if (count > 0) sigma = std::sqrt(sum / count) / kTruncatedSigma;
  }
  return sigma;
}

Deformation::Deformation(const ShellSurface& surface, const Eigen::Matrix3Xd& displacements)
    : surface_(surface), displacements_(displacements) {
  if (displacements.isZero(0.0)) return;
  std::vector<std::array<Vector3d, 2>> points;
  std::vector<double> areas, weights, left;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const StrainPoint point = surface.MakePoint({e, 1.0 / 3.0, 1.0 / 3.0}, 0.5);
    points.push_back(RestAndNow(surface, point, e, displacements));
    areas.push_back(point.area);
  }
  // By iteratively reweighted least squares; |x| is rounded off to sqrt(x^2 + rounding^2), with
  // less and less of it: from the start the mean decides, in the end the median.
  constexpr double kExact = 1e-9;  // of the largest of what the mean leaves
  constexpr double kLess = 0.5;
  constexpr int kIterations = 60;
  weights = areas;
  double rounding = 0.0, least = 0.0;
  for (int i = 0; i <= kIterations; ++i) {
    motion_ = RigidMotionOf(points, weights);
    left.clear();
    for (const auto& [rest, now] : points) left.push_back((now - motion_ * rest).norm());
    if (i == 0) {
      rounding = *std::max_element(left.begin(), left.end());
      least = kExact * rounding;
      // Nothing but rounding is left of a rigid motion.
      if (rounding <= 1e-14 * surface.size()) break;
    }
    rounding = std::max(kLess * rounding, least);
    for (size_t k = 0; k < left.size(); ++k) weights[k] = areas[k] / std::hypot(left[k], rounding);
  }
  for (const ElementPoint& at : surface.vertex_points()) largest_ = std::max(largest_, At(at));
}

double Deformation::At(const ElementPoint& at) const {
  const auto [rest, now] = RestAndNow(surface_, surface_.MakePoint(at), at.element, displacements_);
  return (now - motion_ * rest).norm();
}

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
  const Shape of_face = MakeShape(vertices), of_scan = MakeShape(scan);
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
  Trial trial;
  if (options.initial_pose) {
    trial.pose = *options.initial_pose;
    trial.pose.rotation.normalize();
    summary->num_starts = 1;
  } else {
    trial.pose = Search(face, scan, options).Run(of_face, of_scan, summary);
  }

  // Where it is.
  const std::vector<int> chosen =
      Draw(static_cast<int>(scan.size()), options.max_points, options.seed + 3);
  const std::vector<Vector3d> points = Pick(scan, chosen);
  const Aligner aligner(face, points, options.num_threads);
  const Aligner::Schedule coarse{30, options.initial_pose ? 4.0 : 2.0, 1e-6, 1e-6};
  const Aligner::Schedule fine{50, 1.0, 1e-8, 1e-13};
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
    Aligner(face, scan, options.num_threads).FindFeet(&trial);
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
