#include "solver/stress_recovery.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solver/parallel_for.h"

namespace darboux {
namespace {

constexpr int kTerms = 6;  // of the polynomial, quadratic; linear where points are few
constexpr int kLinear = 3;

// Elements around each element: those that share a corner, hanging ones included, and itself.
std::vector<std::vector<int>> Neighbourhoods(const ShellSurface& surface) {
  std::vector<std::vector<int>> of_corner(surface.num_corners());
  const auto for_each_corner = [&surface](int e, const auto& use) {
    for (int k = 0; k < 3; ++k) {
      use(surface.Corner(e, k));
      if (surface.HangingCorner(e, k) >= 0) use(surface.HangingCorner(e, k));
    }
  };
  for (int e = 0; e < surface.num_elements(); ++e) {
    for_each_corner(e, [&](int corner) { of_corner[corner].push_back(e); });
  }
  std::vector<std::vector<int>> result(surface.num_elements());
  for (int e = 0; e < surface.num_elements(); ++e) {
    for_each_corner(e, [&](int corner) {
      result[e].insert(result[e].end(), of_corner[corner].begin(), of_corner[corner].end());
    });
    std::sort(result[e].begin(), result[e].end());
    result[e].erase(std::unique(result[e].begin(), result[e].end()), result[e].end());
  }
  return result;
}

// Components (11, 22, 12) in the axes of `frame`, turned in the tangent plane (a transport along
// the surface: normals change by an element's curvature only).
TangentStiffness::Stress Turned(const StrainPoint& p,
                                const StrainPoint& frame,
                                const TangentStiffness::Stress& stress) {
  const double x = p.t1.dot(frame.t1) + p.t2.dot(frame.t2);
  const double y = p.t1.dot(frame.t2) - p.t2.dot(frame.t1);
  const double length = std::hypot(x, y);
  if (!(length > 0.0)) return stress;
  const double c = x / length, s = y / length;
  TangentStiffness::Stress result;
  for (const int k : {0, 3}) {
    const double a = stress[k], b = stress[k + 1], d = stress[k + 2];
    result[k] = c * c * a + s * s * b - 2.0 * c * s * d;
    result[k + 1] = s * s * a + c * c * b + 2.0 * c * s * d;
    result[k + 2] = c * s * (a - b) + (c * c - s * s) * d;
  }
  return result;
}

// Twice the complementary energy per area, in the units of the problem.
double Energy(const Material& material, const TangentStiffness::Stress& stress) {
  const double nu = material.poisson_ratio;
  const auto part = [&](int k, double stiffness) {
    const double a = stress[k], b = stress[k + 1], d = stress[k + 2];
    return (a * a + b * b - 2.0 * nu * a * b + 2.0 * (1.0 + nu) * d * d) /
           ((1.0 - nu * nu) * stiffness);
  };
  return part(0, material.MembraneStiffness()) + part(3, material.BendingStiffness());
}

}  // namespace

StressRecovery::StressRecovery(const ShellProblem& problem)
    : problem_(problem), neighbourhoods_(Neighbourhoods(problem.surface())) {
  first_.push_back(0);
  for (const auto& points : problem.strain_points()) {
    first_.push_back(first_.back() + static_cast<int>(points->size()));
  }
}

std::vector<double> StressRecovery::Norms(const TangentStiffness::StressField& stresses,
                                          int num_threads) const {
  const int count = problem_.surface().num_elements();
  std::vector<double> norms(count);
  ParallelFor(ThreadsFor(count, num_threads), count, [&](int, int begin, int end) {
    for (int e = begin; e < end; ++e) norms[e] = Norm(e, stresses);
  });
  return norms;
}

double StressRecovery::Norm(int element, const TangentStiffness::StressField& stresses) const {
  const auto& points = problem_.strain_points();
  const StrainPoint& frame = points[element]->front();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const StrainPoint& p : *points[element]) {
    center += p.area * p.position;
    area += p.area;
  }
  center /= area;
  const double size = std::sqrt(area);
  int count = 0;
  for (const int e : neighbourhoods_[element]) count += static_cast<int>(points[e]->size());
  const int num_terms = count < 2 * kTerms ? kLinear : kTerms;
  const auto terms = [&](const StrainPoint& p) {
    const Eigen::Vector3d d = (p.position - center) / size;
    const double x = d.dot(frame.t1), y = d.dot(frame.t2);
    Eigen::Matrix<double, kTerms, 1> f;
    f << 1.0, x, y, x * x, x * y, y * y;
    f.tail(kTerms - num_terms).setZero();
    return f;
  };
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, 6> right = Eigen::Matrix<double, kTerms, 6>::Zero();
  for (const int e : neighbourhoods_[element]) {
    for (size_t k = 0; k < points[e]->size(); ++k) {
      const StrainPoint& p = (*points[e])[k];
      const auto f = terms(p);
      normal += p.area * f * f.transpose();
      right += f * Turned(p, frame, stresses[first_[e] + k]).transpose();
    }
  }
  normal.diagonal().tail(kTerms - num_terms).setOnes();
  const Eigen::Matrix<double, kTerms, 6> fit = normal.ldlt().solve(right);
  double sum = 0.0;
  for (size_t k = 0; k < points[element]->size(); ++k) {
    const StrainPoint& p = (*points[element])[k];
    const Eigen::Matrix<double, 6, 1> off =
        Turned(p, frame, stresses[first_[element] + k]) / p.area - fit.transpose() * terms(p);
    sum += p.area * Energy(problem_.scaled_material(), off);
  }
  return std::sqrt(std::max(0.0, sum));
}

}  // namespace darboux
