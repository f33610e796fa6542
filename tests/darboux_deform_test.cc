// The tool as its users meet it: command line in, exit status and files out.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace darboux {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kPlate[] = R"(name: clamped-plate
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [16, 16]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1}]
probes: [{name: centre, at: {uv: [50, 50]}}]
)";

// The same in metres, Newtons and Pascals.
constexpr char kPlateMetres[] = R"(name: clamped-plate
surface: {kind: plane, u: [0, 0.1], v: [0, 0.1], divisions: [16, 16]}
shell: {thickness: 0.001, young_modulus: 1.0e13, poisson_ratio: 0.3}
model: {theory: linear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 1.0e6}]
probes: [{name: centre, at: {uv: [0.05, 0.05]}}]
)";

// Takes far longer than any test waits.
constexpr char kLong[] = R"(name: long
surface: {kind: plane, u: [0, 100], v: [0, 100], divisions: [24, 24]}
shell: {thickness: 1, young_modulus: 1.0e7, poisson_ratio: 0.3}
model: {theory: nonlinear}
supports: [{on: rim, clamped: true}]
loads: [{kind: normal_traction, value: 50}]
steps: 5000
probes: [{name: centre, at: {uv: [50, 50]}}]
)";

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::set<std::string> FilesIn(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

class DarbouxDeformTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) /
              ("darboux_deform_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "tmp");
    Scene("plate.yaml", kPlate);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Writes a scene; returns its path.
  std::string Scene(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string Plate() const { return (folder_ / "plate.yaml").string(); }
  fs::path Out() const { return folder_ / "out"; }
  std::string OutFlag() const { return "--out=" + Out().string(); }
  Json Summary() const { return Json::parse(ReadFile(Out() / "summary.json"), nullptr, false); }
  std::string Stdout() const { return ReadFile(folder_ / "stdout"); }
  std::string Stderr() const { return ReadFile(folder_ / "stderr"); }

  // Starts the tool in folder_, with a folder for temporary files that is watched.
  pid_t Start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {DARBOUX_DEFORM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string out = (folder_ / "stdout").string(), err = (folder_ / "stderr").string();
    const std::string temporary = (folder_ / "tmp").string();
    fs::remove(err);  // Nobody shall read what an earlier run said.
    const pid_t pid = fork();
    if (pid != 0) return pid;
    setenv("TMPDIR", temporary.c_str(), 1);
    const int out_file = open(out.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
    const int err_file = open(err.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
    dup2(out_file, STDOUT_FILENO);
    dup2(err_file, STDERR_FILENO);
    if (chdir(folder_.c_str()) != 0) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }

  // Exit status; 128 + number where a signal ended it.
  static int Wait(pid_t pid) {
    int status = 0;
    EXPECT_EQ(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  int Run(const std::vector<std::string>& arguments) {
    const int status = Wait(Start(arguments));
    EXPECT_TRUE(FilesIn(folder_ / "tmp").empty()) << "a file outside --out";
    return status;
  }

  // Waits until the tool has reported a load step.
  void WaitForAStep() const {
    for (int i = 0; i < 6000 && Stderr().find("step 1/") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_THAT(Stderr(), HasSubstr("step 1/"));
  }

  // All files of `steps` load steps are there, complete and finite.
  void ExpectCompleteResults(size_t steps) const {
    std::set<std::string> names = {
        "summary.json", "shell.vtu", "shell.pvd", "deformed.ply", "history.csv"};
    for (size_t i = 1; i <= steps; ++i) {
      const std::string number = std::to_string(i);
      names.insert("shell_" + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number +
                   ".vtu");
    }
    EXPECT_EQ(FilesIn(Out()), names);
    for (const std::string& name : names) {
      const std::string text = ReadFile(Out() / name);
      EXPECT_FALSE(text.empty()) << name;
      if (name.find(".vtu") != std::string::npos || name == "shell.pvd") {
        EXPECT_THAT(text.substr(text.size() - 11), "</VTKFile>\n") << name;
      }
      if (name == "history.csv" || name == "summary.json") {
        EXPECT_EQ(text.find("nan"), std::string::npos);
        EXPECT_EQ(text.find("inf,"), std::string::npos);
      }
    }
    const Json summary = Summary();
    ASSERT_TRUE(summary.is_object());
    EXPECT_EQ(summary["load_steps"].size(), steps);
  }

  fs::path folder_;
};

TEST_F(DarbouxDeformTest, ConvergedSceneWhoseExpectationsHoldExitsWithZero) {
  const std::string scene = Scene("scene.yaml",
                                  std::string(kPlate) +
                                      "expect: [{quantity: probes.centre.displacement.z, "
                                      "value: 0.13817, relative_tolerance: 0.001}]\n");
  EXPECT_EQ(Run({scene, OutFlag()}), 0) << Stderr();
  ExpectCompleteResults(1);
  EXPECT_THAT(Stdout(), HasSubstr("expect OK      probes.centre.displacement.z = 0.1381"));
  EXPECT_THAT(Stdout(), HasSubstr("results in " + Out().string()));
  EXPECT_THAT(Stderr(), HasSubstr("step 1/1"));
  EXPECT_NEAR(Summary()["probes"]["centre"]["displacement"]["z"].get<double>(), 0.13817, 2e-5);
}

TEST_F(DarbouxDeformTest, FailingExpectationExitsWithOneAndKeepsTheResults) {
  const std::string scene =
      Scene("scene.yaml",
            std::string(kPlate) +
                "expect: [{quantity: probes.centre.displacement.z, value: 0.2, "
                "relative_tolerance: 0.001}]\n");
  EXPECT_EQ(Run({scene, OutFlag(), "--quiet"}), 1);
  ExpectCompleteResults(1);
  EXPECT_EQ(Summary()["converged"], true);
  EXPECT_EQ(Summary()["expect"][0]["holds"], false);
  EXPECT_EQ(Stdout(), "");
  EXPECT_THAT(Stderr(), HasSubstr("expectation FAILED  probes.centre.displacement.z"));
}

TEST_F(DarbouxDeformTest, ExpectationsAreEvaluatedWithOverridesToo) {
  const std::string scene = Scene("scene.yaml",
                                  std::string(kPlate) +
                                      "expect: [{quantity: elements, value: 512, "
                                      "absolute_tolerance: 0.5}]\n");
  EXPECT_EQ(Run({scene, OutFlag(), "--divisions=4,6"}), 1);
  EXPECT_EQ(Summary()["elements"], 48);
  EXPECT_THAT(Stdout(), HasSubstr("not for --divisions"));
}

TEST_F(DarbouxDeformTest, QuietPrintsNothing) {
  EXPECT_EQ(Run({"--quiet", "--out", Out().string(), Plate()}), 0);
  EXPECT_EQ(Stdout(), "");
  EXPECT_EQ(Stderr(), "");
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, HelpShowsTheToolsOwnFlagsOnly) {
  for (const char* help : {"--help", "-help", "--h", "-h"}) {
    EXPECT_EQ(Run({"--nonsense", help}), 0) << help;
    const std::string text = Stdout();
    EXPECT_THAT(text, HasSubstr("usage: darboux_deform SCENE.yaml --out=DIR"));
    for (const char* flag : {"--out",
                             "--threads",
                             "--theory",
                             "--strains",
                             "--quadrature",
                             "--divisions",
                             "--minimizer",
                             "--time_limit",
                             "--quiet",
                             "--sparse_backend",
                             "--gradient_tolerance",
                             "--max_iterations"}) {
      EXPECT_THAT(text, HasSubstr(std::string("  ") + flag)) << flag;
    }
    for (const char* foreign : {"logtostderr", "flagfile", "tab_completion", "stderrthreshold"}) {
      EXPECT_THAT(text, Not(HasSubstr(foreign)));
    }
  }
  EXPECT_EQ(Run({"--version"}), 0);
  EXPECT_THAT(Stdout(), HasSubstr("darboux_deform 0."));
}

TEST_F(DarbouxDeformTest, MistakesOnTheCommandLineExitWithTwoAndWriteNothing) {
  struct Mistake {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::vector<Mistake> mistakes = {
      {{}, "usage:"},
      {{OutFlag()}, "no argument"},
      {{Plate(), Plate(), OutFlag()}, "exactly 1"},
      {{Plate()}, "--out"},
      {{Plate(), "--out="}, "--out"},
      {{Plate(), "--out"}, "found no value"},
      {{Plate(), "--out", "--quiet"}, "found no value"},
      {{Plate(), OutFlag(), "--treads=2"}, "did you mean '--threads'?"},
      {{Plate(), OutFlag(), "--flagfile=x"}, "unknown flag"},
      {{Plate(), OutFlag(), "--log_dir=."}, "unknown flag"},
      {{Plate(), OutFlag(), "--noout"}, "unknown flag"},
      {{Plate(), OutFlag(), "--threads=two"}, "--threads: found 'two'; allowed an integer"},
      {{Plate(), OutFlag(), "--threads", "-1"}, "--threads: found '-1'"},
      {{Plate(), OutFlag(), "--time_limit=-1"}, "--time_limit"},
      {{Plate(), OutFlag(), "--time_limit=nan"}, "--time_limit"},
      {{Plate(), OutFlag(), "--gradient_tolerance=0"}, "--gradient_tolerance"},
      {{Plate(), OutFlag(), "--max_iterations=0"}, "--max_iterations"},
      {{Plate(), OutFlag(), "--sparse_backend=cuda"}, "auto | suite_sparse | eigen"},
      {{Plate(), OutFlag(), "--quiet=maybe"}, "true or false"},
      {{Plate(), OutFlag(), "--theory=liner"}, "--theory: found 'liner'"},
      {{Plate(), OutFlag(), "--theory="}, "--theory"},
      {{Plate(), OutFlag(), "--strains=x"}, "--strains"},
      {{Plate(), OutFlag(), "--minimizer=x"}, "--minimizer"},
      {{Plate(), OutFlag(), "--quadrature=0"}, "--quadrature: found 0"},
      {{Plate(), OutFlag(), "--divisions=8"}, "--divisions"},
      {{Plate(), OutFlag(), "--divisions=0,8"}, "--divisions"},
      {{"missing.yaml", OutFlag()}, "missing.yaml:0: scene:"},
      {{folder_.string(), OutFlag()}, "scene:"},
      {{Plate(), "--out=" + Plate()}, "is no folder"},
      {{Plate(), "--out=" + Plate() + "/below"}, "is no folder"},
  };
  const std::set<std::string> before = {"plate.yaml", "stderr", "stdout", "tmp"};
  for (const Mistake& mistake : mistakes) {
    EXPECT_EQ(Run(mistake.arguments), 2) << mistake.message << "\n" << Stderr();
    EXPECT_THAT(Stderr(), HasSubstr(mistake.message));
    EXPECT_EQ(Stdout(), "");
    EXPECT_EQ(FilesIn(folder_), before) << mistake.message;
  }
}

TEST_F(DarbouxDeformTest, MistakeInTheSceneExitsWithTwoAndOneLineThatNamesIt) {
  const std::string scene = Scene("bad.yaml", std::string(kPlate) + "step: 3\n");
  EXPECT_EQ(Run({scene, OutFlag()}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("bad.yaml:8: step"));
  EXPECT_THAT(Stderr(), HasSubstr("'steps'"));
  const std::string text = Stderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(DarbouxDeformTest, SceneThatNothingHoldsExitsWithTwo) {
  std::string text = kPlate;
  text.erase(text.find("supports"), text.find("loads") - text.find("supports"));
  EXPECT_EQ(Run({Scene("free.yaml", text), OutFlag()}), 2);
  EXPECT_THAT(Stderr(), HasSubstr("supports"));
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(DarbouxDeformTest, LoggingFlagsAreTakenAndNoLogFileIsWritten) {
  EXPECT_EQ(Run({Plate(), OutFlag(), "--v=1", "--logtostderr", "--nologtostderr"}), 0) << Stderr();
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, TimeLimitEndsTheRunWithCompleteResults) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Run({Scene("long.yaml", kLong), OutFlag(), "--time_limit=0.5"}), 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  const Json summary = Summary();
  EXPECT_EQ(summary["converged"], false);
  EXPECT_THAT(summary["message"].get<std::string>(), HasSubstr("time limit"));
  EXPECT_EQ(summary["load_steps"].back()["converged"], false);
  ExpectCompleteResults(summary["load_steps"].size());
  EXPECT_THAT(Stderr(), HasSubstr("not converged: time limit"));
}

TEST_F(DarbouxDeformTest, TooFewIterationsGiveMarkedAndFiniteResults) {
  EXPECT_EQ(Run({Scene("long.yaml", kLong), OutFlag(), "--max_iterations=1"}), 1);
  const Json summary = Summary();
  EXPECT_EQ(summary["converged"], false);
  ExpectCompleteResults(summary["load_steps"].size());
}

TEST_F(DarbouxDeformTest, InterruptEndsTheRunWithCompleteResults) {
  for (const int number : {SIGINT, SIGTERM}) {
    const pid_t pid = Start({Scene("long.yaml", kLong), OutFlag()});
    WaitForAStep();
    kill(pid, number);
    EXPECT_EQ(Wait(pid), 1) << Stderr();
    const Json summary = Summary();
    EXPECT_EQ(summary["converged"], false);
    EXPECT_EQ(summary["load_steps"][0]["converged"], true);
    ExpectCompleteResults(summary["load_steps"].size());
  }
}

TEST_F(DarbouxDeformTest, SecondRunReplacesTheFirst) {
  const std::string three = Scene("three.yaml", std::string(kPlate) + "steps: 3\n");
  EXPECT_EQ(Run({three, OutFlag()}), 0);
  ExpectCompleteResults(3);
  EXPECT_EQ(Run({Plate(), OutFlag() + "/"}), 0) << Stderr();
  ExpectCompleteResults(1);
}

TEST_F(DarbouxDeformTest, FullDiskExitsWithOneAndLeavesNothingHalfWritten) {
  rlimit old_limit;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  rlimit limit = old_limit;
  limit.rlim_cur = 20000;
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const int status = Run({Plate(), OutFlag()});  // Inherits the limit.
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(status, 1);
  EXPECT_THAT(Stderr(), HasSubstr("cannot be written"));
  EXPECT_TRUE(FilesIn(Out()).empty());
}

TEST_F(DarbouxDeformTest, UnitsDoNotMatter) {
  ASSERT_EQ(Run({Plate(), OutFlag()}), 0);
  const Json millimetres = Summary();
  ASSERT_EQ(Run({Scene("metres.yaml", kPlateMetres), OutFlag()}), 0);
  const Json metres = Summary();
  const auto value = [](const Json& json, const char* path) {
    return json.at(Json::json_pointer(path)).get<double>();
  };
  struct Quantity {
    const char* path;
    double factor;  // mm, N -> m, N
    double tolerance;
  };
  for (const Quantity& quantity : {Quantity{"/probes/centre/displacement/z", 1e-3, 1e-9},
                                   Quantity{"/energy/total", 1e-3, 1e-9},
                                   Quantity{"/energy/bending", 1e-3, 1e-9},
                                   Quantity{"/max_displacement", 1e-3, 1e-9},
                                   Quantity{"/max_rotation", 1.0, 1e-9},
                                   Quantity{"/supports/reaction/z", 1.0, 1e-9}}) {
    const double expected = quantity.factor * value(millimetres, quantity.path);
    EXPECT_NEAR(value(metres, quantity.path), expected, quantity.tolerance * std::abs(expected))
        << quantity.path;
  }
}

TEST_F(DarbouxDeformTest, AccuracyIsReportedAndDecidesTheStatus) {
  std::string text = kPlate;
  text.replace(text.find("theory: linear"), 14, "theory: linear, accuracy: 0.001");
  EXPECT_EQ(Run({Scene("fine.yaml", text), OutFlag()}), 0) << Stderr();
  EXPECT_EQ(Summary()["accuracy"]["reached"], true);
  EXPECT_THAT(Stdout(), HasSubstr("level    32 x 32"));
  text.replace(text.find("0.001"), 5, "1.0e-14");
  EXPECT_EQ(Run({Scene("finer.yaml", text), OutFlag(), "--divisions=4,4", "--time_limit=1"}), 1);
  EXPECT_EQ(Summary()["accuracy"]["reached"], false);
  EXPECT_EQ(Summary()["converged"], true);
  EXPECT_THAT(Stderr(), HasSubstr("warning: accuracy 1e-14 not reached"));
}

}  // namespace
}  // namespace darboux
