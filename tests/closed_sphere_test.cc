// A closed sphere on a Loop icosphere, twelve extraordinary vertices, nothing held: linear Koiter
// shells against closed forms (R = 31.25, h = 2.5, E = 1, nu = 0.5: a tennis ball).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "tests/solve_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

constexpr double kRadius = 31.25;

Scene Ball(int frequency, const std::string& load) {
  Scene scene =
      SceneFromText("name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: " +
                    std::to_string(frequency) +
                    "}\nshell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5}\n"
                    "model: {theory: linear}\nloads:\n  - {kind: normal_traction, value: \"" +
                    load + "\"}\n");
  return scene;
}

struct Errors {
  double all = 0.0, regular = 0.0, irregular = 0.0;  // relative L2, of the whole displacement
};

// Displacement at a point of the unit sphere.
using Field = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

Errors ErrorsOf(const Solution& solution, const Field& exact) {
  const ShellSurface& surface = solution.problem->surface();
  double error[2] = {}, size = 0.0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto& vertices = surface.control_vertices(e);
    for (const StrainPoint& point : *solution.problem->strain_points()[e]) {
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        u += point.weights(kRowValue, i) * solution.problem->displacements().col(vertices[i]);
      }
      const Eigen::Vector3d expected = exact(point.position.normalized());
      error[surface.basis().IsRegular(e) ? 0 : 1] += point.area * (u - expected).squaredNorm();
      size += point.area * expected.squaredNorm();
    }
  }
  return {std::sqrt((error[0] + error[1]) / size),
          std::sqrt(error[0] / size),
          std::sqrt(error[1] / size)};
}

struct Load {
  const char* name;
  const char* value;
  Field exact;
};

const Load& UniformPressure() {
  static const Load& load = *new Load{"uniform", "1", [](const Eigen::Vector3d& n) {
                                        return Eigen::Vector3d(97.60419442963753 * n);
                                      }};
  return load;
}

// P_2(cos phi), phi from the z axis: w = W P_2, u = U dP_2 / dphi along the meridian.
const Load& SecondHarmonic() {
  static const Load& load = *new Load{
      "P2", "1.5*z^2/(x^2+y^2+z^2) - 0.5", [](const Eigen::Vector3d& n) {
        const double c = n.z(), s = std::hypot(n.x(), n.y());
        const Eigen::Vector3d along = s > 0.0 ? Eigen::Vector3d(n.x() * c / s, n.y() * c / s, -s)
                                              : Eigen::Vector3d::Zero().eval();
        return Eigen::Vector3d(527.8385928709912 * (1.5 * c * c - 0.5) * n -
                               144.364582974489 * 3.0 * c * s * along);
      }};
  return load;
}

class ClosedSphereTest : public ::testing::TestWithParam<const Load*> {};

TEST_P(ClosedSphereTest, ConvergesToTheClosedForm) {
  const Load& load = *GetParam();
  Errors errors[2];
  for (const int level : {0, 1}) {
    const int frequency = level == 0 ? 8 : 16;
    const Solution solution = SolveScene(Ball(frequency, load.value));
    errors[level] = ErrorsOf(solution, load.exact);
    std::printf("  %-8s %6d dof: L2 error %.2e (regular elements %.2e, irregular %.2e)\n",
                load.name,
                solution.summary.dof,
                errors[level].all,
                errors[level].regular,
                errors[level].irregular);
  }
  EXPECT_LE(errors[0].all, 3e-4);
  EXPECT_LE(errors[1].all, 5e-5);
  // From 1,926 to 7,686 dof, at least h^3.4.
  EXPECT_LE(errors[1].all, errors[0].all / std::pow(2.0, 2.0 * 1.7));
}

INSTANTIATE_TEST_SUITE_P(Loads,
                         ClosedSphereTest,
                         ::testing::Values(&UniformPressure(), &SecondHarmonic()),
                         [](const auto& info) { return std::string(info.param->name); });

