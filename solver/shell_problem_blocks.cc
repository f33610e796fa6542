#include <ceres/manifold.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "costs/bending_energy.h"
#include "costs/edge_moment.h"
#include "costs/load_work.h"
#include "costs/membrane_energy.h"
#include "costs/stacked_cost.h"
#include "costs/support.h"
#include "geometry/quadrature.h"
#include "solver/shell_problem.h"

// The ceres::Problem of a scene: its parameters, and a residual block for each part of the energy.

namespace darboux {
namespace {

// Displacements within a fixed subspace: x + basis * delta.
class SubspaceManifold : public ceres::Manifold {
 public:
  explicit SubspaceManifold(Eigen::MatrixXd basis) : basis_(std::move(basis)) {}
  int AmbientSize() const override { return static_cast<int>(basis_.rows()); }
  int TangentSize() const override { return static_cast<int>(basis_.cols()); }
  bool Plus(const double* x, const double* delta, double* result) const override {
    Eigen::Map<Eigen::VectorXd>(result, AmbientSize()) =
        Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()) +
        basis_ * Eigen::Map<const Eigen::VectorXd>(delta, TangentSize());
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    for (int i = 0; i < AmbientSize(); ++i) {
      for (int k = 0; k < TangentSize(); ++k) jacobian[i * TangentSize() + k] = basis_(i, k);
    }
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Eigen::Map<Eigen::VectorXd>(delta, TangentSize()) =
        basis_.transpose() * (Eigen::Map<const Eigen::VectorXd>(y, AmbientSize()) -
                              Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    for (int k = 0; k < TangentSize(); ++k) {
      for (int i = 0; i < AmbientSize(); ++i) jacobian[k * AmbientSize() + i] = basis_(i, k);
    }
    return true;
  }

