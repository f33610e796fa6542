#include "solver/shell_problem.h"

#include <ceres/manifold.h>
#include <glog/logging.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "costs/bending_energy.h"
#include "costs/edge_moment.h"
#include "costs/gas_blocks.h"
#include "costs/load_work.h"
#include "costs/membrane_energy.h"
#include "costs/stacked_cost.h"
#include "costs/strain_derivatives.h"
#include "costs/support.h"
#include "geometry/quadrature.h"
#include "solver/magnitudes.h"
#include "solver/mesh_surface.h"
#include "solver/parallel_for.h"

namespace darboux {
namespace {

// Below this, relative to the natural scale, a quantity is rounding.
constexpr double kRounding = 1e-11;

// Displacements within a fixed subspace: x + basis * delta.
class SubspaceManifold : public ceres::Manifold {
 public:
  explicit SubspaceManifold(Eigen::MatrixXd basis) : basis_(std::move(basis)) {}
  int AmbientSize() const override { return static_cast<int>(basis_.rows()); }
  int TangentSize() const override { return static_cast<int>(basis_.cols()); }
  bool Plus(const double* x, const double* delta, double* result) const override {
    Eigen::Map<Eigen::VectorXd>(result, AmbientSize()) =
        Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()) +
        basis_ * Eigen::Map<const Eigen::VectorXd>(delta, TangentSize());
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    for (int i = 0; i < AmbientSize(); ++i) {
      for (int k = 0; k < TangentSize(); ++k) jacobian[i * TangentSize() + k] = basis_(i, k);
    }
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Eigen::Map<Eigen::VectorXd>(delta, TangentSize()) =
        basis_.transpose() * (Eigen::Map<const Eigen::VectorXd>(y, AmbientSize()) -
                              Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    for (int k = 0; k < TangentSize(); ++k) {
      for (int i = 0; i < AmbientSize(); ++i) jacobian[k * AmbientSize() + i] = basis_(i, k);
    }
    return true;
  }

