// Gas with rest: prestressed: the given shape bears the gauge pressure.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include "solver/fields.h"
#include "solver/gas_start.h"
#include "solver/mixed_iteration.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

struct Ball {
  double radius = 31.25, thickness = 2.5, young = 1.0, nu = 0.3;
  int frequency = 6;
  double gauge = 0.02, ambient = 0.101325;
  std::string rest = "prestressed", model = "theory: nonlinear", loads, rest_of_scene;
  // Overrides the icosphere.
  std::string surface;

  Scene Make() const {
    std::ostringstream text;
    text.precision(17);
    text << "name: ball\nsurface: ";
    if (surface.empty()) {
      text << "{kind: icosphere, radius: " << radius << ", frequency: " << frequency << "}\n";
    } else {
      text << surface << "\n";
    }
    text << "shell: {thickness: " << thickness << ", young_modulus: " << young
         << ", poisson_ratio: " << nu << "}\nmodel: {" << model << "}\nloads:\n";
    if (!rest.empty()) {
      text << "  - {kind: gas, gauge_pressure: " << gauge << ", ambient_pressure: " << ambient
           << ", rest: " << rest << "}\n";
    }
    text << loads << "probes:\n  - {name: pole, at: {nearest: [0, 0, " << radius << "]}}\n"
         << rest_of_scene;
    return SceneFromText(text.str());
  }
  // Dead traction amplitude * P_l(z / R) along the normal.
  Ball& Press(int l, double amplitude) {
    std::ostringstream text;
    text.precision(17);
    const std::string c = "(z/" + std::to_string(radius) + ")";
    text << "  - {kind: normal_traction, value: \"" << amplitude << "*("
         << (l == 2 ? "1.5*" + c + "^2-0.5"
                    : "(231*" + c + "^6-315*" + c + "^4+105*" + c + "^2-5)/16")
         << ")\"}\n";
    loads = text.str();
    return *this;
  }
};

// Normal displacement W of u = W P_l n + grad(Psi P_l) that a dead normal traction p P_l causes on
// a sphere of Koiter's theory with the pressure P inside and N = P R / 2 in it. With lambda =
// l(l+1) / R^2 the membrane energy per mean square of P_l is that of strains Psi D_ab P_l + W g_ab
// / R, the bending energy that of D_ab (W - 2 Psi / R) - W g_ab / R^2, and what N and P add, N
// |grad u|^2 / 2 minus P times the second variation of the volume, comes to
//
//   P R / 4 (lambda - 2 / R^2) (W^2 + lambda Psi^2)
//
// which is zero for rigid motions, l = 1. (M_0, (h/R)^2 of it, is left out.)
double Response(const Ball& ball, int l, double pressure, double traction) {
  const double r = ball.radius, h = ball.thickness, nu = ball.nu, lambda = l * (l + 1.0) / (r * r);
  const double membrane = ball.young * h / (1.0 - nu * nu), bending = membrane * h * h / 12.0;
  using Eigen::Matrix2d;
  using Eigen::Vector2d;
  const Vector2d w(1.0, 0.0), psi(0.0, 1.0);
  // Twice the energy of the strains a D_ab P_l + b g_ab P_l, a and b linear in (W, Psi).
  const auto energy = [&](double stiffness, const Vector2d& a, const Vector2d& b) {
    const Matrix2d ab = a * b.transpose();
    const Matrix2d square = (lambda * lambda - lambda / (r * r)) * a * a.transpose() -
                            lambda * (ab + ab.transpose()) + 2.0 * b * b.transpose();
    const Vector2d trace = 2.0 * b - lambda * a;
    return Matrix2d(stiffness * ((1.0 - nu) * square + nu * trace * trace.transpose()));
  };
  Matrix2d k = energy(membrane, psi, w / r) + energy(bending, w - 2.0 / r * psi, -w / (r * r));
  k += pressure * r / 2.0 * (lambda - 2.0 / (r * r)) * Vector2d(1.0, lambda).asDiagonal();
  return k.inverse()(0, 0) * traction;
}

