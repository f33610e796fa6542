#include "solver/accuracy_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/icosphere.h"
#include "solver/accuracy_results.h"
#include "solver/format.h"
#include "solver/scene_reader.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Scene Parse(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, "test.yaml", &scene, &error)) << error;
  return scene;
}

// `more`: further sections; `model` and `surface`: further keys of theirs.
Scene Plate(const std::string& more = "",
            const std::string& model = "theory: linear",
            const std::string& surface = "divisions: [8, 4]") {
  return Parse("name: plate\nsurface: {kind: plane, u: [0, 2], v: [0, 1], " + surface +
               "}\nshell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0.3}\nmodel: {" +
               model + "}\n" + more);
}

constexpr char kExpectTip[] =
    "probes: [{name: tip, at: {uv: [2, 0.5]}}]\n"
    "expect:\n"
    "  - {quantity: probes.tip.displacement.z, value: 2.0, relative_tolerance: 0.1}\n";

// ---- Plan -----------------------------------------------------------------------------------

TEST(StudyAxesTest, AreNamedAndCheckedByName) {
  std::vector<StudyAxis> axes;
  std::string error;
  ASSERT_TRUE(ParseStudyAxes("solver,resolution,solver", &axes, &error));
  EXPECT_THAT(axes, ElementsAre(StudyAxis::kSolver, StudyAxis::kResolution));
  EXPECT_FALSE(ParseStudyAxes("resolution,gradin", &axes, &error));
  EXPECT_THAT(error, HasSubstr("found 'gradin'"));
  EXPECT_THAT(error, HasSubstr("did you mean 'grading'?"));
  EXPECT_FALSE(ParseStudyAxes("", &axes, &error));
}

