// Registration and shape fits from a scan of the grasped duck of solid elements (data/solids),
// which shares no error with Darboux, with noise, outliers and the shadows of the fingers.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "geometry/first_touch.h"
#include "geometry/scan_simulator.h"
#include "geometry/shell_face.h"
#include "solver/grasp.h"
#include "solver/registration.h"
#include "solver/shape_fit.h"
#include "tests/solids_util.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kTravel = 0.0085;  // of each finger, m
constexpr double kHalf = 0.00075;   // of the thickness

class SolidsFitTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    SolverOptions options;
    options.num_threads = 1;
    solution_ = new Solution(SolveScene(SceneFromData("duck.yaml"), options));
  }
  static void TearDownTestSuite() {
    delete solution_;
    solution_ = nullptr;
  }

  // The scan of data/calibration once more, with what is known of it, and the vertices of the face
  // that nobody sees because of a finger.
  SolidsFitTest() : duck_(SolidDuck("duck_8.5mm.csv")), scene_(SceneFromData("duck.yaml")) {
    std::string error;
    for (const FingerSpec& spec : scene_.fingers) {
      Occluder body;
      body.shape = MakeFinger(spec, &body.pose, &error);
      EXPECT_NE(body.shape, nullptr) << error;
      const Vector3d direction(spec.direction[0], spec.direction[1], spec.direction[2]);
      Touch touch;
      EXPECT_TRUE(FirstTouch(*body.shape, body.pose, direction, duck_.mesh.vertices, 0.0, &touch));
      body.pose.position += touch.shift * direction;
      fingers_.push_back(body);
    }
    ScanOptions options;
    options.seed = 2;
    options.num_points = 2500;
    options.noise = 0.000127;
    options.outliers = 0.02;
    options.viewpoints = ViewpointsAround(duck_, 4, 5.0);
    EXPECT_TRUE(SimulateScan(duck_, fingers_, options, &scan_, &error)) << error;

    options.num_points = static_cast<int>(duck_.mesh.vertices.size());
    options.outliers = 0.0;
    ScanSurface vertices = duck_;
    ScanVertices(&vertices);
    std::set<std::uint64_t> seen, seen_without;
    for (const bool with : {true, false}) {
      Scan all;
      EXPECT_TRUE(
          SimulateScan(vertices, with ? fingers_ : std::vector<Occluder>(), options, &all, &error))
          << error;
      for (const ScanTruth& truth : all.truth) (with ? seen : seen_without).insert(truth.number);
    }
    for (const std::uint64_t v : seen_without) {
      (seen.count(v) == 0 ? shadow_ : seen_).push_back(duck_.mesh.vertices[v]);
    }
  }

  // Distances of points of the true face from the fitted one, in the frame of the scan.
  DistanceStatistics Errors(const ShellSurface& surface,
                            const Matrix3Xd& displacements,
                            const RigidPose& pose,
                            const std::vector<Vector3d>& points) const {
    ShellFace fitted(surface, kHalf);
    fitted.SetDisplacements(displacements);
    const RigidPose together = pose * scan_.model_from_scan.Inverse();
    std::vector<double> errors;
    for (const Vector3d& x : points) errors.push_back(fitted.Closest(together * x).distance);
    return MakeDistanceStatistics(errors);
  }

  ShapeFitSummary Fit(const Scene& scene,
                      const Matrix3Xd& reference,
                      std::unique_ptr<ShellProblem>* shell) const {
    ShellProblem::Options shell_options;
    shell_options.nonlinear = true;
    std::string error;
    *shell = ShellProblem::Create(WithoutLoads(scene), shell_options, &error);
    EXPECT_NE(*shell, nullptr) << error;
    ShapeFitOptions options;
    options.registration.max_relative_sigma = 0.03;
    ShapeFitSummary summary;
    EXPECT_TRUE(
        FitShape(shell->get(), reference, kHalf, scan_.cloud.points, options, &summary, &error))
        << error;
    EXPECT_TRUE(summary.converged) << summary.FullReport();
    return summary;
  }

  // Root mean square, and for whoever asks for the XML of the tests more.
  double Rms(const std::string& what,
             const ShellSurface& surface,
             const Matrix3Xd& displacements,
             const RigidPose& pose,
             const std::vector<Vector3d>& points) const {
    const DistanceStatistics errors = Errors(surface, displacements, pose, points);
    RecordProperty(what + "_rms_um", static_cast<int>(std::lround(1e6 * errors.rms)));
    RecordProperty(what + "_max_um", static_cast<int>(std::lround(1e6 * errors.max)));
    return errors.rms;
  }

  static Solution* solution_;
  ScanSurface duck_;
  Scene scene_;
  std::vector<Occluder> fingers_;
  Scan scan_;
  std::vector<Vector3d> seen_, shadow_;
};
Solution* SolidsFitTest::solution_ = nullptr;

