#include "solver/accuracy_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/accuracy_util.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(StudyAxesTest, AreNamedAndCheckedByName) {
  std::vector<StudyAxis> axes;
  std::string error;
  ASSERT_TRUE(ParseStudyAxes("solver,resolution,solver", &axes, &error));
  EXPECT_THAT(axes, ElementsAre(StudyAxis::kSolver, StudyAxis::kResolution));
  EXPECT_FALSE(ParseStudyAxes("resolution,gradin", &axes, &error));
  EXPECT_THAT(error, HasSubstr("found 'gradin'"));
  EXPECT_THAT(error, HasSubstr("did you mean 'grading'?"));
  EXPECT_FALSE(ParseStudyAxes("", &axes, &error));
}

struct EndsCase {
  const char* name;
  const char* surface;
  const char* more;
  std::array<int, 2> ends;
};
class FavouredEndsTest : public ::testing::TestWithParam<EndsCase> {};
TEST_P(FavouredEndsTest, AreWhereTheSceneIsSingular) {
  const Scene scene = Plate(GetParam().more, "theory: linear", GetParam().surface);
  EXPECT_EQ(FavouredEnds(scene), GetParam().ends);
}
INSTANTIATE_TEST_SUITE_P(
    Scenes,
    FavouredEndsTest,
    ::testing::Values(
        EndsCase{"nothing", "divisions: [8, 4]", "", {0, 0}},
        EndsCase{"graded", "divisions: [8, 4], grading: [0.5, -0.2]", "", {1, -1}},
        EndsCase{"corner",
                 "divisions: [8, 4]",
                 "loads: [{kind: point, at: {uv: [2, 0]}, force: [0, 0, 1]}]",
                 {1, -1}},
        EndsCase{"nearest",
                 "divisions: [8, 4]",
                 "loads: [{kind: point, at: {nearest: [0, 0.5, 1]}, force: [0, 0, 1]}]",
                 {-1, 0}},
        EndsCase{"two_points",
                 "divisions: [8, 4]",
                 "loads:\n"
                 "  - {kind: point, at: {uv: [0, 0]}, force: [0, 0, 1]}\n"
                 "  - {kind: point, at: {uv: [2, 0.1]}, force: [0, 0, 1]}",
                 {0, -1}},
        EndsCase{"clamped", "divisions: [8, 4]", "supports: [{on: u_min, clamped: true}]", {-1, 0}},
        EndsCase{"rim", "divisions: [8, 4]", "supports: [{on: rim, clamped: true}]", {0, 0}},
        EndsCase{"finger",
                 "divisions: [8, 4]",
                 "fingers: [{name: f, shape: {kind: sphere, radius: 0.1}, position: [1.9, 0.9, 1], "
                 "direction: [0, 0, -1], motion: {travel: 0.1}}]",
                 {1, 1}}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(StudyPlanTest, HasTheScenesOwnSettingsFirstAndEachAxisByItself) {
  const StudyPlan plan = MakeStudyPlan(Plate("supports: [{on: u_min, clamped: true}]"), {});
  ASSERT_GE(plan.runs.size(), 5u);
  for (int level = 0; level < 5; ++level) {
    EXPECT_EQ(plan.runs[level].family, 0);
    EXPECT_EQ(plan.runs[level].settings.refinement, std::ldexp(0.25, level));
  }
  // Two gradings, three quadratures, seed_ghosts, seed strains, the nonlinear theory, and at least
  // Ceres' minimizer.
  EXPECT_GE(plan.families.size(), 10u);
  EXPECT_EQ(plan.runs.size(), 5 * plan.families.size());
  EXPECT_THAT(plan.families,
              ::testing::IsSupersetOf({"grading -0.5/0",
                                       "grading -0.85/0",
                                       "1 point",
                                       "6 points",
                                       "12 points",
                                       "seed_ghosts",
                                       "seed",
                                       "nonlinear",
                                       "minimizer ceres"}));
  // Levels in order, so that whatever ends the study has the coarse ones of all.
  for (size_t i = 6; i < plan.runs.size(); ++i) {
    EXPECT_GE(plan.runs[i].level, plan.runs[i - 1].level);
  }
}

TEST(StudyPlanTest, VariesOnlyWhatIsAskedFor) {
  PlanOptions options;
  options.axes = {StudyAxis::kQuadrature};
  const StudyPlan plan = MakeStudyPlan(Plate(), options);
  EXPECT_THAT(plan.families, ElementsAre("the scene's own", "1 point", "6 points", "12 points"));
  ASSERT_EQ(plan.runs.size(), 4u);
  for (const PlannedRun& run : plan.runs) EXPECT_EQ(run.settings.refinement, 1.0);
}

TEST(StudyPlanTest, TheProductHasAllCombinationsOnce) {
  PlanOptions options;
  options.axes = {StudyAxis::kResolution, StudyAxis::kQuadrature, StudyAxis::kStrains};
  options.levels = 2;
  options.product = true;
  const StudyPlan plan = MakeStudyPlan(Plate(), options);
  EXPECT_EQ(plan.families.size(), 8u);
  ASSERT_EQ(plan.runs.size(), 16u);
  for (size_t i = 0; i < plan.runs.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(plan.runs[i].settings == plan.runs[j].settings) << i << " " << j;
    }
  }
}

TEST(StudyPlanTest, SaysWhatIsNotVaried) {
  PlanOptions options;
  options.axes = {StudyAxis::kGrading, StudyAxis::kBoundaryRule};
  const Scene ball = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 1, frequency: 4}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  const StudyPlan plan = MakeStudyPlan(ball, options);
  EXPECT_EQ(plan.families.size(), 1u);
  EXPECT_EQ(plan.notes.size(), 2u);
}

