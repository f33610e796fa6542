#ifndef DARBOUX_TESTS_SCENE_READER_UTIL_H_
#define DARBOUX_TESTS_SCENE_READER_UTIL_H_

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "solver/scene_reader.h"

// What the tests of the reader of scenes share: scenes, and what is expected of mistakes in them.

namespace darboux {

inline constexpr char kFile[] = "roof.yaml";

// A scene with every key; the line numbers in the table of mistakes below are its own.
inline constexpr char kBeforeSurface[] = R"yaml(name: roof
)yaml";
inline constexpr char kSurface[] = R"yaml(surface:
  kind: cylinder
  radius: 300
  u: [0, 600]
  v: [0, pi/2]
  divisions: [16, 8]
  periodic: [false, false]
  grading: [0.8, -0.5]
)yaml";
inline constexpr char kAfterSurface[] = R"yaml(shell:
  thickness: 3
  young_modulus: 3.0e6
  poisson_ratio: 0.3
  density: 0.1
model:
  minimizer: ceres
  theory: linear
  strains: seed
  quadrature: 6
  boundary_rule: seed_ghosts
  accuracy: 0.05
supports:
  - {on: u_min, fix: [y, z], displacement: [0, "0.1*sin(v)", -0.2]}
  - {on: u_max, symmetry: x}
  - {on: v_min, clamped: true}
  - {on: {near: [0, 0, 300], radius: 5}, simply_supported: true, displacement: [0, 0, 1]}
  - {on: rim, symmetry: [3, 0, -4]}
loads:
  - {kind: point, at: {uv: [300, 0.5]}, force: [0, 0, -0.25]}
  - {kind: pressure, value: 1.5, follower: false}
  - {kind: traction, force: ["0", 0, "cos(2*v)*sin(pi*u/600)"]}
  - {kind: normal_traction, value: z/300}
  - {kind: edge, on: v_max, force: [0, 0, 1], moment: [x, 0, 0]}
  - {kind: line, along: {v: 0.25}, force: [0, 0, -1]}
  - {kind: gravity, acceleration: [0, 0, -9.81]}
steps: 4
probes:
  - {name: under_load, at: {uv: [300, 0.5]}}
  - {name: top, at: {nearest: [0, 0, 300]}}
expect:
  - quantity: probes.under_load.displacement.z
    value: -1.8e-5
    relative_tolerance: 0.02
    source: "Reddy 2004 p. 217"
  - {quantity: "load_steps[0].factor", value: 0, absolute_tolerance: 1}
)yaml";

inline constexpr char kMinimal[] = R"yaml(name: square
surface: {kind: plane, u: [0, 1], v: [0, 2], divisions: [4, 8]}
shell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0}
)yaml";

inline constexpr char kTyre[] = R"yaml(name: tyre
surface: {kind: torus, radii: [3, 1], u: [0, 2*pi], v: [-pi, pi], divisions: [9, 4],
          periodic: [true, true]}
shell: {thickness: 0.01, young_modulus: 1, poisson_ratio: 0.5}
)yaml";

inline std::string FullScene() { return std::string(kBeforeSurface) + kSurface + kAfterSurface; }

// The full scene with the first occurrence of `find` replaced.
inline std::string Edit(const std::string& find, const std::string& replace) {
  std::string text = FullScene();
  const size_t at = text.find(find);
  EXPECT_NE(at, std::string::npos) << find;
  if (at != std::string::npos) text.replace(at, find.size(), replace);
  return text;
}

// The full scene with other keys below `surface:`.
inline std::string WithSurface(const std::string& keys) {
  return std::string(kBeforeSurface) + "surface:\n" + keys + kAfterSurface;
}

// The minimal scene with more lines at its end.
inline std::string Minimal(const std::string& more) { return kMinimal + more; }

inline Scene Parse(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, kFile, &scene, &error)) << error;
  return scene;
}

inline std::string ErrorOf(const std::string& text) {
  Scene scene;
  scene.name = "untouched";
  std::string error;
  EXPECT_FALSE(ParseScene(text, kFile, &scene, &error)) << text;
  EXPECT_EQ(scene.name, "untouched");
  return error;
}

inline constexpr char kRootKeys[] =
    "name | surface | shell | model | supports | loads | hand | fingers | steps | path | probes | "
    "expect";

struct Mistake {
  std::string name;
  std::string text;
  // Behind "roof.yaml:"; "(*)" stands for what yaml-cpp or the expression parser say.
  std::string message;
};

inline bool Matches(const std::string& message, const std::string& pattern) {
  const size_t star = pattern.find("(*)");
  if (star == std::string::npos) return message == pattern;
  const std::string head = pattern.substr(0, star + 1), tail = pattern.substr(star + 2);
  return message.size() > head.size() + tail.size() && message.compare(0, head.size(), head) == 0 &&
         message.compare(message.size() - tail.size(), tail.size(), tail) == 0;
}

// Every mistake is reported with place and remedy.
inline void ExpectMessage(const Mistake& mistake) {
  const std::string error = ErrorOf(mistake.text);
  EXPECT_TRUE(Matches(error, std::string(kFile) + ":" + mistake.message))
      << error << "\nis not\n"
      << kFile << ":" << mistake.message;
}

inline std::string NameOf(const ::testing::TestParamInfo<Mistake>& info) { return info.param.name; }

// A scene on a surface that is a mesh, in line 2; `more` begins in line 4.
inline std::string OnMesh(const std::string& surface, const std::string& more = "") {
  return "name: mesh\nsurface: {" + surface +
         "}\nshell: {thickness: 0.01, young_modulus: 1e9, poisson_ratio: 0}\n" + more;
}

inline std::string MeshFile(const std::string& name) {
  return "kind: mesh, file: " DARBOUX_DATA_DIR "/" + name;
}

inline constexpr char kIcosphere[] = "kind: icosphere, radius: 2, frequency: 3";
inline constexpr char kBall[] =
    "kind: implicit, function: x^2+y^2+z^2-1, bounds: [[-2, 2], [-2, 2], [-2, 2]], edge_length: "
    "0.5";

// kBall with the first occurrence of `find` replaced.
inline std::string Ball(const std::string& find, const std::string& replace) {
  std::string text = kBall;
  text.replace(text.find(find), find.size(), replace);
  return OnMesh(text);
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_SCENE_READER_UTIL_H_
