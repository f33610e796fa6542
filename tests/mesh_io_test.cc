#include "geometry/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/mesh_util.h"
#include "tests/sanitizer_util.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kBrokenMeshes[] = DARBOUX_DATA_DIR "/broken_meshes/";

TriangleMesh Parse(const std::string& contents, const std::string& file) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_TRUE(ParseMesh(contents, file, &mesh, &error)) << error;
  return mesh;
}

std::string ParseError(const std::string& contents, const std::string& file) {
  TriangleMesh mesh;
  std::string error;
  EXPECT_FALSE(ParseMesh(contents, file, &mesh, &error)) << contents;
  return error;
}

// Bit for bit, apart from which nan it is.
bool IsSame(const TriangleMesh& a, const TriangleMesh& b) {
  if (a.vertices.size() != b.vertices.size() || a.triangles != b.triangles) return false;
  for (std::size_t v = 0; v < a.vertices.size(); ++v) {
    for (int k = 0; k < 3; ++k) {
      const double x = a.vertices[v][k], y = b.vertices[v][k];
      if (std::isnan(x) ? !std::isnan(y) : x != y || std::signbit(x) != std::signbit(y))
        return false;
    }
  }
  return true;
}

MATCHER_P(IsTheMesh, expected, "") { return IsSame(arg, expected); }

// Bytes of a number in a file.
template <typename T>
std::string Bytes(T value, bool big_endian) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  const std::uint16_t one = 1;
  unsigned char first = 0;
  std::memcpy(&first, &one, 1);
  if ((first == 0) != big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

// --- PLY ---------------------------------------------------------------------------------------

struct PlyCase {
  std::string format;  // ascii, binary_little_endian, binary_big_endian
  std::string coordinate, count, index;
};

std::vector<PlyCase> PlyCases() {
  const std::vector<std::string> integers = {"char",
                                             "uchar",
                                             "short",
                                             "ushort",
                                             "int",
                                             "uint",
                                             "int8",
                                             "uint8",
                                             "int16",
                                             "uint16",
                                             "int32",
                                             "uint32",
                                             "int64",
                                             "uint64"};
  std::vector<PlyCase> cases;
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* type : {"float", "double", "float32", "float64"}) {
      cases.push_back({format, type, "uchar", "int"});
      cases.push_back({format, "double", "uchar", type});
    }
    for (const std::string& type : integers) {
      cases.push_back({format, type, "uchar", "int"});
      cases.push_back({format, "float", type, "int"});
      cases.push_back({format, "float", "uchar", type});
    }
  }
  return cases;
}

std::string Number(double value, const std::string& type, const std::string& format) {
  if (format == "ascii") {
    std::ostringstream text;
    text.precision(17);
    text << value << ' ';
    return text.str();
  }
  const bool big = format == "binary_big_endian";
  if (type == "char" || type == "int8") return Bytes(static_cast<std::int8_t>(value), big);
  if (type == "uchar" || type == "uint8") return Bytes(static_cast<std::uint8_t>(value), big);
  if (type == "short" || type == "int16") return Bytes(static_cast<std::int16_t>(value), big);
  if (type == "ushort" || type == "uint16") return Bytes(static_cast<std::uint16_t>(value), big);
  if (type == "int" || type == "int32") return Bytes(static_cast<std::int32_t>(value), big);
  if (type == "uint" || type == "uint32") return Bytes(static_cast<std::uint32_t>(value), big);
  if (type == "int64") return Bytes(static_cast<std::int64_t>(value), big);
  if (type == "uint64") return Bytes(static_cast<std::uint64_t>(value), big);
  if (type == "float" || type == "float32") return Bytes(static_cast<float>(value), big);
  return Bytes(value, big);
}

