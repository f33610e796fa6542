#ifndef DARBOUX_SOLVER_CALIBRATION_READER_H_
#define DARBOUX_SOLVER_CALIBRATION_READER_H_

#include <string>

#include "solver/calibration.h"
#include "solver/named_data.h"

namespace darboux {

// Reads what darboux_calibrate is asked for from a YAML file; data/README.md lists the keys. As
// strict as the reader of scenes (solver/scene_reader.h), and with the same messages. Scenes, scans
// and fields that it names are read from its folder, and checked.
bool ReadCalibration(const std::string& file, CalibrationSpec* spec, std::string* error);

// The same from text; files that it names are read from `folder`, and `file` is for messages.
// data: scenes and points that are not in files; may be null.
bool ParseCalibration(const std::string& text,
                      const std::string& file,
                      const std::string& folder,
                      CalibrationSpec* spec,
                      std::string* error,
                      const NamedData* data = nullptr);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_READER_H_