 private:
  Eigen::MatrixXd basis_;  // orthonormal columns
};

// Two unit vectors that complete n to an orthonormal frame.
Eigen::Matrix<double, 3, 2> PlaneBasis(const Eigen::Vector3d& n) {
  int smallest;
  n.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = n.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

// Null and *error where a mesh has no smooth Loop surface.
std::unique_ptr<ShellSurface> MakeSurface(const Scene& scene, std::string* error) {
  const SurfaceSpec& spec = scene.surface;
  if (spec.mesh != nullptr) return MakeMeshSurface(spec, error);
  ParameterDomain::Options domain;
  domain.u_range = spec.u_range;
  domain.v_range = spec.v_range;
  domain.divisions = spec.divisions;
  domain.periodic = spec.periodic;
  domain.grading = spec.grading;
  domain.maps = spec.grading_maps;
  return std::make_unique<ShellSurface>(spec.surface,
                                        domain,
                                        scene.model.boundary_rule == BoundaryRule::kSeedGhosts
                                            ? ShellSurface::Ghosts::kFolded
                                            : ShellSurface::Ghosts::kIndependent);
}

StrainMeasure MeasureOf(Strains strains, bool nonlinear) {
  if (strains == Strains::kKoiter) {
    return nonlinear ? StrainMeasure::kKoiter : StrainMeasure::kLinearKoiter;
  }
  return nonlinear ? StrainMeasure::kNonlinearSeed : StrainMeasure::kLinearSeed;
}

}  // namespace

const char* ToString(Effect effect) {
  switch (effect) {
    case Effect::kMembrane:
      return "membrane";
    case Effect::kBending:
      return "bending";
    case Effect::kGeometricNonlinearity:
      return "geometric_nonlinearity";
    case Effect::kContact:
      return "contact";
    case Effect::kFriction:
      return "friction";
    case Effect::kGas:
      return "gas";
    case Effect::kGravity:
      return "gravity";
    case Effect::kSupports:
      return "supports";
    case Effect::kLoads:
      return "loads";
  }
  return "";
}

ShellProblem::ShellProblem(const Scene& scene,
                           const Material& material,
                           const Options& options,
                           std::unique_ptr<ShellSurface> surface)
    : scene_(scene),
      options_(options),
      material_(material),
      measure_(MeasureOf(scene.model.strains, options.nonlinear)) {
  surface_ = std::move(surface);
  points_.resize(surface_->num_elements());
  ParallelFor(ThreadsFor(surface_->num_elements(), options.num_threads),
              surface_->num_elements(),
              [&](int, int begin, int end) {
                for (int e = begin; e < end; ++e) {
                  points_[e] = std::make_shared<const std::vector<StrainPoint>>(
                      surface_->QuadraturePoints(e, scene.model.quadrature));
                }
              });
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const StrainPoints& points : points_) {
    for (const StrainPoint& point : *points) {
      center += point.area * point.position;
      area += point.area;
    }
    num_quadrature_points_ += static_cast<int>(points->size());
  }
  frame_.center = center / area;
  frame_.length = surface_->size();
  force_unit_ = material_.BendingStiffness() / (frame_.length * frame_.length);
  scaled_material_ = material_;
  scaled_material_.young_modulus /= force_unit_;
  displacements_ = Eigen::Matrix3Xd::Zero(3, surface_->mesh().num_vertices);
  if (options_.prestress.size() == 0) return;
  for (int e = 0; e < surface_->num_elements(); ++e) {
    for (const StrainPoint& point : *points_[e]) {
      initial_strains_.push_back(InitialStrain(e, point));
    }
  }
}

Eigen::Matrix<double, 6, 1> ShellProblem::InitialStrain(int element,
                                                        const StrainPoint& point) const {
  const std::vector<int>& vertices = surface_->control_vertices(element);
  Eigen::Matrix<double, kBendingInputs, 1> k = Eigen::Matrix<double, kBendingInputs, 1>::Zero();
  StrainDerivatives strain;
  CHECK(EvaluateStrainDerivatives(measure_, point, k.data(), &strain));
  Eigen::Map<Eigen::Matrix<double, 3, 5>> inputs(k.data());
  for (size_t i = 0; i < vertices.size(); ++i) {
    inputs += options_.prestress.col(vertices[i]) * point.weights.col(i).tail<5>().transpose();
  }
  return strain.gradient * k;
}

std::unique_ptr<ShellProblem> ShellProblem::Create(const Scene& scene,
                                                   const Options& options,
                                                   std::string* error) {
  Material material;
  material.thickness = scene.shell.thickness;
  material.young_modulus = scene.shell.young_modulus;
  material.poisson_ratio = scene.shell.poisson_ratio;
  material.density = scene.shell.density;
  if (!material.IsValid(error)) return nullptr;
  std::unique_ptr<ShellSurface> surface = MakeSurface(scene, error);
  if (surface == nullptr) return nullptr;
  std::unique_ptr<ShellProblem> problem(
      new ShellProblem(scene, material, options, std::move(surface)));
  problem->dead_loads_ = AssembleDeadLoads(
      scene, *problem->surface_, options.nonlinear, problem->frame_, options.num_threads);
  const double size = problem->frame_.length;
  Magnitudes magnitudes{size, problem->force_unit_, problem->dead_loads_.rigid_scale};
  if (const LoadSpec* const gas = FindGas(scene)) {
    magnitudes.loads += (std::abs(gas->gauge_pressure) + gas->ambient_pressure) * size * size;
  }
  if (!CheckMagnitudes(scene, magnitudes, error)) return nullptr;
  problem->dead_loads_.force /= problem->force_unit_;
  SupportConditions supports;
  if (!MakeSupportConditions(scene,
                             *problem->surface_,
                             problem->scaled_material_,
                             problem->frame_,
                             &supports,
                             error)) {
    return nullptr;
  }
  problem->conditions_ = std::move(supports.conditions);
  problem->fixed_vertices_ = std::move(supports.fixed_vertices);
  if (options.start.size() > 0) problem->displacements() = options.start;
  if (!scene.fingers.empty()) {
    problem->grasp_ = Grasp::Create(scene,
                                    *problem->surface_,
                                    problem->scaled_material_,
                                    problem->force_unit_,
                                    problem->displacements_.data(),
                                    error);
    if (problem->grasp_ == nullptr) return nullptr;
  }
  problem->ChooseUnknowns();
  if (!problem->HoldRigidMotions(error)) return nullptr;
  if (problem->grasp_ != nullptr) {
    const auto is_free = [&](const Eigen::Vector3d& direction) {
      return std::all_of(problem->conditions_.begin(),
                         problem->conditions_.end(),
                         [&](const PlacedCondition& condition) {
                           const double moved =
                               (direction.transpose() * condition.coefficients).sum();
                           return std::abs(moved) <= kRounding * condition.coefficients.norm();
                         });
    };
    const Eigen::Vector3d dead = problem->dead_loads_.force.rowwise().sum();
    if (!problem->grasp_->CheckBalance(is_free, dead, error)) return nullptr;
  }

  problem->ListUnknowns();
  problem->force_ = problem->dead_loads_.force;
  problem->correction_ = problem->held_ = Eigen::Matrix3Xd::Zero(3, problem->force_.cols());
  if (options.start.size() > 0) {
    std::copy_n(options.start_multipliers.begin(),
                std::min(options.start_multipliers.size(), problem->multipliers_.size()),
                problem->multipliers_.begin());
  }
  problem->SetLoadFactor(1.0);
  // Forces that follow are among the blocks.
  if (options.nonlinear || problem->grasp_ != nullptr || FindGas(scene) != nullptr) {
    problem->Build();
  }
  return problem;
}

void ShellProblem::Build() {
  ceres::Problem::Options options;
  options.disable_all_safety_checks = true;  // Blocks are built from one mesh, below.
  problem_ = std::make_unique<ceres::Problem>(options);
  AddParameters();
  AddStrainEnergies();
  AddSupports();
  AddLoads();
}

// A flat plate in the linear theory: transverse and in-plane displacement do not meet in any term,
// so the one that nothing drives is exactly zero and need not be an unknown.
void ShellProblem::ChooseUnknowns() {
  EffectReport& membrane = effects_[static_cast<int>(Effect::kMembrane)];
  EffectReport& bending = effects_[static_cast<int>(Effect::kBending)];
  EffectReport& nonlinearity = effects_[static_cast<int>(Effect::kGeometricNonlinearity)];
  membrane = {true, "the shell can stretch", 0, 0};
  bending = {true, "the shell can bend", 0, 0};
  nonlinearity.on = options_.nonlinear;
  nonlinearity.why = options_.nonlinear ? "nonlinear theory" : "linear theory";
  if (options_.nonlinear || grasp_ != nullptr) return;

  plate_normal_ = points_.front()->front().n;
  double curvature = 0.0, tilt = 0.0;
  for (const StrainPoints& element : points_) {
    for (const StrainPoint& p : *element) {
      curvature = std::max({curvature, std::abs(p.b11), std::abs(p.b12), std::abs(p.b22)});
      tilt = std::max(tilt, (p.n - plate_normal_).norm());
    }
  }
  if (curvature * frame_.length > kRounding || tilt > kRounding) return;

  const Eigen::Matrix3Xd& force = dead_loads_.force;
  const double largest = force.size() > 0 ? force.cwiseAbs().maxCoeff() : 0.0;
  const Eigen::RowVectorXd transverse = plate_normal_.transpose() * force;
  const Eigen::Matrix3Xd in_plane = force - plate_normal_ * transverse;
  bool drives_normal =
      transverse.size() > 0 && transverse.cwiseAbs().maxCoeff() > kRounding * largest;
  bool drives_plane = in_plane.size() > 0 && in_plane.cwiseAbs().maxCoeff() > kRounding * largest;
  bool mixes = false;
  for (const PlacedCondition& c : conditions_) {
    for (int i = 0; i < c.coefficients.cols(); ++i) {
      const double along = std::abs(plate_normal_.dot(c.coefficients.col(i)));
      const double across =
          (c.coefficients.col(i) - plate_normal_ * plate_normal_.dot(c.coefficients.col(i))).norm();
      const double scale = kRounding * c.coefficients.col(i).norm();
      if (along > scale && across > scale) mixes = true;
      if (c.target != 0.0 && along > scale) drives_normal = true;
      if (c.target != 0.0 && across > scale) drives_plane = true;
    }
  }
  if (mixes) return;
  // Transverse springs as stiff against bending as the others are against stretching: those of a
  // thin plate would turn rounding of the displacements into forces.
  double area = 0.0;
  for (const StrainPoints& element : points_) {
    for (const StrainPoint& p : *element) area += p.area;
  }
  const double cell = area / static_cast<double>(points_.size());
  const double softer =
      std::min(1.0, material_.BendingStiffness() / (material_.MembraneStiffness() * cell));
  for (PlacedCondition& c : conditions_) {
    const double along = (plate_normal_.transpose() * c.coefficients).norm();
    if (along > 0.5 * c.coefficients.norm()) c.stiffness *= softer;
  }
  if (drives_normal == drives_plane) return;
  if (drives_normal) {
    unknowns_ = Unknowns::kNormalOnly;
    membrane = {false,
                "flat plate, transverse loads and supports, linear theory: the in-plane "
                "displacement is exactly zero",
                0,
                0};
  } else {
    unknowns_ = Unknowns::kInPlaneOnly;
    bending = {false,
               "flat plate, in-plane loads and supports, linear theory: the transverse "
               "displacement is exactly zero",
               0,
               0};
  }
}

bool ShellProblem::HoldRigidMotions(std::string* error) {
  Eigen::MatrixXd rows(conditions_.size(), 6);
  for (size_t i = 0; i < conditions_.size(); ++i) rows.row(i) = conditions_[i].rigid_row;
  // Motions of the unknown part of the displacement.
  Eigen::MatrixXd allowed = Eigen::MatrixXd::Identity(6, 6);
  const Eigen::Matrix<double, 3, 2> plane = PlaneBasis(plate_normal_);
  if (unknowns_ == Unknowns::kNormalOnly) {
    allowed = Eigen::MatrixXd::Zero(6, 3);
    allowed.block<3, 1>(0, 0) = plate_normal_;
    allowed.block<3, 2>(3, 1) = plane;
  } else if (unknowns_ == Unknowns::kInPlaneOnly) {
    allowed = Eigen::MatrixXd::Zero(6, 3);
    allowed.block<3, 2>(0, 0) = plane;
    allowed.block<3, 1>(3, 2) = plate_normal_;
  }
  const Eigen::MatrixXd motions = FreeMotions(rows, allowed);
  if (motions.cols() == 0) return true;
  free_motions_ = NameMotions(motions, frame_);

  // Loads that drive a free motion have no equilibrium.
  // Leaves of different sizes integrate loads that balance to the digits of their rules only, not
  // to rounding as a symmetric mesh does: the means hold what is left.
  constexpr double kBalance = 1e-6, kRefinedBalance = 1e-4;
  const double balance = scene_.surface.mesh != nullptr && IsRefinedLocally(scene_.surface)
                             ? kRefinedBalance
                             : kBalance;
  const Eigen::VectorXd work = motions.transpose() * dead_loads_.rigid_work;
  if (grasp_ == nullptr && work.norm() > balance * dead_loads_.rigid_scale) {
    // Where the supports stand, or else where they are missing.
    const SceneLocation& where =
        scene_.supports.empty() ? scene_.surface.location : scene_.supports.front().location;
    *error = where.file + ":" + std::to_string(where.line) +
             ": supports: found nothing that holds the shell against ";
    for (size_t i = 0; i < free_motions_.size(); ++i) {
      *error += (i == 0 ? "" : "; ") + free_motions_[i];
    }
    *error +=
        ", while the loads drive it; allowed are supports that remove these motions, or "
        "loads in balance on them";
    return false;
  }

  // The mean of motion . displacement over the shell. Stiff beside what dead loads that press on a
  // free shell turn it by: multipliers settle only where it is more than twice that.
  const double stiffness = (grasp_ == nullptr ? 100.0 : 1.0) * scaled_material_.MembraneStiffness();
  double area = 0.0;
  for (int k = 0; k < motions.cols(); ++k) {
    mean_conditions_.push_back({Eigen::Matrix3Xd::Zero(3, displacements_.cols()), stiffness});
  }
  for (size_t e = 0; e < points_.size(); ++e) {
    const std::vector<int>& vertices = surface_->control_vertices(static_cast<int>(e));
    for (const StrainPoint& point : *points_[e]) {
      area += point.area;
      for (int k = 0; k < motions.cols(); ++k) {
        const Eigen::Vector3d turn = motions.col(k).tail<3>() / frame_.length;
        const Eigen::Vector3d motion =
            motions.col(k).head<3>() + turn.cross(point.position - frame_.center);
        Eigen::Matrix3Xd& coefficients = mean_conditions_[k].coefficients;
        for (size_t i = 0; i < vertices.size(); ++i) {
          coefficients.col(vertices[i]) += point.area * point.weights(kRowValue, i) * motion;
        }
      }
    }
  }
  for (MeanCondition& mean : mean_conditions_) mean.coefficients /= area;

  // Pins: as many displacement components as there are free motions, at points where the motions
  // are largest (pivoted QR).
  std::vector<PlacedCondition> candidates;
  const int stride = std::max(1, surface_->num_elements() / 256);
  for (int e = 0; e < surface_->num_elements(); e += stride) {
    const ElementPoint at{e, 1.0 / 3.0, 1.0 / 3.0};
    const StrainPoint point = surface_->MakePoint(at);
    for (const Eigen::Vector3d& direction : {point.t1, point.t2, point.n}) {
      candidates.push_back(PointCondition(*surface_, at, direction, scaled_material_, frame_));
    }
  }
  Eigen::MatrixXd moved(motions.cols(), candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    moved.col(i) = (candidates[i].rigid_row * motions).transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(moved);
  for (int k = 0; k < motions.cols(); ++k) {
    pins_.push_back(candidates[qr.colsPermutation().indices()[k]]);
  }
  pin_targets_.assign(pins_.size(), 0.0);
  held_forces_.assign(mean_conditions_.size(), 0.0);
  return true;
}

std::vector<double*> ShellProblem::Blocks(const std::vector<int>& vertices) {
  std::vector<double*> blocks;
  blocks.reserve(vertices.size());
  for (const int vertex : vertices) blocks.push_back(displacements_.col(vertex).data());
  return blocks;
}

ceres::ResidualBlockId ShellProblem::Record(Effect effect,
                                            ceres::ResidualBlockId id,
                                            int residuals) {
  EffectReport& report = effects_[static_cast<int>(effect)];
  ++report.residual_blocks;
  report.residuals += residuals;
  blocks_[static_cast<int>(effect)].push_back(id);
  return id;
}

Eigen::MatrixXd ShellProblem::unknown_basis() const {
  if (unknowns_ == Unknowns::kNormalOnly) return plate_normal_;
  if (unknowns_ == Unknowns::kInPlaneOnly) return PlaneBasis(plate_normal_);
  return Eigen::Matrix3d::Identity();
}

void ShellProblem::ListUnknowns() {
  is_free_.assign(displacements_.cols(), 0);
  for (int i = 0; i < displacements_.cols(); ++i) is_free_[i] = surface_->IsActive(i) ? 1 : 0;
  for (const int vertex : fixed_vertices_) is_free_[vertex] = 0;
  const Eigen::MatrixXd basis = unknown_basis();
  num_unknowns_ = static_cast<int>(basis.cols() * std::count(is_free_.begin(), is_free_.end(), 1));
  // What the unknown part of the displacement cannot change is no condition on it.
  for (PlacedCondition& condition : conditions_) {
    const Eigen::Matrix3Xd& c = condition.coefficients;
    if ((basis.transpose() * c).norm() <= kRounding * c.norm()) condition.stiffness = 0.0;
  }
  multipliers_.assign(conditions_.size() + mean_conditions_.size(), 0.0);
  targets_.assign(conditions_.size(), 0.0);
}

void ShellProblem::AddParameters() {
  // Shared by all blocks, owned by the problem.
  auto* manifold = unknowns_ == Unknowns::kAll ? nullptr : new SubspaceManifold(unknown_basis());
  for (int i = 0; i < displacements_.cols(); ++i) {
    if (!surface_->IsActive(i)) continue;
    double* const block = displacements_.col(i).data();
    problem_->AddParameterBlock(block, 3);
    if (manifold != nullptr) problem_->SetManifold(block, manifold);
    if (!is_free_[i]) problem_->SetParameterBlockConstant(block);
  }
}

void ShellProblem::AddStrainEnergies() {
  const bool tension_rows = options_.nonlinear && options_.tension_rows;
  size_t next = 0;
  for (int e = 0; e < surface_->num_elements(); ++e) {
    std::vector<std::unique_ptr<ceres::CostFunction>> costs;
    std::vector<Eigen::Vector3d> initial[2];
    for (size_t q = 0; !initial_strains_.empty() && q < points_[e]->size(); ++q) {
      initial[0].push_back(initial_strains_[next + q].head<3>());
      initial[1].push_back(initial_strains_[next + q].tail<3>());
    }
    next += points_[e]->size();
    const auto add = [&](Effect effect, std::unique_ptr<ceres::CostFunction> cost) {
      EffectReport& report = effects_[static_cast<int>(effect)];
      ++report.residual_blocks;
      report.residuals += cost->num_residuals();
      strain_energies_[effect == Effect::kMembrane ? 0 : 1].push_back(cost.get());
      costs.push_back(std::move(cost));
    };
    if (effect(Effect::kMembrane).on) {
      auto cost =
          std::make_unique<MembraneEnergy>(points_[e], measure_, scaled_material_, tension_rows);
      cost->SetInitialStrains(std::move(initial[0]));
      add(Effect::kMembrane, std::move(cost));
    }
    if (effect(Effect::kBending).on) {
      auto cost = std::make_unique<BendingEnergy>(points_[e], measure_, scaled_material_);
      cost->SetInitialStrains(std::move(initial[1]));
      add(Effect::kBending, std::move(cost));
    }
    ceres::CostFunction* block =
        costs.size() == 1 ? costs.front().release() : new StackedCost(std::move(costs));
    problem_->AddResidualBlock(block, nullptr, Blocks(surface_->control_vertices(e)));
  }
}

void ShellProblem::AddSupports() {
  EffectReport& report = effects_[static_cast<int>(Effect::kSupports)];
  report.on = !scene_.supports.empty();
  report.why = report.on ? "the scene names supports" : "the scene names no support";
  // Conditions on the same control vertices that follow each other share a block.
  for (size_t first = 0; first < conditions_.size();) {
    const std::vector<int>& vertices = conditions_[first].vertices;
    std::vector<Support::Condition> together;
    for (; first < conditions_.size() && conditions_[first].vertices == vertices; ++first) {
      const PlacedCondition& placed = conditions_[first];
      if (placed.stiffness == 0.0) continue;
      Support::Condition condition;
      condition.coefficients = placed.coefficients;
      condition.stiffness = placed.stiffness;
      condition.target = &targets_[first];
      together.push_back(std::move(condition));
    }
    if (together.empty()) continue;
    const int residuals = static_cast<int>(together.size());
    Record(Effect::kSupports,
           problem_->AddResidualBlock(new Support(std::move(together)), nullptr, Blocks(vertices)),
           residuals);
  }
  for (size_t k = 0; k < pins_.size(); ++k) {
    Support::Condition condition;
    condition.coefficients = pins_[k].coefficients;
    condition.stiffness = pins_[k].stiffness;
    condition.target = &pin_targets_[k];
    Record(Effect::kSupports,
           problem_->AddResidualBlock(
               new Support({std::move(condition)}), nullptr, Blocks(pins_[k].vertices)),
           1);
  }
}

void ShellProblem::AddLoads() {
  EffectReport& report = effects_[static_cast<int>(Effect::kLoads)];
  report.on = std::any_of(scene_.loads.begin(), scene_.loads.end(), [](const LoadSpec& load) {
    return load.kind != LoadSpec::Kind::kGas;
  });
  report.why = report.on ? "the scene names loads" : "the scene names no load";
  EffectReport& gravity = effects_[static_cast<int>(Effect::kGravity)];
  gravity.why = "the scene names no gravity load";
  for (const LoadSpec& load : scene_.loads) {
    if (load.kind == LoadSpec::Kind::kGravity) {
      gravity.on = true;
      gravity.why = "the scene names a gravity load; it acts through the load vector";
    }
  }
  for (const Effect absent : {Effect::kContact, Effect::kFriction, Effect::kGas}) {
    effects_[static_cast<int>(absent)].why =
        absent == Effect::kGas ? "the scene names no gas load" : "the scene has no fingers";
  }

  // Curvature of a potential's block, (dU/du)^2 / s^2, against the membrane stiffness: 1e-16.
  double largest = force_.cwiseAbs().maxCoeff();
  if (largest == 0.0) largest = scaled_material_.MembraneStiffness() * frame_.length;
  const double stiffness = std::sqrt(scaled_material_.MembraneStiffness());
  const auto scale = [&](double force) { return 1e8 * force / stiffness; };
  if (grasp_ != nullptr) AddFingers(scale);
  for (int i = 0; i < force_.cols(); ++i) {
    if (!surface_->IsActive(i)) continue;
    // The force of mean conditions acts everywhere.
    const bool loaded = !force_.col(i).isZero(0.0) || !mean_conditions_.empty();
    if (loaded) {
      Record(Effect::kLoads,
             Potential::AddTo(problem_.get(),
                              new LoadWork(force_.col(i).data(), scale(largest)),
                              {displacements_.col(i).data()}),
             1);
    }
  }
  if (const LoadSpec* const gas = FindGas(scene_)) AddGas(*gas, 1e8 / stiffness);
  if (!options_.nonlinear) return;

  // Forces that follow the deformation. The origin of the swept volume lies on the mirror planes,
  // where the boundary's part of its gradient vanishes.
  Eigen::Matrix3d normal_sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const SupportSpec& support : scene_.supports) {
    if (support.kind != SupportSpec::Kind::kSymmetry) continue;
    const Eigen::Vector3d normal(support.normal[0], support.normal[1], support.normal[2]);
    for (const Side side : SidesOf(support.on, *surface_)) {
      const Eigen::Vector3d x =
          surface_->SidePoints(side, 1).front().point.position - frame_.center;
      normal_sum += normal * normal.transpose();
      right += normal * normal.dot(x);
    }
  }
  const Eigen::Vector3d origin =
      frame_.center + normal_sum.completeOrthogonalDecomposition().solve(right);
  for (const LoadSpec& load : scene_.loads) {
    if (load.kind == LoadSpec::Kind::kPressure && load.follower) {
      for (int e = 0; e < surface_->num_elements(); ++e) {
        const auto& rule = surface_->Rule(e, scene_.model.quadrature);
        std::vector<double> pressure;
        double total = 0.0;
        for (size_t q = 0; q < rule.size(); ++q) {
          pressure.push_back(EvaluateAt(load.value, *surface_, {e, rule[q].s, rule[q].t}) /
                             force_unit_);
          total += std::abs(pressure.back()) * (*points_[e])[q].area;
        }
        if (total == 0.0) continue;
        auto* cost = new FollowerPressure(
            points_[e], std::move(pressure), origin, &load_factor_, scale(total));
        Record(Effect::kLoads,
               Potential::AddTo(problem_.get(), cost, Blocks(surface_->control_vertices(e))),
               1);
        followers_.push_back({e, cost});
        follower_forces_.push_back({e, cost});
      }
    } else if (load.kind == LoadSpec::Kind::kEdge) {
      for (const Side side : SidesOf(load.on, *surface_)) {
        for (const auto& edge : surface_->SidePoints(side, 3)) {
          const Eigen::Vector3d moment = EvaluateAt(load.moment, *surface_, edge.at) / force_unit_;
          if (moment.isZero(0.0)) continue;
          auto* cost =
              new EdgeMoment(edge.point, edge.tangent, moment, &load_factor_, scale(moment.norm()));
          Record(Effect::kLoads,
                 Potential::AddTo(
                     problem_.get(), cost, Blocks(surface_->control_vertices(edge.at.element))),
                 1);
          moments_.push_back({edge.at.element, cost});
          follower_forces_.push_back({edge.at.element, cost});
        }
      }
    }
  }
  // The correction of follower forces acts on vertices that carry no dead load as well.
  if (followers_.empty()) return;
  double total = 0.0;
  for (const auto& follower : followers_) {
    const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, 64);
    std::vector<const double*> rest(surface_->control_vertices(follower.first).size());
    for (auto& block : rest) block = zero.data();
    total = std::max(total, follower.second->ExactForce(rest.data()).norm());
  }
  for (int i = 0; i < force_.cols(); ++i) {
    if (!surface_->IsActive(i) || !dead_loads_.force.col(i).isZero(0.0)) continue;
    if (!mean_conditions_.empty()) continue;
    Record(Effect::kLoads,
           Potential::AddTo(problem_.get(),
                            new LoadWork(force_.col(i).data(), scale(std::max(total, largest))),
                            {displacements_.col(i).data()}),
           1);
  }
}

