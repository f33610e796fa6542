#include "costs/strain_measures.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Membrane and bending strains together.
Vector6d Strains(StrainMeasure measure, const StrainPoint& point, const Fifteen& k) {
  Vector6d e;
  e << MembraneStrain(measure, point, k), BendingStrain(measure, point, k);
  return e;
}

Vector3d Curvatures(const StrainPoint& point) { return {point.b11, point.b22, 2.0 * point.b12}; }

// Radii of the sample points go down to 0.3 m.
double CurvatureScale(const StrainPoint& point) { return 1.0 + Curvatures(point).norm(); }

class EveryMeasureTest : public ::testing::TestWithParam<StrainMeasure> {};

TEST_P(EveryMeasureTest, IsZeroAtRest) {
  for (const StrainPoint& point : SamplePoints()) {
    EXPECT_EQ(Strains(GetParam(), point, Fifteen::Zero()).norm(), 0.0);
  }
}

TEST_P(EveryMeasureTest, IsATensor) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const StrainPoint point = RandomPoint(seed);
    const Fifteen k = SeededUniform(15, 0.4, seed + 50);
    const Vector3d membrane = MembraneStrain(GetParam(), point, k);
    const Vector3d bending = BendingStrain(GetParam(), point, k);
    for (const double angle : {0.3, M_PI / 2.0, 2.5}) {
      const double c = std::cos(angle), s = std::sin(angle);
      const auto d1 = k.segment<3>(0), d2 = k.segment<3>(3);
      const auto h11 = k.segment<3>(6), h12 = k.segment<3>(9), h22 = k.segment<3>(12);
      StrainPoint turned = point;
      turned.t1 = c * point.t1 + s * point.t2;
      turned.t2 = c * point.t2 - s * point.t1;
      const Vector3d b = TurnedStrain(Curvatures(point), angle);
      turned.b11 = b[0];
      turned.b22 = b[1];
      turned.b12 = 0.5 * b[2];
      Fifteen l;
      l << c * d1 + s * d2, c * d2 - s * d1, c * c * h11 + 2.0 * c * s * h12 + s * s * h22,
          c * s * (h22 - h11) + (c * c - s * s) * h12,
          s * s * h11 - 2.0 * c * s * h12 + c * c * h22;
      EXPECT_LT((MembraneStrain(GetParam(), turned, l) - TurnedStrain(membrane, angle)).norm(),
                2e-15);
      EXPECT_LT((BendingStrain(GetParam(), turned, l) - TurnedStrain(bending, angle)).norm(),
                5e-15);
    }
  }
}

// The part that is odd in the displacement is its linearisation up to the third order. From
// positions, strains of displacements of 1e-9 would keep seven digits.
TEST_P(EveryMeasureTest, TinyDisplacementsKeepTheirDigits) {
  const StrainMeasure linear = GetParam() == StrainMeasure::kLinearSeed
                                   ? StrainMeasure::kLinearSeed
                                   : StrainMeasure::kLinearKoiter;
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen direction = SeededUniform(15, 1.0, 61);
    const Vector3d membrane = MembraneStrain(linear, point, direction);
    Vector3d bending = BendingStrain(linear, point, direction);
    if (GetParam() == StrainMeasure::kNonlinearSeed) {
      bending = BendingStrain(StrainMeasure::kLinearSeed, point, direction) +
                Curvatures(point) * (membrane[0] + membrane[1]);
    }
    for (const double size : {1e-9, 1e-12}) {
      const Vector6d odd = 0.5 / size *
                           (Strains(GetParam(), point, size * direction) -
                            Strains(GetParam(), point, -size * direction));
      EXPECT_LT((odd.head<3>() - membrane).norm(), 1e-14 * membrane.norm());
      EXPECT_LT((odd.tail<3>() - bending).norm(), 1e-14 * (bending.norm() + CurvatureScale(point)));
    }
  }
}

// Values alone and values with derivatives are two instantiations of one template.
TEST_P(EveryMeasureTest, JetsCarryTheValues) {
  using Jet = ceres::Jet<double, 15>;
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen k = SeededUniform(15, 0.3, 62);
    std::array<Jet, 15> jets;
    for (int i = 0; i < 15; ++i) jets[i] = Jet(k[i], i);
    std::array<Jet, 3> membrane, bending;
    EvaluateMembraneStrain(GetParam(), point, jets.data(), membrane.data());
    ASSERT_TRUE(EvaluateBendingStrain(GetParam(), point, jets.data(), bending.data()));
    const Vector6d e = Strains(GetParam(), point, k);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(membrane[i].a, e[i], 1e-15);
      EXPECT_NEAR(bending[i].a, e[3 + i], 1e-15 * CurvatureScale(point));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Measures,
                         EveryMeasureTest,
                         ::testing::ValuesIn(AllMeasures()),
                         [](const auto& info) { return Name(info.param); });

