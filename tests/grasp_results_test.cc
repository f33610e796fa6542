// What is said of a grasp: stiffness against differences, work against energy, contact before and
// after.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "solver/grasp_quality.h"
#include "solver/mixed_iteration.h"
#include "solver/results.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

// A ball of 31.25 mm and E = 1 MPa between two spheres.
struct BallSpec {
  double top = 4.0, bottom = 4.0;
  double friction = 0.0;
  int steps = 1;
  std::string more = "";
  int frequency = 5;
  double tilt = 0.0;  // of the top finger's direction
};

Scene Ball(const BallSpec& spec) {
  std::ostringstream text;
  text.precision(17);
  text << "name: ball\nsteps: " << spec.steps
       << "\nsurface: {kind: icosphere, radius: 31.25, frequency: " << spec.frequency
       << "}\nshell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
       << "model: {minimizer: mip}\n"
       << spec.more;
  if (spec.friction == 0.0) {
    text << "supports:\n";
    for (const char* sign : {"", "-"}) {
      text << "  - {on: {near: [0, 0, " << sign << "31.25], radius: 0}, fix: [x, y]}\n";
    }
  }
  text << "fingers:\n";
  for (const bool top : {true, false}) {
    text << "  - {name: " << (top ? "top" : "bottom")
         << ", shape: {kind: sphere, radius: 4}, position: [0, 0, " << (top ? 40.0 : -40.0)
         << "], direction: [" << (top ? std::sin(spec.tilt) : 0.0) << ", 0, "
         << (top ? -std::cos(spec.tilt) : 1.0)
         << "], motion: {travel: " << (top ? spec.top : spec.bottom)
         << "}, friction: " << spec.friction << "}\n";
  }
  return SceneFromText(text.str());
}

// A finger on a clamped plate, along a direction tilted by an angle; everything of length times
// `unit`.
Scene Plate(double travel, double tilt = 0.0, double friction = 0.0, double unit = 1.0) {
  std::ostringstream text;
  text.precision(17);
  const double a = 10.0 * unit;
  text << "name: plate\nsurface: {kind: plane, u: [" << -a << ", " << a << "], v: [" << -a << ", "
       << a << "], divisions: [8, 8]}\nshell: {thickness: " << 0.5 * unit
       << ", young_modulus: " << 100.0 / (unit * unit)
       << ", poisson_ratio: 0.3}\nmodel: {minimizer: mip}\nsupports: [{on: rim, clamped: true}]\n"
       << "fingers: [{name: tip, shape: {kind: sphere, radius: " << 4.0 * unit << "}, position: ["
       << 0.3 * unit << ", " << 0.2 * unit << ", " << 6.0 * unit << "], direction: ["
       << std::sin(tilt) << ", 0, " << -std::cos(tilt) << "], motion: {travel: " << travel * unit
       << "}, friction: " << friction << "}]\n";
  return SceneFromText(text.str());
}

SolverOptions Exact() {
  SolverOptions options;
  options.gradient_tolerance = 1e-10;
  options.num_threads = 1;
  return options;
}

// With a load of nothing: the solver cannot know that all work is stored and integrates the forces.
Scene WithNil(Scene scene) {
  LoadSpec nil;
  nil.kind = LoadSpec::Kind::kPressure;
  scene.loads.push_back(nil);
  return scene;
}

const GraspReport& GraspOf(const Solution& solution) {
  return solution.summary.steps.back().grasp.value();
}

// An equilibrium of `scene`, which is that of `base` but for travels that differ a little, from the
// state of base on and with contact that gives way by less than 1e-8 of the thickness; and
// the forces of its fingers along their directions.
struct Near {
  std::unique_ptr<ShellProblem> problem;
  std::unique_ptr<MixedIteration> mixed;
  Eigen::VectorXd forces;
};

