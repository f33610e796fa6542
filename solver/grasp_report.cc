#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "solver/grasp.h"

// What fingers do to the shell in the present state, in numbers and in words.

namespace darboux {
namespace {

// For messages, in any unit.
std::string Short(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

}  // namespace

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
