#include "geometry/point_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

namespace darboux {
namespace {

void Insert(int index, double squared, int most, PointTree::Neighbours* found) {
  if (found->count == most && squared >= found->squared[most - 1]) return;
  int at = found->count < most ? found->count++ : most - 1;
  for (; at > 0 && found->squared[at - 1] > squared; --at) {
    found->squared[at] = found->squared[at - 1];
    found->index[at] = found->index[at - 1];
  }
  found->squared[at] = squared;
  found->index[at] = index;
}

}  // namespace

void PointTree::Build(std::vector<Eigen::Vector3d> points) {
  points_ = std::move(points);
  order_.resize(points_.size());
  axis_.assign(points_.size(), 0);
  std::iota(order_.begin(), order_.end(), 0);
  Halve(0, static_cast<int>(order_.size()));
}

void PointTree::Halve(int begin, int end) {
  if (end - begin < 2) return;
  Eigen::AlignedBox3d box;
  for (int i = begin; i < end; ++i) box.extend(points_[order_[i]]);
  int axis;
  box.sizes().maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::nth_element(
      order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        return points_[a][axis] < points_[b][axis];
      });
  axis_[middle] = static_cast<char>(axis);
  Halve(begin, middle);
  Halve(middle + 1, end);
}

PointTree::Neighbours PointTree::Nearest(const Eigen::Vector3d& x, int most) const {
  Neighbours found;
  Search(0, static_cast<int>(order_.size()), x, most, &found);
  return found;
}

void PointTree::Search(
    int begin, int end, const Eigen::Vector3d& x, int most, Neighbours* found) const {
  if (begin >= end) return;
  const int middle = (begin + end) / 2;
  const Eigen::Vector3d& split = points_[order_[middle]];
  const double beyond = x[axis_[middle]] - split[axis_[middle]];
  const bool left_first = beyond < 0.0;
  Search(left_first ? begin : middle + 1, left_first ? middle : end, x, most, found);
  Insert(order_[middle], (split - x).squaredNorm(), most, found);
  if (found->count < most || beyond * beyond < found->squared[most - 1]) {
    Search(left_first ? middle + 1 : begin, left_first ? end : middle, x, most, found);
  }
}

}  // namespace darboux