Near SolveNear(const Solution& base, const Scene& scene) {
  Near near;
  ShellProblem::Options options;
  options.nonlinear = true;
  std::string error;
  near.problem = ShellProblem::Create(scene, options, &error);
  EXPECT_NE(near.problem, nullptr) << error;
  ShellProblem* const problem = near.problem.get();
  Grasp* const grasp = problem->grasp();
  problem->SetLoadFactor(1.0);
  problem->displacements() = base.problem->displacements();
  problem->SetMultipliers(base.problem->multipliers());
  EXPECT_EQ(grasp->state().multipliers.size(), base.problem->grasp()->state().multipliers.size());
  grasp->SetState(base.problem->grasp()->state());
  near.mixed = std::make_unique<MixedIteration>(problem, SparseBackend::kAuto, 1);
  MixedIteration& mixed = *near.mixed;
  EXPECT_TRUE(mixed.SetStresses());
  MixedIteration::Options mixed_options;
  mixed_options.gradient_tolerance = 1e-10;
  for (int pass = 0; pass < 60; ++pass) {
    const MixedIteration::Summary summary = mixed.Solve(mixed_options);
    EXPECT_TRUE(summary.converged) << summary.message;
    Grasp::State state = grasp->state();
    double deep = 0.0, change = 0.0, total = 0.0;
    for (const Grasp::Block& block : grasp->blocks()) {
      const std::vector<ContactState> points = grasp->States(block);
      for (size_t q = 0; q < points.size(); ++q) {
        if (points[q].pressure > 0.0) deep = std::max(deep, std::abs(points[q].gap));
        state.multipliers[block.first + q] = points[q].pressure;
        const double force = points[q].force_on_finger.norm();
        change += std::abs(force - state.friction[block.first + q].normal_force);
        total += force;
      }
    }
    const bool frictionless = scene.fingers[0].friction == 0.0;
    if (deep < 1e-8 * problem->material().thickness && (frictionless || change < 1e-8 * total)) {
      break;
    }
    EXPECT_LT(pass, 59) << deep << " " << change / total;
    grasp->SetState(state);
    grasp->LagFriction();
  }
  std::vector<TravelDerivatives> by_travel;
  EXPECT_TRUE(grasp->ByTravel(&by_travel));
  near.forces.resize(by_travel.size());
  for (size_t i = 0; i < by_travel.size(); ++i) {
    near.forces[i] = problem->force_unit() * by_travel[i].energy;
  }
  return near;
}

// Column j of the stiffness by differences.
Eigen::VectorXd ByDifferences(const Solution& base, const Scene& scene, int j, double step) {
  Scene more = scene, less = scene;
  more.fingers[j].travel += step;
  less.fingers[j].travel -= step;
  return (SolveNear(base, more).forces - SolveNear(base, less).forces) / (2.0 * step);
}

// ---- Stiffness ------------------------------------------------------------------------------

TEST(GraspStiffnessTest, OfABallIsThatOfDifferences) {
  const Scene scene = Ball({});
  const Solution solution = SolveScene(scene, Exact());
  const Eigen::MatrixXd& stiffness = GraspOf(solution).stiffness;
  ASSERT_EQ(stiffness.rows(), 2);
  for (int j = 0; j < 2; ++j) {
    const Eigen::VectorXd expected = ByDifferences(solution, scene, j, 1e-3);
    EXPECT_NEAR(stiffness(0, j), expected[0], 1e-3 * std::abs(expected[0]));
    EXPECT_NEAR(stiffness(1, j), expected[1], 1e-3 * std::abs(expected[1]));
  }
  // A free body: one finger that moves by 2 is both that move by 1.
  EXPECT_NEAR(stiffness(0, 1), stiffness(0, 0), 1e-4 * stiffness(0, 0));
  EXPECT_NEAR(stiffness(1, 0), stiffness(0, 1), 1e-9 * stiffness(0, 0));
}

TEST(GraspStiffnessTest, OfAClampedPlateIsThatOfDifferences) {
  const Scene scene = Plate(0.6);
  const Solution solution = SolveScene(scene, Exact());
  const double stiffness = GraspOf(solution).stiffness(0, 0);
  EXPECT_NEAR(stiffness, ByDifferences(solution, scene, 0, 1e-4)[0], 1e-3 * stiffness);
}

