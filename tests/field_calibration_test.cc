// Young's modulus and Poisson's ratio from a measured field of displacements. The field is that of
// other finite elements (data/calibration/strip_hole_deck.py), so that nothing that Darboux does
// wrong could cancel.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "geometry/shell_face.h"
#include "solver/calibration.h"
#include "solver/calibration_reader.h"
#include "solver/scene_reader.h"
#include "tests/calibration_util.h"
#include "tests/solve_util.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;

constexpr double kModulus = 210000.0, kPoisson = 0.3;  // of the other elements
constexpr double kNoise = 0.0005;                      // of strip_hole_noisy.csv, mm
const std::string kFolder = DARBOUX_DATA_DIR "/calibration/";

CalibrationSpec Strip() {
  CalibrationSpec spec;
  std::string error;
  EXPECT_TRUE(ReadCalibration(kFolder + "strip_hole_calibration.yaml", &spec, &error)) << error;
  return spec;
}

CalibrationSpec::Field& FieldOf(CalibrationSpec* spec) { return spec->grasps[0].fields[0]; }

PointCloud ExactField() {
  PointCloud cloud;
  std::string error;
  EXPECT_TRUE(ReadPointCloud(kFolder + "strip_hole_exact.csv", &cloud, &error)) << error;
  return cloud;
}

// Of strip_hole_noisy.csv.
const CalibrationSummary& Usual() {
  static const CalibrationSummary summary = Calibrated(Strip());
  return summary;
}

double ModulusOf(const CalibrationSummary& summary) {
  return summary.Find(StateParameter::kYoungModulus)->value;
}
double RatioOf(const CalibrationSummary& summary) {
  return summary.Find(StateParameter::kPoissonRatio)->value;
}
bool Covers(const CalibrationSummary& summary, StateParameter parameter, double truth) {
  const auto& interval = summary.Find(parameter)->interval;
  return interval[0] <= truth && truth <= interval[1];
}
bool CoversTruth(const CalibrationSummary& summary) {
  return Covers(summary, StateParameter::kYoungModulus, kModulus) &&
         Covers(summary, StateParameter::kPoissonRatio, kPoisson);
}

class Noise {
 public:
  explicit Noise(unsigned seed) : generator_(seed) {}
  double Uniform() { return static_cast<double>(generator_() >> 11) * 0x1.0p-53; }
  double Normal() {
    return std::sqrt(-2.0 * std::log(1.0 - Uniform())) * std::cos(2.0 * M_PI * Uniform());
  }

 private:
  std::mt19937_64 generator_;
};

void AddNoise(unsigned seed, PointCloud* cloud) {
  Noise noise(seed);
  for (Eigen::Vector3d& u : cloud->displacements) {
    u.x() += kNoise * noise.Normal();
    u.y() += kNoise * noise.Normal();
  }
}

// As if the strip had been moved before it was measured again.
void Move(double angle, const Eigen::Vector3d& translation, PointCloud* cloud) {
  const Eigen::AngleAxisd rotation(angle, Eigen::Vector3d::UnitZ());
  for (size_t i = 0; i < cloud->points.size(); ++i) {
    const Eigen::Vector3d& x = cloud->points[i];
    Eigen::Vector3d& u = cloud->displacements[i];
    u = rotation * (x + u) + translation - x;
  }
}

TEST(FieldCalibrationTest, AForeignFieldTellsModulusAndPoissonsRatio) {
  const CalibrationSummary& summary = Usual();
  EXPECT_NEAR(ModulusOf(summary), kModulus, 0.01 * kModulus);
  EXPECT_NEAR(RatioOf(summary), kPoisson, 0.01);
  EXPECT_TRUE(CoversTruth(summary));
  for (const auto& estimate : summary.estimates) EXPECT_TRUE(estimate.identifiable);
  const CalibrationSummary::Field& field = summary.grasps[0].fields[0];
  EXPECT_EQ(field.points, 1600);
  EXPECT_EQ(field.beside, 0);
  EXPECT_NEAR(field.deviation, kNoise, 0.05 * kNoise);
  EXPECT_NEAR(field.rms, kNoise, 0.05 * kNoise);
  EXPECT_GT(field.independent, 0.5 * field.points);
  EXPECT_NEAR(field.rotation, 2e-4, 0.1e-4);  // The script's.
  // Displacements are those of loads / (modulus * thickness).
  for (const auto& sensitivity : summary.sensitivities) {
    if (sensitivity.of != "young_modulus") continue;
    EXPECT_NEAR(sensitivity.value, sensitivity.to == "loads" ? 1.0 : -1.0, 1e-6) << sensitivity.to;
  }
}

