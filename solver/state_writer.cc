#include "solver/state_writer.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "solver/base64.h"
#include "solver/fields.h"

namespace darboux {
namespace {

template <typename T>
void Append(const T& value, std::string* bytes) {
  char buffer[sizeof(T)];
  std::memcpy(buffer, &value, sizeof(T));
  bytes->append(buffer, sizeof(T));
}

// One DataArray element: attributes and the data with its length in front, in base64.
template <typename T>
std::string DataArray(const std::string& type,
                      const std::string& attributes,
                      const std::vector<T>& values) {
  std::string bytes;
  bytes.reserve(8 + values.size() * sizeof(T));
  Append<std::uint64_t>(values.size() * sizeof(T), &bytes);
  for (const T& value : values) Append(value, &bytes);
  return "<DataArray type=\"" + type + "\" " + attributes + " format=\"binary\">" + Base64(bytes) +
         "</DataArray>\n";
}

std::string ToXml(const Field& field) {
  std::string attributes =
      "Name=\"" + field.name + "\" NumberOfComponents=\"" + std::to_string(field.width()) + "\"";
  for (size_t i = 0; i < field.components.size(); ++i) {
    attributes += " ComponentName" + std::to_string(i) + "=\"" + field.components[i] + "\"";
  }
  return DataArray("Float64", attributes, field.values);
}

}  // namespace

bool IsLittleEndian() {
  const std::uint16_t one = 1;
  unsigned char first;
  std::memcpy(&first, &one, 1);
  return first == 1;
}

StateWriter::StateWriter(const ShellProblem& problem) : table_(problem) {
  std::vector<std::int32_t> connectivity, offsets;
  for (const std::array<int, 3>& triangle : table_.mesh().triangles) {
    connectivity.insert(connectivity.end(), triangle.begin(), triangle.end());
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
  }
  constexpr std::uint8_t kVtkTriangle = 5;
  const std::vector<std::uint8_t> types(table_.mesh().triangles.size(), kVtkTriangle);
  geometry_ = "<Points>\n" + ToXml(table_.points()) + "</Points>\n<Cells>\n" +
              DataArray("Int32", "Name=\"connectivity\"", connectivity) +
              DataArray("Int32", "Name=\"offsets\"", offsets) +
              DataArray("UInt8", "Name=\"types\"", types) + "</Cells>\n";
  for (const Field& field : table_.rest_fields()) rest_fields_ += ToXml(field);
}

std::string StateWriter::Vtu(const Eigen::Matrix3Xd& displacements,
                             const Eigen::Matrix3Xd& mode,
                             double time,
                             size_t* num_not_finite,
                             const std::vector<ExtraField>& extra) const {
  const size_t n = table_.num_points();
  std::string arrays;
  if (mode.size() > 0) {
    Field lowest_mode("lowest_mode", {"x", "y", "z"}, n);
    for (const FieldSite& site : table_.sites()) {
      const auto& vertices = table_.problem().surface().control_vertices(site.element);
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < vertices.size(); ++i) {
        moved += site.point.weights(kRowValue, i) * mode.col(vertices[i]);
      }
      lowest_mode.Add(moved);
    }
    arrays += ToXml(lowest_mode);
  }
  for (const ExtraField& field : extra) {
    Field array(field.name, {}, n);
    for (const double value : field.values) array.Add(value);
    arrays += ToXml(array);
  }
  for (const Field& field : table_.StateFields(displacements)) {
    *num_not_finite += field.num_not_finite;
    arrays += ToXml(field);
  }
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
         "byte_order=\"" +
         std::string(IsLittleEndian() ? "LittleEndian" : "BigEndian") +
         "\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n" +
         DataArray("Float64",
                   "Name=\"TimeValue\" NumberOfTuples=\"1\"",
                   std::vector<double>{std::isfinite(time) ? time : 0.0}) +
         "</FieldData>\n<Piece NumberOfPoints=\"" + std::to_string(n) + "\" NumberOfCells=\"" +
         std::to_string(table_.mesh().triangles.size()) + "\">\n" + geometry_ +
         "<PointData Vectors=\"displacement\" Normals=\"normal\">\n" + arrays + rest_fields_ +
         "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

std::string StateWriter::Ply(const Eigen::Matrix3Xd& displacements) const {
  std::string text = std::string("ply\nformat ") +
                     (IsLittleEndian() ? "binary_little_endian" : "binary_big_endian") +
                     " 1.0\ncomment deformed middle surface\nelement vertex " +
                     std::to_string(table_.num_points()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    text += std::string("property double ") + name + "\n";
  }
  text += "element face " + std::to_string(table_.mesh().triangles.size()) +
          "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const FieldSite& site : table_.sites()) {
    const ShellFields fields = EvaluateFields(table_.problem(), displacements, site);
    const Eigen::Vector3d x = fields.position + fields.displacement;
    for (int i = 0; i < 3; ++i) Append(std::isfinite(x[i]) ? x[i] : 0.0, &text);
    for (int i = 0; i < 3; ++i) Append(fields.normal[i], &text);
  }
  for (const std::array<int, 3>& triangle : table_.mesh().triangles) {
    Append<std::uint8_t>(3, &text);
    for (const int vertex : triangle) Append<std::int32_t>(vertex, &text);
  }
  return text;
}

std::string MakeVtu(const ShellProblem& problem,
                    const Eigen::Matrix3Xd& displacements,
                    const std::vector<ExtraField>& extra) {
  size_t ignored = 0;
  return StateWriter(problem).Vtu(displacements, Eigen::Matrix3Xd(), 1.0, &ignored, extra);
}

std::string MakeDeformedPly(const ShellProblem& problem, const Eigen::Matrix3Xd& displacements) {
  return StateWriter(problem).Ply(displacements);
}

}  // namespace darboux
