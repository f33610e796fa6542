// Errors and their slopes on problems with known answers. "dof" counts all three components of
// every control vertex. Values and digits: data/README.md and the scenes' expect blocks.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

struct Level {
  int dof;
  double error;
};

// Relative error of one component of the first probe over resolutions.
std::vector<Level> Study(Scene scene,
                         int component,
                         double reference,
                         const std::vector<int>& divisions) {
  std::vector<Level> levels;
  for (const int n : divisions) {
    scene.surface.divisions = {n, n};
    const Solution solution = SolveScene(scene);
    levels.push_back(
        {solution.summary.dof, std::abs(solution.Probe()[component] / reference - 1.0)});
    std::printf("  %-22s %6d dof  error %.3e\n",
                scene.name.c_str(),
                levels.back().dof,
                levels.back().error);
  }
  return levels;
}

double Slope(const std::vector<Level>& levels) {
  return std::log(levels.back().error / levels.front().error) /
         std::log(static_cast<double>(levels.back().dof) / levels.front().dof);
}

constexpr double kClampedPlate = 0.13817284435278598;
constexpr double kSupportedPlate = 0.4436089105434862;
constexpr double kPinchedKoiter = -1.828195198757057e-5;
constexpr double kPinchedSeed = -1.825937820944029e-5;
constexpr double kHarmonicRadial = 0.06857928392135801;
constexpr double kHarmonicAxial = -0.008397065217777375;

TEST(ConvergenceTest, ClampedPlateFallsFasterThanDofToTheMinusTwo) {
  const auto levels = Study(SceneFromData("clamped_plate.yaml"), 2, kClampedPlate, {16, 32, 64});
  EXPECT_EQ(levels[0].dof, 1077);
  EXPECT_LE(levels[0].error, 1e-4);
  EXPECT_EQ(levels[2].dof, 13461);
  EXPECT_LE(levels[2].error, 2e-6);
  EXPECT_LE(Slope(levels), -2.0);
}

TEST(ConvergenceTest, SeedGhostRuleFallsLikeTheRootOfDof) {
  Scene scene = SceneFromData("clamped_plate.yaml");
  scene.model.boundary_rule = BoundaryRule::kSeedGhosts;
  const auto levels = Study(scene, 2, kClampedPlate, {16, 32, 64});
  EXPECT_NEAR(levels[0].error, 1.5e-1, 0.1e-1);  // erratum 3's table
  EXPECT_NEAR(levels[1].error, 7.5e-2, 0.1e-2);
  EXPECT_NEAR(levels[2].error, 3.7e-2, 0.1e-2);
  EXPECT_NEAR(Slope(levels), -0.5, 0.1);
}

TEST(ConvergenceTest, SimplySupportedPlate) {
  const auto levels =
      Study(SceneFromData("simply_supported_plate.yaml"), 2, kSupportedPlate, {16, 32, 64});
  EXPECT_LE(levels[0].error, 1e-4);
  EXPECT_LE(Slope(levels), -2.0);
}

TEST(ConvergenceTest, OnePointQuadratureLimitsThePlateToFirstOrder) {
  Scene scene = SceneFromData("clamped_plate.yaml");
  scene.model.quadrature = 1;
  const auto levels = Study(scene, 2, kClampedPlate, {16, 32, 64});
  EXPECT_NEAR(Slope(levels), -1.0, 0.35);
}

TEST(ConvergenceTest, PinchedCylinderUniform) {
  Scene scene = SceneFromData("pinched_cylinder.yaml");
  scene.surface.grading = {0.0, 0.0};
  const auto levels = Study(scene, 2, kPinchedKoiter, {16, 32});
  EXPECT_LE(levels[0].error, 0.03);
  EXPECT_LE(levels[1].error, 0.006);
}

TEST(ConvergenceTest, PinchedCylinderGraded) {
  const auto levels =
      Study(SceneFromData("pinched_cylinder.yaml"), 2, kPinchedKoiter, {16, 32, 64});
  EXPECT_LE(levels[0].error, 3e-3);
  EXPECT_LE(levels[1].error, 2e-4);
  EXPECT_LE(Slope(levels), -1.4);
}

TEST(ConvergenceTest, EachTheoryConvergesToItsOwnValue) {
  // The two differ by 1.2e-3, far more than the error left at 64 x 64.
  Scene scene = SceneFromData("pinched_cylinder.yaml");
  const auto koiter = Study(scene, 2, kPinchedKoiter, {64});
  EXPECT_LE(koiter[0].error, 5e-5);
  scene.model.strains = Strains::kSeed;
  const auto seed = Study(scene, 2, kPinchedSeed, {64});
  EXPECT_LE(seed[0].error, 5e-5);
}

// The radial error changes sign, so the axial displacement is what shows the rate.
TEST(ConvergenceTest, CylinderHarmonic) {
  const Scene scene = SceneFromData("cylinder_harmonic.yaml");
  Scene one = scene;
  one.probes = {scene.probes.at(2)};
  const auto radial = Study(one, 2, kHarmonicRadial, {8, 32, 64});
  EXPECT_LE(radial[1].error, 1e-6);
  EXPECT_LE(radial[2].error, 1e-7);
  EXPECT_LE(Slope(radial), -2.0);
  one.probes = {scene.probes.at(0)};
  const auto axial = Study(one, 0, kHarmonicAxial, {16, 32, 64});
  EXPECT_LE(axial[1].error, 1e-6);
  EXPECT_LE(Slope(axial), -2.0);
}

TEST(ConvergenceTest, NonlinearPlate) {
  const struct {
    const char* file;
    double reference;
  } cases[] = {{"nonlinear_plate_p10.yaml", 0.9373745695149727},
               {"nonlinear_plate_p50.yaml", 2.04177436599579}};
  for (const auto& c : cases) {
    const auto levels = Study(SceneFromData(c.file), 2, c.reference, {8, 16, 32});
    EXPECT_LE(levels[2].error, 2e-5);
    EXPECT_LE(Slope(levels), -1.5);
  }
}

}  // namespace
}  // namespace darboux
