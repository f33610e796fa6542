#include "solver/goal_response.h"

#include <algorithm>
#include <cmath>

#include "solver/equilibrium_response.h"
#include "solver/support_conditions.h"
#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

// Probes that move less, relative to the largest displacement, are measured against this.
constexpr double kStill = 1e-4;

Goal ScalarGoal(const std::string& name, double value) {
  return {name, value * Eigen::Vector3d::UnitX(), std::abs(value), -1};
}

}  // namespace

std::vector<Goal> GoalsOf(const Scene& scene, const SolverSummary& summary) {
  std::vector<Goal> goals;
  for (size_t i = 0; i < summary.probes.size(); ++i) {
    const ProbeSummary& probe = summary.probes[i];
    goals.push_back({"probes." + probe.name,
                     probe.displacement,
                     std::max(probe.displacement.norm(), kStill * summary.max_displacement),
                     static_cast<int>(i)});
  }
  if (!summary.steps.empty()) {
    const std::vector<FingerReport>& fingers = summary.steps.back().fingers;
    for (size_t i = 0; i < fingers.size(); ++i) {
      const std::string name = "fingers." + fingers[i].name;
      goals.push_back(scene.fingers[i].force
                          ? ScalarGoal(name + ".travel", fingers[i].travel)
                          : ScalarGoal(name + ".normal_force", fingers[i].normal_force));
    }
  }
  if (goals.empty()) {
    goals.push_back(ScalarGoal("max_displacement", summary.max_displacement));
    goals.push_back(ScalarGoal("energy.total", summary.energy_total));
  }
  return goals;
}

bool EvaluateGoalResponse(ShellProblem* problem,
                          const std::vector<Goal>& goals,
                          SparseBackend backend,
                          int num_threads,
                          GoalResponse* response) {
  *response = GoalResponse();
  const bool has_probes =
      std::any_of(goals.begin(), goals.end(), [](const Goal& goal) { return goal.probe >= 0; });
  const ShellSurface& surface = problem->surface();
  const Eigen::Matrix3Xd& state = const_cast<const ShellProblem*>(problem)->displacements();
  // Without functionals there is nothing to solve.
  TangentStiffness tangent(problem, backend, num_threads);
  UpdatedCholesky cholesky(SparseCholesky::Create(backend));
  Eigen::VectorXd gradient;
  if (has_probes) {
    cholesky.Analyze(tangent.matrix());
    TangentStiffness::Request request;
    request.gradient = &gradient;
    const Eigen::MatrixXd none(tangent.num_unknowns(), 0);
    if (!tangent.Evaluate(request) || !EvaluateTrueTangent(&tangent) ||
        !FactorizeTangent(*problem, tangent, none, 0.0, &cholesky)) {
      return false;
    }
  }
  for (const Goal& goal : goals) {
    if (goal.probe < 0) {
      const double work = (problem->DeadForce().array() * state.array()).sum();
      response->duals.push_back(work != 0.0 ? (state / std::abs(work)).eval() : state);
      continue;
    }
    const ElementPoint at = Resolve(problem->scene().probes[goal.probe].at, surface);
    const std::vector<int>& vertices = surface.control_vertices(at.element);
    const Eigen::VectorXd weights = surface.ValueWeights(at);
    const double norm = goal.value.norm();
    const Eigen::Vector3d direction =
        norm > 0.0 ? (goal.value / norm).eval() : Eigen::Vector3d::UnitX().eval();
    Eigen::Matrix3Xd functional = Eigen::Matrix3Xd::Zero(3, state.cols());
    const double scale = goal.size > 0.0 ? 1.0 / goal.size : 0.0;
    for (size_t i = 0; i < vertices.size(); ++i) {
      functional.col(vertices[i]) += scale * weights[i] * direction;
    }
    const Eigen::VectorXd z = Response(problem, tangent, &cholesky, tangent.Reduce(functional));
    if (!z.allFinite()) return false;
    response->solver_error = std::max(response->solver_error, std::abs(z.dot(gradient)));
    response->duals.push_back(tangent.Expand(z));
  }
  return true;
}

}  // namespace darboux
