#include "geometry/invariant_strains.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "geometry/parametric_surface.h"
#include "geometry/surface_invariants.h"

namespace darboux {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// A displacement that is a quadratic function of the position in space, so that its jet follows
// from the surface's by the chain rule: delta(x) = offset + gradient x + (x^T hessian_k x)_k / 2.
struct SpaceField {
  Vector3d offset = Vector3d::Zero();
  Matrix3d gradient = Matrix3d::Zero();
  std::array<Matrix3d, 3> hessian = {Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};

  Vector3d Quadratic(const Vector3d& x, const Vector3d& y) const {
    return {x.dot(hessian[0] * y), x.dot(hessian[1] * y), x.dot(hessian[2] * y)};
  }

  DisplacementJet On(const SurfaceJet& s) const {
    const auto first = [&](const Vector3d& x_a) -> Vector3d {
      return gradient * x_a + Quadratic(s.x, x_a);
    };
    return {offset + gradient * s.x + 0.5 * Quadratic(s.x, s.x),
            first(s.x_u),
            first(s.x_v),
            first(s.x_uu) + Quadratic(s.x_u, s.x_u),
            first(s.x_uv) + Quadratic(s.x_u, s.x_v),
            first(s.x_vv) + Quadratic(s.x_v, s.x_v)};
  }
};

SpaceField RandomField(double size, std::mt19937* generator) {
  std::uniform_real_distribution<double> uniform(-size, size);
  const auto fill = [&](Matrix3d* m) {
    for (int k = 0; k < 9; ++k) m->data()[k] = uniform(*generator);
  };
  SpaceField f;
  for (int k = 0; k < 3; ++k) {
    f.offset[k] = uniform(*generator);
    fill(&f.hessian[k]);
    f.hessian[k] = (f.hessian[k] + f.hessian[k].transpose()).eval();
  }
  fill(&f.gradient);
  return f;
}

SpaceField RigidMotion(double angle_rad, const Vector3d& axis, const Vector3d& shift) {
  SpaceField f;
  f.offset = shift;
  f.gradient = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  f.gradient -= Matrix3d::Identity();
  return f;
}

const Vector3d kSkewAxis(1.0, 2.0, 3.0);

SurfaceInvariants Invariants(const SurfaceJet& jet, double umbilic_tolerance = 1e-3) {
  SurfaceInvariantsOptions options;
  options.umbilic_tolerance = umbilic_tolerance;
  const std::optional<SurfaceInvariants> s = EvaluateSurfaceInvariants(jet, options);
  EXPECT_TRUE(s.has_value());
  return s.value();
}

// The fifteen numbers d_i, H_ij of the solver's kernels, in the frame of the invariants but
// without any derivative of that frame: the other way to the same strains.
struct Kinematics {
  Vector3d d[2], h[2][2];
  Vector3d t[2], n;
  Vector3d n_along[2];  // -b_ij t_j
  Matrix2d b;
};

Kinematics EvaluateKinematics(const SurfaceInvariants& s, const DisplacementJet& x) {
  Kinematics k;
  k.t[0] = s.t1;
  k.t[1] = s.t2;
  k.n = s.n;
  k.b = s.b;
  const Vector3d hessian[2][2] = {
      {x.d_uu - s.christoffel[0](0, 0) * x.d_u - s.christoffel[1](0, 0) * x.d_v,
       x.d_uv - s.christoffel[0](0, 1) * x.d_u - s.christoffel[1](0, 1) * x.d_v},
      {x.d_uv - s.christoffel[0](1, 0) * x.d_u - s.christoffel[1](1, 0) * x.d_v,
       x.d_vv - s.christoffel[0](1, 1) * x.d_u - s.christoffel[1](1, 1) * x.d_v}};
  for (int i = 0; i < 2; ++i) {
    k.d[i] = s.Along(i, x.d_u, x.d_v);
    k.n_along[i] = -s.b(i, 0) * s.t1 - s.b(i, 1) * s.t2;
    for (int j = 0; j < 2; ++j) {
      k.h[i][j] = s.Along(
          i, s.Along(j, hessian[0][0], hessian[0][1]), s.Along(j, hessian[1][0], hessian[1][1]));
    }
  }
  return k;
}

// eps_1, eps_2, omega_1 + omega_2, zeta_1, zeta_2, tau from the fifteen numbers.
Vector6d KernelLinear(const Kinematics& k) {
  Vector6d e;
  e << k.d[0].dot(k.t[0]), k.d[1].dot(k.t[1]), k.d[0].dot(k.t[1]) + k.d[1].dot(k.t[0]),
      -(k.h[0][0].dot(k.n) + k.d[0].dot(k.n_along[0])),
      -(k.h[1][1].dot(k.n) + k.d[1].dot(k.n_along[1])),
      -(2.0 * k.h[0][1].dot(k.n) + k.d[0].dot(k.n_along[1]) + k.d[1].dot(k.n_along[0]));
  return e;
}

Vector6d Stacked(const LinearInvariantStrains& e) {
  Vector6d v;
  v << e.eps_1, e.eps_2, e.omega_1 + e.omega_2, e.zeta_1, e.zeta_2, e.tau;
  return v;
}

// (46)-(54) from the fifteen numbers: with N = x_1 x x_2, x_i . N = 0 gives
// x_i . t_j[N] = -(b_ij n + H_ij) . N, without derivatives of the frame or of N.
Vector6d KernelNonlinear(const Kinematics& k) {
  const Vector3d x[2] = {k.t[0] + k.d[0], k.t[1] + k.d[1]};
  const Vector3d normal = x[0].cross(x[1]);
  const auto zeta = [&](int i, int j) {
    return -(k.b(i, j) * k.n + k.h[i][j]).dot(normal) - x[i].dot(k.n_along[j]);
  };
  Vector6d e;
  e << 0.5 * (x[0].dot(x[0]) - 1.0), 0.5 * (x[1].dot(x[1]) - 1.0), x[0].dot(x[1]), zeta(0, 0),
      zeta(1, 1), zeta(0, 1) + zeta(1, 0);
  return e;
}

Vector6d Stacked(const NonlinearInvariantStrains& e) {
  Vector6d v;
  v << e.eps_11, e.eps_22, e.eps_12, e.zeta_11, e.zeta_22, e.zeta_12;
  return v;
}

LinearInvariantStrains Linear(const SurfaceInvariants& s, const DisplacementJet& x) {
  return EvaluateLinearInvariantStrains(s, EvaluateComponents(s, x));
}

// Energy density (38), (58) for E = 1, nu = 0.3, h = 0.1.
double EnergyDensity(const Vector6d& e) {
  const double nu = 0.3, h = 0.1;
  const auto form = [&](double e11, double e22, double e12) {
    return e11 * e11 + e22 * e22 + 2.0 * nu * e11 * e22 + 0.5 * (1.0 - nu) * e12 * e12;
  };
  return 0.5 / (1.0 - nu * nu) *
         (h * form(e[0], e[1], e[2]) + h * h * h / 12.0 * form(e[3], e[4], e[5]));
}

struct Case {
  std::string name;
  std::function<std::unique_ptr<ParametricSurface>()> make;
  bool umbilic;  // Everywhere; else at none of the points.
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class InvariantStrainsTest : public ::testing::TestWithParam<Case> {
 protected:
  InvariantStrainsTest() {
    const std::unique_ptr<ParametricSurface> surface = GetParam().make();
    for (const Vector2d& p : {Vector2d(0.3, 0.2), Vector2d(0.9, -0.4), Vector2d(-0.5, 0.7)}) {
      jets_.push_back(surface->Evaluate(p[0], p[1]));
    }
  }

  std::vector<SurfaceJet> jets_;
};

TEST_P(InvariantStrainsTest, ComponentsRebuildTheDisplacement) {
  std::mt19937 generator(38401);
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    const DisplacementJet x = RandomField(1.0, &generator).On(jet);
    const DisplacementComponents c = EvaluateComponents(s, x);
    EXPECT_LT((c.alpha * s.t1 + c.beta * s.t2 + c.gamma * s.n - x.d).norm(), 1e-14);
    const Vector3d d_u = c.alpha_u * s.t1 + c.alpha * s.t1_d[0] + c.beta_u * s.t2 +
                         c.beta * s.t2_d[0] + c.gamma_u * s.n + c.gamma * s.n_d[0];
    EXPECT_LT((d_u - x.d_u).norm(), 1e-13 * (1.0 + x.d_u.norm()));
    // n . (delta_vv) from the components of delta = gamma n alone.
    const DisplacementComponents normal = EvaluateComponents(
        s,
        {c.gamma * s.n,
         c.gamma_u * s.n + c.gamma * s.n_d[0],
         c.gamma_v * s.n + c.gamma * s.n_d[1],
         c.gamma_uu * s.n + 2.0 * c.gamma_u * s.n_d[0] + c.gamma * s.n_uu,
         c.gamma_uv * s.n + c.gamma_u * s.n_d[1] + c.gamma_v * s.n_d[0] + c.gamma * s.n_uv,
         c.gamma_vv * s.n + 2.0 * c.gamma_v * s.n_d[1] + c.gamma * s.n_vv});
    EXPECT_NEAR(normal.gamma_vv, c.gamma_vv, 1e-13 * (1.0 + std::abs(c.gamma_vv)));
    EXPECT_NEAR(normal.gamma_uv, c.gamma_uv, 1e-13 * (1.0 + std::abs(c.gamma_uv)));
    EXPECT_NEAR(normal.alpha_u, 0.0, 1e-13);
  }
}

TEST_P(InvariantStrainsTest, LinearAgreeWithTheFifteenNumbers) {
  std::mt19937 generator(38402);
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    EXPECT_EQ(s.umbilic, GetParam().umbilic);
    for (const double size : {1e-6, 1.0, 1e3}) {
      const DisplacementJet x = RandomField(size, &generator).On(jet);
      const Kinematics k = EvaluateKinematics(s, x);
      const LinearInvariantStrains e = Linear(s, x);
      const Vector6d expected = KernelLinear(k);
      EXPECT_LT((Stacked(e) - expected).norm(), 1e-9 * expected.norm()) << size;
      // omega_1 as printed is the derivative along t2, omega_2 that along t1.
      EXPECT_NEAR(e.omega_1, k.d[1].dot(s.t1), 1e-12 * expected.norm());
      EXPECT_NEAR(e.omega_2, k.d[0].dot(s.t2), 1e-12 * expected.norm());
      EXPECT_NEAR(e.phi_1, -k.d[0].dot(s.n), 1e-12 * expected.norm());
      EXPECT_NEAR(e.phi_2, -k.d[1].dot(s.n), 1e-12 * expected.norm());
    }
  }
}