// Without noise what is left is the error of both meshes, 1e-5 mm of 0.023 mm.
TEST(FieldCalibrationTest, ExactDisplacementsOfOtherElementsLeaveNearlyNothing) {
  CalibrationSpec spec = Strip();
  FieldOf(&spec).cloud = ExactField();
  const CalibrationSummary summary = Calibrated(spec);
  EXPECT_NEAR(ModulusOf(summary), kModulus, 5e-4 * kModulus);
  EXPECT_NEAR(RatioOf(summary), kPoisson, 5e-4);
  EXPECT_LT(summary.grasps[0].fields[0].rms, 2e-5);
  EXPECT_TRUE(CoversTruth(summary));  // Though neighbours share their errors.
}

TEST(FieldCalibrationTest, IntervalsCoverTheTruthAsOftenAsTheySay) {
  const PointCloud exact = ExactField();
  CalibrationSpec spec = Strip();
  spec.parameter(StateParameter::kYoungModulus).start = 200000;
  spec.parameter(StateParameter::kPoissonRatio).start = 0.28;
  spec.max_points = 800;
  constexpr int kDraws = 8;
  int modulus = 0, ratio = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    FieldOf(&spec).cloud = exact;
    AddNoise(100 + draw, &FieldOf(&spec).cloud);
    const CalibrationSummary summary = Calibrated(spec);
    modulus += Covers(summary, StateParameter::kYoungModulus, kModulus);
    ratio += Covers(summary, StateParameter::kPoissonRatio, kPoisson);
    // Not by being wide: noise / (root mean square displacement * root of the number of values).
    EXPECT_LT(summary.Find(StateParameter::kYoungModulus)->deviation, 0.003);
  }
  EXPECT_GE(modulus, kDraws - 2);
  EXPECT_GE(ratio, kDraws - 2);
}

// Correlation of images has errors that are smooth over many points, which must not count as so
// many independent ones.
TEST(FieldCalibrationTest, ErrorsThatNeighboursShareWidenTheIntervals) {
  CalibrationSpec spec = Strip();
  const double alone = Usual().Find(StateParameter::kPoissonRatio)->deviation;
  PointCloud& cloud = FieldOf(&spec).cloud;
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3d& x = cloud.points[i];
    cloud.displacements[i].x() += kNoise * std::sin(x.x() / 6.0 + x.y() / 9.0);
    cloud.displacements[i].y() += kNoise * std::cos(x.x() / 8.0 - x.y() / 5.0);
  }
  const CalibrationSummary summary = Calibrated(spec);
  EXPECT_LT(summary.grasps[0].fields[0].independent, 200);
  EXPECT_GT(summary.Find(StateParameter::kPoissonRatio)->deviation, 2.5 * alone);
  EXPECT_TRUE(CoversTruth(summary));
}

TEST(FieldCalibrationTest, ARigidMotionOfAnySizeChangesNothing) {
  CalibrationSpec spec = Strip();
  const CalibrationSummary& before = Usual();
  Move(0.2, Eigen::Vector3d(35.0, -12.0, 0.0), &FieldOf(&spec).cloud);
  const CalibrationSummary after = Calibrated(spec);
  EXPECT_NEAR(ModulusOf(after), ModulusOf(before), 1e-6 * kModulus);
  EXPECT_NEAR(RatioOf(after), RatioOf(before), 1e-6);
  EXPECT_NEAR(after.Find(StateParameter::kPoissonRatio)->deviation,
              before.Find(StateParameter::kPoissonRatio)->deviation,
              1e-6);
  EXPECT_NEAR(after.grasps[0].fields[0].rotation, 0.2002, 1e-5);
}