TEST_F(SolidsFitTest, TheScanOfTheDataIsThisOne) {
  PointCloud cloud;
  std::string error;
  ASSERT_TRUE(ReadPointCloud(DARBOUX_DATA_DIR "/calibration/duck_8.5mm_scan.csv", &cloud, &error))
      << error;
  ASSERT_EQ(cloud.points.size(), scan_.cloud.points.size());
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_LT((cloud.points[i] - scan_.cloud.points[i]).norm(), 1e-6) << i;  // six digits, m
  }
  RecordProperty("shadow", static_cast<int>(shadow_.size()));
  EXPECT_GT(shadow_.size(), 30u);
}

// The paper's measure: its best mean is 7 % of the largest displacement, here that of the shell
// under the fingers, which is their travel. Outliers, which the truth knows, are no distances.
TEST_F(SolidsFitTest, TheComputedDuckIsWhereTheScanIs) {
  using Method = RegistrationOptions::Method;
  const ShellSurface& surface = solution_->problem->surface();
  const Matrix3Xd& displacements = solution_->problem->displacements();
  // The scene's duck has turned about the line of the fingers.
  EXPECT_NEAR(Deformation(surface, displacements).largest(), kTravel, 0.02 * kTravel);
  EXPECT_GT(solution_->summary.max_displacement, 2.0 * kTravel);
  ShellFace face(surface, kHalf);
  face.SetDisplacements(displacements);
  for (const Method method : {Method::kRobust, Method::kUndeformedFirst}) {
    const std::string name = method == Method::kRobust ? "robust" : "undeformed_first";
    RegistrationOptions options;
    options.method = method;
    options.max_relative_sigma = 0.03;
    RegistrationSummary summary;
    std::string error;
    ASSERT_TRUE(Register(face, scan_.cloud.points, options, &summary, &error)) << error;
    ASSERT_TRUE(summary.matched) << summary.verdict;
    std::vector<double> distances;
    for (size_t i = 0; i < summary.distances.size(); ++i) {
      if (scan_.truth[i].outlier == OutlierKind::kNone) distances.push_back(summary.distances[i]);
    }
    const double mean = MakeDistanceStatistics(distances).mean_abs / kTravel;
    EXPECT_LT(mean, 0.07) << name;
    RecordProperty(name + "_mean_permyriad", static_cast<int>(1e4 * mean));
    // Without the noise of the scan: how far the two theories are apart.
    EXPECT_LT(Rms(name, surface, displacements, summary.pose, duck_.mesh.vertices), 0.0001);
  }
}

TEST_F(SolidsFitTest, TheFitIsRightInTheShadowOfFingersThatAreKnown) {
  std::unique_ptr<ShellProblem> shell;
  const ShapeFitSummary fit = Fit(scene_, solution_->problem->displacements(), &shell);
  const ShellSurface& surface = shell->surface();
  EXPECT_LT(Rms("shadow", surface, fit.displacements, fit.pose, shadow_), 0.0005);
  EXPECT_LT(Rms("all", surface, fit.displacements, fit.pose, duck_.mesh.vertices), 0.0005);
}

TEST_F(SolidsFitTest, WithoutFingersTheFitIsRightWhereItIsSeen) {
  std::unique_ptr<ShellProblem> shell;
  const ShapeFitSummary fit = Fit(scene_, Matrix3Xd(), &shell);
  const ShellSurface& surface = shell->surface();
  EXPECT_LT(Rms("seen", surface, fit.displacements, fit.pose, seen_), 0.0005);
  // The bottom of a dent that nobody has seen is where the energy has it.
  Rms("shadow", surface, fit.displacements, fit.pose, shadow_);
  Rms("all", surface, fit.displacements, fit.pose, duck_.mesh.vertices);
}

}  // namespace
}  // namespace darboux