struct EndsCase {
  const char* name;
  const char* surface;
  const char* more;
  std::array<int, 2> ends;
};
class FavouredEndsTest : public ::testing::TestWithParam<EndsCase> {};
TEST_P(FavouredEndsTest, AreWhereTheSceneIsSingular) {
  const Scene scene = Plate(GetParam().more, "theory: linear", GetParam().surface);
  EXPECT_EQ(FavouredEnds(scene), GetParam().ends);
}
INSTANTIATE_TEST_SUITE_P(
    Scenes,
    FavouredEndsTest,
    ::testing::Values(
        EndsCase{"nothing", "divisions: [8, 4]", "", {0, 0}},
        EndsCase{"graded", "divisions: [8, 4], grading: [0.5, -0.2]", "", {1, -1}},
        EndsCase{"corner",
                 "divisions: [8, 4]",
                 "loads: [{kind: point, at: {uv: [2, 0]}, force: [0, 0, 1]}]",
                 {1, -1}},
        EndsCase{"nearest",
                 "divisions: [8, 4]",
                 "loads: [{kind: point, at: {nearest: [0, 0.5, 1]}, force: [0, 0, 1]}]",
                 {-1, 0}},
        EndsCase{"two_points",
                 "divisions: [8, 4]",
                 "loads:\n"
                 "  - {kind: point, at: {uv: [0, 0]}, force: [0, 0, 1]}\n"
                 "  - {kind: point, at: {uv: [2, 0.1]}, force: [0, 0, 1]}",
                 {0, -1}},
        EndsCase{"clamped", "divisions: [8, 4]", "supports: [{on: u_min, clamped: true}]", {-1, 0}},
        EndsCase{"rim", "divisions: [8, 4]", "supports: [{on: rim, clamped: true}]", {0, 0}},
        EndsCase{"finger",
                 "divisions: [8, 4]",
                 "fingers: [{name: f, shape: {kind: sphere, radius: 0.1}, position: [1.9, 0.9, 1], "
                 "direction: [0, 0, -1], motion: {travel: 0.1}}]",
                 {1, 1}}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(StudyPlanTest, HasTheScenesOwnSettingsFirstAndEachAxisByItself) {
  const StudyPlan plan = MakeStudyPlan(Plate("supports: [{on: u_min, clamped: true}]"), {});
  ASSERT_GE(plan.runs.size(), 5u);
  for (int level = 0; level < 5; ++level) {
    EXPECT_EQ(plan.runs[level].family, 0);
    EXPECT_EQ(plan.runs[level].settings.refinement, std::ldexp(0.25, level));
  }
  // Two gradings, three quadratures, seed_ghosts, seed strains, the nonlinear theory, and at least
  // Ceres' minimizer.
  EXPECT_GE(plan.families.size(), 10u);
  EXPECT_EQ(plan.runs.size(), 5 * plan.families.size());
  EXPECT_THAT(plan.families,
              ::testing::IsSupersetOf({"grading -0.5/0",
                                       "grading -0.85/0",
                                       "1 point",
                                       "6 points",
                                       "12 points",
                                       "seed_ghosts",
                                       "seed",
                                       "nonlinear",
                                       "minimizer ceres"}));
  // Levels in order, so that whatever ends the study has the coarse ones of all.
  for (size_t i = 6; i < plan.runs.size(); ++i) {
    EXPECT_GE(plan.runs[i].level, plan.runs[i - 1].level);
  }
}

TEST(StudyPlanTest, VariesOnlyWhatIsAskedFor) {
  PlanOptions options;
  options.axes = {StudyAxis::kQuadrature};
  const StudyPlan plan = MakeStudyPlan(Plate(), options);
  EXPECT_THAT(plan.families, ElementsAre("the scene's own", "1 point", "6 points", "12 points"));
  ASSERT_EQ(plan.runs.size(), 4u);
  for (const PlannedRun& run : plan.runs) EXPECT_EQ(run.settings.refinement, 1.0);
}

TEST(StudyPlanTest, TheProductHasAllCombinationsOnce) {
  PlanOptions options;
  options.axes = {StudyAxis::kResolution, StudyAxis::kQuadrature, StudyAxis::kStrains};
  options.levels = 2;
  options.product = true;
  const StudyPlan plan = MakeStudyPlan(Plate(), options);
  EXPECT_EQ(plan.families.size(), 8u);
  ASSERT_EQ(plan.runs.size(), 16u);
  for (size_t i = 0; i < plan.runs.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(plan.runs[i].settings == plan.runs[j].settings) << i << " " << j;
    }
  }
}

TEST(StudyPlanTest, SaysWhatIsNotVaried) {
  PlanOptions options;
  options.axes = {StudyAxis::kGrading, StudyAxis::kBoundaryRule};
  const Scene ball = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 1, frequency: 4}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  const StudyPlan plan = MakeStudyPlan(ball, options);
  EXPECT_EQ(plan.families.size(), 1u);
  EXPECT_EQ(plan.notes.size(), 2u);
}

TEST(ApplySettingsTest, ScalesDivisionsAndKeepsTheirRatio) {
  const Scene scene = Plate();
  StudySettings settings;
  std::string reason;
  for (const double refinement : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    settings.refinement = refinement;
    Scene scaled = scene;
    ASSERT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
    EXPECT_EQ(scaled.surface.divisions[0], 8 * refinement);
    EXPECT_EQ(scaled.surface.divisions[1], 4 * refinement);
    EXPECT_EQ(DivisionsOf(scene, settings), scaled.surface.divisions);
  }
}

TEST(ApplySettingsTest, LeavesALevelOutRatherThanRepeatIt) {
  const Scene scene = Plate("", "theory: linear", "divisions: [2, 1]");
  StudySettings settings;
  std::string reason;
  settings.refinement = 0.5;
  Scene scaled = scene;
  EXPECT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
  settings.refinement = 0.25;
  scaled = scene;
  EXPECT_FALSE(ApplySettings(settings, &scaled, &reason));
  EXPECT_THAT(reason, HasSubstr("halved"));
}

