#ifndef DARBOUX_COSTS_EDGE_MOMENT_H_
#define DARBOUX_COSTS_EDGE_MOMENT_H_

#include <Eigen/Core>

#include "costs/potential.h"
#include "geometry/strain_point.h"

namespace darboux {

// Moment m (vector, per length) on an edge point of a shell that turns far. A moment about a fixed
// axis has no potential for general rotations in space; the potential used here is, for each of
// the axes a = edge tangent e, conormal v and normal n of the rest edge,
//
//   U = -L sum_a (m.a) phi_a   [J],  L the length the point stands for,
//
// phi_a = angle by which the shell's normal (for a = e, v), or the mean of the deformed e and v
// (for a = n), has turned about a, seen along a. Exact for bending about a fixed edge direction
// (Sze et al., Sec. 3.2); for small rotations phi_a is the component of the rotation vector, so the
// linear theory (MomentWork) is its limit. phi_a runs over (-pi, pi).
// Parameters: one block of 3 per control vertex of the element.
class EdgeMoment : public Potential {
 public:
  // point.area is the length L. tangent: of the edge, in the frame's components. moment: N m/m,
  // global components. factor: load factor, read at every evaluation; must outlive the block.
  EdgeMoment(const StrainPoint& point,
             const Eigen::Vector2d& tangent,
             const Eigen::Vector3d& moment,
             const double* factor,
             double s);

 protected:
  // False where the normal has no component across an axis that carries a moment.
  bool EvaluateEnergy(double const* const* displacements,
                      double* energy,
                      double** gradients) const override;

 private:
  StrainPoint point_;
  Eigen::Vector2d tangent_;
  Eigen::Vector3d moment_;
  const double* factor_;
};

// Linear theory: coefficients a_i with work sum_i a_i.u_i = m.theta, theta = (d_2.n) t1 -
// (d_1.n) t2 + (d_1.t2 - d_2.t1)/2 n the infinitesimal rotation of the surface. Column i: a_i.
Eigen::Matrix3Xd MomentWork(const StrainPoint& point, const Eigen::Vector3d& moment);

}  // namespace darboux

#endif  // DARBOUX_COSTS_EDGE_MOMENT_H_
