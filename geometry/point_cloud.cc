#include "geometry/point_cloud.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <utility>

#include "geometry/mesh_builder.h"
#include "geometry/mesh_io.h"
#include "geometry/text_file.h"

namespace darboux {
namespace {

using Words = std::vector<std::string_view>;

const std::array<const char*, 9> kNames = {"x", "y", "z", "nx", "ny", "nz", "ux", "uy", "uz"};
constexpr std::size_t kNormal = 3, kDisplacement = 6;  // First of each in kNames.
constexpr int kNone = -1;
// Columns without names pass for normals up to this error of their length.
constexpr double kUnnamedNormalTolerance = 0.01;
// A unit vector in double precision is one to a few units in the last place.
constexpr double kUnitTolerance = 1e-14;

std::string_view Trimmed(std::string_view word) {
  constexpr char kBlanks[] = " \t\r\v\f";
  const std::size_t first = word.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return word.substr(first, word.find_last_not_of(kBlanks) - first + 1);
}

std::string_view Unquoted(std::string_view word) {
  if (word.size() >= 2 && word.front() == '"' && word.back() == '"') {
    word = Trimmed(word.substr(1, word.size() - 2));
  }
  return word;
}

// Of the nine names; kNone for another word.
int NameIndex(std::string_view word) {
  word = Unquoted(word);
  if (word.size() > 2) return kNone;
  const auto found = std::find(kNames.begin(), kNames.end(), Lower(word));
  return found == kNames.end() ? kNone : static_cast<int>(found - kNames.begin());
}

// "x-displacement [mm]": the name that this long one stands for, and its unit, empty if there is
// none.
int LongNameIndex(std::string_view word, std::string* unit) {
  word = Unquoted(word);
  unit->clear();
  for (const auto& [open, close] : {std::make_pair('[', ']'), std::make_pair('(', ')')}) {
    const std::size_t bracket = word.find(open);
    if (bracket == std::string_view::npos || word.back() != close) continue;
    *unit = std::string(Trimmed(word.substr(bracket + 1, word.size() - bracket - 2)));
    word = Trimmed(word.substr(0, bracket));
    break;
  }
  // What it is of which axis.
  std::string quantity;
  char axis = 0;
  constexpr char kBetween[] = " \t-_.";
  for (std::size_t i = 0; (i = word.find_first_not_of(kBetween, i)) != std::string_view::npos;) {
    const std::size_t end = std::min(word.find_first_of(kBetween, i), word.size());
    const std::string part = Lower(word.substr(i, end - i));
    const bool is_axis = part.size() == 1 && part[0] >= 'x' && part[0] <= 'z';
    if (is_axis ? axis != 0 : !quantity.empty()) return kNone;
    if (is_axis) {
      axis = part[0];
    } else {
      quantity = part;
    }
    i = end;
  }
  if (axis == 0) return unit->empty() ? kNone : NameIndex(word);  // "ux [mm]"
  static const std::array<std::vector<std::string>, 3> kQuantities = {{
      {"", "coordinate", "coord", "position"},
      {"n", "normal"},
      {"u", "displacement", "disp"},
  }};
  for (std::size_t k = 0; k < kQuantities.size(); ++k) {
    const auto& names = kQuantities[k];
    if (std::find(names.begin(), names.end(), quantity) != names.end()) {
      return static_cast<int>(3 * k) + axis - 'x';
    }
  }
  return kNone;
}

class TableReader {
 public:
  TableReader(std::string_view contents, const std::string& file, std::string* error)
      : file_(file), error_(error), lines_(contents) {
    columns_.fill(kNone);
  }

  bool Read(PointCloud* cloud);

 private:
  bool Fail(std::size_t line, const std::string& what) {
    *error_ = file_ + ":" + std::to_string(line) + ": found " + what;
    return false;
  }
  void ChooseSeparator(std::string_view text);
  void Split(std::string_view text);
  bool ReadNames(std::size_t line);
  bool NameByCount();
  bool ReadValues();
  bool has(std::size_t first) const { return columns_[first] != kNone; }