TEST(ApplySettingsTest, PeriodicDirectionsKeepFourCells) {
  const Scene scene = Parse(
      "name: tube\nsurface: {kind: cylinder, radius: 1, u: [0, 1], v: [0, 2*pi], "
      "divisions: [8, 8], periodic: [false, true]}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  StudySettings settings;
  settings.refinement = 0.25;
  EXPECT_EQ(DivisionsOf(scene, settings), (std::array<int, 2>{2, 4}));
}

TEST(ApplySettingsTest, IcospheresAreMadeAnewAndStaySpheres) {
  const Scene scene = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 3, frequency: 4}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  StudySettings settings;
  std::string reason;
  for (const auto& [refinement, frequency] :
       std::map<double, int>{{0.25, 1}, {0.5, 2}, {1.0, 4}, {2.0, 8}}) {
    settings.refinement = refinement;
    Scene scaled = scene;
    ASSERT_TRUE(ApplySettings(settings, &scaled, &reason)) << reason;
    ASSERT_EQ(scaled.surface.mesh->vertices.size(), 10u * frequency * frequency + 2u);
    for (const Eigen::Vector3d& x : scaled.surface.mesh->vertices)
      EXPECT_NEAR(x.norm(), 3.0, 1e-12);
  }
}

TEST(ApplySettingsTest, OtherMeshesAreSubdividedAndNeverCoarsened) {
  Scene scene = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 3, frequency: 2, refine: 1}\n"
      "shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.3}\n");
  const size_t triangles = scene.surface.mesh->triangles.size();
  StudySettings settings;
  std::string reason;
  settings.refinement = 4.0;
  Scene finer = scene;
  ASSERT_TRUE(ApplySettings(settings, &finer, &reason)) << reason;
  EXPECT_EQ(finer.surface.mesh->triangles.size(), 16 * triangles);
  settings.refinement = 0.5;
  EXPECT_FALSE(ApplySettings(settings, &scene, &reason));
}

// ---- Reference ------------------------------------------------------------------------------

TEST(RoundingUncertaintyTest, IsHalfAUnitInTheLastDigitThatIsPrinted) {
  EXPECT_NEAR(RoundingUncertainty(4.067), 0.0005 / 4.067, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(-1.8248e-5), 0.00005 / 1.8248, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(13.891), 0.0005 / 13.891, 1e-9);
  EXPECT_NEAR(RoundingUncertainty(7.0), 0.5 / 7.0, 1e-12);
  EXPECT_LT(RoundingUncertainty(1.0 / 3.0), 1e-15);
  EXPECT_EQ(RoundingUncertainty(0.0), 0.0);
}

TEST(ExpectedQuantitiesTest, AreThoseThatMeasureAccuracy) {
  const Scene scene = Plate(
      "probes: [{name: p, at: {uv: [1, 0.5]}}]\n"
      "expect:\n"
      "  - {quantity: probes.p.displacement.z, value: 4.067, relative_tolerance: 0.1}\n"
      "  - {quantity: iterations, value: 3, absolute_tolerance: 2}\n"
      "  - {quantity: equilibrium.force_balance, value: 1e-9, absolute_tolerance: 1e-9}\n"
      "  - {quantity: fingers.top.penetration, value: 1e-9, absolute_tolerance: 1e-9}\n"
      "  - {quantity: probes.p.displacement.x, value: 0, absolute_tolerance: 1e-9}\n");
  std::vector<std::string> notes;
  const std::vector<StudyQuantity> quantities = ExpectedQuantities(scene, &notes);
  ASSERT_EQ(quantities.size(), 1u);
  EXPECT_EQ(quantities[0].path, "probes.p.displacement.z");
  EXPECT_NEAR(quantities[0].uncertainty, 1.23e-4, 1e-6);
  EXPECT_EQ(notes.size(), 4u);
}

class ExtrapolateTest : public ::testing::TestWithParam<double> {};
TEST_P(ExtrapolateTest, FindsLimitAndOrderOfAPowerForAnyRatioOfSizes) {
  const double order = GetParam();
  for (const std::vector<double>& h :
       {std::vector<double>{1.0, 0.5, 0.25, 0.125}, std::vector<double>{1.0, 0.6, 0.25, 0.2}}) {
    std::vector<double> values;
    for (const double size : h) values.push_back(-3.0 + 0.7 * std::pow(size, order));
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    ASSERT_TRUE(limit->order.has_value());
    EXPECT_NEAR(*limit->order, order, 1e-6);
    EXPECT_NEAR(limit->value, -3.0, 1e-9);
    // Where the power is exact the uncertainty is a third of the last distance.
    EXPECT_NEAR(limit->uncertainty, std::abs(values.back() + 3.0) / 3.0, 1e-6);
  }
}
INSTANTIATE_TEST_SUITE_P(Orders, ExtrapolateTest, ::testing::Values(0.6, 1.0, 2.0, 3.3, 4.0, 4.9));

