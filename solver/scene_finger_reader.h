#ifndef DARBOUX_SOLVER_SCENE_FINGER_READER_H_
#define DARBOUX_SOLVER_SCENE_FINGER_READER_H_

#include <string>
#include <vector>

#include "solver/scene_hand_reader.h"

// The section `fingers` of a scene. Part of the scene reader, not installed.

namespace darboux {

class FingerReader : public HandReader {
 protected:
  FingerReader(const std::string& file, const std::string& folder, const ReadOptions& options)
      : HandReader(file, folder, options) {}
  ~FingerReader() = default;

  // others: those read before, whose names are taken.
  bool ReadFinger(const YamlField& field,
                  const std::vector<FingerSpec>& others,
                  FingerSpec* finger);

 private:
  // `finger_map`: the finger's own, of which links of a hand read place and direction as well.
  bool ReadShape(const YamlField& field,
                 const YamlMap& finger_map,
                 bool* is_link,
                 FingerSpec* finger);
  bool ReadPlace(const YamlMap& map, FingerSpec* finger);
};

// Letters, digits and _, no digit first: names that are part of a path into summary.json.
bool IsIdentifier(const std::string& text);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCENE_FINGER_READER_H_
