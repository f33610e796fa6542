// What every effect costs: one ball, solved with each effect switched on or off, in turns. Prints a
// table; times are the least of all rounds, in cpu seconds of one thread.
//
// Sample run: tests/effect_benchmark --frequency=12 --repeats=5
#include <ceres/problem.h>
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

DEFINE_int32(frequency, 12, "Of the icosphere: 10 n^2 + 2 control vertices.");
DEFINE_int32(repeats, 5, "Rounds over all cases.");

namespace darboux {
namespace {

struct Case {
  const char* name;
  std::string scene;
  int base;  // the case that it adds one effect to; -1: none
  double seconds = std::numeric_limits<double>::infinity();
  int unknowns = 0, blocks = 0, iterations = 0;
};

// A tennis ball (mm, N, MPa) squeezed by 2 mm a side: by dead forces on patches of its poles, or
// between two spheres.
std::string Ball(const char* theory, bool fingers, bool friction, bool gas, bool gravity) {
  std::string text = "name: ball\nsurface: {kind: icosphere, radius: 31.25, frequency: " +
                     std::to_string(FLAGS_frequency) +
                     "}\nshell: {thickness: 2.5, young_modulus: 1, poisson_ratio: 0.5, density: "
                     "1.0e-9}\nmodel: {theory: " +
                     theory + "}\n";
  std::string loads;
  if (!fingers) {
    loads += "  - {kind: traction, force: [0, 0, \"-sign(z)*0.002*exp(-(x^2+y^2)/50)\"]}\n";
    text +=
        "supports:\n  - {on: {near: [0, 0, 31.25], radius: 0}, fix: [x, y]}\n"
        "  - {on: {near: [0, 0, -31.25], radius: 0}, fix: [x, y]}\n"
        "  - {on: {near: [31.25, 0, 0], radius: 0}, fix: [y, z]}\n";
  }
  if (gas) loads += "  - {kind: gas, gauge_pressure: 0, ambient_pressure: 0.101325}\n";
  if (gravity) loads += "  - {kind: gravity, acceleration: [0, 0, -9810]}\n";
  if (!loads.empty()) text += "loads:\n" + loads;
  if (fingers) {
    const std::string tail = friction ? ", friction: 0.5}\n" : "}\n";
    text +=
        "fingers:\n"
        "  - {name: top, shape: {kind: sphere, radius: 6}, position: [0, 0, 60], "
        "direction: [0, 0, -1], motion: {travel: 2}" +
        tail +
        "  - {name: bottom, shape: {kind: sphere, radius: 6}, position: [0, 0, -60], "
        "direction: [0, 0, 1], motion: {travel: 2}" +
        tail;
  }
  return text;
}

std::string Plate(bool in_plane) {
  return std::string(
             "name: plate\nsurface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [32, 32]}\n"
             "shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}\n"
             "model: {theory: linear}\nsupports: [{on: rim, clamped: true}]\nloads:\n"
             "  - {kind: normal_traction, value: 1}\n") +
         (in_plane ? "  - {kind: traction, force: [1, 0, 0]}\n" : "");
}

double CpuSeconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return time.tv_sec + 1e-9 * time.tv_nsec;
}

bool Run(Case* c) {
  Scene scene;
  std::string error;
  SolverOptions options;
  options.num_threads = 1;
  std::unique_ptr<ShellProblem> problem;
  SolverSummary summary;
  if (!ParseScene(c->scene, c->name, &scene, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return false;
  }
  const double start = CpuSeconds();
  if (!Solve(scene, options, &problem, &summary, &error) || !summary.IsConverged()) {
    std::fprintf(stderr, "%s: %s%s\n", c->name, error.c_str(), summary.message.c_str());
    return false;
  }
  c->seconds = std::min(c->seconds, CpuSeconds() - start);
  c->unknowns = summary.unknowns;
  c->iterations = summary.iterations;
  c->blocks = problem->problem()->NumResidualBlocks();
  return true;
}

int RunAll() {
  std::vector<Case> cases = {
      {"plate, bending alone", Plate(false), -1},
      {"  + membrane (a load in its plane)", Plate(true), 0},
      {"ball, linear, patches of force", Ball("linear", false, false, false, false), -1},
      {"  + geometric nonlinearity", Ball("nonlinear", false, false, false, false), 2},
      {"  + gravity", Ball("nonlinear", false, false, false, true), 3},
      {"  + gas", Ball("nonlinear", false, false, true, false), 3},
      {"ball between fingers, linear", Ball("linear", true, false, false, false), -1},
      {"  + geometric nonlinearity", Ball("nonlinear", true, false, false, false), 6},
      {"  + friction", Ball("nonlinear", true, true, false, false), 7},
      {"  + gas", Ball("nonlinear", true, false, true, false), 7},
      {"  + gas and friction", Ball("nonlinear", true, true, true, false), 7},
  };
  for (int round = 0; round < FLAGS_repeats; ++round) {
    for (Case& c : cases) {
      if (!Run(&c)) return 1;
    }
  }
  std::printf("%-36s %9s %9s %10s %9s %9s\n",
              "scene",
              "unknowns",
              "blocks",
              "iterations",
              "cpu s",
              "times");
  for (const Case& c : cases) {
    std::printf("%-36s %9d %9d %10d %9.3f", c.name, c.unknowns, c.blocks, c.iterations, c.seconds);
    if (c.base >= 0) std::printf(" %9.2f", c.seconds / cases[c.base].seconds);
    std::printf("\n");
  }
  return 0;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  return darboux::RunAll();
}
