#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "solver/results.h"
#include "solver/summary_json.h"

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

std::string Describe(const Json& node) {
  if (node.is_object()) {
    std::string keys;
    for (const auto& item : node.items()) keys += (keys.empty() ? "" : ", ") + item.key();
    return keys.empty() ? "no keys" : "the keys " + keys;
  }
  if (node.is_array()) return "an array of " + std::to_string(node.size());
  if (node.is_null()) return "null (no finite number)";
  if (node.is_string()) return "a text";
  return "a number";
}

// Null and *message where the path leads nowhere.
const Json* Find(const Json& root, const std::string& path, std::string* message) {
  const Json* node = &root;
  std::string at = "summary.json";
  const auto fail = [&](const std::string& wanted) {
    *message = "no '" + wanted + "' in " + at + ", which has " + Describe(*node);
    return nullptr;
  };
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('.', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    const size_t bracket = std::min(part.find('['), part.size());
    const std::string name = part.substr(0, bracket);
    if (!node->is_object() || !node->contains(name)) return fail(name);
    node = &node->at(name);
    at = begin == 0 ? name : at + "." + name;
    for (size_t open = bracket; open < part.size();) {
      const size_t close = std::min(part.find(']', open), part.size());
      const std::string digits = part.substr(open + 1, close - std::min(close, open + 1));
      size_t index = 0;
      const std::from_chars_result read =
          std::from_chars(digits.data(), digits.data() + digits.size(), index);
      if (part[open] != '[' || close == part.size() || read.ec != std::errc() ||
          read.ptr != digits.data() + digits.size() || !node->is_array() || index >= node->size()) {
        return fail(part.substr(open));
      }
      node = &node->at(index);
      at += "[" + digits + "]";
      open = close + 1;
    }
    begin = end + 1;
  }
  if (!node->is_number() && !node->is_boolean()) {
    *message = at + " is no number, it has " + Describe(*node);
    return nullptr;
  }
  return node;
}

}  // namespace

nlohmann::ordered_json MakeExpectJson(const std::vector<ExpectResult>& results) {
  Json list = Json::array();
  for (const ExpectResult& result : results) {
    Json entry = {{"quantity", result.quantity},
                  {"value", Optional(result.value)},
                  {"expected", result.expected},
                  {"error", Optional(result.error)},
                  {"tolerance", result.tolerance},
                  {"relative", result.relative},
                  {"holds", result.holds}};
    if (!result.message.empty()) entry["message"] = result.message;
    list.push_back(std::move(entry));
  }
  return list;
}

bool EvaluateExpectations(const Scene& scene,
                          const nlohmann::ordered_json& summary,
                          std::vector<ExpectResult>* results) {
  results->clear();
  bool all_hold = true;
  for (const ExpectSpec& expect : scene.expect) {
    ExpectResult result;
    result.quantity = expect.quantity;
    result.expected = expect.value;
    result.relative = !expect.absolute_tolerance.has_value();
    result.tolerance = expect.absolute_tolerance.value_or(expect.relative_tolerance.value_or(0.0));
    const Json* node = Find(summary, expect.quantity, &result.message);
    if (node != nullptr) {
      result.value = node->is_boolean() ? (node->get<bool>() ? 1.0 : 0.0) : node->get<double>();
      const double difference = std::abs(*result.value - expect.value);
      const double scale = result.relative ? std::abs(expect.value) : 1.0;
      result.holds = difference <= result.tolerance * scale;  // False for NaN.
      // Relative to zero only zero has an error that is a number.
      result.error = scale > 0.0 ? difference / scale : difference;
    }
    all_hold = all_hold && result.holds;
    results->push_back(std::move(result));
  }
  return all_hold;
}

}  // namespace darboux