// With elements and properties that a reader of meshes has to step over, lists among them.
std::string PlyText(const TriangleMesh& mesh, const PlyCase& c) {
  const std::string& f = c.format;
  std::string text = "ply\nformat " + f + " 1.0\ncomment made by hand\nobj_info none\n";
  text += "element camera 2\nproperty list uchar short taps\nproperty double focus\n";
  text += "element vertex " + std::to_string(mesh.vertices.size()) + "\nproperty uchar red\n";
  for (const char* name : {"x", "y", "z"}) text += "property " + c.coordinate + " " + name + "\n";
  text += "property list uint float weights\nproperty short label\n";
  text += "element empty 1000000000000\n";
  text += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty uchar flags\n";
  text += "property list " + c.count + " " + c.index + " vertex_index\n";
  text += "property list uchar float texcoord\nelement edge 1\nproperty int vertex1\nend_header\n";
  const std::string line = f == "ascii" ? "\n" : "";
  for (int k = 0; k < 2; ++k) {
    text += Number(2, "uchar", f) + Number(-3, "short", f) + Number(4, "short", f) +
            Number(0.5, "double", f) + line;
  }
  for (const Eigen::Vector3d& v : mesh.vertices) {
    text += Number(200, "uchar", f);
    for (int k = 0; k < 3; ++k) text += Number(v[k], c.coordinate, f);
    text += Number(1, "uint", f) + Number(0.25, "float", f) + Number(-7, "short", f) + line;
  }
  for (const std::array<int, 3>& t : mesh.triangles) {
    text += Number(1, "uchar", f) + Number(3, c.count, f);
    for (const int v : t) text += Number(v, c.index, f);
    text += Number(0, "uchar", f) + line;
  }
  return text + Number(5, "int", f) + line;
}

class PlyTest : public ::testing::TestWithParam<PlyCase> {};

TEST_P(PlyTest, AnyTypesAreReadAndOtherPropertiesSkipped) {
  TriangleMesh mesh = Octahedron();
  for (Eigen::Vector3d& v : mesh.vertices) v = 20.0 * (v + Eigen::Vector3d::Ones());
  if (GetParam().coordinate.substr(0, 5) == "float") mesh.vertices[0][0] = -1.5;
  if (GetParam().coordinate.substr(0, 6) == "double") mesh.vertices[0][0] = 0.1;
  EXPECT_THAT(Parse(PlyText(mesh, GetParam()), "mesh.ply"), IsTheMesh(mesh));
}

INSTANTIATE_TEST_SUITE_P(AllTypes, PlyTest, ::testing::ValuesIn(PlyCases()));

TEST(PlyTest, NarrowTypesKeepTheirSign) {
  const TriangleMesh mesh = {{{-128, -1, 127}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}};
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* type : {"char", "int16", "int", "int64"}) {
      const std::string text = PlyText(mesh, {format, type, "int8", "int8"});
      EXPECT_THAT(Parse(text, "mesh.ply"), IsTheMesh(mesh)) << format << " " << type;
    }
  }
}

TEST(PlyTest, LinesOfTheHeaderMayEndAsOnAnySystem) {
  const std::string text = PlyText(Octahedron(), {"binary_big_endian", "float", "uchar", "int"});
  const std::size_t header = text.find("end_header\n") + 11;
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string changed;
    for (std::size_t i = 0; i < header; ++i) changed += text[i] == '\n' ? end : text.substr(i, 1);
    // A first byte of data that looks like the rest of the line end is none.
    changed.insert(changed.find("element camera"),
                   "element pad 1" + std::string(end) + "property uchar pad" + end);
    EXPECT_THAT(Parse(changed + "\n" + text.substr(header), "mesh.ply"), IsTheMesh(Octahedron()));
  }
}

TEST(PlyTest, FacesMayComeBeforeVertices) {
  EXPECT_THAT(
      Parse("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
            "element vertex 3\nproperty int x\nproperty int y\nproperty int z\nend_header\n"
            "3 2 0 1\n0 0 0\n1 0 0\n0 1 0\n",
            "mesh.ply"),
      IsTheMesh(TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{2, 0, 1}}}}));
}

// --- Writers -----------------------------------------------------------------------------------

