#include "solver/load_stepping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace darboux {
namespace {

// Iterations after which a load step is cut. States that are found at all take fewer; strips wound
// up by edge moments take the most.
constexpr int kMaxIterations = 40;
// A cut step is this part of the one that failed, and the smallest this part of the whole.
constexpr double kCut = 0.25;
constexpr double kSmallestStep = 1.0 / 300.0;
// Steps that take no more iterations than this grow.
constexpr int kFewIterations = 8;
// States between fingers without friction that are only passed on the way to one asked for: their
// gradient in tolerances, and the iterations that then are few. Looser than 1e-6 a duck went
// astray.
constexpr double kPassing = 10.0;
constexpr int kFewPassing = 6;

}  // namespace

LoadStepping::LoadStepping(ShellProblem* problem,
                           const SolverOptions& options,
                           const Deadline& deadline,
                           std::vector<std::string>* decisions)
    : problem_(problem),
      options_(options),
      deadline_(deadline),
      decisions_(decisions),
      mixed_(std::make_unique<MixedIteration>(problem, options.backend, options.num_threads)) {
  problem_->SetLoadFactor(0.0);
  if (problem->grasp() != nullptr) {
    quality_ = std::make_unique<GraspQuality>(problem, options.backend);
    // Gas makes it touch first, see AdvanceMixed.
    if (!problem->has_gas()) quality_->Record(&mixed_->tangent(), false);
  }
  good_ = Present();
}

void LoadStepping::Accept(bool is_result) {
  good_ = Present();
  if (quality_ != nullptr) quality_->Record(&mixed_->tangent(), is_result);
}

LoadStepping::State LoadStepping::Present() const {
  return {problem_->load_factor(),
          problem_->displacements(),
          problem_->multipliers(),
          mixed_->stresses(),
          problem_->grasp() != nullptr ? problem_->grasp()->state() : Grasp::State()};
}

void LoadStepping::Restore(const State& state) {
  problem_->SetLoadFactor(state.factor);
  problem_->displacements() = state.displacements;
  problem_->SetMultipliers(state.multipliers);
  mixed_->stresses() = state.stresses;
  if (problem_->grasp() != nullptr) problem_->grasp()->SetState(state.grasp);
}

void LoadStepping::SettleGrasp(const MixedIteration::Options& options,
                               bool fine,
                               MixedIteration::Summary* summary) {
  Grasp* const grasp = problem_->grasp();
  const auto again = [&](MixedIteration::Options again_options, bool polish = false) {
    again_options.has_factor = true;
    again_options.polish = polish;
    const MixedIteration::Summary more = mixed_->Solve(again_options);
    summary->iterations += more.iterations;
    summary->chords += more.chords;
    summary->chord_s += more.chord_s;
    summary->iteration_s += more.iteration_s;
    summary->factorisations += more.factorisations;
    summary->limited += more.limited;
    summary->scaled += more.scaled;
    summary->converged = more.converged;
    summary->stopped = more.stopped;
    summary->message = more.message;
    summary->relative_gradient = more.relative_gradient;
  };
  constexpr int kMaxUpdates = 12;
  for (int update = 0; summary->converged && grasp->Update(false); ++update) {
    if (update == kMaxUpdates) {
      summary->converged = false;
      summary->message = "contact and friction do not settle";
      break;
    }
    again(options);
  }
  grasp->Settle();
  if (!summary->converged) return;
  summary->message = grasp->Fault();
  summary->converged = summary->message.empty();
  if (!fine || !summary->converged) return;
  // The last digits. Where contact points come and go with a penalty that grows fast it grows more
  // slowly, or not at all.
  constexpr int kMaxFineUpdates = 6;
  constexpr double kStiffer[] = {100.0, 10.0, 1.0};
  // Stiff contact has much rounding in it.
  constexpr double kFineGradient = 1e-9;
  MixedIteration::Options few = options;
  few.max_iterations = std::min(options.max_iterations, kFewIterations);
  few.gradient_tolerance = std::max(options.gradient_tolerance, kFineGradient);
  const State coarse = Present();
  State finest = coarse;
  const MixedIteration::Summary before = *summary;
  // Those that end well are nearer after two iterations.
  constexpr int kHopeless = 3;
  int evaluations = 0;
  double first = 0.0, last = 0.0;
  few.on_iteration = [&](int iteration, double energy, double relative_gradient) {
    if (evaluations++ == 0) first = relative_gradient;
    last = relative_gradient;
    if (options.on_iteration) options.on_iteration(iteration, energy, relative_gradient);
  };
  few.stop = [&] {
    return (evaluations >= kHopeless && last > first) || (options.stop && options.stop());
  };
  for (const double stiffer : kStiffer) {
    bool settles = true;
    for (int update = 0; update < kMaxFineUpdates && grasp->Update(true, stiffer); ++update) {
      evaluations = 0;
      again(few, true);
      settles = summary->converged;
      if (!settles) break;
      finest = Present();
    }
    Restore(finest);
    summary->stopped = options.stop && options.stop();
    if (settles || summary->stopped) break;
  }
  few.on_iteration = options.on_iteration;
  few.stop = options.stop;
  grasp->Settle();
  few.gradient_tolerance = options.gradient_tolerance;
  again(few, true);
  if (summary->converged && grasp->Fault().empty()) return;
  Restore(coarse);
  summary->converged = true;
  summary->message.clear();
  summary->relative_gradient = before.relative_gradient;
}

