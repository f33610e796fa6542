#include "geometry/urdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "geometry/mesh_finger.h"
#include "geometry/mesh_io.h"
#include "solver/scene_hand_reader.h"
#include "solver/scene_reader.h"

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

const double kPi = std::acos(-1.0);

std::string Robot(const std::string& body) { return "<robot name=\"r\">\n" + body + "</robot>\n"; }

// An arm of two links of length 2 and 1 with a tip, a sphere; the second joint bends about y.
std::string Arm() {
  return Robot(
      "<link name=\"base\"/>\n"
      "<joint name=\"turn\" type=\"continuous\"><parent link=\"base\"/><child link=\"upper\"/>"
      "<axis xyz=\"0 0 2\"/></joint>\n"
      "<link name=\"upper\"/>\n"
      "<joint name=\"bend\" type=\"revolute\"><parent link=\"upper\"/><child link=\"lower\"/>"
      "<origin xyz=\"2 0 0\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1.6\"/></joint>\n"
      "<link name=\"lower\"/>\n"
      "<joint name=\"slide\" type=\"prismatic\"><parent link=\"lower\"/><child link=\"tip\"/>"
      "<origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/><axis xyz=\"1 0 0\"/>"
      "<limit lower=\"0\" upper=\"0.75\"/><mimic joint=\"turn\" multiplier=\"0.25\" "
      "offset=\"0.125\"/></joint>\n"
      "<link name=\"tip\"><collision name=\"pad\"><origin xyz=\"0 0 0.5\"/>"
      "<geometry><sphere radius=\"0.25\"/></geometry></collision></link>\n");
}

class UrdfTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Urdf urdf;
    std::string error;
    if (!ParseUrdf(Robot("<link name=\"a\"/>"), "a.urdf", &urdf, &error)) {
      GTEST_SKIP() << "built without tinyxml2: " << error;
    }
  }
  static Urdf Parse(const std::string& text) {
    Urdf urdf;
    std::string error;
    EXPECT_TRUE(ParseUrdf(text, "r.urdf", &urdf, &error)) << error;
    return urdf;
  }
  static std::string Error(const std::string& text) {
    Urdf urdf;
    urdf.name = "untouched";
    std::string error;
    EXPECT_FALSE(ParseUrdf(text, "r.urdf", &urdf, &error)) << text;
    EXPECT_EQ(urdf.name, "untouched");
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }
};

