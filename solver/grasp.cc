#include "solver/grasp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace darboux {
namespace {

// Penalty of contact relative to the shell through its thickness, E/h. The multipliers take up what
// it lets in. Ten times as stiff, a ball between two spheres takes 35 iterations instead of 58, but
// one between two plates, whose contact points come and go, 403 instead of 58.
constexpr double kStiffness = 30.0;
// Penetration that may be left, in thicknesses; and the mean of all gaps in contact, weighted by
// pressure, in the last step to a load factor that is asked for: so much of a finger's travel
// depends on how its state was come by.
constexpr double kPenetration = 5e-4;
constexpr double kMeanGap = 1e-7;
// Slip below which a point sticks, in thicknesses.
constexpr double kStick = 2e-3;
// Change of the lagged normal forces, relative, that may be left.
constexpr double kFrictionChange = 1e-3;

}  // namespace

std::unique_ptr<Grasp> Grasp::Create(const Scene& scene,
                                     const ShellSurface& surface,
                                     const Material& material,
                                     double force_unit,
                                     double* displacements,
                                     std::string* error) {
  std::unique_ptr<Grasp> grasp(new Grasp());
  grasp->surface_ = &surface;
  grasp->displacements_ = displacements;
  const int size = 3 * surface.mesh().num_vertices;
  grasp->inflated_ = !Eigen::Map<const Eigen::VectorXd>(displacements, size).isZero(0.0);
  grasp->thickness_ = material.thickness;
  grasp->spacing_ = scene.model.contact_spacing;
  grasp->specs_ = scene.fingers;
  // How far a force drives a finger is not known before. No shell gives way by more than half its
  // size without touching itself.
  Eigen::AlignedBox3d bounds;
  for (const ElementPoint& at : surface.vertex_points()) bounds.extend(grasp->Position(at));
  const double half_size = 0.5 * bounds.sizes().maxCoeff();
  for (const FingerSpec& spec : grasp->specs_) {
    Finger finger;
    finger.spec = &spec;
    finger.travel = spec.travel;
    finger.reach = std::abs(spec.travel);
    if (spec.force) {
      finger.force = *spec.force / force_unit;
      finger.reach = half_size;
      finger.driven = grasp->num_driven();
      grasp->state_.travels.push_back(0.0);
    }
    ContactFinger& contact = finger.contact;
    contact.shape = MakeFinger(spec, &contact.pose, error);
    if (contact.shape == nullptr) return nullptr;
    contact.direction = Eigen::Vector3d(spec.direction.data());
    contact.offset = 0.5 * material.thickness;
    contact.stiffness = kStiffness * material.young_modulus / material.thickness;
    contact.friction = spec.friction;
    contact.stick_length = kStick * material.thickness;
    if (!grasp->FindTouch(surface, &finger, error)) return nullptr;
    contact.pose.position += finger.shift * contact.direction;
    grasp->fingers_.push_back(std::move(finger));
  }
  std::vector<Patch> patches;
  for (size_t f = 0; f < grasp->fingers_.size(); ++f) {
    grasp->AddPatches(surface, static_cast<int>(f), &patches);
  }
  // Blocks point into the state: it has its size before they are made.
  size_t num_points = 0;
  for (const Patch& patch : patches) num_points += patch.points->size();
  grasp->state_.multipliers.assign(num_points, 0.0);
  grasp->state_.friction.resize(num_points);
  int first = 0;
  for (const Patch& patch : patches) {
    const ContactFinger& finger = grasp->fingers_[patch.finger].contact;
    Block block;
    block.element = patch.element;
    block.finger = patch.finger;
    block.first = first;
    block.places = patch.places;
    const int driven = grasp->fingers_[patch.finger].driven;
    if (driven >= 0) block.travel = &grasp->state_.travels[driven];
    block.contact =
        new FingerContact(patch.points, &finger, &grasp->state_.multipliers[first], driven >= 0);
    if (finger.friction > 0.0) {
      block.friction =
          new Friction(patch.points, &finger, &grasp->state_.friction[first], driven >= 0);
    }
    first += patch.points->size();
    grasp->blocks_.push_back(block);
  }
  grasp->SetLoadFactor(0.0);
  for (Finger& finger : grasp->fingers_) finger.gap = std::numeric_limits<double>::infinity();
  for (const Block& block : grasp->blocks_) {
    double& gap = grasp->fingers_[block.finger].gap;
    for (const ContactState& state : grasp->States(block)) gap = std::min(gap, state.gap);
  }
  grasp->Advance();
  return grasp;
}

Grasp::~Grasp() {
  // A scene can be refused before its problem is built.
  if (handed_over_) return;
  for (const Block& block : blocks_) {
    delete block.contact;
    delete block.friction;
  }
}

