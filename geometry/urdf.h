#ifndef DARBOUX_GEOMETRY_URDF_H_
#define DARBOUX_GEOMETRY_URDF_H_

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

namespace darboux {

// Robot hands as URDF describes them (wiki.ros.org/urdf/XML): links with shapes, joined into a
// tree. Lengths in metres, angles in radians.

// A frame in another one: x = rotation * y + translation.
struct UrdfPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  UrdfPose operator*(const UrdfPose& other) const {
    return {rotation * other.rotation, translation + rotation * other.translation};
  }
};

// Fixed axes: about x by roll, then y by pitch, then z by yaw.
Eigen::Matrix3d RotationOfRpy(const Eigen::Vector3d& rpy);

// A shape of a link.
struct UrdfShape {
  enum class Kind { kBox, kSphere, kCylinder, kCapsule, kMesh };
  Kind kind = Kind::kBox;
  std::string name;                                // may be empty
  UrdfPose origin;                                 // of the shape in its link
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // box
  double radius = 0.0, length = 0.0;               // along z; of a capsule's straight part
  std::string file;                                // mesh, as the file has it
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  int line = 0;
};

// A rigid part of the hand.
struct UrdfLink {
  std::string name;
  std::vector<UrdfShape> collision, visual;
  int parent_joint = -1;
  int line = 0;
};

// What joins two links.
struct UrdfJoint {
  enum class Kind { kRevolute, kContinuous, kPrismatic, kFixed };
  Kind kind = Kind::kFixed;
  std::string name;
  int parent = -1, child = -1;                      // links
  UrdfPose origin;                                  // of the child in the parent at zero
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit
  double lower = 0.0, upper = 0.0;                  // revolute and prismatic
  int mimic = -1;  // joint; its value is multiplier * that + offset
  double multiplier = 1.0, offset = 0.0;
  int line = 0;
};

// A robot.
struct Urdf {
  std::string name, file;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;

  int FindLink(const std::string& name) const;  // -1: there is none
  int FindJoint(const std::string& name) const;
};

// False and one line, "FILE:LINE: <element>: found ...; allowed ...", with *urdf as it was: broken
// XML, missing or repeated names, links that are not there, loops, two parents, several roots,
// numbers that are none, joints of kinds other than these (floating, planar). Elements that say
// nothing about shapes and poses (inertial, material, transmission, gazebo, ...) are skipped. Any
// bytes are safe to read. Where Darboux was built without tinyxml2 that is the message.
bool ParseUrdf(const std::string& text, const std::string& file, Urdf* urdf, std::string* error);
bool ReadUrdf(const std::string& file, Urdf* urdf, std::string* error);

// Poses of all links, that of the root being `base`; `values` by name of joint, 0 where not named.
// False and *error ("joint NAME: found ...; allowed ..."): no such joint, a joint that does not
// move or mimics another, a value beyond the limits, mimicry in a circle.
bool UrdfPoses(const Urdf& urdf,
               const std::map<std::string, double>& values,
               const UrdfPose& base,
               std::vector<UrdfPose>* poses,
               std::string* error);

// The file that a mesh's name means: relative to the URDF file, file://, or package://NAME/...: in
// the folder that `packages` gives for NAME, else in a folder NAME among those above the URDF file
// or beside them. Empty and *error where there is none.
std::string ResolveUrdfMesh(const std::string& name,
                            const std::string& urdf_file,
                            const std::map<std::string, std::string>& packages,
                            std::string* error);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_URDF_H_
