#include "solver/grasp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "geometry/first_touch.h"
#include "geometry/mesh_finger.h"
#include "geometry/quadrature.h"

namespace darboux {
namespace {

// For messages, in any unit.
std::string Short(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

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
// Of model.contact_spacing, and of all points that a finger does not come near.
constexpr double kSpacing = 0.3;
constexpr int kMostParts = 6;  // of an element's edge with that spacing
// Part of the step at which a finger could tunnel.
constexpr double kSafeStep = 0.6;

Eigen::Vector3d Vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

std::shared_ptr<const FingerShape> MakeShape(const FingerSpec& spec, std::string* error) {
  switch (spec.shape) {
    case FingerSpec::Shape::kPin:  // Pushes one point along its direction, whatever lies beside it.
    case FingerSpec::Shape::kPlane:
      return MakePlaneFinger();
    case FingerSpec::Shape::kSphere:
      return MakeSphereFinger(spec.radius);
    case FingerSpec::Shape::kCapsule:
      return MakeCapsuleFinger(spec.radius, spec.length);
    case FingerSpec::Shape::kBox:
      return MakeBoxFinger(Vector(spec.half_sizes), spec.rounding);
    case FingerSpec::Shape::kMesh:
      return MakeMeshFinger(*spec.mesh, error);
  }
  return nullptr;
}

// The shape's frame: planes and boxes have z along the direction, capsules along their axis, boxes
// x along it as far as that goes; a mesh keeps the axes of the scene.
Eigen::Matrix3d Rotation(const FingerSpec& spec) {
  if (spec.shape == FingerSpec::Shape::kMesh) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = Vector(spec.axis);
  const Eigen::Vector3d z =
      spec.shape == FingerSpec::Shape::kCapsule ? axis : Vector(spec.direction);
  Eigen::Vector3d x = spec.shape == FingerSpec::Shape::kBox ? axis : Eigen::Vector3d::Zero();
  x -= z * z.dot(x);
  if (x.norm() < 1e-9) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return rotation;
}

// Points of a triangle rule on each of parts^2 triangles of an element.
std::vector<TrianglePoint> SubdividedRule(int parts) {
  std::vector<TrianglePoint> points;
  const double size = 1.0 / parts;
  for (int j = 0; j < parts; ++j) {
    for (int i = 0; i + j < parts; ++i) {
      for (const TrianglePoint& p : TriangleQuadrature(3)) {
        points.push_back({(i + p.s) * size, (j + p.t) * size, p.weight * size * size});
        if (i + j + 1 < parts) {  // the triangle that points the other way
          points.push_back({(i + 1 - p.s) * size, (j + 1 - p.t) * size, p.weight * size * size});
        }
      }
    }
  }
  return points;
}

// The travel in one step that no point of the shell can be tunnelled through by.
double SafeTravel(const ContactFinger& finger, double thickness) {
  const double step = finger.shape->MaxStep() + finger.offset;
  // A half space cannot be tunnelled through; what it flattens in one step is bounded all the same.
  return kSafeStep * (std::isfinite(step) ? step : 4.0 * thickness);
}

}  // namespace

std::shared_ptr<const FingerShape> MakeFinger(const FingerSpec& spec,
                                              FingerPose* pose,
                                              std::string* error) {
  std::shared_ptr<const FingerShape> shape = MakeShape(spec, error);
  if (shape == nullptr) {
    *error = spec.location.file + ":" + std::to_string(spec.location.line) + ": " +
             spec.location.key + ": found " + *error + "; allowed is a closed mesh";
    return nullptr;
  }
  *pose = {Vector(spec.position), Rotation(spec)};
  return shape;
}

Eigen::Vector3d Grasp::Position(const ElementPoint& at) const {
  Eigen::Vector3d x = surface_->Position(at);
  if (!inflated_) return x;
  const std::vector<int>& vertices = surface_->control_vertices(at.element);
  const Eigen::VectorXd weights = surface_->ValueWeights(at);
  for (size_t i = 0; i < vertices.size(); ++i) {
    x += weights[i] * Eigen::Map<const Eigen::Vector3d>(displacements_ + 3 * vertices[i]);
  }
  return x;
}

Eigen::Vector3d Grasp::Normal(const ElementPoint& at) const {
  const StrainPoint point = surface_->MakePoint(at);
  if (!inflated_) return point.n;
  const std::vector<int>& vertices = surface_->control_vertices(at.element);
  Eigen::Vector3d x1 = point.t1, x2 = point.t2;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> u(displacements_ + 3 * vertices[i]);
    x1 += point.weights(kRowD1, i) * u;
    x2 += point.weights(kRowD2, i) * u;
  }
  return x1.cross(x2).normalized();
}

double Grasp::ElementSize(int element) const {
  const Eigen::Vector3d a = Position({element, 0.0, 0.0});
  const Eigen::Vector3d b = Position({element, 1.0, 0.0});
  const Eigen::Vector3d c = Position({element, 0.0, 1.0});
  return std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
}

std::vector<const double*> Grasp::Parameters(const Block& block) const {
  std::vector<const double*> blocks;
  for (const int vertex : surface_->control_vertices(block.element)) {
    blocks.push_back(displacements_ + 3 * vertex);
  }
  if (block.travel != nullptr) blocks.push_back(block.travel);
  return blocks;
}

double Grasp::TravelOf(const Finger& finger) const {
  return finger.driven >= 0 ? state_.travels[finger.driven] : factor_ * finger.travel;
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

bool Grasp::FindTouch(const ShellSurface& surface, Finger* finger, std::string* error) const {
  ContactFinger& contact = finger->contact;
  std::vector<Eigen::Vector3d> points;
  std::vector<ElementPoint> places = surface.vertex_points();
  for (int e = 0; e < surface.num_elements(); ++e) places.push_back({e, 1.0 / 3.0, 1.0 / 3.0});
  // On a coarse mesh none of these need be in the finger's way.
  if (std::isfinite(contact.shape->MaxStep())) {
    places.push_back(surface.ClosestPoint(contact.pose.position));
  }
  for (const ElementPoint& at : places) points.push_back(Position(at));
  Touch touch;
  // A pin pushes the point nearest to it.
  if (finger->spec->shape == FingerSpec::Shape::kPin) {
    const ElementPoint at = surface.ClosestPoint(contact.pose.position);
    const Eigen::Vector3d x = Position(at);
    finger->shift = (x - contact.pose.position).dot(contact.direction) - contact.offset;
    finger->touch = x;
    finger->touched = at;
    const Eigen::Vector3d n = Normal(at);
    finger->normal_before = n.dot(contact.direction) > 0.0 ? n : Eigen::Vector3d(-n);
    return true;
  }
  // A finger smaller than the elements would pass between their vertices and centres.
  const Ball ball = contact.pose.Bounds(*contact.shape);
  const double reach = ball.radius + contact.offset;
  for (int e = 0; e < surface.num_elements() && std::isfinite(reach); ++e) {
    const double size = ElementSize(e);
    const Eigen::Vector3d arm = Position({e, 1.0 / 3.0, 1.0 / 3.0}) - ball.center;
    if (size <= reach || arm.cross(contact.direction).norm() > size + reach) continue;
    constexpr double kParts = 3.0, kMost = 64.0;
    const int parts = static_cast<int>(std::min(std::ceil(kParts * size / reach), kMost));
    for (int j = 0; j <= parts; ++j) {
      for (int i = 0; i + j <= parts; ++i) {
        places.push_back({e, i / (1.0 * parts), j / (1.0 * parts)});
        points.push_back(Position(places.back()));
      }
    }
  }
  // Where it touches first, then once more between ever nearer points there.
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (!FirstTouch(
            *contact.shape, contact.pose, contact.direction, points, contact.offset, &touch)) {
      const SceneLocation& where = finger->spec->location;
      *error = where.file + ":" + std::to_string(where.line) + ": " + where.key +
               ": found a finger that never touches the shell along its direction; allowed is a "
               "position and direction that lead to the shell";
      return false;
    }
    if (pass + 1 == kPasses) break;
    const ElementPoint near = places[touch.point];
    const Eigen::Vector3d x = points[touch.point];
    if (pass == 0) {
      const double size = ElementSize(near.element);
      constexpr int kParts = 12;
      for (int e = 0; e < surface.num_elements(); ++e) {
        const double larger = std::max(size, ElementSize(e));
        if ((Position({e, 1.0 / 3.0, 1.0 / 3.0}) - x).norm() > 1.5 * larger) continue;
        for (int j = 0; j <= kParts; ++j) {
          for (int i = 0; i + j <= kParts; ++i) {
            places.push_back({e, i / (1.0 * kParts), j / (1.0 * kParts)});
          }
        }
      }
    } else {
      constexpr int kParts = 10;
      for (int j = -kParts; j <= kParts; ++j) {
        for (int i = -kParts; i <= kParts; ++i) {
          const double s = near.s + i / 120.0, t = near.t + j / 120.0;
          if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) places.push_back({near.element, s, t});
        }
      }
    }
    for (size_t k = points.size(); k < places.size(); ++k) {
      points.push_back(Position(places[k]));
    }
  }
  finger->shift = touch.shift;
  finger->touch = points[touch.point];
  finger->touched = places[touch.point];
  const Eigen::Vector3d n = Normal(places[touch.point]);
  finger->normal_before = n.dot(contact.direction) > 0.0 ? n : Eigen::Vector3d(-n);
  return true;
}

