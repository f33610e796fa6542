#include "costs/follower_pressure.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/test_util.h"

namespace darboux {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPressure = 1.7e3;  // Pa
const double kOne = 1.0;             // load factor
const Vector3d kOrigin(0.3, -0.2, 0.5);

std::unique_ptr<FollowerPressure> MakeCost(const StrainPoints& points,
                                           const Vector3d& origin = kOrigin,
                                           const double* factor = &kOne) {
  return std::make_unique<FollowerPressure>(
      points, std::vector<double>(points->size(), kPressure), origin, factor, 1e6);
}

Matrix3Xd ExactForce(const FollowerPressure& cost, const VectorXd& x) {
  std::vector<const double*> blocks;
  for (int i = 0; 3 * i < x.size(); ++i) blocks.push_back(x.data() + 3 * i);
  return cost.ExactForce(blocks.data());
}

// Energy, gradient and exact force of a whole patch.
struct Assembly {
  double energy = 0.0;
  Matrix3Xd gradient, force;
};

Assembly Assemble(const LoopPatch& patch,
                  const Matrix3Xd& displacements,
                  const std::vector<TrianglePoint>& rule,
                  const Vector3d& origin = kOrigin) {
  Assembly sum;
  sum.gradient = sum.force = Matrix3Xd::Zero(3, patch.mesh.num_vertices);
  for (int e = 0; e < patch.mesh.num_elements; ++e) {
    const auto cost = MakeCost(patch.Points(e, rule), origin);
    const VectorXd x = patch.Parameters(e, displacements);
    const VectorXd gradient = Gradient(*cost, x);
    const Matrix3Xd force = ExactForce(*cost, x);
    sum.energy += Energy(*cost, x);
    const std::vector<int>& vertices = patch.basis->control_vertices(e);
    for (size_t i = 0; i < vertices.size(); ++i) {
      sum.gradient.col(vertices[i]) += gradient.segment<3>(3 * i);
      sum.force.col(vertices[i]) += force.col(i);
    }
  }
  return sum;
}

// x.n / 3 over the rest surface.
double Volume(const LoopPatch& patch) {
  double volume = 0.0;
  for (int e = 0; e < patch.mesh.num_elements; ++e) {
    const StrainPoints points = patch.Points(e, ExactTriangleRule());
    for (const StrainPoint& p : *points) {
      volume += p.area * p.position.dot(p.n) / 3.0;
    }
  }
  return volume;
}

class FollowerPressurePatchTest : public ::testing::TestWithParam<Patch> {
 protected:
  const LoopPatch patch_ = MakeLoopPatch(GetParam());
};

TEST_P(FollowerPressurePatchTest, RestHasNoEnergyAndTheForceOfADeadPressure) {
  const StrainPoints points = patch_.Points(2, 6);
  const auto cost = MakeCost(points);
  EXPECT_EQ(Energy(*cost, VectorXd::Zero(36)), 0.0);
  Matrix3Xd expected = Matrix3Xd::Zero(3, 12);
  for (const StrainPoint& p : *points) {
    expected += kPressure * p.area * p.n * p.weights.row(kRowValue);
  }
  EXPECT_LT((ExactForce(*cost, VectorXd::Zero(36)) - expected).norm(), 1e-15 * expected.norm());
}

TEST_P(FollowerPressurePatchTest, ForceTurnsWithTheSurface) {
  for (const double angle : {1e-3, 0.7, 3.0}) {
    const Matrix3d r = SkewRotation(angle);
    for (int e = 0; e < patch_.mesh.num_elements; ++e) {
      const auto cost = MakeCost(patch_.Points(e, 3));
      const Matrix3Xd u = patch_.RandomField(0.1);
      const Matrix3Xd before = ExactForce(*cost, patch_.Parameters(e, u));
      const Matrix3Xd after =
          ExactForce(*cost, patch_.Parameters(e, patch_.RigidMotion(angle) + r * u));
      EXPECT_LT((after - r * before).norm(), 1e-14 * before.norm());
    }
  }
}

// Turned about the origin the shell sweeps nothing.
TEST_P(FollowerPressurePatchTest, RotationAboutTheOriginHasNoEnergy) {
  const Matrix3d r = SkewRotation(0.7) - Matrix3d::Identity();
  const Assembly a = Assemble(patch_, patch_.Affine(r, -r * kOrigin), TriangleQuadrature(3));
  EXPECT_NEAR(a.energy, 0.0, 1e-13 * kPressure);
}

// x -> lambda x about the origin: every cone grows by lambda^3.
TEST_P(FollowerPressurePatchTest, ScalingSweepsTheConesExactly) {
  const double lambda = 1.4;
  const Assembly a = Assemble(patch_,
                              patch_.Affine((lambda - 1.0) * Matrix3d::Identity()),
                              TriangleQuadrature(3),
                              Vector3d::Zero());
  double cones = 0.0;
  for (int e = 0; e < patch_.mesh.num_elements; ++e) {
    const StrainPoints points = patch_.Points(e);
    for (const StrainPoint& p : *points) cones += p.area * p.position.dot(p.n) / 3.0;
  }
  EXPECT_NEAR(a.energy, -kPressure * (std::pow(lambda, 3) - 1.0) * cones, 1e-13 * kPressure);
}

// The two differ by an integral over the boundary: at control vertices whose functions vanish
// there they agree.
TEST_P(FollowerPressurePatchTest, GradientIsMinusTheForceAwayFromTheBoundary) {
  Patch wide = GetParam();
  wide.domain.divisions = {5, 5};
  const LoopPatch patch = MakeLoopPatch(wide);
  const Assembly a = Assemble(patch, patch.RandomField(0.05), ExactTriangleRule());
  const ParameterDomain domain(wide.domain);
  std::set<int> inside;
  for (int i = 2; i <= 3; ++i) {
    for (int j = 2; j <= 3; ++j) inside.insert(domain.VertexIndex(i, j));
  }
  double at_boundary = 0.0;
  for (int vertex = 0; vertex < patch.mesh.num_vertices; ++vertex) {
    const double difference = (a.gradient + a.force).col(vertex).norm();
    if (inside.count(vertex) > 0) {
      EXPECT_LT(difference, 1e-12 * a.force.norm());
      EXPECT_GT(a.force.col(vertex).norm(), 1e-3 * a.force.norm());
    } else {
      at_boundary = std::max(at_boundary, difference);
    }
  }
  EXPECT_GT(at_boundary, 1e-3 * a.force.norm());
}

INSTANTIATE_TEST_SUITE_P(Patches,
                         FollowerPressurePatchTest,
                         ::testing::ValuesIn(SamplePatches()),
                         PatchName);

class ClosedTorusTest : public ::testing::Test {
 protected:
  const LoopPatch torus_ = MakeClosedTorus(1.0, 0.4, 10, 8);
  const Matrix3Xd deformed_ = torus_.RandomField(0.1);
};

TEST_F(ClosedTorusTest, GradientIsMinusTheForce) {
  const Assembly a = Assemble(torus_, deformed_, ExactTriangleRule());
  EXPECT_LT((a.gradient + a.force).norm(), 1e-13 * a.force.norm());
  // Volume knows no origin.
  const Assembly b = Assemble(torus_, deformed_, ExactTriangleRule(), Vector3d(5.0, -7.0, 11.0));
  EXPECT_NEAR(a.energy, b.energy, 1e-12 * kPressure);
}

TEST_F(ClosedTorusTest, ForceAndMomentVanish) {
  const Matrix3Xd force = Assemble(torus_, deformed_, ExactTriangleRule()).force;
  EXPECT_LT(force.rowwise().sum().norm(), 1e-13 * force.norm());
  Vector3d moment = Vector3d::Zero();
  for (int i = 0; i < force.cols(); ++i) {
    moment += Vector3d(torus_.positions.col(i) + deformed_.col(i)).cross(force.col(i));
  }
  EXPECT_LT(moment.norm(), 1e-13 * force.norm());
}

TEST_F(ClosedTorusTest, EnergyIsThePressureTimesTheVolumeGained) {
  const double lambda = 1.3;
  const Matrix3Xd inflation = torus_.Affine((lambda - 1.0) * Matrix3d::Identity());
  const double volume = Volume(torus_);
  EXPECT_NEAR(Assemble(torus_, inflation, ExactTriangleRule()).energy,
              -kPressure * (std::pow(lambda, 3) - 1.0) * volume,
              1e-13 * kPressure);
  // Any affine map, by its determinant; also turned inside out.
  for (const unsigned seed : {21u, 22u, 23u}) {
    const Matrix3d a = SeededMatrix(0.8, seed);
    const double gained = ((Matrix3d::Identity() + a).determinant() - 1.0) * volume;
    EXPECT_NEAR(Assemble(torus_, torus_.Affine(a, {1, 2, 3}), ExactTriangleRule()).energy,
                -kPressure * gained,
                1e-12 * kPressure);
  }
  // A Loop surface lies inside its control net.
  const double exact = 2.0 * M_PI * M_PI * 1.0 * 0.4 * 0.4;
  EXPECT_LT(volume, exact);
  const double coarse = Volume(MakeClosedTorus(1.0, 0.4, 20, 16));
  const double fine = Volume(MakeClosedTorus(1.0, 0.4, 40, 32));
  EXPECT_NEAR((exact - fine) / (exact - coarse), 0.25, 0.01);
}

TEST_F(ClosedTorusTest, RigidMotionHasNoEnergy) {
  const Assembly a = Assemble(torus_, torus_.RigidMotion(0.7), ExactTriangleRule());
  EXPECT_NEAR(a.energy, 0.0, 1e-12 * kPressure);
}

// Where the pressure varies there is no energy, and the gradient must not be taken for the force.
TEST_F(ClosedTorusTest, VaryingPressureHasAnotherForce) {
  Matrix3Xd gradient = Matrix3Xd::Zero(3, torus_.mesh.num_vertices), force = gradient;
  for (int e = 0; e < torus_.mesh.num_elements; ++e) {
    const StrainPoints points = torus_.Points(e, ExactTriangleRule());
    std::vector<double> pressure;
    for (const StrainPoint& p : *points) pressure.push_back(kPressure * (1.0 + p.position.z()));
    const FollowerPressure cost(points, pressure, kOrigin, &kOne, 1e6);
    const VectorXd x = torus_.Parameters(e, deformed_);
    const VectorXd g = Gradient(cost, x);
    const Matrix3Xd f = ExactForce(cost, x);
    for (int i = 0; i < 12; ++i) {
      const int vertex = torus_.basis->control_vertices(e)[i];
      gradient.col(vertex) += g.segment<3>(3 * i);
      force.col(vertex) += f.col(i);
    }
  }
  EXPECT_GT((gradient + force).norm(), 1e-2 * force.norm());
}

TEST(FollowerPressureTest, InflatedBallWithIrregularVertices) {
  const LoopPatch ball = MakeIcosphere(1.0, 2);
  const double lambda = 1.3;
  const Assembly a =
      Assemble(ball, ball.Affine((lambda - 1.0) * Matrix3d::Identity()), ExactTriangleRule());
  const double volume = Volume(ball);
  EXPECT_NEAR(a.energy, -kPressure * (std::pow(lambda, 3) - 1.0) * volume, 1e-3 * kPressure);
  EXPECT_LT(volume, 4.0 / 3.0 * M_PI);
  EXPECT_GT(volume, 0.8 * 4.0 / 3.0 * M_PI);
}

TEST(FollowerPressureTest, ReadsTheFactorAtEveryEvaluation) {
  const LoopPatch patch = MakeLoopPatch(TorusPatch());
  double factor = 1.0;
  const auto cost = MakeCost(patch.Points(0), kOrigin, &factor);
  const VectorXd x = SeededUniform(36, 0.1);
  const double energy = Energy(*cost, x);
  const VectorXd gradient = Gradient(*cost, x);
  const Matrix3Xd force = ExactForce(*cost, x);
  factor = -0.25;
  EXPECT_NEAR(Energy(*cost, x) / energy, factor, 1e-15);
  EXPECT_LT((Gradient(*cost, x) - factor * gradient).norm(), 1e-15 * gradient.norm());
  EXPECT_LT((ExactForce(*cost, x) - factor * force).norm(), 1e-15 * force.norm());
}

TEST(FollowerPressureTest, EachPointHasItsOwnPressure) {
  const LoopPatch patch = MakeLoopPatch(TorusPatch());
  const StrainPoints points = patch.Points(0);
  const std::vector<double> pressure = {1.0, -20.0, 300.0};
  const VectorXd x = SeededUniform(36, 0.1);
  double energy = 0.0;
  for (int q = 0; q < 3; ++q) {
    energy += Energy(FollowerPressure(std::make_shared<std::vector<StrainPoint>>(1, (*points)[q]),
                                      {pressure[q]},
                                      kOrigin,
                                      &kOne,
                                      1.0),
                     x);
  }
  EXPECT_NEAR(
      Energy(FollowerPressure(points, pressure, kOrigin, &kOne, 1.0), x) / energy, 1.0, 1e-14);
}

// Displacements of 1e-9: -p n.u dA to first order, not the difference of two volumes.
TEST(FollowerPressureTest, TinyDisplacementsKeepTheirDigits) {
  const LoopPatch torus = MakeClosedTorus(1.0, 0.4, 10, 8);
  const Matrix3Xd u = torus.RandomField(1.0);
  const Matrix3Xd force = Assemble(torus, Matrix3Xd::Zero(3, u.cols()), ExactTriangleRule()).force;
  const double first_order = -(force.array() * u.array()).sum();
  const double size = 1e-9;
  const double odd = 0.5 * (Assemble(torus, size * u, ExactTriangleRule()).energy -
                            Assemble(torus, -size * u, ExactTriangleRule()).energy);
  EXPECT_NEAR(odd / size / first_order, 1.0, 1e-12);
}

class FollowerPressureJacobianTest : public ::testing::TestWithParam<std::tuple<double, Patch>> {};

TEST_P(FollowerPressureJacobianTest, MatchesRiddersDifferences) {
  const auto& [size, patch] = GetParam();
  const std::unique_ptr<FollowerPressure> cost = MakeCost(MakeLoopPatch(patch).Points(2));
  EXPECT_THAT(cost, HasCorrectJacobianAt(SeededUniform(36, size), 1e-9));
}

INSTANTIATE_TEST_SUITE_P(DisplacementM,
                         FollowerPressureJacobianTest,
                         ::testing::Combine(::testing::Values(0, 1e-8, 1e-2, 1, 1e2),
                                            ::testing::Values(TorusPatch(), PlanePatch())));

}  // namespace
}  // namespace darboux
