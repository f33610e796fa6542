#include "geometry/icosphere.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "geometry/triangle_mesh.h"
#include "tests/mesh_quality.h"

namespace darboux {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

class IcosphereTest : public ::testing::TestWithParam<int> {
 protected:
  const double radius_ = 0.035;
  const int n_ = GetParam();
  const TriangleMesh mesh_ = MakeIcosphere(radius_, n_);
  const MeshQuality quality_ = MeasureMesh(mesh_);
};

TEST_P(IcosphereTest, IsAClosedSphereSeenCounterclockwiseFromOutside) {
  EXPECT_EQ(mesh_.vertices.size(), static_cast<size_t>(10 * n_ * n_ + 2));
  EXPECT_EQ(mesh_.triangles.size(), static_cast<size_t>(20 * n_ * n_));
  EXPECT_TRUE(quality_.is_manifold);
  EXPECT_EQ(quality_.num_boundary_edges, 0);
  EXPECT_EQ(quality_.euler_characteristic, 2);
  EXPECT_EQ(quality_.num_components, 1);
  for (const std::array<int, 3>& t : mesh_.triangles) {
    const Eigen::Vector3d& a = mesh_.vertices[t[0]];
    EXPECT_GT(a.dot(mesh_.vertices[t[1]].cross(mesh_.vertices[t[2]])), 0.0);
  }
}

TEST_P(IcosphereTest, LiesOnTheSphere) {
  for (const Eigen::Vector3d& p : mesh_.vertices) EXPECT_NEAR(p.norm(), radius_, 1e-15 * radius_);
}

TEST_P(IcosphereTest, HasTwelveVerticesOfValenceFiveAndElseSix) {
  if (n_ == 1) {
    EXPECT_THAT(quality_.valences, UnorderedElementsAre(Pair(5, 12)));
  } else {
    EXPECT_THAT(quality_.valences, UnorderedElementsAre(Pair(5, 12), Pair(6, 10 * n_ * n_ - 10)));
  }
}

TEST_P(IcosphereTest, IsEven) {  // The bounds that the header states.
  EXPECT_LT(quality_.max_edge / quality_.min_edge, 1.18);
  EXPECT_LT(quality_.max_area / quality_.min_area, 1.21);
  EXPECT_GT(quality_.min_angle_deg, 53.9);
}

TEST_P(IcosphereTest, MirrorsInTheCoordinatePlanes) {
  if (n_ > 16) return;  // All pairs.
  for (const Eigen::Vector3d& p : mesh_.vertices) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d image = p;
      image[axis] = -image[axis];
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& q : mesh_.vertices) {
        nearest = std::min(nearest, (q - image).norm());
      }
      EXPECT_LT(nearest, 1e-15 * radius_);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frequency, IcosphereTest, ::testing::Values(1, 2, 3, 4, 5, 8, 16, 31, 64));

TEST(MakeIcosphereTest, AreaAndVolumeConvergeWithOrderTwo) {
  double area_error[2], volume_error[2];
  for (int i = 0; i < 2; ++i) {
    const MeshQuality q = MeasureMesh(MakeIcosphere(1.0, 16 << i));
    area_error[i] = 4.0 * M_PI - q.area;
    volume_error[i] = 4.0 / 3.0 * M_PI - q.volume;
  }
  EXPECT_NEAR(area_error[0] / area_error[1], 4.0, 0.02);
  EXPECT_NEAR(volume_error[0] / volume_error[1], 4.0, 0.02);
  EXPECT_LT(volume_error[1], 1e-2);
}

TEST(MakeIcosphereTest, ScalesExactly) {
  const TriangleMesh m = MakeIcosphere(1.0, 7);
  const TriangleMesh mm = MakeIcosphere(1000.0, 7);
  EXPECT_EQ(m.triangles, mm.triangles);
  for (size_t i = 0; i < m.vertices.size(); ++i) {
    EXPECT_LE((mm.vertices[i] - 1000.0 * m.vertices[i]).norm(), 1e-12);
  }
}

TEST(MakeIcosphereTest, EvenFrequencyHasVerticesOnTheAxes) {
  const TriangleMesh mesh = MakeIcosphere(2.0, 8);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d pole = 2.0 * sign * Eigen::Vector3d::Unit(axis);
      EXPECT_TRUE(std::any_of(
          mesh.vertices.begin(), mesh.vertices.end(), [&pole](const Eigen::Vector3d& p) {
            return (p - pole).norm() < 1e-14;
          }));
    }
  }
}

}  // namespace
}  // namespace darboux
