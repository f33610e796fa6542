#ifndef DARBOUX_SOLVER_REPORT_ARRAYS_H_
#define DARBOUX_SOLVER_REPORT_ARRAYS_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace darboux {

// Arrays of numbers, packed for somebody who reads them in a browser. What Add returns describes an
// array in JSON: "count", "components", "type" and "blob", the number of its bytes among blobs(),
// little endian, the components of an element side by side.
//
//   "f32"  floats
//   "u32"  indices
//   "u16"  quantised: component k of element i is offset[k] + scale[k] * code, but code 65535 says
//          that there is no value. Values are off by at most half of scale[k], a 131,068th of the
//          component's range, and roundings of that range. Where all values are equal, scale is 0
//          and they are exact; where that holds of all components and every value is there, "blob"
//          is null, there are no bytes.
class ReportArrays {
 public:
  static constexpr int kLargestCode = 65534;
  static constexpr int kNoValue = 65535;

  // A column per element. Floats must be finite.
  nlohmann::ordered_json AddFloats(const Eigen::MatrixXd& values);
  nlohmann::ordered_json AddIndices(const std::vector<std::array<int, 3>>& triangles);
  // What is not finite as a float has no value.
  nlohmann::ordered_json AddQuantised(const Eigen::MatrixXd& values);

  const std::vector<std::string>& blobs() const { return blobs_; }
  std::size_t num_bytes() const { return num_bytes_; }

 private:
  int AddBlob(std::string bytes);

  std::vector<std::string> blobs_;
  std::size_t num_bytes_ = 0;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_REPORT_ARRAYS_H_
