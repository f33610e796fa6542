#include "solver/shape_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "costs/scan_distance.h"
#include "geometry/point_tree.h"
#include "geometry/shell_face.h"
#include "solver/format.h"
#include "solver/parallel_for.h"
#include "solver/robust_statistics.h"
#include "solver/tangent_stiffness.h"

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Motion = Eigen::Matrix<double, 6, 1>;

// A shape with a pose, and the scan's distances to it.
struct State {
  Matrix3Xd u;
  RigidPose pose;
  std::vector<ShellFace::Foot> feet;
  std::vector<double> distances;
};

class Fit {
 public:
  Fit(ShellProblem* shell,
      const Matrix3Xd& reference,
      const std::vector<Vector3d>& scan,
      const ShapeFitOptions& options,
      ShellFace* face,
      ShapeFitSummary* summary)
      : shell_(shell),
        reference_(reference),
        scan_(scan),
        options_(options),
        face_(face),
        summary_(summary),
        stiffness_(shell, options.backend, options.num_threads),
        cholesky_(SparseCholesky::Create(options.backend)) {
    cholesky_.Analyze(stiffness_.matrix());
    const double h = shell->material().thickness;
    energy_scale_ = h * h;
    PointTree tree;
    tree.Build(scan);
    neighbours_.resize(scan.size());
    std::vector<double> reach;
    for (size_t i = 0; i < scan.size(); ++i) {
      const PointTree::Neighbours near = tree.Nearest(scan[i], kNeighbours + 1);
      reach.push_back(std::sqrt(near.squared[near.count - 1]));
      for (int k = 0; k < near.count; ++k) {
        if (near.index[k] != static_cast<int>(i)) neighbours_[i].push_back(near.index[k]);
      }
    }
    spacing_ = Median(std::move(reach));
  }

  bool Run(State* state) {
    noise_ = summary_->noise;
    FindFeet(state);
    if (!reference_.cols()) {
      shell_->displacements().setZero();
    } else {
      shell_->displacements() = reference_;
    }
    TangentStiffness::Request request;
    request.matrix = true;
    if (!stiffness_.Evaluate(request)) {
      summary_->verdict = "the reference shape has no strains: it is folded";
      return false;
    }
    reference_matrix_ = stiffness_.matrix();
    update_vectors_ = stiffness_.update_vectors();
    update_weights_ = stiffness_.update_weights();
    return options_.weight > 0.0 ? AtWeight(options_.weight, true, state) : ChooseWeight(state);
  }

  double energy() const { return energy_ * shell_->force_unit(); }
  const std::vector<double>& weights() const { return weights_; }
  bool settled() const { return settled_; }
  bool reached() const { return reached_; }
  const std::string& note() const { return note_; }

 private:
  static constexpr int kNeighbours = 10;

