#include "solver/shape_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "geometry/shell_face.h"
#include "solver/fields.h"
#include "solver/scan_results.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// The poked ellipsoid of data/: a dent five times as deep as the wall is thick, mm.
class ShapeFitTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    solution_ = new Solution(SolveScene(SceneFromData("ellipsoid_poke.yaml")));
  }
  static void TearDownTestSuite() {
    delete solution_;
    solution_ = nullptr;
  }

  ShapeFitTest()
      : surface_(solution_->problem->surface()),
        truth_(surface_, kHalf),
        equilibrium_(solution_->problem->displacements()) {
    truth_.SetDisplacements(equilibrium_);
    pose_.rotation = Eigen::Quaterniond(0.9, 0.2, -0.3, 0.1).normalized();
    pose_.translation = Vector3d(100.0, -50.0, 20.0);
    std::string error;
    ShellProblem::Options options;
    options.nonlinear = true;
    shell_ =
        ShellProblem::Create(WithoutLoads(SceneFromData("ellipsoid_poke.yaml")), options, &error);
    EXPECT_NE(shell_, nullptr) << error;
  }

  std::vector<Vector3d> Scan(int num_points,
                             double noise,
                             double outliers,
                             const std::optional<Vector3d>& view = std::nullopt) const {
    std::mt19937_64 generator(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<Vector3d> scan;
    while (static_cast<int>(scan.size()) < num_points) {
      if (uniform(generator) < outliers) {
        const double x = uniform(generator), y = uniform(generator), z = uniform(generator);
        scan.push_back(pose_ * (surface_.size() * (Vector3d(x, y, z) - Vector3d::Constant(0.5))));
        continue;
      }
      const int e = static_cast<int>(generator() % surface_.num_elements());
      double s = uniform(generator), t = uniform(generator);
      if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
      const ShellFace::Foot foot = truth_.Evaluate({e, s, t});
      const double a = 1.0 - uniform(generator), b = uniform(generator);
      if (view && foot.normal.dot(view->normalized()) < 0.0) continue;
      const double normal = std::sqrt(-2.0 * std::log(a)) * std::cos(2.0 * M_PI * b);
      scan.push_back(pose_ * (foot.position + noise * normal * foot.normal));
    }
    return scan;
  }

  ShapeFitSummary Fit(const std::vector<Vector3d>& scan,
                      const Matrix3Xd& reference,
                      const ShapeFitOptions& given = {}) const {
    ShapeFitOptions options = given;
    options.registration.max_relative_sigma = 0.03;
    ShapeFitSummary summary;
    std::string error;
    EXPECT_TRUE(FitShape(shell_.get(), reference, kHalf, scan, options, &summary, &error)) << error;
    return summary;
  }

  // Distances of points of the true face from the fitted one, in the frame of the scan.
  std::vector<double> Errors(const ShapeFitSummary& summary) const {
    ShellFace fitted(shell_->surface(), kHalf);
    fitted.SetDisplacements(summary.displacements);
    const RigidPose together = summary.pose * pose_;
    std::vector<double> errors;
    for (const ElementPoint& at : surface_.vertex_points()) {
      errors.push_back(fitted.Closest(together * truth_.Evaluate(at).position).distance);
    }
    return errors;
  }

  static constexpr double kHalf = 0.5;  // of the thickness
  static Solution* solution_;
  const ShellSurface& surface_;
  ShellFace truth_;
  Matrix3Xd equilibrium_;
  RigidPose pose_;
  std::unique_ptr<ShellProblem> shell_;
};
Solution* ShapeFitTest::solution_ = nullptr;

