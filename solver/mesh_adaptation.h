#ifndef DARBOUX_SOLVER_MESH_ADAPTATION_H_
#define DARBOUX_SOLVER_MESH_ADAPTATION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "solver/indicator_sequence.h"
#include "solver/mesh_refinement.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// What model.accuracy does on meshes: where it begins, how far off an answer is, and which mesh
// comes next (solver/mesh_refinement.h).
class MeshAdaptation {
 public:
  MeshAdaptation(int max_dof, SparseBackend backend, int num_threads);

  // The first mesh. A sphere begins with about as many triangles as lattices do, edges no longer
  // than 2.5 times the length sqrt(radius thickness) that dents decay in, or the scene's own mesh
  // where that is coarser. Its control points are fitted to the sphere on this and all later meshes
  // (SurfaceSpec::sphere_radius), so that its shape gets more exact where it is refined. The shape
  // of other meshes, and of one that the scene refines itself, is what it is. Returns a line that
  // says so, empty where nothing changes.
  static std::string Begin(double thickness, SurfaceSpec* surface);

  // For a mesh that the scene does not converge on, of which the problem is in the last state of
  // equilibrium, at a part of the load: refined where that needs it or, where there is none, all of
  // it once; either way the shape stays. *where: "everywhere" or what else. False and *why where
  // there is no room.
  bool RefineFailed(ShellProblem* problem,
                    SurfaceSpec* surface,
                    std::string* where,
                    std::string* why);

  // The answers of a scene on one more mesh, which its problem has been solved on; see
  // IndicatorSequence. False and *why where there are no indicators.
  bool Add(ShellProblem* problem,
           const std::vector<Eigen::Vector3d>& values,
           const std::vector<double>& sizes,
           std::string* why);
  void ReplaceLast(const std::vector<Eigen::Vector3d>& values) { sequence_.ReplaceLast(values); }
  // None of the first.
  std::optional<double> Estimate() const { return sequence_.Estimate(); }

  // Refines the surface, that of the problem added last, as far as it takes to bring the estimate
  // down to `wanted`, or the larger part of the indicator is dealt with. dof: of the next mesh.
  // False and *why where there is nothing to refine or no room.
  bool Refine(
      ShellProblem* problem, double wanted, SurfaceSpec* surface, int* dof, std::string* why);

 private:
  MeshRefinementOptions options_;
  MeshRefinementReport indicators_;
  IndicatorSequence sequence_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MESH_ADAPTATION_H_
