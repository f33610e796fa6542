// Patch tests: fields of constant strain on plates whose lattices are even, graded, sheared and
// curved in the plane. Affine displacements are quadratic functions of the lattice coordinates at
// most, hence in the Loop space on all of them; constant curvatures are where the map is affine.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "costs/bending_energy.h"
#include "costs/membrane_energy.h"
#include "geometry/shell_surface.h"
#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Patch EvenPlate() { return MakePatch("even", MakePlane(), {0.0, 1.2}, {0.0, 0.9}, {4, 3}); }

Patch GradedPlate() {
  Patch plate = EvenPlate();
  plate.name = "graded";
  plate.domain.grading = {0.8, -0.5};
  return plate;
}

Patch ExpressionPlate(const std::string& name, const std::array<std::string, 3>& xyz) {
  std::string error;
  std::shared_ptr<const ParametricSurface> surface = MakeExpressionSurface(xyz, &error);
  EXPECT_NE(surface, nullptr) << error;
  return MakePatch(name, std::move(surface), {0.0, 1.2}, {0.0, 0.9}, {4, 3});
}

Patch CurvedPlate() {
  return ExpressionPlate("curved_lines", {"u + 0.2*u*v + 0.1*v^2", "v - 0.15*u^2", "0"});
}

// The plane is an affine function of the lattice coordinates.
std::vector<Patch> AffinePlates() {
  return {EvenPlate(),
          ExpressionPlate("sheared", {"u + 0.6*v", "0.9*v - 0.2*u", "0"}),
          // In a plane askew to the axes, so that no component is zero.
          ExpressionPlate("skew", {"0.6*u", "0.8*u", "v + 0.3*u"})};
}

std::vector<Patch> AllPlates() {
  std::vector<Patch> plates = AffinePlates();
  plates.push_back(GradedPlate());
  plates.push_back(CurvedPlate());
  return plates;
}

class PlatePatchTest : public ::testing::TestWithParam<Patch> {
 protected:
  const ShellSurface shell_{GetParam().surface, GetParam().domain};
  const Material material_ = SampleMaterial(0.3);

  // Calls visit(point, fifteen numbers) at all quadrature points.
  void ForEachPoint(const Matrix3Xd& displacements,
                    const std::function<void(const StrainPoint&, const Fifteen&)>& visit) const {
    for (int e = 0; e < shell_.num_elements(); ++e) {
      const std::vector<StrainPoint> points = shell_.QuadraturePoints(e, 3);
      for (const StrainPoint& point : points) {
        visit(point, InputsAt(point, shell_.control_vertices(e), displacements));
      }
    }
  }

  template <typename Cost>
  double TotalEnergy(StrainMeasure measure, const Matrix3Xd& displacements) const {
    double energy = 0.0;
    for (int e = 0; e < shell_.num_elements(); ++e) {
      const auto points = std::make_shared<std::vector<StrainPoint>>(shell_.QuadraturePoints(e, 3));
      const std::vector<int>& vertices = shell_.control_vertices(e);
      VectorXd x(3 * vertices.size());
      for (size_t i = 0; i < vertices.size(); ++i) {
        x.segment<3>(3 * i) = displacements.col(vertices[i]);
      }
      energy += Energy(Cost(points, measure, material_), x);
    }
    return energy;
  }

  // Sum of the quadrature weights times area elements: polynomials on these plates.
  double Area() const {
    double area = 0.0;
    ForEachPoint(Matrix3Xd::Zero(3, shell_.mesh().num_vertices),
                 [&](const StrainPoint& point, const Fifteen&) { area += point.area; });
    return area;
  }
};

TEST_P(PlatePatchTest, AffineDisplacementHasConstantMembraneStrain) {
  const Matrix3d a = SeededMatrix(0.3, 41);
  const Matrix3Xd u = FitField(
      shell_, [&](const Vector3d& x) -> Vector3d { return a * x + Vector3d(0.1, -0.2, 0.3); });
  const Matrix3d linear = 0.5 * (a + a.transpose());
  const Matrix3d green = linear + 0.5 * a.transpose() * a;
  ForEachPoint(u, [&](const StrainPoint& p, const Fifteen& k) {
    for (const StrainMeasure measure : AllMeasures()) {
      const Matrix3d& tensor = IsLinear(measure) ? linear : green;
      const Vector3d expected(
          p.t1.dot(tensor * p.t1), p.t2.dot(tensor * p.t2), 2.0 * p.t1.dot(tensor * p.t2));
      EXPECT_LT((MembraneStrain(measure, p, k) - expected).norm(), 1e-12);
      EXPECT_LT(BendingStrain(measure, p, k).norm(), 1e-11);
    }
  });
}