TEST(ExtrapolateTest, TheUncertaintyCoversTheErrorOfMixedPowers) {
  std::vector<double> h, values;
  for (int k = 0; k < 5; ++k) {
    h.push_back(std::ldexp(1.0, -k));
    values.push_back(1.0 + 0.3 * std::pow(h.back(), 2.0) - 0.5 * std::pow(h.back(), 3.0));
    if (k < 2) continue;
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    EXPECT_LE(std::abs(limit->value - 1.0), limit->uncertainty) << k;
  }
}

TEST(ExtrapolateTest, PromisesNothingWhereValuesSwingStallOrLeap) {
  const std::vector<double> h{1.0, 0.5, 0.25};
  for (const std::vector<double>& values : {std::vector<double>{1.0, 2.0, 1.5},
                                            std::vector<double>{1.0, 2.0, 3.0},
                                            std::vector<double>{1.0, 1.5, 2.5},
                                            std::vector<double>{1.0, 2.0, 2.01}}) {
    const auto limit = Extrapolate(h, values);
    ASSERT_TRUE(limit.has_value());
    EXPECT_FALSE(limit->order.has_value());
    EXPECT_EQ(limit->value, values[2]);
    EXPECT_GE(limit->uncertainty, std::abs(values[2] - values[1]));
  }
  EXPECT_FALSE(Extrapolate({1.0, 0.5}, {1.0, 1.1}).has_value());
  EXPECT_FALSE(Extrapolate(h, {1.0, std::nan(""), 1.1}).has_value());
}

StudyQuantity Quantity(const std::string& path, const std::string& group) {
  StudyQuantity quantity;
  quantity.path = path;
  quantity.group = group;
  return quantity;
}

TEST(ExtrapolateFamiliesTest, TakesTheBestAndHeedsTheOthers) {
  const std::vector<StudyQuantity> quantities{Quantity("energy.total", "energy.total")};
  const auto family = [](const std::string& name, double limit, double order) {
    FamilyValues values;
    values.name = name;
    for (const double h : {1.0, 0.5, 0.25, 0.125}) {
      values.h.push_back(h);
      values.values.push_back({limit + std::pow(h, order)});
    }
    return values;
  };
  const auto agree =
      ExtrapolateFamilies(quantities, {family("slow", 5.0, 1.0), family("fast", 5.0, 4.0)});
  ASSERT_TRUE(agree.has_value());
  EXPECT_EQ(agree->family, "fast");
  EXPECT_NEAR(agree->quantities[0].reference, 5.0, 1e-9);
  EXPECT_LT(agree->uncertainty, 1e-4);
  // Another limit: the uncertainty says so.
  const auto differ =
      ExtrapolateFamilies(quantities, {family("other", 5.5, 3.0), family("fast", 5.0, 4.0)});
  ASSERT_TRUE(differ.has_value());
  EXPECT_NEAR(differ->uncertainty, 0.1, 1e-3);
}

TEST(ExtrapolateFamiliesTest, AHeldProbeIsMeasuredAgainstTheOthers) {
  const std::vector<StudyQuantity> quantities{
      Quantity("probes.a.displacement.z", "probes.a.displacement"),
      Quantity("probes.b.displacement.z", "probes.b.displacement"),
      Quantity("gas.absolute_pressure", "gas.absolute_pressure")};
  FamilyValues family;
  for (const double h : {1.0, 0.5, 0.25}) {
    family.h.push_back(h);
    family.values.push_back({2.0 + h * h, 1e-17 * h, 0.0});
  }
  const auto reference = ExtrapolateFamilies(quantities, {family});
  ASSERT_TRUE(reference.has_value());
  // The pressure, zero for all, is gone.
  ASSERT_EQ(reference->quantities.size(), 2u);
  EXPECT_NEAR(reference->quantities[1].scale, 2e-4, 1e-10);
  const auto error = ErrorOf(reference->quantities,
                             {{"probes.a.displacement.z", 2.5}, {"probes.b.displacement.z", 0.0}});
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->error, 0.25, 1e-6);
  EXPECT_FALSE(ErrorOf(reference->quantities, {{"probes.a.displacement.z", 2.5}}).has_value());
}

