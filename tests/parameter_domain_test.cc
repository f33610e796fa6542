#include "geometry/parameter_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace darboux {
namespace {

constexpr std::array<Side, 4> kSides = {Side::kUMin, Side::kUMax, Side::kVMin, Side::kVMax};

ParameterDomain::Options MakeOptions(std::array<int, 2> divisions,
                                     std::array<bool, 2> periodic = {false, false}) {
  ParameterDomain::Options options;
  options.u_range = {-1.0, 4.0};
  options.v_range = {2.0, 2.5};
  options.divisions = divisions;
  options.periodic = periodic;
  return options;
}

// Open, periodic and graded domains, down to the smallest.
std::vector<ParameterDomain::Options> SampleOptions() {
  std::vector<ParameterDomain::Options> samples = {MakeOptions({1, 1}),
                                                   MakeOptions({1, 3}),
                                                   MakeOptions({2, 1}),
                                                   MakeOptions({5, 7}),
                                                   MakeOptions({4, 1}, {true, false}),
                                                   MakeOptions({7, 5}, {true, false}),
                                                   MakeOptions({3, 6}, {false, true}),
                                                   MakeOptions({4, 4}, {true, true}),
                                                   MakeOptions({9, 5}, {true, true})};
  samples.push_back(MakeOptions({6, 5}));
  samples.back().grading = {0.8, -0.8};
  samples.push_back(MakeOptions({6, 5}));
  samples.back().grading = {-0.99, 0.4};
  samples.push_back(MakeOptions({6, 5}, {true, false}));
  samples.back().grading = {0.0, 0.7};
  return samples;
}

class ParameterDomainTest : public ::testing::TestWithParam<ParameterDomain::Options> {
 protected:
  const ParameterDomain domain_{GetParam()};
  const std::array<int, 2> divisions_ = GetParam().divisions;
  const std::array<bool, 2> periodic_ = GetParam().periodic;
};

TEST(ParameterDomainSizeTest, OpenSquaresHaveThePlateBenchmarksUnknowns) {
  // theory.md, erratum 3: 1,077, 3,669 and 13,461 dof.
  for (const auto& expected :
       std::vector<std::array<int, 3>>{{16, 359, 1077}, {32, 1223, 3669}, {64, 4487, 13461}}) {
    const ParameterDomain domain(MakeOptions({expected[0], expected[0]}));
    EXPECT_EQ(domain.mesh().num_vertices, expected[1]);
    EXPECT_EQ(3 * domain.mesh().num_vertices, expected[2]);
    EXPECT_EQ(domain.mesh().num_elements, 2 * expected[0] * expected[0]);
  }
}

TEST(ParameterDomainSizeTest, PeriodicDirectionsHaveNoGhosts) {
  EXPECT_EQ(ParameterDomain(MakeOptions({8, 5}, {true, false})).mesh().num_vertices, 8 * (5 + 3));
  EXPECT_EQ(ParameterDomain(MakeOptions({8, 5}, {false, true})).mesh().num_vertices, (8 + 3) * 5);
  const ParameterDomain torus(MakeOptions({8, 5}, {true, true}));
  EXPECT_EQ(torus.mesh().num_vertices, 8 * 5);
  EXPECT_EQ(torus.mesh().triangles.size(), 2u * 8 * 5);
}

TEST_P(ParameterDomainTest, EveryElementVertexIsInteriorWithSixNeighbours) {
  const ControlMesh& mesh = domain_.mesh();
  EXPECT_EQ(mesh.num_elements, 2 * divisions_[0] * divisions_[1]);
  std::map<std::pair<int, int>, int> directed;
  std::vector<int> valence(mesh.num_vertices, 0);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_GE(t[k], 0);
      ASSERT_LT(t[k], mesh.num_vertices);
      ++valence[t[k]];
      ++directed[{t[k], t[(k + 1) % 3]}];
    }
  }
  for (const auto& edge : directed) EXPECT_EQ(edge.second, 1) << "not an oriented manifold";
  for (int e = 0; e < mesh.num_elements; ++e) {
    for (const int vertex : mesh.triangles[e]) {
      EXPECT_EQ(valence[vertex], 6);
      for (const auto& edge : directed) {
        if (edge.first.second != vertex) continue;
        EXPECT_EQ(directed.count({vertex, edge.first.first}), 1u) << "vertex on the mesh boundary";
      }
    }
  }
  // Nothing superfluous: every control vertex belongs to a triangle.
  EXPECT_EQ(std::count(valence.begin(), valence.end(), 0), 0);
}

