#include "solver/path_following.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "solver/support_conditions.h"

namespace darboux {
namespace {

// A step that takes more iterations is halved; one that takes few grows.
constexpr int kMaxIterations = 15;
constexpr int kManyIterations = 8;
constexpr int kFewIterations = 5;
// First step of the arc length: this part of the full load, a smaller one where the scene asks for
// more steps, or where that would turn the shell by more, this rotation (rad, first order).
constexpr double kFirstFactor = 0.05;
constexpr double kFirstRotation = 0.2;
// Steps grow to this many times the first, and are cut to this part of it at most.
constexpr double kLongest = 4.0;
constexpr double kShortest = 1e-5;
// The path turns by no more than this between its points (cosine), or it might be another's.
constexpr double kSharpest = 0.7;

}  // namespace

PathFollowing::PathFollowing(ShellProblem* problem,
                             const SolverOptions& options,
                             const Deadline& deadline,
                             std::vector<std::string>* decisions)
    : problem_(problem),
      options_(options),
      deadline_(deadline),
      decisions_(decisions),
      mixed_(problem, options.backend, options.num_threads) {}

// -d gradient / d factor: what depends on the load factor is linear in it.
Eigen::VectorXd PathFollowing::LoadVector() {
  const double factor = problem_->load_factor();
  problem_->SetLoadFactor(0.0);
  Eigen::VectorXd load = mixed_.tangent().ExternalGradient();
  problem_->SetLoadFactor(1.0);
  load -= mixed_.tangent().ExternalGradient();
  problem_->SetLoadFactor(factor);
  return load;
}

PathFollowing::State PathFollowing::Present(const State* previous) {
  State state;
  state.factor = problem_->load_factor();
  state.displacements = problem_->displacements();
  state.multipliers = problem_->multipliers();
  state.negative_modes = mixed_.FactorizeHessian();
  if (state.negative_modes < 0) {
    state.tangent = Eigen::VectorXd::Zero(mixed_.tangent().num_unknowns());
    return state;
  }
  state.tangent = mixed_.cholesky().Solve(LoadVector());
  const double length = state.tangent.norm();
  if (length == 0.0) return state;
  double direction = 1.0;
  if (previous != nullptr) {
    const Eigen::VectorXd moved =
        mixed_.tangent().Reduce(state.displacements - previous->displacements);
    direction = moved.dot(state.tangent) >= 0.0 ? 1.0 : -1.0;
  }
  state.slope = direction / length;
  return state;
}

void PathFollowing::Restore(const State& state) {
  problem_->SetLoadFactor(state.factor);
  problem_->displacements() = state.displacements;
  problem_->SetMultipliers(state.multipliers);
  mixed_.SetStresses();
}

void PathFollowing::Report(const State& state,
                           int iterations,
                           bool limit,
                           const OnPoint& on_point) {
  Point point;
  point.factor = state.factor;
  point.iterations = iterations;
  // A stable state needs no mode: its Hessian has just been factorised.
  point.stability.negative_modes = state.negative_modes;
  if (state.negative_modes > 0) point.stability = CheckStability(&mixed_);
  point.limit_point = limit;
  // By Ceres' problem, which is not what found the state.
  if (problem_->NeedsCorrection()) problem_->UpdateCorrection();
  point.relative_gradient = CheckEquilibrium(problem_).relative_gradient;
  on_point(point);
}

MixedIteration::Summary PathFollowing::Correct(const Eigen::VectorXd* control,
                                               const State& from,
                                               double step,
                                               int max_iterations,
                                               double spring) {
  MixedIteration::Summary summary;
  TangentStiffness& tangent = mixed_.tangent();
  Eigen::VectorXd gradient;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  request.matrix = true;
  request.initial_stresses = &mixed_.stresses();
  request.control_spring = spring > 0.0;
  TangentStiffness::Request again = request;
  again.gradient = nullptr;
  double energy = 0.0;
  if (deadline_.log != nullptr) request.energy = &energy;
  double previous = std::numeric_limits<double>::infinity();
  while (true) {
    if (!tangent.Evaluate(request)) {
      summary.message = "the strains are undefined";
      return summary;
    }
    const double left =
        control == nullptr
            ? 0.0
            : step - control->dot(tangent.Reduce(problem_->displacements() - from.displacements));
    summary.relative_gradient = mixed_.RelativeGradient(gradient);
    if (!std::isfinite(summary.relative_gradient)) {
      summary.message = "the iteration diverged";
      return summary;
    }
    if (deadline_.log != nullptr) {
      deadline_.log->Record(IterationReport::Method::kPath,
                            problem_->load_factor(),
                            summary.iterations,
                            problem_->force_unit() * energy,
                            summary.relative_gradient);
    }
    constexpr double kStep = 1e-7;  // of the step, that may be left
    const bool balanced = mixed_.IsBalanced(
        gradient, summary.relative_gradient, previous, options_.gradient_tolerance);
    previous = summary.relative_gradient;
    if (balanced && std::abs(left) <= kStep * std::abs(step)) {
      summary.converged = true;
      problem_->SetAngleReferences();
      return summary;
    }
    if (summary.iterations >= max_iterations) {
      std::ostringstream text;
      text << "relative gradient " << summary.relative_gradient << " after " << summary.iterations
           << " iterations";
      summary.message = text.str();
      return summary;
    }
    ++summary.iterations;
    ++summary.factorisations;
    if (spring > 0.0) {
      bool factorised = mixed_.FactorizePositive();
      if (!factorised) ++summary.scaled;
      for (const double factor : {0.5, 0.25, 0.125, 0.0}) {
        if (factorised) break;
        again.stress_factor = factor;
        if (!tangent.Evaluate(again)) break;
        ++summary.factorisations;
        factorised = mixed_.FactorizePositive();
      }
      if (!factorised) {
        summary.message = "the stiffness matrix is singular or nearly so";
        return summary;
      }
      gradient -= spring * left * *control;
    } else if (mixed_.Factorize() < 0) {
      summary.message = "the stiffness matrix is singular";
      return summary;
    }
    Eigen::VectorXd change = mixed_.cholesky().Solve(-gradient);
    if (control != nullptr) {
      const Eigen::VectorXd by_load = mixed_.cholesky().Solve(LoadVector());
      const double moved = control->dot(by_load);
      const double factor = (left - control->dot(change)) / moved;
      if (!std::isfinite(factor)) {
        summary.message = "the controlled displacement does not depend on the load";
        return summary;
      }
      change += factor * by_load;
      problem_->SetLoadFactor(problem_->load_factor() + factor);
    }
    tangent.LinearisedStresses(change, &mixed_.stresses());
    problem_->displacements() += tangent.Expand(change);
    mixed_.SettleSupports();
  }
}

bool PathFollowing::Follow(const OnPoint& on_point, std::string* message) {
  problem_->SetLoadFactor(0.0);
  MixedIteration::Options inflation;
  inflation.max_iterations = options_.max_iterations;
  inflation.gradient_tolerance = options_.gradient_tolerance;
  inflation.stop = [this] { return deadline_.Stopped() || deadline_.TimedOut(); };
  if (deadline_.log != nullptr) {
    inflation.on_iteration = [this](int iteration, double energy, double relative_gradient) {
      deadline_.log->Record(
          IterationReport::Method::kMixed, 0.0, iteration, energy, relative_gradient);
    };
  }
  const MixedIteration::Summary inflated = mixed_.Inflate(inflation);
  if (!inflated.converged) {
    if (!inflated.stopped || !deadline_.IsOver(message)) *message = inflated.message;
    return false;
  }
  if (inflated.iterations > 0) {
    decisions_->push_back("gas fills the shell: " + std::to_string(inflated.iterations) +
                          " iterations");
  }
  mixed_.SetStresses();
  if (problem_->scene().path.control == PathControl::kDisplacement) {
    return FollowDisplacement(on_point, message);
  }
  return FollowArcLength(on_point, message);
}

bool PathFollowing::FollowDisplacement(const OnPoint& on_point, std::string* message) {
  const PathSpec& path = problem_->scene().path;
  const ElementPoint at = Resolve(problem_->scene().probes[path.probe].at, problem_->surface());
  Eigen::Matrix3Xd weights = Eigen::Matrix3Xd::Zero(3, problem_->displacements().cols());
  const Eigen::VectorXd values = problem_->surface().ValueWeights(at);
  const std::vector<int>& vertices = problem_->surface().control_vertices(at.element);
  for (size_t i = 0; i < vertices.size(); ++i) weights(path.component, vertices[i]) += values[i];
  const Eigen::VectorXd control = mixed_.tangent().Reduce(weights);
  // Stiff beside anything that the shell can set against it.
  const double spring = 10.0 * problem_->scaled_material().MembraneStiffness();
  Eigen::Matrix3Xd local(3, vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) local.col(i) = weights.col(vertices[i]);
  mixed_.tangent().SetControlSpring(at.element, local, spring);

  State good = Present(nullptr);
  const int steps = problem_->scene().steps;
  // Zero, but for a shell that gas has inflated.
  const double begin = control.dot(mixed_.tangent().Reduce(good.displacements));
  double reached = begin;
  for (int k = 1; k <= steps; ++k) {
    const double target = k < steps ? begin + (path.to - begin) * k / steps : path.to;
    double step = target - reached;
    int iterations = 0;
    while (reached != target) {
      if (deadline_.IsOver(message)) {
        Restore(good);
        return false;
      }
      if (std::abs(target - reached) <= std::abs(step) * (1.0 + 1e-9)) step = target - reached;
      const MixedIteration::Summary summary =
          Correct(&control, good, step, 2 * kMaxIterations, spring);
      iterations += summary.iterations;
      if (summary.converged) {
        reached = step == target - reached ? target : reached + step;
        good = Present(&good);
        mixed_.SetStresses();
        continue;
      }
      Restore(good);
      step *= 0.5;
      if (std::abs(step) < kShortest * std::abs(path.to)) {
        *message = "the controlled displacement stops at " + std::to_string(reached) + ": " +
                   summary.message + "; arc_length may go on";
        return false;
      }
      std::ostringstream line;
      line << "displacement step cut to " << step << " at " << reached << ": " << summary.message;
      decisions_->push_back(line.str());
    }
    Report(good, iterations, false, on_point);
  }
  return true;
}

bool PathFollowing::FollowArcLength(const OnPoint& on_point, std::string* message) {
  State good = Present(nullptr);
  if (good.tangent.isZero(0.0)) {
    *message = "nothing moves along the path: no load, or a singular stiffness at rest";
    return false;
  }
  const int scene_steps = problem_->scene().steps;
  const double rotation = mixed_.tangent().LargestRotation(good.tangent);
  const double part = scene_steps > 1 ? std::min(kFirstFactor, 1.0 / scene_steps) : kFirstFactor;
  const double first =
      good.tangent.norm() * std::min(part, rotation > 0.0 ? kFirstRotation / rotation : part);
  double step = first;
  const int max_steps = problem_->scene().path.max_steps;
  for (int k = 0; k < max_steps; ++k) {
    State next;
    MixedIteration::Summary summary;
    while (true) {
      if (deadline_.IsOver(message)) {
        Restore(good);
        return false;
      }
      const Eigen::VectorXd direction = good.tangent * good.slope;  // unit length
      mixed_.tangent().LinearisedStresses(step * direction, &mixed_.stresses());
      problem_->displacements() += mixed_.tangent().Expand(step * direction);
      problem_->SetLoadFactor(good.factor + step * good.slope);
      summary = Correct(&direction, good, step, kMaxIterations);
      if (summary.converged) {
        next = Present(&good);
        const double length =
            mixed_.tangent().Reduce(next.displacements - good.displacements).norm();
        const double turn = direction.dot(next.tangent) * next.slope;
        if (length > 0.0 && step / length >= kSharpest && turn >= kSharpest) break;
        summary.message = "the path turns too sharply";
      }
      Restore(good);
      step *= 0.5;
      if (step < kShortest * first) {
        *message = "the path cannot be followed from load factor " + std::to_string(good.factor) +
                   " on: " + summary.message;
        return false;
      }
    }

    // Between opposite slopes the load factor has an extremum: by secants on the slope.
    if (good.slope * next.slope < 0.0) {
      State low = good, limit = next;
      const Eigen::VectorXd direction = good.tangent * good.slope;
      const auto along = [&](const State& state) {
        return direction.dot(mixed_.tangent().Reduce(state.displacements - good.displacements));
      };
      State high = next;
      double at_low = 0.0, at_high = along(next);
      int iterations = 0;
      for (int i = 0; i < 6; ++i) {
        double at = at_low + (at_high - at_low) * low.slope / (low.slope - high.slope);
        at =
            std::clamp(at, at_low + 0.05 * (at_high - at_low), at_high - 0.05 * (at_high - at_low));
        Restore(good);
        // From the nearer end, so that few iterations are needed.
        Restore(at - at_low < at_high - at ? low : high);
        const MixedIteration::Summary found = Correct(&direction, good, at, kMaxIterations);
        if (!found.converged) break;
        iterations += found.iterations;
        limit = Present(&good);
        const double change = std::abs(limit.slope) * (at_high - at_low);
        (limit.slope * good.slope > 0.0 ? low : high) = limit;
        (limit.slope * good.slope > 0.0 ? at_low : at_high) = at;
        if (change <= 1e-6 * std::max(std::abs(limit.factor), 1e-3)) break;
      }
      Restore(limit);
      Report(limit, iterations, true, on_point);
      std::ostringstream line;
      line << "limit point at load factor " << limit.factor;
      decisions_->push_back(line.str());
      Restore(next);
    }

    // The full load is reached between the two: end there.
    if (good.factor < 1.0 && next.factor >= 1.0) {
      const double part = (1.0 - good.factor) / (next.factor - good.factor);
      Restore(next);
      problem_->displacements() =
          good.displacements + part * (next.displacements - good.displacements);
      problem_->SetLoadFactor(1.0);
      mixed_.SetStresses();
      summary = Correct(nullptr, good, 0.0, 2 * kMaxIterations);
      if (!summary.converged) {
        Restore(next);
        *message = "the full load is passed but not hit: " + summary.message;
        return false;
      }
      good = Present(&good);
      Report(good, summary.iterations, false, on_point);
      return true;
    }
    good = next;
    Restore(good);
    Report(good, summary.iterations, false, on_point);
    if (summary.iterations <= kFewIterations) step = std::min(1.5 * step, kLongest * first);
    if (summary.iterations > kManyIterations) step *= 0.7;
  }
  *message = "the path has not reached the full load in " + std::to_string(max_steps) + " steps";
  return false;
}

}  // namespace darboux