MixedIteration::Options LoadStepping::MixedOptions() const {
  MixedIteration::Options options;
  options.max_iterations = std::min(kMaxIterations, options_.max_iterations);
  options.gradient_tolerance = options_.gradient_tolerance;
  options.polish = problem_->grasp() == nullptr;  // SettleGrasp goes on
  options.stop = [this] { return deadline_.Stopped() || deadline_.TimedOut(); };
  if (deadline_.log != nullptr) {
    options.on_iteration = [this](int iteration, double energy, double relative_gradient) {
      deadline_.log->Record(IterationReport::Method::kMixed,
                            problem_->load_factor(),
                            iteration,
                            energy,
                            relative_gradient);
    };
  }
  return options;
}

void LoadStepping::CountChords(const MixedIteration::Summary& summary) {
  chords_ += summary.chords;
  if (summary.iterations == 0) return;
  const double gain = summary.iteration_s / summary.iterations * summary.chords - summary.chord_s;
  saved_s_ += std::max(0.0, gain);
}

bool LoadStepping::AdvanceMixed(double target, Result* result) {
  const MixedIteration::Options options = MixedOptions();
  Grasp* const grasp = problem_->grasp();
  if (problem_->has_gas() && good_.factor == 0.0) {
    Restore(good_);
    MixedIteration::Summary summary = mixed_->Inflate(options);
    if (summary.converged && grasp != nullptr) SettleGrasp(options, false, &summary);
    result->iterations += summary.iterations;
    if (summary.iterations > 0) {
      std::ostringstream line;
      line << "gas fills the shell: " << summary.iterations << " iterations, "
           << summary.factorisations << " factorisations";
      Note(line.str());
    }
    if (!summary.converged) {
      result->message = summary.message;
      if (summary.stopped && deadline_.Stopped()) result->message = "stopped by the user";
      if (summary.stopped && deadline_.TimedOut()) result->message = "time limit reached";
      return false;
    }
    if (grasp != nullptr) grasp->Advance();
    Accept();
  }
  const double whole = target - good_.factor;
  double step = whole;
  const double largest =
      grasp != nullptr ? grasp->LargestStep() : std::numeric_limits<double>::infinity();
  // The first touch is the hardest.
  constexpr double kFirst = 0.25;
  if (grasp != nullptr && good_.factor == 0.0) {
    step = std::copysign(std::min(std::abs(whole), kFirst * largest), whole);
  }
  while (good_.factor != target) {
    if (std::abs(step) > largest) step = std::copysign(largest, step);
    const bool last = std::abs(target - good_.factor) <= std::abs(step) * (1.0 + 1e-9);
    const double factor = last ? target : good_.factor + step;
    Restore(good_);
    problem_->SetLoadFactor(factor);
    if (grasp != nullptr && before_good_.displacements.size() > 0) {
      // As far as the last step went, in proportion.
      const double part = (factor - good_.factor) / (good_.factor - before_good_.factor);
      problem_->displacements() += part * (good_.displacements - before_good_.displacements);
      mixed_->SetStresses();
    }
    // What friction does depends on the way, and limit points are looked for between good states.
    const bool passes = grasp != nullptr && !last && !problem_->effect(Effect::kFriction).on &&
                        !grasp->has_unknown_travels();
    MixedIteration::Options to = options;
    if (passes) to.gradient_tolerance *= kPassing;
    MixedIteration::Summary summary = mixed_->Solve(to);
    if (grasp != nullptr) SettleGrasp(to, last, &summary);
    if (summary.converged && grasp != nullptr && grasp->has_unknown_travels()) {
      LookForSnap(options, &summary);
    }
    result->iterations += summary.iterations;
    CountChords(summary);
    std::ostringstream line;
    line << "mixed iteration to load factor " << factor << ": " << summary.iterations
         << " iterations, " << summary.factorisations << " factorisations";
    if (summary.chords > 0) line << ", " << summary.chords << " steps with a factor at hand";
    if (summary.limited > 0) line << ", " << summary.limited << " steps limited";
    if (summary.scaled > 0) line << ", " << summary.scaled << " with scaled stress";
    if (!summary.converged) line << "; " << summary.message;
    Note(line.str());
    if (summary.stopped) {
      result->message = deadline_.Stopped() ? "stopped by the user" : "time limit reached";
      return false;
    }
    if (summary.converged) {
      problem_->SetAngleReferences();
      if (grasp != nullptr) {
        grasp->Advance();
        before_good_ = good_;
      }
      Accept(last);
      good_.travel_rate = travel_rate_;
      const int few = passes ? kFewPassing : kFewIterations;
      if (summary.iterations + summary.chords <= few) step *= 2.0;
      continue;
    }
    step *= kCut;
    if (std::abs(step) < kSmallestStep * std::abs(whole)) {
      result->message = summary.message;
      return false;
    }
  }
  return true;
}

