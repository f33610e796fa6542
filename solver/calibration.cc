#include "solver/calibration.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <sstream>
#include <utility>

#include "geometry/point_tree.h"
#include "solver/calibration_estimates.h"
#include "solver/calibration_problem.h"
#include "solver/format.h"
#include "solver/grasp.h"
#include "solver/minimisation.h"

namespace darboux {
namespace {

using Estimate = CalibrationSummary::Estimate;

constexpr char kStopped[] = "stopped before there was a result: interrupted, or out of time";
// Robust distances of a scan to the state of its scene, in sizes of the shell, before anything is
// fitted.
constexpr double kFarthest = 0.04;

double Length(const std::array<double, 3>& vector) {
  return std::hypot(vector[0], vector[1], vector[2]);
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + middle, values.end());
  return values[middle];
}

// Every k-th point, so that at most `most` are left; files are in the order that a scanner sweeps.
std::vector<size_t> Spread(size_t count, int most) {
  std::vector<size_t> chosen;
  if (most <= 0 || count <= static_cast<size_t>(most)) {
    for (size_t i = 0; i < count; ++i) chosen.push_back(i);
    return chosen;
  }
  for (int k = 0; k < most; ++k) chosen.push_back(count * k / most);
  return chosen;
}

// Parts of about as many points each, at most kRegions, by halving along the longest side, so that
// 2 k and 2 k + 1 are halves of one; 0 and no parts where there are too few points.
int Divide(const std::vector<Eigen::Vector3d>& points, std::vector<int>* parts) {
  constexpr size_t kLeast = 8;  // points of a part
  int halvings = 0;
  while ((1 << halvings) < kRegions && points.size() >> (halvings + 1) >= kLeast) ++halvings;
  parts->clear();
  if ((1 << halvings) < kRegions / 2) return 0;
  std::vector<std::vector<size_t>> groups(1);
  for (size_t i = 0; i < points.size(); ++i) groups[0].push_back(i);
  for (int k = 0; k < halvings; ++k) {
    std::vector<std::vector<size_t>> halves;
    for (std::vector<size_t>& group : groups) {
      Eigen::AlignedBox3d box;
      for (const size_t i : group) box.extend(points[i]);
      int axis = 0;
      box.sizes().maxCoeff(&axis);
      const auto middle = group.begin() + group.size() / 2;
      std::nth_element(group.begin(), middle, group.end(), [&](size_t a, size_t b) {
        return std::make_pair(points[a][axis], a) < std::make_pair(points[b][axis], b);
      });
      halves.emplace_back(group.begin(), middle);
      halves.emplace_back(middle, group.end());
    }
    groups = std::move(halves);
  }
  parts->resize(points.size());
  for (size_t g = 0; g < groups.size(); ++g) {
    for (const size_t i : groups[g]) (*parts)[i] = static_cast<int>(g);
  }
  return static_cast<int>(groups.size());
}

// Numbers of points off by more than `least` and less than `most`, together with most of their
// neighbours, on the same side. Outliers so near to a surface have points of it beside them.
std::vector<size_t> BeyondTogether(const std::vector<Eigen::Vector3d>& points,
                                   const std::vector<ShellFace::Foot>& feet,
                                   double least,
                                   double most) {
  constexpr int kNeighbours = 9;  // itself is one
  PointTree tree;
  tree.Build(points);
  std::vector<size_t> together;
  for (size_t i = 0; i < points.size(); ++i) {
    const double distance = feet[i].distance;
    if (!(std::abs(distance) > least && std::abs(distance) < most)) continue;
    const PointTree::Neighbours near = tree.Nearest(points[i], kNeighbours);
    int same = 0;
    for (int k = 0; k < near.count; ++k) {
      const double other = feet[near.index[k]].distance;
      same +=
          std::abs(other) > least && std::abs(other) < most && (other > 0.0) == (distance > 0.0);
    }
    if (2 * same > near.count) together.push_back(i);
  }
  return together;
}

class Calibration {
 public:
  Calibration(const CalibrationSpec& spec,
              const CalibrationOptions& options,
              CalibrationSummary* summary)
      : spec_(spec), options_(options), summary_(*summary), start_(Clock::now()) {}

  void IgnoreContradictions() { contradictions_end_ = false; }
  bool Run(std::vector<std::unique_ptr<StateModel>>* models, std::string* error);

 private:
  using Termination = CalibrationSummary::Termination;

