#include "solver/scene_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace darboux {
namespace {

using ::testing::StartsWith;

constexpr char kFile[] = "roof.yaml";

// A scene with every key; the line numbers in the table of mistakes below are its own.
constexpr char kBeforeSurface[] = R"yaml(name: roof
)yaml";
constexpr char kSurface[] = R"yaml(surface:
  kind: cylinder
  radius: 300
  u: [0, 600]
  v: [0, pi/2]
  divisions: [16, 8]
  periodic: [false, false]
  grading: [0.8, -0.5]
)yaml";
constexpr char kAfterSurface[] = R"yaml(shell:
  thickness: 3
  young_modulus: 3.0e6
  poisson_ratio: 0.3
  density: 0.1
model:
  minimizer: ceres
  theory: linear
  strains: seed
  quadrature: 6
  boundary_rule: seed_ghosts
  accuracy: 0.05
supports:
  - {on: u_min, fix: [y, z], displacement: [0, "0.1*sin(v)", -0.2]}
  - {on: u_max, symmetry: x}
  - {on: v_min, clamped: true}
  - {on: {near: [0, 0, 300], radius: 5}, simply_supported: true, displacement: [0, 0, 1]}
  - {on: rim, symmetry: [3, 0, -4]}
loads:
  - {kind: point, at: {uv: [300, 0.5]}, force: [0, 0, -0.25]}
  - {kind: pressure, value: 1.5, follower: false}
  - {kind: traction, force: ["0", 0, "cos(2*v)*sin(pi*u/600)"]}
  - {kind: normal_traction, value: z/300}
  - {kind: edge, on: v_max, force: [0, 0, 1], moment: [x, 0, 0]}
  - {kind: line, along: {v: 0.25}, force: [0, 0, -1]}
  - {kind: gravity, acceleration: [0, 0, -9.81]}
steps: 4
probes:
  - {name: under_load, at: {uv: [300, 0.5]}}
  - {name: top, at: {nearest: [0, 0, 300]}}
expect:
  - quantity: probes.under_load.displacement.z
    value: -1.8e-5
    relative_tolerance: 0.02
    source: "Reddy 2004 p. 217"
  - {quantity: "load_steps[0].factor", value: 0, absolute_tolerance: 1}
)yaml";

constexpr char kMinimal[] = R"yaml(name: square
surface: {kind: plane, u: [0, 1], v: [0, 2], divisions: [4, 8]}
shell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0}
)yaml";

constexpr char kTyre[] = R"yaml(name: tyre
surface: {kind: torus, radii: [3, 1], u: [0, 2*pi], v: [-pi, pi], divisions: [9, 4],
          periodic: [true, true]}
shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.5}
)yaml";

std::string FullScene() { return std::string(kBeforeSurface) + kSurface + kAfterSurface; }

// The full scene with the first occurrence of `find` replaced.
std::string Edit(const std::string& find, const std::string& replace) {
  std::string text = FullScene();
  const size_t at = text.find(find);
  EXPECT_NE(at, std::string::npos) << find;
  if (at != std::string::npos) text.replace(at, find.size(), replace);
  return text;
}

// The full scene with other keys below `surface:`.
std::string WithSurface(const std::string& keys) {
  return std::string(kBeforeSurface) + "surface:\n" + keys + kAfterSurface;
}

// The minimal scene with more lines at its end.
std::string Minimal(const std::string& more) { return kMinimal + more; }

Scene Parse(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, kFile, &scene, &error)) << error;
  return scene;
}

std::string ErrorOf(const std::string& text) {
  Scene scene;
  scene.name = "untouched";
  std::string error;
  EXPECT_FALSE(ParseScene(text, kFile, &scene, &error)) << text;
  EXPECT_EQ(scene.name, "untouched");
  return error;
}

double Evaluate(const SceneValue& value, double u, double v, double x, double y, double z) {
  const double variables[5] = {u, v, x, y, z};
  return value.expression.Evaluate(variables);
}

std::array<double, 3> Evaluate(const SceneVector& vector, double u, double v, double x) {
  std::array<double, 3> values;
  for (int i = 0; i < 3; ++i) values[i] = Evaluate(vector.component[i], u, v, x, 0.0, 0.0);
  return values;
}

using Vector = std::array<double, 3>;

TEST(SceneReaderTest, EveryKeyIsReadBack) {
  const Scene scene = Parse(FullScene());
  EXPECT_EQ(scene.name, "roof");
  EXPECT_EQ(scene.steps, 4);

  const SurfaceSpec& surface = scene.surface;
  EXPECT_EQ(surface.kind, "cylinder");
  EXPECT_EQ(surface.u_range, (std::array<double, 2>{0.0, 600.0}));
  EXPECT_EQ(surface.v_range, (std::array<double, 2>{0.0, std::acos(0.0)}));
  EXPECT_EQ(surface.divisions, (std::array<int, 2>{16, 8}));
  EXPECT_EQ(surface.periodic, (std::array<bool, 2>{false, false}));
  EXPECT_EQ(surface.grading, (std::array<double, 2>{0.8, -0.5}));
  EXPECT_EQ(surface.location.line, 2);
  ASSERT_NE(surface.surface, nullptr);
  EXPECT_NEAR((surface.surface->Evaluate(7, 0).x - Eigen::Vector3d(7, 0, 300)).norm(), 0, 1e-12);

  EXPECT_EQ(scene.shell.thickness, 3.0);
  EXPECT_EQ(scene.shell.young_modulus, 3.0e6);
  EXPECT_EQ(scene.shell.poisson_ratio, 0.3);
  EXPECT_EQ(scene.shell.density, 0.1);

  EXPECT_EQ(scene.model.minimizer, Minimizer::kCeres);
  EXPECT_EQ(scene.model.theory, Theory::kLinear);
  EXPECT_EQ(scene.model.strains, Strains::kSeed);
  EXPECT_EQ(scene.model.quadrature, 6);
  EXPECT_EQ(scene.model.boundary_rule, BoundaryRule::kSeedGhosts);
  EXPECT_EQ(scene.model.accuracy, 0.05);
}

TEST(SceneReaderTest, SupportsAreReadBack) {
  const std::vector<SupportSpec> supports = Parse(FullScene()).supports;
  ASSERT_EQ(supports.size(), 5u);
  EXPECT_EQ(supports[0].on.kind, Region::Kind::kUMin);
  EXPECT_EQ(supports[0].kind, SupportSpec::Kind::kFix);
  EXPECT_EQ(supports[0].fix, (std::array<bool, 3>{false, true, true}));
  EXPECT_EQ(Evaluate(supports[0].displacement, 0.0, 1.0, 0.0),
            (Vector{0.0, 0.1 * std::sin(1.0), -0.2}));
  EXPECT_EQ(supports[1].on.kind, Region::Kind::kUMax);
  EXPECT_EQ(supports[1].kind, SupportSpec::Kind::kSymmetry);
  EXPECT_EQ(supports[1].normal, (Vector{1.0, 0.0, 0.0}));
  EXPECT_EQ(supports[2].on.kind, Region::Kind::kVMin);
  EXPECT_EQ(supports[2].kind, SupportSpec::Kind::kClamped);
  EXPECT_EQ(Evaluate(supports[2].displacement, 1.0, 1.0, 1.0), (Vector{0.0, 0.0, 0.0}));
  EXPECT_EQ(supports[3].on.kind, Region::Kind::kNear);
  EXPECT_EQ(supports[3].on.center, (Vector{0.0, 0.0, 300.0}));
  EXPECT_EQ(supports[3].on.radius, 5.0);
  EXPECT_EQ(supports[3].kind, SupportSpec::Kind::kSimplySupported);
  EXPECT_EQ(Evaluate(supports[3].displacement, 1.0, 1.0, 1.0), (Vector{0.0, 0.0, 1.0}));
  EXPECT_EQ(supports[4].on.kind, Region::Kind::kRim);
  EXPECT_DOUBLE_EQ(supports[4].normal[0], 0.6);
  EXPECT_DOUBLE_EQ(supports[4].normal[2], -0.8);
  EXPECT_EQ(supports[4].location.file, kFile);
  EXPECT_EQ(supports[4].location.line, 27);
  EXPECT_EQ(supports[4].location.key, "supports[4]");
}

TEST(SceneReaderTest, LoadsAreReadBack) {
  const std::vector<LoadSpec> loads = Parse(FullScene()).loads;
  ASSERT_EQ(loads.size(), 7u);
  EXPECT_EQ(loads[0].kind, LoadSpec::Kind::kPoint);
  EXPECT_EQ(loads[0].at.kind, SurfacePoint::Kind::kUv);
  EXPECT_EQ(loads[0].at.uv, (std::array<double, 2>{300.0, 0.5}));
  EXPECT_EQ(loads[0].at.location.key, "loads[0].at.uv");
  EXPECT_EQ(loads[0].at.location.line, 29);
  EXPECT_EQ(Evaluate(loads[0].force, 1.0, 1.0, 1.0), (Vector{0.0, 0.0, -0.25}));
  EXPECT_EQ(loads[1].kind, LoadSpec::Kind::kPressure);
  EXPECT_EQ(Evaluate(loads[1].value, 1, 1, 1, 1, 1), 1.5);
  EXPECT_FALSE(loads[1].follower);
  EXPECT_EQ(loads[2].kind, LoadSpec::Kind::kTraction);
  EXPECT_NEAR(
      Evaluate(loads[2].force, 100.0, 0.3, 0.0)[2], std::cos(0.6) * std::sin(M_PI / 6.0), 1e-15);
  EXPECT_EQ(loads[3].kind, LoadSpec::Kind::kNormalTraction);
  EXPECT_EQ(Evaluate(loads[3].value, 1, 2, 3, 4, 150), 0.5);
  EXPECT_EQ(loads[4].kind, LoadSpec::Kind::kEdge);
  EXPECT_EQ(loads[4].on.kind, Region::Kind::kVMax);
  EXPECT_EQ(Evaluate(loads[4].force, 1.0, 1.0, 7.0), (Vector{0.0, 0.0, 1.0}));
  EXPECT_EQ(Evaluate(loads[4].moment, 1.0, 1.0, 7.0), (Vector{7.0, 0.0, 0.0}));
  EXPECT_EQ(loads[5].kind, LoadSpec::Kind::kLine);
  EXPECT_EQ(loads[5].line_parameter, 1);
  EXPECT_EQ(loads[5].line_value, 0.25);
  EXPECT_EQ(Evaluate(loads[5].force, 1.0, 1.0, 1.0), (Vector{0.0, 0.0, -1.0}));
  EXPECT_EQ(loads[6].kind, LoadSpec::Kind::kGravity);
  EXPECT_EQ(loads[6].acceleration, (Vector{0.0, 0.0, -9.81}));
}

TEST(SceneReaderTest, ProbesAndExpectationsAreReadBack) {
  const Scene scene = Parse(FullScene());
  ASSERT_EQ(scene.probes.size(), 2u);
  EXPECT_EQ(scene.probes[0].name, "under_load");
  EXPECT_EQ(scene.probes[0].at.uv, (std::array<double, 2>{300.0, 0.5}));
  EXPECT_EQ(scene.probes[1].at.kind, SurfacePoint::Kind::kNearest);
  EXPECT_EQ(scene.probes[1].at.nearest, (Vector{0.0, 0.0, 300.0}));
  ASSERT_EQ(scene.expect.size(), 2u);
  EXPECT_EQ(scene.expect[0].quantity, "probes.under_load.displacement.z");
  EXPECT_EQ(scene.expect[0].value, -1.8e-5);
  EXPECT_EQ(scene.expect[0].relative_tolerance, 0.02);
  EXPECT_FALSE(scene.expect[0].absolute_tolerance.has_value());
  EXPECT_EQ(scene.expect[0].source, "Reddy 2004 p. 217");
  EXPECT_EQ(scene.expect[0].location.line, 41);
  EXPECT_EQ(scene.expect[1].absolute_tolerance, 1.0);
}

