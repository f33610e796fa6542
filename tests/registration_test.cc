#include "solver/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "geometry/icosphere.h"
#include "geometry/loop_mesh.h"
#include "geometry/shell_surface.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

ShellSurface Ellipsoid(const Vector3d& semi_axes, int frequency = 8) {
  TriangleMesh mesh = MakeIcosphere(1.0, frequency);
  SmoothOnSphere(10, &mesh);
  for (Vector3d& x : mesh.vertices) x = x.cwiseProduct(semi_axes);
  return ShellSurface(MakeLoopMesh(mesh));
}

// Two dents that leave the body no symmetry.
Matrix3Xd Dents(const ShellSurface& surface, double scale = 1.0) {
  Matrix3Xd u(3, surface.mesh().num_vertices);
  for (int i = 0; i < u.cols(); ++i) {
    const Vector3d x = surface.control_points().col(i) / scale;
    u.col(i) =
        -0.15 * std::exp(-(x - Vector3d(0.9, 0.2, 0.1)).squaredNorm() / 0.08) * Vector3d::UnitX() -
        0.10 * std::exp(-(x - Vector3d(0.3, 0.2, 0.55)).squaredNorm() / 0.05) * Vector3d::UnitZ();
  }
  return scale * u;
}

struct Scanner {
  int num_points = 2000;
  double noise = 0.0;
  double outliers = 0.0;         // part of the points
  std::optional<Vector3d> view;  // seen from there only
  unsigned seed = 1;
};

double Normal(std::mt19937_64* generator) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double a = 1.0 - uniform(*generator), b = uniform(*generator);
  return std::sqrt(-2.0 * std::log(a)) * std::cos(2.0 * M_PI * b);
}

