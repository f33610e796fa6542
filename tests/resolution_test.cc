// Meshes that are too coarse for their answer are named, whatever it is that they cannot show.
#include "solver/resolution.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "tests/hard_util.h"

namespace darboux {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// An eighth of the pinched cylinder, n x n cells.
Solution PinchedCylinder(double thickness, int n, double unit = 1.0, int num_threads = 1) {
  SolverOptions options;
  options.num_threads = num_threads;
  const double force = unit * unit;  // stresses stay
  return SolveScene(
      SceneFromText(Fill(
          R"yaml(
name: pinched
surface: {kind: cylinder, radius: $r, u: [0, $r], v: [0, pi/2], divisions: [$n, $n]}
shell: {thickness: $h, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: u_min, fix: [y, z]}
  - {on: u_max, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, symmetry: z}
loads: [{kind: point, at: {uv: [$r, 0]}, force: [0, 0, -$f]}]
probes: [{name: under_load, at: {uv: [$r, 0]}}]
)yaml",
          {{"r", 300.0 * unit}, {"h", thickness * unit}, {"n", 1.0 * n}, {"f", 0.25 * force}})),
      options);
}

TEST(ResolutionTest, AMeshThatShowsTheAnswerIsSufficient) {
  // 0.3 % off.
  const Solution solution = PinchedCylinder(3.0, 32);
  ASSERT_TRUE(solution.summary.resolution.has_value());
  EXPECT_LT(solution.summary.resolution->roughness, 0.005);
  EXPECT_NEAR(solution.summary.resolution->turn, M_PI / 2.0 / 32, 0.2 * M_PI / 2.0 / 32);
  EXPECT_TRUE(solution.summary.resolution->IsSufficient());
  EXPECT_EQ(solution.summary.resolution->Complaint(), "");
}

TEST(ResolutionTest, AMeshThatLocksIsNot) {
  // Of the true deflection it has 0.07, the fine one 0.99.
  const Solution coarse = PinchedCylinder(0.03, 16), fine = PinchedCylinder(0.03, 96);
  EXPECT_LT(coarse.Probe().norm(), 0.1 * fine.Probe().norm());
  EXPECT_GT(coarse.summary.resolution->roughness, 0.4);
  EXPECT_FALSE(coarse.summary.resolution->IsSufficient());
  EXPECT_THAT(coarse.summary.decisions,
              Contains(AllOf(StartsWith("the mesh does not resolve the answer: stresses of "
                                        "neighbouring elements disagree by 0.4"),
                             HasSubstr("refine, or let model.accuracy do it"))));
  EXPECT_LT(fine.summary.resolution->roughness, 0.05);
}

TEST(ResolutionTest, BetweenTheTwoItIsCalledCoarse) {
  // 14 % off.
  const Resolution resolution = *PinchedCylinder(3.0, 8).summary.resolution;
  EXPECT_GT(resolution.roughness, Resolution::kDoubtfulRoughness);
  EXPECT_TRUE(resolution.IsSufficient());
  EXPECT_THAT(resolution.Complaint(), StartsWith("a coarse mesh: stresses of"));
}

TEST(ResolutionTest, ElementsThatRunAroundTheShellDoNotResolveItsShape) {
  // Each cell runs 82 degrees around the cylinder, and few points see nothing of it.
  const Solution solution = SolveScene(SceneFromText(R"yaml(
name: sheared
surface: {kind: expression, position: ["u", "300*sin(v + 11.43*u/300)", "300*cos(v + 11.43*u/300)"],
          u: [0, 600], v: [0, 2*pi], divisions: [16, 48], periodic: [false, true]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear, quadrature: 6}
supports: [{on: u_min, fix: [y, z]}, {on: u_max, fix: [y, z]}]
loads: [{kind: normal_traction, value: "cos(2*(v + 11.43*u/300))*sin(pi*u/600)"}]
)yaml"));
  EXPECT_FALSE(solution.summary.resolution->IsSufficient());
  EXPECT_THAT(solution.summary.resolution->Complaint(),
              StartsWith("the mesh does not resolve the shape: its normal turns by "));
}

TEST(ResolutionTest, DoesNotDependOnUnitsOrThreads) {
  const double one = PinchedCylinder(3.0, 24).summary.resolution->roughness;
  for (const double unit : {1e-3, 1e3}) {
    EXPECT_NEAR(PinchedCylinder(3.0, 24, unit).summary.resolution->roughness, one, 1e-6 * one);
  }
  EXPECT_NEAR(PinchedCylinder(3.0, 24, 1.0, 2).summary.resolution->roughness, one, 1e-6 * one);
}

TEST(ResolutionTest, NothingIsRoughAtRestOrInARigidMotion) {
  const Solution solution = SolveScene(SceneFromText(
      "name: still\n"
      "surface: {kind: sphere, radius: 5, u: [0, 1], v: [-0.5, 0.5], divisions: [8, 8]}\n"
      "shell: {thickness: 0.1, young_modulus: 1, poisson_ratio: 0.3}\n"
      "model: {theory: linear}\n"
      "supports: [{on: u_min, clamped: true}]\n"));
  EXPECT_EQ(solution.summary.resolution->roughness, 0.0);
  solution.problem->displacements().colwise() = Eigen::Vector3d(1.0, 2.0, 3.0);
  EXPECT_EQ(CheckResolution(*solution.problem, 1)->roughness, 0.0);
}

TEST(ResolutionTest, GraspsOfMeshesAreResolved) {
  const Solution solution = SolveScene(SceneFromData("ellipsoid_poke.yaml"));
  EXPECT_GT(solution.summary.resolution->roughness, 0.0);
  EXPECT_LT(solution.summary.resolution->roughness, 0.05);
}

}  // namespace
}  // namespace darboux
