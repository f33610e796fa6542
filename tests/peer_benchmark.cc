// Darboux and CalculiX side by side on the same shells: each as its users run it, a whole process
// on one thread, in turns. Prints, for each run, unknowns, iterations, errors, processor seconds
// and peak memory, and who needs less time for 3 %, 1 %, 0.3 % and 0.1 %. Asserts only that runs
// succeed.
//
// Darboux is a Kirchhoff-Love shell; CalculiX' shells are expanded to bricks, which shear. The two
// theories have limits of their own. "own" is the error against the limit of the solver's theory,
// "published" against the number in the literature, where there is one.
//
// Sample run: tests/peer_benchmark --ccx=ccx --repeats=3
#include <fcntl.h>
#include <gflags/gflags.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/calculix_deck.h"

DEFINE_string(ccx, "ccx", "CalculiX: a name on the path or a file.");
DEFINE_string(problems, "", "Names, joined by commas; all of them by default.");
DEFINE_int32(repeats, 1, "Runs of each, in turns; the least seconds count.");
DEFINE_int32(levels, 100, "The coarsest resolutions of each problem that are run.");
DEFINE_double(max_cpu, 300, "Processor seconds after which a run is stopped.");
DEFINE_string(work, "", "Folder for decks and results, kept; a temporary one by default.");

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Element = CalculixElement;

constexpr double kPi = 3.14159265358979323846;

// ---- Problems -------------------------------------------------------------------------------

// A displacement, with what it should be.
struct Quantity {
  std::string probe;
  int component;
  int corner_s, corner_t;  // where it is on the patch
  double kirchhoff_love, shearing;
  std::optional<double> published;
};

struct Problem {
  std::string name;
  std::string note;   // where the limits come from
  std::string scene;  // text of a scene, or the name of a file in data/
  std::vector<std::array<int, 2>> divisions;
  std::vector<Quantity> quantities;
  std::vector<std::pair<Element, std::array<int, 2>>> peers;
  std::function<CalculixMesh(Element, std::array<int, 2>)> mesh;
  std::function<CalculixDeck(const CalculixMesh&)> deck;
};

std::vector<CalculixFix> Fixed(const CalculixMesh& mesh,
                               std::initializer_list<std::pair<CalculixMesh::Side, int>> which) {
  std::vector<CalculixFix> list;
  for (const auto& [side, direction] : which) {
    list.push_back({mesh.SideNodes(side), direction, direction});
  }
  return list;
}

CalculixFix Clamped(const CalculixMesh& mesh, CalculixMesh::Side side) {
  return {mesh.SideNodes(side), 1, mesh.IsSolid() ? 3 : 6};
}

// Bricks have no rotations.
void FixRotation(const CalculixMesh& mesh,
                 CalculixMesh::Side side,
                 int direction,
                 CalculixDeck* deck) {
  if (!mesh.IsSolid()) deck->fixed.push_back({mesh.SideNodes(side), direction, direction});
}

void Add(std::vector<CalculixFix> more, CalculixDeck* deck) {
  deck->fixed.insert(deck->fixed.end(), more.begin(), more.end());
}

// As the key grading of a scene: equal steps of q, denser towards the upper end (g > 0), or the
// lower one.
double Graded(double q, double g) {
  const double r = g > 0 ? 1 - q : q, a = std::abs(g);
  const double d = (1 - a) * r + a * r * r;
  return g > 0 ? 1 - d : d;
}

std::vector<std::pair<Element, std::array<int, 2>>> Peers(
    Element element, std::initializer_list<std::array<int, 2>> sizes) {
  std::vector<std::pair<Element, std::array<int, 2>>> list;
  for (const std::array<int, 2>& size : sizes) list.emplace_back(element, size);
  return list;
}

