#include "geometry/strain_point.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "geometry/shell_surface.h"
#include "gtest/gtest.h"

namespace darboux {
namespace {

using SurfacePtr = std::shared_ptr<const ParametricSurface>;

RestJet RestOf(const SurfaceJet& jet) {
  return {jet.x, jet.x_u, jet.x_v, jet.x_uu, jet.x_uv, jet.x_vv};
}

// A basis function that is nothing: geometry alone.
StrainPoint Geometry(const ParametricSurface& surface, double u, double v, double turn = 0.0) {
  return MakeStrainPoint(RestOf(surface.Evaluate(u, v)),
                         BasisMatrix::Zero(6, 1),
                         {std::cos(turn), std::sin(turn)},
                         1.0);
}

SurfacePtr Skewed() {
  std::string error;
  SurfacePtr surface = MakeExpressionSurface(
      {"u + 0.3*v + 0.2*v^2", "0.5*v - 0.1*u*v + 0.1*u^3", "0.2*u^2 - 0.3*u*v + 0.1*sin(3*v)"},
      &error);
  EXPECT_NE(surface, nullptr) << error;
  return surface;
}

struct NamedSurface {
  std::string name;
  SurfacePtr surface;
};

std::vector<NamedSurface> Surfaces() {
  return {{"plane", MakePlane()},
          {"cylinder", MakeCylinder(0.7)},
          {"sphere", MakeSphere(1.3)},
          {"torus", MakeTorus(2.0, 0.6)},
          {"monkey saddle", MakeMonkeySaddle(0.4)},
          {"skewed", Skewed()}};
}

// A smooth function of space with its derivatives.
struct Field {
  Eigen::Vector3d a, b;