  std::string file_;
  std::string* error_;
  LineReader lines_;
  char separator_ = 0;  // ' ' stands for tabs and spaces; 0: not known yet
  Words words_;
  std::array<int, 9> columns_;  // Of the names; kNone: not there.
  std::size_t num_columns_ = 0;
  std::size_t line_of_names_ = 0;  // 0: none
  PointCloud cloud_;
  std::vector<std::size_t> line_of_;  // Of each point.
  // The first value that is not finite, and how many lines have one.
  std::string not_finite_;
  std::size_t first_not_finite_ = 0, num_not_finite_ = 0;
};

void TableReader::ChooseSeparator(std::string_view text) {
  separator_ = text.find(';') != std::string_view::npos   ? ';'
               : text.find(',') != std::string_view::npos ? ','
                                                          : ' ';
}

void TableReader::Split(std::string_view text) {
  words_.clear();
  text = Trimmed(text);
  if (separator_ == ' ') {
    std::size_t i = 0;
    while ((i = text.find_first_not_of(" \t\r\v\f", i)) != std::string_view::npos) {
      const std::size_t end = std::min(text.find_first_of(" \t\r\v\f", i), text.size());
      words_.push_back(text.substr(i, end - i));
      i = end;
    }
    return;
  }
  std::size_t first = 0;
  for (std::size_t end = 0; end != text.size(); first = end + 1) {
    end = std::min(text.find(separator_, first), text.size());
    words_.push_back(Trimmed(text.substr(first, end - first)));
  }
}

// words_ are names of columns.
bool TableReader::ReadNames(std::size_t line) {
  num_columns_ = words_.size();
  line_of_names_ = line;
  std::array<std::string, 9> units;
  for (const bool is_long : {false, true}) {
    const std::array<int, 9> before = columns_;
    for (std::size_t c = 0; c < words_.size(); ++c) {
      std::string unit;
      const int name = is_long ? LongNameIndex(words_[c], &unit) : NameIndex(words_[c]);
      if (name == kNone || before[static_cast<std::size_t>(name)] != kNone) continue;
      int& column = columns_[static_cast<std::size_t>(name)];
      if (column != kNone) {
        return Fail(line,
                    "a second column '" + std::string(kNames[static_cast<std::size_t>(name)]) +
                        "'; allowed one");
      }
      column = static_cast<int>(c);
      if (name < static_cast<int>(kNormal) || name >= static_cast<int>(kDisplacement)) {
        units[static_cast<std::size_t>(name)] = unit;
      }
    }
  }
  std::string first_unit;
  for (const std::string& unit : units) {
    if (unit.empty() || unit == first_unit) continue;
    if (!first_unit.empty()) {
      return Fail(line,
                  "columns in " + Quoted(first_unit) + " and in " + Quoted(unit) +
                      "; allowed one unit of length");
    }
    first_unit = unit;
  }
  const auto missing = [&](const std::string& which, const std::string& allowed) {
    std::string text = "columns";
    for (std::size_t c = 0; c < std::min<std::size_t>(words_.size(), 9); ++c) {
      text += (c == 0 ? " " : ", ") + Quoted(words_[c]);
    }
    return Fail(
        line,
        text + (words_.size() > 9 ? ", ..." : "") + " without " + which + "; allowed " + allowed);
  };
  if (std::all_of(columns_.begin(), columns_.end(), [](int c) { return c == kNone; })) {
    return Fail(line,
                Quoted(words_[0]) +
                    ", neither a number nor the name of a column; allowed numbers with a decimal "
                    "point, or names of which x y z are some");
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (!has(k)) {
      return missing(std::string("'") + kNames[k] + "'",
                     "x y z, or x y in a plane, with nx ny nz or ux uy uz or others beside them");
    }
  }
  int normals = 0;
  for (std::size_t k = 0; k < 3; ++k) normals += has(kNormal + k) ? 1 : 0;
  if (normals != 0 && normals != 3) return missing("all of nx ny nz", "all three or none");
  const bool moves = has(kDisplacement) || has(kDisplacement + 1) || has(kDisplacement + 2);
  if (moves && !(has(kDisplacement) && has(kDisplacement + 1))) {
    return missing("ux and uy", "ux uy uz, ux uy in a plane, or none");
  }
  return true;
}

// Nobody named the columns.
bool TableReader::NameByCount() {
  if (words_.back().empty()) words_.pop_back();
  num_columns_ = words_.size();
  std::vector<std::size_t> names;
  if (num_columns_ == 3) names = {0, 1, 2};
  if (num_columns_ == 4) names = {0, 1, 6, 7};
  if (num_columns_ == 6) names = {0, 1, 2, 3, 4, 5};
  if (names.empty()) {
    return Fail(lines_.number(),
                std::to_string(num_columns_) + (num_columns_ == 1 ? " column" : " columns") +
                    " and no line of names; allowed 3 (x y z), 4 (x y ux uy), 6 (x y z nx ny nz), "
                    "or a first line of names");
  }
  for (std::size_t c = 0; c < names.size(); ++c) columns_[names[c]] = static_cast<int>(c);
  return true;
}

bool TableReader::ReadValues() {
  if (words_.size() != num_columns_) {
    return Fail(
        lines_.number(),
        std::to_string(words_.size()) + (words_.size() == 1 ? " column" : " columns") +
            "; allowed " + std::to_string(num_columns_) +
            (line_of_names_ > 0 ? ", which line " + std::to_string(line_of_names_) + " names"
                                : ", as on the lines before"));
  }
  std::array<double, 9> values{};
  bool is_finite = true;
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    if (!has(k)) continue;
    const std::string_view word = words_[static_cast<std::size_t>(columns_[k])];
    if (!ParseNumber(word, &values[k])) {
      return Fail(lines_.number(),
                  Quoted(word) + " as " + kNames[k] +
                      "; allowed a number in the range of a double, with a decimal point");
    }
    if (std::isfinite(values[k]) || !is_finite) continue;
    is_finite = false;
    if (num_not_finite_ == 0) {
      not_finite_ = Quoted(word) + " as " + kNames[k];
      first_not_finite_ = lines_.number();
    }
  }
  if (!is_finite) ++num_not_finite_;
  cloud_.points.emplace_back(values[0], values[1], values[2]);
  if (has(kNormal)) cloud_.normals.emplace_back(values[3], values[4], values[5]);
  if (has(kDisplacement)) cloud_.displacements.emplace_back(values[6], values[7], values[8]);
  line_of_.push_back(lines_.number());
  return true;
}

// ", the first of 3 points that are ..."; nothing where it is the only one.
std::string FirstOf(std::size_t count, const std::string& that_are) {
  return count == 1 ? ""
                    : ", the first of " + std::to_string(count) + " points that are " + that_are;
}

// Makes unit vectors of the normals and returns how many cannot become one; `first` is of these.
std::size_t Normalise(std::vector<Eigen::Vector3d>* normals, std::size_t* first) {
  std::size_t failed = 0;
  for (std::size_t i = 0; i < normals->size(); ++i) {
    Eigen::Vector3d& n = (*normals)[i];
    const double largest = n.cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) {
      if (failed++ == 0) *first = i;
      continue;
    }
    if (std::abs(n.squaredNorm() - 1.0) <= kUnitTolerance) continue;
    n = (n / largest).normalized();  // The squares of tiny and huge ones leave the range.
  }
  return failed;
}

