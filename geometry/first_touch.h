#ifndef DARBOUX_GEOMETRY_FIRST_TOUCH_H_
#define DARBOUX_GEOMETRY_FIRST_TOUCH_H_

#include <Eigen/Core>
#include <vector>

#include "geometry/finger_shape.h"

namespace darboux {

// Where a shape first touches.
struct Touch {
  double shift = 0.0;  // of the shape along its direction; negative where it overlapped
  int point = -1;      // which point it then touches
};

// How far a shape has to move along a direction (a unit vector) from its pose to touch the first of
// fixed points, where touching is phi = offset >= 0. A shape that overlaps points, phi < offset,
// moves backwards until it has just left all of them. False where a shape that is apart misses all
// points, or a half space that overlaps never leaves them.
//
// phi changes by no more than the shape moves, so |phi - offset| is a safe step; Newton's steps are
// longer and are taken where they cannot jump over a touch: towards a convex shape, or where two
// safe steps from both ends meet. For meshes also when they are below 1e-3 of the shape's size.
// The shift is good to rounding.
bool FirstTouch(const FingerShape& shape,
                const FingerPose& pose,
                const Eigen::Vector3d& direction,
                const std::vector<Eigen::Vector3d>& points,
                double offset,
                Touch* touch);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_FIRST_TOUCH_H_
