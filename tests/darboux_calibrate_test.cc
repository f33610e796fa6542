// The tool as its users meet it: command line in, exit status and files out.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/scan_simulator.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"
#include "tests/tool_util.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// A ball between two fingers; mm, N, MPa. Its modulus is a guess, half of the truth below.
constexpr char kBall[] = R"(name: ball
surface: {kind: icosphere, radius: 20, frequency: 4}
shell: {thickness: 1.5, young_modulus: 4, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: {near: [0, 0, 20], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -20], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 12}, position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 2}}
  - {name: bottom, shape: {kind: sphere, radius: 12}, position: [0, 0, -60], direction: [0, 0, 1], motion: {travel: 2}}
)";
constexpr double kTruth = 8.0;
constexpr double kNoise = 0.05;

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string Table(const std::vector<Vector3d>& points, double unit = 1.0) {
  std::string text = "x,y,z\n";
  for (const Vector3d& x : points) {
    text += Number(unit * x[0]) + "," + Number(unit * x[1]) + "," + Number(unit * x[2]) + "\n";
  }
  return text;
}

// Points of a body that the function gives for three numbers uniform in [-1, 1].
std::vector<Vector3d> Random(int count, const std::function<Vector3d(Vector3d)>& body) {
  std::mt19937_64 generator(5);
  const auto uniform = [&] { return std::ldexp(double(generator() >> 11), -52) - 1.0; };
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double a = uniform(), b = uniform(), c = uniform();
    points.push_back(body(Vector3d(a, b, c)));
  }
  return points;
}

class DarbouxCalibrateTest : public ToolTest {
 protected:
  DarbouxCalibrateTest() : ToolTest(DARBOUX_CALIBRATE) { common_ = {OutFlag(), "--threads=1"}; }

  // What a scanner and a force sensor would have told, of the state that the ball has.
  static void SetUpTestSuite() {
    Scene scene;
    std::string error;
    ASSERT_TRUE(ParseScene(kBall, "ball.yaml", &scene, &error)) << error;
    SolverOptions solver;
    std::unique_ptr<ShellProblem> problem;
    SolverSummary summary;
    ASSERT_TRUE(Solve(scene, solver, &problem, &summary, &error)) << error;
    ASSERT_TRUE(summary.IsConverged());
    force_ = kTruth / scene.shell.young_modulus * summary.steps.back().fingers[0].normal_force;
    const ScanSurface surface =
        ScanSurfaceOf(problem->surface(), summary.steps.back().displacements, 0.75);
    ScanOptions options;
    options.num_points = 600;
    options.viewpoints = ViewpointsAround(surface, 8, 5.0);
    options.noise = kNoise;
    options.outliers = 0.02;
    Scan scan;
    ASSERT_TRUE(SimulateScan(surface, {}, options, &scan, &error)) << error;
    scan_ = scan.cloud.points;
  }

  void SetUp() override {
    Write("ball.yaml", kBall);
    Write("scan.csv", Table(scan_));
  }
  // A calibration with one grasp.
  std::string Calibration(const std::string& grasp,
                          const std::string& more = "",
                          const std::string& parameters = "{young_modulus: {}}") {
    return Write("calibration.yaml",
                 "name: test\nparameters: " + parameters + "\nnoise: " + Number(kNoise) + "\n" +
                     more + "grasps:\n  - {scene: ball.yaml, " + grasp + "}\n");
  }
  static std::string Force(double value, double error, const std::string& finger = "top") {
    return "forces: [{finger: " + finger + ", value: " + Number(value) +
           ", error: " + Number(error) + "}]";
  }
  static std::string GoodForce() { return Force(force_, 0.01 * force_); }

  Json Result() const { return Json::parse(ReadFile(Out() / "calibration.json"), nullptr, false); }

  // Nobody who reads the file gets a number from it.
  void ExpectNoNumber(const std::string& termination) const {
    const Json json = Result();
    ASSERT_TRUE(json.is_object());
    EXPECT_EQ(json["converged"], false);
    EXPECT_EQ(json["termination"], termination);
    EXPECT_TRUE(json["parameters"]["young_modulus"]["value"].is_null()) << json["parameters"];
    EXPECT_EQ(json["parameters"]["young_modulus"]["identifiable"], false);
    EXPECT_TRUE(json["linear_theory"]["young_modulus"].is_null());
  }

  static double force_;
  static std::vector<Vector3d> scan_;
};

double DarbouxCalibrateTest::force_ = 0.0;
std::vector<Vector3d> DarbouxCalibrateTest::scan_;

