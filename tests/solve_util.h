#ifndef DARBOUX_TESTS_SOLVE_UTIL_H_
#define DARBOUX_TESTS_SOLVE_UTIL_H_

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

namespace darboux {

// A solved scene.
struct Solution {
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;

  Eigen::Vector3d Probe(size_t i = 0) const { return summary.probes.at(i).displacement; }
};

inline Scene SceneFromText(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, "test.yaml", &scene, &error)) << error;
  return scene;
}

inline Scene SceneFromData(const std::string& name) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ReadScene(DARBOUX_DATA_DIR "/" + name, &scene, &error)) << error;
  return scene;
}

// Expects the scene to be well posed and to converge.
inline Solution SolveScene(const Scene& scene, const SolverOptions& options = SolverOptions()) {
  Solution solution;
  std::string error;
  EXPECT_TRUE(Solve(scene, options, &solution.problem, &solution.summary, &error)) << error;
  EXPECT_TRUE(solution.summary.IsConverged()) << solution.summary.message;
  return solution;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_SOLVE_UTIL_H_