void ShellProblem::AddGas(const LoadSpec& load, double scale) {
  EffectReport& report = effects_[static_cast<int>(Effect::kGas)];
  report.on = true;
  report.why = std::string("the scene names a gas load, ") + ToString(load.law) +
               (load.prestressed ? ", rest shape pre-stressed" : "");
  const double unit = 1.0 / force_unit_;
  const double largest = (load.ambient_pressure + load.gauge_pressure) * unit;
  std::vector<std::pair<int, const FollowerPressure*>> blocks;
  gas_ = std::make_unique<GasState>(load);
  double volume = 0.0;
  for (int e = 0; e < surface_->num_elements(); ++e) {
    double area = 0.0;
    for (const StrainPoint& point : *points_[e]) area += point.area;
    auto* cost = new FollowerPressure(points_[e],
                                      std::vector<double>(points_[e]->size(), unit),
                                      frame_.center,
                                      &gas_->pressure,
                                      scale * largest * area,
                                      !options_.nonlinear);
    Record(Effect::kGas,
           Potential::AddTo(problem_.get(), cost, Blocks(surface_->control_vertices(e))),
           1);
    followers_.push_back({e, cost});
    gas_->blocks.push_back({e, cost});
    volume += cost->RestVolume();
  }
  CHECK_GT(volume, 0.0);        // Closed meshes are wound outwards.
  constexpr double kAir = 1.4;  // diatomic
  const double gamma = load.law == GasLaw::kAdiabatic  ? kAir
                       : load.law == GasLaw::kIsobaric ? 0
                                                       : 1;
  gas_->law = Gas(load.gauge_pressure, load.ambient_pressure, gamma, volume, !options_.nonlinear);
  gas_->volumes.assign(gas_->blocks.size(), 0.0);
  if (gamma > 0.0) {
    AddGasShares(gamma * (load.ambient_pressure + load.gauge_pressure) / volume / force_unit_);
  }
  CHECK(UpdateGas());
}

