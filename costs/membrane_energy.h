#ifndef DARBOUX_COSTS_MEMBRANE_ENERGY_H_
#define DARBOUX_COSTS_MEMBRANE_ENERGY_H_

#include "costs/strain_energy.h"

namespace darboux {

// The membrane strain as StrainEnergy asks for it.
struct MembraneKernel {
  static constexpr int kInputs = kMembraneInputs;
  static constexpr int kFirstRow = kRowD1;
  template <typename T>
  static bool Evaluate(StrainMeasure measure, const StrainPoint& point, const T* inputs, T* e) {
    EvaluateMembraneStrain(measure, point, inputs, e);
    return true;
  }
};

// Stretch and in-plane shear energy; Tian & Jia (2010), eq. (58), term 1, eq. (38) in the linear
// theory:
//
//   U = E h / (2 (1 - nu^2)) (e11^2 + e22^2 + 2 nu e11 e22 + (1 - nu)/2 e12^2) dA   [J]
//
// Residuals and parameters: see StrainEnergy.
class MembraneEnergy : public StrainEnergy<MembraneKernel> {
 public:
  // tension_rows: behind the three residuals of each point stand six more that are always zero
  // but whose Jacobian carries the positive part of the membrane stress, so that J^T J contains
  // the stiffness that tension gives to transverse displacement. Energy and gradient are
  // unchanged; a stretched plate then converges in Newton's few iterations instead of hundreds.
  MembraneEnergy(StrainPoints points,
                 StrainMeasure measure,
                 const Material& material,
                 bool tension_rows = false);

  bool Evaluate(double const* const* displacements,
                double* residuals,
                double** jacobians) const override;

 private:
  static constexpr int kTensionRows = 6;
  bool tension_rows_;
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_MEMBRANE_ENERGY_H_
