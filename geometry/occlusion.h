#ifndef DARBOUX_GEOMETRY_OCCLUSION_H_
#define DARBOUX_GEOMETRY_OCCLUSION_H_

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "geometry/scan_simulator.h"
#include "geometry/triangle_mesh.h"
#include "geometry/triangle_tree.h"

namespace darboux {

// Whether a triangle of a surface cuts a ray. Inside of the scan simulator, and built as it is: the
// same on every machine.
class Occlusion {
 public:
  // The surface must outlive this. Cuts nearer than the tolerance, a length, to a ray's ends are
  // none.
  Occlusion(const ScanSurface& surface, double tolerance);

  // Between `from`, a point of the outer face, and `from` + length * direction (unit).
  //
  // A ray that leaves the face meets another part of it from outside, that is against its normal.
  // Where it meets a triangle along its normal, this is the inner side of an open surface, or the
  // triangle that the exact face bulges away from under `from`: then it starts just beneath it.
  bool IsCut(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double length) const;

 private:
  const Eigen::Vector3d& Corner(std::size_t t, std::size_t k) const {
    return mesh_.vertices[static_cast<std::size_t>(mesh_.triangles[t][k])];
  }

  double Depth(std::size_t t, const Eigen::Vector3d& x) const;
  double Bulge(const ScanSurface& surface, std::size_t t) const;
  double RayDistance(std::size_t t,
                     const Eigen::Vector3d& from,
                     const Eigen::Vector3d& direction,
                     bool* from_outside) const;

  const TriangleMesh& mesh_;
  double tolerance_;
  TriangleTree tree_;
  std::vector<double> depths_;  // points beneath a triangle, up to this, are none that it hides
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_OCCLUSION_H_
