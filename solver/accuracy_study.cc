#include "solver/accuracy_study.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "solver/forked_run.h"
#include "solver/format.h"
#include "solver/results.h"

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

// Cost of a level by that of the one before (solver/accuracy.cc).
constexpr double kTimeRatio = 5.0;
// What counts as less error (ParetoFront).
constexpr double kLess = 0.999;
// Levels of a family that do not converge before the finer ones are left out.
constexpr int kMaxFailures = 2;
// A run that does not heed its limit is killed this much later.
constexpr double kGraceS = 5.0;

double Since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return t.tv_sec + 1e-6 * t.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string Serialise(const RunOutcome& outcome) {
  Json values = Json::object();
  for (const auto& [path, value] : outcome.values) values[path] = value;
  const Json json = {
      {"status", static_cast<int>(outcome.status)},
      {"reason", outcome.reason},
      {"theory", static_cast<int>(outcome.theory)},
      {"backend", outcome.backend},
      {"dof", outcome.dof},
      {"elements", outcome.elements},
      {"quadrature_points", outcome.quadrature_points},
      {"iterations", outcome.iterations},
      {"values", values},
      {"seconds", {outcome.setup_s, outcome.solve_s, outcome.total_s, outcome.cpu_s}}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool Parse(const std::string& text, RunOutcome* outcome) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) return false;
  outcome->status = static_cast<RunOutcome::Status>(json["status"].get<int>());
  outcome->reason = json["reason"].get<std::string>();
  outcome->theory = static_cast<Theory>(json["theory"].get<int>());
  outcome->backend = json["backend"].get<std::string>();
  outcome->dof = json["dof"].get<int>();
  outcome->elements = json["elements"].get<int>();
  outcome->quadrature_points = json["quadrature_points"].get<int>();
  outcome->iterations = json["iterations"].get<int>();
  for (const auto& item : json["values"].items()) {
    outcome->values[item.key()] = item.value().get<double>();
  }
  outcome->setup_s = json["seconds"][0].get<double>();
  outcome->solve_s = json["seconds"][1].get<double>();
  outcome->total_s = json["seconds"][2].get<double>();
  outcome->cpu_s = json["seconds"][3].get<double>();
  return true;
}

// Each phase's least time of several runs of the same.
void KeepLeast(const RunOutcome& other, RunOutcome* outcome) {
  outcome->setup_s = std::min(outcome->setup_s, other.setup_s);
  outcome->solve_s = std::min(outcome->solve_s, other.solve_s);
  outcome->total_s = std::min(outcome->total_s, other.total_s);
  outcome->cpu_s = std::min(outcome->cpu_s, other.cpu_s);
  outcome->memory_mb = std::min(outcome->memory_mb, other.memory_mb);
}

// Values wanted of every run: those of the expectations and those for Richardson.
std::vector<ExpectSpec> Wanted(const std::vector<StudyQuantity>& a,
                               const std::vector<StudyQuantity>& b) {
  std::vector<ExpectSpec> wanted;
  std::set<std::string> paths;
  for (const std::vector<StudyQuantity>* list : {&a, &b}) {
    for (const StudyQuantity& quantity : *list) {
      if (!paths.insert(quantity.path).second) continue;
      ExpectSpec expect;
      expect.quantity = quantity.path;
      expect.relative_tolerance = 1.0;
      wanted.push_back(expect);
    }
  }
  return wanted;
}

std::vector<StudyQuantity> RichardsonQuantities(const Scene& scene) {
  std::vector<std::string> ignored;
  const std::vector<StudyQuantity> expected = ExpectedQuantities(scene, &ignored);
  return expected.empty() ? DefaultQuantities(scene) : expected;
}

double LargestUncertainty(const std::vector<StudyQuantity>& quantities) {
  double largest = 0.0;
  for (const StudyQuantity& quantity : quantities) {
    largest = std::max(largest, quantity.uncertainty);
  }
  return largest;
}

std::string Seconds(double seconds) { return Format("%.3g s", seconds); }

// 13,461
std::string Thousands(int number) {
  std::string text = std::to_string(number);
  for (int i = static_cast<int>(text.size()) - 3; i > 0; i -= 3) text.insert(i, ",");
  return text;
}

std::string ErrorText(const StudyError& error) {
  return error.IsBelowUncertainty() ? "< " + Percent(error.uncertainty) : Percent(error.error);
}

// The scene's own theory, which `auto` decides as it goes: the one that most of its runs took.
Theory OwnTheory(const Study& study) {
  Theory theory = Theory::kAuto;
  for (const StudyRun& run : study.runs) {
    if (run.plan.family == 0 && run.outcome.theory != Theory::kAuto) theory = run.outcome.theory;
  }
  return theory;
}

