#ifndef DARBOUX_SOLVER_SCANNED_STATE_H_
#define DARBOUX_SOLVER_SCANNED_STATE_H_

#include <string>
#include <vector>

#include "geometry/scan_simulator.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What a scanner sees of a load step: the outer face of the deformed shell, and the fingers, which
// hide parts of it. For SimulateScan (geometry/scan_simulator.h).

// Which points are scanned.
enum class ScanSampling {
  kArea,     // random points of the face, uniform by area
  kVertices  // the points of MakeOutputMesh (solver/fields.h)
};

// Elements are cut so that the face is hidden by about 1e5 triangles. The problem must outlive the
// result.
ScanSurface ScannedFace(const ShellProblem& problem, const LoadStep& step, ScanSampling sampling);

// The scene's fingers where this step has them, but for pins, which are as thin as a ray. False and
// *error where a finger's mesh is no closed one.
bool FingersOf(const Scene& scene,
               const LoadStep& step,
               std::vector<Occluder>* fingers,
               std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SCANNED_STATE_H_
