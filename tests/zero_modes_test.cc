// What a free shell must not resist: the six rigid motions and nothing else.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "costs/bending_energy.h"
#include "costs/membrane_energy.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Membrane and bending residuals of all elements and their Jacobian by all control displacements.
Evaluation Assemble(const LoopPatch& patch,
                    StrainMeasure measure,
                    const Material& material,
                    const Matrix3Xd& displacements) {
  const int elements = patch.mesh.num_elements;
  Evaluation sum;
  sum.residuals = VectorXd::Zero(18 * elements);
  sum.jacobian = MatrixXd::Zero(18 * elements, displacements.size());
  for (int e = 0; e < elements; ++e) {
    const StrainPoints points = patch.Points(e);
    const VectorXd x = patch.Parameters(e, displacements);
    const Evaluation blocks[2] = {EvaluateAt(MembraneEnergy(points, measure, material), x),
                                  EvaluateAt(BendingEnergy(points, measure, material), x)};
    const std::vector<int>& vertices = patch.basis->control_vertices(e);
    for (int k = 0; k < 2; ++k) {
      EXPECT_TRUE(blocks[k].ok);
      const int row = 18 * e + 9 * k;
      sum.residuals.segment<9>(row) = blocks[k].residuals;
      for (size_t i = 0; i < vertices.size(); ++i) {
        sum.jacobian.block<9, 3>(row, 3 * vertices[i]) = blocks[k].jacobian.middleCols<3>(3 * i);
      }
    }
  }
  return sum;
}

// Eigenvalues of J^T J relative to the largest, ascending; by way of J, which keeps all digits.
VectorXd Eigenvalues(const MatrixXd& jacobian) {
  const Eigen::BDCSVD<MatrixXd> svd(jacobian);
  const VectorXd squares = svd.singularValues().cwiseAbs2();
  return (squares / squares[0]).reverse();
}

// The six infinitesimal motions of the control vertices at x as columns.
MatrixXd RigidModes(const Matrix3Xd& x) {
  MatrixXd modes(x.size(), 6);
  for (int k = 0; k < 3; ++k) {
    const Matrix3Xd turn = CrossMatrix(Vector3d::Unit(k)) * x;
    const Matrix3Xd shift = Vector3d::Unit(k) * Eigen::RowVectorXd::Ones(x.cols());
    modes.col(k) = Eigen::Map<const VectorXd>(shift.data(), shift.size());
    modes.col(3 + k) = Eigen::Map<const VectorXd>(turn.data(), turn.size());
  }
  return modes;
}

Material ThickMaterial() {
  Material material = SampleMaterial(0.3);
  material.thickness = 0.1;
  return material;
}

class ZeroModesTest : public ::testing::TestWithParam<Patch> {
 protected:
  static LoopPatch FourByFour() {
    Patch patch = GetParam();
    patch.domain.divisions = {4, 4};
    return MakeLoopPatch(patch);
  }

  // 16 cells, 47 control vertices with the ghost ring.
  const LoopPatch patch_ = FourByFour();
  const Material material_ = ThickMaterial();
  const Matrix3Xd rest_ = Matrix3Xd::Zero(3, patch_.positions.cols());
};

TEST_P(ZeroModesTest, FreeLinearKoiterShellHasExactlySix) {
  const MatrixXd j = Assemble(patch_, StrainMeasure::kLinearKoiter, material_, rest_).jacobian;
  ASSERT_EQ(j.cols(), 3 * 47);
  const VectorXd lambda = Eigenvalues(j);
  EXPECT_LT(lambda[5], 1e-24);
  EXPECT_GT(lambda[6], 1e-10) << lambda.head<10>().transpose();
  EXPECT_LT((j * RigidModes(patch_.positions)).norm(), 1e-12 * j.norm());
}