void Grasp::AddTo(ceres::Problem* problem,
                  const std::function<double(double force)>& curvature_scale,
                  const std::function<void(ceres::ResidualBlockId, Part, int residuals)>& added) {
  handed_over_ = true;
  for (const Block& block : blocks_) {
    std::vector<double*> parameters;
    for (const int vertex : surface_->control_vertices(block.element)) {
      parameters.push_back(displacements_ + 3 * vertex);
    }
    if (block.travel != nullptr) parameters.push_back(block.travel);
    added(problem->AddResidualBlock(block.contact, nullptr, parameters),
          Part::kContact,
          block.contact->num_residuals());
    if (block.friction == nullptr) continue;
    added(problem->AddResidualBlock(block.friction, nullptr, parameters),
          Part::kFriction,
          block.friction->num_residuals());
  }
  for (const Finger& finger : fingers_) {
    if (finger.driven < 0) continue;
    auto* const force = new FingerForce(&finger.force_now, curvature_scale(finger.force));
    added(Potential::AddTo(problem, force, {&state_.travels[finger.driven]}), Part::kForce, 1);
  }
}

void Grasp::SetLoadFactor(double factor) {
  factor_ = factor;
  for (Finger& finger : fingers_) {
    finger.contact.translation = factor * finger.travel * finger.contact.direction;
    finger.force_now = factor * finger.force;
  }
}

std::vector<const double*> Grasp::Parameters(const Block& block) const {
  std::vector<const double*> blocks;
  for (const int vertex : surface_->control_vertices(block.element)) {
    blocks.push_back(displacements_ + 3 * vertex);
  }
  if (block.travel != nullptr) blocks.push_back(block.travel);
  return blocks;
}

std::vector<ContactState> Grasp::States(const Block& block) const {
  std::vector<ContactState> states;
  block.contact->States(Parameters(block).data(), &states);
  return states;
}

std::vector<FrictionState> Grasp::FrictionStates(const Block& block) const {
  if (block.friction == nullptr) return {};
  return block.friction->States(Parameters(block).data());
}

void Grasp::SetState(const State& state) {
  std::copy(state.multipliers.begin(), state.multipliers.end(), state_.multipliers.begin());
  std::copy(state.friction.begin(), state.friction.end(), state_.friction.begin());
  std::copy(state.travels.begin(), state.travels.end(), state_.travels.begin());
  SetPenalty(state.penalty);
}

bool Grasp::Update(bool fine, double stiffer) {
  std::vector<std::vector<ContactState>> all;
  double penetration = 0.0, change = 0.0, total = 0.0, virtual_gap = 0.0, pressure = 0.0;
  std::vector<char> touching;
  for (const Block& block : blocks_) {
    all.push_back(States(block));
    for (size_t q = 0; q < all.back().size(); ++q) {
      const ContactState& state = all.back()[q];
      penetration = std::max(penetration, -state.gap);
      const double force = state.force_on_finger.norm();
      touching.push_back(state.pressure > 0.0);
      virtual_gap += force * std::abs(state.gap);
      pressure += force;
      if (block.friction == nullptr) continue;
      change += std::abs(force - state_.friction[block.first + q].normal_force);
      total += force;
    }
  }
  double violation = penetration / (kPenetration * thickness_);
  if (fine && pressure > 0.0) {
    violation = std::max(violation, virtual_gap / (pressure * kMeanGap * thickness_));
  }
  const bool open = violation > 1.0;
  const bool unsettled = change > kFrictionChange * total;
  for (size_t b = 0; b < blocks_.size(); ++b) {
    for (size_t q = 0; open && q < all[b].size(); ++q) {
      state_.multipliers[blocks_[b].first + q] = all[b][q].pressure;
    }
    if (unsettled && blocks_[b].friction != nullptr) {
      darboux::LagFriction(all[b], &state_.friction[blocks_[b].first]);
    }
  }
  // Points share a load that the shell hardly tells apart: there an update changes little. Not
  // while points come and go: the stiffer, the more they do.
  constexpr double kSlow = 0.1, kStiffest = 1e4;
  if (open && violation > kSlow * violation_ && touching == touching_ &&
      state_.penalty < kStiffest) {
    SetPenalty(stiffer * state_.penalty);
  }
  touching_.swap(touching);
  violation_ = violation;
  return open || unsettled;
}

void Grasp::SetPenalty(double factor) {
  for (Finger& finger : fingers_) finger.contact.stiffness *= factor / state_.penalty;
  state_.penalty = factor;
}

