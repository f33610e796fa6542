// Scenes on meshes that are refined locally (surface.refine_near, SurfaceSpec::refinement): all
// that a scene can do.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "geometry/shell_face.h"
#include "solver/fields.h"
#include "solver/mesh_surface.h"
#include "solver/results.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

constexpr char kEverywhere[] = ", refine_near: [{near: [0, 0, 0], radius: 1000, levels: 1}]";
constexpr char kPoles[] =
    ", refine_near: [{near: [0, 0, 31.25], radius: 5, levels: 2}, "
    "{near: [0, 0, -31.25], radius: 5, levels: 2}]";

// A ball of `frequency` between two spheres of 6 mm, the `surface` text with more keys.
std::string Ball(int frequency, const std::string& surface, const std::string& more = "") {
  return "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: " +
         std::to_string(frequency) + surface +
         "}\nshell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: {kind: sphere, radius: 6}, position: [0, 0, 40], "
         "direction: [0, 0, -1], motion: {travel: 3}}\n"
         "  - {name: bottom, shape: {kind: sphere, radius: 6}, position: [0, 0, -40], "
         "direction: [0, 0, 1], motion: {travel: 3}}\n"
         "probes:\n  - {name: pole, at: {nearest: [0, 0, 31.25]}}\n"
         "  - {name: side, at: {nearest: [31.25, 0, 0]}}\n" +
         more;
}

constexpr char kGas[] =
    "loads:\n  - {kind: gas, gauge_pressure: 0, ambient_pressure: 0.101325, law: isothermal, "
    "rest: stress_free}\n";

// A square of side 2 cut out of the plane z = 0, clamped, under a pressure.
std::string Plate(const std::string& surface) {
  return "name: plate\nsurface: {kind: implicit, function: \"z + 0.1 * x * x\", bounds: [[-1, 1], "
         "[-1, 1], [-0.6, 0.5]], edge_length: 0.3, open: true" +
         surface +
         "}\nshell: {thickness: 0.02, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
         "model: {theory: linear}\n"
         "supports: [{on: rim, clamped: true}]\n"
         "loads: [{kind: pressure, value: -1}]\n"
         "probes: [{name: centre, at: {nearest: [0, 0, 0]}}]\n";
}

TEST(LocalRefinementTest, RefinedEverywhereAClosedShellIsRefinedUniformly) {
  for (const std::string more : {"", kGas}) {
    // As exact as what is compared. Below that rounding turns the ball about its free axis.
    SolverOptions options;
    options.gradient_tolerance = 1e-8;
    const Solution uniform = SolveScene(SceneFromText(Ball(3, ", refine: 1", more)), options);
    const Solution local = SolveScene(SceneFromText(Ball(3, kEverywhere, more)), options);
    EXPECT_EQ(local.problem->dof(), uniform.problem->dof());
    const double force = uniform.summary.steps.back().fingers.at(0).normal_force;
    EXPECT_NEAR(local.summary.steps.back().fingers.at(0).normal_force, force, 1e-9 * force);
    EXPECT_NEAR(local.summary.energy_total,
                uniform.summary.energy_total,
                1e-9 * uniform.summary.energy_total);
    for (size_t i = 0; i < 2; ++i) {
      EXPECT_LT((local.Probe(i) - uniform.Probe(i)).norm(), 1e-8 * uniform.Probe(0).norm());
    }
  }
}

TEST(LocalRefinementTest, RefinedNearTheFingersTheForceIsThatOfTheFineMesh) {
  const Solution coarse = SolveScene(SceneFromText(Ball(4, "")));
  const Solution uniform = SolveScene(SceneFromText(Ball(4, ", refine: 1")));
  const Solution local =
      SolveScene(SceneFromText(Ball(4,
                                    ", refine_near: [{near: [0, 0, 31.25], radius: 14, levels: 1}, "
                                    "{near: [0, 0, -31.25], radius: 14, levels: 1}]")));
  EXPECT_LT(local.problem->dof(), 0.7 * uniform.problem->dof());
  const auto force = [](const Solution& s) {
    return s.summary.steps.back().fingers.at(0).normal_force;
  };
  EXPECT_LT(std::abs(force(local) - force(uniform)),
            0.1 * std::abs(force(coarse) - force(uniform)));
  const auto energy = [](const Solution& s) { return s.summary.energy_total; };
  EXPECT_LT(std::abs(energy(local) - energy(uniform)),
            0.1 * std::abs(energy(coarse) - energy(uniform)));
}