  double Value(const Eigen::Vector3d& x) const { return std::sin(a.dot(x)) + std::exp(b.dot(x)); }
  Eigen::Vector3d Gradient(const Eigen::Vector3d& x) const {
    return std::cos(a.dot(x)) * a + std::exp(b.dot(x)) * b;
  }
  Eigen::Matrix3d Hessian(const Eigen::Vector3d& x) const {
    return -std::sin(a.dot(x)) * a * a.transpose() + std::exp(b.dot(x)) * b * b.transpose();
  }
};

TEST(StrainPointTest, FrameIsOrthonormalAndRightHanded) {
  std::mt19937 gen(53001);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  for (const NamedSurface& s : Surfaces()) {
    for (int k = 0; k < 20; ++k) {
      const double u = uniform(gen), v = uniform(gen), turn = 3.0 * uniform(gen);
      const StrainPoint p = Geometry(*s.surface, u, v, turn);
      Eigen::Matrix3d frame;
      frame << p.t1, p.t2, p.n;
      EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-14) << s.name;
      EXPECT_NEAR(frame.determinant(), 1.0, 1e-14);
      const SurfaceJet jet = s.surface->Evaluate(u, v);
      EXPECT_GT(p.n.dot(jet.x_u.cross(jet.x_v)), 0.0);
      EXPECT_NEAR(p.n.dot(jet.x_u), 0.0, 1e-13);
      EXPECT_NEAR(p.n.dot(jet.x_v), 0.0, 1e-13);
      const Eigen::Vector3d wanted = std::cos(turn) * jet.x_u + std::sin(turn) * jet.x_v;
      EXPECT_NEAR(p.t1.dot(wanted.normalized()), 1.0, 1e-14);
      EXPECT_EQ(p.position, jet.x);
    }
  }
}

TEST(StrainPointTest, AreaIsTheWeightedAreaElement) {
  // R^2 cos v du dv on the sphere.
  const StrainPoint p = MakeStrainPoint(
      RestOf(MakeSphere(2.0)->Evaluate(0.3, 0.9)), BasisMatrix::Zero(6, 1), {1.0, 0.0}, 0.25);
  EXPECT_NEAR(p.area, 0.25 * 4.0 * std::cos(0.9), 1e-15);
}

TEST(StrainPointTest, CurvaturesHaveTheirClosedForms) {
  std::mt19937 gen(53002);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  constexpr double kTorusRadius = 2.0, kTubeRadius = 0.6;
  for (int k = 0; k < 20; ++k) {
    const double u = uniform(gen), v = uniform(gen), turn = uniform(gen);
    // Normals point outward: curvatures of convex surfaces are negative.
    const StrainPoint sphere = Geometry(*MakeSphere(1.3), u, v, turn);
    EXPECT_NEAR(sphere.b11, -1.0 / 1.3, 1e-13);
    EXPECT_NEAR(sphere.b22, -1.0 / 1.3, 1e-13);
    EXPECT_NEAR(sphere.b12, 0.0, 1e-13);
    // t1 at an angle to the axis: Euler's and Bertrand's formulas.
    const StrainPoint cylinder = Geometry(*MakeCylinder(0.7), u, v, turn);
    const double angle = std::atan2(0.7 * std::sin(turn), std::cos(turn));
    EXPECT_NEAR(cylinder.b11, -std::pow(std::sin(angle), 2) / 0.7, 1e-13);
    EXPECT_NEAR(cylinder.b12, -std::sin(angle) * std::cos(angle) / 0.7, 1e-13);
    EXPECT_NEAR(cylinder.b22, -std::pow(std::cos(angle), 2) / 0.7, 1e-13);
    const StrainPoint torus = Geometry(*MakeTorus(kTorusRadius, kTubeRadius), u, v);
    EXPECT_NEAR(torus.b11, -std::cos(v) / (kTorusRadius + kTubeRadius * std::cos(v)), 1e-13);
    EXPECT_NEAR(torus.b12, 0.0, 1e-13);
    EXPECT_NEAR(torus.b22, -1.0 / kTubeRadius, 1e-13);
    const StrainPoint plane = Geometry(*MakePlane(), u, v, turn);
    EXPECT_EQ(plane.b11, 0.0);
    EXPECT_EQ(plane.b12, 0.0);
    EXPECT_EQ(plane.b22, 0.0);
    // Graph z = f(u, v): K = (f_uu f_vv - f_uv^2) / w^4, 2 H = trace formula / w^3.
    constexpr double kScale = 0.4;
    const StrainPoint saddle = Geometry(*MakeMonkeySaddle(kScale), u, v, turn);
    const double fu = 3.0 * kScale * (u * u - v * v), fv = -6.0 * kScale * u * v;
    const double fuu = 6.0 * kScale * u, fuv = -6.0 * kScale * v, fvv = -fuu;
    const double w = std::sqrt(1.0 + fu * fu + fv * fv);
    EXPECT_NEAR(saddle.b11 * saddle.b22 - saddle.b12 * saddle.b12,
                (fuu * fvv - fuv * fuv) / std::pow(w, 4),
                1e-12);
    EXPECT_NEAR(
        saddle.b11 + saddle.b22,
        ((1.0 + fv * fv) * fuu - 2.0 * fu * fv * fuv + (1.0 + fu * fu) * fvv) / std::pow(w, 3),
        1e-12);
  }
}

// For the restriction of a function F of space to the surface,
//   (covariant Hessian)(t_i, t_j) = t_i . D^2F t_j + (grad F . n) b_ij:
// knows nothing of Christoffel symbols or coordinates.
TEST(StrainPointTest, RowsDifferentiateFunctionsOfSpace) {
  std::mt19937 gen(53003);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(uniform(gen), uniform(gen), uniform(gen)); };
  for (const NamedSurface& s : Surfaces()) {
    for (int k = 0; k < 20; ++k) {
      const RestJet x = RestOf(s.surface->Evaluate(uniform(gen), uniform(gen)));
      const double turn = 3.0 * uniform(gen);
      const Eigen::Vector2d direction(std::cos(turn), std::sin(turn));
      std::array<Field, 3> fields;
      BasisMatrix basis(6, fields.size());
      for (size_t i = 0; i < fields.size(); ++i) {
        fields[i] = {vector(), vector()};
        const Eigen::Vector3d g = fields[i].Gradient(x.x);
        const Eigen::Matrix3d h = fields[i].Hessian(x.x);
        basis.col(i) << fields[i].Value(x.x), g.dot(x.x_s), g.dot(x.x_t),
            g.dot(x.x_ss) + x.x_s.dot(h * x.x_s), g.dot(x.x_st) + x.x_s.dot(h * x.x_t),
            g.dot(x.x_tt) + x.x_t.dot(h * x.x_t);
      }
      const StrainPoint p = MakeStrainPoint(x, basis, direction, 1.0);
      ASSERT_EQ(p.weights.cols(), 3);
      for (size_t i = 0; i < fields.size(); ++i) {
        const Eigen::Vector3d g = fields[i].Gradient(x.x);
        const Eigen::Matrix3d h = fields[i].Hessian(x.x);
        Eigen::Matrix<double, 6, 1> expected;
        expected << fields[i].Value(x.x), g.dot(p.t1), g.dot(p.t2),
            p.t1.dot(h * p.t1) + g.dot(p.n) * p.b11, p.t1.dot(h * p.t2) + g.dot(p.n) * p.b12,
            p.t2.dot(h * p.t2) + g.dot(p.n) * p.b22;
        EXPECT_LT((p.weights.col(i) - expected).norm(), 1e-12 * (1.0 + expected.norm())) << s.name;
      }
    }
  }
}

