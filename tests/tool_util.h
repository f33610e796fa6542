#ifndef DARBOUX_TESTS_TOOL_UTIL_H_
#define DARBOUX_TESTS_TOOL_UTIL_H_

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/file_util.h"

// darboux_deform as its users meet it: command line in, exit status and files out.

namespace darboux {

class ToolTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "_" + info->name();
    std::replace(name.begin(), name.end(), '/', '_');  // of parameters
    folder_ = std::filesystem::path(::testing::TempDir()) / (name + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_ / "tmp");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Writes a scene; returns its path.
  std::string Scene(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::filesystem::path Out() const { return folder_ / "out"; }
  std::string OutFlag() const { return "--out=" + Out().string(); }
  nlohmann::ordered_json Summary() const {
    return nlohmann::ordered_json::parse(ReadFile(Out() / "summary.json"), nullptr, false);
  }
  std::string Stdout() const { return ReadFile(folder_ / "stdout"); }
  std::string Stderr() const { return ReadFile(folder_ / "stderr"); }

  // Starts the tool in folder_, with a folder for temporary files that is watched.
  pid_t Start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {tool_};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string out = (folder_ / "stdout").string(), err = (folder_ / "stderr").string();
    const std::string temporary = (folder_ / "tmp").string();
    std::filesystem::remove(err);  // Nobody shall read what an earlier run said.
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

  // A run that ended with this status, without a word about numbers that are not finite.
  void ExpectStatus(int expected, const std::vector<std::string>& arguments) {
    EXPECT_EQ(Run(arguments), expected) << Stderr();
    EXPECT_THAT(Stderr(), ::testing::Not(::testing::HasSubstr("not finite and"))) << Stderr();
  }

  // Waits until the tool has reported a load step.
  void WaitForAStep() const {
    for (int i = 0; i < 6000 && Stderr().find("step 1/") == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_THAT(Stderr(), ::testing::HasSubstr("step 1/"));
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
    if (!Summary()["fingers"].empty()) names.insert("contact.csv");
    EXPECT_EQ(FilesIn(Out()), names);
    for (const std::string& name : names) {
      const std::string text = ReadFile(Out() / name);
      EXPECT_FALSE(text.empty()) << name;
      if (name.find(".vtu") != std::string::npos || name == "shell.pvd") {
        EXPECT_THAT(text.substr(text.size() - 11), "</VTKFile>\n") << name;
      }
      if (name == "history.csv" || name == "summary.json") {
        for (const char* number : {" nan", "-nan", ",nan", "NaN", "inf,", "Infinity"}) {
          EXPECT_EQ(text.find(number), std::string::npos) << name << ": " << number;
        }
      }
    }
    const nlohmann::ordered_json summary = Summary();
    ASSERT_TRUE(summary.is_object());
    EXPECT_EQ(summary["load_steps"].size(), steps);
  }

  std::filesystem::path folder_;
  std::string tool_ = DARBOUX_DEFORM;  // the program
};

}  // namespace darboux

#endif  // DARBOUX_TESTS_TOOL_UTIL_H_
