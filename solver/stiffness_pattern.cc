#include "solver/stiffness_pattern.h"

#include <algorithm>

namespace darboux {

StiffnessPattern::StiffnessPattern(int num_vertices,
                                   int components,
                                   const std::function<bool(int)>& is_free,
                                   const std::vector<const std::vector<int>*>& terms,
                                   int num_elements,
                                   SparseBackend backend)
    : components_(components) {
  std::vector<int> number(num_vertices, -1), vertex_of;
  for (int i = 0; i < num_vertices; ++i) {
    if (!is_free(i)) continue;
    number[i] = static_cast<int>(vertex_of.size());
    vertex_of.push_back(i);
  }
  const int num_blocks = static_cast<int>(vertex_of.size());
  std::vector<int> term_begin(num_blocks + 1, 0), term_of;
  for (const auto* vertices : terms) {
    for (const int v : *vertices) {
      if (number[v] >= 0) ++term_begin[number[v] + 1];
    }
  }
  for (int i = 0; i < num_blocks; ++i) term_begin[i + 1] += term_begin[i];
  term_of.resize(term_begin.back());
  std::vector<int> next(term_begin.begin(), term_begin.end() - 1);
  for (size_t t = 0; t < terms.size(); ++t) {
    for (const int v : *terms[t]) {
      if (number[v] >= 0) term_of[next[number[v]]++] = static_cast<int>(t);
    }
  }
  std::vector<int> neighbour_begin(1, 0), neighbours, seen(num_blocks, -1);
  neighbours.reserve(20 * num_blocks);
  std::vector<int> lower_begin(1, 0), lower;  // those with a greater number, and the vertex itself
  lower.reserve(10 * num_blocks);
  for (int i = 0; i < num_blocks; ++i) {
    for (int k = term_begin[i]; k < term_begin[i + 1]; ++k) {
      for (const int v : *terms[term_of[k]]) {
        const int j = number[v];
        if (j < 0 || seen[j] == i) continue;
        seen[j] = i;
        neighbours.push_back(j);
        if (j >= i) lower.push_back(j);
      }
    }
    neighbour_begin.push_back(static_cast<int>(neighbours.size()));
    lower_begin.push_back(static_cast<int>(lower.size()));
  }
  const Eigen::VectorXi order = FillReducingOrder(lower_begin, lower, backend);
  block_of_vertex_.assign(num_vertices, -1);
  vertex_of_block_.resize(num_blocks);
  for (int k = 0; k < num_blocks; ++k) {
    vertex_of_block_[k] = vertex_of[order[k]];
    block_of_vertex_[vertex_of_block_[k]] = k;
  }

  // Rows in ascending order without sorting: the pattern is symmetric, so row by row every block
  // is appended to the columns it stands in.
  column_begin_.assign(num_blocks + 1, 0);
  const auto for_each_below = [&](const auto& use) {
    for (int row = 0; row < num_blocks; ++row) {
      const int i = order[row];
      for (int m = neighbour_begin[i]; m < neighbour_begin[i + 1]; ++m) {
        const int column = block_of_vertex_[vertex_of[neighbours[m]]];
        if (column <= row) use(row, column);
      }
    }
  };
  for_each_below([&](int, int column) { ++column_begin_[column + 1]; });
  for (int k = 0; k < num_blocks; ++k) column_begin_[k + 1] += column_begin_[k];
  row_block_.resize(column_begin_.back());
  std::vector<int> end(column_begin_.begin(), column_begin_.end() - 1);
  for_each_below([&](int row, int column) { row_block_[end[column]++] = row; });

  const int c = components_;
  outer_.push_back(0);
  for (int j = 0; j < num_blocks; ++j) {
    const int below = column_begin_[j + 1] - column_begin_[j] - 1;
    for (int b = 0; b < c; ++b) outer_.push_back(outer_.back() + (c - b) + c * below);
  }

  // Column by column: the rows of one are looked up in a table of all blocks.
  element_slot_begin_.push_back(0);
  for (int e = 0; e < num_elements; ++e) {
    const int n = static_cast<int>(terms[e]->size());
    element_slot_begin_.push_back(element_slot_begin_.back() + n * (n + 1) / 2);
  }
  element_slots_.assign(element_slot_begin_.back(), 0);
  std::vector<int> slot_of(num_blocks, 0);
  for (int column = 0; column < num_blocks; ++column) {
    for (int k = column_begin_[column]; k < column_begin_[column + 1]; ++k) {
      slot_of[row_block_[k]] = k + 1;
    }
    const int i = order[column];
    for (int k = term_begin[i]; k < term_begin[i + 1]; ++k) {
      if (term_of[k] >= num_elements) continue;
      const std::vector<int>& vertices = *terms[term_of[k]];
      const int n = static_cast<int>(vertices.size());
      int own = 0;
      while (vertices[own] != vertex_of_block_[column]) ++own;
      // Of local vertices i >= j, counted column by column.
      const auto index = [n](int row, int col) {
        return col * n - col * (col - 1) / 2 + row - col;
      };
      int* const slots = element_slots_.data() + element_slot_begin_[term_of[k]];
      for (int other = 0; other < n; ++other) {
        const int row = block_of_vertex_[vertices[other]];
        if (row < column) continue;
        if (other >= own) {
          slots[index(other, own)] = slot_of[row];
        } else {
          slots[index(own, other)] = -slot_of[row];
        }
      }
    }
  }
}

Eigen::SparseMatrix<double> StiffnessPattern::MakeMatrix() const {
  const int c = components_;
  Eigen::SparseMatrix<double> matrix(c * num_blocks(), c * num_blocks());
  matrix.resizeNonZeros(num_nonzeros());
  std::copy(outer_.begin(), outer_.end(), matrix.outerIndexPtr());
  int* row = matrix.innerIndexPtr();
  for (int j = 0; j < num_blocks(); ++j) {
    for (int b = 0; b < c; ++b) {
      for (int a = b; a < c; ++a) *row++ = c * j + a;
      for (int k = column_begin_[j] + 1; k < column_begin_[j + 1]; ++k) {
        for (int a = 0; a < c; ++a) *row++ = c * row_block_[k] + a;
      }
    }
  }
  return matrix;
}

int StiffnessPattern::Slot(int row, int column) const {
  const auto begin = row_block_.begin() + column_begin_[column];
  const auto end = row_block_.begin() + column_begin_[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - row_block_.begin());
}

}  // namespace darboux