TEST_F(ShapeFitTest, ADentIsFittedToTheNoiseWithoutItsFinger) {
  const double noise = 0.05;
  const ShapeFitSummary summary = Fit(Scan(4000, noise, 0.05), Matrix3Xd());
  EXPECT_TRUE(summary.converged) << summary.FullReport();
  EXPECT_NEAR(summary.noise, noise, 0.15 * noise);
  EXPECT_NEAR(summary.misfit, summary.noise, 0.1 * summary.noise);
  EXPECT_GT(summary.weight, 0.0);
  // One in twenty; some of them lie on the shell, some points next to them fall with them.
  EXPECT_NEAR(summary.num_outliers, 200, 60);
  // 5 mm deep: the fit is nearer to the truth than the noise, but for the kink around the dent.
  const DistanceStatistics errors = MakeDistanceStatistics(Errors(summary));
  EXPECT_LT(errors.rms, noise);
  EXPECT_LT(errors.mean_abs, 0.5 * noise);
  EXPECT_LT(errors.max, 0.15 * solution_->summary.max_displacement);
}

TEST_F(ShapeFitTest, WhatTheScanDoesNotShowIsTheComputedShape) {
  // From the side of the dent: nothing of the lower half.
  const ShapeFitSummary summary = Fit(Scan(3000, 0.02, 0.1, Vector3d(0.3, 0.2, 1.0)), equilibrium_);
  EXPECT_TRUE(summary.converged) << summary.FullReport();
  EXPECT_LT(MakeDistanceStatistics(Errors(summary)).max, 0.1);
}

TEST_F(ShapeFitTest, AWrongEquilibriumIsCorrected) {
  const double noise = 0.03;
  const ShapeFitSummary summary = Fit(Scan(4000, noise, 0.0), 0.8 * equilibrium_);
  EXPECT_TRUE(summary.converged) << summary.FullReport();
  const DistanceStatistics errors = MakeDistanceStatistics(Errors(summary));
  EXPECT_LT(errors.rms, noise);
  // Before, the dent was 1 mm too shallow.
  EXPECT_LT(errors.max, 0.3);
}

TEST_F(ShapeFitTest, ALargeWeightLeavesTheReferenceAsItIs) {
  ShapeFitOptions options;
  options.weight = 1e9;
  const ShapeFitSummary summary = Fit(Scan(1500, 0.05, 0.0), 0.9 * equilibrium_, options);
  EXPECT_EQ(summary.weight, 1e9);
  // Only the strains count, the supports hold the rest.
  EXPECT_LT((summary.displacements - 0.9 * equilibrium_).cwiseAbs().maxCoeff(), 1e-3);
}

TEST_F(ShapeFitTest, AScanInAnotherUnitIsNotFitted) {
  std::vector<Vector3d> scan = Scan(500, 0.05, 0.0);
  for (Vector3d& x : scan) x /= 1000.0;
  const ShapeFitSummary summary = Fit(scan, Matrix3Xd());
  EXPECT_FALSE(summary.converged);
  EXPECT_NE(summary.verdict.find("1000 times smaller"), std::string::npos) << summary.verdict;
  EXPECT_EQ(summary.iterations, -1);
}

TEST_F(ShapeFitTest, TheErrorMapIsFiniteAndKnowsWhatWasSeen) {
  ShellFace face(surface_, kHalf);
  const std::vector<Vector3d> scan = Scan(1000, 0.0, 0.0, Vector3d(0.0, 0.0, 1.0));
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
  for (const Vector3d& x : scan) {
    feet.push_back(face.Closest(pose_.Inverse() * x));
    distances.push_back(feet.back().distance);
  }
  const std::vector<ExtraField> fields = MakeScanFields(face, feet, distances, {});
  ASSERT_EQ(fields.size(), 2u);
  const std::vector<ElementPoint> points = MakeOutputMesh(surface_).points;
  ASSERT_EQ(fields[0].values.size(), points.size());
  int dented = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const ShellFace::Foot at = face.Evaluate(points[i]);
    EXPECT_TRUE(std::isfinite(fields[0].values[i]));
    if (at.normal.z() > 0.3) {
      EXPECT_EQ(fields[1].values[i], 1.0);
    }
    if (at.normal.z() < -0.5) {
      EXPECT_EQ(fields[1].values[i], 0.0);
    }
    dented += fields[0].values[i] < -2.0 ? 1 : 0;
  }
  EXPECT_GT(dented, 3);
}

}  // namespace
}  // namespace darboux
