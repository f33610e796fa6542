#include "geometry/parametric_surface.h"

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace darboux {
namespace {

std::vector<Eigen::Vector3d> Fields(const SurfaceJet& jet) {
  return {jet.x,
          jet.x_u,
          jet.x_v,
          jet.x_uu,
          jet.x_uv,
          jet.x_vv,
          jet.x_uuu,
          jet.x_uuv,
          jet.x_uvv,
          jet.x_vvv};
}

void ExpectNear(const SurfaceJet& actual,
                const SurfaceJet& expected,
                double relative_tolerance,
                const std::string& what) {
  constexpr std::array<const char*, 10> kNames = {
      "x", "x_u", "x_v", "x_uu", "x_uv", "x_vv", "x_uuu", "x_uuv", "x_uvv", "x_vvv"};
  const std::vector<Eigen::Vector3d> a = Fields(actual), e = Fields(expected);
  for (size_t k = 0; k < a.size(); ++k) {
    EXPECT_LE((a[k] - e[k]).norm(), relative_tolerance * std::max(1.0, e[k].norm()))
        << what << ", " << kNames[k] << ": " << a[k].transpose() << " is not " << e[k].transpose();
  }
}

std::unique_ptr<ParametricSurface> FromText(const std::array<std::string, 3>& xyz) {
  std::string error;
  std::unique_ptr<ParametricSurface> surface = MakeExpressionSurface(xyz, &error);
  EXPECT_NE(surface, nullptr) << error;
  return surface;
}

struct Kind {
  std::string name;
  std::unique_ptr<ParametricSurface> surface;
  std::unique_ptr<ParametricSurface> typed;  // The same, as a user would type it.
  bool outward;                              // Whether sigma_u x sigma_v must point outward.
};

std::vector<Kind> Kinds() {
  std::vector<Kind> kinds;
  const auto add = [&kinds](const std::string& name,
                            std::unique_ptr<ParametricSurface> surface,
                            const std::array<std::string, 3>& xyz,
                            bool outward) {
    kinds.push_back({name, std::move(surface), FromText(xyz), outward});
  };
  add("plane", MakePlane(), {"u", "v", "0"}, false);
  add("cylinder", MakeCylinder(2.5), {"u", "2.5*sin(v)", "2.5*cos(v)"}, true);
  add("sphere", MakeSphere(1.5), {"1.5*cos(v)*cos(u)", "1.5*cos(v)*sin(u)", "1.5*sin(v)"}, true);
  add("ellipsoid",
      MakeEllipsoid(1.0, 2.0, 3.0),
      {"1*cos(v)*cos(u)", "2*cos(v)*sin(u)", "3*sin(v)"},
      true);
  add("torus",
      MakeTorus(3.0, 0.5),
      {"(3 + 0.5*cos(v))*cos(u)", "(3 + 0.5*cos(v))*sin(u)", "0.5*sin(v)"},
      true);
  add("monkey saddle", MakeMonkeySaddle(0.7), {"u", "v", "0.7*(u^3 - 3*u*v^2)"}, false);
  return kinds;
}

TEST(ParametricSurfaceTest, NamedKindsEqualWhatAUserWouldType) {
  std::mt19937 gen(38403);
  std::uniform_real_distribution<double> uniform(-1.4, 1.4);
  for (const Kind& kind : Kinds()) {
    for (int k = 0; k < 20; ++k) {
      const double u = uniform(gen), v = uniform(gen);
      ExpectNear(kind.typed->Evaluate(u, v), kind.surface->Evaluate(u, v), 1e-14, kind.name);
    }
  }
}

// Each order is the derivative of the one below it: catches a lost factorial or a swapped index.
// Richardson: two central differences whose error terms h^2 cancel; the rest is about 1e-11.
TEST(ParametricSurfaceTest, EveryOrderIsTheDerivativeOfTheOneBelow) {
  constexpr double kStep = 2e-3, kTolerance = 2e-10;
  constexpr std::array<std::array<int, 2>, 6> kNext = {
      {{1, 2}, {3, 4}, {4, 5}, {6, 7}, {7, 8}, {8, 9}}};  // By u and by v, of fields 0 to 5.
  std::mt19937 gen(38404);
  std::uniform_real_distribution<double> uniform(-1.4, 1.4);
  for (const Kind& kind : Kinds()) {
    for (int repetition = 0; repetition < 5; ++repetition) {
      const double u = uniform(gen), v = uniform(gen);
      const std::vector<Eigen::Vector3d> jet = Fields(kind.surface->Evaluate(u, v));
      for (int k = 0; k < 6; ++k) {
        for (int by : {0, 1}) {
          const auto field = [&](double t) -> Eigen::Vector3d {
            return Fields(kind.surface->Evaluate(by == 0 ? u + t : u, by == 0 ? v : v + t))[k];
          };
          const auto central = [&](double h) -> Eigen::Vector3d {
            return (field(h) - field(-h)) / (2.0 * h);
          };
          const Eigen::Vector3d derivative = (4.0 * central(kStep / 2.0) - central(kStep)) / 3.0;
          EXPECT_LE((jet[kNext[k][by]] - derivative).norm(), kTolerance)
              << kind.name << ", field " << k << " by " << (by == 0 ? "u" : "v");
        }
      }
    }
  }
}

TEST(ParametricSurfaceTest, NormalsOfClosedKindsPointOutward) {
  std::mt19937 gen(38405);
  std::uniform_real_distribution<double> uniform(-1.4, 1.4);
  for (const Kind& kind : Kinds()) {
    if (!kind.outward) continue;
    for (int k = 0; k < 20; ++k) {
      const double u = uniform(gen), v = uniform(gen);
      const SurfaceJet jet = kind.surface->Evaluate(u, v);
      // From the axis of the cylinder, the circle in the torus, the centre of the others.
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      if (kind.name == "cylinder") centre.x() = jet.x.x();
      if (kind.name == "torus") centre = 3.0 * Eigen::Vector3d(std::cos(u), std::sin(u), 0.0);
      EXPECT_GT(jet.x_u.cross(jet.x_v).dot(jet.x - centre), 0.0) << kind.name;
    }
  }
}

TEST(ParametricSurfaceTest, PointsSatisfyTheImplicitEquations) {
  std::mt19937 gen(38406);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int k = 0; k < 50; ++k) {
    const double u = uniform(gen), v = uniform(gen);
    const Eigen::Vector3d c = MakeCylinder(2.0)->Evaluate(u, v).x;
    EXPECT_NEAR(std::hypot(c.y(), c.z()), 2.0, 1e-14);
    EXPECT_EQ(c.x(), u);
    EXPECT_NEAR(MakeSphere(2.0)->Evaluate(u, v).x.norm(), 2.0, 1e-14);
    const Eigen::Vector3d e = MakeEllipsoid(1.0, 2.0, 4.0)->Evaluate(u, v).x;
    EXPECT_NEAR(e.cwiseQuotient(Eigen::Vector3d(1.0, 2.0, 4.0)).norm(), 1.0, 1e-14);
    const Eigen::Vector3d t = MakeTorus(3.0, 1.0)->Evaluate(u, v).x;
    EXPECT_NEAR(std::hypot(std::hypot(t.x(), t.y()) - 3.0, t.z()), 1.0, 1e-14);
  }
}

TEST(ParametricSurfaceTest, MonkeySaddleHasItsThirdDerivatives) {
  const SurfaceJet jet = MakeMonkeySaddle(2.0)->Evaluate(0.0, 0.0);
  EXPECT_EQ(jet.x_uuu.z(), 12.0);  // 6 s
  EXPECT_EQ(jet.x_uuv.z(), 0.0);
  EXPECT_EQ(jet.x_uvv.z(), -12.0);  // -6 s
  EXPECT_EQ(jet.x_vvv.z(), 0.0);
  EXPECT_TRUE(jet.x_uu.isZero(0.0));  // An umbilic.
}

TEST(ExpressionSurfaceTest, MistakesNameTheCoordinate) {
  const auto error_of = [](const std::array<std::string, 3>& xyz) {
    std::string error;
    EXPECT_EQ(MakeExpressionSurface(xyz, &error), nullptr);
    return error;
  };
  EXPECT_EQ(error_of({"u", "v", "u*+"}),
            "z: column 4: found the end of the expression; expected a number, a name, '(' or a "
            "sign");
  EXPECT_EQ(error_of({"2 u", "v", "0"}),
            "x: column 3: found 'u'; expected an operator or the end (to multiply, write '*')");
  EXPECT_EQ(error_of({"u", "x", "0"}).rfind("y: column 1: unknown name 'x'; known: u, v, pi", 0),
            0u);
}

TEST(ExpressionSurfaceTest, MissingDerivativesShowInTheJet) {
  const auto surface = FromText({"u", "v", "sqrt(u)"});
  EXPECT_TRUE(surface->Evaluate(1.0, 0.0).x_uuu.allFinite());
  EXPECT_FALSE(surface->Evaluate(0.0, 0.0).x_u.allFinite());
  EXPECT_FALSE(surface->Evaluate(-1.0, 0.0).x.allFinite());
}

TEST(ExpressionSurfaceTest, HundredThousandEvaluationsTakeLessThanASecond) {
#ifdef NDEBUG
  constexpr double kLimit_s = 1.0;
#else
  constexpr double kLimit_s = 30.0;  // Unoptimised or with sanitizers.
#endif
  const auto surface = FromText({"cos(v)*(3+cos(u))", "sin(v)*(3+cos(u))", "sin(u)"});
  const auto start = std::chrono::steady_clock::now();
  double sum = 0.0;
  for (int k = 0; k < 100000; ++k) sum += surface->Evaluate(1e-4 * k, 0.3).x_uuv.sum();
  const std::chrono::duration<double> elapsed_s = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(std::isfinite(sum));
  EXPECT_LT(elapsed_s.count(), kLimit_s);
}

TEST(ReparametriseTest, EqualsTheComposedExpression) {
  // u = 2 + q1 - q1^3 / 2 and v = sin(q2), put in by hand.
  const auto surface = FromText({"u*v^2", "sin(u*v)", "exp(u) - u^3*v"});
  const std::string u_text = "(2 + u - u^3/2)", v_text = "sin(v)";
  const auto composed = FromText({u_text + "*" + v_text + "^2",
                                  "sin(" + u_text + "*" + v_text + ")",
                                  "exp(" + u_text + ") - " + u_text + "^3*" + v_text});
  std::mt19937 gen(38407);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 50; ++k) {
    const double p = uniform(gen), q = uniform(gen);
    const std::array<double, 4> u = {2.0 + p - p * p * p / 2.0, 1.0 - 1.5 * p * p, -3.0 * p, -3.0};
    const std::array<double, 4> v = {std::sin(q), std::cos(q), -std::sin(q), -std::cos(q)};
    const SurfaceJet jet = Reparametrise(surface->Evaluate(u[0], v[0]), u, v);
    ExpectNear(jet, composed->Evaluate(p, q), 1e-12, "composed");
  }
}

TEST(ReparametriseTest, IdentityChangesNothing) {
  const SurfaceJet jet = MakeTorus(3.0, 1.0)->Evaluate(0.4, -1.1);
  ExpectNear(Reparametrise(jet, {0.4, 1.0, 0.0, 0.0}, {-1.1, 1.0, 0.0, 0.0}), jet, 0.0, "identity");
}

TEST(MakeSurfaceJetTest, AppliesTheFactorials) {
  Taylor3 x;
  for (double& c : x.c) c = 1.0;
  const SurfaceJet jet = MakeSurfaceJet(x, 2.0 * x, 3.0 * x);
  const std::array<double, 10> factors = {1, 1, 1, 2, 1, 2, 6, 2, 2, 6};
  const std::vector<Eigen::Vector3d> fields = Fields(jet);
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(fields[k], factors[k] * Eigen::Vector3d(1.0, 2.0, 3.0)) << k;
  }
}

}  // namespace
}  // namespace darboux