TEST_F(UrdfTest, AnglesTurnAboutFixedAxesRollFirst) {
  const Vector3d rpy(0.3, -0.5, 1.1);
  const Eigen::Matrix3d expected = (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
                                       .toRotationMatrix();
  EXPECT_LT((RotationOfRpy(rpy) - expected).norm(), 1e-15);
  EXPECT_TRUE(RotationOfRpy(Vector3d::Zero()).isIdentity(0.0));
}

TEST_F(UrdfTest, JointsMoveTheLinksBelowThem) {
  const Urdf arm = Parse(Arm());
  std::vector<UrdfPose> poses;
  std::string error;
  const UrdfPose base{Eigen::Matrix3d::Identity(), Vector3d(0, 0, 10)};
  ASSERT_TRUE(UrdfPoses(arm, {{"turn", kPi / 2}, {"bend", kPi / 2}}, base, &poses, &error))
      << error;
  // The upper link along y; the lower one bent down by 90 degrees.
  EXPECT_LT((poses[arm.FindLink("lower")].translation - Vector3d(0, 2, 10)).norm(), 1e-15);
  // The slide follows the turn: 0.125 + pi/8 along the tip's x axis, which is the lower link's y,
  // that is -x now.
  const double slide = 0.125 + kPi / 8;
  const UrdfPose& tip = poses[arm.FindLink("tip")];
  EXPECT_LT((tip.translation - Vector3d(-slide, 2, 9)).norm(), 1e-15);
  EXPECT_LT((tip.rotation * Vector3d::UnitX() - Vector3d(-1, 0, 0)).norm(), 1e-15);
}

TEST_F(UrdfTest, MistakesAreOneLineWithFileLineAndElement) {
  const std::string link = "<link name=\"a\"/>\n<link name=\"b\"/>\n";
  const auto joint = [](const std::string& attributes, const std::string& body) {
    return "<joint name=\"j\" " + attributes + ">" + body + "</joint>\n";
  };
  const std::string ends = "<parent link=\"a\"/><child link=\"b\"/>";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "r.urdf:0: file: found no XML"},
      {"<robot>", "r.urdf:1: file: found no XML"},
      {"<xacro/>", "r.urdf:1: file: found <xacro>; allowed <robot>"},
      {Robot(""), "<robot>: found no <link>"},
      {Robot("<link/>"), "r.urdf:2: <link>: found no name"},
      {Robot("<link name=\"a\"/>\n<link name=\"a\"/>"),
       "r.urdf:3: <link name='a'>: found a second"},
      {Robot(link), "r.urdf:3: <link name='b'>: found a second link without a parent, after 'a'"},
      {Robot(link + joint("type=\"floating\"", ends)), "r.urdf:4: <joint name='j'>: found type="},
      {Robot(link + joint("type=\"revolute\"", ends)), "found no <limit>"},
      {Robot(link + joint("type=\"fixed\"", "<child link=\"b\"/>")), "found no <parent link"},
      {Robot(link + joint("type=\"fixed\"", "<parent link=\"a\"/><child link=\"bb\"/>")),
       "found link='bb', which is no link"},
      {Robot(link + joint("type=\"fixed\"", ends + "<origin xyz=\"0 0\"/>")),
       "r.urdf:4: <origin>: found xyz='0 0'; allowed xyz=\"3 numbers\""},
      {Robot(link + joint("type=\"fixed\"", ends + "<origin xyz=\"0 0 nan\"/>")), "found xyz="},
      {Robot(link + joint("type=\"fixed\"", ends + "<origin rpy=\"0 0 1e999\"/>")), "found rpy="},
      {Robot(link + joint("type=\"continuous\"", ends + "<axis xyz=\"0 0 0\"/>")),
       "found an axis of length zero"},
      {Robot(link + joint("type=\"prismatic\"", ends + "<limit lower=\"2\" upper=\"1\"/>")),
       "found lower above upper"},
      {Robot(link + joint("type=\"continuous\"", ends + "<mimic joint=\"k\"/>")),
       "found joint='k'"},
      {Robot(link + joint("type=\"fixed\"", ends) +
             "<joint name=\"k\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint>\n"),
       "joints in a circle"},
      {Robot(link + joint("type=\"fixed\"", ends) +
             "<joint name=\"k\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n"),
       "found a second parent of link 'b', after joint 'j'"},
      {Robot("<link name=\"a\"><collision/></link>"), "found no <geometry>"},
      {Robot("<link name=\"a\"><collision><geometry><cone/></geometry></collision></link>"),
       "found <cone>; allowed one of <box>"},
      {Robot("<link name=\"a\"><collision><geometry><sphere radius=\"-1\"/></geometry>"
             "</collision></link>"),
       "found radius='-1'"},
      {Robot("<link name=\"a\"><visual><geometry><mesh/></geometry></visual></link>"),
       "found no filename"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(Error(text), HasSubstr(message)) << text;
}

TEST_F(UrdfTest, DeeplyNestedAndTruncatedFilesAreErrors) {
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<robot>";
  Error(deep);
  const std::string arm = Arm();
  for (size_t length = 0; length + 10 < arm.size(); length += 7) Error(arm.substr(0, length));
}

// A chain as long as a file may make it.
TEST_F(UrdfTest, LongChainsTakeTimeInProportion) {
  std::string body = "<link name=\"l0\"/>\n";
  for (int i = 1; i < 20000; ++i) {
    const std::string a = std::to_string(i - 1), b = std::to_string(i);
    body += "<link name=\"l" + b + "\"/><joint name=\"j" + b +
            "\" type=\"fixed\"><parent link=\"l" + a + "\"/><child link=\"l" + b +
            "\"/><origin xyz=\"1 0 0\"/></joint>\n";
  }
  const Urdf chain = Parse(Robot(body));
  std::vector<UrdfPose> poses;
  std::string error;
  ASSERT_TRUE(UrdfPoses(chain, {}, UrdfPose(), &poses, &error)) << error;
  EXPECT_EQ(poses.back().translation, Vector3d(19999, 0, 0));
}

TEST_F(UrdfTest, ValuesOfJointsAreChecked) {
  const Urdf arm = Parse(Arm());
  const auto error_of = [&arm](const std::map<std::string, double>& values) {
    std::vector<UrdfPose> poses;
    std::string error;
    EXPECT_FALSE(UrdfPoses(arm, values, UrdfPose(), &poses, &error));
    return error;
  };
  EXPECT_EQ(error_of({{"bent", 0.5}}),
            "joint 'bent': found no such joint; allowed turn | bend; did you mean 'bend'?");
  EXPECT_EQ(error_of({{"bend", 1.7}}), "joint 'bend': found 1.7; allowed a number in [-1, 1.6]");
  EXPECT_EQ(error_of({{"slide", 0.1}}),
            "joint 'slide': found 0.1; allowed nothing: it follows joint 'turn'");
  EXPECT_EQ(error_of({{"turn", 4}}), "joint 'slide': found 1.125; allowed a number in [0, 0.75]");
}

// ---- In scenes --------------------------------------------------------------------------------

constexpr char kSphere[] =
    "name: s\nsurface: {kind: icosphere, radius: 20, frequency: 4}\n"
    "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\n";

class HandSceneTest : public UrdfTest {
 protected:
  void SetUp() override {
    UrdfTest::SetUp();
    folder_ = ::testing::TempDir();
  }
  std::string Write(const std::string& name, const std::string& text) {
    const std::string file = folder_ + name;
    FILE* const stream = std::fopen(file.c_str(), "wb");
    std::fwrite(text.data(), 1, text.size(), stream);
    std::fclose(stream);
    return file;
  }
  static Scene Read(const std::string& text) {
    Scene scene;
    std::string error;
    EXPECT_TRUE(ParseScene(text, "s.yaml", &scene, &error)) << error;
    return scene;
  }
  static std::string SceneError(const std::string& text) {
    Scene scene;
    std::string error;
    EXPECT_FALSE(ParseScene(text, "s.yaml", &scene, &error));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }
  static void ExpectSame(const FingerSpec& a, const FingerSpec& b) {
    EXPECT_EQ(a.shape, b.shape);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.length, b.length);
    EXPECT_EQ(a.half_sizes, b.half_sizes);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.direction, b.direction);
    EXPECT_EQ(a.axis, b.axis);
    EXPECT_EQ(a.travel, b.travel);
    EXPECT_EQ(a.force, b.force);
    EXPECT_EQ(a.friction, b.friction);
    ASSERT_EQ(a.mesh == nullptr, b.mesh == nullptr);
    if (a.mesh == nullptr) return;
    EXPECT_EQ(a.mesh->vertices, b.mesh->vertices);
    EXPECT_EQ(a.mesh->triangles, b.mesh->triangles);
  }
  std::string folder_;
};