void ShellProblem::AddGasShares(double stiffness) {
  // What the springs leave behind of a change of pressure. Stiffer ones need fewer passes, but
  // where Ceres damps, it damps every share.
  constexpr double kLeft = 1e-4;
  const int leaves = static_cast<int>(gas_->blocks.size());
  gas_->shares.assign(2 * leaves - 1, 0.0);
  const double spring = stiffness / kLeft * static_cast<double>(gas_->shares.size());
  double area = 0.0;
  std::vector<Eigen::Vector3d> centers;
  for (const auto& block : gas_->blocks) {
    for (const StrainPoint& point : *points_[block.first]) area += point.area;
    centers.push_back(points_[block.first]->front().position);
  }
  // Halved across the longest side of what is left: a factorisation by nested dissection meets
  // neighbours before it meets their sums.
  std::vector<int> order(leaves);
  std::iota(order.begin(), order.end(), 0);
  int used = 0;
  const std::function<double*(int, int)> add = [&](int begin, int end) -> double* {
    double* const share = &gas_->shares[used++];
    problem_->AddParameterBlock(share, 1);
    if (end - begin == 1) {
      const auto& [element, volume] = gas_->blocks[order[begin]];
      std::vector<double*> parameters = Blocks(surface_->control_vertices(element));
      parameters.push_back(share);
      auto* cost = new GasShare(volume, &gas_->volumes[order[begin]], spring, area);
      Record(Effect::kGas, problem_->AddResidualBlock(cost, nullptr, parameters), 1);
      return share;
    }
    Eigen::AlignedBox3d box;
    for (int k = begin; k < end; ++k) box.extend(centers[order[k]]);
    int axis;
    box.sizes().maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(
        order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
          return centers[a][axis] < centers[b][axis];
        });
    double* const left = add(begin, middle);
    double* const right = add(middle, end);
    Record(Effect::kGas,
           problem_->AddResidualBlock(new GasSum(spring, area), nullptr, {left, right, share}),
           1);
    return share;
  };
  double* const root = add(0, leaves);
  auto* cost = new GasSpring(&gas_->law, &gas_->change, area, 1.0 / force_unit_);
  Record(Effect::kGas, problem_->AddResidualBlock(cost, nullptr, {root}), 1);
}

