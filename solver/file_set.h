#ifndef DARBOUX_SOLVER_FILE_SET_H_
#define DARBOUX_SOLVER_FILE_SET_H_

#include <cstddef>
#include <string>
#include <vector>

namespace darboux {

// Whether results could be written into a folder: it exists and is writable, or can be created.
// Writes nothing; *error says what is in the way.
bool IsWritableFolder(const std::string& folder, std::string* error);

// Creates a folder, and those above it, where it is missing.
bool MakeFolder(const std::string& folder, std::string* error);

// Files that appear in a folder together or not at all (short of a crash between two renames):
// under temporary names (NAME.part) until Commit.
class FileSet {
 public:
  explicit FileSet(std::string folder);  // which exists
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;
  ~FileSet();  // removes what was not committed

  // In the order of Add.
  const std::vector<std::string>& names() const { return names_; }

  // False and *error ("FOLDER/NAME: ...") where it cannot be written.
  bool Add(const std::string& name, const std::string& content, std::string* error);
  // Commit removes a file of this name that an earlier run has left, unless it is added.
  void Outdate(const std::string& name) { outdated_.push_back(name); }
  // Replaces files of these names.
  bool Commit(std::string* error);

 private:
  std::string Part(const std::string& name) const;

  std::string folder_;
  std::vector<std::string> names_, outdated_;
  std::size_t num_committed_ = 0;
};

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FILE_SET_H_
