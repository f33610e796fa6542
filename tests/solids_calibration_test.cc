#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "solver/calibration.h"
#include "tests/solids_util.h"
#include "tests/solve_util.h"

// Calibration from grasps of solid elements (data/solids), which share no error with it.

namespace darboux {
namespace {

constexpr double kTruth = 14.2;

std::string Ball(double travel, int frequency, const std::string& more = "") {
  const std::string t = std::to_string(travel);
  return "name: ball\n"
         "surface: {kind: icosphere, radius: 31.25, frequency: " +
         std::to_string(frequency) +
         "}\n"
         "shell: {thickness: 2.5, young_modulus: 8, poisson_ratio: 0.49}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: {kind: sphere, radius: 10}, position: [0, 0, 50], "
         "direction: [0, 0, -1], motion: {travel: " +
         t +
         "}}\n"
         "  - {name: bottom, shape: {kind: sphere, radius: 10}, position: [0, 0, -50], "
         "direction: [0, 0, 1], motion: {travel: " +
         t + "}}\n" + more;
}

CalibrationSpec::Grasp Grasp(double travel, int frequency, bool gas, std::uint64_t seed) {
  CalibrationSpec::Grasp grasp;
  const std::string name = gas ? "ball_r10_gas" : "ball_r10";
  grasp.scene_file = name + ".yaml";
  grasp.scene = SceneFromText(
      Ball(travel,
           frequency,
           gas ? "loads: [{kind: gas, gauge_pressure: 0.03, ambient_pressure: 0.101325}]\n" : ""));
  const double force = SolidForce(name + ".json", travel);
  grasp.forces.push_back({0, force, 0.01 * force, {}});
  const ScanSurface surface =
      SolidBall(name + "_" + std::to_string(static_cast<int>(travel)) + "mm.csv");
  ScanOptions options;
  options.seed = seed;
  options.num_points = 3000;
  options.viewpoints = ViewpointsAround(surface, 6, 5.0);
  options.noise = 0.127;
  options.outliers = 0.02;
  options.max_angle_deg = 20.0;
  std::vector<Occluder> fingers;
  Scan scan;
  std::string error;
  EXPECT_TRUE(SimulateScan(surface, fingers, options, &scan, &error)) << error;
  CalibrationSpec::Scan added;
  added.file = "scan";
  added.cloud = scan.cloud;
  grasp.scans.push_back(added);
  return grasp;
}

CalibrationSummary Calibrated(const CalibrationSpec& spec) {
  CalibrationSummary summary;
  CalibrationOptions options;
  options.solver.num_threads = 1;
  if (getenv("VERBOSE")) {
    options.on_progress = [](const std::string& line) {
      puts(line.c_str());
      fflush(stdout);
    };
  }
  std::string error;
  EXPECT_TRUE(Calibrate(spec, options, &summary, nullptr, &error)) << error;
  return summary;
}

TEST(SolidsCalibrationTest, Try) {
  CalibrationSpec spec;
  spec.name = "try";
  spec.parameter(StateParameter::kYoungModulus).asked = true;
  spec.noise = 0.127;
  const int frequency = getenv("FREQ") ? atoi(getenv("FREQ")) : 8;
  const bool gas = getenv("GAS") != nullptr;
  if (gas) spec.parameter(StateParameter::kGasPressure).asked = true;
  if (getenv("SHAPE")) spec.shape_error = atof(getenv("SHAPE"));
  for (const double travel : {2.0, 4.0, 6.0}) {
    if (getenv("JOINT")) break;
    spec.grasps = {Grasp(travel, frequency, gas, 1)};
    if (getenv("FREE")) spec.grasps[0].travel_error = atof(getenv("FREE"));
    const CalibrationSummary summary = Calibrated(spec);
    printf("%s\n", summary.FullReport().c_str());
  }
  spec.grasps.clear();
  for (const double travel : {2.0, 4.0, 6.0})
    spec.grasps.push_back(Grasp(travel, frequency, gas, 1));
  if (getenv("REST")) spec.rest_error = atof(getenv("REST"));
  for (auto& g : spec.grasps) {
    if (getenv("NOSCAN")) g.scans.clear();
    if (getenv("FREE")) g.travel_error = atof(getenv("FREE"));
  }
  const CalibrationSummary summary = Calibrated(spec);
  printf("%s\n", summary.FullReport().c_str());
  printf("rest %g bias %g\n", summary.rest_offset, summary.model_bias);
}

}  // namespace
}  // namespace darboux