std::string NoLength(std::size_t count) {
  return "a normal of no length" + FirstOf(count, "without one") +
         "; allowed a direction at every point, or no normals at all";
}

bool TableReader::Read(PointCloud* cloud) {
  std::string_view named_by_comment;
  std::size_t line_of_comment = 0;
  bool is_first = true;
  while (lines_.Next()) {
    const std::size_t hash = lines_.line().find('#');
    const std::string_view text = Trimmed(lines_.line().substr(0, hash));
    if (text.empty()) {
      if (!is_first || hash == std::string_view::npos) continue;
      std::string_view comment = lines_.line().substr(hash);
      comment.remove_prefix(std::min(comment.find_first_not_of('#'), comment.size()));
      ChooseSeparator(comment);
      Split(comment);
      if (!words_.empty() && std::all_of(words_.begin(), words_.end(), [](std::string_view word) {
            return NameIndex(word) != kNone;
          })) {
        named_by_comment = comment;
        line_of_comment = lines_.number();
      }
      continue;
    }
    if (is_first) {
      is_first = false;
      ChooseSeparator(text);
      Split(text);
      double number = 0.0;
      if (std::none_of(words_.begin(), words_.end(), [&](std::string_view word) {
            return ParseNumber(word, &number);
          })) {
        if (!ReadNames(lines_.number())) return false;
        continue;
      }
      if (line_of_comment > 0) {
        const char separator = separator_;
        ChooseSeparator(named_by_comment);
        Split(named_by_comment);
        if (!ReadNames(line_of_comment)) return false;
        separator_ = separator;
        Split(text);
      } else if (!NameByCount()) {
        return false;
      }
    } else {
      Split(text);
    }
    // A separator that ends the line instead of parting two values.
    if (words_.size() == num_columns_ + 1 && words_.back().empty()) words_.pop_back();
    if (!ReadValues()) return false;
  }
  if (cloud_.empty()) {
    return Fail(lines_.number(), "no points; allowed a line of numbers for each point");
  }
  if (num_not_finite_ > 0) {
    return Fail(first_not_finite_,
                not_finite_ + FirstOf(num_not_finite_, "not finite") + "; allowed finite numbers");
  }
  if (line_of_names_ == 0) {
    for (std::size_t i = 0; i < cloud_.normals.size(); ++i) {
      const double length = cloud_.normals[i].stableNorm();
      if (std::abs(length - 1.0) <= kUnnamedNormalTolerance) continue;
      std::string number;
      AppendNumber(length, &number);
      return Fail(line_of_[i],
                  "6 columns without names, of which the last three have the length " + number +
                      "; allowed unit normals, or a first line of names such as x,y,z,ux,uy,uz");
    }
  }
  std::size_t first = 0;
  if (const std::size_t count = Normalise(&cloud_.normals, &first); count > 0) {
    return Fail(line_of_[first], NoLength(count));
  }
  cloud_.has_uz = cloud_.displacements.empty() || has(kDisplacement + 2);
  *cloud = std::move(cloud_);
  return true;
}