// Under a turn of the frame d_i is a vector, H_ij and b_ij are tensors; the area stays.
TEST(StrainPointTest, RowsTransformAsTensorsWhenTheFrameTurns) {
  std::mt19937 gen(53004);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const BasisMatrix basis = BasisMatrix::NullaryExpr(6, 5, [&] { return uniform(gen); });
  for (const NamedSurface& s : Surfaces()) {
    const RestJet x = RestOf(s.surface->Evaluate(0.3, -0.4));
    const StrainPoint a = MakeStrainPoint(x, basis, {1.0, 0.0}, 0.5);
    const StrainPoint b = MakeStrainPoint(x, basis, {-0.4, 1.7}, 0.5);
    Eigen::Matrix2d turn;  // b's frame in components of a's
    turn << b.t1.dot(a.t1), b.t1.dot(a.t2), b.t2.dot(a.t1), b.t2.dot(a.t2);
    EXPECT_NEAR(a.area, b.area, 1e-15);
    const auto tensor = [](double m11, double m12, double m22) {
      return (Eigen::Matrix2d() << m11, m12, m12, m22).finished();
    };
    EXPECT_LT((turn * tensor(a.b11, a.b12, a.b22) * turn.transpose() - tensor(b.b11, b.b12, b.b22))
                  .norm(),
              1e-13)
        << s.name;
    for (int i = 0; i < basis.cols(); ++i) {
      const auto wa = a.weights.col(i), wb = b.weights.col(i);
      EXPECT_EQ(wa[kRowValue], wb[kRowValue]);
      EXPECT_LT((turn * wa.segment<2>(kRowD1) - wb.segment<2>(kRowD1)).norm(), 1e-13);
      EXPECT_LT((turn * tensor(wa[kRowH11], wa[kRowH12], wa[kRowH22]) * turn.transpose() -
                 tensor(wb[kRowH11], wb[kRowH12], wb[kRowH22]))
                    .norm(),
                1e-12)
          << s.name;
    }
  }
}

