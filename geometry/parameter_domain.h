#ifndef DARBOUX_GEOMETRY_PARAMETER_DOMAIN_H_
#define DARBOUX_GEOMETRY_PARAMETER_DOMAIN_H_

#include <array>
#include <utility>
#include <vector>

#include "geometry/control_mesh.h"
#include "geometry/grading_map.h"

namespace darboux {

// A point of an element: A + s (B - A) + t (C - A) of its triangle (A, B, C).
struct ElementPoint {
  int element = 0;
  double s = 0.0;
  double t = 0.0;
};

// Sides of the parameter rectangle.
enum class Side { kUMin = 0, kUMax = 1, kVMin = 2, kVMax = 3 };

// The parameter rectangle of a surface, cut into cells of two triangles each:
//
//   (i,j+1) C---C (i+1,j+1)     triangle 2k:     A = (i,j), B = (i+1,j),   C = (i+1,j+1)
//           | / |               triangle 2k + 1: A = (i,j), B = (i+1,j+1), C = (i,j+1)
//     (i,j) A---B (i+1,j)       k = j * divisions[0] + i
//
// so that every vertex has six neighbours. Around open boundaries lies a ring of ghost cells whose
// control vertices are unknowns like any others. Lattice coordinates q = (q1, q2) run over
// [0, divisions[i]]; with grading g the parameter at fraction f = q / divisions of its range is
// such that the distance from the favoured end is (1 - |g|) p + |g| p^2 times the range, where p
// is the fraction counted from that end: the upper one for g > 0, the lower one for g < 0. A map
// spreads the cells in any other way.
class ParameterDomain {
 public:
  // The rectangle and its lattice.
  struct Options {
    std::array<double, 2> u_range{0.0, 1.0};  // ascending
    std::array<double, 2> v_range{0.0, 1.0};
    std::array<int, 2> divisions{1, 1};  // >= 1; >= 4 in a periodic direction, where
                                         // an element must not meet itself
    std::array<bool, 2> periodic{false, false};
    std::array<double, 2> grading{0.0, 0.0};  // in (-1, 1); 0 in a periodic direction
    std::array<GradingMap, 2> maps;           // instead of a grading, where not the identity
  };

  explicit ParameterDomain(const Options& options);

  const Options& options() const { return options_; }
  const ControlMesh& mesh() const { return mesh_; }
  // Lattice point (i, j), i in [-1, divisions + 1] in an open direction, any i in a periodic one;
  // -1 for the two corners of the ghost ring that touch no element.
  int VertexIndex(int i, int j) const;

  // Parameter along direction 0 (u) or 1 (v) and its first to third derivatives by the lattice
  // coordinate.
  std::array<double, 4> Parameter(int direction, double q) const;
  // Inverse of Parameter; in a periodic direction any value is brought into the range first.
  double LatticeCoordinate(int direction, double parameter) const;

  // Lattice coordinates of an element point, and of the element's axes B - A and C - A.
  std::array<double, 2> Lattice(const ElementPoint& point) const;
  static std::array<std::array<double, 2>, 2> ElementAxes(int element);

  // The element point at parameters (u, v) within the rectangle (rounding beyond it is forgiven).
  ElementPoint Locate(double u, double v) const;
  ElementPoint LocateLattice(double q1, double q2) const;

  bool HasSide(Side side) const;
  // Edges of elements along a side, as the pairs of end points of each edge in lattice
  // coordinates, both on the same element.
  struct BoundaryEdge {
    int element;
    ElementPoint begin, end;
    Side side;
  };
  std::vector<BoundaryEdge> BoundaryEdges(Side side) const;

  // The rule of Sec. VII-C of the paper, Fig. 6: every ghost vertex as a combination of control
  // vertices of the shell, x4 = x2 + x3 - x1. Per vertex the list of (vertex, factor); a vertex of
  // the shell stands for itself.
  std::vector<std::vector<std::pair<int, double>>> FoldedGhosts() const;

 private:
  bool InLattice(int i, int j) const;

  Options options_;
  std::array<int, 2> first_;  // lowest lattice index: -1 or 0
  std::array<int, 2> count_;  // lattice indices in each direction
  std::vector<int> vertex_;   // lattice -> control vertex
  ControlMesh mesh_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_PARAMETER_DOMAIN_H_
