#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "solver/exports.h"
#include "solver/inp_export.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"
#include "tests/calculix_dat.h"
#include "tests/file_util.h"

// Decks that CalculiX runs and agrees with: each scene is solved by both. Differences are those of
// two discretisations and of two theories (solids shear and are squeezed); tolerances are what was
// measured, with a margin of half.

namespace darboux {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class CalculixTest : public ::testing::Test {
 protected:
  void SetUp() override {
#ifndef DARBOUX_CCX
    GTEST_SKIP() << "CalculiX (ccx) was not found at configure time";
#endif
    folder_ = fs::path(::testing::TempDir()) / ("calculix_export_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  static Scene Read(const std::string& text) {
    Scene scene;
    std::string error;
    const std::string file = std::string(DARBOUX_DATA_DIR) + "/" + text;
    const bool is_file = text.find('\n') == std::string::npos;
    EXPECT_TRUE(is_file ? ReadScene(file, &scene, &error)
                        : ParseScene(text, "scene.yaml", &scene, &error))
        << error;
    return scene;
  }

  // Solves by Darboux and makes the deck.
  void SolveAndExport(const Scene& scene, const std::string& element) {
    std::string error;
    SolverOptions options;
    ASSERT_TRUE(Solve(scene, options, &problem_, &summary_, &error)) << error;
    ASSERT_TRUE(summary_.IsConverged()) << summary_.message;
    ExportOptions exports;
    exports.inp = true;
    ASSERT_TRUE(ParseInpElement(element, &exports, &error)) << error;
    ASSERT_TRUE(CheckExports(exports, scene, &error)) << error;
    std::vector<NamedFile> files;
    remarks_.clear();
    ASSERT_TRUE(MakeInpExport(*problem_, exports, &summary_, &files, &remarks_, &error)) << error;
    ASSERT_EQ(files.size(), 1u);
    deck_ = files[0].content;
  }

  void RunCalculix(CalculixResult* result) {
#ifdef DARBOUX_CCX
    std::ofstream(folder_ / "shell.inp") << deck_;
    fs::remove(folder_ / "shell.dat");
    const std::string command = "cd '" + folder_.string() +
                                "' && OMP_NUM_THREADS=1 timeout 400 '" DARBOUX_CCX
                                "' shell > log 2>&1";
    const int status = std::system(command.c_str());
    const std::string log = ReadFile(folder_ / "log");
    ASSERT_EQ(status, 0) << log;
    ASSERT_THAT(log, HasSubstr("Job finished"));
    ASSERT_EQ(log.find("*ERROR"), std::string::npos) << log;
#endif
    *result = ReadCalculixDat(ReadFile(folder_ / "shell.dat"));
  }

  // The largest difference of a probe's displacement over the largest displacement of all probes.
  double ProbeError(const CalculixResult& result) const {
    double largest = 0.0, error = 0.0;
    for (const ProbeSummary& probe : summary_.probes) {
      largest = std::max(largest, probe.displacement.norm());
    }
    for (const ProbeSummary& probe : summary_.probes) {
      const auto found = result.probes.find(Upper(probe.name));
      if (found == result.probes.end()) return 1.0;
      error = std::max(error, (found->second - probe.displacement).norm());
    }
    return error / largest;
  }

  fs::path folder_;
  std::unique_ptr<ShellProblem> problem_;
  SolverSummary summary_;
  std::string deck_;
  std::vector<std::string> remarks_;
};

struct Case {
  const char* name;
  const char* scene;  // text, or a file of data/
  const char* element;
  double tolerance;
  const char* divisions = nullptr;  // in place of the scene's
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class CalculixAgreesTest : public CalculixTest, public ::testing::WithParamInterface<Case> {
 protected:
  void Compare() {
    Scene scene = Read(GetParam().scene);
    if (GetParam().divisions != nullptr) {
      SceneOverrides overrides;
      overrides.divisions = GetParam().divisions;
      std::string error;
      ASSERT_TRUE(ApplyOverrides(overrides, &scene, &error)) << error;
    }
    SolveAndExport(scene, GetParam().element);
    if (HasFatalFailure()) return;
    CalculixResult result;
    RunCalculix(&result);
    if (HasFatalFailure()) return;
    const double error = ProbeError(result);
    std::printf("| %s | %s | %.2g |\n", GetParam().name, GetParam().element, error);
    EXPECT_LT(error, GetParam().tolerance);
  }
};

TEST_P(CalculixAgreesTest, AtTheProbes) { Compare(); }

constexpr char kPlate[] =
    "name: quarter-plate\n"
    "surface: {kind: plane, u: [0, 50], v: [0, 50], divisions: [8, 8], grading: [0.85, 0.85]}\n"
    "shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports:\n  - {on: u_min, symmetry: x}\n  - {on: v_min, symmetry: y}\n"
    "  - {on: u_max, clamped: true}\n  - {on: v_max, clamped: true}\n"
    "loads: [{kind: pressure, value: 1}]\n"
    "probes: [{name: centre, at: {uv: [0, 0]}}]\n";
// The load of data/pinched_cylinder.yaml over five thicknesses.
constexpr char kPinchedPatch[] =
    "name: pinched-patch\n"
    "surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [16, 16], "
    "grading: [0.85, -0.85]}\n"
    "shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports:\n  - {on: u_min, fix: [y, z]}\n  - {on: u_max, symmetry: x}\n"
    "  - {on: v_min, symmetry: y}\n  - {on: v_max, symmetry: z}\n"
    "loads:\n  - kind: traction\n"
    "    force: [\"0\", \"0\", \"-exp(-((u-300)^2+(300*v)^2)/450)/(450*pi)\"]\n"
    "probes: [{name: under_load, at: {uv: [300, 0]}}]\n";
constexpr char kSphere[] =
    "name: sphere\nsurface: {kind: icosphere, radius: 30, frequency: 4}\n"
    "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\nmodel: {theory: nonlinear}\n"
    "loads: [{kind: pressure, value: 0.004}]\n"
    "probes:\n  - {name: a, at: {nearest: [0, 0, 30]}}\n  - {name: b, at: {nearest: [30, 0, 0]}}\n";
constexpr char kGas[] =  // its pressure falls as the shell makes room
    "name: gas\nsurface: {kind: icosphere, radius: 30, frequency: 4}\n"
    "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\nmodel: {theory: nonlinear}\n"
    "loads: [{kind: gas, gauge_pressure: 0.006, ambient_pressure: 0.01}]\n"
    "probes:\n  - {name: a, at: {nearest: [0, 0, 30]}}\n  - {name: b, at: {nearest: [30, 0, 0]}}\n";
constexpr char kTube[] =  // follower pressure on a part of a sphere with a free edge
    "name: half-bowl\nsurface: {kind: sphere, radius: 30, u: [0, pi/2], v: [0, 1.2], "
    "divisions: [8, 8]}\n"
    "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\nmodel: {theory: nonlinear}\n"
    "supports:\n  - {on: u_min, symmetry: y}\n  - {on: u_max, symmetry: x}\n"
    "  - {on: v_min, symmetry: z}\n"
    "loads: [{kind: pressure, value: 0.003}]\n"
    "probes: [{name: inside, at: {uv: [0.7853981633974483, 0.6]}}]\n";
constexpr char kMoment[] =  // a tenth of the full circle
    "name: strip\nsurface: {kind: plane, u: [0, 12], v: [0, 0.5], divisions: [24, 1]}\n"
    "shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}\nmodel: {theory: nonlinear}\n"
    "supports:\n  - {on: u_min, clamped: true}\n  - {on: v_min, symmetry: y}\n"
    "loads: [{kind: edge, on: u_max, moment: [0, -5*pi/3, 0]}]\n"
    "probes: [{name: tip, at: {uv: [12, 0]}}]\n";
constexpr char kLinearMoment[] =
    "name: strip\nsurface: {kind: plane, u: [0, 12], v: [0, 0.5], divisions: [24, 1]}\n"
    "shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}\nmodel: {theory: linear}\n"
    "supports:\n  - {on: u_min, clamped: true}\n"
    "loads: [{kind: edge, on: u_max, moment: [0, -0.1, 0], force: [0, 0, 0.01]}]\n"
    "probes: [{name: tip, at: {uv: [12, 0.5]}}]\n";
constexpr char kGravity[] =  // a hanging roof, at an angle to its own weight
    "name: roof\nsurface: {kind: cylinder, radius: 25, u: [0, 20], v: [-0.6, 0.6], "
    "divisions: [8, 8]}\n"
    "shell: {thickness: 0.25, young_modulus: 4.32e8, poisson_ratio: 0.2, density: 360}\n"
    "model: {theory: linear}\n"
    "supports:\n  - {on: u_min, clamped: true}\n  - {on: u_max, simply_supported: true}\n"
    "loads: [{kind: gravity, acceleration: [0.2, 0.3, -1]}]\n"
    "probes: [{name: edge, at: {uv: [10, 0.6]}}]\n";
constexpr char kPrescribed[] =
    "name: pulled\nsurface: {kind: cylinder, radius: 25, u: [0, 20], v: [-0.6, 0.6], "
    "divisions: [8, 8]}\n"
    "shell: {thickness: 0.5, young_modulus: 1000, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports:\n  - {on: u_min, clamped: true}\n"
    "  - {on: u_max, fix: [x, z], displacement: [0.1, 0, \"0.3*cos(2*v)\"]}\n"
    "probes: [{name: middle, at: {uv: [10, 0]}}, {name: corner, at: {uv: [20, 0.6]}}]\n";
constexpr char kOblique[] =  // the pinched patch, turned about x by 30 degrees
    "name: oblique\nsurface:\n  kind: expression\n"
    "  position: [u, \"300*sin(v+pi/6)\", \"300*cos(v+pi/6)\"]\n"
    "  u: [0, 300]\n  v: [0, pi/2]\n  divisions: [12, 12]\n  grading: [0.85, -0.85]\n"
    "shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports:\n  - {on: u_min, fix: [y, z]}\n  - {on: u_max, symmetry: x}\n"
    "  - {on: v_min, symmetry: [0, \"cos(pi/6)\", \"-sin(pi/6)\"]}\n"
    "  - {on: v_max, symmetry: [0, \"sin(pi/6)\", \"cos(pi/6)\"]}\n"
    "loads:\n  - kind: normal_traction\n"
    "    value: \"-exp(-((u-300)^2+(300*v)^2)/4500)/(4500*pi)\"\n"
    "probes: [{name: under_load, at: {uv: [300, 0]}}]\n";
constexpr char kCap[] =  // a mesh with a rim
    "name: cap\nsurface: {kind: implicit, function: \"x^2+y^2+z^2-900\", open: true, "
    "bounds: [[-35, 35], [-35, 35], [8, 35]], edge_length: 5}\n"
    "shell: {thickness: 1, young_modulus: 1000, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports: [{on: rim, clamped: true}]\n"
    "loads: [{kind: traction, force: [0.1, 0, \"-0.01*z\"]}]\n"
    "probes: [{name: top, at: {nearest: [0, 0, 30]}}]\n";
constexpr char kLine[] =
    "name: line\nsurface: {kind: plane, u: [0, 10], v: [0, 4], divisions: [20, 8]}\n"
    "shell: {thickness: 0.05, young_modulus: 1000, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
    "supports: [{on: rim, simply_supported: true}]\n"
    "loads: [{kind: line, along: {u: 5}, force: [0, 0, -0.01]}]\n"
    "probes: [{name: centre, at: {uv: [5, 2]}}]\n";

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    CalculixAgreesTest,
    ::testing::Values(Case{"plate", kPlate, "C3D20R", 0.005},
                      Case{"plate", kPlate, "S8R", 0.005},
                      Case{"plate", kPlate, "C3D15", 0.01, "16,16"},
                      Case{"plate", kPlate, "S6", 0.01, "16,16"},
                      Case{"plate", kPlate, "S4", 0.006, "16,16"},
                      Case{"pinched_patch", kPinchedPatch, "auto", 0.003},
                      Case{"pinched_patch", kPinchedPatch, "C3D15", 0.02},
                      Case{"pinched_cylinder", "pinched_cylinder.yaml", "auto", 0.02},
                      Case{"cantilever", "cantilever_shear.yaml", "auto", 3e-4},
                      Case{"cantilever", "cantilever_shear.yaml", "C3D15", 3e-4},
                      Case{"sphere", kSphere, "auto", 0.002},
                      Case{"sphere", kSphere, "S6", 0.03},
                      Case{"gas", kGas, "auto", 0.002},
                      Case{"bowl", kTube, "auto", 0.003},
                      Case{"edge_moment", kMoment, "auto", 1e-4},
                      Case{"linear_moment", kLinearMoment, "auto", 1e-4, "24,2"},
                      Case{"gravity", kGravity, "auto", 0.003, "16,16"},
                      Case{"prescribed", kPrescribed, "auto", 0.01},
                      Case{"prescribed", kPrescribed, "S8R", 0.01},
                      Case{"oblique", kOblique, "auto", 0.001, "24,24"},
                      Case{"cap", kCap, "auto", 0.02},
                      Case{"line", kLine, "auto", 0.01}),
    [](const ::testing::TestParamInfo<Case>& info) {
      return std::string(info.param.name) + "_" + info.param.element;
    });

class CalculixAgreesSlow : public CalculixAgreesTest {};
TEST_P(CalculixAgreesSlow, AtTheProbes) { Compare(); }
constexpr char kHemisphere[] =
    "name: hemisphere\nsurface: {kind: sphere, radius: 10, u: [0, pi/2], v: [0, 0.4*pi], "
    "divisions: [16, 16]}\n"
    "shell: {thickness: 0.04, young_modulus: 6.825e7, poisson_ratio: 0.3}\n"
    "model: {theory: nonlinear}\n"
    "supports:\n  - {on: u_min, symmetry: y}\n  - {on: u_max, symmetry: x}\n"
    "  - {on: {near: [10, 0, 0], radius: 0}, fix: [z]}\n"
    "loads:\n  - {kind: point, at: {uv: [0, 0]}, force: [50, 0, 0]}\n"
    "  - {kind: point, at: {uv: [pi/2, 0]}, force: [0, -50, 0]}\n"
    "probes: [{name: pulled, at: {uv: [0, 0]}}, {name: pinched, at: {uv: [pi/2, 0]}}]\n";
INSTANTIATE_TEST_SUITE_P(Scenes,
                         CalculixAgreesSlow,
                         ::testing::Values(Case{"hemisphere", kHemisphere, "auto", 0.02}),
                         [](const ::testing::TestParamInfo<Case>& info) {
                           return std::string(info.param.name);
                         });

// ---- Fingers ----------------------------------------------------------------------------------

constexpr char kBall[] =
    "name: ball\nsurface: {kind: icosphere, radius: 30, frequency: 8}\n"
    "shell: {thickness: 1.5, young_modulus: 1, poisson_ratio: 0.3}\n"
    "supports:\n  - {on: {near: [0, 0, 30], radius: 0}, fix: [x, y]}\n"
    "  - {on: {near: [0, 0, -30], radius: 0}, fix: [x, y]}\n"
    "fingers:\n"
    "  - {name: top, shape: {kind: sphere, radius: 10}, position: [0, 0, 50], "
    "direction: [0, 0, -1], motion: {MOTION}}\n"
    "  - {name: bottom, shape: {kind: sphere, radius: 10}, position: [0, 0, -50], "
    "direction: [0, 0, 1], motion: {MOTION}}\n";

std::string Ball(const std::string& motion) {
  std::string text = kBall;
  for (size_t at; (at = text.find("MOTION")) != std::string::npos;) text.replace(at, 6, motion);
  return text;
}

TEST_F(CalculixTest, SlowBallBetweenFingersNeedsTheSameForce) {
  SolveAndExport(Read(Ball("travel: 1.5")), "auto");
  CalculixResult result;
  RunCalculix(&result);
  const double force = summary_.steps.back().fingers[0].normal_force;
  std::printf("| force at a travel | %.5g | %.5g |\n", force, -result.forces["TOP"].z());
  EXPECT_NEAR(-result.forces["TOP"].z() / force, 1.0, 0.1);
  EXPECT_NEAR(result.forces["TOP"].z() / result.forces["BOTTOM"].z(), -1.0, 1e-3);
}

TEST_F(CalculixTest, SlowFingersDrivenByForceTravelAlike) {
  std::string text = Ball("force: 0.12");
  text.replace(text.find("frequency: 8"), 12, "frequency: 6");
  SolveAndExport(Read(text), "auto");
  CalculixResult result;
  RunCalculix(&result);
  const double travel = summary_.steps.back().fingers[0].travel;
  std::printf("| travel at a force | %.5g | %.5g |\n", travel, result.travels["TOP"]);
  EXPECT_NEAR(result.travels["TOP"] / travel, 1.0, 0.15);
}

TEST_F(CalculixTest, PinsPushTheirNode) {
  SolveAndExport(Read("name: pushed\n"
                      "surface: {kind: plane, u: [0, 10], v: [0, 10], divisions: [8, 8]}\n"
                      "shell: {thickness: 0.2, young_modulus: 1000, poisson_ratio: 0.3}\n"
                      "model: {theory: nonlinear}\n"
                      "supports: [{on: rim, clamped: true}]\n"
                      "fingers: [{name: pin, shape: {kind: pin}, position: [5, 5, 1], "
                      "direction: [0, 0, -1], motion: {travel: 0.1}}]\n"
                      "probes: [{name: beside, at: {uv: [2.5, 5]}}]\n"),
                 "auto");
  CalculixResult result;
  RunCalculix(&result);
  const double error = ProbeError(result);
  std::printf("| pin | %.2g |\n", error);
  EXPECT_LT(error, 0.05);
}

// ---- The deck itself --------------------------------------------------------------------------

// The same plate in other units is the same plate.
TEST_F(CalculixTest, ResultsScaleWithTheUnits) {
  const std::string text = kPlate;
  SolveAndExport(Read(text), "auto");
  CalculixResult first;
  RunCalculix(&first);
  const double length = 1e-3;  // mm to m; forces stay in N
  std::string scaled = text;
  const auto replace = [&scaled](const std::string& from, const std::string& to) {
    const size_t at = scaled.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    scaled.replace(at, from.size(), to);
  };
  replace("u: [0, 50]", "u: [0, 0.05]");
  replace("v: [0, 50]", "v: [0, 0.05]");
  replace("thickness: 1", "thickness: 1e-3");
  replace("1.0e7", "1.0e13");
  replace("value: 1}", "value: 1.0e6}");
  SolveAndExport(Read(scaled), "auto");
  CalculixResult second;
  RunCalculix(&second);
  // CalculiX prints seven digits.
  EXPECT_NEAR(second.probes["CENTRE"].z() / (length * first.probes["CENTRE"].z()), 1.0, 1e-6);
}

TEST_F(CalculixTest, EveryLoadStepOfTheSceneIsAStepOfTheDeck) {
  Scene scene = Read("cantilever_shear.yaml");
  scene.steps = 2;
  SolveAndExport(scene, "auto");
  CalculixResult result;
  RunCalculix(&result);
  EXPECT_LT(ProbeError(result), 5e-4);
  size_t steps = 0;
  for (size_t at = 0; (at = deck_.find("\n*STEP", at)) != std::string::npos; ++at) ++steps;
  EXPECT_EQ(steps, 2u);
}

}  // namespace
}  // namespace darboux
