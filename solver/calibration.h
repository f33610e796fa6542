#ifndef DARBOUX_SOLVER_CALIBRATION_H_
#define DARBOUX_SOLVER_CALIBRATION_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/rigid_pose.h"
#include "solver/registration.h"
#include "solver/scene.h"
#include "solver/shell_solver.h"
#include "solver/state_model.h"

namespace darboux {

// Material parameters of a shell from measured states of it: scans of grasps, readings of the
// fingers' forces, fields of displacements. Any consistent unit system, the same in all of it.
//
// The parameters theta = (ln E, ln h, nu, p) that are asked for, and what else is not known,
// minimise
//
//   1/2 sum over scans, points i      rho(((d_i(theta, t_g, pose_s) - r) / s_s)^2)
// + 1/2 sum over fields, points i     rho(|motion_f(X + u(theta, t_g)) - X - measured_i|^2 / s_f^2)
// + 1/2 sum over force readings k     ((F_k(theta, t_g) (1 + m) + c tau_g - reading_k) / error_k)^2
// + 1/2 [ (t_g / travel error)^2 + (m / model error)^2 + (c / drift)^2 + (r / rest error)^2
//         + priors of theta ]
//
// d: signed distance of a scan point to the face that the computed state has, after a rigid motion
// `pose` of the scan; rho: Cauchy's loss, so that outliers count little; t_g: what the travel of
// the fingers of grasp g is more than the scene says; m: relative error of the theory's forces that
// all of them share, and as much again in each of them by itself, which is part of error_k; r: how
// far the rest surface lies outside of what the scene says; c: drift of the force sensor, tau_g
// from 0 to 1 in the course of the session. Errors are standard deviations.
//
// States are functions of theta and t_g that StateModel solves and differentiates; Ceres' trust
// region sees theta, t, m, c and the poses alone, and asks for states by an evaluation callback.
//
// Neighbouring points of a scan share the errors of the model, so that a million of them do not
// know more than a few regions of the surface. With the noise sigma and a shape error e (of the
// largest displacement of the state, without rigid motion: Deformation in registration.h) a point
// has the standard deviation s^2 = sigma^2 + e^2, which tells outliers; each of n points counts
// s^2 / (sigma^2 + e^2 max(1, n / kRegions)) times, so that all of them know what kRegions
// independent ones do.
//
// Where neighbouring points of a scan lie together inside of a closed shell's fitted state, or deep
// in a finger of it, by more than 3 s each and as more than 1/200 of the points, the scan is of
// another state or object: there is no match and no estimate. Robust losses would pass over them.
//
// Points of a field do likewise, with e of the largest displacement that is not a rigid motion and
// zero unless the field says otherwise, because what neighbours share can be seen there: the means
// m_r of what is left in each of kRegions parts (or pairs of them) of n_r points would have the
// variance s^2 / n_r if errors were independent. Where they have D times that, a point counts 1 / D
// times. A field's deviation is the standard deviation of one component of one point.
//
// A point of a field within half the thickness h (and a little) of the middle surface, at the
// height z above it, moves by u + z (n' - n), n the normal at rest and n' that of the state; others
// are left out.
struct CalibrationSpec {
  // What is asked and known of one parameter of the shell.
  struct Parameter {
    bool asked = false;
    std::optional<double> start;
    std::optional<double> prior, prior_error;  // both or none
    SceneLocation location;
  };
  // A measured force of a finger, along its direction.
  struct ForceReading {
    int finger = 0;  // of the scene
    double value = 0.0;
    double error = 0.0;  // > 0
    SceneLocation location;
  };
  // A scan of the outer face.
  struct Scan {
    std::string file;
    PointCloud cloud;
    std::optional<RigidPose> pose;  // known and exact; else unknown
    SceneLocation location;
  };
  // Measured displacements of many points.
  struct Field {
    std::string file;
    PointCloud cloud;                                  // with displacements
    std::array<bool, 3> components{true, true, true};  // z only where the cloud has it
    double noise = 0.0;                                // > 0; 0: estimated from what is left
    double shape_error = 0.0;  // of the theory, of the largest displacement without rigid motion
    bool free_motion = true;   // an unknown rigid motion is part of what was measured
    SceneLocation location;
  };
  // A measured state of the shell, with all that was measured of it.
  struct Grasp {
    std::string scene_file;
    Scene scene;
    std::vector<Scan> scans;
    std::vector<Field> fields;
    std::vector<ForceReading> forces;
    // Of the travel; 0: exact, infinity: not known at all.
    double travel_error = 0.0;
    double time = 0.0;
    SceneLocation location;
  };

