#include "solver/mesh_surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/sphere_fit.h"

namespace darboux {
namespace {

std::string Where(const SceneLocation& at) {
  return at.file + ":" + std::to_string(at.line) + ": " + at.key + ": ";
}

size_t NumRefined(const MeshRefinement& refinement) {
  size_t count = 0;
  for (const auto& numbers : refinement.refined) count += numbers.size();
  return count;
}

}  // namespace

bool MakeBaseMesh(const SurfaceSpec& spec, LoopMesh* mesh, std::string* error) {
  *mesh = MakeLoopMesh(*spec.mesh);
  if (spec.interpolate && !InterpolatePoints(mesh)) {
    *error = Where(spec.location) +
             "found points that no Loop surface passes through; allowed fit: control";
    return false;
  }
  const int vertex = FindSingularVertex(*mesh);
  if (vertex < 0) return true;
  *error = Where(spec.location) + "found no tangent plane of the Loop surface at vertex " +
           std::to_string(vertex) + "; allowed a mesh without cusps and needles";
  return false;
}

bool IsRefinedLocally(const SurfaceSpec& spec) {
  return !spec.refine_near.empty() || (spec.refinement != nullptr && !spec.refinement->empty());
}

std::unique_ptr<HierarchicalMesh> RefineBaseMesh(const SurfaceSpec& spec,
                                                 const LoopMesh& base,
                                                 std::string* error) {
  auto mesh = std::make_unique<HierarchicalMesh>(
      base, spec.refinement != nullptr ? *spec.refinement : MeshRefinement());
  for (int level = 0;; ++level) {
    std::vector<HierarchicalMesh::Ball> balls;
    std::vector<const RefineNearSpec*> specs;
    for (const RefineNearSpec& near : spec.refine_near) {
      if (near.levels <= level) continue;
      balls.push_back({{near.center[0], near.center[1], near.center[2]}, near.radius});
      specs.push_back(&near);
    }
    if (balls.empty()) return mesh;
    std::vector<double> beyond;
    const MeshRefinement refinement = mesh->RefineNear(balls, level, &beyond);
    for (size_t i = 0; i < specs.size(); ++i) {
      if (level > 0 || beyond[i] <= 0.0) continue;
      *error = Where(specs[i]->location) +
               "found a neighbourhood without a point of the surface; allowed a point on it or a "
               "larger radius";
      return nullptr;
    }
    if (NumRefined(refinement) > static_cast<size_t>(kMostRefined)) {
      *error = Where(specs.front()->location) + "found " + std::to_string(NumRefined(refinement)) +
               " triangles to refine at level " + std::to_string(level) + "; allowed " +
               std::to_string(kMostRefined) + " in all";
      return nullptr;
    }
    mesh = std::make_unique<HierarchicalMesh>(base, refinement);
  }
}

std::unique_ptr<HierarchicalMesh> MakeHierarchicalMesh(const SurfaceSpec& spec,
                                                       std::string* error) {
  LoopMesh base;
  if (!MakeBaseMesh(spec, &base, error)) return nullptr;
  return RefineBaseMesh(spec, base, error);
}

std::unique_ptr<ShellSurface> MakeMeshSurface(const SurfaceSpec& spec, std::string* error) {
  LoopMesh base;
  if (!MakeBaseMesh(spec, &base, error)) return nullptr;
  if (IsRefinedLocally(spec)) {
    const std::unique_ptr<HierarchicalMesh> mesh = RefineBaseMesh(spec, base, error);
    if (mesh == nullptr) return nullptr;
    base = mesh->mesh();
  }
  if (spec.sphere_radius > 0.0 && !FitToSphere(spec.sphere_radius, &base)) {
    *error = Where(spec.location) + "found a mesh that is no sphere about the origin; allowed one";
    return nullptr;
  }
  return std::make_unique<ShellSurface>(std::move(base));
}

}  // namespace darboux
