#ifndef DARBOUX_SOLVER_CALIBRATION_REPORT_H_
#define DARBOUX_SOLVER_CALIBRATION_REPORT_H_

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "solver/report_view.h"

namespace darboux {

// The report of a calibration: a view of every grasp in the calibrated state, each with "summary",
// the contents of its summary.json, with its scans beside it as registered and their distances from
// the outer face, less the offset of the rest surface that was estimated; what is farther than
// three deviations has no part in the map scan_distance. calibration: MakeCalibrationJson.
Report MakeCalibrationReport(const std::string& tool,
                             const CalibrationSpec& spec,
                             const CalibrationSummary& summary,
                             const std::vector<std::unique_ptr<StateModel>>& models,
                             const nlohmann::ordered_json& calibration);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_REPORT_H_