// The first vector that is not finite, in words; empty if there is none.
std::string NotFinite(const PointCloud& cloud) {
  const std::array<const std::vector<Eigen::Vector3d>*, 3> vectors = {
      &cloud.points, &cloud.normals, &cloud.displacements};
  std::string text;
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    bool is_finite = true;
    for (std::size_t v = 0; v < vectors.size() && is_finite; ++v) {
      if (vectors[v]->empty()) continue;
      for (int k = 0; k < 3 && is_finite; ++k) {
        const double value = (*vectors[v])[i][k];
        is_finite = std::isfinite(value);
        if (is_finite || count > 0) continue;
        AppendNumber(value, &text);
        text = "'" + text + "' as " + kNames[3 * v + static_cast<std::size_t>(k)] + " of point " +
               std::to_string(i);
      }
    }
    if (!is_finite) ++count;
  }
  return count == 0 ? "" : text + FirstOf(count, "not finite") + "; allowed finite numbers";
}

bool IsText(const std::string& ending) {
  return ending == ".csv" || ending == ".txt" || ending == ".xyz";
}

std::string Ending(const std::string& file) {
  return Lower(std::filesystem::path(file).extension().string());
}

}  // namespace

bool ParsePointCloud(std::string_view contents,
                     const std::string& file,
                     PointCloud* cloud,
                     std::string* error) {
  if (contents.empty()) {
    *error = file + ":0: found an empty file; allowed a line of numbers for each point";
    return false;
  }
  return TableReader(contents, file, error).Read(cloud);
}

