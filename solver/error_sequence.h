#ifndef DARBOUX_SOLVER_ERROR_SEQUENCE_H_
#define DARBOUX_SOLVER_ERROR_SEQUENCE_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace darboux {

// Discretisation errors of answers on finer and finer meshes, from the answers alone. With N
// elements the error of a quantity Q falls like N^-q, so that of the last three answers
//
//   |Q_1 - Q_0| / |Q_2 - Q_1| = (1 - (N_1/N_0)^-q) / ((N_1/N_0)^-q - (N_2/N_0)^-q)
//
// tells q, and of the last two
//
//   error of Q_2 = F |Q_2 - Q_1| / ((N_2/N_1)^q - 1)          (Richardson; F = 5/4, Roache 1994)
//
// q is kept within [1/4, 2]: a point force on a uniform mesh has 1 at best, smooth shells 2. Where
// only two answers are there q is 3/2 and F one. An answer that meets its predecessor by chance, on
// the way past it, is not taken for exact: no estimate is smaller than what two answers earlier
// would have led to with q = 2 throughout.
class ErrorSequence {
 public:
  // Answers of one more mesh: the same quantities, vectors or numbers in x, and the sizes that make
  // their errors relative.
  void Add(double elements,
           const std::vector<Eigen::Vector3d>& values,
           const std::vector<double>& sizes);
  void Clear() { levels_.clear(); }

  int num_levels() const { return static_cast<int>(levels_.size()); }
  // Relative error of the last answers, the largest of all quantities; none of the first.
  std::optional<double> Estimate() const;
  // q of the quantity with the largest error; none before there are three answers.
  std::optional<double> Order() const;

 private:
  struct Level {
    double elements;
    std::vector<Eigen::Vector3d> values;
    std::vector<double> sizes;
    std::vector<double> errors;  // estimated; empty on the first
    std::vector<double> least;   // the same with q = 2
    double order = 0.0;          // of the largest, where there are three levels
  };
  std::vector<Level> levels_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ERROR_SEQUENCE_H_
