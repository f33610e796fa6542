// Writes the duck, a closed control mesh made of an icosphere (geometry/duck_mesh.h), in metres.
// Sample run: tools/darboux_duck --frequency=8 --out=data/duck_642.obj

#include <gflags/gflags.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "geometry/duck_mesh.h"
#include "geometry/triangle_mesh.h"
#include "tools/command_line.h"

DEFINE_int32(frequency,
             8,
             "mesh | N | 4 to 64 | Divisions of the icosahedron's edges; the mesh has 10 N^2 + 2 "
             "vertices.");
DEFINE_string(out, "", "output | FILE | .obj; required without --formula | The file to write.");
DEFINE_bool(formula,
            false,
            "output | | | Prints the surface as a formula of x, y, z, as scenes with an implicit "
            "surface take it, and writes nothing.");

namespace darboux {
namespace {

constexpr HelpItem kExitStatuses[] = {
    {"0", "done"}, {"1", "the file cannot be written"}, {"2", "a mistake on the command line"}};

constexpr HelpItem kExamples[] = {{"darboux_duck --frequency=4 --out=duck.obj",
                                   "A coarse one; 8 gives data/duck_642.obj, 16 duck_2562.obj:"},
                                  {"darboux_duck --formula", "Its formula:"}};

constexpr Tool kTool = {
    "darboux_duck",
    "--frequency=N --out=FILE.obj",
    "Writes a bath duck, 90 mm long, as a closed control mesh in metres: the connectivity of an "
    "icosphere, its vertices on a smooth surface.",
    0,
    "makes the mesh of a bath duck",
    {},
    {},
    kExitStatuses,
    "",
    kExamples};

// As few digits as give the same number back.
std::string Shortest(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), x).ptr};
}

int FailUsage(const std::string& message) {
  std::fprintf(stderr, "%s: %s\n", kTool.name, message.c_str());
  PrintUsage(kTool);
  return kExitBadInput;
}

int Run(int argc, char** argv) {
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  std::vector<std::string> arguments;
  std::string error;
  if (!ParseWords(kTool, "", words, &arguments, &error)) {
    return error.empty() ? kExitDone : FailUsage(error);
  }
  if (FLAGS_formula) {
    std::printf("%s\n", DuckFormula().c_str());
    return kExitDone;
  }
  if (FLAGS_frequency < 4 || FLAGS_frequency > 64) {
    std::fprintf(stderr,
                 "%s: --frequency: found '%d'; allowed an integer in [4, 64]\n",
                 kTool.name,
                 FLAGS_frequency);
    return kExitBadInput;
  }
  if (FLAGS_out.empty()) {
    return FailUsage("--out: found no file; allowed the name of an .obj file");
  }
  const TriangleMesh mesh = MakeDuckMesh(FLAGS_frequency);
  std::ofstream out(FLAGS_out);
  out << "# Duck, metres; made by darboux_duck --frequency=" << FLAGS_frequency << "\n";
  for (const Eigen::Vector3d& p : mesh.vertices) {
    out << "v " << Shortest(p.x()) << ' ' << Shortest(p.y()) << ' ' << Shortest(p.z()) << '\n';
  }
  for (const std::array<int, 3>& t : mesh.triangles) {
    out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
  out.close();
  if (!out) {
    std::fprintf(stderr, "%s: cannot write '%s'\n", kTool.name, FLAGS_out.c_str());
    return kExitNotConverged;
  }
  std::printf("%s: %zu vertices, %zu triangles\n",
              FLAGS_out.c_str(),
              mesh.vertices.size(),
              mesh.triangles.size());
  return kExitDone;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  std::string error;
  const int exit_status = darboux::RunAndCatch(darboux::Run, argc, argv, &error);
  if (!error.empty()) std::fprintf(stderr, "%s: %s\n", darboux::kTool.name, error.c_str());
  return exit_status;
}
