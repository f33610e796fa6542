#ifndef DARBOUX_TOOLS_SCAN_TRUTH_H_
#define DARBOUX_TOOLS_SCAN_TRUTH_H_

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/rigid_pose.h"
#include "geometry/scan_simulator.h"
#include "solver/report_view.h"
#include "tools/scan_target.h"

namespace darboux {

// What is known of a simulated scan, for truth.json, truth.csv and the report.
nlohmann::ordered_json CoordinatesJson(const Eigen::Vector3d& x);
nlohmann::ordered_json MotionJson(const RigidPose& pose);
std::string TruthCsv(const Scan& scan);

// Triangles of which all vertices are scanned, and none is a stray.
std::vector<std::array<int, 3>> FacesOf(const ScanSurface& surface, const Scan& scan);

// The surface with the scan beside it, in the frame of the surface, and what is wrong about each
// point: its distance from where it should be, along the normal where there is one. `unit`: of
// length; empty: not known. `tool`: its name.
Report MakeScanReport(const std::string& tool,
                      const std::string& name,
                      const ScanTarget& target,
                      const Scan& scan,
                      const std::string& unit,
                      const nlohmann::ordered_json& truth);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_SCAN_TRUTH_H_