// The parts of the shell that a finger can reach, each with its contact points.
void Grasp::AddPatches(const ShellSurface& surface, int index, std::vector<Patch>* patches) const {
  const Finger& finger = fingers_[index];
  const ContactFinger& contact = finger.contact;
  const auto add =
      [&](int element, const std::vector<StrainPoint>& points, std::vector<ElementPoint> places) {
        patches->push_back({element,
                            index,
                            std::make_shared<const ContactPoints>(ContactPoints::From(points)),
                            std::move(places)});
      };
  if (finger.spec->shape == FingerSpec::Shape::kPin) {
    const ElementPoint at = surface.ClosestPoint(Vector(finger.spec->position));
    StrainPoint point = surface.MakePoint(at);
    const double size = ElementSize(at.element);
    point.area = 0.5 * size * size;
    add(at.element, {point}, {at});
    return;
  }
  // Elements on the finger's way, with what the other fingers may push towards it.
  double margin = 0.0;
  for (const Finger& other : fingers_) margin += other.reach;
  const double radius = contact.shape->MaxStep() + contact.offset;
  constexpr int kSamples = 8;
  for (int e = 0; e < surface.num_elements(); ++e) {
    const Eigen::Vector3d x = Position({e, 1.0 / 3.0, 1.0 / 3.0});
    const double size = ElementSize(e);
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= kSamples; ++k) {
      FingerPose pose = contact.pose;
      pose.position += contact.direction * (finger.reach * k / kSamples);
      Distance distance;
      pose.Evaluate(*contact.shape, x, &distance);
      nearest = std::min(nearest, distance.value - contact.offset);
    }
    const double way = finger.reach / (2.0 * kSamples);
    if (nearest > size + way + margin) continue;
    int parts = 3;
    if (std::isfinite(radius)) {
      const bool is_met = nearest < size / std::sqrt(3.0) + way + 0.5 * radius;
      const double spacing = is_met ? spacing_ : std::max(kSpacing, spacing_);
      const int most = static_cast<int>(std::ceil(kMostParts * std::max(1.0, kSpacing / spacing)));
      parts = std::clamp(static_cast<int>(std::ceil(size / (spacing * radius))), 1, most);
      // Where only a motion of the whole shell would lead.
      if (nearest > size + way + radius) parts = std::min(parts, 2);
    }
    std::vector<StrainPoint> points;
    std::vector<ElementPoint> places;
    for (const TrianglePoint& p : SubdividedRule(parts)) {
      places.push_back({e, p.s, p.t});
      points.push_back(surface.MakePoint(places.back(), p.weight));
    }
    add(e, points, std::move(places));
  }
}

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
    contact.direction = Vector(spec.direction);
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