TEST_P(InvariantStrainsTest, NonlinearAgreeWithTheFifteenNumbers) {
  std::mt19937 generator(38403);
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    for (const double size : {1e-6, 1e-2, 1.0, 1e2}) {
      const DisplacementJet x = RandomField(size, &generator).On(jet);
      const Vector6d expected = KernelNonlinear(EvaluateKinematics(s, x));
      const Vector6d actual = Stacked(EvaluateNonlinearInvariantStrains(s, x));
      EXPECT_LT((actual - expected).norm(), 1e-9 * expected.norm()) << size;
    }
  }
}

TEST_P(InvariantStrainsTest, InfinitesimalRigidMotionHasNoMembraneStrain) {
  SpaceField spin;
  spin.offset << 0.1, -0.2, 0.3;
  spin.gradient << 0.0, -0.3, 0.2, 0.3, 0.0, -0.1, -0.2, 0.1, 0.0;
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    const LinearInvariantStrains e = Linear(s, spin.On(jet));
    EXPECT_NEAR(e.eps_1, 0.0, 1e-14);
    EXPECT_NEAR(e.eps_2, 0.0, 1e-14);
    EXPECT_NEAR(e.omega_1 + e.omega_2, 0.0, 1e-14);
    EXPECT_NEAR(e.zeta_1, 0.0, 1e-12);
    EXPECT_NEAR(e.zeta_2, 0.0, 1e-12);
    // Love's defect: tau sees the rotation about n wherever kappa_1 and kappa_2 differ.
    if (!s.umbilic) {
      EXPECT_NEAR(e.tau, -e.omega_2 * (s.kappa[0] - s.kappa[1]), 1e-12);
    }
  }
}