bool ReadPointCloud(const std::string& file, PointCloud* cloud, std::string* error) {
  const std::string ending = Ending(file);
  if (IsText(ending)) {
    std::string contents;
    return ReadBytes(file, "a file of points", &contents, error) &&
           ParsePointCloud(contents, file, cloud, error);
  }
  const auto fail = [&](const std::string& what) {
    *error = file + ":0: found " + what;
    return false;
  };
  static const std::vector<std::string> kEndings = {
      ".csv", ".txt", ".xyz", ".ply", ".obj", ".stl", ".off"};
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end()) {
    return fail(FoundInsteadOf("a name that ends with", ending, kEndings));
  }
  TriangleMesh mesh;
  VertexVectors vectors;
  if (!ReadVertices(file, &mesh, &vectors, error)) return false;
  PointCloud read;
  read.points = std::move(mesh.vertices);
  read.normals = std::move(vectors.normals);
  read.displacements = std::move(vectors.displacements);
  if (const std::string what = NotFinite(read); !what.empty()) return fail(what);
  std::size_t first = 0;
  if (const std::size_t count = Normalise(&read.normals, &first); count > 0) {
    return fail("at point " + std::to_string(first) + " " + NoLength(count));
  }
  *cloud = std::move(read);
  return true;
}

bool WritePointCloud(const std::string& file,
                     const PointCloud& cloud,
                     const std::vector<std::string>& comment,
                     std::string* error) {
  std::string text;
  return FormatPointCloud(file, cloud, {}, comment, &text, error) && WriteBytes(file, text, error);
}

bool FormatPointCloud(const std::string& file,
                      const PointCloud& cloud,
                      const std::vector<std::array<int, 3>>& triangles,
                      const std::vector<std::string>& comment,
                      std::string* out,
                      std::string* error) {
  CHECK(cloud.normals.empty() || cloud.normals.size() == cloud.points.size());
  CHECK(cloud.displacements.empty() || cloud.displacements.size() == cloud.points.size());
  const auto fail = [&](const std::string& what) {
    *error = file + ":0: found " + what;
    return false;
  };
  const std::string ending = Ending(file);
  if (ending != ".csv" && ending != ".ply") {
    return fail(FoundInsteadOf("a name that ends with", ending, {".csv", ".ply"}));
  }
  if (cloud.empty()) return fail("no points to write; allowed one at least");
  if (const std::string what = NotFinite(cloud); !what.empty()) return fail(what);

  const bool is_csv = ending == ".csv";
  const bool is_plane = is_csv && !cloud.has_uz;
  std::string text = is_csv ? "" : "ply\nformat ascii 1.0\n";
  for (const std::string& entry : comment) {  // A line feed in one begins another.
    LineReader lines(entry);
    while (lines.Next()) {
      text += is_csv ? "# " : "comment ";
      text += Trimmed(lines.line());
      text += '\n';
    }
  }
  if (!is_csv) text += "element vertex " + std::to_string(cloud.points.size()) + "\n";
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    if (k >= kNormal && k < kDisplacement && cloud.normals.empty()) continue;
    if (k >= kDisplacement && cloud.displacements.empty()) continue;
    if (k == kDisplacement + 2 && is_plane) continue;
    text += is_csv ? (k == 0 ? "" : ",") : "property double ";
    text += kNames[k];
    if (!is_csv) text += '\n';
  }
  const bool has_faces = !is_csv && !triangles.empty();
  if (has_faces) {
    text += "element face " + std::to_string(triangles.size()) +
            "\nproperty list uchar int vertex_indices\n";
  }
  text += is_csv ? "\n" : "end_header\n";
  const char separator = is_csv ? ',' : ' ';
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    AppendNumbers(cloud.points[i], separator, &text);
    if (!cloud.normals.empty()) {
      text += separator;
      AppendNumbers(cloud.normals[i], separator, &text);
    }
    if (!cloud.displacements.empty()) {
      text += separator;
      if (is_plane) {
        AppendNumber(cloud.displacements[i].x(), &text);
        text += separator;
        AppendNumber(cloud.displacements[i].y(), &text);
      } else {
        AppendNumbers(cloud.displacements[i], separator, &text);
      }
    }
    text += '\n';
  }
  for (std::size_t t = 0; has_faces && t < triangles.size(); ++t) {
    text += '3';
    for (const int corner : triangles[t]) text += ' ' + std::to_string(corner);
    text += '\n';
  }
  *out = std::move(text);
  return true;
}

double Extent(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

}  // namespace darboux
