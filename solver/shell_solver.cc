#include "solver/shell_solver.h"

#include <ceres/ceres.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <sstream>

#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Deadline {
  Clock::time_point start;
  double limit_s;
  const std::atomic<bool>* stop;

  bool Stopped() const { return stop != nullptr && stop->load(); }
  bool TimedOut() const { return limit_s > 0.0 && Since(start) >= limit_s; }
  double Remaining() const { return limit_s > 0.0 ? std::max(limit_s - Since(start), 0.01) : 1e9; }
};

// Ends Ceres' iteration when the Euclidean norm of the gradient is small enough (Ceres itself tests
// the largest component), when the user stops it, or when time is up.
class StopCallback : public ceres::IterationCallback {
 public:
  StopCallback(const Deadline& deadline, double gradient)
      : deadline_(deadline), gradient_(gradient) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.step_is_successful && summary.gradient_norm <= gradient_) {
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    // A rejected step whose change of energy is lost in the energy's own rounding: energies cannot
    // tell any more, only the gradient can, and the caller asks it.
    constexpr double kRounding = 1e3 * std::numeric_limits<double>::epsilon();
    if (!summary.step_is_successful && summary.step_is_valid &&
        std::abs(summary.cost_change) <= kRounding * std::abs(summary.cost)) {
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return deadline_.Stopped() || deadline_.TimedOut() ? ceres::SOLVER_ABORT
                                                       : ceres::SOLVER_CONTINUE;
  }

 private:
  const Deadline& deadline_;
  double gradient_;
};

ceres::SparseLinearAlgebraLibraryType BackendOf(SparseBackend backend) {
  const bool suite_sparse = ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE);
  if (backend == SparseBackend::kEigen || !suite_sparse) return ceres::EIGEN_SPARSE;
  return ceres::SUITE_SPARSE;
}

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

// The force scale that gradients are measured against, and the relative gradient.
struct Equilibrium {
  double relative_gradient = 0.0;
  double reference = 0.0;  // N, loads and reactions
  double loads = 0.0;      // N, loads alone
};

Equilibrium CheckEquilibrium(ShellProblem* problem) {
  Equilibrium result;
  const Eigen::Matrix3Xd supports = problem->Gradient(Effect::kSupports);
  const Eigen::Matrix3Xd loads = problem->Gradient(Effect::kLoads);
  result.loads = loads.norm();
  result.reference = supports.norm() + result.loads;
  const double gradient = problem->Gradient().norm();
  result.relative_gradient = result.reference > 0.0 ? gradient / result.reference : gradient;
  return result;
}

// Relative change of the gradient when every unknown moves by one unit of rounding: no state in
// double can be told from equilibrium below about ten times it (a residual sums a dozen terms).
// Matters for supports and membranes that are stiff against a large displacement.
constexpr double kRoundings = 10.0;

double RoundingFloor(ShellProblem* problem, double reference) {
  std::mt19937 generator(20417);
  const Eigen::Matrix3Xd state = problem->displacements();
  const Eigen::Matrix3Xd gradient = problem->Gradient();
  problem->displacements() = state.unaryExpr([&](double x) {
    const double unit = std::numeric_limits<double>::epsilon();
    return (generator() & 1) != 0 ? x * (1.0 + unit) : x * (1.0 - unit);
  });
  const double change = (problem->Gradient() - gradient).norm();
  problem->displacements() = state;
  return reference > 0.0 ? change / reference : 0.0;
}

// Over the lattice vertices and one point inside each element.
double MaxDisplacement(const ShellProblem& problem) {
  const ParameterDomain& domain = problem.surface().domain();
  double largest = 0.0;
  for (int j = 0; j <= domain.options().divisions[1]; ++j) {
    for (int i = 0; i <= domain.options().divisions[0]; ++i) {
      largest = std::max(largest, problem.Displacement(domain.LocateLattice(i, j)).norm());
    }
  }
  for (int e = 0; e < problem.surface().num_elements(); ++e) {
    const auto& vertices = problem.surface().control_vertices(e);
    const StrainPoint& p = problem.strain_points()[e]->front();
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < vertices.size(); ++i) {
      u += p.weights(kRowValue, i) * problem.displacements().col(vertices[i]);
    }
    largest = std::max(largest, u.norm());
  }
  return largest;
}