template <typename T>
std::vector<T> Joined(std::vector<T> a, const std::vector<T>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Problem ClampedPlate() {
  Problem problem;
  problem.name = "clamped_plate";
  problem.note =
      "a quarter; Kirchhoff: Legendre-Galerkin series, 11 digits (data/clamped_plate.yaml); "
      "shearing: bricks, extrapolated";
  problem.scene =
      "name: quarter-plate\n"
      "surface: {kind: plane, u: [0, 50], v: [0, 50], divisions: [8, 8]}\n"
      "shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
      "supports:\n  - {on: u_min, symmetry: x}\n  - {on: v_min, symmetry: y}\n"
      "  - {on: u_max, clamped: true}\n  - {on: v_max, clamped: true}\n"
      "loads: [{kind: normal_traction, value: 1}]\n"
      "probes: [{name: centre, at: {uv: [0, 0]}}]\n";
  problem.divisions = {{4, 4}, {8, 8}, {16, 16}, {32, 32}};
  problem.quantities = {{"centre", 2, 0, 0, 0.13817284435, 0.13842, std::nullopt}};
  problem.peers = Joined(Peers(Element::kS8R, {{2, 2}, {4, 4}, {8, 8}, {16, 16}}),
                         Peers(Element::kC3D20R, {{2, 2}, {4, 4}, {8, 8}, {16, 16}, {32, 32}}));
  problem.mesh = [](Element element, std::array<int, 2> cells) {
    return CalculixMesh(element, cells, 1.0, [](double s, double t) {
      return PatchPoint{{50 * Graded(s, 0.85), 50 * Graded(t, 0.85), 0}, Vector3d::UnitZ()};
    });
  };
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck;
    deck.young_modulus = 1e7;
    deck.poisson_ratio = 0.3;
    deck.fixed = Fixed(mesh, {{CalculixMesh::kSMin, 1}, {CalculixMesh::kTMin, 2}});
    FixRotation(mesh, CalculixMesh::kSMin, 5, &deck);
    FixRotation(mesh, CalculixMesh::kTMin, 4, &deck);
    Add({Clamped(mesh, CalculixMesh::kSMax), Clamped(mesh, CalculixMesh::kTMax)}, &deck);
    deck.forces = mesh.AreaForces([](const Vector3d&) { return Vector3d::UnitZ(); });
    return deck;
  };
  return problem;
}

// One eighth of the cylinder of data/pinched_cylinder.yaml, cells graded alike for both solvers.
CalculixMesh PinchedMesh(Element element, std::array<int, 2> cells) {
  return CalculixMesh(element, cells, 3.0, [](double s, double t) {
    const double x = 300 * Graded(s, 0.85), v = 0.5 * kPi * Graded(t, -0.85);
    const Vector3d normal(0, std::sin(v), std::cos(v));
    return PatchPoint{300 * normal + x * Vector3d::UnitX(), normal};
  });
}

CalculixDeck PinchedDeck(const CalculixMesh& mesh) {
  CalculixDeck deck;
  deck.young_modulus = 3e6;
  deck.poisson_ratio = 0.3;
  if (mesh.IsSolid()) {
    deck.fixed = Fixed(mesh,
                       {{CalculixMesh::kSMin, 2},
                        {CalculixMesh::kSMin, 3},
                        {CalculixMesh::kSMax, 1},
                        {CalculixMesh::kTMin, 2},
                        {CalculixMesh::kTMax, 3}});
  } else {
    deck.cylindrical = true;
    deck.fixed = Fixed(mesh,
                       {{CalculixMesh::kSMin, 1},
                        {CalculixMesh::kSMin, 2},
                        {CalculixMesh::kSMax, 3},
                        {CalculixMesh::kSMax, 5},
                        {CalculixMesh::kTMin, 2},
                        {CalculixMesh::kTMin, 6},
                        {CalculixMesh::kTMax, 2},
                        {CalculixMesh::kTMax, 6}});
  }
  return deck;
}

Problem PinchedPoint() {
  Problem problem;
  problem.name = "pinched_cylinder";
  problem.note =
      "an eighth, graded 0.85; both against the Kirchhoff-Love series, 10 digits, which are also "
      "the published 1.8248e-5: with shear a point force has no limit, its dent grows with the "
      "mesh";
  problem.scene = "pinched_cylinder.yaml";
  problem.divisions = {{8, 8}, {16, 16}, {32, 32}, {64, 64}};
  problem.quantities = {{"under_load", 2, 1, 0, -1.828195199e-5, -1.828195199e-5, -1.8248e-5}};
  problem.peers = Joined(Peers(Element::kS8R, {{4, 4}, {8, 8}, {16, 16}, {32, 32}}),
                         Peers(Element::kC3D20R, {{4, 4}, {8, 8}, {16, 16}, {32, 32}}));
  problem.mesh = PinchedMesh;
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck = PinchedDeck(mesh);
    deck.forces = mesh.CornerForces(1, 0, {0, 0, -0.25});
    return deck;
  };
  return problem;
}

