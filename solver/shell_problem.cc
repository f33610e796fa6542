#include "solver/shell_problem.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "costs/strain_derivatives.h"
#include "solver/magnitudes.h"
#include "solver/mesh_surface.h"
#include "solver/parallel_for.h"
#include "solver/plane_basis.h"

namespace darboux {
namespace {

// Below this, relative to the natural scale, a quantity is rounding.
constexpr double kRounding = 1e-11;

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