bool Grasp::Resistance(int finger, double* force, double* stiffness, double* distance) const {
  *force = *stiffness = 0.0;
  *distance = std::numeric_limits<double>::infinity();
  TravelDerivatives by_travel;
  for (const Block& block : blocks_) {
    if (block.finger != finger) continue;
    const std::vector<const double*> parameters = Parameters(block);
    if (!block.contact->LineariseTravel(parameters.data(), &by_travel)) return false;
    const bool touches = by_travel.stiffness != 0.0;
    *force += by_travel.energy;
    *stiffness += by_travel.stiffness;
    if (block.friction != nullptr) {
      if (!block.friction->LineariseTravel(parameters.data(), &by_travel)) return false;
      *force += by_travel.energy;
      *stiffness += by_travel.stiffness;
    }
    if (touches) {
      *distance = 0.0;
    } else if (*distance > 0.0) {
      for (const ContactState& state : States(block)) *distance = std::min(*distance, state.gap);
    }
  }
  return true;
}

bool Grasp::Close(std::string* error) {
  if (!has_unknown_travels()) return true;
  for (size_t f = 0; f < fingers_.size(); ++f) {
    const Finger& finger = fingers_[f];
    if (finger.driven < 0 || finger.force_now == 0.0) continue;
    double& travel = state_.travels[finger.driven];
    // The resistance grows with the travel, faster and faster as more points touch: Newton's method
    // overshoots once and then comes from above.
    constexpr int kMaxSteps = 200;
    constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    bool found = false;
    for (int step = 0; step < kMaxSteps && !found; ++step) {
      double force, stiffness, distance;
      if (!Resistance(static_cast<int>(f), &force, &stiffness, &distance)) break;
      (force < finger.force_now ? low : high) = travel;
      double change = 0.01 * thickness_;
      if (distance > 0.0) {
        // Nothing touches: no way to the shell is shorter than the distance.
        if (std::isfinite(distance)) change = std::max(change, distance);
      } else {
        change = std::clamp((finger.force_now - force) / stiffness, -thickness_, thickness_);
      }
      const double next = travel + change;
      const double width = kRounding * finger.reach;
      found = std::abs(force - finger.force_now) <= kRounding * finger.force_now ||
              (distance == 0.0 && std::abs(change) <= width) || high - low <= width;
      if (found) break;
      travel = next > low && next < high ? next : 0.5 * (low + high);
      if (std::abs(travel) > finger.reach) break;
    }
    if (!found) {
      *error = "finger " + finger.spec->name + " finds no shell to press with its force against";
      return false;
    }
  }
  return true;
}

