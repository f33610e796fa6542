// Hard cases: contact. Fingers at rest on the shell, grazing, fast, overlapping, too small for the
// mesh, and those that miss.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/hard_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

// In words of a scene. The plate is 100 x 100 x 1, clamped, its upper
// face at z = 0.5.
struct Finger {
  std::string shape = "{kind: sphere, radius: 5}";
  std::string position = "[50, 50, 40]";
  std::string direction = "[0, 0, -1]";
  double travel = 1.0;
  std::string rest;  // friction
};

Scene Plate(const Finger& finger, const std::string& model = "{theory: nonlinear}") {
  return SceneFromText(R"(
name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
supports: [{on: rim, clamped: true}]
model: )" + model + R"(
fingers:
  - {name: f, shape: )" +
                       finger.shape + ", position: " + finger.position +
                       ", direction: " + finger.direction +
                       ", motion: {travel: " + Text(finger.travel) + "}" + finger.rest + R"(}
probes: [{name: centre, at: {uv: [50, 50]}}]
)");
}

const FingerReport& Report(const Solution& solution) {
  return solution.summary.steps.back().fingers.at(0);
}

// The centre of a sphere that came from (x, y, z) along -z is below its face's first touch by its
// travel; no point of the deformed upper face may be inside.
double DeepestPoint(const Solution& solution, const Eigen::Vector3d& centre, double radius) {
  double deepest = 0.0;
  const ShellSurface& surface = solution.problem->surface();
  for (int e = 0; e < surface.num_elements(); ++e) {
    for (int j = 0; j <= 6; ++j) {
      for (int i = 0; i + j <= 6; ++i) {
        const ElementPoint at{e, i / 6.0, j / 6.0};
        const Eigen::Vector3d x = surface.Position(at) + solution.problem->Displacement(at);
        deepest = std::max(deepest, radius + 0.5 - (x - centre).norm());
      }
    }
  }
  return deepest;
}

std::string ErrorOf(const Scene& scene) {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  EXPECT_FALSE(Solve(scene, SolverOptions(), &problem, &summary, &error)) << summary.message;
  return error;
}

TEST(HardContactTest, FingerExactlyAtRestWithoutTravelFeelsNothing) {
  for (const char* rest : {"", ", friction: 0.5"}) {
    for (const char* shape : {"{kind: sphere, radius: 5}",
                              "{kind: box, half_sizes: [3, 3, 5]}",
                              "{kind: plane}",
                              "{kind: pin}"}) {
      Finger finger;
      finger.shape = shape;
      finger.rest = rest;
      const bool is_flat = std::string(shape).find("sphere") == std::string::npos &&
                           std::string(shape).find("box") == std::string::npos;
      finger.position = is_flat ? "[50, 50, 0.5]" : "[50, 50, 5.5]";
      finger.travel = 0.0;
      const Solution solution = SolveScene(Plate(finger));
      EXPECT_EQ(Report(solution).normal_force, 0.0) << shape << rest;
      EXPECT_EQ(solution.problem->displacements().norm(), 0.0) << shape << rest;
      EXPECT_EQ(Report(solution).penetration, 0.0) << shape << rest;
      if (std::string(shape).find("pin") == std::string::npos) {
        EXPECT_NEAR(Report(solution).shift, 0.0, 1e-12) << shape << rest;
      }
    }
  }
}

// Contact points lie beside the place that is touched first. A travel that does not reach them is
// no success with a force of zero.
TEST(HardContactTest, TravelBelowWhatTheMeshResolvesIsSaid) {
  for (const double travel : {1e-12, 1e-6, 4e-3}) {
    Finger finger;
    finger.travel = travel;
    const Solution solution = TryScene(Plate(finger));
    EXPECT_FALSE(solution.summary.IsConverged());
    EXPECT_THAT(solution.summary.message, HasSubstr("without any contact"));
  }
  Finger finger;
  finger.travel = 0.02;
  const Solution solution = SolveScene(Plate(finger));
  EXPECT_GT(Report(solution).normal_force, 0.0);
  EXPECT_GT(Report(solution).gap, 0.01 * finger.travel);
  EXPECT_THAT(::testing::PrintToString(solution.summary.decisions), HasSubstr("off its way"));
}

