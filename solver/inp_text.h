#ifndef DARBOUX_SOLVER_INP_TEXT_H_
#define DARBOUX_SOLVER_INP_TEXT_H_

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "solver/inp_mesh.h"
#include "solver/inp_supports.h"

namespace darboux {

// Words and lines of an input deck (solver/inp_export.h).

// At most twenty characters, all that CalculiX reads of a number: 14 digits or more.
std::string InpNumber(double value);
std::string InpTriple(const Eigen::Vector3d& x);
// Numbers, at most sixteen in a line.
std::string InpList(const std::vector<int>& numbers);
// kind: NSET or ELSET.
std::string InpSet(const std::string& kind,
                   const std::string& name,
                   const std::vector<int>& numbers);
// A line of *BOUNDARY without its value.
std::string InpDofText(const InpDof& dof);
// A paragraph of *EQUATION.
std::string InpEquation(const std::vector<std::pair<InpDof, double>>& terms);
// Comments on top of a deck, and its heading.
std::string InpHeader(const std::string& name,
                      const InpMesh& mesh,
                      const std::vector<std::string>& remarks);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_TEXT_H_
