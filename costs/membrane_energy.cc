#include "costs/membrane_energy.h"

#include <algorithm>
#include <cmath>

namespace darboux {

MembraneEnergy::MembraneEnergy(StrainPoints points,
                               StrainMeasure measure,
                               const Material& material,
                               bool tension_rows)
    : StrainEnergy(
          std::move(points), measure, material.MembraneStiffness(), material.poisson_ratio),
      tension_rows_(tension_rows && !IsLinear(measure)) {
  if (tension_rows_) {
    set_num_residuals((3 + kTensionRows) * static_cast<int>(points_->size()));
  }
}

bool MembraneEnergy::Evaluate(double const* const* displacements,
                              double* residuals,
                              double** jacobians) const {
  if (!tension_rows_) return EvaluatePoints(displacements, residuals, jacobians, nullptr);

  constexpr int kRows = 3 + kTensionRows;
  const auto add_tension = [&](int q, const Inputs&, const Eigen::Vector3d& r) {
    const StrainPoint& point = (*points_)[q];
    Eigen::Map<Eigen::Matrix<double, kTensionRows, 1>>(residuals + kRows * q + 3).setZero();
    if (jacobians == nullptr) return;
    // Stress resultants times dA from the residual: with e = strain, r = s L^T e and
    // N dA = B C e dA = s L r, s = sqrt(B dA).
    const double s = std::sqrt(stiffness_ * point.area);
    const Eigen::Vector3d n = s * factor_.transpose() * r;  // N_11, N_22, N_12
    // Principal stresses and directions of the symmetric 2 x 2 matrix.
    const double mean = 0.5 * (n[0] + n[1]);
    const double radius = std::hypot(0.5 * (n[0] - n[1]), n[2]);
    const double angle = 0.5 * std::atan2(n[2], 0.5 * (n[0] - n[1]));
    const double principal[2] = {mean + radius, mean - radius};
    const double direction[2][2] = {{std::cos(angle), std::sin(angle)},
                                    {-std::sin(angle), std::cos(angle)}};
    for (int i = 0; i < point.weights.cols(); ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, kTensionRows, 3, Eigen::RowMajor>> rows(jacobians[i] +
                                                                               3 * (kRows * q + 3));
      for (int a = 0; a < 2; ++a) {
        const double factor =
            std::sqrt(std::max(principal[a], 0.0)) * (direction[a][0] * point.weights(kRowD1, i) +
                                                      direction[a][1] * point.weights(kRowD2, i));
        rows.middleRows<3>(3 * a) = factor * Eigen::Matrix3d::Identity();
      }
    }
  };
  return EvaluatePoints(displacements, residuals, jacobians, add_tension, kRows);
}

}  // namespace darboux