bool Grasp::LineariseTravels(std::vector<Travel>* travels) const {
  travels->assign(has_unknown_travels() ? num_driven() : 0, Travel());
  if (travels->empty()) return true;
  for (const Finger& finger : fingers_) {
    if (finger.driven < 0) continue;
    Travel& travel = (*travels)[finger.driven];
    travel.imbalance = -finger.force_now;
    travel.coupling = Eigen::Matrix3Xd::Zero(3, surface_->mesh().num_vertices);
  }
  TravelDerivatives by_travel;
  for (const Block& block : blocks_) {
    if (block.travel == nullptr) continue;
    Travel& travel = (*travels)[fingers_[block.finger].driven];
    const std::vector<int>& vertices = surface_->control_vertices(block.element);
    const std::vector<const double*> parameters = Parameters(block);
    const auto add = [&](const auto& part) {
      if (!part.LineariseTravel(parameters.data(), &by_travel)) return false;
      if (by_travel.stiffness == 0.0) return true;
      travel.imbalance += by_travel.energy;
      travel.stiffness += by_travel.stiffness;
      for (size_t i = 0; i < vertices.size(); ++i) {
        travel.coupling.col(vertices[i]) -= by_travel.force.col(i);
      }
      return true;
    };
    if (!add(*block.contact)) return false;
    if (block.friction != nullptr && !add(*block.friction)) return false;
  }
  return true;
}

double Grasp::SafePart(const Eigen::VectorXd& changes) const {
  double part = 1.0;
  for (const Finger& finger : fingers_) {
    if (finger.driven < 0 || finger.driven >= changes.size()) continue;
    const double change = std::abs(changes[finger.driven]);
    const double safe = SafeTravel(finger.contact, thickness_);
    if (change > safe) part = std::min(part, safe / change);
  }
  return part;
}

Eigen::VectorXd Grasp::DrivingForces() const {
  Eigen::VectorXd forces(num_driven());
  for (const Finger& finger : fingers_) {
    if (finger.driven >= 0) forces[finger.driven] = finger.force;
  }
  return forces;
}

