#include "geometry/surface_invariants.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "geometry/parametric_surface.h"

namespace darboux {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPi = 3.14159265358979323846;

// The base surface in skewed, nonlinear parameters:
// u = p + 0.4 q + 0.15 p q, v = -0.3 p + 0.8 q + 0.1 p^2, by the chain rule through third order.
class Reparametrised : public ParametricSurface {
 public:
  explicit Reparametrised(std::unique_ptr<ParametricSurface> base) : base_(std::move(base)) {}

  static Vector2d Map(double p, double q) {
    return {p + 0.4 * q + 0.15 * p * q, -0.3 * p + 0.8 * q + 0.1 * p * p};
  }

  SurfaceJet Evaluate(double p, double q) const override {
    const Vector2d at = Map(p, q);
    const SurfaceJet s = base_->Evaluate(at[0], at[1]);
    const Vector3d d[2] = {s.x_u, s.x_v};
    const Vector3d dd[2][2] = {{s.x_uu, s.x_uv}, {s.x_uv, s.x_vv}};
    const Vector3d ddd[4] = {s.x_uuu, s.x_uuv, s.x_uvv, s.x_vvv};
    Matrix2d m;  // (a, i): derivative of parameter a of the base.
    m << 1.0 + 0.15 * q, 0.4 + 0.15 * p, -0.3 + 0.2 * p, 0.8;
    const Matrix2d mm[2] = {(Matrix2d() << 0.0, 0.15, 0.15, 0.0).finished(),
                            (Matrix2d() << 0.2, 0.0, 0.0, 0.0).finished()};
    const auto first = [&](int i) -> Vector3d { return m(0, i) * d[0] + m(1, i) * d[1]; };
    const auto second = [&](int i, int j) {
      Vector3d x = Vector3d::Zero();
      for (int a = 0; a < 2; ++a) {
        x += mm[a](i, j) * d[a];
        for (int b = 0; b < 2; ++b) x += m(a, i) * m(b, j) * dd[a][b];
      }
      return x;
    };
    const auto third = [&](int i, int j, int k) {
      Vector3d x = Vector3d::Zero();
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) {
          x += (mm[a](i, j) * m(b, k) + mm[a](i, k) * m(b, j) + mm[a](j, k) * m(b, i)) * dd[a][b];
          for (int c = 0; c < 2; ++c) x += m(a, i) * m(b, j) * m(c, k) * ddd[a + b + c];
        }
      }
      return x;
    };
    return {s.x,
            first(0),
            first(1),
            second(0, 0),
            second(0, 1),
            second(1, 1),
            third(0, 0, 0),
            third(0, 0, 1),
            third(0, 1, 1),
            third(1, 1, 1)};
  }

 private:
  std::unique_ptr<ParametricSurface> base_;
};

// All lengths times `length`; parameters of the result are `parameter` times those of the base.
SurfaceJet Scaled(SurfaceJet s, double length, double parameter) {
  const double first = length / parameter, second = first / parameter, third = second / parameter;
  s.x *= length;
  for (Vector3d* x : {&s.x_u, &s.x_v}) *x *= first;
  for (Vector3d* x : {&s.x_uu, &s.x_uv, &s.x_vv}) *x *= second;
  for (Vector3d* x : {&s.x_uuu, &s.x_uuv, &s.x_uvv, &s.x_vvv}) *x *= third;
  return s;
}

SurfaceInvariants Invariants(const SurfaceJet& jet, double umbilic_tolerance = 1e-3) {
  SurfaceInvariantsOptions options;
  options.umbilic_tolerance = umbilic_tolerance;
  const std::optional<SurfaceInvariants> s = EvaluateSurfaceInvariants(jet, options);
  EXPECT_TRUE(s.has_value());
  return s.value();
}

