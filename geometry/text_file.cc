#include "geometry/text_file.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace darboux {

bool ReadBytes(const std::string& file,
               const std::string& what,
               std::string* contents,
               std::string* error) {
  const auto fail = [&](const std::string& reason) {
    *error = file + ":0: found a file that cannot be read (" + reason + "); allowed " + what;
    return false;
  };
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(file, code);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return fail(std::filesystem::is_directory(status) ? "it is a directory"
                                                      : "it is no plain file");
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fail(errno != 0 ? std::generic_category().message(errno) : "no reason given");
  const std::uintmax_t size = std::filesystem::file_size(file, code);
  if (code) return fail(code.message());
  if (size > kMaxFileBytes) {
    return fail("it has " + std::to_string(size) + " bytes, more than " +
                std::to_string(kMaxFileBytes));
  }
  contents->resize(static_cast<std::size_t>(size));
  stream.read(contents->data(), static_cast<std::streamsize>(size));
  if (stream.bad()) return fail("reading failed");
  contents->resize(static_cast<std::size_t>(stream.gcount()));
  return true;
}

bool WriteBytes(const std::string& file, const std::string& contents, std::string* error) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary);
  stream.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  stream.close();
  if (stream) return true;
  *error = file + ":0: found a file that cannot be written (" +
           (errno != 0 ? std::generic_category().message(errno) : "no reason given") +
           "); allowed a new file in an existing directory";
  return false;
}

void AppendNumber(double number, std::string* text) {
  std::array<char, 32> digits{};
  const std::to_chars_result result =
      std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text->append(digits.data(), result.ptr);
}

void AppendNumbers(const Eigen::Vector3d& numbers, char separator, std::string* text) {
  for (int k = 0; k < 3; ++k) {
    if (k > 0) *text += separator;
    AppendNumber(numbers[k], text);
  }
}

}  // namespace darboux
