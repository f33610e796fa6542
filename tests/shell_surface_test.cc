#include "geometry/shell_surface.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/quadrature.h"
#include "gtest/gtest.h"

namespace darboux {
namespace {

using SurfacePtr = std::shared_ptr<const ParametricSurface>;

ParameterDomain::Options Domain(std::array<double, 2> u,
                                std::array<double, 2> v,
                                std::array<int, 2> divisions,
                                std::array<double, 2> grading = {0.0, 0.0},
                                std::array<bool, 2> periodic = {false, false}) {
  ParameterDomain::Options options;
  options.u_range = u;
  options.v_range = v;
  options.divisions = divisions;
  options.grading = grading;
  options.periodic = periodic;
  return options;
}

SurfacePtr Expression(const std::array<std::string, 3>& xyz) {
  std::string error;
  SurfacePtr surface = MakeExpressionSurface(xyz, &error);
  EXPECT_NE(surface, nullptr) << error;
  return surface;
}

struct Sample {
  std::string name;
  SurfacePtr surface;
  ParameterDomain::Options domain;
};

std::vector<Sample> Samples() {
  constexpr double kTurn = 2.0 * M_PI;
  return {
      {"plane", MakePlane(), Domain({-1, 2}, {0, 1}, {5, 3})},
      {"graded_plane", MakePlane(), Domain({-1, 2}, {0, 1}, {5, 3}, {0.8, -0.6})},
      {"quarter_cylinder", MakeCylinder(0.7), Domain({0, 2}, {0, M_PI / 2}, {4, 6}, {0.8, -0.8})},
      {"tube", MakeCylinder(0.7), Domain({0, 2}, {0, kTurn}, {4, 8}, {-0.5, 0.0}, {false, true})},
      {"sphere_zone",
       MakeSphere(1.3),
       Domain({0, kTurn}, {-1.1, 1.3}, {12, 8}, {0, 0}, {true, false})},
      {"sphere_patch", MakeSphere(1.3), Domain({0.2, 1.8}, {-1.1, 1.3}, {5, 7}, {0.5, 0.3})},
      {"torus",
       MakeTorus(2.0, 0.6),
       Domain({0, kTurn}, {0, kTurn}, {16, 10}, {0, 0}, {true, true})},
      {"monkey_saddle", MakeMonkeySaddle(0.4), Domain({-1, 1}, {-1, 1}, {8, 8})},
      {"skewed",
       Expression({"u + 0.7*v", "0.5*v - 0.1*u*v", "0.2*u^2 - 0.3*u*v + 0.1*sin(3*v)"}),
       Domain({-1, 1}, {0, 2}, {6, 7}, {0.2, 0.4})}};
}

// A distance in the smaller of the two ways around.
double ParameterDistance(const ParameterDomain& domain,
                         const std::array<double, 2>& a,
                         const std::array<double, 2>& b) {
  double sum = 0.0;
  for (int d : {0, 1}) {
    const auto& range = d == 0 ? domain.options().u_range : domain.options().v_range;
    double off = a[d] - b[d];
    if (domain.options().periodic[d]) off = std::remainder(off, range[1] - range[0]);
    sum += off * off;
  }
  return std::sqrt(sum);
}

Eigen::Matrix3Xd RandomControl(int n, std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return uniform(*gen); });
}

// WeightRow -> 3-vector of a field of control displacements.
Eigen::Matrix<double, 3, 6> Kinematics(const StrainPoint& point,
                                       const std::vector<int>& vertices,
                                       const Eigen::Matrix3Xd& control) {
  EXPECT_EQ(static_cast<size_t>(point.weights.cols()), vertices.size());
  Eigen::Matrix<double, 3, 6> sum = Eigen::Matrix<double, 3, 6>::Zero();
  for (size_t i = 0; i < vertices.size(); ++i) {
    sum += control.col(vertices[i]) * point.weights.col(i).transpose();
  }
  return sum;
}

void ExpectSame(const StrainPoint& a, const StrainPoint& b, double tolerance) {
  EXPECT_LT((a.position - b.position).norm(), tolerance);
  EXPECT_LT((a.t1 - b.t1).norm(), tolerance);
  EXPECT_LT((a.t2 - b.t2).norm(), tolerance);
  EXPECT_LT((a.n - b.n).norm(), tolerance);
  EXPECT_NEAR(a.b11, b.b11, tolerance);
  EXPECT_NEAR(a.b12, b.b12, tolerance);
  EXPECT_NEAR(a.b22, b.b22, tolerance);
}