TEST(GasPrestressTest, GivenShapeStaysWithoutOtherLoads) {
  Ball ellipsoid;
  ellipsoid.surface =
      "{kind: implicit, function: \"(x/40)^2 + (y/31.25)^2 + (z/25)^2 - 1\", bounds: [[-45, 45], "
      "[-35, 35], [-30, 30]], edge_length: 9}";
  for (const char* strains : {"koiter", "seed"}) {
    for (const double gauge : {1e-6, 0.02, 0.1, -0.002}) {
      for (const Ball& base : {Ball(), ellipsoid}) {
        Ball ball = base;
        ball.gauge = gauge;
        ball.model = std::string("theory: nonlinear, strains: ") + strains;
        const Solution solution = SolveScene(ball.Make());
        // A sphere stays to the last digit. The pressure on the elements of an ellipsoid is
        // balanced up to its quadrature: what is left moves the body as a whole.
        const double moves = base.surface.empty() ? 1e-12 : 1e-8;
        EXPECT_LE(solution.summary.max_displacement, moves * ball.radius);
        EXPECT_LE(solution.summary.max_membrane_strain, moves);
        EXPECT_LE(std::abs(solution.summary.energy_total),
                  moves * std::abs(gauge) * std::pow(ball.radius, 3));
        EXPECT_LE(solution.summary.gradient_norm, 1e-7);
        EXPECT_NEAR(solution.summary.steps.back().gas->gauge_pressure / gauge, 1.0, 1e-9);
        EXPECT_NEAR(solution.summary.steps.back().gas->volume_ratio, 1.0, 1e-9);
      }
    }
  }
}

TEST(GasPrestressTest, SphereHasTheStressOfABubble) {  // N = P R / 2, both ways
  Ball ball;
  const Solution solution = SolveScene(ball.Make());
  const double expected = 0.5 * ball.gauge * ball.radius;
  for (int e = 0; e < solution.problem->surface().num_elements(); e += 37) {
    const ShellFields fields = EvaluateFields(*solution.problem, ElementPoint{e, 0.3, 0.4});
    EXPECT_NEAR(fields.membrane_force[0], expected, 0.02 * expected);
    EXPECT_NEAR(fields.membrane_force[1], expected, 0.02 * expected);
    EXPECT_NEAR(fields.membrane_force[2], 0.0, 0.02 * expected);
    EXPECT_LE(fields.moment.norm(), 0.02 * expected * ball.thickness);
    EXPECT_EQ(fields.membrane_strain.norm(), 0.0);
  }
}

TEST(GasPrestressTest, TensionStiffensASphereAsTheClosedFormSays) {
  double error[2];
  for (const int fine : {0, 1}) {
    for (const int l : {2, 6}) {
      for (const double gauge : {0.0, 0.02}) {
        Ball ball;
        ball.thickness = 1.0;
        ball.frequency = fine == 0 ? 5 : 10;
        ball.gauge = gauge;
        const double traction = 1e-5;
        SolverOptions options;
        options.gradient_tolerance = 1e-10;
        const Solution solution = SolveScene(ball.Press(l, traction).Make(), options);
        const double expected = Response(ball, l, gauge, traction);
        const double free = Response(ball, l, 0.0, traction);
        error[fine] = std::abs(solution.Probe().z() / expected - 1.0);
        std::printf(
            "  frequency %d, P%d, gauge %g: %.6e, closed form %.6e (%.1e), unstressed %.3e\n",
            ball.frequency,
            l,
            gauge,
            solution.Probe().z(),
            expected,
            error[fine],
            free);
        EXPECT_LE(error[fine], fine == 0 ? 0.03 : 8e-3);
      }
    }
  }
}

TEST(GasPrestressTest, InflatedShapeAgreesInTheLimitOfSmallStrain) {
  // A ball that gas has blown up to the radius, against one that is given so. They differ by the
  // strain, what tension does to P_6 is many times that.
  double difference[2], stiffening[2];
  for (const int k : {0, 1}) {
    Ball given;
    given.frequency = 5;
    given.thickness = 1.0;
    given.gauge = k == 0 ? 1e-4 : 2.5e-5;
    const double strain = given.gauge * given.radius * (1.0 - given.nu) / (2.0 * given.thickness);
    const double traction = 1e-8;
    Ball blown = given;
    blown.rest = "stress_free";
    blown.radius = given.radius / (1.0 + strain);
    // What is in it at rest has the gauge pressure of the other at its volume.
    const double absolute = (given.ambient + given.gauge) * std::pow(1.0 + strain, 3);
    blown.gauge = absolute - given.ambient;
    const Solution before = SolveScene(blown.Make());
    EXPECT_NEAR(before.summary.steps.back().gas->gauge_pressure, given.gauge, 5e-3 * given.gauge);
    const double w = SolveScene(given.Press(6, traction).Make()).Probe().z();
    const double inflated =
        SolveScene(blown.Press(6, traction).Make()).Probe().z() - before.Probe().z();
    given.rest = "";
    const double unstressed = SolveScene(given.Make()).Probe().z();
    stiffening[k] = unstressed / w - 1.0;
    difference[k] = std::abs(inflated / w - 1.0);
    std::printf("  strain %.2e: stiffening %.3e, conventions differ by %.3e\n",
                strain,
                stiffening[k],
                difference[k]);
    EXPECT_GT(stiffening[k], 5.0 * strain);
    EXPECT_LE(difference[k], 0.2 * stiffening[k]);
  }
  EXPECT_NEAR(difference[0] / difference[1], 4.0, 1.0);
}

