#include <Eigen/Geometry>
#include <memory>
#include <string>

#include "geometry/mesh_finger.h"
#include "solver/grasp.h"

// The rigid body that a scene's finger is, and where the scene has it.

namespace darboux {
namespace {

std::shared_ptr<const FingerShape> MakeShape(const FingerSpec& spec, std::string* error) {
  switch (spec.shape) {
    case FingerSpec::Shape::kPin:  // Pushes one point along its direction, whatever lies beside it.
    case FingerSpec::Shape::kPlane:
      return MakePlaneFinger();
    case FingerSpec::Shape::kSphere:
      return MakeSphereFinger(spec.radius);
    case FingerSpec::Shape::kCapsule:
      return MakeCapsuleFinger(spec.radius, spec.length);
    case FingerSpec::Shape::kBox:
      return MakeBoxFinger(Eigen::Vector3d(spec.half_sizes.data()), spec.rounding);
    case FingerSpec::Shape::kMesh:
      return MakeMeshFinger(*spec.mesh, error);
  }
  return nullptr;
}

// The shape's frame: planes and boxes have z along the direction, capsules along their axis, boxes
// x along it as far as that goes; a mesh keeps the axes of the scene.
Eigen::Matrix3d Rotation(const FingerSpec& spec) {
  if (spec.shape == FingerSpec::Shape::kMesh) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis(spec.axis.data());
  const Eigen::Vector3d z =
      spec.shape == FingerSpec::Shape::kCapsule ? axis : Eigen::Vector3d(spec.direction.data());
  Eigen::Vector3d x = spec.shape == FingerSpec::Shape::kBox ? axis : Eigen::Vector3d::Zero();
  x -= z * z.dot(x);
  if (x.norm() < 1e-9) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return rotation;
}

}  // namespace

std::shared_ptr<const FingerShape> MakeFinger(const FingerSpec& spec,
                                              FingerPose* pose,
                                              std::string* error) {
  std::shared_ptr<const FingerShape> shape = MakeShape(spec, error);
  if (shape == nullptr) {
    *error = spec.location.file + ":" + std::to_string(spec.location.line) + ": " +
             spec.location.key + ": found " + *error + "; allowed is a closed mesh";
    return nullptr;
  }
  *pose = {Eigen::Vector3d(spec.position.data()), Rotation(spec)};
  return shape;
}

}  // namespace darboux
