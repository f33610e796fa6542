#include "solver/calibration_problem.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/parallel_for.h"

namespace darboux {
namespace {

constexpr StateParameter kParameters[] = {StateParameter::kYoungModulus,
                                          StateParameter::kThickness,
                                          StateParameter::kPoissonRatio,
                                          StateParameter::kGasPressure,
                                          StateParameter::kTravel};

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Matrix3d Rotation(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

// d(exp(w) y)/dw = -exp(w) [y]x J(w), J the right Jacobian of the rotation group.
Eigen::Matrix3d RotationDerivative(const Eigen::Vector3d& w, const Eigen::Vector3d& y) {
  const double angle = w.norm();
  Eigen::Matrix3d right = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d k = Cross(w);
  if (angle < 1e-4) {
    right += -0.5 * k + k * k / 6.0;
  } else {
    right += -(1.0 - std::cos(angle)) / (angle * angle) * k +
             (angle - std::sin(angle)) / (angle * angle * angle) * k * k;
  }
  return -Rotation(w) * Cross(y) * right;
}

using Problem = CalibrationProblem;

// Parameters: theta (4 of 1), travel (1), rest offset (1), motion (6).
class ScanBlock : public ceres::CostFunction {
 public:
  ScanBlock(const Problem* problem, int scan, int point)
      : problem_(problem), scan_(scan), point_(point) {
    set_num_residuals(1);
    *mutable_parameter_block_sizes() = {1, 1, 1, 1, 1, 1, 6};
  }
  bool Evaluate(double const* const*, double* residual, double** jacobians) const override {
    if (problem_->failed()) return false;
    const Problem::Scan& scan = problem_->scans()[scan_];
    if (!problem_->ScanResidual(
            scan, point_, residual, jacobians == nullptr ? nullptr : jacobians[6])) {
      return false;
    }
    if (jacobians == nullptr) return true;
    for (int k = 0; k < 5; ++k) {
      if (jacobians[k] != nullptr) jacobians[k][0] = scan.rates(k, point_) / scan.deviation;
    }
    if (jacobians[5] != nullptr) {
      jacobians[5][0] = -problem_->unit(Problem::kRest) / scan.deviation;
    }
    return true;
  }

 private:
  const Problem* problem_;
  int scan_, point_;
};

class FieldBlock : public ceres::CostFunction {
 public:
  FieldBlock(const Problem* problem, int field, int point)
      : problem_(problem), field_(field), point_(point) {
    set_num_residuals(3);
    *mutable_parameter_block_sizes() = {1, 1, 1, 1, 1, 6};
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (problem_->failed()) return false;
    const Problem::Field& field = problem_->fields()[field_];
    problem_->FieldResidual(
        field, point_, residuals, jacobians == nullptr ? nullptr : jacobians[5]);
    if (jacobians == nullptr) return true;
    for (int k = 0; k < 5; ++k) {
      if (jacobians[k] == nullptr) continue;
      const Eigen::Vector3d rate = problem_->FieldRate(field, point_, k);
      for (int c = 0; c < 3; ++c) {
        jacobians[k][c] = field.components[c] ? rate[c] / field.deviation : 0.0;
      }
    }
    return true;
  }

 private:
  const Problem* problem_;
  int field_, point_;
};

// Parameters: theta (4 of 1), bias, drift, travel.
class ForceBlock : public ceres::CostFunction {
 public:
  ForceBlock(const Problem* problem, int force) : problem_(problem), force_(force) {
    set_num_residuals(1);
    *mutable_parameter_block_sizes() = {1, 1, 1, 1, 1, 1, 1};
  }
  bool Evaluate(double const* const*, double* residual, double** jacobians) const override {
    if (problem_->failed()) return false;
    problem_->ForceResidual(problem_->forces()[force_], residual, jacobians);
    return true;
  }

 private:
  const Problem* problem_;
  int force_;
};

// (x - value) / deviation
class PriorBlock : public ceres::CostFunction {
 public:
  PriorBlock(double value, double deviation) : value_(value), deviation_(deviation) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(1);
  }
  bool Evaluate(double const* const* x, double* residual, double** jacobians) const override {
    residual[0] = (x[0][0] - value_) / deviation_;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 1.0 / deviation_;
    return true;
  }

 private:
  double value_, deviation_;
};

double RestError(const CalibrationSpec& spec, double thickness) {
  return spec.rest_error < 0.0   ? kRestPart * thickness
         : spec.rest_error > 0.0 ? spec.rest_error
                                 : 1.0;
}

ceres::LossFunction* RobustLoss(double share) {
  return new ceres::ScaledLoss(
      new ceres::CauchyLoss(Problem::kRobust), share, ceres::TAKE_OWNERSHIP);
}

// Triggs' first-order weight of a loss.
double RobustWeight(double squared_norm) {
  const ceres::CauchyLoss loss(Problem::kRobust);
  double rho[3];
  loss.Evaluate(squared_norm, rho);
  return rho[1];
}

}  // namespace

bool IsDrivenByLoads(const Scene& scene) {
  constexpr double kZeros[8] = {};
  for (const SupportSpec& support : scene.supports) {
    for (const SceneValue& value : support.displacement.component) {
      if (!value.expression.IsConstant() || value.expression.Evaluate(kZeros) != 0.0) return false;
    }
  }
  return !scene.loads.empty() && scene.fingers.empty() && FindGas(scene) == nullptr;
}

CalibrationProblem::CalibrationProblem(const CalibrationSpec& spec,
                                       int num_threads,
                                       std::vector<std::unique_ptr<StateModel>>* models)
    : spec_(spec), num_threads_(num_threads), models_(*models) {
  const StateModel& first = *models_.front();
  start_ = first.parameters();
  // Gas may be in a later scene only.
  for (const auto& model : models_) {
    if (FindGas(model->scene()) != nullptr) start_.gas_pressure = model->parameters().gas_pressure;
  }
  const ShellSurface& surface = first.problem().surface();
  size_ = surface.size();
  for (const ElementPoint& at : surface.vertex_points()) middle_ += surface.Position(at);
  middle_ /= static_cast<double>(surface.vertex_points().size());
  const size_t count = models_.size();
  unknowns_.assign(kTravels + count, 0.0);
  units_.assign(kTravels + count, 1.0);
  units_[3] = start_.young_modulus * start_.thickness / size_;
  units_[kBias] = spec.model_error > 0.0 ? spec.model_error : 1.0;
  units_[kDrift] = spec.force_drift > 0.0 ? spec.force_drift : 1.0;
  units_[kRest] = RestError(spec, start_.thickness);
  double begin = std::numeric_limits<double>::infinity(), end = -begin;
  for (const CalibrationSpec::Grasp& grasp : spec.grasps) {
    begin = std::min(begin, grasp.time);
    end = std::max(end, grasp.time);
  }
  for (size_t g = 0; g < count; ++g) {
    const CalibrationSpec::Grasp& grasp = spec.grasps[g];
    const bool known = std::isfinite(grasp.travel_error) && grasp.travel_error > 0.0;
    units_[kTravels + g] = known ? grasp.travel_error : start_.thickness;
    faces_.push_back(std::make_unique<ShellFace>(models_[g]->problem().surface(), 0.0));
    for (const CalibrationSpec::ForceReading& reading : grasp.forces) {
      forces_.push_back({static_cast<int>(g),
                         reading.finger,
                         reading.value,
                         std::hypot(reading.error, spec.model_error * reading.value),
                         end > begin ? (grasp.time - begin) / (end - begin) : 0.0});
    }
  }
  force_rates_.resize(forces_.size());
  SetParameters(start_);
}

int CalibrationProblem::AddScan(Scan scan) {
  scan.feet.resize(scan.points.size());
  scan.moved.resize(scan.points.size());
  scans_.push_back(std::move(scan));
  return static_cast<int>(scans_.size()) - 1;
}

int CalibrationProblem::AddField(Field field) {
  const ShellSurface& surface = models_[field.grasp]->problem().surface();
  for (const ElementPoint& at : field.feet) field.weights.push_back(surface.ValueWeights(at));
  fields_.push_back(std::move(field));
  return static_cast<int>(fields_.size()) - 1;
}

void CalibrationProblem::Finish() {
  num_unknowns_ = static_cast<int>(unknowns_.size());
  for (Scan& scan : scans_) {
    scan.column = num_unknowns_;
    num_unknowns_ += 6;
  }
  for (Field& field : fields_) {
    field.column = num_unknowns_;
    num_unknowns_ += 6;
  }
}

ShellParameters CalibrationProblem::Parameters() const {
  return {start_.young_modulus * std::exp(unknowns_[0]),
          start_.thickness * std::exp(unknowns_[1]),
          unknowns_[2],
          unknowns_[3] * units_[3]};
}

void CalibrationProblem::SetParameters(const ShellParameters& parameters) {
  unknowns_[0] = std::log(parameters.young_modulus / start_.young_modulus);
  unknowns_[1] = std::log(parameters.thickness / start_.thickness);
  unknowns_[2] = parameters.poisson_ratio;
  unknowns_[3] = parameters.gas_pressure / units_[3];
}

double CalibrationProblem::TravelChange(int grasp) const {
  return unknowns_[TravelColumn(grasp)] * units_[TravelColumn(grasp)];
}

RigidPose CalibrationProblem::PoseOf(int scan) const {
  const Scan& s = scans_[scan];
  const Eigen::Vector3d w(s.motion.data()), t(s.motion.data() + 3);
  const Eigen::Matrix3d r = Rotation(w);
  RigidPose more;
  more.rotation = Eigen::Quaterniond(r);
  more.translation = middle_ - r * middle_ + size_ * t;
  return more * s.pose;
}

std::vector<StateParameter> CalibrationProblem::Wanted(bool all) const {
  std::vector<StateParameter> wanted;
  for (int k = 0; k < kShell; ++k) {
    if (all || spec_.parameters[k].asked) wanted.push_back(kParameters[k]);
  }
  wanted.push_back(StateParameter::kTravel);
  return wanted;
}

// d(n' - n) at the field's feet when displacements change along a direction, by central
// differences: exact to 1e-9 or so, of what is a small part of a displacement.
Eigen::Matrix3Xd CalibrationProblem::TurnRates(const Field& field,
                                               const Eigen::Matrix3Xd& displacements,
                                               const Eigen::Matrix3Xd& direction) const {
  constexpr double kStep = 1e-6;
  const Eigen::Index n = static_cast<Eigen::Index>(field.feet.size());
  Eigen::Matrix3Xd rates = Eigen::Matrix3Xd::Zero(3, n);
  const double largest = direction.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return rates;
  const bool is_linear = models_[field.grasp]->summary().theory == Theory::kLinear;
  const double step = kStep * size_ / largest;
  ShellFace middle(models_[field.grasp]->problem().surface(), 0.0);
  for (const double side : {1.0, -1.0}) {
    const Eigen::Matrix3Xd change = side * step * direction;
    if (is_linear) {
      middle.SetDisplacements(change);  // The linear theory turns normals from rest.
    } else {
      middle.SetDisplacements(displacements + change);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      rates.col(i) += side / (2.0 * step) * middle.Evaluate(field.feet[i]).normal;
    }
  }
  return rates;
}

// n' - n at the field's feet.
Eigen::Matrix3Xd CalibrationProblem::Turns(const Field& field,
                                           const Eigen::Matrix3Xd& displacements) const {
  if (models_[field.grasp]->summary().theory == Theory::kLinear) {
    return TurnRates(field, displacements, displacements);
  }
  ShellFace middle(models_[field.grasp]->problem().surface(), 0.0);  // at rest
  const Eigen::Index n = static_cast<Eigen::Index>(field.feet.size());
  Eigen::Matrix3Xd turns(3, n);
  for (Eigen::Index i = 0; i < n; ++i) turns.col(i) = -middle.Evaluate(field.feet[i]).normal;
  middle.SetDisplacements(displacements);
  for (Eigen::Index i = 0; i < n; ++i) turns.col(i) += middle.Evaluate(field.feet[i]).normal;
  return turns;
}

bool CalibrationProblem::Update(bool derivatives) {
  const ShellParameters parameters = Parameters();
  for (size_t g = 0; g < models_.size(); ++g) {
    if (!models_[g]->Solve(parameters, TravelChange(static_cast<int>(g)), &error_)) return false;
  }
  std::vector<char> with_scans(models_.size(), 0);
  for (const Scan& scan : scans_) with_scans[scan.grasp] = 1;
  for (size_t g = 0; g < models_.size(); ++g) {
    if (!with_scans[g]) continue;
    ShellFace& face = *faces_[g];
    const double offset = 0.5 * parameters.thickness;
    if (&face.surface() != &models_[g]->problem().surface() || face.offset() != offset) {
      faces_[g] = std::make_unique<ShellFace>(models_[g]->problem().surface(), offset);
    } else if (face.displacements().size() > 0 &&
               face.displacements() == models_[g]->displacements()) {
      continue;
    }
    faces_[g]->SetDisplacements(models_[g]->displacements());
  }
  for (size_t s = 0; s < scans_.size(); ++s) {
    Scan& scan = scans_[s];
    const RigidPose pose = PoseOf(static_cast<int>(s));
    const ShellFace& face = *faces_[scan.grasp];
    const int count = static_cast<int>(scan.points.size());
    ParallelFor(ThreadsFor(count, num_threads_), count, [&](int, int begin, int end) {
      for (int i = begin; i < end; ++i) {
        scan.moved[i] = pose * scan.points[i];
        scan.feet[i] = face.Closest(scan.moved[i]);
      }
    });
  }
  for (Field& field : fields_) {
    const Eigen::Matrix3Xd& u = models_[field.grasp]->displacements();
    const ShellSurface& surface = models_[field.grasp]->problem().surface();
    field.model.setZero(3, field.points.size());
    for (size_t i = 0; i < field.points.size(); ++i) {
      const std::vector<int>& vertices = surface.control_vertices(field.feet[i].element);
      for (size_t v = 0; v < vertices.size(); ++v) {
        field.model.col(i) += field.weights[i][v] * u.col(vertices[v]);
      }
    }
    if (field.heights.size() > 0) {
      field.model.array() += Turns(field, u).array().rowwise() * field.heights.array();
    }
  }
  if (!derivatives) return true;

  for (Scan& scan : scans_) scan.rates.setZero(5, scan.points.size());
  for (Field& field : fields_) {
    for (auto& rates : field.rates) rates.setZero(3, field.points.size());
  }
  for (auto& rates : force_rates_) rates.fill(0.0);
  for (const StateParameter wanted : Wanted(all_derivatives_)) {
    const int k = static_cast<int>(wanted);
    for (size_t g = 0; g < models_.size(); ++g) {
      const bool travels = spec_.grasps[g].travel_error > 0.0 || all_derivatives_;
      if (wanted == StateParameter::kTravel && (models_[g]->scene().fingers.empty() || !travels)) {
        continue;
      }
      const bool has_gas = FindGas(models_[g]->scene()) != nullptr;
      if (wanted == StateParameter::kGasPressure && !has_gas) continue;
      const StateDerivative* by = nullptr;
      if (!models_[g]->Derivative(wanted, &by, &error_)) {
        if (k < kShell && !spec_.parameters[k].asked) continue;  // for information only
        return false;
      }
      const double unit = k < kShell ? units_[k] : units_[kTravels + g];
      const double thicker =
          wanted == StateParameter::kThickness ? 0.5 * parameters.thickness : 0.0;
      const ShellSurface& surface = models_[g]->problem().surface();
      for (Scan& scan : scans_) {
        if (scan.grasp != static_cast<int>(g)) continue;
        for (size_t i = 0; i < scan.points.size(); ++i) {
          const ShellFace::Foot& foot = scan.feet[i];
          const std::vector<int>& vertices = surface.control_vertices(foot.at.element);
          const Eigen::VectorXd weights = surface.ValueWeights(foot.at);
          double motion = thicker;
          for (size_t v = 0; v < vertices.size(); ++v) {
            motion += weights[v] * foot.normal.dot(by->displacement.col(vertices[v]));
          }
          scan.rates(k, i) = -unit * motion;
        }
      }
      for (Field& field : fields_) {
        if (field.grasp != static_cast<int>(g)) continue;
        for (size_t i = 0; i < field.points.size(); ++i) {
          const std::vector<int>& vertices = surface.control_vertices(field.feet[i].element);
          for (size_t v = 0; v < vertices.size(); ++v) {
            field.rates[k].col(i) += unit * field.weights[i][v] * by->displacement.col(vertices[v]);
          }
        }
        if (field.heights.size() > 0) {
          const Eigen::Matrix3Xd turns =
              TurnRates(field, models_[g]->displacements(), by->displacement);
          field.rates[k].array() += (unit * turns).array().rowwise() * field.heights.array();
        }
      }
      for (size_t f = 0; f < forces_.size(); ++f) {
        if (forces_[f].grasp != static_cast<int>(g)) continue;
        force_rates_[f][k] = unit * by->force[forces_[f].finger];
      }
    }
  }
  return true;
}

void CalibrationProblem::PrepareForEvaluation(bool evaluate_jacobians, bool) {
  failed_ = !Update(evaluate_jacobians);
}

double CalibrationProblem::BareForceOf(const Force& force) const {
  return models_[force.grasp]->forces()[force.finger];
}

double CalibrationProblem::ForceOf(const Force& force) const {
  return BareForceOf(force) * (1.0 + bias()) + drift() * force.time;
}

bool CalibrationProblem::ScanResidual(const Scan& scan,
                                      int point,
                                      double* residual,
                                      double* by_motion) const {
  const ShellFace::Foot& foot = scan.feet[point];
  residual[0] = (foot.distance - rest_offset()) / scan.deviation;
  if (by_motion == nullptr) return std::isfinite(residual[0]);
  const Eigen::Vector3d w(scan.motion.data());
  const Eigen::Vector3d y = scan.pose * scan.points[point] - middle_;
  const Eigen::RowVector3d normal = foot.normal.transpose() / scan.deviation;
  Eigen::Map<Eigen::RowVector3d>{by_motion} = normal * RotationDerivative(w, y);
  Eigen::Map<Eigen::RowVector3d>{by_motion + 3} = size_ * normal;
  return std::isfinite(residual[0]);
}

void CalibrationProblem::FieldResidual(const Field& field,
                                       int point,
                                       double* residuals,
                                       double* by_motion) const {
  // Exact for rotations of any size: those of a testing machine are not small beside strains.
  const Eigen::Vector3d w(field.motion.data()), t(field.motion.data() + 3);
  const Eigen::Vector3d arm = field.points[point] - middle_;
  const Eigen::Vector3d moved = arm + field.model.col(point);
  const Eigen::Vector3d left = Rotation(w) * moved + size_ * t - arm - field.measured[point];
  Eigen::Matrix3d by_rotation = Eigen::Matrix3d::Zero();
  if (by_motion != nullptr) by_rotation = RotationDerivative(w, moved);
  for (int c = 0; c < 3; ++c) {
    const double scale = field.components[c] ? 1.0 / field.deviation : 0.0;
    residuals[c] = scale * left[c];
    if (by_motion == nullptr) continue;
    for (int a = 0; a < 3; ++a) {
      by_motion[6 * c + a] = scale * by_rotation(c, a);
      by_motion[6 * c + 3 + a] = a == c ? scale * size_ : 0.0;
    }
  }
}

Eigen::Vector3d CalibrationProblem::FieldRate(const Field& field, int point, int k) const {
  return Rotation(Eigen::Vector3d(field.motion.data())) * field.rates[k].col(point);
}

void CalibrationProblem::FitMotion(double scale,
                                   Field* field,
                                   Eigen::Matrix3Xd* left,
                                   Eigen::Matrix3Xd* turned) const {
  const Eigen::Index n = static_cast<Eigen::Index>(field->points.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d arm = field->points[i] - middle_;
    from.col(i) = arm + scale * field->model.col(i);
    to.col(i) = arm + field->measured[i];
  }
  Eigen::Matrix3d rotation = Rotation(Eigen::Vector3d(field->motion.data()));
  Eigen::Vector3d translation = size_ * Eigen::Vector3d(field->motion.data() + 3);
  if (field->free_motion) {
    const Eigen::Vector3d from_middle = from.rowwise().mean(), to_middle = to.rowwise().mean();
    const Eigen::Matrix3d h =
        (from.colwise() - from_middle) * (to.colwise() - to_middle).transpose();
    const auto& measured = field->components;
    const int count = measured[0] + measured[1] + measured[2];
    rotation.setIdentity();
    if (count == 3) {
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
      const double sign = (v * u.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
      rotation = v * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * u.transpose();
    } else if (count == 2) {
      const int normal = measured[0] ? (measured[1] ? 2 : 1) : 0;
      const int a = (normal + 1) % 3, b = (normal + 2) % 3;
      const double angle = std::atan2(h(a, b) - h(b, a), h(a, a) + h(b, b));
      rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(normal)).toRotationMatrix();
    }
    translation = to_middle - rotation * from_middle;
    const Eigen::AngleAxisd turn(rotation);
    for (int c = 0; c < 3; ++c) {
      if (!measured[c]) translation[c] = 0.0;
      field->motion[c] = turn.angle() * turn.axis()[c];
      field->motion[3 + c] = translation[c] / size_;
    }
  }
  *left = (rotation * from).colwise() + translation - to;
  *turned = rotation * field->model;
  for (int c = 0; c < 3; ++c) {
    if (field->components[c]) continue;
    left->row(c).setZero();
    turned->row(c).setZero();
  }
}

double CalibrationProblem::Deformation(const Field& field) const {
  Field still = field;
  for (Eigen::Vector3d& u : still.measured) u.setZero();
  Eigen::Matrix3Xd left, turned;
  if (!field.free_motion) still.motion.fill(0.0);
  FitMotion(1.0, &still, &left, &turned);
  return std::sqrt(left.colwise().squaredNorm().maxCoeff());
}

void CalibrationProblem::ForceResidual(const Force& force,
                                       double* residual,
                                       double** jacobians) const {
  const size_t index = &force - forces_.data();
  residual[0] = (ForceOf(force) - force.reading) / force.error;
  if (jacobians == nullptr) return;
  const double scale = 1.0 / force.error;
  for (int k = 0; k < kShell; ++k) {
    if (jacobians[k] != nullptr) {
      jacobians[k][0] = scale * (1.0 + bias()) * force_rates_[index][k];
    }
  }
  if (jacobians[4] != nullptr) jacobians[4][0] = scale * BareForceOf(force) * units_[kBias];
  if (jacobians[5] != nullptr) jacobians[5][0] = scale * force.time * units_[kDrift];
  if (jacobians[6] != nullptr) {
    jacobians[6][0] = scale * (1.0 + bias()) * force_rates_[index][4];
  }
}

void CalibrationProblem::Build(ceres::Problem* problem) {
  std::vector<double*> theta;
  for (int k = 0; k < kShell; ++k) theta.push_back(&unknowns_[k]);
  for (double& unknown : unknowns_) problem->AddParameterBlock(&unknown, 1);
  for (size_t s = 0; s < scans_.size(); ++s) {
    Scan& scan = scans_[s];
    problem->AddParameterBlock(scan.motion.data(), 6);
    if (scan.known_pose) problem->SetParameterBlockConstant(scan.motion.data());
    std::vector<double*> blocks = theta;
    blocks.push_back(&unknowns_[TravelColumn(scan.grasp)]);
    blocks.push_back(&unknowns_[kRest]);
    blocks.push_back(scan.motion.data());
    for (size_t i = 0; i < scan.points.size(); ++i) {
      problem->AddResidualBlock(new ScanBlock(this, static_cast<int>(s), static_cast<int>(i)),
                                RobustLoss(scan.share),
                                blocks);
    }
  }
  for (size_t f = 0; f < fields_.size(); ++f) {
    Field& field = fields_[f];
    problem->AddParameterBlock(field.motion.data(), 6);
    if (!field.free_motion) problem->SetParameterBlockConstant(field.motion.data());
    std::vector<double*> blocks = theta;
    blocks.push_back(&unknowns_[TravelColumn(field.grasp)]);
    blocks.push_back(field.motion.data());
    for (size_t i = 0; i < field.points.size(); ++i) {
      problem->AddResidualBlock(new FieldBlock(this, static_cast<int>(f), static_cast<int>(i)),
                                RobustLoss(field.share),
                                blocks);
    }
  }
  for (size_t f = 0; f < forces_.size(); ++f) {
    std::vector<double*> blocks = theta;
    blocks.push_back(&unknowns_[kBias]);
    blocks.push_back(&unknowns_[kDrift]);
    blocks.push_back(&unknowns_[TravelColumn(forces_[f].grasp)]);
    problem->AddResidualBlock(new ForceBlock(this, static_cast<int>(f)), nullptr, blocks);
  }

  const std::vector<int> nuisances = Nuisances();
  const auto is_free = [&](int column) {
    return std::find(nuisances.begin(), nuisances.end(), column) != nuisances.end();
  };
  for (int k = 0; k < static_cast<int>(unknowns_.size()); ++k) {
    if (k < kShell ? !spec_.parameters[k].asked : !is_free(k)) {
      problem->SetParameterBlockConstant(&unknowns_[k]);
    } else if (k >= kShell &&
               (k < kTravels || std::isfinite(spec_.grasps[k - kTravels].travel_error))) {
      problem->AddResidualBlock(new PriorBlock(0.0, 1.0), nullptr, &unknowns_[k]);
    }
  }
  // Far beyond all sense, and where the solver is still defined.
  constexpr double kDecades = 14.0, kThicker = 1.5;
  if (spec_.parameters[0].asked) {
    problem->SetParameterLowerBound(&unknowns_[0], 0, unknowns_[0] - kDecades);
    problem->SetParameterUpperBound(&unknowns_[0], 0, unknowns_[0] + kDecades);
  }
  if (spec_.parameters[1].asked) {
    problem->SetParameterLowerBound(&unknowns_[1], 0, -kThicker);
    problem->SetParameterUpperBound(&unknowns_[1], 0, kThicker);
  }
  if (spec_.parameters[2].asked) {
    problem->SetParameterLowerBound(&unknowns_[2], 0, -0.99);
    problem->SetParameterUpperBound(&unknowns_[2], 0, 0.5);
  }
  if (spec_.parameters[3].asked) {
    double ambient = 0.0;
    for (const auto& model : models_) {
      const LoadSpec* const gas = FindGas(model->scene());
      if (gas != nullptr) ambient = gas->ambient_pressure;
    }
    problem->SetParameterLowerBound(&unknowns_[3], 0, -0.99 * ambient / units_[3]);
  }
  for (int k = 0; k < kShell; ++k) {
    const CalibrationSpec::Parameter& p = spec_.parameters[k];
    if (!p.asked || !p.prior) continue;
    const bool logarithm = k < 2;
    const double reference = k == 0 ? start_.young_modulus : start_.thickness;
    const double value = logarithm ? std::log(*p.prior / reference) : *p.prior / units_[k];
    const double deviation = logarithm ? *p.prior_error / *p.prior : *p.prior_error / units_[k];
    problem->AddResidualBlock(new PriorBlock(value, deviation), nullptr, &unknowns_[k]);
  }
}

std::vector<int> CalibrationProblem::Interest() const {
  std::vector<int> interest;
  for (int k = 0; k < kShell; ++k) {
    if (spec_.parameters[k].asked) interest.push_back(k);
  }
  return interest;
}

std::vector<int> CalibrationProblem::Nuisances() const {
  std::vector<int> nuisances;
  if (!forces_.empty()) {
    if (spec_.model_error > 0.0) nuisances.push_back(kBias);
    if (spec_.force_drift > 0.0) nuisances.push_back(kDrift);
  }
  if (!scans_.empty() && spec_.rest_error != 0.0) nuisances.push_back(kRest);
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    if (spec_.grasps[g].travel_error > 0.0 && !models_[g]->scene().fingers.empty()) {
      nuisances.push_back(TravelColumn(static_cast<int>(g)));
    }
  }
  const auto add = [&](int column) {
    for (int a = 0; a < 6; ++a) nuisances.push_back(column + a);
  };
  for (const Scan& scan : scans_) {
    if (!scan.known_pose) add(scan.column);
  }
  for (const Field& field : fields_) {
    if (field.free_motion) add(field.column);
  }
  return nuisances;
}

