#include "geometry/urdf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "geometry/nearest_name.h"
#include "geometry/text_file.h"
#ifdef DARBOUX_HAVE_TINYXML2
#include <tinyxml2.h>
#endif

namespace darboux {

using Eigen::Vector3d;

Eigen::Matrix3d RotationOfRpy(const Vector3d& rpy) {
  const auto about = [](double angle, int axis) {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    rotation(i, i) = rotation(j, j) = std::cos(angle);
    rotation(j, i) = std::sin(angle);
    rotation(i, j) = -std::sin(angle);
    return rotation;
  };
  return about(rpy.z(), 2) * about(rpy.y(), 1) * about(rpy.x(), 0);
}

int Urdf::FindLink(const std::string& link) const {
  for (size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link) return static_cast<int>(i);
  }
  return -1;
}

int Urdf::FindJoint(const std::string& joint) const {
  for (size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].name == joint) return static_cast<int>(i);
  }
  return -1;
}

#ifdef DARBOUX_HAVE_TINYXML2
namespace {

using tinyxml2::XMLElement;

constexpr size_t kMaxBytes = 64 << 20;

// For one-line messages.
std::string Quote(const char* text) {
  if (text == nullptr) return "nothing";
  std::string quoted = "'";
  for (const char* c = text; *c != '\0' && quoted.size() < 60; ++c) {
    quoted += static_cast<unsigned char>(*c) < 32 || *c == 127 ? '?' : *c;
  }
  return quoted + "'";
}

class Parser {
 public:
  Parser(const std::string& file, std::string* error) : file_(file), error_(error) {}

  bool Parse(const std::string& text, Urdf* urdf) {
    if (text.size() > kMaxBytes) {
      return FailAt(0, "file", std::to_string(text.size()) + " bytes", "at most 64 MiB");
    }
    tinyxml2::XMLDocument document;
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      return FailAt(document.ErrorLineNum(),
                    "file",
                    std::string("no XML (") + document.ErrorName() + ")",
                    "a URDF file");
    }
    const XMLElement* const robot = document.RootElement();
    if (robot == nullptr || std::string(robot->Name()) != "robot") {
      return FailAt(robot == nullptr ? 1 : robot->GetLineNum(),
                    "file",
                    robot == nullptr ? "no element" : "<" + Clean(robot->Name()) + ">",
                    "<robot> (expand xacro files first)");
    }
    urdf_.file = file_;
    if (robot->Attribute("name") != nullptr) urdf_.name = robot->Attribute("name");
    for (const XMLElement* e = Child(robot, "link"); e != nullptr; e = Next(e)) {
      if (!ReadLink(e)) return false;
    }
    for (const XMLElement* e = Child(robot, "joint"); e != nullptr; e = Next(e)) {
      if (!ReadJoint(e)) return false;
    }
    if (!FindMimics() || !CheckTree()) return false;
    *urdf = std::move(urdf_);
    return true;
  }

 private:
  static const XMLElement* Child(const XMLElement* e, const char* name) {
    return e->FirstChildElement(name);
  }
  static const XMLElement* Next(const XMLElement* e) { return e->NextSiblingElement(e->Name()); }
  static std::string Clean(const char* text) {
    const std::string quoted = Quote(text);
    return quoted.substr(1, quoted.size() - 2);
  }

  bool FailAt(int line,
              const std::string& where,
              const std::string& found,
              const std::string& allowed) {
    *error_ = file_ + ":" + std::to_string(line) + ": " + where + ": found " + found +
              "; allowed " + allowed;
    return false;
  }
  bool Fail(const XMLElement* e, const std::string& found, const std::string& allowed) {
    std::string where = "<" + Clean(e->Name());
    if (e->Attribute("name") != nullptr) where += " name=" + Quote(e->Attribute("name"));
    return FailAt(e->GetLineNum(), where + ">", found, allowed);
  }

  bool ReadName(const XMLElement* e, std::string* name) {
    const char* const text = e->Attribute("name");
    if (text == nullptr || *text == '\0') return Fail(e, "no name", "name=\"...\"");
    *name = text;
    return true;
  }

