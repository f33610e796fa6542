#include "solver/minimisation.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "solver/sparse_cholesky.h"
#include "solver/support_conditions.h"
#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

// Ends Ceres' iteration when the Euclidean norm of the gradient is small enough (Ceres itself tests
// the largest component), when the user stops it, or when time is up.
class StopCallback : public ceres::IterationCallback {
 public:
  // Gradients are reported relative to `reference`, in the units of the problem.
  StopCallback(ShellProblem* problem,
               IterationReport::Method method,
               const Deadline& deadline,
               double gradient,
               double reference)
      : problem_(problem),
        method_(method),
        deadline_(deadline),
        gradient_(gradient),
        reference_(reference) {
    if (deadline.log == nullptr) return;
    for (int e = 0; e < kNumEffects; ++e) energy_ += problem->Energy(static_cast<Effect>(e));
  }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (deadline_.log != nullptr) {
      // Ceres' cost has squares of multipliers in it, which stay as they are.
      if (summary.iteration == 0) energy_ -= problem_->force_unit() * summary.cost;
      deadline_.log->Record(
          method_,
          problem_->load_factor(),
          summary.iteration,
          problem_->force_unit() * summary.cost + energy_,
          reference_ > 0.0 ? summary.gradient_norm / reference_ : summary.gradient_norm);
    }
    const bool line_search = summary.line_search_iterations > 0;
    if ((line_search || summary.step_is_successful) && summary.gradient_norm <= gradient_) {
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    if (line_search) return Continue();
    // A rejected step whose change of energy is lost in the energy's own rounding: energies cannot
    // tell any more, only the gradient can, and the caller asks it.
    constexpr double kRounding = 1e3 * std::numeric_limits<double>::epsilon();
    if (!summary.step_is_successful && summary.step_is_valid &&
        std::abs(summary.cost_change) <= kRounding * std::abs(summary.cost)) {
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return Continue();
  }

 private:
  ceres::CallbackReturnType Continue() const {
    return deadline_.Stopped() || deadline_.TimedOut() ? ceres::SOLVER_ABORT
                                                       : ceres::SOLVER_CONTINUE;
  }

  ShellProblem* problem_;
  IterationReport::Method method_;
  const Deadline& deadline_;
  double gradient_;
  double reference_;
  double energy_ = 0.0;  // J, at the start; then without Ceres' cost there
};

ceres::Solver::Options CeresOptions(const SolverOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = BackendOf(options.backend);
  ceres_options.num_threads = options.num_threads;
  ceres_options.logging_type = ceres::SILENT;
  // The cost is normally negative and its change can round to zero: neither says anything about
  // equilibrium, only the gradient does.
  ceres_options.function_tolerance = 0.0;
  ceres_options.parameter_tolerance = 0.0;
  ceres_options.min_trust_region_radius = 1e-40;
  ceres_options.max_num_consecutive_invalid_steps = 50;
  return ceres_options;
}

// Lets Ceres go on from the present state until the gradient, in the scene's units, is the
// tolerance times `reference`, or time is up.
ceres::Solver::Summary RunCeres(ceres::Solver::Options ceres_options,
                                IterationReport::Method method,
                                double reference,
                                const SolverOptions& options,
                                const Deadline& deadline,
                                ShellProblem* problem) {
  reference /= problem->force_unit();
  ceres_options.max_solver_time_in_seconds = deadline.Remaining();
  ceres_options.gradient_tolerance = 0.0;
  StopCallback stop(problem, method, deadline, options.gradient_tolerance * reference, reference);
  ceres_options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, problem->problem(), &summary);
  problem->KeepMeanForces();
  return summary;
}

