// Writes the duck, a closed control mesh made of an icosphere (geometry/duck_mesh.h), in metres.
// Sample run: tools/darboux_duck --frequency=8 --out=data/duck_642.obj

#include <gflags/gflags.h>
#include <glog/logging.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "geometry/duck_mesh.h"
#include "geometry/triangle_mesh.h"

DEFINE_int32(frequency, 8, "Divisions of the icosahedron's edges, 4 to 64: 10 n^2 + 2 vertices.");
DEFINE_string(out, "", "OBJ file to write; required.");
DEFINE_bool(formula, false, "Print the surface as a formula of x, y, z, and write nothing.");

namespace darboux {
namespace {

// As few digits as give the same number back.
std::string Shortest(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), x).ptr};
}

int Run() {
  if (FLAGS_formula) {
    std::printf("%s\n", DuckFormula().c_str());
    return EXIT_SUCCESS;
  }
  if (FLAGS_frequency < 4 || FLAGS_frequency > 64) {
    std::fprintf(stderr, "--frequency=%d; allowed 4 to 64\n", FLAGS_frequency);
    return EXIT_FAILURE;
  }
  if (FLAGS_out.empty()) {
    std::fprintf(stderr, "--out=FILE.obj is required\n");
    return EXIT_FAILURE;
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
    std::fprintf(stderr, "cannot write '%s'\n", FLAGS_out.c_str());
    return EXIT_FAILURE;
  }
  std::printf("%s: %zu vertices, %zu triangles\n",
              FLAGS_out.c_str(),
              mesh.vertices.size(),
              mesh.triangles.size());
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  gflags::SetUsageMessage("darboux_duck --frequency=N --out=FILE.obj");
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  if (argc > 1) {
    std::fprintf(stderr, "unexpected argument '%s'\n", argv[1]);
    return EXIT_FAILURE;
  }
  return darboux::Run();
}