void RecordStep(ShellProblem* problem,
                double factor,
                int iterations,
                bool converged,
                double relative_gradient,
                const SolverOptions& options,
                Clock::time_point start,
                SolverSummary* summary) {
  LoadStep step;
  step.factor = factor;
  step.iterations = iterations;
  step.converged = converged;
  step.relative_gradient = relative_gradient;
  for (int e = 0; e < kNumEffects; ++e) {
    step.energies[e] = problem->Energy(static_cast<Effect>(e));
    step.energy += step.energies[e];
  }
  step.max_displacement = MaxDisplacement(*problem);
  step.reaction = problem->Reaction();
  for (const ProbeSpec& probe : problem->scene().probes) {
    step.probe_displacements.push_back(
        problem->Displacement(Resolve(probe.at, problem->surface())));
  }
  step.displacements = problem->displacements();
  summary->steps.push_back(step);
  if (options.on_step) {
    StepReport report;
    report.step = static_cast<int>(summary->steps.size());
    report.steps = problem->scene().steps;
    report.load_factor = factor;
    report.iterations = iterations;
    report.energy = step.energy;
    report.relative_gradient = relative_gradient;
    report.max_displacement = step.max_displacement;
    report.seconds = Since(start);
    report.converged = converged;
    options.on_step(report);
  }
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

// Whether the state is as near to equilibrium as asked, or as rounding allows.
bool AcceptLinear(ShellProblem* problem,
                  const SolverOptions& options,
                  const Equilibrium& equilibrium,
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
  *message = text.str();
  return equilibrium.relative_gradient <= kRoundings * floor;
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
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const Eigen::Matrix3Xd before = problem->displacements();
    const std::vector<double> multipliers = problem->multipliers();
    if (pass > 0) problem->UpdateMultipliers();
    ceres::Solver::Summary ceres_summary;
    ceres::Solve(ceres_options, problem->problem(), &ceres_summary);
    *iterations += static_cast<int>(ceres_summary.iterations.size()) - 1;
    if (!ceres_summary.IsSolutionUsable()) {
      *message = "the linear solver failed: " + ceres_summary.message;
      return false;
    }
    const double violation = problem->LargestViolation();
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
  return AcceptLinear(problem, options, *equilibrium, message);
}

// The linear theory by one factorisation of our own; multipliers of the supports and refinement
// cost a pair of triangular solves each. Ceres' problem checks the result. False also where the
// matrix is not positive definite, with an empty message: Ceres may know better.
bool SolveLinearDirectly(ShellProblem* problem,
                         const SolverOptions& options,
                         int* iterations,
                         Equilibrium* equilibrium,
                         std::string* message) {
  TangentStiffness tangent(problem, options.backend, options.num_threads);
  const std::unique_ptr<SparseCholesky> cholesky = SparseCholesky::Create(options.backend);
  Eigen::VectorXd gradient;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  request.matrix = true;
  message->clear();
  if (!tangent.Evaluate(request)) return false;
  cholesky->Analyze(tangent.matrix());
  if (!cholesky->Factorize(tangent.matrix())) return false;
  request.matrix = false;
  *iterations = 1;
  double previous = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (pass > 0) {
      problem->UpdateMultipliers();
      tangent.Evaluate(request);
    }
    const Eigen::Matrix3Xd step = tangent.Expand(cholesky->Solve(-gradient));
    const double change = step.cwiseAbs().maxCoeff();
    if (!(change < previous)) break;  // rounding, or not finite
    problem->displacements() += step;
    // Changes shrink geometrically, so the next one is known before it is made.
    const double next = pass > 0 ? change * (change / previous) : change;
    const double size = problem->displacements().cwiseAbs().maxCoeff();
    if (next <= kHeld * size) break;
    if (change > kSlow * previous && change <= kHeldSlowly * size) break;
    previous = change;
  }
  *equilibrium = CheckEquilibrium(problem);
  return AcceptLinear(problem, options, *equilibrium, message);
}