  // `count` numbers; leaves them alone where the attribute is missing and not required.
  bool ReadNumbers(
      const XMLElement* e, const char* attribute, bool required, int count, double* out) {
    const char* const text = e->Attribute(attribute);
    const std::string allowed = std::string(attribute) + "=\"" +
                                (count == 1 ? "number" : std::to_string(count) + " numbers") + "\"";
    if (text == nullptr) return !required || Fail(e, std::string("no ") + attribute, allowed);
    const std::string words = text;
    const char* at = words.data();
    const char* const end = at + words.size();
    const auto skip = [&] {
      while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
    };
    std::array<double, 3> values{};
    for (int i = 0; i < count; ++i) {
      skip();
      if (at != end && *at == '+') ++at;
      const std::from_chars_result read = std::from_chars(at, end, values[i]);
      if (read.ec != std::errc() || !std::isfinite(values[i])) {
        return Fail(e, std::string(attribute) + "=" + Quote(text), allowed);
      }
      at = read.ptr;
    }
    skip();
    if (at != end) return Fail(e, std::string(attribute) + "=" + Quote(text), allowed);
    std::copy_n(values.begin(), count, out);
    return true;
  }

  bool ReadPositive(const XMLElement* e, const char* attribute, double* value) {
    if (!ReadNumbers(e, attribute, true, 1, value)) return false;
    return *value > 0.0 || Fail(e,
                                std::string(attribute) + "=" + Quote(e->Attribute(attribute)),
                                std::string(attribute) + " > 0");
  }

  bool ReadOrigin(const XMLElement* owner, UrdfPose* pose) {
    const XMLElement* const e = Child(owner, "origin");
    if (e == nullptr) return true;
    Vector3d xyz = Vector3d::Zero(), rpy = Vector3d::Zero();
    if (!ReadNumbers(e, "xyz", false, 3, xyz.data()) ||
        !ReadNumbers(e, "rpy", false, 3, rpy.data())) {
      return false;
    }
    *pose = {RotationOfRpy(rpy), xyz};
    return true;
  }

  bool ReadShape(const XMLElement* owner, UrdfShape* shape) {
    constexpr char kKinds[] = "one of <box>, <sphere>, <cylinder>, <capsule>, <mesh>";
    shape->line = owner->GetLineNum();
    if (owner->Attribute("name") != nullptr) shape->name = owner->Attribute("name");
    const XMLElement* const geometry = Child(owner, "geometry");
    if (geometry == nullptr) return Fail(owner, "no <geometry>", "<geometry>");
    const XMLElement* const e = geometry->FirstChildElement();
    if (e == nullptr) return Fail(geometry, "nothing", kKinds);
    if (!ReadOrigin(owner, &shape->origin)) return false;
    const std::string kind = e->Name();
    if (kind == "box") {
      shape->kind = UrdfShape::Kind::kBox;
      if (!ReadNumbers(e, "size", true, 3, shape->size.data())) return false;
      return shape->size.minCoeff() > 0.0 ||
             Fail(e, "size=" + Quote(e->Attribute("size")), "three numbers > 0");
    }
    if (kind == "sphere") {
      shape->kind = UrdfShape::Kind::kSphere;
      return ReadPositive(e, "radius", &shape->radius);
    }
    if (kind == "cylinder" || kind == "capsule") {
      shape->kind = kind == "capsule" ? UrdfShape::Kind::kCapsule : UrdfShape::Kind::kCylinder;
      return ReadPositive(e, "radius", &shape->radius) && ReadPositive(e, "length", &shape->length);
    }
    if (kind == "mesh") {
      shape->kind = UrdfShape::Kind::kMesh;
      const char* const file = e->Attribute("filename");
      if (file == nullptr || *file == '\0') return Fail(e, "no filename", "filename=\"...\"");
      shape->file = file;
      if (!ReadNumbers(e, "scale", false, 3, shape->scale.data())) return false;
      return shape->scale.cwiseAbs().minCoeff() > 0.0 ||
             Fail(e, "scale=" + Quote(e->Attribute("scale")), "three numbers other than 0");
    }
    return Fail(geometry, "<" + Clean(e->Name()) + ">", kKinds);
  }

