#ifndef DARBOUX_GEOMETRY_SHELL_FACE_H_
#define DARBOUX_GEOMETRY_SHELL_FACE_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/shell_surface.h"

namespace darboux {

// A face of a deformed shell, what a scanner sees of it:
//
//   x(s, t) = sigma + delta + offset * n',   n' = unit normal of the deformed middle surface,
//
// offset = +h/2 for the outer face. Knows the point of it nearest to any point in space.
class ShellFace {
 public:
  // The surface must outlive this.
  ShellFace(const ShellSurface& surface, double offset);
  ~ShellFace();

  // A column per control vertex. Builds the search structure anew.
  void SetDisplacements(const Eigen::Matrix3Xd& displacements);
  const Eigen::Matrix3Xd& displacements() const;
  const ShellSurface& surface() const;
  double offset() const;

  // A point of the face, the nearest one to a point in space where one was asked for.
  struct Foot {
    ElementPoint at;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // on the face
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // of it, outward
    double distance = 0.0;  // of the point asked for, > 0 outside, along the normal in the interior
    bool on_boundary = false;  // of an open shell: the point asked for lies beyond it
  };
  // Of the face at a point.
  Foot Evaluate(const ElementPoint& at) const;
  // The nearest one: candidates from the search structure, then Newton's method across elements.
  // hint: a foot nearby, e.g. the last one of the same point; it is one candidate more.
  Foot Closest(const Eigen::Vector3d& point, const Foot* hint = nullptr) const;

 private:
  struct Search;
  std::unique_ptr<Search> search_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_SHELL_FACE_H_