double LoadStepping::DrivenTravel(const State& state) const {
  const std::vector<double>& travels = state.grasp.travels;
  return problem_->grasp()->DrivingForces().dot(
      Eigen::Map<const Eigen::VectorXd>(travels.data(), travels.size()));
}

double LoadStepping::DrivenTravelRate() {
  constexpr double kUnstable = std::numeric_limits<double>::infinity();
  if (mixed_->FactorizeHessian() != 0) return kUnstable;
  const Eigen::VectorXd forces = problem_->grasp()->DrivingForces();
  const double factor = problem_->load_factor();
  Eigen::Matrix3Xd dead = problem_->DeadForce();
  if (factor != 0.0) dead /= factor;
  const double rate = forces.dot(mixed_->TravelRates(forces, dead));
  return rate >= 0.0 ? rate : kUnstable;
}

void LoadStepping::LookForSnap(const MixedIteration::Options& options,
                               MixedIteration::Summary* summary) {
  // A travel whose rate goes up or down all the way from one state to the next grows by no more
  // than the larger rate has it. The rest is for rates that do both.
  constexpr double kMore = 1.2;
  // Of the load factor of a limit point, relative.
  constexpr double kResolution = 2e-3;
  const auto leaps = [&](const State& from, const State& to) {
    const double rate = std::max(from.travel_rate, to.travel_rate);
    return DrivenTravel(to) - DrivenTravel(from) > kMore * rate * (to.factor - from.factor);
  };
  const auto find = [&](const State& from, double factor, State* state) {
    Restore(from);
    problem_->SetLoadFactor(factor);
    MixedIteration::Summary one = mixed_->Solve(options);
    if (one.converged) SettleGrasp(options, false, &one);
    summary->iterations += one.iterations;
    summary->chords += one.chords;
    summary->chord_s += one.chord_s;
    summary->iteration_s += one.iteration_s;
    summary->factorisations += one.factorisations;
    *state = Present();
    state->travel_rate = DrivenTravelRate();
    return one.converged;
  };
  const State target = Present();
  travel_rate_ = DrivenTravelRate();
  State low = good_, high = target;
  high.travel_rate = travel_rate_;
  if (low.travel_rate < 0.0 && leaps(low, high)) {
    // Without load nothing touches, so that there is no rate.
    for (const double little : {2e-2, 4e-4}) {
      State first;
      if (!find(low, low.factor + little * (high.factor - low.factor), &first)) continue;
      low = first;
      break;
    }
  }
  while (low.travel_rate >= 0.0 && leaps(low, high) &&
         high.factor - low.factor > kResolution * std::abs(high.factor)) {
    const double factor = 0.5 * (low.factor + high.factor);
    State between;
    const bool found = find(low, factor, &between);
    if (found && !leaps(low, between)) {
      low = between;
    } else if (found) {
      high = between;
    } else {
      high.factor = factor;  // Nothing is known of it but that the path ends before.
    }
  }
  if (low.travel_rate >= 0.0 && leaps(low, high)) {
    Restore(low);
    std::ostringstream line;
    line << "the fingers' forces have a limit point at load factor " << low.factor;
    for (const FingerReport& finger : problem_->grasp()->Report(problem_->force_unit())) {
      if (!finger.by_force) continue;
      line << ", finger " << finger.name << " with force " << finger.force.norm() << " at travel "
           << finger.travel;
    }
    line << ": there the shell gives way, and this state lies behind; fingers driven by travel "
            "follow the path";
    Note(line.str());
    limit_factor_ = low.factor;
  }
  Restore(target);
}