// Numbers of all sizes, as bit patterns.
TriangleMesh AnyNumbers() {
  TriangleMesh mesh = Octahedron();
  std::mt19937_64 gen(38401);
  for (int i = 0; i < 2000; ++i) {
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t bits = gen();
      std::memcpy(&v[k], &bits, sizeof(bits));
    }
    mesh.vertices.push_back(v);
  }
  using Limits = std::numeric_limits<double>;
  mesh.vertices.emplace_back(-0.0, Limits::denorm_min(), -Limits::min());
  mesh.vertices.emplace_back(Limits::max(), Limits::infinity(), Limits::quiet_NaN());
  mesh.vertices.emplace_back(0.1, 1.0 / 3.0, 1e23);
  return mesh;
}

using WriterTest = FolderTest;

TEST_F(WriterTest, EveryDoubleComesBackBitForBit) {
  const TriangleMesh mesh = AnyNumbers();
  std::string error;
  TriangleMesh read;
  ASSERT_TRUE(WriteObj(Path("a.obj"), mesh, &error)) << error;
  ASSERT_TRUE(ReadMesh(Path("a.obj"), &read, &error)) << error;
  EXPECT_THAT(read, IsTheMesh(mesh));
  ASSERT_TRUE(WritePly(Path("a.PLY"), mesh, &error)) << error;
  ASSERT_TRUE(ReadMesh(Path("a.PLY"), &read, &error)) << error;
  EXPECT_THAT(read, IsTheMesh(mesh));
}

TEST_F(WriterTest, WritesTheShortestDigits) {
  std::string error;
  ASSERT_TRUE(WriteObj(Path("a.obj"), {{{0.1, -2, 1e-7}}, {{{0, 0, 0}}}}, &error));
  std::ifstream stream(Path("a.obj"));
  std::stringstream text;
  text << stream.rdbuf();
  EXPECT_EQ(text.str(), "v 0.1 -2 1e-07\nf 1 1 1\n");
}

TEST_F(WriterTest, SaysWhyAFileCannotBeWritten) {
  std::string error;
  EXPECT_FALSE(WriteObj(Path("missing/a.obj"), Octahedron(), &error));
  EXPECT_THAT(error, StartsWith(Path("missing/a.obj") + ":0: found a file that cannot be written"));
  EXPECT_FALSE(WritePly(folder_.string(), Octahedron(), &error));
  EXPECT_THAT(error, StartsWith(folder_.string() + ":0: found a file that cannot be written"));
}

TEST_F(WriterTest, SaysWhyAFileCannotBeRead) {
  std::string error;
  TriangleMesh mesh = Octahedron();
  EXPECT_FALSE(ReadMesh(Path("missing.obj"), &mesh, &error));
  EXPECT_EQ(error,
            Path("missing.obj") +
                ":0: found a file that cannot be read (No such file or directory); "
                "allowed a mesh file");
  std::filesystem::create_directory(Path("folder.obj"));
  EXPECT_FALSE(ReadMesh(Path("folder.obj"), &mesh, &error));
  EXPECT_THAT(error, HasSubstr("it is a directory"));
  std::filesystem::create_symlink("/dev/zero", Path("endless.stl"));
  EXPECT_FALSE(ReadMesh(Path("endless.stl"), &mesh, &error));
  EXPECT_THAT(error, HasSubstr("it is no plain file"));
  EXPECT_THAT(mesh, IsTheMesh(Octahedron()));  // Unchanged.
}

// --- OBJ ---------------------------------------------------------------------------------------

TEST(ObjTest, ReadsWhatOthersWrite) {
  const std::string text =
      "\xEF\xBB\xBF# a comment\nmtllib a.mtl\no thing\ng one two\nusemtl red\ns off\n"
      "v +1 0 0 # here too\n  v\t-1.0e0 0 0 1.0\nv 0 1 0 0.5 0.5 0.5\nvn 0 0 1\nvt 0 0\n"
      "v 0 0 \\\n 1\nvn 0 0 1\n\nf 1/1/1 2/1/1 3/1/1\nf 1//1 3//2 -1//-1\nf -4/1 \\\n 4 2\n"
      "l 1 2\np 1\nf 2 4 3";
  const TriangleMesh mesh = {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                             {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{1, 3, 2}}}};
  EXPECT_THAT(Parse(text, "a.obj"), IsTheMesh(mesh));
  for (const char* end : {"\r\n", "\r"}) {
    std::string changed;
    for (const char c : text) changed += c == '\n' ? std::string(end) : std::string(1, c);
    EXPECT_THAT(Parse(changed, "a.obj"), IsTheMesh(mesh));
  }
}

