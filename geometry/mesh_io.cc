#include "geometry/mesh_io.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <unordered_map>
#include <utility>

#include "geometry/mesh_builder.h"
#include "geometry/ply_reader.h"
#include "geometry/text_file.h"

namespace darboux {
namespace {

using Words = std::vector<std::string_view>;

bool Contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Three numbers from words[first] on.
bool ReadPosition(const Words& words,
                  std::size_t first,
                  std::size_t line,
                  MeshBuilder* builder,
                  Eigen::Vector3d* position) {
  if (words.size() < first + 3) {
    return builder->FailAtLine(
        line,
        "a vertex with " + std::to_string(words.size() - first) + " coordinates; allowed x y z");
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (!ParseNumber(words[first + k], &(*position)[static_cast<Eigen::Index>(k)])) {
      return builder->FailAtLine(
          line,
          Quoted(words[first + k]) + " in a vertex; allowed a number in the range of a double");
    }
  }
  return true;
}

bool ReadObj(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  static const std::vector<std::string> kSkipped = {"vt",
                                                    "vn",
                                                    "vp",
                                                    "g",
                                                    "o",
                                                    "s",
                                                    "l",
                                                    "p",
                                                    "mtllib",
                                                    "usemtl",
                                                    "maplib",
                                                    "usemap",
                                                    "mg",
                                                    "bevel",
                                                    "c_interp",
                                                    "d_interp",
                                                    "lod",
                                                    "shadow_obj",
                                                    "trace_obj"};
  static const std::vector<std::string> kAllowed = {
      "v", "f", "vt", "vn", "g", "o", "s", "l", "p", "mtllib", "usemtl"};
  builder->set_first_index(1);
  LineReader lines(contents);
  Words words, more;
  while (lines.Next()) {
    const std::size_t line = lines.number();
    lines.Split('#', &words);
    while (!words.empty() && words.back().back() == '\\' && lines.Next()) {  // Goes on there.
      words.back().remove_suffix(1);
      if (words.back().empty()) words.pop_back();
      lines.Split('#', &more);
      words.insert(words.end(), more.begin(), more.end());
    }
    if (words.empty() || Contains(kSkipped, words[0])) continue;
    if (words[0] == "v") {
      Eigen::Vector3d position;
      if (!ReadPosition(words, 1, line, builder, &position)) return false;
      builder->AddVertex(position);
    } else if (words[0] == "f" || words[0] == "fo") {
      builder->BeginFace(line);
      for (std::size_t k = 1; k < words.size(); ++k) {
        std::int64_t vertex = 0;  // v, v/vt, v//vn or v/vt/vn
        if (!ParseInteger(words[k].substr(0, words[k].find('/')), &vertex)) {
          return builder->FailAtLine(
              line, Quoted(words[k]) + " in a face; allowed the number of a vertex, from 1");
        }
        if (vertex == 0 || vertex < -builder->num_vertices()) {
          return builder->FailAtLine(line,
                                     "vertex " + std::to_string(vertex) +
                                         " in a face; allowed numbers from 1, or from -1 " +
                                         "to -" + std::to_string(builder->num_vertices()) +
                                         " for the vertices so far");
        }
        builder->AddCorner(vertex > 0 ? vertex - 1 : builder->num_vertices() + vertex);
      }
    } else {
      return builder->FailAtLine(line, FoundInsteadOf("the keyword", words[0], kAllowed));
    }
  }
  *end = lines.number();
  return true;
}

// The next line with words; false at the end.
bool NextWords(LineReader* lines, Words* words) {
  while (lines->Next()) {
    lines->Split('#', words);
    if (!words->empty()) return true;
  }
  return false;
}

bool ReadOff(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  LineReader lines(contents);
  Words words;
  const auto fail = [&](const std::string& what) {
    return builder->FailAtLine(lines.number(), what);
  };
  static const std::vector<std::string> kHeaders = {
      "OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"};
  if (!NextWords(&lines, &words)) return fail("no text; allowed 'OFF' first");
  // Many files of a well-known collection have the counts glued to the keyword: OFF8 6 12.
  const std::size_t keyword = std::min(words[0].find_first_of("0123456789"), words[0].size());
  if (!Contains(kHeaders, words[0].substr(0, keyword))) {
    return fail(FoundInsteadOf("the header", words[0], kHeaders));
  }
  words[0].remove_prefix(keyword);
  if (words[0].empty()) words.erase(words.begin());
  if (words.empty() && !NextWords(&lines, &words)) {
    return fail("the end of the file; allowed the counts of vertices, faces and edges");
  }
  std::array<std::int64_t, 2> counts{};
  for (std::size_t k = 0; k < 2; ++k) {
    if (words.size() < 2 || words.size() > 3 || !ParseInteger(words[k], &counts[k]) ||
        counts[k] < 0) {
      return fail(Quoted(words[std::min(k, words.size() - 1)]) +
                  " in the counts; allowed the numbers of vertices, faces and edges");
    }
  }
  const std::size_t line_of_counts = lines.number();
  const auto fail_at_end = [&](const char* what, std::int64_t i, std::int64_t count) {
    return fail("the end of the file in place of " + std::string(what) + " " + std::to_string(i) +
                "; allowed " + what + " 0 to " + std::to_string(count - 1) + " as line " +
                std::to_string(line_of_counts) + " says");
  };
  for (std::int64_t i = 0; i < counts[0]; ++i) {  // What follows a position is skipped.
    if (!NextWords(&lines, &words)) return fail_at_end("vertex", i, counts[0]);
    Eigen::Vector3d position;
    if (!ReadPosition(words, 0, lines.number(), builder, &position)) return false;
    builder->AddVertex(position);
  }
  for (std::int64_t i = 0; i < counts[1]; ++i) {
    if (!NextWords(&lines, &words)) return fail_at_end("face", i, counts[1]);
    std::int64_t n = 0;
    if (!ParseInteger(words[0], &n) || n < 0 || n >= static_cast<std::int64_t>(words.size())) {
      return fail(Quoted(words[0]) + " as the number of corners of face " + std::to_string(i) +
                  ", followed by " + std::to_string(words.size() - 1) +
                  " words; allowed n v0 ... v(n-1), with n at least 3");
    }
    builder->BeginFace(lines.number());
    for (std::int64_t k = 1; k <= n; ++k) {  // What follows, a colour, is skipped.
      std::int64_t vertex = 0;
      if (!ParseInteger(words[static_cast<std::size_t>(k)], &vertex)) {
        return fail(Quoted(words[static_cast<std::size_t>(k)]) + " in face " + std::to_string(i) +
                    "; allowed the number of a vertex, from 0");
      }
      builder->AddCorner(vertex);
    }
  }
  if (NextWords(&lines, &words)) {
    return fail(Quoted(words[0]) + " after the last face; allowed the end of the file, as line " +
                std::to_string(line_of_counts) + " counts no more");
  }
  *end = lines.number();
  return true;
}

// Gives equal positions, bit for bit, the same vertex.
class VertexMerger {
 public:
  explicit VertexMerger(MeshBuilder* builder) : builder_(*builder) {}

