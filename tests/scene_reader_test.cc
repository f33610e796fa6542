#include "solver/scene_reader.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/scene_reader_util.h"

namespace darboux {
namespace {

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
