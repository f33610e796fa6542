#ifndef DARBOUX_TESTS_SOLIDS_UTIL_H_
#define DARBOUX_TESTS_SOLIDS_UTIL_H_

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/scan_simulator.h"
#include "geometry/surface_of_revolution.h"

// Scans and forces of the grasped bodies of data/solids, which are not Darboux' own.

namespace darboux {

inline PointCloud SolidPoints(const std::string& name) {
  PointCloud cloud;
  std::string error;
  EXPECT_TRUE(ReadPointCloud(DARBOUX_DATA_DIR "/solids/" + name, &cloud, &error)) << error;
  return cloud;
}

// The deformed outer face of a ball.
inline ScanSurface SolidBall(const std::string& name) {
  const PointCloud cloud = SolidPoints(name);
  std::vector<Eigen::Vector3d> profile;
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    profile.push_back(cloud.points[i] + cloud.displacements[i]);
  }
  TriangleMesh mesh;
  std::string error;
  EXPECT_TRUE(Revolve(profile, 360, &mesh, &error)) << error;
  return ScanSurfaceOf(std::move(mesh), {}, 0.0);
}

// The deformed outer face of the duck.
inline ScanSurface SolidDuck(const std::string& name) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_TRUE(ReadMesh(DARBOUX_DATA_DIR "/duck_2562.obj", &mesh, &error)) << error;
  const PointCloud cloud = SolidPoints(name);
  EXPECT_EQ(cloud.points.size(), mesh.vertices.size());
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    mesh.vertices[i] = cloud.points[i] + cloud.displacements[i];
  }
  return ScanSurfaceOf(std::move(mesh), {}, 0.0);
}

inline double SolidForce(const std::string& name, double travel) {
  std::ifstream file(DARBOUX_DATA_DIR "/solids/" + name);
  const nlohmann::json json = nlohmann::json::parse(file);
  for (const auto& result : json["results"]) {
    if (result["travel"].get<double>() == travel) return result["force"].get<double>();
  }
  ADD_FAILURE() << "no travel " << travel << " in " << name;
  return 0.0;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_SOLIDS_UTIL_H_
