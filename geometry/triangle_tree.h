#ifndef DARBOUX_GEOMETRY_TRIANGLE_TREE_H_
#define DARBOUX_GEOMETRY_TRIANGLE_TREE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// The triangles of a mesh in boxes, halved by their centres across the longest side of these.
class TriangleTree {
 public:
  // A box around the triangles order()[begin .. end). Leaves have no children: left < 0.
  struct Node {
    Eigen::AlignedBox3d box;
    int begin, end;
    int left = -1, right = -1;
  };

  TriangleTree() = default;
  explicit TriangleTree(const TriangleMesh& mesh);

  // The first one is around all; none where there are no triangles.
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<int>& order() const { return order_; }
  const Eigen::Vector3d& center(int triangle) const {
    return centers_[static_cast<std::size_t>(triangle)];
  }

 private:
  int MakeNode(const TriangleMesh& mesh, int begin, int end);

  std::vector<int> order_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<Node> nodes_;
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_TRIANGLE_TREE_H_
