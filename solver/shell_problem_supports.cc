#include <glog/logging.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "solver/mesh_surface.h"
#include "solver/plane_basis.h"
#include "solver/shell_problem.h"

// What holds the shell: supports by springs with multipliers, and the means and pins of the motions
// that no support removes.

namespace darboux {

bool ShellProblem::HoldRigidMotions(std::string* error) {
  Eigen::MatrixXd rows(conditions_.size(), 6);
  for (size_t i = 0; i < conditions_.size(); ++i) rows.row(i) = conditions_[i].rigid_row;
  // Motions of the unknown part of the displacement.
  Eigen::MatrixXd allowed = Eigen::MatrixXd::Identity(6, 6);
  const Eigen::Matrix<double, 3, 2> plane = PlaneBasis(plate_normal_);
  if (unknowns_ == Unknowns::kNormalOnly) {
    allowed = Eigen::MatrixXd::Zero(6, 3);
    allowed.block<3, 1>(0, 0) = plate_normal_;
    allowed.block<3, 2>(3, 1) = plane;
  } else if (unknowns_ == Unknowns::kInPlaneOnly) {
    allowed = Eigen::MatrixXd::Zero(6, 3);
    allowed.block<3, 2>(0, 0) = plane;
    allowed.block<3, 1>(3, 2) = plate_normal_;
  }
  const Eigen::MatrixXd motions = FreeMotions(rows, allowed);
  if (motions.cols() == 0) return true;
  free_motions_ = NameMotions(motions, frame_);

  // Loads that drive a free motion have no equilibrium.
  // Leaves of different sizes integrate loads that balance to the digits of their rules only, not
  // to rounding as a symmetric mesh does: the means hold what is left.
  constexpr double kBalance = 1e-6, kRefinedBalance = 1e-4;
  const double balance = scene_.surface.mesh != nullptr && IsRefinedLocally(scene_.surface)
                             ? kRefinedBalance
                             : kBalance;
  const Eigen::VectorXd work = motions.transpose() * dead_loads_.rigid_work;
  if (grasp_ == nullptr && work.norm() > balance * dead_loads_.rigid_scale) {
    // Where the supports stand, or else where they are missing.
    const SceneLocation& where =
        scene_.supports.empty() ? scene_.surface.location : scene_.supports.front().location;
    *error = where.file + ":" + std::to_string(where.line) +
             ": supports: found nothing that holds the shell against ";
    for (size_t i = 0; i < free_motions_.size(); ++i) {
      *error += (i == 0 ? "" : "; ") + free_motions_[i];
    }
    *error +=
        ", while the loads drive it; allowed are supports that remove these motions, or "
        "loads in balance on them";
    return false;
  }

  // The mean of motion . displacement over the shell. Stiff beside what dead loads that press on a
  // free shell turn it by: multipliers settle only where it is more than twice that.
  const double stiffness = (grasp_ == nullptr ? 100.0 : 1.0) * scaled_material_.MembraneStiffness();
  double area = 0.0;
  for (int k = 0; k < motions.cols(); ++k) {
    mean_conditions_.push_back({Eigen::Matrix3Xd::Zero(3, displacements_.cols()), stiffness});
  }
  for (size_t e = 0; e < points_.size(); ++e) {
    const std::vector<int>& vertices = surface_->control_vertices(static_cast<int>(e));
    for (const StrainPoint& point : *points_[e]) {
      area += point.area;
      for (int k = 0; k < motions.cols(); ++k) {
        const Eigen::Vector3d turn = motions.col(k).tail<3>() / frame_.length;
        const Eigen::Vector3d motion =
            motions.col(k).head<3>() + turn.cross(point.position - frame_.center);
        Eigen::Matrix3Xd& coefficients = mean_conditions_[k].coefficients;
        for (size_t i = 0; i < vertices.size(); ++i) {
          coefficients.col(vertices[i]) += point.area * point.weights(kRowValue, i) * motion;
        }
      }
    }
  }
  for (MeanCondition& mean : mean_conditions_) mean.coefficients /= area;

  // Pins: as many displacement components as there are free motions, at points where the motions
  // are largest (pivoted QR).
  std::vector<PlacedCondition> candidates;
  const int stride = std::max(1, surface_->num_elements() / 256);
  for (int e = 0; e < surface_->num_elements(); e += stride) {
    const ElementPoint at{e, 1.0 / 3.0, 1.0 / 3.0};
    const StrainPoint point = surface_->MakePoint(at);
    for (const Eigen::Vector3d& direction : {point.t1, point.t2, point.n}) {
      candidates.push_back(PointCondition(*surface_, at, direction, scaled_material_, frame_));
    }
  }
  Eigen::MatrixXd moved(motions.cols(), candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    moved.col(i) = (candidates[i].rigid_row * motions).transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(moved);
  for (int k = 0; k < motions.cols(); ++k) {
    pins_.push_back(candidates[qr.colsPermutation().indices()[k]]);
  }
  pin_targets_.assign(pins_.size(), 0.0);
  held_forces_.assign(mean_conditions_.size(), 0.0);
  return true;
}

void ShellProblem::SetTargets() {
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    targets_[i] = load_factor_ * conditions_[i].target - multipliers_[i] / conditions_[i].stiffness;
  }
}

double ShellProblem::Violation(const PlacedCondition& condition) const {
  double c = -load_factor_ * condition.target;
  for (size_t i = 0; i < condition.vertices.size(); ++i) {
    c += condition.coefficients.col(i).dot(displacements_.col(condition.vertices[i]));
  }
  return c;
}

void ShellProblem::SetMultipliers(const std::vector<double>& multipliers) {
  CHECK_EQ(multipliers.size(), multipliers_.size());
  multipliers_ = multipliers;
  SetTargets();
}

double ShellProblem::MeanForce(size_t k) const {
  if (grasp_ != nullptr) return 0.0;
  const MeanCondition& mean = mean_conditions_[k];
  return mean.stiffness * mean.coefficients.cwiseProduct(displacements_).sum() +
         multipliers_[conditions_.size() + k];
}

void ShellProblem::HoldHere() {
  if (gas_ != nullptr)
    gas_->at.resize(3, 0);  // Shares can have moved where displacements have not.
  UpdateGas();
  if (mean_conditions_.empty()) return;
  for (size_t i = 0; i < pins_.size(); ++i) {
    pin_targets_[i] = 0.0;
    for (size_t k = 0; k < pins_[i].vertices.size(); ++k) {
      pin_targets_[i] += pins_[i].coefficients.col(k).dot(displacements_.col(pins_[i].vertices[k]));
    }
  }
  held_.setZero();
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    held_forces_[k] = MeanForce(k);
    held_ -= held_forces_[k] * mean_conditions_[k].coefficients;
  }
  SetLoadFactor(load_factor_);
}

