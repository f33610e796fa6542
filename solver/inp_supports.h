#ifndef DARBOUX_SOLVER_INP_SUPPORTS_H_
#define DARBOUX_SOLVER_INP_SUPPORTS_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "solver/inp_mesh.h"
#include "solver/rigid_motion.h"
#include "solver/scene.h"

namespace darboux {

// Supports of a scene as conditions on the nodes of finite elements (solver/inp_export.h).

// A degree of freedom of a node, numbered as in *BOUNDARY: 1-3 displacements, 4-6 rotations, in the
// node's axes.
struct InpDof {
  int node = 0, dof = 0;
};

// sum of coefficient * dof = target, the target times the load factor; the first term has the
// coefficient 1 and is in no other condition of the list.
struct InpCondition {
  std::vector<std::pair<InpDof, double>> terms;
  double target = 0.0;
};

// All supports of a scene.
struct InpSupports {
  std::vector<InpCondition> conditions;
  // Nodes with axes of their own: rows are the local axes in global components. Rotations of shells
  // are only held about tangents of the shell, never about its normal: elements that are expanded
  // to solids know no such rotation.
  std::map<int, Eigen::Matrix3d> axes;
  // What the conditions do to rigid motions (rows, RigidFrame of the shell's size).
  std::vector<Eigen::Matrix<double, 1, 6>> rigid_rows;
  std::vector<std::string> remarks;  // what could not be said exactly
};

// On sides, all columns of the side; in a neighbourhood those within the radius, the nearest where
// there is none. A solid element's fibre is held
//   fix, simply_supported: at the middle surface;
//   clamped: at all of its nodes;
//   symmetry: at all of its nodes, along the plane's normal.
// Shell elements are held at their nodes, with the rotations that keep the director.
InpSupports MakeInpSupports(const Scene& scene, const InpMesh& mesh, const RigidFrame& frame);

// Adds that the displacement of a node vanishes along some directions, independent of each other.
void HoldNode(int node, const std::vector<Eigen::Vector3d>& directions, InpSupports* supports);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_SUPPORTS_H_
