#include "solver/mesh_refinement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>

#include "solver/equilibrium_response.h"
#include "solver/mesh_surface.h"
#include "solver/stress_recovery.h"
#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

using StressField = TangentStiffness::StressField;

// Right-hand sides of dual problems with what they are divided by.
struct Quantity {
  Eigen::VectorXd force;
  double size = 1.0;
};

void AddFingers(const TangentStiffness& tangent,
                const std::vector<TravelDerivatives>& by_travel,
                std::vector<Quantity>* quantities) {
  double largest = 0.0;
  for (const TravelDerivatives& finger : by_travel) {
    largest = std::max(largest, std::abs(finger.energy));
  }
  for (const TravelDerivatives& finger : by_travel) {
    // One without a force, as on a floor that nothing presses on, has no relative error.
    constexpr double kIdle = 1e-3;
    if (!(std::abs(finger.energy) > kIdle * largest)) continue;
    quantities->push_back({tangent.Reduce(finger.force), std::abs(finger.energy)});
  }
}

void AddProbes(const ShellProblem& problem,
               const TangentStiffness& tangent,
               std::vector<Quantity>* quantities) {
  const ShellSurface& surface = problem.surface();
  double largest = 0.0;
  for (const ElementPoint& at : surface.vertex_points()) {
    largest = std::max(largest, problem.Displacement(at).norm());
  }
  if (!(largest > 0.0)) return;
  for (const ProbeSpec& probe : problem.scene().probes) {
    const ElementPoint at = Resolve(probe.at, surface);
    // Of a point that all but stays where it is, to a part of the largest displacement.
    constexpr double kStill = 1e-2;
    const double size = std::max(problem.Displacement(at).norm(), kStill * largest);
    const Eigen::VectorXd weights = surface.ValueWeights(at);
    const std::vector<int>& vertices = surface.control_vertices(at.element);
    for (int c = 0; c < 3; ++c) {
      Eigen::Matrix3Xd row = Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices);
      for (size_t i = 0; i < vertices.size(); ++i) row(c, vertices[i]) += weights[i];
      const Eigen::VectorXd force = tangent.Reduce(row);
      if (!force.isZero(0.0)) quantities->push_back({force, size});
    }
  }
}

// Indicators of the elements. False and *error where the tangent stiffness is singular.
bool FindIndicators(ShellProblem* problem,
                    const MeshRefinementOptions& options,
                    MeshRefinementReport* report,
                    std::string* error) {
  TangentStiffness tangent(problem, options.backend, options.num_threads);
  StressField stresses;
  TangentStiffness::Request request;
  request.stresses = &stresses;
  if (!tangent.Evaluate(request)) {
    *error = "found strains that are not defined; allowed a state that was solved";
    return false;
  }
  const StressRecovery recovery(*problem);
  const std::vector<double> primal = recovery.Norms(stresses, options.num_threads);
  report->indicators.assign(primal.size(), 0.0);

  std::vector<Quantity> quantities;
  constexpr double kRigid = 1024.0;
  std::unique_ptr<RigidContact> rigid;
  if (problem->grasp() != nullptr) {
    rigid = std::make_unique<RigidContact>(problem->grasp(), kRigid);
  }
  if (options.fingers && problem->grasp() != nullptr) {
    std::vector<TravelDerivatives> by_travel;
    if (problem->grasp()->ByTravel(&by_travel)) {
      AddFingers(tangent, by_travel, &quantities);
    }
  }
  if (options.probes) AddProbes(*problem, tangent, &quantities);
  report->num_quantities = static_cast<int>(quantities.size());
  if (quantities.empty()) {
    double energy = 0.0;
    for (const Effect effect : {Effect::kMembrane, Effect::kBending}) {
      energy += problem->Energy(effect) / problem->force_unit();
    }
    if (!(std::abs(energy) > 0.0)) energy = 1.0;
    for (size_t e = 0; e < primal.size(); ++e) {
      report->indicators[e] = 0.5 * primal[e] * primal[e] / std::abs(energy);
    }
    return true;
  }
  UpdatedCholesky cholesky(SparseCholesky::Create(options.backend));
  if (!EvaluateTrueTangent(&tangent)) {
    *error = "found no tangent stiffness; allowed a state that was solved";
    return false;
  }
  cholesky.Analyze(tangent.matrix());
  const Eigen::MatrixXd none(tangent.num_unknowns(), 0);
  if (!FactorizeTangent(*problem, tangent, none, 0.0, &cholesky)) {
    *error = "found a singular tangent stiffness; allowed a state away from critical points";
    return false;
  }
  const double length = problem->displacements().cwiseAbs().maxCoeff();
  for (const Quantity& quantity : quantities) {
    const Eigen::VectorXd z = Response(problem, tangent, &cholesky, quantity.force);
    if (!z.allFinite()) {
      *error = "found a singular tangent stiffness; allowed a state away from critical points";
      return false;
    }
    // The change of the stresses alone, of a step of the state's size for its digits.
    const double largest = z.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) continue;
    const double scale = std::max(length, problem->material().thickness) / largest;
    StressField dual;
    tangent.LinearisedStresses(scale * z, &dual);
    for (size_t k = 0; k < dual.size(); ++k) dual[k] -= stresses[k];
    const std::vector<double> norms = recovery.Norms(dual, options.num_threads);
    for (size_t e = 0; e < norms.size(); ++e) {
      report->indicators[e] += primal[e] * norms[e] / (scale * quantity.size);
    }
  }
  return true;
}