// Ridders' extrapolated central difference of a vector function at 0.
VectorXd RiddersDerivative(const std::function<VectorXd(double)>& f, double step) {
  constexpr int kLevels = 10;
  std::vector<std::vector<VectorXd>> a(kLevels, std::vector<VectorXd>(kLevels));
  VectorXd best;
  VectorXd error;
  for (int i = 0; i < kLevels; ++i) {
    a[0][i] = (f(step) - f(-step)) / (2.0 * step);
    if (i == 0) {
      best = a[0][0];
      error = VectorXd::Constant(best.size(), std::numeric_limits<double>::max());
    }
    double factor = 1.96;
    for (int j = 1; j <= i; ++j) {
      a[j][i] = (a[j - 1][i] * factor - a[j - 1][i - 1]) / (factor - 1.0);
      factor *= 1.96;
      for (int k = 0; k < best.size(); ++k) {
        const double e = std::max(std::abs(a[j][i][k] - a[j - 1][i][k]),
                                  std::abs(a[j][i][k] - a[j - 1][i - 1][k]));
        if (e < error[k]) {
          error[k] = e;
          best[k] = a[j][i][k];
        }
      }
    }
    step /= 1.4;
  }
  return best;
}

VectorXd Concatenate(const std::vector<VectorXd>& parts) {
  VectorXd all(0);
  for (const VectorXd& part : parts) {
    const VectorXd head = all;
    all.resize(head.size() + part.size());
    all << head, part;
  }
  return all;
}

VectorXd Flat(const Matrix2d& m) { return Eigen::Map<const Eigen::Vector4d>(m.data()); }

// Everything that has a derivative member, and those members, in the same order.
VectorXd Differentiable(const SurfaceInvariants& s) {
  return Concatenate({Flat(s.first_form),
                      Flat(s.second_form),
                      Flat(s.frame),
                      Flat(s.b),
                      s.kappa,
                      s.t1,
                      s.t2,
                      s.n,
                      s.n_d[0],
                      s.n_d[1]});
}

VectorXd DerivativeMembers(const SurfaceInvariants& s, int a) {
  return Concatenate({Flat(s.first_form_d[a]),
                      Flat(s.second_form_d[a]),
                      Flat(s.frame_d[a]),
                      Flat(s.b_d[a]),
                      s.kappa_d[a],
                      s.t1_d[a],
                      s.t2_d[a],
                      s.n_d[a],
                      a == 0 ? s.n_uu : s.n_uv,
                      a == 0 ? s.n_uv : s.n_vv});
}

bool AllFinite(const SurfaceInvariants& s) {
  VectorXd all = Concatenate({Differentiable(s), DerivativeMembers(s, 0), DerivativeMembers(s, 1)});
  for (int i = 0; i < 2; ++i) {
    all = Concatenate({all,
                       Flat(s.christoffel[i]),
                       s.covariant[i][0],
                       s.covariant[i][1],
                       Flat(s.kappa_along_frame)});
  }
  return all.allFinite() && std::isfinite(s.mean_curvature) && std::isfinite(s.gaussian_curvature);
}