// Erratum of the paper: (46)-(54) with omega_1, omega_2 as (30), (31) define them.
TEST_P(InvariantStrainsTest, RigidMotionHasNoMembraneStrainOnlyIfTheOmegasAreExchanged) {
  const SpaceField motion = RigidMotion(0.5, kSkewAxis, {0.1, -0.2, 0.3});
  double largest_as_printed = 0.0;
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    const DisplacementJet x = motion.On(jet);
    EXPECT_LT(Stacked(EvaluateNonlinearInvariantStrains(s, x)).head<3>().norm(), 1e-15);
    largest_as_printed =
        std::max(largest_as_printed,
                 Stacked(EvaluateNonlinearInvariantStrains(s, x, OmegaConvention::kAsPrinted))
                     .head<3>()
                     .norm());
  }
  EXPECT_GT(largest_as_printed, 1e-2);
}

// (52)-(54) are not invariant on a curved surface; they are up to kappa times membrane terms.
TEST_P(InvariantStrainsTest, RigidMotionLeavesTheStatedRemainderInBending) {
  for (const double angle : {1e-6, 0.5, 3.0}) {
    const SpaceField motion = RigidMotion(angle, kSkewAxis, {0.1, -0.2, 0.3});
    for (const SurfaceJet& jet : jets_) {
      const SurfaceInvariants s = Invariants(jet);
      const DisplacementJet x = motion.On(jet);
      const NonlinearInvariantStrains e = EvaluateNonlinearInvariantStrains(s, x);
      const Kinematics k = EvaluateKinematics(s, x);
      const Matrix2d d =
          (Matrix2d() << k.d[0].dot(s.t1), k.d[0].dot(s.t2), k.d[1].dot(s.t1), k.d[1].dot(s.t2))
              .finished();
      // kappa_1 eps_1, kappa_2 eps_2, kappa_2 omega_1 + kappa_1 omega_2 in a principal frame.
      const Matrix2d product = d * s.b;
      EXPECT_NEAR(e.zeta_11 - product(0, 0), 0.0, 1e-13);
      EXPECT_NEAR(e.zeta_22 - product(1, 1), 0.0, 1e-13);
      EXPECT_NEAR(e.zeta_12 - product(0, 1) - product(1, 0), 0.0, 1e-13);
      if (!s.umbilic) {
        EXPECT_NEAR(e.zeta_11, s.kappa[0] * d(0, 0), 1e-13);
        EXPECT_NEAR(e.zeta_12, s.kappa[1] * d(0, 1) + s.kappa[0] * d(1, 0), 1e-13);
      }
    }
  }
}