  void Progress(const std::string& line) const {
    if (options_.on_progress) options_.on_progress(line);
  }
  bool End(Termination termination, const std::string& message) {
    summary_.termination = termination;
    summary_.message = message;
    return true;
  }
  bool EndWithoutState() {
    return IsStopped() ? End(Termination::kStopped, kStopped)
                       : End(Termination::kFailed, problem_->error());
  }
  bool IsStopped() const {
    const SolverOptions& solver = options_.solver;
    return (solver.time_limit_s > 0.0 && Since(start_) > solver.time_limit_s) ||
           (solver.stop != nullptr && solver.stop->load());
  }
  Scene SceneOf(const CalibrationSpec::Grasp& grasp) const;
  bool AddScans(std::string* error);
  bool AddFields(std::string* error);
  bool SetDeviations();
  bool SetFieldDeviations();
  double RegionVariance(const CalibrationProblem::Field& field,
                        const std::vector<std::array<double, 3>>& left) const;
  void AlignFields();
  void ScaleModulus();
  bool Minimise(std::string* message);
  void CheckRegions(int number, const CalibrationSummary::Scan& report);
  void Report();

  const CalibrationSpec& spec_;
  const CalibrationOptions& options_;
  CalibrationSummary& summary_;
  const Clock::time_point start_;
  std::vector<std::unique_ptr<StateModel>>* models_ = nullptr;
  std::unique_ptr<CalibrationProblem> problem_;
  bool contradictions_end_ = true;
  std::string contradiction_;        // of a scan to its state; empty: none
  std::vector<bool> estimate_scan_;  // deviations
  struct FieldPlan {
    const CalibrationSpec::Field* spec = nullptr;
    std::vector<int> regions;  // of each point; empty: too few points to tell
    int num_regions = 0, beside = 0;
    double deformation = 0.0;
  };
  std::vector<FieldPlan> fields_;  // of the problem's
  bool started_ = false;           // something has been minimised
};

Scene Calibration::SceneOf(const CalibrationSpec::Grasp& grasp) const {
  Scene scene = grasp.scene;
  if (spec_.theory != Theory::kAuto) scene.model.theory = spec_.theory;
  scene.probes.clear();
  scene.expect.clear();
  const auto set = [&](StateParameter which, double* value) {
    const CalibrationSpec::Parameter& p = spec_.parameter(which);
    if (p.start) *value = *p.start;
  };
  set(StateParameter::kYoungModulus, &scene.shell.young_modulus);
  set(StateParameter::kThickness, &scene.shell.thickness);
  set(StateParameter::kPoissonRatio, &scene.shell.poisson_ratio);
  for (LoadSpec& load : scene.loads) {
    if (load.kind == LoadSpec::Kind::kGas) {
      set(StateParameter::kGasPressure, &load.gauge_pressure);
    }
  }
  return scene;
}

// Where the scans lie against the states that the scenes have as they are.
bool Calibration::AddScans(std::string* error) {
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const StateModel& model = *(*models_)[g];
    const ShellSurface& surface = model.problem().surface();
    ShellFace face(surface, 0.5 * model.parameters().thickness);
    if (!spec_.grasps[g].scans.empty()) face.SetDisplacements(model.displacements());
    for (const CalibrationSpec::Scan& scan : spec_.grasps[g].scans) {
      CalibrationProblem::Scan added;
      added.grasp = static_cast<int>(g);
      added.known_pose = scan.pose.has_value();
      for (const size_t i : Spread(scan.cloud.points.size(), spec_.max_points)) {
        added.points.push_back(scan.cloud.points[i]);
      }
      added.deviation = spec_.noise > 0.0 ? spec_.noise : 1e-3 * surface.size();
      estimate_scan_.push_back(!(spec_.noise > 0.0));
      if (scan.pose) {
        added.pose = *scan.pose;
      } else {
        if (IsStopped()) return End(Termination::kStopped, kStopped);
        Progress("registering " + scan.file);
        RegistrationOptions options;
        options.noise = spec_.noise;
        options.num_threads = options_.solver.num_threads;
        options.max_points = spec_.max_points;
        // The state that it is held against has yet to be fitted.
        options.max_relative_sigma = 0.5 * kFarthest;
        if (model.by_force() || spec_.grasps[g].travel_error > 0.0) {
          options.max_relative_sigma = kFarthest;
        }
        RegistrationSummary registration;
        std::string trouble;
        if (!Register(face, scan.cloud.points, options, &registration, &trouble)) {
          *error = scan.location.file + ":" + std::to_string(scan.location.line) + ": " +
                   scan.location.key + ": " + scan.file + ": " + trouble;
          return false;
        }
        if (!registration.matched) {
          return End(
              Termination::kNoMatch,
              scan.file + " against " + spec_.grasps[g].scene_file + ": " + registration.verdict);
        }
        added.pose = registration.pose;
      }
      problem_->AddScan(std::move(added));
    }
  }
  return true;
}

