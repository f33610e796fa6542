#include "tools/python/convert.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "solver/yaml_reader.h"

namespace py = pybind11;

namespace darboux {
namespace {

using Json = nlohmann::ordered_json;

std::string ShapeOf(const py::array& array) {
  std::string text = "an array of shape (";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void Fail(const std::string& name,
                       const std::string& found,
                       const std::string& allowed) {
  throw InputError(name + ": " + Problem(found, allowed));
}

// (n, columns) of finite numbers.
template <typename T>
py::array_t<T, py::array::c_style | py::array::forcecast> TableOf(const py::handle& object,
                                                                  int columns,
                                                                  const std::string& name) {
  const std::string allowed = "an array of shape (n, " + std::to_string(columns) + ")";
  const py::array any = py::array::ensure(object);
  if (!any) {
    PyErr_Clear();
    Fail(name, py::str(py::type::handle_of(object).attr("__name__")), allowed);
  }
  const char kind = any.dtype().kind();
  const bool is_number = kind == 'i' || kind == 'u' || (kind == 'f' && std::is_floating_point_v<T>);
  if (!is_number) {
    Fail(name,
         "an array of type " + std::string(py::str(any.dtype())),
         allowed + (std::is_floating_point_v<T> ? " of numbers" : " of integers"));
  }
  if (any.ndim() != 2 || any.shape(1) != columns || any.shape(0) == 0) {
    Fail(name, ShapeOf(any), allowed);
  }
  auto table = py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(any);
  if (!table) throw py::error_already_set();
  return table;
}

template <typename T>
std::string RowProblem(const T* row, int columns) {
  for (int k = 0; k < columns; ++k) {
    if (std::isnan(row[k])) return "nan";
    if (!std::isfinite(row[k])) return FormatNumber(row[k]);
  }
  return "";
}

template <typename T>
py::array_t<T> Table(py::ssize_t rows, py::ssize_t columns) {
  return py::array_t<T>(std::vector<py::ssize_t>{rows, columns});
}

bool IsText(const std::string& key) {
  return key == "name" || key == "file" || key == "source" || key == "quantity" || key == "scene";
}

py::object ScalarToPython(const YAML::Node& node, bool is_text) {
  const std::string& text = node.Scalar();
  if (!is_text && node.Tag() != "!") {  // Not quoted.
    if (text == "true") return py::bool_(true);
    if (text == "false") return py::bool_(false);
    int integer = 0;
    if (ParseInteger(text, &integer)) return py::int_(integer);
    double number = 0.0;
    if (ParseNumber(text, &number) == NumberSyntax::kNumber) return py::float_(number);
  }
  return py::str(text);
}

// Anchors let a short text stand for more than memory holds.
constexpr int kMaxNodes = 2000000;
constexpr int kMaxDepth = 200;

py::object NodeToPython(const YAML::Node& node, bool is_text, int depth, int* count) {
  if (++*count > kMaxNodes || depth > kMaxDepth) Fail("scene", "too much text", "less of it");
  if (node.IsScalar()) return ScalarToPython(node, is_text);
  if (node.IsSequence()) {
    py::list list;
    for (const auto& item : node) list.append(NodeToPython(item, false, depth + 1, count));
    return list;
  }
  if (node.IsMap()) {
    py::dict dict;
    for (const auto& entry : node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
      dict[py::str(key)] = NodeToPython(entry.second, IsText(key), depth + 1, count);
    }
    return dict;
  }
  return py::none();
}

}  // namespace

py::object ToPython(const Json& json) {
  switch (json.type()) {
    case Json::value_t::object: {
      py::dict dict;
      for (const auto& item : json.items()) dict[py::str(item.key())] = ToPython(item.value());
      return dict;
    }
    case Json::value_t::array: {
      py::list list;
      for (const Json& item : json) list.append(ToPython(item));
      return list;
    }
    case Json::value_t::string: {
      // As the tools' files have it: bytes that are no UTF-8 are replaced.
      const std::string& text = json.get_ref<const std::string&>();
      PyObject* decoded =
          PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace");
      if (decoded == nullptr) throw py::error_already_set();
      return py::reinterpret_steal<py::object>(decoded);
    }
    case Json::value_t::boolean:
      return py::bool_(json.get<bool>());
    case Json::value_t::number_integer:
      return py::int_(json.get<std::int64_t>());
    case Json::value_t::number_unsigned:
      return py::int_(json.get<std::uint64_t>());
    case Json::value_t::number_float: {
      const double number = json.get<double>();
      if (!std::isfinite(number)) return py::none();  // As in the file.
      return py::float_(number);
    }
    default:
      return py::none();
  }
}

py::array_t<double> ToArray(const std::vector<Eigen::Vector3d>& points) {
  py::array_t<double> array = Table<double>(static_cast<py::ssize_t>(points.size()), 3);
  double* out = array.mutable_data();
  for (const Eigen::Vector3d& x : points) out = std::copy(x.data(), x.data() + 3, out);
  return array;
}

py::array_t<double> ToArray(const Eigen::Matrix3Xd& columns) {
  py::array_t<double> array = Table<double>(columns.cols(), 3);
  std::copy(columns.data(), columns.data() + columns.size(), array.mutable_data());
  return array;
}

py::array_t<double> ToArray(const std::vector<double>& values, int components) {
  const py::ssize_t rows = static_cast<py::ssize_t>(values.size()) / components;
  py::array_t<double> array =
      components == 1 ? py::array_t<double>(rows) : Table<double>(rows, components);
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

py::array_t<double> ToMatrix(const Eigen::MatrixXd& matrix) {
  py::array_t<double> array = Table<double>(matrix.rows(), matrix.cols());
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      array.mutable_data(), matrix.rows(), matrix.cols()) = matrix;
  return array;
}

py::array_t<int> ToArray(const std::vector<std::array<int, 3>>& triangles) {
  py::array_t<int> array = Table<int>(static_cast<py::ssize_t>(triangles.size()), 3);
  int* out = array.mutable_data();
  for (const std::array<int, 3>& t : triangles) out = std::copy(t.begin(), t.end(), out);
  return array;
}

py::array_t<bool> ToBools(const std::vector<char>& values) {
  py::array_t<bool> array(static_cast<py::ssize_t>(values.size()));
  bool* const out = array.mutable_data();
  for (std::size_t i = 0; i < values.size(); ++i) out[i] = values[i] != 0;
  return array;
}

py::array_t<double> ToArray(const RigidPose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation;
  return ToMatrix(matrix);
}

std::vector<Eigen::Vector3d> PointsOf(const py::handle& object,
                                      const std::string& name,
                                      bool may_be_nan) {
  const auto table = TableOf<double>(object, 3, name);
  std::vector<Eigen::Vector3d> points(static_cast<std::size_t>(table.shape(0)));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double* row = table.data() + 3 * i;
    const std::string problem = may_be_nan ? "" : RowProblem(row, 3);
    if (!problem.empty()) {
      Fail(name, problem + " in row " + std::to_string(i), "finite numbers");
    }
    points[i] = Eigen::Vector3d(row[0], row[1], row[2]);
  }
  return points;
}

std::vector<std::array<double, 2>> PairsOf(const py::handle& object, const std::string& name) {
  const auto table = TableOf<double>(object, 2, name);
  std::vector<std::array<double, 2>> pairs(static_cast<std::size_t>(table.shape(0)));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double* row = table.data() + 2 * i;
    const std::string problem = RowProblem(row, 2);
    if (!problem.empty()) {
      Fail(name, problem + " in row " + std::to_string(i), "finite numbers");
    }
    pairs[i] = {row[0], row[1]};
  }
  return pairs;
}

