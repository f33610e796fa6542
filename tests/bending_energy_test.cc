#include "costs/bending_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "geometry/shell_surface.h"
#include "tests/strain_energy_util.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Sum of D/2 rho^T C rho dA over the points, rho = strain(point).
template <typename Strain>
double ExpectedEnergy(const LoopPatch& patch, const Material& material, const Strain& strain) {
  double energy = 0.0;
  for (int e = 0; e < patch.mesh.num_elements; ++e) {
    const StrainPoints points = patch.Points(e);
    for (const StrainPoint& p : *points) {
      energy +=
          p.area * EnergyDensity(material.BendingStiffness(), material.poisson_ratio, strain(p));
    }
  }
  return energy;
}

Vector3d Curvatures(const StrainPoint& p) { return {p.b11, p.b22, 2.0 * p.b12}; }

class BendingPatchTest : public ::testing::TestWithParam<Patch> {
 protected:
  const Material material_ = SampleMaterial();
  const LoopPatch patch_ = MakeLoopPatch(GetParam());
  // What a bending strain of 1 / m would store.
  const double unit_ = material_.BendingStiffness() * patch_.Area();
};

TEST_P(BendingPatchTest, RestStoresNothing) {
  for (const StrainMeasure measure : AllMeasures()) {
    EXPECT_EQ(
        PatchEnergy<BendingEnergy>(patch_, measure, material_, patch_.Affine(Matrix3d::Zero())),
        0.0);
  }
}

TEST_P(BendingPatchTest, SkewRigidMotionStoresNoKoiterEnergy) {
  for (const double angle : {1e-6, 0.7, 3.0}) {
    // Second derivatives of the basis on cells of 1/2 m: rounding is that of 1e2 / m.
    EXPECT_LT(PatchEnergy<BendingEnergy>(
                  patch_, StrainMeasure::kKoiter, material_, patch_.RigidMotion(angle)),
              1e-26 * unit_);
  }
}

TEST_P(BendingPatchTest, LinearKoiterIsBlindToInfinitesimalRigidMotion) {
  const Matrix3Xd spin = patch_.Affine(CrossMatrix({0.3, -0.5, 0.7}), {0.1, -0.2, 0.3});
  EXPECT_LT(PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kLinearKoiter, material_, spin),
            1e-26 * unit_);
}

// Love's defect: the linear theory of the paper twists under a rotation about the normal.
TEST_P(BendingPatchTest, LinearSeedStoresTheTwistOfARotation) {
  const Vector3d w(0.3, -0.5, 0.7);
  const double expected = ExpectedEnergy(patch_, material_, [&](const StrainPoint& p) -> Vector3d {
    return w.dot(p.n) * Vector3d(-p.b12, p.b12, p.b11 - p.b22);
  });
  EXPECT_NEAR(PatchEnergy<BendingEnergy>(
                  patch_, StrainMeasure::kLinearSeed, material_, patch_.Affine(CrossMatrix(w))),
              expected,
              1e-13 * unit_);
}

TEST_P(BendingPatchTest, ScalingHasClosedForm) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.5}) {
    const Material material = SampleMaterial(nu);
    const double lambda = 1.3;
    const Matrix3Xd u = patch_.Affine((lambda - 1.0) * Matrix3d::Identity());
    const auto expected = [&](double factor) {
      return ExpectedEnergy(patch_, material, [&](const StrainPoint& p) -> Vector3d {
        return factor * Curvatures(p);
      });
    };
    const double tolerance = 1e-13 * unit_;
    EXPECT_NEAR(PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kKoiter, material, u),
                expected(lambda - 1.0),
                tolerance);
    EXPECT_NEAR(PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kLinearKoiter, material, u),
                expected(lambda - 1.0),
                tolerance);
    EXPECT_NEAR(PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kLinearSeed, material, u),
                0.0,
                tolerance);
    EXPECT_NEAR(PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kNonlinearSeed, material, u),
                expected(lambda * (lambda * lambda - 1.0)),
                tolerance);
  }
}