Problem PinchedPatch() {
  Problem problem;
  problem.name = "pinched_patch";
  problem.note =
      "the same, the unit force spread as a Gaussian of 15 = 5 h; each against its own "
      "extrapolation";
  problem.scene =
      "name: pinched-patch\n"
      "surface: {kind: cylinder, radius: 300, u: [0, 300], v: [0, pi/2], divisions: [16, 16], "
      "grading: [0.85, -0.85]}\n"
      "shell: {thickness: 3, young_modulus: 3.0e6, poisson_ratio: 0.3}\nmodel: {theory: linear}\n"
      "supports:\n  - {on: u_min, fix: [y, z]}\n  - {on: u_max, symmetry: x}\n"
      "  - {on: v_min, symmetry: y}\n  - {on: v_max, symmetry: z}\n"
      "loads:\n  - kind: traction\n"
      "    force: [\"0\", \"0\", \"-exp(-((u-300)^2+(300*v)^2)/450)/(450*pi)\"]\n"
      "probes: [{name: under_load, at: {uv: [300, 0]}}]\n";
  problem.divisions = {{8, 8}, {16, 16}, {32, 32}, {64, 64}};
  problem.quantities = {{"under_load", 2, 1, 0, -1.525774e-5, -1.52814e-5, std::nullopt}};
  problem.peers = Joined(Peers(Element::kS8R, {{4, 4}, {8, 8}, {16, 16}, {32, 32}}),
                         Peers(Element::kC3D20R, {{4, 4}, {8, 8}, {16, 16}, {32, 32}}));
  problem.mesh = PinchedMesh;
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck = PinchedDeck(mesh);
    deck.forces = mesh.AreaForces([](const Vector3d& x) {
      const double u = x.x() - 300, arc = 300 * std::atan2(x.y(), x.z());
      return Vector3d(0, 0, -std::exp(-(u * u + arc * arc) / 450) / (450 * kPi));
    });
    return deck;
  };
  return problem;
}

Problem Cantilever() {
  Problem problem;
  problem.name = "cantilever";
  problem.note =
      "Sze, Liu & Lo 2004, 3.1, P = 4; both against the Kirchhoff-Love strip, 9 digits "
      "(data/cantilever_shear.yaml): shear moves the linear tip by 1e-4";
  problem.scene = "cantilever_shear.yaml";
  problem.divisions = {{6, 1}, {12, 1}, {24, 1}, {48, 2}};
  problem.quantities = {{"tip", 0, 1, 0, -3.28954362, -3.28954362, -3.286},
                        {"tip", 2, 1, 0, 6.69988894, 6.69988894, 6.698}};
  problem.peers = Joined(Peers(Element::kS8R, {{4, 2}, {8, 2}, {16, 2}, {32, 2}}),
                         Peers(Element::kC3D20R, {{4, 2}, {8, 2}, {16, 2}, {32, 4}}));
  problem.mesh = [](Element element, std::array<int, 2> cells) {
    return CalculixMesh(element, cells, 0.1, [](double s, double t) {
      return PatchPoint{{10 * s, t, 0}, Vector3d::UnitZ()};
    });
  };
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck;
    deck.young_modulus = 1.2e6;
    deck.nonlinear = true;
    deck.first_increment = deck.largest_increment = 0.5;  // The fastest: 0.1 takes twice as long.
    deck.fixed = {Clamped(mesh, CalculixMesh::kSMin)};
    deck.forces = mesh.SideForces(CalculixMesh::kSMax, {0, 0, 4});
    return deck;
  };
  return problem;
}