std::string CostText(const StudyRun& run) {
  return run.label + ": error " + ErrorText(*run.error) + ", " + Seconds(run.cost_s) + ", " +
         Thousands(run.outcome.dof) + " dof";
}

CheapestRun FindCheapest(const Study& study, double target) {
  CheapestRun result;
  result.target = target;
  const StudyRun *cheapest = nullptr, *other = nullptr, *best = nullptr;
  for (size_t i = 0; i < study.runs.size(); ++i) {
    const StudyRun& run = study.runs[i];
    if (!run.error) continue;
    if (!run.other_model && (best == nullptr || run.CountedError() < best->CountedError())) {
      best = &run;
    }
    if (run.CountedError() > target) continue;
    const StudyRun*& least = run.other_model ? other : cheapest;
    if (least != nullptr && run.cost_s >= least->cost_s) continue;
    least = &run;
    if (!run.other_model) result.run = static_cast<int>(i);
  }
  if (cheapest != nullptr) {
    result.text = CostText(*cheapest);
  } else {
    result.text = "not reached; ";
    if (target < study.reference.uncertainty) {
      result.text +=
          "the reference itself is known to " + Percent(study.reference.uncertainty) + " only; ";
    }
    result.text += best == nullptr ? "nothing converged" : "most accurate " + CostText(*best);
  }
  // Worth a word where it saves half.
  if (other != nullptr && (cheapest == nullptr || other->cost_s < 0.5 * cheapest->cost_s)) {
    result.text += "; by another model " + CostText(*other);
  }
  return result;
}

}  // namespace

const char* ToString(RunOutcome::Status status) {
  switch (status) {
    case RunOutcome::Status::kConverged:
      return "converged";
    case RunOutcome::Status::kNotConverged:
      return "not converged";
    case RunOutcome::Status::kImpossible:
      return "impossible";
    case RunOutcome::Status::kSkipped:
      return "skipped";
    case RunOutcome::Status::kStopped:
      return "stopped";
    case RunOutcome::Status::kCrashed:
      return "crashed";
  }
  return "";
}

RunOutcome RunHere(const Scene& scene, const SolverOptions& options) {
  RunOutcome outcome;
  const Clock::time_point start = Clock::now();
  const double cpu_start = CpuSeconds();
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  const bool posed = Solve(scene, options, &problem, &summary, &outcome.reason);
  outcome.total_s = Since(start);
  outcome.cpu_s = CpuSeconds() - cpu_start;
  if (!posed) {
    outcome.status = RunOutcome::Status::kImpossible;
    return outcome;
  }
  using Termination = SolverSummary::Termination;
  outcome.status = summary.IsConverged() ? RunOutcome::Status::kConverged
                   : summary.termination == Termination::kStopped
                       ? RunOutcome::Status::kStopped
                       : RunOutcome::Status::kNotConverged;
  outcome.reason = summary.IsConverged() ? "" : summary.message;
  outcome.theory = summary.theory;
  outcome.backend = summary.backend;
  outcome.dof = summary.dof;
  outcome.elements = summary.elements;
  outcome.quadrature_points = summary.quadrature_points;
  outcome.iterations = summary.iterations;
  outcome.setup_s = summary.setup_s;
  outcome.solve_s = summary.solve_s;
  std::vector<ExpectResult> results;
  EvaluateExpectations(scene, MakeSummaryJson(scene, summary, nullptr), &results);
  for (const ExpectResult& result : results) {
    if (result.value && std::isfinite(*result.value)) {
      outcome.values[result.quantity] = *result.value;
    } else if (outcome.status == RunOutcome::Status::kConverged) {
      outcome.status = RunOutcome::Status::kNotConverged;
      outcome.reason = result.quantity + ": " + result.message;
    }
  }
  return outcome;
}

RunOutcome RunInChild(const Scene& scene, const SolverOptions& options) {
  const double limit = options.time_limit_s > 0.0 ? options.time_limit_s + kGraceS : 0.0;
  const ForkedOutcome forked =
      RunForked([&] { return Serialise(RunHere(scene, options)); }, limit, options.stop);
  RunOutcome outcome;
  outcome.reason = forked.message;
  switch (forked.status) {
    case ForkedOutcome::Status::kDone:
      if (!Parse(forked.output, &outcome)) {
        outcome.status = RunOutcome::Status::kCrashed;
        outcome.reason = "its report is not readable";
      }
      break;
    case ForkedOutcome::Status::kStopped:
      outcome.status = RunOutcome::Status::kStopped;
      break;
    case ForkedOutcome::Status::kTimeLimit:
      outcome.status = RunOutcome::Status::kNotConverged;
      break;
    default:
      outcome.status = RunOutcome::Status::kCrashed;
  }
  outcome.memory_mb = forked.memory_mb;
  return outcome;
}

