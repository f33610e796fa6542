#ifndef DARBOUX_SOLVER_SCENE_HAND_READER_H_
#define DARBOUX_SOLVER_SCENE_HAND_READER_H_

#include <map>
#include <string>
#include <vector>

#include "geometry/urdf.h"
#include "solver/scene_surface_reader.h"

// The section `hand` of a scene, a robot hand from a URDF file, and fingers whose shapes are links
// of it. Part of the scene reader, not installed.

namespace darboux {

class HandReader : public SurfaceReader {
 protected:
  HandReader(const std::string& file, const std::string& folder, const ReadOptions& options)
      : SurfaceReader(file, folder, options) {}
  ~HandReader() = default;

  bool ReadHand(const YamlField& field);

  // Shape, position and direction of a finger that is a link: `shape` is its map of kind link,
  // `map` the finger's.
  bool ReadLinkFinger(const YamlField& shape, const YamlMap& map, FingerSpec* finger);

  bool ReadUnitVector(const YamlField& field, std::array<double, 3>* vector);

 private:
  bool ReadPose(const YamlField& field, UrdfPose* pose);
  bool ReadPackages(const YamlField& field);
  bool ReadLinkShape(const YamlField& field,
                     const UrdfShape& shape,
                     const UrdfPose& pose,
                     FingerSpec* finger);

  bool has_hand_ = false;
  Urdf urdf_;
  std::map<std::string, std::string> packages_;
  double scale_ = 1.0;           // units of the scene to a metre
  UrdfPose base_;                // in the scene
  std::vector<UrdfPose> poses_;  // of the links, in metres, in the root link
};

// A prism of regular polygons for a cylinder about z: `sides` corners on it.
TriangleMesh MakeCylinderMesh(double radius, double length, int sides);
TriangleMesh MakeBoxMesh(const std::array<double, 3>& half_sizes);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_HAND_READER_H_