  void AddCorner(Eigen::Vector3d position) {
    position.array() += 0.0;  // -0 is 0.
    Key key{};
    std::memcpy(key.data(), position.data(), sizeof(key));
    const auto [found, is_new] = vertices_.emplace(key, builder_.num_vertices());
    if (is_new) builder_.AddVertex(position);
    builder_.AddCorner(found->second);
  }

 private:
  using Key = std::array<std::uint64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t hash = 0;
      for (const std::uint64_t word : key) {
        hash = (hash ^ word) * 0x9E3779B97F4A7C15u;  // Fibonacci hashing.
        hash ^= hash >> 32;
      }
      return static_cast<std::size_t>(hash);
    }
  };

  MeshBuilder& builder_;
  std::unordered_map<Key, std::int64_t, Hash> vertices_;
};

std::uint32_t LoadUint32(const char* bytes) {  // STL is little-endian.
  std::uint32_t value = 0;
  for (int k = 3; k >= 0; --k) value = value << 8 | static_cast<unsigned char>(bytes[k]);
  return value;
}

constexpr std::size_t kStlHeader = 84;    // 80 bytes of anything, then the number of triangles.
constexpr std::size_t kStlTriangle = 50;  // Normal, three corners, two bytes of anything.

bool ReadBinaryStl(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  builder->set_binary();
  if (contents.size() < kStlHeader) {
    return builder->FailAtByte(contents.size(),
                               "the end of the file; allowed a binary STL header of 84 bytes, or " +
                                   std::string("a text that begins with 'solid'"));
  }
  const std::size_t count = LoadUint32(contents.data() + 80);
  const std::size_t room = (contents.size() - kStlHeader) / kStlTriangle;
  if (contents.size() != kStlHeader + count * kStlTriangle) {
    return builder->FailAtByte(80,
                               "a count of " + std::to_string(count) + " triangles, which take " +
                                   std::to_string(kStlHeader + count * kStlTriangle) +
                                   " bytes, in a file of " + std::to_string(contents.size()) +
                                   "; allowed " + std::to_string(room));
  }
  VertexMerger merger(builder);
  for (std::size_t t = 0; t < count; ++t) {
    const std::size_t first = kStlHeader + t * kStlTriangle;
    builder->BeginFace(first);
    for (std::size_t c = 0; c < 3; ++c) {
      Eigen::Vector3d position;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t bits = LoadUint32(contents.data() + first + 12 * (c + 1) + 4 * k);
        float value = 0.0f;
        std::memcpy(&value, &bits, sizeof(value));
        position[static_cast<Eigen::Index>(k)] = value;
      }
      merger.AddCorner(position);
    }
  }
  *end = contents.size();
  return true;
}

