// The gas as sparse blocks: shares of the elements, their sums, and the spring.
#include "costs/gas_blocks.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

const double kOne = 1.0;

class GasSizeTest : public ::testing::TestWithParam<double> {
 protected:
  GasSizeTest() : patch_(MakeLoopPatch(EllipsoidPatch())) {}
  std::unique_ptr<FollowerPressure> Element(bool linear) const {
    const StrainPoints points = patch_.Points(2, 6);
    return std::make_unique<FollowerPressure>(points,
                                              std::vector<double>(points->size(), 1.7),
                                              Eigen::Vector3d(0.3, -0.2, 0.5),
                                              &kOne,
                                              1e6,
                                              linear);
  }
  const LoopPatch patch_;
};

TEST_P(GasSizeTest, JacobiansMatchRiddersDifferences) {
  const double size = GetParam();
  for (const bool linear : {false, true}) {
    const auto element = Element(linear);
    EXPECT_THAT(element.get(), HasCorrectJacobianAt(SeededUniform(36, size), 1e-6));
    const double reference = 0.01;
    const GasShare share(element.get(), &reference, 3.0, 2.5);
    EXPECT_THAT(&share, HasCorrectJacobianAt(SeededUniform(37, size), 1e-6));
  }
  const GasSum sum(3.0, 2.5);
  EXPECT_THAT(&sum, HasCorrectJacobianAt(SeededUniform(3, size), 1e-6));
  for (const double gamma : {1.0, 1.4}) {
    for (const double share : {size, -size}) {
      if (share < -0.2) continue;  // No volume is left.
      const Gas gas(0.5, 1.0, gamma, 0.7);
      const double change = 0.1;
      const GasSpring spring(&gas, &change, 2.5, 1.3);
      EXPECT_THAT(&spring, HasCorrectJacobianAt(Eigen::VectorXd::Constant(1, share), 1e-6));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lengths, GasSizeTest, ::testing::Values(0, 1e-8, 1e-2, 1, 1e2));

TEST(GasBlocksTest, NothingAtTheStateTheyStartFrom) {
  const Gas gas(0.5, 1.0, 1.4, 0.7);
  const double change = 0.1;
  EXPECT_EQ(Energy(GasSpring(&gas, &change, 2.5, 1.3), Eigen::VectorXd::Zero(1)), 0.0);
  EXPECT_EQ(Energy(GasSum(3.0, 2.5), Eigen::VectorXd::Zero(3)), 0.0);
}

TEST(GasBlocksTest, SpringHasTheEnergyAndFailsWithoutVolume) {
  const Gas gas(0.5, 1.0, 1.4, 0.7);
  const double change = 0.1;
  const GasSpring spring(&gas, &change, 2.5, 1.3);
  for (const double share : {-0.25, 0.3}) {
    EXPECT_NEAR(Energy(spring, Eigen::VectorXd::Constant(1, share)),
                1.3 * gas.Divergence(change, 2.5 * share),
                1e-14);
  }
  const double empty = -0.4;
  const double* parameters[] = {&empty};
  double residual;
  EXPECT_FALSE(spring.Evaluate(parameters, &residual, nullptr));
}

TEST(GasBlocksTest, LinearVolumeIsTheFirstOrderOfTheOther) {
  const LoopPatch patch = MakeLoopPatch(SpherePatch());
  const StrainPoints points = patch.Points(2, 6);
  const std::vector<double> pressure(points->size(), 1.0);
  const Eigen::Vector3d origin(0.3, -0.2, 0.5);
  const FollowerPressure linear(points, pressure, origin, &kOne, 1.0, true);
  const FollowerPressure whole(points, pressure, origin, &kOne, 1.0, false);
  const auto force = [](const FollowerPressure& cost, const Eigen::VectorXd& x) {
    std::vector<const double*> blocks;
    for (int i = 0; 3 * i < x.size(); ++i) blocks.push_back(x.data() + 3 * i);
    return cost.ExactForce(blocks.data());
  };
  const Eigen::VectorXd x = SeededUniform(36, 1.0), zero = Eigen::VectorXd::Zero(36);
  EXPECT_EQ(force(linear, x), force(whole, zero));
  // Its potential has that force.
  const Eigen::Matrix3Xd expected = force(linear, zero);
  const Eigen::VectorXd gradient = Gradient(linear, x);
  EXPECT_LE((gradient + Eigen::Map<const Eigen::VectorXd>(expected.data(), 36)).norm(),
            1e-12 * gradient.norm());
}

}  // namespace
}  // namespace darboux