  bool ReadLink(const XMLElement* e) {
    UrdfLink link;
    link.line = e->GetLineNum();
    if (!ReadName(e, &link.name)) return false;
    if (!link_index_.insert({link.name, static_cast<int>(urdf_.links.size())}).second) {
      return Fail(e, "a second link of this name", "a name of its own");
    }
    for (const bool visual : {false, true}) {
      for (const XMLElement* s = Child(e, visual ? "visual" : "collision"); s != nullptr;
           s = Next(s)) {
        std::vector<UrdfShape>& shapes = visual ? link.visual : link.collision;
        shapes.emplace_back();
        if (!ReadShape(s, &shapes.back())) return false;
      }
    }
    urdf_.links.push_back(std::move(link));
    return true;
  }

  // The link that <parent> or <child> names.
  bool ReadEnd(const XMLElement* joint, const char* which, int* link) {
    const XMLElement* const e = Child(joint, which);
    const char* const name = e == nullptr ? nullptr : e->Attribute("link");
    if (name == nullptr) {
      return Fail(joint, std::string("no <") + which + " link=\"...\">", "the name of a link");
    }
    const auto found = link_index_.find(name);
    if (found == link_index_.end()) {
      std::vector<std::string> names;
      for (const UrdfLink& other : urdf_.links) names.push_back(other.name);
      const std::string nearest = NearestName(name, names);
      return Fail(e,
                  "link=" + Quote(name) + ", which is no link",
                  "a link of this file" +
                      (nearest.empty() ? "" : "; did you mean " + Quote(nearest.c_str()) + "?"));
    }
    *link = found->second;
    return true;
  }

  bool ReadJoint(const XMLElement* e) {
    UrdfJoint joint;
    joint.line = e->GetLineNum();
    if (!ReadName(e, &joint.name)) return false;
    if (!joint_index_.insert({joint.name, static_cast<int>(urdf_.joints.size())}).second) {
      return Fail(e, "a second joint of this name", "a name of its own");
    }
    constexpr char kKinds[] = "revolute | continuous | prismatic | fixed";
    const char* const type = e->Attribute("type");
    const std::string kind = type == nullptr ? "" : type;
    if (kind == "revolute") {
      joint.kind = UrdfJoint::Kind::kRevolute;
    } else if (kind == "continuous") {
      joint.kind = UrdfJoint::Kind::kContinuous;
    } else if (kind == "prismatic") {
      joint.kind = UrdfJoint::Kind::kPrismatic;
    } else if (kind != "fixed") {
      return Fail(e, "type=" + Quote(type), kKinds);
    }
    if (!ReadEnd(e, "parent", &joint.parent) || !ReadEnd(e, "child", &joint.child) ||
        !ReadOrigin(e, &joint.origin)) {
      return false;
    }
    if (const XMLElement* const axis = Child(e, "axis")) {
      if (!ReadNumbers(axis, "xyz", true, 3, joint.axis.data())) return false;
      if (joint.axis.isZero(0.0)) return Fail(axis, "an axis of length zero", "a direction");
      joint.axis.stableNormalize();
    }
    const bool limited =
        joint.kind == UrdfJoint::Kind::kRevolute || joint.kind == UrdfJoint::Kind::kPrismatic;
    const XMLElement* const limit = Child(e, "limit");
    if (limited && limit == nullptr) return Fail(e, "no <limit>", "<limit lower=... upper=...>");
    if (limited) {
      if (!ReadNumbers(limit, "lower", false, 1, &joint.lower) ||
          !ReadNumbers(limit, "upper", false, 1, &joint.upper)) {
        return false;
      }
      if (joint.lower > joint.upper) return Fail(limit, "lower above upper", "lower <= upper");
    }
    UrdfLink& child = urdf_.links[joint.child];
    if (child.parent_joint >= 0) {
      return Fail(e,
                  "a second parent of link " + Quote(child.name.c_str()) + ", after joint " +
                      Quote(urdf_.joints[child.parent_joint].name.c_str()),
                  "one joint to each child");
    }
    child.parent_joint = static_cast<int>(urdf_.joints.size());
    mimics_.push_back(Child(e, "mimic"));
    urdf_.joints.push_back(joint);
    return true;
  }

  bool FindMimics() {
    for (size_t i = 0; i < mimics_.size(); ++i) {
      const XMLElement* const e = mimics_[i];
      if (e == nullptr) continue;
      UrdfJoint& joint = urdf_.joints[i];
      const char* const name = e->Attribute("joint");
      const auto found = joint_index_.find(name == nullptr ? "" : name);
      if (found == joint_index_.end()) {
        return Fail(e, "joint=" + Quote(name) + ", which is no joint", "a joint of this file");
      }
      joint.mimic = found->second;
      if (!ReadNumbers(e, "multiplier", false, 1, &joint.multiplier) ||
          !ReadNumbers(e, "offset", false, 1, &joint.offset)) {
        return false;
      }
    }
    return true;
  }

