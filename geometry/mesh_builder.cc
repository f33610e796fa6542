#include "geometry/mesh_builder.h"

#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "geometry/nearest_name.h"
#include "geometry/polygon_triangulation.h"

namespace darboux {
namespace {

constexpr std::size_t kLongestQuote = 40;
// Corners of a polygon that is no fan: triangulating it takes the third power of this.
constexpr std::size_t kMaxConcaveCorners = 64;

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

// from_chars takes no plus sign.
std::string_view WithoutPlus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

template <typename T>
std::from_chars_result ParseWhole(std::string_view word, T* value) {
  const char* const end = word.data() + word.size();
  std::from_chars_result result = std::from_chars(word.data(), end, *value);
  if (result.ec == std::errc() && result.ptr != end) result.ec = std::errc::invalid_argument;
  return result;
}

}  // namespace

LineReader::LineReader(std::string_view text) : text_(text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end != std::string_view::npos && text[end] == '\r' &&
      (end + 1 == text.size() || text[end + 1] != '\n')) {
    end_of_line_ = '\r';
  }
  if (text.substr(0, 3) == "\xEF\xBB\xBF") position_ = 3;  // Byte order mark.
}

bool LineReader::Next() {
  if (position_ >= text_.size()) return false;
  const std::size_t end = text_.find(end_of_line_, position_);
  const std::size_t length = (end == std::string_view::npos ? text_.size() : end) - position_;
  line_ = text_.substr(position_, length);
  position_ += length + (end == std::string_view::npos ? 0 : 1);
  ++number_;
  return true;
}

void LineReader::Split(char comment, std::vector<std::string_view>* words) const {
  words->clear();
  std::size_t i = 0;
  while (i < line_.size()) {
    if (IsBlank(line_[i])) {
      ++i;
      continue;
    }
    if (comment != 0 && line_[i] == comment) return;
    const std::size_t first = i;
    while (i < line_.size() && !IsBlank(line_[i])) ++i;
    words->push_back(line_.substr(first, i - first));
  }
}

bool ParseNumber(std::string_view word, double* value) {
  word = WithoutPlus(word);
  const std::from_chars_result result = ParseWhole(word, value);
  if (result.ec == std::errc()) return true;
  if (result.ec != std::errc::result_out_of_range) return false;
  // Too large or too small? A wider type knows.
  long double wide = 0.0L;
  if (ParseWhole(word, &wide).ec != std::errc()) return false;
  if (wide > 1.0L || wide < -1.0L) return false;
  *value = static_cast<double>(wide);
  return true;
}

bool ParseInteger(std::string_view word, std::int64_t* value) {
  return ParseWhole(WithoutPlus(word), value).ec == std::errc();
}

std::string Quoted(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, kLongestQuote)) {
    text += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return text + (word.size() > kLongestQuote ? "...'" : "'");
}

std::string Lower(std::string_view word) {
  std::string text(word);
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

std::string FoundInsteadOf(const std::string& kind,
                           std::string_view found,
                           const std::vector<std::string>& allowed) {
  std::string text = kind + " " + Quoted(found) + "; allowed ";
  for (const std::string& name : allowed) text += (&name == &allowed.front() ? "" : " | ") + name;
  const std::string nearest = NearestName(std::string(found.substr(0, 100)), allowed);
  return nearest.empty() ? text : text + "; did you mean '" + nearest + "'?";
}

MeshBuilder::MeshBuilder(std::string file, std::string* error)
    : file_(std::move(file)), error_(error) {}

bool MeshBuilder::FailAtLine(std::size_t line, const std::string& what) {
  *error_ = file_ + ":" + std::to_string(line) + ": found " + what;
  return false;
}

bool MeshBuilder::FailAtByte(std::size_t offset, const std::string& what) {
  *error_ = file_ + ":byte " + std::to_string(offset) + ": found " + what;
  return false;
}

bool MeshBuilder::Fail(std::size_t place, const std::string& what) {
  return is_binary_ ? FailAtByte(place, what) : FailAtLine(place, what);
}

void MeshBuilder::BeginFace(std::size_t place) {
  first_corner_.push_back(corners_.size());
  place_.push_back(place);
}

bool MeshBuilder::Finish(bool needs_faces, std::size_t end, TriangleMesh* mesh) {
  const std::size_t num_faces = first_corner_.size();
  if (mesh_.vertices.empty()) return Fail(end, "no vertices; allowed at least one face");
  if (needs_faces && num_faces == 0) {
    return Fail(
        end, std::to_string(num_vertices()) + " vertices and no faces; allowed at least one face");
  }
  first_corner_.push_back(corners_.size());
  std::vector<Eigen::Vector3d> polygon;
  for (std::size_t f = 0; f < num_faces; ++f) {
    const std::int64_t* const corner = corners_.data() + first_corner_[f];
    const std::size_t n = first_corner_[f + 1] - first_corner_[f];
    if (n < 3) {
      return Fail(place_[f],
                  "face " + std::to_string(f) + " with " + std::to_string(n) +
                      (n == 1 ? " corner" : " corners") + "; allowed 3 or more");
    }
    polygon.clear();
    for (std::size_t k = 0; k < n; ++k) {
      if (corner[k] < 0 || corner[k] >= num_vertices()) {
        return Fail(place_[f],
                    "vertex " + std::to_string(corner[k] + first_index_) + " in face " +
                        std::to_string(f) + "; allowed " + std::to_string(first_index_) + " to " +
                        std::to_string(num_vertices() - 1 + first_index_));
      }
      if (n > 3) polygon.push_back(mesh_.vertices[static_cast<std::size_t>(corner[k])]);
    }
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      mesh_.triangles.push_back(
          {static_cast<int>(corner[a]), static_cast<int>(corner[b]), static_cast<int>(corner[c])});
    };
    if (n > 3 && !IsFan(polygon)) {
      if (n > kMaxConcaveCorners) {
        return Fail(place_[f],
                    "face " + std::to_string(f) + ", not convex, with " + std::to_string(n) +
                        " corners; allowed " + std::to_string(kMaxConcaveCorners) +
                        ", or any number of a convex face");
      }
      for (const std::array<int, 3>& t : TriangulatePolygon(polygon)) {
        add(static_cast<std::size_t>(t[0]),
            static_cast<std::size_t>(t[1]),
            static_cast<std::size_t>(t[2]));
      }
    } else {
      for (std::size_t k = 1; k + 1 < n; ++k) add(0, k, k + 1);
    }
  }
  *mesh = std::move(mesh_);
  return true;
}

}  // namespace darboux
