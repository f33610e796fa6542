#include "geometry/loop_basis.h"

#include <glog/logging.h>
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>

namespace darboux {
namespace {

namespace osd = OpenSubdiv;

// A monomial c u^a v^b w^d of barycentric coordinates.
struct Monomial {
  double c;
  int a, b, d;
};
using Quartic = std::vector<Monomial>;

// Stam's twelve polynomials, times 12. Up to a permutation of the corners there are three: of a
// corner of the element, of a vertex across an edge, and of a vertex that touches one corner.
Quartic CornerPolynomial(int own, int next, int last) {
  // 6u^4 + 24u^3(v+w) + 24u^2(v^2+w^2) + 60u^2vw + 8u(v^3+w^3) + 36uvw(v+w) + v^4 + w^4
  //   + 6vw(v^2+w^2) + 12v^2w^2
  const int terms[][4] = {{6, 4, 0, 0},
                          {24, 3, 1, 0},
                          {24, 3, 0, 1},
                          {24, 2, 2, 0},
                          {24, 2, 0, 2},
                          {60, 2, 1, 1},
                          {8, 1, 3, 0},
                          {8, 1, 0, 3},
                          {36, 1, 2, 1},
                          {36, 1, 1, 2},
                          {1, 0, 4, 0},
                          {1, 0, 0, 4},
                          {6, 0, 3, 1},
                          {6, 0, 1, 3},
                          {12, 0, 2, 2}};
  Quartic q;
  for (const auto& term : terms) {
    int e[3];
    e[own] = term[1];
    e[next] = term[2];
    e[last] = term[3];
    q.push_back({static_cast<double>(term[0]), e[0], e[1], e[2]});
  }
  return q;
}

// Of the vertex across the edge of corners i and j; k is the third corner.
Quartic EdgePolynomial(int i, int j, int k) {
  // u^4 + v^4 + 6uv(u^2+v^2) + 12u^2v^2 + 2w(u^3+v^3) + 6uvw(u+v)
  const int terms[][4] = {{1, 4, 0, 0},
                          {1, 0, 4, 0},
                          {6, 3, 1, 0},
                          {6, 1, 3, 0},
                          {12, 2, 2, 0},
                          {2, 3, 0, 1},
                          {2, 0, 3, 1},
                          {6, 2, 1, 1},
                          {6, 1, 2, 1}};
  Quartic q;
  for (const auto& term : terms) {
    int e[3];
    e[i] = term[1];
    e[j] = term[2];
    e[k] = term[3];
    q.push_back({static_cast<double>(term[0]), e[0], e[1], e[2]});
  }
  return q;
}

// Of a vertex that touches corner i only, on the side of corner j: u^4 + 2u^3v.
Quartic TipPolynomial(int i, int j) {
  int e[3] = {0, 0, 0};
  e[i] = 3;
  e[j] = 1;
  Quartic q = {{1.0, 0, 0, 0}, {2.0, e[0], e[1], e[2]}};
  int* corner[3] = {&q[0].a, &q[0].b, &q[0].d};
  *corner[i] = 4;
  return q;
}

// In the order of control_vertices (see FindRegularRing).
const std::array<Quartic, 12>& RegularPolynomials() {
  static const auto* const polynomials = new std::array<Quartic, 12>{
      CornerPolynomial(0, 1, 2),
      CornerPolynomial(1, 2, 0),
      CornerPolynomial(2, 0, 1),
      EdgePolynomial(0, 1, 2),
      EdgePolynomial(1, 2, 0),
      EdgePolynomial(2, 0, 1),
      TipPolynomial(0, 2),
      TipPolynomial(0, 1),
      TipPolynomial(1, 0),
      TipPolynomial(1, 2),
      TipPolynomial(2, 1),
      TipPolynomial(2, 0),
  };
  return *polynomials;
}

// Who lies across each directed edge.
class Adjacency {
 public:
  explicit Adjacency(const ControlMesh& mesh) : begin_(mesh.num_vertices + 1, 0) {
    for (const auto& triangle : mesh.triangles) {
      for (const int vertex : triangle) ++begin_[vertex + 1];
    }
    for (int i = 0; i < mesh.num_vertices; ++i) begin_[i + 1] += begin_[i];
    edges_.resize(begin_.back());
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (const auto& triangle : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        edges_[next[triangle[k]]++] = {triangle[(k + 1) % 3], triangle[(k + 2) % 3]};
      }
    }
  }