bool CalibrationProblem::Linearise(Posterior* posterior, std::vector<Row>* rows) {
  all_derivatives_ = true;
  const bool updated = Update(true);
  all_derivatives_ = false;
  if (!updated) return false;
  const auto add = [&](Row row) {
    posterior->Add(row.columns, row.coefficients, row.residual, row.weight);
    if (rows != nullptr) rows->push_back(std::move(row));
  };
  for (size_t s = 0; s < scans_.size(); ++s) {
    const Scan& scan = scans_[s];
    Row row;
    row.scan = static_cast<int>(s);
    row.columns = {0, 1, 2, 3, TravelColumn(scan.grasp)};
    for (int a = 0; a < 6; ++a) row.columns.push_back(scan.column + a);
    row.coefficients.resize(11);
    for (size_t i = 0; i < scan.points.size(); ++i) {
      row.coefficients.head<5>() = scan.rates.col(i) / scan.deviation;
      if (!ScanResidual(scan, static_cast<int>(i), &row.residual, row.coefficients.data() + 5)) {
        return false;
      }
      row.weight = scan.share * RobustWeight(row.residual * row.residual);
      add(row);
    }
  }
  for (size_t f = 0; f < fields_.size(); ++f) {
    const Field& field = fields_[f];
    Row row;
    row.scan = static_cast<int>(scans_.size() + f);
    row.columns = {0, 1, 2, 3, TravelColumn(field.grasp)};
    for (int a = 0; a < 6; ++a) row.columns.push_back(field.column + a);
    row.coefficients.resize(11);
    for (size_t i = 0; i < field.points.size(); ++i) {
      double residuals[3], by_motion[18];
      FieldResidual(field, static_cast<int>(i), residuals, by_motion);
      const double weight =
          field.share * RobustWeight(Eigen::Map<Eigen::Vector3d>(residuals).squaredNorm());
      Eigen::Matrix<double, 3, 5> rates;
      for (int k = 0; k < 5; ++k) {
        rates.col(k) = FieldRate(field, static_cast<int>(i), k) / field.deviation;
      }
      for (int c = 0; c < 3; ++c) {
        if (!field.components[c]) continue;
        for (int k = 0; k < 5; ++k) row.coefficients[k] = rates(c, k);
        for (int a = 0; a < 6; ++a) row.coefficients[5 + a] = by_motion[6 * c + a];
        row.residual = residuals[c];
        row.weight = weight;
        add(row);
      }
    }
  }
  for (const Force& force : forces_) {
    Row row;
    row.columns = {0, 1, 2, 3, kBias, kDrift, TravelColumn(force.grasp)};
    row.coefficients.resize(7);
    double* jacobians[7];
    for (int k = 0; k < 7; ++k) jacobians[k] = &row.coefficients[k];
    ForceResidual(force, &row.residual, jacobians);
    add(row);
  }
  for (const int k : Nuisances()) {
    if (k >= static_cast<int>(unknowns_.size())) break;
    if (k >= kTravels && !std::isfinite(spec_.grasps[k - kTravels].travel_error)) continue;
    Row row;
    row.columns = {k};
    row.coefficients = Eigen::VectorXd::Ones(1);
    row.residual = unknowns_[k];
    add(row);
  }
  return true;
}

}  // namespace darboux