TEST(ApplySettingsTest, ScalesDivisionsAndKeepsTheirRatio) {
  const Scene scene = Plate();
  StudySettings settings;
  std::string reason;
  for (const double refinement : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    settings.refinement = refinement;
    Scene scaled = scene;
    ASSERT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
    EXPECT_EQ(scaled.surface.divisions[0], 8 * refinement);
    EXPECT_EQ(scaled.surface.divisions[1], 4 * refinement);
    EXPECT_EQ(DivisionsOf(scene, settings), scaled.surface.divisions);
  }
}

TEST(ApplySettingsTest, LeavesALevelOutRatherThanRepeatIt) {
  const Scene scene = Plate("", "theory: linear", "divisions: [2, 1]");
  StudySettings settings;
  std::string reason;
  settings.refinement = 0.5;
  Scene scaled = scene;
  EXPECT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
  settings.refinement = 0.25;
  scaled = scene;
  EXPECT_FALSE(ApplySettings(settings, &scaled, &reason));
  EXPECT_THAT(reason, HasSubstr("halved"));
}

TEST(ApplySettingsTest, PeriodicDirectionsKeepFourCells) {
  const Scene scene = Parse(
      "name: tube\nsurface: {kind: cylinder, radius: 1, u: [0, 1], v: [0, 2*pi], "
      "divisions: [8, 8], periodic: [false, true]}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  StudySettings settings;
  settings.refinement = 0.25;
  EXPECT_EQ(DivisionsOf(scene, settings), (std::array<int, 2>{2, 4}));
}

TEST(ApplySettingsTest, IcospheresAreMadeAnewAndStaySpheres) {
  const Scene scene = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 3, frequency: 4}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  StudySettings settings;
  std::string reason;
  for (const auto& [refinement, frequency] :
       std::map<double, int>{{0.25, 1}, {0.5, 2}, {1.0, 4}, {2.0, 8}}) {
    settings.refinement = refinement;
    Scene scaled = scene;
    ASSERT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
    ASSERT_EQ(scaled.surface.mesh->vertices.size(), 10u * frequency * frequency + 2u);
    for (const Eigen::Vector3d& x : scaled.surface.mesh->vertices)
      EXPECT_NEAR(x.norm(), 3.0, 1e-12);
  }
}

TEST(ApplySettingsTest, OtherMeshesAreSubdividedAndNeverCoarsened) {
  Scene scene = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 3, frequency: 2, refine: 1}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  const size_t triangles = scene.surface.mesh->triangles.size();
  StudySettings settings;
  std::string reason;
  settings.refinement = 4.0;
  Scene finer = scene;
  ASSERT_TRUE(ApplySettings(settings, &finer, &reason)) << reason;
  EXPECT_EQ(finer.surface.mesh->triangles.size(), 16 * triangles);
  settings.refinement = 0.5;
  EXPECT_FALSE(ApplySettings(settings, &scene, &reason));
}

}  // namespace
}  // namespace darboux
