#ifndef DARBOUX_TOOLS_SCAN_FIT_H_
#define DARBOUX_TOOLS_SCAN_FIT_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/rigid_pose.h"
#include "geometry/shell_face.h"
#include "solver/report_view.h"
#include "solver/results.h"
#include "solver/scene.h"
#include "solver/shape_fit.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"

namespace darboux {

// What darboux_fit and the Python module do with a scene and a scan: where the scene has causes,
// its own equilibrium, then registration or a fit of the deformation (solver/registration.h,
// solver/shape_fit.h). Any consistent system of units; the scan in the scene's unit of length.
struct ScanFitOptions {
  SolverOptions solver;
  std::string mode = "fit";  // fit | register
  // fit: scene, the reference is the scene's own equilibrium; none, the shell at rest. Empty: scene
  // where it has fingers or loads.
  std::string fingers;
  std::string against = "deformed";  // register: deformed, the scene's equilibrium | rest
  std::string method = "robust";     // register: robust | undeformed_first
  double undeformed_part = 0.05;     // (0, 1], RegistrationOptions
  std::string face = "outer";        // the scanned face: outer | inner | middle
  double noise = 0.0;                // standard deviation along normals; 0: estimated
  double weight = 0.0;               // ShapeFitOptions; 0: by the discrepancy principle
  std::function<void(const ShapeFitIteration&)> on_iteration;  // fit
  std::uint64_t seed = 1;  // of the points drawn for the search of the pose

  // *error: "NAME: found ...; allowed ..."
  bool IsValid(std::string* error) const;
};

struct ScanFit {
  Scene scene;
  bool is_fitted = false;  // else only registered
  bool converged = false;
  std::string verdict, report;               // one line; several
  nlohmann::ordered_json json;               // fit.json
  std::optional<SolverSummary> equilibrium;  // the scene's own, where it was asked for
  Eigen::Matrix3Xd displacements;  // control displacements; the reference where nothing matched
  // Empty where nothing matched.
  RigidPose pose;  // scan -> shell
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;  // signed, > 0 outside
  std::vector<char> counts;       // whether a point has a part in the map of errors
  double face_offset = 0.0;
  std::shared_ptr<ShellProblem> shell;  // without loads and fingers
};

// `scan_name` goes into fit.json and messages. False and *error on bad input; what went wrong later
// is in *fit. options.solver.stop ends it early.
bool FitScan(const Scene& scene,
             const std::vector<Eigen::Vector3d>& scan,
             const std::string& scan_name,
             const ScanFitOptions& options,
             ScanFit* fit,
             std::string* error);

// fit.json, and where something matched shell.vtu with the map of errors, deformed.ply and
// scan_registered.ply.
std::vector<NamedFile> ScanFitFiles(const ScanFit& fit, const std::vector<Eigen::Vector3d>& scan);

// What darboux_fit's --report shows.
Report MakeFitReport(const ScanFit& fit, const std::vector<Eigen::Vector3d>& scan);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_SCAN_FIT_H_