class ShellSurfaceTest : public ::testing::TestWithParam<Sample> {
 protected:
  const Sample& sample_ = GetParam();
  const ShellSurface shell_{sample_.surface, sample_.domain};
  const ShellSurface folded_{sample_.surface, sample_.domain, ShellSurface::Ghosts::kFolded};
};

TEST_P(ShellSurfaceTest, PositionParametersAndPointsAgree) {
  std::mt19937 gen(54001);
  std::uniform_real_distribution<double> uniform(0.0, 0.5);
  for (int e = 0; e < shell_.num_elements(); ++e) {
    const ElementPoint at{e, uniform(gen), uniform(gen)};
    const auto uv = shell_.Parameters(at);
    const SurfaceJet jet = sample_.surface->Evaluate(uv[0], uv[1]);
    EXPECT_EQ(shell_.Position(at), jet.x);
    EXPECT_EQ(shell_.ParametricJet(at).x_uvv, jet.x_uvv);
    const StrainPoint point = shell_.MakePoint(at, 0.5);
    EXPECT_EQ(point.position, jet.x);
    EXPECT_NEAR(point.t1.dot(jet.x_u.normalized()), 1.0, 1e-14);
    EXPECT_NEAR(point.n.dot(jet.x_u.cross(jet.x_v).normalized()), 1.0, 1e-14);
    const ElementPoint found = shell_.domain().Locate(uv[0], uv[1]);
    EXPECT_LT((shell_.Position(found) - jet.x).norm(), 1e-13);
  }
}

TEST_P(ShellSurfaceTest, QuadraturePointsAreThePointsOfTheRule) {
  for (const ShellSurface* shell : {&shell_, &folded_}) {
    double area = 0.0;
    for (const int n : {1, 3, 6, 12}) {
      const auto& rule = TriangleQuadrature(n);
      for (const int e : {0, 3, shell->num_elements() - 1}) {
        const auto points = shell->QuadraturePoints(e, n);
        ASSERT_EQ(points.size(), static_cast<size_t>(n));
        for (int k = 0; k < n; ++k) {
          const StrainPoint expected = shell->MakePoint({e, rule[k].s, rule[k].t}, rule[k].weight);
          ExpectSame(points[k], expected, 1e-15);
          EXPECT_EQ(points[k].area, expected.area);
          EXPECT_EQ(points[k].weights, expected.weights);
        }
      }
    }
    for (int e = 0; e < shell->num_elements(); ++e) {
      for (const StrainPoint& p : shell->QuadraturePoints(e, 1)) area += p.area;
    }
    EXPECT_NEAR(shell->area(), area, 1e-12 * area);
  }
}

// One point of the surface, seen from two elements: same frame, same kinematics (C2).
TEST_P(ShellSurfaceTest, NeighboursAgreeOnTheirCommonEdge) {
  std::mt19937 gen(54002);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Eigen::Matrix3Xd control = RandomControl(shell_.mesh().num_vertices, &gen);
  const int m = sample_.domain.divisions[0], n = sample_.domain.divisions[1];
  const auto element = [&](int i, int j, int upper) {
    return 2 * ((j + n) % n * m + (i + m) % m) + upper;
  };
  const auto compare = [&](const ElementPoint& a, const ElementPoint& b) {
    const StrainPoint pa = shell_.MakePoint(a), pb = shell_.MakePoint(b);
    ExpectSame(pa, pb, 1e-12);
    const auto ka = Kinematics(pa, shell_.control_vertices(a.element), control);
    const auto kb = Kinematics(pb, shell_.control_vertices(b.element), control);
    EXPECT_LT((ka - kb).norm(), 1e-11 * ka.norm()) << a.element << " and " << b.element;
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const double x = uniform(gen);
      compare({element(i, j, 0), 0.0, x}, {element(i, j, 1), x, 0.0});
      if (i + 1 < m || sample_.domain.periodic[0]) {
        compare({element(i, j, 0), 1.0 - x, x}, {element(i + 1, j, 1), 0.0, x});
      }
      if (j + 1 < n || sample_.domain.periodic[1]) {
        compare({element(i, j, 1), x, 1.0 - x}, {element(i, j + 1, 0), x, 0.0});
      }
    }
  }
}

