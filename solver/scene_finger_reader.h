#ifndef DARBOUX_SOLVER_SCENE_FINGER_READER_H_
#define DARBOUX_SOLVER_SCENE_FINGER_READER_H_

#include <string>
#include <vector>

#include "solver/scene_surface_reader.h"

// The section `fingers` of a scene. Part of the scene reader, not installed.

namespace darboux {

class FingerReader : public SurfaceReader {
 protected:
  FingerReader(const std::string& file, const std::string& folder, const ReadOptions& options)
      : SurfaceReader(file, folder, options) {}
  ~FingerReader() = default;

  // others: those read before, whose names are taken.
  bool ReadFinger(const YamlField& field,
                  const std::vector<FingerSpec>& others,
                  FingerSpec* finger);

 private:
  bool ReadShape(const YamlField& field, FingerSpec* finger);
  bool ReadUnitVector(const YamlField& field, std::array<double, 3>* vector);
};

// Letters, digits and _, no digit first: names that are part of a path into summary.json.
bool IsIdentifier(const std::string& text);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_FINGER_READER_H_