void ShellProblem::SetGasCharge(double part) {
  if (gas_ == nullptr) return;
  gas_->law.SetCharge(part * gas_->gauge);
  gas_->at.resize(3, 0);
}

bool ShellProblem::UpdateGas() const {
  if (gas_ == nullptr) return true;
  GasState& gas = *gas_;
  if (gas.at.cols() == displacements_.cols() && gas.at == displacements_) return true;
  gas.at.resize(3, 0);
  std::fill(gas.shares.begin(), gas.shares.end(), 0.0);
  if (!displacements_.allFinite()) return false;
  const int count = static_cast<int>(gas.blocks.size());
  const int num_threads = ThreadsFor(count, options_.num_threads);
  std::vector<double> changes(num_threads, 0.0);
  std::vector<Eigen::Matrix3Xd> gradients(num_threads);
  gas.pressure = 1.0;  // Forces are gradients of the volume then.
  ParallelFor(num_threads, count, [&](int thread, int begin, int end) {
    gradients[thread].setZero(3, displacements_.cols());
    std::vector<const double*> blocks;
    for (int k = begin; k < end; ++k) {
      const std::vector<int>& vertices = surface_->control_vertices(gas.blocks[k].first);
      blocks.clear();
      for (const int vertex : vertices) blocks.push_back(displacements_.col(vertex).data());
      gas.volumes[k] = gas.blocks[k].second->SweptVolume(blocks.data());
      changes[thread] += gas.volumes[k];
      const Eigen::Matrix3Xd force = gas.blocks[k].second->ExactForce(blocks.data());
      for (size_t i = 0; i < vertices.size(); ++i) {
        gradients[thread].col(vertices[i]) += force.col(i);
      }
    }
  });
  gas.change = std::accumulate(changes.begin(), changes.end(), 0.0);
  gas.gradient = gradients.front();
  for (int t = 1; t < num_threads; ++t) gas.gradient += gradients[t];
  if (!gas.law.IsDefined(gas.change)) return false;
  gas.pressure = gas.law.GaugePressure(gas.change);
  gas.at = displacements_;
  return true;
}