class RigidMotionTest : public ::testing::TestWithParam<double> {};  // angle, rad

TEST_P(RigidMotionTest, HasNoKoiterStrain) {
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen k = RotationInputs(point, GetParam());
    EXPECT_LT(MembraneStrain(StrainMeasure::kKoiter, point, k).norm(), 1e-15);
    EXPECT_LT(BendingStrain(StrainMeasure::kKoiter, point, k).norm(),
              2e-15 * CurvatureScale(point));
  }
}

TEST_P(RigidMotionTest, DoesNotChangeTheKoiterStrainOfADeformation) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const StrainPoint point = RandomPoint(seed);
    const Fifteen k = SeededUniform(15, 0.4, seed + 70);
    // x -> R x: d -> R d + (R - I) t, H -> R H + (R - I) b n.
    const Matrix3d r = SkewRotation(GetParam());
    Fifteen turned = RotationInputs(point, GetParam());
    for (int i = 0; i < 5; ++i) turned.segment<3>(3 * i) += r * k.segment<3>(3 * i);
    EXPECT_LT(
        (Strains(StrainMeasure::kKoiter, point, turned) - Strains(StrainMeasure::kKoiter, point, k))
            .norm(),
        1e-14);
  }
}

INSTANTIATE_TEST_SUITE_P(AngleRad, RigidMotionTest, ::testing::Values(1e-9, 1e-4, 0.5, 1.5, 3.0));

TEST(LinearMeasuresTest, AreBlindToInfinitesimalRigidMotionButForLovesDefect) {
  const Vector3d spin(0.3, -0.5, 0.7);
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen k = AffineInputs(point, CrossMatrix(spin));
    EXPECT_LT(Strains(StrainMeasure::kLinearKoiter, point, k).norm(),
              2e-15 * CurvatureScale(point));
    // zeta, tau feel the rotation about n: in the principal frame only tau, as kappa_1 - kappa_2.
    const double about_n = spin.dot(point.n);
    const Vector3d defect(
        -point.b12 * about_n, point.b12 * about_n, (point.b11 - point.b22) * about_n);
    EXPECT_LT((BendingStrain(StrainMeasure::kLinearSeed, point, k) - defect).norm(),
              2e-15 * CurvatureScale(point));
    // Its size in the principal frame.
    const double difference =
        std::hypot(point.b11 - point.b22, 2.0 * point.b12);  // kappa_1 - kappa_2
    EXPECT_NEAR(std::hypot(defect[0] - defect[1], defect[2]),
                std::abs(about_n) * difference,
                1e-14 * CurvatureScale(point));
  }
}

// Finite rotations are strained in the second order.
TEST(LinearMeasuresTest, StrainOfAFiniteRotationGrowsWithItsSquare) {
  for (const StrainPoint& point : SamplePoints()) {
    const Vector6d small =
        Strains(StrainMeasure::kLinearKoiter, point, RotationInputs(point, 1e-4));
    const Vector6d large =
        Strains(StrainMeasure::kLinearKoiter, point, RotationInputs(point, 1e-3));
    EXPECT_NEAR(large.norm() / small.norm(), 100.0, 0.1);
  }
}

// Koiter and linear Koiter differ by a term that is quadratic in the displacement.
TEST(LimitTest, KoiterTendsToItsLinearisation) {
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen direction = SeededUniform(15, 1.0, 63);
    const Vector6d linear = Strains(StrainMeasure::kLinearKoiter, point, direction);
    const auto relative_difference = [&](double size) {
      return (Strains(StrainMeasure::kKoiter, point, size * direction) / size - linear).norm() /
             linear.norm();
    };
    EXPECT_NEAR(std::log10(relative_difference(1e-3) / relative_difference(1e-5)), 2.0, 0.02);
    EXPECT_LT(relative_difference(1e-7), 1e-5);
  }
}

TEST(LimitTest, NonlinearSeedTendsToLinearSeedPlusStretchTimesCurvature) {
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen direction = SeededUniform(15, 1.0, 64);
    Vector6d linear = Strains(StrainMeasure::kLinearSeed, point, direction);
    linear.tail<3>() += (linear[0] + linear[1]) * Curvatures(point);
    const auto relative_difference = [&](double size) {
      return (Strains(StrainMeasure::kNonlinearSeed, point, size * direction) / size - linear)
                 .norm() /
             linear.norm();
    };
    EXPECT_NEAR(std::log10(relative_difference(1e-3) / relative_difference(1e-5)), 2.0, 0.02);
  }
}

