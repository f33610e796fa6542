// model.accuracy on meshes: what its answers cost and how far off they are. References are our own:
// meshes refined until the estimate was 0.02 to 0.05 %, points of contact 0.05 or 0.075 of a
// finger's radius apart, extrapolated to none.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <ostream>
#include <string>

#include "solver/accuracy.h"
#include "solver/goal_response.h"
#include "solver/mesh_adaptation.h"
#include "tests/mesh_util.h"
#include "tests/refine_util.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// A ball between two fingertips, frictionless.
std::string Ball(const char* thickness,
                 const char* finger,
                 const char* travel,
                 int frequency = 12) {
  std::string text = "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: " +
                     std::to_string(frequency) +
                     "}\n"
                     "shell: {thickness: H, young_modulus: 1, poisson_ratio: 0.5}\n"
                     "supports:\n"
                     "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
                     "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
                     "fingers:\n"
                     "  - {name: top, shape: {kind: sphere, radius: R}, position: [0, 0, 60], "
                     "direction: [0, 0, -1], motion: {travel: T}}\n"
                     "  - {name: bottom, shape: {kind: sphere, radius: R}, position: [0, 0, -60], "
                     "direction: [0, 0, 1], motion: {travel: T}}\n";
  for (size_t i = text.size(); i-- > 2;) {
    if (text[i - 1] != ' ') continue;
    if (text.compare(i, 2, "H,") == 0) text.replace(i, 1, thickness);
    if (text.compare(i, 2, "R}") == 0) text.replace(i, 1, finger);
    if (text.compare(i, 2, "T}") == 0) text.replace(i, 1, travel);
  }
  return text;
}

// A free ball squeezed by Gaussian tractions, in the linear theory.
constexpr char kPatches[] =
    "name: patch-ball\nsurface: {kind: icosphere, radius: 1, frequency: 12}\n"
    "shell: {thickness: 0.05, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
    "model: {theory: linear}\n"
    "loads: [{kind: traction, force: [\"-sign(x)*exp(-10*(y*y+z*z))\", \"0\", \"0\"]}]\n"
    "probes: [{name: pole, at: {nearest: [1, 0, 0]}}]\n";

struct Case {
  const char* name;
  std::string text;  // empty: data/NAME.yaml
  double accuracy;
  const char* goal;  // of GoalsOf; component x
  double reference;
  int most_dof;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name << " to " << c.accuracy; }

Scene SceneOf(const Case& c) {
  Scene scene =
      c.text.empty() ? SceneFromData(std::string(c.name) + ".yaml") : SceneFromText(c.text);
  scene.model.accuracy = c.accuracy;
  return scene;
}

double ErrorOf(const Case& c, const Scene& scene, const SolverSummary& summary) {
  for (const Goal& goal : GoalsOf(scene, summary)) {
    if (goal.name == c.goal) return std::abs(goal.value.x() - c.reference) / goal.size;
  }
  ADD_FAILURE() << c.goal;
  return 0.0;
}

class MeshAccuracyTest : public ::testing::TestWithParam<Case> {};

