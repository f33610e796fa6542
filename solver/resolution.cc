#include "solver/resolution.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "costs/strain_measures.h"
#include "solver/parallel_for.h"
#include "solver/stress_recovery.h"

namespace darboux {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// Membrane force and moment of a strain (engineering shear), times the area.
Vector6d StressOf(const Material& material, double area, const Vector6d& strain) {
  const double nu = material.poisson_ratio;
  Vector6d stress;
  for (const int k : {0, 3}) {
    const double c = area * (k == 0 ? material.MembraneStiffness() : material.BendingStiffness());
    stress[k] = c * (strain[k] + nu * strain[k + 1]);
    stress[k + 1] = c * (strain[k + 1] + nu * strain[k]);
    stress[k + 2] = c * 0.5 * (1.0 - nu) * strain[k + 2];
  }
  return stress;
}

// The largest angle between normals of an element's points, which lie at half of the distances of
// its corners.
double TurnOf(const std::vector<StrainPoint>& points) {
  double sine = 0.0, cosine = 1.0;
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const double c = points[i].n.dot(points[j].n);
      if (c >= cosine) continue;
      cosine = c;
      sine = points[i].n.cross(points[j].n).norm();
    }
  }
  return 2.0 * std::atan2(sine, cosine);
}

}  // namespace

std::string Resolution::Complaint() const {
  std::ostringstream text;
  text.precision(2);
  if (turn > kMostTurn) {
    text << "the mesh does not resolve the shape: its normal turns by " << turn
         << " rad within an element, on the average (allowed " << kMostTurn << ")";
  } else if (roughness > kMostRoughness) {
    text << "the mesh does not resolve the answer: stresses of neighbouring elements disagree by "
         << roughness << " of the strain energy (allowed " << kMostRoughness
         << "); the shell may be many times too stiff";
  } else if (roughness > kDoubtfulRoughness) {
    text << "a coarse mesh: stresses of neighbouring elements disagree by " << roughness
         << " of the strain energy; answers are off by about as much";
  } else {
    return "";
  }
  text << "; refine, or let model.accuracy do it";
  return text.str();
}

std::optional<Resolution> CheckResolution(const ShellProblem& problem, int num_threads) {
  const ShellSurface& surface = problem.surface();
  const Material& material = problem.scaled_material();
  const StrainMeasure measure = problem.measure();
  const int num_elements = surface.num_elements();
  std::vector<int> first(num_elements + 1, 0);
  for (int e = 0; e < num_elements; ++e) {
    first[e + 1] = first[e] + static_cast<int>(problem.strain_points()[e]->size());
  }
  TangentStiffness::StressField stresses(first.back());
  struct Sums {
    double energy = 0.0, area = 0.0, turn = 0.0;
    bool is_defined = true;
  };
  const int threads = ThreadsFor(num_elements, num_threads);
  std::vector<Sums> sums(threads);
  ParallelFor(threads, num_elements, [&](int thread, int begin, int end) {
    Sums mine;
    for (int e = begin; e < end; ++e) {
      const std::vector<int>& vertices = surface.control_vertices(e);
      const std::vector<StrainPoint>& points = *problem.strain_points()[e];
      double area = 0.0;
      for (size_t q = 0; q < points.size(); ++q) {
        const StrainPoint& p = points[q];
        Eigen::Matrix<double, 3, 5> k = Eigen::Matrix<double, 3, 5>::Zero();
        for (size_t i = 0; i < vertices.size(); ++i) {
          k += problem.displacements().col(vertices[i]) * p.weights.col(i).tail<5>().transpose();
        }
        Vector6d strain;
        EvaluateMembraneStrain(measure, p, k.data(), strain.data());
        mine.is_defined &= EvaluateBendingStrain(measure, p, k.data(), strain.data() + 3);
        const Vector6d stress = StressOf(material, p.area, strain);
        stresses[first[e] + q] = stress;
        mine.energy += 0.5 * stress.dot(strain);
        area += p.area;
      }
      mine.area += area;
      if (surface.is_parametric()) mine.turn += area * TurnOf(points);
    }
    sums[thread] = mine;
  });
  Sums all;
  for (const Sums& one : sums) {
    all.energy += one.energy;
    all.area += one.area;
    all.turn += one.turn;
    all.is_defined &= one.is_defined;
  }
  if (!all.is_defined || !std::isfinite(all.energy)) return std::nullopt;
  Resolution resolution;
  resolution.turn = all.turn / all.area;
  // Strains of a shell that moves as a body are of rounding.
  constexpr double kRounding = 1e-11;
  const double largest = problem.displacements().cwiseAbs().maxCoeff();
  const double rounding = kRounding * largest / surface.size();
  if (!(all.energy > 0.5 * material.MembraneStiffness() * rounding * rounding * all.area)) {
    return resolution;
  }
  const std::vector<double> norms = StressRecovery(problem).Norms(stresses, num_threads);
  double sum = 0.0;
  for (const double norm : norms) sum += 0.5 * norm * norm;
  if (!std::isfinite(sum)) return std::nullopt;
  resolution.roughness = sum / all.energy;
  return resolution;
}

}  // namespace darboux
