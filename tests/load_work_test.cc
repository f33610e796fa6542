#include "costs/load_work.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <ostream>
#include <vector>

#include "costs/support.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kForce(2.0, -3.0, 0.5);  // N

class LoadWorkTest : public ::testing::TestWithParam<double> {};  // size of u, m

TEST_P(LoadWorkTest, IsMinusForceTimesDisplacement) {
  const Vector3d u = SeededUniform(3, GetParam());
  for (const double s : {1.0, 1e4, 1e8}) {
    const LoadWork load(kForce.data(), s);
    EXPECT_EQ(Energy(load, u), -kForce.dot(u));
    EXPECT_LT((Gradient(load, u) + kForce).norm(), 1e-15 * kForce.norm());
  }
}

TEST_P(LoadWorkTest, JacobianMatchesRiddersDifferences) {
  const auto load = std::make_unique<LoadWork>(kForce.data(), 1e6);
  EXPECT_THAT(load, HasCorrectJacobianAt(SeededUniform(3, GetParam()), 1e-10));
}

INSTANTIATE_TEST_SUITE_P(DisplacementM, LoadWorkTest, ::testing::Values(0, 1e-8, 1e-2, 1, 1e2));

TEST(LoadWorkTest, ReadsTheForceAtEveryEvaluation) {
  Vector3d force = kForce;
  const LoadWork load(force.data(), 1e6);
  const Vector3d u(0.1, 0.2, 0.3);
  EXPECT_EQ(Energy(load, u), -kForce.dot(u));
  force *= -4.0;
  EXPECT_EQ(Energy(load, u), 4.0 * kForce.dot(u));
  EXPECT_LT((Gradient(load, u) - 4.0 * kForce).norm(), 1e-14);
}

// A dead load does work only on the displacement of its vertex along it.
TEST(LoadWorkTest, NeitherRestNorATurnAboutTheForceDoesWork) {
  const LoadWork load(kForce.data(), 1e6);
  EXPECT_EQ(Energy(load, Vector3d::Zero()), 0.0);
  const Matrix3d turn = Eigen::AngleAxisd(1.0, kForce.normalized()).toRotationMatrix();
  EXPECT_NEAR(Energy(load, turn * Vector3d(1, 2, 3) - Vector3d(1, 2, 3)), 0.0, 1e-15);
}

struct SpringCase {
  double stiffness, force, s;
};

void PrintTo(const SpringCase& c, std::ostream* out) {
  *out << "k " << c.stiffness << ", force " << c.force << ", s " << c.s;
}

class LoadedSpringTest : public ::testing::TestWithParam<SpringCase> {};

// Spring and load: u = f / k, whatever the sizes.
TEST_P(LoadedSpringTest, SettlesAtForceOverStiffness) {
  const auto& [stiffness, size, s] = GetParam();
  Vector3d force = size * kForce, u = Vector3d::Zero();
  ceres::Problem problem;
  std::vector<Support::Condition> springs(3);
  for (int i = 0; i < 3; ++i) {
    springs[i].coefficients = Vector3d::Unit(i);
    springs[i].stiffness = stiffness;
  }
  problem.AddResidualBlock(new Support(springs), nullptr, u.data());
  Potential::AddTo(&problem, new LoadWork(force.data(), s), {u.data()});
  ceres::Solver::Options options;
  options.function_tolerance = options.parameter_tolerance = 0.0;
  options.gradient_tolerance = 1e-13 * force.norm();
  options.max_num_iterations = 200;
  options.initial_trust_region_radius = 1e16;  // Undamped: one step settles springs.
  options.logging_type = ceres::SILENT;
  // Loads change between the solves of one problem.
  for (const double factor : {1.0, -2.0, 0.0}) {
    force = factor * size * kForce;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const Vector3d expected = force / stiffness;
    EXPECT_LT((u - expected).norm(), 1e-10 * size * kForce.norm() / stiffness)
        << summary.FullReport();
    EXPECT_NEAR(summary.final_cost,
                -0.5 * force.dot(expected),
                1e-10 * size * size * kForce.squaredNorm() / stiffness);
  }
}

// s as the problem chooses it, far above |f| / sqrt(k): f f^T / s^2 below 1e-10 of the stiffness.
INSTANTIATE_TEST_SUITE_P(Springs,
                         LoadedSpringTest,
                         ::testing::Values(SpringCase{1.0, 1.0, 1e7},
                                           SpringCase{1.0, 1.0, 1e8},
                                           SpringCase{1e6, 1e3, 1e7},
                                           SpringCase{1e6, 1e-3, 1e4},
                                           SpringCase{1e-2, 1e-4, 1e4}));

}  // namespace
}  // namespace darboux