TEST_P(ParameterDomainTest, TriangleCornersAreTheLatticePointsOfTheElement) {
  for (int e = 0; e < domain_.mesh().num_elements; ++e) {
    constexpr double kCorners[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    for (int k = 0; k < 3; ++k) {
      const auto q = domain_.Lattice({e, kCorners[k][0], kCorners[k][1]});
      EXPECT_EQ(domain_.VertexIndex(static_cast<int>(q[0]), static_cast<int>(q[1])),
                domain_.mesh().triangles[e][k]);
    }
  }
}

TEST_P(ParameterDomainTest, ParameterFollowsTheGradingFormula) {
  for (int direction : {0, 1}) {
    const auto range = direction == 0 ? GetParam().u_range : GetParam().v_range;
    const double g = GetParam().grading[direction], length = range[1] - range[0];
    for (int k = 0; k <= 40; ++k) {
      const double f = k / 40.0, p = g > 0.0 ? 1.0 - f : f;
      // scene.md: distance from the favoured end d = (1-|g|) q + |g| q^2, times the range.
      const double d = length * ((1.0 - std::abs(g)) * p + std::abs(g) * p * p);
      const double expected = g > 0.0 ? range[1] - d : range[0] + d;
      EXPECT_NEAR(domain_.Parameter(direction, f * divisions_[direction])[0], expected, 1e-14);
    }
    EXPECT_NEAR(domain_.Parameter(direction, 0.0)[0], range[0], 1e-15);
    EXPECT_NEAR(domain_.Parameter(direction, divisions_[direction])[0], range[1], 1e-15);
  }
}

TEST_P(ParameterDomainTest, GradingConcentratesCellsTowardsTheFavouredEnd) {
  for (int direction : {0, 1}) {
    const double g = GetParam().grading[direction];
    const double first = domain_.Parameter(direction, 0.0)[1];
    const double last = domain_.Parameter(direction, divisions_[direction])[1];
    if (g == 0.0) {
      EXPECT_NEAR(first, last, 1e-15);
    } else {
      // Slopes (1 - |g|) at the favoured end, (1 + |g|) at the other.
      const double ratio = (1.0 - std::abs(g)) / (1.0 + std::abs(g));
      EXPECT_NEAR(g > 0.0 ? last / first : first / last, ratio, 1e-13);
    }
  }
}

TEST_P(ParameterDomainTest, DerivativesOfTheParameterAreExact) {
  constexpr double kStep = 1e-3;
  for (int direction : {0, 1}) {
    for (int k = 1; k < 10; ++k) {
      const double q = 0.1 * k * divisions_[direction];
      const auto center = domain_.Parameter(direction, q);
      const auto above = domain_.Parameter(direction, q + kStep);
      const auto below = domain_.Parameter(direction, q - kStep);
      for (int order = 0; order < 3; ++order) {  // Quadratics: differences are exact.
        EXPECT_NEAR((above[order] - below[order]) / (2.0 * kStep), center[order + 1], 1e-11);
      }
    }
  }
}

TEST_P(ParameterDomainTest, LatticeCoordinateInvertsParameter) {
  std::mt19937 gen(52001);
  for (int direction : {0, 1}) {
    std::uniform_real_distribution<double> uniform(0.0, divisions_[direction]);
    for (int k = 0; k < 50; ++k) {
      const double q = k == 0 ? 0.0 : uniform(gen);
      const double parameter = domain_.Parameter(direction, q)[0];
      EXPECT_NEAR(domain_.LatticeCoordinate(direction, parameter), q, 1e-12);
    }
  }
}

TEST_P(ParameterDomainTest, PeriodicParametersAreBroughtIntoTheRange) {
  for (int direction : {0, 1}) {
    if (!periodic_[direction]) continue;
    const auto range = direction == 0 ? GetParam().u_range : GetParam().v_range;
    const double length = range[1] - range[0];
    for (const int turns : {-3, -1, 1, 2}) {
      const double parameter = range[0] + (0.3 + turns) * length;
      EXPECT_NEAR(
          domain_.LatticeCoordinate(direction, parameter), 0.3 * divisions_[direction], 1e-12);
    }
    const int n = divisions_[direction];
    for (int k = -n; k <= 2 * n; ++k) {
      const int wrapped = ((k % n) + n) % n;
      const int a = direction == 0 ? domain_.VertexIndex(k, 0) : domain_.VertexIndex(0, k);
      const int b =
          direction == 0 ? domain_.VertexIndex(wrapped, 0) : domain_.VertexIndex(0, wrapped);
      EXPECT_EQ(a, b);
    }
  }
}

TEST_P(ParameterDomainTest, LocateFindsThePointAgain) {
  std::mt19937 gen(52002);
  const auto& u = GetParam().u_range;
  const auto& v = GetParam().v_range;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto check = [&](double fu, double fv) {
    const std::array<double, 2> uv = {u[0] + fu * (u[1] - u[0]), v[0] + fv * (v[1] - v[0])};
    const ElementPoint at = domain_.Locate(uv[0], uv[1]);
    ASSERT_GE(at.element, 0);
    ASSERT_LT(at.element, domain_.mesh().num_elements);
    EXPECT_GE(at.s, 0.0);
    EXPECT_GE(at.t, 0.0);
    EXPECT_LE(at.s + at.t, 1.0 + 1e-15);
    const auto q = domain_.Lattice(at);
    for (int direction : {0, 1}) {
      const auto range = direction == 0 ? u : v;
      double off = domain_.Parameter(direction, q[direction])[0] - uv[direction];
      // The two ends of a periodic direction are one.
      if (periodic_[direction]) off = std::remainder(off, range[1] - range[0]);
      EXPECT_NEAR(off, 0.0, 1e-13) << "direction " << direction << " of " << fu << ", " << fv;
    }
  };
  for (int k = 0; k < 100; ++k) check(uniform(gen), uniform(gen));
  for (int k = 0; k < 20; ++k) {
    const double f = uniform(gen);
    check(0.0, f);
    check(1.0, f);
    check(f, 0.0);
    check(f, 1.0);
    check(f, f);
  }
  for (const double a : {0.0, 1.0}) {
    for (const double b : {0.0, 1.0}) check(a, b);
  }
  for (int i = 0; i <= divisions_[0]; ++i) {
    for (int j = 0; j <= divisions_[1]; ++j) {
      const ElementPoint at = domain_.LocateLattice(i, j);
      const auto q = domain_.Lattice(at);
      EXPECT_EQ(q[0], i);
      EXPECT_EQ(q[1], j);
    }
  }
}

TEST_P(ParameterDomainTest, LocateForgivesRounding) {
  const auto& u = GetParam().u_range;
  const auto& v = GetParam().v_range;
  for (const double sign : {-1.0, 1.0}) {
    const double off = sign * 1e-15;
    for (const auto& uv : std::vector<std::array<double, 2>>{{u[0] + off, v[0] + off},
                                                             {u[1] + off, v[0] + off},
                                                             {u[0] + off, v[1] + off},
                                                             {u[1] + off, v[1] + off}}) {
      const ElementPoint at = domain_.Locate(uv[0], uv[1]);
      EXPECT_GE(at.s, 0.0);
      EXPECT_GE(at.t, 0.0);
      EXPECT_LE(at.s + at.t, 1.0 + 1e-15);
      EXPECT_GE(at.element, 0);
      EXPECT_LT(at.element, domain_.mesh().num_elements);
    }
  }
}

TEST_P(ParameterDomainTest, BoundaryEdgesCoverEachSideOnce) {
  for (const Side side : kSides) {
    const bool at_u = side == Side::kUMin || side == Side::kUMax;
    const int across = at_u ? 0 : 1, along = 1 - across;
    const auto edges = domain_.BoundaryEdges(side);
    EXPECT_EQ(domain_.HasSide(side), !periodic_[across]);
    if (periodic_[across]) {
      EXPECT_TRUE(edges.empty());
      continue;
    }
    const double fixed = side == Side::kUMin || side == Side::kVMin ? 0.0 : divisions_[across];
    ASSERT_EQ(edges.size(), static_cast<size_t>(divisions_[along]));
    for (size_t k = 0; k < edges.size(); ++k) {
      EXPECT_EQ(edges[k].side, side);
      EXPECT_EQ(edges[k].begin.element, edges[k].element);
      EXPECT_EQ(edges[k].end.element, edges[k].element);
      const auto begin = domain_.Lattice(edges[k].begin), end = domain_.Lattice(edges[k].end);
      EXPECT_EQ(begin[across], fixed);
      EXPECT_EQ(end[across], fixed);
      EXPECT_EQ(begin[along], static_cast<double>(k));
      EXPECT_EQ(end[along], k + 1.0);
    }
  }
}

TEST_P(ParameterDomainTest, FoldedGhostsReproduceLinearFieldsFromShellVerticesAlone) {
  const auto folded = domain_.FoldedGhosts();
  ASSERT_EQ(folded.size(), static_cast<size_t>(domain_.mesh().num_vertices));
  // Of a periodic direction only fields that do not depend on it are linear.
  const double a = periodic_[0] ? 0.0 : 0.7, b = periodic_[1] ? 0.0 : -1.3;
  const auto field = [&](int i, int j) { return 0.4 + a * i + b * j; };
  std::set<int> shell;
  std::map<int, double> value;
  for (int j = 0; j <= divisions_[1]; ++j) {
    for (int i = 0; i <= divisions_[0]; ++i) {
      shell.insert(domain_.VertexIndex(i, j));
      value[domain_.VertexIndex(i, j)] = field(i, j);
    }
  }
  const int low[2] = {periodic_[0] ? 0 : -1, periodic_[1] ? 0 : -1};
  for (int j = low[1]; j <= divisions_[1] - low[1]; ++j) {
    for (int i = low[0]; i <= divisions_[0] - low[0]; ++i) {
      const int vertex = domain_.VertexIndex(i, j);
      if (vertex < 0) continue;
      const auto& row = folded[vertex];
      if (shell.count(vertex) > 0) {
        ASSERT_EQ(row.size(), 1u);
        EXPECT_EQ(row[0], std::make_pair(vertex, 1.0));
      }
      double sum = 0.0, weights = 0.0;
      for (const auto& term : row) {
        EXPECT_EQ(shell.count(term.first), 1u) << "a ghost is left";
        sum += term.second * value[term.first];
        weights += term.second;
      }
      EXPECT_NEAR(weights, 1.0, 1e-15);
      EXPECT_NEAR(sum, field(i, j), 1e-13) << "(" << i << ", " << j << ")";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, ParameterDomainTest, ::testing::ValuesIn(SampleOptions()));

// The triangle of three shell vertices (x1, x2, x3) and the ghost triangle on the same edge
// (x2, x3): Fig. 6 of the paper. At the corners of the domain the edge would stick out.
TEST(ParameterDomainTest, GhostsAreOppositeTheirTriangleAcrossTheBoundary) {
  const ParameterDomain domain(MakeOptions({4, 5}));
  const auto folded = domain.FoldedGhosts();
  std::map<std::pair<int, int>, int> opposite;  // directed edge -> third vertex
  for (const auto& t : domain.mesh().triangles) {
    for (int k = 0; k < 3; ++k) opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
  }
  int checked = 0;
  for (const Side side : kSides) {
    for (const auto& edge : domain.BoundaryEdges(side)) {
      const auto q2 = domain.Lattice(edge.begin), q3 = domain.Lattice(edge.end);
      const int x2 = domain.VertexIndex(static_cast<int>(q2[0]), static_cast<int>(q2[1]));
      const int x3 = domain.VertexIndex(static_cast<int>(q3[0]), static_cast<int>(q3[1]));
      // One of the two triangles at this edge is the shell's.
      int x1 = opposite.at({x2, x3}), x4 = opposite.at({x3, x2});
      if (folded[x1].size() != 1 || folded[x1][0].first != x1) std::swap(x1, x4);
      std::map<int, double> row;
      for (const auto& term : folded[x4]) row[term.first] += term.second;
      const std::map<int, double> expected = {{x1, -1.0}, {x2, 1.0}, {x3, 1.0}};
      EXPECT_EQ(row, expected);
      ++checked;
    }
  }
  EXPECT_EQ(checked, 2 * (4 + 5));
}

TEST(ParameterDomainDeathTest, ImpossibleOptionsAreBrokenInvariants) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // A BLAS may have started threads.
  EXPECT_DEATH(ParameterDomain(MakeOptions({0, 3})), "");
  EXPECT_DEATH(ParameterDomain(MakeOptions({3, 3}, {true, false})), "");
  ParameterDomain::Options graded = MakeOptions({4, 4});
  graded.grading = {1.0, 0.0};
  EXPECT_DEATH(ParameterDomain{graded}, "");
  graded = MakeOptions({4, 4}, {true, false});
  graded.grading = {0.5, 0.0};
  EXPECT_DEATH(ParameterDomain{graded}, "");
  const ParameterDomain domain(MakeOptions({2, 2}));
  EXPECT_DEATH(domain.VertexIndex(4, 0), "beyond the ghost ring");
  EXPECT_EQ(domain.VertexIndex(-1, 3), -1);
  EXPECT_EQ(domain.VertexIndex(3, -1), -1);
}

TEST(ParameterDomainMapTest, ParametersFollowTheMapsAndBack) {
  ParameterDomain::Options options = MakeOptions({6, 7}, {true, false});
  options.maps = {GradingMap({0.0, -1.0, -2.0, -1.0, 0.0}, true),
                  GradingMap({-1.0, 0.0, 0.3, 0.1, -2.0}, false)};
  const ParameterDomain domain(options);
  for (int d = 0; d < 2; ++d) {
    const auto& range = d == 0 ? options.u_range : options.v_range;
    const double length = range[1] - range[0];
    const double step = 1.0 / options.divisions[d];
    for (const double q : {0.0, 0.4, 2.0, 3.7, 6.0}) {
      const auto x = options.maps[d].Evaluate(q * step);
      const auto parameter = domain.Parameter(d, q);
      double unit = length;
      for (int i = 0; i < 4; ++i, unit *= step) {
        const double expected = (i == 0 ? range[0] : 0.0) + unit * x[i];
        EXPECT_NEAR(parameter[i], expected, 1e-14 * (std::abs(expected) + length));
      }
      if (q < options.divisions[d]) {
        EXPECT_NEAR(domain.LatticeCoordinate(d, parameter[0]), q, 1e-12);
      }
    }
  }
  // Once around a periodic parameter is where it began.
  const double u = domain.Parameter(0, 1.3)[0];
  EXPECT_NEAR(domain.LatticeCoordinate(0, u + 5.0), 1.3, 1e-12);
}

}  // namespace
}  // namespace darboux