TEST(SceneReaderTest, DefaultsFillWhatIsLeftOut) {
  const Scene scene = Parse(kMinimal);
  EXPECT_EQ(scene.surface.periodic, (std::array<bool, 2>{false, false}));
  EXPECT_EQ(scene.surface.grading, (std::array<double, 2>{0.0, 0.0}));
  EXPECT_EQ(scene.shell.density, 0.0);
  EXPECT_EQ(scene.model.minimizer, Minimizer::kAuto);
  EXPECT_EQ(scene.model.theory, Theory::kAuto);
  EXPECT_EQ(scene.model.strains, Strains::kKoiter);
  EXPECT_EQ(scene.model.quadrature, 3);
  EXPECT_EQ(scene.model.boundary_rule, BoundaryRule::kIndependent);
  EXPECT_FALSE(scene.model.accuracy.has_value());
  EXPECT_EQ(scene.steps, 1);
  EXPECT_TRUE(scene.supports.empty());
  EXPECT_TRUE(scene.loads.empty());
  EXPECT_TRUE(scene.probes.empty());
  EXPECT_TRUE(scene.expect.empty());
  EXPECT_TRUE(Parse(Minimal("loads: [{kind: pressure, value: 1}]\n")).loads[0].follower);
  EXPECT_TRUE(Parse(Minimal("supports: []\nloads: []\n")).loads.empty());
}

TEST(SceneReaderTest, ReadingReplacesTheWholeScene) {
  Scene scene = Parse(FullScene());
  std::string error;
  ASSERT_TRUE(ParseScene(kMinimal, kFile, &scene, &error)) << error;
  EXPECT_TRUE(scene.loads.empty());
  EXPECT_EQ(scene.shell.density, 0.0);
}

// A point of each kind of surface, at u = 0.3, v = 0.2.
struct SurfaceCase {
  const char* name;
  const char* keys;
  Eigen::Vector3d point;
};

class SceneReaderSurfaceTest : public ::testing::TestWithParam<SurfaceCase> {};

TEST_P(SceneReaderSurfaceTest, IsTheOneOfItsKind) {
  const Scene scene = Parse(std::string("name: a\nsurface: {") + GetParam().keys +
                            ", u: [-1, 1], v: [-0.5, 0.5], divisions: [2, 3]}\n"
                            "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0}\n");
  const Eigen::Vector3d x = scene.surface.surface->Evaluate(0.3, 0.2).x;
  EXPECT_NEAR((x - GetParam().point).norm(), 0.0, 1e-14) << x.transpose();
}

INSTANTIATE_TEST_SUITE_P(
    Kind,
    SceneReaderSurfaceTest,
    ::testing::Values(SurfaceCase{"plane", "kind: plane", {0.3, 0.2, 0.0}},
                      SurfaceCase{"cylinder",
                                  "kind: cylinder, radius: 2",
                                  {0.3, 2 * std::sin(0.2), 2 * std::cos(0.2)}},
                      SurfaceCase{"sphere",
                                  "kind: sphere, radius: 2",
                                  {2 * std::cos(0.2) * std::cos(0.3),
                                   2 * std::cos(0.2) * std::sin(0.3),
                                   2 * std::sin(0.2)}},
                      SurfaceCase{"ellipsoid",
                                  "kind: ellipsoid, semi_axes: [2, 3, 4]",
                                  {2 * std::cos(0.2) * std::cos(0.3),
                                   3 * std::cos(0.2) * std::sin(0.3),
                                   4 * std::sin(0.2)}},
                      SurfaceCase{"torus",
                                  "kind: torus, radii: [3, 1]",
                                  {(3 + std::cos(0.2)) * std::cos(0.3),
                                   (3 + std::cos(0.2)) * std::sin(0.3),
                                   std::sin(0.2)}},
                      SurfaceCase{"monkey_saddle",
                                  "kind: monkey_saddle, scale: -2",
                                  {0.3, 0.2, -2 * (0.027 - 3 * 0.3 * 0.04)}},
                      SurfaceCase{"expression",
                                  "kind: expression, position: [2*u, \"v\", u^2*v + 1]",
                                  {0.6, 0.2, 0.09 * 0.2 + 1.0}}),
    [](const ::testing::TestParamInfo<SurfaceCase>& info) { return info.param.name; });

TEST(SceneReaderTest, ClosedDirectionsMayBePeriodic) {
  const Scene torus =
      Parse(kTyre + std::string("supports: [{on: {near: [3, 0, 1], radius: 0}, clamped: true}]\n"));
  EXPECT_EQ(torus.surface.periodic, (std::array<bool, 2>{true, true}));
  const Scene pipe = Parse(R"yaml(
name: pipe
surface: {kind: cylinder, radius: 1, u: [0, 1], v: [0, 6.283185], divisions: [1, 4],
          periodic: [false, true], grading: [0.5, 0]}
shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: -0.99}
supports: [{on: rim, clamped: true}]
loads: [{kind: edge, on: rim, force: [1, 0, 0]}]
)yaml");
  EXPECT_EQ(pipe.loads[0].on.kind, Region::Kind::kRim);
}

TEST(SceneReaderTest, RegularSurfacesPassHoweverUneven) {
  Parse(R"yaml(
name: horn
surface: {kind: expression, position: [u, exp(u)*cos(v), exp(u)*sin(v)], u: [-9, 0],
          v: [0, 2*pi], divisions: [8, 8], periodic: [false, true]}
shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0}
)yaml");
  Parse(R"yaml(
name: corrugated
surface: {kind: expression, position: [u, v, sin(50*u)*cos(40*v)], u: [0, 6], v: [0, 6],
          divisions: [80, 80]}
shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0}
)yaml");
}

TEST(SceneReaderTest, SurfacesWithStepsOrKinksAreRefused) {
  const auto error_of = [](const std::string& height, const std::string& u) {
    Scene scene;
    std::string error;
    ParseScene("name: s\nsurface: {kind: expression, position: [u, v, \"" + height +
                   "\"], u: " + u + ", v: [0, 1], divisions: [4, 4]}\n" +
                   "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0}\n",
               "kink.yaml",
               &scene,
               &error);
    return error;
  };
  for (const std::string height : {"abs(u - 0.5)",
                                   "abs(u - 0.512345)",
                                   "(u < 0.51)*1",
                                   "max(u, v)",
                                   "0.3*abs(u + v - 1.01)",
                                   "sqrt(abs(u - 0.512345))",
                                   "1/(u - 0.3)"}) {
    EXPECT_THAT(error_of(height, "[0, 1]"), StartsWith("kink.yaml:2: surface.position: found a "))
        << height;
  }
  for (const std::string height : {"sqrt((u - 0.5)^2 + 4e-4)",
                                   "tanh(40*(u - 0.5))",
                                   "sin(30*u)*cos(20*v)",
                                   "u*abs(u)",
                                   "0.1*exp(-2000*((u - 0.51)^2 + (v - 0.49)^2))"}) {
    EXPECT_EQ(error_of(height, "[-1, 1]"), "") << height;
  }
}

TEST(SceneReaderTest, NumbersMayBeConstantExpressions) {
  const Scene scene = Parse(R"yaml(
name: numbers
surface: {kind: plane, u: [-pi/2, "2^3"], v: [+.5, 1.], divisions: [+4, 2]}
shell: {thickness: sqrt(4)/100, young_modulus: "210e9", poisson_ratio: 3e-1}
loads: [{kind: point, at: {uv: [pi, 3/4]}, force: [-1e3, "sin(pi/6)", 0]}]
)yaml");
  EXPECT_EQ(scene.surface.u_range, (std::array<double, 2>{-std::acos(0.0), 8.0}));
  EXPECT_EQ(scene.surface.v_range, (std::array<double, 2>{0.5, 1.0}));
  EXPECT_EQ(scene.shell.thickness, 0.02);
  EXPECT_EQ(scene.shell.young_modulus, 210e9);
  EXPECT_EQ(scene.shell.poisson_ratio, 0.3);
  EXPECT_EQ(scene.loads[0].at.uv, (std::array<double, 2>{std::acos(-1.0), 0.75}));
  EXPECT_NEAR(Evaluate(scene.loads[0].force, 0, 0, 0)[1], 0.5, 1e-15);
}

