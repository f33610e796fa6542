#ifndef DARBOUX_SOLVER_CALIBRATION_RESULTS_H_
#define DARBOUX_SOLVER_CALIBRATION_RESULTS_H_

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "solver/exports.h"
#include "solver/results.h"

namespace darboux {

// The contents of calibration.json. Keys are stable; a number that is not finite, such as the
// deviation of what is not identifiable, is null, and so is the value of what was not found.
nlohmann::ordered_json MakeCalibrationJson(const CalibrationSpec& spec,
                                           const CalibrationSummary& summary);

// Writes calibration.json into a folder, created when missing, and for every grasp a folder
// grasp_1, grasp_2, ... with the results of its scene in the calibrated state (solver/results.h)
// and, where it has scans, scan_1.ply, ...: their points on the shell's side. models may be empty:
// then there are no such folders. `exports`: csv and npz go into them. more: of the contents of
// calibration.json, beside it. False and *error where a file cannot be written.
bool WriteCalibration(const std::string& folder,
                      const CalibrationSpec& spec,
                      const CalibrationSummary& summary,
                      const std::vector<std::unique_ptr<StateModel>>& models,
                      const ExportOptions& exports,
                      std::string* error,
                      const MoreFiles& more = nullptr);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_RESULTS_H_