TEST_P(MeshAccuracyTest, EstimateIsTheErrorWithinAFactorForFewUnknowns) {
  const Case& c = GetParam();
  const Scene scene = SceneOf(c);
  const double start = CpuSeconds();
  const Refined refined = Refine(scene);
  const double seconds = CpuSeconds() - start;
  ASSERT_TRUE(refined.report.reached) << refined.report.message;
  const double error = ErrorOf(c, scene, refined.summary);
  const double effectivity = *refined.report.estimate / error;
  std::string levels;
  for (const AccuracyLevel& level : refined.report.levels) {
    levels += (levels.empty() ? "" : ", ") + std::to_string(level.dof);
  }
  std::printf(
      "  %-19s accuracy %.0e: %s dof, error %.2e, estimate %.2e, effectivity %.2f, %.1f s\n",
      c.name,
      c.accuracy,
      levels.c_str(),
      error,
      *refined.report.estimate,
      effectivity,
      seconds);
  EXPECT_LE(error, c.accuracy);
  EXPECT_GE(effectivity, 0.3);
  EXPECT_LE(effectivity, 5.0);
  EXPECT_LE(refined.summary.dof, c.most_dof);
  // Not far past what was asked for either.
  EXPECT_GE(*refined.report.estimate, 0.1 * c.accuracy);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    MeshAccuracyTest,
    ::testing::Values(
        Case{"tennis_ball", "", 1e-2, "fingers.top.normal_force", 1.502, 900},
        Case{"tennis_ball", "", 3e-3, "fingers.top.normal_force", 1.502, 1500},
        Case{"thin ball", Ball("0.5", "2", "2"), 1e-2, "fingers.top.normal_force", 0.012397, 1700},
        Case{"thin ball", Ball("0.5", "2", "2"), 3e-3, "fingers.top.normal_force", 0.012397, 2800},
        Case{"wide fingers", Ball("2.5", "6", "2"), 1e-2, "fingers.top.normal_force", 0.7052, 1100},
        Case{"wide fingers", Ball("2.5", "6", "2"), 3e-3, "fingers.top.normal_force", 0.7052, 1400},
        Case{"tennis_ball_patches", "", 1e-2, "probes.equator", 0.10757921834906689, 2000}));

TEST(MeshAccuracyTest, TheTennisBallTakesAThirdOfTheUniformUnknownsForOnePercent) {
  // Uniform meshes of frequency 7 and 8: 1,476 dof, 1.4 %, and 1,926 dof, 0.6 %.
  const Case c{"tennis_ball", "", 1e-2, "fingers.top.normal_force", 1.502, 642};
  const Scene scene = SceneOf(c);
  AccuracyOptions options;
  options.max_dof = c.most_dof;
  const Refined refined = Refine(scene, options);
  EXPECT_LE(refined.summary.dof, c.most_dof);
  const double error = ErrorOf(c, scene, refined.summary);
  std::printf("  %d dof: error %.2e\n", refined.summary.dof, error);
  EXPECT_LE(error, c.accuracy);
  EXPECT_GE(*refined.report.estimate, error);
}

TEST(MeshAccuracyTest, AFirstMeshThatAFingerPassesThroughIsRefinedEverywhere) {
  // An icosahedron; the finger slips between its points of contact.
  Scene scene = SceneFromText(Ball("2.5", "0.5", "4", 1));
  scene.model.accuracy = 0.03;
  const Refined refined = Refine(scene);
  EXPECT_TRUE(refined.report.reached) << refined.report.message;
  EXPECT_EQ(refined.report.levels[0].dof, 3 * 42);
  EXPECT_THAT(refined.summary.decisions,
              Contains(HasSubstr("resolution: finer everywhere, as the scene does not converge on "
                                 "36 dof: finger top has travelled 4 without touching the shell")));
}

TEST(MeshAccuracyTest, AMeshWithAnEquilibriumAtPartOfTheLoadIsRefinedWhereThatNeedsIt) {
  Scene scene = SceneFromText(Ball("0.5", "1", "6", 3));
  scene.model.accuracy = 0.03;
  SolverOptions few;
  few.max_iterations = 25;
  const Refined refined = Refine(scene, {}, few);
  EXPECT_TRUE(refined.report.reached) << refined.report.message;
  EXPECT_THAT(refined.summary.decisions,
              Contains(HasSubstr("resolution: finer where its last equilibrium needs it, as the "
                                 "scene does not converge on 276 dof")));
}

