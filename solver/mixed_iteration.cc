#include "solver/mixed_iteration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include "solver/minimisation.h"

namespace darboux {
namespace {

// Largest rotation of the surface in one step, rad, as its linear displacements have it, and of the
// step's second order against it. Between 0.85 and 1.1 rad and between 0.65 and 1 a strip that an
// edge moment winds to a circle took 11 to 18 iterations, two circles 23 to 36, a slit annulus 10
// to 16, an open hemisphere 6 to 8; steps without second order 14 to 36, 37, 8 to 14 and 10 to 19.
constexpr double kMaxRotation = 1.0;
constexpr double kMaxBend = 0.75;

// A step that reduces the gradient to this part or less, and turns the surface by no more than this
// (rad), is followed by a chord.
constexpr double kChord = 0.1;
constexpr double kChordRotation = 5e-3;
// Of the tolerance.
constexpr double kPolished = 1e-3;

// Sticking is as sharp as it should be again, however a solve ends.
struct StickGuard {
  Grasp* grasp;
  ~StickGuard() {
    if (grasp != nullptr) grasp->SetStickFactor(1.0);
  }
};

}  // namespace

MixedIteration::MixedIteration(ShellProblem* problem, SparseBackend backend, int num_threads)
    : problem_(problem),
      tangent_(problem, backend, num_threads),
      cholesky_(std::make_unique<UpdatedCholesky>(SparseCholesky::Create(backend))),
      stresses_(tangent_.num_points(), TangentStiffness::Stress::Zero()) {
  cholesky_->SetUpdate(tangent_.update_vectors(), tangent_.update_weights());
}

bool MixedIteration::SetStresses() {
  TangentStiffness::Request request;
  request.stresses = &stresses_;
  return tangent_.Evaluate(request);
}

double MixedIteration::RelativeGradient(const Eigen::VectorXd& gradient) const {
  const double scale = tangent_.ForceScale();
  const double size = gradient.norm();
  return scale > 0.0 ? size / scale : size;
}

bool MixedIteration::IsBalanced(const Eigen::VectorXd& gradient,
                                double relative_gradient,
                                double previous,
                                double tolerance) {
  if (relative_gradient <= tolerance) return true;
  // Gradients rise and fall on the way; only small ones that stay tell of rounding.
  constexpr double kSmall = 1e-5, kStays = 0.3;
  return relative_gradient > kStays * previous && relative_gradient <= kSmall &&
         relative_gradient <= kRoundings * RoundingFloor(gradient);
}

double MixedIteration::RoundingFloor(const Eigen::VectorXd& gradient) {
  std::mt19937 generator(20417);
  const Eigen::Matrix3Xd state = problem_->displacements();
  problem_->displacements() = state.unaryExpr([&](double x) {
    const double unit = std::numeric_limits<double>::epsilon();
    return (generator() & 1) != 0 ? x * (1.0 + unit) : x * (1.0 - unit);
  });
  Eigen::VectorXd moved;
  TangentStiffness::Request request;
  request.gradient = &moved;
  const bool defined = tangent_.Evaluate(request);
  problem_->displacements() = state;
  return defined ? RelativeGradient(moved - gradient) : 0.0;
}

void MixedIteration::SettleSupports() {
  // Each pass costs a pair of triangular solves and gains the ratio of the springs to the shell.
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::Matrix3Xd before = problem_->SupportGradient();
    problem_->UpdateMultipliers();
    const Eigen::VectorXd change = tangent_.Reduce(problem_->SupportGradient() - before);
    problem_->displacements() -= tangent_.Expand(cholesky_->Solve(change));
  }
  problem_->UpdateMultipliers();
}

bool MixedIteration::FactorizePositive(double part_of_means) {
  has_factor_ = false;
  if (!analysed_) cholesky_->Analyze(tangent_.matrix());
  analysed_ = true;
  if (problem_->has_gas() || problem_->grasp() != nullptr) {
    cholesky_->SetUpdate(tangent_.update_vectors(), tangent_.UpdateWeights(part_of_means));
  }
  return cholesky_->Factorize(tangent_.matrix());
}

