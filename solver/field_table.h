#ifndef DARBOUX_SOLVER_FIELD_TABLE_H_
#define DARBOUX_SOLVER_FIELD_TABLE_H_

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "solver/fields.h"
#include "solver/shell_problem.h"

namespace darboux {

// The fields of solver/fields.h at all points of the output mesh, by name, for whoever writes them
// to a file: .vtu, .csv, .npz.

// One field: a number, or several, at each point.
struct Field {
  Field(std::string field_name, std::vector<std::string> component_names, std::size_t num_points)
      : name(std::move(field_name)), components(std::move(component_names)) {
    values.reserve(width() * num_points);
  }

  // Values that are not finite become 0 and are counted.
  void Add(double value) {
    const bool finite = std::isfinite(value);
    num_not_finite += finite ? 0 : 1;
    values.push_back(finite ? value : 0.0);
  }
  template <int n>
  void Add(const Eigen::Matrix<double, n, 1>& value) {
    for (int i = 0; i < n; ++i) Add(value[i]);
  }
  // Numbers at each point.
  std::size_t width() const { return components.empty() ? 1 : components.size(); }

  std::string name;
  std::vector<std::string> components;  // x, y, z or 11, 22, 12 or 1, 2; none: a scalar
  std::vector<double> values;           // point after point
  std::size_t num_not_finite = 0;
};

// The fields of a shell at rest, and those of any state of it.
class FieldTable {
 public:
  explicit FieldTable(const ShellProblem& problem);

  const OutputMesh& mesh() const { return mesh_; }
  const std::vector<FieldSite>& sites() const { return sites_; }
  std::size_t num_points() const { return sites_.size(); }
  const ShellProblem& problem() const { return problem_; }

  const Field& points() const { return points_; }  // at rest
  // uv, principal_curvatures, principal_direction_1: what no displacement changes.
  const std::vector<Field>& rest_fields() const { return rest_fields_; }
  // displacement, normal, strains, stresses, energies.
  std::vector<Field> StateFields(const Eigen::Matrix3Xd& displacements) const;

 private:
  const ShellProblem& problem_;
  OutputMesh mesh_;
  std::vector<FieldSite> sites_;
  Field points_;
  std::vector<Field> rest_fields_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FIELD_TABLE_H_
