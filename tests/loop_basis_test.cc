#include "geometry/loop_basis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "geometry/parameter_domain.h"
#include "gtest/gtest.h"

namespace darboux {
namespace {

// A control mesh with its control points.
struct Body {
  ControlMesh mesh;
  Eigen::Matrix3Xd points;
};

Body Closed(const Eigen::Matrix3Xd& points, const std::vector<std::array<int, 3>>& triangles) {
  Body body;
  body.points = points;
  body.mesh.num_vertices = static_cast<int>(points.cols());
  body.mesh.num_elements = static_cast<int>(triangles.size());
  body.mesh.triangles = triangles;
  return body;
}

Body Tetrahedron() {
  Eigen::Matrix3Xd points(3, 4);
  points << 1, -1, -1, 1, 1, -1, 1, -1, 1, 1, -1, -1;
  return Closed(points, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
}

Body Icosahedron() {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Eigen::Matrix3Xd points(3, 12);
  points << -1, 1, -1, 1, 0, 0, 0, 0, g, g, -g, -g,  //
      g, g, -g, -g, -1, 1, -1, 1, 0, 0, 0, 0,        //
      0, 0, 0, 0, g, g, -g, -g, -1, 1, -1, 1;
  return Closed(
      points, {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
               {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
               {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
}

// Two apexes of valence `sides`, an equator of valence 4; no two control points alike.
Body DoublePyramid(int sides) {
  Eigen::Matrix3Xd points(3, sides + 2);
  std::vector<std::array<int, 3>> triangles;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2.0 * M_PI * k / sides;
    points.col(k) << std::cos(angle), std::sin(angle), 0.1 * std::cos(2.0 * angle + 0.4);
    triangles.push_back({k, (k + 1) % sides, sides});
    triangles.push_back({(k + 1) % sides, k, sides + 1});
  }
  points.col(sides) << 0.1, 0.0, 0.9;
  points.col(sides + 1) << 0.0, -0.2, -1.1;
  return Closed(points, triangles);
}

// C. Loop (1987): weight of each neighbour in the new position of a vertex.
double Beta(int valence) {
  const double c = 0.375 + 0.25 * std::cos(2.0 * M_PI / valence);
  return (0.625 - c * c) / valence;
}

std::vector<std::set<int>> Neighbours(const ControlMesh& mesh) {
  std::vector<std::set<int>> neighbours(mesh.num_vertices);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) neighbours[t[k]].insert({t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  return neighbours;
}

// One step of Loop subdivision of a closed mesh. Children of triangle f = (A, B, C), with a, b, c
// the midpoints of the sides opposite A, B, C: 4f = (A, c, b), 4f+1 = (c, B, a), 4f+2 = (b, a, C),
// 4f+3 = (a, b, c).
Body Subdivide(const Body& body) {
  const auto neighbours = Neighbours(body.mesh);
  std::map<std::pair<int, int>, int> edges;
  std::vector<Eigen::Vector3d> points(body.mesh.num_vertices);
  for (int i = 0; i < body.mesh.num_vertices; ++i) {
    const int valence = static_cast<int>(neighbours[i].size());
    points[i] = (1.0 - valence * Beta(valence)) * body.points.col(i);
    for (const int j : neighbours[i]) points[i] += Beta(valence) * body.points.col(j);
  }
  const auto midpoint = [&](int i, int j) {
    const auto inserted = edges.insert({std::minmax(i, j), static_cast<int>(points.size())});
    if (inserted.second) points.push_back(Eigen::Vector3d::Zero());
    return inserted.first->second;
  };
  std::vector<std::array<int, 3>> triangles;
  for (const auto& t : body.mesh.triangles) {
    const int a = midpoint(t[1], t[2]), b = midpoint(t[2], t[0]), c = midpoint(t[0], t[1]);
    triangles.insert(triangles.end(), {{t[0], c, b}, {c, t[1], a}, {b, a, t[2]}, {a, b, c}});
    // Each of the two triangles at an edge gives half: 3/16 of its ends, 1/8 of its apex.
    const int middle[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      points[middle[k]] +=
          0.1875 * (body.points.col(t[(k + 1) % 3]) + body.points.col(t[(k + 2) % 3])) +
          0.125 * body.points.col(t[k]);
    }
  }
  Eigen::Matrix3Xd all(3, points.size());
  for (size_t i = 0; i < points.size(); ++i) all.col(i) = points[i];
  return Closed(all, triangles);
}

// Limit position of every vertex by the limit mask.
Eigen::Matrix3Xd LimitPoints(const Body& body) {
  const auto neighbours = Neighbours(body.mesh);
  Eigen::Matrix3Xd limit(3, body.points.cols());
  for (int i = 0; i < body.mesh.num_vertices; ++i) {
    const int valence = static_cast<int>(neighbours[i].size());
    const double chi = 1.0 / (0.375 / Beta(valence) + valence);
    limit.col(i) = (1.0 - valence * chi) * body.points.col(i);
    for (const int j : neighbours[i]) limit.col(i) += chi * body.points.col(j);
  }
  return limit;
}

// Rows of BasisRow as columns: the limit surface and its derivatives.
Eigen::Matrix<double, 3, 6> Evaluate(
    const LoopBasis& basis, const Eigen::Matrix3Xd& points, int element, double s, double t) {
  const BasisMatrix rows = basis.Evaluate(element, s, t);
  const auto& vertices = basis.control_vertices(element);
  EXPECT_EQ(static_cast<size_t>(rows.cols()), vertices.size());
  Eigen::Matrix<double, 3, 6> jet = Eigen::Matrix<double, 3, 6>::Zero();
  for (size_t i = 0; i < vertices.size(); ++i) {
    jet += points.col(vertices[i]) * rows.col(i).transpose();
  }
  return jet;
}

std::array<double, 2> RandomPoint(std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double a = uniform(*gen), b = uniform(*gen);
  if (a + b > 1.0) return {1.0 - a, 1.0 - b};
  return {a, b};
}

Eigen::Matrix3Xd RandomPoints(int n, std::mt19937* gen) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return uniform(*gen); });
}

ParameterDomain Lattice(int m, int n) {
  ParameterDomain::Options options;
  options.divisions = {m, n};
  return ParameterDomain(options);
}

// Control values f(i, j) at the lattice points of a domain.
template <typename Function>
Eigen::VectorXd ControlValues(const ParameterDomain& domain, const Function& f) {
  Eigen::VectorXd values(domain.mesh().num_vertices);
  for (int j = -1; j <= domain.options().divisions[1] + 1; ++j) {
    for (int i = -1; i <= domain.options().divisions[0] + 1; ++i) {
      if (domain.VertexIndex(i, j) >= 0) values[domain.VertexIndex(i, j)] = f(i, j);
    }
  }
  return values;
}

// Value, gradient and second derivatives (11, 12, 22) in lattice coordinates.
Eigen::Matrix<double, 6, 1> InLattice(const LoopBasis& basis,
                                      const Eigen::VectorXd& values,
                                      const ElementPoint& at) {
  const BasisMatrix rows = basis.Evaluate(at.element, at.s, at.t);
  Eigen::Matrix<double, 6, 1> d = Eigen::Matrix<double, 6, 1>::Zero();
  for (int i = 0; i < rows.cols(); ++i) {
    d += values[basis.control_vertices(at.element)[i]] * rows.col(i);
  }
  const auto axes = ParameterDomain::ElementAxes(at.element);
  Eigen::Matrix2d from_lattice, second;  // d/ds = axes[0] . grad
  from_lattice << axes[0][0], axes[0][1], axes[1][0], axes[1][1];
  const Eigen::Matrix2d inverse = from_lattice.inverse();
  second << d[kDss], d[kDst], d[kDst], d[kDtt];
  const Eigen::Vector2d gradient = inverse * d.segment<2>(kDs);
  const Eigen::Matrix2d hessian = inverse * second * inverse.transpose();
  Eigen::Matrix<double, 6, 1> result;
  result << d[kValue], gradient, hessian(0, 0), hessian(0, 1), hessian(1, 1);
  return result;
}

TEST(RegularLoopBasisTest, IsAPartitionOfUnityWithoutNegativeValues) {
  std::mt19937 gen(51001);
  for (int k = 0; k < 200; ++k) {
    const auto st = RandomPoint(&gen);
    const auto basis = EvaluateRegularLoopBasis(st[0], st[1]);
    EXPECT_NEAR(basis.row(kValue).sum(), 1.0, 1e-15);
    EXPECT_GE(basis.row(kValue).minCoeff(), 0.0);
    for (int row = kDs; row <= kDtt; ++row) EXPECT_NEAR(basis.row(row).sum(), 0.0, 1e-14) << row;
  }
}

TEST(RegularLoopBasisTest, DerivativesMatchDifferencesOfTheRowBefore) {
  constexpr double kStep = 1e-4;
  constexpr int kNext[3][2] = {{kDs, kDt}, {kDss, kDst}, {kDst, kDtt}};
  std::mt19937 gen(51002);
  for (int k = 0; k < 50; ++k) {
    const auto st = RandomPoint(&gen);
    const auto basis = EvaluateRegularLoopBasis(st[0], st[1]);
    const auto ds = (EvaluateRegularLoopBasis(st[0] + kStep, st[1]) -
                     EvaluateRegularLoopBasis(st[0] - kStep, st[1]))
                        .eval();
    const auto dt = (EvaluateRegularLoopBasis(st[0], st[1] + kStep) -
                     EvaluateRegularLoopBasis(st[0], st[1] - kStep))
                        .eval();
    for (int row = kValue; row <= kDt; ++row) {
      EXPECT_LT((ds.row(row) / (2.0 * kStep) - basis.row(kNext[row][0])).norm(), 1e-7) << row;
      EXPECT_LT((dt.row(row) / (2.0 * kStep) - basis.row(kNext[row][1])).norm(), 1e-7) << row;
    }
  }
}

TEST(RegularLoopBasisTest, CornerHasTheLimitMask) {
  const auto basis = EvaluateRegularLoopBasis(0.0, 0.0);
  EXPECT_NEAR(basis(kValue, 0), 0.5, 1e-16);
  for (const int neighbour : {1, 2, 3, 5, 6, 7}) {
    EXPECT_NEAR(basis(kValue, neighbour), 1.0 / 12.0, 1e-16);
  }
  for (const int far : {4, 8, 9, 10, 11}) EXPECT_EQ(basis(kValue, far), 0.0);
}

TEST(LoopBasisTest, FastPathEqualsOpenSubdiv) {
  const ParameterDomain domain = Lattice(3, 2);
  LoopBasis::Options slow;
  slow.regular_fast_path = false;
  const LoopBasis fast_basis(domain.mesh()), slow_basis(domain.mesh(), slow);
  std::mt19937 gen(51003);
  const Eigen::Matrix3Xd points = RandomPoints(domain.mesh().num_vertices, &gen);
  for (int e = 0; e < domain.mesh().num_elements; ++e) {
    EXPECT_TRUE(fast_basis.IsRegular(e));
    EXPECT_FALSE(slow_basis.IsRegular(e));
    for (int k = 0; k < 20; ++k) {
      const auto st = RandomPoint(&gen);
      const auto fast = Evaluate(fast_basis, points, e, st[0], st[1]);
      const auto slow = Evaluate(slow_basis, points, e, st[0], st[1]);
      EXPECT_LT((fast - slow).cwiseAbs().maxCoeff(), 1e-12) << "element " << e;
    }
  }
}

// Also cubics, up to the constant that smoothing adds to their values and gradients: the quartic
// box spline reproduces them.
TEST(LoopBasisTest, ReproducesPolynomialsOfTheLattice) {
  const ParameterDomain domain = Lattice(4, 3);
  const LoopBasis basis(domain.mesh());
  std::mt19937 gen(51004);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::array<double, 10> c;
  for (double& x : c) x = uniform(gen);
  const auto linear = [&](double x, double y) { return c[0] + c[1] * x + c[2] * y; };
  const auto quadratic = [&](double x, double y) {
    return linear(x, y) + c[3] * x * x + c[4] * x * y + c[5] * y * y;
  };
  const auto cubic = [&](double x, double y) {
    return quadratic(x, y) + c[6] * x * x * x + c[7] * x * x * y + c[8] * x * y * y +
           c[9] * y * y * y;
  };
  const Eigen::VectorXd linear_values = ControlValues(domain, linear);
  const Eigen::VectorXd quadratic_values = ControlValues(domain, quadratic);
  const Eigen::VectorXd cubic_values = ControlValues(domain, cubic);
  // Limit mask 1/2, six times 1/12, over the neighbours +-(1,0), +-(0,1), +-(1,1).
  const double smoothing = (2.0 * c[3] + 2.0 * c[5] + 2.0 * (c[3] + c[4] + c[5])) / 12.0;
  for (int e = 0; e < domain.mesh().num_elements; ++e) {
    for (int k = 0; k < 5; ++k) {
      const auto st = RandomPoint(&gen);
      const ElementPoint at{e, st[0], st[1]};
      const auto q = domain.Lattice(at);
      const double x = q[0], y = q[1];
      Eigen::Matrix<double, 6, 1> expected;
      expected << linear(x, y), c[1], c[2], 0.0, 0.0, 0.0;
      EXPECT_LT((InLattice(basis, linear_values, at) - expected).norm(), 1e-12);
      expected << quadratic(x, y) + smoothing, c[1] + 2.0 * c[3] * x + c[4] * y,
          c[2] + c[4] * x + 2.0 * c[5] * y, 2.0 * c[3], c[4], 2.0 * c[5];
      EXPECT_LT((InLattice(basis, quadratic_values, at) - expected).norm(), 1e-12);
      const Eigen::Vector3d second(2.0 * c[3] + 6.0 * c[6] * x + 2.0 * c[7] * y,
                                   c[4] + 2.0 * c[7] * x + 2.0 * c[8] * y,
                                   2.0 * c[5] + 2.0 * c[8] * x + 6.0 * c[9] * y);
      EXPECT_LT((InLattice(basis, cubic_values, at).tail<3>() - second).norm(), 1e-12);
    }
  }
}

TEST(LoopBasisTest, IsTwiceDifferentiableAcrossRegularEdges) {
  const ParameterDomain domain = Lattice(4, 4);
  const LoopBasis basis(domain.mesh());
  std::mt19937 gen(51005);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::VectorXd values = ControlValues(domain, [&](int, int) { return uniform(gen); });
  // Cell (1, 1) and its neighbours: diagonal, right, upper edge.
  const auto element = [](int i, int j, int upper) { return 2 * (j * 4 + i) + upper; };
  for (int k = 0; k < 20; ++k) {
    const double x = 0.5 + 0.5 * uniform(gen);
    const std::array<std::pair<ElementPoint, ElementPoint>, 3> pairs = {{
        {{element(1, 1, 0), 0.0, x}, {element(1, 1, 1), x, 0.0}},
        {{element(1, 1, 0), 1.0 - x, x}, {element(2, 1, 1), 0.0, x}},
        {{element(1, 1, 1), x, 1.0 - x}, {element(1, 2, 0), x, 0.0}},
    }};
    for (const auto& pair : pairs) {
      const auto q0 = domain.Lattice(pair.first), q1 = domain.Lattice(pair.second);
      ASSERT_NEAR(q0[0], q1[0], 1e-15);
      ASSERT_NEAR(q0[1], q1[1], 1e-15);
      const auto a = InLattice(basis, values, pair.first);
      const auto b = InLattice(basis, values, pair.second);
      EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-13);
    }
  }
}

TEST(LoopBasisTest, ControlVerticesOfARegularElementAreItsTwelveNearest) {
  const ParameterDomain domain = Lattice(3, 3);
  const LoopBasis basis(domain.mesh());
  for (int e = 0; e < domain.mesh().num_elements; ++e) {
    std::set<int> expected;
    const auto neighbours = Neighbours(domain.mesh());
    for (const int corner : domain.mesh().triangles[e]) {
      expected.insert(neighbours[corner].begin(), neighbours[corner].end());
    }
    const auto& vertices = basis.control_vertices(e);
    EXPECT_EQ(vertices.size(), 12u);
    EXPECT_EQ(std::set<int>(vertices.begin(), vertices.end()), expected);
  }
}

TEST(LoopBasisDeathTest, ElementsOnTheMeshBoundaryAreABrokenInvariant) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // A BLAS may have started threads.
  ControlMesh mesh;
  mesh.num_vertices = 3;
  mesh.num_elements = 1;
  mesh.triangles = {{0, 1, 2}};
  EXPECT_DEATH(LoopBasis{mesh}, "lies on the boundary of the control mesh");
}

class IrregularLoopBasisTest : public ::testing::TestWithParam<int> {
 protected:
  // 0: tetrahedron; 1: icosahedron; 2: once subdivided icosahedron; otherwise a double pyramid.
  static Body MakeBody(int which) {
    if (which == 0) return Tetrahedron();
    if (which == 1) return Icosahedron();
    if (which == 2) return Subdivide(Icosahedron());
    return DoublePyramid(which);
  }

