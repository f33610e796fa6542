// Solves a scene through the installed headers and libraries.
#include <cstdio>
#include <memory>
#include <string>

#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  darboux::Scene scene;
  std::string error;
  if (!darboux::ReadScene(argv[1], &scene, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 2;
  }
  std::unique_ptr<darboux::ShellProblem> problem;
  darboux::SolverSummary summary;
  if (!darboux::Solve(scene, darboux::SolverOptions(), &problem, &summary, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 2;
  }
  std::printf("%s\n", summary.BriefReport().c_str());
  return summary.IsConverged() ? 0 : 1;
}
