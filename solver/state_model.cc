#include "solver/state_model.h"

#include <algorithm>
#include <cmath>

#include "solver/minimisation.h"

namespace darboux {
namespace {

Eigen::VectorXd ForcesAlong(const Scene& scene, const std::vector<FingerReport>& fingers) {
  Eigen::VectorXd forces(fingers.size());
  for (size_t i = 0; i < fingers.size(); ++i) {
    const auto& way = scene.fingers[i].direction;
    forces[i] = -fingers[i].force.dot(Eigen::Vector3d(way[0], way[1], way[2]));
  }
  return forces;
}

}  // namespace

ShellParameters ParametersOf(const Scene& scene) {
  const LoadSpec* const gas = FindGas(scene);
  return {scene.shell.young_modulus,
          scene.shell.thickness,
          scene.shell.poisson_ratio,
          gas == nullptr ? 0.0 : gas->gauge_pressure};
}

std::unique_ptr<StateModel> StateModel::Create(const Scene& scene,
                                               const SolverOptions& options,
                                               std::string* error) {
  std::unique_ptr<StateModel> model(new StateModel(scene, options));
  model->scales_with_modulus_ = scene.loads.empty();
  for (const FingerSpec& finger : scene.fingers) {
    if (finger.force) model->by_force_ = true;
    if (finger.friction > 0.0) model->has_friction_ = true;
  }
  // Only the final state counts.
  model->scene_.steps = model->has_friction_ ? scene.steps : 1;
  if (!model->SolveAnew(model->scene_, {}, error)) return nullptr;
  if (model->by_force_) {
    const std::vector<FingerReport>& fingers = model->summary_.steps.back().fingers;
    for (size_t i = 0; i < fingers.size(); ++i) {
      model->scene_.fingers[i].force.reset();
      model->scene_.fingers[i].travel = fingers[i].travel;
    }
    if (!model->SolveAnew(model->scene_, {}, error)) return nullptr;
  }
  model->parameters_ = ParametersOf(model->scene_);
  return model;
}

Scene StateModel::At(const ShellParameters& parameters, double travel_change) const {
  Scene scene = scene_;
  scene.shell.young_modulus = parameters.young_modulus;
  scene.shell.thickness = parameters.thickness;
  scene.shell.poisson_ratio = parameters.poisson_ratio;
  for (LoadSpec& load : scene.loads) {
    if (load.kind == LoadSpec::Kind::kGas) load.gauge_pressure = parameters.gas_pressure;
  }
  for (FingerSpec& finger : scene.fingers) finger.travel += travel_change;
  return scene;
}

Scene StateModel::StateScene() const { return At(parameters_, travel_change_); }

bool StateModel::SolveAnew(const Scene& scene, const Eigen::Matrix3Xd& guess, std::string* error) {
  const Clock::time_point start = Clock::now();
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  SolverOptions options = options_;
  options.initial_displacements = guess;
  if (guess.size() > 0) options.initial_contact = contact_;
  const bool posed = darboux::Solve(scene, options, &problem, &summary, error);
  work_.solve_s += Since(start);
  ++work_.solutions;
  if (!posed) return false;
  work_.iterations += std::max(0, summary.iterations);
  if (!summary.IsConverged()) {
    *error = "scene " + scene.name + " has no solution: " + summary.message;
    return false;
  }
  sensitivity_.reset();
  bare_sensitivity_.reset();
  bare_.reset();
  for (auto& derivative : derivatives_) derivative.reset();
  problem_ = std::move(problem);
  summary_ = std::move(summary);
  solved_modulus_ = scene.shell.young_modulus;
  displacements_ = problem_->displacements();
  if (problem_->grasp() != nullptr) contact_ = problem_->grasp()->state().multipliers;
  forces_ = ForcesAlong(scene, summary_.steps.back().fingers);
  max_displacement_ = summary_.max_displacement;
  return true;
}

bool StateModel::Settle(std::string* error) {
  sensitivity_.reset();  // It keeps contact stiffened.
  bare_sensitivity_.reset();
  if (solved_modulus_ == parameters_.young_modulus) return true;
  return SolveAnew(StateScene(), Guess(parameters_, travel_change_), error);
}

bool StateModel::Solve(const ShellParameters& parameters,
                       double travel_change,
                       std::string* error) {
  const bool same_shape =
      parameters.thickness == parameters_.thickness &&
      parameters.poisson_ratio == parameters_.poisson_ratio &&
      parameters.gas_pressure == parameters_.gas_pressure && travel_change == travel_change_ &&
      (scales_with_modulus_ || parameters.young_modulus == parameters_.young_modulus);
  if (same_shape) {
    const double ratio = parameters.young_modulus / parameters_.young_modulus;
    if (ratio == 1.0) return true;
    forces_ *= ratio;
    for (auto& derivative : derivatives_) {
      if (derivative) derivative->force *= ratio;
    }
    parameters_ = parameters;
    return true;
  }
  if (!SolveAnew(At(parameters, travel_change), Guess(parameters, travel_change), error)) {
    return false;
  }
  parameters_ = parameters;
  travel_change_ = travel_change;
  return true;
}

// The last state, moved along what is known of its derivatives. None with friction, where the way
// counts.
Eigen::Matrix3Xd StateModel::Guess(const ShellParameters& parameters, double travel_change) const {
  if (has_friction_ || summary_.theory != Theory::kNonlinear) return {};
  const double changes[] = {std::log(parameters.young_modulus / parameters_.young_modulus),
                            std::log(parameters.thickness / parameters_.thickness),
                            parameters.poisson_ratio - parameters_.poisson_ratio,
                            parameters.gas_pressure - parameters_.gas_pressure,
                            travel_change - travel_change_};
  Eigen::Matrix3Xd guess = displacements_;
  for (int k = 0; k < kNumStateParameters; ++k) {
    if (derivatives_[k]) guess += changes[k] * derivatives_[k]->displacement;
  }
  return guess;
}

bool StateModel::DeriveImplicitly(StateParameter parameter,
                                  StateDerivative* derivative,
                                  std::string* error) {
  const SparseBackend backend = options_.backend;
  if (sensitivity_ == nullptr) {
    sensitivity_ =
        EquilibriumSensitivity::Create(problem_.get(), backend, options_.num_threads, error);
    if (sensitivity_ == nullptr) return false;
    ++work_.factorisations;
  }
  const Scene at = StateScene();
  const LoadSpec* const gas = FindGas(at);
  const bool inflated = gas != nullptr && !gas->prestressed && gas->gauge_pressure != 0.0 &&
                        !at.fingers.empty() && parameter != StateParameter::kTravel;
  StateDerivative start;
  if (inflated) {
    if (bare_sensitivity_ == nullptr) {
      Scene bare = at;
      bare.fingers.clear();
      bare.probes.clear();
      bare.expect.clear();
      bare.loads = {*gas};
      SolverSummary summary;
      if (!darboux::Solve(bare, options_, &bare_, &summary, error)) return false;
      if (!summary.IsConverged()) {
        *error = summary.message;
        return false;
      }
      bare_sensitivity_ =
          EquilibriumSensitivity::Create(bare_.get(), backend, options_.num_threads, error);
      if (bare_sensitivity_ == nullptr) return false;
      ++work_.factorisations;
    }
    if (!bare_sensitivity_->Evaluate(parameter, nullptr, &start, error)) return false;
  }
  return sensitivity_->Evaluate(
      parameter, inflated ? &start.displacement : nullptr, derivative, error);
}

bool StateModel::DeriveByDifferences(StateParameter parameter,
                                     StateDerivative* derivative,
                                     std::string* error) {
  // States with friction are good to about 1e-6 of the displacement: the step balances that against
  // curvature.
  constexpr double kStep = 1e-3;
  ShellParameters moved = parameters_;
  double travel = travel_change_, step = kStep;
  switch (parameter) {
    case StateParameter::kYoungModulus:
      moved.young_modulus *= std::exp(step);
      break;
    case StateParameter::kThickness:
      moved.thickness *= std::exp(step);
      break;
    case StateParameter::kPoissonRatio:
      if (moved.poisson_ratio + step > 0.5) step = -step;
      moved.poisson_ratio += step;
      break;
    case StateParameter::kGasPressure: {
      const LoadSpec* const gas = FindGas(scene_);
      if (gas == nullptr) {
        *error = "the scene has no gas";
        return false;
      }
      step = kStep * (gas->ambient_pressure + std::abs(moved.gas_pressure));
      moved.gas_pressure += step;
      break;
    }
    case StateParameter::kTravel:
      if (scene_.fingers.empty()) {
        *error = "the scene has no fingers";
        return false;
      }
      step = kStep * max_displacement_;
      travel += step;
      break;
  }
  const Clock::time_point start = Clock::now();
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  const Scene scene = At(moved, travel);
  const bool posed = darboux::Solve(scene, options_, &problem, &summary, error);
  work_.solve_s += Since(start);
  ++work_.solutions;
  if (!posed) return false;
  if (!summary.IsConverged()) {
    *error = summary.message;
    return false;
  }
  derivative->displacement = (problem->displacements() - displacements_) / step;
  derivative->force = (ForcesAlong(scene, summary.steps.back().fingers) - forces_) / step;
  return true;
}

bool StateModel::Derivative(StateParameter parameter,
                            const StateDerivative** derivative,
                            std::string* error) {
  std::optional<StateDerivative>& kept = derivatives_[static_cast<int>(parameter)];
  if (!kept) {
    const Clock::time_point start = Clock::now();
    const double solving = work_.solve_s;
    StateDerivative found;
    if (parameter == StateParameter::kYoungModulus && scales_with_modulus_) {
      found.displacement = Eigen::Matrix3Xd::Zero(3, displacements_.cols());
      found.force = forces_;
    } else if (has_friction_) {
      if (!DeriveByDifferences(parameter, &found, error)) return false;
    } else {
      if (!DeriveImplicitly(parameter, &found, error)) return false;
      found.force *= parameters_.young_modulus / solved_modulus_;
    }
    work_.derivative_s += Since(start) - (work_.solve_s - solving);
    kept = std::move(found);
  }
  *derivative = &*kept;
  return true;
}

}  // namespace darboux
