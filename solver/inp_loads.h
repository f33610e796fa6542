#ifndef DARBOUX_SOLVER_INP_LOADS_H_
#define DARBOUX_SOLVER_INP_LOADS_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "solver/inp_mesh.h"
#include "solver/scene.h"

namespace darboux {

// Loads of a scene as nodal forces and pressures of finite elements (solver/inp_export.h).

// All loads of a scene, summed up.
struct InpLoads {
  // By node, global components: dead forces that do the work of the loads in every displacement of
  // the elements, integrated over the exact surface; moments (shell elements only).
  std::map<int, Eigen::Vector3d> forces, moments;
  // Per element, along +n: of pressures that turn with the shell. Empty: there is none.
  std::vector<double> pressures;
  std::vector<Eigen::Vector3d> gravity;  // accelerations
  std::vector<std::string> remarks;      // what could not be said exactly
};

// Pressures follow in the nonlinear theory where the scene says so, else they are dead forces. Of
// solid elements, area loads act with one half on each face; loads of lines and points along the
// fibre as 1 : 4 : 1, or half on each face where there is no node between; moments as couples of
// the faces. Gas is left to the caller.
InpLoads MakeInpLoads(const Scene& scene, const InpMesh& mesh, bool nonlinear);

// Whether some edge load has a moment.
bool HasEdgeMoments(const Scene& scene);

// Ratio of the area of the middle surface to that of the face below (side -1) or above (+1) of each
// element: pressure on a face is to act on the middle surface.
std::vector<double> FaceRatios(const InpMesh& mesh, int side);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_LOADS_H_
