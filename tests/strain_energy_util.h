#ifndef DARBOUX_TESTS_STRAIN_ENERGY_UTIL_H_
#define DARBOUX_TESTS_STRAIN_ENERGY_UTIL_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <vector>

#include "geometry/shell_surface.h"
#include "tests/test_util.h"

// What is true of membrane and of bending energy alike. Cost: MembraneEnergy or BendingEnergy;
// fields are random displacements of this size, m.

namespace darboux {

template <typename Cost>
void ExpectTheSameInAnyFrame(const LoopPatch& patch,
                             const Material& material,
                             double field,
                             double tolerance) {
  const Eigen::Matrix3Xd x = patch.RandomField(field);
  for (const StrainMeasure measure : AllMeasures()) {
    const double energy = PatchEnergy<Cost>(patch, measure, material, x);
    for (const double turn : {0.4, 1.9, 4.0}) {
      EXPECT_NEAR(PatchEnergy<Cost>(patch, measure, material, x, turn) / energy, 1.0, tolerance);
    }
  }
}

// In millimetres, newtons and N/mm^2 the energy comes out in N mm.
template <typename Cost>
void ExpectTheSameInMillimetres(const LoopPatch& patch, const Material& material) {
  LoopPatch millimetres = patch;
  millimetres.positions *= 1e3;
  Material in_millimetres = material;
  in_millimetres.thickness *= 1e3;
  in_millimetres.young_modulus *= 1e-6;
  const Eigen::Matrix3Xd x = patch.RandomField(0.1);
  for (const StrainMeasure measure : AllMeasures()) {
    EXPECT_NEAR(1e-3 * PatchEnergy<Cost>(millimetres, measure, in_millimetres, 1e3 * x) /
                    PatchEnergy<Cost>(patch, measure, material, x),
                1.0,
                1e-14);
  }
}

// Displacements of 1e-9 of the size: the difference of the energies of u and -u is of third order,
// their mean is the linear theory's to 1e-16. From positions seven digits would be left.
template <typename Cost>
void ExpectTinyDisplacementsToKeepTheirDigits(const LoopPatch& patch, const Material& material) {
  const Eigen::Matrix3Xd x = patch.RandomField(1.0);
  const double linear = PatchEnergy<Cost>(patch, StrainMeasure::kLinearKoiter, material, x);
  const double size = 1e-9;
  const double up = PatchEnergy<Cost>(patch, StrainMeasure::kKoiter, material, size * x);
  const double down = PatchEnergy<Cost>(patch, StrainMeasure::kKoiter, material, -size * x);
  EXPECT_NEAR(0.5 * (up + down) / (size * size) / linear, 1.0, 1e-13);
}

template <typename Cost>
void ExpectKoiterToTendToLinearKoiter(const LoopPatch& patch, const Material& material) {
  const Eigen::Matrix3Xd x = patch.RandomField(1.0);
  const double linear = PatchEnergy<Cost>(patch, StrainMeasure::kLinearKoiter, material, x);
  const auto difference = [&](double size) {
    return std::abs(PatchEnergy<Cost>(patch, StrainMeasure::kKoiter, material, size * x) /
                        (size * size) / linear -
                    1.0);
  };
  EXPECT_NEAR(std::log10(difference(1e-4) / difference(1e-6)), 2.0, 0.05);
}

// make(points): the cost of these points; rows: residuals of each.
template <typename MakeCost>
void ExpectABlockToBeTheSumOfItsPoints(const LoopPatch& patch,
                                       const MakeCost& make,
                                       int rows,
                                       double field) {
  const StrainPoints points = patch.Points(3, 6);
  const Eigen::VectorXd x = SeededUniform(36, field);
  const Evaluation block = EvaluateAt(make(points), x);
  ASSERT_EQ(block.residuals.size(), rows * 6);
  for (int q = 0; q < 6; ++q) {
    const auto point = std::make_shared<std::vector<StrainPoint>>(1, (*points)[q]);
    const Evaluation single = EvaluateAt(make(point), x);
    EXPECT_EQ(block.residuals.segment(rows * q, rows), single.residuals);
    EXPECT_EQ(block.jacobian.middleRows(rows * q, rows), single.jacobian);
  }
}

// On the exact surface rotations are in the space only approximately: what a torus of so many cells
// a side stores under one, J.
template <typename Cost>
double SpuriousEnergyOfARotation(int divisions) {
  Patch patch = TorusPatch();
  patch.domain.divisions = {divisions, divisions};
  const ShellSurface shell(patch.surface, patch.domain);
  const Eigen::Matrix3Xd u = FitRigidMotion(shell, 0.7);
  double sum = 0.0;
  for (int e = 0; e < shell.num_elements(); ++e) {
    const auto points = std::make_shared<std::vector<StrainPoint>>(shell.QuadraturePoints(e, 3));
    Eigen::VectorXd x(36);
    for (int i = 0; i < 12; ++i) x.segment<3>(3 * i) = u.col(shell.control_vertices(e)[i]);
    sum += Energy(Cost(points, StrainMeasure::kKoiter, SampleMaterial()), x);
  }
  return sum;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_STRAIN_ENERGY_UTIL_H_
