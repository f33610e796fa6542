#include "solver/scene_hand_reader.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "geometry/mesh_finger.h"
#include "geometry/mesh_io.h"
#include "geometry/nearest_name.h"

namespace darboux {
namespace {

using Eigen::Vector3d;

// Corners of the polygon that a cylinder is: it lies within by 1 - cos(pi / 96), 5e-4 of the
// radius.
constexpr int kCylinderSides = 96;

void Set(const Vector3d& from, std::array<double, 3>* to) {
  Eigen::Map<Vector3d>(to->data()) = from;
}

}  // namespace

TriangleMesh MakeCylinderMesh(double radius, double length, int sides) {
  TriangleMesh mesh;
  const double pi = std::acos(-1.0);
  for (const double z : {-0.5 * length, 0.5 * length}) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2.0 * pi * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
    mesh.vertices.emplace_back(0.0, 0.0, z);
  }
  const int top = sides + 1;
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    mesh.triangles.push_back({i, j, top + j});
    mesh.triangles.push_back({i, top + j, top + i});
    mesh.triangles.push_back({sides, j, i});
    mesh.triangles.push_back({top + sides, top + i, top + j});
  }
  return mesh;
}

TriangleMesh MakeBoxMesh(const std::array<double, 3>& half_sizes) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d x;
    for (int k = 0; k < 3; ++k) x[k] = (corner >> k & 1 ? 1.0 : -1.0) * half_sizes[k];
    mesh.vertices.push_back(x);
  }
  constexpr int kFaces[6][4] = {
      {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({face[0], face[1], face[2]});
    mesh.triangles.push_back({face[0], face[2], face[3]});
  }
  return mesh;
}

bool HandReader::ReadUnitVector(const YamlField& field, std::array<double, 3>* vector) {
  if (!ReadNumbers(field, 3, kVectorAllowed, kAnyNumber, vector->data())) return false;
  Eigen::Map<Vector3d> v(vector->data());
  if (v.isZero(0.0)) return Fail(field, "a vector of length zero", kVectorAllowed);
  v.stableNormalize();
  return true;
}

bool HandReader::ReadPose(const YamlField& field, UrdfPose* pose) {
  constexpr char kAllowed[] = "a map with xyz and rpy or quaternion";
  constexpr char kQuaternion[] = "a list of four numbers, [w, x, y, z]";
  YamlMap map;
  if (!OpenMap(field, kAllowed, &map) || !CheckKeys(map, {"xyz", "rpy", "quaternion"}))
    return false;
  const YamlField* const xyz = map.Find("xyz");
  if (xyz != nullptr &&
      !ReadNumbers(*xyz, 3, kVectorAllowed, kAnyNumber, pose->translation.data())) {
    return false;
  }
  const YamlField* const rpy = map.Find("rpy");
  const YamlField* const quaternion = map.Find("quaternion");
  if (rpy != nullptr && quaternion != nullptr) {
    return Fail(*quaternion, "a quaternion beside rpy", "one of the two");
  }
  if (rpy != nullptr) {
    Vector3d angles;
    if (!ReadNumbers(*rpy, 3, kVectorAllowed, kAnyNumber, angles.data())) return false;
    pose->rotation = RotationOfRpy(angles);
  }
  if (quaternion != nullptr) {
    Eigen::Vector4d wxyz;
    if (!ReadNumbers(*quaternion, 4, kQuaternion, kAnyNumber, wxyz.data())) return false;
    if (std::abs(wxyz.stableNorm() - 1.0) > 1e-3) {
      return Fail(*quaternion, "a quaternion of length " + FormatShort(wxyz.stableNorm()), "1");
    }
    pose->rotation =
        Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
  }
  return true;
}

bool HandReader::ReadPackages(const YamlField& field) {
  YamlMap map;
  if (!OpenMap(field, "a map from package names to folders", &map)) return false;
  for (const auto& [name, entry] : map.entries) {
    std::string folder;
    if (!ReadText(entry, "the name of a folder", &folder)) return false;
    packages_[name] = Resolve(folder);
  }
  return true;
}