TEST(FieldCalibrationTest, AStartFarOffAndAKnownNoiseDoNotMatter) {
  CalibrationSpec spec = Strip();
  const CalibrationSummary& before = Usual();
  FieldOf(&spec).noise = kNoise;
  for (const double start : {200.0, 2e8}) {
    spec.parameter(StateParameter::kYoungModulus).start = start;
    const CalibrationSummary after = Calibrated(spec);
    EXPECT_NEAR(ModulusOf(after), ModulusOf(before), 1e-4 * kModulus);
    EXPECT_NEAR(RatioOf(after), RatioOf(before), 1e-3);
  }
}

TEST(FieldCalibrationTest, PointsBesideTheSheetAreLeftOutAndCounted) {
  CalibrationSpec spec = Strip();
  const CalibrationSummary& before = Usual();
  PointCloud& cloud = FieldOf(&spec).cloud;
  for (const auto& [x, y] : {std::make_pair(-1.2, 5.0),
                             std::make_pair(81.0, 3.0),
                             std::make_pair(20.0, -0.2),
                             std::make_pair(61.0, 20.3),
                             std::make_pair(40.0, 10.0),
                             std::make_pair(43.5, 10.5),
                             std::make_pair(500.0, 10.0)}) {
    cloud.points.emplace_back(x, y, 0.0);
    cloud.displacements.emplace_back(0.05, 0.07, 0.0);
  }
  const CalibrationSummary after = Calibrated(spec);
  EXPECT_EQ(after.grasps[0].fields[0].beside, 7);
  EXPECT_EQ(after.grasps[0].fields[0].points, 1600);
  EXPECT_NEAR(ModulusOf(after), ModulusOf(before), 1e-9 * kModulus);
  EXPECT_NEAR(RatioOf(after), RatioOf(before), 1e-9);
}

TEST(FieldCalibrationTest, OutliersCountLittle) {
  CalibrationSpec spec = Strip();
  PointCloud& cloud = FieldOf(&spec).cloud;
  Noise noise(3);
  for (size_t i = 0; i < cloud.points.size(); i += 20) {
    cloud.displacements[i] += Eigen::Vector3d(0.1 * noise.Uniform(), -0.1 * noise.Uniform(), 0.0);
  }
  const CalibrationSummary summary = Calibrated(spec);
  EXPECT_NEAR(ModulusOf(summary), kModulus, 0.01 * kModulus);
  EXPECT_NEAR(RatioOf(summary), kPoisson, 0.02);
  EXPECT_NEAR(summary.grasps[0].fields[0].inliers, 0.95 * 0.989, 0.01);  // of a length
  EXPECT_NEAR(summary.grasps[0].fields[0].rms, kNoise, 0.1 * kNoise);
}

// Displacements tell the product of both.
TEST(FieldCalibrationTest, ModulusAndThicknessAreNotToldApart) {
  CalibrationSpec spec = Strip();
  spec.parameter(StateParameter::kThickness).asked = true;
  const CalibrationSummary summary = Calibrated(spec);
  for (const StateParameter p : {StateParameter::kYoungModulus, StateParameter::kThickness}) {
    EXPECT_FALSE(summary.Find(p)->identifiable);
    EXPECT_THAT(summary.Find(p)->verdict, HasSubstr("not identifiable"));
    EXPECT_THAT(summary.Find(p)->verdict, ::testing::Not(HasSubstr("finger")));
  }
}

