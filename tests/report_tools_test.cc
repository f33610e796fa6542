// --report of every tool: one more file, or one clear error before anything is done.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "tests/deform_util.h"
#include "tools/html_report.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kBall[] = R"(name: ball
surface: {kind: icosphere, radius: 20, frequency: 4}
shell: {thickness: 1.5, young_modulus: 4, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports:
  - {on: {near: [0, 0, 20], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -20], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: sphere, radius: 12}, position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 1}}
  - {name: bottom, shape: {kind: sphere, radius: 12}, position: [0, 0, -60], direction: [0, 0, 1], motion: {travel: 1}}
)";
constexpr char kPlate[] = R"(name: plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [8, 8]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
)";
constexpr char kCalibration[] = R"(name: ball
parameters: {young_modulus: {}}
grasps:
  - scene: ball.yaml
    scans: [out/scan.csv]
    forces: [{finger: top, value: 0.6, error: 0.02}]
)";

class ReportToolsTest : public DeformTest {
 protected:
  void SetUp() override {
    Write("ball.yaml", kBall);
    Write("plate.yaml", kPlate);
    Write("ball_calibration.yaml", kCalibration);
  }
  // The files of the tool are there, with a report that is a page; status 0 or 1: the answer is not
  // what is tested.
  void ExpectReport(const std::string& tool,
                    const std::vector<std::string>& arguments,
                    const std::string& document) {
    tool_ = tool;
    const int status = Run(arguments);
    if (!HasReportPage()) {
      EXPECT_EQ(status, 2);
      EXPECT_THAT(Stderr(), HasSubstr("--report: found a build without the report's page"));
      return;
    }
    EXPECT_LE(status, 1) << Stderr();
    const std::set<std::string> names = FilesIn(Out());
    EXPECT_EQ(names.count("report.html"), 1u) << tool << ": " << Stderr();
    EXPECT_EQ(names.count(document), 1u) << tool << ": " << Stderr();
    const std::string page = ReadFile(Out() / "report.html");
    EXPECT_THAT(page.substr(0, 40), StartsWith("<!DOCTYPE html>"));
    EXPECT_EQ(page.substr(page.size() - 8), "</html>\n");
  }
};

TEST_F(ReportToolsTest, EveryToolWritesOne) {
  ExpectReport(DARBOUX_DEFORM, {"plate.yaml", OutFlag(), "--report", "--quiet"}, "summary.json");
  if (HasReportPage()) {
    // Without being asked for, the report of an earlier run does not stay beside other numbers.
    EXPECT_EQ(Run({"plate.yaml", OutFlag(), "--quiet"}), 0);
    EXPECT_EQ(FilesIn(Out()).count("report.html"), 0u);
  }
  ExpectReport(DARBOUX_ACCURACY,
               {"plate.yaml", OutFlag(), "--report", "--quiet", "--levels=3", "--sweep=resolution"},
               "accuracy.json");
  ExpectReport(DARBOUX_SCAN,
               {"ball.yaml", OutFlag(), "--report", "--quiet", "--noise=0.01", "--points=2000"},
               "truth.json");
  if (!HasReportPage()) return;
  ExpectReport(
      DARBOUX_FIT,
      {"ball.yaml", OutFlag(), "--scan=out/scan.csv", "--mode=register", "--report", "--quiet"},
      "fit.json");
  ExpectReport(DARBOUX_CALIBRATE,
               {"ball_calibration.yaml", OutFlag(), "--report", "--quiet"},
               "calibration.json");
  // A surface that is no scene.
  ExpectReport(DARBOUX_SCAN,
               {"out/grasp_1/deformed.ply",
                OutFlag(),
                "--report",
                "--quiet",
                "--noise=0.01",
                "--thickness=1.5",
                "--points=500"},
               "truth.json");
}

TEST_F(ReportToolsTest, NothingIsWrittenWhereTheReportCannotBe) {
  if (!HasReportPage()) GTEST_SKIP() << NoReportPage();
  std::filesystem::create_directories(Out() / "report.html");
  EXPECT_EQ(Run({"plate.yaml", OutFlag(), "--report", "--quiet"}), 1);
  EXPECT_THAT(Stderr(), HasSubstr("report.html: is a folder, cannot be replaced"));
  EXPECT_EQ(FilesIn(Out()), std::set<std::string>{"report.html"});
}

TEST_F(ReportToolsTest, ABuildWithoutThePageSaysSoBeforeItSolves) {
  tool_ = DARBOUX_DEFORM_WITHOUT_PAGE;
  EXPECT_EQ(Run({"plate.yaml", OutFlag(), "--report"}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("--report: found a build without the report's page; allowed "));
  EXPECT_THAT(Stderr(), ::testing::Not(HasSubstr("step 1/1")));
  EXPECT_FALSE(std::filesystem::exists(Out()));
  EXPECT_EQ(Run({"plate.yaml", OutFlag(), "--quiet"}), 0) << Stderr();
}

}  // namespace
}  // namespace darboux
