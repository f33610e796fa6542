// Hard cases: parametrisations. The same plate and cylinder by sheared, stretched and bent
// parameters, and poles of a sphere.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/hard_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

constexpr char kPlateRest[] = R"yaml(
shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: traction, force: [0, 0, 1.0e-3]}]
)yaml";

// 0.13817284435 at L = 100, h = 1, E = 1e7, p = 1, nu = 0.3 (data/README.md), for this plate.
const double kPlate = 0.13817284435 * 1e-3 / (1e6 * 1e-6) * 1e7 / 1e8;

// Parameters 1000 times as long as the plate one way, or a thousandth both ways.
TEST(HardParametrisationTest, StretchedPlateIsThePlate) {
  double reference = 0.0;
  for (const auto& [scale_u, scale_v] :
       {std::make_pair(1.0, 1.0), std::make_pair(1000.0, 1.0), std::make_pair(1e-3, 1e3)}) {
    const Solution solution = SolveScene(SceneFromText(Fill(std::string(R"yaml(
name: stretched
surface: {kind: expression, position: ["u/$a", "v/$b", "0"], u: [0, $a], v: [0, $b],
          divisions: [16, 16]}
probes: [{name: centre, at: {uv: [$a*0.5, $b*0.5]}}]
)yaml") + kPlateRest,
                                                            {{"a", scale_u}, {"b", scale_v}})));
    if (reference == 0.0) {
      reference = solution.Probe().z();
      EXPECT_NEAR(reference, kPlate, 1e-4 * kPlate);
      continue;
    }
    const double change = std::abs(solution.Probe().z() / reference - 1.0);
    EXPECT_LE(change, 1e-9) << scale_u;
    Measured("parametrisation: plate stretched by " + Text(scale_u / scale_v), change);
  }
}

// A parameter that runs a thousand times faster at one side than at the other: cells of aspect
// 1:1000 beside square ones.
TEST(HardParametrisationTest, UnevenCellsConvergeToThePlate) {
  const auto error = [](int n) {
    const Solution solution = SolveScene(SceneFromText(Fill(std::string(R"yaml(
name: uneven
surface: {kind: expression, position: ["(exp(6.9*u) - 1)/(exp(6.9) - 1)", "v", "0"], u: [0, 1],
          v: [0, 1], divisions: [$n, $n]}
probes: [{name: centre, at: {nearest: [0.5, 0.5, 0]}}]
)yaml") + kPlateRest,
                                                            {{"n", 1.0 * n}})));
    return std::abs(solution.Probe().z() / kPlate - 1.0);
  };
  const double coarse = error(16), fine = error(32);
  EXPECT_LE(fine, 1e-2);
  EXPECT_LE(fine, coarse / 4.0);
  Measured("parametrisation: plate, cells of 1:1 to 1:1000, 32 x 32", fine);
}

// A clamped parallelogram of 5 degrees does not fill a square; the sheared strip that does is a
// cylinder: x along its axis and with the angle, period and all.
double HarmonicError(double shear, int n, Resolution* resolution = nullptr) {
  const Solution solution =
      SolveScene(SceneFromText(Fill(R"yaml(
name: sheared
surface: {kind: expression, position: ["u", "300*sin(v + $s*u/300)", "300*cos(v + $s*u/300)"],
          u: [0, 600], v: [0, 2*pi], divisions: [$n, $m], periodic: [false, true]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear, quadrature: 6}
supports: [{on: u_min, fix: [y, z]}, {on: u_max, fix: [y, z]}]
loads: [{kind: normal_traction, value: "cos(2*(v + $s*u/300))*sin(pi*u/600)"}]
probes: [{name: top, at: {nearest: [300, 0, 300]}}]
)yaml",
                                    {{"s", shear}, {"n", 1.0 * n}, {"m", 3.0 * n}})));
  if (resolution != nullptr) *resolution = *solution.summary.resolution;
  // W = 6.857928392136e-2: closed form of data/cylinder_harmonic.yaml, linear Koiter theory.
  return std::abs(std::abs(solution.Probe().z()) / 6.857928392136e-2 - 1.0);
}

TEST(HardParametrisationTest, ShearedCylinderIsTheCylinder) {
  EXPECT_LE(HarmonicError(0.0, 16), 1e-3);
  // 45 degrees and 5 degrees between the parameter lines: tan = 1 / shear.
  const double half = HarmonicError(1.0, 24);
  EXPECT_LE(half, 1e-2);
  Measured("parametrisation: cylinder, 45 degrees, 24 x 72", half);
  const double steep = 1.0 / std::tan(5.0 * M_PI / 180.0);
  Resolution locked, doubtful;
  const double coarse = HarmonicError(steep, 32, &locked);
  const double fine = HarmonicError(steep, 64, &doubtful);
  EXPECT_LE(fine, coarse / 6.0);  // locking of cells that run around the cylinder
  EXPECT_LE(fine, 0.15);
  // And the solver says so.
  EXPECT_FALSE(locked.IsSufficient());
  EXPECT_THAT(doubtful.Complaint(), HasSubstr("a coarse mesh"));
  Measured("parametrisation: cylinder, 5 degrees, 32 x 96", coarse);
  Measured("parametrisation: cylinder, 5 degrees, 64 x 192", fine);
}

// A pole of a sphere has no tangent plane in its parameters: at the rim or inside it is an error.
TEST(HardParametrisationTest, PolesAreErrors) {
  for (const char* v : {"[0, pi/2]", "[-pi/2, 0.5]", "[1, 2]", "[-2, 2]"}) {
    for (const char* surface :
         {"kind: sphere, radius: 2", "kind: ellipsoid, semi_axes: [1, 2, 3]"}) {
      const std::string text = std::string("name: pole\nsurface: {") + surface +
                               ", u: [0, 1], v: " + v + ", divisions: [8, 8]}\n" +
                               "shell: {thickness: 0.1, young_modulus: 1, poisson_ratio: 0.3}\n"
                               "supports: [{on: u_min, clamped: true}]\n";
      Scene scene;
      std::string error;
      std::unique_ptr<ShellProblem> problem;
      SolverSummary summary;
      const bool read = ParseScene(text, "test.yaml", &scene, &error);
      EXPECT_FALSE(read && Solve(scene, SolverOptions(), &problem, &summary, &error)) << v;
      EXPECT_THAT(error, HasSubstr("test.yaml:2: surface")) << v;
    }
  }
}

}  // namespace
}  // namespace darboux