  void FindFeet(State* state) const {
    face_->SetDisplacements(state->u);
    const bool has_hints = state->feet.size() == scan_.size();
    state->feet.resize(scan_.size());
    state->distances.resize(scan_.size());
    const int n = static_cast<int>(scan_.size());
    const auto work = [&](int, int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const ShellFace::Foot hint = state->feet[i];
        state->feet[i] = face_->Closest(state->pose * scan_[i], has_hints ? &hint : nullptr);
        state->distances[i] = state->feet[i].distance;
      }
    };
    ParallelFor(ThreadsFor(n, options_.num_threads), n, work);
  }

  // Points without support are outliers: fewer than half of the neighbours are as near as they are
  // on a surface and have distances that noise explains, or noise and a slope, which then shows in
  // the spread among the neighbours as well. What is left is weighted down where it is far beyond
  // the rest.
  void FindWeights(const State& state) {
    constexpr double kSlope = 0.5, kDeviations = 4.0, kFar = 4.685, kSpreads = 4.0;
    weights_.assign(scan_.size(), 0.0);
    double squares = 0.0;
    int count = 0;
    std::vector<double> near;
    for (size_t i = 0; i < scan_.size(); ++i) {
      if (state.feet[i].on_boundary) continue;
      near.clear();
      for (const int k : neighbours_[i]) near.push_back(state.distances[k]);
      const double middle = Median(near);
      for (double& d : near) d = std::abs(d - middle);
      const double spread = kSpreads * Median(near);
      int support = 0;
      for (const int k : neighbours_[i]) {
        const double apart = (scan_[i] - scan_[k]).norm();
        const double allowed =
            std::min(kSlope * apart, spread) + kDeviations * std::sqrt(2.0) * noise_;
        support +=
            apart <= 2.0 * spacing_ && std::abs(state.distances[i] - state.distances[k]) <= allowed
                ? 1
                : 0;
      }
      if (2 * support < static_cast<int>(neighbours_[i].size())) continue;
      weights_[i] = 1.0;
      squares += state.distances[i] * state.distances[i];
      ++count;
    }
    const double rms = std::sqrt(squares / std::max(count, 1));
    const double far = kFar * std::max(2.0 * rms, noise_);
    for (size_t i = 0; i < scan_.size(); ++i) {
      const double r = state.distances[i] / far;
      if (weights_[i] > 0.0) weights_[i] = std::abs(r) < 1.0 ? (1 - r * r) * (1 - r * r) : 0.0;
    }
  }

  double Misfit(const State& state) const {
    double squares = 0.0;
    int count = 0;
    for (size_t i = 0; i < scan_.size(); ++i) {
      if (!(weights_[i] > 0.0)) continue;
      squares += state.distances[i] * state.distances[i];
      ++count;
    }
    return count > 0 ? std::sqrt(squares / count) : std::numeric_limits<double>::infinity();
  }

  // R in the units of the problem, and where wanted its gradient; its matrix is then in
  // regulariser(). False where strains are undefined.
  bool Regularise(const Matrix3Xd& u, double* energy, VectorXd* gradient) {
    if (reference_.cols() > 0) {
      const VectorXd change = stiffness_.Reduce(u - reference_);
      VectorXd force = reference_matrix_.selfadjointView<Eigen::Lower>() * change;
      if (update_vectors_.cols() > 0) {
        force +=
            update_vectors_ * update_weights_.cwiseProduct(update_vectors_.transpose() * change);
      }
      *energy = 0.5 * force.dot(change);
      if (gradient != nullptr) *gradient = force;
      return true;
    }
    shell_->displacements() = u;
    TangentStiffness::Request request;
    request.energy = energy;
    request.gradient = gradient;
    request.matrix = gradient != nullptr;
    return stiffness_.Evaluate(request);
  }
  const Eigen::SparseMatrix<double>& regulariser() const {
    return reference_.cols() > 0 ? reference_matrix_ : stiffness_.matrix();
  }

  double DataTerm(const State& state) const {
    double sum = 0.0;
    for (size_t i = 0; i < scan_.size(); ++i) {
      const double r = state.distances[i] / noise_;
      sum += 0.5 * weights_[i] * r * r;
    }
    return sum;
  }

  // Normal equations of the distances: over displacements in *values and *gradient, the motion in
  // border (a column per component), corner and motion_gradient.
  struct Normal {
    VectorXd values, gradient;
    Eigen::MatrixXd border;
    Eigen::Matrix<double, 6, 6> corner = Eigen::Matrix<double, 6, 6>::Zero();
    Motion motion_gradient = Motion::Zero();
  };
  Normal MakeNormal(const State& state, const ScanDistance::Frame& frame) const {
    const ShellSurface& surface = shell_->surface();
    Normal normal;
    normal.values = VectorXd::Zero(stiffness_.matrix().nonZeros());
    Matrix3Xd gradient = Matrix3Xd::Zero(3, state.u.cols());
    std::array<Matrix3Xd, 6> border;
    for (Matrix3Xd& column : border) column = Matrix3Xd::Zero(3, state.u.cols());
    std::vector<std::vector<int>> of_element(surface.num_elements());
    for (size_t i = 0; i < scan_.size(); ++i) {
      if (weights_[i] > 0.0) of_element[state.feet[i].at.element].push_back(static_cast<int>(i));
    }
    for (int e = 0; e < surface.num_elements(); ++e) {
      if (of_element[e].empty()) continue;
      const std::vector<int>& vertices = surface.control_vertices(e);
      const int n = static_cast<int>(vertices.size());
      Eigen::MatrixXd block = Eigen::MatrixXd::Zero(3 * n, 3 * n);
      for (const int i : of_element[e]) {
        const ShellFace::Foot& foot = state.feet[i];
        const double s = weights_[i] / (noise_ * noise_);
        const VectorXd weights = surface.ValueWeights(foot.at);
        VectorXd row(3 * n);  // of the distance, as ScanDistance has it
        for (int k = 0; k < n; ++k) row.segment<3>(3 * k) = -weights[k] * foot.normal;
        const Vector3d x = state.pose * scan_[i];
        Motion motion;
        motion << foot.normal, (x - frame.center).cross(foot.normal) / frame.length;
        block.selfadjointView<Eigen::Lower>().rankUpdate(row, s);
        normal.corner += s * motion * motion.transpose();
        normal.motion_gradient += s * foot.distance * motion;
        for (int k = 0; k < n; ++k) {
          gradient.col(vertices[k]) += s * foot.distance * row.segment<3>(3 * k);
          for (int m = 0; m < 6; ++m) {
            border[m].col(vertices[k]) += s * motion[m] * row.segment<3>(3 * k);
          }
        }
      }
      block.triangularView<Eigen::StrictlyUpper>() = block.transpose();
      stiffness_.AddElementMatrix(e, block, &normal.values);
    }
    normal.gradient = stiffness_.Reduce(gradient);
    normal.border.resize(normal.gradient.size(), 6);
    for (int m = 0; m < 6; ++m) normal.border.col(m) = stiffness_.Reduce(border[m]);
    return normal;
  }

  ScanDistance::Frame MakeFrame(const State& state) const {
    ScanDistance::Frame frame;
    const double n = static_cast<double>(scan_.size());
    for (const Vector3d& x : scan_) frame.center += state.pose * x / n;
    double squared = 0.0;
    for (const Vector3d& x : scan_) squared += (state.pose * x - frame.center).squaredNorm() / n;
    frame.length = std::sqrt(squared);
    return frame;
  }

  // Gauss-Newton at one weight, from *state. to_the_end: until nothing changes. False: the system
  // could not be solved or strains are undefined.
  bool AtWeight(double weight, bool to_the_end, State* state) {
    const double factor = weight / energy_scale_;
    const double few = to_the_end ? 1e-7 : 1e-3;
    int iteration = 0;
    settled_ = false;
    // Points that turn into outliers and back would keep it from settling.
    constexpr int kFrozen = 5;
    const int most = to_the_end ? 3 * options_.max_iterations : options_.max_iterations;
    const auto report = [&](bool is_end) {
      if (!options_.on_iteration) return;
      ShapeFitIteration report;
      report.trial = static_cast<int>(summary_->trials.size()) + 1;
      report.weight = weight;
      report.iteration = iteration;
      report.is_end = is_end;
      report.misfit = Misfit(*state);
      report.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
      if (is_end) report.seconds_left_at_most = trials_left_ * report.seconds / report.trial;
      options_.on_iteration(report);
    };
    for (; iteration < most; ++iteration) {
      if (options_.stop != nullptr && options_.stop->load()) return false;
      if (!to_the_end || iteration < kFrozen) FindWeights(*state);
      report(false);
      VectorXd gradient;
      if (!Regularise(state->u, &energy_, &gradient)) return false;
      const double value = DataTerm(*state) + factor * energy_;
      const ScanDistance::Frame frame = MakeFrame(*state);
      const Normal normal = MakeNormal(*state, frame);
      VectorXd step;
      Motion motion;
      if (!SolveNormal(normal, factor, gradient, &step, &motion)) return false;
      bool moved = false;
      double now = value;
      State trial;
      for (double part = 1.0; part > 1e-3 && !moved; part *= 0.5) {
        trial = *state;
        trial.u += stiffness_.Expand(part * step);
        trial.pose = frame.Pose(part * motion) * state->pose;
        FindFeet(&trial);
        double energy;
        if (!Regularise(trial.u, &energy, nullptr)) continue;
        now = DataTerm(trial) + factor * energy;
        if (now < value * (1.0 + 1e-13)) {
          moved = true;
          energy_ = energy;
        }
      }
      if (!moved) {
        FindFeet(state);
        settled_ = true;
        break;
      }
      *state = std::move(trial);
      if (value - now <= few * value) {
        settled_ = true;
        ++iteration;
        break;
      }
    }
    if (!to_the_end) FindWeights(*state);
    summary_->weight = weight;
    summary_->misfit = Misfit(*state);
    summary_->iterations = std::max(0, summary_->iterations) + iteration;
    if (trials_left_ > 0) --trials_left_;
    report(true);
    summary_->trials.push_back({weight, summary_->misfit, iteration});
    return true;
  }

  // (H + factor K) step + border motion = -..., border^T step + corner motion = -...
  bool SolveNormal(const Normal& normal,
                   double factor,
                   const VectorXd& gradient,
                   VectorXd* step,
                   Motion* motion) {
    Eigen::SparseMatrix<double> matrix = regulariser();
    Eigen::Map<VectorXd> values(matrix.valuePtr(), matrix.nonZeros());
    values = factor * values + normal.values;
    cholesky_.SetUpdate(update_vectors_, factor * update_weights_);
    double damping = 0.0;
    bool solved = cholesky_.Factorize(matrix);
    constexpr double kFirst = 1e-12, kLast = 1e-3;
    const VectorXd diagonal = matrix.diagonal();
    for (double next = kFirst; !solved && next <= kLast; next *= 100.0) {
      for (int j = 0; j < matrix.cols(); ++j) {
        matrix.valuePtr()[matrix.outerIndexPtr()[j]] += (next - damping) * diagonal[j];
      }
      damping = next;
      solved = cholesky_.Factorize(matrix);
    }
    if (!solved) return false;
    const VectorXd right = -(normal.gradient + factor * gradient);
    Eigen::MatrixXd all(right.size(), 7);
    all << right, normal.border;
    const Eigen::MatrixXd solution = cholesky_.SolveMany(all);
    // A rigid motion of the shell is as good as the opposite one of the scan where nothing holds
    // the shell: the smallest motion of the scan will do.
    Eigen::Matrix<double, 6, 6> schur =
        normal.corner - normal.border.transpose() * solution.rightCols<6>();
    schur = (0.5 * (schur + schur.transpose())).eval();
    constexpr double kSmall = 1e-9;
    schur.diagonal().array() += kSmall * normal.corner.trace();
    const Motion schur_right =
        -normal.motion_gradient - normal.border.transpose() * solution.col(0);
    *motion = schur.ldlt().solve(schur_right);
    *step = solution.col(0) - solution.rightCols<6>() * *motion;
    return step->allFinite() && motion->allFinite();
  }

  // The discrepancy principle: from stiff to soft until the misfit is the noise, then the weight in
  // between.
  bool ChooseWeight(State* state) {
    constexpr double kClose = 0.03, kStagnant = 0.02;
    const double target = noise_ * (1.0 + kClose);
    FindWeights(*state);
    const Normal normal = MakeNormal(*state, MakeFrame(*state));
    // Where the data weigh as much as the energy, at the average unknown; and a thousand times up.
    const double data = VectorXd(normal.values).cwiseAbs().sum();
    const double stiff =
        Eigen::Map<const VectorXd>(reference_matrix_.valuePtr(), reference_matrix_.nonZeros())
            .cwiseAbs()
            .sum();
    double weight = 1e3 * energy_scale_ * data / stiff;
    double stiff_weight = 0.0, stiff_misfit = 0.0, soft_weight = 0.0, soft_misfit = 0.0;
    State at_stiff;
    int num_stagnant = 0;
    constexpr double kStep = 0.1;
    const State first = *state;
    constexpr int kMostBetween = 6;
    trials_left_ = options_.max_weights + kMostBetween + 1;
    for (int k = 0; k < options_.max_weights; ++k) {
      if (!AtWeight(weight, false, state)) return false;
      const double misfit = summary_->misfit;
      if (misfit <= target) {
        soft_weight = weight;
        soft_misfit = misfit;
        break;
      }
      // Outliers that look like signal leave a rest.
      constexpr double kNearly = 1.5;
      const bool stagnates = stiff_weight > 0.0 && misfit > (1.0 - kStagnant) * stiff_misfit;
      num_stagnant = stagnates ? num_stagnant + 1 : 0;
      if (stagnates && misfit < kNearly * noise_) {
        note_ =
            Format("; smaller weights leave the misfit at %.3g times the noise", misfit / noise_);
        *state = std::move(at_stiff);
        return Finish(stiff_weight, state);
      }
      if (num_stagnant > 1) break;
      stiff_weight = weight;
      stiff_misfit = misfit;
      at_stiff = *state;
      weight *= kStep;
    }
    if (soft_weight == 0.0) {
      reached_ = false;
      return Finish(stiff_weight, state);
    }
    // The trial at `weight` is now one end or the other.
    const auto narrow = [&](State* trial) {
      if (summary_->misfit <= target) {
        soft_weight = weight;
        soft_misfit = summary_->misfit;
        *state = std::move(*trial);
      } else {
        stiff_weight = weight;
        stiff_misfit = summary_->misfit;
      }
    };
    // Soft enough at once: how stiff may it be?
    constexpr int kMostSteps = 5;
    for (int k = 0; k < kMostSteps && stiff_weight == 0.0; ++k) {
      weight = soft_weight / kStep;
      State trial = first;
      if (!AtWeight(weight, false, &trial)) return false;
      narrow(&trial);
    }
    if (stiff_weight == 0.0) {
      note_ = "; the computed shape explains the scan within its noise";
      if (reference_.cols() == 0) note_ = "; the rest shape explains the scan within its noise";
      return Finish(soft_weight, state);
    }
    // Misfits grow with the weight: false position in logarithms, kept off the ends.
    trials_left_ = kMostBetween + 1;
    for (int k = 0; k < kMostBetween && !(soft_misfit > (1.0 - kClose) * noise_); ++k) {
      double part = std::log(noise_ / soft_misfit) / std::log(stiff_misfit / soft_misfit);
      part = std::clamp(part, 0.15, 0.85);
      weight = soft_weight * std::pow(stiff_weight / soft_weight, part);
      State trial = *state;  // from the soft side: it has found what there is to fit
      if (!AtWeight(weight, false, &trial)) return false;
      narrow(&trial);
    }
    return Finish(soft_weight, state);
  }

  bool Finish(double weight, State* state) {
    trials_left_ = 1;
    return AtWeight(weight, true, state);
  }

  ShellProblem* shell_;
  const Matrix3Xd& reference_;
  const std::vector<Vector3d>& scan_;
  const ShapeFitOptions& options_;
  ShellFace* face_;
  ShapeFitSummary* summary_;
  TangentStiffness stiffness_;
  UpdatedCholesky cholesky_;
  Eigen::SparseMatrix<double> reference_matrix_;
  Eigen::MatrixXd update_vectors_;
  VectorXd update_weights_;
  std::vector<std::vector<int>> neighbours_;
  std::vector<double> weights_;
  double spacing_ = 0.0;  // to the last of the neighbours, at the median
  double energy_scale_ = 1.0, noise_ = 0.0, energy_ = 0.0;

  const Clock::time_point start_ = Clock::now();
  int trials_left_ = 1;   // of weights, at most
  bool settled_ = false;  // the last iteration at a weight
  bool reached_ = true;   // the misfit came down to the noise
  std::string note_;
};

}  // namespace

