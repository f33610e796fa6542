#include "solver/equilibrium_sensitivity.h"

#include <Eigen/Dense>
#include <algorithm>

namespace darboux {
namespace {

bool HasFriction(const ShellProblem& problem) {
  const auto& fingers = problem.scene().fingers;
  return std::any_of(fingers.begin(), fingers.end(), [](const FingerSpec& finger) {
    return finger.friction > 0.0;
  });
}

// Plane stress: S = c(nu) M(nu) e with c the membrane or bending stiffness.
Eigen::Matrix3d Unit(double nu) {
  Eigen::Matrix3d m;
  m << 1.0, nu, 0.0, nu, 1.0, 0.0, 0.0, 0.0, 0.5 * (1.0 - nu);
  return m;
}

// (dC/dnu) C^-1 of plane stress, the same for membrane and bending: C ~ M(nu) / (1 - nu^2). At nu =
// 1/2 and -1 < nu all is regular.
Eigen::Matrix3d LogDerivativeByPoisson(double nu) {
  Eigen::Matrix3d by_nu;
  by_nu << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.5;
  return by_nu * Unit(nu).inverse() + 2.0 * nu / (1.0 - nu * nu) * Eigen::Matrix3d::Identity();
}

}  // namespace

const char* ToString(StateParameter parameter) {
  switch (parameter) {
    case StateParameter::kYoungModulus:
      return "young_modulus";
    case StateParameter::kThickness:
      return "thickness";
    case StateParameter::kPoissonRatio:
      return "poisson_ratio";
    case StateParameter::kGasPressure:
      return "gas_pressure";
    case StateParameter::kTravel:
      break;
  }
  return "travel";
}

EquilibriumSensitivity::EquilibriumSensitivity(ShellProblem* problem,
                                               SparseBackend backend,
                                               int num_threads)
    : problem_(problem),
      tangent_(problem, backend, num_threads),
      cholesky_(SparseCholesky::Create(backend)) {}

std::unique_ptr<EquilibriumSensitivity> EquilibriumSensitivity::Create(ShellProblem* problem,
                                                                       SparseBackend backend,
                                                                       int num_threads,
                                                                       std::string* error) {
  if (HasFriction(*problem)) {
    *error = "with friction a state depends on the way that leads to it";
    return nullptr;
  }
  std::unique_ptr<EquilibriumSensitivity> s(
      new EquilibriumSensitivity(problem, backend, num_threads));
  if (problem->grasp() != nullptr) {
    constexpr double kRigid = 65536.0;
    s->rigid_ = std::make_unique<RigidContact>(problem->grasp(), kRigid);
    if (!problem->grasp()->ByTravel(&s->by_travel_)) {
      *error = "a point in contact has no normal";
      return nullptr;
    }
  }
  TangentStiffness::Request request;
  request.stresses = &s->stresses_;
  s->cholesky_.Analyze(s->tangent_.matrix());
  const Eigen::MatrixXd none(s->tangent_.num_unknowns(), 0);
  if (!s->tangent_.Evaluate(request) || !EvaluateTrueTangent(&s->tangent_) ||
      !FactorizeTangent(*problem, s->tangent_, none, 0.0, &s->cholesky_)) {
    *error = "the tangent stiffness is singular";
    return nullptr;
  }
  return s;
}

Eigen::VectorXd EquilibriumSensitivity::Forces() const {
  Eigen::VectorXd forces(by_travel_.size());
  for (size_t i = 0; i < by_travel_.size(); ++i) forces[i] = by_travel_[i].energy;
  return problem_->force_unit() * forces;
}

Eigen::VectorXd EquilibriumSensitivity::StrainForces(StateParameter parameter) const {
  TangentStiffness::StressField change = stresses_;
  // An initial stress stays what it is: that of the pressure it was found for.
  if (!problem_->initial_strains().empty()) {
    const Material& material = problem_->scaled_material();
    const Eigen::Matrix3d unit = Unit(material.poisson_ratio);
    size_t q = 0;
    for (const StrainPoints& points : problem_->strain_points()) {
      for (const StrainPoint& point : *points) {
        const Eigen::Matrix<double, 6, 1>& strain = problem_->initial_strains()[q];
        change[q].head<3>() -=
            point.area * material.MembraneStiffness() * (unit * strain.head<3>());
        change[q].tail<3>() -= point.area * material.BendingStiffness() * (unit * strain.tail<3>());
        ++q;
      }
    }
  }
  const Eigen::Matrix3d by_nu = LogDerivativeByPoisson(problem_->material().poisson_ratio);
  for (size_t q = 0; q < change.size(); ++q) {
    TangentStiffness::Stress& stress = change[q];
    switch (parameter) {
      case StateParameter::kThickness:
        stress.tail<3>() *= 3.0;
        break;
      case StateParameter::kPoissonRatio:
        stress.head<3>() = by_nu * stress.head<3>();
        stress.tail<3>() = by_nu * stress.tail<3>();
        break;
      case StateParameter::kGasPressure:
        stress = stresses_[q] - stress;  // the initial stress alone
        break;
      default:
        break;
    }
  }
  return tangent_.StressForces(change);
}

Eigen::VectorXd EquilibriumSensitivity::TouchRates(double offset_rate,
                                                   const Eigen::Matrix3Xd* start) const {
  // phi(x - pose) = offset where the finger touches first, and the distances of all points beside
  // it are stationary: normal . (dx - direction dt) = d(offset).
  const std::vector<FingerReport> fingers = problem_->grasp()->Report(1.0);
  Eigen::VectorXd rates(fingers.size());
  for (size_t i = 0; i < fingers.size(); ++i) {
    const auto& way = problem_->scene().fingers[i].direction;
    const Eigen::Vector3d direction(way[0], way[1], way[2]);
    double moved = -offset_rate;
    if (start != nullptr) {
      const ElementPoint& at = fingers[i].touched;
      const std::vector<int>& vertices = problem_->surface().control_vertices(at.element);
      const Eigen::VectorXd weights = problem_->surface().ValueWeights(at);
      for (size_t k = 0; k < vertices.size(); ++k) {
        moved += weights[k] * fingers[i].normal_before.dot(start->col(vertices[k]));
      }
    }
    rates[i] = moved / fingers[i].normal_before.dot(direction);
  }
  return rates;
}

bool EquilibriumSensitivity::Evaluate(StateParameter parameter,
                                      const Eigen::Matrix3Xd* start,
                                      StateDerivative* derivative,
                                      std::string* error) {
  const Eigen::Index n = static_cast<Eigen::Index>(by_travel_.size());
  const bool prestressed = !problem_->initial_strains().empty();
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(tangent_.num_unknowns());  // -U_up
  Eigen::VectorXd own = Eigen::VectorXd::Zero(n), rates = Eigen::VectorXd::Zero(n);
  double offset_rate = 0.0;
  switch (parameter) {
    case StateParameter::kThickness:
    case StateParameter::kPoissonRatio:
      if (prestressed) {
        *error = "the initial stress of prestressed gas is not known as a function of " +
                 std::string(ToString(parameter));
        return false;
      }
      if (parameter == StateParameter::kThickness) {
        offset_rate = 0.5 * problem_->material().thickness;
      }
      [[fallthrough]];
    case StateParameter::kYoungModulus:
      forces = -StrainForces(parameter);
      break;
    case StateParameter::kGasPressure: {
      if (!problem_->has_gas()) {
        *error = "the scene has no gas";
        return false;
      }
      // The pressure is linear in the amount of gas, whatever the law.
      const LoadSpec& gas = *FindGas(problem_->scene());
      const double rate =
          problem_->ReportGas().absolute_pressure / (gas.ambient_pressure + gas.gauge_pressure);
      forces = rate * tangent_.Reduce(problem_->gas_vector());
      if (prestressed) forces -= StrainForces(parameter) / gas.gauge_pressure;
      break;
    }
    case StateParameter::kTravel:
      if (n == 0) {
        *error = "the scene has no fingers";
        return false;
      }
      rates.setOnes();
      break;
  }
  if (n > 0) {
    rates += TouchRates(offset_rate, start);
    if (offset_rate != 0.0) {
      Eigen::Matrix3Xd by_offset = Eigen::Matrix3Xd::Zero(3, problem_->displacements().cols());
      for (const Grasp::Block& block : problem_->grasp()->blocks()) {
        const std::vector<int>& vertices = problem_->surface().control_vertices(block.element);
        const ContactFinger& finger = block.contact->finger();
        const ContactPoints& points = block.contact->points();
        const std::vector<ContactState> states = problem_->grasp()->States(block);
        for (size_t q = 0; q < states.size(); ++q) {
          if (!(states[q].pressure > 0.0)) continue;
          const Eigen::Vector3d force =
              offset_rate * finger.stiffness * points.areas[q] * states[q].normal;
          own[block.finger] += force.dot(finger.direction);
          for (size_t i = 0; i < vertices.size(); ++i) {
            by_offset.col(vertices[i]) += points.weights(q, i) * force;
          }
        }
      }
      forces += tangent_.Reduce(by_offset);
    }
  }
  std::vector<Eigen::VectorXd> by_travel(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    by_travel[i] = tangent_.Reduce(by_travel_[i].force);
    forces += rates[i] * by_travel[i];
    own[i] += rates[i] * by_travel_[i].stiffness;
  }
  const Eigen::VectorXd response = Response(problem_, tangent_, &cholesky_, forces);
  if (!response.allFinite()) {
    *error = "the tangent stiffness is singular";
    return false;
  }
  derivative->displacement = tangent_.Expand(response);
  derivative->force.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    derivative->force[i] = problem_->force_unit() * (own[i] - by_travel[i].dot(response));
  }
  return true;
}

}  // namespace darboux
