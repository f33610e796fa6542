#ifndef DARBOUX_TESTS_HARD_UTIL_H_
#define DARBOUX_TESTS_HARD_UTIL_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "tests/solve_util.h"

// What the hard cases share: scenes with numbers filled in, and a word to say about each.

namespace darboux {

// 17 digits: read back it is the same number.
inline std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

// Replaces every $name by its number; longer names first where one begins with another.
inline std::string Fill(std::string text,
                        const std::vector<std::pair<std::string, double>>& values) {
  for (const auto& [name, value] : values) {
    size_t at = text.find("$" + name);
    EXPECT_NE(at, std::string::npos) << name;
    for (; at != std::string::npos; at = text.find("$" + name)) {
      text.replace(at, name.size() + 1, Text(value));
    }
  }
  EXPECT_EQ(text.find('$'), std::string::npos) << text.substr(text.find('$'), 20);
  return text;
}

// The figures of the table `Hard cases` in README.md: ctest -L hard -V prints them.
inline void Measured(const std::string& what, double value) {
  std::printf("  measured  %-60s %.3g\n", what.c_str(), value);
}

// Displacement of the tip of a strip along x under an end moment of m = curvature * D, in the plane
// of x and z. In Koiter's theory the energy of a strip of stretch l that turns by t per length is
// C (l^2 - 1)^2 / 8 + D (l t)^2 / 2, so that t = m / (D l^2), l^2 = 1 - (h t)^2 / 6: a circle.
inline Eigen::Vector3d KoiterCircle(double length, double thickness, double curvature) {
  double turn = curvature, stretch = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double squared = 1.0 - std::pow(thickness * turn, 2) / 6.0;
    stretch = std::sqrt(squared);
    turn = curvature / squared;
  }
  const double radius = stretch / turn, angle = length * turn;
  return {radius * std::sin(angle) - length, 0.0, radius * (1.0 - std::cos(angle))};
}

// Solves what may fail: the summary says how it ended. Expects the scene to be well posed.
inline Solution TryScene(const Scene& scene, const SolverOptions& options = SolverOptions()) {
  Solution solution;
  std::string error;
  EXPECT_TRUE(Solve(scene, options, &solution.problem, &solution.summary, &error)) << error;
  return solution;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_HARD_UTIL_H_
