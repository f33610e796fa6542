#ifndef DARBOUX_GEOMETRY_LOOP_BASIS_H_
#define DARBOUX_GEOMETRY_LOOP_BASIS_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "geometry/control_mesh.h"

namespace darboux {

// Rows of a basis evaluation: the limit value and its derivatives in the element coordinates
// (s, t), where the point is A + s (B - A) + t (C - A) of the element's triangle (A, B, C).
enum BasisRow { kValue = 0, kDs = 1, kDt = 2, kDss = 3, kDst = 4, kDtt = 5 };

// 6 rows (BasisRow) by one column per control vertex of the element.
using BasisMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// The quartic box spline on a regular element (all three vertices interior, valence 6); columns in
// the order of LoopBasis::control_vertices. J. Stam, "Evaluation of Loop subdivision surfaces"
// (1998), appendix; derivatives by differentiating the polynomials in barycentric coordinates.
Eigen::Matrix<double, 6, 12> EvaluateRegularLoopBasis(double s, double t);

// Limit basis of Loop subdivision over the elements of a control mesh, any valence >= 3.
// Regular elements use EvaluateRegularLoopBasis; the others OpenSubdiv's Bfr stencils in double.
// Evaluation is const and safe from several threads.
class LoopBasis {
 public:
  // How elements are evaluated.
  struct Options {
    bool regular_fast_path = true;  // false: OpenSubdiv for every element (tests, comparison).
  };

  // The mesh must be an oriented 2-manifold in which every vertex of an element is interior.
  explicit LoopBasis(const ControlMesh& mesh) : LoopBasis(mesh, Options()) {}
  LoopBasis(const ControlMesh& mesh, const Options& options);
  ~LoopBasis();

  int num_elements() const { return static_cast<int>(control_vertices_.size()); }
  bool IsRegular(int element) const { return regular_[element]; }
  const std::vector<int>& control_vertices(int element) const { return control_vertices_[element]; }

  // s, t >= 0, s + t <= 1. At an extraordinary vertex second derivatives do not exist: callers
  // stay away from it.
  BasisMatrix Evaluate(int element, double s, double t) const;

 private:
  struct Irregular;  // OpenSubdiv's refiner, factory and surfaces.

  std::vector<std::vector<int>> control_vertices_;
  std::vector<char> regular_;
  std::unique_ptr<Irregular> irregular_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_LOOP_BASIS_H_