Problem Hemisphere() {
  Problem problem;
  problem.name = "hemisphere";
  problem.note =
      "Sze, Liu & Lo 2004, 3.4, P = 400, a quarter; own: Darboux extrapolated, CalculiX published";
  problem.scene = "pinched_hemisphere.yaml";
  problem.divisions = {{10, 10}, {16, 16}, {24, 24}, {40, 40}};
  problem.quantities = {{"pulled", 0, 0, 0, 4.067, 4.067, 4.067},
                        {"pinched", 1, 1, 0, -8.178, -8.178, -8.178}};
  problem.peers = Peers(Element::kC3D20R, {{8, 8}, {16, 16}, {24, 24}});
  problem.mesh = [](Element element, std::array<int, 2> cells) {
    return CalculixMesh(element, cells, 0.04, [](double s, double t) {
      const double u = 0.5 * kPi * s, v = 0.4 * kPi * t;
      const Vector3d normal(std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v));
      return PatchPoint{10 * normal, normal};
    });
  };
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck;
    deck.young_modulus = 6.825e7;
    deck.poisson_ratio = 0.3;
    deck.nonlinear = true;
    deck.first_increment = 0.05;
    deck.fixed = Fixed(mesh, {{CalculixMesh::kSMin, 2}, {CalculixMesh::kSMax, 1}});
    deck.fixed.push_back({{mesh.CornerNode(0, 0)}, 3, 3});
    deck.forces = mesh.CornerForces(0, 0, {200, 0, 0});
    for (const auto& [node, force] : mesh.CornerForces(1, 0, {0, -200, 0})) {
      deck.forces.emplace(node, Vector3d::Zero()).first->second += force;
    }
    return deck;
  };
  return problem;
}

Problem Annulus() {
  Problem problem;
  problem.name = "slit_annulus";
  problem.note =
      "Sze, Liu & Lo 2004, 3.3; own: Kirchhoff-Love 13.8447, 17.4823 (darboux_accuracy, uncertain "
      "by "
      "0.013 %); shearing: that, moved by the edge layer, 13.8636, 17.5012 (README.md)";
  problem.scene = "slit_annulus.yaml";
  problem.divisions = {{3, 30}, {4, 40}, {6, 60}, {10, 100}};
  problem.quantities = {{"inner", 2, 0, 1, 13.8447, 13.8636, 13.891},
                        {"outer", 2, 1, 1, 17.4823, 17.5012, 17.528}};
  problem.peers = Joined(Peers(Element::kS8R, {{2, 16}, {4, 30}}),
                         Peers(Element::kC3D20R, {{2, 16}, {3, 30}, {6, 60}}));
  problem.mesh = [](Element element, std::array<int, 2> cells) {
    return CalculixMesh(element, cells, 0.03, [](double s, double t) {
      const double r = 6 + 4 * s, v = 2 * kPi * t;
      return PatchPoint{{r * std::cos(v), r * std::sin(v), 0}, Vector3d::UnitZ()};
    });
  };
  problem.deck = [](const CalculixMesh& mesh) {
    CalculixDeck deck;
    deck.young_modulus = 21e6;
    deck.nonlinear = true;
    deck.first_increment = 0.02;
    deck.largest_increment = 0.05;
    deck.fixed = {Clamped(mesh, CalculixMesh::kTMin)};
    deck.forces = mesh.SideForces(CalculixMesh::kTMax, {0, 0, 0.8});
    return deck;
  };
  return problem;
}

// ---- Runs -----------------------------------------------------------------------------------

struct Process {
  bool ended = false;  // by itself, with whatever status
  int status = -1;
  double cpu_s = 0.0, memory_mb = 0.0;
};

