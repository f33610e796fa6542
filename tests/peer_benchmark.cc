// Darboux and CalculiX side by side on the same shells: each as its users run it, a whole process
// on one thread, in turns, CalculiX with the decks that Darboux exports. Prints, for each run,
// unknowns, iterations, errors, processor seconds and peak memory, and who needs less time for 3 %,
// 1 %, 0.3 % and 0.1 %. Asserts only that runs succeed.
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
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "solver/inp_export.h"
#include "solver/scene_reader.h"
#include "tests/calculix_dat.h"
#include "tests/peer_problems.h"

DEFINE_string(ccx, "ccx", "CalculiX: a name on the path or a file.");
DEFINE_string(problems, "", "Names, joined by commas; all of them by default.");
DEFINE_int32(repeats, 1, "Runs of each, in turns; the least seconds count.");
DEFINE_int32(levels, 100, "The coarsest resolutions of each problem that are run.");
DEFINE_double(max_cpu, 300, "Processor seconds after which a run is stopped.");
DEFINE_string(work, "", "Folder for decks and results, kept; a temporary one by default.");

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Element = InpElement;

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

void RunDarboux(const PeerProblem& problem, const fs::path& work, Row* row) {
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
  for (const PeerQuantity& quantity : problem.quantities) {
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

// The deck that darboux_deform --export=inp writes, for other cells and elements. Empty and *error
// where there is none.
std::string MakePeerDeck(const PeerProblem& problem,
                         Element element,
                         const std::array<int, 2>& size,
                         bool* nonlinear,
                         std::string* error) {
  Scene scene;
  const bool is_file = problem.scene.find('\n') == std::string::npos;
  if (!(is_file ? ReadScene(std::string(DARBOUX_DATA_DIR) + "/" + problem.scene, &scene, error)
                : ParseScene(problem.scene, problem.name, &scene, error))) {
    return "";
  }
  scene.surface.divisions = size;
  if (problem.peer_grading) scene.surface.grading = *problem.peer_grading;
  *nonlinear = scene.model.theory == Theory::kNonlinear;
  ShellProblem::Options options;
  options.nonlinear = *nonlinear;
  const std::unique_ptr<ShellProblem> shell = ShellProblem::Create(scene, options, error);
  if (shell == nullptr) return "";
  InpOptions inp;
  inp.element = element;
  inp.increments = problem.increments;
  InpDeck deck;
  return MakeInpDeck(*shell, inp, &deck, error) ? deck.text : "";
}

void RunCalculix(const PeerProblem& problem, Element element, const fs::path& work, Row* row) {
  bool nonlinear = false;
  std::string error;
  const std::string deck = MakePeerDeck(problem, element, row->size, &nonlinear, &error);
  if (deck.empty()) {
    row->failure = error;
    return;
  }
  std::ofstream(work / "job.inp") << deck;
  for (const char* old : {"job.dat", "job.cvg", "job.sta"}) fs::remove(work / old);
  // The process changes its folder.
  const std::string program =
      FLAGS_ccx.find('/') == std::string::npos ? FLAGS_ccx : fs::absolute(FLAGS_ccx).string();
  const Process process = RunProcess({program, "job"}, work.string(), "job.log");
  row->cpu_s = std::min(row->cpu_s, process.cpu_s);
  row->memory_mb = process.memory_mb;
  const std::string log = ReadFile(work / "job.log");
  const CalculixResult result = ReadCalculixDat(ReadFile(work / "job.dat"));
  if (!process.ended || log.find("Job finished") == std::string::npos || result.probes.empty()) {
    const size_t at = log.find("*ERROR");
    row->failure = !process.ended            ? "stopped"
                   : at == std::string::npos ? "failed"
                                             : log.substr(at, log.find('\n', at) - at);
    return;
  }
  const std::string key = "number of equations";
  const size_t at = log.rfind(key);
  if (at != std::string::npos) row->unknowns = std::atoi(log.c_str() + at + key.size());
  row->iterations = nonlinear ? CountIterations(ReadFile(work / "job.cvg")) : 1;
  row->values.clear();
  for (const PeerQuantity& quantity : problem.quantities) {
    row->values.push_back(result.probes.at(Upper(quantity.probe))[quantity.component]);
  }
}

void SetErrors(const PeerProblem& problem, Row* row) {
  if (row->values.size() != problem.quantities.size()) return;
  row->own_error = 0.0;
  for (size_t i = 0; i < row->values.size(); ++i) {
    const PeerQuantity& quantity = problem.quantities[i];
    const double own = row->is_darboux ? quantity.kirchhoff_love : quantity.shearing;
    row->own_error = std::max(row->own_error, std::abs(row->values[i] / own - 1.0));
    if (quantity.published) {
      row->published_error =
          std::max(row->published_error, std::abs(row->values[i] / *quantity.published - 1.0));
    }
  }
}

void PrintRow(const PeerProblem& problem, const Row& row) {
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

void PrintVerdicts(const PeerProblem& problem, const std::vector<Row>& rows, bool published) {
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

bool Compare(const PeerProblem& problem, const fs::path& work) {
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
  const std::vector<PeerProblem> all = MakePeerProblems();
  std::vector<const PeerProblem*> chosen;
  std::istringstream names(FLAGS_problems);
  std::string name, allowed;
  for (const PeerProblem& problem : all) {
    allowed += (allowed.empty() ? "" : ", ") + problem.name;
    if (FLAGS_problems.empty()) chosen.push_back(&problem);
  }
  while (std::getline(names, name, ',')) {
    const auto found = std::find_if(all.begin(), all.end(), [&name](const PeerProblem& problem) {
      return problem.name == name;
    });
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
  for (const PeerProblem* problem : chosen) done = Compare(*problem, work) && done;
  if (!keep) fs::remove_all(work, code);
  return done ? 0 : 1;
}

}  // namespace
}  // namespace darboux

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  return darboux::Run();
}