int MixedIteration::Factorize() {
  if (FactorizePositive()) return 0;
  return cholesky_->FactorizeIndefinite(tangent_.matrix());
}

int MixedIteration::FactorizeHessian() {
  if (!SetStresses()) return -1;
  TangentStiffness::Request request;
  request.matrix = true;
  request.initial_stresses = &stresses_;
  return tangent_.Evaluate(request) ? Factorize() : -1;
}

Eigen::VectorXd MixedIteration::TravelRates(const Eigen::VectorXd& force_rates,
                                            const Eigen::Matrix3Xd& dead_force) {
  const Eigen::VectorXd step =
      cholesky_->Solve(tangent_.travel_forces() * force_rates + tangent_.Reduce(dead_force));
  return tangent_.TravelChanges(step) + tangent_.travel_compliances().cwiseProduct(force_rates);
}

MixedIteration::Summary MixedIteration::Inflate(const Options& options) {
  // Steps of the charge are cut to this part of one that fails, down to the smallest.
  constexpr double kCut = 0.25, kSmallest = 1.0 / 300.0;
  Summary summary;
  summary.converged = true;
  if (!problem_->has_gas()) return summary;
  if (!problem_->displacements().isZero(0.0)) SetStresses();  // full already
  double reached = 0.0, step = 1.0;
  while (reached < 1.0) {
    const Eigen::Matrix3Xd displacements = problem_->displacements();
    const std::vector<double> multipliers = problem_->multipliers();
    const TangentStiffness::StressField stresses = stresses_;
    const double part = std::min(1.0, reached + step);
    problem_->SetGasCharge(part);
    const Summary one = Solve(options);
    summary.iterations += one.iterations;
    summary.chords += one.chords;
    summary.chord_s += one.chord_s;
    summary.iteration_s += one.iteration_s;
    summary.factorisations += one.factorisations;
    summary.limited += one.limited;
    summary.scaled += one.scaled;
    summary.relative_gradient = one.relative_gradient;
    if (one.converged) {
      reached = part;
      continue;
    }
    problem_->displacements() = displacements;
    problem_->SetMultipliers(multipliers);
    stresses_ = stresses;
    step *= kCut;
    if (step >= kSmallest && !one.stopped) continue;
    problem_->SetGasCharge(1.0);
    summary.converged = false;
    summary.stopped = one.stopped;
    std::ostringstream text;
    text << "the gas reaches " << reached << " of its gauge pressure only: " << one.message;
    summary.message = text.str();
    return summary;
  }
  return summary;
}

bool MixedIteration::Bend(double rotation, const UnilateralStep* contact, Eigen::VectorXd* step) {
  Eigen::VectorXd defect;
  if (!tangent_.StrainDefect(*step, &defect)) return false;
  const Eigen::VectorXd bend =
      contact != nullptr ? contact->Solve(-defect) : cholesky_->Solve(-defect);
  const double size = tangent_.LargestRotation(bend);
  if (!std::isfinite(size)) return false;
  // The bend grows with the square of the step.
  const double part = size > kMaxBend * rotation ? kMaxBend * rotation / size : 1.0;
  *step = part * *step + part * part * bend;
  return part < 1.0;
}

