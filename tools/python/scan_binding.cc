// Simulated scans of a solved scene.

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "geometry/point_cloud.h"
#include "geometry/scan_simulator.h"
#include "geometry/text_file.h"
#include "solver/scanned_state.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/module.h"
#include "tools/python/solver_options.h"

namespace py = pybind11;

namespace darboux {
namespace {

std::string Choice(const py::dict& arguments,
                   const char* name,
                   const char* allowed,
                   const std::string& first,
                   const std::string& second) {
  std::string value = first;
  Get(arguments, name, allowed, &value);
  if (value == first || value == second) return value;
  throw InputError(std::string(name) + ": found '" + value + "'; allowed " + allowed);
}

// All but the viewpoints.
ScanOptions OptionsOf(const py::dict& arguments) {
  ScanOptions options;
  Get(arguments, "points", "an integer, 1 to 1e7", &options.num_points);
  Get(arguments, "seed", "an integer >= 0", &options.seed);
  Get(arguments, "noise", "a length >= 0", &options.noise);
  Get(arguments, "bias", "a length >= 0", &options.bias);
  Get(arguments, "bias_length", "a length >= 0", &options.bias_length);
  options.bias_along_ray =
      Choice(arguments, "bias_along", "normal | ray", "normal", "ray") == "ray";
  Get(arguments, "outliers", "a number in [0, 1]", &options.outliers);
  Get(arguments, "spike_share", "a number in [0, 1]", &options.spike_share);
  Get(arguments, "spike_size", "a number >= 0", &options.spike_size);
  Get(arguments, "outlier_box", "a number >= 1", &options.outlier_box);
  options.moves = Choice(arguments, "motion", "random | none", "random", "none") == "random";
  Get(arguments, "max_angle", "degrees, 0 to 180", &options.max_angle_deg);
  Get(arguments, "max_translation", "a number >= 0", &options.max_translation);
  Get(arguments, "grazing", "degrees, above 0, to 90", &options.grazing_deg);
  return options;
}

py::dict SimulateScanOf(const std::shared_ptr<Solution>& solution,
                        int step,
                        const py::dict& arguments) {
  const LoadStep& state = solution->summary.steps[solution->StepIndex(step)];
  ScanOptions options = OptionsOf(arguments);
  const ScanSampling sampling =
      Choice(arguments, "sampling", "area | vertices", "area", "vertices") == "area"
          ? ScanSampling::kArea
          : ScanSampling::kVertices;
  int views = 8;
  double distance = 5.0;
  constexpr char kViews[] = "an integer, 0 to 1000, or viewpoints as an array of shape (n, 3)";
  const bool given = arguments.contains("views") && !py::isinstance<py::int_>(arguments["views"]) &&
                     !arguments["views"].is_none();
  if (given) {
    options.viewpoints = PointsOf(arguments["views"], "views");
  } else {
    Get(arguments, "views", kViews, &views);
    if (views < 0 || views > 1000) {
      throw InputError("views: found " + std::to_string(views) + "; allowed " + kViews);
    }
  }
  Get(arguments, "view_distance", "a factor > 0", &distance);
  if (!(distance > 0.0)) throw InputError("view_distance: found no factor > 0; allowed one");
  std::string error;
  Scan scan;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    const ScanSurface face = ScannedFace(*solution->problem, state, sampling);
    std::vector<Occluder> fingers;
    ok = FingersOf(solution->problem->scene(), state, &fingers, &error);
    if (ok) {
      if (!given) options.viewpoints = ViewpointsAround(face, views, distance);
      ok = SimulateScan(face, fingers, options, &scan, &error);
    }
  }
  if (!ok) throw MakeInputError(error);
  std::vector<Eigen::Vector3d> face;
  std::vector<double> noise, bias;
  const auto n = static_cast<py::ssize_t>(scan.truth.size());
  py::array_t<int> outlier(n), view(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const ScanTruth& truth = scan.truth[static_cast<std::size_t>(i)];
    face.push_back(truth.face.position);
    noise.push_back(truth.noise);
    bias.push_back(truth.bias);
    outlier.mutable_at(i) = static_cast<int>(truth.outlier);
    view.mutable_at(i) = truth.view;
  }
  return py::dict(py::arg("points") = ToArray(scan.cloud.points),
                  py::arg("normals") = ToArray(scan.cloud.normals),
                  py::arg("pose") = ToArray(scan.model_from_scan),
                  py::arg("true_points") = ToArray(face),
                  py::arg("outlier") = outlier,
                  py::arg("view") = view,
                  py::arg("noise") = ToArray(noise),
                  py::arg("bias") = ToArray(bias),
                  py::arg("viewpoints") = ToArray(options.viewpoints),
                  py::arg("num_tried") = scan.num_tried);
}

py::dict ReadPoints(const std::string& file) {
  PointCloud cloud;
  std::string error;
  if (!ReadPointCloud(file, &cloud, &error)) throw InputError(error);
  const auto or_none = [](const std::vector<Eigen::Vector3d>& vectors) -> py::object {
    if (vectors.empty()) return py::none();
    return ToArray(vectors);
  };
  return py::dict(py::arg("points") = ToArray(cloud.points),
                  py::arg("normals") = or_none(cloud.normals),
                  py::arg("displacements") = or_none(cloud.displacements));
}

void WritePoints(const std::string& file, const py::object& points, const py::object& normals) {
  PointCloud cloud;
  cloud.points = PointsOf(points, "points");
  if (!normals.is_none()) cloud.normals = PointsOf(normals, "normals");
  std::string error;
  if (WritePointCloud(file, cloud, {}, &error)) return;
  PyErr_SetString(PyExc_OSError, error.c_str());
  throw py::error_already_set();
}

}  // namespace

void BindScan(py::module_* module) {
  module->def(
      "simulate_scan", &SimulateScanOf, py::arg("solution"), py::arg("step"), py::arg("options"));
  module->def("read_points", &ReadPoints, py::arg("file"));
  module->def("write_points", &WritePoints, py::arg("file"), py::arg("points"), py::arg("normals"));
}

}  // namespace darboux
