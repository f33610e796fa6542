#ifndef DARBOUX_TESTS_TEMPORARY_FOLDER_H_
#define DARBOUX_TESTS_TEMPORARY_FOLDER_H_

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/file_util.h"

namespace darboux {

// A folder of this process's own: empty at first, removed at the end.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(std::string name) {
    std::replace(name.begin(), name.end(), '/', '_');  // of parameters
    path_ = std::filesystem::path(::testing::TempDir()) / (name + "_" + std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// A test with such a folder.
class FolderTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  // Writes a file; returns its path.
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
    return Path(name);
  }
  std::string Read(const std::string& name) const { return ReadFile(Path(name)); }

 private:
  static std::string TestName() {
    const auto* const info = ::testing::UnitTest::GetInstance()->current_test_info();
    return std::string(info->test_suite_name()) + "_" + info->name();
  }
  const TemporaryFolder temporary_{TestName()};

 protected:
  const std::filesystem::path folder_ = temporary_.path();
};

struct CommandOutcome {
  int status;  // -1 where a signal ended it
  std::string out, err;
};

// Runs a command of the shell in a folder, where stdout and stderr stay as files of these names.
inline CommandOutcome RunCommand(const std::filesystem::path& folder, const std::string& command) {
  const std::string line = "cd '" + folder.string() + "' && { " + command + "\n} >stdout 2>stderr";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          ReadFile(folder / "stdout"),
          ReadFile(folder / "stderr")};
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_TEMPORARY_FOLDER_H_