bool Calibration::AddFields(std::string* error) {
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const ShellSurface& surface = (*models_)[g]->problem().surface();
    ShellFace middle(surface, 0.0);
    middle.SetDisplacements(Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices));
    for (const CalibrationSpec::Field& field : spec_.grasps[g].fields) {
      CalibrationProblem::Field added;
      added.grasp = static_cast<int>(g);
      added.components = field.components;
      added.components[2] = field.components[2] && field.cloud.has_uz;
      added.free_motion = field.free_motion;
      // What lies beside the sheet by more than this part of its size is no point of it; through
      // its thickness, a tenth more than to its faces is.
      const double beside = 1e-3 * surface.size();
      const double above = 0.55 * (*models_)[g]->parameters().thickness + beside;
      const bool in_space = added.components[0] && added.components[1] && added.components[2];
      std::vector<double> heights;
      FieldPlan plan;
      plan.spec = &field;
      for (const size_t i : Spread(field.cloud.points.size(), spec_.max_points)) {
        const Eigen::Vector3d& x = field.cloud.points[i];
        const ShellFace::Foot foot = middle.Closest(x);
        Eigen::Vector3d left = x - foot.position;
        double height = 0.0;
        if (in_space) {
          height = left.dot(foot.normal);
          left -= height * foot.normal;
        }
        for (int c = 0; c < 3; ++c) {
          if (!added.components[c]) {
            left[c] = 0.0;  // A plane field need not say where its plane is.
          }
        }
        if (left.norm() > beside || std::abs(height) > above) {
          ++plan.beside;
          continue;
        }
        added.points.push_back(x);
        added.measured.push_back(field.cloud.displacements[i]);
        added.feet.push_back(foot.at);
        heights.push_back(height);
      }
      // Rounding of points that are meant to be on the middle surface is no height.
      constexpr double kNothing = 1e-9;
      if (std::any_of(heights.begin(), heights.end(), [&](double height) {
            return std::abs(height) > kNothing * surface.size();
          })) {
        added.heights = Eigen::Map<const Eigen::RowVectorXd>(heights.data(), heights.size());
      }
      if (added.points.size() < 10) {
        *error = field.location.file + ":" + std::to_string(field.location.line) + ": " +
                 field.location.key + ": found " + std::to_string(added.points.size()) + " of " +
                 std::to_string(field.cloud.points.size()) +
                 " points on the surface of the scene; allowed at least 10 (a field is in the "
                 "scene's coordinates and unit of length)";
        return false;
      }
      plan.num_regions = Divide(added.points, &plan.regions);
      fields_.push_back(std::move(plan));
      problem_->AddField(std::move(added));
    }
  }
  return true;
}

// Standard deviations of the points: what is known of the noise, or what is left now; and the
// model's own errors, which neighbours share. Whether one has changed by more than 2 %.
bool Calibration::SetDeviations() {
  constexpr double kNormal = 1.4826;  // standard deviation / median of absolute values
  constexpr double kChange = 0.02;
  bool changed = false;
  const auto set =
      [&](bool estimated, double noise, double left, int grasp, size_t count, auto* points) {
        const StateModel& state = *(*models_)[grasp];
        const double model =
            spec_.shape_error *
            Deformation(state.problem().surface(), state.displacements()).largest();
        // Exact data of our own model have no noise; rounding is the least.
        const double least = 1e-9 * problem_->size();
        // What is left has the model's errors in it.
        const double now = estimated ? std::max(left, least) : std::hypot(noise, model);
        const double random = estimated ? now : noise;
        const double shared =
            model * std::sqrt(std::max(1.0, static_cast<double>(count) / kRegions));
        const double share = now * now / (random * random + shared * shared);
        if (std::abs(now - points->deviation) > kChange * points->deviation ||
            std::abs(share - points->share) > kChange * points->share) {
          changed = true;
        }
        points->deviation = now;
        points->share = share;
      };
  size_t s = 0;
  for (auto& scan : problem_->scans()) {
    std::vector<double> distances;
    for (const ShellFace::Foot& foot : scan.feet) distances.push_back(std::abs(foot.distance));
    set(estimate_scan_[s],
        spec_.noise,
        kNormal * Median(distances),
        scan.grasp,
        scan.points.size(),
        &scan);
    ++s;
  }
  return SetFieldDeviations() || changed;
}

