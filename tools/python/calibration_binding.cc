// Material parameters from measured grasps.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "solver/calibration.h"
#include "solver/calibration_reader.h"
#include "solver/calibration_report.h"
#include "solver/calibration_results.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/job.h"
#include "tools/python/module.h"
#include "tools/python/report.h"
#include "tools/python/solver_options.h"

namespace py = pybind11;

namespace darboux {
namespace {

struct CalibrationHandle {
  CalibrationSpec spec;
  CalibrationSummary summary;
  std::vector<std::unique_ptr<StateModel>> models;  // final states, one per grasp
};

CalibrationSpec ReadSpec(const py::object& file,
                         const std::string& text,
                         const std::string& folder,
                         const py::dict& named) {
  NamedData data = NamedDataOf(named);
  if (named.contains("scenes")) {
    for (const auto& [key, value] : named["scenes"].cast<py::dict>()) {
      data.scenes[py::str(key)] = value.cast<std::shared_ptr<SceneHandle>>()->scene;
    }
  }
  CalibrationSpec spec;
  std::string error;
  bool ok = false;
  const std::string name = file.is_none() ? "" : file.cast<std::string>();
  {
    const py::gil_scoped_release release;
    ok = name.empty() ? ParseCalibration(text, kCalibrationLabel, folder, &spec, &error, &data)
                      : ReadCalibration(name, &spec, &error);
  }
  if (!ok) throw MakeInputError(error);
  return spec;
}

std::shared_ptr<CalibrationHandle> CalibrateSpec(const py::object& file,
                                                 const std::string& text,
                                                 const std::string& folder,
                                                 const py::dict& named,
                                                 const py::dict& arguments,
                                                 const py::object& progress,
                                                 const py::object& stop) {
  struct CalibrationTask : Task<CalibrationHandle> {
    CalibrationOptions options;
  };
  const auto task = std::make_shared<CalibrationTask>();
  task->options.solver = SolverOptionsOf(arguments);
  CalibrationSpec& spec = task->result->spec;
  spec = ReadSpec(file, text, folder, named);
  int bootstrap = -1;
  if (Get(arguments, "bootstrap", "an integer >= 0", &bootstrap)) {
    if (bootstrap < 0)
      throw InputError("bootstrap: found " + std::to_string(bootstrap) +
                       "; allowed an integer >= 0");
    spec.bootstrap = bootstrap;
  }
  for (CalibrationSpec::Grasp& grasp : spec.grasps) Override(arguments, &grasp.scene);
  if (arguments.contains("theory") && !arguments["theory"].is_none()) {
    spec.theory = Theory::kAuto;  // Now that of the scenes.
  }
  const auto work = [task, callback = &progress, reports = !progress.is_none()](Job* job) {
    task->options.solver.stop = job->stop();
    if (reports) {
      const Progress events(callback, job);
      task->options.on_progress = [events](const std::string& line) {
        events.Post([line] { return py::dict(py::arg("kind") = "line", py::arg("text") = line); });
      };
      task->options.on_iteration = [events](const CalibrationIteration& iteration) {
        events.Post([iteration] {
          py::dict parameters;
          for (const auto& [name, value] : iteration.parameters) parameters[name.c_str()] = value;
          return py::dict(py::arg("kind") = "calibration_iteration",
                          py::arg("iteration") = iteration.iteration,
                          py::arg("cost") = iteration.cost,
                          py::arg("parameters") = parameters,
                          py::arg("seconds") = iteration.seconds,
                          py::arg("seconds_left") = iteration.seconds_left,
                          py::arg("text") = iteration.text);
        });
      };
    }
    CalibrationHandle& result = *task->result;
    task->posed =
        Calibrate(result.spec, task->options, &result.summary, &result.models, &task->error);
    if (!task->posed) return;
    for (const std::unique_ptr<StateModel>& model : result.models) {
      std::string trouble;
      if (!model->Settle(&trouble)) result.summary.notes.push_back(trouble);
    }
  };
  return RunTask(task, work, stop);
}

// Of one grasp, as a result of its own. It keeps all of them alive.
std::shared_ptr<Solution> StateOf(const std::shared_ptr<CalibrationHandle>& self, std::size_t g) {
  if (g >= self->models.size()) throw py::index_error("no such grasp");
  const StateModel& model = *self->models[g];
  auto solution = std::make_shared<Solution>();
  solution->problem = std::shared_ptr<const ShellProblem>(self, &model.problem());
  solution->summary = model.summary();
  return solution;
}

void Write(const CalibrationHandle& self, const std::string& folder, bool report) {
  if (report) RequireReportPage();
  MoreFiles more;
  if (report) {
    more = [&self](const nlohmann::ordered_json& json) {
      return std::vector<NamedFile>{ReportFile(
          MakeCalibrationReport("darboux_calibrate", self.spec, self.summary, self.models, json))};
    };
  }
  std::string error;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    ok = WriteCalibration(
        folder, self.spec, self.summary, self.models, ExportOptions(), &error, more);
  }
  if (ok) return;
  PyErr_SetString(PyExc_OSError, error.c_str());
  throw py::error_already_set();
}

}  // namespace

void BindCalibration(py::module_* module) {
  py::class_<CalibrationHandle, std::shared_ptr<CalibrationHandle>>(*module, "CalibrationHandle")
      .def_property_readonly(
          "converged", [](const CalibrationHandle& self) { return self.summary.IsConverged(); })
      .def_property_readonly("message",
                             [](const CalibrationHandle& self) { return self.summary.message; })
      .def_property_readonly(
          "report", [](const CalibrationHandle& self) { return self.summary.FullReport(); })
      .def_property_readonly("num_states",
                             [](const CalibrationHandle& self) { return self.models.size(); })
      .def("state", &StateOf, py::arg("grasp"))
      .def("summary",
           [](const CalibrationHandle& self) {
             return ToPython(MakeCalibrationJson(self.spec, self.summary));
           })
      .def("write", &Write, py::arg("folder"), py::arg("report"));
  module->def("calibrate",
              &CalibrateSpec,
              py::arg("file"),
              py::arg("text"),
              py::arg("folder"),
              py::arg("data"),
              py::arg("options"),
              py::arg("progress"),
              py::arg("stop"));
}

}  // namespace darboux
