#include "solver/mesh_adaptation.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "geometry/icosphere.h"
#include "solver/mesh_surface.h"

namespace darboux {
namespace {

constexpr int kFirstFrequency = 3;  // 180 triangles
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

std::string MeshAdaptation::Begin(SurfaceSpec* surface) {
  // With `refine` the mesh is no geodesic one any more.
  if (surface->kind != "icosphere" || !surface->interpolate || IsRefinedLocally(*surface))
    return "";
  const double radius = surface->mesh->vertices[0].norm();
  surface->sphere_radius = radius;
  TriangleMesh mesh = MakeSmoothIcosphere(radius, kFirstFrequency);
  std::string line = "surface: the control points are fitted to the sphere";
  if (mesh.vertices.size() >= surface->mesh->vertices.size()) return line;
  surface->mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return line + ", which begins with frequency " + std::to_string(kFirstFrequency);
}

bool MeshAdaptation::RefineEverywhere(SurfaceSpec* surface, std::string* why) const {
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
