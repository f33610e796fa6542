#ifndef DARBOUX_COSTS_STRAIN_ENERGY_H_
#define DARBOUX_COSTS_STRAIN_ENERGY_H_

#include <ceres/cost_function.h>
#include <ceres/jet.h>

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "costs/material.h"
#include "costs/strain_measures.h"
#include "geometry/strain_point.h"

namespace darboux {

// Quadrature points that share their control vertices: all those of one element, or a single one.
using StrainPoints = std::shared_ptr<const std::vector<StrainPoint>>;

// Common part of the strain energies (58). With C = [1 nu 0; nu 1 0; 0 0 (1 - nu)/2] and a
// stiffness B, the energy of a point that stands for the area dA is B/2 e^T C e dA = 1/2 |r|^2,
//
//   r = sqrt(B dA) [e11 + nu e22, sqrt(1 - nu^2) e22, sqrt((1 - nu)/2) e12]   (e12 = 2 x tensor)
//
// i.e. r = sqrt(B dA) L^T e, L the Cholesky factor of C; three residuals per quadrature point, in
// sqrt(J). One residual block holds the points of one element, because Ceres' cost per block is
// several times that of a point (tests/kernel_benchmark.cc); a block of a single point is
// the same code.
//
// Autodiff runs over the Kernel::kInputs kinematic numbers of a point; the weights that make them
// from control displacements are constant, so the chain rule is a product of small matrices.
//
// Kernel: static constexpr int kInputs, kFirstRow; template <T> bool Evaluate(measure, point,
// const T* inputs, T* strain) const.
// Parameters: one block of 3 per control vertex, its displacement.
template <typename Kernel>
class StrainEnergy : public ceres::CostFunction {
 public:
  StrainEnergy(StrainPoints points, StrainMeasure measure, double stiffness, double poisson_ratio)
      : points_(std::move(points)), measure_(measure), stiffness_(stiffness) {
    factor_ << 1.0, poisson_ratio, 0.0,                            //
        0.0, std::sqrt(1.0 - poisson_ratio * poisson_ratio), 0.0,  //
        0.0, 0.0, std::sqrt(0.5 * (1.0 - poisson_ratio));
    const int num_vertices = static_cast<int>(points_->front().weights.cols());
    for (int i = 0; i < num_vertices; ++i) mutable_parameter_block_sizes()->push_back(3);
    set_num_residuals(3 * static_cast<int>(points_->size()));
  }

  bool Evaluate(double const* const* displacements,
                double* residuals,
                double** jacobians) const override {
    return EvaluatePoints(displacements, residuals, jacobians, nullptr);
  }

  const std::vector<StrainPoint>& points() const { return *points_; }

  // Strains per point that the shell has at rest already, those of its initial stress: r = sqrt(B
  // dA) L^T (e + e_0). One per point, or none.
  void SetInitialStrains(std::vector<Eigen::Vector3d> strains) {
    initial_strains_ = std::move(strains);
  }

 protected:
  static constexpr int kBlocks = Kernel::kInputs / 3;
  using Jet = ceres::Jet<double, Kernel::kInputs>;
  using Inputs = Eigen::Matrix<double, 3, kBlocks>;  // column b: b-th kinematic vector

  // Kinematic vectors of a point.
  Inputs KinematicInputs(const StrainPoint& point, double const* const* displacements) const {
    Inputs inputs = Inputs::Zero();
    for (int i = 0; i < point.weights.cols(); ++i) {
      const Eigen::Map<const Eigen::Vector3d> u(displacements[i]);
      for (int b = 0; b < kBlocks; ++b) {
        inputs.col(b) += point.weights(Kernel::kFirstRow + b, i) * u;
      }
    }
    return inputs;
  }

  // Residual rows and Jacobian rows of all points; rows_per_point >= 3 leaves room for a derived
  // class's own rows behind the three strain residuals of each point. on_point, where given, is
  // called with (point index, inputs, strain residuals).
  template <typename OnPoint = std::nullptr_t>
  bool EvaluatePoints(double const* const* displacements,
                      double* residuals,
                      double** jacobians,
                      OnPoint on_point,
                      int rows_per_point = 3) const {
    const int num_vertices = static_cast<int>(parameter_block_sizes().size());
    for (size_t q = 0; q < points_->size(); ++q) {
      const StrainPoint& point = (*points_)[q];
      const Inputs inputs = KinematicInputs(point, displacements);
      const Eigen::Matrix3d scale = std::sqrt(stiffness_ * point.area) * factor_;
      Eigen::Map<Eigen::Vector3d> r(residuals + rows_per_point * q);
      if (jacobians == nullptr) {
        Eigen::Vector3d strain;
        if (!Kernel::Evaluate(measure_, point, inputs.data(), strain.data())) return false;
        r.noalias() = scale * strain;
      } else {
        std::array<Jet, Kernel::kInputs> jets;
        for (int k = 0; k < Kernel::kInputs; ++k) jets[k] = Jet(inputs.data()[k], k);
        std::array<Jet, 3> strain;
        if (!Kernel::Evaluate(measure_, point, jets.data(), strain.data())) return false;
        r.noalias() = scale * Eigen::Vector3d(strain[0].a, strain[1].a, strain[2].a);
        Eigen::Matrix<double, 3, Kernel::kInputs> gradient;
        for (int row = 0; row < 3; ++row) gradient.row(row) = strain[row].v.transpose();
        gradient = scale * gradient;
        // Column-major 3 x kInputs is 9 x kBlocks: column b holds d r / d (kinematic vector b).
        const Eigen::Map<const Eigen::Matrix<double, 9, kBlocks>> by_block(gradient.data());
        for (int i = 0; i < num_vertices; ++i) {
          if (jacobians[i] == nullptr) continue;
          const Eigen::Matrix<double, 9, 1> d =
              by_block *
              point.weights.col(i).template segment<kBlocks>(static_cast<int>(Kernel::kFirstRow));
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
              jacobians[i] + 3 * rows_per_point * q) = Eigen::Map<const Eigen::Matrix3d>(d.data());
        }
      }
      if (!initial_strains_.empty()) r += scale * initial_strains_[q];
      if constexpr (!std::is_same_v<OnPoint, std::nullptr_t>) {
        on_point(static_cast<int>(q), inputs, Eigen::Vector3d(r));
      }
    }
    return true;
  }

  StrainPoints points_;
  StrainMeasure measure_;
  double stiffness_;
  Eigen::Matrix3d factor_;
  std::vector<Eigen::Vector3d> initial_strains_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_STRAIN_ENERGY_H_
