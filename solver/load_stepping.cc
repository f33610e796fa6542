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
  good_ = Present();
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
                               MixedIteration::Summary* summary) {
  Grasp* const grasp = problem_->grasp();
  constexpr int kMaxUpdates = 12;
  for (int update = 0; summary->converged && grasp->Update(); ++update) {
    if (update == kMaxUpdates) {
      summary->converged = false;
      summary->message = "contact and friction do not settle";
      return;
    }
    const MixedIteration::Summary more = mixed_->Solve(options);
    summary->iterations += more.iterations;
    summary->factorisations += more.factorisations;
    summary->limited += more.limited;
    summary->scaled += more.scaled;
    summary->converged = more.converged;
    summary->stopped = more.stopped;
    summary->message = more.message;
    summary->relative_gradient = more.relative_gradient;
  }
  if (!summary->converged) return;
  summary->message = grasp->Fault();
  summary->converged = summary->message.empty();
}

bool LoadStepping::AdvanceMixed(double target, Result* result) {
  MixedIteration::Options options;
  options.max_iterations = std::min(kMaxIterations, options_.max_iterations);
  options.gradient_tolerance = options_.gradient_tolerance;
  options.stop = [this] { return deadline_.Stopped() || deadline_.TimedOut(); };
  Grasp* const grasp = problem_->grasp();
  if (problem_->has_gas() && good_.factor == 0.0) {
    Restore(good_);
    MixedIteration::Summary summary = mixed_->Inflate(options);
    if (summary.converged && grasp != nullptr) SettleGrasp(options, &summary);
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
    good_ = Present();
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
    MixedIteration::Summary summary = mixed_->Solve(options);
    if (grasp != nullptr) SettleGrasp(options, &summary);
    result->iterations += summary.iterations;
    std::ostringstream line;
    line << "mixed iteration to load factor " << factor << ": " << summary.iterations
         << " iterations, " << summary.factorisations << " factorisations";
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
      good_ = Present();
      if (summary.iterations <= kFewIterations) step *= 2.0;
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
  MixedIteration::Options options;
  options.max_iterations = std::min(kMaxIterations, options_.max_iterations);
  options.gradient_tolerance = options_.gradient_tolerance;
  options.stop = [this] { return deadline_.Stopped() || deadline_.TimedOut(); };
  const MixedIteration::Summary summary = mixed_->Solve(options);
  result->iterations += summary.iterations;
  std::ostringstream line;
  line << "from the given start: " << summary.iterations << " iterations, ";
  const double found = energy();
  const int negative_modes = summary.converged ? mixed_->FactorizeHessian() : -1;
  const bool accepted = summary.converged && negative_modes == 0 && found <= undeformed;
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
    good_ = Present();
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
      good_ = Present();
    }
  }
  Restore(good_);
  mixed_->SetStresses();
  best.iterations = iterations;
  return best;
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
  if (result->converged) good_ = Present();
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
      int used = 0;
      result.converged =
          Descend(problem_, options_, deadline_, &used, &result.equilibrium, &result.message);
      result.iterations += used;
      // Multipliers of contact and lagged friction.
      constexpr int kMaxUpdates = 30;
      for (int update = 0; grasp != nullptr && result.converged && grasp->Update(); ++update) {
        result.converged =
            update < kMaxUpdates &&
            Descend(problem_, options_, deadline_, &used, &result.equilibrium, &result.message);
        result.iterations += used;
      }
      if (grasp != nullptr && result.converged) {
        result.message = grasp->Fault();
        result.converged = result.message.empty();
        if (result.converged) grasp->Advance();
      }
      if (result.converged) good_ = Present();
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
  good_ = Present();
  return result;
}

LoadStepping::Result LoadStepping::Advance(double factor) {
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
      int used = 0;
      result.converged =
          Descend(problem_, options_, deadline_, &used, &result.equilibrium, &result.message);
      result.iterations += used;
      std::ostringstream line;
      line << "Ceres: " << used << " iterations, relative gradient "
           << result.equilibrium.relative_gradient;
      Note(line.str());
    }
    if (result.converged) {
      mixed_->SetStresses();
      good_ = Present();
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
    result.message = text.str();
  }
  return result;
}

}  // namespace darboux
