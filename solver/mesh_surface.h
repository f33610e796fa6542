#ifndef DARBOUX_SOLVER_MESH_SURFACE_H_
#define DARBOUX_SOLVER_MESH_SURFACE_H_

#include <memory>
#include <string>

#include "geometry/hierarchical_mesh.h"
#include "geometry/loop_mesh.h"
#include "geometry/shell_surface.h"
#include "solver/scene.h"

namespace darboux {

// The surface of a scene of kind mesh, icosphere or implicit. All are null (false) with a message
// "FILE:LINE: KEY: found ...; allowed ..." where the mesh has no smooth Loop surface, where a
// refined neighbourhood has no part of the surface or where more than kMostRefined triangles are
// refined.

constexpr int kMostRefined = 1000000;

// Level 0: the control mesh without local refinement.
bool MakeBaseMesh(const SurfaceSpec& spec, LoopMesh* mesh, std::string* error);

// With surface.refinement and surface.refine_near.
bool IsRefinedLocally(const SurfaceSpec& spec);
std::unique_ptr<HierarchicalMesh> RefineBaseMesh(const SurfaceSpec& spec,
                                                 const LoopMesh& base,
                                                 std::string* error);
std::unique_ptr<HierarchicalMesh> MakeHierarchicalMesh(const SurfaceSpec& spec, std::string* error);

std::unique_ptr<ShellSurface> MakeMeshSurface(const SurfaceSpec& spec, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MESH_SURFACE_H_
