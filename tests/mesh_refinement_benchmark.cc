// What local refinement is worth: dof, quantity and cpu seconds of a scene on a mesh, refined again
// and again where its errors are.
// Sample run: tests/mesh_refinement_benchmark --frequency=4 --steps=5 data/tennis_ball.yaml
#include <gflags/gflags.h>

#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include "geometry/icosphere.h"
#include "solver/mesh_refinement.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"

DEFINE_int32(frequency, 0, "Of an icosphere, in place of the scene's; 0: as it is.");
DEFINE_int32(steps, 5, "Refinements.");
DEFINE_double(fraction, 0.6, "Of the indicators' sum that is refined.");
DEFINE_bool(goals, true, "Fingers and probes are quantities; false: the primal indicator alone.");
DEFINE_bool(probes, true, "Probes are quantities.");
DEFINE_bool(sphere, false, "The control points are fitted to the sphere, as model.accuracy does.");
DEFINE_double(contact_spacing, 0.0, "Of points of contact, in place of the scene's; 0: as it is.");
DEFINE_int32(max_dof, 0, "Stops there; 0: no limit.");

namespace darboux {
namespace {

double Seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

int Run(const std::string& file) {
  Scene scene;
  std::string error;
  if (!ReadScene(file, &scene, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  if (FLAGS_frequency > 0 && scene.surface.kind == "icosphere") {
    scene.surface.mesh = std::make_shared<const TriangleMesh>(
        MakeSmoothIcosphere(scene.surface.mesh->vertices.front().norm(), FLAGS_frequency));
  }
  if (FLAGS_contact_spacing > 0.0) scene.model.contact_spacing = FLAGS_contact_spacing;
  if (FLAGS_sphere) scene.surface.sphere_radius = scene.surface.mesh->vertices.front().norm();
  SolverOptions options;
  options.num_threads = 1;
  MeshRefinementOptions refinement;
  refinement.fraction = FLAGS_fraction;
  refinement.fingers = FLAGS_goals;
  refinement.probes = FLAGS_goals && FLAGS_probes;
  refinement.num_threads = 1;
  refinement.max_dof = FLAGS_max_dof;
  double sum = 0.0;
  std::printf(
      "   dof elements levels     finger 0 F    probe 0 |u|         energy  indicator  "
      "marked  solve s  mark s   sum s\n");
  for (int step = 0; step <= FLAGS_steps; ++step) {
    const double start = Seconds();
    std::unique_ptr<ShellProblem> problem;
    SolverSummary summary;
    if (!Solve(scene, options, &problem, &summary, &error) || !summary.IsConverged()) {
      std::fprintf(stderr, "%s%s\n", error.c_str(), summary.message.c_str());
      return 1;
    }
    const double solved = Seconds();
    MeshRefinement next;
    MeshRefinementReport report;
    const bool marked = MarkForRefinement(problem.get(), refinement, &next, &report, &error);
    const double done = Seconds();
    sum += solved - start;
    const auto& fingers = summary.steps.back().fingers;
    const auto& old = scene.surface.refinement;
    std::printf("%6d %8d %6d %14.9g %14.9g %14.9g %14.9g %10.3g %7d %8.2f %7.2f %7.2f\n",
                problem->dof(),
                problem->surface().num_elements(),
                old == nullptr ? 0 : static_cast<int>(old->refined.size()),
                summary.steps.back().factor,
                fingers.empty() ? 0.0 : fingers[0].normal_force,
                summary.probes.empty() ? 0.0 : summary.probes[0].displacement.norm(),
                summary.energy_total,
                report.total,
                report.marked,
                solved - start,
                done - solved,
                sum);
    std::fflush(stdout);
    sum += done - solved;
    if (!marked) {
      std::fprintf(stderr, "%s\n", error.c_str());
      break;
    }
    scene.surface.refinement = std::make_shared<const MeshRefinement>(next);
  }
  return 0;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  if (argc != 2) return 1;
  return darboux::Run(argv[1]);
}