TEST(ObjTest, FacesMayComeBeforeTheirVertices) {
  EXPECT_EQ(Parse("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "a.obj").triangles.size(), 1u);
}

TEST(ObjTest, CoordinatesAreDoublesSoThatMillimetresAreMetres) {
  const std::vector<std::string> digits = {"123456789012", "987654321098", "100000000001"};
  std::string metres, millimetres;
  for (const std::string& d : digits) {
    metres += "v 0." + d + " 0.5 1.000000000001\n";
    millimetres += "v " + d.substr(0, 3) + "." + d.substr(3) + " 500 1000.000000001\n";
  }
  const TriangleMesh m = Parse(metres + "f 1 2 3\n", "m.obj");
  const TriangleMesh mm = Parse(millimetres + "f 1 2 3\n", "mm.obj");
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_LE((1e-3 * mm.vertices[v] - m.vertices[v]).norm(), 1e-15 * m.vertices[v].norm());
  }
}

TEST(ObjTest, NumbersHaveAPointWhateverTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const TriangleMesh mesh = Parse("v 0.5 1000.25 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj");
  std::locale::global(before);
  EXPECT_EQ(mesh.vertices[0], Eigen::Vector3d(0.5, 1000.25, 0.0));
}

TEST(ObjTest, NumbersTooSmallForADoubleAreZero) {
  EXPECT_EQ(Parse("v 1e-999 -1e-400 0.5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj").vertices[0],
            Eigen::Vector3d(0.0, 0.0, 0.5));
}

// --- OFF ---------------------------------------------------------------------------------------

TEST(OffTest, SkipsColoursNormalsAndComments) {
  const TriangleMesh mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                             {{{0, 1, 2}}, {{0, 2, 3}}}};
  const std::string plain = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n";
  for (const char* head : {"OFF\n4 2 0\n",
                           "OFF 4 2 0\n",
                           "OFF4 2 0\n",
                           "OFF\n4 2\n",
                           "# made by hand\n\nOFF # yes\n# no\n4 2 5\n\n",
                           "OFF\r\n4 2 0\r\n"}) {
    EXPECT_THAT(Parse(head + plain, "a.off"), IsTheMesh(mesh)) << head;
  }
  for (const char* head : {"COFF", "NOFF", "STOFF", "CNOFF"}) {
    EXPECT_THAT(
        Parse(std::string(head) + "\n4 2 0\n0 0 0 1 0 0 1\n1 0 0 1 1 1 1\n0 1 0 0 0 0 1 # c\n"
                                  "0 0 1 9 9 9 1\n3 0 1 2 255 0 0\n3 0 2 3 0.5 0.5 0.5 1\n",
              "a.off"),
        IsTheMesh(mesh))
        << head;
  }
}

// --- STL ---------------------------------------------------------------------------------------

std::string BinaryStl(const std::vector<std::array<std::array<float, 3>, 3>>& triangles) {
  std::string text = "solid as some begin binary files too";
  text.resize(80, ' ');
  text += Bytes(static_cast<std::uint32_t>(triangles.size()), false);
  for (const auto& triangle : triangles) {
    text += Bytes(0.0f, false) + Bytes(0.0f, false) + Bytes(1.0f, false);
    for (const auto& corner : triangle) {
      for (const float x : corner) text += Bytes(x, false);
    }
    text += "ab";
  }
  return text;
}