// What the means of regions and of pairs of them vary by, the more of both, as a multiple of what
// they would if errors were independent and had the field's deviation.
double Calibration::RegionVariance(const CalibrationProblem::Field& field,
                                   const std::vector<std::array<double, 3>>& left) const {
  const FieldPlan& plan = fields_[&field - problem_->fields().data()];
  if (plan.num_regions == 0) return 1.0;
  const int components = field.components[0] + field.components[1] + field.components[2];
  std::vector<std::array<double, 3>> sums(plan.num_regions, {0.0, 0.0, 0.0});
  std::vector<double> counts(plan.num_regions, 0.0);
  // Outliers are not what regions share.
  const double most = CalibrationProblem::kRobust * field.deviation;
  for (size_t i = 0; i < left.size(); ++i) {
    const double factor = std::min(1.0, most / std::max(Length(left[i]), 1e-3 * most));
    counts[plan.regions[i]] += 1.0;
    for (int c = 0; c < 3; ++c) sums[plan.regions[i]][c] += factor * left[i][c];
  }
  // Each unknown that was fitted has taken one degree of freedom.
  const double fitted =
      static_cast<double>(problem_->Interest().size()) + (!field.free_motion ? 0.0
                                                          : components == 3  ? 6.0
                                                          : components == 2  ? 3.0
                                                                             : 1.0);
  // Errors that are smooth over more than one region show in pairs of them.
  double largest = 0.0;
  for (int parts = plan.num_regions; parts >= plan.num_regions / 2; parts /= 2) {
    double sum = 0.0;
    for (int r = 0; r < parts; ++r) {
      for (int c = 0; c < 3; ++c) sum += sums[r][c] * sums[r][c] / counts[r];
    }
    const double freedom = std::max(1.0, components * parts - fitted);
    largest = std::max(largest, sum / (field.deviation * field.deviation * freedom));
    for (int r = 0; r < parts / 2; ++r) {
      counts[r] = counts[2 * r] + counts[2 * r + 1];
      for (int c = 0; c < 3; ++c) sums[r][c] = sums[2 * r][c] + sums[2 * r + 1][c];
    }
  }
  return largest;
}

bool Calibration::SetFieldDeviations() {
  // Median length of a vector of so many components of unit deviation: lengths do not depend on how
  // the strip was turned in front of the camera.
  constexpr double kMedianLength[] = {1.0, 0.67449, 1.17741, 1.53817};
  constexpr double kChange = 0.02;
  bool changed = false;
  for (size_t f = 0; f < fields_.size(); ++f) {
    CalibrationProblem::Field& field = problem_->fields()[f];
    FieldPlan& plan = fields_[f];
    plan.deformation = problem_->Deformation(field);
    std::vector<std::array<double, 3>> left(field.points.size());
    std::vector<double> lengths;
    const double before = field.deviation, share_before = field.share;
    for (size_t i = 0; i < field.points.size(); ++i) {
      problem_->FieldResidual(field, static_cast<int>(i), left[i].data(), nullptr);
      for (double& component : left[i]) component *= before;
      lengths.push_back(Length(left[i]));
    }
    const double error = plan.spec->shape_error * plan.deformation;
    // Exact data of our own model have no noise; rounding is the least.
    const int components = field.components[0] + field.components[1] + field.components[2];
    const double spread =
        std::max(Median(lengths) / kMedianLength[components], 1e-9 * problem_->size());
    const double known = std::hypot(plan.spec->noise, error);
    const bool estimated = !(plan.spec->noise > 0.0);
    // Far from the minimum what is left is more than noise, and a robust loss of the noise alone
    // would take all points for outliers.
    field.deviation = estimated  ? std::max(spread, error)
                      : started_ ? known
                                 : std::max(known, spread);
    field.share = 1.0;
    if (started_) {
      const double count = static_cast<double>(field.points.size());
      const double variance = field.deviation * field.deviation;
      const double random = estimated ? variance : plan.spec->noise * plan.spec->noise;
      const double shared = error * error * std::max(1.0, count / kRegions);
      field.share = std::min(
          {1.0, 1.0 / std::max(1.0, RegionVariance(field, left)), variance / (random + shared)});
    }
    changed = changed || std::abs(field.deviation - before) > kChange * before ||
              std::abs(field.share - share_before) > kChange * share_before;
  }
  return changed;
}

