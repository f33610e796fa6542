#include "solver/shell_solver.h"

#include <ceres/crs_matrix.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "tests/solve_util.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

constexpr char kPlate[] = R"(
name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [8, 8]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: rim, clamped: true}
loads:
  - {kind: normal_traction, value: 1}
probes:
  - {name: centre, at: {uv: [50, 50]}}
)";

constexpr char kCylinder[] = R"(
name: cylinder
surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [8, 8]}
shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: u_min, fix: [y, z]}
  - {on: u_max, symmetry: x}
  - {on: v_min, symmetry: y}
  - {on: v_max, symmetry: z}
loads:
  - {kind: point, at: {uv: [300, 0]}, force: [0, 0, -0.25]}
probes:
  - {name: under_load, at: {uv: [300, 0]}}
)";

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// What is said about a scene that cannot be posed.
std::string RefusalOf(const Scene& scene) {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  EXPECT_FALSE(Solve(scene, SolverOptions(), &problem, &summary, &error));
  return error;
}

const EffectSummary& EffectNamed(const SolverSummary& summary, const std::string& name) {
  for (const EffectSummary& effect : summary.effects) {
    if (effect.name == name) return effect;
  }
  ADD_FAILURE() << "no effect " << name;
  return summary.effects.front();
}

TEST(ShellSolverTest, LinearTheoryTakesOneGaussNewtonStep) {
  const Solution solution = SolveScene(SceneFromText(kCylinder));
  EXPECT_EQ(solution.summary.iterations, 1);
  EXPECT_LE(solution.summary.gradient_norm, 1e-8);
}

TEST(ShellSolverTest, ClapeyronHoldsInTheLinearTheory) {
  // Work of the loads = twice the strain energy; supports that do not give way store nothing.
  const Solution solution = SolveScene(SceneFromText(kCylinder));
  const SolverSummary& s = solution.summary;
  const double strain = EffectNamed(s, "membrane").energy + EffectNamed(s, "bending").energy;
  EXPECT_NEAR(s.load_work, 2.0 * strain, 1e-9 * s.load_work);
  EXPECT_NEAR(s.energy_total, -0.5 * s.load_work, 1e-9 * s.load_work);
  EXPECT_LE(std::abs(s.support_energy), 1e-9 * strain);
}

TEST(ShellSolverTest, ReactionsBalanceTheLoads) {
  const Solution solution = SolveScene(SceneFromText(kPlate));
  EXPECT_NEAR(solution.summary.applied_force.z(), 1e4, 1e-8);
  EXPECT_NEAR(solution.summary.reaction.z(), -1e4, 1e-4);
  EXPECT_LE(solution.summary.force_balance, 1e-8);
}

TEST(ShellSolverTest, ReactionsOfFixedRingsBalanceTheLoads) {
  Scene scene = SceneFromText(kPlate);
  scene.model.boundary_rule = BoundaryRule::kSeedGhosts;
  const Solution solution = SolveScene(scene);
  EXPECT_NEAR(solution.summary.reaction.z(), -1e4, 1e-4);
}

TEST(ShellSolverTest, FlatPlateUnderTransverseLoadHasNoMembraneUnknowns) {
  const Solution solution = SolveScene(SceneFromText(kPlate));
  EXPECT_EQ(3 * solution.summary.unknowns, solution.summary.dof);
  ceres::CRSMatrix jacobian;
  solution.problem->problem()->Evaluate({}, nullptr, nullptr, nullptr, &jacobian);
  EXPECT_EQ(jacobian.num_cols, solution.summary.unknowns);
  const EffectSummary& membrane = EffectNamed(solution.summary, "membrane");
  EXPECT_FALSE(membrane.report.on);
  EXPECT_EQ(membrane.report.residual_blocks, 0);
  EXPECT_THAT(membrane.report.why, HasSubstr("in-plane displacement is exactly zero"));
  EXPECT_TRUE(EffectNamed(solution.summary, "bending").report.on);
}