TEST_P(InvariantStrainsTest, NonlinearTendToLinearPlusStretchTimesCurvature) {
  std::mt19937 generator(38404);
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants s = Invariants(jet);
    const double size = 1e-7;
    const DisplacementJet x = RandomField(size, &generator).On(jet);
    const LinearInvariantStrains linear = Linear(s, x);
    Vector6d expected = Stacked(linear);
    // The normal (49)-(51) is as long as the surface has been stretched.
    const double stretch = linear.eps_1 + linear.eps_2;
    expected[3] -= s.b(0, 0) * stretch;
    expected[4] -= s.b(1, 1) * stretch;
    expected[5] -= 2.0 * s.b(0, 1) * stretch;
    const Vector6d actual = Stacked(EvaluateNonlinearInvariantStrains(s, x));
    EXPECT_LT((actual - expected).norm(), 1e4 * size * size);
  }
}

// The same displacement in two frames: components differ, energy must not.
TEST_P(InvariantStrainsTest, EnergyDoesNotDependOnTheFrame) {
  std::mt19937 generator(38405);
  for (const SurfaceJet& jet : jets_) {
    const SurfaceInvariants principal = Invariants(jet);
    const SurfaceInvariants parametric = Invariants(jet, 1e9);
    EXPECT_TRUE(parametric.umbilic);
    const DisplacementJet x = RandomField(0.1, &generator).On(jet);
    const double linear = EnergyDensity(Stacked(Linear(principal, x)));
    EXPECT_NEAR(EnergyDensity(Stacked(Linear(parametric, x))) / linear, 1.0, 1e-11);
    const double nonlinear =
        EnergyDensity(Stacked(EvaluateNonlinearInvariantStrains(principal, x)));
    EXPECT_NEAR(
        EnergyDensity(Stacked(EvaluateNonlinearInvariantStrains(parametric, x))) / nonlinear,
        1.0,
        1e-11);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Surfaces,
    InvariantStrainsTest,
    ::testing::Values(Case{"torus", [] { return MakeTorus(3.0, 1.0); }, false},
                      Case{"cylinder", [] { return MakeCylinder(2.0); }, false},
                      Case{"ellipsoid", [] { return MakeEllipsoid(2.0, 1.5, 0.7); }, false},
                      Case{"monkey_saddle", [] { return MakeMonkeySaddle(0.3); }, false},
                      Case{"sphere", [] { return MakeSphere(2.0); }, true},
                      Case{"plane", [] { return MakePlane(); }, true}),
    [](const ::testing::TestParamInfo<Case>& info) { return info.param.name; });

// In new parameters u = 0.8 p + 0.5 q, v = -0.3 p + 0.9 q, exactly.
SurfaceJet Skewed(const SurfaceJet& s) {
  const double a = 0.8, b = 0.5, c = -0.3, d = 0.9;
  SurfaceJet r;
  r.x = s.x;
  r.x_u = a * s.x_u + c * s.x_v;
  r.x_v = b * s.x_u + d * s.x_v;
  r.x_uu = a * a * s.x_uu + 2 * a * c * s.x_uv + c * c * s.x_vv;
  r.x_uv = a * b * s.x_uu + (a * d + b * c) * s.x_uv + c * d * s.x_vv;
  r.x_vv = b * b * s.x_uu + 2 * b * d * s.x_uv + d * d * s.x_vv;
  r.x_uuu =
      a * a * a * s.x_uuu + 3 * a * a * c * s.x_uuv + 3 * a * c * c * s.x_uvv + c * c * c * s.x_vvv;
  r.x_uuv = a * a * b * s.x_uuu + (a * a * d + 2 * a * b * c) * s.x_uuv +
            (2 * a * c * d + b * c * c) * s.x_uvv + c * c * d * s.x_vvv;
  r.x_uvv = a * b * b * s.x_uuu + (b * b * c + 2 * a * b * d) * s.x_uuv +
            (2 * b * c * d + a * d * d) * s.x_uvv + c * d * d * s.x_vvv;
  r.x_vvv =
      b * b * b * s.x_uuu + 3 * b * b * d * s.x_uuv + 3 * b * d * d * s.x_uvv + d * d * d * s.x_vvv;
  return r;
}

TEST(InvariantStrainsClosedFormTest, ATorusDoNotDependOnTheParameters) {
  std::mt19937 generator(38406);
  const SurfaceJet jet = MakeTorus(3.0, 1.0)->Evaluate(0.4, 0.9);
  const SurfaceJet skewed = Skewed(jet);
  const SurfaceInvariants s = Invariants(jet), r = Invariants(skewed);
  for (int trial = 0; trial < 5; ++trial) {
    const SpaceField field = RandomField(0.2, &generator);
    // Reversing t1 and t2 together leaves every strain as it is.
    const Vector6d linear = Stacked(Linear(s, field.On(jet)));
    EXPECT_LT((Stacked(Linear(r, field.On(skewed))) - linear).norm(), 1e-11);
    const Vector6d nonlinear = Stacked(EvaluateNonlinearInvariantStrains(s, field.On(jet)));
    EXPECT_LT((Stacked(EvaluateNonlinearInvariantStrains(r, field.On(skewed))) - nonlinear).norm(),
              1e-11);
  }
}

TEST(InvariantStrainsClosedFormTest, ATorusRotatedAboutASkewAxisShowTheErrata) {
  const SurfaceJet jet = MakeTorus(3.0, 1.0)->Evaluate(0.7, 0.4);
  const SurfaceInvariants s = Invariants(jet);
  const DisplacementJet x = RigidMotion(0.5, kSkewAxis, Vector3d::Zero()).On(jet);
  const Vector6d printed =
      Stacked(EvaluateNonlinearInvariantStrains(s, x, OmegaConvention::kAsPrinted));
  EXPECT_GT(printed.head<3>().cwiseAbs().maxCoeff(), 1e-2);
  const Vector6d exchanged = Stacked(EvaluateNonlinearInvariantStrains(s, x));
  EXPECT_LT(exchanged.head<3>().cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_GT(exchanged.tail<3>().cwiseAbs().maxCoeff(), 1e-2);  // Not invariant either way.
}

TEST(InvariantStrainsClosedFormTest, ATorusRotatedAboutItsNormalHideTheErratum) {
  const SurfaceJet jet = MakeTorus(3.0, 1.0)->Evaluate(0.7, 0.4);
  const SurfaceInvariants s = Invariants(jet);
  const SpaceField in_plane = RigidMotion(0.5, s.n, Vector3d::Zero());
  const Vector6d printed =
      Stacked(EvaluateNonlinearInvariantStrains(s, in_plane.On(jet), OmegaConvention::kAsPrinted));
  EXPECT_LT(printed.head<3>().norm(), 1e-15);
}

TEST(InvariantStrainsClosedFormTest, AnInflatedSphereHaveClosedForm) {
  const double radius = 2.0, w = 0.3;
  const SurfaceJet jet = MakeSphere(radius)->Evaluate(0.7, 0.4);
  const SurfaceInvariants s = Invariants(jet);
  SpaceField inflation;
  inflation.gradient = w / radius * Matrix3d::Identity();
  const double eps = w / radius;
  const Vector6d linear = Stacked(Linear(s, inflation.On(jet)));
  EXPECT_LT((linear - (Vector6d() << eps, eps, 0, 0, 0, 0).finished()).norm(), 1e-14);
  // N = (1 + eps)^2 n: zeta = (1 + eps) ((1 + eps)^2 - 1) / R.
  const double zeta = (1.0 + eps) * (std::pow(1.0 + eps, 2) - 1.0) / radius;
  const double green = eps + 0.5 * eps * eps;
  const Vector6d nonlinear = Stacked(EvaluateNonlinearInvariantStrains(s, inflation.On(jet)));
  EXPECT_LT((nonlinear - (Vector6d() << green, green, 0, zeta, zeta, 0).finished()).norm(), 1e-14);
}

TEST(InvariantStrainsClosedFormTest, ACylinderBentAlongItsAxisHaveClosedForm) {
  // gamma = x^2 / 2 with n = e_z at v = 0: phi_1 = -x, zeta_1 = -1, eps_2 = -kappa_2 gamma.
  const double radius = 2.0, x = 0.6;
  const SurfaceJet jet = MakeCylinder(radius)->Evaluate(x, 0.0);
  const SurfaceInvariants s = Invariants(jet);
  DisplacementJet delta;  // x^2 / 2 n
  const Vector3d n = s.n, n_v = s.n_d[1];
  delta.d = 0.5 * x * x * n;
  delta.d_u = x * n;
  delta.d_v = 0.5 * x * x * n_v;
  delta.d_uu = n;
  delta.d_uv = x * n_v;
  delta.d_vv = 0.5 * x * x * s.n_vv;
  const LinearInvariantStrains e = Linear(s, delta);
  EXPECT_NEAR(e.eps_1, 0.0, 1e-15);
  EXPECT_NEAR(e.eps_2, 0.5 * x * x / radius, 1e-15);
  EXPECT_NEAR(e.phi_1, -x, 1e-15);
  EXPECT_NEAR(e.phi_2, 0.0, 1e-15);
  EXPECT_NEAR(e.zeta_1, -1.0, 1e-15);
  EXPECT_NEAR(e.zeta_2, 0.0, 1e-15);
  EXPECT_NEAR(e.tau, 0.0, 1e-15);
}

// Through the hand-over from the principal frame to the other one: along a line into an umbilic of
// the ellipsoid, and into the flat centre of the monkey saddle, the energy is that of the kernel,
// which knows no umbilics.
class HandOverTest : public ::testing::TestWithParam<Vector2d> {};

TEST_P(HandOverTest, EnergyIsContinuous) {
  const double a = 2.0, b = 1.5, c = 0.7;
  const std::unique_ptr<ParametricSurface> ellipsoid = MakeEllipsoid(a, b, c);
  const std::unique_ptr<ParametricSurface> saddle = MakeMonkeySaddle(0.3);
  const Vector2d umbilic(0.0, std::acos(std::sqrt((a * a - b * b) / (a * a - c * c))));
  std::mt19937 generator(38407);
  const SpaceField field = RandomField(0.05, &generator);
  for (const ParametricSurface* surface : {ellipsoid.get(), saddle.get()}) {
    const Vector2d centre = surface == saddle.get() ? Vector2d(0.0, 0.0) : umbilic;
    int principal = 0, handed_over = 0;
    for (double distance = 0.1; distance > 1e-9; distance *= 0.7) {
      const Vector2d p = centre + distance * GetParam();
      const SurfaceJet jet = surface->Evaluate(p[0], p[1]);
      const SurfaceInvariants s = Invariants(jet);
      (s.umbilic ? handed_over : principal) += 1;
      const DisplacementJet x = field.On(jet);
      const Kinematics k = EvaluateKinematics(Invariants(jet, 1e9), x);
      const double linear = EnergyDensity(KernelLinear(k));
      EXPECT_NEAR(EnergyDensity(Stacked(Linear(s, x))) / linear, 1.0, 1e-11) << distance;
      const double nonlinear = EnergyDensity(KernelNonlinear(k));
      EXPECT_NEAR(
          EnergyDensity(Stacked(EvaluateNonlinearInvariantStrains(s, x))) / nonlinear, 1.0, 1e-11)
          << distance;
    }
    EXPECT_GT(principal, 5);
    EXPECT_GT(handed_over, 5);
  }
}
INSTANTIATE_TEST_SUITE_P(Directions,
                         HandOverTest,
                         ::testing::Values(Vector2d(1.0, 0.0),
                                           Vector2d(0.0, -1.0),
                                           Vector2d(0.6, 0.8)));

}  // namespace
}  // namespace darboux