// Nor do they depend on the coordinates: the same point seen from linear combinations of (s, t).
TEST(StrainPointTest, RowsDoNotDependOnTheElementCoordinates) {
  std::mt19937 gen(53005);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const BasisMatrix basis = BasisMatrix::NullaryExpr(6, 4, [&] { return uniform(gen); });
  const RestJet x = RestOf(Skewed()->Evaluate(0.3, 0.2));
  // s = p + q, t = 2 q: d/dp = d/ds, d/dq = d/ds + 2 d/dt.
  RestJet y = x;
  y.x_t = x.x_s + 2.0 * x.x_t;
  y.x_st = x.x_ss + 2.0 * x.x_st;
  y.x_tt = x.x_ss + 4.0 * x.x_st + 4.0 * x.x_tt;
  BasisMatrix other = basis;
  other.row(kDt) = basis.row(kDs) + 2.0 * basis.row(kDt);
  other.row(kDst) = basis.row(kDss) + 2.0 * basis.row(kDst);
  other.row(kDtt) = basis.row(kDss) + 4.0 * basis.row(kDst) + 4.0 * basis.row(kDtt);
  const StrainPoint a = MakeStrainPoint(x, basis, {1.0, 0.0}, 2.0);
  const StrainPoint b = MakeStrainPoint(y, other, {1.0, 0.0}, 1.0);
  EXPECT_LT((a.weights - b.weights).norm(), 1e-12 * a.weights.norm());
  EXPECT_NEAR(a.area, b.area, 1e-15);
  EXPECT_NEAR(a.b11, b.b11, 1e-13);
  EXPECT_NEAR(a.b12, b.b12, 1e-13);
  EXPECT_NEAR(a.b22, b.b22, 1e-13);
}

TEST(StrainPointDeathTest, DegenerateSurfacesAreABrokenInvariant) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // A BLAS may have started threads.
  // The pole of the sphere in its own parameters, without rounding: x_u = 0.
  RestJet pole = RestOf(MakeSphere(1.0)->Evaluate(0.0, 0.5 * M_PI));
  pole.x_s.setZero();
  EXPECT_DEATH(MakeStrainPoint(pole, BasisMatrix::Zero(6, 1), {1.0, 0.0}, 1.0), "degenerates");
}

// ------------------------------------------------------------------------------------------------
// Rows of a shell's elements: a displacement in the Loop space, differentiated numerically in (u,
// v) and turned into covariant derivatives with Christoffel symbols written out by hand.

struct Christoffel {
  double u_uu, u_uv, u_vv, v_uu, v_uv, v_vv;  // Gamma^c_ab as c_ab
};

struct HandSurface {
  std::string name;
  SurfacePtr surface;
  std::function<Christoffel(double, double)> gamma;
  std::array<double, 2> u_range, v_range;
};

