#ifndef DARBOUX_TESTS_FUZZ_TARGETS_H_
#define DARBOUX_TESTS_FUZZ_TARGETS_H_

#include <glog/logging.h>

#include <string>
#include <string_view>
#include <vector>

#include "geometry/mesh_doctor.h"
#include "geometry/mesh_io.h"
#include "geometry/point_cloud.h"
#include "geometry/urdf.h"
#include "solver/scene_reader.h"

namespace darboux {

// What any bytes may do to the readers: nothing but a result, or one line of an error. Both abort
// where that does not hold. Used by the fuzzers (DARBOUX_BUILD_FUZZERS) and by fuzz_replay_test.

inline void CheckMessage(const std::string& error) {
  CHECK(!error.empty());
  CHECK(error.find('\n') == std::string::npos) << error;
}

// A scene file.
inline void FuzzScene(std::string_view data) {
  Scene scene;
  scene.name = "untouched";
  std::string error;
  if (ParseScene(std::string(data), "fuzz.yaml", &scene, &error)) return;
  CheckMessage(error);
  CHECK_EQ(scene.name, "untouched");
}

// A mesh or point file; its first byte says of which format.
inline void FuzzMesh(std::string_view data) {
  if (data.empty()) return;
  constexpr const char* kNames[] = {"fuzz.obj", "fuzz.ply", "fuzz.stl", "fuzz.off", "fuzz.csv"};
  const unsigned format = static_cast<unsigned char>(data[0]) % 5;
  const std::string_view contents = data.substr(1);
  std::string error;
  if (format == 4) {
    PointCloud cloud;
    if (!ParsePointCloud(contents, kNames[format], &cloud, &error)) CheckMessage(error);
    return;
  }
  TriangleMesh mesh;
  if (!ParseMesh(contents, kNames[format], &mesh, &error)) {
    CheckMessage(error);
    CHECK(mesh.vertices.empty() && mesh.triangles.empty());
    return;
  }
  // The doctor takes whatever the reader lets through.
  for (const MeshDefect& defect : FindMeshDefects(mesh, MeshDoctorOptions())) {
    CheckMessage(defect.text);
  }
}

// A robot hand, and where its links are.
inline void FuzzUrdf(std::string_view data) {
  Urdf urdf;
  std::string error;
  if (!ParseUrdf(std::string(data), "fuzz.urdf", &urdf, &error)) {
    CheckMessage(error);
    CHECK(urdf.links.empty() && urdf.joints.empty());
    return;
  }
  std::vector<UrdfPose> poses;
  if (UrdfPoses(urdf, {}, UrdfPose(), &poses, &error)) {
    CHECK_EQ(poses.size(), urdf.links.size());
  } else {
    CheckMessage(error);
  }
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_FUZZ_TARGETS_H_