// A shape error is of what is not a rigid motion.
TEST(FieldCalibrationTest, AShapeErrorIsRelativeToTheDeformation) {
  CalibrationSpec spec = Strip();
  Move(0.01, Eigen::Vector3d(0.0, 5.0, 0.0), &FieldOf(&spec).cloud);
  FieldOf(&spec).noise = kNoise;
  FieldOf(&spec).shape_error = 0.02;
  const CalibrationSummary summary = Calibrated(spec);
  const CalibrationSummary::Field& field = summary.grasps[0].fields[0];
  EXPECT_NEAR(field.deformation, 0.0228, 0.0005);
  EXPECT_NEAR(field.deviation, std::hypot(kNoise, 0.02 * field.deformation), 1e-6);
  // kRegions times what one knows, nearly.
  EXPECT_LT(field.independent, 4.0 * kRegions);
  EXPECT_GT(field.independent, kRegions);
}

// What a camera sees of a bent plate is its face, which also moves as the plate turns.
class FaceTest : public ::testing::TestWithParam<const char*> {};

TEST_P(FaceTest, PointsOfAFaceTurnWithIt) {
  const std::string text =
      "name: plate\n"
      "surface: {kind: plane, u: [0, 2], v: [0, 1], divisions: [10, 5]}\n"
      "shell: {thickness: 0.05, young_modulus: 2e5, poisson_ratio: 0.3}\n"
      "model: {theory: " +
      std::string(GetParam()) +
      "}\n"
      "supports: [{on: u_min, clamped: true}]\n"
      "loads: [{kind: pressure, value: 0.2}]\n";
  const Solution truth = SolveScene(SceneFromText(text));
  const ShellSurface& surface = truth.problem->surface();
  const double offset = 0.5 * 0.05;
  ShellFace rest(surface, offset), state(surface, offset), before(surface, offset);
  // The linear theory turns normals linearly.
  const bool is_linear = std::string(GetParam()) == "linear";
  const double part = is_linear ? 1e-6 : 1.0;
  state.SetDisplacements(part * truth.problem->displacements());
  before.SetDisplacements(-part * truth.problem->displacements());
  CalibrationSpec spec;
  spec.name = "plate";
  spec.compare_linear = false;
  spec.parameter(StateParameter::kYoungModulus).asked = true;
  spec.parameter(StateParameter::kYoungModulus).start = 3e5;
  spec.grasps.emplace_back();
  spec.grasps[0].scene = SceneFromText(text);
  CalibrationSpec::Field field;
  field.file = "plate.csv";
  field.free_motion = false;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const ElementPoint at = {e, 0.3, 0.2};
    const Eigen::Vector3d x = rest.Evaluate(at).position, after = state.Evaluate(at).position;
    field.cloud.points.push_back(x);
    field.cloud.displacements.push_back(
        is_linear ? Eigen::Vector3d((after - before.Evaluate(at).position) / (2.0 * part))
                  : Eigen::Vector3d(after - x));
  }
  spec.grasps[0].fields.push_back(field);
  const CalibrationSummary summary = Calibrated(spec);
  EXPECT_EQ(summary.grasps[0].fields[0].beside, 0);
  EXPECT_NEAR(ModulusOf(summary), 2e5, 1e-6 * 2e5);
  EXPECT_LT(summary.grasps[0].fields[0].rms, 1e-6 * summary.grasps[0].max_displacement);
}

INSTANTIATE_TEST_SUITE_P(Theories, FaceTest, ::testing::Values("linear", "nonlinear"));

class FilesTest : public FolderTest {
 protected:
  FilesTest() {
    for (const char* name : {"strip_hole.yaml", "strip_hole.obj"}) {
      std::filesystem::copy_file(kFolder + name, folder_ / name);
    }
  }
  bool Read(const std::string& field, CalibrationSpec* spec, std::string* error) const {
    return ParseCalibration(
        "name: strip\n"
        "parameters: {young_modulus: {}}\n"
        "grasps:\n"
        "  - scene: strip_hole.yaml\n"
        "    fields: [" +
            field + "]\n",
        "strip.yaml",
        folder_.string(),
        spec,
        error);
  }
};

