// Where the formulas of Tian & Jia (2010), as printed, must not be copied: shown on the kernels
// that the solver uses. tests/invariant_strains_test.cc has the same on the paper's own formulas.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <vector>

#include "costs/bending_energy.h"
#include "costs/membrane_energy.h"
#include "costs/strain_measures.h"
#include "geometry/invariant_strains.h"
#include "geometry/surface_invariants.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr StrainMeasure kSeed = StrainMeasure::kNonlinearSeed;

// The same point and displacement for the kernels and for the paper's formulas: the frame of the
// invariants, the affine displacement A x.
struct Both {
  Both(const SurfaceJet& jet, const Matrix3d& a)
      : invariants(*EvaluateSurfaceInvariants(jet)),
        displacement{a * jet.x, a * jet.x_u, a * jet.x_v, a * jet.x_uu, a * jet.x_uv, a * jet.x_vv},
        point(DirectPoint(jet)) {
    point.t1 = invariants.t1;
    point.t2 = invariants.t2;
    point.b11 = invariants.b(0, 0);
    point.b12 = invariants.b(0, 1);
    point.b22 = invariants.b(1, 1);
    inputs = AffineInputs(point, a);
  }

  SurfaceInvariants invariants;
  DisplacementJet displacement;
  StrainPoint point;
  Fifteen inputs;
};

class ErrataTest : public ::testing::TestWithParam<Patch> {
 protected:
  ErrataTest() {
    const auto& u = GetParam().domain.u_range;
    const auto& v = GetParam().domain.v_range;
    for (const double f : {0.15, 0.4, 0.85}) {
      jets_.push_back(
          GetParam().surface->Evaluate(u[0] + f * (u[1] - u[0]), v[1] - 0.9 * f * (v[1] - v[0])));
    }
  }

  std::vector<SurfaceJet> jets_;
};

TEST_P(ErrataTest, LinearKernelIsThePapersFormula) {
  for (const SurfaceJet& jet : jets_) {
    const Both both(jet, SeededMatrix(0.5, 31));
    const LinearInvariantStrains e = EvaluateLinearInvariantStrains(
        both.invariants, EvaluateComponents(both.invariants, both.displacement));
    const Vector3d membrane(e.eps_1, e.eps_2, e.omega_1 + e.omega_2);
    EXPECT_LT(
        (MembraneStrain(StrainMeasure::kLinearSeed, both.point, both.inputs) - membrane).norm(),
        1e-13);
    // The paper counts bending the other way.
    const Vector3d bending(-e.zeta_1, -e.zeta_2, -e.tau);
    EXPECT_LT((BendingStrain(StrainMeasure::kLinearSeed, both.point, both.inputs) - bending).norm(),
              1e-12);
  }
}

// Item 1: (46)-(54) need omega_1 and omega_2 the other way round.
TEST_P(ErrataTest, NonlinearKernelIsThePapersFormulaWithTheOmegasExchanged) {
  double largest_as_printed = 0.0;
  for (const SurfaceJet& jet : jets_) {
    const Both both(jet, SeededMatrix(0.5, 32));
    const Vector3d membrane = MembraneStrain(kSeed, both.point, both.inputs);
    const Vector3d bending = BendingStrain(kSeed, both.point, both.inputs);
    const NonlinearInvariantStrains e =
        EvaluateNonlinearInvariantStrains(both.invariants, both.displacement);
    EXPECT_LT((membrane - Vector3d(e.eps_11, e.eps_22, e.eps_12)).norm(), 1e-13);
    EXPECT_LT((bending + Vector3d(e.zeta_11, e.zeta_22, e.zeta_12)).norm(), 1e-12);
    const NonlinearInvariantStrains printed = EvaluateNonlinearInvariantStrains(
        both.invariants, both.displacement, OmegaConvention::kAsPrinted);
    largest_as_printed =
        std::max(largest_as_printed,
                 (membrane - Vector3d(printed.eps_11, printed.eps_22, printed.eps_12)).norm());
  }
  EXPECT_GT(largest_as_printed, 1e-2);
}