// Unknowns that have been sorted by their shares of the indicators' sum: those that matter first by
// their shares per unknown that their refinement adds, with all that has to be refined for them.
// Next to what is fine already, or within it, refinement is cheap; around something new and small
// it is not.
void SortByWorth(const LoopMesh& base,
                 const HierarchicalMesh& mesh,
                 const std::vector<double>& share,
                 double total,
                 std::vector<int>* order) {
  // Part of the sum that those make up which matter; elements of all meshes that are tried, at
  // most.
  constexpr double kMatters = 0.95, kMostElements = 5e4;
  const int most = std::max(1, static_cast<int>(kMostElements / mesh.mesh().mesh.num_elements));
  const int now = NumUnknowns(mesh);
  std::vector<std::pair<double, int>> worth;
  double sum = 0.0;
  for (const int i : *order) {
    if (!(sum < kMatters * total) || static_cast<int>(worth.size()) == most) break;
    const HierarchicalMesh next(base, mesh.RefineSupports({i}));
    worth.push_back({share[i] / std::max(1, NumUnknowns(next) - now), i});
    sum += share[i];
  }
  std::stable_sort(
      worth.begin(), worth.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (size_t k = 0; k < worth.size(); ++k) (*order)[k] = worth[k].second;
}

// The sum on the next mesh: what is refined keeps a small part, as stresses that are smooth within
// elements fit their neighbours like the second or third power of the size.
double ExpectedTotal(const HierarchicalMesh& mesh,
                     const MeshRefinement& more,
                     const std::vector<double>& indicators) {
  constexpr double kLeft = 1.0 / 16.0;
  double sum = 0.0;
  for (int e = 0; e < static_cast<int>(indicators.size()); ++e) {
    const HierarchicalMesh::Cell& cell = mesh.cell(e);
    bool is_refined = false;
    if (cell.level < static_cast<int>(more.refined.size())) {
      const std::vector<std::int64_t>& refined = more.refined[cell.level];
      is_refined = std::binary_search(refined.begin(), refined.end(), cell.triangle);
    }
    sum += (is_refined ? kLeft : 1.0) * indicators[e];
  }
  return sum;
}

}  // namespace

int NumUnknowns(const HierarchicalMesh& mesh) {
  int count = 0;
  for (int i = 0; i < mesh.mesh().mesh.num_vertices; ++i) count += mesh.IsUnknown(i) ? 1 : 0;
  return count;
}

bool MeshRefinementOptions::IsValid(std::string* error) const {
  if (!(fraction > 0.0 && fraction <= 1.0)) {
    *error = "fraction: found " + std::to_string(fraction) + "; allowed a number in (0, 1]";
    return false;
  }
  if (max_dof < 0 || max_level < 0 || max_level >= HierarchicalMesh::kMaxLevels ||
      num_threads < 1) {
    *error = "found a limit out of range; allowed max_dof >= 0, max_level from 0 to " +
             std::to_string(HierarchicalMesh::kMaxLevels - 1) + " and num_threads >= 1";
    return false;
  }
  return true;
}