// Points on the face, then moved by the pose.
std::vector<Vector3d> Scan(const ShellFace& face, const Scanner& scanner, const RigidPose& pose) {
  std::mt19937_64 generator(scanner.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double size = face.surface().size();
  std::vector<Vector3d> points;
  while (static_cast<int>(points.size()) < scanner.num_points) {
    if (uniform(generator) < scanner.outliers) {
      const double x = uniform(generator), y = uniform(generator), z = uniform(generator);
      points.push_back(pose * (size * (Vector3d(x, y, z) - Vector3d::Constant(0.5))));
      continue;
    }
    const int e = static_cast<int>(generator() % face.surface().num_elements());
    double s = uniform(generator), t = uniform(generator);
    if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
    const ShellFace::Foot foot = face.Evaluate({e, s, t});
    if (scanner.view && foot.normal.dot(scanner.view->normalized()) < 0.15) continue;
    points.push_back(pose * (foot.position + scanner.noise * Normal(&generator) * foot.normal));
  }
  return points;
}

RigidPose RandomPose(unsigned seed) {
  std::mt19937_64 generator(seed);
  const double w = Normal(&generator), x = Normal(&generator), y = Normal(&generator),
               z = Normal(&generator);
  RigidPose pose;
  pose.rotation = Eigen::Quaterniond(w, x, y, z).normalized();
  pose.translation = Vector3d(3.0 * x, -2.0 * z, 5.0 * y);
  return pose;
}

// The largest error of the pose of a point of the body.
double Error(const RigidPose& found, const RigidPose& pose, double size) {
  const RigidPose together = found * pose;
  double worst = 0.0;
  for (int k = 0; k < 8; ++k) {
    const Vector3d x = 0.3 * size * Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    worst = std::max(worst, (together * x - x).norm());
  }
  return worst;
}

// Four standard deviations of it, from the normal equations.
double ErrorBound(const RegistrationSummary& summary) {
  double variance = 0.0;
  for (int k = 0; k < 6; ++k) variance += 1.0 / (summary.inliers.count * summary.eigenvalues[k]);
  return 4.0 * summary.sigma * std::sqrt(variance);
}

class RegistrationTest : public ::testing::Test {
 protected:
  RegistrationTest() : surface_(Ellipsoid({1.0, 0.8, 0.6})), face_(surface_, 0.02) {
    face_.SetDisplacements(Dents(surface_));
  }
  RegistrationSummary Run(const std::vector<Vector3d>& scan,
                          const RegistrationOptions& options = {}) const {
    RegistrationSummary summary;
    std::string error;
    EXPECT_TRUE(Register(face_, scan, options, &summary, &error)) << error;
    return summary;
  }

  ShellSurface surface_;
  ShellFace face_;
};

TEST_F(RegistrationTest, ExactScansAreFoundToRounding) {
  for (const unsigned seed : {1u, 2u}) {
    const RigidPose pose = RandomPose(seed);
    const RegistrationSummary summary = Run(Scan(face_, {}, pose));
    EXPECT_TRUE(summary.matched) << summary.verdict;
    EXPECT_LT(Error(summary.pose, pose, surface_.size()), 1e-9 * surface_.size());
    EXPECT_LT(summary.sigma, 1e-12 * surface_.size());
    EXPECT_EQ(summary.equivalent_poses, 0);
    EXPECT_TRUE(summary.undetermined.empty());
  }
}

class RegistrationOutlierTest : public RegistrationTest,
                                public ::testing::WithParamInterface<double> {};

TEST_P(RegistrationOutlierTest, NoiseAndOutliersAreFound) {
  const RigidPose pose = RandomPose(11);
  Scanner scanner;
  scanner.noise = 0.003;
  scanner.outliers = GetParam();
  const std::vector<Vector3d> scan = Scan(face_, scanner, pose);
  const RegistrationSummary summary = Run(scan);
  EXPECT_TRUE(summary.matched) << summary.verdict;
  EXPECT_LT(Error(summary.pose, pose, surface_.size()), ErrorBound(summary));
  EXPECT_LT(ErrorBound(summary), 0.005);
  EXPECT_NEAR(summary.sigma, 0.003, 0.0005);
  EXPECT_NEAR(summary.noise, 0.003, 0.0015);
  // 0.3 % of the inliers are beyond three sigma, and some outliers lie on the face.
  EXPECT_NEAR(1.0 - summary.inlier_fraction, GetParam(), 0.02);
  EXPECT_EQ(summary.all.count, 2000);
  EXPECT_EQ(summary.inliers.count + static_cast<int>(summary.outliers.size()), 2000);
  for (const int i : summary.outliers) {
    EXPECT_GT(std::abs(summary.distances[i]), summary.inliers.max);
  }
}
INSTANTIATE_TEST_SUITE_P(Part, RegistrationOutlierTest, ::testing::Values(0.0, 0.02, 0.2));

TEST_F(RegistrationTest, ScansFromOneSideAreFoundOrCalledAmbiguous) {
  int found = 0, ambiguous = 0, count = 0;
  for (const Vector3d& view : {Vector3d(1, 0.2, 0.3),
                               Vector3d(0.8, 0.3, 0.6),
                               Vector3d(0.3, 0.1, 1.0),
                               Vector3d(-1, -0.4, -0.5)}) {  // without the dents
    Scanner scanner;
    scanner.noise = 0.002;
    scanner.outliers = 0.05;
    scanner.view = view;
    scanner.seed = 20 + count;
    const RigidPose pose = RandomPose(30 + count);
    const RegistrationSummary summary = Run(Scan(face_, scanner, pose));
    ++count;
    EXPECT_TRUE(summary.matched) << summary.verdict;
    EXPECT_NEAR(summary.sigma, 0.002, 0.0005) << view.transpose();
    const bool right = Error(summary.pose, pose, surface_.size()) < ErrorBound(summary);
    found += right ? 1 : 0;
    ambiguous += summary.equivalent_poses > 0 ? 1 : 0;
    EXPECT_TRUE(right || summary.equivalent_poses > 0)
        << view.transpose() << ": error " << Error(summary.pose, pose, surface_.size())
        << ", bound " << ErrorBound(summary) << "; " << summary.FullReport();
  }
  EXPECT_GE(found, 3);
  EXPECT_LE(ambiguous, 1);
}

TEST_F(RegistrationTest, AnInitialPoseIsRefined) {
  const RigidPose pose = RandomPose(5);
  RigidPose near = pose.Inverse();
  near.rotation = near.rotation * Eigen::AngleAxisd(0.15, Vector3d(1, 2, -1).normalized());
  near.translation +=
      Vector3d(0.03, -0.02, 0.02) + pose.Inverse() * Vector3d::Zero() - near * Vector3d::Zero();
  RegistrationOptions options;
  options.initial_pose = near;
  const RegistrationSummary summary = Run(Scan(face_, {}, pose), options);
  EXPECT_TRUE(summary.matched) << summary.verdict;
  EXPECT_EQ(summary.num_starts, 1);
}

TEST_F(RegistrationTest, AScanInMillimetresIsNamed) {
  std::vector<Vector3d> scan = Scan(face_, {}, RandomPose(6));
  for (Vector3d& x : scan) x *= 1000.0;
  const RegistrationSummary larger = Run(scan);
  EXPECT_FALSE(larger.matched);
  EXPECT_NE(larger.verdict.find("1000 times larger"), std::string::npos) << larger.verdict;
  for (Vector3d& x : scan) x *= 1e-6;
  const RegistrationSummary smaller = Run(scan);
  EXPECT_FALSE(smaller.matched);
  EXPECT_NE(smaller.verdict.find("1000 times smaller"), std::string::npos) << smaller.verdict;
}

TEST_F(RegistrationTest, AnotherObjectIsNoMatch) {
  const ShellSurface other = Ellipsoid({0.9, 0.9, 0.75});
  const RegistrationSummary summary = Run(Scan(ShellFace(other, 0.0), {}, RandomPose(7)));
  EXPECT_FALSE(summary.matched) << summary.verdict;
  EXPECT_NE(summary.verdict.find("another object"), std::string::npos) << summary.verdict;
}

TEST_F(RegistrationTest, NothingButOutliersIsNoMatch) {
  Scanner scanner;
  scanner.outliers = 1.0;
  const RegistrationSummary summary = Run(Scan(face_, scanner, RandomPose(8)));
  EXPECT_FALSE(summary.matched) << summary.verdict;
}

TEST_F(RegistrationTest, FewPointsAreNoMatch) {
  Scanner scanner;
  scanner.num_points = 5;
  const RegistrationSummary summary = Run(Scan(face_, scanner, RandomPose(9)));
  EXPECT_FALSE(summary.matched);
  EXPECT_NE(summary.verdict.find("too few points: found 5"), std::string::npos);
}

TEST_F(RegistrationTest, PointsThatAreNotFiniteAreAnError) {
  std::vector<Vector3d> scan = Scan(face_, {}, RandomPose(9));
  scan[17].y() = std::numeric_limits<double>::quiet_NaN();
  RegistrationSummary summary;
  std::string error;
  EXPECT_FALSE(Register(face_, scan, {}, &summary, &error));
  EXPECT_NE(error.find("point 17"), std::string::npos) << error;
}

TEST_F(RegistrationTest, AScanOfTheRestShapeDoesNotMatchTheDentedOneWithinItsNoise) {
  const ShellFace rest(surface_, 0.02);
  Scanner scanner;
  scanner.noise = 0.0005;
  RegistrationOptions options;
  options.noise = 0.0005;
  const RegistrationSummary summary = Run(Scan(rest, scanner, RandomPose(10)), options);
  // Most of the body is the same: it matches, and the dents are outliers.
  EXPECT_TRUE(summary.matched) << summary.verdict;
  EXPECT_GT(summary.outliers.size(), 100u);
  EXPECT_LT(summary.inlier_fraction, 0.95);
}

// Footnote 11: the pose comes from where nothing moved, so that what the computed dent gets wrong
// does not pull at it.
TEST_F(RegistrationTest, UndeformedPartsAlignFirst) {
  ShellFace deeper(surface_, 0.02);
  deeper.SetDisplacements(1.3 * Dents(surface_));
  const RigidPose pose = RandomPose(12);
  Scanner scanner;
  scanner.num_points = 4000;
  const std::vector<Vector3d> scan = Scan(deeper, scanner, pose);
  RegistrationOptions options;
  options.method = RegistrationOptions::Method::kUndeformedFirst;
  options.undeformed_part = 1e-6;
  const RegistrationSummary summary = Run(scan, options);
  EXPECT_TRUE(summary.matched) << summary.verdict;
  EXPECT_GT(summary.num_undeformed, 400);
  EXPECT_LT(summary.num_undeformed, 4000);
  EXPECT_LT(Error(summary.pose, pose, surface_.size()), 1e-6);
  // The dent is 0.045 deeper than computed: the paper's statistics say so.
  EXPECT_NEAR(summary.all.max, 0.3 * 0.15, 0.01);
  EXPECT_GT(summary.all.max, 10.0 * summary.all.mean_abs);
}

// What a computed state did as a whole is no deformation.
TEST_F(RegistrationTest, RigidMotionsOfTheComputedShapeDoNotCount) {
  const RigidPose turn = RandomPose(13);
  Matrix3Xd turned = surface_.control_points() + Dents(surface_);
  for (int i = 0; i < turned.cols(); ++i) turned.col(i) = turn * Vector3d(turned.col(i));
  turned -= surface_.control_points();
  const Deformation still(surface_, Dents(surface_)), moved(surface_, turned);
  // The dents cover a small part and do not pull at it.
  EXPECT_LT(Error(still.motion(), {}, surface_.size()), 1e-5);
  EXPECT_LT(Error(moved.motion(), (turn * still.motion()).Inverse(), surface_.size()), 1e-8);
  EXPECT_NEAR(moved.largest(), still.largest(), 1e-8);
  EXPECT_NEAR(still.largest(), 0.15, 0.02);  // The limit surface has less of it.
  for (const ElementPoint& at : surface_.vertex_points()) {
    EXPECT_NEAR(moved.At(at), still.At(at), 1e-8);
  }
  Matrix3Xd only_turned = surface_.control_points();
  for (int i = 0; i < turned.cols(); ++i) only_turned.col(i) = turn * Vector3d(only_turned.col(i));
  EXPECT_LT(Deformation(surface_, only_turned - surface_.control_points()).largest(), 1e-12);
  EXPECT_EQ(Deformation(surface_, Matrix3Xd::Zero(3, turned.cols())).largest(), 0.0);

  // Hence not for where the shell hardly deformed.
  const RigidPose pose = RandomPose(14);
  const std::vector<Vector3d> scan = Scan(face_, {}, pose);
  RegistrationOptions options;
  options.method = RegistrationOptions::Method::kUndeformedFirst;
  const RegistrationSummary before = Run(scan, options);
  face_.SetDisplacements(turned);
  const RegistrationSummary after = Run(scan, options);
  EXPECT_TRUE(after.matched) << after.verdict;
  EXPECT_EQ(after.num_undeformed, before.num_undeformed);
  EXPECT_LT(Error(turn.Inverse() * after.pose, pose, surface_.size()), 1e-9 * surface_.size());
}

// A ball turns as it likes: the scan stays as it is and only moves.
TEST(RegistrationOfABallTest, TurnsAreNotDetermined) {
  const ShellSurface ball = Ellipsoid({1.0, 1.0, 1.0}, 10);
  const ShellFace face(ball, 0.0);
  RigidPose pose;
  pose.translation = Vector3d(1.0, 2.0, 3.0);
  Scanner scanner;
  scanner.noise = 0.002;
  RegistrationSummary summary;
  std::string error;
  ASSERT_TRUE(Register(face, Scan(face, scanner, pose), {}, &summary, &error)) << error;
  EXPECT_TRUE(summary.matched) << summary.verdict;
  EXPECT_EQ(summary.undetermined.size(), 3u) << summary.verdict;
  // But for the bumps of its triangulation, in which it settles.
  EXPECT_LT(Eigen::AngleAxisd(summary.pose.rotation).angle(), 0.03) << summary.FullReport();
}

TEST_F(RegistrationTest, MillimetresAreMetres) {
  LoopMesh loop;
  loop.mesh = surface_.mesh();
  loop.points = 1000.0 * surface_.control_points();
  const ShellSurface in_mm(std::move(loop));
  ShellFace face_mm(in_mm, 20.0);
  face_mm.SetDisplacements(Dents(in_mm, 1000.0));
  const RigidPose pose = RandomPose(13);
  Scanner scanner;
  scanner.noise = 0.002;
  scanner.outliers = 0.1;
  std::vector<Vector3d> scan = Scan(face_, scanner, pose);
  const RegistrationSummary metres = Run(scan);
  for (Vector3d& x : scan) x *= 1000.0;
  RegistrationSummary millimetres;
  std::string error;
  ASSERT_TRUE(Register(face_mm, scan, {}, &millimetres, &error)) << error;
  EXPECT_TRUE(metres.matched && millimetres.matched);
  EXPECT_LT((millimetres.pose.translation / 1000.0 - metres.pose.translation).norm(), 1e-9);
  EXPECT_NEAR(std::abs(millimetres.pose.rotation.dot(metres.pose.rotation)), 1.0, 1e-12);
  EXPECT_NEAR(millimetres.sigma, 1000.0 * metres.sigma, 1e-6 * millimetres.sigma);
}

TEST(DistanceStatisticsTest, AreThoseOfAHandfulOfNumbers) {
  const DistanceStatistics s = MakeDistanceStatistics({1.0, -2.0, 3.0, -4.0, 20.0});
  EXPECT_EQ(s.count, 5);
  EXPECT_DOUBLE_EQ(s.mean, 3.6);
  EXPECT_DOUBLE_EQ(s.mean_abs, 6.0);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(430.0 / 5.0));
  EXPECT_DOUBLE_EQ(s.median_abs, 3.0);
  EXPECT_DOUBLE_EQ(s.max, 20.0);
  EXPECT_DOUBLE_EQ(s.bin_width, 1.0);
  EXPECT_EQ(s.histogram[1] + s.histogram[2] + s.histogram[3] + s.histogram[4], 4);
  EXPECT_EQ(s.histogram.back(), 1);
  EXPECT_EQ(std::accumulate(s.histogram.begin(), s.histogram.end(), 0), 5);
  EXPECT_EQ(MakeDistanceStatistics({}).count, 0);
  EXPECT_EQ(MakeDistanceStatistics({0.0, 0.0}).histogram[0], 2);
}

}  // namespace
}  // namespace darboux
