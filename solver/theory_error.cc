#include "solver/theory_error.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "solver/equilibrium_response.h"
#include "solver/support_conditions.h"
#include "solver/tangent_stiffness.h"

namespace darboux {

bool EstimateTheoryError(const ShellProblem& linear,
                         const std::vector<Goal>& goals,
                         SparseBackend backend,
                         int num_threads,
                         TheoryError* result,
                         std::string* error) {
  CHECK(!linear.nonlinear());
  CHECK(linear.grasp() == nullptr && !linear.has_gas());
  *result = TheoryError();
  ShellProblem::Options options;
  options.nonlinear = true;
  options.num_threads = num_threads;
  const std::unique_ptr<ShellProblem> problem =
      ShellProblem::Create(linear.scene(), options, error);
  if (problem == nullptr) return false;
  problem->SetLoadFactor(linear.load_factor());
  problem->displacements() = linear.displacements();
  if (linear.multipliers().size() == problem->multipliers().size()) {
    problem->SetMultipliers(linear.multipliers());
  }

  result->value = std::numeric_limits<double>::infinity();
  TangentStiffness tangent(problem.get(), backend, num_threads);
  Eigen::VectorXd gradient;
  TangentStiffness::StressField stresses;
  TangentStiffness::Request request;
  request.gradient = &gradient;
  request.stresses = &stresses;
  if (!tangent.Evaluate(request)) return true;
  TangentStiffness::Request matrix;
  matrix.matrix = true;
  matrix.initial_stresses = &stresses;
  if (!tangent.Evaluate(matrix)) return true;
  UpdatedCholesky cholesky(SparseCholesky::Create(backend));
  cholesky.SetUpdate(tangent.update_vectors(), tangent.update_weights());
  cholesky.Analyze(tangent.matrix());
  if (!cholesky.Factorize(tangent.matrix())) return true;
  const Eigen::VectorXd step = Response(problem.get(), tangent, &cholesky, -gradient);
  if (!step.allFinite()) return true;

  const Eigen::Matrix3Xd change = tangent.Expand(step);
  const ShellSurface& surface = problem->surface();
  const auto displacement = [&](const Eigen::Matrix3Xd& field, const ElementPoint& at) {
    const std::vector<int>& vertices = surface.control_vertices(at.element);
    const Eigen::VectorXd weights = surface.ValueWeights(at);
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < vertices.size(); ++i) u += weights[i] * field.col(vertices[i]);
    return u;
  };
  result->value = 0.0;
  for (const Goal& goal : goals) {
    double relative = 0.0;
    if (goal.probe >= 0) {
      const ElementPoint at = Resolve(problem->scene().probes[goal.probe].at, surface);
      const double moved = displacement(change, at).norm();
      if (moved > 0.0) relative = moved / goal.size;
    } else {
      double moved = 0.0, largest = 0.0;
      for (const ElementPoint& at : surface.vertex_points()) {
        moved = std::max(moved, displacement(change, at).norm());
        largest = std::max(largest, displacement(linear.displacements(), at).norm());
      }
      if (moved > 0.0) relative = moved / largest;
    }
    if (relative > result->value) {
      result->value = relative;
      result->goal = goal.name;
    }
  }
  return true;
}

}  // namespace darboux