// ---- Study, with runs that are made up -------------------------------------------------------

TEST(ParetoFrontTest, KeepsWhatNothingBeats) {
  EXPECT_THAT(ParetoFront({3, 1, 2, 2, 5}, {1, 4, 2, 3, 2}), ElementsAre(1, 2, 0));
  EXPECT_THAT(ParetoFront({1, 1, 1}, {2, 2, 1}), ElementsAre(2));
  EXPECT_THAT(ParetoFront({}, {}), IsEmpty());
}

// A solver whose error is known: 1 / divisions^2, or ^4 with six points or more, in seconds that
// are 1e-6 of dof^1.5.
RunOutcome PretendToSolve(const Scene& scene, const SolverOptions&) {
  RunOutcome outcome;
  const std::array<int, 2>& divisions = scene.surface.divisions;
  if (scene.model.quadrature == 1) {
    outcome.status = RunOutcome::Status::kImpossible;
    outcome.reason = "free edges are loose";
    return outcome;
  }
  outcome.status = RunOutcome::Status::kConverged;
  outcome.theory = scene.model.theory == Theory::kAuto ? Theory::kLinear : scene.model.theory;
  outcome.elements = 2 * divisions[0] * divisions[1];
  outcome.dof = 3 * (divisions[0] + 3) * (divisions[1] + 3);
  outcome.quadrature_points = outcome.elements * scene.model.quadrature;
  outcome.iterations = 1;
  double error = std::pow(divisions[0], scene.model.quadrature >= 6 ? -4.0 : -2.0);
  if (outcome.theory == Theory::kNonlinear) error += 0.05;
  for (const ExpectSpec& expect : scene.expect) outcome.values[expect.quantity] = 2.0 * (1 + error);
  outcome.total_s = 1e-6 * std::pow(outcome.dof, 1.5) * scene.model.quadrature;
  outcome.setup_s = 0.2 * outcome.total_s;
  outcome.solve_s = 0.7 * outcome.total_s;
  outcome.cpu_s = outcome.total_s;
  return outcome;
}

StudyOptions Pretending(std::vector<StudyAxis> axes) {
  StudyOptions options;
  options.plan.axes = std::move(axes);
  options.runner = PretendToSolve;
  return options;
}

TEST(StudyTest, FindsTheCheapestSettingsAndTheFront) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution, StudyAxis::kQuadrature});
  options.targets = {0.1, 0.01, 0.001, 1e-7};
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error)) << error;
  EXPECT_TRUE(study.established);
  EXPECT_EQ(study.reference.kind, StudyReference::Kind::kExpect);
  ASSERT_EQ(study.cheapest.size(), 4u);
  // 2.0 is printed with one digit: known to 25 %, which is all that the errors are worth.
  EXPECT_NEAR(study.reference.uncertainty, 0.25, 1e-12);
  EXPECT_THAT(study.cheapest[0].text, HasSubstr("known to 25 % only"));
  for (const StudyRun& run : study.runs) {
    if (run.outcome.status == RunOutcome::Status::kConverged && run.divisions[0] > 2) {
      EXPECT_TRUE(run.error->IsBelowUncertainty());
    }
  }
}