bool HandReader::ReadHand(const YamlField& field) {
  YamlMap map, joints;
  YamlField file;
  std::string name, error;
  if (!OpenMap(field, "a map with the key file", &map) ||
      !CheckKeys(map, {"file", "scale", "pose", "joints", "packages"}) ||
      !Require(map, "file", "the name of a .urdf file", &file) ||
      !ReadText(file, "the name of a .urdf file", &name)) {
    return false;
  }
  if (!ReadUrdf(Resolve(name), &urdf_, &error)) return FailWith(file, Clean(error, 400));
  const YamlField* const scale = map.Find("scale");
  if (scale != nullptr && !ReadNumber(*scale, kPositiveNumber, &scale_)) return false;
  const YamlField* const pose = map.Find("pose");
  if (pose != nullptr && !ReadPose(*pose, &base_)) return false;
  const YamlField* const packages = map.Find("packages");
  if (packages != nullptr && !ReadPackages(*packages)) return false;
  std::map<std::string, double> values;
  const YamlField* const list = map.Find("joints");
  if (list != nullptr) {
    if (!OpenMap(*list, "a map from joint names to values", &joints)) return false;
    for (const auto& [joint, entry] : joints.entries) {
      if (!ReadNumber(entry, kAnyNumber, &values[joint])) return false;
    }
  }
  if (!UrdfPoses(urdf_, values, UrdfPose(), &poses_, &error)) {
    return FailWith(list == nullptr ? field : *list, Clean(error, 400));
  }
  has_hand_ = true;
  return true;
}

bool HandReader::ReadLinkFinger(const YamlField& shape, const YamlMap& map, FingerSpec* finger) {
  YamlMap keys;
  YamlField entry;
  std::string name;
  if (!OpenMap(shape, "a map with the key kind", &keys)) return false;
  if (!has_hand_) {
    return Fail(shape, "a link without a hand", "the section hand, with the file of a robot hand");
  }
  if (const YamlField* const position = map.Find("position")) {
    return Fail(*position, "a position of a link", "none: the hand has it");
  }
  if (!Require(keys, "link", "the name of a link", &entry) ||
      !ReadText(entry, "the name of a link", &name)) {
    return false;
  }
  const int link = urdf_.FindLink(name);
  if (link < 0) {
    Names names;
    for (const UrdfLink& other : urdf_.links) names.push_back(other.name);
    return Fail(entry, Quote(name), Clean(Join(names), 300), NearestName(name, names));
  }
  std::string kind = "collision";
  const YamlField* const geometry = keys.Find("geometry");
  if (geometry != nullptr && !ReadChoice(*geometry, {"collision", "visual"}, {}, &kind))
    return false;
  const std::vector<UrdfShape>& shapes =
      kind == "visual" ? urdf_.links[link].visual : urdf_.links[link].collision;
  if (shapes.empty()) {
    return Fail(entry,
                "link " + Quote(name) + " without a <" + kind + ">",
                "a link with one (geometry: collision | visual)");
  }
  // Which of several: its number, from 0, or its name.
  int element = 0;
  const YamlField* const which = keys.Find("element");
  Names choices;
  for (size_t i = 0; i < shapes.size(); ++i) {
    choices.push_back(shapes[i].name.empty() ? std::to_string(i) : shapes[i].name);
  }
  if (which == nullptr && shapes.size() > 1) {
    return Fail(
        entry,
        "link " + Quote(name) + " with " + std::to_string(shapes.size()) + " of <" + kind + ">",
        "the key element beside it: " + Clean(Join(choices), 300));
  }
  if (which != nullptr) {
    std::string text;
    if (!ReadScalar(*which, Clean(Join(choices), 300), &text)) return false;
    const auto found = std::find(choices.begin(), choices.end(), text);
    int number = -1;
    if (found != choices.end()) {
      element = static_cast<int>(found - choices.begin());
    } else if (ParseInteger(text, &number) && number >= 0 &&
               number < static_cast<int>(shapes.size())) {
      element = number;
    } else {
      return Fail(*which, Quote(text), Clean(Join(choices), 300), NearestName(text, choices));
    }
  }
  if (!Require(map, "direction", kVectorAllowed, &entry) ||
      !ReadUnitVector(entry, &finger->direction)) {
    return false;
  }
  std::string frame = "scene";
  const YamlField* const in = map.Find("direction_in");
  if (in != nullptr && !ReadChoice(*in, {"scene", "hand", "link"}, {}, &frame)) return false;
  if (frame != "scene") {
    Vector3d direction(finger->direction[0], finger->direction[1], finger->direction[2]);
    if (frame == "link") direction = poses_[link].rotation * direction;
    Set(base_.rotation * direction, &finger->direction);
  }
  return ReadLinkShape(shape, shapes[element], poses_[link] * shapes[element].origin, finger);
}

