#ifndef DARBOUX_SOLVER_SCENE_READER_H_
#define DARBOUX_SOLVER_SCENE_READER_H_

#include <optional>
#include <string>

#include "solver/named_data.h"
#include "solver/scene.h"

namespace darboux {

// What a reader may do for a scene.
struct ReadOptions {
  // Mend the mesh file of a scene (geometry/mesh_repair.h; holes stay). SurfaceSpec::mended tells
  // what was done. What cannot be mended is an error still.
  bool repair = false;
  // Meshes that the scene names and that are not in files; must live as long as the reading takes.
  const NamedData* data = nullptr;
};

// Reads a scene from a YAML file. Strict: an unknown or repeated key, a wrong type, a non-finite
// number or an impossible value is an error, never silently ignored. On failure returns false,
// leaves *scene alone and sets *error to one message
//   FILE:LINE: KEY: what was found; what is allowed [; did you mean 'NEAREST'?]
// LINE counts from 1 and is 0 for a file that cannot be opened; KEY is "scene" where the mistake
// concerns the whole file (an empty one, YAML syntax). A mesh that the scene names is read from
// the scene's folder.
bool ReadScene(const std::string& file,
               Scene* scene,
               std::string* error,
               const ReadOptions& options = {});

// The same from text; `file` is only the name used in messages, and a mesh is read from the
// current folder, or from `folder`.
bool ParseScene(const std::string& text,
                const std::string& file,
                Scene* scene,
                std::string* error,
                const ReadOptions& options = {});
bool ParseSceneIn(const std::string& folder,
                  const std::string& text,
                  const std::string& file,
                  Scene* scene,
                  std::string* error,
                  const ReadOptions& options = {});

// What a tool's command line says in place of the scene file; unset members change nothing.
struct SceneOverrides {
  std::optional<std::string> theory;     // auto | linear | nonlinear
  std::optional<std::string> strains;    // koiter | seed
  std::optional<std::string> minimizer;  // auto | ceres
  std::optional<int> quadrature;         // 1, 3, 6, 12
  std::optional<std::string> divisions;  // "M,N"
};

// Applies all overrides or, on a mistake, none: returns false and sets *error to
//   --FLAG: what was found; what is allowed [; did you mean 'NEAREST'?]
bool ApplyOverrides(const SceneOverrides& overrides, Scene* scene, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_READER_H_