TEST_F(DarbouxCalibrateTest, AGoodGraspGivesTheModulusAndAllThatIsKnownAboutIt) {
  ASSERT_EQ(
      Run({Calibration("scans: [scan.csv], " + GoodForce(), "bootstrap: 50\nmodel_error: 0.01\n")}),
      0)
      << Stderr();
  const Json json = Result();
  for (const char* key : {"name",
                          "converged",
                          "termination",
                          "message",
                          "parameters",
                          "correlation",
                          "sensitivities",
                          "linear_theory",
                          "errors",
                          "grasps",
                          "notes",
                          "iterations",
                          "solutions",
                          "time_s"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["name"], "test");
  EXPECT_EQ(json["termination"], "converged");
  const Json modulus = json["parameters"]["young_modulus"];
  EXPECT_NEAR(modulus["value"].get<double>(), kTruth, 0.02 * kTruth);
  EXPECT_EQ(modulus["identifiable"], true);
  EXPECT_EQ(modulus["verdict"], "identified");
  for (const char* key : {"interval_95", "bootstrap_95"}) {
    EXPECT_LT(modulus[key][0].get<double>(), kTruth) << key;
    EXPECT_GT(modulus[key][1].get<double>(), kTruth) << key;
    EXPECT_LT(modulus[key][1].get<double>(), 1.3 * kTruth) << key;
  }
  // Forces are proportional to it, and go with a power of the thickness between 1 and 3.
  const Json sensitivities = json["sensitivities"]["young_modulus"];
  EXPECT_NEAR(sensitivities["relative_to_forces"].get<double>(), 1.0, 1e-6);
  EXPECT_LT(sensitivities["relative_to_thickness"].get<double>(), -1.0);
  EXPECT_GT(sensitivities["relative_to_thickness"].get<double>(), -3.0);
  EXPECT_TRUE(sensitivities.contains("relative_to_poisson_ratio"));
  EXPECT_TRUE(sensitivities.contains("relative_to_travel"));
  EXPECT_GT(json["linear_theory"]["young_modulus"].get<double>(), 0.0);
  const Json grasp = json["grasps"][0];
  EXPECT_EQ(grasp["scene"], "ball.yaml");
  EXPECT_EQ(grasp["theory"], "nonlinear");
  EXPECT_EQ(grasp["forces"][0]["finger"], "top");
  EXPECT_NEAR(grasp["forces"][0]["computed"].get<double>(), force_, 0.02 * force_);
  const Json scan = grasp["scans"][0];
  EXPECT_EQ(scan["file"], "scan.csv");
  EXPECT_EQ(scan["points"], 600);
  EXPECT_GT(scan["inliers"].get<double>(), 0.95);
  EXPECT_LT(scan["distances"]["rms"].get<double>(), 1.5 * kNoise);
  EXPECT_TRUE(scan["pose"].contains("quaternion_wxyz"));
  // Each scene's results are those of the calibrated shell.
  const Json solved = Json::parse(ReadFile(Out() / "grasp_1" / "summary.json"), nullptr, false);
  EXPECT_NEAR(solved["fingers"]["top"]["normal_force"].get<double>(), force_, 0.02 * force_);
  EXPECT_TRUE(fs::exists(Out() / "grasp_1" / "scan_1.ply"));
  EXPECT_THAT(Stdout(), AllOf(StartsWith("test: converged"), HasSubstr("young_modulus")));
}

TEST_F(DarbouxCalibrateTest, TheSameFilesGiveTheSameNumbers) {
  const std::string file =
      Calibration("scans: [scan.csv], " + GoodForce(), "bootstrap: 20\ncompare_linear: false\n");
  ASSERT_EQ(Run({file, "--quiet"}), 0) << Stderr();
  EXPECT_EQ(Stdout() + Stderr(), "");
  Json first = Result();
  ASSERT_EQ(Run({file}), 0) << Stderr();
  Json second = Result();
  first.erase("time_s");
  second.erase("time_s");
  EXPECT_EQ(first, second);
}

TEST_F(DarbouxCalibrateTest, AScanThatMatchesNothingGivesNoNumber) {
  struct Case {
    std::string text, why;
  };
  const auto cube = [](Vector3d x) {
    int largest;
    x.cwiseAbs().maxCoeff(&largest);
    x[largest] = x[largest] > 0.0 ? 1.0 : -1.0;
    return Vector3d(18.0 * x);
  };
  const auto plate = [](const Vector3d& x) { return Vector3d(30.0 * x[0], 20.0 * x[1], 0.0); };
  const auto anywhere = [](const Vector3d& x) { return Vector3d(25.0 * x); };
  const auto rod = [](const Vector3d& x) {
    return Vector3d(60.0 * x[0], 4.0 * std::cos(3.2 * x[1]), 4.0 * std::sin(3.2 * x[1]));
  };
  const std::vector<Case> cases = {{Table(scan_, 1e-3), "1000"},
                                   {Table(scan_, 1e3), "1000"},
                                   {Table(Random(300, cube)), ""},
                                   {Table(Random(300, plate)), ""},
                                   {Table(Random(300, rod)), ""},
                                   {Table(Random(300, anywhere)), ""},
                                   {Table({scan_.begin(), scan_.begin() + 5}), "points"}};
  // With a travel that is known, and with one that the scan has to tell.
  for (const char* travel : {"", "travel_error: unknown, "}) {
    for (std::size_t k = 0; k < cases.size(); ++k) {
      if (*travel != '\0' && cases[k].why[0] != '\0') continue;  // Whatever the travel.
      Write("bad.csv", cases[k].text);
      EXPECT_EQ(
          Run({Calibration(travel + ("scans: [bad.csv], " + GoodForce()), "theory: linear\n")}), 1)
          << travel << k << Stdout();
      EXPECT_THAT(Stderr(),
                  AllOf(HasSubstr("darboux_calibrate: bad.csv against ball.yaml: no match: "),
                        HasSubstr(cases[k].why)))
          << travel << k;
      ExpectNoNumber("no_match");
    }
  }
}

TEST_F(DarbouxCalibrateTest, AScanThatContradictsTheTravelGivesNoNumber) {
  // The ball at rest: the same but for two spots, which would be in the fingers.
  const auto rest = [](const Vector3d& x) { return Vector3d(20.75 * x.normalized()); };
  Write("rest.csv", Table(Random(600, rest)));
  const std::string more = "theory: linear\n";
  EXPECT_EQ(Run({Calibration("scans: [rest.csv], " + GoodForce(), more)}), 1) << Stdout();
  EXPECT_THAT(Stderr(), HasSubstr("deep in a finger of the computed state: the scan is of"));
  ExpectNoNumber("no_match");
  // The fingers have moved on since the scene.
  EXPECT_EQ(Run({Calibration("travel: 0.5, scans: [scan.csv], " + GoodForce(), more)}), 1)
      << Stdout();
  EXPECT_THAT(Stderr(), HasSubstr("inside of the computed state: the scan is of"));
  ExpectNoNumber("no_match");
}

TEST_F(DarbouxCalibrateTest, StrewnOutliersAreNoContradiction) {
  std::vector<Vector3d> points = scan_;
  Vector3d centre(0, 0, 0);
  for (const Vector3d& x : scan_) centre += x / static_cast<double>(scan_.size());
  const std::vector<Vector3d> strays =
      Random(200, [&](const Vector3d& x) { return Vector3d(centre + 25.0 * x); });
  points.insert(points.end(), strays.begin(), strays.end());
  Write("strewn.csv", Table(points));
  EXPECT_EQ(Run({Calibration("scans: [strewn.csv], " + GoodForce(), "compare_linear: false\n")}), 0)
      << Stderr();
  const Json json = Result();
  // But for the ball's mesh, as coarse as the test is fast.
  ASSERT_EQ(json["notes"].size(), 1u) << json["notes"];
  EXPECT_THAT(json["notes"][0].get<std::string>(), HasSubstr("scene ball: a coarse mesh"));
  EXPECT_NEAR(json["parameters"]["young_modulus"]["value"].get<double>(), kTruth, 0.02 * kTruth);
}

TEST_F(DarbouxCalibrateTest, ForcesThatAreNoneTellNoModulus) {
  EXPECT_EQ(Run({Calibration("scans: [scan.csv], " + Force(0.0, 0.05), "theory: linear\n")}), 1);
  EXPECT_THAT(Stderr(), HasSubstr("young_modulus: not identifiable: no force reading is above"));
  EXPECT_EQ(Result()["parameters"]["young_modulus"]["identifiable"], false);
  // A scan alone tells none either.
  EXPECT_EQ(Run({Calibration("scans: [scan.csv]", "theory: linear\n")}), 1);
  EXPECT_THAT(Stderr(),
              AllOf(HasSubstr("young_modulus: not identifiable"),
                    HasSubstr("a reading of a finger's force is needed")));
  EXPECT_EQ(Result()["parameters"]["young_modulus"]["identifiable"], false);
}

TEST_F(DarbouxCalibrateTest, OneForceDoesNotTellModulusAndThickness) {
  EXPECT_EQ(Run({Calibration(
                GoodForce(), "compare_linear: false\n", "{young_modulus: {}, thickness: {}}")}),
            1);
  EXPECT_THAT(Stderr(),
              AllOf(HasSubstr("young_modulus: not identifiable"),
                    HasSubstr("more of it against less of the thickness"),
                    HasSubstr("thickness: not identifiable"),
                    HasSubstr("more of it against less of Young's modulus")));
  const Json parameters = Result()["parameters"];
  EXPECT_EQ(parameters["young_modulus"]["identifiable"], false);
  EXPECT_EQ(parameters["thickness"]["identifiable"], false);
  // A thickness that was measured is enough.
  EXPECT_EQ(
      Run({Calibration(GoodForce(),
                       "compare_linear: false\n",
                       "{young_modulus: {}, thickness: {prior: {value: 1.5, error: 0.02}}}")}),
      0)
      << Stderr();
  EXPECT_NEAR(
      Result()["parameters"]["young_modulus"]["value"].get<double>(), kTruth, 0.02 * kTruth);
  EXPECT_EQ(Result()["parameters"]["thickness"]["verdict"],
            "known from its prior; the measurements do not tell it");
}

TEST_F(DarbouxCalibrateTest, WhatIsStoppedIsMarked) {
  // A finer mesh takes longer than that.
  std::string slow = kBall;
  slow.replace(slow.find("frequency: 4"), 12, "frequency: 14");
  Write("slow.yaml", slow);
  const std::string file = Write("slow_calibration.yaml",
                                 "name: slow\nparameters: {young_modulus: {}}\ngrasps: [{scene: "
                                 "slow.yaml, " +
                                     GoodForce() + "}]\n");
  EXPECT_EQ(Run({file, "--time_limit=0.5"}), 1);
  ExpectNoNumber("stopped");
  for (const int signal : {SIGINT, SIGTERM}) {
    fs::remove_all(Out());
    const pid_t pid = Start({file});
    for (int i = 0; i < 6000 && Stderr().find("solving") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    kill(pid, signal);
    EXPECT_EQ(Wait(pid), 1);
    ExpectNoNumber("stopped");
  }
}

TEST_F(DarbouxCalibrateTest, ASceneWithoutSolutionGivesNoNumber) {
  EXPECT_EQ(Run({Calibration(GoodForce()), "--max_iterations=1"}), 1);
  EXPECT_THAT(Stderr(), HasSubstr("has no solution"));
  ExpectNoNumber("failed");
}

TEST_F(DarbouxCalibrateTest, BadInputIsOneLineAndWritesNothing) {
  Write("empty.csv", "x,y,z\n");
  Write("blank.csv", "");
  Write("nan.csv", "x,y,z\n1,2,3\n4,nan,6\n");
  Write("text.csv", "x,y,z\n1,2,3\n4,five,6\n");
  std::string without = kBall;
  without.erase(without.find("fingers:"));
  Write("free.yaml", without + "loads: [{kind: normal_traction, value: -0.001}]\n");
  struct Mistake {
    std::string file, message;
  };
  int number = 0;
  const auto text = [&](const std::string& body) {
    return Write("bad_" + std::to_string(++number) + ".yaml", body);
  };
  const auto grasp = [&](const std::string& body) {
    return text("name: bad\nparameters: {young_modulus: {}}\ngrasps:\n  - {" + body + "}\n");
  };
  const std::string top = "name: bad\nparameters: {young_modulus: {}}\n";
  const std::string good = "grasps:\n  - {scene: ball.yaml, " + GoodForce() + "}\n";
  const std::vector<Mistake> mistakes = {
      {"no.yaml", "no.yaml:0: "},
      {text("name: [bad\n"), ".yaml:"},
      {text(top + "nois: 0.1\n" + good), ".yaml:3: nois: "},
      {text(top + "nois: 0.1\n" + good), "did you mean 'noise'?"},
      {text(top), "grasps: "},
      {text(top + "grasps: []\n"), "found an empty list; allowed at least one grasp"},
      {text("name: bad\nparameters: {}\n" + good), "parameters: found an empty map"},
      {text("name: bad\nparameters: {youngs_modulus: {}}\n" + good),
       "did you mean 'young_modulus'?"},
      {text("name: bad\nparameters: {young_modulus: {start: -1}}\n" + good),
       "parameters.young_modulus.start: found -1; allowed a number > 0"},
      {text("name: bad\nparameters: {young_modulus: {prior: {value: 3}}}\n" + good),
       "parameters.young_modulus.prior.error: "},
      {text("name: bad\nparameters: {poisson_ratio: {start: 0.6}}\n" + good),
       "parameters.poisson_ratio.start: found 0.6; allowed a number in (-1, 0.5]"},
      {text("name: bad\nparameters: {young_modulus: {}, gas_pressure: {}}\n" + good),
       "parameters: found gas_pressure, but no scene has gas"},
      {text(top + "noise: -1\n" + good), "noise: found -1; allowed a number > 0"},
      {text(top + "noise: .nan\n" + good), "noise: found .nan"},
      {text(top + "model_error: 2\n" + good), "model_error: found 2; allowed a number in [0, 1)"},
      {text(top + "max_points: 3\n" + good),
       "max_points: found 3; allowed 0 for all, or at least 10"},
      {text(top + "bootstrap: -5\n" + good), "bootstrap: found -5; allowed an integer >= 0"},
      {text(top + "theory: elastic\n" + good), "theory: found 'elastic'; allowed"},
      {grasp("scene: no_ball.yaml, " + GoodForce()),
       "grasps[0].scene: found 'no_ball.yaml', which "},
      {grasp(GoodForce()), "grasps[0].scene: "},
      {grasp("scene: ball.yaml"), "grasps[0]: found nothing measured; allowed scans, fields or"},
      {grasp("scene: ball.yaml, scans: [no.csv]"), "scans[0]: found 'no.csv', which is no file"},
      {grasp("scene: ball.yaml, scans: [empty.csv]"), "empty.csv:1: found no points"},
      {grasp("scene: ball.yaml, scans: [blank.csv]"), "blank.csv:"},
      {grasp("scene: ball.yaml, scans: [nan.csv]"), "nan.csv:3: found 'nan'"},
      {grasp("scene: ball.yaml, scans: [text.csv]"), "text.csv:3: found 'five'"},
      {grasp("scene: ball.yaml, scans: [{fil: scan.csv}]"), "did you mean 'file'?"},
      {grasp("scene: ball.yaml, " + Force(1, 0.1, "thumb")), "forces[0].finger: found 'thumb'; "},
      {grasp("scene: ball.yaml, " + Force(1, -0.1)), "forces[0].error: found -0.1; allowed a num"},
      {grasp("scene: ball.yaml, " + Force(1, 0.0)), "forces[0].error: found 0; allowed a num"},
      {grasp("scene: ball.yaml, forces: [{finger: top, value: 1}]"), "forces[0].error: "},
      {grasp("scene: ball.yaml, forces: [{finger: top, value: .inf, error: 1}]"),
       "forces[0].value: found .inf"},
      {grasp("scene: ball.yaml, travel_error: unknown, " + GoodForce()),
       "found an unknown travel and neither scan nor field; allowed"},
      {grasp("scene: ball.yaml, travel_error: -1, " + GoodForce()), "travel_error: found -1; "},
      {grasp("scene: ball.yaml, travel: -1, " + GoodForce()), "travel: found -1; allowed a number"},
      {grasp("scene: free.yaml, travel: 1, scans: [scan.csv]"), "travel: found a travel; allowed "},
      {grasp("scene: free.yaml, " + Force(1, 0.1)), "forces[0].finger: "}};
  for (const Mistake& mistake : mistakes) {
    EXPECT_EQ(Run({mistake.file}), 2) << mistake.message;
    const std::string said = Stderr();
    EXPECT_THAT(said, HasSubstr(mistake.message));
    EXPECT_THAT(said, StartsWith("darboux_calibrate: "));
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(Stdout(), "");
    EXPECT_FALSE(fs::exists(Out())) << mistake.message;
  }
  const std::string fine = text(top + good);
  EXPECT_EQ(Run({fine, "--out=" + fine}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--out: found "));
  EXPECT_EQ(Run({fine, "--boot=1"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--boot"));
}

TEST_F(DarbouxCalibrateTest, HelpNamesWhatItDoes) {
  EXPECT_EQ(Run({"--help"}), 0);
  EXPECT_THAT(Stdout(),
              AllOf(HasSubstr("CALIBRATION.yaml"),
                    HasSubstr("calibration.json"),
                    HasSubstr("\n  --bootstrap"),
                    HasSubstr("\nEXIT STATUS\n")));
  // Scenes of a calibration are read as they are.
  EXPECT_THAT(Stdout(), Not(HasSubstr("--repair")));
  EXPECT_EQ(Run({"x.yaml", "--repair"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("unknown flag"));
}

}  // namespace
}  // namespace darboux
