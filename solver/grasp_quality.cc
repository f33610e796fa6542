#include "solver/grasp_quality.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "solver/equilibrium_response.h"

namespace darboux {
namespace {

constexpr double kPi = 3.14159265358979323846;
// The spring of a point contact, in E h: of the order of what a shell is against a point force, so
// that no digits are lost when it is taken away.
constexpr double kPoint = 0.1;

// own - forces^T K^-1 forces, see GraspStiffness. False where that is no number.
bool Condense(ShellProblem* problem,
              const TangentStiffness& tangent,
              SparseCholesky* cholesky,
              const Eigen::MatrixXd& forces,
              const Eigen::VectorXd& own,
              Eigen::MatrixXd* stiffness) {
  *stiffness = own.asDiagonal();
  for (Eigen::Index j = 0; j < own.size(); ++j) {
    if (forces.col(j).isZero(0.0)) continue;
    stiffness->col(j) -= forces.transpose() * Response(problem, tangent, cholesky, forces.col(j));
  }
  return stiffness->allFinite();
}

bool HasFriction(const Grasp& grasp) {
  return std::any_of(grasp.blocks().begin(), grasp.blocks().end(), [](const Grasp::Block& block) {
    return block.friction != nullptr;
  });
}

// Whether the work of the fingers is found nowhere but in strain and gas.
bool Conserves(const ShellProblem& problem) {
  const auto is_gas = [](const LoadSpec& load) { return load.kind == LoadSpec::Kind::kGas; };
  const auto is_still = [](const PlacedCondition& condition) { return condition.target == 0.0; };
  const std::vector<LoadSpec>& loads = problem.scene().loads;
  const std::vector<PlacedCondition>& conditions = problem.conditions();
  return !HasFriction(*problem.grasp()) && std::all_of(loads.begin(), loads.end(), is_gas) &&
         std::all_of(conditions.begin(), conditions.end(), is_still);
}

// What the forces of friction change by, on the vertices and on the fingers along their directions,
// where the shell moves by `response` and finger j by 1, because their normal forces and normals
// do.
void ChangeFriction(const ShellProblem& problem,
                    const Eigen::Matrix3Xd& response,
                    Eigen::Index j,
                    Eigen::Matrix3Xd* on_shell,
                    Eigen::VectorXd* on_fingers) {
  on_shell->setZero(3, response.cols());
  on_fingers->setZero();
  for (const Grasp::Block& block : problem.grasp()->blocks()) {
    if (block.friction == nullptr) continue;
    const std::vector<int>& vertices = problem.surface().control_vertices(block.element);
    const std::vector<ContactState> contact = problem.grasp()->States(block);
    const std::vector<FrictionState> friction = problem.grasp()->FrictionStates(block);
    const ContactFinger& finger = block.contact->finger();
    const ContactPoints& points = block.contact->points();
    for (size_t q = 0; q < contact.size(); ++q) {
      const double lagged = problem.grasp()->state().friction[block.first + q].normal_force;
      if (!(contact[q].pressure > 0.0) || !(lagged > 0.0)) continue;
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      if (block.finger == j) moved -= finger.direction;
      for (size_t i = 0; i < vertices.size(); ++i) {
        moved += points.weights(q, i) * response.col(vertices[i]);
      }
      const double harder = -finger.stiffness * points.areas[q] * contact[q].normal.dot(moved);
      // Slip stays across the normal of the finger, which turns as they move along one another.
      Distance distance;
      finger.PoseAt(block.travel != nullptr ? *block.travel : 0.0)
          .Evaluate(*finger.shape, contact[q].position, &distance);
      const Eigen::Vector3d turn = distance.hessian * moved;
      const Eigen::Vector3d& force = friction[q].force_on_finger;
      const Eigen::Vector3d change = harder / lagged * force - turn.dot(force) * contact[q].normal;
      (*on_fingers)[block.finger] -= change.dot(finger.direction);
      for (size_t i = 0; i < vertices.size(); ++i) {
        on_shell->col(vertices[i]) -= points.weights(q, i) * change;
      }
    }
  }
}

// Adds to a stiffness what comes of that, by a fixed point as the solver's; where it has none, a
// column stays as it is.
void FollowContact(ShellProblem* problem,
                   const TangentStiffness& tangent,
                   SparseCholesky* cholesky,
                   const Eigen::MatrixXd& forces,
                   Eigen::MatrixXd* stiffness) {
  constexpr int kMaxPasses = 40;
  constexpr double kSettled = 1e-6;
  Eigen::Matrix3Xd on_shell;
  Eigen::VectorXd on_fingers(forces.cols());
  for (Eigen::Index j = 0; j < forces.cols(); ++j) {
    if (forces.col(j).isZero(0.0)) continue;
    const Eigen::VectorXd first = Response(problem, tangent, cholesky, forces.col(j));
    Eigen::VectorXd response = first;
    double change = 1.0;
    for (int pass = 0; pass < kMaxPasses && change > kSettled; ++pass) {
      ChangeFriction(*problem, tangent.Expand(response), j, &on_shell, &on_fingers);
      const Eigen::VectorXd next =
          Response(problem, tangent, cholesky, forces.col(j) + tangent.Reduce(on_shell));
      change = (next - response).norm() / first.norm();
      response = next;
    }
    if (!(change <= kSettled)) continue;
    stiffness->col(j) += on_fingers - forces.transpose() * (response - first);
  }
}

}  // namespace

bool GraspStiffness(ShellProblem* problem,
                    TangentStiffness* tangent,
                    UpdatedCholesky* cholesky,
                    Eigen::MatrixXd* stiffness) {
  constexpr double kRigid = 1024.0;
  const RigidContact rigid(problem->grasp(), kRigid);
  std::vector<TravelDerivatives> by_travel;
  const Eigen::MatrixXd none(tangent->num_unknowns(), 0);
  if (!EvaluateTrueTangent(tangent) || !problem->grasp()->ByTravel(&by_travel) ||
      !FactorizeTangent(*problem, *tangent, none, 0.0, cholesky)) {
    return false;
  }
  const Eigen::Index n = static_cast<Eigen::Index>(by_travel.size());
  Eigen::MatrixXd forces(tangent->num_unknowns(), n);
  Eigen::VectorXd own(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    forces.col(i) = tangent->Reduce(by_travel[i].force);
    own[i] = by_travel[i].stiffness;
  }
  if (!Condense(problem, *tangent, cholesky, forces, own, stiffness)) return false;
  if (HasFriction(*problem->grasp())) {
    FollowContact(problem, *tangent, cholesky, forces, stiffness);
  }
  return stiffness->allFinite();
}

bool TouchStiffness(ShellProblem* problem,
                    TangentStiffness* tangent,
                    UpdatedCholesky* cholesky,
                    Eigen::MatrixXd* stiffness) {
  const ShellSurface& surface = problem->surface();
  const std::vector<FingerReport> fingers = problem->grasp()->Report(1.0);
  const Eigen::Index n = static_cast<Eigen::Index>(fingers.size());
  const double spring = kPoint * problem->scaled_material().MembraneStiffness();
  Eigen::MatrixXd rows(tangent->num_unknowns(), n);
  Eigen::VectorXd along(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ElementPoint at = surface.ClosestPoint(fingers[i].center_before);
    const StrainPoint point = surface.MakePoint(at);
    const std::vector<int>& vertices = surface.control_vertices(at.element);
    Eigen::Matrix3Xd row = Eigen::Matrix3Xd::Zero(3, surface.mesh().num_vertices);
    for (size_t k = 0; k < vertices.size(); ++k) {
      row.col(vertices[k]) += point.weights(kRowValue, k) * fingers[i].normal_before;
    }
    rows.col(i) = tangent->Reduce(row);
    const std::array<double, 3>& way = problem->scene().fingers[i].direction;
    along[i] = fingers[i].normal_before.dot(Eigen::Vector3d(way[0], way[1], way[2]));
  }
  if (!EvaluateTrueTangent(tangent) ||
      !FactorizeTangent(*problem, *tangent, rows, spring, cholesky)) {
    return false;
  }
  // With springs s between the fingers and the shell their displacements under unit forces are G =
  // c^T (K + s c c^T)^-1 c, and without the give of the springs the forces are G^-1 - s, also where
  // K alone is singular.
  Eigen::MatrixXd give(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    give.col(j) = rows.transpose() * Response(problem, *tangent, cholesky, rows.col(j));
  }
  *stiffness = give.fullPivLu().inverse();
  stiffness->diagonal().array() -= spring;
  *stiffness = along.asDiagonal() * *stiffness * along.asDiagonal();
  return stiffness->allFinite();
}

GraspQuality::GraspQuality(ShellProblem* problem, SparseBackend backend)
    : problem_(problem),
      integrates_(!Conserves(*problem)),
      cholesky_(std::make_unique<UpdatedCholesky>(SparseCholesky::Create(backend))) {
  center_before_ = Centroid(false);
  for (const ElementPoint& at : problem->surface().vertex_points()) {
    length_ = std::max(length_, (problem->surface().Position(at) - center_before_).norm());
  }
  last_.travel = last_.force = Eigen::VectorXd::Zero(problem->scene().fingers.size());
}

Eigen::Vector3d GraspQuality::Centroid(bool deformed) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (int e = 0; e < problem_->surface().num_elements(); ++e) {
    const std::vector<int>& vertices = problem_->surface().control_vertices(e);
    for (const StrainPoint& point : *problem_->strain_points()[e]) {
      Eigen::Vector3d x = point.position;
      for (size_t i = 0; deformed && i < vertices.size(); ++i) {
        x += point.weights(kRowValue, i) * problem_->displacements().col(vertices[i]);
      }
      sum += point.area * x;
      area += point.area;
    }
  }
  return sum / area;
}