double ShellProblem::gas_weight() const {
  return -force_unit_ * gas_->law.PressureDerivative(gas_->change);
}

GasReport ShellProblem::ReportGas() const {
  GasReport report;
  if (gas_ == nullptr || !UpdateGas()) return report;
  report.gauge_pressure = gas_->pressure;
  report.absolute_pressure = gas_->law.ambient() + gas_->pressure;
  report.volume = gas_->law.rest_volume() + gas_->change;
  report.volume_ratio = report.volume / gas_->law.rest_volume();
  return report;
}

void ShellProblem::AddFingers(const std::function<double(double)>& curvature_scale) {
  EffectReport& contact = effects_[static_cast<int>(Effect::kContact)];
  EffectReport& friction = effects_[static_cast<int>(Effect::kFriction)];
  contact.on = true;
  contact.why = "the scene has fingers";
  friction.why = "no finger has friction";
  const auto added = [&](ceres::ResidualBlockId id, Grasp::Part part, int residuals) {
    switch (part) {
      case Grasp::Part::kContact:
        Record(Effect::kContact, id, residuals);
        return;
      case Grasp::Part::kFriction:
        Record(Effect::kFriction, id, residuals);
        friction.on = true;
        friction.why = "a finger has friction";
        return;
      case Grasp::Part::kForce:
        Record(Effect::kLoads, id, residuals);
        effects_[static_cast<int>(Effect::kLoads)].on = true;
        effects_[static_cast<int>(Effect::kLoads)].why = "a finger is driven by a force";
        return;
    }
  };
  grasp_->AddTo(problem_.get(), curvature_scale, added);
  for (const Grasp::Block& block : grasp_->blocks()) {
    follower_forces_.push_back({block.element, block.contact, block.travel});
    if (block.friction != nullptr) {
      follower_forces_.push_back({block.element, block.friction, block.travel});
    }
  }
}

void ShellProblem::SetLoadFactor(double factor) {
  load_factor_ = factor;
  if (grasp_ != nullptr) grasp_->SetLoadFactor(factor);
  force_ = factor * dead_loads_.force + correction_ + held_;
  SetTargets();
}

void ShellProblem::SetTargets() {
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    targets_[i] = load_factor_ * conditions_[i].target - multipliers_[i] / conditions_[i].stiffness;
  }
}

