// The tool as its users meet it: command line in, exit status and files out.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/mesh_doctor.h"
#include "geometry/mesh_io.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/deform_util.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kPlate[] = R"(name: clamped-plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
)";

// The same in metres, Newtons and Pascals.
constexpr char kPlateMetres[] = R"(name: clamped-plate
surface: {kind: plane, u: [0, 0.1], v: [0, 0.1], divisions: [16, 16]}
shell: {thickness: 0.001, young_modulus: 1.0e13, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1.0e6}]
probes: [{name: centre, at: {uv: [0.05, 0.05]}}]
)";

// Takes far longer than any test waits.
constexpr char kLong[] = R"(name: long
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [24, 24]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 50}]
steps: 5000
probes: [{name: centre, at: {uv: [50, 50]}}]
)";

// A mesh of any shape and size, held at one point. The surface is in line 2.
std::string MeshScene(const std::string& surface) {
  return "name: mesh\nsurface: {" + surface +
         "}\nshell: {thickness: 0.01, young_modulus: 1.0e7, poisson_ratio: 0.3}\n"
         "model: {theory: linear}\n"
         "supports: [{on: {near: [10, 20, 30], radius: 0}, clamped: true}]\n"
         "loads: [{kind: pressure, value: 1}]\n";
}

class DarbouxDeformTest : public DeformTest {
 protected:
  void SetUp() override { Write("plate.yaml", kPlate); }
  std::string Plate() const { return (folder_ / "plate.yaml").string(); }
};

TEST_F(DarbouxDeformTest, ConvergedSceneWhoseExpectationsHoldExitsWithZero) {
  const std::string scene = Write("scene.yaml",
                                  std::string(kPlate) +
                                      "expect: [{quantity: probes.centre.displacement.z, "
                                      "value: 0.13817, relative_tolerance: 0.001}]\n");
  EXPECT_EQ(Run({scene, OutFlag()}), 0) << Stderr();
  ExpectCompleteResults(1);
  EXPECT_THAT(Stdout(), HasSubstr("expect OK      probes.centre.displacement.z = 0.1381"));
  EXPECT_THAT(Stdout(), HasSubstr("results in " + Out().string()));
  EXPECT_THAT(Stderr(), HasSubstr("step 1/1"));
  EXPECT_NEAR(Summary()["probes"]["centre"]["displacement"]["z"].get<double>(), 0.13817, 2e-5);
}

TEST_F(DarbouxDeformTest, FailingExpectationExitsWithOneAndKeepsTheResults) {
  const std::string scene =
      Write("scene.yaml",
            std::string(kPlate) +
                "expect: [{quantity: probes.centre.displacement.z, value: 0.2, "
                "relative_tolerance: 0.001}]\n");
  EXPECT_EQ(Run({scene, OutFlag(), "--quiet"}), 1);
  ExpectCompleteResults(1);
  EXPECT_EQ(Summary()["converged"], true);
  EXPECT_EQ(Summary()["expect"][0]["holds"], false);
  EXPECT_EQ(Stdout(), "");
  EXPECT_THAT(Stderr(), HasSubstr("expectation FAILED  probes.centre.displacement.z"));
}

TEST_F(DarbouxDeformTest, ExpectationsAreEvaluatedWithOverridesToo) {
  const std::string scene = Write("scene.yaml",
                                  std::string(kPlate) +
                                      "expect: [{quantity: elements, value: 512, "
                                      "absolute_tolerance: 0.5}]\n");
  EXPECT_EQ(Run({scene, OutFlag(), "--divisions=4,6"}), 1);
  EXPECT_EQ(Summary()["elements"], 48);
  EXPECT_THAT(Stdout(), HasSubstr("not for --divisions"));
}

TEST_F(DarbouxDeformTest, QuietPrintsNothing) {
  EXPECT_EQ(Run({"--quiet", "--out", Out().string(), Plate()}), 0);
  EXPECT_EQ(Stdout(), "");
  EXPECT_EQ(Stderr(), "");
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, HelpShowsTheToolsOwnFlagsOnly) {
  for (const char* help : {"--help", "-help", "--h", "-h"}) {
    EXPECT_EQ(Run({"--nonsense", help}), 0) << help;
    const std::string text = Stdout();
    EXPECT_THAT(text, HasSubstr("SYNOPSIS\n  darboux_deform SCENE.yaml --out=DIR"));
    for (const char* flag : {"--out",
                             "--threads",
                             "--theory",
                             "--strains",
                             "--quadrature",
                             "--divisions",
                             "--minimizer",
                             "--time_limit",
                             "--quiet",
                             "--repair",
                             "--sparse_backend",
                             "--gradient_tolerance",
                             "--max_iterations"}) {
      EXPECT_THAT(text, HasSubstr(std::string("  ") + flag)) << flag;
    }
    for (const char* foreign : {"logtostderr", "flagfile", "tab_completion", "stderrthreshold"}) {
      EXPECT_THAT(text, Not(HasSubstr(foreign)));
    }
  }
  EXPECT_EQ(Run({"--version"}), 0);
  EXPECT_THAT(Stdout(), HasSubstr("darboux_deform 0."));
}

