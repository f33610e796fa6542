#ifndef DARBOUX_TESTS_FILE_UTIL_H_
#define DARBOUX_TESTS_FILE_UTIL_H_

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace darboux {

// Empty where there is no such file.
inline std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

inline std::set<std::string> FilesIn(const std::filesystem::path& folder) {
  std::set<std::string> names;
  if (!std::filesystem::exists(folder)) return names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

}  // namespace darboux

#endif  // DARBOUX_TESTS_FILE_UTIL_H_