 private:
  Eigen::MatrixXd basis_;  // orthonormal columns
};

}  // namespace

void ShellProblem::Build() {
  ceres::Problem::Options options;
  options.disable_all_safety_checks = true;  // Blocks are built from one mesh, below.
  problem_ = std::make_unique<ceres::Problem>(options);
  AddParameters();
  AddStrainEnergies();
  AddSupports();
  AddLoads();
}

std::vector<double*> ShellProblem::Blocks(const std::vector<int>& vertices) {
  std::vector<double*> blocks;
  blocks.reserve(vertices.size());
  for (const int vertex : vertices) blocks.push_back(displacements_.col(vertex).data());
  return blocks;
}

ceres::ResidualBlockId ShellProblem::Record(Effect effect,
                                            ceres::ResidualBlockId id,
                                            int residuals) {
  EffectReport& report = effects_[static_cast<int>(effect)];
  ++report.residual_blocks;
  report.residuals += residuals;
  blocks_[static_cast<int>(effect)].push_back(id);
  return id;
}

void ShellProblem::AddParameters() {
  // Shared by all blocks, owned by the problem.
  auto* manifold = unknowns_ == Unknowns::kAll ? nullptr : new SubspaceManifold(unknown_basis());
  for (int i = 0; i < displacements_.cols(); ++i) {
    if (!surface_->IsActive(i)) continue;
    double* const block = displacements_.col(i).data();
    problem_->AddParameterBlock(block, 3);
    if (manifold != nullptr) problem_->SetManifold(block, manifold);
    if (!is_free_[i]) problem_->SetParameterBlockConstant(block);
  }
}

void ShellProblem::AddStrainEnergies() {
  const bool tension_rows = options_.nonlinear && options_.tension_rows;
  size_t next = 0;
  for (int e = 0; e < surface_->num_elements(); ++e) {
    std::vector<std::unique_ptr<ceres::CostFunction>> costs;
    std::vector<Eigen::Vector3d> initial[2];
    for (size_t q = 0; !initial_strains_.empty() && q < points_[e]->size(); ++q) {
      initial[0].push_back(initial_strains_[next + q].head<3>());
      initial[1].push_back(initial_strains_[next + q].tail<3>());
    }
    next += points_[e]->size();
    const auto add = [&](Effect effect, std::unique_ptr<ceres::CostFunction> cost) {
      EffectReport& report = effects_[static_cast<int>(effect)];
      ++report.residual_blocks;
      report.residuals += cost->num_residuals();
      strain_energies_[effect == Effect::kMembrane ? 0 : 1].push_back(cost.get());
      costs.push_back(std::move(cost));
    };
    if (effect(Effect::kMembrane).on) {
      auto cost =
          std::make_unique<MembraneEnergy>(points_[e], measure_, scaled_material_, tension_rows);
      cost->SetInitialStrains(std::move(initial[0]));
      add(Effect::kMembrane, std::move(cost));
    }
    if (effect(Effect::kBending).on) {
      auto cost = std::make_unique<BendingEnergy>(points_[e], measure_, scaled_material_);
      cost->SetInitialStrains(std::move(initial[1]));
      add(Effect::kBending, std::move(cost));
    }
    ceres::CostFunction* block =
        costs.size() == 1 ? costs.front().release() : new StackedCost(std::move(costs));
    problem_->AddResidualBlock(block, nullptr, Blocks(surface_->control_vertices(e)));
  }
}

void ShellProblem::AddSupports() {
  EffectReport& report = effects_[static_cast<int>(Effect::kSupports)];
  report.on = !scene_.supports.empty();
  report.why = report.on ? "the scene names supports" : "the scene names no support";
  // Conditions on the same control vertices that follow each other share a block.
  for (size_t first = 0; first < conditions_.size();) {
    const std::vector<int>& vertices = conditions_[first].vertices;
    std::vector<Support::Condition> together;
    for (; first < conditions_.size() && conditions_[first].vertices == vertices; ++first) {
      const PlacedCondition& placed = conditions_[first];
      if (placed.stiffness == 0.0) continue;
      Support::Condition condition;
      condition.coefficients = placed.coefficients;
      condition.stiffness = placed.stiffness;
      condition.target = &targets_[first];
      together.push_back(std::move(condition));
    }
    if (together.empty()) continue;
    const int residuals = static_cast<int>(together.size());
    Record(Effect::kSupports,
           problem_->AddResidualBlock(new Support(std::move(together)), nullptr, Blocks(vertices)),
           residuals);
  }
  for (size_t k = 0; k < pins_.size(); ++k) {
    Support::Condition condition;
    condition.coefficients = pins_[k].coefficients;
    condition.stiffness = pins_[k].stiffness;
    condition.target = &pin_targets_[k];
    Record(Effect::kSupports,
           problem_->AddResidualBlock(
               new Support({std::move(condition)}), nullptr, Blocks(pins_[k].vertices)),
           1);
  }
}

void ShellProblem::AddLoads() {
  EffectReport& report = effects_[static_cast<int>(Effect::kLoads)];
  report.on = std::any_of(scene_.loads.begin(), scene_.loads.end(), [](const LoadSpec& load) {
    return load.kind != LoadSpec::Kind::kGas;
  });
  report.why = report.on ? "the scene names loads" : "the scene names no load";
  EffectReport& gravity = effects_[static_cast<int>(Effect::kGravity)];
  gravity.why = "the scene names no gravity load";
  for (const LoadSpec& load : scene_.loads) {
    if (load.kind == LoadSpec::Kind::kGravity) {
      gravity.on = true;
      gravity.why = "the scene names a gravity load; it acts through the load vector";
    }
  }
  for (const Effect absent : {Effect::kContact, Effect::kFriction, Effect::kGas}) {
    effects_[static_cast<int>(absent)].why =
        absent == Effect::kGas ? "the scene names no gas load" : "the scene has no fingers";
  }

  // Curvature of a potential's block, (dU/du)^2 / s^2, against the membrane stiffness: 1e-16.
  double largest = force_.cwiseAbs().maxCoeff();
  if (largest == 0.0) largest = scaled_material_.MembraneStiffness() * frame_.length;
  const double stiffness = std::sqrt(scaled_material_.MembraneStiffness());
  const auto scale = [&](double force) { return 1e8 * force / stiffness; };
  if (grasp_ != nullptr) AddFingers(scale);
  for (int i = 0; i < force_.cols(); ++i) {
    if (!surface_->IsActive(i)) continue;
    // The force of mean conditions acts everywhere.
    const bool loaded = !force_.col(i).isZero(0.0) || !mean_conditions_.empty();
    if (loaded) {
      Record(Effect::kLoads,
             Potential::AddTo(problem_.get(),
                              new LoadWork(force_.col(i).data(), scale(largest)),
                              {displacements_.col(i).data()}),
             1);
    }
  }
  if (const LoadSpec* const gas = FindGas(scene_)) AddGas(*gas, 1e8 / stiffness);
  if (!options_.nonlinear) return;

  // Forces that follow the deformation. The origin of the swept volume lies on the mirror planes,
  // where the boundary's part of its gradient vanishes.
  Eigen::Matrix3d normal_sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const SupportSpec& support : scene_.supports) {
    if (support.kind != SupportSpec::Kind::kSymmetry) continue;
    const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
    for (const Side side : SidesOf(support.on, *surface_)) {
      const Eigen::Vector3d x =
          surface_->SidePoints(side, 1).front().point.position - frame_.center;
      normal_sum += normal * normal.transpose();
      right += normal * normal.dot(x);
    }
  }
  const Eigen::Vector3d origin =
      frame_.center + normal_sum.completeOrthogonalDecomposition().solve(right);
  for (const LoadSpec& load : scene_.loads) {
    if (load.kind == LoadSpec::Kind::kPressure && load.follower) {
      for (int e = 0; e < surface_->num_elements(); ++e) {
        const auto& rule = surface_->Rule(e, scene_.model.quadrature);
        std::vector<double> pressure;
        double total = 0.0;
        for (size_t q = 0; q < rule.size(); ++q) {
          pressure.push_back(EvaluateAt(load.value, *surface_, {e, rule[q].s, rule[q].t}) /
                             force_unit_);
          total += std::abs(pressure.back()) * (*points_[e])[q].area;
        }
        if (total == 0.0) continue;
        auto* cost = new FollowerPressure(
            points_[e], std::move(pressure), origin, &load_factor_, scale(total));
        Record(Effect::kLoads,
               Potential::AddTo(problem_.get(), cost, Blocks(surface_->control_vertices(e))),
               1);
        followers_.push_back({e, cost});
        follower_forces_.push_back({e, cost});
      }
    } else if (load.kind == LoadSpec::Kind::kEdge) {
      for (const Side side : SidesOf(load.on, *surface_)) {
        for (const auto& edge : surface_->SidePoints(side, 3)) {
          const Eigen::Vector3d moment = EvaluateAt(load.moment, *surface_, edge.at) / force_unit_;
          if (moment.isZero(0.0)) continue;
          auto* cost =
              new EdgeMoment(edge.point, edge.tangent, moment, &load_factor_, scale(moment.norm()));
          Record(Effect::kLoads,
                 Potential::AddTo(
                     problem_.get(), cost, Blocks(surface_->control_vertices(edge.at.element))),
                 1);
          moments_.push_back({edge.at.element, cost});
          follower_forces_.push_back({edge.at.element, cost});
        }
      }
    }
  }
  // The correction of follower forces acts on vertices that carry no dead load as well.
  if (followers_.empty()) return;
  double total = 0.0;
  for (const auto& follower : followers_) {
    const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, 64);
    std::vector<const double*> rest(surface_->control_vertices(follower.first).size());
    for (auto& block : rest) block = zero.data();
    total = std::max(total, follower.second->ExactForce(rest.data()).norm());
  }
  for (int i = 0; i < force_.cols(); ++i) {
    if (!surface_->IsActive(i) || !dead_loads_.force.col(i).isZero(0.0)) continue;
    if (!mean_conditions_.empty()) continue;
    Record(Effect::kLoads,
           Potential::AddTo(problem_.get(),
                            new LoadWork(force_.col(i).data(), scale(std::max(total, largest))),
                            {displacements_.col(i).data()}),
           1);
  }
}

