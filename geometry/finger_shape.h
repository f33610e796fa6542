#ifndef DARBOUX_GEOMETRY_FINGER_SHAPE_H_
#define DARBOUX_GEOMETRY_FINGER_SHAPE_H_

#include <Eigen/Core>
#include <memory>

namespace darboux {

// Signed distance phi to a rigid body, positive outside, and its first two derivatives by the
// point. Where phi is smooth |normal| = 1, hessian is symmetric and hessian * normal = 0.
struct Distance {
  double value = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   // away from the body
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();  // 1 / length
};

// A ball around a body; infinite radius for a half space.
struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

// A rigid finger, in its own frame.
//
// A shell of thickness h touches a finger with its face exactly where its middle surface is at the
// distance h/2 from it, so contact only ever asks for phi at points of the middle surface.
class FingerShape {
 public:
  virtual ~FingerShape() = default;

  // False where the normal is undefined: at the centre of a sphere or pin and on the axis of a
  // capsule; out->value is right all the same. On the other ridges inside a body, where two
  // features are equally near, and on sharp edges, the derivatives are those of one of them.
  virtual bool Evaluate(const Eigen::Vector3d& x, Distance* out) const = 0;

  // Contains the body.
  virtual Ball Bounds() const = 0;

  // The body's thinnest place, half of its thickness there: a step of less leaves every point that
  // it enters on the side where it came in. Infinite for a half space, 0 for a pin. Shells add
  // their offset h/2 to it.
  virtual double MaxStep() const = 0;

  // phi is a convex function of x, the body convex: true of all but meshes.
  virtual bool IsConvex() const { return true; }

  // Radius of a ball about the origin of the frame that contains the body.
  double Reach() const;
};

// The point at the origin.
std::shared_ptr<const FingerShape> MakePinFinger();

// About the origin; radius > 0.
std::shared_ptr<const FingerShape> MakeSphereFinger(double radius);

// All points within `radius` > 0 of the piece |z| <= length/2 of the z axis: the straight part is
// `length` >= 0 long, the whole length + 2 radius.
std::shared_ptr<const FingerShape> MakeCapsuleFinger(double radius, double length);

// |x| <= half_sizes.x() and so on, edges and corners rounded by `rounding`, 0 <= rounding <= the
// smallest half size. The distance of a box that is not rounded has no gradient at its edges.
std::shared_ptr<const FingerShape> MakeBoxFinger(const Eigen::Vector3d& half_sizes,
                                                 double rounding);

// The half space z <= 0.
std::shared_ptr<const FingerShape> MakePlaneFinger();

// Where a finger is: x = position + rotation * (x in the shape's frame).
struct FingerPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();

  // Of the shape at this pose, for x and derivatives in the frame of the scene.
  bool Evaluate(const FingerShape& shape, const Eigen::Vector3d& x, Distance* out) const;
  Ball Bounds(const FingerShape& shape) const;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_FINGER_SHAPE_H_