TEST(LimitTest, OnAPlaneTheTwoLinearTheoriesAgree) {
  const Fifteen k = SeededUniform(15, 1.0, 65);
  EXPECT_EQ(BendingStrain(StrainMeasure::kLinearSeed, PlanePoint(), k),
            BendingStrain(StrainMeasure::kLinearKoiter, PlanePoint(), k));
}

class ScalingTest : public ::testing::TestWithParam<double> {};  // lambda

// x -> lambda x: on the sphere an inflation.
TEST_P(ScalingTest, HasClosedForm) {
  const double lambda = GetParam(), strain = lambda - 1.0;
  const double green = strain + 0.5 * strain * strain;
  for (const StrainPoint& point : SamplePoints()) {
    const Fifteen k = AffineInputs(point, strain * Matrix3d::Identity());
    const double tolerance =
        1e-15 * (1.0 / (lambda * lambda) + std::pow(lambda, 3)) * CurvatureScale(point);
    const Vector3d b = Curvatures(point);
    for (const StrainMeasure measure : AllMeasures()) {
      const double e = IsLinear(measure) ? strain : green;
      EXPECT_LT((MembraneStrain(measure, point, k) - Vector3d(e, e, 0.0)).norm(), tolerance);
    }
    EXPECT_LT((BendingStrain(StrainMeasure::kKoiter, point, k) - b * strain).norm(), tolerance);
    EXPECT_LT((BendingStrain(StrainMeasure::kLinearKoiter, point, k) - b * strain).norm(),
              tolerance);
    EXPECT_LT(BendingStrain(StrainMeasure::kLinearSeed, point, k).norm(), tolerance);
    // Its normal is as long as the surface has been stretched.
    EXPECT_LT((BendingStrain(StrainMeasure::kNonlinearSeed, point, k) -
               b * (lambda * strain * (lambda + 1.0)))
                  .norm(),
              3.0 * tolerance);
  }
}

