#include "solver/named_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "geometry/icosphere.h"
#include "solver/calibration_reader.h"
#include "solver/scene_reader.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

constexpr char kScene[] =
    "name: ball\n"
    "surface: {kind: mesh, file: <ball>, fit: interpolate}\n"
    "shell: {thickness: 0.1, young_modulus: 1, poisson_ratio: 0.3}\n"
    "fingers:\n"
    "  - {name: top, shape: {kind: mesh, file: <tip>}, position: [0, 0, 2], direction: [0, 0, "
    "-1],\n"
    "     motion: {travel: 0.1}}\n";

class NamedDataTest : public ::testing::Test {
 protected:
  NamedDataTest() {
    data_.meshes["<ball>"] = MakeIcosphere(1.0, 2);
    data_.meshes["<tip>"] = MakeIcosphere(0.1, 1);
    options_.data = &data_;
  }

  NamedData data_;
  ReadOptions options_;
  Scene scene_;
  std::string error_;
};

TEST_F(NamedDataTest, MeshesInMemoryStandForFiles) {
  ASSERT_TRUE(ParseScene(kScene, "scene", &scene_, &error_, options_)) << error_;
  EXPECT_EQ(scene_.surface.mesh->vertices.size(), data_.meshes["<ball>"].vertices.size());
  EXPECT_EQ(scene_.surface.mesh->triangles, data_.meshes["<ball>"].triangles);
  ASSERT_EQ(scene_.fingers.size(), 1u);
  EXPECT_EQ(scene_.fingers[0].mesh->triangles, data_.meshes["<tip>"].triangles);
}

TEST_F(NamedDataTest, TheyAreCheckedAsFilesAre) {
  TriangleMesh& ball = data_.meshes["<ball>"];
  ball.triangles[1] = ball.triangles[0];
  EXPECT_FALSE(ParseScene(kScene, "scene", &scene_, &error_, options_));
  EXPECT_THAT(error_, HasSubstr("scene:2: surface.file: found <ball>: "));
}

TEST_F(NamedDataTest, OtherNamesAreFiles) {
  data_.meshes.erase("<tip>");
  EXPECT_FALSE(ParseSceneIn("folder", kScene, "scene", &scene_, &error_, options_));
  EXPECT_THAT(error_, HasSubstr("fingers[0].shape.file: found folder/<tip>"));
}

TEST_F(NamedDataTest, CalibrationsTakeScenesAndPointsFromMemory) {
  ASSERT_TRUE(ParseScene(kScene, "scene", &scene_, &error_, options_)) << error_;
  data_.scenes["<grasp>"] = scene_;
  for (const Eigen::Vector3d& x : data_.meshes["<ball>"].vertices) {
    data_.clouds["<scan>"].points.push_back(x);
  }
  constexpr char kCalibration[] =
      "{name: ball, parameters: {young_modulus: {}}, grasps: [{scene: <grasp>, scans: [<scan>],\n"
      "  forces: [{finger: top, value: 1, error: 0.1}]}]}";
  CalibrationSpec spec;
  ASSERT_TRUE(ParseCalibration(kCalibration, "calibration", "", &spec, &error_, &data_)) << error_;
  ASSERT_EQ(spec.grasps.size(), 1u);
  EXPECT_EQ(spec.grasps[0].scene.name, "ball");
  ASSERT_EQ(spec.grasps[0].scans.size(), 1u);
  EXPECT_EQ(spec.grasps[0].scans[0].cloud.points, data_.clouds["<scan>"].points);
  EXPECT_FALSE(ParseCalibration(kCalibration, "calibration", "", &spec, &error_));
  EXPECT_THAT(error_, HasSubstr("calibration:1: grasps[0].scene: found '<grasp>'"));
}

}  // namespace
}  // namespace darboux
