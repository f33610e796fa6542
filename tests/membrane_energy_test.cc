#include "costs/membrane_energy.h"

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
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

const StrainMeasure kLinear = StrainMeasure::kLinearKoiter;
const StrainMeasure kNonlinear = StrainMeasure::kKoiter;

// Energy of a point of area 1 with given kinematics.
double PointEnergy(const StrainPoint& point,
                   StrainMeasure measure,
                   const Material& material,
                   const Fifteen& k) {
  const MembraneEnergy cost(
      std::make_shared<std::vector<StrainPoint>>(1, point), measure, material);
  return Energy(cost, k);
}

class MembranePatchTest : public ::testing::TestWithParam<Patch> {
 protected:
  const Material material_ = SampleMaterial();
  const LoopPatch patch_ = MakeLoopPatch(GetParam());
  // What a strain of 1 would store: rounding is measured against it.
  const double unit_ = material_.MembraneStiffness() * patch_.Area();
};

TEST_P(MembranePatchTest, RestStoresNothing) {
  const Matrix3Xd rest = patch_.Affine(Matrix3d::Zero());
  for (const StrainMeasure measure : AllMeasures()) {
    EXPECT_EQ(PatchEnergy<MembraneEnergy>(patch_, measure, material_, rest), 0.0);
  }
}

TEST_P(MembranePatchTest, SkewRigidMotionStoresNoEnergy) {
  for (const double angle : {1e-6, 0.7, 3.0}) {
    for (const StrainMeasure measure : {StrainMeasure::kKoiter, StrainMeasure::kNonlinearSeed}) {
      EXPECT_LT(PatchEnergy<MembraneEnergy>(patch_, measure, material_, patch_.RigidMotion(angle)),
                1e-27 * unit_);
    }
  }
}

TEST_P(MembranePatchTest, LinearTheoryIsBlindToInfinitesimalRigidMotion) {
  const Matrix3Xd spin = patch_.Affine(CrossMatrix({0.3, -0.5, 0.7}), {0.1, -0.2, 0.3});
  EXPECT_LT(PatchEnergy<MembraneEnergy>(patch_, kLinear, material_, spin), 1e-28 * unit_);
  // A finite one strains it by angle^2 / 2: energy to the fourth power.
  const double small =
      PatchEnergy<MembraneEnergy>(patch_, kLinear, material_, patch_.RigidMotion(1e-3));
  const double large =
      PatchEnergy<MembraneEnergy>(patch_, kLinear, material_, patch_.RigidMotion(1e-2));
  EXPECT_NEAR(large / small, 1e4, 10.0);
}

// An affine map of the surface: Green's strain is that of the map, seen in the tangent plane.
TEST_P(MembranePatchTest, AffineMapHasClosedForm) {
  const Matrix3d a = SeededMatrix(0.3, 11);
  const Matrix3d green = 0.5 * (a + a.transpose() + a.transpose() * a);
  const Matrix3d linear = 0.5 * (a + a.transpose());
  for (const double nu : {-0.5, 0.0, 0.3, 0.5}) {
    const Material material = SampleMaterial(nu);
    for (const StrainMeasure measure : AllMeasures()) {
      const Matrix3d& tensor = IsLinear(measure) ? linear : green;
      double expected = 0.0;
      for (int e = 0; e < patch_.mesh.num_elements; ++e) {
        const StrainPoints points = patch_.Points(e);
        for (const StrainPoint& p : *points) {
          expected += p.area * EnergyDensity(material.MembraneStiffness(),
                                             nu,
                                             {p.t1.dot(tensor * p.t1),
                                              p.t2.dot(tensor * p.t2),
                                              2.0 * p.t1.dot(tensor * p.t2)});
        }
      }
      EXPECT_NEAR(
          PatchEnergy<MembraneEnergy>(patch_, measure, material, patch_.Affine(a)) / expected,
          1.0,
          1e-13);
    }
  }
}

TEST_P(MembranePatchTest, EnergyDoesNotDependOnTheFrame) {
  ExpectTheSameInAnyFrame<MembraneEnergy>(patch_, material_, 0.2, 1e-13);
}

TEST_P(MembranePatchTest, EnergyDoesNotDependOnTheUnits) {
  ExpectTheSameInMillimetres<MembraneEnergy>(patch_, material_);
}

TEST_P(MembranePatchTest, TinyDisplacementsKeepTheirDigits) {
  ExpectTinyDisplacementsToKeepTheirDigits<MembraneEnergy>(patch_, material_);
}

