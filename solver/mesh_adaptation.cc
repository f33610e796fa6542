#include "solver/mesh_adaptation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "geometry/icosphere.h"
#include "solver/mesh_surface.h"

namespace darboux {
namespace {

constexpr int kFirstFrequency = 3;  // 180 triangles
constexpr double kDecayLengths = 2.5;
constexpr double kEdge = 1.1;       // mean edge of frequency 1, in radii
constexpr double kFraction = 0.65;  // MeshRefinementOptions, at most
// The sum of the indicators after a step, relative to that before: estimates of smaller steps would
// be of noise.
constexpr double kLeastStep = 0.6;

}  // namespace

MeshAdaptation::MeshAdaptation(int max_dof, SparseBackend backend, int num_threads) {
  options_.max_dof = max_dof;
  options_.backend = backend;
  options_.num_threads = num_threads;
}

std::string MeshAdaptation::Begin(double thickness, SurfaceSpec* surface) {
  // With `refine` the mesh is no geodesic one any more.
  if (surface->kind != "icosphere" || !surface->interpolate || IsRefinedLocally(*surface))
    return "";
  const double radius = surface->mesh->vertices[0].norm();
  surface->sphere_radius = radius;
  const std::string line = "surface: the control points are fitted to the sphere";
  const double finest = std::ceil(kEdge / kDecayLengths * std::sqrt(radius / thickness));
  const double own = std::sqrt((surface->mesh->vertices.size() - 2.0) / 10.0);
  if (!(std::max<double>(kFirstFrequency, finest) < own - 0.5)) return line;
  const int frequency = std::max(kFirstFrequency, static_cast<int>(finest));
  surface->mesh = std::make_shared<const TriangleMesh>(MakeSmoothIcosphere(radius, frequency));
  return line + ", which begins with frequency " + std::to_string(frequency);
}

bool MeshAdaptation::RefineFailed(ShellProblem* problem,
                                  SurfaceSpec* surface,
                                  std::string* where,
                                  std::string* why) {
  MeshRefinementOptions options = options_;
  options.fraction = kFraction;
  MeshRefinementReport report;
  MeshRefinement refinement;
  std::string unknown;
  if (IndicateErrors(problem, options, &report, &unknown) &&
      MarkIndicated(*problem, options, &report, &refinement, &unknown)) {
    surface->refinement = std::make_shared<const MeshRefinement>(std::move(refinement));
    *where = "where its last equilibrium needs it";
    return true;
  }
  *where = "everywhere";
  LoopMesh base;
  if (!MakeBaseMesh(*surface, &base, why)) return false;
  const std::unique_ptr<HierarchicalMesh> mesh = RefineBaseMesh(*surface, base, why);
  if (mesh == nullptr) return false;
  std::vector<int> all(mesh->mesh().mesh.num_elements);
  std::iota(all.begin(), all.end(), 0);
  const HierarchicalMesh finer(base, mesh->RefineElements(all));
  if (options_.max_dof > 0 && 3 * NumUnknowns(finer) > options_.max_dof) {
    *why = "the next mesh would have more than " + std::to_string(options_.max_dof) + " dof";
    return false;
  }
  surface->refinement = std::make_shared<const MeshRefinement>(finer.refinement());
  return true;
}

bool MeshAdaptation::Add(ShellProblem* problem,
                         const std::vector<Eigen::Vector3d>& values,
                         const std::vector<double>& sizes,
                         std::string* why) {
  if (!IndicateErrors(problem, options_, &indicators_, why)) return false;
  sequence_.Add(indicators_.total, values, sizes);
  return true;
}

bool MeshAdaptation::Refine(
    ShellProblem* problem, double wanted, SurfaceSpec* surface, int* dof, std::string* why) {
  MeshRefinementOptions options = options_;
  options.fraction = kFraction;
  if (const std::optional<double> estimate = Estimate(); estimate && *estimate > 0.0) {
    options.wanted = indicators_.total * std::min(kLeastStep, wanted / *estimate);
  }
  MeshRefinement refinement;
  if (!MarkIndicated(*problem, options, &indicators_, &refinement, why)) return false;
  *dof = indicators_.dof;
  surface->refinement = std::make_shared<const MeshRefinement>(std::move(refinement));
  return true;
}

}  // namespace darboux