std::vector<int> ParetoFront(const std::vector<double>& costs, const std::vector<double>& errors) {
  std::vector<int> order(costs.size()), front;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return costs[a] != costs[b] ? costs[a] < costs[b] : errors[a] < errors[b];
  });
  for (const int i : order) {
    if (front.empty() || errors[i] < kLess * errors[front.back()]) front.push_back(i);
  }
  return front;
}

bool RunStudy(const Scene& scene, const StudyOptions& options, Study* study, std::string* error) {
  *study = Study();
  study->name = scene.name;
  const StudyPlan plan = MakeStudyPlan(scene, options.plan);
  study->families = plan.families;
  study->notes = plan.notes;
  study->count_cpu = options.count_cpu;
  std::vector<std::string> ignored;
  const std::vector<ExpectSpec> wanted =
      Wanted(ExpectedQuantities(scene, &ignored), RichardsonQuantities(scene));

  const Clock::time_point start = Clock::now();
  const double limit = options.solver.time_limit_s;
  const int num_runs = static_cast<int>(plan.runs.size());
  // Seconds of the last level of each family, and of each level of the scene's own.
  std::map<int, double> before, own;
  std::map<int, int> failures;             // of each family, one after the other
  double taken_s = 0.0, taken_work = 0.0;  // of all runs so far
  bool posed = false;
  std::string first_reason;
  for (int i = 0; i < num_runs; ++i) {
    StudyRun run;
    run.plan = plan.runs[i];
    const StudySettings& settings = run.plan.settings;
    Scene run_scene = scene;
    run_scene.expect = wanted;
    run.divisions = DivisionsOf(scene, settings);
    RunOutcome& outcome = run.outcome;
    const double dof = EstimatedDof(scene, settings);
    const double left = limit - Since(start);
    double expected_s = own.count(run.plan.level) > 0 ? own[run.plan.level] : 0.0;
    if (before.count(run.plan.family) > 0) {
      expected_s = std::max(expected_s, kTimeRatio * before[run.plan.family]);
    }
    if (study->stopped) {
      outcome.reason = "stopped before";
    } else if (failures[run.plan.family] >= kMaxFailures) {
      outcome.reason = "the coarser levels did not converge either";
    } else if (dof > options.max_dof) {
      outcome.reason =
          "about " + Format("%.0f", dof) + " dof, more than " + Format("%.0f", options.max_dof);
    } else if (limit > 0.0 && left < expected_s) {
      outcome.reason = "does not fit into the time limit: it may take " + Seconds(expected_s);
    } else if (limit > 0.0 && left <= 0.0) {
      outcome.reason = "no time is left";
    } else if (ApplySettings(settings, &run_scene, &outcome.reason)) {
      for (int k = 0; k < std::max(1, options.repeats); ++k) {
        SolverOptions solver = options.solver;
        solver.backend = settings.backend;
        if (limit > 0.0) {
          solver.time_limit_s = limit - Since(start);
          if (solver.time_limit_s <= 0.0) break;  // Never in the first.
        }
        const RunOutcome again = options.runner(run_scene, solver);
        if (k == 0) {
          outcome = again;
        } else if (again.status == RunOutcome::Status::kConverged) {
          KeepLeast(again, &outcome);
        }
        if (again.status != RunOutcome::Status::kConverged) break;
      }
      if (outcome.status != RunOutcome::Status::kImpossible) posed = true;
      if (outcome.status == RunOutcome::Status::kImpossible && first_reason.empty()) {
        first_reason = outcome.reason;
      }
      if (outcome.status == RunOutcome::Status::kConverged) {
        failures[run.plan.family] = 0;
      } else if (outcome.status == RunOutcome::Status::kNotConverged) {
        ++failures[run.plan.family];
      }
      if (outcome.total_s >= 0.0) {
        before[run.plan.family] = outcome.total_s;
        if (run.plan.family == 0) own[run.plan.level] = outcome.total_s;
      }
    }
    run.label = DescribeRun(
        scene, settings, outcome.theory == Theory::kAuto ? settings.theory : outcome.theory);
    study->runs.push_back(run);
    if (options.solver.stop != nullptr && options.solver.stop->load()) study->stopped = true;
    if (options.on_run && !(study->stopped && outcome.status == RunOutcome::Status::kSkipped)) {
      // Sparse factorisations of shells grow a little faster than the dof.
      constexpr double kPower = 1.2;
      if (outcome.total_s >= 0.0) {
        taken_s += outcome.total_s * std::max(1, options.repeats);
        taken_work += std::pow(dof, kPower);
      }
      double work = 0.0;
      for (int next = i + 1; next < num_runs; ++next) {
        const double next_dof = EstimatedDof(scene, plan.runs[next].settings);
        if (next_dof <= options.max_dof) work += std::pow(next_dof, kPower);
      }
      double left_s = taken_work > 0.0 ? taken_s * work / taken_work : 0.0;
      if (limit > 0.0) left_s = std::min(left_s, std::max(0.0, limit - Since(start)));
      options.on_run(run, i + 1, num_runs, left_s);
    }
    // The scene's own settings come first: without a single one of them there is no study.
    const bool own_end = i + 1 == num_runs || plan.runs[i + 1].family != 0;
    if (run.plan.family == 0 && own_end && !posed && !first_reason.empty()) {
      *error = first_reason;
      return false;
    }
  }
  EvaluateStudy(scene, options, study);
  return true;
}