TEST(MeshAccuracyTest, AFreeShellWhoseLoadsOnlyBalanceOnItsOwnMeshKeepsIt) {
  // No edges along the mirror plane of the loads at odd frequencies.
  Scene scene = SceneFromText(kPatches);
  scene.model.accuracy = 1e-3;
  const Refined refined = Refine(scene);
  ASSERT_TRUE(refined.report.reached) << refined.report.message;
  EXPECT_EQ(refined.report.levels[0].dof, 3 * 1442);
  EXPECT_THAT(refined.summary.decisions, Contains(HasSubstr("surface: the scene's own after all")));
  // Frequency 36: -1.746596e-5.
  const double error = std::abs(refined.summary.probes[0].displacement.x() / -1.746596e-5 - 1.0);
  EXPECT_LT(error, 5e-5);
}

TEST(MeshAccuracyTest, WhereEstimatesDoNotFallAnyMoreARunEnds) {
  // A clamped point has no limit that refinement around it would lead to.
  std::string text = kPatches;
  text.insert(text.find("loads:"),
              "supports: [{on: {near: [0, 0, -1], radius: 0}, clamped: true}]\n");
  Scene scene = SceneFromText(text);
  scene.model.accuracy = 3e-4;
  const Refined refined = Refine(scene);
  EXPECT_FALSE(refined.report.reached);
  EXPECT_THAT(refined.report.message, HasSubstr("estimates do not fall below"));
  EXPECT_LT(refined.summary.dof, 20000);
}

TEST(MeshAccuracyTest, WithoutRoomForItAMeshThatDoesNotConvergeIsTheAnswer) {
  Scene scene = SceneFromText(Ball("2.5", "0.5", "4", 1));
  scene.model.accuracy = 0.03;
  AccuracyOptions options;
  options.max_dof = 100;
  const Refined refined = Refine(scene, options);
  EXPECT_FALSE(refined.report.reached);
  EXPECT_FALSE(refined.summary.IsConverged());
  EXPECT_THAT(refined.report.message, HasSubstr("the next mesh would have more than 100 dof"));
}

TEST(MeshAccuracyTest, AMeshThatIsNoSphereOrThatTheSceneRefinesKeepsItsShape) {
  SurfaceSpec surface = SceneFromText(Ball("2.5", "2", "2", 6)).surface;
  const std::shared_ptr<const TriangleMesh> mesh = surface.mesh;
  SurfaceSpec other = surface;
  other.kind = "mesh";
  EXPECT_EQ(MeshAdaptation::Begin(2.5, &other), "");
  EXPECT_EQ(other.mesh, mesh);
  other = surface;
  other.refine_near.emplace_back();
  EXPECT_EQ(MeshAdaptation::Begin(2.5, &other), "");
  EXPECT_EQ(other.sphere_radius, 0.0);
  other = surface;
  EXPECT_THAT(MeshAdaptation::Begin(2.5, &other), HasSubstr("begins with frequency 3"));
  EXPECT_EQ(other.mesh->vertices.size(), 92u);
  EXPECT_NEAR(other.sphere_radius, 31.25, 1e-12);
  // Thin: dents are smaller.
  other = surface;
  EXPECT_THAT(MeshAdaptation::Begin(0.5, &other), HasSubstr("begins with frequency 4"));
  other = surface;
  EXPECT_EQ(MeshAdaptation::Begin(0.05, &other),
            "surface: the control points are fitted to the sphere");
  EXPECT_EQ(other.mesh, mesh);
}

TEST(MeshAccuracyTest, ForcesConvergeWithPointsOfContactLikeTheSquareOfTheirSpacing) {
  Scene scene = SceneFromText(Ball("2.5", "2", "4", 6));
  double force[3];
  for (int k = 0; k < 3; ++k) {
    scene.model.contact_spacing = 0.3 / (1 << k);
    force[k] = SolveScene(scene).summary.steps.back().fingers[0].normal_force;
  }
  const double first = force[0] - force[1], second = force[1] - force[2];
  std::printf("  changes of the force %.2e and %.2e\n", first / force[2], second / force[2]);
  EXPECT_GT(first / second, 2.0);
  EXPECT_LT(first / second, 8.0);
  EXPECT_LT(std::abs(first), 4e-3 * force[2]);
}

}  // namespace
}  // namespace darboux