// A change of the displacements, relative to the largest, that is not worth another pass; and one
// that is not where passes gain little: next to corners of fine lattices conditions of two sides
// all but depend on each other, and what tells them apart settles slowly and matters to nothing.
constexpr double kHeld = 1e-12;
constexpr double kHeldSlowly = 1e-8;
constexpr double kSlow = 0.1;
// Passes of multipliers and refinement; each gains three digits or more, so that only supports that
// contradict each other get here.
constexpr int kMaxPasses = 8;
// By triangular solves alone. Shells so thin that rounding spoils the factor gain little in each.
constexpr int kMaxDirectPasses = 40;

// Every displacement by a rounding, up or down.
void PerturbByRounding(ShellProblem* problem) {
  std::mt19937 generator(20417);
  const Eigen::Matrix3Xd state = problem->displacements();
  problem->displacements() = state.unaryExpr([&](double x) {
    const double unit = std::numeric_limits<double>::epsilon();
    return (generator() & 1) != 0 ? x * (1.0 + unit) : x * (1.0 - unit);
  });
}

// Whether the state is as near to equilibrium as asked, or as rounding allows; up to a relative
// gradient `worst`, beyond which nothing says how far off the displacements are.
bool AcceptLinear(ShellProblem* problem,
                  const SolverOptions& options,
                  const Equilibrium& equilibrium,
                  double worst,
                  std::string* message) {
  if (equilibrium.relative_gradient <= options.gradient_tolerance) return true;
  std::ostringstream text;
  const double floor = RoundingFloor(problem, equilibrium.reference);
  text << "relative gradient " << equilibrium.relative_gradient
       << "; one rounding of the unknowns changes it by " << floor;
  if (equilibrium.relative_gradient > 0.5) {
    text << "; the stiffness matrix is singular or nearly so";
    if (problem->scene().model.quadrature == 1) {
      text
          << ": one quadrature point per triangle leaves a free edge's control vertices loose, use "
             "quadrature: 3";
    }
  }
  if (equilibrium.relative_gradient > worst && floor > worst / kRoundings) {
    text << "; the shell is too thin for elements so small: its stretching stiffness drowns its "
            "bending stiffness in rounding";
  }
  *message = text.str();
  return equilibrium.relative_gradient <= std::min(kRoundings * floor, worst);
}

// The linear theory by Ceres: one Gauss-Newton step solves it for given multipliers of the
// supports, further ones update these and refine.
bool SolveLinearByCeres(ShellProblem* problem,
                        const SolverOptions& options,
                        const Deadline& deadline,
                        int* iterations,
                        Equilibrium* equilibrium,
                        std::string* message) {
  ceres::Solver::Options ceres_options = CeresOptions(options);
  // Levenberg-Marquardt's damping at this radius is below rounding: plain Gauss-Newton.
  ceres_options.initial_trust_region_radius = 1e20;
  ceres_options.max_trust_region_radius = 1e20;
  ceres_options.max_num_iterations = 1;
  ceres_options.gradient_tolerance = 0.0;
  ceres_options.jacobi_scaling = false;  // Cholesky's answer does not depend on it, its cost does.
  *iterations = 0;
  double previous = std::numeric_limits<double>::infinity();
  double unsettled = previous;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const Eigen::Matrix3Xd before = problem->displacements();
    const std::vector<double> multipliers = problem->multipliers();
    if (pass > 0) problem->UpdateMultipliers();
    ceres::Solver::Summary ceres_summary;
    ceres::Solve(ceres_options, problem->problem(), &ceres_summary);
    problem->KeepMeanForces();
    *iterations += static_cast<int>(ceres_summary.iterations.size()) - 1;
    if (!ceres_summary.IsSolutionUsable()) {
      *message = "the linear solver failed: " + ceres_summary.message;
      return false;
    }
    const double violation = problem->LargestViolation();
    if (problem->has_gas()) {  // Once more for what the springs between its shares leave behind.
      const double gradient = CheckEquilibrium(problem).relative_gradient;
      const bool settles = gradient > options.gradient_tolerance && gradient < 0.5 * unsettled;
      unsettled = gradient;
      if (settles && !deadline.Stopped() && !deadline.TimedOut()) continue;
    }
    if (violation >= previous) {
      problem->displacements() = before;
      problem->SetMultipliers(multipliers);
      break;
    }
    const bool slow = violation > kSlow * previous && violation <= kHeldSlowly;
    previous = violation;
    if (violation <= kHeld || slow || deadline.Stopped() || deadline.TimedOut()) break;
  }
  *equilibrium = CheckEquilibrium(problem);
  constexpr double kWorst = 1e-5;
  return AcceptLinear(problem, options, *equilibrium, kWorst, message);
}

