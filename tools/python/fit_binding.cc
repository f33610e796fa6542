// Registration of scans, and fits of the deformation to them.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <vector>

#include "solver/fields.h"
#include "solver/results.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/job.h"
#include "tools/python/module.h"
#include "tools/python/report.h"
#include "tools/python/solver_options.h"
#include "tools/scan_fit.h"

namespace py = pybind11;

namespace darboux {
namespace {

// A scan and what was found of it.
struct FitHandle {
  std::vector<Eigen::Vector3d> scan;
  ScanFit fit;
};

ScanFitOptions OptionsOf(const py::dict& arguments) {
  ScanFitOptions options;
  options.solver = SolverOptionsOf(arguments);
  Get(arguments, "mode", "fit | register", &options.mode);
  Get(arguments, "fingers", "scene | none", &options.fingers);
  Get(arguments, "against", "deformed | rest", &options.against);
  Get(arguments, "method", "robust | undeformed_first", &options.method);
  Get(arguments, "undeformed_part", "0 < part <= 1", &options.undeformed_part);
  Get(arguments, "face", "outer | inner | middle", &options.face);
  Get(arguments, "noise", "a length >= 0", &options.noise);
  Get(arguments, "weight", "a number >= 0", &options.weight);
  Get(arguments, "seed", "an integer >= 0", &options.seed);
  std::string error;
  if (!options.IsValid(&error)) throw InputError(error);
  return options;
}

std::shared_ptr<FitHandle> Fit(const std::shared_ptr<SceneHandle>& scene,
                               const py::object& points,
                               const std::string& name,
                               const py::dict& arguments,
                               const py::object& progress,
                               const py::object& stop) {
  struct FitTask : Task<FitHandle> {
    Scene scene;
    ScanFitOptions options;
  };
  const auto task = std::make_shared<FitTask>();
  task->scene = scene->scene;
  task->options = OptionsOf(arguments);
  Override(arguments, &task->scene);
  task->result->scan = PointsOf(points, "scan");
  const auto work = [task, name, callback = &progress, reports = !progress.is_none()](Job* job) {
    task->options.solver.stop = job->stop();
    if (reports) {
      const Progress events(callback, job);
      ReportProgress(events, &task->options.solver);
      task->options.on_iteration = [events](const ShapeFitIteration& iteration) {
        events.Post([iteration] {
          return py::dict(py::arg("kind") = iteration.is_end ? "weight" : "fit_iteration",
                          py::arg("trial") = iteration.trial,
                          py::arg("weight") = iteration.weight,
                          py::arg("iteration") = iteration.iteration,
                          py::arg("misfit") = iteration.misfit,
                          py::arg("seconds") = iteration.seconds);
        });
      };
    }
    task->posed = FitScan(
        task->scene, task->result->scan, name, task->options, &task->result->fit, &task->error);
  };
  return RunTask(task, work, stop);
}

// The fitted shape at the points where fields are sampled.
py::dict Shape(const FitHandle& self) {
  const ShellProblem& shell = *self.fit.shell;
  const OutputMesh mesh = MakeOutputMesh(shell.surface());
  std::vector<Eigen::Vector3d> points, displacement, normal;
  {
    const py::gil_scoped_release release;
    for (const ElementPoint& at : mesh.points) {
      const ShellFields fields =
          EvaluateFields(shell, self.fit.displacements, MakeFieldSite(shell.surface(), at));
      points.push_back(fields.position);
      displacement.push_back(fields.displacement);
      normal.push_back(fields.normal);
    }
  }
  return py::dict(py::arg("points") = ToArray(points),
                  py::arg("triangles") = ToArray(mesh.triangles),
                  py::arg("displacement") = ToArray(displacement),
                  py::arg("normal") = ToArray(normal));
}

py::object Feet(const FitHandle& self) {
  std::vector<Eigen::Vector3d> feet;
  for (const ShellFace::Foot& foot : self.fit.feet) feet.push_back(foot.position);
  return ToArray(feet);
}

std::vector<std::string> Write(const FitHandle& self, const std::string& folder, bool report) {
  if (report) RequireReportPage();
  std::string error;
  std::vector<std::string> names;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    std::vector<NamedFile> files = ScanFitFiles(self.fit, self.scan);
    if (report) files.push_back(ReportFile(MakeFitReport(self.fit, self.scan)));
    for (const NamedFile& file : files) names.push_back(file.name);
    ok = WriteFiles(folder, files, &error);
  }
  if (ok) return names;
  PyErr_SetString(PyExc_OSError, error.c_str());
  throw py::error_already_set();
}

}  // namespace

void BindFit(py::module_* module) {
  py::class_<FitHandle, std::shared_ptr<FitHandle>>(*module, "FitHandle")
      .def_property_readonly("converged", [](const FitHandle& self) { return self.fit.converged; })
      .def_property_readonly("verdict", [](const FitHandle& self) { return self.fit.verdict; })
      .def_property_readonly("report", [](const FitHandle& self) { return self.fit.report; })
      .def_property_readonly("matched",
                             [](const FitHandle& self) { return !self.fit.distances.empty(); })
      .def_property_readonly("pose", [](const FitHandle& self) { return ToArray(self.fit.pose); })
      .def("summary", [](const FitHandle& self) { return ToPython(self.fit.json); })
      .def("distances", [](const FitHandle& self) { return ToArray(self.fit.distances); })
      .def("inliers", [](const FitHandle& self) { return ToBools(self.fit.counts); })
      .def("feet", &Feet)
      .def("shape", &Shape)
      .def("write", &Write, py::arg("folder"), py::arg("report"));
  module->def("fit",
              &Fit,
              py::arg("scene"),
              py::arg("points"),
              py::arg("name"),
              py::arg("options"),
              py::arg("progress"),
              py::arg("stop"));
}

}  // namespace darboux