TEST_P(ShellSurfaceTest, TranslationsHaveNoDerivatives) {
  for (const ShellSurface* shell : {&shell_, &folded_}) {
    Eigen::Matrix3Xd control(3, shell->mesh().num_vertices);
    control.colwise() = Eigen::Vector3d(1.0, -2.0, 3.0);
    for (int e = 0; e < shell->num_elements(); ++e) {
      for (const StrainPoint& p : shell->QuadraturePoints(e, 3)) {
        auto k = Kinematics(p, shell->control_vertices(e), control);
        EXPECT_LT((k.col(kRowValue) - Eigen::Vector3d(1.0, -2.0, 3.0)).norm(), 1e-13);
        k.col(kRowValue).setZero();
        EXPECT_LT(k.norm(), 1e-13 * p.weights.norm());
      }
    }
  }
}

TEST_P(ShellSurfaceTest, EveryControlVertexIsActive) {
  EXPECT_EQ(shell_.num_active_vertices(), shell_.mesh().num_vertices);
  for (int i = 0; i < shell_.mesh().num_vertices; ++i) EXPECT_TRUE(shell_.IsActive(i));
}

TEST_P(ShellSurfaceTest, FoldedGhostsLeaveTheVerticesOfTheShell) {
  const auto& domain = sample_.domain;
  const int columns = domain.divisions[0] + (domain.periodic[0] ? 0 : 1);
  const int rows = domain.divisions[1] + (domain.periodic[1] ? 0 : 1);
  EXPECT_EQ(folded_.num_active_vertices(), columns * rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      EXPECT_TRUE(folded_.IsActive(folded_.domain().VertexIndex(i, j)));
    }
  }
  for (int e = 0; e < folded_.num_elements(); ++e) {
    const auto& vertices = folded_.control_vertices(e);
    EXPECT_EQ(std::set<int>(vertices.begin(), vertices.end()).size(), vertices.size());
    for (const int vertex : vertices) EXPECT_TRUE(folded_.IsActive(vertex));
  }
}

// The folded space is the full one with ghosts put where the rule says.
TEST_P(ShellSurfaceTest, FoldedGhostsEqualGhostsThatFollowTheRule) {
  std::mt19937 gen(54003);
  const Eigen::Matrix3Xd control = RandomControl(shell_.mesh().num_vertices, &gen);
  Eigen::Matrix3Xd full = Eigen::Matrix3Xd::Zero(3, control.cols());
  const auto rule = shell_.domain().FoldedGhosts();
  for (size_t i = 0; i < rule.size(); ++i) {
    for (const auto& term : rule[i]) full.col(i) += term.second * control.col(term.first);
  }
  for (int e = 0; e < shell_.num_elements(); ++e) {
    const auto points = shell_.QuadraturePoints(e, 3), folded = folded_.QuadraturePoints(e, 3);
    for (size_t k = 0; k < points.size(); ++k) {
      const auto a = Kinematics(points[k], shell_.control_vertices(e), full);
      const auto b = Kinematics(folded[k], folded_.control_vertices(e), control);
      EXPECT_LT((a - b).norm(), 1e-13 * points[k].weights.norm());
    }
  }
}

TEST_P(ShellSurfaceTest, SizeIsTheDiameterOfTheBox) {
  Eigen::AlignedBox3d box;
  for (int e = 0; e < shell_.num_elements(); ++e) {
    for (const double s : {0.0, 1.0}) {
      for (const double t : {0.0, 1.0 - s}) box.extend(shell_.Position({e, s, t}));
    }
  }
  EXPECT_NEAR(shell_.size(), box.diagonal().norm(), 1e-12);
}

