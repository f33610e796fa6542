#ifndef DARBOUX_SOLVER_MESH_REFINEMENT_H_
#define DARBOUX_SOLVER_MESH_REFINEMENT_H_

#include <string>
#include <vector>

#include "geometry/hierarchical_mesh.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// Where a mesh that has been solved is to be refined, so that what is asked for gets more accurate
// for the fewest unknowns.
//
// Primal: a spline's stresses are wrong by what is not smooth in them. Around each element its
// stress resultants and those of its neighbours are fitted by one polynomial (recovery:
// O. C. Zienkiewicz & J. Z. Zhu, 1992), and the energy norm of the difference is the indicator,
//
//   e_K(u)^2 = integral over K of (N - N*) : A^-1 (N - N*) + (M - M*) : D^-1 (M - M*)  dA.
//
// It needs nothing but the stresses: supports, fingers, gas and loads enter through them alone.
//
// Goals: for a quantity J the dual solution z, K z = J'(u), K the tangent stiffness with contact
// rigid where it is (one factorisation, a solve per quantity), has an indicator of the same kind
// (R. Becker & R. Rannacher, "An optimal control approach to a posteriori error estimation", 2001):
//
//   error of J ~ sum over K of e_K(u) e_K(z).
//
// For the force on a finger whose travel is given (and the travel of one that a force drives) K z
// is the force that a unit of travel exerts on the shell. Several quantities: sum of their
// indicators relative to their sizes. None: the primal indicator alone, squared, relative to the
// energy, which is right for what is conjugate to the loads.
//
// Shares of indicators go to unknowns by their part in the partition of unity. Supports of unknowns
// are refined, those with the largest shares per unknown that this adds (all that has to be refined
// for them included) first, as many as it takes that the unknowns that give way to finer ones have
// `fraction` of the sum (W. Doerfler, 1996), or that the sum on the next mesh is expected to be
// `wanted`.
struct MeshRefinementOptions {
  double fraction = 0.6;  // in (0, 1]
  double wanted = 0.0;    // as MeshRefinementReport::total; 0: whatever it is
  bool probes = true;     // displacements of the scene's probes are quantities, all components
  bool fingers = true;    // forces of fingers, or travels
  // Not more unknowns of the next mesh (components, as ShellProblem::dof) than about this; 0: no
  // limit.
  int max_dof = 0;
  int max_level = HierarchicalMesh::kMaxLevels - 1;  // of unknowns that give way
  SparseBackend backend = SparseBackend::kAuto;
  int num_threads = 2;

  bool IsValid(std::string* error) const;
};

// Where a mesh is too coarse, and how far off its answers may be.
struct MeshRefinementReport {
  std::vector<double> indicators;  // of each element, >= 0
  // Their sum: an estimate of the sum of the relative errors of the quantities (of each component
  // of a probe; without quantities of the energy), mostly from above: measured 1 to 2 times that
  // for forces of fingers on coarse meshes, 5 to 20 times where fields are smooth and signs cancel.
  // The shape of the base mesh and the contact points count as exact. Good for comparing meshes of
  // one scene, and for stopping.
  double total = 0.0;
  int num_quantities = 0;
  int marked = 0;         // unknowns
  double part = 0.0;      // of the sum, of all unknowns that give way
  double expected = 0.0;  // the total on the next mesh
  int dof = 0;            // of the next mesh
};

// Of one component.
int NumUnknowns(const HierarchicalMesh& mesh);

// The indicators, total and num_quantities. The problem, of a scene of kind mesh, icosphere or
// implicit, is in the state that Solve leaves, and stays so. False and *error where there are none:
// a parametric surface, a singular tangent stiffness that duals need.
bool IndicateErrors(ShellProblem* problem,
                    const MeshRefinementOptions& options,
                    MeshRefinementReport* report,
                    std::string* error);

// With the indicators of the same problem, for SurfaceSpec::refinement of the scene solved next;
// fills the rest of the report. The refinement is that of the problem's scene (surface.refine_near,
// which may stay there, included) with more, so that Prolong gives a start. False and *error where
// there is nothing to refine: no stress at all, no room below max_dof or max_level.
bool MarkIndicated(const ShellProblem& problem,
                   const MeshRefinementOptions& options,
                   MeshRefinementReport* report,
                   MeshRefinement* refinement,
                   std::string* error);

// Both.
bool MarkForRefinement(ShellProblem* problem,
                       const MeshRefinementOptions& options,
                       MeshRefinement* refinement,
                       MeshRefinementReport* report,
                       std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MESH_REFINEMENT_H_