// A hand of one link with a shape of each kind, half a metre up.
std::string Shapes() {
  return Robot(
      "<link name=\"palm\"/>\n<joint name=\"j\" type=\"prismatic\"><parent link=\"palm\"/>"
      "<child link=\"tip\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"1\"/></joint>\n"
      "<link name=\"tip\">\n"
      "<collision name=\"ball\"><origin xyz=\"0.25 0 0\"/><geometry><sphere radius=\"0.5\"/>"
      "</geometry></collision>\n"
      "<collision name=\"pill\"><geometry><capsule radius=\"0.5\" length=\"2\"/></geometry>"
      "</collision>\n"
      "<collision name=\"block\"><geometry><box size=\"1 2 4\"/></geometry></collision>\n"
      "<collision name=\"rod\"><geometry><cylinder radius=\"0.5\" length=\"2\"/></geometry>"
      "</collision>\n"
      "<collision name=\"shape\"><geometry><mesh filename=\"hand_tip.obj\" scale=\"2 2 2\"/>"
      "</geometry></collision>\n"
      "</link>\n");
}

TEST_F(HandSceneTest, LinksAreFingersAsIfWrittenByHand) {
  Write("hand_tip.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  Write("hand_tip_twice.obj",
        "v 0 0 0\nv 8 0 0\nv 0 8 0\nv 0 0 8\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string file = Write("hand.urdf", Shapes());
  const std::string hand = std::string(kSphere) + "hand: {file: " + file +
                           ", scale: 4, pose: {xyz: [0, 0, 60]}, joints: {j: 0.5}}\nfingers:\n";
  const std::string rest = ", direction: [0, 0, -2], motion: {travel: 1}, friction: 0.25}\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"ball", "{kind: sphere, radius: 2}, position: [1, 0, 62]"},
      {"pill", "{kind: capsule, radius: 2, length: 8, axis: [0, 0, 1]}, position: [0, 0, 62]"},
      {"block", "{kind: box, half_sizes: [2, 4, 8], axis: [1, 0, 0]}, position: [0, 0, 62]"},
      {"shape", "{kind: mesh, file: " + folder_ + "hand_tip_twice.obj}, position: [0, 0, 62]"}};
  for (const auto& [element, written] : cases) {
    SCOPED_TRACE(element);
    std::string by_hand = written;
    if (element == "shape") {  // 4 * 2 = 8 times the file; the other is twice it
      Write("hand_tip_twice.obj",
            "v 0 0 0\nv 32 0 0\nv 0 32 0\nv 0 0 32\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    }
    const Scene a = Read(hand + "  - {name: f, shape: {kind: link, link: tip, element: " + element +
                         "}" + rest);
    const Scene b = Read(std::string(kSphere) + "fingers:\n  - {name: f, shape: " + by_hand + rest);
    ASSERT_EQ(a.fingers.size(), 1u);
    ASSERT_EQ(b.fingers.size(), 1u);
    ExpectSame(a.fingers[0], b.fingers[0]);
  }
}

TEST_F(HandSceneTest, PosesAndDirectionsTurnWithTheHand) {
  const std::string file = Write("arm.urdf", Arm());
  const auto read = [&](const std::string& pose, const std::string& in) {
    return Read(std::string(kSphere) + "hand: {file: " + file + ", scale: 10, pose: {" + pose +
                "}, joints: {bend: pi/2}}\nfingers: [{name: f, shape: {kind: link, link: tip}, "
                "direction: [0, 0, 1], direction_in: " +
                in + ", motion: {travel: 1}}]\n")
        .fingers[0];
  };
  // The tip, bent down: its z axis is x of the arm; the pad half a metre along it.
  FingerSpec f = read("xyz: [0, 0, 50]", "link");
  const auto vector = [](const std::array<double, 3>& v) { return Vector3d(v[0], v[1], v[2]); };
  EXPECT_LT((vector(f.position) - Vector3d(25, 1.25, 40)).norm(), 1e-13);
  EXPECT_LT((vector(f.direction) - Vector3d(1, 0, 0)).norm(), 1e-15);
  f = read("xyz: [0, 0, 50], rpy: [0, 0, pi/2]", "link");
  EXPECT_LT((vector(f.position) - Vector3d(-1.25, 25, 40)).norm(), 1e-13);
  EXPECT_LT((vector(f.direction) - Vector3d(0, 1, 0)).norm(), 1e-15);
  const double s = std::sqrt(0.5);
  f = read(
      "xyz: [0, 0, 50], quaternion: [" + std::to_string(s) + ", 0, 0, " + std::to_string(s) + "]",
      "hand");
  EXPECT_LT((vector(f.position) - Vector3d(-1.25, 25, 40)).norm(), 1e-4);
  EXPECT_LT((vector(f.direction) - Vector3d(0, 0, 1)).norm(), 1e-15);
  f = read("rpy: [pi, 0, 0]", "scene");
  EXPECT_EQ(vector(f.direction), Vector3d(0, 0, 1));
}

TEST_F(HandSceneTest, CylindersAndTurnedBoxesAreClosedMeshes) {
  std::string error;
  const auto cylinder = MakeMeshFinger(MakeCylinderMesh(2, 5, 96), &error);
  ASSERT_NE(cylinder, nullptr) << error;
  Distance d;
  ASSERT_TRUE(cylinder->Evaluate({4, 0, 0}, &d));
  EXPECT_NEAR(d.value, 2.0, 2 * 2.0 * (1 - std::cos(kPi / 96)));
  ASSERT_TRUE(cylinder->Evaluate({0.1, 0.2, 3.5}, &d));
  EXPECT_NEAR(d.value, 1.0, 1e-14);
  const auto box = MakeMeshFinger(MakeBoxMesh({1, 2, 3}), &error);
  ASSERT_NE(box, nullptr) << error;
  ASSERT_TRUE(box->Evaluate({0, 3, 0}, &d));
  EXPECT_NEAR(d.value, 1.0, 1e-15);
  const std::string file = Write("hand.urdf", Shapes());
  const Scene scene = Read(std::string(kSphere) + "hand: {file: " + file +
                           ", scale: 4, pose: {xyz: [0, 0, 60], rpy: [0.2, 0, 0]}}\nfingers: "
                           "[{name: f, shape: {kind: link, link: tip, element: block}, direction: "
                           "[0, 0, -1], motion: {travel: 1}}]\n");
  ASSERT_EQ(scene.fingers[0].shape, FingerSpec::Shape::kMesh);
  EXPECT_NE(MakeMeshFinger(*scene.fingers[0].mesh, &error), nullptr) << error;
}

TEST_F(HandSceneTest, MistakesNameTheKeyOfTheScene) {
  const std::string file = Write("hand.urdf", Shapes());
  const std::string hand = std::string(kSphere) + "hand: {file: " + file + "}\n";
  const auto finger = [](const std::string& shape, const std::string& more = "") {
    return "fingers: [{name: f, shape: {kind: link, " + shape +
           "}, direction: [0, 0, -1], motion: {travel: 1}" + more + "}]\n";
  };
  EXPECT_THAT(SceneError(std::string(kSphere) + finger("link: tip")),
              HasSubstr("s.yaml:4: fingers[0].shape: found a link without a hand"));
  EXPECT_THAT(SceneError(hand + finger("link: tipp, element: ball")),
              HasSubstr("did you mean 'tip'?"));
  EXPECT_THAT(SceneError(hand + finger("link: tip")),
              HasSubstr("5 of <collision>; allowed the key element beside it: ball | pill"));
  EXPECT_THAT(SceneError(hand + finger("link: tip, element: 5")), HasSubstr("element: found '5'"));
  EXPECT_THAT(SceneError(hand + finger("link: palm")), HasSubstr("without a <collision>"));
  EXPECT_THAT(SceneError(hand + finger("link: tip, element: 0", ", position: [0, 0, 1]")),
              HasSubstr("found a position of a link"));
  EXPECT_THAT(SceneError(std::string(kSphere) + "hand: {file: " + file + ", joints: {j: 2}}\n"),
              HasSubstr("hand.joints: joint 'j': found 2; allowed a number in [0, 1]"));
  EXPECT_THAT(SceneError(std::string(kSphere) + "hand: {file: no_such.urdf}\n"),
              HasSubstr("hand.file: no_such.urdf:0: found a file that cannot be read"));
  EXPECT_THAT(
      SceneError(std::string(kSphere) +
                 "fingers: [{name: f, shape: {kind: sphere, radius: 1}, position: [0, 0, 40], "
                 "direction: [0, 0, -1], direction_in: link, motion: {travel: 1}}]\n"),
      HasSubstr("direction_in of a shape that is no link"));
}

TEST_F(HandSceneTest, PackagesAreFoundAboveTheFileOrWhereTheSceneSays) {
  std::string error;
  const std::string file = Write("hand.urdf", Shapes());
  EXPECT_EQ(ResolveUrdfMesh("meshes/a.stl", "x/hand.urdf", {}, &error), "x/meshes/a.stl");
  EXPECT_EQ(ResolveUrdfMesh("file:///a/b.stl", "x/hand.urdf", {}, &error), "/a/b.stl");
  EXPECT_EQ(ResolveUrdfMesh("package://p/m/a.stl", "x/hand.urdf", {{"p", "y"}}, &error),
            "y/m/a.stl");
  const std::string data = DARBOUX_DATA_DIR;
  EXPECT_EQ(ResolveUrdfMesh("package://data/gripper_tip.stl", data + "/gripper.urdf", {}, &error),
            data + "/gripper_tip.stl");
  EXPECT_EQ(ResolveUrdfMesh("package://none/a.stl", file, {}, &error), "");
  EXPECT_THAT(error, HasSubstr("no folder 'none'"));
  EXPECT_EQ(ResolveUrdfMesh("http://a.stl", file, {}, &error), "");
}

}  // namespace
}  // namespace darboux