bool Grasp::CheckBalance(const std::function<bool(const Eigen::Vector3d& direction)>& is_free,
                         const Eigen::Vector3d& dead_force,
                         std::string* error) const {
  if (num_driven() == 0 || num_driven() < static_cast<int>(fingers_.size())) return true;
  const Eigen::Vector3d line = fingers_.front().contact.direction;
  double sum = dead_force.dot(line), size = std::abs(sum);
  constexpr double kParallel = 1e-9, kBalance = 1e-9;
  for (const Finger& finger : fingers_) {
    if (finger.contact.direction.cross(line).norm() > kParallel) return true;
    sum += finger.force * finger.contact.direction.dot(line);
    size += finger.force;
  }
  if (std::abs(sum) <= kBalance * size || !is_free(line)) return true;
  const SceneLocation& where = fingers_.back().spec->location;
  std::ostringstream text;
  text
      << where.file << ":" << where.line << ": " << where.key
      << ": found forces that drive all the fingers along one line and do not balance, by "
      << std::abs(sum) / size
      << " of their sum; allowed are forces in balance, a support along that line or a finger with "
         "a travel";
  *error = text.str();
  return false;
}

double Grasp::Imbalance() const {
  std::vector<Travel> travels;
  if (!LineariseTravels(&travels)) return std::numeric_limits<double>::infinity();
  double squares = 0.0;
  for (const Travel& travel : travels) squares += travel.imbalance * travel.imbalance;
  return std::sqrt(squares);
}

double Grasp::LargestStep() const {
  double largest = std::numeric_limits<double>::infinity();
  for (const Finger& finger : fingers_) {
    if (finger.travel == 0.0) continue;
    largest = std::min(largest, SafeTravel(finger.contact, thickness_) / std::abs(finger.travel));
  }
  return largest;
}

void Grasp::SetState(const State& state) {
  std::copy(state.multipliers.begin(), state.multipliers.end(), state_.multipliers.begin());
  std::copy(state.friction.begin(), state.friction.end(), state_.friction.begin());
  std::copy(state.travels.begin(), state.travels.end(), state_.travels.begin());
  SetPenalty(state.penalty);
}

