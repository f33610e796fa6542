#include "solver/pose_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "solver/parallel_for.h"
#include "solver/robust_statistics.h"
#include "solver/scan_alignment.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d MedianPoint(const std::vector<Vector3d>& points) {
  Vector3d result;
  std::vector<double> coordinate(points.size());
  for (int k = 0; k < 3; ++k) {
    for (size_t i = 0; i < points.size(); ++i) coordinate[i] = points[i][k];
    result[k] = Median(coordinate);
  }
  return result;
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

// The best pose of many starts, refined with some of the points.
class Search {
 public:
  Search(const ShellFace& face,
         const std::vector<Vector3d>& scan,
         const RegistrationOptions& options)
      : face_(face), scan_(scan), options_(options), size_(face.surface().size()) {}

  RigidPose Run(const CloudShape& of_face,
                const CloudShape& of_scan,
                RegistrationSummary* summary) {
    const int n = static_cast<int>(scan_.size());
    std::vector<Quaterniond> rotations = SpreadRotations();
    for (const Quaterniond& q : AxisRotations(of_scan.axes, of_face.axes)) rotations.push_back(q);
    // A scan from one side has its middle on that side; the sphere through it is about where the
    // body's is.
    std::vector<std::pair<Vector3d, Vector3d>> centers = {{of_scan.center, of_face.center}};
    if ((of_scan.sphere_center - of_scan.center).norm() > 0.15 * of_scan.radius) {
      centers.push_back({of_scan.sphere_center, of_face.sphere_center});
    }
    std::vector<PoseTrial> trials;
    for (const auto& [from, to] : centers) {
      for (const Quaterniond& q : rotations) {
        PoseTrial trial;
        trial.pose = {q, to - q * from};
        trials.push_back(std::move(trial));
      }
    }
    summary->num_starts = static_cast<int>(trials.size());

    trials.front().stays = true;
    constexpr int kFewPoints = 120, kMorePoints = 240, kManyPoints = 600;
    constexpr size_t kSecond = 20, kThird = 6;
    const auto few = PickPoints(scan_, DrawNumbers(n, kFewPoints, options_.seed));
    const auto more = PickPoints(scan_, DrawNumbers(n, kMorePoints, options_.seed + 1));
    const auto many = PickPoints(scan_, DrawNumbers(n, kManyPoints, options_.seed + 2));
    const FaceSamples samples(face_);
    Refine(few, &samples, {6, 1.0, 1e-3, 1e-3}, &trials);
    Drop(kSecond, &trials);
    Refine(more, &samples, {20, 2.0, 1e-4, 1e-4}, &trials);
    RemoveTwins(more, &trials);
    Drop(kThird, &trials);
    Refine(many, nullptr, {20, 2.0, 1e-6, 1e-10}, &trials);
    RemoveTwins(more, &trials);

    double sigma = std::max(options_.noise, 1e-13 * size_),
           lowest = RobustSigma(trials[0].distances);
    for (const PoseTrial& trial : trials) lowest = std::min(lowest, RobustSigma(trial.distances));
    sigma = std::max(sigma, lowest);
    for (PoseTrial& trial : trials) trial.score = TruncatedScore(trial.distances, sigma);
    double best = trials[0].score;
    for (const PoseTrial& trial : trials) best = std::min(best, trial.score);
    // Of equals, the one that turns least.
    const auto as_good = [best](const PoseTrial& trial) {
      return trial.score <= 1.03 * best + 0.02;
    };
    const PoseTrial* chosen = nullptr;
    for (const PoseTrial& trial : trials) {
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
  static void Drop(size_t most, std::vector<PoseTrial>* trials) {
    for (size_t i = most; i < trials->size(); ++i) {
      if ((*trials)[i].stays) std::swap((*trials)[i], (*trials)[most - 1]);
    }
    trials->resize(std::min(trials->size(), most));
  }

  void Refine(const std::vector<Vector3d>& points,
              const FaceSamples* samples,
              const ScanAligner::Schedule& schedule,
              std::vector<PoseTrial>* trials) const {
    const ScanAligner aligner(face_, points, 1, samples);
    const int n = static_cast<int>(trials->size());
    const auto work = [&](int, int begin, int end) {
      for (int i = begin; i < end; ++i) {
        PoseTrial& trial = (*trials)[i];
        trial.feet.clear();
        aligner.Align(schedule, {}, Motions(6, 0), &trial);
        trial.score = TrimmedScore(trial.distances);
      }
    };
    ParallelFor(std::clamp(options_.num_threads, 1, n), n, work);
    std::stable_sort(trials->begin(), trials->end(), [](const PoseTrial& a, const PoseTrial& b) {
      return a.score < b.score;
    });
  }

  void RemoveTwins(const std::vector<Vector3d>& points, std::vector<PoseTrial>* trials) const {
    constexpr double kSame = 0.02;
    std::vector<PoseTrial> kept;
    for (PoseTrial& trial : *trials) {
      bool is_new = true;
      for (PoseTrial& other : kept) {
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

}  // namespace

CloudShape MakeCloudShape(const std::vector<Vector3d>& points) {
  CloudShape shape;
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

RigidPose SearchPose(const ShellFace& face,
                     const std::vector<Vector3d>& scan,
                     const CloudShape& of_face,
                     const CloudShape& of_scan,
                     const RegistrationOptions& options,
                     RegistrationSummary* summary) {
  return Search(face, scan, options).Run(of_face, of_scan, summary);
}

std::vector<int> DrawNumbers(int n, int count, std::uint64_t seed) {
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

std::vector<Vector3d> PickPoints(const std::vector<Vector3d>& points,
                                 const std::vector<int>& chosen) {
  std::vector<Vector3d> result;
  for (const int i : chosen) result.push_back(points[i]);
  return result;
}

}  // namespace darboux