TEST_P(ZeroModesTest, SmallestEigenvaluesOfTheHessianAreSixZeros) {
  const MatrixXd j = Assemble(patch_, StrainMeasure::kLinearKoiter, material_, rest_).jacobian;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(j.transpose() * j, Eigen::EigenvaluesOnly);
  const VectorXd lambda = solver.eigenvalues() / solver.eigenvalues().tail<1>()[0];
  EXPECT_LT(lambda.head<6>().cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(lambda[6], 1e2 * lambda.head<6>().cwiseAbs().maxCoeff());
}

TEST_P(ZeroModesTest, KoiterAtRestIsLinearKoiter) {
  const Evaluation koiter = Assemble(patch_, StrainMeasure::kKoiter, material_, rest_);
  const MatrixXd linear = Assemble(patch_, StrainMeasure::kLinearKoiter, material_, rest_).jacobian;
  EXPECT_EQ(koiter.residuals.norm(), 0.0);
  EXPECT_LT((koiter.jacobian - linear).norm(), 1e-15 * linear.norm());
}

TEST_P(ZeroModesTest, FreeKoiterShellMovedFarHasNoForceAndTheSameEigenvalues) {
  const Matrix3Xd moved = patch_.RigidMotion(2.0);
  const MatrixXd at_rest = Assemble(patch_, StrainMeasure::kKoiter, material_, rest_).jacobian;
  const Evaluation e = Assemble(patch_, StrainMeasure::kKoiter, material_, moved);
  EXPECT_LT((e.jacobian.transpose() * e.residuals).norm(), 1e-13 * at_rest.squaredNorm());
  const VectorXd before = Eigenvalues(at_rest), after = Eigenvalues(e.jacobian);
  EXPECT_LT(after[5], 1e-24);
  EXPECT_LT((after.tail(after.size() - 6).array() / before.tail(after.size() - 6).array() - 1.0)
                .abs()
                .maxCoeff(),
            1e-6);
  // The modes are the motions of the moved shell.
  EXPECT_LT((e.jacobian * RigidModes(patch_.positions + moved)).norm(), 1e-12 * at_rest.norm());
}

// Forces of a deformed shell add up to nothing, nor have they a moment.
TEST_P(ZeroModesTest, InnerForcesAreInEquilibrium) {
  const Matrix3Xd deformed = patch_.RandomField(0.02);
  const Evaluation e = Assemble(patch_, StrainMeasure::kKoiter, material_, deformed);
  const VectorXd force = e.jacobian.transpose() * e.residuals;
  EXPECT_GT(force.norm(), 1.0);
  EXPECT_LT((RigidModes(patch_.positions + deformed).transpose() * force).norm(),
            1e-12 * force.norm());
}

// The paper's linear theory resists rotations about the normal where the curvatures differ.
TEST_P(ZeroModesTest, FreeLinearSeedShellHasThreeTranslationsAndWhatLoveLeaves) {
  const MatrixXd j = Assemble(patch_, StrainMeasure::kLinearSeed, material_, rest_).jacobian;
  const VectorXd lambda = Eigenvalues(j);
  EXPECT_LT(lambda[2], 1e-24);
  const double rotations = (j * RigidModes(patch_.positions).rightCols<3>()).norm() / j.norm();
  if (GetParam().name == "plane") {
    EXPECT_LT(lambda[5], 1e-24);
  } else if (GetParam().name != "sphere") {
    EXPECT_GT(lambda[5], 1e-20);
    EXPECT_GT(rotations, 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Patches, ZeroModesTest, ::testing::ValuesIn(SamplePatches()), PatchName);

// Closed, with vertices of valence five.
TEST(ClosedZeroModesTest, BallHasExactlySix) {
  const LoopPatch ball = MakeIcosphere(1.0, 1);
  const MatrixXd j = Assemble(ball,
                              StrainMeasure::kLinearKoiter,
                              ThickMaterial(),
                              Matrix3Xd::Zero(3, ball.positions.cols()))
                         .jacobian;
  const VectorXd lambda = Eigenvalues(j);
  EXPECT_LT(lambda[5], 1e-20);
  EXPECT_GT(lambda[6], 1e-6);
}

TEST(ClosedZeroModesTest, TorusHasExactlySix) {
  const LoopPatch torus = MakeClosedTorus(1.0, 0.4, 6, 5);
  const MatrixXd j = Assemble(torus,
                              StrainMeasure::kLinearKoiter,
                              ThickMaterial(),
                              Matrix3Xd::Zero(3, torus.positions.cols()))
                         .jacobian;
  const VectorXd lambda = Eigenvalues(j);
  EXPECT_LT(lambda[5], 1e-24);
  EXPECT_GT(lambda[6], 1e-8);
}

}  // namespace
}  // namespace darboux
