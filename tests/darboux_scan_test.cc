// The tool as its users meet it: command line in, exit status and files out.

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/rigid_pose.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/tool_util.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kPlate[] = R"(name: clamped-plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
)";

// A plate under a ball, pushed in by twice the thickness in two steps.
constexpr char kFinger[] = R"(name: plate-under-finger
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [10, 10]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: rim, clamped: true}]
fingers:
  - {name: top, shape: {kind: sphere, radius: 20}, position: [50, 50, 40], direction: [0, 0, -1], motion: {travel: 2}}
steps: 2
)";

class DarbouxScanTest : public ToolTest {
 protected:
  DarbouxScanTest() : ToolTest(DARBOUX_SCAN) {
    common_ = {OutFlag(), "--points=500", "--threads=1"};  // unless told otherwise
  }
  void SetUp() override {
    plate_ = Write("plate.yaml", kPlate);
    sphere_ = Path("sphere.obj");
    std::string error;
    ASSERT_TRUE(WriteObj(sphere_, MakeIcosphere(10.0, 8), &error)) << error;
  }
  Json Truth() const { return Json::parse(ReadFile(Out() / "truth.json"), nullptr, false); }

  PointCloud Cloud(const std::string& name) const {
    PointCloud cloud;
    std::string error;
    EXPECT_TRUE(ReadPointCloud((Out() / name).string(), &cloud, &error)) << error;
    return cloud;
  }

  RigidPose Pose(const char* name) const {
    const Json json = Truth()[name];
    const auto q = json["quaternion_wxyz"].get<std::vector<double>>();
    const auto t = json["translation"].get<std::vector<double>>();
    return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), Vector3d(t[0], t[1], t[2])};
  }

  std::string plate_, sphere_;
};

TEST_F(DarbouxScanTest, AScanWithoutErrorsIsTheOuterFaceOfTheSolution) {
  ASSERT_EQ(Run({plate_, "--noise=0", "--motion=none", "--points=4000", "--normals"}), 0)
      << Stderr();
  EXPECT_EQ(FilesIn(Out()), (std::set<std::string>{"scan.csv", "truth.csv", "truth.json"}));
  const PointCloud scan = Cloud("scan.csv"), truth = Cloud("truth.csv");
  ASSERT_EQ(scan.points.size(), 4000u);
  ASSERT_EQ(scan.normals.size(), 4000u);
  EXPECT_EQ(scan.points, truth.points);
  // Half the thickness above the deflection, 0.13817 in the middle, 0 at the rim.
  double highest = 0.0;
  for (const Vector3d& x : scan.points) {
    highest = std::max(highest, x.z());
    EXPECT_GT(x.z(), 0.5 - 1e-4);  // In the corners these cells are coarse.
    if (std::min({x.x(), x.y(), 100 - x.x(), 100 - x.y()}) < 0.5) {
      EXPECT_LT(x.z(), 0.502);
    }
  }
  EXPECT_NEAR(highest, 0.63817, 5e-4);
  const Json json = Truth();
  EXPECT_EQ(json["thickness"], 1.0);
  EXPECT_EQ(json["solution"]["name"], "clamped-plate");
  EXPECT_EQ(json["solution"]["theory"], "linear");
  EXPECT_EQ(json["options"]["noise"], 0.0);
  EXPECT_THAT(Stdout(), HasSubstr("plate.yaml: 4000 points"));
}

