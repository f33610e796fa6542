// What a command line may replace in a scene.

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene_reader_util.h"

namespace darboux {
namespace {

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

}  // namespace
}  // namespace darboux