std::vector<HandSurface> HandSurfaces() {
  constexpr double kMajor = 2.0, kMinor = 0.6, kScale = 0.4;
  return {
      {"torus",
       MakeTorus(kMajor, kMinor),
       [](double, double v) {
         const double w = kMajor + kMinor * std::cos(v);
         return Christoffel{
             0.0, -kMinor * std::sin(v) / w, 0.0, w * std::sin(v) / kMinor, 0.0, 0.0};
       },
       {0.2, 1.7},
       {-0.5, 1.9}},
      {"monkey saddle",
       MakeMonkeySaddle(kScale),
       // Of a graph z = f: Gamma^c_ab = f_c f_ab / (1 + |grad f|^2).
       [](double u, double v) {
         const double fu = 3.0 * kScale * (u * u - v * v), fv = -6.0 * kScale * u * v;
         const double fuu = 6.0 * kScale * u, fuv = -6.0 * kScale * v, fvv = -fuu;
         const double w = 1.0 + fu * fu + fv * fv;
         return Christoffel{
             fu * fuu / w, fu * fuv / w, fu * fvv / w, fv * fuu / w, fv * fuv / w, fv * fvv / w};
       },
       {-0.7, 0.9},
       {-0.8, 0.6}},
      {"cylinder",
       MakeCylinder(0.7),
       [](double, double) {
         return Christoffel{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
       },
       {0.0, 2.0},
       {0.3, 1.6}}};
}

class ShellRowsTest : public ::testing::TestWithParam<std::array<double, 2>> {};  // grading

TEST_P(ShellRowsTest, EqualHandComputedCovariantDerivatives) {
  constexpr double kStep = 2e-3;
  std::mt19937 gen(53006);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const HandSurface& s : HandSurfaces()) {
    ParameterDomain::Options options;
    options.u_range = s.u_range;
    options.v_range = s.v_range;
    options.divisions = {3, 4};
    options.grading = GetParam();
    const ShellSurface shell(s.surface, options);
    const Eigen::Matrix3Xd control = Eigen::Matrix3Xd::NullaryExpr(
        3, shell.mesh().num_vertices, [&] { return uniform(gen) - 0.5; });
    const auto displacement = [&](double u, double v) -> Eigen::Vector3d {
      const ElementPoint at = shell.domain().Locate(u, v);
      const StrainPoint p = shell.MakePoint(at);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int i = 0; i < p.weights.cols(); ++i) {
        sum += p.weights(kRowValue, i) * control.col(shell.control_vertices(at.element)[i]);
      }
      return sum;
    };
    for (int element = 0; element < shell.num_elements(); ++element) {
      const ElementPoint at{element, 0.25 + 0.1 * uniform(gen), 0.25 + 0.1 * uniform(gen)};
      const auto uv = shell.Parameters(at);
      const double u = uv[0], v = uv[1];
      // Small enough to stay within the polynomial of this element.
      const auto q = shell.domain().Lattice(at);
      const double hu = kStep * shell.domain().Parameter(0, q[0])[1];
      const double hv = kStep * shell.domain().Parameter(1, q[1])[1];
      const Eigen::Vector3d center = displacement(u, v);
      // Fourth-order differences.
      const auto first = [&](double du, double dv, double h) -> Eigen::Vector3d {
        return (8.0 * (displacement(u + du, v + dv) - displacement(u - du, v - dv)) -
                (displacement(u + 2.0 * du, v + 2.0 * dv) -
                 displacement(u - 2.0 * du, v - 2.0 * dv))) /
               (12.0 * h);
      };
      const auto second = [&](double du, double dv) -> Eigen::Vector3d {
        return (16.0 * (displacement(u + du, v + dv) + displacement(u - du, v - dv)) -
                (displacement(u + 2.0 * du, v + 2.0 * dv) +
                 displacement(u - 2.0 * du, v - 2.0 * dv)) -
                30.0 * center) /
               12.0;
      };
      const Eigen::Vector3d d_u = first(hu, 0.0, hu), d_v = first(0.0, hv, hv);
      const Eigen::Vector3d uu = second(hu, 0.0), vv = second(0.0, hv);
      const Eigen::Vector3d uv_mixed = 0.25 * (second(hu, hv) - second(hu, -hv)) / (hu * hv);
      const Christoffel g = s.gamma(u, v);
      const Eigen::Vector3d h_uu = uu / (hu * hu) - g.u_uu * d_u - g.v_uu * d_v;
      const Eigen::Vector3d h_uv = uv_mixed - g.u_uv * d_u - g.v_uv * d_v;
      const Eigen::Vector3d h_vv = vv / (hv * hv) - g.u_vv * d_u - g.v_vv * d_v;
      // Frame with t1 along sigma_u: t1 = sigma_u / a, t2 = (sigma_v - (sigma_v.t1) t1) / c.
      const SurfaceJet jet = s.surface->Evaluate(u, v);
      const Eigen::Vector3d t1 = jet.x_u.normalized();
      const double a = jet.x_u.norm(), along = jet.x_v.dot(t1);
      const double c = (jet.x_v - along * t1).norm();
      const auto t2_of = [&](const Eigen::Vector3d& by_u, const Eigen::Vector3d& by_v) {
        return Eigen::Vector3d((by_v - along / a * by_u) / c);
      };
      const Eigen::Vector3d d1 = d_u / a, d2 = t2_of(d_u, d_v);
      const Eigen::Vector3d h11 = h_uu / (a * a), h12 = t2_of(h_uu, h_uv) / a;
      const Eigen::Vector3d h22 = t2_of(t2_of(h_uu, h_uv), t2_of(h_uv, h_vv));

      const StrainPoint p = shell.MakePoint(at);
      EXPECT_LT((p.t1 - t1).norm(), 1e-14);
      Eigen::Matrix<double, 3, 6> rows = Eigen::Matrix<double, 3, 6>::Zero();
      for (int i = 0; i < p.weights.cols(); ++i) {
        rows += control.col(shell.control_vertices(element)[i]) * p.weights.col(i).transpose();
      }
      EXPECT_LT((rows.col(kRowValue) - center).norm(), 1e-14);
      const double scale = rows.norm();
      EXPECT_LT((rows.col(kRowD1) - d1).norm(), 1e-8 * scale) << s.name << " " << element;
      EXPECT_LT((rows.col(kRowD2) - d2).norm(), 1e-8 * scale) << s.name << " " << element;
      EXPECT_LT((rows.col(kRowH11) - h11).norm(), 1e-7 * scale) << s.name << " " << element;
      EXPECT_LT((rows.col(kRowH12) - h12).norm(), 1e-7 * scale) << s.name << " " << element;
      EXPECT_LT((rows.col(kRowH22) - h22).norm(), 1e-7 * scale) << s.name << " " << element;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grading,
                         ShellRowsTest,
                         ::testing::Values(std::array<double, 2>{0.0, 0.0},
                                           std::array<double, 2>{0.6, -0.8}));

// ------------------------------------------------------------------------------------------------
// Areas

double Area(const SurfacePtr& surface, const ParameterDomain::Options& options, int num_points) {
  const ShellSurface shell(surface, options);
  double area = 0.0;
  for (int e = 0; e < shell.num_elements(); ++e) {
    for (const StrainPoint& p : shell.QuadraturePoints(e, num_points)) area += p.area;
  }
  return area;
}

struct AreaCase {
  int num_points;
  double order;  // in the element size: degree + 1, rounded up to even by symmetry
};

class AreaTest : public ::testing::TestWithParam<AreaCase> {};

TEST_P(AreaTest, ConvergesAtTheOrderOfTheRule) {
  // A zone of the sphere: R^2 (u1 - u0) (sin v1 - sin v0).
  ParameterDomain::Options options;
  options.u_range = {0.2, 1.4};
  options.v_range = {-0.5, 1.1};
  options.grading = {0.3, -0.4};
  const SurfacePtr sphere = MakeSphere(1.3);
  const double exact = 1.69 * 1.2 * (std::sin(1.1) + std::sin(0.5));
  std::array<double, 2> error;
  for (int k : {0, 1}) {
    options.divisions = k == 0 ? std::array<int, 2>{3, 3} : std::array<int, 2>{6, 6};
    error[k] = std::abs(Area(sphere, options, GetParam().num_points) - exact) / exact;
  }
  EXPECT_LT(error[1], 2e-2);
  EXPECT_GT(std::log2(error[0] / error[1]), GetParam().order - 0.3)
      << error[0] << " -> " << error[1];
}

INSTANTIATE_TEST_SUITE_P(
    Rules,
    AreaTest,
    ::testing::Values(AreaCase{1, 2.0}, AreaCase{3, 4.0}, AreaCase{6, 6.0}, AreaCase{12, 8.0}),
    [](const auto& info) { return std::to_string(info.param.num_points); });

TEST(AreaTest, OfClosedAndDevelopableSurfacesIsExact) {
  ParameterDomain::Options options;
  options.divisions = {12, 12};
  options.u_range = {0.0, 2.0 * M_PI};
  options.v_range = {0.0, 2.0 * M_PI};
  options.periodic = {true, true};
  // Trapezoidal sums of a periodic function.
  EXPECT_NEAR(Area(MakeTorus(2.0, 0.6), options, 3) / (4.0 * M_PI * M_PI * 2.0 * 0.6), 1.0, 1e-13);
  options.u_range = {-1.0, 3.0};
  options.periodic = {false, true};
  options.grading = {0.8, 0.0};
  EXPECT_NEAR(Area(MakeCylinder(0.7), options, 1) / (4.0 * 2.0 * M_PI * 0.7), 1.0, 1e-13);
}

}  // namespace
}  // namespace darboux
