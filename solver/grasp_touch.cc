#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/first_touch.h"
#include "geometry/quadrature.h"
#include "solver/grasp.h"

// Where fingers touch the shell first, and the contact points that they can reach.

namespace darboux {
namespace {

// Of model.contact_spacing, and of all points that a finger does not come near.
constexpr double kSpacing = 0.3;
constexpr int kMostParts = 6;  // of an element's edge with that spacing

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

}  // namespace

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
    const ElementPoint at = surface.ClosestPoint(Eigen::Vector3d(finger.spec->position.data()));
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

}  // namespace darboux
