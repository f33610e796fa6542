#ifndef DARBOUX_GEOMETRY_MESH_BUILDER_H_
#define DARBOUX_GEOMETRY_MESH_BUILDER_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace darboux {

// What the readers of the mesh formats (mesh_io.cc, ply_reader.cc) share.

// Lines of a text. They end with "\n" or "\r\n" or, where the first line does, with "\r".
class LineReader {
 public:
  explicit LineReader(std::string_view text);

  bool Next();  // Goes to the next line; false where there is none.
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }      // Of this line, from 1.
  std::size_t position() const { return position_; }  // Of the byte after it.
  // Words of this line, parted by blanks, up to a word that begins with `comment` (0: none does).
  void Split(char comment, std::vector<std::string_view>* words) const;

 private:
  std::string_view text_;
  char end_of_line_ = '\n';
  std::string_view line_;
  std::size_t number_ = 0;
  std::size_t position_ = 0;
};

// The whole word as a number, whatever the locale: "1", "+1.5e3", "nan", "-inf". Too small for a
// double is 0, too large is false.
bool ParseNumber(std::string_view word, double* value);
bool ParseInteger(std::string_view word, std::int64_t* value);
// The word in quotes, shortened and without control characters: fit for a message of one line.
std::string Quoted(std::string_view word);
std::string Lower(std::string_view word);
// "KIND 'found'; allowed a | b | c", with "; did you mean 'a'?" for a misspelt word.
std::string FoundInsteadOf(const std::string& kind,
                           std::string_view found,
                           const std::vector<std::string>& allowed);

// Collects vertices and polygons in any order and makes triangles of them.
class MeshBuilder {
 public:
  // `file` is for messages. The first error goes to `error`.
  MeshBuilder(std::string file, std::string* error);

  // Return false. "FILE:LINE: found WHAT" and "FILE:byte OFFSET: found WHAT".
  bool FailAtLine(std::size_t line, const std::string& what);
  bool FailAtByte(std::size_t offset, const std::string& what);

  // Files that count vertices from 1 say so in messages about them; corners count from 0 always.
  void set_first_index(int first) { first_index_ = first; }
  // Where a face stands is a byte instead of a line.
  void set_binary() { is_binary_ = true; }

  std::int64_t num_vertices() const { return static_cast<std::int64_t>(mesh_.vertices.size()); }
  void AddVertex(const Eigen::Vector3d& position) { mesh_.vertices.push_back(position); }
  // At the vertex last added; at every one, or at none.
  void AddNormal(const Eigen::Vector3d& normal) { vectors_.normals.push_back(normal); }
  void AddDisplacement(const Eigen::Vector3d& u) { vectors_.displacements.push_back(u); }
  void BeginFace(std::size_t place);
  void AddCorner(std::int64_t vertex) { corners_.push_back(vertex); }

  // Checks the polygons and cuts them into triangles. `end` is the place of a message about what
  // is missing. Without `needs_faces` a file of points is as good.
  bool Finish(bool needs_faces, std::size_t end, TriangleMesh* mesh);
  VertexVectors TakeVectors() { return std::move(vectors_); }

 private:
  bool Fail(std::size_t place, const std::string& what);

  std::string file_;
  std::string* error_;
  int first_index_ = 0;
  bool is_binary_ = false;
  TriangleMesh mesh_;
  VertexVectors vectors_;
  std::vector<std::int64_t> corners_;      // Of all polygons.
  std::vector<std::size_t> first_corner_;  // Of each polygon.
  std::vector<std::size_t> place_;         // Of each polygon in the file.
};

}  // namespace darboux

#endif  // DARBOUX_GEOMETRY_MESH_BUILDER_H_
