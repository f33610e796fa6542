#include "solver/mesh_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "solver/mesh_surface.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

// A thin ball dented by two fingertips much smaller than itself.
std::string ThinBall(int frequency, const std::string& more = "") {
  return "name: thin-ball\nsurface: {kind: icosphere, radius: 31.25, frequency: " +
         std::to_string(frequency) +
         "}\nshell: {thickness: 0.5, young_modulus: 1, poisson_ratio: 0.5}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: {kind: sphere, radius: 2}, position: [0, 0, 40], "
         "direction: [0, 0, -1], motion: {travel: 2}}\n"
         "  - {name: bottom, shape: {kind: sphere, radius: 2}, position: [0, 0, -40], "
         "direction: [0, 0, 1], motion: {travel: 2}}\n" +
         more;
}

// A ball squeezed by Gaussian tractions at both ends of the x axis, in the linear theory.
std::string PatchBall(int frequency, const std::string& more = "") {
  return "name: patch-ball\nsurface: {kind: icosphere, radius: 1, frequency: " +
         std::to_string(frequency) +
         "}\nshell: {thickness: 0.05, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
         "model: {theory: linear}\n"
         "supports: [{on: {near: [0, 0, -1], radius: 0}, clamped: true}]\n"
         "loads: [{kind: traction, force: [\"-sign(x)*exp(-10*(y*y+z*z))\", \"0\", \"0\"]}]\n" +
         more;
}

struct Marked {
  MeshRefinement refinement;
  MeshRefinementReport report;
};

Marked Mark(ShellProblem* problem, const MeshRefinementOptions& options = MeshRefinementOptions()) {
  Marked marked;
  std::string error;
  EXPECT_TRUE(MarkForRefinement(problem, options, &marked.refinement, &marked.report, &error))
      << error;
  return marked;
}

double Force(const Solution& solution) {
  return solution.summary.steps.back().fingers.at(0).normal_force;
}

TEST(MeshRefinementTest, AThinBallsFingerForceTakesAThirdOfTheUnknowns) {
  // Frequency 32: 0.012428. Uniform meshes: 6.8 % at frequency 10, 2.5 % at 11, 0.3 % at 12, which
  // has 4,326 dof.
  Scene scene = SceneFromText(ThinBall(4));
  Solution solution = SolveScene(scene);
  EXPECT_GT(Force(solution), 2.0 * 0.012428);
  double indicator = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 2; ++step) {
    MeshRefinementOptions options;
    options.fraction = 0.5;
    const Marked marked = Mark(solution.problem.get(), options);
    EXPECT_EQ(marked.report.num_quantities, 2);
    EXPECT_LT(marked.report.total, indicator);
    indicator = marked.report.total;
    scene.surface.refinement = std::make_shared<const MeshRefinement>(marked.refinement);
    solution = SolveScene(scene);
    EXPECT_EQ(solution.problem->dof(), marked.report.dof);
  }
  EXPECT_LT(solution.problem->dof(), 4326 / 3);
  EXPECT_NEAR(Force(solution), 0.012428, 0.01 * 0.012428);
}

TEST(MeshRefinementTest, TheIndicatorIsOfTheErrorsSize) {
  // Of a probe's displacement, against a mesh of three times the frequency. Where the field is
  // smooth the error is of fourth order.
  const std::string probe = "probes: [{name: pole, at: {nearest: [1, 0, 0]}}]\n";
  const double fine = SolveScene(SceneFromText(PatchBall(18, probe))).Probe().norm();
  double before = 0.0;
  for (const int frequency : {4, 8}) {
    const Solution solution = SolveScene(SceneFromText(PatchBall(frequency, probe)));
    const double error = std::abs(solution.Probe().norm() - fine) / fine;
    const double total = Mark(solution.problem.get()).report.total;
    EXPECT_LT(total, 30.0 * error);
    EXPECT_GT(total, error);
    if (before > 0.0) {
      EXPECT_LT(total, before / 6.0);
    }
    before = total;
  }
}

