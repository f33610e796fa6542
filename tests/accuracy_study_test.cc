#include "solver/accuracy_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "solver/accuracy_results.h"
#include "tests/accuracy_util.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr char kExpectTip[] =
    "probes: [{name: tip, at: {uv: [2, 0.5]}}]\n"
    "expect:\n"
    "  - {quantity: probes.tip.displacement.z, value: 2.0, relative_tolerance: 0.1}\n";

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