  // One root, and every link below it.
  bool CheckTree() {
    int root = -1;
    for (size_t i = 0; i < urdf_.links.size(); ++i) {
      const UrdfLink& link = urdf_.links[i];
      if (link.parent_joint >= 0) continue;
      if (root >= 0) {
        return FailAt(
            link.line,
            "<link name=" + Quote(link.name.c_str()) + ">",
            "a second link without a parent, after " + Quote(urdf_.links[root].name.c_str()),
            "one root");
      }
      root = static_cast<int>(i);
    }
    if (urdf_.links.empty()) return FailAt(1, "<robot>", "no <link>", "at least one");
    if (root < 0)
      return FailAt(1, "<robot>", "joints in a circle: no link without a parent", "a tree");
    // With one parent each, a link that the root does not lead to is in a circle.
    std::vector<std::vector<int>> children(urdf_.links.size());
    for (const UrdfJoint& joint : urdf_.joints) children[joint.parent].push_back(joint.child);
    std::vector<int> reached = {root};
    for (size_t i = 0; i < reached.size(); ++i) {
      const std::vector<int>& below = children[reached[i]];
      reached.insert(reached.end(), below.begin(), below.end());
    }
    if (reached.size() == urdf_.links.size()) return true;
    std::vector<char> is_reached(urdf_.links.size(), 0);
    for (const int link : reached) is_reached[link] = 1;
    const size_t lost = std::find(is_reached.begin(), is_reached.end(), 0) - is_reached.begin();
    const UrdfLink& link = urdf_.links[lost];
    return FailAt(link.line,
                  "<link name=" + Quote(link.name.c_str()) + ">",
                  "joints in a circle above it",
                  "a tree");
  }

  const std::string file_;
  std::string* const error_;
  Urdf urdf_;
  std::map<std::string, int> link_index_, joint_index_;
  std::vector<const XMLElement*> mimics_;
};

}  // namespace

bool ParseUrdf(const std::string& text, const std::string& file, Urdf* urdf, std::string* error) {
  return Parser(file, error).Parse(text, urdf);
}
#else
bool ParseUrdf(const std::string&, const std::string& file, Urdf*, std::string* error) {
  *error = file +
           ":0: file: found a URDF file; allowed where Darboux was built with tinyxml2 (Debian: "
           "libtinyxml2-dev)";
  return false;
}
#endif

bool ReadUrdf(const std::string& file, Urdf* urdf, std::string* error) {
  std::string text;
  return ReadBytes(file, "a URDF file", &text, error) && ParseUrdf(text, file, urdf, error);
}