  const Body body_ = MakeBody(GetParam());
  const LoopBasis basis_{body_.mesh};
};

TEST_P(IrregularLoopBasisTest, IsAPartitionOfUnityAwayFromExtraordinaryVertices) {
  std::mt19937 gen(51006);
  for (int e = 0; e < basis_.num_elements(); ++e) {
    for (int k = 0; k < 5; ++k) {
      const auto st = RandomPoint(&gen);
      const BasisMatrix rows = basis_.Evaluate(e, st[0], st[1]);
      ASSERT_TRUE(rows.allFinite());
      EXPECT_NEAR(rows.row(kValue).sum(), 1.0, 1e-13);
      EXPECT_GE(rows.row(kValue).minCoeff(), -1e-14);
      for (int row = kDs; row <= kDtt; ++row) {
        EXPECT_NEAR(rows.row(row).sum(), 0.0, 1e-12 * (1.0 + rows.row(row).norm())) << row;
      }
    }
  }
}

TEST_P(IrregularLoopBasisTest, StaysFiniteCloseToExtraordinaryVertices) {
  for (int e = 0; e < basis_.num_elements(); ++e) {
    for (const double distance : {1e-2, 1e-3, 1e-4}) {
      for (const auto& st : std::vector<std::array<double, 2>>{{distance, 0.5 * distance},
                                                               {1.0 - distance, 0.5 * distance},
                                                               {0.5 * distance, 1.0 - distance}}) {
        EXPECT_TRUE(basis_.Evaluate(e, st[0], st[1]).allFinite());
      }
    }
  }
}

// The limit positions of the vertices of a subdivided mesh are points of the same surface.
TEST_P(IrregularLoopBasisTest, MeetsTheLimitPointsOfSubdividedMeshes) {
  Body fine = body_;
  for (int level = 0; level <= 4; ++level) {
    const Eigen::Matrix3Xd limit = LimitPoints(fine);
    const int children = 1 << (2 * level);
    for (int f = 0; f < fine.mesh.num_elements; ++f) {
      // Corners of the descendant in its ancestor: digits of f in base 4, coarsest first.
      Eigen::Matrix<double, 2, 3> st;
      st << 0, 1, 0, 0, 0, 1;
      for (int digit = level - 1; digit >= 0; --digit) {
        const Eigen::Vector2d a = st.col(0), b = st.col(1), c = st.col(2);
        switch ((f % children) >> (2 * digit) & 3) {
          case 0:
            st << a, 0.5 * (a + b), 0.5 * (a + c);
            break;
          case 1:
            st << 0.5 * (a + b), b, 0.5 * (b + c);
            break;
          case 2:
            st << 0.5 * (a + c), 0.5 * (b + c), c;
            break;
          case 3:
            st << 0.5 * (b + c), 0.5 * (a + c), 0.5 * (a + b);
        }
      }
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d x =
            Evaluate(basis_, body_.points, f / children, st(0, k), st(1, k)).col(kValue);
        ASSERT_LT((x - limit.col(fine.mesh.triangles[f][k])).norm(), 1e-10)
            << "level " << level << ", element " << f / children << " at " << st.col(k).transpose();
      }
    }
    fine = Subdivide(fine);
  }
}

// Wherever subdivision has produced a regular triangle, the surface there is the box spline.
TEST_P(IrregularLoopBasisTest, DerivativesMatchTheBoxSplineOfSubdividedMeshes) {
  constexpr int kLevels = 5;
  std::vector<Body> bodies = {body_};
  for (int level = 1; level <= kLevels; ++level) bodies.push_back(Subdivide(bodies.back()));
  std::vector<std::vector<std::set<int>>> neighbours;
  for (const Body& body : bodies) neighbours.push_back(Neighbours(body.mesh));
  std::mt19937 gen(51007);
  int compared = 0;
  for (int e = 0; e < basis_.num_elements(); ++e) {
    for (int k = 0; k < 10; ++k) {
      const auto st = RandomPoint(&gen);
      double s = st[0], t = st[1], scale = 1.0;
      int f = e, level = 0;
      const auto regular = [&] {
        const auto& corners = bodies[level].mesh.triangles[f];
        return std::all_of(corners.begin(), corners.end(), [&](int i) {
          return neighbours[level][i].size() == 6;
        });
      };
      while (!regular() && level < kLevels) {
        ++level;
        if (s + t <= 0.5) {
          s = 2.0 * s, t = 2.0 * t, f = 4 * f, scale *= 2.0;
        } else if (s >= 0.5) {
          s = 2.0 * s - 1.0, t = 2.0 * t, f = 4 * f + 1, scale *= 2.0;
        } else if (t >= 0.5) {
          s = 2.0 * s, t = 2.0 * t - 1.0, f = 4 * f + 2, scale *= 2.0;
        } else {
          s = 1.0 - 2.0 * s, t = 1.0 - 2.0 * t, f = 4 * f + 3, scale *= -2.0;
        }
      }
      if (!regular()) continue;
      // A mesh of this one triangle and its ring.
      ControlMesh local = bodies[level].mesh;
      std::swap(local.triangles[0], local.triangles[f]);
      local.num_elements = 1;
      Eigen::Matrix<double, 3, 6> expected =
          Evaluate(LoopBasis(local), bodies[level].points, 0, s, t);
      expected.middleCols<2>(kDs) *= scale;
      expected.rightCols<3>() *= scale * scale;
      const auto actual = Evaluate(basis_, body_.points, e, st[0], st[1]);
      EXPECT_LT((actual.col(kValue) - expected.col(kValue)).norm(), 1e-12);
      EXPECT_LT((actual - expected).middleCols<2>(kDs).norm(), 1e-11);
      EXPECT_LT((actual - expected).rightCols<3>().norm(), 1e-9);
      ++compared;
    }
  }
  EXPECT_GT(compared, 8 * basis_.num_elements());
}

INSTANTIATE_TEST_SUITE_P(TetrahedronIcosahedraDoublePyramids,
                         IrregularLoopBasisTest,
                         ::testing::Range(0, 13));

// In the chart in which two neighbours form a parallelogram.
TEST(LoopBasisTest, IsTwiceDifferentiableAcrossIrregularEdges) {
  const Body body = DoublePyramid(7);
  const LoopBasis basis(body.mesh);
  // Triangles 0 = (0, 1, N) and 1 = (1, 0, S): point (s, 0) of the one is (1 - s, 0) of the other.
  for (const double s : {0.1, 0.3, 0.5, 0.8}) {
    const auto a = Evaluate(basis, body.points, 0, s, 0.0);
    const auto b = Evaluate(basis, body.points, 1, 1.0 - s, 0.0);
    // The other's axes are those of the first, reversed.
    EXPECT_LT((a.col(kValue) - b.col(kValue)).norm(), 1e-12);
    EXPECT_LT((a.middleCols<2>(kDs) + b.middleCols<2>(kDs)).norm(), 1e-11);
    EXPECT_LT((a.rightCols<3>() - b.rightCols<3>()).norm(), 1e-9);
  }
}

// Nor does it jump, or change its sign, on the lines along which subdivision splits an element.
TEST(LoopBasisTest, SecondDerivativesAreContinuousWithinIrregularElements) {
  const Body body = DoublePyramid(7);
  const LoopBasis basis(body.mesh);
  for (const double x : {0.07, 0.19, 0.31, 0.44}) {
    for (const auto& st : std::vector<std::array<double, 2>>{{x, 0.5 - x},
                                                             {0.5, x},
                                                             {x, 0.5},
                                                             {0.5 * x, 0.25 - 0.5 * x},
                                                             {0.25, 0.5 * x},
                                                             {0.5 * x, 0.25},
                                                             {0.75, 0.5 * x}}) {
      const auto on = Evaluate(basis, body.points, 0, st[0], st[1]);
      for (const double ds : {-1e-9, 1e-9}) {
        for (const double dt : {-1e-9, 1e-9}) {
          const auto beside = Evaluate(basis, body.points, 0, st[0] + ds, st[1] + dt);
          EXPECT_LT((on - beside).norm(), 1e-6 * on.norm()) << st[0] << ", " << st[1];
        }
      }
    }
  }
}

TEST(LoopBasisTest, LimitOfTheIcosahedronHasItsSymmetry) {
  const Body body = Icosahedron();
  const LoopBasis basis(body.mesh);
  const std::array<std::array<double, 2>, 3> points = {
      {{1.0 / 3.0, 1.0 / 3.0}, {0.5, 0.0}, {0.5, 0.5}}};
  std::array<double, 3> radius{};
  for (int e = 0; e < basis.num_elements(); ++e) {
    for (size_t k = 0; k < points.size(); ++k) {
      const auto jet = Evaluate(basis, body.points, e, points[k][0], points[k][1]);
      const Eigen::Vector3d x = jet.col(kValue);
      if (e == 0) radius[k] = x.norm();
      EXPECT_NEAR(x.norm(), radius[k], 1e-12);
      const Eigen::Vector3d x_s = jet.col(kDs), x_t = jet.col(kDt);
      const Eigen::Vector3d n = x_s.cross(x_t).normalized();
      EXPECT_NEAR(n.dot(x.normalized()), 1.0, 1e-12);  // outward, along a symmetry axis
    }
    const double corner = Evaluate(basis, body.points, e, 0.0, 0.0).col(kValue).norm();
    EXPECT_NEAR(corner, LimitPoints(body).col(0).norm(), 1e-12);
  }
  EXPECT_NEAR(radius[1], radius[2], 1e-12);
}

TEST(LoopBasisTest, EvaluationFromSeveralThreadsAgrees) {
  const Body body = DoublePyramid(9);
  const LoopBasis basis(body.mesh);
  const auto sum = [&] {
    double total = 0.0;
    for (int k = 0; k < 50; ++k) {
      for (int e = 0; e < basis.num_elements(); ++e) {
        total += Evaluate(basis, body.points, e, 0.3 + 0.004 * k, 0.4).sum();
      }
    }
    return total;
  };
  const double expected = sum();
  std::array<double, 4> results{};
  std::vector<std::thread> threads;
  for (double& result : results) threads.emplace_back([&] { result = sum(); });
  for (std::thread& thread : threads) thread.join();
  for (const double result : results) EXPECT_EQ(result, expected);
}

}  // namespace
}  // namespace darboux