TEST_P(ShellSurfaceTest, CurvePointsHaveTangentAndConormal) {
  std::vector<std::pair<ShellSurface::CurvePoint, Side>> points;
  for (const Side side : {Side::kUMin, Side::kUMax, Side::kVMin, Side::kVMax}) {
    for (const auto& p : shell_.SidePoints(side, 2)) points.push_back({p, side});
  }
  for (const auto& entry : points) {
    const StrainPoint& p = entry.first.point;
    EXPECT_NEAR(entry.first.tangent.norm(), 1.0, 1e-14);
    EXPECT_NEAR(entry.first.conormal.norm(), 1.0, 1e-14);
    EXPECT_NEAR(entry.first.tangent.dot(entry.first.conormal), 0.0, 1e-14);
    const Eigen::Vector3d tangent = entry.first.tangent.x() * p.t1 + entry.first.tangent.y() * p.t2;
    const Eigen::Vector3d conormal =
        entry.first.conormal.x() * p.t1 + entry.first.conormal.y() * p.t2;
    const SurfaceJet jet = shell_.ParametricJet(entry.first.at);
    const bool at_u = entry.second == Side::kUMin || entry.second == Side::kUMax;
    // Along ascending parameter, and out of the domain.
    EXPECT_NEAR(tangent.dot((at_u ? jet.x_v : jet.x_u).normalized()), 1.0, 1e-13);
    const Eigen::Vector3d across = at_u ? jet.x_u : jet.x_v;
    const bool upper = entry.second == Side::kUMax || entry.second == Side::kVMax;
    EXPECT_GT((upper ? 1.0 : -1.0) * conormal.dot(across), 0.0);
    EXPECT_NEAR(conormal.dot(p.n), 0.0, 1e-14);
  }
}

TEST_P(ShellSurfaceTest, SidePointsLieOnTheirSideInOrder) {
  for (const Side side : {Side::kUMin, Side::kUMax, Side::kVMin, Side::kVMax}) {
    const bool at_u = side == Side::kUMin || side == Side::kUMax;
    const int across = at_u ? 0 : 1, along = 1 - across;
    const auto points = shell_.SidePoints(side, 3);
    if (!shell_.domain().HasSide(side)) {
      EXPECT_TRUE(points.empty());
      continue;
    }
    EXPECT_EQ(points.size(), 3u * sample_.domain.divisions[along]);
    const auto& range = at_u ? sample_.domain.u_range : sample_.domain.v_range;
    const bool upper = side == Side::kUMax || side == Side::kVMax;
    double last = -std::numeric_limits<double>::infinity();
    for (const auto& p : points) {
      const auto uv = shell_.Parameters(p.at);
      EXPECT_NEAR(uv[across], upper ? range[1] : range[0], 1e-14);
      EXPECT_GT(uv[along], last);
      last = uv[along];
      ExpectSame(p.point, shell_.MakePoint(p.at), 1e-15);
    }
  }
}

// Side u = u_max is the parameter line u = u_max.
TEST_P(ShellSurfaceTest, ParameterLinesAtTheEndsAreTheSides) {
  for (const Side side : {Side::kUMin, Side::kUMax, Side::kVMin, Side::kVMax}) {
    if (!shell_.domain().HasSide(side)) continue;
    const bool at_u = side == Side::kUMin || side == Side::kUMax;
    const auto& range = at_u ? sample_.domain.u_range : sample_.domain.v_range;
    const bool upper = side == Side::kUMax || side == Side::kVMax;
    const auto line = shell_.ParameterLinePoints(at_u ? 0 : 1, upper ? range[1] : range[0], 2);
    const auto points = shell_.SidePoints(side, 2);
    ASSERT_EQ(line.size(), points.size());
    for (size_t k = 0; k < line.size(); ++k) {
      EXPECT_LT((line[k].point.position - points[k].point.position).norm(), 1e-13);
      EXPECT_NEAR(line[k].point.area, points[k].point.area, 1e-14);
    }
  }
}

TEST_P(ShellSurfaceTest, ParameterLinesCrossEachElementWithinIt) {
  std::mt19937 gen(54004);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int parameter : {0, 1}) {
    const auto& range = parameter == 0 ? sample_.domain.u_range : sample_.domain.v_range;
    for (int k = 0; k < 10; ++k) {
      const double value = range[0] + uniform(gen) * (range[1] - range[0]);
      const auto points = shell_.ParameterLinePoints(parameter, value, 1);
      // The diagonals cut every cell's piece in two.
      EXPECT_EQ(points.size(), 2u * sample_.domain.divisions[1 - parameter]);
      double last = -std::numeric_limits<double>::infinity();
      std::set<int> elements;
      for (const auto& p : points) {
        const auto uv = shell_.Parameters(p.at);
        EXPECT_NEAR(uv[parameter], value, 1e-13);
        EXPECT_GT(uv[1 - parameter], last);
        last = uv[1 - parameter];
        EXPECT_TRUE(elements.insert(p.at.element).second);
      }
    }
  }
}