bool LoadStepping::AdvanceFromStart(double factor, Result* result) {
  const auto energy = [this] {
    double total = 0.0;
    for (int e = 0; e < kNumEffects; ++e) total += problem_->Energy(static_cast<Effect>(e));
    return total;
  };
  const State rest = good_;
  problem_->SetLoadFactor(factor);
  const double undeformed = energy();
  problem_->displacements() = start_;
  MixedIteration::Options options = MixedOptions();
  Grasp* const grasp = problem_->grasp();
  if (grasp != nullptr) {
    // Near the answer, or it is faster to come from rest.
    mixed_->SetStresses();
    options.max_iterations = std::min(options.max_iterations, kFewIterations);
    Grasp::State contact = grasp->state();
    if (start_contact_.size() == contact.multipliers.size()) {
      contact.multipliers = start_contact_;
      grasp->SetState(contact);
    }
  }
  MixedIteration::Summary summary = mixed_->Solve(options);
  if (grasp != nullptr) SettleGrasp(options, true, &summary);
  result->iterations += summary.iterations;
  CountChords(summary);
  std::ostringstream line;
  line << "from the given start: " << summary.iterations << " iterations, ";
  const double found = energy();
  const int negative_modes = summary.converged ? mixed_->FactorizeHessian() : -1;
  // Undeformed, the shell would be inside of the fingers: its energy says nothing.
  const bool accepted =
      summary.converged && negative_modes == 0 && (grasp != nullptr || found <= undeformed);
  if (!summary.converged) {
    line << summary.message << "; from rest instead";
  } else if (!accepted) {
    line << "another equilibrium, of energy " << found << " with " << negative_modes
         << " negative modes (undeformed: " << undeformed << "); from rest instead";
  } else {
    line << "energy " << found;
  }
  Note(line.str());
  if (accepted) {
    if (grasp != nullptr) grasp->Advance();
    Accept();
  } else {
    Restore(rest);
  }
  return accepted;
}

LoadStepping::Result LoadStepping::LeaveUnstable(const Eigen::Matrix3Xd& mode) {
  const State unstable = good_;
  // Within the range of the quadratic model, far beyond its rounding.
  const double push = 0.1 * problem_->material().thickness;
  Result best;
  double lowest = std::numeric_limits<double>::infinity();
  int iterations = 0;
  for (const double sign : {1.0, -1.0}) {
    Restore(unstable);
    problem_->displacements() += sign * push * mode;
    Result result;
    result.converged = Descend(
        problem_, options_, deadline_, &result.iterations, &result.equilibrium, &result.message);
    iterations += result.iterations;
    double energy = 0.0;
    for (int e = 0; e < kNumEffects; ++e) energy += problem_->Energy(static_cast<Effect>(e));
    std::ostringstream line;
    line << "left an unstable state " << (sign > 0.0 ? "along" : "against")
         << " its mode: " << result.iterations << " iterations, energy " << energy;
    Note(line.str());
    // Two branches of one energy are mirror images: the first is as good as the second.
    const bool lower = energy < lowest - 1e-9 * std::abs(energy);
    if (!std::isfinite(lowest) || (result.converged && (!best.converged || lower))) {
      best = result;
      lowest = energy;
      mixed_->SetStresses();
      Accept();
    }
  }
  Restore(good_);
  mixed_->SetStresses();
  best.iterations = iterations;
  return best;
}