TEST_P(PlatePatchTest, AffineDisplacementHasTheExactEnergy) {
  const Matrix3d a = SeededMatrix(0.3, 42);
  const Matrix3Xd u = FitField(shell_, [&](const Vector3d& x) -> Vector3d { return a * x; });
  const Matrix3d green = 0.5 * (a + a.transpose() + a.transpose() * a);
  // Any frame of the plane will do.
  const StrainPoint p = shell_.QuadraturePoints(0, 1).front();
  const Vector3d strain(
      p.t1.dot(green * p.t1), p.t2.dot(green * p.t2), 2.0 * p.t1.dot(green * p.t2));
  const double expected = Area() * EnergyDensity(material_.MembraneStiffness(), 0.3, strain);
  EXPECT_NEAR(TotalEnergy<MembraneEnergy>(StrainMeasure::kKoiter, u) / expected, 1.0, 1e-11);
  EXPECT_LT(TotalEnergy<BendingEnergy>(StrainMeasure::kKoiter, u), 1e-20 * expected);
}

TEST_P(PlatePatchTest, RigidMotionOfAPlateIsInTheSpace) {
  const Matrix3Xd u = FitRigidMotion(shell_, 2.0);
  const double unit = material_.MembraneStiffness() * Area();
  EXPECT_LT(TotalEnergy<MembraneEnergy>(StrainMeasure::kKoiter, u), 1e-24 * unit);
  EXPECT_LT(TotalEnergy<BendingEnergy>(StrainMeasure::kKoiter, u), 1e-24 * unit);
}

// Elsewhere x^2 is of fourth order in the lattice coordinates.
class AffineLatticeTest : public PlatePatchTest {};

TEST_P(AffineLatticeTest, QuadraticDeflectionHasConstantCurvature) {
  const Matrix3d c = [] {
    const Matrix3d m = SeededMatrix(0.5, 43);
    return Matrix3d(m + m.transpose());
  }();
  const Vector3d n = shell_.QuadraturePoints(0, 1).front().n;
  const Matrix3Xd u =
      FitField(shell_, [&](const Vector3d& x) -> Vector3d { return 0.5 * x.dot(c * x) * n; });
  Vector3d strain;
  ForEachPoint(u, [&](const StrainPoint& p, const Fifteen& k) {
    strain << p.t1.dot(c * p.t1), p.t2.dot(c * p.t2), 2.0 * p.t1.dot(c * p.t2);
    EXPECT_LT((BendingStrain(StrainMeasure::kLinearKoiter, p, k) - strain).norm(), 1e-11);
    EXPECT_LT((BendingStrain(StrainMeasure::kLinearSeed, p, k) - strain).norm(), 1e-11);
    EXPECT_LT(MembraneStrain(StrainMeasure::kLinearKoiter, p, k).norm(), 1e-12);
  });
  const double expected = Area() * EnergyDensity(material_.BendingStiffness(), 0.3, strain);
  EXPECT_NEAR(TotalEnergy<BendingEnergy>(StrainMeasure::kLinearKoiter, u) / expected, 1.0, 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Plates, PlatePatchTest, ::testing::ValuesIn(AllPlates()), PatchName);
INSTANTIATE_TEST_SUITE_P(Plates, AffineLatticeTest, ::testing::ValuesIn(AffinePlates()), PatchName);

// Where the lattice is not affine the curvature of w = x^2 / 2 converges, its error at second order
// of the cells at least.
class CurvedLatticeTest : public ::testing::TestWithParam<Patch> {};

TEST_P(CurvedLatticeTest, ConstantCurvatureConverges) {
  const auto worst = [&](int refinement) {
    Patch patch = GetParam();
    patch.domain.divisions = {3 * refinement, 2 * refinement};
    const ShellSurface shell(patch.surface, patch.domain);
    const Matrix3Xd u = FitField(shell, [](const Vector3d& x) -> Vector3d {
      return 0.5 * x.x() * x.x() * Vector3d::UnitZ();
    });
    double squared = 0.0;
    for (int e = 0; e < shell.num_elements(); ++e) {
      for (const StrainPoint& p : shell.QuadraturePoints(e, 3)) {
        const Vector3d expected(
            p.t1.x() * p.t1.x(), p.t2.x() * p.t2.x(), 2.0 * p.t1.x() * p.t2.x());
        squared += p.area * (BendingStrain(StrainMeasure::kLinearKoiter,
                                           p,
                                           InputsAt(p, shell.control_vertices(e), u)) -
                             expected)
                                .squaredNorm();
      }
    }
    return std::sqrt(squared);
  };
  const double coarse = worst(1), fine = worst(3);
  EXPECT_LT(coarse, 0.1);
  EXPECT_GT(std::log(coarse / fine) / std::log(3.0), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Plates,
                         CurvedLatticeTest,
                         ::testing::Values(GradedPlate(), CurvedPlate()),
                         PatchName);

}  // namespace
}  // namespace darboux