TEST(LocalRefinementTest, AnOpenClampedShellConvergesToTheRefinedOne) {
  // The uniform refinement of an open mesh changes the surface; a refinement of all of it does not.
  const Solution coarse = SolveScene(SceneFromText(Plate("")));
  const Solution all = SolveScene(SceneFromText(Plate(kEverywhere)));
  const Solution rim =
      SolveScene(SceneFromText(Plate(", refine_near: [{near: [1, 0, 0], radius: 0.3, levels: 2}, "
                                     "{near: [-1, 1, -0.1], radius: 0.3, levels: 1}]")));
  EXPECT_GT(rim.problem->dof(), coarse.problem->dof());
  EXPECT_NEAR(rim.problem->surface().area(), all.problem->surface().area(), 2e-3);
  for (const Solution* solution : {&coarse, &rim, &all}) {
    EXPECT_LT(solution->problem->LargestViolation(), 1e-6);
  }
  // The clamping, in means over boundary edges, holds more of the rim the finer it is.
  EXPECT_NEAR(rim.Probe().z(), all.Probe().z(), 0.05 * std::abs(all.Probe().z()));
}

TEST(LocalRefinementTest, RigidMotionsAreFreeAndStoreNothing) {
  Scene scene = SceneFromText(Ball(3, kPoles));
  scene.supports.clear();
  scene.fingers.clear();
  std::string error;
  ShellProblem::Options options;
  options.nonlinear = true;
  const auto problem = ShellProblem::Create(scene, options, &error);
  ASSERT_NE(problem, nullptr) << error;
  EXPECT_EQ(problem->free_motions().size(), 6u);
  const Eigen::Matrix3d r =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3Xd& x = problem->surface().control_points();
  Eigen::Matrix3Xd u = (r * x - x).colwise() + Eigen::Vector3d(1, -2, 3);
  for (int i = 0; i < u.cols(); ++i) {
    if (!problem->surface().IsActive(i)) u.col(i).setZero();
  }
  problem->displacements() = u;
  const double moved = problem->Energy(Effect::kMembrane) + problem->Energy(Effect::kBending);
  problem->displacements() = 0.01 * x;
  const double stretched = problem->Energy(Effect::kMembrane);
  EXPECT_LT(moved, 1e-20 * stretched / 1e-4);
}

TEST(LocalRefinementTest, UniformInflationOfASphereIsUniformOnAllLevels) {
  Scene scene = SceneFromText(
      "name: inflated\nsurface: {kind: icosphere, radius: 1, frequency: 8, refine_near: [{near: "
      "[0.1, 0.2, 1], radius: 0.3, levels: 2}]}\n"
      "shell: {thickness: 0.05, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
      "model: {theory: linear}\nloads: [{kind: pressure, value: 10}]\n"
      "probes: [{name: fine, at: {nearest: [0.1, 0.2, 1]}}, {name: coarse, at: {nearest: [0, 0, "
      "-1]}}]\n");
  const Solution solution = SolveScene(scene);
  // w = p R^2 (1 - nu) / (2 E h); the sphere is one to 1e-3.
  const double w = 10.0 * 0.7 / (2.0 * 1.0e6 * 0.05);
  for (size_t i = 0; i < 2; ++i) EXPECT_NEAR(solution.Probe(i).norm(), w, 0.02 * w);
}

std::unique_ptr<ShellProblem> ProblemOf(const std::string& text) {
  std::string error;
  auto problem = ShellProblem::Create(SceneFromText(text), ShellProblem::Options(), &error);
  EXPECT_NE(problem, nullptr) << error;
  return problem;
}

