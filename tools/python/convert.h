#ifndef DARBOUX_TOOLS_PYTHON_CONVERT_H_
#define DARBOUX_TOOLS_PYTHON_CONVERT_H_

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/rigid_pose.h"
#include "geometry/triangle_mesh.h"
#include "solver/named_data.h"

namespace darboux {

// Python's objects from ours and back. Arrays that come out are copies which own their memory, in C
// order, float64 or int32; arrays that go in may be of any layout and of any type that numpy
// converts to these.

// darboux.InputError: what a tool ends with status 2 for.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

pybind11::object ToPython(const nlohmann::ordered_json& json);

// (n, 3) of points or of the columns of a matrix; (n,) or (n, k) of n * k numbers.
pybind11::array_t<double> ToArray(const std::vector<Eigen::Vector3d>& points);
pybind11::array_t<double> ToArray(const Eigen::Matrix3Xd& columns);
pybind11::array_t<double> ToArray(const std::vector<double>& values, int components = 1);
pybind11::array_t<double> ToMatrix(const Eigen::MatrixXd& matrix);
pybind11::array_t<int> ToArray(const std::vector<std::array<int, 3>>& triangles);
pybind11::array_t<bool> ToBools(const std::vector<char>& values);
// (4, 4), homogeneous.
pybind11::array_t<double> ToArray(const RigidPose& pose);

// InputError "NAME: found ...; allowed an array of shape (n, 3)" where it is no such thing; numbers
// that are not finite are an error too, but for `may_be_nan`.
std::vector<Eigen::Vector3d> PointsOf(const pybind11::handle& array,
                                      const std::string& name,
                                      bool may_be_nan = false);
std::vector<std::array<double, 2>> PairsOf(const pybind11::handle& array, const std::string& name);
TriangleMesh MeshOf(const pybind11::handle& vertices,
                    const pybind11::handle& faces,
                    const std::string& name);

// {"meshes": {name: (vertices, faces)}, "clouds": {name: (points, displacements or None)}}
NamedData NamedDataOf(const pybind11::dict& data);

// A YAML text as Python's dicts, lists, numbers, booleans and texts, as the reader of scenes would
// read them; what stands under name, file, source and quantity is always a text. To be called with
// what a reader has accepted; InputError otherwise.
pybind11::object YamlToPython(const std::string& text);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_CONVERT_H_