TEST_P(BendingPatchTest, EnergyDoesNotDependOnTheFrame) {
  ExpectTheSameInAnyFrame<BendingEnergy>(patch_, material_, 0.1, 1e-12);
}

TEST_P(BendingPatchTest, RotatingADeformedShellKeepsItsKoiterEnergy) {
  const Matrix3Xd x = patch_.RandomField(0.1);
  const double energy = PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kKoiter, material_, x);
  const Matrix3Xd turned = patch_.RigidMotion(2.0) + SkewRotation(2.0) * x;
  EXPECT_NEAR(
      PatchEnergy<BendingEnergy>(patch_, StrainMeasure::kKoiter, material_, turned) / energy,
      1.0,
      1e-12);
}

TEST_P(BendingPatchTest, EnergyDoesNotDependOnTheUnits) {
  ExpectTheSameInMillimetres<BendingEnergy>(patch_, material_);
}

TEST_P(BendingPatchTest, TinyDisplacementsKeepTheirDigits) {
  ExpectTinyDisplacementsToKeepTheirDigits<BendingEnergy>(patch_, material_);
}

TEST_P(BendingPatchTest, KoiterTendsToLinearKoiter) {
  ExpectKoiterToTendToLinearKoiter<BendingEnergy>(patch_, material_);
}

TEST_P(BendingPatchTest, BlockOfAnElementIsTheSumOfItsPoints) {
  const auto make = [this](const StrainPoints& points) {
    return BendingEnergy(points, StrainMeasure::kKoiter, material_);
  };
  ExpectABlockToBeTheSumOfItsPoints(patch_, make, 3, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Patches,
                         BendingPatchTest,
                         ::testing::ValuesIn(SamplePatches()),
                         PatchName);

// Per area D (1 - nu^2) kappa^2 / 2 / (1 - nu^2): a plate rolled up, all twist and all nu.
TEST(BendingEnergyTest, PlateRolledUpAndTwisted) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    const Material m = SampleMaterial(nu);
    const double d = m.young_modulus * std::pow(m.thickness, 3) / 12.0 / (1.0 - nu * nu);
    const BendingEnergy cost(
        std::make_shared<std::vector<StrainPoint>>(1, PlanePoint()), StrainMeasure::kKoiter, m);
    Fifteen roll = Fifteen::Zero();
    const double angle = 1.1, curvature = 2.0;
    roll.segment<3>(0) = Vector3d(std::cos(angle) - 1.0, 0.0, std::sin(angle));
    roll.segment<3>(6) = curvature * Vector3d(-std::sin(angle), 0.0, std::cos(angle));
    EXPECT_NEAR(Energy(cost, roll) / (0.5 * d * curvature * curvature), 1.0, 1e-14);
    Fifteen twist = Fifteen::Zero();
    twist[11] = 0.7;  // w = 0.7 x y
    EXPECT_NEAR(Energy(cost, twist) / (d * (1.0 - nu) * 0.49), 1.0, 1e-14);
    Fifteen dome = Fifteen::Zero();
    dome[8] = dome[14] = 0.7;
    EXPECT_NEAR(Energy(cost, dome) / (d * (1.0 + nu) * 0.49), 1.0, 1e-14);
  }
}

TEST(BendingEnergyTest, InflatedSphere) {
  const double radius = 0.5, lambda = 1.3;
  const StrainPoint point = DirectPoint(MakeSphere(radius)->Evaluate(0.4, 0.3), 0.9);
  const Fifteen k = AffineInputs(point, (lambda - 1.0) * Matrix3d::Identity());
  const Material m = SampleMaterial(0.5);
  const BendingEnergy cost(
      std::make_shared<std::vector<StrainPoint>>(1, point), StrainMeasure::kKoiter, m);
  const double rho = (lambda - 1.0) / radius;
  EXPECT_NEAR(Energy(cost, k) / (m.BendingStiffness() * 1.5 * rho * rho), 1.0, 1e-13);
}

