#ifndef DARBOUX_TESTS_CALIBRATION_UTIL_H_
#define DARBOUX_TESTS_CALIBRATION_UTIL_H_

#include <gtest/gtest.h>

#include <string>

#include "solver/calibration.h"

namespace darboux {

// Expects it to be well posed and to converge.
inline CalibrationSummary Calibrated(const CalibrationSpec& spec) {
  CalibrationSummary summary;
  CalibrationOptions options;
  options.solver.num_threads = 1;
  std::string error;
  EXPECT_TRUE(Calibrate(spec, options, &summary, nullptr, &error)) << error;
  EXPECT_TRUE(summary.IsConverged()) << summary.message;
  return summary;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_CALIBRATION_UTIL_H_
