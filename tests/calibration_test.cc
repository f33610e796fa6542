#include "solver/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "geometry/shell_face.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

// A ball of 486 dof between two spheres.
std::string Ball(double travel, double modulus, const std::string& more = "") {
  const std::string t = std::to_string(travel);
  return "name: ball\n"
         "surface: {kind: icosphere, radius: 31.25, frequency: 4}\n"
         "shell: {thickness: 2.5, young_modulus: " +
         std::to_string(modulus) +
         ", poisson_ratio: 0.45}\n"
         "supports:\n"
         "  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
         "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
         "fingers:\n"
         "  - {name: top, shape: {kind: sphere, radius: 8}, position: [0, 0, 45], "
         "direction: [0, 0, -1], motion: {travel: " +
         t +
         "}}\n"
         "  - {name: bottom, shape: {kind: sphere, radius: 8}, position: [0, 0, -45], "
         "direction: [0, 0, 1], motion: {travel: " +
         t + "}}\n" + more;
}

std::string Gas(double gauge) {
  return "loads:\n  - {kind: gas, gauge_pressure: " + std::to_string(gauge) +
         ", ambient_pressure: 0.101325}\n";
}

class Noise {
 public:
  explicit Noise(unsigned seed) : generator_(seed) {}
  double Uniform() { return (generator_() >> 11) * 0x1.0p-53; }
  double Normal() {
    return std::sqrt(-2.0 * std::log(1.0 - Uniform())) * std::cos(2.0 * M_PI * Uniform());
  }

 private:
  std::mt19937_64 generator_;
};

// Points on the outer face of a solved scene, in another frame.
PointCloud ScanOf(const ShellProblem& problem,
                  int points,
                  double noise,
                  const RigidPose& to_shell) {
  ShellFace face(problem.surface(), 0.5 * problem.material().thickness);
  face.SetDisplacements(problem.displacements());
  const RigidPose to_scanner = to_shell.Inverse();
  Noise random(7);
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    double s = random.Uniform(), t = random.Uniform();
    if (s + t > 1.0) {
      s = 1.0 - s;
      t = 1.0 - t;
    }
    const int element = i % problem.surface().num_elements();
    const ShellFace::Foot foot = face.Evaluate({element, s, t});
    cloud.points.push_back(to_scanner * (foot.position + noise * random.Normal() * foot.normal));
  }
  return cloud;
}

RigidPose SmallMotion() {
  RigidPose pose;
  pose.rotation = Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, -2, 0.5).normalized());
  pose.translation = Eigen::Vector3d(0.3, -0.2, 0.4);
  return pose;
}

double ForceOn(const Solution& solution, int finger) {
  const auto& report = solution.summary.steps.back().fingers[finger];
  const auto& way = solution.problem->scene().fingers[finger].direction;
  return -report.force.dot(Eigen::Vector3d(way[0], way[1], way[2]));
}

// Measurements of a scene, and the same scene as somebody has it who does not know the modulus.
CalibrationSpec::Grasp Measure(const std::string& truth,
                               const std::string& guess,
                               int points,
                               double noise,
                               double force_error) {
  const Solution solution = SolveScene(SceneFromText(truth));
  CalibrationSpec::Grasp grasp;
  grasp.scene_file = "ball.yaml";
  grasp.scene = SceneFromText(guess);
  grasp.forces.push_back({0, ForceOn(solution, 0), force_error, {}});
  if (points > 0) {
    CalibrationSpec::Scan scan;
    scan.file = "ball.csv";
    scan.cloud = ScanOf(*solution.problem, points, noise, SmallMotion());
    grasp.scans.push_back(scan);
  }
  return grasp;
}

CalibrationSummary Calibrated(const CalibrationSpec& spec) {
  CalibrationSummary summary;
  CalibrationOptions options;
  options.solver.num_threads = 1;
  options.solver.gradient_tolerance = 1e-9;
  if (getenv("VERBOSE")) options.on_progress = [](const std::string& line) { puts(line.c_str()); };
  std::string error;
  EXPECT_TRUE(Calibrate(spec, options, &summary, nullptr, &error)) << error;
  return summary;
}

CalibrationSpec Spec() {
  CalibrationSpec spec;
  spec.name = "test";
  spec.parameter(StateParameter::kYoungModulus).asked = true;
  spec.compare_linear = false;
  return spec;
}

// As someone with one reading of a force and no scan has it.
CalibrationSpec::Grasp Reading(const std::string& truth, const std::string& guess, double error) {
  return Measure(truth, guess, 0, 0.0, error);
}

