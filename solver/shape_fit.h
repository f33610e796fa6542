#ifndef DARBOUX_SOLVER_SHAPE_FIT_H_
#define DARBOUX_SOLVER_SHAPE_FIT_H_

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "solver/registration.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/sparse_cholesky.h"

namespace darboux {

// Fits the deformation of a shell to a scan of one of its faces:
//
//   min over u, M   1/2 sum_i w_i (d_i / sigma)^2 + weight R(u) / (k h^2),
//
// d_i the signed distance of scan point M y_i to the deformed face, M the pose of the scan, sigma
// its noise, h the thickness and k the shell's stiffness ShellProblem::force_unit(), so that the
// weight is a number without unit. The regulariser R is
//
//   without a reference: the strain energy, from rest; what the scan does not show takes the shape
//     of least energy;
//   with a reference u0, a computed equilibrium: the energy of strains that are added to it,
//     (u - u0)^T K (u - u0) / 2, K = sum B^T C B there. At a large weight the answer is the
//     computed shape, and holes in the scan and shadows of fingers are filled by it.
//
// The weight is chosen by the discrepancy principle: the largest at which the root mean square of
// the distances is the noise; a smaller one would fit noise, a larger one leaves signal. Points
// without neighbours on the same sheet are outliers, w_i = 0; a dent, which is far away but
// coherent, is not.
// Progress of a fit: an iteration at a weight, or its end.
struct ShapeFitIteration {
  int trial = 1;  // of weights, 1-based
  double weight = 0.0;
  int iteration = 0;     // at this weight
  bool is_end = false;   // of the trial: `iteration` is how many it took
  double misfit = 0.0;   // root mean square of the distances of points that count
  double seconds = 0.0;  // since the first weight
  // At the end of a trial, of all that may follow, by the mean of those that were.
  double seconds_left_at_most = 0.0;
};

// How a shape is fitted to a scan.
struct ShapeFitOptions {
  // Standard deviation of the scan along normals, in the unit of length; 0: estimated from
  // neighbouring points (EstimateNoise).
  double noise = 0.0;
  double weight = 0.0;      // 0: by the discrepancy principle
  int max_iterations = 15;  // Gauss-Newton steps at each weight
  int max_weights = 15;     // that are tried
  RegistrationOptions registration;
  SparseBackend backend = SparseBackend::kAuto;
  int num_threads = 1;
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const ShapeFitIteration&)> on_iteration;

  bool IsValid(std::string* error) const;
};

// The fitted shape, and how well it agrees with the scan.
struct ShapeFitSummary {
  // Registration belongs, the iteration settled, and the misfit came down to the noise.
  bool converged = false;
  std::string verdict = "not run";

  RegistrationSummary registration;  // to the reference or rest shape, before the fit
  double noise = 0.0;                // given or estimated: what the misfit is to be
  double weight = 0.0;
  double misfit = 0.0;  // root mean square of the distances of points that count
  double energy = 0.0;  // R at the end, in the scene's units
  int iterations = -1;
  // A weight of the energy that was tried.
  struct Trial {
    double weight = 0.0, misfit = 0.0;
    int iterations = 0;
  };
  std::vector<Trial> trials;  // weights in the order they were tried

  Eigen::Matrix3Xd displacements;  // control displacements
  double max_displacement = 0.0;   // of the deformation (registration.h)
  RigidPose pose;                  // scan -> shell
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
  std::vector<char> counts;                       // of each point whether w_i > 0
  int num_outliers = 0, num_beyond_boundary = 0;  // points that do not count
  DistanceStatistics all, inliers;

  std::string FullReport() const;
};

// What a fit needs of a scene: the shell and its supports, without loads and fingers, whose place
// the reference takes.
Scene WithoutLoads(const Scene& scene);

// shell: of the scene WithoutLoads, nonlinear. Its displacements are changed. reference: control
// displacements, or empty for none. face_offset: of the scanned face from the middle surface.
// False and *error: options or points that cannot be used.
bool FitShape(ShellProblem* shell,
              const Eigen::Matrix3Xd& reference,
              double face_offset,
              const std::vector<Eigen::Vector3d>& scan,
              const ShapeFitOptions& options,
              ShapeFitSummary* summary,
              std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_SHAPE_FIT_H_