TEST(StudyTest, ARunIsCheapestWhenNoneThatIsAccurateEnoughIsFaster) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution, StudyAxis::kQuadrature});
  options.richardson = true;
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error)) << error;
  ASSERT_EQ(study.reference.kind, StudyReference::Kind::kRichardson);
  EXPECT_NEAR(study.reference.quantities[0].reference, 2.0, 1e-9);
  EXPECT_LT(study.reference.uncertainty, 1e-5);
  for (const CheapestRun& entry : study.cheapest) {
    ASSERT_GE(entry.run, 0) << entry.text;
    const StudyRun& cheapest = study.runs[entry.run];
    EXPECT_LE(cheapest.CountedError(), entry.target);
    EXPECT_THAT(entry.text, HasSubstr(cheapest.label));
    for (const StudyRun& run : study.runs) {
      if (!run.error || run.CountedError() > entry.target) continue;
      EXPECT_LE(cheapest.outcome.total_s, run.outcome.total_s);
    }
  }
  // 0.1 % with three points takes 32 cells, with six 8: eighty times fewer.
  EXPECT_EQ(study.runs[study.cheapest[2].run].label,
            "divisions 8 x 4, grading 0, 6 points, koiter, linear");
  int on_front = 0;
  for (const StudyRun& run : study.runs) {
    on_front += run.on_front;
    for (const StudyRun& other : study.runs) {
      if (!run.on_front || !other.error) continue;
      EXPECT_FALSE(other.outcome.total_s < run.outcome.total_s &&
                   other.CountedError() < run.CountedError());
    }
  }
  EXPECT_GE(on_front, 3);
  // What cannot be is a row with its reason.
  int impossible = 0;
  for (const StudyRun& run : study.runs) {
    if (run.outcome.status != RunOutcome::Status::kImpossible) continue;
    ++impossible;
    EXPECT_EQ(run.outcome.reason, "free edges are loose");
    EXPECT_FALSE(run.error.has_value());
  }
  EXPECT_EQ(impossible, 5);
}

TEST(StudyTest, AnotherTheoryIsMarkedAndIsNotTheCheapest) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution, StudyAxis::kTheory});
  options.richardson = true;
  ASSERT_TRUE(RunStudy(Plate(kExpectTip, "theory: auto"), options, &study, &error)) << error;
  int marked = 0;
  for (const StudyRun& run : study.runs) {
    EXPECT_EQ(run.other_model, run.outcome.theory == Theory::kNonlinear);
    marked += run.other_model;
    if (run.other_model) {
      EXPECT_FALSE(run.on_front);
      EXPECT_GT(run.error->error, 0.04);  // That of the model.
    }
  }
  EXPECT_EQ(marked, 5);
  // The limit is that of the scene's own theory.
  EXPECT_NEAR(study.reference.quantities[0].reference, 2.0, 1e-6);
}

TEST(StudyTest, TellsWhereExpectAndExtrapolationDisagree) {
  const auto run = [](const std::string& value) {
    Study study;
    std::string error;
    const Scene scene = Plate(
        "probes: [{name: tip, at: {uv: [2, 0.5]}}]\nexpect:\n  - {quantity: "
        "probes.tip.displacement.z, relative_tolerance: 0.1, value: " +
        value + "}\n");
    EXPECT_TRUE(RunStudy(
        scene, Pretending({StudyAxis::kResolution, StudyAxis::kQuadrature}), &study, &error));
    return study.notes;
  };
  EXPECT_THAT(run("2.0000001"), IsEmpty());
  EXPECT_THAT(run("2.0101"), ElementsAre(HasSubstr("is 0.5 % from the limit")));
}

TEST(StudyTest, WithoutThreeLevelsOrAnExpectationThereIsNoReference) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution});
  options.plan.levels = 2;
  const Scene scene = Plate("probes: [{name: tip, at: {uv: [2, 0.5]}}]\n");
  ASSERT_TRUE(RunStudy(scene, options, &study, &error));
  EXPECT_FALSE(study.established);
  EXPECT_EQ(study.reference.kind, StudyReference::Kind::kNone);
  for (const CheapestRun& entry : study.cheapest) EXPECT_EQ(entry.run, -1);
}