// Centre of what is refined, by numbers of triangles.
Eigen::Vector3d Middle(const Scene& scene, const MeshRefinement& refinement) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::int64_t number : refinement.refined.at(0)) {
    for (const int vertex : scene.surface.mesh->triangles[number]) {
      sum += scene.surface.mesh->vertices[vertex];
    }
  }
  return sum / (3.0 * refinement.refined[0].size());
}

TEST(MeshRefinementTest, GoesWhereTheQuantityIsAndElseWhereTheEnergyIs) {
  const Scene scene =
      SceneFromText(PatchBall(6, "probes: [{name: pole, at: {nearest: [1, 0, 0]}}]\n"));
  const Solution solution = SolveScene(scene);
  MeshRefinementOptions options;
  options.fraction = 0.3;
  const Marked probe = Mark(solution.problem.get(), options);
  EXPECT_EQ(probe.report.num_quantities, 3);
  EXPECT_GT(Middle(scene, probe.refinement).x(), 0.6);
  options.probes = false;
  const Marked energy = Mark(solution.problem.get(), options);
  EXPECT_EQ(energy.report.num_quantities, 0);
  EXPECT_LT(std::abs(Middle(scene, energy.refinement).x()), 0.4);
  for (const double indicator : energy.report.indicators) EXPECT_GE(indicator, 0.0);
}

TEST(MeshRefinementTest, LeavesTheProblemAsItWas) {
  for (const std::string more :
       {"", "loads: [{kind: gas, gauge_pressure: 0, ambient_pressure: 0.101325}]\n"}) {
    const Solution solution = SolveScene(SceneFromText(ThinBall(4, more)));
    const Eigen::Matrix3Xd before = solution.problem->displacements();
    const Eigen::Matrix3Xd gradient = solution.problem->Gradient();
    const std::vector<double> pressures = solution.problem->grasp()->state().multipliers;
    const Marked first = Mark(solution.problem.get()), second = Mark(solution.problem.get());
    EXPECT_EQ(solution.problem->displacements(), before);
    EXPECT_EQ(solution.problem->Gradient(), gradient);
    EXPECT_EQ(solution.problem->grasp()->state().multipliers, pressures);
    EXPECT_EQ(first.refinement, second.refinement);
  }
}

TEST(MeshRefinementTest, FingersThatForcesDriveAndFrictionHaveQuantitiesToo) {
  const std::string text =
      "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: 4}\n"
      "shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
      "fingers:\n"
      "  - {name: top, shape: {kind: sphere, radius: 6}, position: [0, 0, 40], "
      "direction: [0, 0, -1], friction: 0.5, motion: {force: 0.8}}\n"
      "  - {name: bottom, shape: {kind: sphere, radius: 6}, position: [0, 0, -40], "
      "direction: [0, 0, 1], friction: 0.5, motion: {force: 0.8}}\n";
  const Scene scene = SceneFromText(text);
  const Solution solution = SolveScene(scene);
  MeshRefinementOptions options;
  options.fraction = 0.3;
  const Marked marked = Mark(solution.problem.get(), options);
  EXPECT_EQ(marked.report.num_quantities, 2);
  // What is refined is near the fingers.
  for (const std::int64_t number : marked.refinement.refined.at(0)) {
    const int vertex = scene.surface.mesh->triangles[number][0];
    EXPECT_GT(std::abs(scene.surface.mesh->vertices[vertex].z()), 0.3 * 31.25);
  }
}

TEST(MeshRefinementTest, KeepsToItsLimits) {
  const Solution solution = SolveScene(SceneFromText(PatchBall(6)));
  MeshRefinementOptions options;
  options.fraction = 1.0;
  const Marked all = Mark(solution.problem.get(), options);
  EXPECT_EQ(all.report.dof, 3 * (10 * 12 * 12 + 2));  // everything: frequency 12
  options.max_dof = 2000;
  const Marked some = Mark(solution.problem.get(), options);
  EXPECT_LE(some.report.dof, 2000);
  EXPECT_GT(some.report.dof, solution.problem->dof());
  EXPECT_LT(some.report.marked, all.report.marked);
  options.max_dof = 1100;
  MeshRefinement refinement;
  MeshRefinementReport report;
  std::string error;
  EXPECT_FALSE(MarkForRefinement(solution.problem.get(), options, &refinement, &report, &error));
  EXPECT_EQ(error, "found no unknown that could be refined within max_dof and max_level");
}

