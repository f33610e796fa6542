#ifndef DARBOUX_SOLVER_SCENE_SURFACE_CHECKS_H_
#define DARBOUX_SOLVER_SCENE_SURFACE_CHECKS_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "geometry/expression.h"
#include "geometry/parametric_surface.h"
#include "solver/scene.h"

// Whether a surface and the expressions on it are sound, judged on a grid of samples.

namespace darboux {

// A point of the grid of samples.
struct SurfaceSample {
  double u, v;
  Eigen::Vector3d x;
};

// "u = 0.5, v = 1"
std::string FormatParameters(double u, double v);

// Whether the surface has this side: u_min, u_max, v_min, v_max or, the fifth, the rim.
bool HasSide(const SurfaceSpec& surface, int side);

// Those of the samples of the surface that lie in the region.
std::vector<SurfaceSample> SamplesOn(const SurfaceSpec& surface,
                                     const std::vector<SurfaceSample>& samples,
                                     const Region& region);

// Samples of the line on which u (parameter 0) or v (parameter 1) has this value.
std::vector<SurfaceSample> SamplesOnLine(const SurfaceSpec& surface, int parameter, double value);

// The first sample where an expression of u, v, x, y, z is not finite; null where it always is.
const SurfaceSample* FirstNonFinite(const Expression& expression,
                                    const std::vector<SurfaceSample>& where);

// Looks at a surface on a grid of samples and, for points without tangent plane, between them.
// The surface must live as long as the check.
class SurfaceCheck {
 public:
  explicit SurfaceCheck(const SurfaceSpec& spec);

  // False where position, first or second derivatives are not finite; sets u, v.
  bool IsFinite(double* u, double* v);

  // The others come after IsFinite.

  // False where position or first derivatives jump (a step, a kink, a pole) between or at samples,
  // found by bisecting intervals whose ends do not fit each other's derivatives; sets u, v.
  bool IsSmooth(double* u, double* v) const;

  // False where sigma_u x sigma_v vanishes; sets u, v.
  bool IsRegular(double* u, double* v) const;

  // Whether the line at this end (0 or 1) of a direction shrinks to a point.
  bool IsPole(int direction, int end) const;

  // False where positions or first derivatives differ between the ends of a direction; says how.
  bool IsPeriodic(int direction, std::string* difference) const;

  const std::vector<SurfaceSample>& samples() const { return samples_; }

 private:
  // How far the ends of a short piece of a parameter line are from fitting together: positions
  // against first derivatives and first against second ones, relative to the surface's.
  double Mismatch(int direction, double fixed, double from, double to) const;

  // Whether no neighbour of a sample has a smaller |sigma_u x sigma_v|.
  bool IsLowest(int i, int j) const;

  // Compass search for a smaller |sigma_u x sigma_v|; true when it gets down to the limit.
  bool Descend(double limit, double* u, double* v) const;

  const ParametricSurface& surface_;
  const std::array<std::array<double, 2>, 2> range_;
  std::vector<SurfaceSample> samples_;
  std::vector<double> normal_;      // |sigma_u x sigma_v| of each sample.
  double largest_[2] = {0.0, 0.0};  // |sigma_u|, |sigma_v|.
  double size_ = 0.0;               // Diagonal of the bounding box.
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_SURFACE_CHECKS_H_
