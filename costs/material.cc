#include "costs/material.h"

#include <cmath>

namespace darboux {

bool Material::IsValid(std::string* error) const {
  const auto fail = [&](const char* what) {
    *error = what;
    return false;
  };
  if (!(thickness > 0.0) || !std::isfinite(thickness)) return fail("thickness must be positive");
  if (!(young_modulus > 0.0) || !std::isfinite(young_modulus)) {
    return fail("young_modulus must be positive");
  }
  if (!(poisson_ratio > -1.0 && poisson_ratio <= 0.5)) {
    return fail("poisson_ratio must lie in (-1, 0.5]");
  }
  if (!(density >= 0.0) || !std::isfinite(density)) return fail("density must not be negative");
  return true;
}

}  // namespace darboux
