#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "solver/grasp.h"

// Fingers that a force drives: their travels are unknowns.

namespace darboux {
namespace {

// Part of the step at which a finger could tunnel.
constexpr double kSafeStep = 0.6;

// The travel in one step that no point of the shell can be tunnelled through by.
double SafeTravel(const ContactFinger& finger, double thickness) {
  const double step = finger.shape->MaxStep() + finger.offset;
  // A half space cannot be tunnelled through; what it flattens in one step is bounded all the same.
  return kSafeStep * (std::isfinite(step) ? step : 4.0 * thickness);
}

}  // namespace

double Grasp::TravelOf(const Finger& finger) const {
  return finger.driven >= 0 ? state_.travels[finger.driven] : factor_ * finger.travel;
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

}  // namespace darboux
