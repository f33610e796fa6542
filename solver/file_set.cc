#include "solver/file_set.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace darboux {

namespace fs = std::filesystem;

bool IsWritableFolder(const std::string& folder, std::string* error) {
  const auto fail = [&](const std::string& what) {
    *error = folder + ": " + what;
    return false;
  };
  if (folder.empty()) return fail("an empty name is no folder");
  std::error_code code;
  fs::path existing = fs::absolute(folder, code);
  if (code) return fail(code.message());
  // The first part of the path that is there: everything below it can be created or not.
  while (true) {
    const fs::file_status status = fs::status(existing, code);
    if (fs::is_directory(status)) break;
    if (status.type() != fs::file_type::not_found) {
      if (fs::exists(status)) return fail(existing.string() + " is no folder");
      return fail(existing.string() + ": " + code.message());
    }
    if (!existing.has_relative_path()) return fail("no such file system");
    existing = existing.parent_path();
  }
  if (access(existing.c_str(), W_OK | X_OK) != 0) {
    return fail(existing.string() + ": " + std::generic_category().message(errno));
  }
  return true;
}

bool MakeFolder(const std::string& folder, std::string* error) {
  if (!IsWritableFolder(folder, error)) return false;
  std::error_code code;
  fs::create_directories(folder, code);
  // "DIR/" has been created all the same where the last name of the path is empty.
  if (code && !fs::is_directory(folder)) {
    *error = folder + ": cannot be created: " + code.message();
    return false;
  }
  return true;
}

FileSet::FileSet(std::string folder) : folder_(std::move(folder)) {}

FileSet::~FileSet() {
  std::error_code ignored;
  for (std::size_t i = num_committed_; i < names_.size(); ++i) fs::remove(Part(names_[i]), ignored);
}

bool FileSet::Add(const std::string& name, const std::string& content, std::string* error) {
  names_.push_back(name);
  errno = 0;
  std::ofstream file(Part(name), std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();  // Sets failbit where the last bytes do not fit on the disk.
  if (file) return true;
  *error = (fs::path(folder_) / name).string() + ": cannot be written: " +
           (errno != 0 ? std::generic_category().message(errno) : "output error");
  return false;
}

bool FileSet::Commit(std::string* error) {
  for (const std::string& name : names_) {
    std::error_code ignored;
    if (fs::is_directory(fs::path(folder_) / name, ignored)) {
      *error = (fs::path(folder_) / name).string() + ": is a folder, cannot be replaced";
      return false;
    }
  }
  for (; num_committed_ < names_.size(); ++num_committed_) {
    const std::string& name = names_[num_committed_];
    std::error_code code;
    fs::rename(Part(name), fs::path(folder_) / name, code);
    if (code) {
      *error = (fs::path(folder_) / name).string() + ": cannot be replaced: " + code.message();
      return false;
    }
  }
  for (const std::string& name : outdated_) {
    if (std::find(names_.begin(), names_.end(), name) != names_.end()) continue;
    std::error_code ignored;
    if (fs::is_directory(fs::path(folder_) / name, ignored)) continue;
    fs::remove(fs::path(folder_) / name, ignored);
  }
  return true;
}

std::string FileSet::Part(const std::string& name) const {
  return (fs::path(folder_) / (name + ".part")).string();
}

}  // namespace darboux