void LoadStepping::DescendAndSettle(Result* result) {
  Grasp* const grasp = problem_->grasp();
  const auto descend = [&] {
    int used = 0;
    result->converged =
        Descend(problem_, options_, deadline_, &used, &result->equilibrium, &result->message);
    result->iterations += used;
  };
  if (grasp == nullptr) return descend();
  result->converged = grasp->Close(&result->message);
  if (result->converged) descend();
  constexpr int kMaxUpdates = 30;
  for (int update = 0; result->converged && grasp->Update(false); ++update) {
    descend();
    if (update == kMaxUpdates && result->converged) {
      result->converged = false;
      result->message = "contact and friction do not settle";
    }
  }
  grasp->Settle();
  if (!result->converged) return;
  result->message = grasp->Fault();
  result->converged = result->message.empty();
}

// Gas before loads, as MixedIteration::Inflate.
bool LoadStepping::FillByDescent(Result* result) {
  for (const int parts : {1, 4, 16}) {
    Restore(good_);
    result->converged = true;
    for (int part = 1; part <= parts && result->converged; ++part) {
      problem_->SetGasCharge(static_cast<double>(part) / parts);
      int used = 0;
      result->converged =
          Descend(problem_, options_, deadline_, &used, &result->equilibrium, &result->message);
      result->iterations += used;
    }
    problem_->SetGasCharge(1.0);
    if (result->converged || deadline_.Stopped() || deadline_.TimedOut()) break;
  }
  if (result->iterations > 0) {
    Note("gas fills the shell: " + std::to_string(result->iterations) + " iterations");
  }
  if (result->converged) Accept();
  return result->converged;
}

LoadStepping::Result LoadStepping::AdvanceByDescent(double factor) {
  Result result;
  if (problem_->has_gas() && good_.factor == 0.0 && (!FillByDescent(&result) || factor == 0.0)) {
    return result;
  }
  const double from = good_.factor;
  // What the first attempt, straight to the asked load, ended with.
  State direct;
  std::string direct_message;
  // Straight to the asked load; where that fails, in 5, then 20 parts from the last good state.
  Grasp* const grasp = problem_->grasp();
  const int least =
      grasp == nullptr
          ? 1
          : std::max(1, static_cast<int>(std::ceil((factor - from) / grasp->LargestStep())));
  for (const int times : {1, 5, 20}) {
    const int parts = times * least;
    Restore(good_);
    result.converged = true;
    const double begin = good_.factor;
    for (int part = 1; part <= parts && result.converged; ++part) {
      const double next = begin + (factor - begin) * part / parts;
      problem_->SetLoadFactor(next);
      if (good_.factor == 0.0 && linear_displacements_.size() > 0) {
        std::vector<double> multipliers = linear_multipliers_;
        for (double& multiplier : multipliers) multiplier *= next;
        problem_->SetMultipliers(multipliers);
        const double multiple = StartFromLinear(next * linear_displacements_, problem_);
        std::ostringstream line;
        line << "start: " << multiple << " of the linear solution at load factor " << next;
        Note(line.str());
      }
      DescendAndSettle(&result);
      if (grasp != nullptr && result.converged) grasp->Advance();
      if (result.converged) Accept();
    }
    if (times == 1) {
      direct = Present();
      direct_message = result.message;
    }
    // Smaller steps do not help where equilibrium is reached but for the last digits.
    constexpr double kNearly = 100.0;
    if (result.converged || deadline_.Stopped() || deadline_.TimedOut() ||
        (times == 1 &&
         result.equilibrium.relative_gradient <= kNearly * options_.gradient_tolerance)) {
      break;
    }
    if (times < 20) {
      std::ostringstream line;
      line << "load factor " << factor << " not reached in " << parts
           << (parts == 1 ? " step (" : " steps (") << result.message << "): cut";
      Note(line.str());
    }
  }
  if (result.converged) return result;
  // The last good state; where there is none, what the first attempt came to.
  if (good_.factor > from) {
    Restore(good_);
    std::ostringstream text;
    text << result.message << "; the results are the last good state, at load factor "
         << good_.factor;
    result.message = text.str();
  } else {
    Restore(direct);
    result.message = direct_message;
  }
  result.equilibrium = CheckEquilibrium(problem_);
  return result;
}

