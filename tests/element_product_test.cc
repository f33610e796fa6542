#include "solver/element_product.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "solver/tangent_stiffness.h"
#include "tests/solve_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

// Control vertices of regular elements, of fewer and of more than fill whole lanes; points.
class ElementProductTest : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(ElementProductTest, IsTheSumOverPoints) {
  const auto [n, num_points] = GetParam();
  ElementProduct product;
  // What an element before has left must not matter.
  product.Begin(17, 12);
  for (int q = 0; q < 12; ++q) {
    StrainPoint point;
    point.weights = BasisMatrix::Constant(6, 17, 1e3);
    product.SetPoint(q, point, ElementProduct::PointMatrix::Constant(1e3));
  }
  product.Multiply();

  product.Begin(n, num_points);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (int q = 0; q < num_points; ++q) {
    StrainPoint point;
    point.weights = SeededUniform(6 * n, 1.0, 10 * n + q).reshaped(6, n);
    const Eigen::MatrixXd half = SeededUniform(225, 1.0, 1000 * n + q).reshaped(15, 15);
    const ElementProduct::PointMatrix matrix = half + half.transpose();
    product.SetPoint(q, point, matrix);
    Eigen::MatrixXd kinematics = Eigen::MatrixXd::Zero(15, 3 * n);
    for (int i = 0; i < n; ++i) {
      for (int c = 0; c < 5; ++c) {
        kinematics.block<3, 3>(3 * c, 3 * i) =
            point.weights(kRowD1 + c, i) * Eigen::Matrix3d::Identity();
      }
    }
    expected += kinematics.transpose() * matrix * kinematics;
  }
  product.Multiply();
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) {
      const Eigen::Matrix3d error = product.Block(i, j) - expected.block<3, 3>(3 * i, 3 * j);
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-14 * expected.norm()) << i << ' ' << j;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         ElementProductTest,
                         ::testing::Values(std::pair(12, 3),
                                           std::pair(12, 1),
                                           std::pair(12, 12),
                                           std::pair(3, 3),
                                           std::pair(9, 6),
                                           std::pair(15, 4),
                                           std::pair(22, 3)));

// Linear strains have one stiffness, which is made once where contact iterates.
TEST(LinearContactTest, KeepsTheMatrixOfTheShellAndNotThatOfContact) {
  const Scene scene = SceneFromText(
      "name: ball\nsurface: {kind: icosphere, radius: 30, frequency: 3}\n"
      "shell: {thickness: 2, young_modulus: 1, poisson_ratio: 0.4}\n"
      "supports: [{on: {near: [0, 0, 30], radius: 0}, fix: [x, y]}]\n"
      "fingers:\n"
      "  - {name: top, shape: {kind: sphere, radius: 5}, position: [0, 0, 40], direction: [0, 0, "
      "-1],"
      " motion: {travel: 3}}\n"
      "  - {name: bottom, shape: {kind: sphere, radius: 5}, position: [0, 0, -40],"
      " direction: [0, 0, 1], motion: {travel: 3}}\n");
  ShellProblem::Options options;
  options.nonlinear = false;
  std::string error;
  const auto problem = ShellProblem::Create(scene, options, &error);
  ASSERT_NE(problem, nullptr) << error;
  TangentStiffness::Request request;
  request.matrix = true;
  TangentStiffness kept(problem.get(), SparseBackend::kAuto, 1);
  ASSERT_TRUE(kept.Evaluate(request));
  const Eigen::MatrixXd at_rest = kept.matrix();
  // Another state, in contact with more points.
  problem->SetLoadFactor(1.0);
  problem->displacements() = kept.Expand(SeededUniform(kept.num_unknowns(), 0.3, 4));
  ASSERT_TRUE(kept.Evaluate(request));
  TangentStiffness fresh(problem.get(), SparseBackend::kAuto, 1);
  ASSERT_TRUE(fresh.Evaluate(request));
  EXPECT_GT((kept.matrix().toDense() - at_rest).norm(), 1e-3 * at_rest.norm());
  EXPECT_EQ((kept.matrix().toDense() - fresh.matrix().toDense()).norm(), 0.0);
}

}  // namespace
}  // namespace darboux