MixedIteration::Summary MixedIteration::Solve(const Options& options) {
  Summary summary;
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin = Clock::now();
  Eigen::VectorXd gradient;
  TangentStiffness::Request first, again;  // the gradient alone: often it is all that is needed
  double energy = 0.0;
  first.gradient = &gradient;
  if (options.on_iteration) first.energy = &energy;
  again.matrix = true;
  again.initial_stresses = &stresses_;
  has_factor_ = has_factor_ && options.has_factor;
  double rotation = 0.0;  // of the last step
  // Where the last step was a chord: what it started from.
  struct Before {
    Eigen::Matrix3Xd displacements;
    std::vector<double> multipliers;
    TangentStiffness::StressField stresses;
    Grasp::State grasp;
    double relative_gradient = 0.0;
  };
  std::unique_ptr<Before> chord;
  bool polishes = false;  // balanced, but a chord may still gain
  Eigen::VectorXd step;
  // A step into a state whose strains are undefined is halved, this often at most.
  constexpr int kMaxHalvings = 10;
  int halvings = 0;
  int lagged = 0;
  Grasp* const grasp = problem_->grasp();
  // Slip that counts as sticking, relative to what it is in the end. From the first touch on it
  // starts as large as this: friction that is nearly a step of the slip throws a shell that nothing
  // else holds from one side to the other.
  constexpr double kEasiestStick = 100.0;
  double stick = 1.0;
  const StickGuard guard{grasp};
  double previous = std::numeric_limits<double>::infinity();
  while (true) {
    std::string error = "the strains are undefined";
    if (summary.iterations + summary.chords > 0) {
      const Clock::time_point now = Clock::now();
      (chord != nullptr ? summary.chord_s : summary.iteration_s) +=
          std::chrono::duration<double>(now - begin).count();
      begin = now;
    }
    bool defined = (grasp == nullptr || grasp->Close(&error)) && tangent_.Evaluate(first);
    if (chord != nullptr &&
        (!defined || !(RelativeGradient(gradient) <= kChord * chord->relative_gradient))) {
      // As if it had not been.
      problem_->displacements() = chord->displacements;
      problem_->SetMultipliers(chord->multipliers);
      stresses_ = chord->stresses;
      if (grasp != nullptr) grasp->SetState(chord->grasp);
      summary.relative_gradient = chord->relative_gradient;
      chord.reset();
      has_factor_ = false;
      --summary.chords;
      defined = (grasp == nullptr || grasp->Close(&error)) && tangent_.Evaluate(first);
      if (polishes) {
        summary.converged = true;
        return summary;
      }
    }
    const bool was_chord = chord != nullptr;
    chord.reset();
    if (!defined) {
      if (summary.iterations == 0 || halvings >= kMaxHalvings) {
        summary.message = error;
        return summary;
      }
      ++halvings;
      step *= 0.5;
      problem_->displacements() -= tangent_.Expand(step);
      continue;
    }
    halvings = 0;
    summary.relative_gradient = RelativeGradient(gradient);
    if (!std::isfinite(summary.relative_gradient)) {
      summary.message = "the iteration diverged";
      return summary;
    }
    if (stick > 1.0) {
      // Sharper as equilibrium comes nearer, but not at once.
      constexpr double kSharper = 0.25;
      stick = std::clamp(
          kEasiestStick * summary.relative_gradient, std::max(1.0, kSharper * stick), stick);
      grasp->SetStickFactor(stick);
      if (!tangent_.Evaluate(first)) {
        summary.message = "the strains are undefined";
        return summary;
      }
      summary.relative_gradient = RelativeGradient(gradient);
    }
    if (options.on_iteration) {
      options.on_iteration(summary.iterations + summary.chords,
                           problem_->force_unit() * energy,
                           summary.relative_gradient);
    }
    const double before = previous;
    previous = summary.relative_gradient;
    if (stick == 1.0 &&
        (polishes ||
         IsBalanced(gradient, summary.relative_gradient, before, options.gradient_tolerance))) {
      // A Newton step that ends below the tolerance ends far below it. Chords go on until they do.
      polishes = options.polish && was_chord && has_factor_ &&
                 summary.relative_gradient > kPolished * options.gradient_tolerance &&
                 summary.iterations + summary.chords < options.max_iterations;
      if (!polishes) {
        summary.converged = true;
        return summary;
      }
    }
    if (!polishes && options.stop && options.stop()) {
      summary.stopped = true;
      summary.message = "stopped";
      return summary;
    }
    // Farther away the fingers are not what their tangent planes are; of chords, which are short,
    // nothing is that far.
    const auto make_contact = [&](double reach, const std::vector<int>* in_matrix) {
      return std::make_unique<UnilateralStep>(*grasp, tangent_, cholesky_.get(), reach, in_matrix);
    };
    std::unique_ptr<UnilateralStep> contact;
    const bool is_last = summary.iterations + summary.chords >= options.max_iterations;
    bool is_chord = has_factor_ && stick == 1.0 && !is_last &&
                    (polishes || summary.iterations + summary.chords == 0 ||
                     (summary.relative_gradient <= kChord * before && rotation <= kChordRotation));
    if (is_chord && grasp != nullptr) {
      contact = make_contact(problem_->material().thickness, &factor_contact_);
      is_chord = contact->is_valid();
    }
    if (polishes && !is_chord) {
      summary.converged = true;
      return summary;
    }
    if (is_chord) {
      chord = std::make_unique<Before>();
      chord->displacements = problem_->displacements();
      chord->multipliers = problem_->multipliers();
      chord->stresses = stresses_;
      if (grasp != nullptr) chord->grasp = grasp->state();
      chord->relative_gradient = summary.relative_gradient;
      ++summary.chords;
    } else if (is_last) {
      std::ostringstream text;
      text << "relative gradient " << summary.relative_gradient << " after "
           << summary.iterations + summary.chords << " mixed iterations";
      summary.message = text.str();
      return summary;
    } else {
      ++summary.iterations;
    }
    bool factorised = is_chord;
    if (!is_chord) {
      ++summary.factorisations;
      again.stress_factor = 1.0;
      if (!tangent_.Evaluate(again)) {
        summary.message = error;
        return summary;
      }
    }
    double part_of_means = 1.0;
    if (is_chord) {
      // As it is.
    } else if (grasp != nullptr && !problem_->mean_conditions().empty()) {
      // What bounds the steps of a shell that fingers do not hold yet must not slow down the last;
      // but a motion that nothing resists at all needs more, or rounding decides.
      for (const double least : {1e-8, 1e-3, 1.0}) {
        if (factorised) break;
        part_of_means = std::clamp(summary.relative_gradient, least, 1.0);
        factorised = FactorizePositive(part_of_means);
      }
    } else {
      factorised = FactorizePositive();
    }
    if (!factorised) ++summary.scaled;
    for (const double factor : {0.5, 0.25, 0.125, 0.0}) {
      if (factorised) break;
      again.stress_factor = factor;
      if (!tangent_.Evaluate(again)) break;
      ++summary.factorisations;
      factorised = FactorizePositive(part_of_means);
    }
    if (!factorised) {
      summary.message = "the stiffness matrix is singular or nearly so";
      return summary;
    }
    has_factor_ = true;
    step = cholesky_->Solve(-gradient);
    if (grasp != nullptr) {
      if (!is_chord) {
        const double reach = std::min(tangent_.Expand(step).colwise().norm().maxCoeff(),
                                      problem_->material().thickness);
        contact = make_contact(reach, nullptr);
        factor_contact_ = contact->Contact();
      }
      contact->Correct(&step);
      // Friction begins with the normal forces of this step, which is not taken: it slides, while
      // what a finger touches sticks until the forces there say otherwise.
      if (summary.iterations == 1 && !is_chord && grasp->BeginFriction(contact->Forces(step))) {
        stick = kEasiestStick;
        has_factor_ = false;
        continue;
      }
    }
    tangent_.LinearisedStresses(step, &stresses_);
    if (grasp != nullptr && grasp->has_unknown_travels()) {
      const double part = grasp->SafePart(tangent_.TravelChanges(step));
      if (part < 1.0) ++summary.limited;
      step *= part;
    }
    // Stresses are those of the whole step also where the displacements take part of it: they
    // balance the loads, while those of a part would keep what the last steps have stretched too
    // far, and its stiffness with it.
    // The linear theory knows no rotation.
    rotation = problem_->nonlinear() ? tangent_.LargestRotation(step) : 0.0;
    if (rotation > kMaxRotation) {
      step *= kMaxRotation / rotation;
      rotation = kMaxRotation;
      ++summary.limited;
    }
    if (problem_->nonlinear() && Bend(rotation, contact.get(), &step)) ++summary.limited;
    problem_->displacements() += tangent_.Expand(step);
    SettleSupports();
    // What is held by friction alone needs it in every iteration; after a few times it stays as it
    // is, or the iteration would have no fixed aim.
    constexpr int kTimes = 10;
    if (grasp != nullptr && lagged < kTimes) {
      grasp->LagFriction();
      ++lagged;
    }
  }
}

}  // namespace darboux
