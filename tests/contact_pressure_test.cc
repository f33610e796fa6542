#include "solver/contact_pressure.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "solver/results.h"
#include "tests/solve_util.h"
#include "tests/temporary_folder.h"
#include "tests/vtu_util.h"

namespace darboux {
namespace {

std::string Ball(const std::string& shape, int frequency) {
  return "name: ball\nsurface: {kind: icosphere, radius: 20, frequency: " +
         std::to_string(frequency) +
         "}\nshell: {thickness: 1.5, young_modulus: 4, poisson_ratio: 0.3}\n"
         "model: {theory: nonlinear}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 20], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -20], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: " +
         shape +
         ", position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 1}}\n"
         "  - {name: bottom, shape: {kind: plane}, position: [0, 0, -60], direction: [0, 0, 1], "
         "motion: {travel: 1}}\n";
}

// The integral of the field that is linear on the rest triangles.
double Integral(const ShellSurface& surface,
                const OutputMesh& mesh,
                const std::vector<double>& field) {
  double sum = 0.0;
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Eigen::Vector3d x = surface.Position(mesh.points[t[0]]);
    const Eigen::Vector3d a = surface.Position(mesh.points[t[1]]) - x;
    const Eigen::Vector3d b = surface.Position(mesh.points[t[2]]) - x;
    sum += a.cross(b).norm() / 6.0 * (field[t[0]] + field[t[1]] + field[t[2]]);
  }
  return sum;
}

class ContactPressureTest : public ::testing::TestWithParam<std::pair<const char*, int>> {};

TEST_P(ContactPressureTest, IntegralIsTheNormalForceOfTheFingers) {
  const auto& [shape, frequency] = GetParam();
  const Solution solution = SolveScene(SceneFromText(Ball(shape, frequency)));
  const LoadStep& step = solution.summary.steps.back();
  double force = 0.0;
  for (const FingerReport& finger : step.fingers) force += finger.normal_force;
  ASSERT_GT(force, 0.0);
  const ShellSurface& surface = solution.problem->surface();
  const OutputMesh mesh = MakeOutputMesh(surface);
  const std::vector<double> pressure = MakeContactPressure(surface, mesh, step.contact_points);
  EXPECT_NEAR(Integral(surface, mesh, pressure), force, 1e-12 * force);
  double largest = 0.0;
  for (size_t i = 0; i < pressure.size(); ++i) {
    EXPECT_GE(pressure[i], 0.0);
    largest = std::max(largest, pressure[i]);
    // Nothing touches near the equator.
    if (std::abs(surface.Position(mesh.points[i]).z()) < 10.0) {
      EXPECT_EQ(pressure[i], 0.0);
    }
  }
  EXPECT_GT(largest, 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    Fingers,
    ContactPressureTest,
    ::testing::Values(std::pair("{kind: sphere, radius: 12}", 3),
                      std::pair("{kind: sphere, radius: 12}", 5),
                      std::pair("{kind: plane}", 3),
                      std::pair("{kind: box, half_sizes: [5, 5, 5], rounding: 2}", 3)));

TEST(OutputMeshTest, PlacesOfCornersAreTheirPoints) {
  const Solution solution = SolveScene(SceneFromData("clamped_plate.yaml"));
  const ShellSurface& surface = solution.problem->surface();
  const OutputMesh mesh = MakeOutputMesh(surface);
  ASSERT_EQ(mesh.elements.size(), mesh.triangles.size());
  ASSERT_EQ(mesh.places.size(), mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto& [s, u] = mesh.places[t][k];
      const Eigen::Vector3d x = surface.Position({mesh.elements[t], s, u});
      EXPECT_LT((x - surface.Position(mesh.points[mesh.triangles[t][k]])).norm(), 1e-12);
    }
  }
}

TEST(ContactPressureFileTest, VtuHasItWhereThereAreFingersAndOnlyThere) {
  const TemporaryFolder temporary("contact_pressure");
  const std::filesystem::path& folder = temporary.path();
  const auto write = [&](const Solution& solution) {
    Results results;
    std::string error;
    EXPECT_TRUE(WriteResults(
        folder.string(), *solution.problem, solution.summary, nullptr, &results, &error))
        << error;
    return ReadVtu(folder / "shell.vtu");
  };
  const Solution ball = SolveScene(SceneFromText(Ball("{kind: sphere, radius: 12}", 3)));
  Vtu vtu = write(ball);
  ASSERT_EQ(vtu.arrays.count("contact_pressure"), 1u);
  const OutputMesh mesh = MakeOutputMesh(ball.problem->surface());
  EXPECT_EQ(
      vtu.arrays["contact_pressure"],
      MakeContactPressure(ball.problem->surface(), mesh, ball.summary.steps.back().contact_points));
  EXPECT_EQ(write(SolveScene(SceneFromData("clamped_plate.yaml"))).arrays.count("contact_pressure"),
            0u);
}

TEST(ContactPressureOfNothingTest, IsZero) {
  const Solution solution = SolveScene(SceneFromData("clamped_plate.yaml"));
  const OutputMesh mesh = MakeOutputMesh(solution.problem->surface());
  const std::vector<double> pressure = MakeContactPressure(solution.problem->surface(), mesh, {});
  EXPECT_EQ(pressure, std::vector<double>(mesh.points.size(), 0.0));
}

}  // namespace
}  // namespace darboux