// Nothing is pinned: where the loads balance the ball stays where it is on the average, and nothing
// bears on it.
TEST_P(ClosedSphereTest, DoesNotDrift) {
  const Solution solution = SolveScene(Ball(8, GetParam()->value));
  const ShellSurface& surface = solution.problem->surface();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto& vertices = surface.control_vertices(e);
    for (const StrainPoint& point : *solution.problem->strain_points()[e]) {
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        u += point.weights(kRowValue, i) * solution.problem->displacements().col(vertices[i]);
      }
      area += point.area;
      mean += point.area * u;
      turn += point.area * point.position.cross(u) / kRadius;
    }
  }
  const double largest = solution.summary.max_displacement;
  EXPECT_GT(largest, 90.0);
  EXPECT_LT(mean.norm() / area, 1e-10 * largest);
  EXPECT_LT(turn.norm() / area, 1e-10 * largest);
  EXPECT_EQ(solution.summary.free_motions.size(), 6u);
  // Against the load on one side of the ball, in N.
  EXPECT_LT(solution.summary.reaction.norm(), 1e-10 * M_PI * kRadius * kRadius);
}

// Isoparametric: any rigid motion of a deformed ball is in the space, finite ones as well.
TEST(ClosedSphereEnergyTest, IsInvariantUnderFiniteRigidMotions) {
  Scene scene = Ball(4, "1");
  scene.model.theory = Theory::kNonlinear;
  ShellProblem::Options options;
  options.nonlinear = true;
  std::string error;
  const auto problem = ShellProblem::Create(scene, options, &error);
  ASSERT_NE(problem, nullptr) << error;
  ASSERT_EQ(problem->measure(), StrainMeasure::kKoiter);
  const Eigen::Matrix3Xd& x = problem->surface().control_points();
  // Strains of some percent.
  Eigen::Matrix3Xd u(3, x.cols());
  for (int i = 0; i < x.cols(); ++i) {
    const Eigen::Vector3d n = x.col(i).normalized();
    u.col(i) = 0.05 * kRadius *
               Eigen::Vector3d(std::sin(2.0 * n.y()), n.x() * n.z(), n.z() + std::cos(3.0 * n.x()));
  }
  const auto energy = [&problem](Effect effect, const Eigen::Matrix3Xd& displacements) {
    problem->displacements() = displacements;
    return problem->Energy(effect);
  };
  const Eigen::Vector3d far(3.0 * kRadius, -kRadius, 2.0 * kRadius);
  for (const Effect effect : {Effect::kMembrane, Effect::kBending}) {
    const double expected = energy(effect, u);
    ASSERT_GT(expected, 0.0);
    for (const double angle : {0.3, 2.5}) {
      const Eigen::Matrix3Xd moved = (SkewRotation(angle) * (x + u)).colwise() + far;
      EXPECT_NEAR(energy(effect, moved - x), expected, 1e-12 * expected)
          << ToString(effect) << ", " << angle << " rad";
      // Of the undeformed ball: nothing at all.
      const Eigen::Matrix3Xd rigid = (SkewRotation(angle) * x).colwise() + far;
      EXPECT_LT(energy(effect, rigid - x), 1e-20 * expected)
          << ToString(effect) << ", " << angle << " rad";
    }
  }
}

// Pressure on two smooth caps about the poles (Legendre series, 12 digits).
TEST(ClosedSphereTest, SmoothCapsHaveTheirDisplacementsAndEnergy) {
  Scene scene = Ball(16, "exp(-(1-z/sqrt(x^2+y^2+z^2))/0.02) + exp(-(1+z/sqrt(x^2+y^2+z^2))/0.02)");
  for (const bool pole : {true, false}) {
    ProbeSpec probe;
    probe.name = pole ? "pole" : "equator";
    probe.at.kind = SurfacePoint::Kind::kNearest;
    probe.at.nearest = {pole ? 0.0 : kRadius, 0.0, pole ? kRadius : 0.0};
    scene.probes.push_back(probe);
  }
  const Solution solution = SolveScene(scene);
  EXPECT_NEAR(solution.Probe(0).z(), 156.46887968730104, 5e-5 * 156.5);
  EXPECT_NEAR(solution.Probe(1).x(), -11.266720491729256, 5e-5 * 11.3);
  EXPECT_NEAR(-solution.summary.energy_total, 14638.31836945704, 5e-5 * 14638.0);
}

}  // namespace
}  // namespace darboux