TriangleMesh MeshOf(const py::handle& vertices, const py::handle& faces, const std::string& name) {
  TriangleMesh mesh;
  mesh.vertices = PointsOf(vertices, name + ".vertices", true);  // The mesh doctor names these.
  const auto table = TableOf<std::int64_t>(faces, 3, name + ".faces");
  const auto num_vertices = static_cast<std::int64_t>(mesh.vertices.size());
  if (num_vertices > std::numeric_limits<int>::max()) {
    Fail(name + ".vertices", std::to_string(num_vertices) + " rows", "fewer");
  }
  mesh.triangles.resize(static_cast<std::size_t>(table.shape(0)));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int64_t v = table.data()[3 * i + k];
      if (v < 0 || v >= num_vertices) {
        Fail(name + ".faces",
             std::to_string(v) + " in row " + std::to_string(i),
             "rows of vertices, 0 to " + std::to_string(num_vertices - 1));
      }
      mesh.triangles[i][k] = static_cast<int>(v);
    }
  }
  return mesh;
}

NamedData NamedDataOf(const py::dict& data) {
  NamedData named;
  if (data.contains("meshes")) {
    for (const auto& [key, value] : data["meshes"].cast<py::dict>()) {
      const std::string name = py::str(key);
      const auto parts = value.cast<py::tuple>();
      named.meshes[name] = MeshOf(parts[0], parts[1], name);
    }
  }
  if (data.contains("clouds")) {
    for (const auto& [key, value] : data["clouds"].cast<py::dict>()) {
      const std::string name = py::str(key);
      const auto parts = value.cast<py::tuple>();
      PointCloud& cloud = named.clouds[name];
      cloud.points = PointsOf(parts[0], name);
      if (parts[1].is_none()) continue;
      cloud.displacements = PointsOf(parts[1], name + ".displacements");
      if (cloud.displacements.size() != cloud.points.size()) {
        Fail(name + ".displacements",
             std::to_string(cloud.displacements.size()) + " rows",
             "as many as points, " + std::to_string(cloud.points.size()));
      }
    }
  }
  return named;
}

py::object YamlToPython(const std::string& text) {
  int count = 0;
  try {
    return NodeToPython(YAML::Load(text), false, 0, &count);
  } catch (const YAML::Exception& exception) {
    throw InputError("scene: " + Problem("a YAML mistake (" + exception.msg + ")", "valid YAML"));
  }
}

}  // namespace darboux
