#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "solver/calibration_run.h"

// What is measured becomes part of the problem: scans, which are registered, and fields, aligned.

namespace darboux {
namespace {

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

}  // namespace

// Where the scans lie against the states that the scenes have as they are.
bool CalibrationRun::AddScans(std::string* error) {
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

bool CalibrationRun::AddFields(std::string* error) {
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

// Where a rigid motion is free, starts with that which fits best; and with the modulus that does,
// where displacements are inversely proportional to it.
void CalibrationRun::AlignFields() {
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

}  // namespace darboux