// Thickness enters cubed.
TEST(BendingEnergyTest, ThinShellsBendEasily) {
  const LoopPatch patch = MakeLoopPatch(TorusPatch());
  const Matrix3Xd x = patch.RandomField(0.1);
  Material thin = SampleMaterial();
  thin.thickness *= 1e-4;
  EXPECT_NEAR(PatchEnergy<BendingEnergy>(patch, StrainMeasure::kKoiter, thin, x) /
                  PatchEnergy<BendingEnergy>(patch, StrainMeasure::kKoiter, SampleMaterial(), x),
              1e-12,
              1e-25);
}

TEST(BendingEnergyTest, CollapsedShellIsRefused) {
  const LoopPatch patch = MakeLoopPatch(TorusPatch());
  const BendingEnergy cost(patch.Points(0), StrainMeasure::kKoiter, SampleMaterial());
  Matrix3d onto_a_line = -Matrix3d::Identity();
  onto_a_line(0, 0) = 0.0;
  for (const Matrix3d& map : {Matrix3d(-Matrix3d::Identity()), onto_a_line}) {
    const VectorXd x = patch.Parameters(0, patch.Affine(map));
    EXPECT_FALSE(EvaluateAt(cost, x).ok);
    EXPECT_FALSE(EvaluateAt(cost, x, false).ok);
  }
}

// Elements at vertices of valence five have eleven control vertices and another basis.
TEST(BendingEnergyTest, IrregularElementsAreRigidAndScaleTheSame) {
  const LoopPatch ball = MakeIcosphere(1.0, 1);
  const Material material = SampleMaterial();
  const double unit = material.BendingStiffness() * ball.Area();
  EXPECT_LT(
      PatchEnergy<BendingEnergy>(ball, StrainMeasure::kKoiter, material, ball.RigidMotion(0.7)),
      1e-24 * unit);
  const double expected = ExpectedEnergy(
      ball, material, [&](const StrainPoint& p) -> Vector3d { return 0.3 * Curvatures(p); });
  EXPECT_NEAR(PatchEnergy<BendingEnergy>(
                  ball, StrainMeasure::kKoiter, material, ball.Affine(0.3 * Matrix3d::Identity())),
              expected,
              1e-12 * expected);
}

class BendingJacobianTest
    : public ::testing::TestWithParam<std::tuple<StrainMeasure, double, Patch>> {};

TEST_P(BendingJacobianTest, MatchesRiddersDifferences) {
  const auto& [measure, size, patch] = GetParam();
  const auto cost =
      std::make_unique<BendingEnergy>(MakeLoopPatch(patch).Points(2), measure, SampleMaterial());
  EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(36, size), 1e-7));
}

INSTANTIATE_TEST_SUITE_P(DisplacementM,
                         BendingJacobianTest,
                         ::testing::Combine(::testing::ValuesIn(AllMeasures()),
                                            ::testing::Values(0, 1e-8, 1e-2, 1, 1e2),
                                            ::testing::Values(TorusPatch(), EllipsoidPatch())));

TEST(BendingIrregularJacobianTest, MatchesRiddersDifferences) {
  const LoopPatch ball = MakeIcosphere(1.0, 1);
  const auto cost =
      std::make_unique<BendingEnergy>(ball.Points(0), StrainMeasure::kKoiter, SampleMaterial());
  EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(NumParameters(*cost), 1e-2), 1e-7));
}

// Curvatures of a rotation follow at second order of the cells, their energy at fourth.
TEST(ExactSurfaceTest, SpuriousEnergyOfARotationFallsFast) {
  const double coarse = SpuriousEnergyOfARotation<BendingEnergy>(2);
  const double fine = SpuriousEnergyOfARotation<BendingEnergy>(4);
  EXPECT_LT(coarse, 1e-2 * SampleMaterial().BendingStiffness());
  EXPECT_LT(fine, coarse / 10.0);
}

}  // namespace
}  // namespace darboux