TEST(LocalRefinementTest, TheDrawnMeshHasNoCracks) {
  for (const std::string& text :
       {Ball(3, kPoles), Plate(", refine_near: [{near: [1, 0, 0], radius: 0.3, levels: 2}]")}) {
    const auto problem = ProblemOf(text);
    const ShellSurface& surface = problem->surface();
    const OutputMesh mesh = MakeOutputMesh(surface);
    std::map<std::pair<int, int>, int> edges;
    double area = 0.0;
    for (const auto& t : mesh.triangles) {
      Eigen::Vector3d x[3];
      for (int k = 0; k < 3; ++k) {
        x[k] = surface.Position(mesh.points[t[k]]);
        ++edges[{t[k], t[(k + 1) % 3]}];
      }
      const Eigen::Vector3d normal = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]);
      EXPECT_GT(normal.dot(surface.MakePoint(mesh.points[t[0]]).n), 0.9 * normal.norm());
      area += normal.norm();
    }
    EXPECT_NEAR(area, surface.area(), 0.01 * surface.area());
    size_t open = 0, boundary = 0;
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      if (edges.count({edge.second, edge.first}) == 0) ++open;
    }
    for (int k = 0; k < surface.num_loops(); ++k) {
      boundary += surface.BoundaryEdges(ShellSurface::Loop(k)).size();
    }
    EXPECT_EQ(open, 2 * boundary);
    for (size_t i = 0; i < mesh.points.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        EXPECT_GT((surface.Position(mesh.points[i]) - surface.Position(mesh.points[k])).norm(),
                  1e-3 * surface.size());
      }
    }
  }
}

TEST(LocalRefinementTest, TheNearestPointIsFoundAcrossLevels) {
  for (const std::string& text :
       {Ball(3, kPoles), Plate(", refine_near: [{near: [1, 0, 0], radius: 0.3, levels: 2}]")}) {
    const auto problem = ProblemOf(text);
    const ShellSurface& surface = problem->surface();
    std::mt19937 gen(90411);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    // A smooth bump in the displacement.
    Eigen::Matrix3Xd u = 0.05 * surface.control_points();
    for (int i = 0; i < u.cols(); ++i) u.col(i) *= std::sin(3.0 * u(2, i) / surface.size());
    ShellFace face(surface, 0.02 * surface.size());
    face.SetDisplacements(u);
    // What face says about its own points, from there and from a hint elsewhere.
    for (int k = 0; k < 400; ++k) {
      const int e = std::uniform_int_distribution<int>(0, surface.num_elements() - 1)(gen);
      double s = std::abs(uniform(gen)), t = std::abs(uniform(gen));
      if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
      const ShellFace::Foot on = face.Evaluate({e, s, t});
      const double height = 0.01 * surface.size() * uniform(gen);
      const Eigen::Vector3d x = on.position + height * on.normal;
      const ShellFace::Foot foot = face.Closest(x);
      EXPECT_NEAR(std::abs(foot.distance), std::abs(height), 1e-9 * surface.size());
      EXPECT_LT((foot.position - on.position).norm(), 1e-6 * surface.size());
      const ShellFace::Foot other = face.Evaluate({(e + 1) % surface.num_elements(), 0.3, 0.3});
      EXPECT_NEAR(face.Closest(x, &other).distance, foot.distance, 1e-9 * surface.size());
      const Eigen::Vector3d p = surface.Position({e, s, t});
      EXPECT_LT((surface.Position(surface.ClosestPoint(p)) - p).norm(), 1e-9 * surface.size());
    }
  }
}

TEST(LocalRefinementTest, ANeighbourhoodIsHeldOnceAtEveryPoint) {
  // The lattice of a neighbourhood smaller than a triangle, on an edge between two levels.
  const auto plain = ProblemOf(Ball(3, kPoles));
  const ShellSurface& surface = plain->surface();
  int element = 0, side = 0;
  while (surface.HangingCorner(element, side) < 0) {
    side = (side + 1) % 3;
    if (side == 0) ++element;
  }
  constexpr double kCorner[4][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}};
  const Eigen::Vector3d x = surface.Position({element,
                                              0.7 * kCorner[side][0] + 0.3 * kCorner[side + 1][0],
                                              0.7 * kCorner[side][1] + 0.3 * kCorner[side + 1][1]});
  Scene scene = SceneFromText(Ball(3, kPoles));
  scene.supports.resize(1);
  scene.supports[0].on.center = {x.x(), x.y(), x.z()};
  scene.supports[0].on.radius = 2.0;
  std::string error;
  const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
  ASSERT_NE(problem, nullptr) << error;
  // No two of the conditions of a component are the same.
  std::vector<Eigen::VectorXd> rows;
  for (const PlacedCondition& condition : problem->conditions()) {
    Eigen::Matrix3Xd full = Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices);
    for (size_t i = 0; i < condition.vertices.size(); ++i) {
      full.col(condition.vertices[i]) += condition.coefficients.col(i);
    }
    const Eigen::VectorXd row = Eigen::Map<Eigen::VectorXd>(full.data(), full.size());
    for (const Eigen::VectorXd& other : rows) EXPECT_GT((row - other).norm(), 1e-3 * row.norm());
    rows.push_back(row);
  }
  EXPECT_GE(rows.size(), 14u);
}

