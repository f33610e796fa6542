#ifndef DARBOUX_SOLVER_MAGNITUDES_H_
#define DARBOUX_SOLVER_MAGNITUDES_H_

#include <string>

#include "solver/scene.h"

namespace darboux {

// What a scene's numbers come to, in its own units. Sums of squares of forces and lengths have to
// stay between the smallest and the largest double; where they do not, loads vanish without a sign
// (1e-200 squared is zero) or forces are infinite.
struct Magnitudes {
  double size = 0.0;           // of the surface, m
  double bending_force = 0.0;  // D / size^2, the force that bends the shell by its size, N
  double loads = 0.0;          // sum of the sizes of all forces and moments / size, N; 0 = none
};

// False and *error, with the place in the scene, where they cannot be computed with. The limits
// leave room for any unit anybody measures in: sizes and thicknesses from 1e-60 to 1e60, forces
// from 1e-120 to 1e120, loads from 1e-100 to 1e100 of the bending force.
bool CheckMagnitudes(const Scene& scene, const Magnitudes& magnitudes, std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_MAGNITUDES_H_
