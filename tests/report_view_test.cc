#include "solver/report_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "solver/fields.h"
#include "tests/solve_util.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kBall[] = R"(name: ball
surface: {kind: icosphere, radius: 20, frequency: 4}
shell: {thickness: 1.5, young_modulus: 4, poisson_ratio: 0.3}
model: {theory: nonlinear}
steps: 3
supports:
  - {on: {near: [0, 0, 20], radius: 0}, fix: [x, y]}
  - {on: {near: [0, 0, -20], radius: 0}, fix: [x, y]}
fingers:
  - {name: top, shape: {kind: capsule, radius: 8, length: 10, axis: [0, 1, 0]}, position: [0, 0, 60], direction: [0, 0, -1], motion: {travel: 1.5}}
  - {name: bottom, shape: {kind: plane}, position: [0, 0, -60], direction: [0, 0, 1], motion: {travel: 1}}
probes: [{name: pole, at: {nearest: [0, 0, 20]}}]
)";

double Value(const ReportArrays& arrays, const Json& info, int i, int k) {
  const double offset = info["offset"][k], scale = info["scale"][k];
  if (info["blob"].is_null()) return offset;
  const std::string& bytes = arrays.blobs()[info["blob"].get<int>()];
  const size_t at = 2 * (static_cast<size_t>(i) * info["components"].get<size_t>() + k);
  return offset + scale * (static_cast<unsigned char>(bytes[at]) +
                           256 * static_cast<unsigned char>(bytes[at + 1]));
}

const Json& FieldOf(const Json& view, const std::string& name) {
  for (const Json& field : view["fields"]) {
    if (field["name"] == name) return field;
  }
  ADD_FAILURE() << "no field " << name;
  return view["fields"][0];
}

class ReportViewTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    solution_ = new Solution(SolveScene(SceneFromText(kBall)));
    const Json summary = MakeSummaryJson(solution_->problem->scene(), solution_->summary, nullptr);
    report_ = new Report(MakeSceneReport("tool", *solution_->problem, solution_->summary, summary));
  }
  static void TearDownTestSuite() {
    delete solution_;
    delete report_;
    solution_ = nullptr;
    report_ = nullptr;
  }
  static const Json& View() { return report_->header["views"][0]; }

  static Solution* solution_;
  static Report* report_;
};
Solution* ReportViewTest::solution_ = nullptr;
Report* ReportViewTest::report_ = nullptr;

TEST_F(ReportViewTest, FieldsAreThoseOfEvaluateFieldsInEveryStep) {
  const OutputMesh mesh = MakeOutputMesh(solution_->problem->surface());
  ASSERT_EQ(View()["points"], mesh.points.size());
  ASSERT_EQ(View()["steps"].size(), 4u);  // at rest, and three
  for (size_t step = 0; step < 4; ++step) {
    const Eigen::Matrix3Xd displacements =
        step == 0 ? Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(
                        3, solution_->problem->surface().mesh().num_vertices))
                  : solution_->summary.steps[step - 1].displacements;
    for (size_t i = 0; i < mesh.points.size(); i += 7) {
      const ShellFields fields =
          EvaluateFields(*solution_->problem,
                         displacements,
                         MakeFieldSite(solution_->problem->surface(), mesh.points[i]));
      const auto expect = [&](const char* name, int k, double value) {
        const Json& info = FieldOf(View(), name)["steps"][step];
        const double tolerance = 0.5000001 * info["scale"][k].get<double>() + 1e-15;
        EXPECT_NEAR(Value(report_->arrays, info, static_cast<int>(i), k), value, tolerance)
            << name << " " << k << " step " << step;
      };
      for (int k = 0; k < 3; ++k) {
        expect("displacement", k, fields.displacement[k]);
        expect("membrane_strain", k, fields.membrane_strain[k]);
        expect("bending_strain", k, fields.bending_strain[k]);
      }
      expect("von_mises", 0, fields.von_mises_top);
      expect("von_mises", 1, fields.von_mises_bottom);
      expect("energy_density", 0, fields.membrane_energy_density);
      expect("energy_density", 1, fields.bending_energy_density);
    }
  }
}

TEST_F(ReportViewTest, FingersAreWhereTheSolverHasThem) {
  const Json& fingers = View()["fingers"];
  ASSERT_EQ(fingers.size(), 2u);
  EXPECT_EQ(fingers[0]["shape"], "capsule");
  EXPECT_EQ(fingers[1]["shape"], "plane");
  // First touch: the face at 20 + 0.75, the capsule's axis 8 above it. Of the middle surface the
  // contact points are a little below their own sphere.
  EXPECT_NEAR(fingers[0]["position"][2].get<double>(), 28.75, 0.1);
  EXPECT_NEAR(fingers[1]["position"][2].get<double>(), -20.75, 0.1);
  ASSERT_EQ(fingers[0]["travel"].size(), 4u);
  for (int step = 0; step < 4; ++step) {
    EXPECT_NEAR(fingers[0]["travel"][step].get<double>(), 0.5 * step, 1e-12);
  }
  // The capsule's own z axis lies along y.
  EXPECT_NEAR(std::abs(fingers[0]["rotation"][5].get<double>()), 1.0, 1e-12);
}

