#ifndef DARBOUX_SOLVER_NAMED_DATA_H_
#define DARBOUX_SOLVER_NAMED_DATA_H_

#include <map>
#include <string>

#include "geometry/point_cloud.h"
#include "geometry/triangle_mesh.h"
#include "solver/scene.h"

namespace darboux {

// Meshes, points and scenes that are in memory already, by the names that stand in a text where a
// file's would. Readers look here first, and check them as they check files. For programs that make
// scenes and calibrations themselves (tools/python).
struct NamedData {
  std::map<std::string, TriangleMesh> meshes;  // surface.file, fingers[i].shape.file
  std::map<std::string, PointCloud> clouds;    // grasps[i].scans[j], grasps[i].fields[j].file
  std::map<std::string, Scene> scenes;         // grasps[i].scene
};

// Null where there is no such entry, or no data at all.
template <typename T>
const T* FindNamed(const NamedData* data,
                   std::map<std::string, T> NamedData::*kind,
                   const std::string& name) {
  if (data == nullptr) return nullptr;
  const auto found = (data->*kind).find(name);
  return found == (data->*kind).end() ? nullptr : &found->second;
}

}  // namespace darboux

#endif  // DARBOUX_SOLVER_NAMED_DATA_H_
