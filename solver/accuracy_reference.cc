#include "solver/accuracy_reference.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>

namespace darboux {
namespace {

constexpr double kLeastOrder = 0.5, kMostOrder = 5.0;
// Of the distance between the finest value and the limit.
constexpr double kDoubt = 1.0 / 3.0;
constexpr double kStill = 1e-4;  // as solver/accuracy.h

bool StartsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

// Roots of the results that are physics, and names within them that are none.
bool MeasuresAccuracy(const std::string& path) {
  static const char* const kRoots[] = {"probes.",
                                       "fingers.",
                                       "energy.",
                                       "gas.",
                                       "supports.",
                                       "load_steps[",
                                       "limit_points[",
                                       "max_",
                                       "grasp."};
  static const char* const kOthers[] = {"iterations",
                                        "penetration",
                                        "slipping",
                                        "contact_points",
                                        "negative_modes",
                                        "converged",
                                        "residual_blocks"};
  const std::string name = path.substr(path.find_last_of('.') + 1);
  if (std::any_of(std::begin(kOthers), std::end(kOthers), [&](const char* other) {
        return StartsWith(name, other);
      })) {
    return false;
  }
  return std::any_of(std::begin(kRoots), std::end(kRoots), [&](const char* root) {
    return StartsWith(path, root);
  });
}

// The kind of a group, within which sizes can be compared: without the name of the probe or finger.
std::string KindOf(const std::string& group) {
  const size_t first = group.find('.'), last = group.find_last_of('.');
  return first == last ? group : group.substr(0, first) + group.substr(last);
}

// Sizes that make the errors relative, from the references. Zero where a whole kind is zero.
void SetScales(std::vector<StudyQuantity>* quantities) {
  std::map<std::string, double> squares, largest;
  for (const StudyQuantity& quantity : *quantities) {
    squares[quantity.group] += quantity.reference * quantity.reference;
  }
  for (const auto& [group, square] : squares) {
    double& size = largest[KindOf(group)];
    size = std::max(size, std::sqrt(square));
  }
  for (StudyQuantity& quantity : *quantities) {
    quantity.scale =
        std::max(std::sqrt(squares[quantity.group]), kStill * largest[KindOf(quantity.group)]);
  }
}

// Of absolute uncertainties.
double LargestRelative(const std::vector<StudyQuantity>& quantities) {
  double largest = 0.0;
  for (const StudyQuantity& quantity : quantities) {
    if (quantity.scale > 0.0) largest = std::max(largest, quantity.uncertainty / quantity.scale);
  }
  return largest;
}

// p of the three values, see Extrapolation; the right side grows with p. kMostOrder or more.
double OrderOf(const double* h, double ratio) {
  const auto right = [h](double p) {
    const double a = std::pow(h[0] / h[1], p), c = std::pow(h[2] / h[1], p);
    return (a - 1.0) / (1.0 - c);
  };
  double low = kLeastOrder, high = kMostOrder;
  if (ratio <= right(low)) return low;
  if (ratio >= right(high)) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (right(middle) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Extrapolation FromThree(const double* h, const double* q) {
  Extrapolation result;
  const double before = q[1] - q[0], change = q[2] - q[1];
  if (change == 0.0) return {q[2], std::abs(before), std::nullopt};
  const double ratio = before / change;
  const double at_rest = std::log(h[0] / h[1]) / std::log(h[1] / h[2]);  // of order zero
  if (!(ratio > at_rest)) {
    return {q[2], std::max(std::abs(before), std::abs(change)), std::nullopt};
  }
  const double p = OrderOf(h, ratio);
  if (p >= kMostOrder) return {q[2], std::abs(change), std::nullopt};
  result.value = q[2] + change / (std::pow(h[1] / h[2], p) - 1.0);
  result.uncertainty = std::abs(result.value - q[2]);
  result.order = p;
  return result;
}

}  // namespace

double RoundingUncertainty(double value) {
  if (value == 0.0 || !std::isfinite(value)) return 0.0;
  for (int digits = 1; digits <= 17; ++digits) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.*e", digits - 1, value);
    if (std::strtod(text, nullptr) != value) continue;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - digits + 1);
    return 0.5 * unit / std::abs(value);
  }
  return 0.0;
}

std::vector<StudyQuantity> ExpectedQuantities(const Scene& scene, std::vector<std::string>* notes) {
  std::vector<StudyQuantity> quantities;
  for (const ExpectSpec& expect : scene.expect) {
    if (!MeasuresAccuracy(expect.quantity)) {
      notes->push_back("expect " + expect.quantity + " is no measure of accuracy and left out");
    } else if (expect.value == 0.0) {
      notes->push_back("expect " + expect.quantity +
                       " is zero, which has no relative error, and left out");
    } else {
      StudyQuantity quantity;
      quantity.path = quantity.group = expect.quantity;
      quantity.reference = expect.value;
      quantity.scale = std::abs(expect.value);
      quantity.uncertainty = RoundingUncertainty(expect.value);
      quantity.source = expect.source;
      quantities.push_back(quantity);
    }
  }
  return quantities;
}

std::vector<StudyQuantity> DefaultQuantities(const Scene& scene) {
  std::vector<StudyQuantity> quantities;
  const auto add = [&quantities](const std::string& path, const std::string& group) {
    StudyQuantity quantity;
    quantity.path = path;
    quantity.group = group;
    quantities.push_back(quantity);
  };
  for (const ProbeSpec& probe : scene.probes) {
    const std::string group = "probes." + probe.name + ".displacement";
    for (const char* component : {".x", ".y", ".z"}) add(group + component, group);
  }
  for (const FingerSpec& finger : scene.fingers) {
    const std::string path =
        "fingers." + finger.name + (finger.force ? ".travel" : ".normal_force");
    add(path, path);
  }
  if (FindGas(scene) != nullptr) add("gas.absolute_pressure", "gas.absolute_pressure");
  if (scene.path.control == PathControl::kDisplacement) {
    const std::string path = "load_steps[" + std::to_string(scene.steps - 1) + "].factor";
    add(path, path);
  }
  if (quantities.empty()) {
    add("max_displacement", "max_displacement");
    add("energy.total", "energy.total");
  }
  return quantities;
}

std::optional<Extrapolation> Extrapolate(const std::vector<double>& h,
                                         const std::vector<double>& values) {
  const size_t n = values.size();
  if (n < 3 || h.size() != n) return std::nullopt;
  for (const double value : values) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  Extrapolation result = FromThree(&h[n - 3], &values[n - 3]);
  if (n < 4 || !result.order) return result;
  const Extrapolation before = FromThree(&h[n - 4], &values[n - 4]);
  if (!before.order) return result;  // All of the last step stays in doubt.
  result.uncertainty = std::max(std::abs(result.value - before.value), kDoubt * result.uncertainty);
  return result;
}

std::optional<RichardsonReference> ExtrapolateFamilies(const std::vector<StudyQuantity>& quantities,
                                                       const std::vector<FamilyValues>& families) {
  std::vector<RichardsonReference> all;
  for (const FamilyValues& family : families) {
    RichardsonReference reference;
    reference.quantities = quantities;
    reference.family = family.name;
    bool complete = !family.h.empty();
    for (size_t i = 0; complete && i < quantities.size(); ++i) {
      std::vector<double> values;
      for (const std::vector<double>& level : family.values) values.push_back(level[i]);
      const std::optional<Extrapolation> limit = Extrapolate(family.h, values);
      complete = limit.has_value();
      if (!complete) break;
      StudyQuantity& quantity = reference.quantities[i];
      quantity.reference = limit->value;
      quantity.uncertainty = limit->uncertainty;  // absolute yet
      quantity.source = "Richardson extrapolation of '" + family.name + "'";
      reference.orders.push_back(limit->order);
    }
    if (!complete) continue;
    SetScales(&reference.quantities);
    reference.uncertainty = LargestRelative(reference.quantities);
    all.push_back(std::move(reference));
  }
  const auto found = std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.uncertainty < b.uncertainty;
  });
  if (found == all.end()) return std::nullopt;
  std::optional<RichardsonReference> best = *found;
  for (size_t i = 0; i < quantities.size(); ++i) {
    StudyQuantity& quantity = best->quantities[i];
    for (const RichardsonReference& other : all) {
      const StudyQuantity& rival = other.quantities[i];
      quantity.uncertainty = std::max(
          quantity.uncertainty, std::abs(rival.reference - quantity.reference) - rival.uncertainty);
    }
    if (quantity.scale > 0.0) quantity.uncertainty /= quantity.scale;
  }
  best->uncertainty = 0.0;
  for (const StudyQuantity& quantity : best->quantities) {
    best->uncertainty = std::max(best->uncertainty, quantity.uncertainty);
  }
  // What is zero for all has no error and no order.
  for (size_t i = best->quantities.size(); i-- > 0;) {
    if (best->quantities[i].scale > 0.0) continue;
    best->quantities.erase(best->quantities.begin() + i);
    best->orders.erase(best->orders.begin() + i);
  }
  if (best->quantities.empty()) return std::nullopt;
  return best;
}

std::optional<StudyError> ErrorOf(const std::vector<StudyQuantity>& quantities,
                                  const std::map<std::string, double>& values) {
  StudyError worst;
  for (size_t i = 0; i < quantities.size(); ++i) {
    const StudyQuantity& quantity = quantities[i];
    const auto value = values.find(quantity.path);
    if (value == values.end() || !std::isfinite(value->second)) return std::nullopt;
    const double error = std::abs(value->second - quantity.reference) / quantity.scale;
    // By what is known of it: an error below the uncertainty counts as that.
    const double counted = std::max(error, quantity.uncertainty);
    if (worst.quantity < 0 || counted > std::max(worst.error, worst.uncertainty)) {
      worst = {error, quantity.uncertainty, static_cast<int>(i)};
    }
  }
  if (worst.quantity < 0) return std::nullopt;
  return worst;
}

}  // namespace darboux
