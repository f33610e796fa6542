#ifndef DARBOUX_GEOMETRY_PARAMETRIC_SURFACE_H_
#define DARBOUX_GEOMETRY_PARAMETRIC_SURFACE_H_

#include <array>
#include <memory>
#include <string>

#include "geometry/surface_jet.h"
#include "geometry/taylor.h"

namespace darboux {

// A parametric middle surface sigma(u, v). Normals point along sigma_u x sigma_v.
class ParametricSurface {
 public:
  virtual ~ParametricSurface() = default;

  // Exact derivatives through third order.
  virtual SurfaceJet Evaluate(double u, double v) const = 0;
};

// The jet of the surface whose coordinates have these Taylor polynomials.
SurfaceJet MakeSurfaceJet(const Taylor3& x, const Taylor3& y, const Taylor3& z);

// The jet in (q1, q2) of the surface sigma(u(q1), v(q2)), by the chain rule; for example of a
// graded mesh, whose cells are equal steps of q. u = {u, u', u'', u'''} is u with its derivatives
// by q1, and v likewise by q2; jet is that of sigma at (u[0], v[0]).
SurfaceJet Reparametrise(const SurfaceJet& jet,
                         const std::array<double, 4>& u,
                         const std::array<double, 4>& v);

// All surfaces below are immutable: Evaluate is safe to call from several threads.

// (u, v, 0)
std::unique_ptr<ParametricSurface> MakePlane();
// (u, R sin v, R cos v)
std::unique_ptr<ParametricSurface> MakeCylinder(double radius);
// R (cos v cos u, cos v sin u, sin v)
std::unique_ptr<ParametricSurface> MakeSphere(double radius);
// (a cos v cos u, b cos v sin u, c sin v)
std::unique_ptr<ParametricSurface> MakeEllipsoid(double a, double b, double c);
// ((R + r cos v) cos u, (R + r cos v) sin u, r sin v)
std::unique_ptr<ParametricSurface> MakeTorus(double major_radius, double minor_radius);
// (u, v, s (u^3 - 3 u v^2))
std::unique_ptr<ParametricSurface> MakeMonkeySaddle(double scale);
// What a user types: three expressions of u and v (geometry/expression.h). On a mistake returns
// null and says in *error which of the three it is in ("y: column 3: ..."), what was found and what
// is allowed. Where the expressions have no derivative or no value, the jet is not finite.
std::unique_ptr<ParametricSurface> MakeExpressionSurface(const std::array<std::string, 3>& xyz,
                                                         std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_PARAMETRIC_SURFACE_H_