// On the surface itself the closest point is the point.
TEST_P(ShellSurfaceTest, ClosestPointFindsPointsOfTheSurface) {
  std::mt19937 gen(54005);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto& u = sample_.domain.u_range;
  const auto& v = sample_.domain.v_range;
  const auto check = [&](double fu, double fv) {
    const std::array<double, 2> uv = {u[0] + fu * (u[1] - u[0]), v[0] + fv * (v[1] - v[0])};
    const Eigen::Vector3d x = sample_.surface->Evaluate(uv[0], uv[1]).x;
    const ElementPoint at = shell_.ClosestPoint(x);
    EXPECT_LT((shell_.Position(at) - x).norm(), 1e-12) << fu << ", " << fv;
    EXPECT_LT(ParameterDistance(shell_.domain(), shell_.Parameters(at), uv), 1e-11);
  };
  for (int k = 0; k < 40; ++k) check(uniform(gen), uniform(gen));
  for (int k = 0; k < 5; ++k) {
    check(0.0, uniform(gen));
    check(1.0, uniform(gen));
    check(uniform(gen), 0.0);
    check(uniform(gen), 1.0);
  }
  for (const double a : {0.0, 1.0}) {
    for (const double b : {0.0, 1.0}) check(a, b);
  }
}

// No point of a fine sample of the surface is nearer, wherever x lies.
TEST_P(ShellSurfaceTest, ClosestPointIsNoFartherThanBruteForce) {
  std::mt19937 gen(54006);
  std::normal_distribution<double> normal(0.0, 1.0);
  constexpr int kSamples = 120;
  const auto& u = sample_.domain.u_range;
  const auto& v = sample_.domain.v_range;
  std::vector<Eigen::Vector3d> cloud;
  for (int i = 0; i <= kSamples; ++i) {
    for (int j = 0; j <= kSamples; ++j) {
      cloud.push_back(
          sample_.surface
              ->Evaluate(u[0] + (u[1] - u[0]) * i / kSamples, v[0] + (v[1] - v[0]) * j / kSamples)
              .x);
    }
  }
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : cloud) center += x / cloud.size();
  for (int k = 0; k < 200; ++k) {
    // From close to the centre of the body to twice its size away.
    const double reach = k % 4 == 0 ? 0.1 : k % 4 == 1 ? 0.4 : k % 4 == 2 ? 1.0 : 2.0;
    const Eigen::Vector3d x = center + reach * shell_.size() * 0.5 *
                                           Eigen::Vector3d(normal(gen), normal(gen), normal(gen));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& y : cloud) nearest = std::min(nearest, (y - x).norm());
    const ElementPoint at = shell_.ClosestPoint(x);
    EXPECT_LT((shell_.Position(at) - x).norm(), nearest + 1e-9) << x.transpose();
    // First-order conditions: nothing nearer along the surface.
    const auto uv = shell_.Parameters(at);
    const SurfaceJet jet = shell_.ParametricJet(at);
    const Eigen::Vector3d r = jet.x - x;
    for (int d : {0, 1}) {
      const Eigen::Vector3d tangent = (d == 0 ? jet.x_u : jet.x_v).normalized();
      const auto& range = d == 0 ? u : v;
      const double slope = r.dot(tangent) / shell_.size();
      const double edge = 1e-12 * (range[1] - range[0]);
      const bool open = !sample_.domain.periodic[d];
      if (!(open && uv[d] <= range[0] + edge)) {
        EXPECT_LT(slope, 1e-7) << "along " << d << " from " << x.transpose();
      }
      if (!(open && uv[d] >= range[1] - edge)) {
        EXPECT_GT(slope, -1e-7) << "along " << d << " from " << x.transpose();
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Samples,
                         ShellSurfaceTest,
                         ::testing::ValuesIn(Samples()),
                         [](const auto& info) { return info.param.name; });

// A field that is linear in the lattice is linear on a plane: its gradient is exact, for both
// treatments of ghosts.
TEST(ShellSurfacePlaneTest, LinearDisplacementFieldsAreReproduced) {
  const auto options = Domain({-1, 2}, {0, 1}, {5, 3});
  Eigen::Matrix3d gradient;
  gradient << 1, 2, 0, -3, 4, 0, 5, -6, 0;  // by x and y
  for (const auto ghosts : {ShellSurface::Ghosts::kIndependent, ShellSurface::Ghosts::kFolded}) {
    const ShellSurface shell(MakePlane(), options, ghosts);
    Eigen::Matrix3Xd control = Eigen::Matrix3Xd::Zero(3, shell.mesh().num_vertices);
    for (int j = -1; j <= 4; ++j) {
      for (int i = -1; i <= 6; ++i) {
        const int vertex = shell.domain().VertexIndex(i, j);
        if (vertex >= 0 && shell.IsActive(vertex)) {
          control.col(vertex) = gradient * Eigen::Vector3d(-1.0 + 3.0 * i / 5.0, j / 3.0, 0.0);
        }
      }
    }
    for (int e = 0; e < shell.num_elements(); ++e) {
      for (const StrainPoint& p : shell.QuadraturePoints(e, 6)) {
        const auto k = Kinematics(p, shell.control_vertices(e), control);
        EXPECT_LT((k.col(kRowValue) - gradient * p.position).norm(), 1e-13);
        EXPECT_LT((k.col(kRowD1) - gradient.col(0)).norm(), 1e-13);
        EXPECT_LT((k.col(kRowD2) - gradient.col(1)).norm(), 1e-13);
        EXPECT_LT(k.rightCols<3>().norm(), 1e-11);
      }
    }
  }
}

double Length(const std::vector<ShellSurface::CurvePoint>& points) {
  double length = 0.0;
  for (const auto& p : points) length += p.point.area;
  return length;
}

TEST(ShellSurfaceLengthTest, SidesHaveTheirExactLength) {
  const ShellSurface tube(MakeCylinder(0.7),
                          Domain({0, 2}, {0, 2 * M_PI}, {4, 8}, {-0.5, 0.0}, {false, true}));
  EXPECT_NEAR(Length(tube.SidePoints(Side::kUMin, 1)), 2.0 * M_PI * 0.7, 1e-13);
  EXPECT_NEAR(Length(tube.SidePoints(Side::kUMax, 1)), 2.0 * M_PI * 0.7, 1e-13);
  EXPECT_TRUE(tube.SidePoints(Side::kVMin, 1).empty());
  const ShellSurface sphere(MakeSphere(1.3), Domain({0.2, 1.8}, {-1.1, 1.3}, {5, 7}, {0.5, 0.3}));
  // Circles of latitude, with a graded lattice: the speed is linear, one point is exact.
  EXPECT_NEAR(Length(sphere.SidePoints(Side::kVMin, 1)), 1.6 * 1.3 * std::cos(1.1), 1e-13);
  EXPECT_NEAR(Length(sphere.SidePoints(Side::kVMax, 1)), 1.6 * 1.3 * std::cos(1.3), 1e-13);
  EXPECT_NEAR(Length(sphere.SidePoints(Side::kUMin, 1)), 2.4 * 1.3, 1e-13);
  const ShellSurface saddle(MakeMonkeySaddle(1.0), Domain({0, 1}, {0, 1}, {8, 8}));
  // z = u^3 on v = 0: integral of sqrt(1 + 9 u^4), to 1e-9 with five points.
  double exact = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    exact += std::sqrt(1.0 + 9.0 * std::pow((i + 0.5) / kSteps, 4)) / kSteps;
  }
  EXPECT_NEAR(Length(saddle.SidePoints(Side::kVMin, 5)), exact, 2e-9);
}