enum class Direct {
  kSolved,
  kFailed,
  kTooThin  // for double precision, whoever solves it
};

// The linear theory by one factorisation of our own; multipliers of the supports and refinement
// cost a pair of triangular solves each. Ceres' problem checks the result. Fails also where the
// matrix is not positive definite, with an empty message: Ceres may know better. A factorisation
// cannot be stopped; it is not begun where time is up.
Direct SolveLinearDirectly(ShellProblem* problem,
                           const SolverOptions& options,
                           const Deadline& deadline,
                           int* iterations,
                           Equilibrium* equilibrium,
                           std::string* message) {
  // Ceres' problem, which checks the result, is built beside the pattern of the matrix.
  std::thread builder;
  if (options.num_threads > 1) builder = std::thread([problem] { problem->problem(); });
  TangentStiffness tangent(problem, options.backend, options.num_threads);
  if (builder.joinable()) builder.join();
  const auto cholesky = std::make_unique<UpdatedCholesky>(SparseCholesky::Create(options.backend));
  Eigen::VectorXd gradient;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  request.matrix = true;
  message->clear();
  if (!tangent.Evaluate(request)) return Direct::kFailed;
  cholesky->SetUpdate(tangent.update_vectors(), tangent.update_weights());
  cholesky->Analyze(tangent.matrix());
  if (deadline.Stopped() || deadline.TimedOut()) return Direct::kFailed;
  if (!cholesky->Factorize(tangent.matrix())) return Direct::kFailed;
  request.matrix = false;
  *iterations = 1;
  double previous = std::numeric_limits<double>::infinity();
  double size = 0.0, rest = 0.0;  // of the displacements; of what further passes would change
  for (int pass = 0; pass < kMaxDirectPasses; ++pass) {
    if (pass > 0) {
      problem->UpdateMultipliers();
      tangent.Evaluate(request);
    }
    const Eigen::Matrix3Xd step = tangent.Expand(cholesky->Solve(-gradient));
    const double change = step.cwiseAbs().maxCoeff();
    if (!(change < previous)) {  // rounding, or not finite
      rest = change;
      break;
    }
    problem->displacements() += step;
    // Changes shrink geometrically, so the next one is known before it is made.
    const double next = pass > 0 ? change * (change / previous) : change;
    rest = pass > 0 ? next / (1.0 - change / previous) : change;
    size = problem->displacements().cwiseAbs().maxCoeff();
    if (next <= kHeld * size) break;
    if (change > kSlow * previous && change <= kHeldSlowly * size) break;
    previous = change;
    if (deadline.Stopped() || deadline.TimedOut()) break;
  }
  *equilibrium = CheckEquilibrium(problem);
  // Displacements that the factor cannot settle: Ceres' turn.
  constexpr double kSettled = 1e-3;
  if (!(rest <= kSettled * size) && !(deadline.Stopped() || deadline.TimedOut()))
    return Direct::kFailed;
  constexpr double kWorst = 1e-3;
  if (!AcceptLinear(problem, options, *equilibrium, kWorst, message)) return Direct::kFailed;
  if (equilibrium->relative_gradient <= options.gradient_tolerance) return Direct::kSolved;
  // Rounding decided. What it does to the displacements is what its forces do.
  const Eigen::Matrix3Xd state = problem->displacements();
  tangent.Evaluate(request);
  const Eigen::VectorXd before = gradient;
  PerturbByRounding(problem);
  tangent.Evaluate(request);
  problem->displacements() = state;
  const double error =
      tangent.Expand(cholesky->Solve(gradient - before)).cwiseAbs().maxCoeff() / size;
  constexpr double kUsable = 1e-2;
  if (error <= kUsable) return Direct::kSolved;
  std::ostringstream text;
  text << "rounding moves the displacements by " << error
       << " of the largest: the shell is too thin for elements so small";
  *message = text.str();
  return Direct::kTooThin;
}

