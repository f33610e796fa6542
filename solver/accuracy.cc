#include "solver/accuracy.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "solver/adaptive_grading.h"
#include "solver/error_sequence.h"
#include "solver/goal_response.h"
#include "solver/mesh_adaptation.h"
#include "solver/mesh_surface.h"
#include "solver/minimisation.h"
#include "solver/theory_error.h"

namespace darboux {
namespace {

constexpr double kFirstCells = 64.0;
constexpr int kFirstSolutions = 4, kSolutions = 3;  // on a lattice of one size
constexpr int kFirstTries = 4, kTries = 3;          // where a level does not converge
// A map that makes the sum of errors less than this much smaller is not worth having, and one that
// changes cells by less than kSettled no further solution.
constexpr double kWorthwhile = 1.5, kSettled = 0.1;
constexpr double kMostSkew = 2.0;  // of the proportion at a time
constexpr double kLeastGrowth = 1.25, kUnknownGrowth = 2.0, kMostGrowth = 4.0;
constexpr double kSmallGrowth = 1.05;  // where little lacks
constexpr double kLastGrowth = 1.02;   // where max_dof allows no more
// Aim and end below the target: estimates were as small as 0.7 of the error on lattices, 0.6 on
// meshes.
constexpr double kSafety = 0.75;
constexpr double kTheoryShare = 0.5;  // of the target
constexpr double kQuadratureShare = 0.5;
constexpr double kContactShare = 0.25;
constexpr int kStalled = 4;  // levels of meshes in a row whose estimates are above an earlier one
constexpr double kLeastSpacing = 0.05;  // of points of contact
// Time of a level by its number of unknowns.
constexpr double kTimeOrder = 1.2;

std::vector<double> SizesOf(const std::vector<Goal>& goals) {
  std::vector<double> sizes;
  for (const Goal& goal : goals) sizes.push_back(goal.size);
  return sizes;
}

std::vector<Eigen::Vector3d> ValuesOf(const std::vector<Goal>& goals) {
  std::vector<Eigen::Vector3d> values;
  for (const Goal& goal : goals) values.push_back(goal.value);
  return values;
}

double DofOf(const std::array<int, 2>& divisions) {
  return 3.0 * (divisions[0] + 3.0) * (divisions[1] + 3.0);
}

double LargestDifference(const std::vector<Goal>& a, const std::vector<Goal>& b) {
  double largest = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double difference = (a[i].value - b[i].value).norm();
    if (difference > 0.0) largest = std::max(largest, difference / a[i].size);
  }
  return largest;
}

// A solved scene.
struct Answer {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  std::vector<Goal> goals;
};

// The state of one call of SolveToAccuracy.
class AccuracyLoop {
 public:
  AccuracyLoop(const Scene& scene,
               const SolverOptions& solver_options,
               const AccuracyOptions& options,
               AccuracyReport* report)
      : scene_(scene),
        solver_options_(solver_options),
        options_(options),
        report_(*report),
        asked_theory_(scene.model.theory),
        start_(Clock::now()),
        meshes_(options.max_dof, solver_options.backend, solver_options.num_threads) {
    report_ = AccuracyReport();
    report_.target = *scene.model.accuracy;
  }

  bool Run(Answer* answer, std::string* error);

 private:
  enum class Outcome { kDone, kContinue, kFailed };

