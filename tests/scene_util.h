#ifndef DARBOUX_TESTS_SCENE_UTIL_H_
#define DARBOUX_TESTS_SCENE_UTIL_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "geometry/shell_surface.h"
#include "solver/rigid_motion.h"
#include "solver/scene.h"

// Parts of scenes and the shells on which they are tested, without a scene file.

namespace darboux {

inline SceneValue Value(const std::string& text) {
  std::string error;
  const auto expression = Expression::Parse(text, {"u", "v", "x", "y", "z"}, &error);
  EXPECT_TRUE(expression.has_value()) << error;
  return {expression.value_or(Expression::Constant(0.0))};
}

inline SceneVector Vector(const std::string& x, const std::string& y, const std::string& z) {
  return {{Value(x), Value(y), Value(z)}};
}

inline ParameterDomain::Options Domain(std::array<double, 2> u,
                                       std::array<double, 2> v,
                                       std::array<int, 2> divisions,
                                       std::array<double, 2> grading = {0.0, 0.0}) {
  ParameterDomain::Options options;
  options.u_range = u;
  options.v_range = v;
  options.divisions = divisions;
  options.grading = grading;
  return options;
}

// [0, 3] x [0, 2].
inline std::unique_ptr<ShellSurface> MakePlate(
    std::array<int, 2> divisions,
    ShellSurface::Ghosts ghosts = ShellSurface::Ghosts::kIndependent) {
  return std::make_unique<ShellSurface>(
      MakePlane(), Domain({0.0, 3.0}, {0.0, 2.0}, divisions), ghosts);
}

// x in [0, 2], a quarter of the circle of radius 0.7 from the z axis to the y axis.
inline std::unique_ptr<ShellSurface> MakeQuarterCylinder(std::array<int, 2> divisions,
                                                         std::array<double, 2> grading = {0.0,
                                                                                          0.0}) {
  return std::make_unique<ShellSurface>(MakeCylinder(0.7),
                                        Domain({0.0, 2.0}, {0.0, 0.5 * M_PI}, divisions, grading));
}

// Not at any symmetric place.
inline RigidFrame Frame() {
  RigidFrame frame;
  frame.center = Eigen::Vector3d(0.3, -0.4, 0.5);
  frame.length = 2.5;
  return frame;
}

// Control values of a function that is at most quadratic in the plate's coordinates; the limit
// field has its exact gradient (tests/loop_basis_test.cc).
template <typename Function>
Eigen::Matrix3Xd PlateField(const ShellSurface& plate, const Function& f) {
  Eigen::Matrix3Xd control = Eigen::Matrix3Xd::Zero(3, plate.mesh().num_vertices);
  const auto& options = plate.domain().options();
  for (int j = -1; j <= options.divisions[1] + 1; ++j) {
    for (int i = -1; i <= options.divisions[0] + 1; ++i) {
      const int vertex = plate.domain().VertexIndex(i, j);
      if (vertex < 0) continue;
      control.col(vertex) = f(plate.domain().Parameter(0, i)[0], plate.domain().Parameter(1, j)[0]);
    }
  }
  return control;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_SCENE_UTIL_H_