// Large: steps are Newton's as long as they go down. Ceres' damping is relative to the diagonal of
// J^T J, which the support springs dominate at the rim, so a small radius holds the rim alone and
// is left only by factors of three an iteration.
constexpr double kInitialRadius = 1e10;

}  // namespace

ceres::SparseLinearAlgebraLibraryType BackendOf(SparseBackend backend) {
  const bool suite_sparse = ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE);
  if (backend == SparseBackend::kEigen || !suite_sparse) return ceres::EIGEN_SPARSE;
  return ceres::SUITE_SPARSE;
}

double RoundingFloor(ShellProblem* problem, double reference) {
  const Eigen::Matrix3Xd state = problem->displacements();
  const Eigen::Matrix3Xd gradient = problem->Gradient();
  PerturbByRounding(problem);
  const double change = (problem->Gradient() - gradient).norm();
  problem->displacements() = state;
  return reference > 0.0 ? change / reference : 0.0;
}

Equilibrium CheckEquilibrium(ShellProblem* problem) {
  Equilibrium result;
  problem->HoldHere();
  const Eigen::Matrix3Xd supports = problem->Gradient(Effect::kSupports);
  Eigen::Matrix3Xd loads = problem->Gradient(Effect::kLoads);
  if (problem->grasp() != nullptr) loads -= problem->force_unit() * problem->grasp()->Force();
  if (problem->has_gas()) loads += problem->Gradient(Effect::kGas);
  result.loads = loads.norm();
  // Also where a finger that a force drives has lost the shell.
  if (problem->grasp() != nullptr) {
    result.loads =
        std::hypot(result.loads, problem->force_unit() * problem->grasp()->DrivingForce());
  }
  result.reference = supports.norm() + result.loads;
  double gradient = problem->Gradient().norm();
  if (problem->grasp() != nullptr) {
    gradient = std::hypot(gradient, problem->force_unit() * problem->grasp()->Imbalance());
  }
  result.relative_gradient = result.reference > 0.0 ? gradient / result.reference : gradient;
  return result;
}

bool SolveLinear(ShellProblem* problem,
                 const SolverOptions& options,
                 const Deadline& deadline,
                 int* iterations,
                 Equilibrium* equilibrium,
                 std::string* message) {
  if (problem->scene().model.minimizer != Minimizer::kCeres) {
    const Direct direct =
        SolveLinearDirectly(problem, options, deadline, iterations, equilibrium, message);
    if (direct != Direct::kFailed) return direct == Direct::kSolved;
    problem->displacements().setZero();
    problem->SetMultipliers(std::vector<double>(problem->multipliers().size(), 0.0));
  }
  if (deadline.IsOver(message)) {
    *equilibrium = CheckEquilibrium(problem);
    return false;
  }
  return SolveLinearByCeres(problem, options, deadline, iterations, equilibrium, message);
}