double ShellProblem::Violation(const PlacedCondition& condition) const {
  double c = -load_factor_ * condition.target;
  for (size_t i = 0; i < condition.vertices.size(); ++i) {
    c += condition.coefficients.col(i).dot(displacements_.col(condition.vertices[i]));
  }
  return c;
}

void ShellProblem::SetMultipliers(const std::vector<double>& multipliers) {
  CHECK_EQ(multipliers.size(), multipliers_.size());
  multipliers_ = multipliers;
  SetTargets();
}

double ShellProblem::MeanForce(size_t k) const {
  if (grasp_ != nullptr) return 0.0;
  const MeanCondition& mean = mean_conditions_[k];
  return mean.stiffness * mean.coefficients.cwiseProduct(displacements_).sum() +
         multipliers_[conditions_.size() + k];
}

void ShellProblem::HoldHere() {
  if (gas_ != nullptr)
    gas_->at.resize(3, 0);  // Shares can have moved where displacements have not.
  UpdateGas();
  if (mean_conditions_.empty()) return;
  for (size_t i = 0; i < pins_.size(); ++i) {
    pin_targets_[i] = 0.0;
    for (size_t k = 0; k < pins_[i].vertices.size(); ++k) {
      pin_targets_[i] += pins_[i].coefficients.col(k).dot(displacements_.col(pins_[i].vertices[k]));
    }
  }
  held_.setZero();
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    held_forces_[k] = MeanForce(k);
    held_ -= held_forces_[k] * mean_conditions_[k].coefficients;
  }
  SetLoadFactor(load_factor_);
}

void ShellProblem::KeepMeanForces() {
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    multipliers_[conditions_.size() + k] += held_forces_[k] - MeanForce(k);
  }
}

void ShellProblem::UpdateMultipliers() {
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    multipliers_[conditions_.size() + k] = MeanForce(k);
  }
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    multipliers_[i] += conditions_[i].stiffness * Violation(conditions_[i]);
  }
  SetTargets();
}

double ShellProblem::LargestViolation() const {
  double largest = 0.0;
  for (const PlacedCondition& condition : conditions_) {
    if (condition.stiffness == 0.0) continue;
    largest = std::max(largest, condition.arm * std::abs(Violation(condition)));
  }
  const double size = displacements_.cwiseAbs().maxCoeff();
  return size > 0.0 ? largest / size : 0.0;
}

double ShellProblem::SupportEnergy() const {
  double energy = 0.0;
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    const double c = Violation(conditions_[i]);
    energy += (0.5 * conditions_[i].stiffness * c + multipliers_[i]) * c;
  }
  for (size_t k = 0; k < mean_conditions_.size() && grasp_ == nullptr; ++k) {
    const MeanCondition& mean = mean_conditions_[k];
    const double c = mean.coefficients.cwiseProduct(displacements_).sum();
    energy += (0.5 * mean.stiffness * c + multipliers_[conditions_.size() + k]) * c;
  }
  return energy;
}

Eigen::Matrix3Xd ShellProblem::SupportGradient() const {
  Eigen::Matrix3Xd gradient = Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  for (size_t i = 0; i < conditions_.size(); ++i) {
    const PlacedCondition& condition = conditions_[i];
    if (condition.stiffness == 0.0) continue;
    const double force = condition.stiffness * Violation(condition) + multipliers_[i];
    for (size_t k = 0; k < condition.vertices.size(); ++k) {
      gradient.col(condition.vertices[k]) += force * condition.coefficients.col(k);
    }
  }
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    gradient += MeanForce(k) * mean_conditions_[k].coefficients;
  }
  return gradient;
}

void ShellProblem::SetAngleReferences() {
  for (const auto& moment : moments_) {
    moment.second->SetReference(Blocks(surface_->control_vertices(moment.first)).data());
  }
}

double ShellProblem::UpdateCorrection() {
  if (followers_.empty()) return 0.0;
  UpdateGas();
  Eigen::Matrix3Xd exact = Eigen::Matrix3Xd::Zero(3, force_.cols());
  Eigen::Matrix3Xd potential = exact;
  std::vector<double> gradient;
  for (const auto& follower : followers_) {
    const auto& vertices = surface_->control_vertices(follower.first);
    const std::vector<double*> blocks = Blocks(vertices);
    const Eigen::Matrix3Xd force = follower.second->ExactForce(blocks.data());
    // -dU/du through the block's own residual and Jacobian: J^T r.
    double residual;
    gradient.assign(3 * vertices.size(), 0.0);
    std::vector<double*> jacobians;
    for (size_t i = 0; i < vertices.size(); ++i) jacobians.push_back(&gradient[3 * i]);
    follower.second->Evaluate(blocks.data(), &residual, jacobians.data());
    for (size_t i = 0; i < vertices.size(); ++i) {
      exact.col(vertices[i]) += force.col(i);
      potential.col(vertices[i]) -= residual * Eigen::Map<Eigen::Vector3d>(jacobians[i]);
    }
  }
  const Eigen::Matrix3Xd correction = exact - potential;
  const double size = exact.norm();
  const double change = size > 0.0 ? (correction - correction_).norm() / size : 0.0;
  correction_ = correction;
  SetLoadFactor(load_factor_);
  return change;
}