  std::string name;
  std::array<Parameter, 4> parameters;  // by StateParameter, without travel
  Theory theory = Theory::kAuto;        // auto: each scene's own
  double noise = 0.0;                   // of scan points; 0: estimated
  double model_error = 0.03;            // of computed forces, relative
  double shape_error = 0.05;            // of computed shapes, of the largest displacement
  double rest_error = -1.0;             // of the rest surface along its normal; < 0: h / 10
  double force_drift = 0.0;
  int max_points = 4000;       // of each scan that are used, spread over it; 0: all
  int bootstrap = 0;           // resamples
  unsigned seed = 1;           // of these
  bool compare_linear = true;  // where the theory is nonlinear
  std::vector<Grasp> grasps;

  const Parameter& parameter(StateParameter p) const { return parameters[static_cast<int>(p)]; }
  Parameter& parameter(StateParameter p) { return parameters[static_cast<int>(p)]; }
  bool IsValid(std::string* error) const;
};

constexpr int kRegions = 16;
constexpr double kRestPart = 0.1;  // default of rest_error, in thicknesses

// An iteration of the estimation, and the state that it starts from.
struct CalibrationIteration {
  int iteration = 0;
  double cost = 0.0;  // half of the sum of squares, in standard deviations
  std::vector<std::pair<std::string, double>> parameters;  // those asked for, Young's modulus first
  double seconds = 0.0;                                    // since the calibration began
  // While costs fall: until their change is what ends the iteration, at the rate of the last two.
  std::optional<double> seconds_left;
  std::string text;  // all of it but the last, in a line
};

// How the parameters are searched for.
struct CalibrationOptions {
  SolverOptions solver;
  int max_iterations = 30;
  std::function<void(const std::string&)> on_progress;  // what begins now, one line each
  std::function<void(const CalibrationIteration&)> on_iteration;
};

// The answer: values, what is known of them, and how well the measurements agree.
struct CalibrationSummary {
  enum class Termination { kNotRun, kConverged, kNotConverged, kNoMatch, kStopped, kFailed };
  Termination termination = Termination::kNotRun;
  std::string message = "not run";

  // A parameter that was asked for.
  struct Estimate {
    StateParameter parameter = StateParameter::kYoungModulus;
    double value = 0.0;
    // Standard deviation; of the logarithm for Young's modulus and thickness. Infinity: none.
    double deviation = 0.0;
    std::array<double, 2> interval{};  // 95 %
    std::optional<std::array<double, 2>> bootstrap;
    bool identifiable = false;
    std::string verdict;
  };
  std::vector<Estimate> estimates;
  Eigen::MatrixXd correlation;  // of the estimates; empty where one is not identifiable

  // What the first estimate (Young's modulus) changes by, relative, per relative change of what was
  // taken as known.
  struct Sensitivity {
    std::string of, to;
    double value = 0.0;  // d ln(of) / d ln(to); of pressure and Poisson's ratio: see `relative`
    bool relative = true;
  };
  std::vector<Sensitivity> sensitivities;

  // A reading against the computed force.
  struct Force {
    std::string finger;
    double reading = 0.0, model = 0.0, error = 0.0;
  };
  // A scan against the computed face.
  struct Scan {
    std::string file;
    RigidPose pose;
    DistanceStatistics distances;  // of inliers
    double deviation = 0.0;        // that its points were given
    int points = 0;
    double inliers = 0.0;  // part of the points within three deviations
  };
  // A measured field against the computed displacements.
  struct Field {
    std::string file;
    double rms = 0.0;            // of a measured component, of inliers
    int points = 0, beside = 0;  // used; not on the surface
    double inliers = 0.0;        // part of the points within three deviations
    double deviation = 0.0;      // of a component
    double independent = 0.0;    // as many independent points know as much
    double deformation = 0.0;    // largest displacement without rigid motion
    double rotation = 0.0;       // of the rigid motion, rad
  };
  // A measured state against the computed one.
  struct Grasp {
    std::string scene;
    Theory theory = Theory::kAuto;
    double travel_change = 0.0, travel_deviation = 0.0, max_displacement = 0.0;
    std::vector<Force> forces;
    std::vector<Scan> scans;
    std::vector<Field> fields;
  };
  std::vector<Grasp> grasps;
  double model_bias = 0.0, drift = 0.0, rest_offset = 0.0;
  std::optional<double> linear_young_modulus;
  std::vector<std::string> notes;  // decisions and warnings
  int iterations = 0;
  StateModel::Work work;
  double cost = 0.0, seconds = 0.0;

  bool IsConverged() const { return termination == Termination::kConverged; }
  const Estimate* Find(StateParameter parameter) const;
  std::string FullReport() const;
};

// False and *error where the input cannot be posed; trouble on the way is in *summary. models: the
// final states, one per grasp, for whoever writes results; may be null.
bool Calibrate(const CalibrationSpec& spec,
               const CalibrationOptions& options,
               CalibrationSummary* summary,
               std::vector<std::unique_ptr<StateModel>>* models,
               std::string* error);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_H_
