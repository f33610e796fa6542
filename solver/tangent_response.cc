#include "solver/tangent_response.h"

#include <cmath>

namespace darboux {
namespace {

// Contact for derivatives, relative to that of the solver: what its give adds to a travel is about
// 1e-6 of what the shell's does. A power of two, see Grasp::Stiffen.
constexpr double kRigid = 1024.0;
// Mean conditions, relative to what bounds the steps of the solver: nothing, if rounding allows.
constexpr double kMeans[] = {1e-8, 1e-3};

}  // namespace

RigidContact::RigidContact(Grasp* grasp) : grasp_(grasp) {
  if (grasp_ == nullptr) return;
  state_ = grasp_->state();
  grasp_->HoldTravels(true);
  grasp_->Stiffen(kRigid);
}

RigidContact::~RigidContact() {
  if (grasp_ == nullptr) return;
  grasp_->HoldTravels(false);
  grasp_->Stiffen(1.0 / kRigid);
  grasp_->SetState(state_);
}

bool FactorizeTangent(const ShellProblem& problem,
                      const TangentStiffness& tangent,
                      const Eigen::MatrixXd& springs,
                      double stiffness,
                      UpdatedCholesky* cholesky) {
  const Eigen::Index pins = problem.pins().size(), means = problem.mean_conditions().size();
  const Eigen::MatrixXd& update = tangent.update_vectors();
  Eigen::MatrixXd vectors(tangent.num_unknowns(), update.cols() + springs.cols());
  vectors << update, springs;
  for (const double least : kMeans) {
    Eigen::VectorXd weights = Eigen::VectorXd::Constant(vectors.cols(), stiffness);
    weights.head(update.cols()) = tangent.update_weights();
    weights.segment(pins, means) *= least;
    cholesky->SetUpdate(vectors, weights);
    if (cholesky->Factorize(tangent.matrix())) return true;
    if (means == 0) break;
  }
  return cholesky->FactorizeIndefinite(tangent.matrix()) >= 0;
}

bool EvaluateTangent(TangentStiffness* tangent) {
  TangentStiffness::StressField stresses;
  TangentStiffness::Request strains, matrix;
  strains.stresses = &stresses;
  matrix.matrix = true;
  matrix.initial_stresses = &stresses;
  return tangent->Evaluate(strains) && tangent->Evaluate(matrix);
}

Eigen::VectorXd Response(ShellProblem* problem,
                         const TangentStiffness& tangent,
                         SparseCholesky* cholesky,
                         const Eigen::VectorXd& forces) {
  constexpr int kPasses = 3;
  Eigen::VectorXd held = Eigen::VectorXd::Zero(forces.size());
  Eigen::VectorXd response = cholesky->Solve(forces);
  if (problem->conditions().empty()) return response;
  // The supports' gradient is linear, so that a step of any size will do; one of the size of the
  // thickness keeps the digits.
  const Eigen::Matrix3Xd state = problem->displacements();
  const Eigen::Matrix3Xd before = problem->SupportGradient();
  for (int pass = 1; pass < kPasses; ++pass) {
    const Eigen::Matrix3Xd way = tangent.Expand(response);
    const double size = way.cwiseAbs().maxCoeff();
    if (!(size > 0.0) || !std::isfinite(size)) break;
    const double part = problem->material().thickness / size;
    problem->displacements() = state + part * way;
    held += tangent.Reduce(problem->SupportGradient() - before) / part;
    problem->displacements() = state;
    response = cholesky->Solve(forces - held);
  }
  return response;
}

}  // namespace darboux