// Placed far away, touching, overlapping, or with its centre on the other side: travel counts from
// first touch, so the answer is the same.
TEST(HardContactTest, WhereAFingerIsPlacedOnItsLineDoesNotMatter) {
  Finger finger;
  const Solution far = SolveScene(Plate(finger));
  EXPECT_GT(Report(far).normal_force, 0.0);
  double worst = 0.0;
  for (const double z : {5.5, 5.0, 2.0, -3.0}) {
    finger.position = "[50, 50, " + Text(z) + "]";
    const Solution near = SolveScene(Plate(finger));
    EXPECT_NEAR(Report(near).shift, z - 5.5, 1e-9);
    const double change =
        std::abs(Report(near).normal_force - Report(far).normal_force) / Report(far).normal_force;
    EXPECT_LE(change, 1e-9) << z;
    worst = std::max(worst, change);
  }
  Measured("contact: force, finger placed 34.5 off or 8.5 inside", worst);
}

TEST(HardContactTest, FingersThatMissAreErrors) {
  const auto error = [](const char* position, const char* direction) {
    Finger finger;
    finger.position = position;
    finger.direction = direction;
    return ErrorOf(Plate(finger));
  };
  for (const std::string& text : {error("[50, 50, -20]", "[0, 0, -1]"),  // below, moving away
                                  error("[50, 50, 40]", "[0, 0, 1]"),
                                  error("[150, 50, 5]", "[0, 0, -1]"),   // beside
                                  error("[-50, 50, 5.6]", "[1, 0, 0]"),  // passing 0.1 above
                                  error("[50, 50, 40]", "[1, 0, 0]")}) {
    EXPECT_THAT(text, HasSubstr("test.yaml:8: fingers[0]"));
    EXPECT_THAT(text, HasSubstr("never touches"));
  }
}

Scene Ball(const std::string& position, const std::string& direction, double travel) {
  return SceneFromText(R"(
name: ball
surface: {kind: icosphere, radius: 31.25, frequency: 6}
shell: {thickness: 0.5, young_modulus: 1, poisson_ratio: 0.3}
supports:
  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y, z]}
  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}
  - {on: {near: [31.25, 0, 0], radius: 0}, fix: [y]}
fingers:
  - {name: f, shape: {kind: sphere, radius: 4}, position: )" +
                       position + ", direction: " + direction +
                       ", motion: {travel: " + Text(travel) + "}}\n");
}

// A sphere that slides over a ball, 0.1 lower than it could without pushing, is over the top where
// a finger from above would be that travelled by 0.1.
TEST(HardContactTest, GrazingFingerPushesAsDeepAsItReaches) {
  const double touch = Report(SolveScene(Ball("[-60, 0, 35.4]", "[1, 0, 0]", 0.0))).shift;
  EXPECT_NEAR(60.0 - touch, std::sqrt(35.5 * 35.5 - 35.4 * 35.4), 0.01);
  const Solution sliding = SolveScene(Ball("[-60, 0, 35.4]", "[1, 0, 0]", 60.0 - touch));
  const Solution pushed = SolveScene(Ball("[0, 0, 60]", "[0, 0, -1]", 0.1));
  const double force = Report(pushed).normal_force;
  EXPECT_GT(force, 0.0);
  EXPECT_NEAR(Report(sliding).normal_force, force, 1e-3 * force);
  Measured("contact: force of a sphere that slid in against one from above",
           std::abs(Report(sliding).normal_force / force - 1.0));
  // Nearly or exactly tangential: it pushes nothing, and says so.
  for (const char* position : {"[-60, 0, 35.4999]", "[-60, 0, 35.5]"}) {
    const Solution grazing = TryScene(Ball(position, "[1, 0, 0]", 2.0));
    EXPECT_FALSE(grazing.summary.IsConverged());
    EXPECT_THAT(grazing.summary.message, HasSubstr("without")) << position;
  }
  EXPECT_THAT(ErrorOf(Ball("[-60, 0, 35.501]", "[1, 0, 0]", 2.0)), HasSubstr("never touches"));
}

