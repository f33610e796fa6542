#ifndef DARBOUX_COSTS_MATERIAL_H_
#define DARBOUX_COSTS_MATERIAL_H_

#include <string>

namespace darboux {

// Isotropic, linearly elastic (St. Venant-Kirchhoff) shell of constant thickness. Any consistent
// system of units; SI in comments.
struct Material {
  double thickness = 0.0;      // m, > 0
  double young_modulus = 0.0;  // Pa, > 0
  double poisson_ratio = 0.0;  // in (-1, 1/2]; 1/2 (rubber) is legal in plane stress
  double density = 0.0;        // kg/m^3, >= 0; needed by gravity only

  bool IsValid(std::string* error) const;

  // E h / (1 - nu^2), N/m
  double MembraneStiffness() const {
    return young_modulus * thickness / (1.0 - poisson_ratio * poisson_ratio);
  }
  // D = E h^3 / (12 (1 - nu^2)), N m
  double BendingStiffness() const { return MembraneStiffness() * thickness * thickness / 12.0; }
};

}  // namespace darboux

#endif  // DARBOUX_COSTS_MATERIAL_H_