TEST(LocalRefinementTest, FrictionAndForcesWorkToo) {
  std::string text = Ball(3, kPoles);
  text.replace(text.find("supports:"), text.find("fingers:") - text.find("supports:"), "");
  for (size_t at = text.find("travel: 3"); at != std::string::npos; at = text.find("travel: 3")) {
    text.replace(at, 9, "force: 0.8");
  }
  for (size_t at = text.find("motion: {f"); at != std::string::npos;
       at = text.find("motion: {f", at + 20)) {
    text.insert(at, "friction: 0.5, ");
  }
  const Solution solution = SolveScene(SceneFromText(text));
  EXPECT_NEAR(solution.summary.steps.back().fingers.at(0).force.z(), 0.8, 1e-5);
}

TEST(LocalRefinementTest, AProgramSaysWhatIsRefined) {
  Scene scene = SceneFromText(Ball(3, ""));
  std::string error;
  const auto base = MakeHierarchicalMesh(scene.surface, &error);
  ASSERT_NE(base, nullptr) << error;
  scene.surface.refinement =
      std::make_shared<const MeshRefinement>(base->RefineElements({0, 7, 50}));
  const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
  ASSERT_NE(problem, nullptr) << error;
  EXPECT_EQ(problem->surface().num_elements(), 20 * 9 + 3 * 3);
  // With refine_near both are refined.
  Scene both = SceneFromText(Ball(3, kPoles));
  both.surface.refinement = scene.surface.refinement;
  const auto more = MakeHierarchicalMesh(both.surface, &error);
  ASSERT_NE(more, nullptr) << error;
  EXPECT_TRUE(more->refinement().Contains(*scene.surface.refinement));
}

TEST(LocalRefinementTest, AFreeShellUnderBalancedLoadsNeedsNoSupports) {
  // Leaves of different sizes integrate the two halves differently, by 2e-6 here.
  const Scene scene = SceneFromText(
      "name: free\nsurface: {kind: icosphere, radius: 1, frequency: 6, refine_near: [{near: [0.3, "
      "0.4, 0.9], radius: 0.2, levels: 2}]}\n"
      "shell: {thickness: 0.05, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
      "loads: [{kind: traction, force: [\"0\", \"0\", \"-sign(z)*exp(-10*(x*x+y*y))\"]}]\n"
      "probes: [{name: up, at: {nearest: [0, 0, 1]}}, {name: down, at: {nearest: [0, 0, -1]}}]\n");
  const Solution solution = SolveScene(scene);
  EXPECT_EQ(solution.summary.free_motions.size(), 6u);
  EXPECT_LT(solution.Probe(0).z(), 0.0);
  EXPECT_NEAR(solution.Probe(0).z(), -solution.Probe(1).z(), 0.02 * solution.Probe(1).z());
}

TEST(LocalRefinementTest, ANeighbourhoodOffTheSurfaceIsAnError) {
  const Scene scene =
      SceneFromText(Ball(3, ", refine_near: [{near: [0, 0, 90], radius: 5, levels: 1}]"));
  std::string error;
  EXPECT_EQ(ShellProblem::Create(scene, ShellProblem::Options(), &error), nullptr);
  EXPECT_EQ(error,
            "test.yaml:2: surface.refine_near[0]: found a neighbourhood without a point of the "
            "surface; allowed a point on it or a larger radius");
}

}  // namespace
}  // namespace darboux
