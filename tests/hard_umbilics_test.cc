// Hard cases: umbilics, where principal directions are not defined.
// tests/surface_invariants_test.cc and tests/invariant_strains_test.cc have the formulas next to
// them; here are all four umbilics of an ellipsoid, ellipsoids that are almost spheres, and shells
// with umbilics that are solved.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "geometry/parametric_surface.h"
#include "geometry/surface_invariants.h"
#include "tests/hard_util.h"

namespace darboux {
namespace {

bool IsFinite(const SurfaceInvariants& s) {
  return s.kappa.allFinite() && s.frame.allFinite() && s.b.allFinite() && s.t1.allFinite() &&
         s.b_d[0].allFinite() && s.b_d[1].allFinite() && s.frame_d[0].allFinite() &&
         s.frame_d[1].allFinite() && s.n_uu.allFinite() && s.n_uv.allFinite() && s.n_vv.allFinite();
}

SurfaceInvariants At(const ParametricSurface& surface, double u, double v) {
  return EvaluateSurfaceInvariants(surface.Evaluate(u, v)).value();
}

// On the section y = 0 of a > b > c, kappa_1 = kappa_2 = -a c / b^3.
TEST(HardUmbilicsTest, AllFourOfAnEllipsoidAreFound) {
  const double a = 2.0, b = 1.5, c = 0.7;
  const auto ellipsoid = MakeEllipsoid(a, b, c);
  const double v = std::acos(std::sqrt((a * a - b * b) / (a * a - c * c)));
  for (const double u : {0.0, M_PI}) {
    for (const double sign : {-1.0, 1.0}) {
      const SurfaceInvariants s = At(*ellipsoid, u, sign * v);
      EXPECT_TRUE(s.umbilic);
      EXPECT_TRUE(IsFinite(s));
      EXPECT_NEAR(s.kappa[0], -a * c / (b * b * b), 1e-14);
      EXPECT_NEAR(s.kappa[1], -a * c / (b * b * b), 1e-14);
    }
  }
}

// Axes 1 + e, 1, 1 - e: curvatures differ by about e. Their product and sum have closed forms.
TEST(HardUmbilicsTest, AlmostSpheresHaveTheirCurvatures) {
  for (const double e : {1e-4, 1e-8, 1e-12, 0.0}) {
    const double a = 1.0 + e, b = 1.0, c = 1.0 - e;
    const auto ellipsoid = MakeEllipsoid(a, b, c);
    for (const double u : {0.0, 0.4, 1.3, 2.9}) {
      for (const double v : {-1.2, 0.0, 0.7854, 1.1}) {
        const SurfaceInvariants s = At(*ellipsoid, u, v);
        EXPECT_TRUE(IsFinite(s));
        const double x = a * std::cos(v) * std::cos(u), y = b * std::cos(v) * std::sin(u),
                     z = c * std::sin(v);
        const double q = x * x / std::pow(a, 4) + y * y / std::pow(b, 4) + z * z / std::pow(c, 4);
        const double gauss = 1.0 / (std::pow(a * b * c, 2) * q * q);
        const double mean = -(a * a + b * b + c * c - x * x - y * y - z * z) /
                            (2.0 * std::pow(a * b * c, 2) * std::pow(q, 1.5));
        EXPECT_NEAR(s.kappa[0] * s.kappa[1], gauss, 1e-13);
        EXPECT_NEAR(0.5 * (s.kappa[0] + s.kappa[1]), mean, 1e-13);
      }
    }
  }
}

constexpr char kEllipsoid[] = R"(
name: ellipsoid
surface: {kind: ellipsoid, semi_axes: [$a, 1, $c], u: [0, pi/2], v: [0, 1.2], divisions: [12, 12]}
shell: {thickness: 0.02, young_modulus: 1, poisson_ratio: 0.3}
model: {theory: $theory}
supports: [{on: v_min, clamped: true}, {on: u_min, symmetry: y}, {on: u_max, symmetry: x}]
loads: [{kind: pressure, value: 1.0e-5}, {kind: traction, force: [0, 0, "-1.0e-5*x"]}]
probes: [{name: inside, at: {uv: [0.6, 0.8]}}]
)";

// Solutions of almost spheres go to that of the sphere as fast as their axes do.
TEST(HardUmbilicsTest, ShellsThatAreAlmostSpheresMoveAlmostLikeOne) {
  for (const std::string theory : {"linear", "nonlinear"}) {
    const auto solve = [&](double e) {
      std::string text = kEllipsoid;
      text.replace(text.find("$theory"), 7, theory);
      return SolveScene(SceneFromText(Fill(text, {{"a", 1.0 + e}, {"c", 1.0 - e}}))).Probe();
    };
    const Eigen::Vector3d sphere = solve(0.0);
    const double coarse = (solve(1e-4) - sphere).norm() / sphere.norm();
    const double fine = (solve(1e-8) - sphere).norm() / sphere.norm();
    EXPECT_LE(coarse, 1e-2) << theory;
    EXPECT_LE(fine, 1e-6) << theory;
    EXPECT_LE(fine, 2e-4 * coarse) << theory;
    Measured("umbilics: axes that differ by 1e-8, " + theory + ", change", fine);
  }
}

// A clamped monkey saddle whose umbilic is a vertex, on an edge, or within an element: the lattice
// is moved beneath it by parts of a cell, the rim with it, against which the surface is moved back.
double Deflection(double shift, int n, const std::string& theory) {
  const double cell = 1.0 / n;
  const double s = shift * cell;
  // The same square of the saddle; lattice lines move inside only.
  return SolveScene(SceneFromText(Fill(
                        R"yaml(
name: saddle
surface: {kind: expression, position: ["u + $s*sin(pi*u)^2", "v + $s*sin(pi*v)^2",
          "0.3*((u + $s*sin(pi*u)^2 - 0.5)^3 - 3*(u + $s*sin(pi*u)^2 - 0.5)*(v + $s*sin(pi*v)^2 - 0.5)^2)"],
          u: [0, 1], v: [0, 1], divisions: [$n, $n]
}
shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: )yaml" + theory +
                            R"yaml(}
supports: [{on: rim, clamped: true}]
loads: [{kind: traction, force: [0, 0, 1.0e-3]}]
probes: [{name: umbilic, at: {nearest: [0.5, 0.5, 0]}}]
)yaml",
                        {{"s", s}, {"n", 1.0 * n}})))
      .Probe()
      .z();
}

TEST(HardUmbilicsTest, WhereTheLatticeHasTheUmbilicDoesNotMatter) {
  for (const std::string theory : {"linear", "nonlinear"}) {
    double spread[2], centre[2];
    for (const int level : {0, 1}) {
      const int n = level == 0 ? 16 : 32;
      const double vertex = centre[level] = Deflection(0.0, n, theory);
      spread[level] = 0.0;
      for (const double shift : {0.31, 0.5}) {  // within an element; in the middle of an edge
        const double change = std::abs(Deflection(shift, n, theory) / vertex - 1.0);
        spread[level] = std::max(spread[level], change);
      }
    }
    // What is left is the discretisation: no more than halving the cells changes, falling as fast.
    EXPECT_LE(spread[1], std::abs(centre[1] / centre[0] - 1.0)) << theory;
    EXPECT_LE(spread[1], spread[0] / 8.0) << theory;
    Measured("umbilics: monkey saddle 32 x 32, umbilic in a vertex or not, " + theory, spread[1]);
  }
}

}  // namespace
}  // namespace darboux