bool SolveLinear(ShellProblem* problem,
                 const SolverOptions& options,
                 const Deadline& deadline,
                 int* iterations,
                 Equilibrium* equilibrium,
                 std::string* message) {
  if (problem->scene().model.minimizer != Minimizer::kCeres) {
    if (SolveLinearDirectly(problem, options, iterations, equilibrium, message)) return true;
    problem->displacements().setZero();
    problem->SetMultipliers(std::vector<double>(problem->multipliers().size(), 0.0));
  }
  return SolveLinearByCeres(problem, options, deadline, iterations, equilibrium, message);
}

// Large: steps are Newton's as long as they go down. Ceres' damping is relative to the diagonal of
// J^T J, which the support springs dominate at the rim, so a small radius holds the rim alone and
// is left only by factors of three an iteration.
constexpr double kInitialRadius = 1e10;

// Moves the problem to the lowest energy among multiples of the linear solution. A stretched plate
// lies far below the linear theory (w = 2 h where it says 7 h): from here Newton's steps go down at
// once, from rest the first one overshoots and all damping has to be found by failing.
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

// Levenberg-Marquardt at the problem's present load factor, from its present state.
bool SolveNonlinear(ShellProblem* problem,
                    const SolverOptions& options,
                    const Deadline& deadline,
                    int* iterations,
                    Equilibrium* equilibrium,
                    std::string* message) {
  *iterations = 0;
  // A violated support, relative to the largest displacement, that may be left.
  constexpr double kHeldNonlinear = 1e-9;
  double previous = std::numeric_limits<double>::infinity();
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
    ceres_options.max_solver_time_in_seconds = deadline.Remaining();
    ceres_options.gradient_tolerance = 0.0;
    // Reactions are still to be found; the loads alone are a scale on the safe side.
    const double loads = equilibrium->loads;
    StopCallback stop(deadline,
                      options.gradient_tolerance * (loads > 0.0 ? loads : equilibrium->reference) /
                          problem->force_unit());
    ceres_options.callbacks.push_back(&stop);
    ceres::Solver::Summary ceres_summary;
    ceres::Solve(ceres_options, problem->problem(), &ceres_summary);
    *iterations += static_cast<int>(ceres_summary.iterations.size()) - 1;
    *equilibrium = CheckEquilibrium(problem);
    if (deadline.Stopped() || deadline.TimedOut()) {
      *message = deadline.Stopped() ? "stopped by the user" : "time limit reached";
      return false;
    }
    if (!ceres_summary.IsSolutionUsable()) {
      *message = "the minimiser failed: " + ceres_summary.message;
      return false;
    }
    if (equilibrium->relative_gradient > options.gradient_tolerance &&
        equilibrium->relative_gradient >
            kRoundings * RoundingFloor(problem, equilibrium->reference)) {
      // Without loads the scale was that of reactions before equilibrium, which were larger.
      if (loads == 0.0 && ceres_summary.num_successful_steps > 1 &&
          *iterations < options.max_iterations) {
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

// Strain energy that the nonlinear theory finds in the linear solution, against the linear one:
// an estimate of what the linear theory leaves out.
double EstimateNonlinearity(const ShellProblem& linear) {
  const StrainMeasure measure = linear.measure() == StrainMeasure::kLinearKoiter
                                    ? StrainMeasure::kKoiter
                                    : StrainMeasure::kNonlinearSeed;
  const Material& material = linear.material();
  const double nu = material.poisson_ratio;
  const double membrane = material.MembraneStiffness(), bending = material.BendingStiffness();
  const auto form = [nu](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return a[0] * b[0] + a[1] * b[1] + nu * (a[0] * b[1] + a[1] * b[0]) +
           0.5 * (1.0 - nu) * a[2] * b[2];
  };
  double difference = 0.0, reference = 0.0;
  const ShellSurface& surface = linear.surface();
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto& vertices = surface.control_vertices(e);
    for (const StrainPoint& p : *linear.strain_points()[e]) {
      Eigen::Matrix<double, 3, 5> k = Eigen::Matrix<double, 3, 5>::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        k += linear.displacements().col(vertices[i]) * p.weights.col(i).tail<5>().transpose();
      }
      Eigen::Vector3d e0, e1, z0, z1;
      EvaluateMembraneStrain(linear.measure(), p, k.data(), e0.data());
      EvaluateMembraneStrain(measure, p, k.data(), e1.data());
      EvaluateBendingStrain(linear.measure(), p, k.data(), z0.data());
      if (!EvaluateBendingStrain(measure, p, k.data(), z1.data())) {
        return std::numeric_limits<double>::infinity();
      }
      e1 -= e0;
      z1 -= z0;
      difference += p.area * (membrane * form(e1, e1) + bending * form(z1, z1));
      reference += p.area * (membrane * form(e0, e0) + bending * form(z0, z0));
    }
  }
  return reference > 0.0 ? difference / reference : 0.0;
}

void Finish(ShellProblem* problem,
            const SolverOptions& options,
            const Equilibrium& equilibrium,
            SolverSummary* summary) {
  summary->theory = problem->nonlinear() ? Theory::kNonlinear : Theory::kLinear;
  summary->backend =
      BackendOf(options.backend) == ceres::SUITE_SPARSE ? "suite_sparse" : "eigen_sparse";
  summary->dof = problem->dof();
  summary->unknowns = problem->num_unknowns();
  summary->elements = problem->surface().num_elements();
  summary->quadrature_points = problem->num_quadrature_points();
  summary->free_motions = problem->free_motions();
  summary->iterations = 0;
  for (const LoadStep& step : summary->steps) summary->iterations += step.iterations;
  const LoadStep& state = summary->steps.back();  // recorded last: the problem's present state
  summary->effects.clear();
  summary->energy_total = 0.0;
  for (int i = 0; i < kNumEffects; ++i) {
    const Effect effect = static_cast<Effect>(i);
    EffectSummary entry{ToString(effect), problem->effect(effect), state.energies[i]};
    summary->energy_total += entry.energy;
    if (effect == Effect::kLoads) summary->load_work = -entry.energy;
    if (effect == Effect::kSupports) summary->support_energy = entry.energy;
    summary->effects.push_back(std::move(entry));
  }
  summary->probes.clear();
  for (const ProbeSpec& probe : problem->scene().probes) {
    const ElementPoint at = Resolve(probe.at, problem->surface());
    summary->probes.push_back(
        {probe.name, problem->surface().Position(at), problem->Displacement(at)});
  }
  summary->reaction = problem->Reaction();
  summary->applied_force = problem->AppliedForce();
  // Self-equilibrated loads have no resultant: then the size of their nodal forces is the scale.
  const double forces =
      std::max(summary->reaction.norm() + summary->applied_force.norm(), equilibrium.reference);
  summary->force_balance =
      forces > 0.0 ? (summary->reaction + summary->applied_force).norm() / forces : 0.0;
  summary->gradient_norm = equilibrium.relative_gradient;
  summary->max_displacement = state.max_displacement;

  // Springs hold what they hold to 1e-5 or so of the displacements; conditions that exclude each
  // other leave a gap of the order of the displacements themselves.
  constexpr double kContradiction = 1e-2;
  int support = -1;
  const double violation = problem->LargestViolation(&support);
  if (support >= 0 && violation > kContradiction && summary->IsConverged()) {
    const SceneLocation& where = problem->scene().supports[support].location;
    std::ostringstream text;
    text
        << where.file << ":" << where.line << ": " << where.key << ": is not kept, by " << violation
        << " of the largest displacement: another support or the stiffness of the shell contradicts"
           " it";
    summary->termination = SolverSummary::Termination::kNotConverged;
    summary->message = text.str();
  }

  summary->max_membrane_strain = summary->max_rotation = 0.0;
  const ShellSurface& surface = problem->surface();
  for (int e = 0; e < surface.num_elements(); ++e) {
    const auto& vertices = surface.control_vertices(e);
    for (const StrainPoint& p : *problem->strain_points()[e]) {
      Eigen::Matrix<double, 3, 2> d = Eigen::Matrix<double, 3, 2>::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        d += problem->displacements().col(vertices[i]) *
             p.weights.col(i).segment<2>(kRowD1).transpose();
      }
      Eigen::Vector3d strain;
      EvaluateMembraneStrain(problem->measure(), p, d.data(), strain.data());
      const double mean = 0.5 * (strain[0] + strain[1]);
      const double radius = std::hypot(0.5 * (strain[0] - strain[1]), 0.5 * strain[2]);
      summary->max_membrane_strain =
          std::max(summary->max_membrane_strain, std::abs(mean) + radius);
      const double linear = d.transpose().operator*(p.n).norm();
      double rotation = linear;
      if (problem->nonlinear()) {
        const Eigen::Vector3d normal =
            Eigen::Vector3d(p.t1 + d.col(0)).cross(Eigen::Vector3d(p.t2 + d.col(1)));
        rotation = std::atan2(normal.cross(p.n).norm(), normal.dot(p.n));
      }
      summary->max_rotation = std::max(summary->max_rotation, rotation);
    }
  }
}