TEST(ShellSolverTest, DecoupledPlateEqualsTheCoupledOne) {
  // A tiny in-plane pull brings the membrane back without changing the deflection.
  const Solution alone = SolveScene(SceneFromText(kPlate));
  const Solution coupled = SolveScene(SceneFromText(
      Replace(kPlate, "loads:\n", "loads:\n  - {kind: traction, force: [1.0e-3, 0, 0]}\n")));
  EXPECT_TRUE(EffectNamed(coupled.summary, "membrane").report.on);
  EXPECT_EQ(coupled.summary.unknowns, coupled.summary.dof);
  EXPECT_NEAR(alone.Probe().z(), coupled.Probe().z(), 1e-9 * coupled.Probe().z());
}

TEST(ShellSolverTest, InPlaneLoadNeedsNoBending) {
  // A strip pulled by its end: u = p L / (E h), free to contract.
  const Solution solution = SolveScene(SceneFromText(R"(
name: strip
surface: {kind: plane, u: [0, 10], v: [0, 2], divisions: [6, 3]}
shell: {thickness: 0.1, young_modulus: 2.0e5, poisson_ratio: 0.25}
model: {theory: linear, quadrature: 6}   # uniform strain is exact from six points on
supports:
  - {on: u_min, fix: [x]}
  - {on: v_min, fix: [y]}
loads:
  - {kind: edge, on: u_max, force: [30, 0, 0]}
probes:
  - {name: tip, at: {uv: [10, 2]}}
)"));
  EXPECT_FALSE(EffectNamed(solution.summary, "bending").report.on);
  const double strain = 30.0 / (2.0e5 * 0.1);
  EXPECT_NEAR(solution.Probe().x(), strain * 10.0, 1e-9 * strain);
  EXPECT_NEAR(solution.Probe().y(), -0.25 * strain * 2.0, 1e-9 * strain);
}

TEST(ShellSolverTest, EffectsThatAreOffSayWhyAndAddNothing) {
  const Solution solution = SolveScene(SceneFromText(kCylinder));
  for (const char* name : {"contact", "friction", "gas", "gravity", "geometric_nonlinearity"}) {
    const EffectSummary& effect = EffectNamed(solution.summary, name);
    EXPECT_FALSE(effect.report.on) << name;
    EXPECT_EQ(effect.report.residual_blocks, 0) << name;
    EXPECT_FALSE(effect.report.why.empty()) << name;
  }
}

TEST(ShellSolverTest, EigenBackendGivesTheSameAnswer) {
  const Solution cholmod = SolveScene(SceneFromText(kCylinder));
  SolverOptions options;
  options.backend = SparseBackend::kEigen;
  const Solution eigen = SolveScene(SceneFromText(kCylinder), options);
  EXPECT_EQ(eigen.summary.backend, "eigen_sparse");
  EXPECT_LE((eigen.Probe() - cholmod.Probe()).norm(), 1e-8 * cholmod.Probe().norm());
}

// mm and N against m and N: lengths 1e-3, modulus 1e6, densities of force per area 1e6.
TEST(ShellSolverTest, AnswersDoNotDependOnTheUnitOfLength) {
  const char* const text = R"(
name: scale
surface: {kind: torus, radii: [$R, $r], u: [0, 2], v: [-1, 1.5], divisions: [8, 8]}
shell: {thickness: $h, young_modulus: $E, poisson_ratio: 0.3}
model: {theory: $T}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: point, at: {uv: [2, 1.5]}, force: [0.02, 0.01, -0.03]}
  - {kind: pressure, value: $p, follower: false}
probes:
  - {name: tip, at: {uv: [2, 1.5]}}
)";
  const auto make = [&](const std::string& theory, bool metres) {
    std::string t = text;
    const std::pair<const char*, const char*> values[] = {
        {"$R", metres ? "0.05" : "50"},
        {"$r", metres ? "0.02" : "20"},
        {"$h", metres ? "0.001" : "1"},
        {"$E", metres ? "2.0e7" : "20"},
        {"$p", metres ? "100" : "1.0e-4"},
    };
    for (const auto& v : values) t = Replace(t, v.first, v.second);
    return SceneFromText(Replace(t, "$T", theory));
  };
  for (const std::string theory : {"linear", "nonlinear"}) {
    const Solution mm = SolveScene(make(theory, false));
    const Solution m = SolveScene(make(theory, true));
    EXPECT_LE((1e3 * m.Probe() - mm.Probe()).norm(), 1e-9 * mm.Probe().norm()) << theory;
    EXPECT_NEAR(1e3 * m.summary.energy_total,
                mm.summary.energy_total,
                1e-9 * std::abs(mm.summary.energy_total))
        << theory;
  }
}