bool Grasp::Update(bool fine) {
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
  const double stiffer = fine ? 100.0 : 10.0;
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

std::string Grasp::Fault() const {
  for (const FingerReport& report : Report(1.0)) {
    if (report.travel == 0.0) continue;
    const auto same = [&](const Finger& finger) { return finger.spec->name == report.name; };
    const Finger& finger = *std::find_if(fingers_.begin(), fingers_.end(), same);
    if (report.contact_points == 0) {
      // Contact points lie beside the place that it touched first.
      constexpr double kAllowance = 2.0;
      if (std::abs(report.travel) <= kAllowance * std::max(0.0, finger.gap)) continue;
      return "finger " + report.name + " has travelled " + Short(report.travel) +
             " without touching the shell";
    }
    const double sign = report.travel > 0.0 ? 1.0 : -1.0;
    if (sign * report.normal.dot(finger.contact.direction) <= 0.0) {
      return "finger " + report.name + " has come through the shell";
    }
  }
  return "";
}

std::string Grasp::FaultAtTheEnd() const {
  for (const FingerReport& report : Report(1.0)) {
    if (report.travel == 0.0 || report.contact_points > 0) continue;
    return "finger " + report.name + " has travelled " + Short(report.travel) +
           " without any contact: the contact points nearest to where it touches lie " +
           Short(report.gap) + " off its way; finer elements or more travel";
  }
  return "";
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

bool Grasp::ByTravel(std::vector<TravelDerivatives>* by_travel) const {
  by_travel->assign(fingers_.size(), TravelDerivatives());
  for (TravelDerivatives& finger : *by_travel) {
    finger.force.setZero(3, surface_->mesh().num_vertices);
  }
  TravelDerivatives part;
  for (const Block& block : blocks_) {
    const std::vector<const double*> parameters = Parameters(block);
    const std::vector<int>& vertices = surface_->control_vertices(block.element);
    TravelDerivatives& finger = (*by_travel)[block.finger];
    const auto add = [&](const auto& effect) {
      if (!effect.LineariseTravel(parameters.data(), &part)) return false;
      finger.energy += part.energy;
      finger.stiffness += part.stiffness;
      for (size_t i = 0; i < vertices.size(); ++i)
        finger.force.col(vertices[i]) += part.force.col(i);
      return true;
    };
    if (!add(*block.contact) || (block.friction != nullptr && !add(*block.friction))) return false;
  }
  return true;
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

std::vector<FingerReport> Grasp::Report(double force_unit) const {
  std::vector<FingerReport> reports(fingers_.size());
  for (size_t f = 0; f < fingers_.size(); ++f) {
    reports[f].name = fingers_[f].spec->name;
    reports[f].travel = TravelOf(fingers_[f]);
    reports[f].by_force = fingers_[f].driven >= 0;
    reports[f].shift = fingers_[f].shift;
    const Finger& finger = fingers_[f];
    const std::vector<int>& vertices = surface_->control_vertices(finger.touched.element);
    const Eigen::VectorXd weights = surface_->ValueWeights(finger.touched);
    Eigen::Vector3d moved = surface_->Position(finger.touched) - finger.touch;
    for (size_t i = 0; i < vertices.size(); ++i) {
      moved += weights[i] * Eigen::Map<const Eigen::Vector3d>(displacements_ + 3 * vertices[i]);
    }
    reports[f].indentation = moved.dot(finger.contact.direction);
    reports[f].gap = std::max(0.0, fingers_[f].gap);
    reports[f].center_before = fingers_[f].touch;
    reports[f].touched = fingers_[f].touched;
    reports[f].normal_before = fingers_[f].normal_before;
  }
  struct Pressed {
    int finger;
    double force, area;
    Eigen::Vector3d position;
  };
  std::vector<Pressed> pressed;
  for (const Block& block : blocks_) {
    FingerReport& report = reports[block.finger];
    const std::vector<ContactState> states = States(block);
    std::vector<FrictionState> friction;
    if (block.friction != nullptr) {
      friction = block.friction->States(Parameters(block).data());
    }
    for (size_t q = 0; q < states.size(); ++q) {
      const ContactState& state = states[q];
      report.penetration = std::max(report.penetration, -state.gap);
      if (!(state.pressure > 0.0)) continue;
      const double force = state.force_on_finger.norm();
      ++report.contact_points;
      report.force += force_unit * state.force_on_finger;
      report.normal_force += force_unit * force;
      report.normal += force * state.normal;
      report.center += force * state.position;
      report.contact_area += block.contact->points().areas[q];
      // The area of a pin's point is made up.
      const bool pin = specs_[block.finger].shape == FingerSpec::Shape::kPin;
      pressed.push_back({block.finger,
                         force_unit * force,
                         pin ? 0.0 : block.contact->points().areas[q],
                         state.position});
      report.largest_pressure = std::max(report.largest_pressure, force_unit * state.pressure);
      if (friction.empty()) continue;
      report.force += force_unit * friction[q].force_on_finger;
      ++(friction[q].sticks ? report.sticking : report.slipping);
    }
  }
  for (FingerReport& report : reports) {
    if (report.contact_points == 0) continue;
    report.center *= force_unit / report.normal_force;
    report.normal.normalize();
  }
  // The friction of even pressure on a disc has 2/3 of the radius as its arm.
  constexpr double kDisc = 4.0 / (9.0 * 3.14159265358979323846);
  for (const Pressed& point : pressed) {
    FingerReport& report = reports[point.finger];
    const Eigen::Vector3d way = point.position - report.center;
    const double across = (way - report.normal * report.normal.dot(way)).squaredNorm();
    report.spin_arm += point.force / report.normal_force * std::sqrt(across + kDisc * point.area);
  }
  return reports;
}

std::vector<ContactPointReport> Grasp::ReportPoints(double force_unit) const {
  std::vector<ContactPointReport> reports;
  for (const Block& block : blocks_) {
    const std::vector<ContactState> states = States(block);
    const std::vector<FrictionState> friction = FrictionStates(block);
    for (size_t q = 0; q < states.size(); ++q) {
      const ContactState& state = states[q];
      if (!(state.pressure > 0.0)) continue;
      ContactPointReport report;
      report.finger = block.finger;
      report.element = block.element;
      report.at = block.places[q];
      report.position = state.position;
      report.normal = state.normal;
      report.gap = state.gap;
      report.pressure = force_unit * state.pressure;
      report.area = block.contact->points().areas[q];
      if (!friction.empty()) {
        report.friction = force_unit * friction[q].force_on_finger;
        report.sticks = friction[q].sticks;
      }
      reports.push_back(report);
    }
  }
  return reports;
}

}  // namespace darboux