// Better a message now than the kernel's kill signal after minutes.
bool FitsIntoMemory(const Scene& scene, std::string* error) {
  // Measured 20 kB per dof at 1e5 dof (tests/linear_solve_benchmark.cc); the factor's share grows.
  constexpr double kBytesPerDof = 2e4;
  const double dof = 3.0 * (scene.surface.divisions[0] + 3.0) * (scene.surface.divisions[1] + 3.0);
  const double needed = kBytesPerDof * dof;
  const double present = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
  if (needed <= present) return true;
  std::ostringstream text;
  text.precision(3);
  text << scene.surface.location.file << ":" << scene.surface.location.line
       << ": surface.divisions: found [" << scene.surface.divisions[0] << ", "
       << scene.surface.divisions[1] << "], " << dof << " dof, which need about "
       << needed / 1073741824.0 << " GiB; allowed is what fits into this machine's "
       << present / 1073741824.0 << " GiB";
  *error = text.str();
  return false;
}

}  // namespace

bool SolverOptions::IsValid(std::string* error) const {
  const auto fail = [&](const char* what) {
    *error = what;
    return false;
  };
  if (num_threads < 1) return fail("num_threads must be at least 1");
  if (max_iterations < 1) return fail("max_iterations must be at least 1");
  if (!(gradient_tolerance > 0.0)) return fail("gradient_tolerance must be positive");
  if (!(time_limit_s >= 0.0)) return fail("time_limit must not be negative");
  if (!(theory_tolerance > 0.0)) return fail("theory_tolerance must be positive");
  if (backend == SparseBackend::kSuiteSparse &&
      !ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE)) {
    return fail("this Ceres was built without SuiteSparse; use eigen");
  }
  return true;
}

