#include "costs/scan_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "geometry/shell_face.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Motion = Eigen::Matrix<double, 6, 1>;

ScanDistance::Foot SampleFoot() {
  ScanDistance::Foot foot;
  foot.point = Vector3d(0.3, -0.4, 0.9);
  foot.position = Vector3d(0.25, -0.38, 0.8);
  foot.normal = Vector3d(0.2, -0.3, 0.9).normalized();
  foot.weights = Vector3d(0.2, 0.5, 0.3);
  return foot;
}

class ScanDistanceTest : public ::testing::TestWithParam<double> {};  // size of u and w

TEST_P(ScanDistanceTest, JacobianMatchesRiddersDifferences) {
  ScanDistance::Frame frame;
  frame.center = Vector3d(0.1, 0.2, -0.1);
  frame.length = 0.7;
  const auto cost = std::make_unique<ScanDistance>(SampleFoot(), frame, 20.0);
  EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(15, GetParam()), 1e-9));
}
INSTANTIATE_TEST_SUITE_P(MotionM, ScanDistanceTest, ::testing::Values(0, 1e-8, 3e-3, 1e-2, 0.3, 1));

double Residual(const ScanDistance& cost, const Motion& motion, const Matrix3Xd& u) {
  std::vector<const double*> parameters = {motion.data()};
  for (int i = 0; i < u.cols(); ++i) parameters.push_back(u.col(i).data());
  double r = 0.0;
  EXPECT_TRUE(cost.Evaluate(parameters.data(), &r, nullptr));
  return r;
}

TEST(ScanDistanceTest, MotionIsItsPose) {
  ScanDistance::Foot foot = SampleFoot();
  foot.weights.resize(0);
  ScanDistance::Frame frame;
  frame.center = Vector3d(0.1, 0.2, -0.1);
  frame.length = 0.7;
  const Motion motion = SeededUniform(6, 0.8);
  const Vector3d moved = frame.Pose(motion) * foot.point;
  EXPECT_NEAR(Residual(ScanDistance(foot, frame, 3.0), motion, Matrix3Xd(3, 0)),
              3.0 * foot.normal.dot(moved - foot.position),
              1e-14);
}

// The block at a foot is the distance to the face to first order, in the motion of the scan and in
// the displacements, on a curved shell with a half thickness: what is left falls fourfold.
TEST(ScanDistanceTest, IsTheDistanceToFirstOrder) {
  ParameterDomain::Options options;
  options.u_range = options.v_range = {0.0, 2.0 * M_PI};
  options.divisions = {12, 8};
  options.periodic = {true, true};
  const ShellSurface surface(MakeTorus(3.0, 1.0), options);
  ShellFace face(surface, 0.1);
  const int n = surface.mesh().num_vertices;
  const auto field = [n](unsigned seed) -> Matrix3Xd {
    return Eigen::Map<const Matrix3Xd>(SeededUniform(3 * n, 0.05, seed).data(), 3, n);
  };
  const Matrix3Xd start = field(1), change = field(2);
  face.SetDisplacements(start);
  ScanDistance::Frame frame;
  frame.length = 3.0;
  const Motion motion = SeededUniform(6, 0.1, 3);

  ScanDistance::Foot foot;
  foot.point = Vector3d(2.9, 2.4, 0.9);
  const ShellFace::Foot there = face.Closest(foot.point);
  ASSERT_LT(std::abs(there.distance), 0.3);
  const std::vector<int>& vertices = surface.control_vertices(there.at.element);
  foot.position = there.position;
  foot.normal = there.normal;
  foot.weights = surface.ValueWeights(there.at);
  Matrix3Xd local_start(3, vertices.size()), local_change(3, vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    local_start.col(i) = start.col(vertices[i]);
    local_change.col(i) = change.col(vertices[i]);
    foot.position -= foot.weights[i] * local_start.col(i);
  }
  const ScanDistance cost(foot, frame, 1.0);
  EXPECT_NEAR(Residual(cost, Motion::Zero(), local_start), there.distance, 1e-14);

  double last = 0.0;
  for (const double part : {0.02, 0.01, 0.005}) {
    face.SetDisplacements(start + part * change);
    const double exact = face.Closest(frame.Pose(part * motion) * foot.point).distance;
    const double left =
        std::abs(Residual(cost, part * motion, local_start + part * local_change) - exact);
    EXPECT_LT(left, 0.1 * std::abs(exact - there.distance));
    if (last > 0.0) {
      EXPECT_NEAR(last / left, 4.0, 0.4);
    }
    last = left;
  }
}

}  // namespace
}  // namespace darboux