void GraspQuality::Record(TangentStiffness* tangent, bool is_result) {
  if (!integrates_ && !is_result && problem_->load_factor() != 0.0) return;
  const bool is_again =
      last_.displacements.size() > 0 && last_.displacements == problem_->displacements();
  if (is_again && (last_.has_stiffness || !is_result)) return;
  Sample now;
  now.displacements = problem_->displacements();
  const std::vector<FingerReport> fingers = problem_->grasp()->Report(1.0);
  const Eigen::Index n = static_cast<Eigen::Index>(fingers.size());
  std::vector<TravelDerivatives> by_travel;
  if (!problem_->grasp()->ByTravel(&by_travel)) return;
  now.travel.resize(n);
  now.force.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    now.travel[i] = fingers[i].travel;
    now.force[i] = by_travel[i].energy;
  }
  now.begins = problem_->load_factor() == 0.0 || (is_again && last_.begins);
  if (last_.displacements.size() == 0) cholesky_->Analyze(tangent->matrix());
  const auto stiffness = now.begins && now.force.isZero(0.0) ? TouchStiffness : GraspStiffness;
  now.has_stiffness = integrates_ || is_result;
  if (now.has_stiffness && !stiffness(problem_, tangent, cholesky_.get(), &now.stiffness)) {
    now.stiffness.resize(0, 0);
  }
  if (now.begins) {
    work_ = 0.0;
    energy_before_ = 0.0;
    for (const Effect effect : {Effect::kMembrane, Effect::kBending, Effect::kGas}) {
      energy_before_ += problem_->Energy(effect);
    }
  } else if (integrates_) {
    const Eigen::VectorXd way = now.travel - last_.travel;
    const auto slopes = [&](const Sample& sample) {
      return sample.stiffness.size() > 0 ? Eigen::VectorXd(sample.stiffness * way)
                                         : Eigen::VectorXd::Zero(n);
    };
    const Eigen::VectorXd slope_before = slopes(last_), slope = slopes(now);
    for (Eigen::Index i = 0; i < n; ++i) {
      const bool slope_known = now.stiffness.size() > 0 && now.force[i] != 0.0;
      // The part of the way on which it touches.
      double part = 1.0;
      if (last_.begins && last_.force[i] == 0.0 && way[i] > 0.0) {
        part = std::max(0.0, 1.0 - fingers[i].gap / way[i]);
      }
      double mean = 0.5 * (last_.force[i] + now.force[i]);
      if (slope_known && (last_.force[i] != 0.0 || last_.begins) && last_.stiffness.size() > 0) {
        mean += part * (slope_before[i] - slope[i]) / 12.0;
      } else if (slope_known && last_.force[i] == 0.0) {
        mean = 2.0 / 3.0 * now.force[i] - part * slope[i] / 6.0;
      }
      work_ += mean * part * way[i];
    }
  }
  last_ = std::move(now);
}