TEST_F(DarbouxScanTest, TheFingersHideWhatTheyTouchAndTheirForcesAreToldByTheTruth) {
  const std::string scene = Write("finger.yaml", kFinger);
  ASSERT_EQ(Run({scene, "--noise=0", "--motion=none", "--points=4000"}), 0) << Stderr();
  Json solution = Truth()["solution"];
  EXPECT_EQ(solution["state"], 2);
  EXPECT_EQ(solution["states"], 2);
  Json finger = solution["fingers"]["top"];
  EXPECT_NEAR(finger["travel"].get<double>(), 2.0, 1e-12);
  EXPECT_GT(finger["normal_force"].get<double>(), 0.0);
  EXPECT_NEAR(finger["shift"].get<double>(), 19.5, 1e-6);
  const double force = finger["normal_force"].get<double>();
  // The finger's lowest point is at the height 0.5 - 2. Nothing scanned lies inside it, and
  // nothing lies where it covers the plate: seen from viewpoints at 35 degrees above the plate on
  // all sides, that is about its contact and little more.
  const Vector3d center(50, 50, 18.5);
  double nearest = 100.0;
  for (const Vector3d& x : Cloud("scan.csv").points) {
    EXPECT_GT((x - center).norm(), 20.0 - 1e-3);
    nearest = std::min(nearest, std::hypot(x.x() - 50.0, x.y() - 50.0));
  }
  EXPECT_GT(nearest, 1.0);
  EXPECT_LT(nearest, 15.0);
  // The state before.
  ASSERT_EQ(Run({scene, "--noise=0", "--state=1"}), 0) << Stderr();
  finger = Truth()["solution"]["fingers"]["top"];
  EXPECT_EQ(Truth()["solution"]["state"], 1);
  EXPECT_NEAR(finger["travel"].get<double>(), 1.0, 1e-12);
  EXPECT_LT(finger["normal_force"].get<double>(), force);
  EXPECT_EQ(Run({scene, "--noise=0", "--state=3"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--state: found '3'; allowed 1 to 2, or 0 for the last"));
}

TEST_F(DarbouxScanTest, WhatHasNotConvergedIsNotScanned) {
  const std::string scene = Write("finger.yaml", kFinger);
  EXPECT_EQ(Run({scene, "--noise=0", "--max_iterations=1"}), 1);
  EXPECT_THAT(Stderr(), HasSubstr("not converged, nothing is scanned"));
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(DarbouxScanTest, AnInterruptedSolutionIsNotScanned) {
  std::string text = kFinger;
  text.replace(text.find("steps: 2"), 8, "steps: 5000");
  const std::string scene = Write("long.yaml", text);
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t pid = Start({scene, "--noise=0"});
    for (int i = 0; i < 6000 && Stderr().find("step 1/") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_EQ(kill(pid, signal), 0);
    EXPECT_EQ(Wait(pid), 1);
    EXPECT_THAT(Stderr(), HasSubstr("nothing is scanned"));
    EXPECT_FALSE(fs::exists(Out()));
  }
}

TEST_F(DarbouxScanTest, ThePoseOfTheTruthBringsTheScanToTheModel) {
  ASSERT_EQ(Run({sphere_, "--noise=0"}), 0) << Stderr();
  const PointCloud scan = Cloud("scan.csv"), truth = Cloud("truth.csv");
  const RigidPose pose = Pose("model_from_scan"), back = Pose("scan_from_model");
  double moved = 0.0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    EXPECT_LT((pose * scan.points[i] - truth.points[i]).norm(), 1e-12);
    EXPECT_LT((back * truth.points[i] - scan.points[i]).norm(), 1e-12);
    moved = std::max(moved, (truth.points[i] - scan.points[i]).norm());
  }
  EXPECT_GT(moved, 1.0);
  EXPECT_TRUE(Truth()["solution"].is_null());
}

TEST_F(DarbouxScanTest, TheDefaultNoiseHasTheUnitOfTheScene) {
  EXPECT_EQ(Run({sphere_}), 2);
  EXPECT_THAT(Stderr(),
              HasSubstr("--unit: found no unit of length, which the default noise of 0.127 mm "
                        "needs; allowed --unit=um | mm | cm | m | in, or --noise=LENGTH"));
  EXPECT_FALSE(fs::exists(Out()));
  const std::vector<std::pair<std::string, double>> units = {
      {"um", 127.0}, {"mm", 0.127}, {"cm", 0.0127}, {"m", 1.27e-4}, {"in", 0.005}};
  for (const auto& [unit, noise] : units) {
    ASSERT_EQ(Run({sphere_, "--unit=" + unit}), 0) << Stderr();
    EXPECT_NEAR(Truth()["options"]["noise"].get<double>(), noise, 1e-15 * noise * 10.0);
  }
}

TEST_F(DarbouxScanTest, OutliersAndNoiseAreToldPointByPoint) {
  ASSERT_EQ(Run({sphere_,
                 "--noise=0.1",
                 "--outliers=0.1",
                 "--spike_share=0.6",
                 "--bias=0.02",
                 "--bias_along=ray",
                 "--points=2000"}),
            0)
      << Stderr();
  EXPECT_EQ(Truth()["spikes"], 120);
  EXPECT_EQ(Truth()["strays"], 80);
  std::istringstream lines(ReadFile(Out() / "truth.csv"));
  std::string line;
  std::vector<std::vector<double>> rows;
  while (std::getline(lines, line)) {
    if (line[0] == '#' || line[0] == 'x') continue;
    std::istringstream words(line);
    rows.emplace_back();
    for (std::string word; std::getline(words, word, ',');) rows.back().push_back(std::stod(word));
    ASSERT_EQ(rows.back().size(), 7u);
  }
  const PointCloud scan = Cloud("scan.csv");
  ASSERT_EQ(rows.size(), scan.points.size());
  const RigidPose pose = Pose("model_from_scan");
  std::vector<int> kinds(3, 0);
  double squares = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ++kinds[static_cast<std::size_t>(rows[i][3])];
    const Vector3d face(rows[i][0], rows[i][1], rows[i][2]);
    const double d = (pose * scan.points[i] - face).norm();
    if (rows[i][3] == 0.0) {
      EXPECT_NEAR(d, std::abs(rows[i][5] + rows[i][6]), 1e-12);
    }
    squares += rows[i][5] * rows[i][5];
    EXPECT_EQ(rows[i][4] < 0.0, rows[i][3] == 2.0);
  }
  EXPECT_EQ(kinds, (std::vector<int>{1800, 120, 80}));
  EXPECT_NEAR(squares / (0.01 * 1920), 1.0, 4.0 * std::sqrt(2.0 / 1920));
}

TEST_F(DarbouxScanTest, TheSameSeedGivesTheSameBytes) {
  const std::vector<std::string> flags = {
      sphere_, "--noise=0.1", "--bias=0.1", "--outliers=0.1", "--seed=7"};
  ASSERT_EQ(Run(flags), 0);
  const std::string scan = ReadFile(Out() / "scan.csv"), truth = ReadFile(Out() / "truth.csv"),
                    json = ReadFile(Out() / "truth.json");
  ASSERT_EQ(Run(flags), 0);
  EXPECT_EQ(ReadFile(Out() / "scan.csv"), scan);
  EXPECT_EQ(ReadFile(Out() / "truth.csv"), truth);
  EXPECT_EQ(ReadFile(Out() / "truth.json"), json);
  ASSERT_EQ(Run({sphere_, "--noise=0.1", "--bias=0.1", "--outliers=0.1", "--seed=8"}), 0);
  EXPECT_NE(ReadFile(Out() / "scan.csv"), scan);
  // Everything it was made with is on top.
  for (const char* line : {"# seed: 7\n",
                           "# points: 500\n",
                           "# noise: 0.1\n",
                           "# bias: 0.1\n",
                           "# outliers: 0.1\n",
                           "# views: 8\n",
                           "# grazing: 75.0\n"}) {
    EXPECT_THAT(scan, HasSubstr(line));
  }
  // But not what is to be found.
  for (const char* secret : {"model_from_scan", "quaternion", "# translation", "spikes"}) {
    EXPECT_EQ(scan.find(secret), std::string::npos) << secret;
  }
}

TEST_F(DarbouxScanTest, FilesHoldTheFaceOrWithAThicknessTheMiddleSurface) {
  ASSERT_EQ(Run({sphere_, "--noise=0", "--motion=none", "--sampling=vertices"}), 0) << Stderr();
  const PointCloud face = Cloud("scan.csv");
  EXPECT_EQ(face.points.size(), 500u);  // Of 642.
  for (const Vector3d& x : face.points) EXPECT_NEAR(x.norm(), 10.0, 1e-12);
  ASSERT_EQ(Run({sphere_, "--noise=0", "--motion=none", "--sampling=vertices", "--thickness=2"}),
            0);
  for (const Vector3d& x : Cloud("scan.csv").points) EXPECT_NEAR(x.norm(), 11.0, 1e-12);
  ASSERT_EQ(Run({sphere_, "--noise=0", "--motion=none", "--thickness=2", "--points=2000"}), 0);
  for (const Vector3d& x : Cloud("scan.csv").points) {
    EXPECT_LT(x.norm(), 11.0 + 1e-12);
    EXPECT_GT(x.norm(), 10.9);
  }
}

TEST_F(DarbouxScanTest, ASceneGivesAFileItsFingersAndItsThickness) {
  const std::string scene = Write("ball.yaml", R"(name: ball
surface: {kind: icosphere, radius: 10, frequency: 4}
shell: {thickness: 2, young_modulus: 1, poisson_ratio: 0.3}
fingers:
  - {name: table, shape: {kind: plane}, position: [0, 0, -40], direction: [0, 0, 1], motion: {travel: 0.5}}
  - {name: ball, shape: {kind: sphere, radius: 10}, position: [0, 0, 60], direction: [0, 0, -1], motion: {force: 1}}
)");
  const std::vector<std::string> flags = {
      sphere_, "--noise=0", "--motion=none", "--views=6", "--scene=" + scene, "--points=3000"};
  ASSERT_EQ(Run(flags), 0) << Stderr();
  EXPECT_EQ(Truth()["thickness"], 2.0);
  // The table touches at z = -11 and hides the viewpoint below: there, points more than 75 degrees
  // off the ray from the nearest other viewpoint, at the side, are seen by none.
  double lowest = 0.0;
  for (const Vector3d& x : Cloud("scan.csv").points) lowest = std::min(lowest, x.z());
  EXPECT_GT(lowest, -11.0 * std::sin(75.0 * M_PI / 180.0));
  EXPECT_LT(lowest, -10.0);
  std::vector<std::string> face = flags;
  face.push_back("--thickness=0");
  ASSERT_EQ(Run(face), 0) << Stderr();
  for (const Vector3d& x : Cloud("scan.csv").points) EXPECT_LT(x.norm(), 10.0 + 1e-12);
  // A finger that misses.
  const std::string other = Write("other.yaml", R"(name: other
surface: {kind: icosphere, radius: 1, frequency: 4}
shell: {thickness: 2, young_modulus: 1, poisson_ratio: 0.3}
fingers:
  - {name: ball, shape: {kind: sphere, radius: 1}, position: [30, 0, 60], direction: [0, 0, -1], motion: {travel: 1}}
)");
  EXPECT_EQ(Run({sphere_, "--noise=0", "--scene=" + other}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("found a finger that never touches"));
}

TEST_F(DarbouxScanTest, PointsOfAFileMoveByTheirDisplacements) {
  const std::string field =
      Write("field.csv", "x,y,z,ux,uy,uz\n0,0,0,0,0,1\n1,0,0,0,0,2\n0,1,0,0,0,3\n");
  ASSERT_EQ(Run({field, "--noise=0", "--motion=none"}), 0) << Stderr();
  const PointCloud scan = Cloud("scan.csv");
  EXPECT_THAT(scan.points,
              ::testing::ElementsAre(Vector3d(0, 0, 1), Vector3d(1, 0, 2), Vector3d(0, 1, 3)));
  EXPECT_EQ(Run({field, "--noise=0", "--thickness=1"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("found displaced points without faces and a thickness"));
  EXPECT_EQ(Run({field, "--noise=0", "--normals"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--normals: found a surface without normals"));
  const std::string oriented = Write("oriented.xyz", "0 0 0 0 0 1\n1 0 0 0 0 -1\n");
  const std::string eye = Write("eye.csv", "0,0,9\n");
  ASSERT_EQ(Run({oriented, "--noise=0", "--motion=none", "--thickness=1", "--views_file=" + eye}),
            0)
      << Stderr();
  EXPECT_THAT(Cloud("scan.csv").points, ::testing::ElementsAre(Vector3d(0, 0, 0.5)));
}

TEST_F(DarbouxScanTest, PointsOfAFileMayHaveTheFacesOfAMesh) {
  // The sphere, moved by 50 along x, and its triangles from where it was.
  TriangleMesh mesh;
  std::string error;
  ASSERT_TRUE(ReadMesh(sphere_, &mesh, &error)) << error;
  std::ostringstream text;
  text.precision(17);
  text << "x,y,z,ux,uy,uz\n";
  for (const Vector3d& x : mesh.vertices) {
    text << x.x() << ',' << x.y() << ',' << x.z() << ",50,0,0\n";
  }
  const std::string field = Write("field.csv", text.str());
  const std::vector<std::string> flags = {"--noise=0", "--motion=none", "--views=1"};
  std::vector<std::string> points = flags, faces = flags;
  points.insert(points.end(), {field, "--points=100000"});
  ASSERT_EQ(Run(points), 0) << Stderr();
  EXPECT_EQ(Cloud("scan.csv").points.size(), mesh.vertices.size());  // Nothing hides anything.
  faces.insert(faces.end(), {field, "--faces=" + sphere_});
  ASSERT_EQ(Run(faces), 0) << Stderr();
  EXPECT_EQ(Truth()["options"]["faces"], "sphere.obj");
  const std::vector<double> eye = Truth()["viewpoints"][0];
  const Vector3d towards = (Vector3d(eye[0], eye[1], eye[2]) - Vector3d(50, 0, 0)).normalized();
  const PointCloud scan = Cloud("scan.csv");
  ASSERT_EQ(scan.points.size(), 500u);
  for (const Vector3d& x : scan.points) {
    const Vector3d outward = x - Vector3d(50, 0, 0);
    EXPECT_NEAR(outward.norm(), 10.0, 0.3);
    EXPECT_GT(outward.dot(towards), 0.0);  // The sphere hides its other side.
  }
}

TEST_F(DarbouxScanTest, AProfileIsTurnedIntoTheBodyThatItBounds) {
  // A half circle from pole to pole, moved up by its displacements, in both orders.
  std::vector<std::string> lines;
  for (int k = 0; k <= 90; ++k) {
    std::ostringstream line;
    line.precision(17);
    const double angle = M_PI * (k + 0.5) / 91;
    line << 10.0 * std::sin(angle) << ",0," << 10.0 * std::cos(angle) << ",0,0,3\n";
    lines.push_back(line.str());
  }
  std::string down = "x,y,z,ux,uy,uz\n", up = down;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    down += lines[k];
    up += lines[lines.size() - 1 - k];
  }
  const std::vector<std::string> flags = {
      "--revolve=180", "--noise=0", "--motion=none", "--points=4000", "--normals"};
  for (const std::string& text : {down, up}) {
    std::vector<std::string> words = flags;
    words.insert(words.begin(), Write("profile.csv", text));
    ASSERT_EQ(Run(words), 0) << Stderr();
    const PointCloud scan = Cloud("scan.csv");
    ASSERT_EQ(scan.points.size(), 4000u);
    Vector3d mean(0, 0, 0);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const Vector3d x = scan.points[i] - Vector3d(0, 0, 3);
      mean += x / 4000.0;
      EXPECT_NEAR(x.norm(), 10.0, 4e-3);  // Chords.
      EXPECT_GT(scan.normals[i].dot(x), 9.9);
    }
    EXPECT_LT(mean.norm(), 0.4);  // On all sides.
    EXPECT_EQ(Truth()["options"]["revolve"], 180);
  }
  // A thickness is measured along the normals of the body.
  ASSERT_EQ(Run({"profile.csv", "--revolve=180", "--noise=0", "--motion=none", "--thickness=2"}), 0)
      << Stderr();
  for (const Vector3d& x : Cloud("scan.csv").points) {
    EXPECT_NEAR((x - Vector3d(0, 0, 3)).norm(), 11.0, 5e-3);
  }
}

TEST_F(DarbouxScanTest, FewerDigitsAreThoseOfAllRounded) {
  ASSERT_EQ(Run({sphere_, "--noise=0.1"}), 0) << Stderr();
  const PointCloud all = Cloud("scan.csv");
  ASSERT_EQ(Run({sphere_, "--noise=0.1", "--digits=4"}), 0) << Stderr();
  const PointCloud few = Cloud("scan.csv");
  ASSERT_EQ(all.points.size(), few.points.size());
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(few.points[i][c], all.points[i][c], 5.001e-4 * std::abs(all.points[i][c]));
    }
  }
  std::string text = ReadFile(Out() / "scan.csv");
  text = text.substr(text.find("\nx,y,z") + 7);
  EXPECT_LT(text.size(), 500u * 24u) << text.substr(0, 200);
}

TEST_F(DarbouxScanTest, TheFormatMayBePlyAndAnEarlierScanGoes) {
  ASSERT_EQ(Run({sphere_, "--noise=0.1", "--normals"}), 0);
  const PointCloud csv = Cloud("scan.csv");
  ASSERT_EQ(Run({sphere_, "--noise=0.1", "--normals", "--format=ply", "--quiet"}), 0);
  EXPECT_EQ(Stdout() + Stderr(), "");
  EXPECT_EQ(FilesIn(Out()), (std::set<std::string>{"scan.ply", "truth.csv", "truth.json"}));
  const PointCloud ply = Cloud("scan.ply");
  EXPECT_EQ(ply.points, csv.points);
  EXPECT_EQ(ply.normals, csv.normals);
}

TEST_F(DarbouxScanTest, AScanOfVerticesMayBeAMesh) {
  const std::vector<std::string> flags = {
      "--noise=0", "--sampling=vertices", "--format=ply", "--points=100000"};
  const auto scan = [&](const std::string& surface, const std::vector<std::string>& more) {
    std::vector<std::string> words = flags;
    words.insert(words.begin(), surface);
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(Run(words), 0) << Stderr();
    TriangleMesh mesh;
    std::string error;
    EXPECT_TRUE(ReadMesh((Out() / "scan.ply").string(), &mesh, &error)) << error;
    return mesh;
  };
  const TriangleMesh whole = MakeIcosphere(10.0, 8);
  EXPECT_EQ(scan(sphere_, {}).triangles, whole.triangles);
  // Strays are corners of nothing.
  const TriangleMesh part = scan(sphere_, {"--outliers=0.1", "--spike_share=0", "--motion=none"});
  EXPECT_EQ(part.vertices.size(), whole.vertices.size());
  EXPECT_LT(part.triangles.size(), whole.triangles.size());
  for (const std::array<int, 3>& t : part.triangles) {
    for (const int v : t) {
      EXPECT_NEAR(part.vertices[static_cast<std::size_t>(v)].norm(), 10.0, 1e-12);
    }
  }
  // 16 x 16 cells of two triangles, each of them four.
  const TriangleMesh plate = scan(plate_, {"--motion=none"});
  EXPECT_EQ(plate.vertices.size(), 33u * 33u);
  EXPECT_EQ(plate.triangles.size(), 2048u);
  double highest = 0.0;
  for (const Vector3d& x : plate.vertices) highest = std::max(highest, x.z());
  EXPECT_NEAR(highest, 0.63817, 5e-5);
}

TEST_F(DarbouxScanTest, MillimetresGiveTheScanInMetres) {
  const std::string metres = Write("metres.yaml", R"(name: clamped-plate
surface: {kind: plane, u: [0, 0.1], v: [0, 0.1], divisions: [16, 16]}
shell: {thickness: 0.001, young_modulus: 1.0e13, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1.0e6}]
)");
  ASSERT_EQ(Run({plate_, "--unit=mm", "--outliers=0.1", "--bias=0.1", "--bias_length=20"}), 0);
  const PointCloud a = Cloud("scan.csv");
  ASSERT_EQ(Run({metres, "--unit=m", "--outliers=0.1", "--bias=1e-4", "--bias_length=0.02"}), 0);
  const PointCloud b = Cloud("scan.csv");
  ASSERT_EQ(a.points.size(), b.points.size());
  const double size = Extent(a.points);
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_LT((a.points[i] - 1000.0 * b.points[i]).norm(), 1e-9 * size);
  }
}

TEST_F(DarbouxScanTest, FilesAppearTogetherOrNotAtAll) {
  fs::create_directories(Out() / "truth.json");
  EXPECT_EQ(Run({sphere_, "--noise=0.1"}), 1);
  EXPECT_THAT(Stderr(), HasSubstr("is a folder, cannot be replaced"));
  EXPECT_EQ(FilesIn(Out()), std::set<std::string>{"truth.json"});
  EXPECT_EQ(Run({sphere_, "--noise=0.1", "--out=" + sphere_}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--out: found "));
}

TEST_F(DarbouxScanTest, BadInputIsOneLineAndWritesNothing) {
  struct Mistake {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::string inward = Write("inward.off",
                                   "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n"
                                   "3 0 3 1\n3 1 3 2\n");
  const std::string broken = Write("broken.csv", "1,2,3\n4,5\n");
  const std::string beside = Write("beside.csv", "0,0,1\n1,0.1,0\n0,0,-1\n");
  const std::string nothing = Write("nothing.csv", "x,y,z\n");
  const std::string infinite = Write("infinite.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
  const std::string three = Write("three.csv", "0,0,0\n1,0,0\n0,1,0\n");
  const std::vector<Mistake> mistakes = {
      {{sphere_, "--noise=-1"}, "--noise: found -1; allowed a length >= 0"},
      {{sphere_, "--noise=nan"}, "--noise: found nan; allowed a length >= 0"},
      {{sphere_, "--noise=0", "--points=0"}, "--points: found 0; allowed 1 to 10000000"},
      {{sphere_, "--unit=yard"}, "--unit: found 'yard'; allowed um | mm | cm | m | in"},
      {{sphere_, "--noise=0", "--seed=-1"}, "--seed: found '-1'; allowed an integer >= 0"},
      {{sphere_, "--noise=0", "--seed=x"}, "--seed: found 'x'; allowed an integer"},
      {{sphere_, "--noise=0", "--bias=-1"}, "--bias: found -1; allowed a length >= 0"},
      {{sphere_, "--noise=0", "--bias_along=up"}, "--bias_along: found 'up'; allowed normal | ray"},
      {{sphere_, "--noise=0", "--outliers=2"}, "--outliers: found 2; allowed a part in [0, 1]"},
      {{sphere_, "--noise=0", "--motion=yes"}, "--motion: found 'yes'; allowed random | none"},
      {{sphere_, "--noise=0", "--max_angle=200"}, "--max_angle: found 200; allowed an angle"},
      {{sphere_, "--noise=0", "--grazing=0"}, "--grazing: found 0; allowed an angle in (0, 90]"},
      {{sphere_, "--noise=0", "--views=-1"}, "--views: found '-1'; allowed 0 to 1000"},
      {{sphere_, "--noise=0", "--view_distance=0"}, "--view_distance: found '0'; allowed a factor"},
      {{sphere_, "--noise=0", "--views_file=no.csv"}, "--views_file: no.csv:0: found a file that"},
      {{sphere_, "--noise=0", "--sampling=all"},
       "--sampling: found 'all'; allowed area | vertices"},
      {{sphere_, "--noise=0", "--format=obj"}, "--format: found 'obj'; allowed csv | ply"},
      {{sphere_, "--noise=0", "--thickness=-2"}, "--thickness: found '-2'; allowed a length >= 0"},
      {{sphere_, "--noise=0", "--state=1"}, "--state: found '1'; allowed with a scene"},
      {{sphere_, "--noise=0", "--digits=2"}, "--digits: found '2'; allowed 3 to 17, or 0"},
      {{sphere_, "--noise=0", "--revolve=36"}, "--revolve: found '36'; allowed with the points of"},
      {{beside, "--noise=0", "--revolve=2"}, "--revolve: found '2'; allowed 3 to 10000"},
      {{beside, "--noise=0", "--revolve=36"},
       "beside.csv:0: found point 1 off the half plane y = 0, x > 0; allowed a profile"},
      {{plate_, "--noise=0", "--revolve=36"}, "--revolve: found '36'; allowed with a file"},
      {{sphere_, "--noise=0", "--scene=no.yaml"}, "no.yaml:0: "},
      {{sphere_, "--noise=0", "--nois=1"}, "did you mean '--noise'?"},
      {{plate_, "--noise=0", "--thickness=1"}, "--thickness: found '1'; allowed with a file"},
      {{plate_, "--noise=0", "--scene=a.yaml"}, "--scene: found 'a.yaml'; allowed with a file"},
      {{plate_, "--noise=0", "--faces=a.obj"}, "--faces: found 'a.obj'; allowed with a file"},
      {{sphere_, "--noise=0", "--faces=" + sphere_}, "; allowed with points; "},
      {{three, "--noise=0", "--faces=" + sphere_},
       "sphere.obj:0: found 1280 triangles and 642 vertices; allowed a mesh with as many vertices"},
      {{three, "--noise=0", "--faces=no.obj"}, "--faces: no.obj:0: found a file that cannot be"},
      {{inward, "--noise=0"}, "inward.off:0: found a closed mesh wound inwards; allowed"},
      {{broken, "--noise=0"}, "broken.csv:2: found 2 columns; allowed 3"},
      {{nothing, "--noise=0"}, "nothing.csv:1: found no points; allowed"},
      {{infinite, "--noise=0"}, "infinite.obj:0: found 'nan' as y of point 2; allowed"},
      {{sphere_, "--noise=0", "--views=1", "--view_distance=0.01"},
       "random points that can be seen"},
      {{"no.ply", "--noise=0"}, "no.ply:0: found a file that cannot be read"},
      {{"no.yaml", "--noise=0"}, "no.yaml:0: "},
      {{"no.dat", "--noise=0"}, "no.dat:0: found a name that ends with '.dat'; allowed .csv"}};
  for (const Mistake& mistake : mistakes) {
    EXPECT_EQ(Run(mistake.arguments), 2) << mistake.message;
    const std::string text = Stderr();
    EXPECT_THAT(text, HasSubstr(mistake.message));
    EXPECT_THAT(text, StartsWith("darboux_scan: "));
    const auto lines = std::count(text.begin(), text.end(), '\n');
    EXPECT_EQ(lines, text.find("usage:") == std::string::npos ? 1 : 3) << text;
    EXPECT_EQ(Stdout(), "");
    EXPECT_FALSE(fs::exists(Out())) << mistake.message;
  }
}

TEST_F(DarbouxScanTest, HelpNamesEveryFlag) {
  EXPECT_EQ(Run({"--help"}), 0);
  for (const char* flag :
       {"points",      "seed",          "unit",      "noise",           "bias",
        "bias_length", "bias_along",    "outliers",  "spike_share",     "spike_size",
        "outlier_box", "motion",        "max_angle", "max_translation", "views",
        "views_file",  "view_distance", "grazing",   "sampling",        "state",
        "thickness",   "scene",         "format",    "normals",         "revolve",
        "digits",      "faces"}) {
    EXPECT_THAT(Stdout(), HasSubstr(std::string("\n  --") + flag)) << flag;
  }
}

}  // namespace
}  // namespace darboux
