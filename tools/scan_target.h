#ifndef DARBOUX_TOOLS_SCAN_TARGET_H_
#define DARBOUX_TOOLS_SCAN_TARGET_H_

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/scan_simulator.h"
#include "solver/report_view.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What darboux_scan scans: the face of a scene, which is solved, or of somebody's file.
struct ScanTargetOptions {
  int state = 0;            // load step of the scene; 0: the last
  bool vertices = false;    // are the places to scan, not random points
  double thickness = -1.0;  // of a file; < 0: that of `scene`, or 0
  std::string scene;        // the file's scene; empty: none
  std::string faces;        // mesh whose vertices the file has; empty: none
  int revolve = 0;          // meridians that a profile is turned about the z axis with; 0: none
};

struct ScanTarget {
  ScanSurface surface;
  std::vector<Occluder> occluders;
  double thickness = 0.0;                     // 0: the file is the face
  nlohmann::ordered_json solution = nullptr;  // of a scene: what was solved
  std::unique_ptr<ShellProblem> problem;      // whose surface is scanned
  SolverSummary summary;                      // up to the state that is scanned
  Scene scene;                                // of a file: that of --scene
  std::vector<PlacedFinger> fingers;          // of it
};

// By the ending of the name.
bool IsSceneFile(const std::string& file);

// Messages name the flags of darboux_scan. The exit status, and *error where it is not kExitDone.
int SolveScanScene(const std::string& file,
                   const ScanTargetOptions& options,
                   ScanTarget* target,
                   std::string* error);
bool ReadScanSurface(const std::string& file,
                     const ScanTargetOptions& options,
                     ScanTarget* target,
                     std::string* error);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_SCAN_TARGET_H_
