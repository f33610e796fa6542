#include "solver/report_arrays.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

template <typename Unsigned>
void Append(Unsigned value, std::string* bytes) {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    bytes->push_back(static_cast<char>(value >> (8 * i) & 0xff));
  }
}

// As a float, which is what the page computes with.
bool HasValue(double value) { return std::isfinite(static_cast<float>(value)); }

}  // namespace

int ReportArrays::AddBlob(std::string bytes) {
  num_bytes_ += bytes.size();
  blobs_.push_back(std::move(bytes));
  return static_cast<int>(blobs_.size()) - 1;
}

Json ReportArrays::AddFloats(const Eigen::MatrixXd& values) {
  std::string bytes;
  bytes.reserve(4 * values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const float value = static_cast<float>(values.data()[i]);
    std::uint32_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    Append(bits, &bytes);
  }
  return {{"count", values.cols()},
          {"components", values.rows()},
          {"type", "f32"},
          {"blob", AddBlob(std::move(bytes))}};
}

Json ReportArrays::AddIndices(const std::vector<std::array<int, 3>>& triangles) {
  std::string bytes;
  bytes.reserve(12 * triangles.size());
  for (const std::array<int, 3>& triangle : triangles) {
    for (const int index : triangle) Append(static_cast<std::uint32_t>(index), &bytes);
  }
  return {{"count", triangles.size()},
          {"components", 3},
          {"type", "u32"},
          {"blob", AddBlob(std::move(bytes))}};
}

Json ReportArrays::AddQuantised(const Eigen::MatrixXd& values) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Eigen::Index rows = values.rows();
  Eigen::VectorXd low = Eigen::VectorXd::Constant(rows, kInfinity), high = -low;
  bool all_there = true;
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double value = values(k, i);
      if (HasValue(value)) {
        low[k] = std::min(low[k], value);
        high[k] = std::max(high[k], value);
      } else {
        all_there = false;
      }
    }
  }
  Json offset = Json::array(), scale = Json::array();
  Eigen::VectorXd step(rows);
  bool constant = all_there;
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (!(low[k] <= high[k])) low[k] = high[k] = 0.0;  // No value at all.
    step[k] = (high[k] - low[k]) / kLargestCode;
    constant = constant && step[k] == 0.0;
    offset.push_back(low[k]);
    scale.push_back(step[k]);
  }
  Json json = {{"count", values.cols()},
               {"components", rows},
               {"type", "u16"},
               {"offset", std::move(offset)},
               {"scale", std::move(scale)},
               {"blob", nullptr}};
  if (constant) return json;
  std::string bytes;
  bytes.reserve(2 * values.size());
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double value = values(k, i);
      int code = kNoValue;
      if (HasValue(value)) {
        const double steps = step[k] > 0.0 ? (value - low[k]) / step[k] : 0.0;
        code = static_cast<int>(
            std::lround(std::min(std::max(steps, 0.0), static_cast<double>(kLargestCode))));
      }
      Append(static_cast<std::uint16_t>(code), &bytes);
    }
  }
  json["blob"] = AddBlob(std::move(bytes));
  return json;
}

}  // namespace darboux
