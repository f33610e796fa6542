#ifndef DARBOUX_SOLVER_STATE_WRITER_H_
#define DARBOUX_SOLVER_STATE_WRITER_H_

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "solver/field_table.h"
#include "solver/results.h"
#include "solver/shell_problem.h"

namespace darboux {

// Inside of the solver.

// Writes states of one problem; what no displacement changes is encoded once.
class StateWriter {
 public:
  explicit StateWriter(const ShellProblem& problem);

  // The contents of a .vtu file. Adds the number of values that are not finite.
  // mode: written as lowest_mode where it is not empty.
  std::string Vtu(const Eigen::Matrix3Xd& displacements,
                  const Eigen::Matrix3Xd& mode,
                  double time,
                  size_t* num_not_finite,
                  const std::vector<ExtraField>& extra = {}) const;

  const OutputMesh& mesh() const { return table_.mesh(); }

  // The contents of deformed.ply.
  std::string Ply(const Eigen::Matrix3Xd& displacements) const;

 private:
  FieldTable table_;
  std::string geometry_, rest_fields_;
};

// As VTK and PLY name it.
bool IsLittleEndian();

}  // namespace darboux

#endif  // DARBOUX_SOLVER_STATE_WRITER_H_