LoadStepping::Result LoadStepping::AdvanceByConjugateGradients(double factor) {
  Result result;
  problem_->SetLoadFactor(factor);
  if (problem_->grasp() != nullptr && !problem_->grasp()->Close(&result.message)) return result;
  if (good_.factor == 0.0) {
    const double height = StartFromCones(problem_);
    std::ostringstream line;
    line << "conical start of height " << height << " around each point load";
    Note(line.str());
  }
  result.converged = DescendByConjugateGradients(
      problem_, options_, deadline_, &result.iterations, &result.equilibrium, &result.message);
  std::ostringstream line;
  line << "conjugate gradients: " << result.iterations << " iterations";
  Note(line.str());
  Accept();
  return result;
}

LoadStepping::Result LoadStepping::Advance(double factor) {
  limit_factor_.reset();
  const Minimizer minimizer = problem_->scene().model.minimizer;
  if (minimizer == Minimizer::kCeres) return AdvanceByDescent(factor);
  if (minimizer == Minimizer::kCg) return AdvanceByConjugateGradients(factor);
  Result result;
  const double from = good_.factor;
  const bool given = start_.size() > 0 && from == 0.0 && AdvanceFromStart(factor, &result);
  const bool reached = given || AdvanceMixed(factor, &result);
  const bool out_of_time = deadline_.Stopped() || deadline_.TimedOut();
  Restore(good_);
  if (reached || (!out_of_time && minimizer == Minimizer::kAuto)) {
    if (!reached) {
      std::ostringstream line;
      line << "descent from load factor " << good_.factor << " to " << factor;
      Note(line.str());
      problem_->SetLoadFactor(factor);
    }
    if (problem_->NeedsCorrection()) problem_->UpdateCorrection();
    result.equilibrium = CheckEquilibrium(problem_);
    const double floor = options_.gradient_tolerance < result.equilibrium.relative_gradient
                             ? RoundingFloor(problem_, result.equilibrium.reference)
                             : 0.0;
    result.converged = reached && result.equilibrium.relative_gradient <=
                                      std::max(options_.gradient_tolerance, kRoundings * floor);
    if (!result.converged) {
      const int before = result.iterations;
      DescendAndSettle(&result);
      std::ostringstream line;
      line << "Ceres: " << result.iterations - before << " iterations, relative gradient "
           << result.equilibrium.relative_gradient;
      Note(line.str());
      if (!reached && result.converged && problem_->grasp() != nullptr &&
          problem_->grasp()->has_unknown_travels()) {
        MixedIteration::Summary summary;
        mixed_->SetStresses();
        LookForSnap(MixedOptions(), &summary);
        result.iterations += summary.iterations;
      }
    }
    if (result.converged) {
      mixed_->SetStresses();
      Accept();
      return result;
    }
    if (good_.factor == 0.0) return result;  // Nothing better to go back to.
  }
  Restore(good_);
  if (problem_->NeedsCorrection()) problem_->UpdateCorrection();
  result.equilibrium = CheckEquilibrium(problem_);
  if (good_.factor > from) {
    std::ostringstream text;
    text << result.message << "; the results are the last good state, at load factor "
         << good_.factor;
    if (problem_->grasp() != nullptr && problem_->grasp()->has_unknown_travels()) {
      text << "; the fingers' forces may have a limit point there, fingers driven by travel would "
              "go on";
    }
    result.message = text.str();
  }
  return result;
}

}  // namespace darboux