TEST_P(MembranePatchTest, NonlinearTendsToLinear) {
  ExpectKoiterToTendToLinearKoiter<MembraneEnergy>(patch_, material_);
}

TEST_P(MembranePatchTest, BlockOfAnElementIsTheSumOfItsPoints) {
  const auto make = [this](const StrainPoints& points) {
    return MembraneEnergy(points, kNonlinear, material_, true);
  };
  ExpectABlockToBeTheSumOfItsPoints(patch_, make, 9, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Patches,
                         MembranePatchTest,
                         ::testing::ValuesIn(SamplePatches()),
                         PatchName);

TEST(MembraneEnergyTest, UniformlyStretchedPlate) {
  const LoopPatch plate = MakeLoopPatch(PlanePatch());
  Matrix3d stretch = Matrix3d::Zero();
  stretch(0, 0) = 0.2;
  const double green = 0.2 + 0.02, area = 1.2 * 0.9;
  for (const double nu : {0.3, 0.5}) {
    const Material m = SampleMaterial(nu);
    const double per_strain = 0.5 * m.young_modulus * m.thickness / (1.0 - nu * nu) * area;
    EXPECT_NEAR(PatchEnergy<MembraneEnergy>(plate, kLinear, m, plate.Affine(stretch)),
                per_strain * 0.2 * 0.2,
                1e-13 * per_strain);
    EXPECT_NEAR(PatchEnergy<MembraneEnergy>(plate, kNonlinear, m, plate.Affine(stretch)),
                per_strain * green * green,
                1e-13 * per_strain);
    // Free to contract sideways, it stores E h eps^2 / 2 (linear).
    stretch(1, 1) = -nu * 0.2;
    EXPECT_NEAR(PatchEnergy<MembraneEnergy>(plate, kLinear, m, plate.Affine(stretch)),
                0.5 * m.young_modulus * m.thickness * 0.04 * area,
                1e-13 * per_strain);
    stretch(1, 1) = 0.0;
  }
}

TEST(MembraneEnergyTest, ShearedPlate) {
  const LoopPatch plate = MakeLoopPatch(PlanePatch());
  Matrix3d shear = Matrix3d::Zero();
  shear(0, 1) = 0.1;
  const Material m = SampleMaterial(0.3);
  const double modulus = m.young_modulus / (2.0 * 1.3);  // G
  EXPECT_NEAR(PatchEnergy<MembraneEnergy>(plate, kLinear, m, plate.Affine(shear)),
              0.5 * modulus * m.thickness * 0.01 * 1.2 * 0.9,
              1e-12);
}

TEST(MembraneEnergyTest, InflatedSphere) {
  const StrainPoint point = DirectPoint(MakeSphere(0.5)->Evaluate(0.4, 0.3), 0.9);
  for (const double nu : {0.3, 0.5}) {
    const Material m = SampleMaterial(nu);
    const double lambda = 1.3, e = 0.5 * (lambda * lambda - 1.0);
    EXPECT_NEAR(
        PointEnergy(
            point, kNonlinear, m, AffineInputs(point, (lambda - 1.0) * Matrix3d::Identity())),
        m.young_modulus * m.thickness / (1.0 - nu) * e * e,  // J/m^2
        1e-11);
  }
}

TEST(MembraneEnergyTest, ReadsTheAreaOfThePoint) {
  StrainPoint point = RandomPoint(3);
  const Fifteen k = SeededUniform(15, 0.3);
  const double energy = PointEnergy(point, kNonlinear, SampleMaterial(), k);
  point.area = 0.37;
  EXPECT_NEAR(PointEnergy(point, kNonlinear, SampleMaterial(), k) / energy, 0.37, 1e-15);
}

// Constant parameter blocks come without a place for their Jacobian.
TEST(MembraneEnergyTest, SkipsTheJacobiansThatNobodyAsksFor) {
  const LoopPatch patch = MakeLoopPatch(TorusPatch());
  const MembraneEnergy cost(patch.Points(0), kNonlinear, SampleMaterial(), true);
  const VectorXd x = SeededUniform(36, 0.2);
  const Evaluation all = EvaluateAt(cost, x);
  std::vector<const double*> parameters;
  for (int i = 0; i < 12; ++i) parameters.push_back(x.data() + 3 * i);
  std::vector<double> residuals(cost.num_residuals()), jacobian(3 * cost.num_residuals());
  std::vector<double*> jacobians(12, nullptr);
  jacobians[7] = jacobian.data();
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobians.data()));
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>> block(
      jacobian.data(), cost.num_residuals(), 3);
  EXPECT_EQ(all.jacobian.middleCols(21, 3), block);
  EXPECT_EQ(all.residuals, Eigen::Map<const VectorXd>(residuals.data(), residuals.size()));
}