// Item 2: under a rotation R the bending strain of nonlinear_seed is -sym(d b), d_ij = d_i.t_j; in
// the principal frame -kappa_1 eps_1, -kappa_2 eps_2, -(kappa_2 omega_1 + kappa_1 omega_2).
TEST_P(ErrataTest, RotationLeavesTheStatedBendingStrain) {
  for (const double angle : {1e-6, 0.5, 3.0}) {
    for (const SurfaceJet& jet : jets_) {
      const Both both(jet, SkewRotation(angle) - Matrix3d::Identity());
      const StrainPoint& p = both.point;
      const Vector3d d1 = both.inputs.segment<3>(0), d2 = both.inputs.segment<3>(3);
      Matrix2d d, b;
      d << d1.dot(p.t1), d1.dot(p.t2), d2.dot(p.t1), d2.dot(p.t2);
      b << p.b11, p.b12, p.b12, p.b22;
      const Matrix2d remainder = -d * b;
      EXPECT_LT((BendingStrain(kSeed, p, both.inputs) -
                 Vector3d(remainder(0, 0), remainder(1, 1), remainder(0, 1) + remainder(1, 0)))
                    .norm(),
                1e-13);
      // What the code offers instead.
      EXPECT_LT(BendingStrain(StrainMeasure::kKoiter, p, both.inputs).norm(), 1e-13);
    }
  }
}

// In energies: per area at most B h^2 / 12 kappa^2 angle^2, next to nothing in a thin shell but not
// nothing; a patch of the solver's blocks, rotated exactly.
TEST_P(ErrataTest, RotatedPatchStoresBendingEnergyInTheSeedTheoryOnly) {
  const LoopPatch patch = MakeLoopPatch(GetParam());
  const Material material = SampleMaterial();
  const auto energy = [&](StrainMeasure measure, double angle) {
    double sum = 0.0;
    for (int e = 0; e < patch.mesh.num_elements; ++e) {
      sum += Energy(BendingEnergy(patch.Points(e), measure, material),
                    patch.Parameters(e, patch.RigidMotion(angle)));
    }
    return sum;
  };
  const double unit = material.BendingStiffness() * patch.Area();
  EXPECT_LT(energy(StrainMeasure::kKoiter, 0.5), 1e-25 * unit);
  if (GetParam().name == "plane") {
    EXPECT_LT(energy(kSeed, 0.5), 1e-25 * unit);
    return;
  }
  EXPECT_GT(energy(kSeed, 0.5), 1e-3 * unit);
  // omega has the size of the angle, eps that of its square: where kappa_1 = kappa_2 the energy
  // starts with the fourth power, elsewhere with the second.
  const double growth = energy(kSeed, 1e-2) / energy(kSeed, 1e-3);
  if (GetParam().name != "sphere") {
    EXPECT_NEAR(growth, 1e2, 1.0);
  } else {
    EXPECT_GT(growth, 1e2);  // A Loop surface through it is not quite a sphere.
  }
}

INSTANTIATE_TEST_SUITE_P(Patches, ErrataTest, ::testing::ValuesIn(SamplePatches()), PatchName);

// With kappa_1 = kappa_2 exactly.
TEST(ErrataSphereTest, RotationIsStrainedInTheSecondOrder) {
  const StrainPoint point = DirectPoint(MakeSphere(1.2)->Evaluate(0.4, 0.3), 0.9);
  const double small = BendingStrain(kSeed, point, RotationInputs(point, 1e-3)).norm();
  const double large = BendingStrain(kSeed, point, RotationInputs(point, 1e-2)).norm();
  EXPECT_NEAR(large / small, 100.0, 0.1);
}

}  // namespace
}  // namespace darboux