double StartFromLinear(const Eigen::Matrix3Xd& linear, ShellProblem* problem) {
  const auto energy = [&](double factor) {
    problem->displacements() = factor * linear;
    double total = std::numeric_limits<double>::infinity();
    if (!problem->problem()->Evaluate({}, &total, nullptr, nullptr, nullptr)) {
      total = std::numeric_limits<double>::infinity();
    }
    return total;
  };
  // Golden section on [0, 1]: the energy falls at 0 and is convex in most cases; where it is not,
  // any lower point will do.
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = 0.0, high = 1.0;
  double a = high - ratio * (high - low), b = low + ratio * (high - low);
  double at_a = energy(a), at_b = energy(b);
  double best = 1.0, best_energy = energy(1.0);
  for (int i = 0; i < 16; ++i) {
    if (at_a < best_energy) {
      best = a;
      best_energy = at_a;
    }
    if (at_b < best_energy) {
      best = b;
      best_energy = at_b;
    }
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - ratio * (high - low);
      at_a = energy(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + ratio * (high - low);
      at_b = energy(b);
    }
  }
  if (!(best_energy < energy(0.0))) best = 0.0;
  problem->displacements() = best * linear;
  return best;
}

bool Descend(ShellProblem* problem,
             const SolverOptions& options,
             const Deadline& deadline,
             int* iterations,
             Equilibrium* equilibrium,
             std::string* message) {
  *iterations = 0;
  problem->SetAngleReferences();
  // A violated support, relative to the largest displacement, that may be left.
  constexpr double kHeldNonlinear = 1e-9;
  double previous = std::numeric_limits<double>::infinity();
  double unsettled = previous;  // relative gradient that the gas's last pass has left
  constexpr int kMaxCorrections = 50;
  for (int correction = 0; correction < kMaxCorrections; ++correction) {
    if (problem->NeedsCorrection()) problem->UpdateCorrection();
    *equilibrium = CheckEquilibrium(problem);
    if (equilibrium->reference == 0.0 ||
        (correction > 0 && equilibrium->relative_gradient <= options.gradient_tolerance)) {
      return true;
    }
    ceres::Solver::Options ceres_options = CeresOptions(options);
    ceres_options.initial_trust_region_radius = kInitialRadius;
    ceres_options.max_num_iterations = options.max_iterations - *iterations;
    // Reactions are still to be found; the loads alone are a scale on the safe side.
    const double loads = equilibrium->loads;
    const ceres::Solver::Summary ceres_summary =
        RunCeres(ceres_options,
                 IterationReport::Method::kCeres,
                 loads > 0.0 ? loads : equilibrium->reference,
                 options,
                 deadline,
                 problem);
    *iterations += static_cast<int>(ceres_summary.iterations.size()) - 1;
    *equilibrium = CheckEquilibrium(problem);
    if (deadline.IsOver(message)) return false;
    if (!ceres_summary.IsSolutionUsable()) {
      *message = "the minimiser failed: " + ceres_summary.message;
      return false;
    }
    if (equilibrium->relative_gradient > options.gradient_tolerance &&
        equilibrium->relative_gradient >
            kRoundings * RoundingFloor(problem, equilibrium->reference)) {
      // Without loads the scale was that of reactions before equilibrium, with fingers that of a
      // contact before the shell gave way: larger.
      if ((loads == 0.0 || problem->grasp() != nullptr) && ceres_summary.num_successful_steps > 1 &&
          *iterations < options.max_iterations) {
        continue;
      }
      // The gas's pressure has changed, and what goes with it in the correction: once more from
      // here.
      if (problem->has_gas() && equilibrium->relative_gradient < 0.5 * unsettled &&
          *iterations < options.max_iterations) {
        unsettled = equilibrium->relative_gradient;
        continue;
      }
      std::ostringstream text;
      text << "relative gradient " << equilibrium->relative_gradient << " after " << *iterations
           << " iterations";
      *message = text.str();
      return false;
    }
    const double violation = problem->LargestViolation();
    const bool held = violation <= kHeldNonlinear || violation >= 0.5 * previous;
    if (held && !problem->NeedsCorrection()) return true;
    if (!held) problem->UpdateMultipliers();
    previous = violation;
  }
  *message = "the forces that follow the deformation did not settle";
  return false;
}