  // Third vertex of the triangle that has the directed edge (from, to); -1 where there is none.
  int Opposite(int from, int to) const {
    for (int i = begin_[from]; i < begin_[from + 1]; ++i) {
      if (edges_[i].to == to) return edges_[i].opposite;
    }
    return -1;
  }

  // Whether the triangles around the vertex close up.
  bool IsInterior(int vertex) const {
    for (int i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
      if (Opposite(edges_[i].to, vertex) < 0) return false;
    }
    return begin_[vertex] < begin_[vertex + 1];
  }

  int Valence(int vertex) const { return begin_[vertex + 1] - begin_[vertex]; }

 private:
  struct Edge {
    int to, opposite;
  };
  std::vector<int> begin_;
  std::vector<Edge> edges_;
};

// The twelve control vertices of a regular element (A, B, C): in lattice coordinates with origin
// A and axes B - A, C - A
//   (0,0) (1,0) (0,1) | (1,-1) (1,1) (-1,1) | (-1,0) (0,-1) (2,-1) (2,0) (0,2) (-1,2).
std::vector<int> FindRegularRing(const Adjacency& adjacency, const std::array<int, 3>& triangle) {
  const int a = triangle[0], b = triangle[1], c = triangle[2];
  const int ab = adjacency.Opposite(b, a);
  const int bc = adjacency.Opposite(c, b);
  const int ca = adjacency.Opposite(a, c);
  return {a,
          b,
          c,
          ab,
          bc,
          ca,
          adjacency.Opposite(a, ca),
          adjacency.Opposite(ab, a),
          adjacency.Opposite(b, ab),
          adjacency.Opposite(bc, b),
          adjacency.Opposite(c, bc),
          adjacency.Opposite(ca, c)};
}

}  // namespace

namespace {

// Monomials s^i t^j with i + j <= 4, and their index in a row of 15.
constexpr int kMonomials = 15;
int MonomialIndex(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// Coefficients of the twelve polynomials in monomials of s and t: u = 1 - s - t, v = s, w = t.
Eigen::Matrix<double, kMonomials, 12> MakeCoefficients() {
  Eigen::Matrix<double, kMonomials, 12> coefficients;
  coefficients.setZero();
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  for (int column = 0; column < 12; ++column) {
    for (const Monomial& m : RegularPolynomials()[column]) {
      for (int i = 0; i <= m.a; ++i) {
        for (int j = 0; i + j <= m.a; ++j) {
          const double multinomial =
              std::round(factorial(m.a) / (factorial(i) * factorial(j) * factorial(m.a - i - j)));
          coefficients(MonomialIndex(i + m.b, j + m.d), column) +=
              ((i + j) % 2 == 0 ? 1.0 : -1.0) * multinomial * m.c / 12.0;
        }
      }
    }
  }
  return coefficients;
}

}  // namespace

Eigen::Matrix<double, 6, 12> EvaluateRegularLoopBasis(double s, double t) {
  static const auto* const coefficients =
      new Eigen::Matrix<double, kMonomials, 12>(MakeCoefficients());
  // Powers and their first and second derivatives.
  double p[2][3][5];
  for (int axis = 0; axis < 2; ++axis) {
    const double x = axis == 0 ? s : t;
    double power = 1.0;
    for (int k = 0; k < 5; ++k) {
      p[axis][0][k] = power;
      power *= x;
    }
    p[axis][1][0] = p[axis][2][0] = p[axis][2][1] = 0.0;
    for (int k = 1; k < 5; ++k) p[axis][1][k] = k * p[axis][0][k - 1];
    for (int k = 2; k < 5; ++k) p[axis][2][k] = k * p[axis][1][k - 1];
  }
  Eigen::Matrix<double, 6, kMonomials> monomials;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; i + j < 5; ++j) {
      monomials.col(MonomialIndex(i, j)) << p[0][0][i] * p[1][0][j], p[0][1][i] * p[1][0][j],
          p[0][0][i] * p[1][1][j], p[0][2][i] * p[1][0][j], p[0][1][i] * p[1][1][j],
          p[0][0][i] * p[1][2][j];
    }
  }
  return monomials.lazyProduct(*coefficients);
}

struct LoopBasis::Irregular {
  std::unique_ptr<osd::Far::TopologyRefiner> refiner;
  std::unique_ptr<osd::Bfr::RefinerSurfaceFactory<>> factory;
  std::vector<std::unique_ptr<osd::Bfr::Surface<double>>> surface;  // per element; null if regular
};

