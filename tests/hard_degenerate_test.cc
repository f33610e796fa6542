// Hard cases: degenerate input. Nothing loaded is nothing moved; what cannot be computed with is an
// error of one line, exit status 2; what is absurd ends with a diagnosis; no output has a NaN.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/deform_util.h"
#include "tests/hard_util.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

constexpr char kPlate[] = R"(name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [8, 8]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
)";

constexpr char kMesh[] = R"(name: mesh
surface: {kind: mesh, file: mesh.obj}
shell: {thickness: 0.1, young_modulus: 1.0e7, poisson_ratio: 0.3}
loads: [{kind: pressure, value: 1}]
)";

std::string With(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// ---- Nothing ------------------------------------------------------------------------------------

struct Named {
  const char* name;
  const char* text;
};

class NothingTest : public ::testing::TestWithParam<Named> {};

TEST_P(NothingTest, MovesNothing) {
  for (const char* theory : {"linear", "nonlinear", "auto"}) {
    Scene scene = SceneFromText(GetParam().text);
    scene.model.theory = std::string(theory) == "linear"      ? Theory::kLinear
                         : std::string(theory) == "nonlinear" ? Theory::kNonlinear
                                                              : Theory::kAuto;
    const Solution solution = SolveScene(scene);
    EXPECT_EQ(solution.problem->displacements().cwiseAbs().maxCoeff(), 0.0) << theory;
    EXPECT_EQ(solution.summary.energy_total, 0.0) << theory;
    EXPECT_EQ(solution.summary.max_displacement, 0.0) << theory;
    EXPECT_EQ(solution.summary.reaction.norm(), 0.0) << theory;
    EXPECT_EQ(solution.summary.gradient_norm, 0.0) << theory;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         NothingTest,
                         ::testing::Values(Named{"no_loads", R"(
name: nothing
surface: {kind: cylinder, radius: 3, u: [0, 2], v: [0, 1], divisions: [6, 6]}
shell: {thickness: 0.1, young_modulus: 1.0e7, poisson_ratio: 0.3}
supports: [{on: u_min, clamped: true}]
)"},
                                           Named{"loads_of_zero", R"(
name: nothing
surface: {kind: cylinder, radius: 3, u: [0, 2], v: [0, 1], divisions: [6, 6]}
shell: {thickness: 0.1, young_modulus: 1.0e7, poisson_ratio: 0.3, density: 1}
supports: [{on: u_min, clamped: true}]
loads:
  - {kind: pressure, value: 0}
  - {kind: traction, force: ["0*u", 0, 0]}
  - {kind: point, at: {uv: [2, 1]}, force: [0, 0, 0]}
  - {kind: edge, on: u_max, force: [0, 0, 0], moment: [0, 0, 0]}
  - {kind: gravity, acceleration: [0, 0, 0]}
steps: 3
)"},
                                           Named{"free_ball", R"(
name: nothing
surface: {kind: icosphere, radius: 3, frequency: 3}
shell: {thickness: 0.1, young_modulus: 1.0e7, poisson_ratio: 0.3}
loads: [{kind: gas, gauge_pressure: 0, ambient_pressure: 1e5}]
)"}),
                         [](const auto& info) { return std::string(info.param.name); });

// ---- What cannot be computed with ---------------------------------------------------------------

using HardDegenerateTest = DeformTest;

// Exit status 2, one line that names the key, nothing written.
TEST_F(HardDegenerateTest, ImpossibleNumbersAreErrors) {
  const std::string plane = "u: [0, 100], v: [0, 100]", thick = "thickness: 1,";
  const std::string young = "young_modulus: 1.0e7", load = "value: 1";
  struct Mistake {
    std::string from, to, key;
  };
  std::vector<Mistake> mistakes = {
      {"poisson_ratio: 0.3", "poisson_ratio: -1", "shell.poisson_ratio"},
      {"poisson_ratio: 0.3", "poisson_ratio: 0.5000001", "shell.poisson_ratio"},
      {plane, "u: [0, 1.0e200], v: [0, 1.0e200]", "surface"},
      {plane, "u: [0, 1.0e100], v: [0, 100]", "surface"},
      {plane, "u: [-1.0e308, 1.0e308], v: [0, 100]", "surface.u"},
      {plane, "u: [0, 0], v: [0, 100]", "surface.u"},
      {"divisions: [8, 8]", "divisions: [0, 8]", "surface.divisions"},
      {"divisions: [8, 8]", "divisions: [99999999999999999999, 8]", "surface.divisions"},
      {"divisions: [8, 8]", "divisions: [3000, 3000]", "surface.divisions"},
      {young, "young_modulus: 1.0e300", "shell.young_modulus"},
      {young, "young_modulus: 1.0e-300", "shell.young_modulus"},
      {thick, "thickness: 1.0e150,", "shell.thickness"},
      {thick, "thickness: 1.0e-150,", "shell.thickness"},
      {thick, "thickness: 1.0e-320,", "shell.thickness"},
      {load, "value: 1.0e300", "loads"},
      {load, "value: 1.0e-300", "loads"},  // would have been no load at all
      {load, "value: 1.0e-320", "loads"},
      {load, "value: log(0)", "loads[0].value"},
      {load, "value: sqrt(u - 1)", "loads[0].value"},
      {"uv: [50, 50]", "uv: [.nan, 50]", "probes[0].at.uv"},
  };
  for (const char* number : {"0", "-1", ".nan", ".inf", "-.inf", "1.0e999", "nan", "0/0", "''"}) {
    mistakes.push_back({thick, std::string("thickness: ") + number + ",", "shell.thickness"});
    mistakes.push_back({young, std::string("young_modulus: ") + number, "shell.young_modulus"});
  }
  for (const char* number : {".nan", ".inf", "1.0e999", "nan", "0/0", "1/0"}) {
    mistakes.push_back({load, std::string("value: ") + number, "loads[0].value"});
  }
  for (const char* theory : {"linear", "nonlinear"}) {
    for (const Mistake& mistake : mistakes) {
      const std::string text = With(With(kPlate, mistake.from, mistake.to),
                                    "theory: linear",
                                    std::string("theory: ") + theory);
      EXPECT_EQ(Run({Write("scene.yaml", text), OutFlag()}), 2) << mistake.to << Stderr();
      const std::string message = Stderr();
      EXPECT_THAT(message, HasSubstr(": " + mistake.key)) << mistake.to;
      EXPECT_THAT(message, HasSubstr("allowed")) << mistake.to;
      EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 1) << message;
      EXPECT_FALSE(std::filesystem::exists(Out())) << mistake.to;
    }
  }
}

TEST_F(HardDegenerateTest, FilesThatAreNoneAreErrors) {
  std::string binary;
  for (int i = 0; i < 4096; ++i) binary += static_cast<char>((i * 7919 + 13) % 256);
  const std::map<std::string, std::string> scenes = {{"empty.yaml", ""},
                                                     {"blank.yaml", "\n\n   \n"},
                                                     {"comment.yaml", "# nothing\n"},
                                                     {"list.yaml", "- 1\n- 2\n"},
                                                     {"word.yaml", "plate"},
                                                     {"binary.yaml", binary},
                                                     {"zeros.yaml", std::string(1000, '\0')},
                                                     {"open.yaml", "name: [a, b"},
                                                     {"half.yaml", std::string(kPlate, 120)}};
  for (const auto& [name, text] : scenes) {
    EXPECT_EQ(Run({Write(name, text), OutFlag()}), 2) << name << Stderr();
    EXPECT_THAT(Stderr(), HasSubstr(name + ":"));
    EXPECT_FALSE(std::filesystem::exists(Out())) << name;
  }
  // Folders and devices in place of files.
  std::filesystem::create_directories(folder_ / "folder.yaml");
  std::filesystem::create_directories(folder_ / "mesh.obj");
  for (const std::string& name : {(folder_ / "folder.yaml").string(), std::string("/dev/null")}) {
    EXPECT_EQ(Run({name, OutFlag()}), 2) << name << Stderr();
    EXPECT_THAT(Stderr(), HasSubstr(name + ":"));
  }
  EXPECT_EQ(Run({Write("mesh.yaml", kMesh), OutFlag()}), 2) << Stderr();
  EXPECT_THAT(Stderr(), HasSubstr("mesh.yaml:2: surface.file"));
  EXPECT_FALSE(std::filesystem::exists(Out()));
}

TEST_F(HardDegenerateTest, MeshesWithImpossibleNumbersAreErrors) {
  const std::string octahedron =
      "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\n"
      "f 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
  for (const char* vertex : {"v nan 0 0",
                             "v 1 inf 0",
                             "v 1 0 -inf",
                             "v 1e999 0 0",
                             "v 1e300 0 0",
                             "v 1 0",
                             "v 1 0 x",
                             ""}) {
    std::ofstream(folder_ / "mesh.obj") << With(octahedron, "v 1 0 0", vertex);
    EXPECT_EQ(Run({Write("mesh.yaml", kMesh), OutFlag()}), 2) << vertex << Stderr();
    EXPECT_THAT(Stderr(), HasSubstr("mesh.yaml:2: surface"));
    EXPECT_FALSE(std::filesystem::exists(Out())) << vertex;
  }
  for (const char* face :
       {"f 1 3 7", "f 0 3 5", "f 1 3", "f 1 3 nan", "f 1 1 5", "f 1 3 99999999999999999999"}) {
    std::ofstream(folder_ / "mesh.obj") << With(octahedron, "f 1 3 5", face);
    EXPECT_EQ(Run({Write("mesh.yaml", kMesh), OutFlag()}), 2) << face << Stderr();
    EXPECT_FALSE(std::filesystem::exists(Out())) << face;
  }
  std::ofstream(folder_ / "mesh.obj") << "";
  EXPECT_EQ(Run({Write("mesh.yaml", kMesh), OutFlag()}), 2) << Stderr();
}

// ---- Absurd loads -------------------------------------------------------------------------------

class AbsurdLoadTest : public DeformTest, public ::testing::WithParamInterface<Named> {};

// 1e12 times what would be sensible, in the nonlinear theory: it says that it did not get there.
TEST_P(AbsurdLoadTest, EndsWithADiagnosisAndFiniteResults) {
  ExpectStatus(1, {Write("absurd.yaml", GetParam().text), OutFlag(), "--time_limit=2"});
  EXPECT_THAT(Stderr(), HasSubstr("not converged: ")) << Stderr();
  const nlohmann::ordered_json summary = Summary();
  EXPECT_EQ(summary["converged"], false);
  EXPECT_GT(summary["message"].get<std::string>().size(), 10u);
  ExpectCompleteResults(summary["load_steps"].size());
  ReadVtu(Out() / "shell.vtu");  // expects finite numbers
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         AbsurdLoadTest,
                         ::testing::Values(Named{"plate", R"(name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [8, 8]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1.0e12}]
)"},
                                           Named{"strip", R"(name: strip
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [16, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}]
loads: [{kind: edge, on: u_max, force: [0, 0, 4.0e12]}]
)"},
                                           Named{"crushed_ball", R"(name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 3}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
model: {theory: nonlinear}
loads: [{kind: pressure, value: -1.0e10}]
)"},
                                           Named{"moment", R"(name: moment
surface: {kind: plane, u: [0, 12], v: [0, 0.5], divisions: [24, 1]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports: [{on: u_min, clamped: true}, {on: v_min, symmetry: y}]
loads: [{kind: edge, on: u_max, moment: [0, -5.0e13, 0]}]
)"}),
                         [](const auto& info) { return std::string(info.param.name); });

// The linear theory has an answer to any load, proportional to it, and a word about it.
TEST_F(HardDegenerateTest, LinearAnswerBeyondItsTheoryIsSaidToBe) {
  const std::string absurd = With(kPlate, "value: 1}", "value: 1.0e12}");
  EXPECT_EQ(Run({Write("absurd.yaml", absurd), OutFlag()}), 0) << Stderr();
  const nlohmann::ordered_json summary = Summary();
  EXPECT_THAT(summary["decisions"].dump(), HasSubstr("takes rotations for small"));
  EXPECT_EQ(Run({Write("plate.yaml", kPlate), OutFlag()}), 0) << Stderr();
  EXPECT_EQ(Summary()["decisions"].size(), 0u);
  EXPECT_NEAR(summary["probes"]["centre"]["displacement"]["z"].get<double>() /
                  Summary()["probes"]["centre"]["displacement"]["z"].get<double>(),
              1e12,
              1.0);
}

}  // namespace
}  // namespace darboux