TEST(SurfaceInvariantsTest, TorusHasClosedForm) {
  const double major = 3.0, minor = 1.0;
  const std::unique_ptr<ParametricSurface> torus = MakeTorus(major, minor);
  for (const double u : {0.3, 2.0, 5.1}) {
    for (const double v : {-2.5, -0.4, 0.9, 1.6, 3.0}) {
      SCOPED_TRACE(::testing::Message() << "u = " << u << ", v = " << v);
      const SurfaceInvariants s = Invariants(torus->Evaluate(u, v));
      const double rho = major + minor * std::cos(v);
      EXPECT_FALSE(s.umbilic);
      EXPECT_NEAR(s.first_form(0, 0), rho * rho, 1e-14 * rho * rho);
      EXPECT_NEAR(s.first_form(0, 1), 0.0, 1e-15);
      EXPECT_NEAR(s.first_form(1, 1), minor * minor, 1e-15);
      EXPECT_NEAR(s.second_form(0, 0), -rho * std::cos(v), 1e-14);
      EXPECT_NEAR(s.second_form(0, 1), 0.0, 1e-15);
      EXPECT_NEAR(s.second_form(1, 1), -minor, 1e-15);
      EXPECT_NEAR(s.area_element, rho * minor, 1e-14);
      const Vector3d radial(std::cos(u), std::sin(u), 0.0);
      const Vector3d along(-std::sin(u), std::cos(u), 0.0);
      EXPECT_LT((s.n - std::cos(v) * radial - std::sin(v) * Vector3d::UnitZ()).norm(), 1e-15);
      EXPECT_LT((s.t1 - along).norm(), 1e-15);
      EXPECT_LT((s.t2 - s.n.cross(along)).norm(), 1e-15);
      // Outward normal: both curvatures negative outside, and that of the parallel the larger.
      EXPECT_NEAR(s.kappa[0], -std::cos(v) / rho, 1e-15);
      EXPECT_NEAR(s.kappa[1], -1.0 / minor, 1e-15);
      EXPECT_NEAR(s.gaussian_curvature, std::cos(v) / (rho * minor), 1e-15);
      EXPECT_NEAR(s.mean_curvature, -0.5 * (std::cos(v) / rho + 1.0 / minor), 1e-15);
      EXPECT_NEAR(s.kappa_d[1][0], major * std::sin(v) / (rho * rho), 1e-14);
      EXPECT_NEAR(s.kappa_d[0][0], 0.0, 1e-14);
      EXPECT_NEAR(s.kappa_d[1][1], 0.0, 1e-14);
      // Parallels have geodesic curvature sin v / rho, meridians none.
      EXPECT_NEAR(s.covariant[0][0](1), std::sin(v) / rho, 1e-14);
      EXPECT_NEAR(s.covariant[0][1](0), -std::sin(v) / rho, 1e-14);
      EXPECT_NEAR(s.covariant[1][1](0), 0.0, 1e-14);
      // Gamma^u_uv, Gamma^v_uu
      EXPECT_NEAR(s.christoffel[0](0, 1), -minor * std::sin(v) / rho, 1e-14);
      EXPECT_NEAR(s.christoffel[1](0, 0), rho * std::sin(v) / minor, 1e-14);
    }
  }
}

TEST(SurfaceInvariantsTest, SphereIsUmbilicEverywhere) {
  const double radius = 0.03125;  // m
  const std::unique_ptr<ParametricSurface> sphere = MakeSphere(radius);
  for (const double v : {-1.5, -0.7, 0.0, 0.4, 1.2}) {
    const SurfaceInvariants s = Invariants(sphere->Evaluate(0.8, v));
    EXPECT_TRUE(s.umbilic);
    EXPECT_TRUE(AllFinite(s));
    EXPECT_NEAR(s.kappa[0] * radius, -1.0, 1e-13);
    EXPECT_NEAR(s.kappa[1] * radius, -1.0, 1e-13);
    EXPECT_LT((s.b * radius + Matrix2d::Identity()).norm(), 1e-13);
    EXPECT_NEAR(s.t1.dot(s.t2), 0.0, 1e-15);
    EXPECT_LT((s.t1.cross(s.t2) - s.n).norm(), 1e-14);
    EXPECT_NEAR(s.covariant[0][0](1) * radius, std::tan(v), 1e-12 / std::cos(v));
    EXPECT_NEAR(s.kappa_d[1][0] * radius, 0.0, 1e-12);
  }
}

