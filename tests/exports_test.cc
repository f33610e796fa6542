#include "solver/exports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "solver/field_table.h"
#include "solver/inp_export.h"
#include "solver/npz_writer.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"
#include "tests/temporary_folder.h"

namespace darboux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::uint64_t Little(const std::string& bytes, size_t at, size_t count) {
  std::uint64_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

// Bit by bit, not by table as the writer has it.
std::uint32_t Crc(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

struct Array {
  std::string header, data;
};

// The entries of a zip archive, found from its end as readers do, each checked.
std::map<std::string, Array> ReadNpz(const std::string& zip) {
  std::map<std::string, Array> arrays;
  if (zip.size() < 22) return arrays;
  const size_t end = zip.size() - 22;
  EXPECT_EQ(zip.substr(end, 4), std::string("PK\x05\x06"));
  const size_t count = Little(zip, end + 10, 2);
  size_t at = Little(zip, end + 16, 4);
  EXPECT_EQ(at + Little(zip, end + 12, 4), end);
  for (size_t i = 0; i < count; ++i) {
    EXPECT_EQ(zip.substr(at, 4), std::string("PK\x01\x02"));
    const size_t size = Little(zip, at + 24, 4), length = Little(zip, at + 28, 2);
    const std::string name = zip.substr(at + 46, length);
    const size_t local = Little(zip, at + 42, 4);
    EXPECT_EQ(zip.substr(local, 4), std::string("PK\x03\x04"));
    EXPECT_EQ(zip.substr(local + 30, length), name);
    const std::string contents = zip.substr(local + 30 + length, size);
    EXPECT_EQ(Little(zip, at + 16, 4), Crc(contents)) << name;
    EXPECT_EQ(Little(zip, local + 14, 4), Crc(contents)) << name;
    EXPECT_EQ(contents.substr(0, 8), std::string("\x93NUMPY\x01\0", 8));
    const size_t header = Little(contents, 8, 2);
    EXPECT_EQ((10 + header) % 64, 0u);
    EXPECT_EQ(contents[9 + header], '\n');
    arrays[name] = {contents.substr(10, header), contents.substr(10 + header)};
    at += 46 + length;
  }
  return arrays;
}

double Value(const Array& array, size_t i) {
  const std::uint64_t bits = Little(array.data, 8 * i, 8);
  double value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

TEST(NpzWriterTest, ArraysComeBackBitForBit) {
  NpzWriter writer;
  writer.Add("a", {2, 3}, std::vector<double>{1.5, -0.0, 1e-310, 3.14, -2e300, 7});
  writer.Add("b", {4}, std::vector<std::int32_t>{-1, 0, 2147483647, 5});
  writer.Add("none", {0, 3}, std::vector<double>());
  std::string zip, error;
  ASSERT_TRUE(writer.Finish(&zip, &error)) << error;
  const auto arrays = ReadNpz(zip);
  ASSERT_EQ(arrays.size(), 3u);
  const Array& a = arrays.at("a.npy");
  EXPECT_THAT(a.header, HasSubstr("'descr': '<f8'"));
  EXPECT_THAT(a.header, HasSubstr("'shape': (2, 3)"));
  ASSERT_EQ(a.data.size(), 48u);
  EXPECT_EQ(Value(a, 2), 1e-310);
  EXPECT_EQ(Value(a, 4), -2e300);
  EXPECT_TRUE(std::signbit(Value(a, 1)));
  const Array& b = arrays.at("b.npy");
  EXPECT_THAT(b.header, HasSubstr("'descr': '<i4'"));
  EXPECT_THAT(b.header, HasSubstr("'shape': (4,)"));
  EXPECT_EQ(Little(b.data, 0, 4), 0xffffffffu);
  EXPECT_THAT(arrays.at("none.npy").header, HasSubstr("'shape': (0, 3)"));
}

class ExportsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string error;
    ASSERT_TRUE(ReadScene(DARBOUX_DATA_DIR "/cantilever_shear.yaml", &scene_, &error)) << error;
    scene_.steps = 2;
    scene_.surface.divisions = {6, 1};
    SolverOptions options;
    options.num_threads = 1;
    ASSERT_TRUE(Solve(scene_, options, &problem_, &summary_, &error)) << error;
    ASSERT_TRUE(summary_.IsConverged());
    ExportOptions exports;
    ASSERT_TRUE(ParseExports("npz,inp,csv", true, &exports, &error)) << error;
    std::vector<NamedFile> files;
    std::vector<std::string> remarks;
    ASSERT_TRUE(MakeFieldExports(*problem_, exports, ExportStatesOf(summary_), {}, &files, &error))
        << error;
    ASSERT_TRUE(MakeInpExport(*problem_, exports, &summary_, &files, &remarks, &error)) << error;
    for (const NamedFile& file : files) files_[file.name] = file.content;
  }

  Scene scene_;
  std::unique_ptr<ShellProblem> problem_;
  SolverSummary summary_;
  std::map<std::string, std::string> files_;
};

TEST_F(ExportsTest, TablesAndArraysHaveTheFieldsOfEveryStep) {
  const FieldTable table(*problem_);
  const size_t n = table.num_points();
  const auto arrays = ReadNpz(files_.at("fields.npz"));
  for (int step = 0; step < 2; ++step) {
    const std::vector<Field> fields = table.StateFields(summary_.steps[step].displacements);
    // The table: every number as written, in the order of its columns.
    std::istringstream lines(files_.at("fields_000" + std::to_string(step + 1) + ".csv"));
    std::string line, names;
    std::getline(lines, names);
    EXPECT_EQ(names.find("point,rest.x,rest.y,rest.z,displacement.x,displacement.y,displacement.z,"
                         "normal.x"),
              0u);
    EXPECT_THAT(names, HasSubstr(",von_mises_top,"));
    EXPECT_THAT(names, HasSubstr(",membrane_force.11,membrane_force.22,membrane_force.12,"));
    std::vector<const Field*> columns = {&table.points()};
    for (const Field& field : fields) columns.push_back(&field);
    for (const Field& field : table.rest_fields()) columns.push_back(&field);
    size_t row = 0;
    while (std::getline(lines, line)) {
      const char* at = line.c_str();
      char* next = nullptr;
      ASSERT_EQ(std::strtod(at, &next), static_cast<double>(row));
      for (const Field* field : columns) {
        for (size_t k = 0; k < field->width(); ++k) {
          ASSERT_EQ(*next, ',');
          const double value = std::strtod(next + 1, &next);
          ASSERT_EQ(value, field->values[row * field->width() + k]) << field->name << " " << row;
        }
      }
      ASSERT_EQ(*next, '\0');
      ++row;
    }
    EXPECT_EQ(row, n);
    for (const Field& field : fields) {
      const Array& array = arrays.at(field.name + ".npy");
      ASSERT_EQ(array.data.size(), 2 * 8 * field.values.size());
      for (size_t i = 0; i < field.values.size(); ++i) {
        ASSERT_EQ(Value(array, step * field.values.size() + i), field.values[i]) << field.name;
      }
    }
  }
  EXPECT_EQ(files_.at("fields.csv"), files_.at("fields_0002.csv"));
  EXPECT_EQ(Value(arrays.at("load_factor.npy"), 0), 0.5);
  EXPECT_EQ(Value(arrays.at("load_factor.npy"), 1), 1.0);
  EXPECT_EQ(arrays.at("triangles.npy").data.size(), 12 * table.mesh().triangles.size());
}

TEST_F(ExportsTest, NumPyReadsTheArrays) {
#ifdef DARBOUX_NUMPY_PYTHON
  const TemporaryFolder folder("exports");
  std::ofstream(folder.path() / "fields.npz", std::ios::binary) << files_.at("fields.npz");
  std::ofstream(folder.path() / "read.py")
      << "import numpy as np, zipfile\n"
         "assert zipfile.ZipFile('fields.npz').testzip() is None\n"
         "z = np.load('fields.npz')\n"
         "n = len(z['points'])\n"
         "assert z['points'].shape == (n, 3) and z['points'].dtype == np.float64\n"
         "assert z['displacement'].shape == (2, n, 3)\n"
         "assert z['triangles'].min() == 0 and z['triangles'].max() == n - 1\n"
         "assert np.allclose(np.linalg.norm(z['normal'], axis=2), 1)\n"
         "assert list(z['load_factor']) == [0.5, 1] and z['converged'].all()\n"
         "tip = z['points'][:, 0] == 10\n"
         "assert abs(z['displacement'][1, tip, 2] - 6.69989).max() < 0.067\n";
  const CommandOutcome outcome = RunCommand(folder.path(), "'" DARBOUX_NUMPY_PYTHON "' read.py");
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
#else
  GTEST_SKIP() << "no Python with NumPy was found at configure time";
#endif
}

// CalculiX reads 20 characters of a number and 132 of a line.
TEST_F(ExportsTest, LinesOfTheDeckAreNotTooLongForItsReaders) {
  std::istringstream lines(files_.at("shell.inp"));
  std::string line;
  while (std::getline(lines, line)) {
    ASSERT_LE(line.size(), 132u) << line;
    if (line[0] == '*') continue;
    std::istringstream fields(line);
    std::string field;
    while (std::getline(fields, field, ',')) {
      const size_t begin = std::min(field.find_first_not_of(' '), field.size());
      ASSERT_LE(field.size() - begin, 20u) << line;
    }
  }
}

TEST_F(ExportsTest, TheSameSceneGivesTheSameBytes) {
  ExportOptions exports;
  exports.inp = exports.npz = exports.csv = true;
  std::vector<NamedFile> files;
  std::vector<std::string> remarks;
  std::string error;
  ASSERT_TRUE(MakeFieldExports(*problem_, exports, ExportStatesOf(summary_), {}, &files, &error));
  ASSERT_TRUE(MakeInpExport(*problem_, exports, &summary_, &files, &remarks, &error));
  for (const NamedFile& file : files) EXPECT_EQ(file.content, files_.at(file.name)) << file.name;
}

TEST(ExportOptionsTest, UnknownAndRepeatedFormatsAreErrors) {
  std::string error;
  for (const char* list : {"xml", "csv,csv", "csv,", ",", "npz;csv"}) {
    ExportOptions exports;
    EXPECT_FALSE(ParseExports(list, true, &exports, &error)) << list;
    EXPECT_EQ(
        error,
        "found '" + std::string(list) + "'; allowed csv | npz | inp, joined by commas, each once");
  }
  ExportOptions exports;
  EXPECT_FALSE(ParseExports("inp", false, &exports, &error));
  EXPECT_TRUE(ParseExports("", true, &exports, &error));
  EXPECT_FALSE(exports.any());
  EXPECT_FALSE(ParseInpElement("S5", &exports, &error));
}

Scene Parse(const std::string& text) {
  Scene scene;
  std::string error;
  EXPECT_TRUE(ParseScene(text, "scene.yaml", &scene, &error)) << error;
  return scene;
}

struct Exported {
  std::string deck;
  std::vector<std::string> remarks;
};
Exported Export(const std::string& text, const std::string& element = "auto") {
  ExportOptions exports;
  exports.inp = true;
  std::vector<NamedFile> files;
  Exported result;
  std::string error;
  EXPECT_TRUE(ParseInpElement(element, &exports, &error));
  EXPECT_TRUE(ExportScene(Parse(text), exports, 1, &files, &result.remarks, &error)) << error;
  if (!files.empty()) result.deck = files[0].content;
  return result;
}

constexpr char kBall[] =
    "name: ball\nsurface: {kind: icosphere, radius: 20, frequency: 4}\n"
    "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.5}\n";

// What cannot be said in a deck is said in words, there and to the caller.
TEST(InpRemarksTest, NothingIsDroppedInSilence) {
  const Exported gas = Export(
      std::string(kBall) + "loads: [{kind: gas, gauge_pressure: 0.01, ambient_pressure: 0.1}]\n");
  std::string all;
  for (const std::string& remark : gas.remarks) all += remark + "\n";
  EXPECT_THAT(all, HasSubstr("gas: there is no keyword"));
  EXPECT_THAT(all, HasSubstr("poisson_ratio: 0.4995"));
  EXPECT_THAT(all, HasSubstr("no support holds the shell"));
  EXPECT_THAT(gas.deck, HasSubstr("** Otherwise than in the scene:\n** - "));
  EXPECT_THAT(gas.deck, HasSubstr("P1, 0.00"));
  const Exported finger = Export(std::string(kBall) +
                                 "fingers: [{name: f, shape: {kind: plane}, position: [0, 0, 25], "
                                 "direction: [0, 0, -1], motion: {travel: 1}, friction: 0.3}]\n");
  all.clear();
  for (const std::string& remark : finger.remarks) all += remark + "\n";
  EXPECT_THAT(all, HasSubstr("soft springs"));
  EXPECT_THAT(all, HasSubstr("contact by penalty"));
  EXPECT_THAT(all, HasSubstr("finger f: friction is a penalty"));
}

// Meshes refined locally have no hanging nodes in a deck: every edge has one or two elements.
TEST(InpMeshTest, EveryInnerEdgeHasTwoElements) {
  const Scene scene = Parse(
      "name: ball\nsurface: {kind: icosphere, radius: 20, frequency: 4, refine_near: "
      "[{near: [0, 0, 20], radius: 6, levels: 2}, {near: [20, 0, 0], radius: 1, levels: 1}]}\n"
      "shell: {thickness: 1, young_modulus: 1, poisson_ratio: 0.3}\n");
  std::string error;
  const auto problem = ShellProblem::Create(scene, ShellProblem::Options(), &error);
  ASSERT_NE(problem, nullptr) << error;
  for (const InpElement element : {InpElement::kS3, InpElement::kS6, InpElement::kC3D15}) {
    const InpMesh mesh(problem->surface(), element, 1.0);
    std::map<std::pair<int, int>, int> edges;
    double area = 0.0;
    for (const std::vector<int>& columns : mesh.elements()) {
      for (int k = 0; k < 3; ++k) ++edges[std::minmax(columns[k], columns[(k + 1) % 3])];
      const Eigen::Vector3d a = mesh.columns()[columns[0]].position;
      area += 0.5 * (mesh.columns()[columns[1]].position - a)
                        .cross(mesh.columns()[columns[2]].position - a)
                        .dot(mesh.columns()[columns[0]].normal);
    }
    EXPECT_GT(mesh.elements().size(), static_cast<size_t>(problem->surface().num_elements()));
    for (const auto& edge : edges) EXPECT_EQ(edge.second, 2);
    EXPECT_NEAR(area / problem->surface().area(), 1.0, 0.06);  // chords
    // Euler: a sphere.
    size_t corners = 0;
    for (const InpMesh::Column& column : mesh.columns()) corners += column.is_corner ? 1 : 0;
    EXPECT_EQ(corners + mesh.elements().size(), edges.size() + 2);
  }
}

}  // namespace
}  // namespace darboux