bool UrdfPoses(const Urdf& urdf,
               const std::map<std::string, double>& values,
               const UrdfPose& base,
               std::vector<UrdfPose>* poses,
               std::string* error) {
  const auto fail =
      [error](const std::string& joint, const std::string& found, const std::string& allowed) {
        *error = "joint '" + joint + "': found " + found + "; allowed " + allowed;
        return false;
      };
  const auto number = [](double value) {
    std::string text;
    AppendNumber(value, &text);
    return text;
  };
  std::vector<std::string> movable;
  for (const UrdfJoint& joint : urdf.joints) {
    if (joint.kind != UrdfJoint::Kind::kFixed && joint.mimic < 0) movable.push_back(joint.name);
  }
  std::vector<double> q(urdf.joints.size(), 0.0);
  for (const auto& [name, value] : values) {
    const int i = urdf.FindJoint(name);
    if (i < 0) {
      std::string list;
      for (const std::string& other : movable) list += (list.empty() ? "" : " | ") + other;
      const std::string nearest = NearestName(name, movable);
      return fail(name,
                  "no such joint",
                  (list.empty() ? std::string("none: nothing moves") : list) +
                      (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
    }
    if (urdf.joints[i].kind == UrdfJoint::Kind::kFixed) {
      return fail(name, number(value), "nothing: it is fixed");
    }
    if (urdf.joints[i].mimic >= 0) {
      return fail(name,
                  number(value),
                  "nothing: it follows joint '" + urdf.joints[urdf.joints[i].mimic].name + "'");
    }
    q[i] = value;
  }
  for (size_t i = 0; i < q.size(); ++i) {
    // Through chains of followers, which are no longer than all joints.
    double factor = 1.0, offset = 0.0;
    int leader = static_cast<int>(i);
    for (size_t steps = 0; urdf.joints[leader].mimic >= 0; ++steps) {
      if (steps > q.size()) return fail(urdf.joints[i].name, "mimicry in a circle", "a leader");
      offset += factor * urdf.joints[leader].offset;
      factor *= urdf.joints[leader].multiplier;
      leader = urdf.joints[leader].mimic;
    }
    if (leader != static_cast<int>(i)) q[i] = factor * q[leader] + offset;
  }
  for (size_t i = 0; i < q.size(); ++i) {
    const UrdfJoint& joint = urdf.joints[i];
    const bool limited =
        joint.kind == UrdfJoint::Kind::kRevolute || joint.kind == UrdfJoint::Kind::kPrismatic;
    if (limited && !(q[i] >= joint.lower && q[i] <= joint.upper)) {
      return fail(
          joint.name,
          number(q[i]) + (values.count(joint.name) == 0 && joint.mimic < 0 ? ", the default" : ""),
          "a number in [" + number(joint.lower) + ", " + number(joint.upper) + "]");
    }
  }
  poses->assign(urdf.links.size(), base);
  // Parents first: every link after the one above it.
  std::vector<std::vector<int>> below(urdf.links.size());
  std::vector<int> order;
  for (size_t i = 0; i < urdf.links.size(); ++i) {
    if (urdf.links[i].parent_joint < 0) order.push_back(static_cast<int>(i));
  }
  for (size_t i = 0; i < urdf.joints.size(); ++i) {
    below[urdf.joints[i].parent].push_back(static_cast<int>(i));
  }
  for (size_t k = 0; k < order.size(); ++k) {
    for (const int i : below[order[k]]) {
      const UrdfJoint& joint = urdf.joints[i];
      UrdfPose motion;
      if (joint.kind == UrdfJoint::Kind::kPrismatic) {
        motion.translation = q[i] * joint.axis;
      } else if (joint.kind != UrdfJoint::Kind::kFixed && q[i] != 0.0) {
        motion.rotation = Eigen::AngleAxisd(q[i], joint.axis).toRotationMatrix();
      }
      (*poses)[joint.child] = (*poses)[joint.parent] * joint.origin * motion;
      order.push_back(joint.child);
    }
  }
  return true;
}

std::string ResolveUrdfMesh(const std::string& name,
                            const std::string& urdf_file,
                            const std::map<std::string, std::string>& packages,
                            std::string* error) {
  namespace fs = std::filesystem;
  constexpr char kFile[] = "file://", kPackage[] = "package://";
  const auto begins = [&name](const char* scheme) { return name.rfind(scheme, 0) == 0; };
  const fs::path folder = fs::path(urdf_file).parent_path();
  if (begins(kFile)) return name.substr(sizeof(kFile) - 1);
  if (!begins(kPackage)) {
    if (name.find("://") == std::string::npos) return (folder / name).string();
    *error = "found '" + name + "'; allowed a file name, file:// or package://";
    return "";
  }
  const std::string rest = name.substr(sizeof(kPackage) - 1);
  const size_t slash = std::min(rest.find('/'), rest.size());
  const std::string package = rest.substr(0, slash);
  const std::string below = slash < rest.size() ? rest.substr(slash + 1) : "";
  const auto given = packages.find(package);
  if (given != packages.end()) return (fs::path(given->second) / below).string();
  std::error_code code;
  fs::path at = fs::absolute(folder.empty() ? fs::path(".") : folder, code).lexically_normal();
  while (!code && !package.empty()) {
    if (at.filename() == package && fs::exists(at / below, code)) return (at / below).string();
    if (fs::exists(at / package / below, code)) return (at / package / below).string();
    if (at == at.parent_path()) break;
    at = at.parent_path();
  }
  *error = "found '" + name + "', and no folder '" + package +
           "' with this file above the URDF file; allowed a folder named under packages";
  return "";
}

}  // namespace darboux
