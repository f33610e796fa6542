// Parametric surfaces of scenes, and mistakes in them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/scene_reader_util.h"

namespace darboux {
namespace {

using ::testing::StartsWith;

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

constexpr char kSurfaceKinds[] =
    "plane | cylinder | sphere | ellipsoid | torus | monkey_saddle | expression | implicit | mesh "
    "| "
    "icosphere";

std::vector<Mistake> Mistakes() {
  return {
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
  };
}

class SceneReaderMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneReaderMistakeTest, IsReportedWithPlaceAndRemedy) { ExpectMessage(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Surface, SceneReaderMistakeTest, ::testing::ValuesIn(Mistakes()), NameOf);

}  // namespace
}  // namespace darboux
