#ifndef DARBOUX_TESTS_TOOL_UTIL_H_
#define DARBOUX_TESTS_TOOL_UTIL_H_

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/file_util.h"
#include "tests/temporary_folder.h"

// A tool as its users meet it: command line in, exit status and files out.

namespace darboux {

class ToolTest : public FolderTest {
 protected:
  explicit ToolTest(const std::string& tool) : tool_(tool) {
    std::filesystem::create_directories(folder_ / "tmp");
  }

  std::filesystem::path Out() const { return folder_ / "out"; }
  std::string OutFlag() const { return "--out=" + Out().string(); }
  std::string Stdout() const { return ReadFile(folder_ / "stdout"); }
  std::string Stderr() const { return ReadFile(folder_ / "stderr"); }

  // Starts the tool in folder_, with a folder for temporary files that is watched.
  pid_t Start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {tool_};
    words.insert(words.end(), common_.begin(), common_.end());
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

  std::string tool_;                 // the program
  std::vector<std::string> common_;  // arguments of every run, before the others
};

}  // namespace darboux

#endif  // DARBOUX_TESTS_TOOL_UTIL_H_