TEST(ShellSurfaceLengthTest, ParameterLinesHaveTheirExactLength) {
  const ShellSurface sphere(MakeSphere(1.3), Domain({0.2, 1.8}, {-1.1, 1.3}, {5, 7}, {0.5, 0.3}));
  for (const double f : {0.0, 0.1, 0.37, 0.5, 1.0}) {
    const double v = -1.1 + 2.4 * f;
    EXPECT_NEAR(Length(sphere.ParameterLinePoints(1, v, 2)), 1.6 * 1.3 * std::cos(v), 1e-13);
    EXPECT_NEAR(Length(sphere.ParameterLinePoints(0, 0.2 + 1.6 * f, 2)), 2.4 * 1.3, 1e-13);
  }
  // On a line of the lattice, and a hair beside it.
  const double on = sphere.domain().Parameter(1, 3.0)[0];
  for (const double off : {-1e-9, -1e-15, 0.0, 1e-15, 1e-9}) {
    EXPECT_NEAR(Length(sphere.ParameterLinePoints(1, on + off, 2)), 1.6 * 1.3 * std::cos(on), 1e-8);
  }
  const ShellSurface torus(MakeTorus(2.0, 0.6),
                           Domain({0, 2 * M_PI}, {0, 2 * M_PI}, {16, 10}, {0, 0}, {true, true}));
  for (const double v : {-0.4, 0.0, 1.0, 2.0 * M_PI, 7.0}) {
    EXPECT_NEAR(
        Length(torus.ParameterLinePoints(1, v, 1)), 2.0 * M_PI * (2.0 + 0.6 * std::cos(v)), 1e-12);
  }
}

