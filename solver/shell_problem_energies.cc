#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "solver/parallel_for.h"
#include "solver/shell_problem.h"

// Energies, gradients and forces of the present state.

namespace darboux {

void ShellProblem::SetLoadFactor(double factor) {
  load_factor_ = factor;
  if (grasp_ != nullptr) grasp_->SetLoadFactor(factor);
  force_ = factor * dead_loads_.force + correction_ + held_;
  SetTargets();
}

void ShellProblem::SetAngleReferences() {
  for (const auto& moment : moments_) {
    moment.second->SetReference(Blocks(surface_->control_vertices(moment.first)).data());
  }
}

double ShellProblem::UpdateCorrection() {
  if (followers_.empty()) return 0.0;
  UpdateGas();
  Eigen::Matrix3Xd exact = Eigen::Matrix3Xd::Zero(3, force_.cols());
  Eigen::Matrix3Xd potential = exact;
  std::vector<double> gradient;
  for (const auto& follower : followers_) {
    const auto& vertices = surface_->control_vertices(follower.first);
    const std::vector<double*> blocks = Blocks(vertices);
    const Eigen::Matrix3Xd force = follower.second->ExactForce(blocks.data());
    // -dU/du through the block's own residual and Jacobian: J^T r.
    double residual;
    gradient.assign(3 * vertices.size(), 0.0);
    std::vector<double*> jacobians;
    for (size_t i = 0; i < vertices.size(); ++i) jacobians.push_back(&gradient[3 * i]);
    follower.second->Evaluate(blocks.data(), &residual, jacobians.data());
    for (size_t i = 0; i < vertices.size(); ++i) {
      exact.col(vertices[i]) += force.col(i);
      potential.col(vertices[i]) -= residual * Eigen::Map<Eigen::Vector3d>(jacobians[i]);
    }
  }
  const Eigen::Matrix3Xd correction = exact - potential;
  const double size = exact.norm();
  const double change = size > 0.0 ? (correction - correction_).norm() / size : 0.0;
  correction_ = correction;
  SetLoadFactor(load_factor_);
  return change;
}

double ShellProblem::StrainEnergyOf(const std::vector<const ceres::CostFunction*>& costs) const {
  const int count = static_cast<int>(costs.size());
  const int num_threads = ThreadsFor(count, options_.num_threads);
  std::vector<double> energies(num_threads, 0.0);
  ParallelFor(num_threads, count, [&](int thread, int begin, int end) {
    double energy = 0.0;
    std::vector<double> residuals, at_rest;
    std::vector<const double*> blocks, rest;
    const double zero[3] = {};
    for (int e = begin; e < end; ++e) {
      blocks.clear();
      for (const int vertex : surface_->control_vertices(e)) {
        blocks.push_back(displacements_.col(vertex).data());
      }
      residuals.resize(costs[e]->num_residuals());
      if (!costs[e]->Evaluate(blocks.data(), residuals.data(), nullptr)) {
        energy = std::numeric_limits<double>::infinity();
        break;
      }
      const Eigen::Map<Eigen::VectorXd> r(residuals.data(), residuals.size());
      if (initial_strains_.empty()) {
        energy += 0.5 * r.squaredNorm();
        continue;
      }
      // Beyond the energy of the initial stress, which is no work of the loads.
      rest.assign(blocks.size(), zero);
      at_rest.resize(residuals.size());
      CHECK(costs[e]->Evaluate(rest.data(), at_rest.data(), nullptr));
      const Eigen::Map<Eigen::VectorXd> r0(at_rest.data(), at_rest.size());
      energy += 0.5 * (r - r0).dot(r + r0);
    }
    energies[thread] = energy;
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

double ShellProblem::Energy(Effect effect) {
  problem();
  if (effect == Effect::kMembrane) return force_unit_ * StrainEnergyOf(strain_energies_[0]);
  if (effect == Effect::kBending) return force_unit_ * StrainEnergyOf(strain_energies_[1]);
  if (effect == Effect::kSupports) return force_unit_ * SupportEnergy();
  if (effect == Effect::kGas) {
    if (gas_ == nullptr) return 0.0;
    return UpdateGas() ? gas_->law.Energy(gas_->change) : std::numeric_limits<double>::infinity();
  }
  // Without what the multipliers' squares add.
  if (effect == Effect::kContact && grasp_ != nullptr) return force_unit_ * grasp_->Energy();
  const auto& blocks = blocks_[static_cast<int>(effect)];
  if (blocks.empty()) return 0.0;
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = blocks;
  double cost = 0.0;
  problem()->Evaluate(options, &cost, nullptr, nullptr, nullptr);
  return force_unit_ * cost;
}

Eigen::Matrix3Xd ShellProblem::EvaluateGradient(const std::vector<ceres::ResidualBlockId>* blocks) {
  ceres::Problem::EvaluateOptions options;
  options.num_threads = options_.num_threads;
  std::vector<int> vertices;
  for (int i = 0; i < displacements_.cols(); ++i) {
    double* block = displacements_.col(i).data();
    if (!surface_->IsActive(i)) continue;
    // The whole gradient has all blocks in the order they were added: naming them costs Ceres a
    // program of its own.
    if (blocks != nullptr) options.parameter_blocks.push_back(block);
    vertices.push_back(i);
  }
  if (blocks != nullptr) options.residual_blocks = *blocks;
  std::vector<double> gradient;
  double cost;
  problem()->Evaluate(options, &cost, nullptr, &gradient, nullptr);
  // Tangent components -> vectors; constant blocks have none.
  Eigen::Matrix3Xd result = Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  size_t next = 0;
  const Eigen::MatrixXd basis = unknown_basis();
  for (const int vertex : vertices) {
    if (!is_free_[vertex]) continue;
    result.col(vertex) = basis * Eigen::Map<const Eigen::VectorXd>(&gradient[next], basis.cols());
    next += basis.cols();
  }
  return force_unit_ * result;
}

Eigen::Matrix3Xd ShellProblem::Gradient() {
  UpdateGas();
  return EvaluateGradient(nullptr);
}

Eigen::Matrix3Xd ShellProblem::Gradient(Effect effect) {
  const bool dead = effect == Effect::kLoads && !options_.nonlinear;
  if (effect == Effect::kSupports || dead) {
    const Eigen::MatrixXd basis = unknown_basis();
    const Eigen::Matrix3d project = force_unit_ * basis * basis.transpose();
    Eigen::Matrix3Xd gradient = dead ? Eigen::Matrix3Xd(-force_) : SupportGradient();
    for (int i = 0; i < gradient.cols(); ++i) {
      gradient.col(i) =
          is_free_[i] ? Eigen::Vector3d(project * gradient.col(i)) : Eigen::Vector3d::Zero().eval();
    }
    return gradient;
  }
  const auto& blocks = blocks_[static_cast<int>(effect)];
  if (blocks.empty()) return Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  return EvaluateGradient(&blocks);
}

Eigen::Vector3d ShellProblem::Reaction() {
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    reaction -= force_unit_ *
                (conditions_[i].stiffness * Violation(conditions_[i]) + multipliers_[i]) *
                conditions_[i].direction;
  }
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    reaction -= force_unit_ * MeanForce(k) * mean_conditions_[k].coefficients.rowwise().sum();
  }
  if (fixed_vertices_.empty()) return reaction;
  // What holds a fixed vertex is what all energies together leave unbalanced there.
  for (const int vertex : fixed_vertices_) {
    problem()->SetParameterBlockVariable(displacements_.col(vertex).data());
    is_free_[vertex] = 1;
  }
  const Eigen::Matrix3Xd gradient = Gradient();
  for (const int vertex : fixed_vertices_) {
    problem()->SetParameterBlockConstant(displacements_.col(vertex).data());
    is_free_[vertex] = 0;
    reaction += gradient.col(vertex);
  }
  return reaction;
}

Eigen::Vector3d ShellProblem::AppliedForce() const {
  UpdateGas();
  Eigen::Vector3d force = load_factor_ * force_unit_ * dead_loads_.force.rowwise().sum();
  for (const auto& follower : followers_) {
    std::vector<const double*> blocks;
    for (const int vertex : surface_->control_vertices(follower.first)) {
      blocks.push_back(displacements_.col(vertex).data());
    }
    force += force_unit_ * follower.second->ExactForce(blocks.data()).rowwise().sum();
  }
  return force;
}

}  // namespace darboux