TEST(MeshRefinementTest, RefinesWhatItTakesForTheSumThatIsWantedAndKnowsWhatIsLeft) {
  Scene scene = SceneFromText(PatchBall(4, "probes: [{name: pole, at: {nearest: [1, 0, 0]}}]\n"));
  const Solution solution = SolveScene(scene);
  MeshRefinementOptions options;
  options.fraction = 1.0;
  const Marked all = Mark(solution.problem.get(), options);
  int dof = all.report.dof;
  for (const double part : {0.2, 0.5, 0.8}) {
    options.wanted = part * all.report.total;
    const Marked some = Mark(solution.problem.get(), options);
    EXPECT_LE(some.report.expected, options.wanted);
    EXPECT_LT(some.report.dof, dof);
    dof = some.report.dof;
    scene.surface.refinement = std::make_shared<const MeshRefinement>(some.refinement);
    const double total = Mark(SolveScene(scene).problem.get()).report.total;
    EXPECT_LT(total, 2.0 * some.report.expected) << part;
    EXPECT_GT(total, 0.3 * some.report.expected) << part;
  }
}

TEST(MeshRefinementTest, ContainsWhatTheSceneRefinesNearPoints) {
  Scene scene = SceneFromText(PatchBall(4));
  RefineNearSpec near;
  near.center = {0.0, 0.0, 1.0};
  near.radius = 0.1;
  near.levels = 2;
  scene.surface.refine_near.push_back(near);
  const Solution solution = SolveScene(scene);
  const Marked marked = Mark(solution.problem.get());
  std::string error;
  const auto mesh = MakeHierarchicalMesh(scene.surface, &error);
  ASSERT_NE(mesh, nullptr) << error;
  EXPECT_TRUE(marked.refinement.Contains(mesh->refinement()));
  // The state on the finer mesh, to start from.
  scene.surface.refinement = std::make_shared<const MeshRefinement>(marked.refinement);
  const auto finer = MakeHierarchicalMesh(scene.surface, &error);
  ASSERT_NE(finer, nullptr) << error;
  const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
  ASSERT_NE(problem, nullptr) << error;
  problem->displacements() = mesh->Prolong(solution.problem->displacements(), *finer);
  const double energy = solution.problem->Energy(Effect::kBending);
  EXPECT_NEAR(problem->Energy(Effect::kBending), energy, 1e-3 * energy);  // quadrature
}

TEST(MeshRefinementTest, SaysWhyThereIsNothingToRefine) {
  MeshRefinement refinement;
  MeshRefinementReport report;
  std::string error;
  const auto mark = [&](const Scene& scene, const MeshRefinementOptions& options) {
    const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
    EXPECT_NE(problem, nullptr) << error;
    return MarkForRefinement(problem.get(), options, &refinement, &report, &error);
  };
  EXPECT_FALSE(mark(SceneFromData("clamped_plate.yaml"), MeshRefinementOptions()));
  EXPECT_EQ(error, "found a parametric surface; allowed a mesh");
  EXPECT_FALSE(mark(SceneFromText(PatchBall(3)), MeshRefinementOptions()));  // at rest
  EXPECT_EQ(error, "found no stress that could tell where to refine; allowed a shell under load");
  MeshRefinementOptions options;
  for (const double fraction : {0.0, -1.0, 1.5, std::nan("")}) {
    options.fraction = fraction;
    EXPECT_FALSE(mark(SceneFromText(PatchBall(3)), options));
    EXPECT_NE(error.find("fraction"), std::string::npos);
  }
}

}  // namespace
}  // namespace darboux