void ShellProblem::AddFingers(const std::function<double(double)>& curvature_scale) {
  EffectReport& contact = effects_[static_cast<int>(Effect::kContact)];
  EffectReport& friction = effects_[static_cast<int>(Effect::kFriction)];
  contact.on = true;
  contact.why = "the scene has fingers";
  friction.why = "no finger has friction";
  const auto added = [&](ceres::ResidualBlockId id, Grasp::Part part, int residuals) {
    switch (part) {
      case Grasp::Part::kContact:
        Record(Effect::kContact, id, residuals);
        return;
      case Grasp::Part::kFriction:
        Record(Effect::kFriction, id, residuals);
        friction.on = true;
        friction.why = "a finger has friction";
        return;
      case Grasp::Part::kForce:
        Record(Effect::kLoads, id, residuals);
        effects_[static_cast<int>(Effect::kLoads)].on = true;
        effects_[static_cast<int>(Effect::kLoads)].why = "a finger is driven by a force";
        return;
    }
  };
  grasp_->AddTo(problem_.get(), curvature_scale, added);
  for (const Grasp::Block& block : grasp_->blocks()) {
    follower_forces_.push_back({block.element, block.contact, block.travel});
    if (block.friction != nullptr) {
      follower_forces_.push_back({block.element, block.friction, block.travel});
    }
  }
}

}  // namespace darboux