TEST(GraspStiffnessTest, WithFrictionIsThatOfDifferences) {
  const Scene scene = Ball({3.0, 3.0, 0.6});
  const Solution solution = SolveScene(scene, Exact());
  const Eigen::MatrixXd& stiffness = GraspOf(solution).stiffness;
  ASSERT_EQ(stiffness.rows(), 2);
  const Eigen::VectorXd expected = ByDifferences(solution, scene, 0, 1e-3);
  EXPECT_NEAR(stiffness(0, 0), expected[0], 1e-3 * expected[0]);
  EXPECT_NEAR(stiffness(1, 0), expected[1], 1e-3 * expected[1]);
}

// A finger that slides over the plate: its friction grows with what it is pressed on with. Ahead of
// the state where all that slips is only about to.
TEST(GraspStiffnessTest, OfASlidingFingerIsThatOfDifferences) {
  const Scene scene = Plate(0.6, 0.6, 0.2);
  const Solution solution = SolveScene(scene, Exact());
  Scene ahead = scene;
  ahead.fingers[0].travel += 5e-3;
  const Near near = SolveNear(solution, ahead);
  const FingerReport finger = near.problem->grasp()->Report(1.0)[0];
  EXPECT_EQ(finger.sticking, 0);
  EXPECT_GT(finger.slipping, 1);
  UpdatedCholesky cholesky(SparseCholesky::Create(SparseBackend::kAuto));
  cholesky.Analyze(near.mixed->tangent().matrix());
  Eigen::MatrixXd stiffness;
  ASSERT_TRUE(GraspStiffness(near.problem.get(), &near.mixed->tangent(), &cholesky, &stiffness));
  stiffness *= near.problem->force_unit();
  const double expected = ByDifferences(solution, ahead, 0, 1e-4)[0];
  EXPECT_NEAR(stiffness(0, 0), expected, 1e-3 * expected);
}

// The state asked for is the one the way begins with.
TEST(GraspStiffnessTest, IsThatOfFirstTouchWhereNothingMoves) {
  const Scene scene = Ball({0.0, 0.0});
  const Solution solution = SolveScene(scene);
  const Solution integrated = SolveScene(WithNil(scene));
  const Eigen::MatrixXd& stiffness = GraspOf(solution).stiffness;
  ASSERT_EQ(stiffness.rows(), 2);
  EXPECT_EQ(stiffness, GraspOf(integrated).stiffness);
  EXPECT_EQ(GraspOf(solution).squeeze_work, 0.0);
  // The ball between two fingers is two springs in a row: both matter alike.
  EXPECT_GT(stiffness(0, 0), 0.0);
  EXPECT_NEAR(stiffness(0, 1), stiffness(0, 0), 1e-6 * stiffness(0, 0));
  // A dent of 2 % of the thickness, which softens the ball a little, hardly differs.
  const double after = GraspOf(SolveScene(Ball({0.05, 0.05}))).stiffness(0, 0);
  EXPECT_LT(after, stiffness(0, 0));
  EXPECT_NEAR(after, stiffness(0, 0), 0.02 * stiffness(0, 0));
}

// ---- Work -----------------------------------------------------------------------------------

TEST(SqueezeWorkTest, WithoutFrictionIsStored) {
  for (const int steps : {1, 8}) {
    const Scene scene = Ball({8.0, 8.0, 0.0, steps});
    const Solution solution = SolveScene(scene);
    const GraspReport& grasp = GraspOf(solution);
    EXPECT_GT(grasp.stored_energy, 0.0);
    EXPECT_EQ(grasp.squeeze_work, grasp.stored_energy);
    const Solution integrated = SolveScene(WithNil(scene));
    const double work = GraspOf(integrated).squeeze_work;
    EXPECT_NE(work, grasp.stored_energy);
    EXPECT_NEAR(work, grasp.stored_energy, 1e-3 * grasp.stored_energy) << steps;
  }
}

