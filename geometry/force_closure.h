#ifndef DARBOUX_GEOMETRY_FORCE_CLOSURE_H_
#define DARBOUX_GEOMETRY_FORCE_CLOSURE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace darboux {

// A finger on a body, as statics sees it: a soft finger, which besides its normal force f >= 0 has
// friction across the normal and, by the size of its patch, a moment of friction about it.
struct GraspContact {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, into the body
  double friction = 0.0;                              // Coulomb's coefficient mu
  // The largest moment about the normal is friction * arm * f. 0: a hard point. A patch of area A
  // under even pressure has 2/3 sqrt(A / pi).
  double arm = 0.0;
};

// Whether contacts can hold a body against any force and moment (force closure), and how well.
struct ForceClosure {
  bool closed = false;
  // J. Ferrari, J. Canny, "Planning optimal grasps" (1992): the radius of the largest ball about
  // the origin in the convex hull of the primitive wrenches; the least wrench (force, moment /
  // length) in the worst direction that normal forces of sum 1 resist. No unit; 0 where not closed.
  double margin = 0.0;
  int rank = 0;       // of the primitive wrenches
  std::string lacks;  // what cannot be resisted, in words; empty where closed
};

// Edges that a friction cone is replaced by. They lie within it, so that margins are too small
// rather than too large, by 1 - cos(pi / 12) = 3.4 % of the friction at most. Eight fingers take
// 0.15 s; with 16 edges 0.4 s.
constexpr int kConeEdges = 12;

// The wrenches (f, (p - center) x f / length [+ spin / length]) that a unit normal force can make,
// a column each: the edges n + mu t of the linearised friction cone and, with an arm, the two
// n with spin +- mu arm n. Between these spin and friction trade linearly, within the ellipsoid of
// R. D. Howe and M. R. Cutkosky (1996). A frictionless contact has one.
//
// The edges turn with the grasp: one of them lies towards the other contacts, so that with two
// contacts closure begins exactly where V.-D. Nguyen (1988) has it: the line of the contacts is in
// both cones.
Eigen::Matrix<double, 6, Eigen::Dynamic> PrimitiveWrenches(
    const std::vector<GraspContact>& contacts,
    const Eigen::Vector3d& center,
    double length,
    int edges = kConeEdges);

// Moments are about `center` and are divided by `length` > 0, which both belong to the body, so
// that the margin is that of the grasp and not of the axes or the unit. Preconditions: unit
// normals, friction and arm >= 0, edges >= 3.
ForceClosure EvaluateForceClosure(const std::vector<GraspContact>& contacts,
                                  const Eigen::Vector3d& center,
                                  double length,
                                  int edges = kConeEdges);

// The least coefficient of friction, one for all contacts, with which they are force closure, to 7
// digits; nothing where they are none with 1000. Without hulls: they are where the wrenches have
// rank 6 and some combination of them with positive coefficients only vanishes.
std::optional<double> LeastFriction(const std::vector<GraspContact>& contacts,
                                    const Eigen::Vector3d& center,
                                    double length,
                                    int edges = kConeEdges);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_FORCE_CLOSURE_H_
