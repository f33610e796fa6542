// Mistakes in what acts on the shell and in what is asked of it: supports, loads, path, probes and
// expectations.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/scene_reader_util.h"

namespace darboux {
namespace {

constexpr char kLoadKinds[] =
    "point | pressure | traction | normal_traction | edge | line | gravity | gas";

std::vector<Mistake> Mistakes() {
  return {
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

class SceneReaderMistakeTest : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneReaderMistakeTest, IsReportedWithPlaceAndRemedy) { ExpectMessage(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Conditions,
                         SceneReaderMistakeTest,
                         ::testing::ValuesIn(Mistakes()),
                         NameOf);

}  // namespace
}  // namespace darboux