TEST(SurfaceInvariantsTest, CylinderHasClosedForm) {
  const double radius = 300.0;
  const SurfaceInvariants s = Invariants(MakeCylinder(radius)->Evaluate(17.0, 0.6));
  EXPECT_FALSE(s.umbilic);
  EXPECT_NEAR(s.kappa[0] * radius, 0.0, 1e-15);
  EXPECT_NEAR(s.kappa[1] * radius, -1.0, 1e-15);
  EXPECT_LT((s.t1 - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_EQ(s.gaussian_curvature, 0.0);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(s.kappa_along_frame.row(i).norm() * radius * radius, 0.0, 1e-14);
    for (int j = 0; j < 2; ++j) EXPECT_NEAR(s.covariant[i][j].norm() * radius, 0.0, 1e-14);
  }
}

TEST(SurfaceInvariantsTest, PlaneIsUmbilicEvenWithRoundingNoise) {
  const SurfaceInvariants flat = Invariants(MakePlane()->Evaluate(0.3, -2.0));
  EXPECT_TRUE(flat.umbilic);
  EXPECT_EQ(flat.kappa.norm(), 0.0);
  EXPECT_TRUE(AllFinite(flat));
  // A rotated plane in curved parameters: second derivatives are large, curvature is rounding.
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  const Reparametrised skewed(MakePlane());
  for (const double p : {-0.7, 0.1, 0.6}) {
    SurfaceJet jet = skewed.Evaluate(p, 0.4);
    for (Vector3d* x : {&jet.x_u, &jet.x_v, &jet.x_uu, &jet.x_uv, &jet.x_vv}) {
      *x = rotation * *x;
    }
    const SurfaceInvariants s = Invariants(jet);
    EXPECT_TRUE(s.umbilic);
    EXPECT_LT(s.kappa.norm(), 1e-15);
  }
}

TEST(SurfaceInvariantsTest, EllipsoidCurvaturesHaveClosedForm) {
  const double a = 2.0, b = 1.5, c = 0.7;
  const std::unique_ptr<ParametricSurface> ellipsoid = MakeEllipsoid(a, b, c);
  for (const double u : {0.2, 1.3, 4.0}) {
    for (const double v : {-1.1, 0.0, 0.8}) {
      const SurfaceJet jet = ellipsoid->Evaluate(u, v);
      const SurfaceInvariants s = Invariants(jet);
      const Vector3d& x = jet.x;
      const double w =
          std::pow(x[0] / (a * a), 2) + std::pow(x[1] / (b * b), 2) + std::pow(x[2] / (c * c), 2);
      const double abc2 = std::pow(a * b * c, 2);
      const double gauss = 1.0 / (abc2 * w * w);
      const double mean =
          (x.squaredNorm() - a * a - b * b - c * c) / (2.0 * abc2 * std::pow(w, 1.5));
      EXPECT_NEAR(s.gaussian_curvature / gauss, 1.0, 1e-13);
      EXPECT_NEAR(s.mean_curvature / mean, 1.0, 1e-13);
      EXPECT_NEAR(s.kappa[0] * s.kappa[1] / gauss, 1.0, 1e-13);
      EXPECT_NEAR(s.kappa.sum() / (2.0 * mean), 1.0, 1e-13);
      EXPECT_GE(s.kappa[0], s.kappa[1]);
    }
  }
}

// Eigenvectors of the second form in skewed parameters, with the principal direction of kappa_1 at
// a given angle from sigma_u: 0 makes L - kappa_1 E and M - kappa_1 F vanish, 90 degrees
// L - kappa_2 E, 60 degrees (along sigma_v) N - kappa_1 G, 150 degrees N - kappa_2 G.
class PrincipalDirectionTest : public ::testing::TestWithParam<double> {};

TEST_P(PrincipalDirectionTest, SolvesTheEigenproblem) {
  const double angle = GetParam() * kPi / 180.0;
  for (const double between : {60.0 * kPi / 180.0, 90.0 * kPi / 180.0, 0.01}) {
    const Vector2d kappa(0.7, -0.2);
    const Vector2d direction(std::cos(angle), std::sin(angle));
    const Vector2d normal(-direction[1], direction[0]);
    const Matrix2d shape =
        kappa[0] * direction * direction.transpose() + kappa[1] * normal * normal.transpose();
    const Vector2d u(2.0, 0.0), v(0.5 * std::cos(between), 0.5 * std::sin(between));
    SurfaceJet jet{};
    jet.x.setZero();
    jet.x_u << u, 0.0;
    jet.x_v << v, 0.0;
    jet.x_uu << 0.0, 0.0, u.dot(shape * u);
    jet.x_uv << 0.0, 0.0, u.dot(shape * v);
    jet.x_vv << 0.0, 0.0, v.dot(shape * v);
    jet.x_uuu = jet.x_uuv = jet.x_uvv = jet.x_vvv = Vector3d::Zero();
    const SurfaceInvariants s = Invariants(jet);
    const double tolerance = 1e-14 / std::pow(std::sin(between), 2);
    EXPECT_FALSE(s.umbilic);
    EXPECT_LT((s.kappa - kappa).norm(), tolerance);
    EXPECT_NEAR(std::abs(s.t1.head<2>().dot(direction)), 1.0, tolerance);
    EXPECT_NEAR(std::abs(s.t2.head<2>().dot(normal)), 1.0, tolerance);
    EXPECT_LT((s.t1.cross(s.t2) - s.n).norm(), tolerance);
    const Vector2d t1 = s.frame.row(0);
    EXPECT_LT(((s.second_form - kappa[0] * s.first_form) * t1).norm(), tolerance);
    EXPECT_TRUE(AllFinite(s));
  }
}
INSTANTIATE_TEST_SUITE_P(AngleDegrees,
                         PrincipalDirectionTest,
                         ::testing::Values(0.0, 30.0, 45.0, 60.0, 90.0, 135.0, 150.0, 179.999));

struct Case {
  std::string name;
  std::function<std::unique_ptr<ParametricSurface>()> make;
  std::vector<Vector2d> points;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::unique_ptr<ParametricSurface> Skewed(std::unique_ptr<ParametricSurface> base) {
  return std::make_unique<Reparametrised>(std::move(base));
}

std::vector<Case> Cases() {
  const std::vector<Vector2d> points = {{0.3, 0.2}, {0.9, -0.4}, {-0.5, 0.6}};
  return {
      {"torus", [] { return MakeTorus(3.0, 1.0); }, points},
      {"sphere", [] { return MakeSphere(2.0); }, points},
      {"cylinder", [] { return MakeCylinder(2.0); }, points},
      {"ellipsoid", [] { return MakeEllipsoid(2.0, 1.5, 0.7); }, points},
      {"monkey_saddle", [] { return MakeMonkeySaddle(0.3); }, points},
      {"skewed_torus", [] { return Skewed(MakeTorus(3.0, 1.0)); }, points},
      {"skewed_sphere", [] { return Skewed(MakeSphere(2.0)); }, points},
      {"skewed_ellipsoid", [] { return Skewed(MakeEllipsoid(2.0, 1.5, 0.7)); }, points},
      {"skewed_saddle", [] { return Skewed(MakeMonkeySaddle(0.3)); }, points},
  };
}

class SurfaceDerivativesTest : public ::testing::TestWithParam<Case> {
 protected:
  SurfaceDerivativesTest() : surface_(GetParam().make()) {}

  SurfaceInvariants At(const Vector2d& p) const {
    return Invariants(surface_->Evaluate(p[0], p[1]));
  }

  std::unique_ptr<ParametricSurface> surface_;
};

TEST_P(SurfaceDerivativesTest, MatchRiddersDifferences) {
  for (const Vector2d& p : GetParam().points) {
    const SurfaceInvariants s = At(p);
    for (int a = 0; a < 2; ++a) {
      const VectorXd expected = RiddersDerivative(
          [&](double step) { return Differentiable(At(p + step * Vector2d::Unit(a))); }, 0.05);
      const VectorXd actual = DerivativeMembers(s, a);
      ASSERT_EQ(actual.size(), expected.size());
      for (int k = 0; k < actual.size(); ++k) {
        EXPECT_NEAR(actual[k], expected[k], 2e-9 * (1.0 + std::abs(expected[k])))
            << "entry " << k << " by parameter " << a << " at " << p.transpose();
      }
    }
  }
}

TEST_P(SurfaceDerivativesTest, FrameIsOrthonormalAndItsRatesAreConsistent) {
  for (const Vector2d& p : GetParam().points) {
    const SurfaceInvariants s = At(p);
    EXPECT_LT((s.frame * s.first_form * s.frame.transpose() - Matrix2d::Identity()).norm(), 1e-14);
    EXPECT_LT((s.frame * s.second_form * s.frame.transpose() - s.b).norm(), 1e-13);
    EXPECT_LT((s.t1.cross(s.t2) - s.n).norm(), 1e-14);
    for (int i = 0; i < 2; ++i) {
      // t_i . t_j is constant, so nabla is antisymmetric in (j, k).
      EXPECT_NEAR(s.covariant[i][0](0), 0.0, 1e-13);
      EXPECT_NEAR(s.covariant[i][1](1), 0.0, 1e-13);
      EXPECT_NEAR(s.covariant[i][0](1) + s.covariant[i][1](0), 0.0, 1e-13);
      // The same from the vectors in space.
      EXPECT_NEAR(s.Along(i, s.t1_d[0], s.t1_d[1]).dot(s.t2), s.covariant[i][0](1), 1e-13);
    }
  }
}

// (nabla_X II)(Y, Z) is symmetric in all three: ties the derivatives of curvature, third
// derivatives of sigma, to the connection, second ones.
TEST_P(SurfaceDerivativesTest, SatisfyCodazzi) {
  for (const Vector2d& p : GetParam().points) {
    const SurfaceInvariants s = At(p);
    const auto gradient = [&](int i, int j, int k) {  // (nabla_{t_i} II)(t_j, t_k)
      double value = s.Along(i, s.b_d[0](j, k), s.b_d[1](j, k));
      for (int l = 0; l < 2; ++l) {
        value -= s.covariant[i][j](l) * s.b(l, k) + s.covariant[i][k](l) * s.b(j, l);
      }
      return value;
    };
    EXPECT_NEAR(gradient(1, 0, 0), gradient(0, 1, 0), 1e-12);
    EXPECT_NEAR(gradient(0, 1, 1), gradient(1, 0, 1), 1e-12);
    if (s.umbilic) continue;
    const double gap = s.kappa[0] - s.kappa[1];
    EXPECT_NEAR(s.kappa_along_frame(1, 0), s.covariant[0][0](1) * gap, 1e-12);
    EXPECT_NEAR(s.kappa_along_frame(0, 1), s.covariant[1][0](1) * gap, 1e-12);
  }
}

// Theorema egregium: K = t2[g1] - t1[g2] - g1^2 - g2^2 with g_i = (nabla_ti t1) . t2.
TEST_P(SurfaceDerivativesTest, SatisfyGauss) {
  for (const Vector2d& p : GetParam().points) {
    const SurfaceInvariants s = At(p);
    VectorXd g_d[2];
    for (int a = 0; a < 2; ++a) {
      g_d[a] = RiddersDerivative(
          [&](double step) -> VectorXd {
            const SurfaceInvariants near = At(p + step * Vector2d::Unit(a));
            return Vector2d(near.covariant[0][0](1), near.covariant[1][0](1));
          },
          0.05);
    }
    const double g1 = s.covariant[0][0](1), g2 = s.covariant[1][0](1);
    const double intrinsic =
        s.Along(1, g_d[0][0], g_d[1][0]) - s.Along(0, g_d[0][1], g_d[1][1]) - g1 * g1 - g2 * g2;
    EXPECT_NEAR(s.gaussian_curvature, intrinsic, 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Surfaces,
                         SurfaceDerivativesTest,
                         ::testing::ValuesIn(Cases()),
                         [](const ::testing::TestParamInfo<Case>& info) {
                           return info.param.name;
                         });

TEST(SurfaceInvariantsTest, DoNotDependOnTheParameters) {
  const auto make = [] { return MakeEllipsoid(2.0, 1.5, 0.7); };
  const std::unique_ptr<ParametricSurface> plain = make();
  const Reparametrised skewed(make());
  for (const Vector2d& p : {Vector2d(0.3, 0.2), Vector2d(0.9, -0.4), Vector2d(-0.5, 0.6)}) {
    const Vector2d at = Reparametrised::Map(p[0], p[1]);
    const SurfaceInvariants s = Invariants(plain->Evaluate(at[0], at[1]));
    const SurfaceInvariants r = Invariants(skewed.Evaluate(p[0], p[1]));
    ASSERT_FALSE(s.umbilic || r.umbilic);
    EXPECT_LT((s.kappa - r.kappa).norm(), 1e-13);
    EXPECT_LT((s.n - r.n).norm(), 1e-14);
    const double sign = s.t1.dot(r.t1) > 0.0 ? 1.0 : -1.0;  // Of t1 and t2 together.
    EXPECT_LT((s.t1 - sign * r.t1).norm(), 1e-13);
    EXPECT_LT((s.t2 - sign * r.t2).norm(), 1e-13);
    EXPECT_LT((s.kappa_along_frame - sign * r.kappa_along_frame).norm(), 1e-11);
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        EXPECT_LT((s.covariant[i][j] - sign * r.covariant[i][j]).norm(), 1e-11);
      }
    }
  }
}

// Of a > b > c: on the section y = 0, where kappa_1 = kappa_2 = -a c / b^3.
constexpr double kA = 2.0, kB = 1.5, kC = 0.7;
Vector2d EllipsoidUmbilic() {
  return {0.0, std::acos(std::sqrt((kA * kA - kB * kB) / (kA * kA - kC * kC)))};
}

TEST(UmbilicTest, OfTheEllipsoidIsFoundAndFinite) {
  const std::unique_ptr<ParametricSurface> ellipsoid = MakeEllipsoid(kA, kB, kC);
  const Vector2d umbilic = EllipsoidUmbilic();
  const SurfaceInvariants s = Invariants(ellipsoid->Evaluate(umbilic[0], umbilic[1]));
  EXPECT_TRUE(s.umbilic);
  EXPECT_TRUE(AllFinite(s));
  const double kappa = -kA * kC / (kB * kB * kB);
  EXPECT_NEAR(s.kappa[0], kappa, 1e-14);
  EXPECT_NEAR(s.kappa[1], kappa, 1e-14);
  // Derivatives of b in the frame along sigma_u need no principal directions.
  for (int a = 0; a < 2; ++a) {
    const VectorXd expected = RiddersDerivative(
        [&](double step) {
          const Vector2d p = umbilic + step * Vector2d::Unit(a);
          return Flat(Invariants(ellipsoid->Evaluate(p[0], p[1]), 1e9).b);
        },
        0.05);
    EXPECT_LT((Flat(s.b_d[a]) - expected).norm(), 1e-9);
  }
}

TEST(UmbilicTest, CurvaturesStayAccurateNextToOne) {
  // On y = 0 the section itself is one principal direction, its curvature that of the ellipse.
  const std::unique_ptr<ParametricSurface> ellipsoid = MakeEllipsoid(kA, kB, kC);
  const Vector2d umbilic = EllipsoidUmbilic();
  for (double distance = 1e-1; distance > 1e-12; distance *= 0.1) {
    for (const double side : {-1.0, 1.0}) {
      const double v = umbilic[1] + side * distance;
      const SurfaceInvariants s = Invariants(ellipsoid->Evaluate(0.0, v));
      const double q = std::pow(kA * std::sin(v), 2) + std::pow(kC * std::cos(v), 2);
      const double in_section = -kA * kC / std::pow(q, 1.5);
      const double across = -kA * kC / (kB * kB * std::sqrt(q));
      EXPECT_NEAR(s.kappa[0], std::max(in_section, across), 3e-15) << distance;
      EXPECT_NEAR(s.kappa[1], std::min(in_section, across), 3e-15) << distance;
    }
  }
}

TEST(UmbilicTest, CriterionDependsNeitherOnUnitsNorOnParameters) {
  const std::unique_ptr<ParametricSurface> ellipsoid = MakeEllipsoid(kA, kB, kC);
  const std::unique_ptr<ParametricSurface> saddle = MakeMonkeySaddle(0.3);
  for (double distance = 1e-6; distance < 0.1; distance *= 1.7) {
    const Vector2d p = EllipsoidUmbilic() + distance * Vector2d(0.6, 0.8);
    for (const SurfaceJet& jet :
         {ellipsoid->Evaluate(p[0], p[1]), saddle->Evaluate(0.6 * distance, 0.8 * distance)}) {
      const bool umbilic = Invariants(jet).umbilic;
      // Close by it is one, far off it is not, whatever the unit.
      if (distance < 1e-5) {
        EXPECT_TRUE(umbilic);
      }
      if (distance > 1e-2) {
        EXPECT_FALSE(umbilic);
      }
      for (const double length : {1e-3, 1e3}) {
        EXPECT_EQ(Invariants(Scaled(jet, length, 1.0)).umbilic, umbilic) << distance;
        EXPECT_EQ(Invariants(Scaled(jet, 1.0, length)).umbilic, umbilic) << distance;
      }
    }
  }
}

TEST(UmbilicTest, MonkeySaddleCentreIsFlatAndFinite) {
  const double scale = 0.3;
  const std::unique_ptr<ParametricSurface> saddle = MakeMonkeySaddle(scale);
  const SurfaceInvariants s = Invariants(saddle->Evaluate(0.0, 0.0));
  EXPECT_TRUE(s.umbilic);
  EXPECT_TRUE(AllFinite(s));
  EXPECT_EQ(s.kappa.norm(), 0.0);
  // b = 6 s [u, -v; -v, -u] + O(3)
  EXPECT_LT((s.b_d[0] - 6.0 * scale * Vector2d(1.0, -1.0).asDiagonal().toDenseMatrix()).norm(),
            1e-15);
  EXPECT_NEAR(s.b_d[1](0, 1), -6.0 * scale, 1e-15);
  for (const double r : {1e-8, 1e-4, 0.1, 1.0}) {
    const SurfaceInvariants near = Invariants(saddle->Evaluate(r * 0.6, r * 0.8));
    EXPECT_TRUE(AllFinite(near));
    EXPECT_EQ(near.umbilic, r < 1e-3) << r;
    const double gauss =
        -std::pow(6.0 * scale * r, 2) / std::pow(1.0 + std::pow(3.0 * scale * r * r, 2), 2);
    EXPECT_NEAR(near.gaussian_curvature / gauss, 1.0, 1e-12);
  }
}

TEST(SurfaceInvariantsTest, SingularParametersAreRefused) {
  SurfaceJet jet = MakeTorus(3.0, 1.0)->Evaluate(0.3, 0.2);
  jet.x_v = 2.0 * jet.x_u;
  EXPECT_FALSE(EvaluateSurfaceInvariants(jet).has_value());
  jet.x_v.setZero();
  EXPECT_FALSE(EvaluateSurfaceInvariants(jet).has_value());
  jet.x_v = Vector3d(std::numeric_limits<double>::quiet_NaN(), 0.0, 1.0);
  EXPECT_FALSE(EvaluateSurfaceInvariants(jet).has_value());
}

}  // namespace
}  // namespace darboux
