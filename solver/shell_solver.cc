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

#include "solver/gas_start.h"
#include "solver/load_stepping.h"
#include "solver/mesh_surface.h"
#include "solver/minimisation.h"
#include "solver/parallel_for.h"
#include "solver/path_following.h"
#include "solver/stability.h"

namespace darboux {
namespace {

// Over the vertices and one point inside each element.
double MaxDisplacement(const ShellProblem& problem, int num_threads) {
  const std::vector<ElementPoint>& vertex_points = problem.surface().vertex_points();
  const int num_vertices = static_cast<int>(vertex_points.size());
  const int num_elements = problem.surface().num_elements();
  const int threads = ThreadsFor(num_elements, num_threads);
  std::vector<double> largest(threads, 0.0);
  ParallelFor(threads, num_vertices + num_elements, [&](int thread, int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      if (k < num_vertices) {
        u = problem.Displacement(vertex_points[k]);
      } else {
        const int e = k - num_vertices;
        const auto& vertices = problem.surface().control_vertices(e);
        const StrainPoint& p = problem.strain_points()[e]->front();
        for (size_t i = 0; i < vertices.size(); ++i) {
          u += p.weights(kRowValue, i) * problem.displacements().col(vertices[i]);
        }
      }
      largest[thread] = std::max(largest[thread], u.norm());
    }
  });
  return *std::max_element(largest.begin(), largest.end());
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
  step.max_displacement = MaxDisplacement(*problem, options.num_threads);
  step.reaction = problem->Reaction();
  for (const ProbeSpec& probe : problem->scene().probes) {
    step.probe_displacements.push_back(
        problem->Displacement(Resolve(probe.at, problem->surface())));
  }
  step.displacements = problem->displacements();
  if (problem->grasp() != nullptr) {
    step.fingers = problem->grasp()->Report(problem->force_unit());
    step.contact_points = problem->grasp()->ReportPoints(problem->force_unit());
  }
  if (problem->has_gas()) step.gas = problem->ReportGas();
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

void RecordStability(const Stability& stability, LoadStep* step) {
  if (stability.negative_modes < 0) return;
  step->negative_modes = stability.negative_modes;
  if (std::isfinite(stability.softness)) step->softness = stability.softness;
  step->mode = stability.mode;
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

// The largest membrane strain and rotation over the quadrature points, and a decision where the
// surface is compressed beyond what its material is made for.
void FindExtremes(const ShellProblem& problem, int num_threads, SolverSummary* summary) {
  const ShellSurface& surface = problem.surface();
  const int threads = ThreadsFor(surface.num_elements(), num_threads);
  struct Compression {
    double strain = 0.0;  // smallest principal, below zero
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
  };
  std::vector<double> largest_strain(threads, 0.0), largest_rotation(threads, 0.0);
  std::vector<Compression> compressions(threads);
  ParallelFor(threads, surface.num_elements(), [&](int thread, int begin, int end) {
    double largest = 0.0, turned = 0.0;
    Compression most;
    for (int e = begin; e < end; ++e) {
      const auto& vertices = surface.control_vertices(e);
      for (const StrainPoint& p : *problem.strain_points()[e]) {
        Eigen::Matrix<double, 3, 2> d = Eigen::Matrix<double, 3, 2>::Zero();
        for (size_t i = 0; i < vertices.size(); ++i) {
          d += problem.displacements().col(vertices[i]) *
               p.weights.col(i).segment<2>(kRowD1).transpose();
        }
        Eigen::Vector3d strain;
        EvaluateMembraneStrain(problem.measure(), p, d.data(), strain.data());
        const double mean = 0.5 * (strain[0] + strain[1]);
        const double radius = std::hypot(0.5 * (strain[0] - strain[1]), 0.5 * strain[2]);
        largest = std::max(largest, std::abs(mean) + radius);
        if (mean - radius < most.strain) most = {mean - radius, p.position};
        double rotation = d.transpose().operator*(p.n).norm();
        if (problem.nonlinear()) {
          const Eigen::Vector3d normal =
              Eigen::Vector3d(p.t1 + d.col(0)).cross(Eigen::Vector3d(p.t2 + d.col(1)));
          rotation = std::atan2(normal.cross(p.n).norm(), normal.dot(p.n));
        }
        turned = std::max(turned, rotation);
      }
    }
    largest_strain[thread] = largest;
    largest_rotation[thread] = turned;
    compressions[thread] = most;
  });
  summary->max_membrane_strain = *std::max_element(largest_strain.begin(), largest_strain.end());
  summary->max_rotation = *std::max_element(largest_rotation.begin(), largest_rotation.end());

  constexpr double kFar = 1.0;  // rad
  if (!problem.nonlinear() && summary->max_rotation > kFar) {
    std::ostringstream line;
    line << "beyond the linear theory: it takes rotations for small, here they reach "
         << summary->max_rotation << " rad; its answer is proportional to the loads, no more";
    summary->decisions.push_back(line.str());
  }

  // A strip of St. Venant-Kirchhoff material of l times its length resists with E h l (1 - l^2) /
  // 2: most at l = 1/sqrt(3), Green strain -1/3, less beyond, not at all at l = 0, Green strain
  // -1/2.
  constexpr double kCrushed = -0.3;
  const Compression& most = *std::min_element(
      compressions.begin(), compressions.end(), [](const Compression& a, const Compression& b) {
        return a.strain < b.strain;
      });
  if (problem.nonlinear() && most.strain < kCrushed) {
    std::ostringstream line;
    line << "crushed: membrane strain " << most.strain << " at (" << most.position.x() << ", "
         << most.position.y() << ", " << most.position.z()
         << ") at rest; past -1/3 the St. Venant-Kirchhoff material gives way (-1/2: no length is"
            " left) and is no model; spread a force over about a thickness or take coarser cells"
            " under it";
    summary->decisions.push_back(line.str());
  }
}

// A finger begins to push when it reaches the contact points beside the place it touches first.
void NoteGaps(SolverSummary* summary) {
  constexpr double kNoticed = 0.01;  // of the travel
  for (const FingerReport& finger : summary->steps.back().fingers) {
    if (finger.gap <= kNoticed * std::abs(finger.travel)) continue;
    std::ostringstream line;
    line << "finger " << finger.name << ": the contact points nearest to where it touches lie "
         << finger.gap << " off its way, of a travel of " << finger.travel
         << "; finer elements bring them nearer";
    summary->decisions.push_back(line.str());
  }
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
  double forces =
      std::max(summary->reaction.norm() + summary->applied_force.norm(), equilibrium.reference);
  Eigen::Vector3d resultant = summary->reaction + summary->applied_force;
  for (const FingerReport& finger : state.fingers) {
    resultant -= finger.force;
    forces = std::max(forces, finger.force.norm());
  }
  summary->force_balance = forces > 0.0 ? resultant.norm() / forces : 0.0;
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

  FindExtremes(*problem, options.num_threads, summary);
  summary->resolution = CheckResolution(*problem, options.num_threads);
  if (summary->resolution) {
    const std::string complaint = summary->resolution->Complaint();
    if (!complaint.empty()) summary->decisions.push_back(complaint);
  }
}

// Better a message now than the kernel's kill signal after minutes.
bool FitsIntoMemory(const Scene& scene, std::string* error) {
  // Measured 20 kB per dof at 1e5 dof (tests/linear_solve_benchmark.cc); the factor's share grows.
  constexpr double kBytesPerDof = 2e4;
  const SurfaceSpec& surface = scene.surface;
  double dof = surface.mesh != nullptr
                   ? 3.0 * surface.mesh->vertices.size()
                   : 3.0 * (surface.divisions[0] + 3.0) * (surface.divisions[1] + 3.0);
  if (surface.mesh != nullptr && IsRefinedLocally(surface)) {
    // Without the solve for control points, which move what is near a point by little.
    const auto mesh = RefineBaseMesh(surface, MakeLoopMesh(*surface.mesh), error);
    if (mesh == nullptr) return false;
    dof = 3.0 * mesh->mesh().mesh.num_vertices;
  }
  const double needed = kBytesPerDof * dof;
  const double present = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
  if (needed <= present) return true;
  std::ostringstream text;
  text.precision(3);
  const char* const key = surface.mesh == nullptr       ? "divisions"
                          : surface.kind == "icosphere" ? "frequency"
                          : surface.kind == "implicit"  ? "edge_length"
                                                        : "file";
  text << scene.surface.location.file << ":" << scene.surface.location.line << ": surface." << key
       << ": found " << dof << " dof, which need about " << needed / 1073741824.0
       << " GiB; allowed is what fits into this machine's " << present / 1073741824.0 << " GiB";
  *error = text.str();
  return false;
}

// What is not there for gas. False and *error where the scene asks for it.
bool CheckGas(const Scene& scene, std::string* error) {
  const LoadSpec* const gas = FindGas(scene);
  if (gas == nullptr || scene.model.minimizer != Minimizer::kCg) return true;
  const SceneLocation& where = gas->location;
  *error = where.file + ":" + std::to_string(where.line) + ": " + where.key +
           ": found gas with minimizer cg; allowed with gas: auto | mip | ceres";
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
  if (kept_factors > 0) {
    out << "  " << kept_factors << " steps took the matrix and factor of the one before: about "
        << kept_factors_saved_s << " s saved\n";
  }
  if (!steps.empty()) {
    for (const FingerReport& finger : steps.back().fingers) {
      out << "  finger " << finger.name << ": travel " << finger.travel << ", normal force "
          << finger.normal_force << ", contact area " << finger.contact_area << ", penetration "
          << finger.penetration << "\n";
    }
  }
  if (!steps.empty() && steps.back().gas) {
    const GasReport& gas = *steps.back().gas;
    out << "  gas: gauge pressure " << gas.gauge_pressure << ", volume " << gas.volume << ", "
        << gas.volume_ratio << " of that at rest\n";
  }
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
  summary->decisions = scene.surface.mended;
  problem->reset();
  if (!options.IsValid(error)) return false;
  if (!FitsIntoMemory(scene, error) || !CheckGas(scene, error)) return false;
  const Clock::time_point start = Clock::now();
  IterationLog log(start, scene.steps, options.on_iteration, &summary->iteration_history);
  const Deadline deadline{start, options.time_limit_s, options.stop, &log};
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

  // The linear theory is the answer, or the estimate that asks for the nonlinear theory, or the
  // start of descent. The mixed iteration starts from rest: its first step is the linear one.
  ShellProblem::Options problem_options;
  problem_options.num_threads = options.num_threads;
  summary->theory_reason = "asked for by the scene";
  int linear_iterations = 0;
  Eigen::Matrix3Xd linear_solution;
  std::vector<double> multipliers;
  const bool descends = scene.model.minimizer == Minimizer::kCeres;
  if (theory == Theory::kAuto && scene.path.control != PathControl::kLoad) {
    theory = Theory::kNonlinear;
    summary->theory_reason = "the scene asks for an equilibrium path";
  }
  if (theory == Theory::kAuto && !scene.fingers.empty()) {
    theory = Theory::kNonlinear;
    summary->theory_reason = "the scene has fingers";
  }
  const LoadSpec* const gas = FindGas(scene);
  if (theory == Theory::kAuto && gas != nullptr) {
    theory = Theory::kNonlinear;
    summary->theory_reason = "the scene has gas";
  }
  const bool linear_contact = theory == Theory::kLinear && !scene.fingers.empty();
  const bool starts_linear = descends && scene.fingers.empty() && gas == nullptr;
  // With gas the theory is settled here.
  Eigen::Matrix3Xd prestress;
  problem_options.nonlinear = theory == Theory::kNonlinear;
  if (!FindPrestress(scene, problem_options, options.backend, &prestress, error)) return false;
  problem_options.nonlinear = false;
  problem_options.prestress = prestress;
  if ((theory != Theory::kNonlinear && !linear_contact) || starts_linear) {
    *problem = ShellProblem::Create(scene, problem_options, error);
    if (*problem == nullptr) return false;
    summary->setup_s = Since(start);
    ShellProblem* linear = problem->get();
    Eigen::Matrix3Xd unloaded = Eigen::Matrix3Xd::Zero(3, linear->displacements().cols());
    if (gas != nullptr && scene.steps > 1) {
      // The gas is there whatever the load factor.
      linear->SetLoadFactor(0.0);
      SolveLinear(linear, options, deadline, &linear_iterations, &equilibrium, &message);
      unloaded = linear->displacements();
      linear->SetLoadFactor(1.0);
    }
    converged = SolveLinear(linear, options, deadline, &linear_iterations, &equilibrium, &message);
    summary->solve_s = Since(start) - summary->setup_s;
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
      // What the loads do in the linear theory is proportional to them.
      const Eigen::Matrix3Xd full = linear->displacements();
      for (int step = 1; step <= scene.steps; ++step) {
        const double factor = static_cast<double>(step) / scene.steps;
        linear->displacements() = unloaded + factor * (full - unloaded);
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
      log.Record(IterationReport::Method::kLinear,
                 1.0,
                 linear_iterations,
                 summary->steps.back().energy,
                 equilibrium.relative_gradient);
      terminate(converged, message);
      Finish(linear, options, equilibrium, summary);
      return true;
    }
    linear_solution = linear->displacements();
    multipliers = linear->multipliers();
  } else {
    summary->setup_s = summary->solve_s = 0.0;
  }
  const auto out_of_time = [&] { return deadline.Stopped() || deadline.TimedOut(); };
  if (*problem != nullptr && out_of_time()) {
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
  problem_options.nonlinear = !linear_contact;
  int inflation_iterations = 0;
  if (gas != nullptr && !scene.fingers.empty() && !gas->prestressed && gas->gauge_pressure != 0.0) {
    // Fingers find the shell as the gas has inflated it.
    LoadStepping::Result inflated;
    *problem = InflateBare(
        scene, problem_options, options, deadline, &summary->decisions, &inflated, error);
    if (*problem == nullptr) return false;
    if (!inflated.converged) {
      RecordStep(problem->get(),
                 0.0,
                 inflated.iterations,
                 false,
                 inflated.equilibrium.relative_gradient,
                 options,
                 start,
                 summary);
      summary->solve_s = Since(start) - summary->setup_s;
      terminate(false, inflated.message);
      Finish(problem->get(), options, inflated.equilibrium, summary);
      return true;
    }
    inflation_iterations = inflated.iterations;
    problem_options.start = (*problem)->displacements();
    problem_options.start_multipliers = (*problem)->multipliers();
  }
  *problem = ShellProblem::Create(scene, problem_options, error);
  if (*problem == nullptr) return false;
  ShellProblem* nonlinear = problem->get();
  summary->setup_s += Since(start) - before;
  const double solve_start = Since(start);
  if (scene.path.control != PathControl::kLoad) {
    PathFollowing following(nonlinear, options, deadline, &summary->decisions);
    const auto on_point = [&](const PathFollowing::Point& point) {
      RecordStep(nonlinear,
                 point.factor,
                 point.iterations,
                 true,
                 point.relative_gradient,
                 options,
                 start,
                 summary);
      log.BeginStep(static_cast<int>(summary->steps.size()) + 1);
      summary->steps.back().limit_point = point.limit_point;
      RecordStability(point.stability, &summary->steps.back());
    };
    converged = following.Follow(on_point, &message);
    if (nonlinear->NeedsCorrection()) nonlinear->UpdateCorrection();
    equilibrium = CheckEquilibrium(nonlinear);
    if (summary->steps.empty()) {
      RecordStep(nonlinear,
                 nonlinear->load_factor(),
                 0,
                 false,
                 equilibrium.relative_gradient,
                 options,
                 start,
                 summary);
    }
  } else {
    LoadStepping stepping(nonlinear, options, deadline, &summary->decisions);
    if (linear_solution.size() > 0) stepping.SetLinearSolution(linear_solution, multipliers);
    if (options.initial_displacements.size() > 0) {
      if (options.initial_displacements.cols() != nonlinear->displacements().cols()) {
        *error = "initial_displacements has " +
                 std::to_string(options.initial_displacements.cols()) +
                 " columns; allowed is one " + "per control vertex, " +
                 std::to_string(nonlinear->displacements().cols());
        return false;
      }
      stepping.SetStart(options.initial_displacements, options.initial_contact);
    }
    for (int step = 1; step <= scene.steps; ++step) {
      log.BeginStep(step);
      LoadStepping::Result result = stepping.Advance(static_cast<double>(step) / scene.steps);
      Stability stability = CheckStability(&stepping.mixed());
      if (result.converged && stability.negative_modes > 0 &&
          scene.model.unstable == Unstable::kLeave) {
        const int before = result.iterations;
        result = stepping.LeaveUnstable(stability.mode);
        result.iterations += before;
        stability = CheckStability(&stepping.mixed());
      }
      converged = result.converged;
      equilibrium = result.equilibrium;
      message = result.message;
      if (converged && step == scene.steps && nonlinear->grasp() != nullptr) {
        message = nonlinear->grasp()->FaultAtTheEnd();
        converged = message.empty();
      }
      RecordStep(nonlinear,
                 nonlinear->load_factor(),
                 result.iterations + (step == 1 ? linear_iterations + inflation_iterations : 0),
                 converged,
                 equilibrium.relative_gradient,
                 options,
                 start,
                 summary);
      RecordStability(stability, &summary->steps.back());
      summary->steps.back().limit_factor = stepping.limit_factor();
      summary->steps.back().limit_point = stepping.limit_factor().has_value();
      if (stepping.quality() != nullptr) {
        LoadStep& last = summary->steps.back();
        double energy = 0.0;
        for (const Effect effect : {Effect::kMembrane, Effect::kBending, Effect::kGas}) {
          energy += last.energies[static_cast<int>(effect)];
        }
        last.grasp = stepping.quality()->Report(last.fingers, energy, converged);
      }
      if (!converged) break;
    }
    summary->kept_factors = stepping.chords();
    summary->kept_factors_saved_s = stepping.saved_s();
  }
  summary->solve_s += Since(start) - solve_start;
  NoteGaps(summary);
  terminate(converged, message);
  Finish(nonlinear, options, equilibrium, summary);
  return true;
}

}  // namespace darboux