void EvaluateStudy(const Scene& scene, const StudyOptions& options, Study* study) {
  StudyReference& reference = study->reference;
  const Theory own_theory = OwnTheory(*study);
  for (StudyRun& run : study->runs) {
    const bool other_theory =
        run.outcome.theory != Theory::kAuto && run.outcome.theory != own_theory;
    run.other_model = other_theory || run.plan.settings.strains != scene.model.strains;
  }

  // Families of the scene's own model, finest levels last.
  const std::vector<StudyQuantity> quantities = RichardsonQuantities(scene);
  std::vector<FamilyValues> families;
  for (size_t family = 0; family < study->families.size(); ++family) {
    FamilyValues values;
    values.name = study->families[family];
    for (const StudyRun& run : study->runs) {
      const RunOutcome& outcome = run.outcome;
      if (run.plan.family != static_cast<int>(family) || run.other_model ||
          outcome.status != RunOutcome::Status::kConverged) {
        continue;
      }
      std::vector<double> level;
      for (const StudyQuantity& quantity : quantities) {
        const auto value = outcome.values.find(quantity.path);
        if (value != outcome.values.end()) level.push_back(value->second);
      }
      const double h = 1.0 / std::sqrt(static_cast<double>(outcome.elements));
      if (level.size() != quantities.size() || (!values.h.empty() && h >= values.h.back()))
        continue;
      values.h.push_back(h);
      values.values.push_back(std::move(level));
    }
    families.push_back(std::move(values));
  }
  study->richardson = ExtrapolateFamilies(quantities, families);

  const std::vector<StudyQuantity> expected = ExpectedQuantities(scene, &study->notes);
  if (!expected.empty() && !options.richardson) {
    reference.kind = StudyReference::Kind::kExpect;
    reference.quantities = expected;
    reference.method =
        "the scene's expect; its uncertainty is half a unit in the last digit that is printed";
    if (study->richardson) {
      for (const StudyQuantity& limit : study->richardson->quantities) {
        for (const StudyQuantity& expect : expected) {
          if (expect.path != limit.path) continue;
          const double difference = std::abs(limit.reference - expect.reference) / expect.scale;
          if (difference <= limit.uncertainty + expect.uncertainty) continue;
          study->notes.push_back("expect " + expect.path + " = " +
                                 Format("%.9g", expect.reference) + " is " + Percent(difference) +
                                 " from the limit of '" + study->richardson->family + "', " +
                                 Format("%.9g", limit.reference) + ", which is uncertain by " +
                                 Percent(limit.uncertainty));
        }
      }
    }
  } else if (study->richardson) {
    reference.kind = StudyReference::Kind::kRichardson;
    reference.quantities = study->richardson->quantities;
    reference.method = "Richardson extrapolation of '" + study->richardson->family +
                       "' from its finest levels; uncertainty: its change when the finest "
                       "level is left out, a third of its distance to that level (all of it with "
                       "three levels) or what other settings contradict it by";
  } else {
    reference.method = "none: no family of the scene's own model has three levels that converged";
  }
  reference.uncertainty = LargestUncertainty(reference.quantities);

  std::vector<int> with_error;
  std::vector<double> seconds, dof, errors;
  for (size_t i = 0; i < study->runs.size(); ++i) {
    StudyRun& run = study->runs[i];
    run.on_front = run.on_dof_front = false;
    run.error.reset();
    run.cost_s = options.count_cpu ? run.outcome.cpu_s : run.outcome.total_s;
    if (run.outcome.status != RunOutcome::Status::kConverged) continue;
    if (reference.kind != StudyReference::Kind::kNone) {
      run.error = ErrorOf(reference.quantities, run.outcome.values);
    }
    if (!run.error || run.other_model) continue;
    with_error.push_back(static_cast<int>(i));
    seconds.push_back(run.cost_s);
    dof.push_back(run.outcome.dof);
    errors.push_back(run.CountedError());
  }
  for (const int i : ParetoFront(seconds, errors)) study->runs[with_error[i]].on_front = true;
  for (const int i : ParetoFront(dof, errors)) study->runs[with_error[i]].on_dof_front = true;
  study->established = !with_error.empty();
  study->cheapest.clear();
  for (const double target : options.targets) {
    study->cheapest.push_back(FindCheapest(*study, target));
  }
}

}  // namespace darboux