// Where a rigid motion is free, starts with that which fits best; and with the modulus that does,
// where displacements are inversely proportional to it.
void Calibration::AlignFields() {
  if (fields_.empty()) return;
  bool scales = spec_.parameter(StateParameter::kYoungModulus).asked && problem_->forces().empty();
  for (const auto& model : *models_) {
    scales =
        scales && model->summary().theory == Theory::kLinear && IsDrivenByLoads(model->scene());
  }
  double scale = 1.0;
  constexpr int kTurns = 20;
  for (int turn = 0; turn < (scales ? kTurns : 1); ++turn) {
    double upper = 0.0, lower = 0.0;
    for (CalibrationProblem::Field& field : problem_->fields()) {
      Eigen::Matrix3Xd left, turned;
      problem_->FitMotion(scale, &field, &left, &turned);
      if (field.free_motion) turned.colwise() -= turned.rowwise().mean().eval();
      upper -= left.cwiseProduct(turned).sum();
      lower += turned.squaredNorm();
    }
    if (!scales || !(lower > 0.0)) break;
    scale += upper / lower;
  }
  constexpr double kMost = 1e6;
  if (!scales || !(scale > 1.0 / kMost && scale < kMost)) return;
  ShellParameters parameters = problem_->Parameters();
  parameters.young_modulus /= scale;
  problem_->SetParameters(parameters);
  for (CalibrationProblem::Field& field : problem_->fields()) {
    Eigen::Matrix3Xd left, turned;
    problem_->FitMotion(scale, &field, &left, &turned);
  }
}

// Forces are nearly proportional to Young's modulus: Newton's first step in its logarithm would
// overshoot by orders of magnitude from a bad start.
void Calibration::ScaleModulus() {
  if (!spec_.parameter(StateParameter::kYoungModulus).asked) return;
  double readings = 0.0, models = 0.0;
  for (const CalibrationProblem::Force& force : problem_->forces()) {
    if (FindGas((*models_)[force.grasp]->scene()) != nullptr) return;
    readings += force.reading;
    models += problem_->BareForceOf(force);
  }
  if (!(readings > 0.0) || !(models > 0.0)) return;
  ShellParameters parameters = problem_->Parameters();
  parameters.young_modulus *= readings / models;
  problem_->SetParameters(parameters);
}

bool Calibration::Minimise(std::string* message) {
  // Costs are squares of standard deviations: a change less than kNothing is nothing, in exact data
  // too; and one less than kEnough of the cost.
  constexpr double kNothing = 1e-10, kEnough = 1e-5;
  class Stop : public ceres::IterationCallback {
   public:
    Stop(const Calibration* owner, int* iterations) : owner_(*owner), iterations_(iterations) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
      const ShellParameters now = owner_.problem_->Parameters();
      std::ostringstream line;
      line.precision(6);
      line << "iteration " << *iterations_ << "  cost " << step.cost << "  E " << now.young_modulus;
      CalibrationIteration report;
      report.iteration = *iterations_;
      report.cost = step.cost;
      report.parameters.emplace_back(ToString(StateParameter::kYoungModulus), now.young_modulus);
      for (int k = 1; k < 4; ++k) {
        const StateParameter p = static_cast<StateParameter>(k);
        if (!owner_.spec_.parameter(p).asked) continue;
        const double value = k == 1 ? now.thickness : k == 2 ? now.poisson_ratio : now.gas_pressure;
        line << "  " << ToString(p) << " " << value;
        report.parameters.emplace_back(ToString(p), value);
      }
      report.seconds = Since(owner_.start_);
      line << "  " << Format("%.2f s", report.seconds);
      report.text = line.str();
      if (step.iteration > 0 && step.step_is_successful) {
        const double end = kNothing + kEnough * step.cost;
        const double rate = step.cost_change / change_;  // of the changes, per iteration
        if (change_ > 0.0 && step.cost_change > end && rate < 1.0) {
          const double left = std::ceil(std::log(end / step.cost_change) / std::log(rate));
          report.seconds_left = left * (report.seconds - begun_) / step.iteration;
        }
        change_ = step.cost_change;
      } else if (step.iteration == 0) {
        begun_ = report.seconds;
      }
      if (owner_.options_.on_iteration) owner_.options_.on_iteration(report);
      ++*iterations_;
      if (step.iteration > 0 && step.step_is_successful &&
          step.cost_change <= kNothing + kEnough * step.cost) {
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      }
      // Poses that scans hardly determine creep. Half squares of standard deviations that change
      // by so little, time after time, change no estimate.
      constexpr double kCreep = 1e-3;
      constexpr int kCreeping = 5;
      const double creep = kCreep * std::min(1.0, step.cost);
      if (step.step_is_successful) creeping_ = step.cost_change <= creep ? creeping_ + 1 : 0;
      if (creeping_ >= kCreeping) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      return owner_.IsStopped() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
    }

   private:
    const Calibration& owner_;
    int* iterations_;
    double change_ = 0.0, begun_ = 0.0;
    int creeping_ = 0;  // steps
  };
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = problem_.get();
  ceres::Problem problem(problem_options);
  problem_->Build(&problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = options_.max_iterations;
  options.function_tolerance = 0.0;  // Stop decides.
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 0.0;
  options.update_state_every_iteration = true;
  options.logging_type = ceres::SILENT;
  Stop stop(this, &summary_.iterations);
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary result;
  ceres::Solve(options, &problem, &result);
  summary_.cost = result.final_cost;
  // States, feet and distances belong to the last point that Ceres tried: to the one it chose now.
  problem_->PrepareForEvaluation(false, true);
  const bool converged = result.termination_type == ceres::CONVERGENCE ||
                         result.termination_type == ceres::USER_SUCCESS;
  // A state that was not found for lack of time ends Ceres in other ways.
  if (result.termination_type == ceres::USER_FAILURE ||
      (IsStopped() && (problem_->failed() || !converged))) {
    *message = kStopped;
    return false;
  }
  if (problem_->failed()) {
    *message = problem_->error();
    return false;
  }
  if (converged) return true;
  *message = result.message + (problem_->error().empty() ? "" : " (" + problem_->error() + ")");
  return false;
}

