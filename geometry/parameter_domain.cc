#include "geometry/parameter_domain.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace darboux {

ParameterDomain::ParameterDomain(const Options& options) : options_(options) {
  for (int d = 0; d < 2; ++d) {
    CHECK_GE(options.divisions[d], options.periodic[d] ? 4 : 1);
    CHECK_LT(std::abs(options.grading[d]), 1.0);
    CHECK(!options.periodic[d] || options.grading[d] == 0.0);
    CHECK(options.maps[d].is_identity() || options.grading[d] == 0.0);
    first_[d] = options.periodic[d] ? 0 : -1;
    count_[d] = options.periodic[d] ? options.divisions[d] : options.divisions[d] + 3;
  }
  vertex_.assign(static_cast<size_t>(count_[0]) * count_[1], -1);
  for (int j = 0; j < count_[1]; ++j) {
    for (int i = 0; i < count_[0]; ++i) {
      // The diagonal of a cell runs from its lower left to its upper right corner, so the other
      // two corners of the ghost ring belong to no neighbourhood of an element.
      const bool unused = !options.periodic[0] && !options.periodic[1] &&
                          ((i == 0 && j == count_[1] - 1) || (i == count_[0] - 1 && j == 0));
      if (!unused) vertex_[static_cast<size_t>(j) * count_[0] + i] = mesh_.num_vertices++;
    }
  }
  const int m = options.divisions[0], n = options.divisions[1];
  const auto add_cell = [&](int i, int j) {
    const int a = VertexIndex(i, j), b = VertexIndex(i + 1, j);
    const int c = VertexIndex(i + 1, j + 1), d = VertexIndex(i, j + 1);
    if (b >= 0) mesh_.triangles.push_back({a, b, c});
    if (d >= 0) mesh_.triangles.push_back({a, c, d});
  };
  mesh_.triangles.reserve(2 * static_cast<size_t>(m + 2) * (n + 2));
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) add_cell(i, j);
  }
  mesh_.num_elements = static_cast<int>(mesh_.triangles.size());
  const int i_end = options.periodic[0] ? m : m + 1;
  const int j_end = options.periodic[1] ? n : n + 1;
  for (int j = first_[1]; j < j_end; ++j) {
    for (int i = first_[0]; i < i_end; ++i) {
      if (i < 0 || i >= m || j < 0 || j >= n) add_cell(i, j);
    }
  }
}

bool ParameterDomain::InLattice(int i, int j) const {
  return i >= first_[0] && i < first_[0] + count_[0] && j >= first_[1] && j < first_[1] + count_[1];
}

int ParameterDomain::VertexIndex(int i, int j) const {
  const auto wrap = [](int k, int n) { return ((k % n) + n) % n; };
  if (options_.periodic[0]) i = wrap(i, options_.divisions[0]);
  if (options_.periodic[1]) j = wrap(j, options_.divisions[1]);
  CHECK(InLattice(i, j)) << "lattice point (" << i << ", " << j << ") beyond the ghost ring";
  return vertex_[static_cast<size_t>(j - first_[1]) * count_[0] + (i - first_[0])];
}

std::array<double, 4> ParameterDomain::Parameter(int direction, double q) const {
  const auto& range = direction == 0 ? options_.u_range : options_.v_range;
  const double g = options_.grading[direction];
  const double length = range[1] - range[0];
  const double step = 1.0 / options_.divisions[direction];
  const double f = q * step;
  const GradingMap& map = options_.maps[direction];
  if (!map.is_identity()) {
    const auto x = map.Evaluate(f);
    return {range[0] + length * x[0],
            length * x[1] * step,
            length * x[2] * step * step,
            length * x[3] * step * step * step};
  }
  if (g > 0.0) {
    const double p = 1.0 - f;
    return {range[1] - length * ((1.0 - g) + g * p) * p,
            length * ((1.0 - g) + 2.0 * g * p) * step,
            -2.0 * g * length * step * step,
            0.0};
  }
  return {range[0] + length * ((1.0 + g) - g * f) * f,
          length * ((1.0 + g) - 2.0 * g * f) * step,
          -2.0 * g * length * step * step,
          0.0};
}

double ParameterDomain::LatticeCoordinate(int direction, double parameter) const {
  const auto& range = direction == 0 ? options_.u_range : options_.v_range;
  const double g = std::abs(options_.grading[direction]);
  double f = (parameter - range[0]) / (range[1] - range[0]);
  if (options_.periodic[direction]) f -= std::floor(f);
  const GradingMap& map = options_.maps[direction];
  if (!map.is_identity()) {
    return options_.divisions[direction] * map.Inverse(std::clamp(f, 0.0, 1.0));
  }
  const bool from_top = options_.grading[direction] > 0.0;
  double d = std::max(from_top ? 1.0 - f : f, 0.0);
  // Root of g p^2 + (1 - g) p - d = 0, written without cancellation.
  const double p = 2.0 * d / ((1.0 - g) + std::sqrt((1.0 - g) * (1.0 - g) + 4.0 * g * d));
  return options_.divisions[direction] * (from_top ? 1.0 - p : p);
}

std::array<std::array<double, 2>, 2> ParameterDomain::ElementAxes(int element) {
  if (element % 2 == 0) return {{{1.0, 0.0}, {1.0, 1.0}}};
  return {{{1.0, 1.0}, {0.0, 1.0}}};
}

std::array<double, 2> ParameterDomain::Lattice(const ElementPoint& point) const {
  const int cell = point.element / 2;
  const auto axes = ElementAxes(point.element);
  return {cell % options_.divisions[0] + point.s * axes[0][0] + point.t * axes[1][0],
          cell / options_.divisions[0] + point.s * axes[0][1] + point.t * axes[1][1]};
}

