#include "solver/accuracy.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <utility>

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double kAssumedOrder = 2.0;
constexpr double kWorstOrder = 0.5;
// Probes that move less, relative to the largest displacement, are measured against this.
constexpr double kStill = 1e-4;
// Cost of a level by that of the one before: four times the unknowns, a little more than linear.
constexpr double kTimeRatio = 5.0;

// What the error is estimated of, and the sizes that make it relative.
struct Quantities {
  std::vector<Eigen::Vector3d> value;
  std::vector<double> size;
};

Quantities QuantitiesOf(const SolverSummary& summary) {
  Quantities result;
  for (const ProbeSummary& probe : summary.probes) {
    result.value.push_back(probe.displacement);
    result.size.push_back(std::max(probe.displacement.norm(), kStill * summary.max_displacement));
  }
  if (summary.probes.empty()) {
    for (const double number : {summary.max_displacement, summary.energy_total}) {
      result.value.push_back(number * Eigen::Vector3d::UnitX());
      result.size.push_back(std::abs(number));
    }
  }
  return result;
}

// Of the last level; levels.size() >= 2.
double Estimate(const std::vector<Quantities>& levels) {
  const size_t last = levels.size() - 1;
  double largest = 0.0;
  for (size_t i = 0; i < levels[last].value.size(); ++i) {
    const double change = (levels[last].value[i] - levels[last - 1].value[i]).norm();
    if (change == 0.0) continue;  // Also where nothing moves at all.
    double order = kAssumedOrder;
    if (last >= 2) {
      const double before = (levels[last - 1].value[i] - levels[last - 2].value[i]).norm();
      order = std::clamp(std::log2(before / change), kWorstOrder, kAssumedOrder);
    }
    largest = std::max(largest, change / ((std::exp2(order) - 1.0) * levels[last].size[i]));
  }
  return largest;
}

}  // namespace

bool SolveToAccuracy(const Scene& scene,
                     const SolverOptions& solver_options,
                     const AccuracyOptions& options,
                     std::unique_ptr<ShellProblem>* problem,
                     SolverSummary* summary,
                     AccuracyReport* report,
                     std::string* error) {
  CHECK(scene.model.accuracy.has_value());
  *report = AccuracyReport();
  report->target = *scene.model.accuracy;
  const Clock::time_point start = Clock::now();
  Scene level_scene = scene;
  SolverOptions level_options = solver_options;
  std::vector<Quantities> quantities;
  double setup_s = 0.0, solve_s = 0.0;
  const auto end = [&](const std::string& why) {
    std::ostringstream text;
    text << "accuracy " << report->target << (report->reached ? " reached" : " not reached");
    if (report->estimate) text << ", estimated error " << *report->estimate;
    if (!why.empty()) text << ": " << why;
    report->message = text.str();
    summary->decisions.push_back(report->message);
    summary->setup_s = setup_s;
    summary->solve_s = solve_s;
    return true;
  };

  while (true) {
    const Clock::time_point level_start = Clock::now();
    std::unique_ptr<ShellProblem> level_problem;
    SolverSummary level_summary;
    if (!Solve(level_scene, level_options, &level_problem, &level_summary, error)) {
      if (report->levels.empty()) return false;
      return end("the next level failed: " + *error);
    }
    setup_s += level_summary.setup_s;
    solve_s += level_summary.solve_s;
    const bool converged = level_summary.IsConverged();
    if (!converged && !report->levels.empty()) {
      return end("the next level did not converge: " + level_summary.message);
    }
    *problem = std::move(level_problem);
    *summary = std::move(level_summary);
    AccuracyLevel level;
    level.divisions = level_scene.surface.divisions;
    level.dof = summary->dof;
    level.seconds = Since(level_start);
    if (converged) {
      quantities.push_back(QuantitiesOf(*summary));
      if (quantities.size() > 1) level.estimate = Estimate(quantities);
    }
    report->estimate = level.estimate;
    report->levels.push_back(level);
    if (options.on_level) options.on_level(level);
    if (!converged) return end("the first level did not converge: " + summary->message);
    if (level.estimate && *level.estimate <= report->target) {
      report->reached = true;
      return end("");
    }

    if (solver_options.stop != nullptr && solver_options.stop->load()) {
      return end("stopped by the user");
    }
    if (4.0 * level.dof > options.max_dof) {
      std::ostringstream why;
      why << "the next level would have more than " << options.max_dof << " dof";
      return end(why.str());
    }
    if (solver_options.time_limit_s > 0.0) {
      level_options.time_limit_s = solver_options.time_limit_s - Since(start);
      if (level_options.time_limit_s < kTimeRatio * level.seconds) {
        return end("the next level does not fit into the time limit");
      }
    }
    for (int& divisions : level_scene.surface.divisions) divisions *= 2;
  }
}

}  // namespace darboux