// Where the scan is of something else than the computed state. Points inside of a closed body, or
// where a finger is, cannot be in this state at all; others may be of what was scanned as well.
void Calibration::CheckRegions(int number, const CalibrationSummary::Scan& report) {
  constexpr double kRegion = 0.005;  // part of the points
  constexpr size_t kFewest = 5;
  const CalibrationProblem::Scan& scan = problem_->scans()[number];
  const StateModel& model = *(*models_)[scan.grasp];
  const double limit = 3.0 * scan.deviation;
  const size_t least = std::max(kFewest, static_cast<size_t>(kRegion * report.points));
  std::vector<double> inside, pierced, outside;
  // As far as states differ, or a match is found at all.
  const double farthest =
      std::max(2.0 * model.max_displacement(), kFarthest * model.problem().surface().size());
  for (const size_t i : BeyondTogether(scan.points, scan.feet, limit, farthest)) {
    const double distance = scan.feet[i].distance;
    if (distance < 0.0) {
      inside.push_back(-distance);
      continue;
    }
    double depth = 0.0;
    const Eigen::Vector3d x = report.pose * scan.points[i];
    for (size_t f = 0; f < model.scene().fingers.size(); ++f) {
      const FingerSpec& spec = model.scene().fingers[f];
      FingerPose pose;
      std::string ignored;
      if (spec.shape == FingerSpec::Shape::kPin) continue;
      const auto shape = MakeFinger(spec, &pose, &ignored);
      if (shape == nullptr) continue;
      const FingerReport& now = model.summary().steps.back().fingers[f];
      pose.position += (now.shift + now.travel) *
                       Eigen::Vector3d(spec.direction[0], spec.direction[1], spec.direction[2]);
      Distance to;
      pose.Evaluate(*shape, x, &to);
      depth = std::max(depth, -to.value);
    }
    (depth > limit ? pierced : outside).push_back(depth > limit ? depth : distance);
  }
  const auto words = [&](const std::vector<double>& which, const std::string& where) {
    return report.file + ": " + std::to_string(which.size()) + " of " +
           std::to_string(report.points) + " points lie together, " + Number(Median(which)) + " " +
           where;
  };
  const std::string reasons =
      ": the scan is of another state than its scene, with another travel of the fingers (a "
      "travel_error lets the scan tell it), or of another object";
  // What has a rim may be seen from behind.
  bool closed = true;
  for (int k = 0; k < 4 + model.problem().surface().num_loops(); ++k) {
    closed = closed && !model.problem().surface().HasSide(static_cast<Side>(k));
  }
  if (pierced.size() > least) {
    contradiction_ = words(pierced, "deep in a finger of the computed state") + reasons;
  } else if (inside.size() > least && closed) {
    contradiction_ = words(inside, "inside of the computed state") + reasons;
  } else if (inside.size() > least) {
    summary_.notes.push_back(words(inside, "behind the computed state; they hardly count"));
  }
  if (outside.size() > least && contradiction_.empty()) {
    summary_.notes.push_back(
        words(outside,
              "outside of the computed state: of another state, or of a finger or holder "
              "that was scanned as well; they hardly count"));
  }
}