ElementPoint ParameterDomain::LocateLattice(double q1, double q2) const {
  const auto cell_of = [](double q, int n) {
    return std::clamp(static_cast<int>(std::floor(q)), 0, n - 1);
  };
  const int i = cell_of(q1, options_.divisions[0]);
  const int j = cell_of(q2, options_.divisions[1]);
  const double a = std::clamp(q1 - i, 0.0, 1.0);
  const double b = std::clamp(q2 - j, 0.0, 1.0);
  const int cell = j * options_.divisions[0] + i;
  if (a >= b) return {2 * cell, a - b, b};
  return {2 * cell + 1, a, b - a};
}

ElementPoint ParameterDomain::Locate(double u, double v) const {
  return LocateLattice(LatticeCoordinate(0, u), LatticeCoordinate(1, v));
}

bool ParameterDomain::HasSide(Side side) const {
  return !options_.periodic[side == Side::kUMin || side == Side::kUMax ? 0 : 1];
}

std::vector<ParameterDomain::BoundaryEdge> ParameterDomain::BoundaryEdges(Side side) const {
  std::vector<BoundaryEdge> edges;
  if (!HasSide(side)) return edges;
  const int m = options_.divisions[0], n = options_.divisions[1];
  const bool along_v = side == Side::kUMin || side == Side::kUMax;
  for (int k = 0; k < (along_v ? n : m); ++k) {
    const int i = side == Side::kUMin ? 0 : side == Side::kUMax ? m - 1 : k;
    const int j = side == Side::kVMin ? 0 : side == Side::kVMax ? n - 1 : k;
    const int cell = j * m + i;
    // The lower and right sides of a cell belong to its first triangle, (A, B, C) above; the left
    // and upper ones to its second. Edges run with ascending parameter.
    switch (side) {
      case Side::kVMin:
        edges.push_back({2 * cell, {2 * cell, 0, 0}, {2 * cell, 1, 0}, side});
        break;
      case Side::kUMax:
        edges.push_back({2 * cell, {2 * cell, 1, 0}, {2 * cell, 0, 1}, side});
        break;
      case Side::kUMin:
        edges.push_back({2 * cell + 1, {2 * cell + 1, 0, 0}, {2 * cell + 1, 0, 1}, side});
        break;
      case Side::kVMax:
        edges.push_back({2 * cell + 1, {2 * cell + 1, 0, 1}, {2 * cell + 1, 1, 0}, side});
        break;
    }
  }
  return edges;
}

std::vector<std::vector<std::pair<int, double>>> ParameterDomain::FoldedGhosts() const {
  const int m = options_.divisions[0], n = options_.divisions[1];
  std::vector<std::vector<std::pair<int, double>>> folded(mesh_.num_vertices);
  // In the direction across the boundary the parallelogram x1, x2, x3, x4 of the lattice has x4
  // outside: for the upper side (i, n+1) = (i, n) + (i-1, n) - (i-1, n-1), and so on. Corner
  // ghosts fold twice. Coefficients follow by applying the rule to 'inside' lattice points.
  const auto inside = [&](int i, int j) {
    return (options_.periodic[0] || (i >= 0 && i <= m)) &&
           (options_.periodic[1] || (j >= 0 && j <= n));
  };
  const std::function<void(int, int, double, std::vector<std::pair<int, double>>*)> add =
      [&](int i, int j, double factor, std::vector<std::pair<int, double>>* row) {
        if (inside(i, j)) {
          const int vertex = VertexIndex(i, j);
          for (auto& entry : *row) {
            if (entry.first == vertex) {
              entry.second += factor;
              return;
            }
          }
          row->push_back({vertex, factor});
          return;
        }
        const bool below = !options_.periodic[1] && j < 0;
        const bool above = !options_.periodic[1] && j > n;
        const bool left = !options_.periodic[0] && i < 0;
        // x4 and x1 face each other across the boundary edge (x2, x3).
        if (below || above) {
          // Shift along the boundary towards the inside so that x2, x3 exist.
          const int dj = below ? 1 : -1;
          const int di = below ? 1 : -1;
          const bool fits = options_.periodic[0] || (i + di >= 0 && i + di <= m);
          if (fits && (options_.periodic[0] || (i >= 0 && i <= m))) {
            add(i, j + dj, factor, row);
            add(i + di, j + dj, factor, row);
            add(i + di, j + 2 * dj, -factor, row);
          } else {  // At a corner the edge (x2, x3) would stick out: reflect straight through it.
            add(i, j + dj, 2.0 * factor, row);
            add(i, j + 2 * dj, -factor, row);
          }
          return;
        }
        const int di = left ? 1 : -1;
        const int dj = left ? 1 : -1;
        const bool fits = options_.periodic[1] || (j + dj >= 0 && j + dj <= n);
        if (fits) {
          add(i + di, j, factor, row);
          add(i + di, j + dj, factor, row);
          add(i + 2 * di, j + dj, -factor, row);
        } else {
          add(i + di, j, 2.0 * factor, row);
          add(i + 2 * di, j, -factor, row);
        }
      };
  for (int j = first_[1]; j < first_[1] + count_[1]; ++j) {
    for (int i = first_[0]; i < first_[0] + count_[0]; ++i) {
      const int vertex = VertexIndex(i, j);
      if (vertex >= 0) add(i, j, 1.0, &folded[vertex]);
    }
  }
  return folded;
}

}  // namespace darboux
