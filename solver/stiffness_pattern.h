#ifndef DARBOUX_SOLVER_STIFFNESS_PATTERN_H_
#define DARBOUX_SOLVER_STIFFNESS_PATTERN_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <vector>

#include "solver/sparse_cholesky.h"

namespace darboux {

// Where the entries of a stiffness matrix are: its blocks of `components` rows and columns belong
// to the free control vertices, ordered to keep the factor sparse, and there is one for every pair
// of vertices that share a term of the energy. Only the lower triangle is stored, column by column,
// so that elements find their blocks by number.
class StiffnessPattern {
 public:
  // terms: the vertices of each term of the energy, those of the elements first. Vertices for which
  // is_free is false have no block.
  StiffnessPattern(int num_vertices,
                   int components,
                   const std::function<bool(int)>& is_free,
                   const std::vector<const std::vector<int>*>& terms,
                   int num_elements,
                   SparseBackend backend);

  int num_vertices() const { return static_cast<int>(block_of_vertex_.size()); }
  int num_blocks() const { return static_cast<int>(vertex_of_block_.size()); }
  int num_nonzeros() const { return outer_.back(); }
  // Position in the order of elimination; -1: not unknown.
  int block_of_vertex(int vertex) const { return block_of_vertex_[vertex]; }
  int vertex_of_block(int block) const { return vertex_of_block_[block]; }

  // A matrix with this pattern and values that are not set.
  Eigen::SparseMatrix<double> MakeMatrix() const;

  // Adds the block of a pair of vertices, of the rows of the one and the columns of the other, to
  // the values of such a matrix; nothing where one is not unknown or the block is above the
  // diagonal. Precondition: the pair shares a term.
  template <typename Block>
  void Add(int row_vertex, int column_vertex, const Block& block, double* values) const {
    const int column = block_of_vertex_[column_vertex];
    const int row = block_of_vertex_[row_vertex];
    if (column < 0 || row < column) return;
    AddAt(Slot(row, column), column, block, values);
  }

  // Adds the matrix of an element with these vertices: block(i, j) of local vertices i >= j.
  template <int kComponents, typename Block>
  void AddElement(int element,
                  const std::vector<int>& vertices,
                  const Block& block,
                  double* values) const {
    const int n = static_cast<int>(vertices.size());
    const int* slot = element_slots_.data() + element_slot_begin_[element];
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i, ++slot) {
        if (*slot == 0) continue;
        const Eigen::Matrix<double, kComponents, kComponents> one = block(i, j);
        if (*slot > 0) {
          AddAt(*slot - 1, block_of_vertex_[vertices[j]], one, values);
        } else {
          AddAt(-*slot - 1, block_of_vertex_[vertices[i]], one.transpose(), values);
        }
      }
    }
  }

 private:
  // Index into row_block_ of a block of the lower triangle.
  int Slot(int row, int column) const;

  template <typename Block>
  void AddAt(int slot, int column, const Block& block, double* values) const {
    const int c = static_cast<int>(block.rows());
    const int k = slot - column_begin_[column];
    for (int b = 0; b < c; ++b) {
      double* const to = values + outer_[c * column + b];
      if (k == 0) {
        for (int a = b; a < c; ++a) to[a - b] += block(a, b);
      } else {
        for (int a = 0; a < c; ++a) to[(c - b) + c * (k - 1) + a] += block(a, b);
      }
    }
  }

  int components_;
  std::vector<int> block_of_vertex_, vertex_of_block_;
  // Blocks of the lower triangle: of block column j, rows row_block_[column_begin_[j]] ..., the
  // diagonal first, ascending.
  std::vector<int> column_begin_, row_block_;
  // Per element, for local vertices i >= j, the block of the lower triangle they share: index into
  // row_block_, plus one, negative where it is the transpose; 0: not unknown.
  std::vector<int> element_slots_, element_slot_begin_;
  std::vector<int> outer_;  // of the matrix: where its columns begin
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_STIFFNESS_PATTERN_H_