TEST(StlTest, MergesEqualCornersInTheOrderOfAppearance) {
  const float next = std::nextafter(0.1f, 1.0f);
  const std::string text = BinaryStl({{{{{0.1f, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}}},
                                      {{{{0, 1, -0.0f}}, {{1, 0, 0}}, {{1, 1, 0}}}},
                                      {{{{next, 0, 0}}, {{0, 1, 0}}, {{2, 2, 2}}}}});
  EXPECT_THAT(Parse(text, "a.STL"),
              IsTheMesh(TriangleMesh{
                  {{0.1f, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {next, 0, 0}, {2, 2, 2}},
                  {{{0, 1, 2}}, {{2, 1, 3}}, {{4, 2, 5}}}}));
}

TEST(StlTest, ReadsTextInAnyCaseWithSeveralSolids) {
  const std::string facet =
      "FACET NORMAL 0 0 1\n OUTER LOOP\n  VERTEX 0.1 0 0\n  vertex 1 0 0\n  vertex 0 1e0 0\n"
      " endloop\nendfacet\n";
  EXPECT_THAT(
      Parse("solid one\n" + facet + "endsolid one\nSOLID\n" + facet + "endsolid", "a.stl"),
      IsTheMesh(TriangleMesh{{{0.1, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}, {{0, 1, 2}}}}));
}

// --- Polygons ----------------------------------------------------------------------------------

TEST(PolygonTest, ConvexOnesAreFansAboutTheirFirstCorner) {
  const std::string vertices = "v 0 0 0\nv 2 0 0.2\nv 3 1 0\nv 2 2 0.1\nv 0 2 0\n";
  EXPECT_EQ(Parse(vertices + "f 2 3 4 5 1\n", "a.obj").triangles,
            (std::vector<std::array<int, 3>>{{1, 2, 3}, {1, 3, 4}, {1, 4, 0}}));
}

TEST(PolygonTest, OthersAreCutWithoutLeavingThem) {
  // An L in all its rotations: a fan about most corners would cover its notch.
  const std::string vertices = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  for (int first = 0; first < 6; ++first) {
    std::string face = "f";
    for (int k = 0; k < 6; ++k) face += " " + std::to_string((first + k) % 6 + 1);
    const TriangleMesh mesh = Parse(vertices + face + "\n", "a.obj");
    EXPECT_EQ(mesh.triangles.size(), 4u);
    EXPECT_NEAR(Area(mesh), 3.0, 1e-15) << face;
  }
}

TEST(PolygonTest, SizeIsBounded) {
  std::string star, face = "f";
  for (int k = 0; k < 100; ++k) {
    const double r = k % 2 == 0 ? 1.0 : 0.5;
    star += "v " + std::to_string(r * std::cos(0.02 * M_PI * k)) + " " +
            std::to_string(r * std::sin(0.02 * M_PI * k)) + " 0\n";
    face += " " + std::to_string(k + 1);
  }
  EXPECT_EQ(ParseError(star + face + "\n", "a.obj"),
            "a.obj:101: found face 0, not convex, with 100 corners; allowed 64, or any number of a "
            "convex face");
}

// --- Points ------------------------------------------------------------------------------------

TEST(ReadPointsTest, NeedsNoFaces) {
  std::vector<Eigen::Vector3d> points;
  std::string error;
  ASSERT_TRUE(ReadPoints(std::string(kBrokenMeshes) + "no_faces.obj", &points, &error)) << error;
  EXPECT_EQ(points, Octahedron().vertices);
  EXPECT_FALSE(ReadPoints(std::string(kBrokenMeshes) + "no_vertices.off", &points, &error));
}

// --- Broken files ------------------------------------------------------------------------------

struct Refusal {
  std::string file, message;  // After "FILE:".
};

TEST(BrokenMeshTest, MessagesSayWhereWhatAndWhatIsAllowed) {
  const std::vector<Refusal> refusals = {
      {"empty.obj", "0: found an empty file; allowed a mesh"},
      {"no_faces.obj", "6: found 6 vertices and no faces; allowed at least one face"},
      {"no_vertices.off", "2: found no vertices; allowed at least one face"},
      {"unknown_ending.xyz",
       "0: found a name that ends with '.xyz'; allowed .obj | .ply | .stl | .off"},
      {"garbage.obj",
       "1: found the keyword 'Dear'; allowed v | f | vt | vn | g | o | s | l | p | mtllib | "
       "usemtl"},
      {"garbage.ply", "1: found 'Dear'; allowed 'ply' on the first line"},
      {"garbage.stl", "1: found 'Dear'; allowed 'solid'"},
      {"garbage.off",
       "1: found the header 'Dear'; allowed OFF | COFF | NOFF | CNOFF | STOFF | STCOFF | STNOFF | "
       "STCNOFF"},
      {"misspelt_keyword.obj",
       "3: found the keyword 'vv'; allowed v | f | vt | vn | g | o | s | l | p | mtllib | usemtl; "
       "did you mean 'v'?"},
      {"index_too_large.obj", "14: found vertex 7 in face 7; allowed 1 to 6"},
      {"index_zero.obj",
       "14: found vertex 0 in a face; allowed numbers from 1, or from -1 to -6 for the vertices so "
       "far"},
      {"index_too_negative.obj",
       "14: found vertex -7 in a face; allowed numbers from 1, or from -1 to -6 for the vertices "
       "so "
       "far"},
      {"index_too_large.ply", "23: found vertex 6 in face 7; allowed 0 to 5"},
      {"index_negative_binary.ply", "byte 332: found vertex -1 in face 7; allowed 0 to 5"},
      {"two_coordinates.obj", "4: found a vertex with 2 coordinates; allowed x y z"},
      {"comma_for_point.obj",
       "4: found '-1,5' in a vertex; allowed a number in the range of a double"},
      {"number_too_large.obj",
       "4: found '-1e999' in a vertex; allowed a number in the range of a double"},
      {"truncated_little_endian.ply",
       "byte 225: found the end of the file in place of vertex 4; allowed vertex 0 to 5 as line 3 "
       "of "
       "the header says"},
      {"truncated_big_endian.ply",
       "byte 330: found a list 'vertex_indices' longer than the rest of the file in face 7; "
       "allowed "
       "at most 1 values"},
      {"truncated_header.ply",
       "5: found the keyword 'prope'; allowed format | comment | obj_info | element | property | "
       "end_header"},
      {"vertex_count_too_large.ply",
       "3: found 1000000000000 elements 'vertex', more than the file has room for; allowed as many "
       "as follow"},
      {"vertex_count_too_small.ply", "15: found 3 values of face 0; allowed 1"},
      {"face_count_too_large.ply",
       "23: found the end of the file in place of face 8; allowed face 0 to 8 as line 7 of the "
       "header "
       "says"},
      {"face_count_too_small.ply",
       "byte 332: found 13 bytes after the last element; allowed the end of the file, as the "
       "header "
       "counts no more"},
      {"list_too_long.ply",
       "byte 333: found a list 'vertex_indices' longer than the rest of the file in face 7; "
       "allowed "
       "at most 3 values"},
      {"misspelt_type.ply",
       "6: found the type 'flot'; allowed char | int8 | uchar | uint8 | short | int16 | ushort | "
       "uint16 | int | int32 | uint | uint32 | float | float32 | double | float64 | int64 | "
       "uint64; "
       "did you mean 'float'?"},
      {"no_z.ply", "3: found vertices without a number 'z'; allowed with x, y and z"},
      {"corner_no_integer.ply",
       "16: found a corner of face 0 that is no whole number; allowed the number of a vertex"},
      {"unknown_format.ply",
       "2: found the format 'binary'; allowed ascii | binary_little_endian | binary_big_endian"},
      {"truncated.stl",
       "byte 80: found a count of 8 triangles, which take 484 bytes, in a file of 464; allowed 7"},
      {"count_too_large.stl",
       "byte 80: found a count of 4294967295 triangles, which take 214748364834 bytes, in a file "
       "of "
       "484; allowed 8"},
      {"truncated_text.stl", "54: found 've'; allowed 'vertex'"},
      {"four_corners.stl", "7: found 'vertex'; allowed 'endloop' after three vertices"},
      {"vertex_count_too_small.off",
       "16: found '3' after the last face; allowed the end of the file, as line 2 counts no more"},
      {"face_count_too_large.off",
       "16: found the end of the file in place of face 8; allowed face 0 to 8 as line 2 says"},
      {"face_count_too_small.off",
       "16: found '3' after the last face; allowed the end of the file, as line 2 counts no more"},
      {"two_corners.off", "16: found face 7 with 2 corners; allowed 3 or more"},
  };
  for (const Refusal& refusal : refusals) {
    const std::string file = kBrokenMeshes + refusal.file;
    TriangleMesh mesh = Octahedron();
    std::string error;
    EXPECT_FALSE(ReadMesh(file, &mesh, &error)) << file;
    EXPECT_EQ(error, file + ":" + refusal.message);
    EXPECT_THAT(mesh, IsTheMesh(Octahedron())) << file;  // Unchanged.
  }
}

TEST(BrokenMeshTest, HeadersOfPlyAreChecked) {
  const std::string rest = "end_header\n0 0 0\n";
  const std::string vertex =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  const std::vector<std::array<std::string, 2>> cases = {
      {"ply\n" + vertex + rest, "6: found 'end_header' without a format"},
      {"ply\nformat ascii 2.0\n", "2: found the version '2.0'; allowed 1.0"},
      {"ply\nformat ascii 1.0\nformat ascii 1.0\n", "3: found a second 'format'"},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", "3: found an element without a count"},
      {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n",
       "3: found an element without"},
      {"ply\nformat ascii 1.0\nproperty float x\n", "3: found a property before the first element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
       "4: found a list counted by 'float'; allowed an integer type"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n",
       "4: found a property of 2 words"},
      {"ply\nformat ascii 1.0\n" + vertex + "property float x\n", "7: found a second property 'x'"},
      {"ply\nformat ascii 1.0\n" + vertex + "element vertex 1\n",
       "7: found a second element 'vertex'"},
      {"ply\nformat ascii 1.0\n" + vertex, "6: found the end of the file in the header"},
      {"ply\nformat ascii 1.0\nelement face 1\nproperty int n\n" + vertex + rest,
       "3: found faces without corners"},
      {"ply\nformat ascii 1.0\n" + rest, "3: found no element 'vertex' in the header"},
      {"ply\nformat ascii 1.0\n" + vertex + "end_header\n0 0 0 0\n",
       "8: found 4 values of vertex 0; allowed 3"},
      {"ply\nformat ascii 1.0\n" + vertex + "end_header\n0 0\n", "8: found 2 values of vertex 0"},
      {"ply\nformat ascii 1.0\n" + vertex + "end_header\n0 0 zero\n",
       "8: found 'zero' in vertex 0; allowed a number"},
      {"ply\nformat ascii 1.0\n" + vertex + "end_header\n0 0 0\nmore\n",
       "9: found 'more' after the last element"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(ParseError(text, "a.ply"), StartsWith("a.ply:" + message)) << text;
  }
}

TEST(BrokenMeshTest, MessagesAreOneLineWhateverStandsInTheFile) {
  const std::string error = ParseError("v 1 2 \x01\x02" + std::string(1000, 'x') + "\n", "a.obj");
  EXPECT_EQ(error,
            "a.obj:1: found '??" + std::string(38, 'x') +
                "...' in a vertex; allowed a number in the range of a double");
}

// Files that are right, for the tests below to spoil.
std::vector<std::array<std::string, 2>> Specimens() {
  const TriangleMesh mesh = Octahedron();
  std::vector<std::array<std::string, 2>> files;
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    files.push_back({"a.ply", PlyText(mesh, {format, "float", "uchar", "int"})});
  }
  std::string obj, off = "OFF\n6 8 0\n", stl = "solid s\n";
  std::vector<std::array<std::array<float, 3>, 3>> triangles;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    std::ostringstream text;
    text << v.transpose() << "\n";
    obj += "v " + text.str();
    off += text.str();
  }
  for (const std::array<int, 3>& t : mesh.triangles) {
    obj += "f", off += "3", stl += "facet normal 0 0 0\nouter loop\n";
    triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      obj += " " + std::to_string(t[k] + 1) + "/1";
      off += " " + std::to_string(t[k]);
      const Eigen::Vector3f v = mesh.vertices[static_cast<std::size_t>(t[k])].cast<float>();
      std::ostringstream text;
      text << v.transpose();
      stl += "vertex " + text.str() + "\n";
      triangles.back()[k] = {v[0], v[1], v[2]};
    }
    obj += "\n", off += "\n", stl += "endloop\nendfacet\n";
  }
  files.push_back({"a.obj", obj + "f 1 2 3 4 5\n"});
  files.push_back({"a.off", off});
  files.push_back({"a.stl", stl + "endsolid\n"});
  files.push_back({"a.stl", BinaryStl(triangles)});
  return files;
}