std::string SolverSummary::BriefReport() const {
  std::ostringstream out;
  out << (IsConverged() ? "converged" : "NOT CONVERGED (" + message + ")") << ": "
      << ToString(theory) << " theory, " << dof << " dof";
  if (unknowns != dof) out << " (" << unknowns << " unknown)";
  out << ", " << iterations << (iterations == 1 ? " iteration" : " iterations") << ", set-up "
      << setup_s << " s, solve " << solve_s << " s";
  return out.str();
}

std::string SolverSummary::FullReport() const {
  std::ostringstream out;
  out << BriefReport() << "\n  " << elements << " elements, " << quadrature_points
      << " quadrature points, backend " << backend << "\n  theory: " << theory_reason << "\n";
  for (const EffectSummary& effect : effects) {
    char line[256];
    std::snprintf(line,
                  sizeof(line),
                  "  %-22s %-3s %8d blocks %8d residuals  energy % .6e  ",
                  effect.name.c_str(),
                  effect.report.on ? "on" : "off",
                  effect.report.residual_blocks,
                  effect.report.residuals,
                  effect.energy);
    out << line << effect.report.why << "\n";
  }
  out << "  relative gradient " << gradient_norm << ", force balance " << force_balance
      << "\n  largest displacement " << max_displacement << ", membrane strain "
      << max_membrane_strain << ", rotation " << max_rotation << " rad\n";
  for (const std::string& motion : free_motions) out << "  free: " << motion << "\n";
  for (const std::string& decision : decisions) out << "  " << decision << "\n";
  for (const ProbeSummary& probe : probes) {
    char line[256];
    std::snprintf(line,
                  sizeof(line),
                  "  probe %-16s displacement (% .9e, % .9e, % .9e)\n",
                  probe.name.c_str(),
                  probe.displacement.x(),
                  probe.displacement.y(),
                  probe.displacement.z());
    out << line;
  }
  return out.str();
}

