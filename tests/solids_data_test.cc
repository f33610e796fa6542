// What data/solids/ says it is: rest points on the outer face of the shell that the scenes
// describe, found there by scripts that share no code with the library.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/loop_mesh.h"
#include "geometry/mesh_io.h"
#include "geometry/shell_surface.h"
#include "geometry/triangle_mesh.h"

namespace darboux {
namespace {

struct Field {
  std::vector<Eigen::Vector3d> rest, displacement;
};

Field ReadField(const std::string& name) {
  std::ifstream in(std::string(DARBOUX_DATA_DIR) + "/solids/" + name);
  EXPECT_TRUE(in.good()) << name;
  Field field;
  std::string line;
  while (std::getline(in, line)) {
    Eigen::Vector3d x, u;
    if (std::sscanf(line.c_str(),
                    "%lf,%lf,%lf,%lf,%lf,%lf",
                    &x.x(),
                    &x.y(),
                    &x.z(),
                    &u.x(),
                    &u.y(),
                    &u.z()) == 6) {
      field.rest.push_back(x);
      field.displacement.push_back(u);
    }
  }
  return field;
}

TEST(SolidsData, DuckRestsHalfItsThicknessOutsideTheLimitSurface) {
  TriangleMesh mesh;
  std::string error;
  ASSERT_TRUE(ReadMesh(std::string(DARBOUX_DATA_DIR) + "/duck_2562.obj", &mesh, &error)) << error;
  const ShellSurface surface(MakeLoopMesh(mesh));
  for (const char* travel : {"2", "4", "6", "8.5"}) {
    const Field field = ReadField("duck_" + std::string(travel) + "mm.csv");
    ASSERT_EQ(field.rest.size(), mesh.vertices.size());
    for (int e = 0; e < surface.num_elements(); ++e) {
      const ElementPoint corners[] = {{e, 0.0, 0.0}, {e, 1.0, 0.0}, {e, 0.0, 1.0}};
      for (int i = 0; i < 3; ++i) {
        const StrainPoint p = surface.MakePoint(corners[i]);
        const int k = surface.mesh().triangles[e][i];
        // Seven digits of coordinates up to the duck's size.
        ASSERT_LE((p.position + 0.00075 * p.n - field.rest[k]).norm(), 1e-6 * surface.size()) << k;
      }
    }
  }
}

TEST(SolidsData, DuckIsMovedAlikeOnBothSides) {
  for (const char* travel : {"2", "4", "6", "8.5"}) {
    const Field field = ReadField("duck_" + std::string(travel) + "mm.csv");
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double least = 0.0, largest = 0.0;
    for (const Eigen::Vector3d& u : field.displacement) {
      sum += u;
      least = std::min(least, u.y());
      largest = std::max(largest, u.y());
    }
    EXPECT_NEAR(sum.y(), 0.0, 1e-9);
    EXPECT_NEAR(least, -largest, 1e-9);
    // The shell under the fingers goes with them.
    EXPECT_NEAR(1e3 * largest, std::stod(travel), 0.01 * std::stod(travel));
  }
}

TEST(SolidsData, BallFacesLieOnTheirSpheresAndArePushedByTheTravel) {
  const struct {
    std::string prefix;
    std::vector<double> travels;
    double inflation;  // of the outer pole before the fingers touch, from travel 0
  } cases[] = {{"ball", {1, 2, 3, 4, 5, 6, 8}, 0.0},
               {"ball_gas", {2, 4, 6}, ReadField("ball_gas_0mm.csv").displacement.front().z()}};
  for (const auto& c : cases) {
    for (const double travel : c.travels) {
      std::ostringstream name;
      name << c.prefix << "_" << travel << "mm";
      const Field outer = ReadField(name.str() + ".csv");
      const Field inner = ReadField(name.str() + "_inner.csv");
      ASSERT_GE(outer.rest.size(), 150u);
      ASSERT_EQ(outer.rest.size(), inner.rest.size());
      for (std::size_t k = 0; k < outer.rest.size(); ++k) {
        EXPECT_NEAR(outer.rest[k].norm(), 32.5, 1e-5);
        EXPECT_NEAR(inner.rest[k].norm(), 30.0, 1e-5);
        EXPECT_EQ(outer.rest[k].y(), 0.0);
        const std::size_t mirror = outer.rest.size() - 1 - k;
        EXPECT_EQ(outer.rest[k].z(), -outer.rest[mirror].z());
        EXPECT_EQ(outer.displacement[k].z(), -outer.displacement[mirror].z());
        EXPECT_EQ(outer.displacement[k].x(), outer.displacement[mirror].x());
      }
      // The first point is 0.16 beside the pole, where the finger is 6e-3 higher.
      EXPECT_NEAR(outer.displacement.front().z(), c.inflation - travel, 0.01) << name.str();
      // The wall is squeezed under the finger.
      EXPECT_GT(inner.displacement.front().z(), outer.displacement.front().z());
    }
  }
}

}  // namespace
}  // namespace darboux