void Calibration::Report() {
  summary_.grasps.clear();
  for (size_t g = 0; g < spec_.grasps.size(); ++g) {
    const StateModel& model = *(*models_)[g];
    CalibrationSummary::Grasp grasp;
    grasp.scene = spec_.grasps[g].scene_file;
    grasp.theory = model.summary().theory;
    grasp.travel_change = problem_->TravelChange(static_cast<int>(g));
    grasp.max_displacement = model.max_displacement();
    for (const CalibrationProblem::Force& force : problem_->forces()) {
      if (force.grasp != static_cast<int>(g)) continue;
      grasp.forces.push_back({model.scene().fingers[force.finger].name,
                              force.reading,
                              problem_->ForceOf(force),
                              force.error});
    }
    size_t used = 0;
    for (size_t s = 0; s < problem_->scans().size(); ++s) {
      const CalibrationProblem::Scan& scan = problem_->scans()[s];
      if (scan.grasp != static_cast<int>(g)) continue;
      CalibrationSummary::Scan report;
      report.file = spec_.grasps[g].scans[used++].file;
      report.pose = problem_->PoseOf(static_cast<int>(s));
      report.deviation = scan.deviation;
      report.points = static_cast<int>(scan.points.size());
      std::vector<double> inliers;
      for (const ShellFace::Foot& foot : scan.feet) {
        if (std::abs(foot.distance) <= 3.0 * scan.deviation) inliers.push_back(foot.distance);
      }
      report.distances = MakeDistanceStatistics(inliers);
      report.inliers = static_cast<double>(inliers.size()) / std::max(1, report.points);
      CheckRegions(static_cast<int>(s), report);
      grasp.scans.push_back(report);
    }
    for (size_t f = 0; f < fields_.size(); ++f) {
      const CalibrationProblem::Field& field = problem_->fields()[f];
      if (field.grasp != static_cast<int>(g)) continue;
      CalibrationSummary::Field report;
      report.file = fields_[f].spec->file;
      report.points = static_cast<int>(field.points.size());
      report.beside = fields_[f].beside;
      report.deviation = field.deviation;
      report.independent = field.share * report.points;
      report.deformation = fields_[f].deformation;
      report.rotation = Eigen::Vector3d(field.motion.data()).norm();
      const int components = field.components[0] + field.components[1] + field.components[2];
      double sum = 0.0;
      int inliers = 0;
      for (size_t i = 0; i < field.points.size(); ++i) {
        double residuals[3];  // zero where not measured
        problem_->FieldResidual(field, static_cast<int>(i), residuals, nullptr);
        const Eigen::Map<Eigen::Vector3d> left(residuals);
        if (left.norm() > 3.0) continue;
        sum += left.squaredNorm();
        ++inliers;
      }
      report.rms = field.deviation * std::sqrt(sum / std::max(1, components * inliers));
      report.inliers = static_cast<double>(inliers) / std::max(1, report.points);
      grasp.fields.push_back(report);
    }
    summary_.grasps.push_back(std::move(grasp));
  }
  summary_.model_bias = problem_->bias();
  summary_.drift = problem_->drift();
  summary_.rest_offset = problem_->rest_offset();
}

bool Calibration::Run(std::vector<std::unique_ptr<StateModel>>* models, std::string* error) {
  models_ = models;
  models->clear();
  for (const CalibrationSpec::Grasp& grasp : spec_.grasps) {
    Progress("solving " + grasp.scene_file);
    auto model = StateModel::Create(SceneOf(grasp), options_.solver, error);
    if (model == nullptr) {
      if (IsStopped()) return End(Termination::kStopped, kStopped);
      // A scene that cannot be posed is bad input; one without solution is trouble.
      return error->find("has no solution") != std::string::npos ? End(Termination::kFailed, *error)
                                                                 : false;
    }
    models->push_back(std::move(model));
  }
  problem_ = std::make_unique<CalibrationProblem>(spec_, options_.solver.num_threads, models);
  if (!AddScans(error) || !AddFields(error)) return false;
  if (summary_.termination != Termination::kNotRun) return true;  // Without match, or stopped.
  problem_->Finish();
  ScaleModulus();
  problem_->PrepareForEvaluation(false, true);
  if (problem_->failed()) return EndWithoutState();
  AlignFields();
  problem_->PrepareForEvaluation(false, true);
  if (problem_->failed()) return EndWithoutState();
  SetDeviations();
  std::string message;
  bool converged = false;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    converged = Minimise(&message);
    if (!converged) break;
    started_ = true;
    const bool estimated =
        std::find(estimate_scan_.begin(), estimate_scan_.end(), true) != estimate_scan_.end() ||
        !fields_.empty();
    if (!SetDeviations() || (!estimated && round > 0)) break;
  }
  Report();
  for (const auto& model : *models) {
    summary_.work.solutions += model->work().solutions;
    summary_.work.factorisations += model->work().factorisations;
    summary_.work.iterations += model->work().iterations;
    summary_.work.solve_s += model->work().solve_s;
    summary_.work.derivative_s += model->work().derivative_s;
  }
  summary_.seconds = Since(start_);
  if (!converged) {
    return End(message == kStopped ? Termination::kStopped : Termination::kNotConverged, message);
  }
  if (contradictions_end_ && !contradiction_.empty())
    return End(Termination::kNoMatch, "no match: " + contradiction_);
  CalibrationEstimates(spec_, problem_.get(), models_, &summary_).Report();
  summary_.seconds = Since(start_);
  return End(Termination::kConverged, "converged");
}

}  // namespace