bool HandReader::ReadLinkShape(const YamlField& field,
                               const UrdfShape& shape,
                               const UrdfPose& pose,
                               FingerSpec* finger) {
  const Eigen::Matrix3d rotation = base_.rotation * pose.rotation;
  Set(base_.translation + base_.rotation * (scale_ * pose.translation), &finger->position);
  auto mesh = std::make_shared<TriangleMesh>();
  if (!rotation.allFinite() || !Eigen::Map<const Vector3d>(finger->position.data()).allFinite()) {
    return Fail(field, "a place that is not finite", "a hand of sensible sizes");
  }
  switch (shape.kind) {
    case UrdfShape::Kind::kSphere:
      finger->shape = FingerSpec::Shape::kSphere;
      finger->radius = scale_ * shape.radius;
      return true;
    case UrdfShape::Kind::kCapsule:
      finger->shape = FingerSpec::Shape::kCapsule;
      finger->radius = scale_ * shape.radius;
      finger->length = scale_ * shape.length;
      Set(rotation.col(2), &finger->axis);
      return true;
    case UrdfShape::Kind::kBox: {
      const Vector3d half = 0.5 * scale_ * shape.size;
      const Eigen::Map<const Vector3d> direction(finger->direction.data());
      int along;
      const Vector3d cosines = (rotation.transpose() * direction).cwiseAbs();
      if (cosines.maxCoeff(&along) > 1.0 - 1e-12) {
        // As boxes of a scene are: their z along the direction.
        const int x = (along + 1) % 3, y = (along + 2) % 3;
        finger->shape = FingerSpec::Shape::kBox;
        finger->half_sizes = {half[x], half[y], half[along]};
        Set(rotation.col(x), &finger->axis);
        return true;
      }
      *mesh = MakeBoxMesh({half.x(), half.y(), half.z()});
      break;
    }
    case UrdfShape::Kind::kCylinder:
      *mesh = MakeCylinderMesh(scale_ * shape.radius, scale_ * shape.length, kCylinderSides);
      break;
    case UrdfShape::Kind::kMesh: {
      std::string error;
      const std::string where = urdf_.file + ":" + std::to_string(shape.line) + ": <mesh>: ";
      const std::string file = ResolveUrdfMesh(shape.file, urdf_.file, packages_, &error);
      if (file.empty()) return FailWith(field, Clean(where + error, 500));
      if (!ReadMesh(file, mesh.get(), &error)) {
        return Fail(field, Clean(where + error, 500), "an .stl, .obj, .ply or .off file");
      }
      for (Vector3d& x : mesh->vertices) x = scale_ * shape.scale.cwiseProduct(x);
      if (shape.scale.prod() < 0.0) {  // mirrored
        for (std::array<int, 3>& triangle : mesh->triangles) std::swap(triangle[1], triangle[2]);
      }
      if (MakeMeshFinger(*mesh, &error) == nullptr) {
        return Fail(field,
                    Clean(where + file + ": " + error, 500),
                    "a closed mesh, seen counterclockwise from outside");
      }
      break;
    }
  }
  // A mesh keeps the axes of the scene.
  for (Vector3d& x : mesh->vertices) x = rotation * x;
  finger->shape = FingerSpec::Shape::kMesh;
  finger->mesh = std::move(mesh);
  return true;
}

}  // namespace darboux