TEST(GasPrestressTest, ResultsDoNotDependOnTheUnits) {
  Ball mm;
  mm.frequency = 4;
  Ball m = mm;
  m.radius *= 1e-3;
  m.thickness *= 1e-3;
  m.young *= 1e6;
  m.gauge *= 1e6;
  m.ambient *= 1e6;
  const Solution a = SolveScene(mm.Press(2, 0.002).Make());
  const Solution b = SolveScene(m.Press(2, 0.002e6).Make());
  EXPECT_NEAR(1e3 * b.Probe().z() / a.Probe().z(), 1.0, 1e-9);
  EXPECT_NEAR(1e3 * b.summary.energy_total / a.summary.energy_total, 1.0, 1e-9);
  EXPECT_EQ(a.summary.iterations, b.summary.iterations);
}

TEST(GasPrestressTest, TangentIsTheDerivativeOfTheForces) {
  Ball ball;
  ball.frequency = 3;
  ball.model = "theory: nonlinear, quadrature: 12";
  const Scene scene = ball.Make();
  ShellProblem::Options options;
  options.nonlinear = true;
  std::string error;
  Eigen::Matrix3Xd prestress;
  ASSERT_TRUE(FindPrestress(scene, options, SparseBackend::kAuto, &prestress, &error)) << error;
  options.prestress = prestress;
  const std::unique_ptr<ShellProblem> problem = ShellProblem::Create(scene, options, &error);
  ASSERT_NE(problem, nullptr) << error;
  TangentStiffness tangent(problem.get(), SparseBackend::kAuto, 1);
  Eigen::VectorXd direction(tangent.num_unknowns()), u(tangent.num_unknowns());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    u[i] = 0.1 * std::sin(1.7 * i);
    direction[i] = std::cos(2.3 * i);
  }
  problem->displacements() = tangent.Expand(u);
  TangentStiffness::StressField stresses;
  TangentStiffness::Request request;
  request.stresses = &stresses;
  ASSERT_TRUE(tangent.Evaluate(request));
  request.stresses = nullptr;
  request.initial_stresses = &stresses;
  request.matrix = true;
  ASSERT_TRUE(tangent.Evaluate(request));
  Eigen::VectorXd expected = tangent.matrix().selfadjointView<Eigen::Lower>() * direction;
  expected +=
      tangent.update_vectors() *
      (tangent.update_weights().cwiseProduct(tangent.update_vectors().transpose() * direction));
  const double step = 1e-5;
  Eigen::VectorXd gradient[2];
  double energy[2];
  for (const int k : {0, 1}) {
    problem->displacements() = tangent.Expand(u + (k == 0 ? -step : step) * direction);
    TangentStiffness::Request only;
    only.gradient = &gradient[k];
    only.energy = &energy[k];
    ASSERT_TRUE(tangent.Evaluate(only));
    // Ceres' blocks have the same energy, but for the gas's, and the same forces.
    const double blocks = problem->Energy(Effect::kMembrane) + problem->Energy(Effect::kBending) +
                          problem->Energy(Effect::kSupports);
    EXPECT_NEAR(problem->force_unit() * energy[k], blocks, 1e-9 * std::abs(blocks));
  }
  EXPECT_LE(((gradient[1] - gradient[0]) / (2.0 * step) - expected).norm(), 1e-6 * expected.norm());
}

TEST(GasPrestressTest, LinearTheoryKnowsTheStressOnlyAsABalance) {
  Ball ball;
  ball.model = "theory: linear";
  EXPECT_LE(SolveScene(ball.Make()).summary.max_displacement, 1e-12 * ball.radius);
  ball.Press(2, 1e-4);
  const double w = SolveScene(ball.Make()).Probe().z();
  ball.rest = "";
  EXPECT_NEAR(w / SolveScene(ball.Make()).Probe().z(), 1.0, 1e-5);  // P_2 is no change of volume.
}

}  // namespace
}  // namespace darboux
