// A closed sphere on a Loop icosphere, twelve extraordinary vertices, nothing held: linear Koiter
// shells against closed forms (R = 31.25, h = 2.5, E = 1, nu = 0.5: a tennis ball).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "tests/solve_util.h"

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
}

INSTANTIATE_TEST_SUITE_P(Loads,
                         ClosedSphereTest,
                         ::testing::Values(&UniformPressure(), &SecondHarmonic()),
                         [](const auto& info) { return std::string(info.param->name); });

}  // namespace
}  // namespace darboux