bool ShapeFitOptions::IsValid(std::string* error) const {
  const auto fail = [error](const char* name, double found, const char* allowed) {
    char text[160];
    std::snprintf(text, sizeof(text), "%s: found %g; allowed %s", name, found, allowed);
    *error = text;
    return false;
  };
  if (!(noise >= 0.0) || !std::isfinite(noise)) return fail("noise", noise, ">= 0");
  if (!(weight >= 0.0) || !std::isfinite(weight)) return fail("weight", weight, ">= 0");
  if (max_iterations < 1) return fail("max_iterations", max_iterations, ">= 1");
  if (max_weights < 1) return fail("max_weights", max_weights, ">= 1");
  if (num_threads < 1) return fail("num_threads", num_threads, ">= 1");
  return registration.IsValid(error);
}

Scene WithoutLoads(const Scene& scene) {
  Scene result = scene;
  result.loads.clear();
  result.fingers.clear();
  result.expect.clear();
  result.steps = 1;
  result.path = PathSpec();
  return result;
}

bool FitShape(ShellProblem* shell,
              const Matrix3Xd& reference,
              double face_offset,
              const std::vector<Vector3d>& scan,
              const ShapeFitOptions& options,
              ShapeFitSummary* summary,
              std::string* error) {
  *summary = ShapeFitSummary();
  if (!options.IsValid(error)) return false;
  State state;
  state.u = reference;
  if (reference.cols() == 0) state.u = Matrix3Xd::Zero(3, shell->surface().mesh().num_vertices);
  ShellFace face(shell->surface(), face_offset);
  face.SetDisplacements(state.u);
  if (!Register(face, scan, options.registration, &summary->registration, error)) return false;
  if (!summary->registration.matched) {
    summary->verdict = summary->registration.verdict;
    return true;
  }
  state.pose = summary->registration.pose;
  state.feet = summary->registration.feet;
  // An exact scan is fitted to a part of the shell's size.
  constexpr double kExact = 1e-6;
  summary->noise = options.noise > 0.0 ? options.noise : summary->registration.noise;
  summary->noise = std::max(summary->noise, kExact * shell->surface().size());

  Fit fit(shell, reference, scan, options, &face, summary);
  const bool done = fit.Run(&state);
  shell->displacements() = state.u;
  summary->displacements = state.u;
  summary->max_displacement = Deformation(shell->surface(), state.u).largest();
  summary->pose = state.pose;
  summary->feet = state.feet;
  summary->distances = state.distances;
  summary->energy = fit.energy();
  std::vector<double> inliers;
  for (size_t i = 0; i < scan.size(); ++i) {
    const bool counts = i < fit.weights().size() && fit.weights()[i] > 0.0;
    summary->counts.push_back(counts ? 1 : 0);
    if (counts) inliers.push_back(state.distances[i]);
    if (!counts && state.feet[i].on_boundary) ++summary->num_beyond_boundary;
    if (!counts && !state.feet[i].on_boundary) ++summary->num_outliers;
  }
  summary->all = MakeDistanceStatistics(state.distances);
  summary->inliers = MakeDistanceStatistics(inliers);
  if (!done) {
    if (options.stop != nullptr && options.stop->load()) {
      summary->verdict = "interrupted";
    } else if (summary->verdict == "not run") {
      summary->verdict = "the normal equations could not be solved";
    }
    return true;
  }
  const std::string numbers = Format(
      "misfit %.4g (noise %.4g) at weight %.4g", summary->misfit, summary->noise, summary->weight);
  summary->converged = fit.settled() && fit.reached();
  if (!fit.reached()) {
    summary->verdict = "no weight brings the misfit down to the noise: " + numbers +
                       "; the noise is larger, or the mesh too coarse";
  } else if (!fit.settled()) {
    summary->verdict = "not converged within the iterations allowed: " + numbers;
  } else {
    summary->verdict = "fitted: " + numbers + fit.note();
  }
  return true;
}

std::string ShapeFitSummary::FullReport() const {
  std::string text = verdict + "\n  registration: " + registration.BriefReport() + "\n";
  for (const Trial& trial : trials) {
    text += Format("  weight %.3e  misfit %.4e", trial.weight, trial.misfit) +
            Format("  %.0f iterations\n", trial.iterations);
  }
  text += "  outliers: " + std::to_string(num_outliers) + " of " + std::to_string(all.count) + "\n";
  text += Format("  distances: mean %.4g, mean absolute %.4g, rms %.4g",
                 inliers.mean,
                 inliers.mean_abs,
                 inliers.rms) +
          Format(", max %.4g; largest displacement %.4g\n", inliers.max, max_displacement);
  return text;
}

}  // namespace darboux
