#include "solver/inp_mesh.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace darboux {
namespace {

constexpr const char* kNames[] = {"S3", "S4", "S6", "S8R", "C3D15", "C3D20R"};

bool IsQuadratic(InpElement element) {
  return element != InpElement::kS3 && element != InpElement::kS4;
}

// Shape functions: corners, then middles. Triangles on (0,0), (1,0), (0,1).
std::vector<double> TriangleShape(bool quadratic, double a, double b) {
  const double c = 1.0 - a - b;
  if (!quadratic) return {c, a, b};
  return {c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * a * c, 4 * a * b, 4 * b * c};
}

// Quadrilaterals on [0, 1]^2; of eight nodes the serendipity family.
std::vector<double> QuadrilateralShape(bool quadratic, double p, double q) {
  const double a = 2 * p - 1, b = 2 * q - 1;
  constexpr int kA[] = {-1, 1, 1, -1}, kB[] = {-1, -1, 1, 1};
  std::vector<double> values;
  for (int i = 0; i < 4; ++i) {
    const double value = 0.25 * (1 + kA[i] * a) * (1 + kB[i] * b);
    values.push_back(quadratic ? value * (kA[i] * a + kB[i] * b - 1) : value);
  }
  if (quadratic) {
    values.push_back(0.5 * (1 - a * a) * (1 - b));
    values.push_back(0.5 * (1 + a) * (1 - b * b));
    values.push_back(0.5 * (1 - a * a) * (1 + b));
    values.push_back(0.5 * (1 - a) * (1 - b * b));
  }
  return values;
}

constexpr double kCorner[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};

}  // namespace

const char* ToString(InpElement element) { return kNames[static_cast<int>(element)]; }

bool ParseInpElement(const std::string& name, InpElement* element) {
  for (int i = 0; i < 6; ++i) {
    if (name != kNames[i]) continue;
    *element = static_cast<InpElement>(i);
    return true;
  }
  return false;
}

bool IsSolid(InpElement element) {
  return element == InpElement::kC3D15 || element == InpElement::kC3D20R;
}

bool IsQuadrilateral(InpElement element) {
  return element == InpElement::kS4 || element == InpElement::kS8R ||
         element == InpElement::kC3D20R;
}

InpMesh::InpMesh(const ShellSurface& surface, InpElement element, double thickness)
    : surface_(surface), element_(element), thickness_(thickness) {
  corners_.assign(surface.num_corners(), -1);
  if (IsQuadrilateral(element)) {
    AddQuadrilaterals();
  } else {
    AddTriangles();
  }
  AddNodes();
  element_size_ = std::sqrt(surface.area() / static_cast<double>(elements_.size()));
}

int InpMesh::AddColumn(const ElementPoint& at, bool is_corner) {
  const StrainPoint point = surface_.MakePoint(at);
  columns_.push_back({at, point.position, point.n, is_corner, {}});
  return static_cast<int>(columns_.size()) - 1;
}

int InpMesh::Corner(int place, const ElementPoint& at) {
  int& column = corners_[place];
  if (column < 0) column = AddColumn(at, true);
  return column;
}

int InpMesh::Middle(int column_a, int column_b, const ElementPoint& at) {
  const auto [it, is_new] = middles_.insert({std::minmax(column_a, column_b), -1});
  if (is_new) it->second = AddColumn(at, false);
  return it->second;
}

void InpMesh::AddTriangles() {
  pieces_.resize(surface_.num_elements());
  for (int e = 0; e < surface_.num_elements(); ++e) {
    // The corners around, with the middles of edges across which elements are half as large.
    std::vector<int> around;
    std::vector<Eigen::Vector2d> where;
    int first_hanging = -1;
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      const Eigen::Vector2d a(kCorner[k][0], kCorner[k][1]), b(kCorner[l][0], kCorner[l][1]);
      around.push_back(Corner(surface_.Corner(e, k), {e, a.x(), a.y()}));
      where.push_back(a);
      const int hanging = surface_.HangingCorner(e, k);
      if (hanging < 0) continue;
      const Eigen::Vector2d m = 0.5 * (a + b);
      if (first_hanging < 0) first_hanging = static_cast<int>(around.size());
      around.push_back(Corner(hanging, {e, m.x(), m.y()}));
      where.push_back(m);
    }
    std::vector<std::array<int, 3>> triangles;
    const int n = static_cast<int>(around.size());
    if (n == 6) {
      triangles = {{0, 1, 5}, {1, 2, 3}, {3, 4, 5}, {1, 3, 5}};
    } else {  // A fan; its apex is a middle where there is one, as three points in line are none.
      const int apex = std::max(first_hanging, 0);
      for (int i = 1; i + 1 < n; ++i)
        triangles.push_back({apex, (apex + i) % n, (apex + i + 1) % n});
    }
    for (const std::array<int, 3>& triangle : triangles) {
      Piece piece{static_cast<int>(elements_.size()), {}};
      std::vector<int> columns;
      for (int k = 0; k < 3; ++k) {
        piece.corners[k] = where[triangle[k]];
        columns.push_back(around[triangle[k]]);
      }
      for (int k = 0; IsQuadratic(element_) && k < 3; ++k) {
        const Eigen::Vector2d m = 0.5 * (piece.corners[k] + piece.corners[(k + 1) % 3]);
        columns.push_back(Middle(columns[k], columns[(k + 1) % 3], {e, m.x(), m.y()}));
      }
      pieces_[e].push_back(piece);
      elements_.push_back(columns);
    }
  }
}