GraspReport GraspQuality::Report(const std::vector<FingerReport>& fingers,
                                 double energy,
                                 bool with_stiffness) const {
  GraspReport report;
  if (with_stiffness) report.stiffness = problem_->force_unit() * last_.stiffness;
  report.stored_energy = energy - energy_before_;
  report.squeeze_work = integrates_ ? problem_->force_unit() * work_ : report.stored_energy;
  report.center_before = center_before_;
  report.center = Centroid(true);
  report.length = length_;
  for (size_t i = 0; i < fingers.size(); ++i) {
    const FingerReport& finger = fingers[i];
    const FingerSpec& spec = problem_->scene().fingers[i];
    const bool pin = spec.shape == FingerSpec::Shape::kPin;
    report.before.push_back({finger.center_before,
                             finger.normal_before,
                             spec.friction,
                             pin ? 0.0 : 2.0 / 3.0 * std::sqrt(finger.contact_area / kPi)});
    if (finger.contact_points == 0) continue;
    report.after.push_back({finger.center, finger.normal, spec.friction, finger.spin_arm});
  }
  report.closure_before = EvaluateForceClosure(report.before, center_before_, length_);
  report.closure_after = EvaluateForceClosure(report.after, report.center, length_);
  return report;
}

}  // namespace darboux