TEST(CalibrationTest, ExactDataGiveTheModulusBackExactly) {
  CalibrationSpec spec = Spec();
  spec.noise = 0.01;
  spec.grasps.push_back(Measure(Ball(3.0, 14.2), Ball(3.0, 1.0), 640, 0.0, 0.01));
  const CalibrationSummary summary = Calibrated(spec);
  ASSERT_TRUE(summary.IsConverged()) << summary.message;
  const auto* modulus = summary.Find(StateParameter::kYoungModulus);
  ASSERT_NE(modulus, nullptr);
  EXPECT_NEAR(modulus->value, 14.2, 1e-6 * 14.2);
  EXPECT_TRUE(modulus->identifiable) << modulus->verdict;
  // Every point is back where it was on the ball.
  const RigidPose pose = summary.grasps[0].scans[0].pose * SmallMotion().Inverse();
  EXPECT_LT(summary.grasps[0].scans[0].distances.max, 1e-6 * 62.5);
  EXPECT_LT((pose * Eigen::Vector3d(0, 0, 30) - Eigen::Vector3d(0, 0, 30)).norm(), 1e-6 * 62.5);
  // The shape of a ball between two fingers does not depend on its modulus: one solution is enough.
  EXPECT_EQ(summary.work.solutions, 1);
}

TEST(CalibrationTest, AnUnknownTravelIsReadOffTheScan) {
  CalibrationSpec spec = Spec();
  spec.noise = 0.01;
  spec.grasps.push_back(Measure(Ball(3.0, 14.2), Ball(2.5, 1.0), 640, 0.0, 0.01));
  spec.grasps[0].travel_error = std::numeric_limits<double>::infinity();
  const CalibrationSummary summary = Calibrated(spec);
  ASSERT_TRUE(summary.IsConverged()) << summary.message;
  EXPECT_NEAR(summary.grasps[0].travel_change, 0.5, 1e-5);
  EXPECT_NEAR(summary.Find(StateParameter::kYoungModulus)->value, 14.2, 1e-5 * 14.2);
}

TEST(CalibrationTest, DoesNotDependOnTheUnitsOfLengthAndForce) {
  CalibrationSpec spec = Spec();
  spec.noise = 0.05;
  spec.grasps.push_back(Measure(Ball(3.0, 14.2), Ball(3.0, 1.0), 200, 0.05, 0.02));
  spec.grasps[0].travel_error = 0.1;
  const CalibrationSummary millimetres = Calibrated(spec);
  // m, N, Pa.
  spec.noise *= 1e-3;
  CalibrationSpec::Grasp& grasp = spec.grasps[0];
  grasp.travel_error *= 1e-3;
  grasp.scene = SceneFromText(
      "name: ball\n"
      "surface: {kind: icosphere, radius: 31.25e-3, frequency: 4}\n"
      "shell: {thickness: 2.5e-3, young_modulus: 1e6, poisson_ratio: 0.45}\n"
      "supports:\n"
      "  - {on: {near: [0, 0, 31.25e-3], radius: 0}, fix: [x, y]}\n"
      "  - {on: {near: [0, 0, -31.25e-3], radius: 0}, fix: [x, y]}\n"
      "fingers:\n"
      "  - {name: top, shape: {kind: sphere, radius: 8e-3}, position: [0, 0, 45e-3], "
      "direction: [0, 0, -1], motion: {travel: 3e-3}}\n"
      "  - {name: bottom, shape: {kind: sphere, radius: 8e-3}, position: [0, 0, -45e-3], "
      "direction: [0, 0, 1], motion: {travel: 3e-3}}\n");
  for (Eigen::Vector3d& x : grasp.scans[0].cloud.points) x *= 1e-3;
  const CalibrationSummary metres = Calibrated(spec);
  ASSERT_TRUE(millimetres.IsConverged() && metres.IsConverged());
  const double value = millimetres.estimates[0].value;
  EXPECT_NEAR(metres.estimates[0].value * 1e-6, value, 1e-9 * value);
  EXPECT_NEAR(metres.estimates[0].deviation, millimetres.estimates[0].deviation, 1e-5);
}

TEST(CalibrationTest, AWrongThicknessShiftsTheModulusAsTheSensitivitySays) {
  CalibrationSpec spec = Spec();
  spec.grasps.push_back(Reading(Ball(3.0, 14.2), Ball(3.0, 10.0), 0.05));
  const CalibrationSummary right = Calibrated(spec);
  spec.grasps[0].scene.shell.thickness *= 1.1;
  const CalibrationSummary wrong = Calibrated(spec);
  const auto find = [](const CalibrationSummary& summary, const std::string& to) {
    for (const auto& s : summary.sensitivities) {
      if (s.to == to) return s.value;
    }
    return 0.0;
  };
  const double found = std::log(wrong.estimates[0].value / right.estimates[0].value);
  // To second order: the mean of both ends.
  const double predicted =
      0.5 * (find(right, "thickness") + find(wrong, "thickness")) * std::log(1.1);
  EXPECT_NEAR(found, predicted, 2e-3);
  EXPECT_LT(std::exp(found), 0.83);  // bending alone: 1.1^-3, stretching alone: 1.1^-1
  EXPECT_GT(std::exp(found), 0.76);
  EXPECT_NEAR(find(right, "forces"), 1.0, 1e-9);
}