double ShellProblem::StrainEnergyOf(const std::vector<const ceres::CostFunction*>& costs) const {
  const int count = static_cast<int>(costs.size());
  const int num_threads = ThreadsFor(count, options_.num_threads);
  std::vector<double> energies(num_threads, 0.0);
  ParallelFor(num_threads, count, [&](int thread, int begin, int end) {
    double energy = 0.0;
    std::vector<double> residuals, at_rest;
    std::vector<const double*> blocks, rest;
    const double zero[3] = {};
    for (int e = begin; e < end; ++e) {
      blocks.clear();
      for (const int vertex : surface_->control_vertices(e)) {
        blocks.push_back(displacements_.col(vertex).data());
      }
      residuals.resize(costs[e]->num_residuals());
      if (!costs[e]->Evaluate(blocks.data(), residuals.data(), nullptr)) {
        energy = std::numeric_limits<double>::infinity();
        break;
      }
      const Eigen::Map<Eigen::VectorXd> r(residuals.data(), residuals.size());
      if (initial_strains_.empty()) {
        energy += 0.5 * r.squaredNorm();
        continue;
      }
      // Beyond the energy of the initial stress, which is no work of the loads.
      rest.assign(blocks.size(), zero);
      at_rest.resize(residuals.size());
      CHECK(costs[e]->Evaluate(rest.data(), at_rest.data(), nullptr));
      const Eigen::Map<Eigen::VectorXd> r0(at_rest.data(), at_rest.size());
      energy += 0.5 * (r - r0).dot(r + r0);
    }
    energies[thread] = energy;
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

double ShellProblem::Energy(Effect effect) {
  problem();
  if (effect == Effect::kMembrane) return force_unit_ * StrainEnergyOf(strain_energies_[0]);
  if (effect == Effect::kBending) return force_unit_ * StrainEnergyOf(strain_energies_[1]);
  if (effect == Effect::kSupports) return force_unit_ * SupportEnergy();
  if (effect == Effect::kGas) {
    if (gas_ == nullptr) return 0.0;
    return UpdateGas() ? gas_->law.Energy(gas_->change) : std::numeric_limits<double>::infinity();
  }
  // Without what the multipliers' squares add.
  if (effect == Effect::kContact && grasp_ != nullptr) return force_unit_ * grasp_->Energy();
  const auto& blocks = blocks_[static_cast<int>(effect)];
  if (blocks.empty()) return 0.0;
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = blocks;
  double cost = 0.0;
  problem()->Evaluate(options, &cost, nullptr, nullptr, nullptr);
  return force_unit_ * cost;
}

Eigen::Matrix3Xd ShellProblem::EvaluateGradient(const std::vector<ceres::ResidualBlockId>* blocks) {
  ceres::Problem::EvaluateOptions options;
  options.num_threads = options_.num_threads;
  std::vector<int> vertices;
  for (int i = 0; i < displacements_.cols(); ++i) {
    double* block = displacements_.col(i).data();
    if (!surface_->IsActive(i)) continue;
    // The whole gradient has all blocks in the order they were added: naming them costs Ceres a
    // program of its own.
    if (blocks != nullptr) options.parameter_blocks.push_back(block);
    vertices.push_back(i);
  }
  if (blocks != nullptr) options.residual_blocks = *blocks;
  std::vector<double> gradient;
  double cost;
  problem()->Evaluate(options, &cost, nullptr, &gradient, nullptr);
  // Tangent components -> vectors; constant blocks have none.
  Eigen::Matrix3Xd result = Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  size_t next = 0;
  const Eigen::MatrixXd basis = unknown_basis();
  for (const int vertex : vertices) {
    if (!is_free_[vertex]) continue;
    result.col(vertex) = basis * Eigen::Map<const Eigen::VectorXd>(&gradient[next], basis.cols());
    next += basis.cols();
  }
  return force_unit_ * result;
}

Eigen::Matrix3Xd ShellProblem::Gradient() {
  UpdateGas();
  return EvaluateGradient(nullptr);
}

Eigen::Matrix3Xd ShellProblem::Gradient(Effect effect) {
  const bool dead = effect == Effect::kLoads && !options_.nonlinear;
  if (effect == Effect::kSupports || dead) {
    const Eigen::MatrixXd basis = unknown_basis();
    const Eigen::Matrix3d project = force_unit_ * basis * basis.transpose();
    Eigen::Matrix3Xd gradient = dead ? Eigen::Matrix3Xd(-force_) : SupportGradient();
    for (int i = 0; i < gradient.cols(); ++i) {
      gradient.col(i) =
          is_free_[i] ? Eigen::Vector3d(project * gradient.col(i)) : Eigen::Vector3d::Zero().eval();
    }
    return gradient;
  }
  const auto& blocks = blocks_[static_cast<int>(effect)];
  if (blocks.empty()) return Eigen::Matrix3Xd::Zero(3, displacements_.cols());
  return EvaluateGradient(&blocks);
}

Eigen::Vector3d ShellProblem::Reaction() {
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < conditions_.size(); ++i) {
    if (conditions_[i].stiffness == 0.0) continue;
    reaction -= force_unit_ *
                (conditions_[i].stiffness * Violation(conditions_[i]) + multipliers_[i]) *
                conditions_[i].direction;
  }
  for (size_t k = 0; k < mean_conditions_.size(); ++k) {
    reaction -= force_unit_ * MeanForce(k) * mean_conditions_[k].coefficients.rowwise().sum();
  }
  if (fixed_vertices_.empty()) return reaction;
  // What holds a fixed vertex is what all energies together leave unbalanced there.
  for (const int vertex : fixed_vertices_) {
    problem()->SetParameterBlockVariable(displacements_.col(vertex).data());
    is_free_[vertex] = 1;
  }
  const Eigen::Matrix3Xd gradient = Gradient();
  for (const int vertex : fixed_vertices_) {
    problem()->SetParameterBlockConstant(displacements_.col(vertex).data());
    is_free_[vertex] = 0;
    reaction += gradient.col(vertex);
  }
  return reaction;
}

double ShellProblem::LargestViolation(int* support) const {
  *support = -1;
  double largest = 0.0;
  for (const PlacedCondition& condition : conditions_) {
    if (condition.support < 0 || condition.stiffness == 0.0) continue;
    if (condition.direction.isZero(0.0)) continue;
    const double c = Violation(condition);
    if (std::abs(c) > largest) {
      largest = std::abs(c);
      *support = condition.support;
    }
  }
  const double size = displacements_.cwiseAbs().maxCoeff();
  return size > 0.0 ? largest / size : 0.0;
}

Eigen::Vector3d ShellProblem::AppliedForce() const {
  UpdateGas();
  Eigen::Vector3d force = load_factor_ * force_unit_ * dead_loads_.force.rowwise().sum();
  for (const auto& follower : followers_) {
    std::vector<const double*> blocks;
    for (const int vertex : surface_->control_vertices(follower.first)) {
      blocks.push_back(displacements_.col(vertex).data());
    }
    force += force_unit_ * follower.second->ExactForce(blocks.data()).rowwise().sum();
  }
  return force;
}

Eigen::Vector3d ShellProblem::Displacement(const ElementPoint& point) const {
  const Eigen::VectorXd weights = surface_->ValueWeights(point);
  const auto& vertices = surface_->control_vertices(point.element);
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < vertices.size(); ++i) {
    displacement += weights[i] * displacements_.col(vertices[i]);
  }
  return displacement;
}

}  // namespace darboux
