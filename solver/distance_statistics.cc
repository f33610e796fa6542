#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/point_tree.h"
#include "solver/registration.h"
#include "solver/robust_statistics.h"

// How far points are from a surface, in numbers, and what of that is noise.

namespace darboux {
namespace {

using Eigen::Vector3d;

// What is left within three standard deviations of a normal distribution of its own.
constexpr double kTruncatedSigma = 0.986578;

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
    std::vector<Vector3d> chosen;
    for (const int i : kept) chosen.push_back(points[i]);
    tree.Build(std::move(chosen));
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

}  // namespace darboux
