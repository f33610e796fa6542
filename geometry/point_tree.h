#ifndef DARBOUX_GEOMETRY_POINT_TREE_H_
#define DARBOUX_GEOMETRY_POINT_TREE_H_

#include <Eigen/Core>
#include <array>
#include <vector>

namespace darboux {

// Finds the nearest few of given points: a balanced tree, halved at medians along the longest side
// of the box around each half. O(n log n) to build, O(log n) to search. Search is thread-safe.
class PointTree {
 public:
  static constexpr int kMost = 16;
  // The points nearest to a place, `count` of them, nearest first.
  struct Neighbours {
    int count = 0;
    std::array<int, kMost> index{};       // of the points given
    std::array<double, kMost> squared{};  // distances, ascending
  };

  void Build(std::vector<Eigen::Vector3d> points);
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  // The `most` <= kMost points nearest to x, as many as there are.
  Neighbours Nearest(const Eigen::Vector3d& x, int most) const;

 private:
  void Halve(int begin, int end);
  void Search(int begin, int end, const Eigen::Vector3d& x, int most, Neighbours* found) const;

  std::vector<Eigen::Vector3d> points_;
  std::vector<int> order_;
  std::vector<char> axis_;  // of the point in the middle of a range
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_POINT_TREE_H_