TEST(ShellSolverTest, ThinCylinderDoesNotDependOnTheUnitOfLengthEither) {
  std::string metres = Replace(kCylinder, "radius: 300, u: [0, 300]", "radius: 0.3, u: [0, 0.3]");
  metres = Replace(
      metres, "thickness: 3, young_modulus: 3.0e6", "thickness: 0.003, young_modulus: 3.0e12");
  metres = Replace(metres, "uv: [300, 0]}, force", "uv: [0.3, 0]}, force");
  metres = Replace(metres, "uv: [300, 0]}}", "uv: [0.3, 0]}}");
  for (const int n : {8, 16, 32}) {
    Scene mm = SceneFromText(kCylinder), m = SceneFromText(metres);
    mm.surface.divisions = m.surface.divisions = {n, n};
    const Eigen::Vector3d in_mm = SolveScene(mm).Probe();
    EXPECT_LE((1e3 * SolveScene(m).Probe() - in_mm).norm(), 1e-9 * in_mm.norm()) << n;
  }
}

TEST(ShellSolverTest, NonlinearTheoryTendsToTheLinearOne) {
  // Half the load, half the relative difference.
  const auto difference = [](double force) {
    Scene scene = SceneFromText(Replace(
        kCylinder, "force: [0, 0, -0.25]", "force: [0, 0, -" + std::to_string(force) + "]"));
    const Eigen::Vector3d linear = SolveScene(scene).Probe();
    scene.model.theory = Theory::kNonlinear;
    SolverOptions options;
    options.gradient_tolerance = 1e-8;
    return (SolveScene(scene, options).Probe() - linear).norm() / linear.norm();
  };
  const double coarse = difference(400.0), fine = difference(200.0);
  EXPECT_GT(coarse, 1e-4);
  EXPECT_NEAR(coarse / fine, 2.0, 0.1);
}

TEST(ShellSolverTest, AutoTheoryFollowsTheLoad) {
  const auto run = [](double load) {
    Scene scene =
        SceneFromText(Replace(kPlate, "value: 1}", "value: " + std::to_string(load) + "}"));
    scene.model.theory = Theory::kAuto;
    return SolveScene(scene);
  };
  const Solution small = run(0.1);
  EXPECT_EQ(small.summary.theory, Theory::kLinear);
  EXPECT_THAT(small.summary.theory_reason, HasSubstr("within"));
  const Solution large = run(10.0);
  EXPECT_EQ(large.summary.theory, Theory::kNonlinear);
  EXPECT_THAT(large.summary.theory_reason, HasSubstr("above"));
  EXPECT_GT(large.summary.nonlinearity_estimate, 0.1);
}

TEST(ShellSolverTest, StepsAreReportedAndEndAtFullLoad) {
  Scene scene = SceneFromText(Replace(kPlate, "value: 1}", "value: 10}"));
  scene.model.theory = Theory::kNonlinear;
  const Solution once = SolveScene(scene);
  scene.steps = 4;
  int reported = 0;
  SolverOptions options;
  options.on_step = [&](const StepReport& report) {
    EXPECT_EQ(report.step, ++reported);
    EXPECT_NEAR(report.load_factor, 0.25 * reported, 1e-15);
  };
  const Solution stepped = SolveScene(scene, options);
  EXPECT_EQ(reported, 4);
  EXPECT_NEAR(once.Probe().z(), stepped.Probe().z(), 1e-6 * once.Probe().z());
  // The plate stiffens.
  EXPECT_GT(stepped.summary.steps[0].max_displacement, 0.3 * once.summary.max_displacement);
}

