#ifndef DARBOUX_SOLVER_ADAPTIVE_GRADING_H_
#define DARBOUX_SOLVER_ADAPTIVE_GRADING_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/grading_map.h"
#include "solver/shell_problem.h"

namespace darboux {

// Where a lattice should have its cells, told from a solution on it.
//
// Strains of a Loop displacement field are piecewise quadratic in the lattice coordinates q, those
// of bending linear where they are exact, so that what a cell lacks is its strains' second
// difference: with stresses and strains in units of the root of energy,
//
//   e_a[w] = |r(q + e_a) - 2 r(q) + r(q - e_a)|,   r the six scaled strains of a field w,
//
// falls like the squared size of the cell in direction a, and the error of a goal whose dual
// solution is z like the sum over cells of
//
//   G_a = e_a[u] e_a[z] dA                          (the error in energy of u where z ~ u)
//
// Cells of size s along a parameter line, G ~ s^4, make the sum least for a given number of cells
// where G_a is the same in every column: s_new = s (G_a / mean)^(-1/4), over and over
// (equidistribution). Marginal sums of G_u over the columns and of G_v over the rows grade the two
// parameters; their totals tell the number of columns to that of rows: (columns / rows)^4 ~ total
// G_u / total G_v.
struct LatticeAdvice {
  std::array<GradingMap, 2> maps;
  double proportion = 1.0;                 // columns / rows
  std::array<double, 2> totals{0.0, 0.0};  // G_u, G_v
  // Largest change of the logarithm of a cell's size against the present lattice.
  double change = 0.0;
  // What the sum of G is to fall by, at the same number of cells, by the maps alone; >= 0.
  double gain = 1.0;
};

// From the present state of a parametric problem and the dual solutions of its goals (see
// goal_response.h), summed over them. A direction with fewer than three cells is left as it is.
LatticeAdvice AdviseLattice(const ShellProblem& problem,
                            const std::vector<Eigen::Matrix3Xd>& duals);

// About `cells` cells in the proportion, each number at least `least` and a multiple of `multiple`.
// Two keeps the middle of a symmetric shell a corner of cells on every lattice; answers of lattices
// that have it within a cell by turns jump up and down.
std::array<int, 2> DivisionsFor(double cells,
                                double proportion,
                                const std::array<int, 2>& least,
                                const std::array<int, 2>& multiple);

// The lattice of most cells with at most `dof`, about in the proportion; false where there is none.
bool LargestDivisions(int dof,
                      double proportion,
                      const std::array<int, 2>& least,
                      const std::array<int, 2>& multiple,
                      std::array<int, 2>* divisions);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_ADAPTIVE_GRADING_H_