TEST_F(FilesTest, AMeasurementIsReadAsItIsPublished) {
  Write("dic.csv",
        "x-coordinate [mm],y-coordinate [mm],x-displacement [mm],y-displacement [mm]\n"
        "10,5,0.01,0.002\n20,5,0.02,0.001\n");
  CalibrationSpec spec;
  std::string error;
  ASSERT_TRUE(Read("{file: dic.csv}", &spec, &error)) << error;
  const CalibrationSpec::Field& field = FieldOf(&spec);
  EXPECT_EQ(field.cloud.points.size(), 2u);
  EXPECT_EQ(field.components, (std::array<bool, 3>{true, true, false}));
  EXPECT_TRUE(field.free_motion);
  EXPECT_EQ(field.shape_error, 0.0);
  ASSERT_TRUE(Read(
      "{file: dic.csv, components: [x], shape_error: 0.01, rigid_motion: none}", &spec, &error))
      << error;
  EXPECT_EQ(FieldOf(&spec).components, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(FieldOf(&spec).shape_error, 0.01);
  EXPECT_FALSE(FieldOf(&spec).free_motion);
}

TEST_F(FilesTest, WhatThePlaneFieldDoesNotSayIsNotAskedOfIt) {
  Write("dic.csv", "x,y,ux,uy\n10,5,0.01,0.002\n");
  CalibrationSpec spec;
  std::string error;
  EXPECT_FALSE(Read("{file: dic.csv, components: [x, z]}", &spec, &error));
  EXPECT_THAT(error, HasSubstr("strip.yaml:5: "));
  EXPECT_THAT(error, HasSubstr("found z, of which the file says nothing; allowed"));
}

// The same strip in m, N, N/m^2.
TEST_F(FilesTest, UnitsDoNotMatter) {
  CalibrationSpec spec = Strip();
  const CalibrationSummary& millimetres = Usual();
  const Scene& scene = spec.grasps[0].scene;
  std::string mesh;
  char line[200];
  for (const Eigen::Vector3d& x : scene.surface.mesh->vertices) {
    std::snprintf(line, sizeof(line), "v %.17g %.17g 0\n", 1e-3 * x.x(), 1e-3 * x.y());
    mesh += line;
  }
  for (const auto& t : scene.surface.mesh->triangles) {
    std::snprintf(line, sizeof(line), "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
    mesh += line;
  }
  Write("metres.obj", mesh);
  Write(
      "metres.yaml",
      "name: strip\n"
      "surface: {kind: mesh, file: metres.obj, fit: interpolate}\n"
      "shell: {thickness: 0.00305, young_modulus: 210e9, poisson_ratio: 0.3}\n"
      "model: {theory: linear}\n"
      "loads:\n"
      "  - kind: edge\n"
      "    on: rim\n"
      "    force: [\"324101.845*((0.08 - x < min(y, 0.02005 - y)) - (x < min(y, 0.02005 - y)))\", "
      "0, 0]\n");
  std::string error;
  ASSERT_TRUE(ReadScene(Path("metres.yaml"), &spec.grasps[0].scene, &error)) << error;
  spec.parameter(StateParameter::kYoungModulus).start =
      1e6 * *spec.parameter(StateParameter::kYoungModulus).start;
  for (Eigen::Vector3d& x : FieldOf(&spec).cloud.points) x *= 1e-3;
  for (Eigen::Vector3d& u : FieldOf(&spec).cloud.displacements) u *= 1e-3;
  const CalibrationSummary metres = Calibrated(spec);
  EXPECT_NEAR(ModulusOf(metres), 1e6 * ModulusOf(millimetres), 1e-9 * 1e6 * kModulus);
  EXPECT_NEAR(RatioOf(metres), RatioOf(millimetres), 1e-9);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(metres.estimates[k].deviation, millimetres.estimates[k].deviation, 1e-9);
  }
  EXPECT_NEAR(metres.grasps[0].fields[0].rms,
              1e-3 * millimetres.grasps[0].fields[0].rms,
              1e-9 * 1e-3 * kNoise);
}

}  // namespace
}  // namespace darboux
