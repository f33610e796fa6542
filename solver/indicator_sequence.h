#ifndef DARBOUX_SOLVER_INDICATOR_SEQUENCE_H_
#define DARBOUX_SOLVER_INDICATOR_SEQUENCE_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace darboux {

// Discretisation errors of answers on meshes that are refined locally, where numbers of elements
// say nothing of errors. Each mesh has an indicator I of them (MeshRefinementReport::total), which
// is right but for a factor that changes slowly from mesh to mesh: with error = c I the last two
// answers of a quantity Q differ by c (I_1 - I_2), so that
//
//   error of Q_2 = |Q_2 - Q_1| I_2 / (I_1 - I_2),
//
// however little was refined. Where the indicator fell by less than a fifth, four times the change.
// An answer that meets its predecessor by chance, on the way past it, is not taken for exact: c is
// half of what it was before at least. Nor is a first answer that is far off taken for what is
// usual: indicators are estimates from above, and c is 1 at most.
class IndicatorSequence {
 public:
  // Answers of one more mesh: the same quantities, vectors or numbers in x, and the sizes that make
  // their errors relative.
  void Add(double indicator,
           const std::vector<Eigen::Vector3d>& values,
           const std::vector<double>& sizes);
  // The last answers, by other means on the same mesh: what the next ones are compared with.
  void ReplaceLast(const std::vector<Eigen::Vector3d>& values);

  // Relative error of the last answers, the largest of all quantities; none of the first, unless
  // its indicator is nil.
  std::optional<double> Estimate() const;

 private:
  struct Level {
    double indicator = 0.0;
    std::vector<Eigen::Vector3d> values;
    std::vector<double> factors;  // c; empty on the first
  };
  std::vector<Level> levels_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INDICATOR_SEQUENCE_H_
