#ifndef DARBOUX_GEOMETRY_TEXT_FILE_H_
#define DARBOUX_GEOMETRY_TEXT_FILE_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace darboux {

// What the readers and writers of meshes and of points share.

// Every vertex, triangle and point takes a byte at least, so that all counts fit an int.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31;

// The whole of a plain file. `what`, "a mesh file", is for the message: "FILE:0: found ...".
bool ReadBytes(const std::string& file,
               const std::string& what,
               std::string* contents,
               std::string* error);

bool WriteBytes(const std::string& file, const std::string& contents, std::string* error);

// Appends the shortest digits that read back bit for bit (the sign of a nan aside), with a decimal
// point whatever the locale; three of them with `separator` between them.
void AppendNumber(double number, std::string* text);
void AppendNumbers(const Eigen::Vector3d& numbers, char separator, std::string* text);

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_TEXT_FILE_H_