TEST_F(ReportViewTest, ProbesMoveAsTheSummarySays) {
  const Json& probe = View()["probes"][0];
  ASSERT_EQ(probe["displacement"].size(), 4u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(probe["displacement"][0][k], 0.0);
    EXPECT_NEAR(probe["displacement"][3][k].get<double>(),
                solution_->summary.probes[0].displacement[k],
                1e-14);
  }
}

TEST_F(ReportViewTest, HistoryHasAllStepsAndIterations) {
  const Json& history = View()["history"];
  ASSERT_EQ(history.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const LoadStep& step = solution_->summary.steps[i];
    EXPECT_EQ(history[i]["step"], i + 1);
    EXPECT_EQ(history[i]["energy"], step.energy);
    EXPECT_EQ(history[i]["fingers"]["top"]["normal_force"], step.fingers[0].normal_force);
    EXPECT_EQ(history[i]["fingers"]["top"]["travel"], step.fingers[0].travel);
  }
  const Json& iterations = View()["iterations"];
  const size_t count = solution_->summary.iteration_history.size();
  ASSERT_GT(count, 0u);
  for (const char* column :
       {"method", "step", "factor", "iteration", "energy", "relative_gradient", "seconds"}) {
    EXPECT_EQ(iterations[column].size(), count) << column;
  }
}

TEST_F(ReportViewTest, TrianglesAreThoseOfTheOutputMesh) {
  const OutputMesh mesh = MakeOutputMesh(solution_->problem->surface());
  const std::string& bytes = report_->arrays.blobs()[View()["indices"]["blob"].get<int>()];
  ASSERT_EQ(bytes.size(), 12 * mesh.triangles.size());
  EXPECT_EQ(View()["triangles"], mesh.triangles.size());
  EXPECT_FALSE(View().contains("elements"));  // all cut in four
}

TEST_F(ReportViewTest, ManyStepsAreThinnedAndSaidToBe) {
  ReportShape shape;
  shape.title = "many";
  shape.problem = solution_->problem.get();
  const size_t bytes_per_state = 2 * 14 * View()["points"].get<size_t>();
  const size_t count = kViewBytes / bytes_per_state + 100;
  const std::vector<ReportState> states = StatesOf(solution_->summary);
  for (size_t i = 0; i < count; ++i) {
    shape.states.push_back(states.back());
    shape.states.back().factor = static_cast<double>(i + 1);
  }
  Report report = MakeReport("tool", "many");
  AddShellView(shape, &report);
  const Json& view = report.header["views"][0];
  EXPECT_EQ(view["states"], count);
  EXPECT_LT(view["drawn"].get<size_t>(), count);
  EXPECT_EQ(view["steps"].size(), view["drawn"].get<size_t>() + 1);
  EXPECT_EQ(view["steps"].back()["number"], count);
  EXPECT_EQ(view["steps"].back()["factor"], static_cast<double>(count));
  EXPECT_LE(report.arrays.num_bytes(), kViewBytes + bytes_per_state + (1u << 20));
  // Evenly: no number twice, no gap of more than two.
  for (size_t i = 1; i < view["steps"].size(); ++i) {
    const int gap =
        view["steps"][i]["number"].get<int>() - view["steps"][i - 1]["number"].get<int>();
    EXPECT_GE(gap, 1);
    EXPECT_LE(gap, 2);
  }
}

TEST(MakeCloudTest, LargeCloudsAreThinnedAndSaidToBe) {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> values;
  for (size_t i = 0; i < kCloudPoints + 500; ++i) {
    points.emplace_back(static_cast<double>(i), 0.0, 0.0);
    values.push_back(static_cast<double>(i));
  }
  const ReportCloud cloud = MakeCloud("scan", "distance", points, values);
  ASSERT_EQ(cloud.points.size(), kCloudPoints);
  EXPECT_EQ(cloud.title, "scan, 30000 of 30500 points");
  std::set<double> seen;
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_EQ(cloud.points[i].x(), cloud.values[i]);
    EXPECT_TRUE(seen.insert(cloud.values[i]).second);
  }
  EXPECT_EQ(MakeCloud("scan", "distance", {points[0]}, {values[0]}).title, "scan");
}

}  // namespace
}  // namespace darboux
