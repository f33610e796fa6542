#ifndef DARBOUX_SOLVER_INP_MESH_H_
#define DARBOUX_SOLVER_INP_MESH_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "geometry/shell_surface.h"

namespace darboux {

// Finite elements of CalculiX and Abaqus on a shell's rest surface (solver/inp_export.h).

// Elements by their names in CalculiX and Abaqus.
enum class InpElement {
  kS3,  // triangles of 3 and 6 nodes, quadrilaterals of 4 and 8
  kS4,
  kS6,
  kS8R,
  kC3D15,  // one layer of wedges of 15 nodes, bricks of 20
  kC3D20R
};
const char* ToString(InpElement element);
// False for other names.
bool ParseInpElement(const std::string& name, InpElement* element);
bool IsSolid(InpElement element);
// Of four corners; only a parametric surface has cells for them.
bool IsQuadrilateral(InpElement element);

// The elements of a shell: those of Darboux (cut in two to four where triangles of two sizes meet),
// or the cells of a parametric surface. All nodes of the middle surface lie on the limit surface,
// also those between corners, so that quadratic elements have its curvature.
//
// A node of the middle surface is called a column here: solid elements have one to three nodes on
// its fibre, at heights -h/2, 0, h/2 along the normal; the middle one is there at corners only.
class InpMesh {
 public:
  // A point of the middle surface with the nodes on its fibre.
  struct Column {
    ElementPoint at;
    Eigen::Vector3d position, normal;
    bool is_corner = true;
    std::array<int, 3> nodes{};  // bottom, middle, top; of a shell all are the same; 0: none
  };
  // A node and the column that it belongs to.
  struct Node {
    Eigen::Vector3d position;
    int column = 0;
  };

  // Precondition: a parametric surface for quadrilaterals.
  InpMesh(const ShellSurface& surface, InpElement element, double thickness);

  const ShellSurface& surface() const { return surface_; }
  InpElement element() const { return element_; }
  bool is_solid() const { return IsSolid(element_); }
  double thickness() const { return thickness_; }
  const std::vector<Column>& columns() const { return columns_; }
  // Numbered from 1.
  const std::vector<Node>& nodes() const { return nodes_; }
  // Columns of each element: corners, counterclockwise from the normal's side, then the middles of
  // the edges from each corner to the next.
  const std::vector<std::vector<int>>& elements() const { return elements_; }
  // Node numbers of an element in the order of its type.
  std::vector<int> ElementNodes(int element) const;

  // The element that a point of the shell is in, and the values of its shape functions there (of
  // the middle surface; one for each of its columns).
  int Locate(const ElementPoint& at, std::vector<double>* values) const;

  // Edges of elements along a side: ends and middle (-1 in linear elements).
  struct Edge {
    int begin, end, middle;
    ElementPoint begin_at, end_at;
  };
  std::vector<Edge> SideEdges(Side side) const;

  // The column nearest to a point; only corners count where `corner`.
  int Nearest(const Eigen::Vector3d& x, bool corner) const;
  // Corners far from each other: the one farthest from x, then that farthest from those before, ...
  std::vector<int> FarCorners(const Eigen::Vector3d& x, size_t count) const;
  // Mean size of an element.
  double element_size() const { return element_size_; }

 private:
  // Corners of a piece in the coordinates (s, t) of its element.
  struct Piece {
    int number;  // of the element of this mesh
    std::array<Eigen::Vector2d, 3> corners;
  };
  void AddTriangles();
  void AddQuadrilaterals();
  void AddNodes();
  int Corner(int place, const ElementPoint& at);
  int Middle(int column_a, int column_b, const ElementPoint& at);
  int AddColumn(const ElementPoint& at, bool is_corner);

  const ShellSurface& surface_;
  InpElement element_;
  double thickness_;
  double element_size_ = 0.0;
  std::vector<Column> columns_;
  std::vector<Node> nodes_;
  std::vector<std::vector<int>> elements_;
  std::vector<std::vector<Piece>> pieces_;  // of each element of the surface; triangles only
  std::vector<int> corners_;                // columns of the surface's corners, -1: none yet
  std::map<std::pair<int, int>, int> middles_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_INP_MESH_H_