TEST(SqueezeWorkTest, OfASealedBallIsStoredInShellAndGas) {
  BallSpec spec;
  spec.more = "loads: [{kind: gas, gauge_pressure: 0.005, ambient_pressure: 0.1}]\n";
  const Solution solution = SolveScene(WithNil(Ball(spec)));
  const GraspReport& grasp = GraspOf(solution);
  EXPECT_NE(grasp.squeeze_work, grasp.stored_energy);
  EXPECT_NEAR(grasp.squeeze_work, grasp.stored_energy, 1e-3 * grasp.stored_energy);
}

TEST(SqueezeWorkTest, FrictionTakesItsPart) {
  Scene scene = Plate(0.6, 0.6, 0.2);
  scene.steps = 4;
  const Solution solution = SolveScene(scene);
  const GraspReport& grasp = GraspOf(solution);
  EXPECT_GT(grasp.squeeze_work, grasp.stored_energy);
  // It slides by about travel * sin(tilt), against mu N.
  double friction = 0.0, before = 0.0;
  for (const LoadStep& step : solution.summary.steps) {
    const double now = step.fingers[0].normal_force;
    friction += 0.5 * (before + now) * 0.2 * 0.6 / 4.0 * std::sin(0.6);
    before = now;
  }
  EXPECT_NEAR(grasp.squeeze_work - grasp.stored_energy, friction, 0.15 * friction);
}

// ---- Contact before and after, files ----------------------------------------------------------

TEST(GraspResultsTest, SummaryHasWhatAPlannerAsks) {
  const Scene scene = Ball({2.0, 2.0, 0.6});
  const Solution solution = SolveScene(scene);
  const nlohmann::ordered_json json = MakeSummaryJson(scene, solution.summary, nullptr);
  const auto& top = json["fingers"]["top"];
  EXPECT_NEAR(top["center_before"]["z"].get<double>(), 31.25, 0.02);
  EXPECT_NEAR(top["normal_before"]["z"].get<double>(), -1.0, 1e-3);
  EXPECT_NEAR(top["normal"]["z"].get<double>(), -1.0, 1e-3);
  EXPECT_NEAR(top["friction_cone"]["half_angle"].get<double>(), std::atan(0.6), 1e-12);
  const double used = top["friction_cone"]["used"].get<double>();
  EXPECT_NEAR(std::tan(top["friction_cone"]["force_angle"].get<double>()), 0.6 * used, 1e-12);
  EXPECT_LT(used, 0.1);
  const auto& grasp = json["grasp"];
  for (const char* when : {"force_closure_before", "force_closure_after"}) {
    const auto& closure = grasp[when];
    EXPECT_TRUE(closure["closed"].get<bool>()) << closure["lacks"];
    EXPECT_GT(closure["margin"].get<double>(), 0.0);
    EXPECT_LT(closure["least_friction"].get<double>(), 0.1);
    EXPECT_EQ(closure["lacks"], "");
  }
  EXPECT_EQ(top["stiffness"], grasp["stiffness"][0][0]);
  EXPECT_NEAR(grasp["length"].get<double>(), 31.25, 0.05);
  // Even pressure on the patch is the upper bound of what spheres press.
  const double even =
      2.0 / 3.0 * std::sqrt(top["contact_area"].get<double>() / 3.14159265358979323846);
  EXPECT_GT(top["spin_arm"].get<double>(), 0.5 * even);
  EXPECT_LT(top["spin_arm"].get<double>(), 1.5 * even);
}

// Pressure times area along the normals, and friction, are the finger's force, step by step.
TEST(GraspResultsTest, PointsInContactCarryTheForces) {
  Scene scene = Plate(0.6, 0.6, 0.2);
  scene.steps = 3;
  const Solution solution = SolveScene(scene);
  for (const LoadStep& step : solution.summary.steps) {
    ASSERT_FALSE(step.contact_points.empty());
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (const ContactPointReport& point : step.contact_points) {
      EXPECT_EQ(point.finger, 0);
      EXPECT_GT(point.pressure, 0.0);
      force += point.friction - point.pressure * point.area * point.normal;
    }
    const FingerReport& finger = step.fingers[0];
    EXPECT_LE((force - finger.force).norm(), 1e-12 * force.norm());
    EXPECT_EQ(static_cast<int>(step.contact_points.size()), finger.contact_points);
  }
}