TEST(ShellSolverTest, FreeMotionThatLoadsDriveIsNamed) {
  const char* const kNoSupports = R"(
name: loose
surface: {kind: cylinder, radius: 1, u: [0, 2], v: [0, pi], divisions: [4, 4]}
shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: u_min, fix: [y, z]}
loads:
  - {kind: point, at: {uv: [2, 1]}, force: [1, 0, 0]}
)";
  const std::string error = RefusalOf(SceneFromText(kNoSupports));
  EXPECT_THAT(error, HasSubstr("translation along x"));
  EXPECT_THAT(error, HasSubstr("test.yaml"));
}

TEST(ShellSolverTest, SelfEquilibratedLoadsNeedNoSupport) {
  // A free plate squeezed by opposite edge forces: uniform stress, no reaction.
  const Solution solution = SolveScene(SceneFromText(R"(
name: free
surface: {kind: plane, u: [0, 10], v: [0, 4], divisions: [6, 4]}
shell: {thickness: 0.1, young_modulus: 2.0e5, poisson_ratio: 0.25}
model: {theory: linear, quadrature: 6}
loads:
  - {kind: edge, on: u_max, force: [30, 0, 0]}
  - {kind: edge, on: u_min, force: [-30, 0, 0]}
probes:
  - {name: left, at: {uv: [0, 2]}}
  - {name: right, at: {uv: [10, 2]}}
)"));
  EXPECT_EQ(solution.summary.free_motions.size(), 3u);  // of the plane: bending is off
  const double stretch = solution.Probe(1).x() - solution.Probe(0).x();
  EXPECT_NEAR(stretch, 30.0 / (2.0e5 * 0.1) * 10.0, 1e-10);
  EXPECT_LE(solution.summary.reaction.norm(), 1e-8 * 30.0);
}

TEST(ShellSolverTest, ClosedTorusUnderPressureFloats) {
  Scene scene = SceneFromText(R"(
name: tube
surface:
  kind: torus
  radii: [3, 1]
  u: [0, 2*pi]
  v: [0, 2*pi]
  divisions: [16, 12]
  periodic: [true, true]
shell: {thickness: 0.02, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear}
loads:
  - {kind: pressure, value: 10}
probes:
  - {name: outer, at: {uv: [0, 0]}}
  - {name: opposite, at: {uv: [pi, 0]}}
)");
  const Solution solution = SolveScene(scene);
  EXPECT_EQ(solution.summary.free_motions.size(), 6u);
  EXPECT_LE(solution.summary.reaction.norm(), 1e-4 * 10.0 * 4.0 * M_PI * M_PI * 3.0);
  // Symmetric: the distance across grows, whatever rigid motion is left.
  EXPECT_GT((solution.Probe(0) - solution.Probe(1)).x(), 0.0);
  scene.model.theory = Theory::kNonlinear;
  const Solution nonlinear = SolveScene(scene);
  EXPECT_GT((nonlinear.Probe(0) - nonlinear.Probe(1)).x(), 0.0);
}

TEST(ShellSolverTest, InflatedSphereIsExact) {
  // Uniform stretch 1.2 of a sphere (Koiter, St. Venant-Kirchhoff) needs this follower pressure.
  Scene scene = SceneFromText(R"(
name: inflated
surface: {kind: sphere, radius: 31.25, u: [0, pi/2], v: [0, 1], divisions: [12, 12]}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
model: {theory: nonlinear}
supports:
  - {on: u_min, symmetry: y}
  - {on: u_max, symmetry: x}
  - {on: v_min, symmetry: z}
  - {on: v_max, clamped: true, displacement: ["0.2*x", "0.2*y", "0.2*z"]}
loads:
  - {kind: pressure, value: 0.05869037037037036}
probes:
  - {name: inside, at: {uv: [0.7, 0.5]}}
)");
  const auto error = [&](int divisions) {
    scene.surface.divisions = {divisions, divisions};
    const Solution solution = SolveScene(scene);
    const Eigen::Vector3d expected = 0.2 * solution.summary.probes[0].position;
    return (solution.Probe() - expected).norm() / expected.norm();
  };
  const double coarse = error(12), fine = error(24);
  EXPECT_LE(fine, 1e-6);
  EXPECT_LE(fine, coarse / 12.0);  // What is left is the fourth order of the basis.
}

TEST(ShellSolverTest, InflatedFreeTubeIsExact) {
  // Hoop stretch 1.2 of a cylinder of fixed length; free to float in its plane.
  const Solution solution = SolveScene(SceneFromText(R"(
name: tube
surface: {kind: cylinder, radius: 31.25, u: [0, 20], v: [0, 2*pi], divisions: [6, 24],
          periodic: [false, true]}
shell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}
model: {theory: nonlinear}
supports:
  - {on: u_min, symmetry: x}
  - {on: u_max, symmetry: x}
loads:
  - {kind: pressure, value: 0.023476148148148145}
probes:
  - {name: top, at: {uv: [10, 0]}}
  - {name: bottom, at: {uv: [10, pi]}}
)"));
  EXPECT_EQ(solution.summary.free_motions.size(), 3u);
  EXPECT_NEAR(solution.Probe(0).z() - solution.Probe(1).z(), 0.4 * 31.25, 1e-3);
}

TEST(ShellSolverTest, FollowerPressureOnAFreeEdgeIsTheExactForce) {
  // A cantilever strip under follower pressure: no potential exists at the free edges, yet the
  // equilibrium must be the exact one. Pressure along the strip's normal turns with it, so the
  // resultant has a component along -x that a dead load lacks.
  const auto run = [](const std::string& follower) {
    return SolveScene(SceneFromText(R"(
name: flag
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [20, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: pressure, value: 0.2, follower: )" +
                                    follower + R"(}
probes:
  - {name: tip, at: {uv: [10, 0.5]}}
)"));
  };
  const Solution follower = run("true"), dead = run("false");
  EXPECT_LT(follower.summary.applied_force.x(), -0.1);
  EXPECT_NEAR(dead.summary.applied_force.x(), 0.0, 1e-9);
  EXPECT_LE(follower.summary.force_balance, 1e-6);
  EXPECT_LE(follower.summary.gradient_norm, 1e-7);
}

// A strip of length 10, clamped at u_min, under a load on its other end.
Solution SolveCantilever(const std::string& end_load) {
  return SolveScene(SceneFromText(R"(
name: cantilever
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [32, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, )" + end_load +
                                  R"(}
probes:
  - {name: tip, at: {uv: [10, 0.5]}}
)"));
}

TEST(ShellSolverTest, CantileverEndShearMatchesTheElastica) {
  const Solution solution = SolveCantilever("force: [0, 0, 4]");
  EXPECT_NEAR(solution.Probe().x(), -3.2895436156030384, 1e-4);
  EXPECT_NEAR(solution.Probe().z(), 6.699888944063296, 1e-4);
}

TEST(ShellSolverTest, CantileverEndMomentBendsToAQuarterCircle) {
  const Solution solution = SolveCantilever("moment: [0, -15.707963267948966, 0]");
  EXPECT_NEAR(solution.Probe().x(), -3.6341950169553368, 1e-5);
  EXPECT_NEAR(solution.Probe().z(), 6.366216255215995, 1e-5);
}

TEST(ShellSolverTest, PrescribedDisplacementAlone) {
  // A clamped-clamped strip sheared by one unit transversely: w = L^3 Q / (12 EI), nu = 0.
  const Solution solution = SolveScene(SceneFromText(R"(
name: guided
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [12, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: linear}
supports:
  - {on: u_min, clamped: true}
  - {on: u_max, clamped: true, displacement: [0, 0, 0.01]}
probes:
  - {name: middle, at: {uv: [5, 0.5]}}
)"));
  EXPECT_NEAR(solution.Probe().z(), 0.005, 1e-8);
  // Energy of the strip: 6 E I w^2 / L^3, I = h^3 / 12.
  const double expected = 6.0 * 1.2e6 * 1e-3 / 12.0 * 1e-4 / 1e3;
  EXPECT_NEAR(EffectNamed(solution.summary, "bending").energy, expected, 1e-4 * expected);
}

TEST(ShellSolverTest, MirrorPlanesOfAnyNormalReplaceTheOtherHalf) {
  // A barrel vault in a skew position, whole and cut in half at its crown.
  const auto run = [](const std::string& range, int divisions, const std::string& side) {
    return SolveScene(SceneFromText(R"yaml(
name: vault
surface:
  kind: expression
  position:   # x = sin v along (0.8, 0.6, 0), y = u along (0, 0, 1), height cos v
    - "0.8*sin(v) - 0.6*cos(v)"
    - "0.6*sin(v) + 0.8*cos(v)"
    - "u"
  u: [0, 2]
  v: )yaml" + range + R"yaml(
  divisions: [10, )yaml" + std::to_string(divisions) +
                                    R"yaml(]
shell: {thickness: 0.02, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
  - {on: u_max, fix: [z]}
  )yaml" + side + R"yaml(
loads:
  - {kind: traction, force: [0.6, -0.8, 0]}   # down
probes:
  - {name: crown, at: {uv: [1, 0]}}
)yaml"));
  };
  const Solution whole = run("[-0.6, 0.6]", 12, "");
  const Solution half = run("[0, 0.6]", 6, "- {on: v_min, symmetry: [0.8, 0.6, 0]}");
  EXPECT_GT(whole.Probe().norm(), 1e-3);
  EXPECT_LE((whole.Probe() - half.Probe()).norm(), 2e-3 * whole.Probe().norm());
  EXPECT_NEAR(2.0 * half.summary.energy_total,
              whole.summary.energy_total,
              2e-3 * std::abs(whole.summary.energy_total));
}

TEST(ShellSolverTest, SideThatIsNoMirrorPlaneIsRefused) {
  const std::string error =
      RefusalOf(SceneFromText(Replace(kCylinder, "symmetry: y", "symmetry: [0, 1, 1]")));
  EXPECT_THAT(error, HasSubstr("test.yaml:9: supports[2]"));
  EXPECT_THAT(error, HasSubstr("mirror symmetry"));
}

TEST(ShellSolverTest, PrescribedDisplacementConvergesInSteps) {
  // No load sets a force scale here, only reactions that are still to be found.
  Scene scene = SceneFromText(R"(
name: lifted
surface: {kind: plane, u: [0, 1], v: [0, 0.25], divisions: [8, 2]}
shell: {thickness: 0.002, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
  - {on: u_max, fix: [z], displacement: [0, 0, 0.1]}
probes:
  - {name: tip, at: {uv: [1, 0.125]}}
)");
  const Solution once = SolveScene(scene);
  scene.steps = 5;
  const Solution stepped = SolveScene(scene);
  ASSERT_EQ(stepped.summary.steps.size(), 5u);
  EXPECT_NEAR(stepped.summary.steps[1].probe_displacements[0].z(), 0.04, 1e-6);
  EXPECT_LE((once.Probe() - stepped.Probe()).norm(), 1e-5 * once.Probe().norm());
}

TEST(ShellSolverTest, TinyUnitsOfForceChangeNothing) {
  // Absolute constants within the solver must not show: modulus and loads scaled by 1e-18.
  const auto run = [](const std::string& theory, bool tiny) {
    std::string text = Replace(kCylinder, "theory: linear", "theory: " + theory);
    if (tiny) {
      text = Replace(text, "young_modulus: 3.0e6", "young_modulus: 3.0e-12");
      text = Replace(text, "-0.25]", "-0.25e-18]");
    }
    return SolveScene(SceneFromText(text));
  };
  for (const std::string theory : {"linear", "nonlinear"}) {
    const Solution plain = run(theory, false), tiny = run(theory, true);
    EXPECT_LE((tiny.Probe() - plain.Probe()).norm(), 1e-9 * plain.Probe().norm()) << theory;
    EXPECT_GT(tiny.summary.gradient_norm, 0.0);
    EXPECT_NEAR(tiny.summary.energy_total / plain.summary.energy_total, 1e-18, 1e-27) << theory;
  }
}

TEST(ShellSolverTest, SupportsThatContradictAreNamed) {
  const Scene scene = SceneFromText(Replace(
      kPlate, "loads:", "  - {on: u_min, clamped: true, displacement: [0, 0, 0.1]}\nloads:"));
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  ASSERT_TRUE(Solve(scene, SolverOptions(), &problem, &summary, &error)) << error;
  EXPECT_FALSE(summary.IsConverged());
  EXPECT_THAT(summary.message, HasSubstr("contradicts"));
  EXPECT_THAT(summary.message, HasSubstr("test.yaml:"));
}

TEST(ShellSolverTest, SeedRingsAndSpringsTogetherBalanceTheLoads) {
  Scene scene = SceneFromText(R"(
name: patch
surface: {kind: cylinder, radius: 1, u: [0, 1], v: [0, 1], divisions: [8, 8]}
shell: {thickness: 0.02, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear, boundary_rule: seed_ghosts}
supports:
  - {on: u_min, clamped: true}
  - {on: {near: [0.2, 0, 1], radius: 0.3}, fix: [z]}
loads:
  - {kind: point, at: {uv: [1, 1]}, force: [0.1, 0.2, -0.3]}
  - {kind: pressure, value: 5}
)");
  EXPECT_LE(SolveScene(scene).summary.force_balance, 1e-8);
  scene.model.theory = Theory::kNonlinear;
  EXPECT_LE(SolveScene(scene).summary.force_balance, 1e-6);
}

TEST(ShellSolverTest, SmallNeighbourhoodHoldsLikeAnArea) {
  // A disc held at a spot smaller than a cell cannot turn about it.
  const auto tip = [](const std::string& radius) {
    return SolveScene(SceneFromText(R"(
name: spot
surface: {kind: plane, u: [-1, 1], v: [-1, 1], divisions: [8, 8]}
shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}
model: {theory: linear}
supports:
  - {on: {near: [0, 0, 0], radius: )" +
                                    radius + R"(}, fix: [x, y, z]}
loads:
  - {kind: point, at: {uv: [1, 1]}, force: [0, 0, 1.0e-4]}
probes:
  - {name: tip, at: {uv: [1, 1]}}
)"))
        .Probe()
        .z();
  };
  EXPECT_GT(tip("0.05"), tip("0.2"));
  EXPECT_GT(tip("0.2"), tip("0.6"));
}

TEST(ShellSolverTest, SceneBeyondTheMemoryIsRefused) {
  Scene scene = SceneFromText(kPlate);
  scene.surface.divisions = {300000, 300000};
  const std::string error = RefusalOf(scene);
  EXPECT_THAT(error, HasSubstr("surface.divisions"));
  EXPECT_THAT(error, HasSubstr("GiB"));
}

TEST(ShellSolverTest, FailedStepLeavesTheLastGoodState) {
  // So few iterations that only a small part of the load is reached, and no larger step from there.
  Scene scene = SceneFromText(R"(
name: strip
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [16, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear, minimizer: mip}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, force: [0, 0, 4]}
)");
  SolverOptions options;
  options.max_iterations = 1;
  options.gradient_tolerance = 1e-2;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  ASSERT_TRUE(Solve(scene, options, &problem, &summary, &error)) << error;
  EXPECT_FALSE(summary.IsConverged());
  EXPECT_THAT(summary.message, HasSubstr("last good state"));
  EXPECT_LE(summary.gradient_norm, 1e-2);
  EXPECT_GT(summary.steps.back().factor, 0.0);
  EXPECT_LT(summary.steps.back().factor, 1.0);
}

// A strip held flat whose length goes from 1 to 1 - d has the Green strain ((1 - d)^2 - 1) / 2
// everywhere (six points per triangle: exact up to the free edge).
Solution PressedStrip(double d) {
  return SolveScene(SceneFromText(R"(
name: pressed
surface: {kind: plane, u: [0, 2], v: [0, 1], divisions: [6, 3]}
shell: {thickness: 1, young_modulus: 1000, poisson_ratio: 0}
model: {theory: nonlinear, quadrature: 6}
supports:
  - {on: u_min, fix: [x]}
  - {on: u_max, fix: [x], displacement: [)" +
                                  std::to_string(-2.0 * d) + R"(, 0, 0]}
  - {on: v_min, fix: [y]}
  - {on: {near: [1, 0.5, 0], radius: 2}, fix: [z]}
steps: 4
)"));
}

std::vector<std::string> CrushedLines(const Solution& solution) {
  std::vector<std::string> lines;
  for (const std::string& line : solution.summary.decisions) {
    if (line.find("crushed") != std::string::npos) lines.push_back(line);
  }
  return lines;
}

TEST(ShellSolverTest, CrushedMaterialIsSaid) {
  const Solution crushed = PressedStrip(0.39);
  EXPECT_NEAR(crushed.summary.max_membrane_strain, 0.31395, 1e-5);
  ASSERT_EQ(CrushedLines(crushed).size(), 1u);
  EXPECT_THAT(CrushedLines(crushed)[0], HasSubstr("membrane strain -0.31395 at ("));
  EXPECT_THAT(CrushedLines(crushed)[0], HasSubstr("spread a force"));
  const Solution pressed = PressedStrip(0.35);
  EXPECT_NEAR(pressed.summary.max_membrane_strain, 0.28875, 1e-5);
  EXPECT_TRUE(CrushedLines(pressed).empty());
  const Solution stretched = PressedStrip(-1.0);
  EXPECT_NEAR(stretched.summary.max_membrane_strain, 1.5, 1e-5);
  EXPECT_TRUE(CrushedLines(stretched).empty());
  for (const char* scene : {"nonlinear_plate_p1000.yaml", "cantilever_moment.yaml"}) {
    EXPECT_TRUE(CrushedLines(SolveScene(SceneFromData(scene))).empty()) << scene;
  }
}

TEST(ShellSolverTest, MinimisersAgree) {
  Scene scene = SceneFromText(R"(
name: strip
surface: {kind: plane, u: [0, 10], v: [0, 1], divisions: [16, 2]}
shell: {thickness: 0.1, young_modulus: 1.2e6, poisson_ratio: 0}
model: {theory: nonlinear}
supports:
  - {on: u_min, clamped: true}
loads:
  - {kind: edge, on: u_max, force: [0, 0, 1]}
probes:
  - {name: tip, at: {uv: [10, 0.5]}}
)");
  scene.model.minimizer = Minimizer::kCeres;
  const Solution descent = SolveScene(scene);
  scene.model.minimizer = Minimizer::kMip;
  const Solution mixed = SolveScene(scene);
  EXPECT_LE((descent.Probe() - mixed.Probe()).norm(), 1e-6 * mixed.Probe().norm());
  EXPECT_NEAR(descent.summary.energy_total,
              mixed.summary.energy_total,
              1e-9 * std::abs(mixed.summary.energy_total));
  EXPECT_LT(mixed.summary.iterations, descent.summary.iterations / 3);
}

TEST(ShellSolverTest, StopFlagKeepsAFiniteState) {
  Scene scene = SceneFromText(Replace(kPlate, "value: 1}", "value: 10}"));
  scene.model.theory = Theory::kNonlinear;
  std::atomic<bool> stop{true};
  SolverOptions options;
  options.stop = &stop;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::string error;
  ASSERT_TRUE(Solve(scene, options, &problem, &summary, &error)) << error;
  EXPECT_EQ(summary.termination, SolverSummary::Termination::kStopped);
  EXPECT_TRUE(summary.IsSolutionUsable());
  EXPECT_TRUE(problem->displacements().allFinite());
}

TEST(ShellSolverTest, InvalidOptionsAreNamed) {
  SolverOptions options;
  options.num_threads = 0;
  std::string error;
  EXPECT_FALSE(options.IsValid(&error));
  EXPECT_THAT(error, HasSubstr("num_threads"));
}

TEST(ShellSolverTest, SummaryStartsAsNotRun) {
  const SolverSummary summary;
  EXPECT_EQ(summary.termination, SolverSummary::Termination::kNotRun);
  EXPECT_FALSE(summary.IsSolutionUsable());
  EXPECT_EQ(summary.dof, -1);
}

}  // namespace
}  // namespace darboux