TEST(StudyTest, LimitsLeaveRunsOutAndSaySo) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution});
  options.max_dof = 1000;
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error));
  ASSERT_EQ(study.runs.size(), 5u);
  EXPECT_EQ(study.runs[2].outcome.status, RunOutcome::Status::kConverged);
  EXPECT_EQ(study.runs[4].outcome.status, RunOutcome::Status::kSkipped);
  EXPECT_THAT(study.runs[4].outcome.reason, HasSubstr("more than 1000"));
  EXPECT_THAT(study.runs[4].label, HasSubstr("divisions 32 x 16"));
  // A level takes five times as long as the one before: 5 x 0.3 s do not fit into a second.
  options.max_dof = 1e9;
  options.solver.time_limit_s = 1.0;
  options.runner = [](const Scene& scene, const SolverOptions& solver) {
    RunOutcome outcome = PretendToSolve(scene, solver);
    EXPECT_GT(solver.time_limit_s, 0.0);
    EXPECT_LE(solver.time_limit_s, 1.0);
    outcome.total_s = 0.3;
    return outcome;
  };
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error));
  EXPECT_EQ(study.runs[0].outcome.status, RunOutcome::Status::kConverged);
  EXPECT_THAT(study.runs[1].outcome.reason, HasSubstr("time limit"));
}

TEST(StudyTest, AFamilyThatFailsTwiceIsLeftAlone) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution});
  options.runner = [](const Scene& scene, const SolverOptions& solver) {
    RunOutcome outcome = PretendToSolve(scene, solver);
    outcome.status = RunOutcome::Status::kNotConverged;
    outcome.reason = "200 iterations";
    return outcome;
  };
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error));
  EXPECT_FALSE(study.established);
  EXPECT_EQ(study.runs[1].outcome.reason, "200 iterations");
  EXPECT_EQ(study.runs[2].outcome.status, RunOutcome::Status::kSkipped);
}

TEST(StudyTest, TheLeastOfRepeatedTimesCounts) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kQuadrature});
  options.plan.axes = {StudyAxis::kStrains};
  options.repeats = 3;
  int calls = 0;
  options.runner = [&calls](const Scene& scene, const SolverOptions& solver) {
    RunOutcome outcome = PretendToSolve(scene, solver);
    outcome.total_s = 1.0 + std::abs(calls++ % 3 - 1);
    return outcome;
  };
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error));
  EXPECT_EQ(calls, 6);
  for (const StudyRun& run : study.runs) EXPECT_EQ(run.outcome.total_s, 1.0);
}

TEST(StudyTest, StoppedItKeepsWhatItHas) {
  Study study;
  std::string error;
  std::atomic<bool> stop(false);
  StudyOptions options = Pretending({StudyAxis::kResolution});
  options.solver.stop = &stop;
  int calls = 0;
  options.runner = [&](const Scene& scene, const SolverOptions& solver) {
    if (++calls == 2) stop = true;
    return PretendToSolve(scene, solver);
  };
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error));
  EXPECT_TRUE(study.stopped);
  EXPECT_EQ(calls, 2);
  ASSERT_EQ(study.runs.size(), 5u);
  EXPECT_TRUE(study.runs[1].error.has_value());
  EXPECT_EQ(study.runs[2].outcome.reason, "stopped before");
}

TEST(StudyTest, ASceneThatCannotBePosedIsBadInput) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution});
  options.runner = [](const Scene&, const SolverOptions&) {
    RunOutcome outcome;
    outcome.status = RunOutcome::Status::kImpossible;
    outcome.reason = "test.yaml:3: nothing holds it";
    return outcome;
  };
  EXPECT_FALSE(RunStudy(Plate(kExpectTip), options, &study, &error));
  EXPECT_EQ(error, "test.yaml:3: nothing holds it");
}

// ---- Runs of the solver ---------------------------------------------------------------------

constexpr char kStrip[] =
    "supports: [{on: u_min, clamped: true}]\n"
    "loads: [{kind: normal_traction, value: 1}]\n"
    "probes: [{name: tip, at: {uv: [2, 0.5]}}]\n";