void ShellProblem::KeepMeanForces() {
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    multipliers_[conditions_.size() + k] += held_forces_[k] - MeanForce(k);
  }
}

void ShellProblem::UpdateMultipliers() {
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    multipliers_[conditions_.size() + k] = MeanForce(k);
  }
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    multipliers_[i] += conditions_[i].stiffness * Violation(conditions_[i]);
  }
  SetTargets();
}

double ShellProblem::LargestViolation() const {
  double largest = 0.0;
  for (const PlacedCondition& condition : conditions_) {
    if (condition.stiffness == 0.0) continue;
    largest = std::max(largest, condition.arm * std::abs(Violation(condition)));
  }
  const double size = displacements_.cwiseAbs().maxCoeff();
  return size > 0.0 ? largest / size : 0.0;
}

double ShellProblem::LargestViolation(int* support) const {
  *support = -1;
  double largest = 0.0;
  for (const PlacedCondition& condition : conditions_) {
    if (condition.support < 0 || condition.stiffness == 0.0) continue;
    if (condition.direction.isZero(0.0)) continue;
    const double c = Violation(condition);
    if (std::abs(c) > largest) {
      largest = std::abs(c);
      *support = condition.support;
    }
  }
  const double size = displacements_.cwiseAbs().maxCoeff();
  return size > 0.0 ? largest / size : 0.0;
}

double ShellProblem::SupportEnergy() const {
  double energy = 0.0;
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    const double c = Violation(conditions_[i]);
    energy += (0.5 * conditions_[i].stiffness * c + multipliers_[i]) * c;
  }
  for (size_t k = 0; k < mean_conditions_.size() && grasp_ == nullptr; ++k) {
    const MeanCondition& mean = mean_conditions_[k];
    const double c = mean.coefficients.cwiseProduct(displacements_).sum();
    energy += (0.5 * mean.stiffness * c + multipliers_[conditions_.size() + k]) * c;
  }
  return energy;
}

Eigen::Matrix3Xd ShellProblem::SupportGradient() const {
  Eigen::Matrix3Xd gradient = Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  for (size_t i = 0; i < conditions_.size(); ++i) {
    const PlacedCondition& condition = conditions_[i];
    if (condition.stiffness == 0.0) continue;
    const double force = condition.stiffness * Violation(condition) + multipliers_[i];
    for (size_t k = 0; k < condition.vertices.size(); ++k) {
      gradient.col(condition.vertices[k]) += force * condition.coefficients.col(k);
    }
  }
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    gradient += MeanForce(k) * mean_conditions_[k].coefficients;
  }
  return gradient;
}

}  // namespace darboux