bool Solve(const Scene& scene,
           const SolverOptions& options,
           std::unique_ptr<ShellProblem>* problem,
           SolverSummary* summary,
           std::string* error) {
  *summary = SolverSummary();
  if (!options.IsValid(error)) return false;
  if (!FitsIntoMemory(scene, error)) return false;
  const Clock::time_point start = Clock::now();
  const Deadline deadline{start, options.time_limit_s, options.stop};
  const auto terminate = [&](bool converged, const std::string& message) {
    using Termination = SolverSummary::Termination;
    summary->termination = converged             ? Termination::kConverged
                           : deadline.Stopped()  ? Termination::kStopped
                           : deadline.TimedOut() ? Termination::kTimeLimit
                                                 : Termination::kNotConverged;
    summary->message = converged ? "converged" : message;
  };

  Theory theory = scene.model.theory;
  std::string message;
  Equilibrium equilibrium;
  bool converged = false;

  // The linear theory comes first in any case: it is the answer, or the estimate that asks for the
  // nonlinear theory, or the start of its iteration.
  ShellProblem::Options problem_options;
  problem_options.num_threads = options.num_threads;
  *problem = ShellProblem::Create(scene, problem_options, error);
  if (*problem == nullptr) return false;
  summary->setup_s = Since(start);
  int linear_iterations = 0;
  {
    ShellProblem* linear = problem->get();
    converged = SolveLinear(linear, options, deadline, &linear_iterations, &equilibrium, &message);
    summary->solve_s = Since(start) - summary->setup_s;
    summary->theory_reason = "asked for by the scene";
    if (theory == Theory::kAuto) {
      const double tolerance = scene.model.accuracy.value_or(options.theory_tolerance);
      summary->nonlinearity_estimate = EstimateNonlinearity(*linear);
      const bool needed = summary->nonlinearity_estimate > tolerance;
      std::ostringstream reason;
      reason << "chosen: what the linear theory leaves out is estimated at "
             << summary->nonlinearity_estimate << " of the energy, "
             << (needed ? "above " : "within ") << tolerance;
      summary->theory_reason = reason.str();
      theory = converged && needed ? Theory::kNonlinear : Theory::kLinear;
    }
    if (theory == Theory::kLinear) {
      // The answer of the linear theory is proportional to the load.
      const Eigen::Matrix3Xd full = linear->displacements();
      for (int step = 1; step <= scene.steps; ++step) {
        const double factor = static_cast<double>(step) / scene.steps;
        linear->displacements() = factor * full;
        linear->SetLoadFactor(factor);
        RecordStep(linear,
                   factor,
                   step == 1 ? linear_iterations : 0,
                   converged,
                   equilibrium.relative_gradient,
                   options,
                   start,
                   summary);
      }
      terminate(converged, message);
      Finish(linear, options, equilibrium, summary);
      return true;
    }
  }
  const Eigen::Matrix3Xd linear_solution = (*problem)->displacements();
  std::vector<double> multipliers = (*problem)->multipliers();

  const auto out_of_time = [&] { return deadline.Stopped() || deadline.TimedOut(); };
  if (out_of_time()) {
    // The linear solution is the last good state.
    converged = false;
    message = deadline.Stopped() ? "stopped by the user before the nonlinear solve"
                                 : "time limit reached before the nonlinear solve";
    RecordStep(problem->get(),
               1.0,
               linear_iterations,
               false,
               equilibrium.relative_gradient,
               options,
               start,
               summary);
    terminate(false, message);
    Finish(problem->get(), options, equilibrium, summary);
    return true;
  }

  const double before = Since(start);
  problem_options.nonlinear = true;
  *problem = ShellProblem::Create(scene, problem_options, error);
  if (*problem == nullptr) return false;
  ShellProblem* nonlinear = problem->get();
  summary->setup_s += Since(start) - before;
  const double solve_start = Since(start);
  Eigen::Matrix3Xd good = nonlinear->displacements();
  double good_factor = 0.0;
  for (int step = 1; step <= scene.steps; ++step) {
    const double target = static_cast<double>(step) / scene.steps;
    const double from = good_factor;
    int iterations = step == 1 ? linear_iterations : 0;
    // What the first attempt, straight to the asked load, ended with.
    Eigen::Matrix3Xd direct;
    Equilibrium direct_equilibrium;
    std::string direct_message;
    // Straight to the asked load; where that fails, in 5, then 20 parts from the last good state.
    for (const int parts : {1, 5, 20}) {
      nonlinear->displacements() = good;
      converged = true;
      const double begin = good_factor;
      for (int part = 1; part <= parts && converged; ++part) {
        const double factor = begin + (target - begin) * part / parts;
        nonlinear->SetLoadFactor(factor);
        if (good_factor == 0.0) {
          std::vector<double> start = multipliers;
          for (double& multiplier : start) multiplier *= factor;
          nonlinear->SetMultipliers(start);
          const double multiple = StartFromLinear(factor * linear_solution, nonlinear);
          std::ostringstream decision;
          decision << "start: " << multiple << " of the linear solution at load factor " << factor;
          summary->decisions.push_back(decision.str());
        }
        int used = 0;
        converged = SolveNonlinear(nonlinear, options, deadline, &used, &equilibrium, &message);
        iterations += used;
        if (converged) {
          good = nonlinear->displacements();
          good_factor = factor;
        }
      }
      if (parts == 1) {
        direct = nonlinear->displacements();
        direct_equilibrium = equilibrium;
        direct_message = message;
      }
      // Smaller steps do not help where equilibrium is reached but for the last digits.
      constexpr double kNearly = 100.0;
      if (converged || out_of_time() ||
          (parts == 1 && equilibrium.relative_gradient <= kNearly * options.gradient_tolerance)) {
        break;
      }
      if (parts < 20) {
        std::ostringstream decision;
        decision << "load factor " << target << " not reached in " << parts
                 << (parts == 1 ? " step (" : " steps (") << message << "): cut";
        summary->decisions.push_back(decision.str());
      }
    }
    if (!converged) {
      // The last good state; where the step has none, what the first attempt came to.
      if (good_factor > from) {
        nonlinear->displacements() = good;
        nonlinear->SetLoadFactor(good_factor);
        std::ostringstream text;
        text << message << "; the results are the last good state, at load factor " << good_factor;
        message = text.str();
      } else {
        nonlinear->displacements() = direct;
        nonlinear->SetLoadFactor(target);
        message = direct_message;
      }
      equilibrium = CheckEquilibrium(nonlinear);
    }
    RecordStep(nonlinear,
               nonlinear->load_factor(),
               iterations,
               converged,
               equilibrium.relative_gradient,
               options,
               start,
               summary);
    if (!converged) break;
  }
  summary->solve_s += Since(start) - solve_start;
  terminate(converged, message);
  Finish(nonlinear, options, equilibrium, summary);
  return true;
}

}  // namespace darboux