bool IndicateErrors(ShellProblem* problem,
                    const MeshRefinementOptions& options,
                    MeshRefinementReport* report,
                    std::string* error) {
  *report = MeshRefinementReport();
  if (!options.IsValid(error)) return false;
  if (problem->scene().surface.mesh == nullptr) {
    *error = "found a parametric surface; allowed a mesh";
    return false;
  }
  if (!FindIndicators(problem, options, report, error)) return false;
  report->total = std::accumulate(report->indicators.begin(), report->indicators.end(), 0.0);
  if (std::isfinite(report->total)) return true;
  *error = "found stresses that are not finite; allowed a state that was solved";
  return false;
}

bool MarkForRefinement(ShellProblem* problem,
                       const MeshRefinementOptions& options,
                       MeshRefinement* refinement,
                       MeshRefinementReport* report,
                       std::string* error) {
  return IndicateErrors(problem, options, report, error) &&
         MarkIndicated(*problem, options, report, refinement, error);
}

bool MarkIndicated(const ShellProblem& problem,
                   const MeshRefinementOptions& options,
                   MeshRefinementReport* report,
                   MeshRefinement* refinement,
                   std::string* error) {
  if (!options.IsValid(error)) return false;
  if (!(report->total > 0.0)) {
    *error = "found no stress that could tell where to refine; allowed a shell under load";
    return false;
  }
  const SurfaceSpec& spec = problem.scene().surface;
  LoopMesh base;
  if (!MakeBaseMesh(spec, &base, error)) return false;
  const std::unique_ptr<HierarchicalMesh> mesh = RefineBaseMesh(spec, base, error);
  if (mesh == nullptr) return false;

  // Shares of the unknowns, each element's by their mean weights on it.
  const ShellSurface& surface = problem.surface();
  std::vector<double> share(surface.mesh().num_vertices, 0.0);
  for (int e = 0; e < surface.num_elements(); ++e) {
    const std::vector<int>& vertices = surface.control_vertices(e);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(vertices.size());
    double area = 0.0;
    for (const StrainPoint& p : *problem.strain_points()[e]) {
      weights += p.area * p.weights.row(kRowValue).transpose();
      area += p.area;
    }
    for (size_t i = 0; i < vertices.size(); ++i) {
      share[vertices[i]] += report->indicators[e] * weights[i] / area;
    }
  }
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(share.size()); ++i) {
    if (surface.IsActive(i) && mesh->level(i) <= options.max_level && share[i] > 0.0) {
      order.push_back(i);
    }
  }
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    return share[i] != share[j] ? share[i] > share[j] : i < j;
  });
  SortByWorth(base, *mesh, share, report->total, &order);

  // The fewest of them that do.
  MeshRefinement more;
  const auto refine = [&](int count) {
    more = mesh->RefineSupports(std::vector<int>(order.begin(), order.begin() + count));
    more = HierarchicalMesh(base, more).refinement();
    double sum = 0.0;
    for (int i = 0; i < static_cast<int>(share.size()); ++i) {
      if (share[i] > 0.0 && surface.IsActive(i) && mesh->GivesWay(i, more)) sum += share[i];
    }
    report->part = sum / report->total;
    report->expected = ExpectedTotal(*mesh, more, report->indicators);
  };
  const auto suffices = [&] {
    return report->part >= options.fraction || report->expected <= options.wanted;
  };
  int count = static_cast<int>(order.size());
  if (count > 0) refine(count);
  if (suffices()) {
    int low = 0;  // too few
    while (count - low > 1) {
      const int middle = low + (count - low) / 2;
      refine(middle);
      (suffices() ? count : low) = middle;
    }
  }
  // Fewer, by halves, where they would make too many unknowns.
  for (; count > 0; count /= 2) {
    refine(count);
    report->dof = 3 * NumUnknowns(HierarchicalMesh(base, more));
    report->marked = count;
    *refinement = more;
    if (options.max_dof == 0 || report->dof <= options.max_dof) return true;
  }
  *error = "found no unknown that could be refined within max_dof and max_level";
  return false;
}

}  // namespace darboux
