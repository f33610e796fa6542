#ifndef DARBOUX_SOLVER_CALIBRATION_PROBLEM_H_
#define DARBOUX_SOLVER_CALIBRATION_PROBLEM_H_

#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>

#include <Eigen/Core>
#include <array>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "geometry/shell_face.h"
#include "solver/calibration.h"
#include "solver/posterior.h"
#include "solver/state_model.h"

namespace darboux {

// Nothing but loads moves the shell: displacements depend on loads / Young's modulus alone.
bool IsDrivenByLoads(const Scene& scene);

// The outer least-squares problem of Calibrate: its unknowns, their units, residuals and Jacobians.
// Inside of the solver.
//
// Unknowns are numbers near 1 in any system of units: ln(E/E_0), ln(h/h_0), nu, p / (E_0 h_0 / L),
// travel / (its error, or h_0), model bias, drift and rest offset / their deviations, rotation
// vectors and translations / L about the middle of the shell, added to the pose that registration
// has found.
class CalibrationProblem : public ceres::EvaluationCallback {
 public:
  static constexpr int kShell = 4;  // theta
  // Then travels, then poses and motions.
  static constexpr int kBias = 4, kDrift = 5, kRest = 6, kTravels = 7;
  static constexpr double kRobust = 2.5;  // of Cauchy's loss, in deviations

  // A scan's points in its own frame, with the pose that its unknown motion is added to.
  struct Scan {
    int grasp = 0;
    RigidPose pose;
    bool known_pose = false;
    double deviation = 1.0;  // of one point
    double share = 1.0;      // what a point counts, because it shares errors with its neighbours
    std::vector<Eigen::Vector3d> points;
    std::vector<ShellFace::Foot> feet;
    std::array<double, 6> motion{};
    int column = 0;  // of the motion
    // Per point, after a call with derivatives: minus the normal motion of the face.
    Eigen::Matrix<double, 5, Eigen::Dynamic> rates;
    std::vector<Eigen::Vector3d> moved;  // points on the shell's side
  };
  // A measured field, with where its points are on the shell.
  struct Field {
    int grasp = 0;
    std::array<bool, 3> components{};
    bool free_motion = true;
    double deviation = 1.0, share = 1.0;  // as those of a scan
    std::vector<Eigen::Vector3d> points, measured;
    std::vector<ElementPoint> feet;
    // Of the points at rest above the middle surface, along its normal n: points of a face move by
    // u + height (n' - n). Empty: all 0.
    Eigen::RowVectorXd heights;
    std::vector<Eigen::VectorXd> weights;
    std::array<double, 6> motion{};
    int column = 0;
    Eigen::Matrix3Xd model;                 // displacement of the state
    std::array<Eigen::Matrix3Xd, 5> rates;  // by theta and travel
  };
  // A force reading.
  struct Force {
    int grasp = 0, finger = 0;
    double reading = 0.0, error = 0.0, time = 0.0;
  };

  // Everything must outlive this; states are those of `models`, one per grasp.
  CalibrationProblem(const CalibrationSpec& spec,
                     int num_threads,
                     std::vector<std::unique_ptr<StateModel>>* models);

  int AddScan(Scan scan);
  int AddField(Field field);
  // The rigid motion of the field that leaves least of it where the model's displacements are
  // `scale` times what they are (Kabsch), in the components that are measured; sets its unknowns.
  // *left: what is left per point, *turned: the model's displacements, turned. After
  // PrepareForEvaluation.
  void FitMotion(double scale,
                 Field* field,
                 Eigen::Matrix3Xd* left,
                 Eigen::Matrix3Xd* turned) const;
  // The largest displacement of the model at the field's points that is not a rigid motion, in the
  // components that are measured; where no rigid motion is free, the largest displacement.
  double Deformation(const Field& field) const;
  // After all scans and fields.
  void Finish();

  // Blocks for Ceres, which owns them.
  void Build(ceres::Problem* problem);

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  // In units: of the present unknowns.
  ShellParameters Parameters() const;
  void SetParameters(const ShellParameters& parameters);
  double TravelChange(int grasp) const;
  RigidPose PoseOf(int scan) const;

  // Of the present unknowns, with everything that is not asked for as a column as well: interest is
  // what is asked for. `rows`: of scan points, for a bootstrap; may be null.
  struct Row {
    std::vector<int> columns;
    Eigen::VectorXd coefficients;
    double residual = 0.0, weight = 1.0;
    int scan = -1;  // -1: a reading or a prior
  };
  bool Linearise(Posterior* posterior, std::vector<Row>* rows);
  std::vector<int> Interest() const;
  std::vector<int> Nuisances() const;
  int num_unknowns() const { return num_unknowns_; }
  int TravelColumn(int grasp) const { return kTravels + grasp; }
  // What a change of an unknown is in the scene's units: of theta 1, 1, 1 and the unit of pressure.
  double unit(int column) const { return units_[column]; }

  std::vector<Scan>& scans() { return scans_; }
  std::vector<Field>& fields() { return fields_; }
  const std::vector<Scan>& scans() const { return scans_; }
  const std::vector<Field>& fields() const { return fields_; }
  const std::vector<Force>& forces() const { return forces_; }
  double ForceOf(const Force& force) const;      // that the model has, with bias and drift
  double BareForceOf(const Force& force) const;  // without
  const std::string& error() const { return error_; }
  bool failed() const { return failed_; }
  double bias() const { return unknowns_[kBias] * units_[kBias]; }
  double drift() const { return unknowns_[kDrift] * units_[kDrift]; }
  double rest_offset() const { return unknowns_[kRest] * units_[kRest]; }
  double size() const { return size_; }

  // Residuals and derivatives of single measurements, for the blocks.
  bool ScanResidual(const Scan& scan, int point, double* residual, double* by_motion) const;
  void FieldResidual(const Field& field, int point, double* residuals, double* by_motion) const;
  // Of the displacement of a point by theta or travel, turned as the whole field is.
  Eigen::Vector3d FieldRate(const Field& field, int point, int k) const;
  void ForceResidual(const Force& force, double* residual, double** jacobians) const;

 private:
  bool Update(bool derivatives);
  Eigen::Matrix3Xd Turns(const Field& field, const Eigen::Matrix3Xd& displacements) const;
  Eigen::Matrix3Xd TurnRates(const Field& field,
                             const Eigen::Matrix3Xd& displacements,
                             const Eigen::Matrix3Xd& direction) const;
  std::vector<StateParameter> Wanted(bool all) const;

  const CalibrationSpec& spec_;
  const int num_threads_;
  std::vector<std::unique_ptr<StateModel>>& models_;
  std::vector<std::unique_ptr<ShellFace>> faces_;  // per grasp
  ShellParameters start_;
  double size_ = 1.0;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  std::vector<Scan> scans_;
  std::vector<Field> fields_;
  std::vector<Force> forces_;
  std::deque<double> unknowns_;  // theta, bias, drift, rest offset, travels
  std::vector<double> units_;
  int num_unknowns_ = 0;
  bool all_derivatives_ = false;  // also of what is not asked for
  bool failed_ = false;
  std::string error_;
  // Per force: by theta and travel.
  std::vector<std::array<double, 5>> force_rates_;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_CALIBRATION_PROBLEM_H_
