#ifndef DARBOUX_COSTS_BENDING_ENERGY_H_
#define DARBOUX_COSTS_BENDING_ENERGY_H_

#include "costs/strain_energy.h"

namespace darboux {

// The bending strain as StrainEnergy asks for it.
struct BendingKernel {
  static constexpr int kInputs = kBendingInputs;
  static constexpr int kFirstRow = kRowD1;
  template <typename T>
  static bool Evaluate(StrainMeasure measure, const StrainPoint& point, const T* inputs, T* e) {
    return EvaluateBendingStrain(measure, point, inputs, e);
  }
};

// Bending and twisting energy; Tian & Jia (2010), eq. (58), term 2, eq. (38) in the linear theory:
//
//   U = E h^3 / (24 (1 - nu^2)) (z11^2 + z22^2 + 2 nu z11 z22 + (1 - nu)/2 z12^2) dA   [J]
//
// Residuals and parameters: see StrainEnergy. Evaluation fails (Ceres rejects the step) where the
// deformed surface has no normal.
class BendingEnergy : public StrainEnergy<BendingKernel> {
 public:
  BendingEnergy(StrainPoints points, StrainMeasure measure, const Material& material)
      : StrainEnergy(
            std::move(points), measure, material.BendingStiffness(), material.poisson_ratio) {}
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_BENDING_ENERGY_H_
