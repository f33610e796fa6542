#ifndef DARBOUX_GEOMETRY_SURFACE_JET_H_
#define DARBOUX_GEOMETRY_SURFACE_JET_H_

#include <Eigen/Core>

namespace darboux {

// Position of a surface point and all partial derivatives through third order, in the unit of
// length of the surface per (unit of the parameter)^order. Second derivatives are what strains
// need; third derivatives are what the derivatives of the principal curvatures need.
struct SurfaceJet {
  Eigen::Vector3d x;
  Eigen::Vector3d x_u, x_v;
  Eigen::Vector3d x_uu, x_uv, x_vv;
  Eigen::Vector3d x_uuu, x_uuv, x_uvv, x_vvv;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SURFACE_JET_H_