TEST(GraspResultsTest, FrictionlessFingersAreNoForceClosure) {
  const Scene scene = Ball({2.0, 2.0});
  const Solution solution = SolveScene(scene);
  const nlohmann::ordered_json json = MakeSummaryJson(scene, solution.summary, nullptr);
  EXPECT_FALSE(json["grasp"]["force_closure_after"]["closed"].get<bool>());
  EXPECT_EQ(json["grasp"]["force_closure_after"]["margin"].get<double>(), 0.0);
  EXPECT_NE(json["grasp"]["force_closure_after"]["lacks"], "");
  EXPECT_LT(json["grasp"]["force_closure_after"]["least_friction"].get<double>(), 0.05);
  EXPECT_NEAR(json["fingers"]["top"]["friction_cone"]["force_angle"].get<double>(), 0.0, 1e-6);
  EXPECT_TRUE(json["fingers"]["top"]["friction_cone"]["used"].is_null());
}

TEST(GraspResultsTest, MillimetresAndMetresAgree) {
  SolverOptions options = Exact();
  options.gradient_tolerance = 1e-11;
  const Solution mm = SolveScene(Plate(0.6, 0.6, 0.2), options);
  const Solution m = SolveScene(Plate(0.6, 0.6, 0.2, 1e-3), options);
  const GraspReport &a = GraspOf(mm), &b = GraspOf(m);
  EXPECT_NEAR(1e-3 * b.stiffness(0, 0), a.stiffness(0, 0), 1e-9 * a.stiffness(0, 0));
  EXPECT_NEAR(1e3 * b.squeeze_work, a.squeeze_work, 1e-9 * a.squeeze_work);
  EXPECT_NEAR(1e3 * b.stored_energy, a.stored_energy, 1e-9 * a.stored_energy);
  EXPECT_NEAR(1e3 * b.length, a.length, 1e-12 * a.length);
  EXPECT_NEAR(b.closure_after.margin, a.closure_after.margin, 1e-9);
}

TEST(GraspResultsTest, SceneWithoutFingersHasAnEmptyGrasp) {
  const Scene scene = SceneFromData("clamped_plate.yaml");
  const Solution solution = SolveScene(scene);
  EXPECT_EQ(MakeSummaryJson(scene, solution.summary, nullptr)["grasp"],
            nlohmann::ordered_json::object());
}

// Stiffness and force of a sweep are one curve: Hermite's rule gives the forces back.
TEST(GraspResultsTest, SweepOverTravelIsACurve) {
  const Solution solution = SolveScene(WithNil(Plate(1.0)));
  Scene scene = WithNil(Plate(1.0));
  scene.steps = 10;
  const Solution sweep = SolveScene(scene);
  ASSERT_EQ(sweep.summary.steps.size(), 10u);
  double work = 0.0;
  for (size_t i = 1; i < sweep.summary.steps.size(); ++i) {
    const LoadStep &a = sweep.summary.steps[i - 1], &b = sweep.summary.steps[i];
    const double change = b.fingers[0].force.z() - a.fingers[0].force.z();
    const double mean = 0.5 * (a.grasp->stiffness(0, 0) + b.grasp->stiffness(0, 0));
    EXPECT_NEAR(change, 0.1 * mean, 0.1 * change);
    EXPECT_GT(b.grasp->squeeze_work, work);
    work = b.grasp->squeeze_work;
  }
  EXPECT_NEAR(work, GraspOf(sweep).stored_energy, 1e-3 * work);
  EXPECT_NEAR(GraspOf(solution).squeeze_work, work, 5e-3 * work);
}

}  // namespace
}  // namespace darboux
