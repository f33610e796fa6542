#ifndef DARBOUX_GEOMETRY_QUADRATURE_H_
#define DARBOUX_GEOMETRY_QUADRATURE_H_

#include <vector>

namespace darboux {

// A point of a rule on a triangle.
struct TrianglePoint {
  double s, t;    // inside the triangle (0,0), (1,0), (0,1)
  double weight;  // weights of a rule add up to 1/2, the area of that triangle
};

// Symmetric rules with all points inside: n = 1, 3, 6, 12 points, exact for polynomials of degree
// 1, 2, 4, 6 (D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985).
// Any other n is a broken invariant (CHECK).
const std::vector<TrianglePoint>& TriangleQuadrature(int num_points);
bool IsTriangleQuadrature(int num_points);

// A point of a rule on the interval [0, 1].
struct LinePoint {
  double x;       // in (0, 1)
  double weight;  // weights of a rule add up to 1
};

// Gauss-Legendre rule of n = 1..5 points on [0, 1], exact to degree 2 n - 1.
const std::vector<LinePoint>& LineQuadrature(int num_points);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_QUADRATURE_H_