// Read or refused, but never more than that.
void ExpectSafe(const std::string& text, const std::string& file) {
  TriangleMesh mesh;
  std::string error;
  if (ParseMesh(text, file, &mesh, &error)) {
    ASSERT_FALSE(mesh.triangles.empty());
    ASSERT_LE(mesh.vertices.size() + mesh.triangles.size(), text.size());
    for (const std::array<int, 3>& t : mesh.triangles) {
      for (const int v : t) {
        ASSERT_GE(v, 0);
        ASSERT_LT(v, static_cast<int>(mesh.vertices.size()));
      }
    }
  } else {
    ASSERT_THAT(error, StartsWith(file + ":"));
    ASSERT_THAT(error, HasSubstr(": found "));
    ASSERT_THAT(error, HasSubstr("; allowed "));
    ASSERT_EQ(error.find('\n'), std::string::npos);
    ASSERT_LT(error.size(), 400u);
    ASSERT_TRUE(mesh.vertices.empty() && mesh.triangles.empty());
  }
}

TEST(HostileMeshTest, SpecimensAreRight) {
  for (const auto& [file, text] : Specimens()) EXPECT_EQ(Parse(text, file).vertices.size(), 6u);
}

TEST(HostileMeshTest, TruncatedAnywhere) {
  for (const auto& [file, text] : Specimens()) {
    for (std::size_t n = 0; n < text.size(); ++n) ExpectSafe(text.substr(0, n), file);
  }
}

