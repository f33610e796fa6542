#include "solver/goal_response.h"

#include <algorithm>
#include <cmath>
#include <memory>

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

// The true tangent of a state and its gradient.
struct FactorizedTangent {
  FactorizedTangent(ShellProblem* problem, SparseBackend backend, int num_threads)
      : stiffness(problem, backend, num_threads), cholesky(SparseCholesky::Create(backend)) {}

  // False where it is singular.
  bool Factorize(const ShellProblem& problem) {
    cholesky.Analyze(stiffness.matrix());
    TangentStiffness::Request request;
    request.gradient = &gradient;
    const Eigen::MatrixXd none(stiffness.num_unknowns(), 0);
    return stiffness.Evaluate(request) && EvaluateTrueTangent(&stiffness) &&
           FactorizeTangent(problem, stiffness, none, 0.0, &cholesky);
  }

  TangentStiffness stiffness;
  UpdatedCholesky cholesky;
  Eigen::VectorXd gradient;
};

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
  const ShellSurface& surface = problem->surface();
  const Eigen::Matrix3Xd& state = const_cast<const ShellProblem*>(problem)->displacements();
  std::unique_ptr<FactorizedTangent> tangent;  // Without functionals there is nothing to solve.
  for (const Goal& goal : goals) {
    if (goal.probe < 0) {
      const double work = (problem->DeadForce().array() * state.array()).sum();
      response->duals.push_back(work != 0.0 ? (state / std::abs(work)).eval() : state);
      continue;
    }
    if (tangent == nullptr) {
      tangent = std::make_unique<FactorizedTangent>(problem, backend, num_threads);
      if (!tangent->Factorize(*problem)) return false;
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
    const Eigen::VectorXd z = Response(
        problem, tangent->stiffness, &tangent->cholesky, tangent->stiffness.Reduce(functional));
    if (!z.allFinite()) return false;
    response->solver_error = std::max(response->solver_error, std::abs(z.dot(tangent->gradient)));
    response->duals.push_back(tangent->stiffness.Expand(z));
  }
  return true;
}

}  // namespace darboux
