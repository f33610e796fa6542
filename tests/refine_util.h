#ifndef DARBOUX_TESTS_REFINE_UTIL_H_
#define DARBOUX_TESTS_REFINE_UTIL_H_

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "solver/accuracy.h"

namespace darboux {

// A scene solved to its accuracy; a failure of the test where that is not possible.
struct Refined {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  AccuracyReport report;
};

inline Refined Refine(const Scene& scene, AccuracyOptions options = {}, SolverOptions solver = {}) {
  Refined refined;
  std::string error;
  EXPECT_TRUE(SolveToAccuracy(
      scene, solver, options, &refined.problem, &refined.summary, &refined.report, &error))
      << error;
  return refined;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_REFINE_UTIL_H_