LoopBasis::LoopBasis(const ControlMesh& mesh, const Options& options) {
  const Adjacency adjacency(mesh);
  control_vertices_.resize(mesh.num_elements);
  regular_.assign(mesh.num_elements, 0);
  bool all_regular = true;
  for (int e = 0; e < mesh.num_elements; ++e) {
    bool regular = options.regular_fast_path;
    for (const int vertex : mesh.triangles[e]) {
      CHECK(adjacency.IsInterior(vertex)) << "vertex " << vertex << " of element " << e
                                          << " lies on the boundary of the control mesh";
      regular = regular && adjacency.Valence(vertex) == 6;
    }
    if (regular) {
      regular_[e] = 1;
      control_vertices_[e] = FindRegularRing(adjacency, mesh.triangles[e]);
    } else {
      all_regular = false;
    }
  }
  if (all_regular) return;

  irregular_ = std::make_unique<Irregular>();
  std::vector<int> sizes(mesh.triangles.size(), 3);
  std::vector<int> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  osd::Far::TopologyDescriptor descriptor;
  descriptor.numVertices = mesh.num_vertices;
  descriptor.numFaces = static_cast<int>(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = corners.data();
  using Factory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
  osd::Sdc::Options scheme;
  scheme.SetVtxBoundaryInterpolation(osd::Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  irregular_->refiner.reset(
      Factory::Create(descriptor, Factory::Options(osd::Sdc::SCHEME_LOOP, scheme)));
  CHECK(irregular_->refiner != nullptr) << "OpenSubdiv rejects the control mesh";
  // Level 10: the polynomial patches then meet the limit surface to 1e-10 wherever we evaluate.
  irregular_->factory = std::make_unique<osd::Bfr::RefinerSurfaceFactory<>>(
      *irregular_->refiner,
      osd::Bfr::SurfaceFactory::Options().SetApproxLevelSmooth(10).SetApproxLevelSharp(10));
  irregular_->surface.resize(mesh.num_elements);
  for (int e = 0; e < mesh.num_elements; ++e) {
    if (regular_[e]) continue;
    irregular_->surface[e].reset(irregular_->factory->CreateVertexSurface<double>(e));
    CHECK(irregular_->surface[e] != nullptr) << "no limit surface for element " << e;
    control_vertices_[e].resize(irregular_->surface[e]->GetNumControlPoints());
    irregular_->surface[e]->GetControlPointIndices(control_vertices_[e].data());
  }
}

LoopBasis::~LoopBasis() = default;

BasisMatrix LoopBasis::Evaluate(int element, double s, double t) const {
  if (regular_[element]) return EvaluateRegularLoopBasis(s, t);
  const int n = static_cast<int>(control_vertices_[element].size());
  Eigen::Matrix<double, Eigen::Dynamic, 6> stencil(n, 6);
  const double st[2] = {s, t};
  irregular_->surface[element]->EvaluateStencil(st,
                                                stencil.col(kValue).data(),
                                                stencil.col(kDs).data(),
                                                stencil.col(kDt).data(),
                                                stencil.col(kDss).data(),
                                                stencil.col(kDst).data(),
                                                stencil.col(kDtt).data());
  // OpenSubdiv's EvaluatePatchBasis (seen in 3.5.0) gives second derivatives the wrong sign on the
  // middle triangles of its splits, which lie rotated in the element: it applies the sign of the
  // rotation three times. First derivatives are right everywhere, so their change over a small step
  // into the element tells the sign, whichever way the library has it.
  const double to_corner[3] = {std::hypot(s, t), std::hypot(1.0 - s, t), std::hypot(s, 1.0 - t)};
  const auto nearest = std::min_element(to_corner, to_corner + 3) - to_corner;
  const auto farthest = std::max_element(to_corner, to_corner + 3) - to_corner;
  const double step = 1e-3 * to_corner[nearest] / to_corner[farthest];
  const Eigen::Vector2d d(step * ((farthest == 1 ? 1.0 : 0.0) - s),
                          step * ((farthest == 2 ? 1.0 : 0.0) - t));
  const double moved_st[2] = {s + d.x(), t + d.y()};
  Eigen::Matrix<double, Eigen::Dynamic, 3> moved(n, 3);
  irregular_->surface[element]->EvaluateStencil(
      moved_st, moved.col(kValue).data(), moved.col(kDs).data(), moved.col(kDt).data());
  const double agreement =
      (moved.col(kDs) - stencil.col(kDs)).dot(stencil.middleCols<2>(kDss) * d) +
      (moved.col(kDt) - stencil.col(kDt)).dot(stencil.middleCols<2>(kDst) * d);
  if (agreement < 0.0) stencil.rightCols<3>() *= -1.0;
  return stencil.transpose();
}

}  // namespace darboux
