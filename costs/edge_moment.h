#ifndef DARBOUX_COSTS_EDGE_MOMENT_H_
#define DARBOUX_COSTS_EDGE_MOMENT_H_

#include <Eigen/Core>
#include <vector>

#include "costs/follower_force.h"
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
// linear theory (MomentWork) is its limit. The energy counts phi_a from the last SetReference on,
// by less than half a turn either way, so that a shell may be wound up; the force does not depend
// on it. Parameters: one block of 3 per control vertex of the element.
class EdgeMoment : public Potential, public FollowerForce {
 public:
  // point.area is the length L. tangent: of the edge, in the frame's components. moment: N m/m,
  // global components. factor: load factor, read at every evaluation; must outlive the block.
  EdgeMoment(const StrainPoint& point,
             const Eigen::Vector2d& tangent,
             const Eigen::Vector3d& moment,
             const double* factor,
             double s);

  bool Linearise(double const* const* displacements,
                 Eigen::Matrix3Xd* force,
                 Eigen::MatrixXd* stiffness) const override;

  // Makes this state the one that angles are counted from; it is itself less than half a turn from
  // the last one.
  void SetReference(double const* const* displacements);

 protected:
  // False where the normal has no component across an axis that carries a moment.
  bool EvaluateEnergy(double const* const* displacements,
                      double* energy,
                      double** gradients) const override;

 private:
  // A vector of the deformed surface: its normal, or the images of the edge tangent and conormal.
  enum class Follows { kNormal, kTangent, kConormal };
  // `moment` does work on the angle that the vector has turned by, from `rest`, about `axis`.
  struct Turn {
    double moment;
    Eigen::Vector3d axis, rest;
    Follows follows;
    double reference = 0.0;  // angle at the last SetReference
  };

  StrainPoint point_;
  Eigen::Vector2d tangent_;
  std::vector<Turn> turns_;
  const double* factor_;
};

// Linear theory: coefficients a_i with work sum_i a_i.u_i = m.theta, theta = (d_2.n) t1 -
// (d_1.n) t2 + (d_1.t2 - d_2.t1)/2 n the infinitesimal rotation of the surface. Column i: a_i.
Eigen::Matrix3Xd MomentWork(const StrainPoint& point, const Eigen::Vector3d& moment);

}  // namespace darboux

#endif  // DARBOUX_COSTS_EDGE_MOMENT_H_