class MembraneJacobianTest
    : public ::testing::TestWithParam<std::tuple<StrainMeasure, double, Patch>> {};

TEST_P(MembraneJacobianTest, MatchesRiddersDifferences) {
  const auto& [measure, size, patch] = GetParam();
  const auto cost =
      std::make_unique<MembraneEnergy>(MakeLoopPatch(patch).Points(2), measure, SampleMaterial());
  EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(36, size), 1e-9));
}

INSTANTIATE_TEST_SUITE_P(DisplacementM,
                         MembraneJacobianTest,
                         ::testing::Combine(::testing::ValuesIn(AllMeasures()),
                                            ::testing::Values(0, 1e-8, 1e-2, 1, 1e2),
                                            ::testing::Values(TorusPatch(), EllipsoidPatch())));

// The matcher itself: an entry that is off by 1e-6 of its row.
class SlightlyWrong : public MembraneEnergy {
 public:
  using MembraneEnergy::MembraneEnergy;
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    if (!MembraneEnergy::Evaluate(x, residuals, jacobians)) return false;
    if (jacobians != nullptr) jacobians[4][1] += 1e-6 * std::abs(jacobians[0][0]);
    return true;
  }
};

TEST(HasCorrectJacobianAtTest, SeesASmallMistake) {
  const StrainPoints points = MakeLoopPatch(TorusPatch()).Points(2);
  for (const double size : {0.0, 1e-8, 1e-2, 1.0, 1e2}) {
    const VectorXd x = SeededUniform(36, size);
    const auto right = std::make_unique<MembraneEnergy>(points, kNonlinear, SampleMaterial());
    const auto wrong = std::make_unique<SlightlyWrong>(points, kNonlinear, SampleMaterial());
    EXPECT_THAT(right, HasCorrectJacobianAt(x, 1e-9));
    EXPECT_THAT(wrong, ::testing::Not(HasCorrectJacobianAt(x, 1e-9)));
  }
}

// ---------------------------------------------------------------------------------------------
// Tension rows

class TensionRowsTest : public ::testing::TestWithParam<Patch> {
 protected:
  MembraneEnergy Cost(bool tension_rows) const {
    return MembraneEnergy(points_, kNonlinear, material_, tension_rows);
  }

  // sum N_ab d_a.d_b dA as a quadratic form in the control displacements; only the part of N with
  // positive principal values if asked so.
  MatrixXd StressStiffness(const Matrix3Xd& displacements, bool positive_part) const {
    MatrixXd k = MatrixXd::Zero(36, 36);
    const double b = material_.MembraneStiffness(), nu = material_.poisson_ratio;
    for (const StrainPoint& p : *points_) {
      const Fifteen inputs = InputsAt(p, patch_.basis->control_vertices(1), displacements);
      const Vector3d e = MembraneStrain(kNonlinear, p, inputs);
      Eigen::Matrix2d n;
      n << e[0] + nu * e[1], 0.5 * (1.0 - nu) * e[2], 0.5 * (1.0 - nu) * e[2], e[1] + nu * e[0];
      n *= b * p.area;
      if (positive_part) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(n);
        n = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
            solver.eigenvectors().transpose();
      }
      const auto d = p.weights.middleRows<2>(kRowD1);
      const MatrixXd scalar = d.transpose() * n * d;
      for (int i = 0; i < 12; ++i) {
        for (int j = 0; j < 12; ++j) {
          k.block<3, 3>(3 * i, 3 * j) += scalar(i, j) * Matrix3d::Identity();
        }
      }
    }
    return k;
  }

  const Material material_ = SampleMaterial(0.3);
  const LoopPatch patch_ = MakeLoopPatch(GetParam());
  const StrainPoints points_ = patch_.Points(1);
};