struct Approach {
  const char* name;
  double radius, travel;
  const char* model;
};

class FastFingerTest : public ::testing::TestWithParam<Approach> {};

// In one load step, many radii deep: through the shell it must not come.
TEST_P(FastFingerTest, DoesNotTunnel) {
  Finger finger;
  finger.shape = "{kind: sphere, radius: " + Text(GetParam().radius) + "}";
  finger.position = "[51, 52, 40]";  // not above a vertex
  finger.travel = GetParam().travel;
  const Solution solution = SolveScene(Plate(finger, GetParam().model));
  const FingerReport& report = Report(solution);
  EXPECT_GT(report.normal_force, 0.0);
  EXPECT_LE(solution.summary.force_balance, 1e-6);
  EXPECT_LE(report.penetration, 5e-4);
  const Eigen::Vector3d centre(51.0, 52.0, 40.0 - report.shift - report.travel);
  EXPECT_LE(std::abs(report.shift - (39.5 - GetParam().radius)), 0.01);
  // The face is in front of the finger, the shell pushed as deep as the finger has come.
  EXPECT_NEAR(report.indentation, GetParam().travel, 0.02 * GetParam().travel);
  const double deepest = DeepestPoint(solution, centre, GetParam().radius);
  EXPECT_LE(deepest, 0.1);  // between contact points the face may be a little inside
  Measured(std::string("contact: fast finger, ") + GetParam().name + ": radii in one step",
           GetParam().travel / GetParam().radius);
  Measured(std::string("contact: fast finger, ") + GetParam().name + ": deepest point / h",
           deepest);
}

INSTANTIATE_TEST_SUITE_P(Approaches,
                         FastFingerTest,
                         ::testing::Values(Approach{"one", 5.0, 5.0, "{theory: nonlinear}"},
                                           Approach{"five", 2.0, 10.0, "{theory: nonlinear}"},
                                           Approach{"ten", 1.0, 10.0, "{theory: nonlinear}"},
                                           Approach{"hundred", 0.05, 5.0, "{theory: nonlinear}"},
                                           Approach{"forty_linear", 0.5, 20.0, "{theory: linear}"}),
                         [](const auto& info) { return std::string(info.param.name); });

// A finger smaller than the elements, between their vertices and centres, touches the near side of
// a ball, not the far side from within.
TEST(HardContactTest, SmallFingerTouchesTheNearWall) {
  Finger finger;
  finger.shape = "{kind: sphere, radius: 0.05}";
  for (const char* at : {"[51, 52, 40]", "[47.3, 50.9, 40]", "[22.2, 71.7, 40]"}) {
    finger.position = at;
    finger.travel = 0.0;
    EXPECT_NEAR(Report(SolveScene(Plate(finger))).shift, 39.45, 0.002) << at;
  }
  const Scene ball = SceneFromText(R"(
name: ball
surface: {kind: icosphere, radius: 30, frequency: 4}
shell: {thickness: 0.5, young_modulus: 1, poisson_ratio: 0.3}
fingers:
  - {name: f, shape: {kind: sphere, radius: 0.1}, position: [2.3, 1.1, 60], direction: [0, 0, -1],
     motion: {travel: 0}}
)");
  const double near = 60.0 - std::sqrt(30.35 * 30.35 - 2.3 * 2.3 - 1.1 * 1.1);
  EXPECT_NEAR(Report(SolveScene(ball)).shift, near, 0.02);  // the Loop sphere is a little off
}

}  // namespace
}  // namespace darboux