double StartFromCones(ShellProblem* problem) {
  const Scene& scene = problem->scene();
  const ShellSurface& surface = problem->surface();
  // Radius of the cones: a fraction of the shell, as contacts are local.
  const double radius = 0.25 * surface.size();
  Eigen::Matrix3Xd cones = Eigen::Matrix3Xd::Zero(3, problem->displacements().cols());
  for (const LoadSpec& load : scene.loads) {
    if (load.kind != LoadSpec::Kind::kPoint) continue;
    const ElementPoint at = Resolve(load.at, surface);
    const Eigen::Vector3d force = EvaluateAt(load.force, surface, at);
    if (force.isZero(0.0)) continue;
    const Eigen::Vector3d tip = surface.Position(at);
    // Distance of a control vertex: that of the element corner it belongs to, or of its element.
    for (int e = 0; e < surface.num_elements(); ++e) {
      const double height =
          1.0 - (surface.Position({e, 1.0 / 3.0, 1.0 / 3.0}) - tip).norm() / radius;
      if (height <= 0.0) continue;
      for (const int vertex : surface.control_vertices(e)) {
        if (!problem->IsFree(vertex)) continue;
        const Eigen::Vector3d move = height * force.normalized();
        if (move.norm() > cones.col(vertex).norm()) cones.col(vertex) = move;
      }
    }
  }
  if (cones.isZero(0.0)) return 0.0;
  const auto energy = [&](double height) {
    problem->displacements() = height * cones;
    double total;
    if (!problem->problem()->Evaluate({}, &total, nullptr, nullptr, nullptr)) {
      return std::numeric_limits<double>::infinity();
    }
    return total;
  };
  // Downhill from a height that is certainly too large, by factors.
  double best = 0.0, lowest = energy(0.0);
  for (double height = radius; height > 1e-12 * radius; height *= 0.7) {
    const double at = energy(height);
    if (at < lowest) {
      lowest = at;
      best = height;
    }
  }
  problem->displacements() = best * cones;
  return best;
}

bool DescendByConjugateGradients(ShellProblem* problem,
                                 const SolverOptions& options,
                                 const Deadline& deadline,
                                 int* iterations,
                                 Equilibrium* equilibrium,
                                 std::string* message) {
  *iterations = 0;
  problem->SetAngleReferences();
  // Steps are cheap and many.
  constexpr int kStepsPerIteration = 100;
  constexpr int kMaxRounds = 50;
  double previous = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMaxRounds; ++round) {
    if (problem->NeedsCorrection()) problem->UpdateCorrection();
    *equilibrium = CheckEquilibrium(problem);
    const double violation = problem->LargestViolation();
    if (round > 0 && equilibrium->relative_gradient <= options.gradient_tolerance &&
        violation <= 1e-6) {
      return true;
    }
    if (equilibrium->reference == 0.0) return true;
    ceres::Solver::Options ceres_options = CeresOptions(options);
    ceres_options.minimizer_type = ceres::LINE_SEARCH;
    ceres_options.line_search_direction_type = ceres::NONLINEAR_CONJUGATE_GRADIENT;
    ceres_options.min_line_search_step_size = 1e-30;
    ceres_options.max_num_iterations = kStepsPerIteration * options.max_iterations - *iterations;
    const ceres::Solver::Summary ceres_summary =
        RunCeres(ceres_options,
                 IterationReport::Method::kConjugateGradient,
                 equilibrium->reference,
                 options,
                 deadline,
                 problem);
    const int used = static_cast<int>(ceres_summary.iterations.size()) - 1;
    *iterations += used;
    *equilibrium = CheckEquilibrium(problem);
    if (deadline.IsOver(message)) return false;
    const bool stuck = used < 2 && violation >= 0.5 * previous;
    if (stuck || *iterations >= kStepsPerIteration * options.max_iterations) {
      std::ostringstream text;
      text << "relative gradient " << equilibrium->relative_gradient << " after " << *iterations
           << " iterations of conjugate gradients";
      *message = text.str();
      return false;
    }
    previous = violation;
    problem->UpdateMultipliers();
  }
  *message = "the supports did not settle";
  return false;
}

}  // namespace darboux
