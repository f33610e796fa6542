#ifndef DARBOUX_SOLVER_SCENE_SURFACE_READER_H_
#define DARBOUX_SOLVER_SCENE_SURFACE_READER_H_

#include <array>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.h"
#include "solver/scene.h"
#include "solver/scene_reader.h"
#include "solver/scene_surface_checks.h"
#include "solver/yaml_reader.h"

// The section `surface` of a scene, and the places and functions on the surface to which the other
// sections refer. Part of the scene reader, not installed.

namespace darboux {

inline constexpr char kVectorAllowed[] = "a list of three numbers, [x, y, z]";
inline constexpr char kValueAllowed[] = "a number or an expression of u, v, x, y, z";

// Empty, or what is allowed in place of these divisions.
std::string DivisionsAllowed(const std::array<int, 2>& divisions,
                             const std::array<bool, 2>& periodic);

class SurfaceReader : public YamlReader {
 protected:
  // Mesh files are relative to the folder; empty: the current one.
  SurfaceReader(const std::string& file, const std::string& folder, const ReadOptions& options)
      : YamlReader(file), folder_(folder), options_(options) {}
  ~SurfaceReader() = default;

  bool ReadSurface(const YamlField& field);

  // All below need the surface.

  // A number or an expression that is finite at all samples `where`; three of them.
  bool ReadValue(const YamlField& field,
                 const std::vector<SurfaceSample>& where,
                 SceneValue* value);
  bool ReadVector(const YamlField& field,
                  const std::vector<SurfaceSample>& where,
                  SceneVector* value);

  // A value of u (parameter 0) or v (parameter 1) in its range.
  bool ReadParameter(const YamlField& field, int parameter, double* value);
  bool ReadRegion(const YamlField& field, bool near_allowed, Region* region);
  bool ReadPoint(const YamlField& field, SurfacePoint* point);

  // A file that the scene names.
  std::string Resolve(const std::string& file) const;
  // What messages call it: a file with its folder.
  std::string NameOf(const std::string& file) const;
  // The mesh of this name: in memory (ReadOptions::data), or of a file.
  bool ReadNamedMesh(const std::string& name, TriangleMesh* mesh, std::string* error) const;

  const SurfaceSpec& surface() const { return surface_; }
  const std::vector<SurfaceSample>& samples() const { return samples_; }

 private:
  bool ReadShape(const YamlMap& map);
  bool ReadMeshSurface(const YamlMap& map);
  bool ReadMeshFile(const YamlMap& map, TriangleMesh* mesh);
  bool ReadImplicit(const YamlMap& map, TriangleMesh* mesh);
  bool ReadIcosphere(const YamlMap& map, TriangleMesh* mesh);
  bool Refine(const YamlField& field, int levels, TriangleMesh* mesh);
  bool ReadRefineNear(const YamlField& field);
  bool ReadGrid(const YamlMap& map);
  bool CheckSurface(const YamlMap& map);

  const std::array<double, 2>& Range(int parameter) const {
    return parameter == 0 ? surface_.u_range : surface_.v_range;
  }

  const std::string folder_;
  const ReadOptions options_;
  SurfaceSpec surface_;
  std::vector<SurfaceSample> samples_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_SURFACE_READER_H_