TEST_P(TensionRowsTest, LeaveCostAndGradientAlone) {
  const VectorXd x = SeededUniform(36, 0.2);
  const Evaluation plain = EvaluateAt(Cost(false), x), rows = EvaluateAt(Cost(true), x);
  ASSERT_EQ(rows.residuals.size(), 3 * plain.residuals.size());
  for (int q = 0; q < 3; ++q) {
    EXPECT_EQ(rows.residuals.segment<3>(9 * q), plain.residuals.segment<3>(3 * q));
    EXPECT_EQ(rows.jacobian.middleRows<3>(9 * q), plain.jacobian.middleRows<3>(3 * q));
    EXPECT_EQ((rows.residuals.segment<6>(9 * q + 3).norm()), 0.0);
  }
  // The same without a Jacobian.
  EXPECT_LT((EvaluateAt(Cost(true), x, false).residuals - rows.residuals).norm(),
            1e-15 * rows.residuals.norm());
}

TEST_P(TensionRowsTest, CarryThePositivePartOfTheStress) {
  Matrix3d stretch = Matrix3d::Zero();
  stretch.diagonal() << 0.3, -0.2, 0.05;
  const Matrix3Xd states[] = {patch_.Affine(stretch),
                              patch_.Affine(SeededMatrix(0.3, 5)),
                              patch_.Affine(SeededMatrix(0.3, 6)),
                              patch_.Affine(0.2 * Matrix3d::Identity())};
  double carried = 0.0;
  for (const Matrix3Xd& u : states) {
    const VectorXd x = patch_.Parameters(1, u);
    const MatrixXd with = EvaluateAt(Cost(true), x).jacobian;
    const MatrixXd without = EvaluateAt(Cost(false), x).jacobian;
    const MatrixXd expected = StressStiffness(u, true);
    EXPECT_LT((with.transpose() * with - without.transpose() * without - expected).norm(),
              1e-13 * (with.transpose() * with).norm());
    carried += expected.norm();
  }
  EXPECT_GT(carried, 0.0);
}

// Stretched both ways, J^T J is the whole Hessian: Newton's method.
TEST_P(TensionRowsTest, GiveTheHessianWhereAllStressIsTension) {
  const Matrix3Xd u = patch_.Affine(0.2 * Matrix3d::Identity());
  const VectorXd x = patch_.Parameters(1, u);
  const MembraneEnergy cost = Cost(true);
  const MatrixXd j = EvaluateAt(cost, x).jacobian;
  const VectorXd direction = SeededUniform(36, 1.0);
  const double step = 1e-3;  // The gradient is cubic: extrapolated differences are exact.
  const auto slope = [&](double h) -> VectorXd {
    return (Gradient(cost, x + h * direction) - Gradient(cost, x - h * direction)) / (2.0 * h);
  };
  const VectorXd exact = (4.0 * slope(step) - slope(2.0 * step)) / 3.0;
  EXPECT_LT((j.transpose() * (j * direction) - exact).norm(), 1e-10 * exact.norm());
}

TEST_P(TensionRowsTest, CompressionAddsNothing) {
  const VectorXd x = patch_.Parameters(1, patch_.Affine(-0.2 * Matrix3d::Identity()));
  const MatrixXd j = EvaluateAt(Cost(true), x).jacobian;
  for (int q = 0; q < 3; ++q) EXPECT_EQ(j.middleRows<6>(9 * q + 3).norm(), 0.0);
}

TEST_P(TensionRowsTest, AreFiniteAtRest) {
  const Evaluation e = EvaluateAt(Cost(true), VectorXd::Zero(36));
  ASSERT_TRUE(e.ok);
  EXPECT_TRUE(e.jacobian.allFinite());
}

TEST_P(TensionRowsTest, LinearTheoryHasNone) {
  for (const StrainMeasure measure : {StrainMeasure::kLinearKoiter, StrainMeasure::kLinearSeed}) {
    EXPECT_EQ(MembraneEnergy(points_, measure, material_, true).num_residuals(), 9);
  }
}

INSTANTIATE_TEST_SUITE_P(Patches,
                         TensionRowsTest,
                         ::testing::Values(TorusPatch(), SpherePatch(), PlanePatch()),
                         PatchName);

// ---------------------------------------------------------------------------------------------
// Displacements on the exact surface

// The strain of a rotation falls at the rate of the fit.
TEST(ExactSurfaceTest, SpuriousEnergyOfARotationFallsFast) {
  const double coarse = SpuriousEnergyOfARotation<MembraneEnergy>(4);
  const double fine = SpuriousEnergyOfARotation<MembraneEnergy>(8);
  const double unit = SampleMaterial().MembraneStiffness();
  EXPECT_LT(coarse, 1e-6 * unit);
  EXPECT_LT(fine, coarse / 30.0);  // strain of third order: energy of sixth, 1 / 64
}

}  // namespace
}  // namespace darboux
