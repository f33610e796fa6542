#ifndef DARBOUX_SOLVER_RESOLUTION_H_
#define DARBOUX_SOLVER_RESOLUTION_H_

#include <optional>
#include <string>

#include "solver/shell_problem.h"

namespace darboux {

// Whether a mesh can show the state that a problem is in. Coarse meshes of thin shells lock: they
// resist bending by membrane stresses that jump from element to element, and the answer, in perfect
// equilibrium, is a small part of the true one.
struct Resolution {
  // Sum of e_K^2 / 2 over the strain energy (StressRecovery), of the stresses that the deformation
  // adds. Measured: relative errors of displacements and forces are 0.4 to 2.5 times this up to
  // 0.15; from 0.25 on shells are 1.4 to 1e4 times too stiff. 0 without deformation.
  double roughness = 0.0;
  // Angle that the rest normal turns by within an element, mean over the area, rad; where large,
  // points are too few to tell roughness. 0 on meshes, whose shape is what control points make it.
  double turn = 0.0;

  static constexpr double kMostRoughness = 0.25, kMostTurn = 0.6;
  static constexpr double kDoubtfulRoughness = 0.05;

  bool IsSufficient() const { return roughness <= kMostRoughness && turn <= kMostTurn; }
  // What is wrong in one line; empty where nothing is.
  std::string Complaint() const;
};

// Of the problem's present displacements. None where strains are undefined.
std::optional<Resolution> CheckResolution(const ShellProblem& problem, int num_threads);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_RESOLUTION_H_