TEST(HostileMeshTest, AnyByteChanged) {
  std::mt19937 gen(38401);
  for (const auto& [file, text] : Specimens()) {
    for (int trial = 0; trial < 3000; ++trial) {
      std::string changed = text;
      for (int k = 0; k <= trial % 4; ++k) {
        const std::size_t at = gen() % changed.size();
        switch (gen() % 4) {
          case 0:
            changed[at] = static_cast<char>(gen());
            break;
          case 1:
            changed[at] = "0123456789-. \n"[gen() % 14];
            break;
          case 2:
            changed.erase(at, 1 + gen() % 8);
            break;
          default:
            changed.insert(at, changed.substr(gen() % changed.size(), gen() % 20));
        }
        if (changed.empty()) changed = " ";
      }
      ExpectSafe(changed, file);
    }
  }
}

TEST(HostileMeshTest, TheWrongEnding) {
  for (const auto& [file, text] : Specimens()) {
    for (const char* other : {"b.obj", "b.ply", "b.off", "b.stl"}) ExpectSafe(text, other);
  }
}

TEST(HostileMeshTest, CountsAllocateNothing) {
  const double start = CpuSeconds();
  const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
  const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face =
      "element face 2147483647\nproperty list uint int vertex_indices\nend_header\n";
  ExpectSafe(head + "9223372036854775807" + xyz + face, "a.ply");
  ExpectSafe(head + "0" + xyz + face + std::string(8, '\xff'), "a.ply");
  ExpectSafe(head + "9223372036854775807\n" + face, "a.ply");
  ExpectSafe("OFF\n2147483647 2147483647 0\n", "a.off");
  ExpectSafe("OFF\n1 1 0\n0 0 0\n9223372036854775807 0 0 0\n", "a.off");
  ExpectSafe(std::string(80, '\0') + "\xff\xff\xff\xff", "a.stl");
  EXPECT_LT(CpuSeconds() - start, 0.1 * kSlowdown);
}

TEST(HostileMeshTest, LargeFilesTakeLinearTime) {
  std::string text;
  for (int k = 0; k < 200000; ++k) text += "v " + std::to_string(k) + " 0.25 -1e-3\nf -1 1 1\n";
  const double start = CpuSeconds();
  EXPECT_EQ(Parse(text, "a.obj").triangles.size(), 200000u);
  EXPECT_LT(CpuSeconds() - start, 2.0 * kSlowdown);  // 0.05 s
}

}  // namespace
}  // namespace darboux