bool ReadTextStl(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  // What comes after what; `facet` may also end the solid, and `solid` begin another.
  enum class State { kOutside, kSolid, kFacet, kLoop, kLoopEnded };
  LineReader lines(contents);
  Words words;
  VertexMerger merger(builder);
  State state = State::kOutside;
  int num_corners = 0;
  while (NextWords(&lines, &words)) {
    const std::string key = Lower(words[0]);
    const auto fail = [&](const std::string& allowed) {
      return builder->FailAtLine(lines.number(), Quoted(words[0]) + "; allowed " + allowed);
    };
    switch (state) {
      case State::kOutside:
        if (key != "solid") return fail("'solid'");
        state = State::kSolid;
        break;
      case State::kSolid:
        if (key != "facet" && key != "endsolid") return fail("'facet' or 'endsolid'");
        state = key == "facet" ? State::kFacet : State::kOutside;
        break;
      case State::kFacet:
        if (key != "outer") return fail("'outer loop'");
        state = State::kLoop;
        num_corners = 0;
        builder->BeginFace(lines.number());
        break;
      case State::kLoop: {
        const char* const allowed = num_corners < 3 ? "'vertex'" : "'endloop' after three vertices";
        if (key != (num_corners < 3 ? "vertex" : "endloop")) return fail(allowed);
        if (num_corners == 3) {
          state = State::kLoopEnded;
          break;
        }
        Eigen::Vector3d position;
        if (!ReadPosition(words, 1, lines.number(), builder, &position)) return false;
        merger.AddCorner(position);
        ++num_corners;
        break;
      }
      case State::kLoopEnded:
        if (key != "endfacet") return fail("'endfacet'");
        state = State::kSolid;
        break;
    }
  }
  if (state != State::kOutside) {
    return builder->FailAtLine(lines.number(),
                               "the end of the file in a solid; allowed 'endsolid'");
  }
  *end = lines.number();
  return true;
}

