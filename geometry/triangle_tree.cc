#include "geometry/triangle_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace darboux {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) : order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[static_cast<std::size_t>(t[0])],
                   &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    centers_.push_back((a + b + c) / 3.0);
  }
  if (!order_.empty()) MakeNode(mesh, 0, static_cast<int>(order_.size()));
}

int TriangleTree::MakeNode(const TriangleMesh& mesh, int begin, int end) {
  constexpr int kLeaf = 4;
  const std::size_t index = nodes_.size();
  nodes_.push_back({AlignedBox3d(), begin, end});
  AlignedBox3d box, centers;
  for (int i = begin; i < end; ++i) {
    const int triangle = order_[static_cast<std::size_t>(i)];
    for (const int v : mesh.triangles[static_cast<std::size_t>(triangle)]) {
      box.extend(mesh.vertices[static_cast<std::size_t>(v)]);
    }
    centers.extend(center(triangle));
  }
  nodes_[index].box = box;
  if (end - begin <= kLeaf) return static_cast<int>(index);
  int axis;
  centers.sizes().maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::nth_element(
      order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        return center(a)[axis] < center(b)[axis];
      });
  const int left = MakeNode(mesh, begin, middle);
  const int right = MakeNode(mesh, middle, end);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return static_cast<int>(index);
}

}  // namespace darboux
