#ifndef DARBOUX_TESTS_ACCURACY_UTIL_H_
#define DARBOUX_TESTS_ACCURACY_UTIL_H_

#include <gtest/gtest.h>

#include <string>

#include "solver/scene.h"
#include "solver/scene_reader.h"

// Small scenes of the tests of accuracy studies.

namespace darboux {

inline Scene Parse(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, "test.yaml", &scene, &error)) << error;
  return scene;
}

// `more`: further sections; `model` and `surface`: further keys of theirs.
inline Scene Plate(const std::string& more = "",
                   const std::string& model = "theory: linear",
                   const std::string& surface = "divisions: [8, 4]") {
  return Parse("name: plate\nsurface: {kind: plane, u: [0, 2], v: [0, 1], " + surface +
               "}\nshell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0.3}\nmodel: {" +
               model + "}\n" + more);
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_ACCURACY_UTIL_H_
