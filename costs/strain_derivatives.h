#ifndef DARBOUX_COSTS_STRAIN_DERIVATIVES_H_
#define DARBOUX_COSTS_STRAIN_DERIVATIVES_H_

#include <Eigen/Core>

#include "costs/strain_measures.h"
#include "geometry/strain_point.h"

namespace darboux {

// All six strains of a point (e_11, e_22, 2 e_12, rho_11, rho_22, 2 rho_12) and their derivatives
// by the fifteen kinematic numbers, written out by hand: three to four times as fast as autodiff,
// which the tests hold them against. What solves equations of its own beside Ceres (the factorised
// normal matrix, the mixed iteration) uses these; the residual blocks keep autodiff.
struct StrainDerivatives {
  Eigen::Matrix<double, 6, 1> strain;
  // Row a: d strain_a / d (d_1, d_2, H_11, H_12, H_22).
  Eigen::Matrix<double, 6, kBendingInputs> gradient;
};

// `kinematics`: fifteen numbers, as for EvaluateBendingStrain. False where that returns false.
bool EvaluateStrainDerivatives(StrainMeasure measure,
                               const StrainPoint& point,
                               const double* kinematics,
                               StrainDerivatives* result);

// Adds sum_a stress_a d^2 strain_a / dk dk: the stress (initial, geometric) stiffness of a point.
// Nothing for the linear measures. Precondition: EvaluateStrainDerivatives succeeds.
void AddStressStiffness(StrainMeasure measure,
                        const StrainPoint& point,
                        const double* kinematics,
                        const Eigen::Matrix<double, 6, 1>& stress,
                        Eigen::Matrix<double, kBendingInputs, kBendingInputs>* stiffness);

}  // namespace darboux

#endif  // DARBOUX_COSTS_STRAIN_DERIVATIVES_H_
