#include "geometry/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace darboux {
namespace {

TEST(PointTreeTest, FindsWhatSortingFinds) {
  std::mt19937_64 generator(5);
  std::uniform_int_distribution<int> coordinate(0, 12);  // many equal coordinates
  for (const int n : {0, 1, 5, 300}) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < n; ++i) {
      const int x = coordinate(generator), y = coordinate(generator), z = coordinate(generator);
      points.emplace_back(x, y, z);
    }
    PointTree tree;
    tree.Build(points);
    for (int k = 0; k < 100; ++k) {
      const double x = coordinate(generator), y = coordinate(generator), z = coordinate(generator);
      const Eigen::Vector3d at(x + 0.25, y - 0.125, z);
      std::vector<double> squared;
      for (const Eigen::Vector3d& point : points) squared.push_back((point - at).squaredNorm());
      std::sort(squared.begin(), squared.end());
      for (const int most : {1, 3, PointTree::kMost}) {
        const PointTree::Neighbours found = tree.Nearest(at, most);
        ASSERT_EQ(found.count, std::min(n, most));
        for (int i = 0; i < found.count; ++i) {
          EXPECT_EQ(found.squared[i], squared[i]);
          EXPECT_EQ((points[found.index[i]] - at).squaredNorm(), squared[i]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace darboux