bool CalibrationSpec::IsValid(std::string* error) const {
  const auto fail = [&](const std::string& what) {
    *error = what;
    return false;
  };
  bool asked = false, data = false;
  for (const Parameter& p : parameters) asked = asked || p.asked;
  if (!asked) return fail("no parameter is asked for");
  if (grasps.empty()) return fail("there are no grasps");
  for (const Grasp& grasp : grasps) {
    data = data || !grasp.scans.empty() || !grasp.fields.empty() || !grasp.forces.empty();
    for (const Field& field : grasp.fields) {
      if (!(field.noise >= 0.0) || !(field.shape_error >= 0.0)) {
        return fail("errors of a field must not be negative");
      }
      if (field.cloud.displacements.size() != field.cloud.points.size()) {
        return fail("a field has no displacements");
      }
      if (!field.components[0] && !field.components[1] &&
          !(field.components[2] && field.cloud.has_uz)) {
        return fail("a field has no component");
      }
    }
    for (const ForceReading& force : grasp.forces) {
      if (force.finger < 0 || force.finger >= static_cast<int>(grasp.scene.fingers.size())) {
        return fail("a force reading names no finger of its scene");
      }
      if (!(force.error > 0.0)) return fail("the error of a force reading must be positive");
    }
    if (!(grasp.travel_error >= 0.0)) return fail("travel_error must not be negative");
  }
  if (!data) return fail("there is nothing measured");
  if (!(noise >= 0.0)) return fail("noise must not be negative");
  if (!(model_error >= 0.0) || !(shape_error >= 0.0) || !(force_drift >= 0.0)) {
    return fail("errors must not be negative");
  }
  return true;
}

bool Calibrate(const CalibrationSpec& spec,
               const CalibrationOptions& options,
               CalibrationSummary* summary,
               std::vector<std::unique_ptr<StateModel>>* models,
               std::string* error) {
  *summary = CalibrationSummary();
  if (!spec.IsValid(error) || !options.solver.IsValid(error)) return false;
  std::vector<std::unique_ptr<StateModel>> own;
  Calibration calibration(spec, options, summary);
  if (!calibration.Run(models != nullptr ? models : &own, error)) return false;
  const auto& used = models != nullptr ? *models : own;
  const bool nonlinear =
      std::any_of(used.begin(), used.end(), [](const std::unique_ptr<StateModel>& model) {
        // Gas is for the nonlinear theory: what it does before fingers come is not small.
        return model->summary().theory == Theory::kNonlinear && FindGas(model->scene()) == nullptr;
      });
  if (spec.compare_linear && nonlinear && summary->IsConverged() &&
      summary->Find(StateParameter::kYoungModulus) != nullptr) {
    CalibrationSpec linear = spec;
    linear.theory = Theory::kLinear;
    linear.compare_linear = false;
    linear.bootstrap = 0;
    CalibrationSummary result;
    std::string trouble;
    if (options.on_progress) options.on_progress("the same in the linear theory");
    Calibration comparison(linear, options, &result);
    comparison.IgnoreContradictions();  // Its shapes are wrong, which is the point.
    std::vector<std::unique_ptr<StateModel>> linear_models;
    if (comparison.Run(&linear_models, &trouble) && result.IsConverged()) {
      summary->linear_young_modulus = result.Find(StateParameter::kYoungModulus)->value;
    } else {
      summary->notes.push_back("the linear theory has no answer: " +
                               (trouble.empty() ? result.message : trouble));
    }
  }
  return true;
}

}  // namespace darboux