  // Solves scene_, from an answer on a coarser mesh or with other points of contact where there is
  // one; the times go to the sums.
  bool SolveOnce(Answer* answer, std::string* error, const Answer* before = nullptr);
  // What `before` is on the present mesh; empty where it is no start.
  Eigen::Matrix3Xd StartFrom(const Answer& before) const;
  // The first level on which the scene converges.
  Outcome FirstAnswer(Answer* answer, std::string* error);
  // Where the scene does not converge: finer. False and *why where there is no room.
  bool GrowFailed(const Answer& answer, std::string* why);
  // The next level that converges. False and *why where none does.
  bool NextAnswer(Answer* answer, std::string* why);
  // Theory, on the first lattice. False where the scene fails in the nonlinear theory.
  bool ChooseTheory(Answer* answer, std::string* error);
  // Moves the cells of scene_; whether it is worth solving again with as many.
  bool ImproveLattice(Answer* answer);
  void ChooseQuadrature(const Answer& answer, double estimate);
  // Halves the spacing of points of contact until that matters little.
  void ChooseContact(Answer* answer, double seconds, int* solutions);
  // The answers of one more level, and what they say of its error.
  void Estimate(const Answer& answer, ErrorSequence* sequence);
  // scene_ with more cells, by `least` or more. False and *why where there is no room for them.
  // Meshes are refined by what the problem of their last answer says.
  bool Grow(double factor, double least, double seconds, std::string* why);
  bool RefineMesh(const Answer& answer, double seconds, std::string* why);
  bool HasTime(double seconds, std::string* why) const;
  std::optional<double> Total() const;
  // Whether the total is within the target. Answers of meshes that lock change little from one to
  // the next, so that estimates take them for right: those do not count.
  bool IsReached(const Answer& answer) const;
  static bool IsResolved(const Answer& answer) {
    return !answer.summary.resolution || answer.summary.resolution->IsSufficient();
  }
  double SolverError(Answer* answer);
  void FindMultiples();
  // As many cells as max_dof allows, cells_ at most; {0, 0} where there is no room at all.
  std::array<int, 2> Divisions() const {
    std::array<int, 2> next = DivisionsFor(cells_, proportion_, least_, multiple_);
    if (DofOf(next) > options_.max_dof) {
      LargestDivisions(options_.max_dof, proportion_, least_, multiple_, &next);
    }
    return next;
  }
  bool IsLattice() const { return scene_.surface.mesh == nullptr; }
  bool ChoosesContact() const {
    if (IsLattice() || scene_.model.contact_spacing_given) return false;
    for (const FingerSpec& finger : scene_.fingers) {
      if (finger.shape != FingerSpec::Shape::kPin && finger.shape != FingerSpec::Shape::kPlane) {
        return true;
      }
    }
    return false;
  }
  bool HasOutsideForces() const { return !scene_.fingers.empty() || FindGas(scene_) != nullptr; }
  void Decide(const std::string& line) { decisions_.push_back(line); }
  void Finish(const std::string& why, Answer* answer);

