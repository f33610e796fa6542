#include "solver/calibration_report.h"

#include <cmath>

#include "geometry/shell_face.h"
#include "solver/results.h"
#include "solver/scan_results.h"

namespace darboux {

Report MakeCalibrationReport(const std::string& tool,
                             const CalibrationSpec& spec,
                             const CalibrationSummary& summary,
                             const std::vector<std::unique_ptr<StateModel>>& models,
                             const nlohmann::ordered_json& calibration) {
  Report report = MakeReport(tool, spec.name);
  report.header["documents"]["calibration"] = calibration;
  for (size_t g = 0; g < models.size(); ++g) {
    const StateModel& model = *models[g];
    ReportShape shape;
    shape.title = "grasp " + std::to_string(g + 1) + ": " + model.scene().name;
    shape.problem = &model.problem();
    shape.states = StatesOf(model.summary());
    std::vector<ShellFace::Foot> feet;
    std::vector<double> distances;
    std::vector<char> counts;
    ShellFace face(model.problem().surface(), 0.5 * model.problem().material().thickness);
    face.SetDisplacements(model.displacements());
    const size_t num_scans = g < summary.grasps.size() ? summary.grasps[g].scans.size() : 0;
    for (size_t s = 0; s < num_scans; ++s) {
      const CalibrationSummary::Scan& scan = summary.grasps[g].scans[s];
      // No more points than can be looked at.
      const std::vector<Eigen::Vector3d>& all = spec.grasps[g].scans[s].cloud.points;
      ReportCloud cloud = MakeCloud("scan " + std::to_string(s + 1),
                                    "distance from the face",
                                    all,
                                    std::vector<double>(all.size(), 0.0));
      for (size_t i = 0; i < cloud.points.size(); ++i) {
        cloud.points[i] = scan.pose * cloud.points[i];
        feet.push_back(face.Closest(cloud.points[i]));
        cloud.values[i] = feet.back().distance - summary.rest_offset;
        distances.push_back(cloud.values[i]);
        counts.push_back(std::abs(cloud.values[i]) <= 3.0 * scan.deviation ? 1 : 0);
      }
      shape.clouds.push_back(std::move(cloud));
    }
    if (!distances.empty()) {
      shape.distances = {CoveredDistance(MakeScanFields(face, feet, distances, counts))};
    }
    AddShellView(shape, &report);
    AddHistory(model.scene(), model.summary(), &report);
    report.header["views"].back()["summary"] =
        MakeSummaryJson(model.problem().scene(), model.summary(), nullptr);
  }
  return report;
}

}  // namespace darboux