bool ReadStl(std::string_view contents, MeshBuilder* builder, std::size_t* end) {
  // The header of a binary file may begin with "solid" too: then its length tells, or its zeros.
  const bool has_its_length =
      contents.size() >= kStlHeader &&
      contents.size() == kStlHeader + kStlTriangle * LoadUint32(contents.data() + 80);
  const bool has_zeros = contents.find('\0') != std::string_view::npos;
  if (has_its_length || has_zeros) return ReadBinaryStl(contents, builder, end);
  return ReadTextStl(contents, builder, end);
}

bool Parse(std::string_view contents,
           const std::string& file,
           bool needs_faces,
           TriangleMesh* mesh,
           VertexVectors* vectors,
           std::string* error) {
  MeshBuilder builder(file, error);
  const std::string ending = Lower(std::filesystem::path(file).extension().string());
  std::size_t end = 0;
  bool (*read)(std::string_view, MeshBuilder*, std::size_t*) = nullptr;
  if (ending == ".obj") read = ReadObj;
  if (ending == ".ply") read = ReadPly;
  if (ending == ".stl") read = ReadStl;
  if (ending == ".off") read = ReadOff;
  if (read == nullptr) {
    return builder.FailAtLine(
        0, FoundInsteadOf("a name that ends with", ending, {".obj", ".ply", ".stl", ".off"}));
  }
  if (contents.empty()) return builder.FailAtLine(0, "an empty file; allowed a mesh");
  if (contents.size() > kMaxFileBytes) {
    return builder.FailAtLine(
        0, std::to_string(contents.size()) + " bytes; allowed " + std::to_string(kMaxFileBytes));
  }
  if (!read(contents, &builder, &end) || !builder.Finish(needs_faces, end, mesh)) return false;
  if (vectors != nullptr) *vectors = builder.TakeVectors();
  return true;
}

void Append(const Eigen::Vector3d& position, std::string* text) {
  AppendNumbers(position, ' ', text);
  *text += '\n';
}

void Append(const std::array<int, 3>& triangle, int first_index, std::string* text) {
  for (const int vertex : triangle) *text += ' ' + std::to_string(vertex + first_index);
  *text += '\n';
}

}  // namespace

bool ReadMesh(const std::string& file, TriangleMesh* mesh, std::string* error) {
  std::string contents;
  return ReadBytes(file, "a mesh file", &contents, error) && ParseMesh(contents, file, mesh, error);
}

bool ParseMesh(std::string_view contents,
               const std::string& file,
               TriangleMesh* mesh,
               std::string* error) {
  return Parse(contents, file, /*needs_faces=*/true, mesh, nullptr, error);
}

bool ReadPoints(const std::string& file, std::vector<Eigen::Vector3d>* points, std::string* error) {
  std::string contents;
  TriangleMesh mesh;
  if (!ReadBytes(file, "a mesh file", &contents, error)) return false;
  if (!Parse(contents, file, /*needs_faces=*/false, &mesh, nullptr, error)) return false;
  *points = std::move(mesh.vertices);
  return true;
}

bool ReadVertices(const std::string& file,
                  TriangleMesh* mesh,
                  VertexVectors* vectors,
                  std::string* error) {
  std::string contents;
  return ReadBytes(file, "a mesh file", &contents, error) &&
         Parse(contents, file, /*needs_faces=*/false, mesh, vectors, error);
}

bool WriteObj(const std::string& file, const TriangleMesh& mesh, std::string* error) {
  std::string text;
  for (const Eigen::Vector3d& position : mesh.vertices) {
    text += "v ";
    Append(position, &text);
  }
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    text += 'f';
    Append(triangle, 1, &text);
  }
  return WriteBytes(file, text, error);
}

bool WritePly(const std::string& file, const TriangleMesh& mesh, std::string* error) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                     std::to_string(mesh.vertices.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& position : mesh.vertices) Append(position, &text);
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    text += '3';
    Append(triangle, 0, &text);
  }
  return WriteBytes(file, text, error);
}

}  // namespace darboux