  Scene scene_;
  SolverOptions solver_options_;
  const AccuracyOptions& options_;
  AccuracyReport& report_;
  const Theory asked_theory_;
  const Clock::time_point start_;
  ErrorSequence sequence_, before_;  // of lattices, with and without the last level
  SurfaceSpec own_surface_;          // of the scene
  MeshAdaptation meshes_;
  double least_estimate_ = std::numeric_limits<double>::infinity();
  int stalled_ = 0;            // levels since
  std::string no_indicators_;  // why there are none of the last mesh; empty: there are
  std::vector<std::string> decisions_;
  std::string theory_reason_;
  double cells_ = 0.0, proportion_ = 1.0;
  std::array<int, 2> least_{2, 2}, multiple_{2, 2};  // of divisions
  SurfaceSpec first_surface_;                        // of the first level
  double dual_size_ = 0.0;                           // largest entry of the goals' dual solutions
  double setup_s_ = 0.0, solve_s_ = 0.0;
};

void AccuracyLoop::FindMultiples() {
  for (int d = 0; d < 2; ++d) {
    least_[d] = scene_.surface.periodic[d] ? 6 : 2;
    // Only where forces and probes are at the ends nothing marks the middle.
    const auto& range = d == 0 ? scene_.surface.u_range : scene_.surface.v_range;
    const auto at_end = [&](const SurfacePoint& point) {
      return point.kind == SurfacePoint::Kind::kUv &&
             (point.uv[d] == range[0] || point.uv[d] == range[1]);
    };
    bool ends = !scene_.surface.periodic[d] && !scene_.probes.empty();
    for (const ProbeSpec& probe : scene_.probes) ends = ends && at_end(probe.at);
    for (const LoadSpec& load : scene_.loads) {
      if (load.kind == LoadSpec::Kind::kPoint) ends = ends && at_end(load.at);
    }
    multiple_[d] = ends ? 1 : 2;
  }
}

Eigen::Matrix3Xd AccuracyLoop::StartFrom(const Answer& before) const {
  // Friction depends on the way.
  if (IsLattice() || !before.problem->nonlinear() || scene_.steps > 1 ||
      scene_.path.control != PathControl::kLoad || before.problem->effect(Effect::kFriction).on) {
    return Eigen::Matrix3Xd();
  }
  std::string error;
  const auto coarse = MakeHierarchicalMesh(before.problem->scene().surface, &error);
  const auto fine = MakeHierarchicalMesh(scene_.surface, &error);
  if (coarse == nullptr || fine == nullptr ||
      coarse->mesh().mesh.num_vertices != before.problem->displacements().cols()) {
    return Eigen::Matrix3Xd();
  }
  return coarse->Prolong(before.problem->displacements(), *fine);
}

bool AccuracyLoop::SolveOnce(Answer* answer, std::string* error, const Answer* before) {
  Answer result;
  SolverOptions options = solver_options_;
  if (before != nullptr) options.initial_displacements = StartFrom(*before);
  if (options.time_limit_s > 0.0) {
    options.time_limit_s = std::max(options.time_limit_s - Since(start_), 1e-3);
  }
  if (!Solve(scene_, options, &result.problem, &result.summary, error)) return false;
  setup_s_ += result.summary.setup_s;
  solve_s_ += result.summary.solve_s;
  if (result.summary.IsConverged()) result.goals = GoalsOf(scene_, result.summary);
  *answer = std::move(result);
  return true;
}

AccuracyLoop::Outcome AccuracyLoop::FirstAnswer(Answer* answer, std::string* error) {
  for (int tries = 1;; ++tries) {
    if (!SolveOnce(answer, error)) {
      // What is well posed on the scene's own mesh need not be on another: loads balance to
      // the digits of their integration.
      if (scene_.surface.sphere_radius == own_surface_.sphere_radius) return Outcome::kFailed;
      Decide("surface: the scene's own after all: " + *error);
      scene_.surface = own_surface_;
      if (!SolveOnce(answer, error)) return Outcome::kFailed;
    }
    if (answer->summary.IsConverged()) return Outcome::kContinue;
    std::string why;
    if (tries == kFirstTries || !GrowFailed(*answer, &why)) {
      Finish("the first level did not converge: " + answer->summary.message +
                 (why.empty() ? "" : "; " + why),
             answer);
      return Outcome::kDone;
    }
  }
}

bool AccuracyLoop::GrowFailed(const Answer& answer, std::string* why) {
  using Termination = SolverSummary::Termination;
  const SolverSummary& summary = answer.summary;
  if (summary.termination == Termination::kStopped ||
      summary.termination == Termination::kTimeLimit) {
    return false;
  }
  std::string where = "everywhere";
  if (IsLattice() ? !Grow(kUnknownGrowth, kLeastGrowth, 0.0, why)
                  : !meshes_.RefineFailed(answer.problem.get(), &scene_.surface, &where, why)) {
    return false;
  }
  Decide("resolution: finer " + where + ", as the scene does not converge on " +
         std::to_string(summary.dof) + " dof: " + summary.message);
  return true;
}

bool AccuracyLoop::NextAnswer(Answer* answer, std::string* why) {
  for (int tries = 1;; ++tries) {
    Answer next;
    if (!SolveOnce(&next, why, answer)) {
      *why = "the next level failed: " + *why;
      return false;
    }
    if (next.summary.IsConverged()) {
      *answer = std::move(next);
      return true;
    }
    *why = "the next level did not converge: " + next.summary.message;
    // Lattices grow evenly: the next one would hardly do better.
    std::string no_room;
    if (IsLattice() || tries == kTries || !GrowFailed(next, &no_room)) return false;
  }
}

bool AccuracyLoop::ChooseTheory(Answer* answer, std::string* error) {
  const bool linear = answer->summary.theory == Theory::kLinear;
  if (!linear || HasOutsideForces()) return true;
  TheoryError estimate;
  if (!EstimateTheoryError(*answer->problem,
                           answer->goals,
                           solver_options_.backend,
                           solver_options_.num_threads,
                           &estimate,
                           error)) {
    return false;
  }
  const bool needed = !(estimate.value <= kTheoryShare * report_.target);
  if (asked_theory_ != Theory::kAuto || !needed) {
    report_.theory = estimate.value;
    if (asked_theory_ == Theory::kAuto) {
      std::ostringstream reason;
      reason << "chosen: the nonlinear theory would change the goals by " << estimate.value
             << " (Newton's step from the linear solution), within half of the accuracy";
      theory_reason_ = reason.str();
      scene_.model.theory = Theory::kLinear;
    }
    return true;
  }
  const std::vector<Goal> linear_goals = answer->goals;
  scene_.model.theory = Theory::kNonlinear;
  if (!SolveOnce(answer, error)) return false;
  std::ostringstream reason;
  reason << "chosen: the nonlinear theory was estimated to change " << estimate.goal << " by "
         << estimate.value << ", above half of the accuracy";
  if (answer->summary.IsConverged()) {
    reason << "; it changes the goals by " << LargestDifference(answer->goals, linear_goals);
  }
  theory_reason_ = reason.str();
  return true;
}

bool AccuracyLoop::ImproveLattice(Answer* answer) {
  if (!IsLattice() || scene_.surface.grading_given) return false;
  GoalResponse response;
  if (!EvaluateGoalResponse(answer->problem.get(),
                            answer->goals,
                            solver_options_.backend,
                            solver_options_.num_threads,
                            &response)) {
    return false;
  }
  dual_size_ = 0.0;
  for (const Eigen::Matrix3Xd& dual : response.duals) {
    dual_size_ = std::max(dual_size_, dual.cwiseAbs().maxCoeff());
  }
  const LatticeAdvice advice = AdviseLattice(*answer->problem, response.duals);
  SurfaceSpec& surface = scene_.surface;
  const bool has_maps =
      !surface.grading_maps[0].is_identity() || !surface.grading_maps[1].is_identity();
  const bool moves = has_maps || advice.gain > kWorthwhile;
  if (moves) surface.grading_maps = advice.maps;
  const double skew = std::clamp(advice.proportion / proportion_, 1.0 / kMostSkew, kMostSkew);
  proportion_ *= skew;
  const std::array<int, 2> before = surface.divisions;
  surface.divisions = Divisions();
  return (moves && advice.change > kSettled) || before != surface.divisions;
}

void AccuracyLoop::ChooseQuadrature(const Answer& answer, double estimate) {
  constexpr int kFine = 6;
  if (scene_.model.quadrature_given || scene_.model.quadrature >= kFine) return;
  const SurfaceSpec next = scene_.surface;
  const int coarse = scene_.model.quadrature;
  scene_.model.quadrature = kFine;
  // The meshes so far, the last one first.
  ErrorSequence sequence;
  Answer fine;
  std::string error;
  const auto solve = [&](const SurfaceSpec& surface) {
    scene_.surface = surface;
    return SolveOnce(&fine, &error) && fine.summary.IsConverged();
  };
  double change = 0.0;
  bool finer = solve(answer.problem->scene().surface);
  if (finer) {
    change = LargestDifference(fine.goals, answer.goals);
    const Answer last = std::move(fine);
    finer = change > kQuadratureShare * estimate && solve(first_surface_);
    if (finer) {
      for (const Answer* level : {const_cast<const Answer*>(&fine), &last}) {
        sequence.Add(level->summary.elements, ValuesOf(level->goals), SizesOf(level->goals));
      }
      sequence_ = sequence;
      before_.Clear();
    }
  }
  if (!finer) scene_.model.quadrature = coarse;
  scene_.surface = next;
  std::ostringstream line;
  line << "quadrature: " << scene_.model.quadrature << " points a triangle; " << kFine
       << " change the goals by " << change << ", the estimated error is " << estimate;
  Decide(line.str());
}

bool AccuracyLoop::Grow(double factor, double least, double seconds, std::string* why) {
  SurfaceSpec& surface = scene_.surface;
  const double present = static_cast<double>(surface.divisions[0]) * surface.divisions[1];
  // Rounding to whole numbers may give the same lattice again.
  cells_ *= factor;
  std::array<int, 2> next = Divisions();
  while (next[0] * next[1] < least * present && cells_ < 2.0 * factor * present) {
    cells_ *= 1.1;
    next = Divisions();
  }
  if (next[0] * next[1] < kLastGrowth * present) {
    std::ostringstream text;
    text << "the next level would have more than " << options_.max_dof << " dof";
    *why = text.str();
    return false;
  }
  cells_ = static_cast<double>(next[0]) * next[1];
  // Differences of meshes that are hardly different are no errors.
  if (cells_ < kLeastGrowth * present && !report_.levels.empty()) sequence_ = before_;
  if (!HasTime(seconds * std::pow(cells_ / present, kTimeOrder), why)) return false;
  surface.divisions = next;
  return true;
}

bool AccuracyLoop::RefineMesh(const Answer& answer, double seconds, std::string* why) {
  if (!no_indicators_.empty()) {
    *why = no_indicators_;
    return false;
  }
  if (report_.discretisation && !(*report_.discretisation >= least_estimate_)) {
    least_estimate_ = *report_.discretisation;
    stalled_ = 0;
  } else if (report_.discretisation && ++stalled_ == kStalled) {
    std::ostringstream text;
    text << "estimates do not fall below " << least_estimate_
         << ": what is asked for may have no limit, as where single points are clamped";
    *why = text.str();
    return false;
  }
  const double others = report_.contact.value_or(0.0);
  const double wanted = std::max(kSafety * report_.target - others, 0.1 * report_.target);
  SurfaceSpec surface = scene_.surface;
  int dof = 0;
  if (!meshes_.Refine(answer.problem.get(), wanted, &surface, &dof, why)) return false;
  const double growth = static_cast<double>(dof) / answer.summary.dof;
  if (!HasTime(seconds * std::pow(growth, kTimeOrder), why)) return false;
  scene_.surface = surface;
  return true;
}

void AccuracyLoop::Estimate(const Answer& answer, ErrorSequence* sequence) {
  const std::vector<Eigen::Vector3d> values = ValuesOf(answer.goals);
  const std::vector<double> sizes = SizesOf(answer.goals);
  if (IsLattice()) {
    sequence->Add(answer.summary.elements, values, sizes);
    report_.discretisation = sequence->Estimate();
    return;
  }
  report_.discretisation.reset();
  no_indicators_.clear();
  if (meshes_.Add(answer.problem.get(), values, sizes, &no_indicators_)) {
    report_.discretisation = meshes_.Estimate();
  }
}

void AccuracyLoop::ChooseContact(Answer* answer, double seconds, int* solutions) {
  double& spacing = scene_.model.contact_spacing;
  while (0.5 * spacing >= kLeastSpacing) {
    std::string why;
    constexpr double kCost = 2.0;  // times as long, or less
    if (!HasTime(kCost * seconds, &why)) return;
    spacing *= 0.5;
    Answer finer;
    std::string failure;
    if (!SolveOnce(&finer, &failure, answer) || !finer.summary.IsConverged()) {
      spacing *= 2.0;
      return;
    }
    ++*solutions;
    const double change = LargestDifference(finer.goals, answer->goals);
    std::ostringstream line;
    line << "contact: points " << spacing << " of a finger's radius apart; half as many change the "
         << "goals by " << change;
    *answer = std::move(finer);
    meshes_.ReplaceLast(ValuesOf(answer->goals));
    report_.contact = change / 3.0;  // of second order
    if (*report_.contact <= kContactShare * report_.target || 0.5 * spacing < kLeastSpacing) {
      Decide(line.str());
      return;
    }
  }
}

bool AccuracyLoop::HasTime(double seconds, std::string* why) const {
  if (!(solver_options_.time_limit_s > 0.0)) return true;
  if (solver_options_.time_limit_s - Since(start_) >= seconds) return true;
  *why = "the next level does not fit into the time limit";
  return false;
}

std::optional<double> AccuracyLoop::Total() const {
  if (!report_.discretisation) return std::nullopt;
  double total =
      *report_.discretisation + report_.solver.value_or(0.0) + report_.contact.value_or(0.0);
  if (asked_theory_ == Theory::kAuto) total += report_.theory.value_or(0.0);
  return total;
}

bool AccuracyLoop::IsReached(const Answer& answer) const {
  return report_.estimate && *report_.estimate <= report_.target && IsResolved(answer);
}

double AccuracyLoop::SolverError(Answer* answer) {
  ShellProblem* problem = answer->problem.get();
  if (!problem->nonlinear() && dual_size_ > 0.0) {
    // |z . g| <= max |z| * sum |g|, with the dual solutions of a coarser lattice.
    const Equilibrium equilibrium = CheckEquilibrium(problem);
    return dual_size_ * std::sqrt(3.0 * problem->displacements().cols()) *
           equilibrium.relative_gradient * equilibrium.reference / problem->force_unit();
  }
  GoalResponse response;
  if (!EvaluateGoalResponse(problem,
                            answer->goals,
                            solver_options_.backend,
                            solver_options_.num_threads,
                            &response)) {
    return answer->summary.gradient_norm;
  }
  return response.solver_error;
}

void AccuracyLoop::Finish(const std::string& why, Answer* answer) {
  std::ostringstream text;
  text << "accuracy " << report_.target << (report_.reached ? " reached" : " not reached");
  if (report_.estimate) {
    text << ", estimated error " << *report_.estimate << ": discretisation "
         << *report_.discretisation << ", solver " << report_.solver.value_or(0.0);
    if (report_.contact) text << ", points of contact " << *report_.contact;
    if (report_.theory) {
      text << ", theory " << *report_.theory
           << (asked_theory_ == Theory::kAuto ? "" : " (not counted: the scene asks for it)");
    }
  }
  if (!why.empty()) text << "; " << why;
  report_.message = text.str();
  SolverSummary& summary = answer->summary;
  summary.decisions.insert(summary.decisions.end(), decisions_.begin(), decisions_.end());
  summary.decisions.push_back(report_.message);
  if (!theory_reason_.empty()) summary.theory_reason = theory_reason_;
  summary.setup_s = setup_s_;
  summary.solve_s = solve_s_;
}

bool AccuracyLoop::Run(Answer* answer, std::string* error) {
  SurfaceSpec& surface = scene_.surface;
  own_surface_ = surface;
  proportion_ = static_cast<double>(surface.divisions[0]) / surface.divisions[1];
  cells_ = std::min(kFirstCells, static_cast<double>(surface.divisions[0]) * surface.divisions[1]);
  if (IsLattice()) {
    FindMultiples();
    surface.divisions = Divisions();
  } else if (const std::string line = MeshAdaptation::Begin(scene_.shell.thickness, &surface);
             !line.empty()) {
    Decide(line);
  }
  const bool chooses_theory = asked_theory_ == Theory::kAuto && !HasOutsideForces() &&
                              scene_.path.control == PathControl::kLoad;
  if (chooses_theory) scene_.model.theory = Theory::kLinear;

  Clock::time_point level_start = Clock::now();
  const Outcome outcome = FirstAnswer(answer, error);
  if (outcome != Outcome::kContinue) return outcome == Outcome::kDone;
  if (!ChooseTheory(answer, error)) return false;
  if (!answer->summary.IsConverged()) {
    Finish("the first level did not converge: " + answer->summary.message, answer);
    return true;
  }
  // From here on *answer has converged.
  for (int solutions = 1;;) {
    const bool first = report_.levels.empty();
    ErrorSequence sequence = sequence_;
    Estimate(*answer, &sequence);
    const bool stopped = solver_options_.stop != nullptr && solver_options_.stop->load();
    if (report_.discretisation && *report_.discretisation <= kSafety * report_.target && !stopped &&
        ChoosesContact() && !report_.contact) {
      ChooseContact(answer, Since(level_start), &solutions);
    }
    if (report_.discretisation && *report_.discretisation <= report_.target) {
      report_.solver = SolverError(answer);
    }
    report_.estimate = Total();
    report_.reached = IsReached(*answer);
    const bool enough = report_.reached && *report_.estimate <= kSafety * report_.target;
    // As many cells, better placed?
    const int most = first ? kFirstSolutions : kSolutions;
    const bool improved = !enough && !stopped && ImproveLattice(answer);
    if (improved && solutions < most) {
      Answer next;
      std::string failure;
      if (SolveOnce(&next, &failure) && next.summary.IsConverged() &&
          (first || next.summary.elements > report_.levels.back().elements)) {
        *answer = std::move(next);
        ++solutions;
        continue;
      }
    }
    AccuracyLevel level;
    const SurfaceSpec& solved = answer->problem->scene().surface;
    if (IsLattice()) level.divisions = solved.divisions;
    level.dof = answer->summary.dof;
    level.elements = answer->summary.elements;
    level.quadrature = scene_.model.quadrature;
    level.theory = answer->summary.theory;
    level.solutions = solutions;
    level.estimate = report_.discretisation;
    level.seconds = Since(level_start);
    if (first) first_surface_ = solved;
    before_ = sequence_;
    sequence_ = sequence;
    report_.levels.push_back(level);
    if (options_.on_level) options_.on_level(level);
    if (enough) {
      Finish("", answer);
      return true;
    }
    if (stopped) {
      Finish("stopped by the user", answer);
      return true;
    }

    double growth = kUnknownGrowth, least = kLeastGrowth;
    if (sequence_.Order() && IsResolved(*answer)) {
      const double room = kSafety * report_.target -
                          (asked_theory_ == Theory::kAuto ? report_.theory.value_or(0.0) : 0.0);
      const double lacks = *report_.discretisation / std::max(room, 0.1 * report_.target);
      growth = std::min(std::pow(lacks, 1.0 / *sequence_.Order()), kMostGrowth);
      // Grow compares answers of meshes that hardly differ with the one before.
      if (before_.num_levels() >= 2) least = kSmallGrowth;
    }
    growth = std::max(growth, least);
    if (IsLattice() && report_.levels.size() == 2) {
      ChooseQuadrature(*answer, *report_.discretisation);
    }
    std::string why;
    level_start = Clock::now();
    const double seconds = level.seconds / level.solutions;
    if (!(IsLattice() ? Grow(growth, least, seconds, &why) : RefineMesh(*answer, seconds, &why))) {
      if (ChoosesContact() && !report_.contact) {
        int& solved = report_.levels.back().solutions;
        ChooseContact(answer, seconds, &solved);
        report_.levels.back().seconds += Since(level_start);
        report_.estimate = Total();
        report_.reached = IsReached(*answer);
      }
      Finish(why, answer);
      return true;
    }
    if (!NextAnswer(answer, &why)) {
      Finish(why, answer);
      return true;
    }
    solutions = 1;
  }
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
  AccuracyLoop loop(scene, solver_options, options, report);
  Answer answer;
  if (!loop.Run(&answer, error)) return false;
  *problem = std::move(answer.problem);
  *summary = std::move(answer.summary);
  return true;
}

}  // namespace darboux
