#include <cmath>
#include <sstream>

#include "solver/calibration.h"
#include "solver/format.h"

namespace darboux {

const CalibrationSummary::Estimate* CalibrationSummary::Find(StateParameter parameter) const {
  for (const Estimate& estimate : estimates) {
    if (estimate.parameter == parameter) return &estimate;
  }
  return nullptr;
}

std::string CalibrationSummary::FullReport() const {
  std::ostringstream out;
  out << message << ": " << iterations << " iterations, " << work.solutions << " solutions in "
      << Format("%.2f s", work.solve_s) << ", derivatives " << Format("%.2f s", work.derivative_s)
      << ", in all " << Format("%.2f s", seconds) << "\n";
  for (const Estimate& estimate : estimates) {
    out << "  " << ToString(estimate.parameter) << " " << Format("%.6g", estimate.value);
    if (std::isfinite(estimate.deviation)) {
      out << "  [" << Number(estimate.interval[0]) << ", " << Number(estimate.interval[1])
          << "] 95 %";
    }
    if (estimate.bootstrap) {
      out << "  bootstrap [" << Number((*estimate.bootstrap)[0]) << ", "
          << Number((*estimate.bootstrap)[1]) << "]";
    }
    out << "  " << estimate.verdict << "\n";
  }
  if (correlation.rows() > 1) {
    for (Eigen::Index i = 0; i < correlation.rows(); ++i) {
      for (Eigen::Index j = 0; j < i; ++j) {
        out << "  correlation of " << ToString(estimates[i].parameter) << " and "
            << ToString(estimates[j].parameter) << ": " << Format("%.3f", correlation(i, j))
            << "\n";
      }
    }
  }
  for (const Sensitivity& sensitivity : sensitivities) {
    out << "  1 % more of " << sensitivity.to << ": " << sensitivity.of << " "
        << Format("%+.3f", sensitivity.relative ? sensitivity.value : 0.01 * sensitivity.value)
        << (sensitivity.relative ? " %" : "") << "\n";
  }
  if (linear_young_modulus) {
    out << "  in the linear theory young_modulus would be " << Format("%.6g", *linear_young_modulus)
        << "\n";
  }
  for (const Grasp& grasp : grasps) {
    out << "  " << grasp.scene << ": " << darboux::ToString(grasp.theory) << " theory";
    if (grasp.travel_change != 0.0) {
      out << ", travel " << Format("%+.4g", grasp.travel_change) << " +- "
          << Number(grasp.travel_deviation);
    }
    out << "\n";
    for (const Force& force : grasp.forces) {
      out << "    force of " << force.finger << ": read " << Number(force.reading) << " +- "
          << Number(force.error) << ", computed " << Number(force.model) << "\n";
    }
    for (const Scan& scan : grasp.scans) {
      out << "    scan " << scan.file << ": " << scan.points << " points, "
          << Format("%.1f %%", 100.0 * scan.inliers) << " inliers, distance mean "
          << Number(scan.distances.mean_abs) << ", rms " << Number(scan.distances.rms)
          << ", largest " << Number(scan.distances.max) << "\n";
    }
    for (const Field& field : grasp.fields) {
      out << "    field " << field.file << ": " << field.points << " points, " << field.beside
          << " beside the surface, " << Format("%.1f %%", 100.0 * field.inliers) << " inliers, rms "
          << Number(field.rms) << " of at most " << Number(field.deformation) << ", as good as "
          << Format("%.0f", field.independent) << " independent points\n";
    }
  }
  for (const std::string& note : notes) out << "  " << note << "\n";
  return out.str();
}

}  // namespace darboux