TEST(RunTest, AProcessOfItsOwnComesToTheSame) {
  Scene scene = Plate(std::string(kStrip) +
                      "expect:\n  - {quantity: probes.tip.displacement.z, value: 1, "
                      "relative_tolerance: 1}\n");
  SolverOptions options;
  options.num_threads = 1;
  const RunOutcome here = RunHere(scene, options), child = RunInChild(scene, options);
  for (const RunOutcome* outcome : {&here, &child}) {
    ASSERT_EQ(outcome->status, RunOutcome::Status::kConverged) << outcome->reason;
    EXPECT_EQ(outcome->dof, 225);
    EXPECT_EQ(outcome->elements, 64);
    EXPECT_GT(outcome->total_s, 0.0);
    EXPECT_GE(outcome->total_s, outcome->setup_s + outcome->solve_s);
  }
  EXPECT_EQ(here.values, child.values);
  EXPECT_EQ(here.memory_mb, -1.0);
  EXPECT_GT(child.memory_mb, 1.0);
}

TEST(RunTest, WhatCannotBePosedSaysWhy) {
  Scene scene = Plate("loads: [{kind: normal_traction, value: 1}]\n");
  for (const RunOutcome& outcome :
       {RunHere(scene, SolverOptions()), RunInChild(scene, SolverOptions())}) {
    EXPECT_EQ(outcome.status, RunOutcome::Status::kImpossible);
    EXPECT_THAT(outcome.reason, Not(IsEmpty()));
  }
}

TEST(RunTest, OnePointPerTriangleOnACurvedFreeEdgeIsARowWithAReason) {
  const Scene scene = Parse(
      "name: panel\n"
      "surface: {kind: cylinder, radius: 1, u: [0, 2], v: [0, 1.5], divisions: [8, 8]}\n"
      "shell: {thickness: 0.01, young_modulus: 1.0e6, poisson_ratio: 0.3}\n"
      "model: {theory: linear}\nsupports: [{on: u_min, clamped: true}]\n"
      "loads: [{kind: normal_traction, value: 1}]\n");
  Study study;
  std::string error;
  StudyOptions options;
  options.plan.axes = {StudyAxis::kQuadrature};
  ASSERT_TRUE(RunStudy(scene, options, &study, &error)) << error;
  bool found = false;
  for (const StudyRun& run : study.runs) {
    if (run.plan.settings.quadrature != 1) {
      EXPECT_EQ(run.outcome.status, RunOutcome::Status::kConverged) << run.outcome.reason;
      continue;
    }
    found = true;
    EXPECT_EQ(run.outcome.status, RunOutcome::Status::kNotConverged);
    EXPECT_THAT(run.outcome.reason, HasSubstr("one quadrature point per triangle"));
  }
  EXPECT_TRUE(found);
}

// ---- Files ----------------------------------------------------------------------------------

TEST(StudyFilesTest, HaveEveryRunAndAgree) {
  Study study;
  std::string error;
  StudyOptions options = Pretending({StudyAxis::kResolution, StudyAxis::kQuadrature});
  ASSERT_TRUE(RunStudy(Plate(kExpectTip), options, &study, &error)) << error;
  const std::string csv = MakeAccuracyCsv(study);
  std::istringstream lines(csv);
  std::string line;
  size_t rows = 0;
  std::vector<size_t> columns;
  while (std::getline(lines, line)) {
    ++rows;
    bool quoted = false;
    size_t count = 1;
    for (const char c : line) {
      quoted = quoted != (c == '"');
      count += c == ',' && !quoted;
    }
    columns.push_back(count);
  }
  EXPECT_EQ(rows, study.runs.size() + 1);
  for (const size_t count : columns) EXPECT_EQ(count, columns[0]);
  const nlohmann::ordered_json json = MakeAccuracyJson(study);
  EXPECT_EQ(json["runs"].size(), study.runs.size());
  for (const auto& i : json["pareto_front"]["seconds"]) {
    EXPECT_TRUE(study.runs[i.get<size_t>()].on_front);
  }
  EXPECT_EQ(json["cheapest"].size(), 3u);
  const std::string report = StudyReport(study);
  EXPECT_THAT(report, HasSubstr("cheapest for 10 %: "));
  EXPECT_THAT(report, HasSubstr("cheapest for 0.1 %: "));
  EXPECT_THAT(report, HasSubstr("impossible: free edges are loose"));
  EXPECT_THAT(MakeAccuracySvg(study), HasSubstr("6 points"));
}

}  // namespace
}  // namespace darboux
