#ifndef DARBOUX_GEOMETRY_IMPLICIT_FUNCTION_H_
#define DARBOUX_GEOMETRY_IMPLICIT_FUNCTION_H_

#include <Eigen/Core>

#include "geometry/expression.h"

namespace darboux {

// A formula f(x, y, z) with its derivatives in space, and the way to the surface f = 0.
class ImplicitFunction {
 public:
  // An expression of x, y and z, in this order, which has to outlive this object.
  explicit ImplicitFunction(const Expression& expression) : expression_(expression) {}

  double Value(const Eigen::Vector3d& p) const { return expression_.Evaluate(p.data()); }
  double Value(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const;
  double Value(const Eigen::Vector3d& p,
               Eigen::Vector3d* gradient,
               Eigen::Matrix3d* second_derivatives) const;

  enum class Projection {
    kOnSurface,
    kNotFinite,   // The function or its gradient.
    kNoGradient,  // The gradient vanishes.
    kTooFar,      // No zero within reach, or no convergence.
  };

  // Moves p to the surface by Newton's method along the gradient; coordinates where `is_free` is 0
  // stay (the others are 1). `size` is that of the surface: lengths below 1e-15 of it are taken for
  // rounding, and a zero counts if the last step was below 1e-9 of it (it is some 1e-16, unless f
  // itself is subject to cancellation). Unless the result is kOnSurface, p is as it was.
  Projection Project(double size,
                     double reach,
                     const Eigen::Vector3d& is_free,
                     Eigen::Vector3d* p,
                     Eigen::Vector3d* gradient) const;

 private:
  const Expression& expression_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_IMPLICIT_FUNCTION_H_