TEST_P(ScalingTest, KeepsTheDigitsOfTheStrain) {
  // Where the strain is itself tiny, relative to it.
  const StrainPoint point = DirectPoint(MakeSphere(2.0)->Evaluate(0.3, 0.4), 0.7);
  const double strain = 1e-9 * GetParam();
  const Fifteen k = AffineInputs(point, strain * Matrix3d::Identity());
  const double green = strain + 0.5 * strain * strain;
  EXPECT_NEAR(MembraneStrain(StrainMeasure::kKoiter, point, k)[0] / green, 1.0, 1e-14);
  EXPECT_NEAR(BendingStrain(StrainMeasure::kKoiter, point, k)[1] / (-0.5 * strain), 1.0, 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Lambda, ScalingTest, ::testing::Values(0.2, 0.999, 1.0 + 1e-9, 1.3, 4.0));

TEST(ClosedFormTest, SimpleShear) {
  Fifteen k = Fifteen::Zero();
  k[3] = 0.4;  // delta = 0.4 y e_x
  EXPECT_EQ(MembraneStrain(StrainMeasure::kLinearKoiter, PlanePoint(), k), Vector3d(0, 0, 0.4));
  EXPECT_LT(
      (MembraneStrain(StrainMeasure::kKoiter, PlanePoint(), k) - Vector3d(0, 0.08, 0.4)).norm(),
      1e-16);
  EXPECT_EQ(BendingStrain(StrainMeasure::kKoiter, PlanePoint(), k).norm(), 0.0);
}

TEST(ClosedFormTest, GraphOverThePlane) {
  // delta = w(x, y) e_z: second form of a graph.
  const double w1 = 0.7, w2 = -1.2, w11 = 0.3, w12 = -0.8, w22 = 1.1;
  Fifteen k;
  k << 0, 0, w1, 0, 0, w2, 0, 0, w11, 0, 0, w12, 0, 0, w22;
  const Vector3d hessian(w11, w22, 2.0 * w12);
  const Vector3d koiter = hessian / std::sqrt(1.0 + w1 * w1 + w2 * w2);
  EXPECT_LT((BendingStrain(StrainMeasure::kKoiter, PlanePoint(), k) - koiter).norm(), 4e-16);
  EXPECT_LT((BendingStrain(StrainMeasure::kNonlinearSeed, PlanePoint(), k) - hessian).norm(),
            4e-16);
  EXPECT_LT((BendingStrain(StrainMeasure::kLinearKoiter, PlanePoint(), k) - hessian).norm(), 4e-16);
  EXPECT_LT((MembraneStrain(StrainMeasure::kKoiter, PlanePoint(), k) -
             Vector3d(0.5 * w1 * w1, 0.5 * w2 * w2, w1 * w2))
                .norm(),
            4e-16);
}

// A plate rolled up, and a cylinder of 2 m rolled to another radius, at all angles.
class RollingTest : public ::testing::TestWithParam<double> {};  // 1 / radius, 1/m

TEST_P(RollingTest, BendsWithoutStretching) {
  for (const double rest : {0.0, 0.5}) {
    for (const double arc : {0.0, 0.4, 1.5, 3.0}) {                // m
      const double before = rest * arc, after = GetParam() * arc;  // angles
      StrainPoint point;  // t1 along the axis; n turns with the arc
      point.t1 = Vector3d::UnitX();
      point.t2 = Vector3d(0.0, std::cos(before), -std::sin(before));
      point.n = Vector3d(0.0, std::sin(before), std::cos(before));
      point.b22 = -rest;
      Fifteen k = Fifteen::Zero();
      k.segment<3>(3) = Vector3d(0.0, std::cos(after), -std::sin(after)) - point.t2;
      k.segment<3>(12) =
          -GetParam() * Vector3d(0.0, std::sin(after), std::cos(after)) + rest * point.n;
      EXPECT_LT(MembraneStrain(StrainMeasure::kKoiter, point, k).norm(), 1e-15);
      EXPECT_LT(
          (BendingStrain(StrainMeasure::kKoiter, point, k) - Vector3d(0.0, rest - GetParam(), 0.0))
              .norm(),
          1e-15);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Curvature, RollingTest, ::testing::Values(-2.0, 0.0, 1e-6, 0.5, 2.0));

// Where x_1 x x_2 vanishes there is no normal.
class CollapseTest : public ::testing::TestWithParam<unsigned> {  // seed of the frame
 protected:
  void ExpectUndefined(const Fifteen& k) const {
    Vector3d e;
    EXPECT_FALSE(EvaluateBendingStrain(StrainMeasure::kKoiter, point_, k.data(), e.data()));
    using Jet = ceres::Jet<double, 15>;
    std::array<Jet, 15> jets;
    for (int i = 0; i < 15; ++i) jets[i] = Jet(k[i], i);
    std::array<Jet, 3> strain;
    EXPECT_FALSE(EvaluateBendingStrain(StrainMeasure::kKoiter, point_, jets.data(), strain.data()));
    EXPECT_TRUE(MembraneStrain(StrainMeasure::kKoiter, point_, k).allFinite());
    EXPECT_TRUE(BendingStrain(StrainMeasure::kNonlinearSeed, point_, k).allFinite());
  }

  StrainPoint point_ = RandomPoint(GetParam());
};

TEST_P(CollapseTest, OfOneTangentIsRefused) {
  Fifteen k = SeededUniform(15, 0.3, 81);
  k.segment<3>(0) = -point_.t1;
  ExpectUndefined(k);
}

TEST_P(CollapseTest, OfBothTangentsIsRefused) {
  Fifteen k = SeededUniform(15, 0.3, 82);
  k << -point_.t1, -point_.t2, k.segment<9>(6);
  ExpectUndefined(k);
}

TEST_P(CollapseTest, OntoALineIsRefused) {
  for (const double length : {0.1, 1.0}) {
    Fifteen k = SeededUniform(15, 0.3, 83);
    const Vector3d line = length * Vector3d(0.3, -0.4, 0.8);
    k << line - point_.t1, -2.0 * line - point_.t2, k.segment<9>(6);
    ExpectUndefined(k);
  }
}

TEST_P(CollapseTest, NotQuiteReachedIsFinite) {
  Fifteen k = SeededUniform(15, 0.3, 84);
  k << -(1.0 - 1e-5) * point_.t1, 0.0, 0.0, 0.0, k.segment<9>(6);
  // n stays where it is.
  const Vector3d e = BendingStrain(StrainMeasure::kKoiter, point_, k);
  EXPECT_NEAR(e[0], k.segment<3>(6).dot(point_.n), 1e-9);
}

TEST_P(CollapseTest, NanDisplacementsAreRefused) {
  for (int i = 0; i < 6; ++i) {
    Fifteen k = SeededUniform(15, 0.3, 85);
    k[i] = std::nan("");
    Vector3d e;
    EXPECT_FALSE(EvaluateBendingStrain(StrainMeasure::kKoiter, point_, k.data(), e.data()));
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, CollapseTest, ::testing::Range(0u, 5u));

// Turned over altogether the shell is as good as new.
TEST(KoiterTest, HalfATurnAboutATangentHasNoStrain) {
  for (const StrainPoint& point : SamplePoints()) {
    const Matrix3d r = Eigen::AngleAxisd(M_PI, point.t1).toRotationMatrix();
    const Fifteen k = AffineInputs(point, r - Matrix3d::Identity());
    EXPECT_LT(Strains(StrainMeasure::kKoiter, point, k).norm(), 3e-15 * CurvatureScale(point));
  }
}

}  // namespace
}  // namespace darboux