void InpMesh::AddQuadrilaterals() {
  // Elements 2k and 2k + 1 are the halves (A, B, C) and (A, C, D) of cell k (parameter_domain.h).
  for (int e = 0; e < surface_.num_elements(); e += 2) {
    std::vector<int> columns = {Corner(surface_.Corner(e, 0), {e, 0.0, 0.0}),
                                Corner(surface_.Corner(e, 1), {e, 1.0, 0.0}),
                                Corner(surface_.Corner(e, 2), {e, 0.0, 1.0}),
                                Corner(surface_.Corner(e + 1, 2), {e + 1, 0.0, 1.0})};
    if (IsQuadratic(element_)) {
      const ElementPoint middles[] = {
          {e, 0.5, 0.0}, {e, 0.5, 0.5}, {e + 1, 0.5, 0.5}, {e + 1, 0.0, 0.5}};
      for (int k = 0; k < 4; ++k) {
        columns.push_back(Middle(columns[k], columns[(k + 1) % 4], middles[k]));
      }
    }
    elements_.push_back(columns);
  }
}

void InpMesh::AddNodes() {
  for (size_t c = 0; c < columns_.size(); ++c) {
    Column& column = columns_[c];
    for (int layer = 0; layer < 3; ++layer) {
      if (is_solid() ? layer == 1 && !column.is_corner : layer > 0) continue;
      const double height = is_solid() ? 0.5 * (layer - 1) * thickness_ : 0.0;
      nodes_.push_back({column.position + height * column.normal, static_cast<int>(c)});
      column.nodes[layer] = static_cast<int>(nodes_.size());
    }
    if (!is_solid()) column.nodes[1] = column.nodes[2] = column.nodes[0];
  }
}

std::vector<int> InpMesh::ElementNodes(int element) const {
  const std::vector<int>& columns = elements_[element];
  std::vector<int> nodes;
  const auto add = [&](size_t begin, size_t end, int layer) {
    for (size_t i = begin; i < end; ++i) nodes.push_back(columns_[columns[i]].nodes[layer]);
  };
  if (!is_solid()) {
    add(0, columns.size(), 0);
    return nodes;
  }
  // Corners below and above, edges below and above, then the upright edges.
  const size_t n = columns.size() / 2;
  add(0, n, 0);
  add(0, n, 2);
  add(n, 2 * n, 0);
  add(n, 2 * n, 2);
  add(0, n, 1);
  return nodes;
}

int InpMesh::Locate(const ElementPoint& at, std::vector<double>* values) const {
  if (IsQuadrilateral(element_)) {
    const bool first = at.element % 2 == 0;
    *values = QuadrilateralShape(
        IsQuadratic(element_), first ? at.s + at.t : at.s, first ? at.t : at.s + at.t);
    return at.element / 2;
  }
  // The piece that the point is farthest within.
  double best = -std::numeric_limits<double>::infinity();
  int number = -1;
  for (const Piece& piece : pieces_[at.element]) {
    Eigen::Matrix2d axes;
    axes << piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0];
    const Eigen::Vector2d x = axes.inverse() * (Eigen::Vector2d(at.s, at.t) - piece.corners[0]);
    const double within = std::min({x.x(), x.y(), 1.0 - x.sum()});
    if (within <= best) continue;
    best = within;
    number = piece.number;
    *values = TriangleShape(IsQuadratic(element_), x.x(), x.y());
  }
  return number;
}

std::vector<InpMesh::Edge> InpMesh::SideEdges(Side side) const {
  std::vector<Edge> edges;
  const auto column = [&](const ElementPoint& at) {
    for (int k = 0; k < 3; ++k) {
      const double off = std::abs(at.s - kCorner[k][0]) + std::abs(at.t - kCorner[k][1]);
      if (off < 1e-9) return corners_[surface_.Corner(at.element, k)];
    }
    return -1;
  };
  for (const ParameterDomain::BoundaryEdge& edge : surface_.BoundaryEdges(side)) {
    const int begin = column(edge.begin), end = column(edge.end);
    const auto middle = middles_.find(std::minmax(begin, end));
    edges.push_back(
        {begin, end, middle == middles_.end() ? -1 : middle->second, edge.begin, edge.end});
  }
  return edges;
}

int InpMesh::Nearest(const Eigen::Vector3d& x, bool corner) const {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (size_t c = 0; c < columns_.size(); ++c) {
    if (corner && !columns_[c].is_corner) continue;
    const double distance = (columns_[c].position - x).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(c);
  }
  return nearest;
}

std::vector<int> InpMesh::FarCorners(const Eigen::Vector3d& x, size_t count) const {
  std::vector<int> far;
  while (far.size() < count) {
    int best = 0;
    double farthest = -1.0;
    for (size_t c = 0; c < columns_.size(); ++c) {
      if (!columns_[c].is_corner) continue;
      double distance =
          far.empty() ? (columns_[c].position - x).norm() : std::numeric_limits<double>::infinity();
      for (const int other : far) {
        distance = std::min(distance, (columns_[c].position - columns_[other].position).norm());
      }
      if (distance <= farthest) continue;
      farthest = distance;
      best = static_cast<int>(c);
    }
    far.push_back(best);
  }
  return far;
}

}  // namespace darboux