TEST(SceneReaderTest, ExpressionsNeedToBeFiniteOnlyWhereTheyAct) {
  // On v_max of the plane, y = 2; near (1, 2, 0), x > 0.
  const Scene scene = Parse(Minimal(R"yaml(
supports: [{on: {near: [1, 2, 0], radius: 0.5}, clamped: true, displacement: [1/x, 0, 0]}]
loads:
  - {kind: edge, on: v_max, force: [1/y, 0, 0]}
  - {kind: line, along: {u: 0.5}, force: [0, log(u), 0]}
)yaml"));
  EXPECT_EQ(scene.loads.size(), 2u);
}

TEST(SceneReaderTest, RoundingBeyondARangeMovesToItsEnd) {
  const Scene scene = Parse(Edit("along: {v: 0.25}", "along: {v: 1.570796326795}"));
  EXPECT_EQ(scene.loads[5].line_value, scene.surface.v_range[1]);
}

TEST(SceneReaderTest, AliasesAreFollowed) {
  const Scene scene = Parse(Minimal(R"yaml(
loads:
  - {kind: traction, force: &down [0, 0, -1]}
  - {kind: line, along: {u: 0.5}, force: *down}
)yaml"));
  EXPECT_EQ(Evaluate(scene.loads[1].force, 0, 0, 0), (Vector{0.0, 0.0, -1.0}));
}

TEST(SceneReaderTest, MistakesInAliasesAreReportedWhereTheyAreUsed) {
  EXPECT_EQ(ErrorOf(Minimal("steps: &n 0.5\n")),
            "roof.yaml:4: steps: found 0.5; allowed an integer from 1 to 100000");
  EXPECT_EQ(ErrorOf("name: &n 2.5\nsurface: {kind: plane, u: [0, 1], v: [0, 2], divisions: "
                    "[4, 8]}\nshell: {thickness: 1, young_modulus: 1, poisson_ratio: *n}\n"),
            "roof.yaml:3: shell.poisson_ratio: found 2.5; allowed a number in (-1, 0.5]");
}

// ---- Mistakes --------------------------------------------------------------------------------

constexpr char kRootKeys[] =
    "name | surface | shell | model | supports | loads | hand | fingers | steps | path | probes | "
    "expect";
constexpr char kSurfaceKinds[] =
    "plane | cylinder | sphere | ellipsoid | torus | monkey_saddle | expression | implicit | mesh "
    "| "
    "icosphere";
constexpr char kLoadKinds[] =
    "point | pressure | traction | normal_traction | edge | line | gravity | gas";

struct Mistake {
  std::string name;
  std::string text;
  // Behind "roof.yaml:"; "(*)" stands for what yaml-cpp or the expression parser say.
  std::string message;
};

bool Matches(const std::string& message, const std::string& pattern) {
  const size_t star = pattern.find("(*)");
  if (star == std::string::npos) return message == pattern;
  const std::string head = pattern.substr(0, star + 1), tail = pattern.substr(star + 2);
  return message.size() > head.size() + tail.size() && message.compare(0, head.size(), head) == 0 &&
         message.compare(message.size() - tail.size(), tail.size(), tail) == 0;
}

std::vector<Mistake> Mistakes() {
  return {
      {"EmptyFile",
       "",
       "1: scene: found an empty file; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"OnlyComment",
       "# nothing\n",
       "1: scene: found an empty file; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"NotAMap",
       "- a\n"
       "- b\n",
       "1: scene: found a list of 2; allowed a map with the keys name, surface, "
       "shell, ..."},
      {"TextOnly",
       "hello\n",
       "1: scene: found 'hello'; allowed a map with the keys name, surface, shell, ..."},
      {"LeadingComma",  // yaml-cpp's LoadAll never ends here
       ", lu",
       "1: scene: found a YAML mistake (text that is part of nothing); allowed valid YAML"},
      {"TwoDocuments",
       Edit("shell:\n",
            "---\n"
            "shell:\n"),
       "11: scene: found a second YAML document; allowed one document"},
      {"Tab",
       Edit("  thickness: 3", "\tthickness: 3"),
       "11: scene: found a tab in the indentation; allowed spaces"},
      {"Unclosed",
       Edit("[16, 8]", "[16, 8"),
       "8: scene: found a YAML mistake (*); allowed valid YAML"},
      {"UnclosedQuote",
       Edit("p. 217\"", "p. 217"),
       "45: scene: found a YAML mistake (*); allowed valid YAML"},
      {"BadIndent",
       Edit("  radius: 300", "   radius: 300"),
       "4: scene: found a YAML mistake (*); allowed valid YAML"},
      {"ControlCharacter",
       Edit("name: roof", "name: ro\004of"),
       "1: scene: found a control character (code 4); allowed UTF-8 text"},
      {"NotUtf8",
       Edit("name: roof", "name: ro\377of"),
       "1: scene: found a byte that is not UTF-8 text; allowed UTF-8 text"},
      {"Directive",
       Edit("name: roof",
            "%YAML 1.1\n"
            "---\n"
            "name: roof"),
       "1: scene: found a YAML directive (%); allowed one document without directives"},
      {"UndefinedAlias",
       Edit("radius: 300", "radius: *r"),
       "4: scene: found a YAML mistake (*); allowed valid YAML"},
      {"MergeKey",
       Edit("  radius: 300", "  <<: {radius: 300}"),
       "4: surface.<<: found a YAML merge key; allowed keys written out"},
      {"Tag",
       Edit("radius: 300", "radius: !!float 300"),
       "4: surface.radius: found the tag 'tag:yaml.org,2002:float'; allowed values "
       "without YAML tags"},
      {"ListAsKey",
       Edit("steps: 4", "[steps]: 4"),
       "36: scene: found a list of 1 as a key; allowed names as keys"},
      {"UnknownRootKey",
       Edit("steps: 4", "step: 4"),
       std::string("36: step: found an unknown key; allowed ") + kRootKeys +
           "; did you mean 'steps'?"},
      {"UnknownRootKeyFar",
       Edit("steps: 4", "iterations_of_newton: 4"),
       std::string("36: iterations_of_newton: found an unknown key; allowed ") + kRootKeys},
      {"DuplicateRootKey",
       Edit("steps: 4",
            "steps: 4\n"
            "steps: 5"),
       "37: steps: found the key a second time (first in line 36); allowed every key "
       "once"},
      {"DuplicateKey",
       Edit("  thickness: 3\n",
            "  thickness: 3\n"
            "  thickness: 3\n"),
       "12: shell.thickness: found the key a second time (first in line 11); allowed "
       "every key once"},
      {"NoName",
       Edit("name: roof\n", ""),
       "1: name: found no such key, which is required; allowed a text of one line"},
      {"EmptyName",
       Edit("name: roof", "name:"),
       "1: name: found nothing; allowed a text of one line"},
      {"NameOfTwoLines",
       Edit("name: roof", "name: \"a\\nb\""),
       "1: name: found \"a?b\"; allowed a text of one line"},
      {"NoSurface",
       "name: a\n"
       "shell: {thickness: 1}\n",
       "1: surface: found no such key, which is required; allowed a map with the key "
       "kind"},
      {"NoShell",
       Edit("shell:\n"
            "  thickness: 3\n"
            "  young_modulus: 3.0e6\n"
            "  poisson_ratio: 0.3\n"
            "  density: 0.1\n",
            ""),
       "1: shell: found no such key, which is required; allowed a map with thickness, "
       "young_modulus, poisson_ratio"},
      {"FingerWithoutShape",
       Edit("steps: 4", "fingers: [{name: left}]"),
       "36: fingers[0].shape: found no such key, which is required; allowed a map with the key "
       "kind"},
      {"FingerShapeMisspelt",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: spere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[0].shape.kind: found 'spere'; allowed pin | sphere | capsule | box | plane | "
       "mesh | link; did you mean 'sphere'?"},
      {"FingerRadius",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 0}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[0].shape.radius: found 0; allowed a number > 0"},
      {"FingerDirection",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, 0], motion: {travel: 1}}]"),
       "36: fingers[0].direction: found a vector of length zero; allowed a list of three numbers, "
       "[x, y, z]"},
      {"FingerForce",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {force: -1}}]"),
       "36: fingers[0].motion.force: found -1; allowed a number > 0"},
      {"FingerForceAndTravel",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {force: 1, travel: 1}}]"),
       "36: fingers[0].motion.force: found a force beside a travel; allowed exactly one of travel "
       "and force"},
      {"FingerTwice",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}}, {name: left, shape: {kind: sphere, "
            "radius: 2}, position: [0, 0, 400], direction: [0, 0, -1], motion: {travel: 1}}]"),
       "36: fingers[1].name: found 'left' a second time; allowed a different name for each finger"},
      {"FingerFriction",
       Edit("steps: 4",
            "fingers: [{name: left, shape: {kind: sphere, radius: 2}, position: [0, 0, 400], "
            "direction: [0, 0, -1], motion: {travel: 1}, friction: -1}]"),
       "36: fingers[0].friction: found -1; allowed a number >= 0"},
      {"ModelList",
       Edit("\n"
            "  minimizer: ceres\n"
            "  theory: linear\n"
            "  strains: seed\n"
            "  quadrature: 6\n"
            "  boundary_rule: seed_ghosts\n"
            "  accuracy: 0.05\n",
            "\n"
            "  - 3\n"),
       "15: model: found a list of 1; allowed a map"},
      {"SurfaceNotAMap",
       WithSurface("  cylinder\n"),
       "3: surface: found 'cylinder'; allowed a map with the key kind"},
      {"NoKind",
       Edit("  kind: cylinder\n", ""),
       std::string("2: surface.kind: found no such key, which is required; allowed ") +
           kSurfaceKinds},
      {"KindMisspelt",
       Edit("kind: cylinder", "kind: cilinder"),
       std::string("3: surface.kind: found 'cilinder'; allowed ") + kSurfaceKinds +
           "; did you mean 'cylinder'?"},
      {"KindMesh",
       Edit("kind: cylinder", "kind: mesh"),
       "4: surface.radius: found a key of kind cylinder, sphere, icosphere; allowed with kind "
       "mesh: "
       "file | kind | fit | refine | refine_near"},
      {"KindImplicit",
       Edit("kind: cylinder\n  radius: 300\n", "kind: implicit\n"),
       "4: surface.u: found an unknown key; allowed function | bounds | edge_length | open | kind "
       "| "
       "fit | refine | refine_near"},
      {"KindIcosphere",
       Edit("kind: cylinder", "kind: icosphere"),
       "5: surface.u: found an unknown key; allowed radius | frequency | kind | fit | refine "
       "| refine_near"},
      {"KindList",
       Edit("kind: cylinder", "kind: [cylinder]"),
       std::string("3: surface.kind: found a list of 1; allowed ") + kSurfaceKinds},
      {"KeyOfOtherKind",
       Edit("  radius: 300", "  semi_axes: [1, 2, 3]"),
       "4: surface.semi_axes: found a key of kind ellipsoid; allowed with kind "
       "cylinder: radius | kind | u | v | divisions | periodic | grading"},
      {"KeyMisspelt",
       Edit("  radius: 300", "  radious: 300"),
       "4: surface.radious: found an unknown key; allowed radius | kind | u | v | "
       "divisions | periodic | grading; did you mean 'radius'?"},
      {"NoRadius",
       Edit("  radius: 300\n", ""),
       "2: surface.radius: found no such key, which is required; allowed a number > 0"},
      {"RadiusZero",
       Edit("radius: 300", "radius: 0"),
       "4: surface.radius: found 0; allowed a number > 0"},
      {"RadiusNegative",
       Edit("radius: 300", "radius: -pi"),
       "4: surface.radius: found '-pi'; allowed a number > 0"},
      {"RadiusNan",
       Edit("radius: 300", "radius: .nan"),
       "4: surface.radius: found .nan, which is not finite; allowed a number > 0"},
      {"RadiusInf",
       Edit("radius: 300", "radius: -.inf"),
       "4: surface.radius: found -.inf, which is not finite; allowed a number > 0"},
      {"RadiusHuge",
       Edit("radius: 300", "radius: 1e999"),
       "4: surface.radius: found 1e999, which is not finite; allowed a number > 0"},
      {"RadiusExpressionInf",
       Edit("radius: 300", "radius: 1/0"),
       "4: surface.radius: found '1/0', which is not finite; allowed a number > 0"},
      {"RadiusText",
       Edit("radius: 300", "radius: wide"),
       "4: surface.radius: found 'wide' (*); allowed a number > 0 or a constant "
       "expression such as pi/2"},
      {"RadiusVariable",
       Edit("radius: 300", "radius: 2*u"),
       "4: surface.radius: found '2*u' (*); allowed a number > 0 or a constant "
       "expression such as pi/2"},
      {"RadiusList",
       Edit("radius: 300", "radius: [300]"),
       "4: surface.radius: found a list of 1; allowed a number > 0"},
      {"RadiusBool",
       Edit("radius: 300", "radius: true"),
       "4: surface.radius: found 'true' (*); allowed a number > 0 or a constant "
       "expression such as pi/2"},
      {"RadiusEmpty",
       Edit("radius: 300", "radius:"),
       "4: surface.radius: found nothing; allowed a number > 0"},
      {"NoRange",
       Edit("  u: [0, 600]\n", ""),
       "2: surface.u: found no such key, which is required; allowed a list of two "
       "ascending numbers, [lower, upper]"},
      {"RangeScalar",
       Edit("u: [0, 600]", "u: 600"),
       "5: surface.u: found 600; allowed a list of two ascending numbers, [lower, "
       "upper]"},
      {"RangeOfThree",
       Edit("u: [0, 600]", "u: [0, 300, 600]"),
       "5: surface.u: found a list of 3; allowed a list of two ascending numbers, "
       "[lower, upper]"},
      {"RangeReversed",
       Edit("u: [0, 600]", "u: [600, 0]"),
       "5: surface.u: found [600, 0]; allowed a list of two ascending numbers, "
       "[lower, upper]"},
      {"RangeEmpty",
       Edit("u: [0, 600]", "u: [600, 600]"),
       "5: surface.u: found [600, 600]; allowed a list of two ascending numbers, "
       "[lower, upper]"},
      {"RangeNotFinite",
       Edit("u: [0, 600]", "u: [0, .inf]"),
       "5: surface.u[1]: found .inf, which is not finite; allowed a number"},
      {"NoDivisions",
       Edit("  divisions: [16, 8]\n", ""),
       "2: surface.divisions: found no such key, which is required; allowed a list of "
       "two integers > 0, [cells along u, along v]"},
      {"DivisionsZero",
       Edit("[16, 8]", "[16, 0]"),
       "7: surface.divisions: found [16, 0]; allowed an integer >= 1 for v"},
      {"DivisionsReal",
       Edit("[16, 8]", "[16, 8.5]"),
       "7: surface.divisions[1]: found 8.5; allowed an integer > 0"},
      {"DivisionsHuge",
       Edit("[16, 8]", "[16000, 8000]"),
       "7: surface.divisions: found [16000, 8000]; allowed at most 10000000 vertices"},
      {"DivisionsOverflow",
       Edit("[16, 8]", "[16, 80000000000]"),
       "7: surface.divisions[1]: found 80000000000; allowed an integer > 0"},
      {"PeriodicScalar",
       Edit("periodic: [false, false]", "periodic: false"),
       "8: surface.periodic: found 'false'; allowed a list of two of true | false, "
       "[u, v]"},
      {"PeriodicNoBool",
       Edit("periodic: [false, false]", "periodic: [false, 0]"),
       "8: surface.periodic[1]: found 0; allowed true | false"},
      {"PeriodicGap",
       Edit("periodic: [false, false]\n"
            "  grading: [0.8, -0.5]",
            "periodic: [false, true]"),
       "8: surface.periodic[1]: found true, but surface points 424.3 apart at the two "
       "ends of v (u = 0); allowed true only where position and first derivatives "
       "agree at both ends, i.e. a range of one whole period"},
      {"PeriodicDerivative",
       WithSurface("  kind: expression\n"
                   "  position: [\"sin(pi*u)\", \"v\", \"sin(2*pi*u)\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"
                   "  periodic: [true, false]\n"),
       "8: surface.periodic[0]: found true, but different sigma_u at the two ends of "
       "u (v = 0); allowed true only where position and first derivatives agree at "
       "both ends, i.e. a range of one whole period"},
      {"PeriodicDivisions",
       WithSurface("  kind: torus\n"
                   "  radii: [3, 1]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [2, 8]\n"
                   "  periodic: [true, true]\n"),
       "7: surface.divisions: found [2, 8]; allowed an integer >= 4 for u, which is "
       "periodic"},
      {"GradingPeriodic",
       WithSurface("  kind: torus\n"
                   "  radii: [3, 1]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, true]\n"
                   "  grading: [0, 0.5]\n"),
       "9: surface.grading[1]: found 0.5; allowed 0, because v is periodic"},
      {"GradingTooLarge",
       Edit("[0.8, -0.5]", "[0.8, -1]"),
       "9: surface.grading[1]: found -1; allowed a number in (-1, 1)"},
      {"TorusRadii",
       WithSurface("  kind: torus\n"
                   "  radii: [1, 1]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, true]\n"),
       "4: surface.radii: found R = 1, r = 1; allowed a list of two numbers, [R, r] "
       "with R > r > 0"},
      {"TorusRadiiNegative",
       WithSurface("  kind: torus\n"
                   "  radii: [1, -1]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, true]\n"),
       "4: surface.radii[1]: found -1; allowed a number > 0"},
      {"ClosedSurfaceHasNoSide",
       WithSurface("  kind: torus\n"
                   "  radii: [3, 1]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, true]\n"),
       "22: supports[0].on: found 'u_min', which does not exist because u is "
       "periodic; allowed {near: [x, y, z], radius: r}"},
      {"ClosedSurfaceHasNoRim",
       kTyre + std::string("supports: [{on: rim, clamped: true}]\n"),
       "5: supports[0].on: found 'rim', which does not exist because u and v are periodic; "
       "allowed {near: [x, y, z], radius: r}"},
      {"ClosedSurfaceHasNoEdge",
       kTyre + std::string("loads: [{kind: edge, on: v_max, force: [0, 0, 1]}]\n"),
       "5: loads[0].on: found 'v_max', which does not exist because v is periodic; allowed no "
       "edge, as the surface is closed"},
      {"FullSphere",
       WithSurface("  kind: sphere\n"
                   "  radius: 10\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [-pi/2, pi/2]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "6: surface.v: found [-1.5707963267948966, 1.5707963267948966], which ends in "
       "a pole (sigma_u x sigma_v = 0 at u = 0, v = -1.571); allowed a smaller range "
       "that leaves a hole around the pole, e.g. [-1.414, 1.414]"},
      {"SphereOnePole",
       WithSurface("  kind: sphere\n"
                   "  radius: 10\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [0, pi/2]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "6: surface.v: found [0, 1.5707963267948966], which ends in a pole (sigma_u x "
       "sigma_v = 0 at u = 0, v = 1.571); allowed a smaller range that leaves a hole "
       "around the pole, e.g. [0, 1.492]"},
      {"SpherePoleRounded",
       WithSurface("  kind: sphere\n"
                   "  radius: 10\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [-1, 1.5707963]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "6: surface.v: found [-1, 1.5707963], which ends in a pole (sigma_u x sigma_v "
       "= 0 at u = 0, v = 1.571); allowed a smaller range that leaves a hole around "
       "the pole, e.g. [-1, 1.442]"},
      {"SpherePoleInside",
       WithSurface("  kind: sphere\n"
                   "  radius: 10\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [-2, 1]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "6: surface.v: found a point without tangent plane (sigma_u x sigma_v = 0 at u "
       "= 0.05214, v = -1.571); allowed a surface and ranges of u and v with sigma_u "
       "x sigma_v != 0 at every point"},
      {"SpherePoleJustInside",
       WithSurface("  kind: sphere\n"
                   "  radius: 10\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [-1, 1.5708]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "6: surface.v: found a point without tangent plane (sigma_u x sigma_v = 0 at u "
       "= 0, v = 1.571); allowed a surface and ranges of u and v with sigma_u x "
       "sigma_v != 0 at every point"},
      {"EllipsoidAxes",
       WithSurface("  kind: ellipsoid\n"
                   "  semi_axes: [1, 0, 2]\n"
                   "  u: [0, 2*pi]\n"
                   "  v: [-pi/2, pi/2]\n"
                   "  divisions: [8, 8]\n"
                   "  periodic: [true, false]\n"),
       "4: surface.semi_axes[1]: found 0; allowed a number > 0"},
      {"ExpressionUnknownName",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"v\", \"u*w\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position[2]: found \"u*w\" (*); allowed an expression of u and v"},
      {"ExpressionSyntax",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"v\", \"u*(\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position[2]: found \"u*(\" (*); allowed an expression of u and v"},
      {"ExpressionNotFinite",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"v\", \"1/u\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position: found a surface that is not finite or not twice "
       "differentiable at u = 0, v = 0; allowed a smooth surface over the whole range "
       "of u and v"},
      {"ExpressionNotSmooth",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"v\", \"sqrt(v)\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position: found a surface that is not finite or not twice "
       "differentiable at u = 0, v = 0; allowed a smooth surface over the whole range "
       "of u and v"},
      {"ExpressionDegenerate",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"u\", u]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position: found a point without tangent plane (sigma_u x sigma_v = "
       "0 at u = 0, v = 0); allowed a surface and ranges of u and v with sigma_u x "
       "sigma_v != 0 at every point"},
      {"ExpressionConePoint",
       WithSurface("  kind: expression\n"
                   "  position: [\"u*cos(v)\", \"u*sin(v)\", u]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "5: surface.u: found [0, 1], which ends in a pole (sigma_u x sigma_v = 0 at u "
       "= 0, v = 0); allowed a smaller range that leaves a hole around the pole, e.g. "
       "[0.05, 1]"},
      {"ExpressionDegenerateInside",
       WithSurface("  kind: expression\n"
                   "  position: [\"(u-0.3)^3+0.1*(v-0.4)^2*(u-0.3)\", \"v\", \"(u-0.3)^2\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position: found a point without tangent plane (sigma_u x sigma_v = "
       "0 at u = 0.3, v = 0.4); allowed a surface and ranges of u and v with sigma_u "
       "x sigma_v != 0 at every point"},
      {"ExpressionOfTwo",
       WithSurface("  kind: expression\n"
                   "  position: [\"u\", \"v\"]\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.position: found a list of 2; allowed a list of three expressions "
       "of u and v, [x, y, z]"},
      {"SaddleScale",
       WithSurface("  kind: monkey_saddle\n"
                   "  scale: x\n"
                   "  u: [0, 1]\n"
                   "  v: [0, 1]\n"
                   "  divisions: [4, 4]\n"),
       "4: surface.scale: found 'x' (*); allowed a number or a constant expression "
       "such as pi/2"},
      {"ThicknessZero",
       Edit("thickness: 3", "thickness: 0"),
       "11: shell.thickness: found 0; allowed a number > 0"},
      {"YoungNegative",
       Edit("young_modulus: 3.0e6", "young_modulus: -3.0e6"),
       "12: shell.young_modulus: found -3.0e6; allowed a number > 0"},
      {"PoissonLarge",
       Edit("poisson_ratio: 0.3", "poisson_ratio: 0.51"),
       "13: shell.poisson_ratio: found 0.51; allowed a number in (-1, 0.5]"},
      {"PoissonMinusOne",
       Edit("poisson_ratio: 0.3", "poisson_ratio: -1"),
       "13: shell.poisson_ratio: found -1; allowed a number in (-1, 0.5]"},
      {"DensityNegative",
       Edit("density: 0.1", "density: -0.1"),
       "14: shell.density: found -0.1; allowed a number >= 0"},
      {"NoThickness",
       Edit("  thickness: 3\n", ""),
       "10: shell.thickness: found no such key, which is required; allowed a number > "
       "0"},
      {"ShellKey",
       Edit("thickness: 3", "thicknes: 3"),
       "11: shell.thicknes: found an unknown key; allowed thickness | young_modulus | "
       "poisson_ratio | density; did you mean 'thickness'?"},
      {"ModelKey",
       Edit("theory: linear", "teory: linear"),
       "17: model.teory: found an unknown key; allowed minimizer | theory | strains | "
       "quadrature | contact_spacing | boundary_rule | unstable | accuracy; did you mean "
       "'theory'?"},
      {"ContactSpacing",
       Edit("theory: linear", "contact_spacing: 0.01"),
       "17: model.contact_spacing: found 0.01; allowed a number from 0.02 to 1"},
      {"MinimizerTypo",
       Edit("minimizer: ceres", "minimizer: cere"),
       "16: model.minimizer: found 'cere'; allowed auto | mip | ceres | cg; did you mean 'ceres'?"},
      {"Theory",
       Edit("theory: linear", "theory: non_linear"),
       "17: model.theory: found 'non_linear'; allowed auto | linear | nonlinear; did "
       "you mean 'nonlinear'?"},
      {"TheoryMap",
       Edit("theory: linear", "theory: {a: b}"),
       "17: model.theory: found a map; allowed auto | linear | nonlinear"},
      {"Strains",
       Edit("strains: seed", "strains: donnell"),
       "18: model.strains: found 'donnell'; allowed koiter | seed"},
      {"BoundaryRule",
       Edit("boundary_rule: seed_ghosts", "boundary_rule: seed_ghost"),
       "20: model.boundary_rule: found 'seed_ghost'; allowed independent | "
       "seed_ghosts; did you mean 'seed_ghosts'?"},
      {"Quadrature",
       Edit("quadrature: 6", "quadrature: 4"),
       "19: model.quadrature: found 4; allowed 1, 3, 6 or 12 points per triangle"},
      {"QuadratureText",
       Edit("quadrature: 6", "quadrature: \"6\""),
       "19: model.quadrature: found \"6\"; allowed 1, 3, 6 or 12 points per triangle"},
      {"Accuracy",
       Edit("accuracy: 0.05", "accuracy: 1"),
       "21: model.accuracy: found 1; allowed a number in (0, 1)"},
      {"SupportsMap",
       Edit("supports:\n",
            "supports: {}\n"
            "loads2:\n"),
       std::string("23: loads2: found an unknown key; allowed ") + kRootKeys +
           "; did you mean 'loads'?"},
      {"SupportWithoutOn",
       Edit("{on: u_min, fix", "{fix"),
       "23: supports[0].on: found no such key, which is required; allowed a side, rim "
       "or {near: [x, y, z], radius: r}"},
      {"SupportUnknownSide",
       Edit("on: u_min", "on: u_mim"),
       "23: supports[0].on: found 'u_mim'; allowed u_min | u_max | v_min | v_max | "
       "rim | {near: [x, y, z], radius: r}; did you mean 'u_min'?"},
      {"SupportKey",
       Edit("symmetry: x", "symetry: x"),
       "24: supports[1].symetry: found an unknown key; allowed on | fix | clamped | "
       "simply_supported | symmetry | displacement; did you mean 'symmetry'?"},
      {"SupportNoKind",
       Edit("{on: u_max, symmetry: x}", "{on: u_max}"),
       "24: supports[1]: found no kind of support; allowed exactly one of fix | "
       "clamped | simply_supported | symmetry"},
      {"SupportTwoKinds",
       Edit("{on: u_max, symmetry: x}", "{on: u_max, symmetry: x, clamped: true}"),
       "24: supports[1]: found clamped, symmetry; allowed exactly one of fix | "
       "clamped | simply_supported | symmetry"},
      {"ClampedFalse",
       Edit("clamped: true", "clamped: false"),
       "25: supports[2].clamped: found false; allowed true (leave the support out "
       "otherwise)"},
      {"ClampedYes",
       Edit("clamped: true", "clamped: yes"),
       "25: supports[2].clamped: found 'yes'; allowed true | false"},
      {"FixEmpty",
       Edit("fix: [y, z]", "fix: []"),
       "23: supports[0].fix: found an empty list; allowed a list of one to three of "
       "x, y, z"},
      {"FixScalar",
       Edit("fix: [y, z]", "fix: y"),
       "23: supports[0].fix: found 'y'; allowed a list of one to three of x, y, z"},
      {"FixUnknown",
       Edit("fix: [y, z]", "fix: [y, w]"),
       "23: supports[0].fix[1]: found 'w'; allowed x | y | z"},
      {"FixRepeated",
       Edit("fix: [y, z]", "fix: [y, y]"),
       "23: supports[0].fix[1]: found 'y' a second time; allowed every component once"},
      {"DisplacementWithoutFix",
       Edit("symmetry: x", "symmetry: x, displacement: [0, 0, 1]"),
       "24: supports[1].displacement: found prescribed values on a symmetry plane; "
       "allowed with fix, clamped or simply_supported"},
      {"DisplacementFree",
       Edit("fix: [y, z]", "fix: [y]"),
       "23: supports[0].displacement[2]: found -0.2 for z, which fix does not list; "
       "allowed 0 for free components"},
      {"DisplacementFreeExpression",
       Edit("[0, \"0.1*sin(v)\", -0.2]", "[\"0*u\", 0, 0]"),
       "23: supports[0].displacement[0]: found \"0*u\" for x, which fix does not list; "
       "allowed 0 for free components"},
      {"DisplacementOfTwo",
       Edit("[0, \"0.1*sin(v)\", -0.2]", "[0, 1]"),
       "23: supports[0].displacement: found a list of 2; allowed a list of three "
       "numbers or expressions, [x, y, z]"},
      {"DisplacementInfinite",
       Edit("\"0.1*sin(v)\"", "\"1/v\""),
       "23: supports[0].displacement[1]: found \"1/v\", which is not finite at u = 0, v "
       "= 0; allowed an expression that is finite wherever it acts"},
      {"SymmetryUnknown",
       Edit("symmetry: x", "symmetry: u"),
       "24: supports[1].symmetry: found 'u'; allowed the normal of the mirror plane: "
       "x | y | z | [nx, ny, nz]"},
      {"SymmetryZero",
       Edit("symmetry: [3, 0, -4]", "symmetry: [0, 0, 0]"),
       "27: supports[4].symmetry: found a vector of length zero; allowed the normal "
       "of the mirror plane: x | y | z | [nx, ny, nz]"},
      {"SymmetryOfTwo",
       Edit("symmetry: [3, 0, -4]", "symmetry: [1, 0]"),
       "27: supports[4].symmetry: found a list of 2; allowed the normal of the mirror "
       "plane: x | y | z | [nx, ny, nz]"},
      {"NearNegative",
       Edit("radius: 5}", "radius: -5}"),
       "26: supports[3].on.radius: found -5; allowed a number >= 0"},
      {"NearWithoutRadius",
       Edit(", radius: 5}", "}"),
       "26: supports[3].on.radius: found no such key, which is required; allowed a "
       "number >= 0"},
      {"SideOfPeriodic",
       WithSurface("  kind: cylinder\n"
                   "  radius: 300\n"
                   "  u: [0, 600]\n"
                   "  v: [0, 2*pi]\n"
                   "  divisions: [16, 8]\n"
                   "  periodic: [false, true]\n"),
       "24: supports[2].on: found 'v_min', which does not exist because v is "
       "periodic; allowed u_min | u_max | rim | {near: [x, y, z], radius: r}"},
      {"LoadKindMissing",
       Edit("kind: point, ", ""),
       std::string("29: loads[0].kind: found no such key, which is required; allowed ") +
           kLoadKinds},
      {"LoadGas",
       Edit("{kind: pressure, value: 1.5, follower: false}", "{kind: gas, gauge_pressure: 3}"),
       "30: loads[1].kind: found gas in a surface of kind cylinder; allowed gas in a closed "
       "surface "
       "only: icosphere, implicit or a mesh without rim"},
      {"LoadKindTypo",
       Edit("kind: pressure", "kind: presure"),
       std::string("30: loads[1].kind: found 'presure'; allowed ") + kLoadKinds +
           "; did you mean 'pressure'?"},
      {"LoadKeyOfOtherKind",
       Edit("value: 1.5", "acceleration: 1.5"),
       "30: loads[1].acceleration: found a key of kind gravity; allowed with kind "
       "pressure: value | follower | kind"},
      {"LoadKeyTypo",
       Edit("value: 1.5", "valu: 1.5"),
       "30: loads[1].valu: found an unknown key; allowed value | follower | kind; did "
       "you mean 'value'?"},
      {"LoadWithoutValue",
       Edit("value: 1.5, ", ""),
       "30: loads[1].value: found no such key, which is required; allowed a number or "
       "an expression of u, v, x, y, z"},
      {"PressureNan",
       Edit("value: 1.5", "value: .nan"),
       "30: loads[1].value: found .nan, which is not finite; allowed a number or an "
       "expression of u, v, x, y, z"},
      {"FollowerText",
       Edit("follower: false", "follower: never"),
       "30: loads[1].follower: found 'never'; allowed true | false"},
      {"PointUvOutside",
       Edit("at: {uv: [300, 0.5]}, force", "at: {uv: [300, 2]}, force"),
       "29: loads[0].at.uv[1]: found 2; allowed v in [0, 1.5707963267948966]"},
      {"PointUvOfOne",
       Edit("at: {uv: [300, 0.5]}, force", "at: {uv: [300]}, force"),
       "29: loads[0].at.uv: found a list of 1; allowed a list of two numbers, [u, v]"},
      {"PointBoth",
       Edit("at: {uv: [300, 0.5]}, force", "at: {uv: [300, 0.5], nearest: [1, 2, 3]}, force"),
       "29: loads[0].at: found uv and nearest; allowed {uv: [u, v]} | {nearest: [x, "
       "y, z]}"},
      {"PointNeither",
       Edit("at: {uv: [300, 0.5]}, force", "at: {}, force"),
       "29: loads[0].at: found an empty map; allowed {uv: [u, v]} | {nearest: [x, y, "
       "z]}"},
      {"PointVariableForce",
       Edit("force: [0, 0, -0.25]", "force: [0, 0, u]"),
       "29: loads[0].force[2]: found 'u' (*); allowed a number or a constant "
       "expression such as pi/2"},
      {"PointForceOfTwo",
       Edit("force: [0, 0, -0.25]", "force: [0, 1]"),
       "29: loads[0].force: found a list of 2; allowed a list of three numbers, [x, "
       "y, z]"},
      {"TractionUnknownName",
       Edit("pi*u/600", "pi*w/600"),
       "31: loads[2].force[2]: found \"cos(2*v)*sin(pi*w/600)\" (*); allowed a number "
       "or an expression of u, v, x, y, z"},
      {"TractionNotFinite",
       Edit("\"cos(2*v)*sin(pi*u/600)\"", "\"1/(u-300)\""),
       "31: loads[2].force[2]: found \"1/(u-300)\", which is not finite at u = 300, v = "
       "0; allowed an expression that is finite wherever it acts"},
      {"TractionConstantNotFinite",
       Edit("\"cos(2*v)*sin(pi*u/600)\"", "\"log(0)\""),
       "31: loads[2].force[2]: found \"log(0)\", which is not finite; allowed a number "
       "or an expression of u, v, x, y, z"},
      {"TractionFunction",
       Edit("\"cos(2*v)*sin(pi*u/600)\"", "\"cosine(v)\""),
       "31: loads[2].force[2]: found \"cosine(v)\" (*); allowed a number or an "
       "expression of u, v, x, y, z"},
      {"EdgeEmpty",
       Edit(", force: [0, 0, 1], moment: [x, 0, 0]", ""),
       "33: loads[4]: found neither force nor moment; allowed one of them or both"},
      {"EdgeNear",
       Edit("on: v_max", "on: {near: [0, 0, 0], radius: 1}"),
       "33: loads[4].on: found a map; allowed u_min | u_max | v_min | v_max | rim"},
      {"EdgeMomentNotFinite",
       Edit("moment: [x, 0, 0]", "moment: [1/x, 1/(v-pi/2), 0]"),
       "33: loads[4].moment[0]: found '1/x', which is not finite at u = 0, v = 1.571; "
       "allowed an expression that is finite wherever it acts"},
      {"LineBoth",
       Edit("along: {v: 0.25}", "along: {u: 1, v: 0.25}"),
       "34: loads[5].along: found u and v; allowed {u: number} | {v: number}"},
      {"LineNone",
       Edit("along: {v: 0.25}", "along: {}"),
       "34: loads[5].along: found an empty map; allowed {u: number} | {v: number}"},
      {"LineOutside",
       Edit("along: {v: 0.25}", "along: {v: 1.6}"),
       "34: loads[5].along.v: found 1.6; allowed v in [0, 1.5707963267948966]"},
      {"LineForceNotFinite",
       Edit("{v: 0.25}, force: [0, 0, -1]", "{v: 0.25}, force: [0, 0, 1/(v-0.25)]"),
       "34: loads[5].force[2]: found '1/(v-0.25)', which is not finite at u = 0, v = "
       "0.25; allowed an expression that is finite wherever it acts"},
      {"GravityWithoutDensity",
       Edit("  density: 0.1\n", ""),
       "34: loads[6].kind: found gravity with shell.density 0; allowed gravity only "
       "with shell.density > 0"},
      {"GravityDensityZero",
       Edit("density: 0.1", "density: 0"),
       "35: loads[6].kind: found gravity with shell.density 0; allowed gravity only "
       "with shell.density > 0"},
      {"Unstable",
       Minimal("model: {unstable: leav}\n"),
       "4: model.unstable: found 'leav'; allowed report | leave; did you mean 'leave'?"},
      {"PathControl",
       Minimal("path: {control: arclength}\n"),
       "4: path.control: found 'arclength'; allowed load | displacement | arc_length; did you mean "
       "'arc_length'?"},
      {"PathNoControl",
       Minimal("path: {max_steps: 3}\n"),
       "4: path.control: found no such key, which is required; allowed load | displacement | "
       "arc_length"},
      {"PathText",
       Minimal("path: arc_length\n"),
       "4: path: found 'arc_length'; allowed a map with control"},
      {"PathOfTheLinearTheory",
       Edit("steps: 4", "path: {control: arc_length}"),
       "36: path.control: found 'arc_length' with theory: linear; allowed theory: nonlinear | "
       "auto, "
       "as the linear theory has no path to follow"},
      {"PathLoadKey",
       Minimal("path: {control: load, to: 3}\n"),
       "4: path.to: found an unknown key; allowed control"},
      {"PathMaxSteps",
       Minimal("path: {control: arc_length, max_steps: 0}\n"),
       "4: path.max_steps: found 0; allowed an integer from 1 to 100000"},
      {"PathProbe",
       Minimal("probes: [{name: tip, at: {uv: [1, 1]}}]\n"
               "path: {control: displacement, probe: tap, component: z, to: 1}\n"),
       "5: path.probe: found the probe 'tap'; allowed tip; did you mean 'tip'?"},
      {"PathNoProbes",
       Minimal("path: {control: displacement, probe: tip, component: z, to: 1}\n"),
       "4: path.probe: found the probe 'tip'; allowed no probes, as the scene has none"},
      {"PathComponent",
       Minimal("probes: [{name: tip, at: {uv: [1, 1]}}]\n"
               "path: {control: displacement, probe: tip, component: w, to: 1}\n"),
       "5: path.component: found 'w'; allowed x | y | z"},
      {"PathTo",
       Minimal("probes: [{name: tip, at: {uv: [1, 1]}}]\n"
               "path: {control: displacement, probe: tip, component: z, to: 0}\n"),
       "5: path.to: found 0; allowed a number other than 0"},
      {"StepsZero",
       Edit("steps: 4", "steps: 0"),
       "36: steps: found 0; allowed an integer from 1 to 100000"},
      {"StepsReal",
       Edit("steps: 4", "steps: 1.5"),
       "36: steps: found 1.5; allowed an integer from 1 to 100000"},
      {"ProbeTwice",
       Edit("name: top", "name: under_load"),
       "39: probes[1].name: found 'under_load' a second time; allowed a different "
       "name for each probe"},
      {"ProbeName",
       Edit("name: top", "name: top-right"),
       "39: probes[1].name: found 'top-right'; allowed a name of letters, digits and "
       "_ that begins with no digit"},
      {"ProbeOutside",
       Edit("{name: under_load, at: {uv: [300, 0.5]}}", "{name: under_load, at: {uv: [-1, 0.5]}}"),
       "38: probes[0].at.uv[0]: found -1; allowed u in [0, 600]"},
      {"ProbeWithoutAt",
       Edit("{name: top, at: {nearest: [0, 0, 300]}}", "{name: top}"),
       "39: probes[1].at: found no such key, which is required; allowed {uv: [u, v]} "
       "| {nearest: [x, y, z]}"},
      {"ProbeNearest",
       Edit("nearest: [0, 0, 300]", "nearest: [0, 300]"),
       "39: probes[1].at.nearest: found a list of 2; allowed a list of three numbers, "
       "[x, y, z]"},
      {"ExpectNoTolerance",
       Edit("    relative_tolerance: 0.02\n", ""),
       "41: expect[0]: found no tolerance; allowed exactly one of relative_tolerance "
       "| absolute_tolerance"},
      {"ExpectTwoTolerances",
       Edit("    relative_tolerance: 0.02\n",
            "    relative_tolerance: 0.02\n"
            "    absolute_tolerance: 0.02\n"),
       "41: expect[0]: found two tolerances; allowed exactly one of "
       "relative_tolerance | absolute_tolerance"},
      {"ExpectToleranceZero",
       Edit("relative_tolerance: 0.02", "relative_tolerance: 0"),
       "43: expect[0].relative_tolerance: found 0; allowed a number > 0"},
      {"ExpectRelativeToZero",
       Edit("absolute_tolerance: 1", "relative_tolerance: 1"),
       "45: expect[1].relative_tolerance: found a relative tolerance of the value 0; "
       "allowed absolute_tolerance"},
      {"ExpectUnknownProbe",
       Edit("probes.under_load", "probes.underload"),
       "41: expect[0].quantity: found the probe 'underload'; allowed under_load | "
       "top; did you mean 'under_load'?"},
      {"ExpectQuantity",
       Edit("load_steps[0].factor", "load steps"),
       "45: expect[1].quantity: found \"load steps\"; allowed a path into summary.json, "
       "such as probes.NAME.displacement.z"},
      {"ExpectValueText",
       Edit("value: -1.8e-5", "value: small"),
       "42: expect[0].value: found 'small' (*); allowed a number or a constant "
       "expression such as pi/2"},
      {"ExpectWithoutValue",
       Edit("    value: -1.8e-5\n", ""),
       "41: expect[0].value: found no such key, which is required; allowed a number"},
  };
}

// A scene on a surface that is a mesh, in line 2; `more` begins in line 4.
std::string OnMesh(const std::string& surface, const std::string& more = "") {
  return "name: mesh\nsurface: {" + surface +
         "}\nshell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0}\n" + more;
}

std::string MeshFile(const std::string& name) {
  return "kind: mesh, file: " DARBOUX_DATA_DIR "/" + name;
}

constexpr char kIcosphere[] = "kind: icosphere, radius: 2, frequency: 3";
constexpr char kBall[] =
    "kind: implicit, function: x^2+y^2+z^2-1, bounds: [[-2, 2], [-2, 2], [-2, 2]], edge_length: "
    "0.5";

// kBall with the first occurrence of `find` replaced.
std::string Ball(const std::string& find, const std::string& replace) {
  std::string text = kBall;
  text.replace(text.find(find), find.size(), replace);
  return OnMesh(text);
}

std::vector<Mistake> MeshMistakes() {
  const std::string kNoDefects = "; allowed is a mesh without defects; --repair mends some of them";
  const std::string kFolder = DARBOUX_DATA_DIR "/broken_meshes/";
  return {
      {"NoFile",
       OnMesh("kind: mesh"),
       "2: surface.file: found no such key, which is required; allowed the name of an .obj, .ply, "
       ".stl or .off file"},
      {"FileList",
       OnMesh("kind: mesh, file: [a.obj]"),
       "2: surface.file: found a list of 1; allowed the name of an .obj, .ply, .stl or .off file"},
      {"MissingFile",
       OnMesh(MeshFile("broken_meshes/missing.obj")),
       "2: surface.file: " + kFolder +
           "missing.obj:0: found a file that cannot be read (*); allowed a mesh file"},
      {"MissingFileInTheCurrentFolder",
       OnMesh("kind: mesh, file: missing.obj"),
       "2: surface.file: missing.obj:0: found a file that cannot be read (*); allowed a mesh file"},
      {"UnreadableFile",
       OnMesh(MeshFile("broken_meshes/index_too_large.obj")),
       "2: surface.file: " + kFolder +
           "index_too_large.obj:14: found vertex 7 in face 7; allowed 1 to 6"},
      {"NoMeshFile",
       OnMesh(MeshFile("README.md")),
       "2: surface.file: " DARBOUX_DATA_DIR
       "/README.md:0: found a name that ends with '.md'; allowed .obj | .ply | .stl | .off"},
      {"MeshSeam",
       OnMesh(MeshFile("broken_meshes/seam.obj")),
       "2: surface.file: found " + kFolder +
           "seam.obj: 2 vertices that coincide with others and leave a seam open: 6 (at 0), 13 (at "
           "7)" +
           kNoDefects},
      {"MeshEdge",
       OnMesh(MeshFile("broken_meshes/non_manifold_edge.ply")),
       "2: surface.file: found " + kFolder +
           "non_manifold_edge.ply: 1 edge with more than two triangles: 0-1 (triangles 0, 1, 2)" +
           kNoDefects},
      {"MeshPieces",
       OnMesh(MeshFile("broken_meshes/two_components.obj")),
       "2: surface.file: found " + kFolder +
           "two_components.obj: 2 separate pieces instead of 1: 8 triangles from triangle 0, 8 "
           "triangles from triangle 8" +
           kNoDefects},
      {"MeshTwoDefects",
       OnMesh(MeshFile("broken_meshes/crossing_along_edges.obj")),
       "2: surface.file: found " + kFolder +
           "crossing_along_edges.obj: 2 separate pieces instead of 1: 8 triangles from triangle 0, "
           "8 triangles from triangle 8; and 1 more defect" +
           kNoDefects},
      {"MeshDefectBeforeOtherSections",
       OnMesh(MeshFile("broken_meshes/inside_out.stl"), "probes: 3\n"),
       "2: surface.file: found " + kFolder +
           "inside_out.stl: 1 closed piece inside out, with normals that point inwards: 8 "
           "triangles "
           "from triangle 0" +
           kNoDefects},
      {"Fit",
       OnMesh(MeshFile("duck_642.obj") + ", fit: interpolated"),
       "2: surface.fit: found 'interpolated'; allowed control | interpolate; did you mean "
       "'interpolate'?"},
      {"RefineNegative",
       OnMesh(MeshFile("duck_642.obj") + ", refine: -1"),
       "2: surface.refine: found -1; allowed an integer from 0 to 6"},
      {"RefineTooOften",
       OnMesh(MeshFile("duck_642.obj") + ", refine: 7"),
       "2: surface.refine: found 7; allowed an integer from 0 to 6"},
      {"RefineReal",
       OnMesh(MeshFile("duck_642.obj") + ", refine: 0.5"),
       "2: surface.refine: found 0.5; allowed an integer from 0 to 6"},
      {"RefineTooLarge",
       OnMesh("kind: icosphere, radius: 1, frequency: 20, refine: 6"),
       "2: surface.refine: found 6, which makes 16384002 vertices; allowed at most 10000000 "
       "vertices"},
      {"FrequencyZero",
       OnMesh("kind: icosphere, radius: 1, frequency: 0"),
       "2: surface.frequency: found 0; allowed an integer from 1 to 400"},
      {"FrequencyTooLarge",
       OnMesh("kind: icosphere, radius: 1, frequency: 401"),
       "2: surface.frequency: found 401; allowed an integer from 1 to 400"},
      {"NoFrequency",
       OnMesh("kind: icosphere, radius: 1"),
       "2: surface.frequency: found no such key, which is required; allowed an integer from 1 to "
       "400"},
      {"IcosphereRadius",
       OnMesh("kind: icosphere, radius: 0, frequency: 3"),
       "2: surface.radius: found 0; allowed a number > 0"},
      {"FileOnAnIcosphere",
       OnMesh(std::string(kIcosphere) + ", file: a.obj"),
       "2: surface.file: found a key of kind mesh; allowed with kind icosphere: radius | frequency "
       "| kind | fit | refine | refine_near"},
      {"RefineNearNoList",
       OnMesh(std::string(kIcosphere) + ", refine_near: {near: [0, 0, 1], radius: 1, levels: 1}"),
       "2: surface.refine_near: found a map; allowed a list of {near: [x, y, z], radius: r, "
       "levels: "
       "n}"},
      {"RefineNearWithoutLevels",
       OnMesh(std::string(kIcosphere) + ", refine_near: [{near: [0, 0, 1], radius: 1}]"),
       "2: surface.refine_near[0].levels: found no such key, which is required; allowed an integer "
       "from 1 to 10"},
      {"RefineNearTooFine",
       OnMesh(std::string(kIcosphere) +
              ", refine_near: [{near: [0, 0, 1], radius: 1, levels: 11}]"),
       "2: surface.refine_near[0].levels: found 11; allowed an integer from 1 to 10"},
      {"RefineNearInside",
       OnMesh(std::string(kIcosphere) +
              ", refine_near: [{near: [0, 0, 1], radius: -1, levels: 1}]"),
       "2: surface.refine_near[0].radius: found -1; allowed a number >= 0"},
      {"DivisionsOnAMesh",
       OnMesh(MeshFile("duck_642.obj") + ", divisions: [4, 4]"),
       "2: surface.divisions: found an unknown key; allowed file | kind | fit | refine | "
       "refine_near"},
      {"NoFunction",
       Ball("function: x^2+y^2+z^2-1, ", ""),
       "2: surface.function: found no such key, which is required; allowed an expression of x, y "
       "and z"},
      {"FunctionOfU",
       Ball("x^2", "u^2"),
       "2: surface.function: found 'u^2+y^2+z^2-1' (*); allowed an expression of x, y and z"},
      {"FunctionNegativeOutside",
       Ball("x^2+y^2+z^2-1", "1-x^2-y^2-z^2"),
       "2: surface.function: the function is negative at the bounds, outside the closed surface; "
       "it has to be negative inside and positive outside: change its sign"},
      {"FunctionWithoutZero",
       Ball("z^2-1", "z^2+1"),
       "2: surface.function: the function has no zero within the bounds: it is positive at all of "
       "1331 points, nearest to zero with 1.00076 at (*); a surface needs both signs, and to be "
       "larger "
       "than the edge length 0.5"},
      {"NoBounds",
       Ball("bounds: [[-2, 2], [-2, 2], [-2, 2]], ", ""),
       "2: surface.bounds: found no such key, which is required; allowed a list of three ranges, "
       "[[x0, x1], [y0, y1], [z0, z1]]"},
      {"BoundsOfTwo",
       Ball("[-2, 2], [-2, 2]]", "[-2, 2]]"),
       "2: surface.bounds: found a list of 2; allowed a list of three ranges, [[x0, x1], [y0, y1], "
       "[z0, z1]]"},
      {"BoundsReversed",
       Ball("[-2, 2]]", "[2, -2]]"),
       "2: surface.bounds[2]: found [2, -2]; allowed a list of two ascending numbers, [lower, "
       "upper]"},
      {"BoundsTooNarrow",
       Ball("[-2, 2]]", "[-2, 0.5]]"),
       "2: surface.bounds: the surface leaves the bounds at (*) through the plane z = 0.5; allowed "
       "is a closed surface within the bounds, or open: true to cut it there"},
      {"EdgeLengthZero",
       Ball("edge_length: 0.5", "edge_length: 0"),
       "2: surface.edge_length: found 0; allowed a number > 0"},
      {"EdgeLengthTooLarge",
       Ball("edge_length: 0.5", "edge_length: 5"),
       "2: surface.edge_length: edge length 5; allowed is > 0 and at most the shortest side of the "
       "bounds, 4"},
      {"OpenNoBool",
       Ball("edge_length: 0.5", "edge_length: 0.5, open: 1"),
       "2: surface.open: found 1; allowed true | false"},
      {"ParametersOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "loads: [{kind: pressure, value: cos(u)}]\n"),
       "4: loads[0].value: found 'cos(u)', which names u or v; allowed a number or an expression "
       "of "
       "x, y, z, as surfaces of kind mesh have no parameters"},
      {"ParametersOnAnIcosphere",
       OnMesh(kIcosphere, "loads: [{kind: traction, force: [0, v, 0]}]\n"),
       "4: loads[0].force[1]: found 'v', which names u or v; allowed a number or an expression of "
       "x, "
       "y, z, as surfaces of kind icosphere have no parameters"},
      {"NotFiniteOnAnIcosphere",
       OnMesh(kIcosphere, "loads: [{kind: pressure, value: log(z)}]\n"),
       "4: loads[0].value: found 'log(z)', which is not finite at x = 0, y = -1.051, z = -1.701; "
       "allowed an expression that is finite wherever it acts"},
      {"UvOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "probes: [{name: a, at: {uv: [0, 0]}}]\n"),
       "4: probes[0].at.uv[0]: found the parameter u; allowed {nearest: [x, y, z]}, as surfaces of "
       "kind mesh have no parameters u and v"},
      {"LineOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "loads: [{kind: line, along: {v: 1}, force: [0, 0, 1]}]\n"),
       "4: loads[0].along.v: found the parameter v; allowed {nearest: [x, y, z]}, as surfaces of "
       "kind mesh have no parameters u and v"},
      {"SeedGhostsOnAMesh",
       OnMesh(MeshFile("duck_642.obj"), "model: {boundary_rule: seed_ghosts}\n"),
       "4: model.boundary_rule: found 'seed_ghosts' on a mesh; allowed independent, or a "
       "parametric "
       "surface"},
      {"SideOnAClosedMesh",
       OnMesh(MeshFile("duck_642.obj"), "supports: [{on: u_min, clamped: true}]\n"),
       "4: supports[0].on: found 'u_min', which surfaces of kind mesh do not have; allowed {near: "
       "[x, y, z], radius: r}"},
      {"RimOnAClosedMesh",
       OnMesh(MeshFile("duck_642.obj"), "supports: [{on: rim, clamped: true}]\n"),
       "4: supports[0].on: found 'rim', which a closed surface does not have; allowed {near: [x, "
       "y, "
       "z], radius: r}"},
      {"EdgeOnAClosedMesh",
       OnMesh(kIcosphere, "loads: [{kind: edge, on: rim, force: [0, 0, 1]}]\n"),
       "4: loads[0].on: found 'rim', which a closed surface does not have; allowed no edge, as the "
       "surface is closed"},
      {"SideOnAnOpenMesh",
       OnMesh(MeshFile("broken_meshes/quad_not_planar.obj"),
              "supports: [{on: v_max, clamped: true}]\n"),
       "4: supports[0].on: found 'v_max', which surfaces of kind mesh do not have; allowed rim | "
       "{near: [x, y, z], radius: r}"},
  };
}

class SceneReaderMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneReaderMistakeTest, IsReportedWithPlaceAndRemedy) {
  const std::string error = ErrorOf(GetParam().text);
  EXPECT_TRUE(Matches(error, std::string(kFile) + ":" + GetParam().message))
      << error << "\nis not\n"
      << kFile << ":" << GetParam().message;
}

INSTANTIATE_TEST_SUITE_P(Scene,
                         SceneReaderMistakeTest,
                         ::testing::ValuesIn(Mistakes()),
                         [](const ::testing::TestParamInfo<Mistake>& info) {
                           return info.param.name;
                         });

INSTANTIATE_TEST_SUITE_P(Mesh,
                         SceneReaderMistakeTest,
                         ::testing::ValuesIn(MeshMistakes()),
                         [](const ::testing::TestParamInfo<Mistake>& info) {
                           return info.param.name;
                         });

// ---- Meshes ----------------------------------------------------------------------------------

TEST(SceneReaderTest, MeshesAreReadAsControlPoints) {
  const Scene scene = Parse(OnMesh(MeshFile("duck_642.obj"), "supports: []\n"));
  EXPECT_EQ(scene.surface.kind, "mesh");
  EXPECT_EQ(scene.surface.surface, nullptr);
  ASSERT_NE(scene.surface.mesh, nullptr);
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 642u);
  EXPECT_FALSE(scene.surface.interpolate);
  EXPECT_FALSE(scene.surface.is_open);
  EXPECT_TRUE(scene.surface.mended.empty());
  EXPECT_TRUE(Parse(OnMesh(MeshFile("duck_642.obj") + ", fit: interpolate")).surface.interpolate);
  EXPECT_TRUE(Parse(OnMesh(MeshFile("broken_meshes/quad_not_planar.obj"))).surface.is_open);
}

TEST(SceneReaderTest, OtherMeshesAreReadAsPointsOfTheSurface) {
  for (const char* surface : {kIcosphere, kBall}) {
    const Scene scene = Parse(OnMesh(surface));
    ASSERT_NE(scene.surface.mesh, nullptr);
    EXPECT_TRUE(scene.surface.interpolate);
    EXPECT_FALSE(scene.surface.is_open);
    const double radius = surface == kBall ? 1.0 : 2.0;
    for (const Eigen::Vector3d& x : scene.surface.mesh->vertices) {
      EXPECT_NEAR(x.norm(), radius, 1e-11);
    }
    EXPECT_FALSE(Parse(OnMesh(surface + std::string(", fit: control"))).surface.interpolate);
  }
}

TEST(SceneReaderTest, ImplicitSurfacesMayBeCutAlongTheBounds) {
  std::string text = Ball("[-2, 2]]", "[-2, 0.5]]");
  text.replace(text.find("edge_length"), 0, "open: true, ");
  const SurfaceSpec surface = Parse(text + "supports: [{on: rim, clamped: true}]\n").surface;
  EXPECT_TRUE(surface.is_open);
  double highest = -1.0;
  for (const Eigen::Vector3d& x : surface.mesh->vertices) highest = std::max(highest, x.z());
  EXPECT_EQ(highest, 0.5);
}

TEST(SceneReaderTest, RefinementQuadruplesTheTrianglesOfTheSameSurface) {
  const TriangleMesh coarse = *Parse(OnMesh(MeshFile("duck_642.obj"))).surface.mesh;
  const SurfaceSpec fine = Parse(OnMesh(MeshFile("duck_642.obj") + ", refine: 2")).surface;
  EXPECT_EQ(fine.mesh->triangles.size(), 16u * coarse.triangles.size());
  EXPECT_FALSE(fine.interpolate);
  // Control points now, of the surface through the coarse points.
  const SurfaceSpec sphere = Parse(OnMesh(kIcosphere + std::string(", refine: 1"))).surface;
  EXPECT_EQ(sphere.mesh->vertices.size(), 10u * 36u + 2u);
  EXPECT_FALSE(sphere.interpolate);
}

TEST(SceneReaderTest, MeshesAreInTheFolderOfTheirScene) {
  const std::string folder = ::testing::TempDir() + "/scene_reader_" + std::to_string(getpid());
  std::filesystem::create_directories(folder + "/meshes");
  std::filesystem::copy_file(DARBOUX_DATA_DIR "/duck_642.obj",
                             folder + "/meshes/duck.obj",
                             std::filesystem::copy_options::overwrite_existing);
  const std::string file = folder + "/scene.yaml";
  std::ofstream(file) << OnMesh("kind: mesh, file: meshes/duck.obj");
  Scene scene;
  std::string error;
  EXPECT_TRUE(ReadScene(file, &scene, &error)) << error;
  ASSERT_NE(scene.surface.mesh, nullptr);
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 642u);
  std::ofstream(file) << OnMesh("kind: mesh, file: duck.obj");
  EXPECT_FALSE(ReadScene(file, &scene, &error));
  EXPECT_THAT(error, StartsWith(file + ":2: surface.file: " + folder + "/duck.obj:0: found "));
  std::filesystem::remove_all(folder);
}

TEST(SceneReaderTest, RepairMendsMeshesAndSaysSo) {
  ReadOptions options;
  options.repair = true;
  Scene scene;
  std::string error;
  ASSERT_TRUE(
      ParseScene(OnMesh(MeshFile("broken_meshes/seam.obj")), kFile, &scene, &error, options))
      << error;
  EXPECT_EQ(scene.surface.mesh->vertices.size(), 12u);
  ASSERT_EQ(scene.surface.mended.size(), 2u);
  EXPECT_EQ(scene.surface.mended[0],
            "mended " DARBOUX_DATA_DIR
            "/broken_meshes/seam.obj: sewed 2 vertices that coincide with others and leave a seam "
            "open: 6 (at 0), 13 (at 7)");
  EXPECT_FALSE(
      ParseScene(OnMesh(MeshFile("broken_meshes/bow_tie.obj")), kFile, &scene, &error, options));
  EXPECT_EQ(error,
            "roof.yaml:2: surface.file: found " DARBOUX_DATA_DIR
            "/broken_meshes/bow_tie.obj: 1 vertex where several fans of triangles meet in a point: "
            "0; allowed is a mesh without defects; --repair mends no more");
}

TEST(SceneReaderTest, LongOrUnprintableWordsAreQuotedInOneShortLine) {
  const std::string error = ErrorOf(Edit("steps: 4", "\"a\\n" + std::string(500, 'b') + "\": 4"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
  EXPECT_LT(error.size(), 300u);
  EXPECT_EQ(error.find("roof.yaml:36: a?bbb"), 0u) << error;
}

TEST(SceneReaderTest, DeepNestingIsAnErrorNotACrash) {
  for (const char* piece : {"[", "{", "- ", "? ", "[a: ", "{a: "}) {
    std::string text;
    while (text.size() < 200000) text += piece;
    EXPECT_EQ(ErrorOf(text).find("roof.yaml:1: scene: found a YAML mistake"), 0u) << piece;
  }
  EXPECT_EQ(ErrorOf("&a [*a]\n"),
            "roof.yaml:1: scene: found a list of 1; allowed a map with the keys name, surface, "
            "shell, ...");
  EXPECT_EQ(ErrorOf(Edit("radius: 300", "radius: " + std::string(100000, '('))).find('\n'),
            std::string::npos);
}

// ---- Every line deleted, cut and mangled -----------------------------------------------------

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin);
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Whether the text is accepted; if not, checks the form of the message.
bool IsAcceptedOrExplained(const std::string& text) {
  Scene scene;
  std::string error;
  if (ParseScene(text, kFile, &scene, &error)) return true;
  const std::string prefix = std::string(kFile) + ":";
  EXPECT_EQ(error.compare(0, prefix.size(), prefix), 0) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  EXPECT_NE(error.find("; allowed "), std::string::npos) << error;
  const int line = std::atoi(error.c_str() + prefix.size());
  EXPECT_GE(line, 1) << error;
  EXPECT_LE(line, std::count(text.begin(), text.end(), '\n') + 1) << error;
  return false;
}

TEST(SceneReaderTest, DamagedLinesAreAcceptedOrExplained) {
  std::mt19937 generator(38401);
  const auto below = [&generator](size_t n) {
    return std::uniform_int_distribution<size_t>(0, n - 1)(generator);
  };
  const std::string alphabet = "[]{}:,-#&*!|>'\"%@` \t\n\r\x01\x04\xC3\xFF~?0a.e";
  const std::vector<std::string> lines = Lines(FullScene());
  int accepted = 0, refused = 0;
  const auto check = [&](const std::vector<std::string>& damaged) {
    ++(IsAcceptedOrExplained(JoinLines(damaged)) ? accepted : refused);
  };
  for (size_t i = 0; i < lines.size(); ++i) {
    std::vector<std::string> damaged = lines;
    damaged.erase(damaged.begin() + i);
    check(damaged);
    damaged = lines;
    damaged.insert(damaged.begin() + i, lines[i]);  // Doubled.
    check(damaged);
    for (size_t length = 0; length < lines[i].size(); length += 3) {
      damaged = lines;
      damaged[i].resize(length);
      check(damaged);
    }
    for (int k = 0; k < 15; ++k) {
      damaged = lines;
      for (size_t n = 0; n <= below(3) && !damaged[i].empty(); ++n) {
        const size_t at = below(damaged[i].size());
        switch (below(4)) {
          case 0:
            damaged[i][at] = alphabet[below(alphabet.size())];
            break;
          case 1:
            damaged[i].insert(at, 1, alphabet[below(alphabet.size())]);
            break;
          case 2:
            damaged[i].erase(at, 1);
            break;
          default:
            std::swap(damaged[i][at], damaged[i][below(damaged[i].size())]);
        }
      }
      check(damaged);
    }
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 500);
}

TEST(SceneReaderTest, FilesCutShortAreAcceptedOrExplained) {
  const std::string text = FullScene();
  for (size_t length = 0; length < text.size(); ++length) {
    IsAcceptedOrExplained(text.substr(0, length));
  }
}

// ---- Files -----------------------------------------------------------------------------------

TEST(SceneReaderTest, ReadsFiles) {
  const std::string file = ::testing::TempDir() + "scene_reader_test.yaml";
  std::ofstream(file) << FullScene();
  Scene scene;
  std::string error;
  EXPECT_TRUE(ReadScene(file, &scene, &error)) << error;
  EXPECT_EQ(scene.name, "roof");
  EXPECT_EQ(scene.supports[0].location.file, file);

  std::ofstream(file) << Edit("radius: 300", "radius: 0");
  EXPECT_FALSE(ReadScene(file, &scene, &error));
  EXPECT_EQ(error, file + ":4: surface.radius: found 0; allowed a number > 0");

  std::ofstream(file) << std::string(2000000, ' ');
  EXPECT_FALSE(ReadScene(file, &scene, &error));
  EXPECT_EQ(error,
            file +
                ":1: scene: found more than 1048576 bytes; allowed a scene of at most 1048576 "
                "bytes");
  EXPECT_EQ(scene.name, "roof");
  std::remove(file.c_str());
}

TEST(SceneReaderTest, MissingFilesAndDirectoriesAreErrors) {
  Scene scene;
  std::string error;
  EXPECT_FALSE(ReadScene("no_such_scene.yaml", &scene, &error));
  EXPECT_EQ(error,
            "no_such_scene.yaml:0: scene: found a file that cannot be read (No such file or "
            "directory); allowed a scene in YAML");
  const std::string folder = ::testing::TempDir();
  EXPECT_FALSE(ReadScene(folder, &scene, &error));
  EXPECT_EQ(error,
            folder +
                ":0: scene: found a file that cannot be read (it is a directory); allowed a "
                "scene in YAML");
}

// ---- Overrides -------------------------------------------------------------------------------

TEST(SceneOverridesTest, ReplaceWhatTheyName) {
  Scene scene = Parse(FullScene());
  SceneOverrides overrides;
  std::string error;
  ASSERT_TRUE(ApplyOverrides(overrides, &scene, &error)) << error;
  EXPECT_EQ(scene.model.theory, Theory::kLinear);
  EXPECT_EQ(scene.surface.divisions, (std::array<int, 2>{16, 8}));
  overrides.theory = "nonlinear";
  overrides.strains = "koiter";
  overrides.minimizer = "auto";
  overrides.quadrature = 12;
  overrides.divisions = "3,70";
  ASSERT_TRUE(ApplyOverrides(overrides, &scene, &error)) << error;
  EXPECT_EQ(scene.model.theory, Theory::kNonlinear);
  EXPECT_EQ(scene.model.strains, Strains::kKoiter);
  EXPECT_EQ(scene.model.minimizer, Minimizer::kAuto);
  EXPECT_EQ(scene.model.quadrature, 12);
  EXPECT_EQ(scene.surface.divisions, (std::array<int, 2>{3, 70}));
}

struct OverrideMistake {
  SceneOverrides overrides;
  std::string message;
};

OverrideMistake Divisions(const std::string& text, const std::string& allowed) {
  SceneOverrides overrides;
  overrides.divisions = text;
  return {overrides, "--divisions: found '" + text + "'; allowed " + allowed};
}

class SceneOverridesMistakeTest : public ::testing::TestWithParam<OverrideMistake> {};

TEST_P(SceneOverridesMistakeTest, IsReportedAndNothingChanges) {
  Scene scene = Parse(Edit("v: [0, pi/2]", "v: [0, 2*pi]"));
  scene.surface.periodic = {false, true};
  SceneOverrides overrides = GetParam().overrides;
  // Valid ones beside the mistake.
  if (!overrides.theory) overrides.theory = "nonlinear";
  if (!overrides.divisions) overrides.divisions = "5,6";
  std::string error;
  EXPECT_FALSE(ApplyOverrides(overrides, &scene, &error));
  EXPECT_EQ(error, GetParam().message);
  EXPECT_EQ(scene.model.theory, Theory::kLinear);
  EXPECT_EQ(scene.model.quadrature, 6);
  EXPECT_EQ(scene.surface.divisions, (std::array<int, 2>{16, 8}));
}

INSTANTIATE_TEST_SUITE_P(
    Flags,
    SceneOverridesMistakeTest,
    ::testing::Values(
        OverrideMistake{{"liner", {}, {}, {}, {}},
                        "--theory: found 'liner'; allowed auto | linear | nonlinear; did you mean "
                        "'linear'?"},
        OverrideMistake{{{}, "sanders", {}, {}, {}},
                        "--strains: found 'sanders'; allowed koiter | seed"},
        OverrideMistake{{{}, {}, "newton", {}, {}},
                        "--minimizer: found 'newton'; allowed auto | mip | ceres | cg"},
        OverrideMistake{{{}, {}, {}, 7, {}},
                        "--quadrature: found 7; allowed 1, 3, 6 or 12 points per triangle"},
        Divisions("", "M,N with two integers > 0"),
        Divisions("16", "M,N with two integers > 0"),
        Divisions("16,", "M,N with two integers > 0"),
        Divisions("16,8,4", "M,N with two integers > 0"),
        Divisions("16;8", "M,N with two integers > 0"),
        Divisions("1.5,8", "M,N with two integers > 0"),
        Divisions("16, 8", "M,N with two integers > 0"),
        Divisions("99999999999,8", "M,N with two integers > 0"),
        Divisions("0,8", "an integer >= 1 for u"),
        Divisions("-1,8", "an integer >= 1 for u"),
        Divisions("16,2", "an integer >= 4 for v, which is periodic"),
        Divisions("10000,10000", "at most 10000000 vertices")));

// ---- Names -----------------------------------------------------------------------------------

TEST(SceneReaderPathTest, PathIsRead) {
  const Scene none = Parse(Minimal(""));
  EXPECT_EQ(none.path.control, PathControl::kLoad);
  const Scene arc = Parse(Minimal("path: {control: arc_length, max_steps: 40}\n"));
  EXPECT_EQ(arc.path.control, PathControl::kArcLength);
  EXPECT_EQ(arc.path.max_steps, 40);
  const Scene displacement =
      Parse(Minimal("path: {to: -0.5, control: displacement, component: y, probe: b}\n"
                    "probes: [{name: a, at: {uv: [0, 0]}}, {name: b, at: {uv: [1, 1]}}]\n"));
  EXPECT_EQ(displacement.path.control, PathControl::kDisplacement);
  EXPECT_EQ(displacement.path.probe, 1);
  EXPECT_EQ(displacement.path.component, 1);
  EXPECT_EQ(displacement.path.to, -0.5);
}

TEST(SceneTest, EnumsHaveTheNamesOfTheFile) {
  EXPECT_STREQ(ToString(Minimizer::kAuto), "auto");
  EXPECT_STREQ(ToString(Minimizer::kMip), "mip");
  EXPECT_STREQ(ToString(Minimizer::kCeres), "ceres");
  EXPECT_STREQ(ToString(Minimizer::kCg), "cg");
  EXPECT_STREQ(ToString(PathControl::kLoad), "load");
  EXPECT_STREQ(ToString(PathControl::kDisplacement), "displacement");
  EXPECT_STREQ(ToString(PathControl::kArcLength), "arc_length");
  EXPECT_STREQ(ToString(Theory::kAuto), "auto");
  EXPECT_STREQ(ToString(Theory::kLinear), "linear");
  EXPECT_STREQ(ToString(Theory::kNonlinear), "nonlinear");
  EXPECT_STREQ(ToString(Strains::kKoiter), "koiter");
  EXPECT_STREQ(ToString(Strains::kSeed), "seed");
  EXPECT_STREQ(ToString(BoundaryRule::kIndependent), "independent");
  EXPECT_STREQ(ToString(BoundaryRule::kSeedGhosts), "seed_ghosts");
}

}  // namespace
}  // namespace darboux
