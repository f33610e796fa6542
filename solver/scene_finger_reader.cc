#include "solver/scene_finger_reader.h"

#include <Eigen/Core>
#include <algorithm>
#include <memory>

#include "geometry/mesh_finger.h"
#include "geometry/mesh_io.h"

namespace darboux {
namespace {

const KindKeys& ShapeKeys() {
  static const KindKeys& keys = *new KindKeys{{"pin", {}},
                                              {"sphere", {"radius"}},
                                              {"capsule", {"radius", "length", "axis"}},
                                              {"box", {"half_sizes", "rounding", "axis"}},
                                              {"plane", {}},
                                              {"mesh", {"file"}},
                                              {"link", {"link", "geometry", "element"}}};
  return keys;
}

}  // namespace

bool IsIdentifier(const std::string& text) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  if (text.empty() || !is_letter(text[0])) return false;
  return std::all_of(text.begin(), text.end(), [&is_letter](char c) {
    return is_letter(c) || (c >= '0' && c <= '9');
  });
}

bool FingerReader::ReadShape(const YamlField& field,
                             const YamlMap& finger_map,
                             bool* is_link,
                             FingerSpec* finger) {
  const Names kinds = Kinds(ShapeKeys());
  YamlMap map;
  YamlField kind, entry;
  std::string name;
  if (!OpenMap(field, "a map with the key kind", &map) ||
      !Require(map, "kind", Join(kinds), &kind) || !ReadChoice(kind, kinds, {}, &name) ||
      !CheckKindKeys(map, ShapeKeys(), {"kind"}, name)) {
    return false;
  }
  *is_link = name == "link";
  if (*is_link) return ReadLinkFinger(field, finger_map, finger);
  finger->shape =
      static_cast<FingerSpec::Shape>(std::find(kinds.begin(), kinds.end(), name) - kinds.begin());
  if (const YamlField* axis = map.Find("axis")) {
    if (!ReadUnitVector(*axis, &finger->axis)) return false;
  }
  switch (finger->shape) {
    case FingerSpec::Shape::kPin:
    case FingerSpec::Shape::kPlane:
      return true;
    case FingerSpec::Shape::kCapsule:
      return Require(map, "axis", kVectorAllowed, &entry) &&
             RequireNumber(map, "radius", kPositiveNumber, &finger->radius) &&
             RequireNumber(map, "length", kPositiveNumber, &finger->length);
    case FingerSpec::Shape::kSphere:
      return RequireNumber(map, "radius", kPositiveNumber, &finger->radius);
    case FingerSpec::Shape::kBox: {
      constexpr char kAllowed[] = "a list of three numbers > 0";
      if (!Require(map, "half_sizes", kAllowed, &entry) ||
          !ReadNumbers(entry, 3, kAllowed, kPositiveNumber, finger->half_sizes.data())) {
        return false;
      }
      const YamlField* const rounding = map.Find("rounding");
      if (rounding == nullptr) return true;
      const double least = *std::min_element(finger->half_sizes.begin(), finger->half_sizes.end());
      if (!ReadNumber(*rounding, kNotNegativeNumber, &finger->rounding)) return false;
      return finger->rounding <= least ||
             Fail(*rounding, Describe(*rounding), "at most the smallest of half_sizes");
    }
    case FingerSpec::Shape::kMesh: {
      std::string file, error;
      auto mesh = std::make_shared<TriangleMesh>();
      if (!Require(map, "file", "a mesh file", &entry) ||
          !ReadText(entry, "the name of a mesh file", &file)) {
        return false;
      }
      if (!ReadNamedMesh(file, mesh.get(), &error) || MakeMeshFinger(*mesh, &error) == nullptr) {
        return Fail(entry, Clean(error, 300), "a closed mesh, seen counterclockwise from outside");
      }
      finger->mesh = std::move(mesh);
      return true;
    }
  }
  return true;
}

bool FingerReader::ReadPlace(const YamlMap& map, FingerSpec* finger) {
  YamlField position, direction;
  if (const YamlField* const in = map.Find("direction_in")) {
    return Fail(*in, "direction_in of a shape that is no link", "shape: {kind: link, ...} with it");
  }
  return Require(map, "position", kVectorAllowed, &position) &&
         ReadNumbers(position, 3, kVectorAllowed, kAnyNumber, finger->position.data()) &&
         Require(map, "direction", kVectorAllowed, &direction) &&
         ReadUnitVector(direction, &finger->direction);
}

bool FingerReader::ReadFinger(const YamlField& field,
                              const std::vector<FingerSpec>& others,
                              FingerSpec* finger) {
  constexpr char kNameAllowed[] = "a name of letters, digits and _ that begins with no digit";
  constexpr char kMotionAllowed[] = "{travel: number} or {force: number}";
  YamlMap map, motion;
  YamlField name, shape, entry;
  bool is_link = false;
  finger->location = Location(field);
  if (!OpenMap(field, "a map with name, shape, position, direction, motion", &map) ||
      !CheckKeys(
          map, {"name", "shape", "position", "direction", "direction_in", "motion", "friction"}) ||
      !Require(map, "name", kNameAllowed, &name) ||
      !ReadScalar(name, kNameAllowed, &finger->name)) {
    return false;
  }
  if (!IsIdentifier(finger->name)) return Fail(name, Describe(name), kNameAllowed);
  for (const FingerSpec& other : others) {
    if (other.name == finger->name && &other != finger) {
      return Fail(name, Quote(finger->name) + " a second time", "a different name for each finger");
    }
  }
  if (!Require(map, "shape", "a map with the key kind", &shape) ||
      !ReadShape(shape, map, &is_link, finger) || (!is_link && !ReadPlace(map, finger)) ||
      !Require(map, "motion", kMotionAllowed, &entry) || !OpenMap(entry, kMotionAllowed, &motion) ||
      !CheckKeys(motion, {"travel", "force"})) {
    return false;
  }
  const YamlField* const force = motion.Find("force");
  if (force != nullptr && motion.Find("travel") != nullptr) {
    return Fail(*force, "a force beside a travel", "exactly one of travel and force");
  }
  if (force != nullptr) {
    double value = 0.0;
    if (!ReadNumber(*force, kPositiveNumber, &value)) return false;
    finger->force = value;
  } else if (!RequireNumber(motion, "travel", kNotNegativeNumber, &finger->travel)) {
    return false;
  }
  const YamlField* const friction = map.Find("friction");
  return friction == nullptr || ReadNumber(*friction, kNotNegativeNumber, &finger->friction);
}

}  // namespace darboux