TEST(ClosestPointTest, OfTheSphereIsRadial) {
  const ShellSurface shell(MakeSphere(1.3),
                           Domain({0, 2 * M_PI}, {-1.4, 1.4}, {12, 8}, {0, 0}, {true, false}));
  std::mt19937 gen(54007);
  std::uniform_real_distribution<double> angle(-M_PI, M_PI), latitude(-1.3, 1.3);
  for (const double distance : {1e-3, 0.05, 0.3, 1.0, 1.29, 1.31, 5.0, 100.0}) {
    // Distances differ by R d angle^2 / 2 only: rounding of R^2 shows in the angle.
    const double tolerance = 1e-7 * std::max(1.0, std::sqrt(1.3 / distance));
    for (int k = 0; k < 20; ++k) {
      const double u = angle(gen), v = latitude(gen);
      const Eigen::Vector3d direction(
          std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v));
      const Eigen::Vector3d x = shell.Position(shell.ClosestPoint(distance * direction));
      EXPECT_LT((x - 1.3 * direction).norm(), tolerance) << "from distance " << distance;
    }
  }
}

TEST(ClosestPointTest, OfTheTorusIsOnTheNearSideOfTheTube) {
  const ShellSurface shell(MakeTorus(2.0, 0.6),
                           Domain({0, 2 * M_PI}, {0, 2 * M_PI}, {16, 10}, {0, 0}, {true, true}));
  std::mt19937 gen(54008);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d x(uniform(gen), uniform(gen), uniform(gen));
    const double axis = std::hypot(x.x(), x.y());
    if (axis < 0.2) continue;
    const Eigen::Vector3d core = 2.0 / axis * Eigen::Vector3d(x.x(), x.y(), 0.0);
    const Eigen::Vector3d expected = core + 0.6 * (x - core).normalized();
    EXPECT_LT((shell.Position(shell.ClosestPoint(x)) - expected).norm(), 1e-7) << x.transpose();
  }
}

TEST(ClosestPointTest, BeyondAPlateIsOnItsRim) {
  const ShellSurface shell(MakePlane(), Domain({-1, 2}, {0, 1}, {5, 3}, {0.8, -0.6}));
  std::mt19937 gen(54009);
  std::uniform_real_distribution<double> uniform(-4.0, 4.0);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d x(uniform(gen), uniform(gen), uniform(gen));
    const Eigen::Vector3d expected(std::clamp(x.x(), -1.0, 2.0), std::clamp(x.y(), 0.0, 1.0), 0.0);
    EXPECT_LT((shell.Position(shell.ClosestPoint(x)) - expected).norm(), 1e-7) << x.transpose();
  }
}

// Every point of the surface is equally near; any of them will do, but it must be one.
TEST(ClosestPointTest, AtACentreOfCurvatureIsSomePoint) {
  const ShellSurface sphere(MakeSphere(1.3),
                            Domain({0, 2 * M_PI}, {-1.4, 1.4}, {12, 8}, {0, 0}, {true, false}));
  const ElementPoint at = sphere.ClosestPoint(Eigen::Vector3d::Zero());
  EXPECT_NEAR(sphere.Position(at).norm(), 1.3, 1e-14);
  EXPECT_LE(at.s + at.t, 1.0 + 1e-15);
}

// One cell: the lattice search sees nine points.
TEST(ClosestPointTest, WorksOnTheCoarsestMesh) {
  const ShellSurface shell(MakeSphere(1.0), Domain({0, 1.5}, {-0.7, 0.7}, {1, 1}));
  std::mt19937 gen(54010);
  std::uniform_real_distribution<double> u(0.0, 1.5), v(-0.7, 0.7), r(0.3, 3.0);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d direction = MakeSphere(1.0)->Evaluate(u(gen), v(gen)).x;
    const Eigen::Vector3d found = shell.Position(shell.ClosestPoint(r(gen) * direction));
    EXPECT_LT((found - direction).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace darboux