// Runs a program in a folder, its output in a file there, on one thread.
Process RunProcess(const std::vector<std::string>& command,
                   const std::string& folder,
                   const std::string& log) {
  Process process;
  const pid_t child = fork();
  if (child < 0) return process;
  if (child == 0) {
    if (chdir(folder.c_str()) != 0) _exit(127);
    for (const char* variable : {"OMP_NUM_THREADS",
                                 "OPENBLAS_NUM_THREADS",
                                 "CCX_NPROC_STIFFNESS",
                                 "CCX_NPROC_RESULTS",
                                 "CCX_NPROC_EQUATION_SOLVER"}) {
      setenv(variable, "1", 1);
    }
    const int file = open(log.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0644);
    if (file < 0) _exit(127);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    const rlim_t seconds = static_cast<rlim_t>(std::ceil(FLAGS_max_cpu));
    const rlimit limit{seconds, seconds + 1};
    setrlimit(RLIMIT_CPU, &limit);
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  const auto seconds = [](const timeval& t) { return t.tv_sec + 1e-6 * t.tv_usec; };
  process.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  process.memory_mb = usage.ru_maxrss / 1024.0;
  process.ended = WIFEXITED(status);
  process.status = process.ended ? WEXITSTATUS(status) : -1;
  return process;
}

std::string ReadFile(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

struct Row {
  bool is_darboux = true;
  std::string element;
  std::array<int, 2> size{};
  std::string failure;  // empty: solved
  int unknowns = -1, iterations = -1;
  std::vector<double> values;
  double own_error = -1.0, published_error = -1.0;
  double cpu_s = std::numeric_limits<double>::infinity(), memory_mb = 0.0;
};

std::string SizeText(const std::array<int, 2>& size) {
  return std::to_string(size[0]) + " x " + std::to_string(size[1]);
}

void RunDarboux(const Problem& problem, const fs::path& work, Row* row) {
  std::string scene = problem.scene;
  if (scene.find('\n') == std::string::npos) {
    scene = std::string(DARBOUX_DATA_DIR) + "/" + scene;
  } else {
    scene = (work / (problem.name + ".yaml")).string();
    std::ofstream(scene) << problem.scene;
  }
  const std::string divisions = std::to_string(row->size[0]) + "," + std::to_string(row->size[1]);
  const Process process = RunProcess({DARBOUX_DEFORM,
                                      scene,
                                      "--divisions=" + divisions,
                                      "--threads=1",
                                      "--quiet",
                                      "--out=darboux"},
                                     work.string(),
                                     "darboux.log");
  row->cpu_s = std::min(row->cpu_s, process.cpu_s);
  row->memory_mb = process.memory_mb;
  // Status 1: converged, but beside the scene's tolerance.
  if (!process.ended || process.status > 1) {
    row->failure = process.ended ? "status " + std::to_string(process.status) : "stopped";
    return;
  }
  const auto json =
      nlohmann::json::parse(ReadFile(work / "darboux" / "summary.json"), nullptr, false);
  if (json.is_discarded() || !json["converged"].get<bool>()) {
    row->failure = "not converged";
    return;
  }
  row->unknowns = json["dof"].get<int>();
  row->iterations = json["iterations"].get<int>();
  row->values.clear();
  for (const Quantity& quantity : problem.quantities) {
    const char* const names[] = {"x", "y", "z"};
    row->values.push_back(
        json["probes"][quantity.probe]["displacement"][names[quantity.component]].get<double>());
  }
}

// Lines of the .cvg file that begin with a number are iterations.
int CountIterations(const std::string& cvg) {
  int count = 0;
  std::istringstream lines(cvg);
  std::string line;
  while (std::getline(lines, line)) {
    int step, increment;
    if (std::sscanf(line.c_str(), "%d %d", &step, &increment) == 2) ++count;
  }
  return count;
}

void RunCalculix(const Problem& problem, Element element, const fs::path& work, Row* row) {
  const CalculixMesh mesh = problem.mesh(element, row->size);
  CalculixDeck deck = problem.deck(mesh);
  for (const Quantity& quantity : problem.quantities) {
    deck.printed.push_back(mesh.CornerNode(quantity.corner_s, quantity.corner_t));
  }
  std::ofstream(work / "job.inp") << MakeDeck(mesh, deck);
  for (const char* old : {"job.dat", "job.cvg", "job.sta"}) fs::remove(work / old);
  const Process process = RunProcess({FLAGS_ccx, "job"}, work.string(), "job.log");
  row->cpu_s = std::min(row->cpu_s, process.cpu_s);
  row->memory_mb = process.memory_mb;
  const std::string log = ReadFile(work / "job.log");
  std::map<int, Vector3d> displacements;
  if (!process.ended || log.find("Job finished") == std::string::npos ||
      !ReadDat(ReadFile(work / "job.dat"), &displacements)) {
    const size_t error = log.find("*ERROR");
    row->failure = !process.ended               ? "stopped"
                   : error == std::string::npos ? "failed"
                                                : log.substr(error, log.find('\n', error) - error);
    return;
  }
  const std::string key = "number of equations";
  const size_t at = log.rfind(key);
  if (at != std::string::npos) row->unknowns = std::atoi(log.c_str() + at + key.size());
  row->iterations = deck.nonlinear ? CountIterations(ReadFile(work / "job.cvg")) : 1;
  row->values.clear();
  for (size_t i = 0; i < problem.quantities.size(); ++i) {
    row->values.push_back(displacements[deck.printed[i]][problem.quantities[i].component]);
  }
}

void SetErrors(const Problem& problem, Row* row) {
  if (row->values.size() != problem.quantities.size()) return;
  row->own_error = 0.0;
  for (size_t i = 0; i < row->values.size(); ++i) {
    const Quantity& quantity = problem.quantities[i];
    const double own = row->is_darboux ? quantity.kirchhoff_love : quantity.shearing;
    row->own_error = std::max(row->own_error, std::abs(row->values[i] / own - 1.0));
    if (quantity.published) {
      row->published_error =
          std::max(row->published_error, std::abs(row->values[i] / *quantity.published - 1.0));
    }
  }
}

void PrintRow(const Problem& problem, const Row& row) {
  std::printf("| %s | %s | %s | ",
              problem.name.c_str(),
              row.is_darboux ? "Darboux" : ("CalculiX " + row.element).c_str(),
              SizeText(row.size).c_str());
  if (!row.failure.empty()) {
    std::printf("%s | | | | %.2f | %.0f | |\n", row.failure.c_str(), row.cpu_s, row.memory_mb);
    return;
  }
  std::printf("%d | %d | %.3g %% | ", row.unknowns, row.iterations, 100 * row.own_error);
  if (row.published_error >= 0.0) {
    std::printf("%.3g %%", 100 * row.published_error);
  } else {
    std::printf("-");
  }
  std::printf(" | %.3g | %.0f |", row.cpu_s, row.memory_mb);
  for (const double value : row.values) std::printf(" %.8g", value);
  std::printf(" |\n");
}

// The cheapest row within an error, or null.
const Row* Cheapest(const std::vector<Row>& rows, bool darboux, double target, bool published) {
  const Row* best = nullptr;
  for (const Row& row : rows) {
    const double error = published ? row.published_error : row.own_error;
    if (row.is_darboux != darboux || !row.failure.empty() || error < 0.0 || error > target)
      continue;
    if (best == nullptr || row.cpu_s < best->cpu_s) best = &row;
  }
  return best;
}

void PrintVerdicts(const Problem& problem, const std::vector<Row>& rows, bool published) {
  for (const double target : {0.03, 0.01, 0.003, 0.001}) {
    const Row* const d = Cheapest(rows, true, target, published);
    const Row* const c = Cheapest(rows, false, target, published);
    std::printf(
        "%s, %g %% (%s): ", problem.name.c_str(), 100 * target, published ? "published" : "own");
    const auto print = [](const char* name, const Row& row) {
      const std::string element = row.element.empty() ? "" : " " + row.element;
      std::printf("%s%s %s %.3g s", name, element.c_str(), SizeText(row.size).c_str(), row.cpu_s);
    };
    if (d == nullptr && c == nullptr) {
      std::printf("neither");
    } else if (d == nullptr || c == nullptr) {
      std::printf("only ");
      print(d != nullptr ? "Darboux" : "CalculiX", d != nullptr ? *d : *c);
    } else {
      const bool wins = d->cpu_s < c->cpu_s;
      print(wins ? "Darboux" : "CalculiX", wins ? *d : *c);
      std::printf(", ");
      print(wins ? "CalculiX" : "Darboux", wins ? *c : *d);
      std::printf(": %.3g times", wins ? c->cpu_s / d->cpu_s : d->cpu_s / c->cpu_s);
    }
    std::printf("\n");
  }
}

bool Compare(const Problem& problem, const fs::path& work) {
  std::vector<Row> rows;
  std::vector<Element> elements;
  const auto add = [&](bool darboux, Element element, const std::array<int, 2>& size) {
    Row row;
    row.is_darboux = darboux;
    row.element = darboux ? "" : ToString(element);
    row.size = size;
    rows.push_back(row);
    elements.push_back(element);
  };
  std::map<Element, int> levels;
  for (size_t i = 0; i < problem.divisions.size(); ++i) {
    if (static_cast<int>(i) < FLAGS_levels) add(true, Element::kS4, problem.divisions[i]);
  }
  for (const auto& [element, size] : problem.peers) {
    if (levels[element]++ < FLAGS_levels) add(false, element, size);
  }
  // In turns: one of each solver, so that a busy machine is busy for both.
  std::vector<size_t> order;
  const size_t num_darboux =
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.is_darboux; });
  for (size_t i = 0; i < rows.size(); ++i) {
    if (i < num_darboux) order.push_back(i);
    if (num_darboux + i < rows.size()) order.push_back(num_darboux + i);
  }
  for (int repeat = 0; repeat < std::max(1, FLAGS_repeats); ++repeat) {
    for (const size_t i : order) {
      if (repeat > 0 && !rows[i].failure.empty()) continue;
      if (rows[i].is_darboux) {
        RunDarboux(problem, work, &rows[i]);
      } else {
        RunCalculix(problem, elements[i], work, &rows[i]);
      }
    }
  }
  std::printf("\n%s: %s\n\n", problem.name.c_str(), problem.note.c_str());
  std::printf(
      "| problem | solver | cells | dof / equations | iterations | error, own limit | "
      "error, published | cpu s | MB | values |\n|---|---|---|---|---|---|---|---|---|---|\n");
  bool any_failure = false, any_published = false;
  for (Row& row : rows) {
    if (row.failure.empty()) SetErrors(problem, &row);
    PrintRow(problem, row);
    any_failure = any_failure || (!row.failure.empty() && row.failure != "stopped");
    any_published = any_published || row.published_error >= 0.0;
  }
  std::printf("\n");
  PrintVerdicts(problem, rows, false);
  if (any_published) PrintVerdicts(problem, rows, true);
  std::fflush(stdout);
  return !any_failure;
}