void Grasp::Settle() {
  violation_ = std::numeric_limits<double>::infinity();
  if (state_.penalty == 1.0) return;
  std::vector<std::vector<ContactState>> all;
  for (const Block& block : blocks_) all.push_back(States(block));
  SetPenalty(1.0);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const double stiffness = fingers_[blocks_[b].finger].contact.stiffness;
    for (size_t q = 0; q < all[b].size(); ++q) {
      const ContactState& state = all[b][q];
      state_.multipliers[blocks_[b].first + q] =
          state.pressure > 0.0 ? state.pressure + stiffness * state.gap : 0.0;
    }
  }
}

void Grasp::LagFriction() {
  for (const Block& block : blocks_) {
    if (block.friction == nullptr) continue;
    darboux::LagFriction(States(block), &state_.friction[block.first]);
  }
}

std::vector<bool> Grasp::WithoutNormalForces() const {
  std::vector<bool> without(fingers_.size());
  for (size_t f = 0; f < fingers_.size(); ++f) without[f] = fingers_[f].contact.friction > 0.0;
  for (const Block& block : blocks_) {
    for (int q = 0; q < block.contact->points().size(); ++q) {
      if (state_.friction[block.first + q].normal_force > 0.0) without[block.finger] = false;
    }
  }
  return without;
}

bool Grasp::BeginFriction(const std::vector<NormalForce>& forces) {
  const std::vector<bool> without = WithoutNormalForces();
  bool begun = false;
  for (const NormalForce& force : forces) {
    const auto after = std::upper_bound(
        blocks_.begin(), blocks_.end(), force.point, [](int point, const Block& block) {
          return point < block.first;
        });
    if (!without[std::prev(after)->finger]) continue;
    state_.friction[force.point].normal_force = force.force;
    state_.friction[force.point].normal = force.normal;
    begun = true;
  }
  return begun;
}

void Grasp::SetStickFactor(double factor) {
  for (Finger& finger : fingers_) finger.contact.stick_length = factor * kStick * thickness_;
}

void Grasp::Advance() {
  for (const Block& block : blocks_) {
    if (block.friction == nullptr) continue;
    block.friction->AdvanceAnchors(Parameters(block).data(), &state_.friction[block.first]);
  }
}

double Grasp::LargestPenetration() const {
  double largest = 0.0;
  for (const Block& block : blocks_) {
    for (const ContactState& state : States(block)) largest = std::max(largest, -state.gap);
  }
  return largest;
}

std::vector<Grasp::ContactRow> Grasp::ContactRows(double reach) const {
  std::vector<ContactRow> rows;
  std::vector<ContactState> states;
  for (const Block& block : blocks_) {
    if (block.contact->with_travel()) continue;
    const ContactPoints& points = block.contact->points();
    const double stiffness = block.contact->finger().stiffness;
    if (!block.contact->States(Parameters(block).data(), &states, reach)) continue;
    for (int q = 0; q < points.size(); ++q) {
      const ContactState& state = states[q];
      if (state.normal.isZero(0.0)) continue;
      const double pressure = state_.multipliers[block.first + q] - stiffness * state.gap;
      const double scale = std::sqrt(stiffness * points.areas[q]);
      rows.push_back({&surface_->control_vertices(block.element),
                      scale * state.normal * points.weights.row(q),
                      std::sqrt(points.areas[q] / stiffness) * pressure,
                      block.first + q,
                      scale,
                      state.normal});
    }
  }
  return rows;
}

double Grasp::Energy() const {
  double total = 0.0;
  for (const Block& block : blocks_) {
    double energy = 0.0;
    block.contact->Energy(Parameters(block).data(), &energy);
    total += energy;
  }
  return total;
}

Eigen::Matrix3Xd Grasp::Force() const {
  Eigen::Matrix3Xd total = Eigen::Matrix3Xd::Zero(3, surface_->mesh().num_vertices);
  Eigen::Matrix3Xd part;
  for (const Block& block : blocks_) {
    const std::vector<int>& vertices = surface_->control_vertices(block.element);
    const auto add = [&](const FollowerForce& force) {
      if (!force.Linearise(Parameters(block).data(), &part, nullptr)) return;
      for (size_t i = 0; i < vertices.size(); ++i) total.col(vertices[i]) += part.col(i);
    };
    add(*block.contact);
    if (block.friction != nullptr) add(*block.friction);
  }
  return total;
}

void Grasp::Stiffen(double factor) {
  for (const Block& block : blocks_) {
    const double stiffness = factor * fingers_[block.finger].contact.stiffness;
    const std::vector<ContactState> states = States(block);
    for (size_t q = 0; q < states.size(); ++q) {
      const ContactState& state = states[q];
      state_.multipliers[block.first + q] =
          state.pressure > 0.0 ? state.pressure + stiffness * state.gap : 0.0;
    }
  }
  for (Finger& finger : fingers_) finger.contact.stiffness *= factor;
}

}  // namespace darboux
