// The tool as its users meet it: command line in, exit status and files out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;

// A pebble that a fingertip dents, and whose far side is clamped; mm.
constexpr char kScene[] = R"(name: pebble
surface: {kind: mesh, file: pebble.obj}
shell: {thickness: 1, young_modulus: 5, poisson_ratio: 0.4}
supports: [{on: {near: [-50, 0, 0], radius: 25}, fix: [x, y, z]}]
fingers:
  - {name: tip, shape: {kind: sphere, radius: 8}, position: [70, 5, 3], direction: [-1, 0, 0], motion: {travel: 2}}
)";

class DarbouxFitTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder("darboux_fit_test");
    TriangleMesh mesh = MakeIcosphere(50.0, 4);
    for (Vector3d& x : mesh.vertices) {
      x = x.cwiseProduct(Vector3d(1.0, 0.8, 0.6));
      x.y() += 0.004 * x.x() * x.x();
      x.z() += 0.002 * x.x() * x.y();
    }
    std::string error;
    ASSERT_TRUE(WriteObj(Path("pebble.obj"), mesh, &error)) << error;
    std::ofstream(Path("pebble.yaml")) << kScene;
    Scene scene;
    ASSERT_TRUE(ReadScene(Path("pebble.yaml"), &scene, &error)) << error;
    std::unique_ptr<ShellProblem> problem;
    SolverSummary summary;
    ASSERT_TRUE(Solve(scene, SolverOptions(), &problem, &summary, &error)) << error;
    ASSERT_TRUE(summary.IsConverged()) << summary.message;
    ShellFace face(problem->surface(), 0.5);
    face.SetDisplacements(problem->displacements());
    std::mt19937_64 generator(7);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    PointCloud cloud;
    RigidPose pose;
    pose.rotation = Eigen::Quaterniond(0.5, 0.5, -0.3, 0.6).normalized();
    pose.translation = Vector3d(20.0, 30.0, 500.0);
    for (int k = 0; k < 1500; ++k) {
      double s = uniform(generator), t = uniform(generator);
      if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
      const ShellFace::Foot foot =
          face.Evaluate({static_cast<int>(generator() % problem->surface().num_elements()), s, t});
      const double noise = 0.1 * (uniform(generator) + uniform(generator) - 1.0);
      cloud.points.push_back(pose * (foot.position + noise * foot.normal));
    }
    ASSERT_TRUE(WritePointCloud(Path("scan.csv"), cloud, {}, &error)) << error;
    for (Vector3d& x : cloud.points) x *= 1000.0;
    ASSERT_TRUE(WritePointCloud(Path("scan_um.csv"), cloud, {}, &error)) << error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Path(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string Read(const std::string& name) { return ReadFile(Path(name)); }
  static CommandOutcome Run(const std::string& arguments) {
    return RunCommand(folder_->path(), DARBOUX_FIT " " + arguments + " --threads=1 --quiet");
  }

  static TemporaryFolder* folder_;
};
TemporaryFolder* DarbouxFitTest::folder_ = nullptr;

TEST_F(DarbouxFitTest, RegistersAScanOfTheComputedShape) {
  const CommandOutcome outcome = Run(Path("pebble.yaml") + " --scan=" + Path("scan.csv") +
                                     " --mode=register --out=" + Path("registered"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(Read("registered/fit.json"));
  EXPECT_TRUE(json["converged"].get<bool>());
  EXPECT_EQ(json["all"]["count"], 1500);
  // Noise between -0.1 and 0.1.
  EXPECT_NEAR(json["all"]["rms"].get<double>(), 0.1 / std::sqrt(6.0), 0.005);
  EXPECT_LT(json["all"]["max"].get<double>(), 0.12);
  EXPECT_EQ(json["registration"]["equivalent_poses"], 0);
  EXPECT_THAT(Read("registered/shell.vtu"), HasSubstr("Name=\"scan_distance\""));
  EXPECT_THAT(Read("registered/shell.vtu"), HasSubstr("Name=\"scan_coverage\""));
  EXPECT_TRUE(fs::exists(Path("registered/deformed.ply")));
  PointCloud moved;
  std::string error;
  EXPECT_TRUE(ReadPointCloud(Path("registered/scan_registered.ply"), &moved, &error)) << error;
  EXPECT_EQ(moved.points.size(), 1500u);
}

TEST_F(DarbouxFitTest, FitsADentThatNoFingerIsKnownOf) {
  const CommandOutcome outcome = Run(Path("pebble.yaml") + " --scan=" + Path("scan.csv") +
                                     " --fingers=none --out=" + Path("fitted"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json json = Json::parse(Read("fitted/fit.json"));
  EXPECT_TRUE(json["converged"].get<bool>());
  EXPECT_EQ(json["fingers"], "none");
  EXPECT_NEAR(json["inliers"]["rms"].get<double>(), 0.1 / std::sqrt(6.0), 0.008);
  EXPECT_GT(json["max_displacement"].get<double>(), 1.0);
  EXPECT_GT(json["weight"].get<double>(), 0.0);
}

TEST_F(DarbouxFitTest, AScanInAnotherUnitIsNoMatch) {
  const CommandOutcome outcome = Run(Path("pebble.yaml") + " --scan=" + Path("scan_um.csv") +
                                     " --mode=register --against=rest --out=" + Path("unit"));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("1000 times larger"));
  EXPECT_FALSE(Json::parse(Read("unit/fit.json"))["converged"].get<bool>());
}

TEST_F(DarbouxFitTest, BadInputIsOneLineAndNoFiles) {
  const std::string scene = Path("pebble.yaml"), out = " --out=" + Path("none");
  for (const std::string& arguments :
       {scene + out,
        scene + out + " --scan=" + Path("missing.csv"),
        scene + out + " --scan=" + Path("scan.csv") + " --mode=fix",
        scene + out + " --scan=" + Path("scan.csv") + " --noise=-1"}) {
    const CommandOutcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr("found")) << arguments;
  }
  EXPECT_FALSE(fs::exists(Path("none")));
}

}  // namespace
}  // namespace darboux