bool IsOnPath(const std::string& program) {
  if (program.find('/') != std::string::npos) return access(program.c_str(), X_OK) == 0;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

int Run() {
  if (!IsOnPath(FLAGS_ccx)) {
    std::fprintf(stderr,
                 "peer_benchmark: --ccx: found no program '%s'; install CalculiX CrunchiX (Debian: "
                 "apt-get install calculix-ccx) or name its file\n",
                 FLAGS_ccx.c_str());
    return 2;
  }
  const std::vector<Problem> all = {
      ClampedPlate(), PinchedPoint(), PinchedPatch(), Cantilever(), Hemisphere(), Annulus()};
  std::vector<const Problem*> chosen;
  std::istringstream names(FLAGS_problems);
  std::string name, allowed;
  for (const Problem& problem : all) {
    allowed += (allowed.empty() ? "" : ", ") + problem.name;
    if (FLAGS_problems.empty()) chosen.push_back(&problem);
  }
  while (std::getline(names, name, ',')) {
    const auto found = std::find_if(
        all.begin(), all.end(), [&name](const Problem& problem) { return problem.name == name; });
    if (found == all.end()) {
      std::fprintf(stderr,
                   "peer_benchmark: --problems: found '%s'; allowed %s\n",
                   name.c_str(),
                   allowed.c_str());
      return 2;
    }
    chosen.push_back(&*found);
  }
  const bool keep = !FLAGS_work.empty();
  const fs::path work =
      keep ? fs::absolute(FLAGS_work)
           : fs::temp_directory_path() / ("darboux_peer_benchmark_" + std::to_string(getpid()));
  std::error_code code;
  fs::create_directories(work, code);
  if (code) {
    std::fprintf(stderr, "peer_benchmark: --work: found %s\n", code.message().c_str());
    return 2;
  }
  bool done = true;
  for (const Problem* problem : chosen) done = Compare(*problem, work) && done;
  if (!keep) fs::remove_all(work, code);
  return done ? 0 : 1;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  return darboux::Run();
}