TEST_F(DarbouxDeformTest, MistakesOnTheCommandLineExitWithTwoAndWriteNothing) {
  struct Mistake {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::string ball =
      Write("ball.yaml", MeshScene("kind: icosphere, radius: 1, frequency: 2"));
  const std::vector<Mistake> mistakes = {
      {{}, "usage:"},
      {{OutFlag()}, "no argument"},
      {{Plate(), Plate(), OutFlag()}, "exactly 1"},
      {{Plate()}, "--out"},
      {{Plate(), "--out="}, "--out"},
      {{Plate(), "--out"}, "found no value"},
      {{Plate(), "--out", "--quiet"}, "found no value"},
      {{Plate(), OutFlag(), "--treads=2"}, "did you mean '--threads'?"},
      {{Plate(), OutFlag(), "--flagfile=x"}, "unknown flag"},
      {{Plate(), OutFlag(), "--log_dir=."}, "unknown flag"},
      {{Plate(), OutFlag(), "--noout"}, "unknown flag"},
      {{Plate(), OutFlag(), "--threads=two"}, "--threads: found 'two'; allowed an integer"},
      {{Plate(), OutFlag(), "--threads", "-1"}, "--threads: found '-1'"},
      {{Plate(), OutFlag(), "--time_limit=-1"}, "--time_limit"},
      {{Plate(), OutFlag(), "--time_limit=nan"}, "--time_limit"},
      {{Plate(), OutFlag(), "--gradient_tolerance=0"}, "--gradient_tolerance"},
      {{Plate(), OutFlag(), "--max_iterations=0"}, "--max_iterations"},
      {{Plate(), OutFlag(), "--sparse_backend=cuda"}, "auto | suite_sparse | eigen"},
      {{Plate(), OutFlag(), "--quiet=maybe"}, "true or false"},
      {{Plate(), OutFlag(), "--theory=liner"}, "--theory: found 'liner'"},
      {{Plate(), OutFlag(), "--theory="}, "--theory"},
      {{Plate(), OutFlag(), "--strains=x"}, "--strains"},
      {{Plate(), OutFlag(), "--minimizer=x"}, "--minimizer"},
      {{Plate(), OutFlag(), "--quadrature=0"}, "--quadrature: found 0"},
      {{Plate(), OutFlag(), "--divisions=8"}, "--divisions"},
      {{Plate(), OutFlag(), "--divisions=0,8"}, "--divisions"},
      {{ball, OutFlag(), "--divisions=8,8"},
       "--divisions: found a surface of kind icosphere; allowed a parametric surface"},
      {{Plate(), OutFlag(), "--repair=some"}, "true or false"},
      {{Plate(), OutFlag(), "--export=xml"}, "--export: found 'xml'; allowed csv | npz | inp"},
      {{Plate(), OutFlag(), "--export_only"}, "--export_only: found --export="},
      {{Plate(), OutFlag(), "--export=inp", "--inp_element=S5"}, "--inp_element: found 'S5'"},
      {{ball, OutFlag(), "--export=inp", "--inp_element=S8R"}, "which has four corners"},
      {{"missing.yaml", OutFlag()}, "missing.yaml:0: scene:"},
      {{folder_.string(), OutFlag()}, "scene:"},
      {{Plate(), "--out=" + Plate()}, "is no folder"},
      {{Plate(), "--out=" + Plate() + "/below"}, "is no folder"},
  };
  const std::set<std::string> before = {"ball.yaml", "plate.yaml", "stderr", "stdout", "tmp"};
  for (const Mistake& mistake : mistakes) {
    EXPECT_EQ(Run(mistake.arguments), 2) << mistake.message << "\n" << Stderr();
    EXPECT_THAT(Stderr(), HasSubstr(mistake.message));
    EXPECT_EQ(Stdout(), "");
    EXPECT_EQ(FilesIn(folder_), before) << mistake.message;
  }
}

TEST_F(DarbouxDeformTest, MistakeInTheSceneExitsWithTwoAndOneLineThatNamesIt) {
  const std::string scene = Write("bad.yaml", std::string(kPlate) + "step: 3\n");
  EXPECT_EQ(Run({scene, OutFlag()}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("bad.yaml:8: step"));
  EXPECT_THAT(Stderr(), HasSubstr("'steps'"));
  const std::string text = Stderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(DarbouxDeformTest, SceneThatNothingHoldsExitsWithTwo) {
  std::string text = kPlate;
  text.erase(text.find("supports"), text.find("loads") - text.find("supports"));
  EXPECT_EQ(Run({Write("free.yaml", text), OutFlag()}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("supports"));
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(DarbouxDeformTest, LoggingFlagsAreTakenAndNoLogFileIsWritten) {
  EXPECT_EQ(Run({Plate(), OutFlag(), "--v=1", "--logtostderr", "--nologtostderr"}), 0) << Stderr();
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, TimeLimitEndsTheRunWithCompleteResults) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Run({Write("long.yaml", kLong), OutFlag(), "--time_limit=0.5"}), 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  const Json summary = Summary();
  EXPECT_EQ(summary["converged"], false);
  EXPECT_THAT(summary["message"].get<std::string>(), HasSubstr("time limit"));
  EXPECT_EQ(summary["load_steps"].back()["converged"], false);
  ExpectCompleteResults(summary["load_steps"].size());
  EXPECT_THAT(Stderr(), HasSubstr("not converged: time limit"));
}

TEST_F(DarbouxDeformTest, TooFewIterationsGiveMarkedAndFiniteResults) {
  EXPECT_EQ(Run({Write("long.yaml", kLong), OutFlag(), "--max_iterations=1"}), 1);
  const Json summary = Summary();
  EXPECT_EQ(summary["converged"], false);
  ExpectCompleteResults(summary["load_steps"].size());
}

TEST_F(DarbouxDeformTest, InterruptEndsTheRunWithCompleteResults) {
  for (const int number : {SIGINT, SIGTERM}) {
    const pid_t pid = Start({Write("long.yaml", kLong), OutFlag()});
    WaitForAStep();
    kill(pid, number);
    EXPECT_EQ(Wait(pid), 1) << Stderr();
    const Json summary = Summary();
    EXPECT_EQ(summary["converged"], false);
    EXPECT_EQ(summary["load_steps"][0]["converged"], true);
    ExpectCompleteResults(summary["load_steps"].size());
  }
}

TEST_F(DarbouxDeformTest, SecondRunReplacesTheFirst) {
  const std::string three = Write("three.yaml", std::string(kPlate) + "steps: 3\n");
  EXPECT_EQ(Run({three, OutFlag()}), 0);
  ExpectCompleteResults(3);
  EXPECT_EQ(Run({Plate(), OutFlag() + "/"}), 0) << Stderr();
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, ExportsAppearWithTheOtherFilesAndGoWithThem) {
  const std::set<std::string> plain = {
      "summary.json", "shell.vtu", "shell_0001.vtu", "shell.pvd", "deformed.ply", "history.csv"};
  std::set<std::string> all = plain;
  all.insert({"fields.csv", "fields_0001.csv", "fields.npz", "shell.inp"});
  EXPECT_EQ(Run({Plate(), OutFlag(), "--export=csv,npz,inp"}), 0) << Stderr();
  EXPECT_EQ(FilesIn(Out()), all);
  EXPECT_EQ(Run({Plate(), OutFlag()}), 0) << Stderr();
  EXPECT_EQ(FilesIn(Out()), plain);  // Those of the earlier run would be of another state.
}

TEST_F(DarbouxDeformTest, DecksAreWrittenWithoutASolutionAndSayWhatTheyLack) {
  const std::string ball =
      Write("gas.yaml",
            "name: gas\nsurface: {kind: icosphere, radius: 1, frequency: 4}\n"
            "shell: {thickness: 0.01, young_modulus: 1.0e7, poisson_ratio: 0.3}\n"
            "loads: [{kind: gas, gauge_pressure: 1, ambient_pressure: 10}]\n");
  EXPECT_EQ(Run({ball, OutFlag(), "--export=inp", "--export_only"}), 0) << Stderr();
  EXPECT_EQ(FilesIn(Out()), (std::set<std::string>{"shell.inp"}));
  EXPECT_THAT(Stderr(), HasSubstr("shell.inp: warning: gas: there is no keyword for gas"));
  EXPECT_THAT(ReadFile(Out() / "shell.inp"), HasSubstr("** Otherwise than in the scene:"));
  EXPECT_EQ(Run({ball, OutFlag(), "--export=inp", "--export_only", "--quiet"}), 0);
  EXPECT_EQ(Stderr(), "");
}

TEST_F(DarbouxDeformTest, FullDiskExitsWithOneAndLeavesNothingHalfWritten) {
  rlimit old_limit;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  rlimit limit = old_limit;
  limit.rlim_cur = 20000;
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const int status = Run({Plate(), OutFlag()});  // Inherits the limit.
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(status, 1);
  EXPECT_THAT(Stderr(), HasSubstr("cannot be written"));
  EXPECT_TRUE(FilesIn(Out()).empty());
}

TEST_F(DarbouxDeformTest, UnitsDoNotMatter) {
  ASSERT_EQ(Run({Plate(), OutFlag()}), 0);
  const Json millimetres = Summary();
  ASSERT_EQ(Run({Write("metres.yaml", kPlateMetres), OutFlag()}), 0);
  const Json metres = Summary();
  const auto value = [](const Json& json, const char* path) {
    return json.at(Json::json_pointer(path)).get<double>();
  };
  struct Quantity {
    const char* path;
    double factor;  // mm, N -> m, N
    double tolerance;
  };
  for (const Quantity& quantity : {Quantity{"/probes/centre/displacement/z", 1e-3, 1e-9},
                                   Quantity{"/energy/total", 1e-3, 1e-9},
                                   Quantity{"/energy/bending", 1e-3, 1e-9},
                                   Quantity{"/max_displacement", 1e-3, 1e-9},
                                   Quantity{"/max_rotation", 1.0, 1e-9},
                                   Quantity{"/supports/reaction/z", 1.0, 1e-9}}) {
    const double expected = quantity.factor * value(millimetres, quantity.path);
    EXPECT_NEAR(value(metres, quantity.path), expected, quantity.tolerance * std::abs(expected))
        << quantity.path;
  }
}

TEST_F(DarbouxDeformTest, AccuracyIsReportedAndDecidesTheStatus) {
  std::string text = kPlate;
  text.replace(text.find("theory: linear"), 14, "theory: linear, accuracy: 0.001");
  EXPECT_EQ(Run({Write("fine.yaml", text), OutFlag()}), 0) << Stderr();
  EXPECT_EQ(Summary()["accuracy"]["reached"], true);
  EXPECT_THAT(Stdout(), HasSubstr("level    12 x 12"));
  text.replace(text.find("0.001"), 5, "1.0e-14");
  EXPECT_EQ(Run({Write("finer.yaml", text), OutFlag(), "--divisions=4,4", "--time_limit=1"}), 1);
  EXPECT_EQ(Summary()["accuracy"]["reached"], false);
  EXPECT_EQ(Summary()["converged"], true);
  EXPECT_THAT(Stderr(), HasSubstr("warning: accuracy 1e-14 not reached"));
}

TEST_F(DarbouxDeformTest, AMeshThatLocksIsNoSuccess) {
  const std::string scene = Write(
      "thin.yaml",
      "name: thin\n"
      "surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [16, 16]}\n"
      "shell: {thickness: 0.03, young_modulus: 3.0e6, poisson_ratio: 0.3}\n"
      "model: {theory: linear}\n"
      "supports:\n"
      "  - {on: u_min, fix: [y, z]}\n"
      "  - {on: u_max, symmetry: x}\n"
      "  - {on: v_min, symmetry: y}\n"
      "  - {on: v_max, symmetry: z}\n"
      "loads: [{kind: point, at: {uv: [300, 0]}, force: [0, 0, -0.25]}]\n");
  EXPECT_EQ(Run({scene, OutFlag(), "--quiet"}), 1);
  EXPECT_EQ(Summary()["converged"], true);
  EXPECT_GT(Summary()["resolution"]["roughness"].get<double>(), 0.25);
  EXPECT_THAT(Stderr(), HasSubstr("warning: the mesh does not resolve the answer"));
  EXPECT_EQ(Run({scene, OutFlag(), "--quiet", "--divisions=80,80"}), 0) << Stderr();
  EXPECT_EQ(Stderr(), "");
}

// ---- Meshes ------------------------------------------------------------------------------------

std::vector<std::string> BrokenMeshes() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(DARBOUX_DATA_DIR "/broken_meshes")) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(DarbouxDeformTest, BrokenMeshesExitWithTwoAndOneLineThatNamesTheDefect) {
  const std::vector<std::string> names = BrokenMeshes();
  EXPECT_EQ(names.size(), 60u);
  std::set<std::string> sound;
  for (const std::string& name : names) {
    const std::string file = DARBOUX_DATA_DIR "/broken_meshes/" + name;
    const std::string scene = Write("scene.yaml", MeshScene("kind: mesh, file: " + file));
    const int status = Run({scene, OutFlag(), "--quiet"});
    const std::string text = Stderr();
    TriangleMesh mesh;
    std::string expected;
    if (ReadMesh(file, &mesh, &expected)) {
      const std::vector<MeshDefect> defects = FindMeshDefects(mesh, {});
      if (defects.empty()) {
        EXPECT_EQ(status, 0) << name << ": " << text;
        sound.insert(name);
        fs::remove_all(Out());
        continue;
      }
      expected = "found " + file + ": " + defects[0].text + "; ";
    }
    EXPECT_EQ(status, 2) << name;
    EXPECT_THAT(text, StartsWith("darboux_deform: " + scene + ":2: surface.file: " + expected));
    EXPECT_THAT(text, HasSubstr("allowed")) << name;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_EQ(Stdout(), "");
    EXPECT_FALSE(fs::exists(Out())) << name;
  }
  EXPECT_THAT(sound, ElementsAre("hole.off", "quad_not_planar.obj"));
}

TEST_F(DarbouxDeformTest, MeshesThatCanBeMendedRunWithRepair) {
  std::set<std::string> run;
  for (const std::string& name : BrokenMeshes()) {
    // Beside the scene, under a name that is no part of a number.
    const fs::path file = folder_ / ("mesh" + fs::path(name).extension().string());
    fs::copy_file(
        DARBOUX_DATA_DIR "/broken_meshes/" + name, file, fs::copy_options::overwrite_existing);
    const std::string scene =
        Write("scene.yaml", MeshScene("kind: mesh, file: " + file.filename().string()));
    const int status = Run({scene, OutFlag(), "--repair"});
    if (status == 2) {
      EXPECT_THAT(Stderr(), StartsWith("darboux_deform: " + scene + ":2: surface.file: ")) << name;
      EXPECT_FALSE(fs::exists(Out())) << name;
      continue;
    }
    // What is left of some is a handful of triangles.
    const bool is_coarse =
        Stderr().find("warning: the mesh does not resolve the answer") != std::string::npos;
    EXPECT_EQ(status, is_coarse ? 1 : 0) << name << ": " << Stderr();
    EXPECT_EQ(Summary()["converged"], true) << name;
    run.insert(name);
    ExpectCompleteResults(1);
    // What was mended is said first, and kept.
    const bool was_sound = name == "hole.off" || name == "quad_not_planar.obj";
    const std::string text = Stderr();
    EXPECT_EQ(text.find("mended " + file.string() + ": ") == 0, !was_sound) << text;
    const Json decisions = Summary()["decisions"];
    const auto is_mending = [](const Json& line) {
      return line.get<std::string>().find("mended ") == 0;
    };
    EXPECT_EQ(std::count_if(decisions.begin(), decisions.end(), is_mending) == 0, was_sound)
        << name << ": " << decisions;
    if (!was_sound) {
      const std::string first = decisions[0].get<std::string>();
      EXPECT_EQ(first, text.substr(0, first.size()));
    }
    fs::remove_all(Out());
  }
  EXPECT_THAT(run,
              ElementsAre("back_to_back.off",
                          "collinear.obj",
                          "duplicate_triangle.off",
                          "flipped_closed.obj",
                          "flipped_triangle.obj",
                          "hole.off",
                          "inside_out.stl",
                          "isolated_vertex.obj",
                          "nan.obj",
                          "nan_binary.ply",
                          "quad_not_planar.obj",
                          "repeated_vertex.obj",
                          "seam.obj",
                          "soup.obj"));
}

TEST_F(DarbouxDeformTest, RepairIsSilentWhenQuiet) {
  const std::string scene = Write(
      "scene.yaml", MeshScene("kind: mesh, file: " DARBOUX_DATA_DIR "/broken_meshes/seam.obj"));
  EXPECT_EQ(Run({scene, OutFlag(), "--repair", "--quiet"}), 0);
  EXPECT_EQ(Stderr(), "");
  EXPECT_EQ(Summary()["decisions"].size(), 2u);
}

TEST_F(DarbouxDeformTest, SoundMeshesAreTheSameWithRepair) {
  const std::string scene =
      Write("scene.yaml", MeshScene("kind: mesh, file: " DARBOUX_DATA_DIR "/duck_642.obj"));
  EXPECT_EQ(Run({scene, OutFlag()}), 0) << Stderr();
  const Json before = Summary();
  EXPECT_EQ(Run({scene, OutFlag(), "--repair"}), 0) << Stderr();
  EXPECT_EQ(Summary()["max_displacement"], before["max_displacement"]);
  EXPECT_EQ(Summary()["decisions"], before["decisions"]);
}

// Sound as a mesh, but squares of lengths are no numbers any more.
TEST_F(DarbouxDeformTest, MeshesWithoutATangentPlaneExitWithTwo) {
  TriangleMesh duck;
  std::string error;
  ASSERT_TRUE(ReadMesh(DARBOUX_DATA_DIR "/duck_642.obj", &duck, &error)) << error;
  for (const double factor : {1e-200, 1e200}) {
    TriangleMesh scaled = duck;
    for (Eigen::Vector3d& x : scaled.vertices) x *= factor;
    ASSERT_TRUE(WriteObj((folder_ / "duck.obj").string(), scaled, &error)) << error;
    const std::string scene = Write("scene.yaml", MeshScene("kind: mesh, file: duck.obj"));
    EXPECT_EQ(Run({scene, OutFlag()}), 2);
    EXPECT_EQ(Stderr(),
              "darboux_deform: " + scene +
                  ":2: surface: found no tangent plane of the Loop surface at vertex 0; allowed a "
                  "mesh without cusps and needles\n");
  }
}

// A duck of 90 mm under uniform pressure, nothing held, in SI units and in N, mm, MPa; the mesh of
// the latter lies beside the scene.
TEST_F(DarbouxDeformTest, UnitsOfAMeshDoNotMatter) {
  TriangleMesh duck;
  std::string error;
  ASSERT_TRUE(ReadMesh(DARBOUX_DATA_DIR "/duck_642.obj", &duck, &error)) << error;
  for (Eigen::Vector3d& x : duck.vertices) x *= 1e3;
  ASSERT_TRUE(WriteObj((folder_ / "duck_mm.obj").string(), duck, &error)) << error;
  const auto solve = [&](const std::string& file,
                         const std::string& shell,
                         const std::string& pressure,
                         const std::string& beak) {
    const std::string scene =
        Write("duck.yaml",
              "name: duck\nsurface: {kind: mesh, file: " + file + "}\nshell: {" + shell +
                  ", poisson_ratio: 0.45}\nmodel: {theory: linear}\n"
                  "loads: [{kind: pressure, value: " +
                  pressure + "}]\nprobes: [{name: beak, at: {nearest: " + beak + "}}]\n");
    EXPECT_EQ(Run({scene, OutFlag()}), 0) << Stderr();
    ExpectCompleteResults(1);
    return Summary();
  };
  const Json metres = solve(DARBOUX_DATA_DIR "/duck_642.obj",
                            "thickness: 0.001, young_modulus: 1.0e6",
                            "1",
                            "[0.1, 0, 0.06]");
  const Json millimetres =
      solve("duck_mm.obj", "thickness: 1, young_modulus: 1", "1.0e-6", "[100, 0, 60]");
  const auto value = [](const Json& json, const char* path) {
    return json.at(Json::json_pointer(path)).get<double>();
  };
  EXPECT_EQ(metres["elements"], 1280);
  EXPECT_GT(value(metres, "/max_displacement"), 1e-7);
  EXPECT_LT(value(metres, "/max_displacement"), 1e-3);
  for (const auto& [path, factor] : {std::make_pair("/max_displacement", 1e3),
                                     std::make_pair("/probes/beak/displacement/x", 1e3),
                                     std::make_pair("/probes/beak/position/0", 1e3),
                                     std::make_pair("/energy/total", 1e3),
                                     std::make_pair("/energy/bending", 1e3),
                                     std::make_pair("/max_rotation", 1.0)}) {
    const double expected = factor * value(metres, path);
    EXPECT_NEAR(value(millimetres, path), expected, 1e-9 * std::abs(expected)) << path;
  }
}

}  // namespace
}  // namespace darboux