TEST(CalibrationTest, ADriftOfTheForceSensorIsTakenOut) {
  CalibrationSpec spec = Spec();
  spec.model_error = 0.0;
  spec.force_drift = 10.0;
  const double drift = 0.7;
  for (int k = 0; k < 3; ++k) {
    const double travel = 1.0 + k;
    spec.grasps.push_back(Reading(Ball(travel, 14.2), Ball(travel, 9.0), 1e-3));
    spec.grasps.back().time = 60.0 * k;
    spec.grasps.back().forces[0].value += drift * k / 2.0;
  }
  const CalibrationSummary summary = Calibrated(spec);
  ASSERT_TRUE(summary.IsConverged()) << summary.message;
  EXPECT_NEAR(summary.estimates[0].value, 14.2, 1e-4 * 14.2);
  EXPECT_NEAR(summary.drift, drift, 1e-3);
  spec.force_drift = 0.0;
  EXPECT_GT(std::abs(Calibrated(spec).estimates[0].value - 14.2), 0.1);
}

TEST(CalibrationTest, TheBootstrapAgreesWithLaplace) {
  CalibrationSpec spec = Spec();
  spec.noise = 0.05;
  spec.bootstrap = 2000;
  spec.grasps.push_back(Measure(Ball(3.0, 14.2), Ball(3.0, 10.0), 200, 0.05, 0.3));
  spec.grasps[0].travel_error = 0.1;
  const CalibrationSummary summary = Calibrated(spec);
  ASSERT_TRUE(summary.IsConverged()) << summary.message;
  const auto& estimate = summary.estimates[0];
  ASSERT_TRUE(estimate.bootstrap);
  const double laplace = std::log(estimate.interval[1] / estimate.interval[0]);
  const double bootstrap = std::log((*estimate.bootstrap)[1] / (*estimate.bootstrap)[0]);
  EXPECT_NEAR(bootstrap, laplace, 0.2 * laplace);
}

CalibrationSpec ModulusAndPressure() {
  CalibrationSpec spec = Spec();
  spec.parameter(StateParameter::kGasPressure).asked = true;
  spec.noise = 0.05;
  return spec;
}

TEST(CalibrationTest, SeveralGraspsTellModulusAndPressureApart) {
  CalibrationSpec spec = ModulusAndPressure();
  for (const double travel : {1.0, 4.0}) {
    spec.grasps.push_back(
        Measure(Ball(travel, 14.2, Gas(0.06)), Ball(travel, 8.0, Gas(0.03)), 160, 0.05, 0.02));
  }
  const CalibrationSummary summary = Calibrated(spec);
  ASSERT_TRUE(summary.IsConverged()) << summary.message;
  const auto* modulus = summary.Find(StateParameter::kYoungModulus);
  const auto* pressure = summary.Find(StateParameter::kGasPressure);
  EXPECT_NEAR(modulus->value, 14.2, 0.02 * 14.2);
  EXPECT_NEAR(pressure->value, 0.06, 0.02 * 0.06);
  EXPECT_TRUE(modulus->identifiable) << modulus->verdict;
  EXPECT_TRUE(pressure->identifiable) << pressure->verdict;
  EXPECT_EQ(summary.correlation.rows(), 2);
}

TEST(CalibrationTest, OneReadingDoesNotTellModulusAndPressureApart) {
  CalibrationSpec spec = ModulusAndPressure();
  spec.grasps.push_back(Reading(Ball(3.0, 14.2, Gas(0.06)), Ball(3.0, 8.0, Gas(0.03)), 0.02));
  const CalibrationSummary summary = Calibrated(spec);
  for (const auto& estimate : summary.estimates) {
    EXPECT_FALSE(estimate.identifiable) << estimate.verdict;
    EXPECT_NE(estimate.verdict.find("a second grasp with a travel of"), std::string::npos)
        << estimate.verdict;
    EXPECT_NE(estimate.verdict.find("against less of"), std::string::npos) << estimate.verdict;
  }
  EXPECT_EQ(summary.correlation.size(), 0);
}

TEST(CalibrationTest, OneGraspWithGasIsNotTrustedForWhatOnlyItsShapeTells) {
  CalibrationSpec spec = ModulusAndPressure();
  spec.grasps.push_back(
      Measure(Ball(3.0, 14.2, Gas(0.06)), Ball(3.0, 12.0, Gas(0.05)), 160, 0.05, 0.02));
  for (const auto& estimate : Calibrated(spec).estimates) {
    EXPECT_FALSE(estimate.identifiable) << estimate.verdict;
    EXPECT_NE(estimate.verdict.find("a second grasp with a travel of"), std::string::npos)
        << estimate.verdict;
  }
}

}  // namespace
}  // namespace darboux
