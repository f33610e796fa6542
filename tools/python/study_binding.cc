// What accuracy costs.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "solver/accuracy_results.h"
#include "solver/accuracy_study.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/job.h"
#include "tools/python/module.h"
#include "tools/python/solver_options.h"

namespace py = pybind11;

namespace darboux {
namespace {

struct StudyHandle {
  Study study;
};

void RequireRange(const char* name, bool holds, const std::string& found, const char* allowed) {
  if (!holds) throw InputError(std::string(name) + ": found " + found + "; allowed " + allowed);
}

StudyOptions OptionsOf(const py::dict& arguments) {
  StudyOptions options;
  options.solver = SolverOptionsOf(arguments);
  // A child process of a Python with threads may inherit a lock that nobody will ever open.
  options.runner = RunHere;
  std::string text, error;
  if (Get(arguments, "sweep", "names joined by commas", &text) && !text.empty() &&
      !ParseStudyAxes(text, &options.plan.axes, &error)) {
    throw InputError("sweep: " + error);
  }
  Get(arguments, "product", "True | False", &options.plan.product);
  constexpr char kLevels[] = "an integer from 1 to 12, or 0";
  Get(arguments, "levels", kLevels, &options.plan.levels);
  RequireRange("levels",
               options.plan.levels >= 0 && options.plan.levels <= 12,
               std::to_string(options.plan.levels),
               kLevels);
  constexpr char kDof[] = "a number >= 1";
  Get(arguments, "max_dof", kDof, &options.max_dof);
  RequireRange("max_dof", options.max_dof >= 1.0, std::to_string(options.max_dof), kDof);
  constexpr char kRepeats[] = "an integer from 1 to 1000";
  Get(arguments, "repeats", kRepeats, &options.repeats);
  RequireRange("repeats",
               options.repeats >= 1 && options.repeats <= 1000,
               std::to_string(options.repeats),
               kRepeats);
  std::string clock = "wall", reference = "auto";
  Get(arguments, "clock", "wall | cpu", &clock);
  RequireRange("clock", clock == "wall" || clock == "cpu", "'" + clock + "'", "wall | cpu");
  options.count_cpu = clock == "cpu";
  Get(arguments, "reference", "auto | richardson", &reference);
  RequireRange("reference",
               reference == "auto" || reference == "richardson",
               "'" + reference + "'",
               "auto | richardson");
  options.richardson = reference == "richardson";
  options.plan.backend = options.solver.backend;
  return options;
}

std::shared_ptr<StudyHandle> RunStudyOf(const std::shared_ptr<SceneHandle>& scene,
                                        const py::dict& arguments,
                                        const py::object& progress,
                                        const py::object& stop) {
  struct StudyTask : Task<StudyHandle> {
    Scene scene;
    StudyOptions options;
  };
  const auto task = std::make_shared<StudyTask>();
  task->scene = scene->scene;
  task->options = OptionsOf(arguments);
  Override(arguments, &task->scene);
  double target = task->scene.model.accuracy.value_or(0.0);
  constexpr char kTarget[] = "a number in (0, 1)";
  if (Get(arguments, "target", kTarget, &target)) {
    RequireRange("target", target > 0.0 && target < 1.0, std::to_string(target), kTarget);
  }
  std::vector<double>& targets = task->options.targets;
  if (target > 0.0 && std::find(targets.begin(), targets.end(), target) == targets.end()) {
    targets.push_back(target);
    std::sort(targets.rbegin(), targets.rend());
  }
  const auto work = [task, callback = &progress, reports = !progress.is_none()](Job* job) {
    task->options.solver.stop = job->stop();
    if (reports) {
      const Progress events(callback, job);
      task->options.on_run = [events](
                                 const StudyRun& run, int done, int planned, double seconds_left) {
        events.Post([text = RunLine(run), done, planned, seconds_left] {
          return py::dict(py::arg("kind") = "run",
                          py::arg("text") = text,
                          py::arg("done") = done,
                          py::arg("planned") = planned,
                          py::arg("seconds_left") = seconds_left);
        });
      };
    }
    task->posed = RunStudy(task->scene, task->options, &task->result->study, &task->error);
  };
  return RunTask(task, work, stop);
}

}  // namespace

void BindStudy(py::module_* module) {
  py::class_<StudyHandle, std::shared_ptr<StudyHandle>>(*module, "StudyHandle")
      .def_property_readonly("established",
                             [](const StudyHandle& self) { return self.study.established; })
      .def_property_readonly("report",
                             [](const StudyHandle& self) { return StudyReport(self.study); })
      .def("summary",
           [](const StudyHandle& self) { return ToPython(MakeAccuracyJson(self.study)); })
      .def(
          "write",
          [](const StudyHandle& self, const std::string& folder) {
            std::string error;
            if (WriteStudy(folder, self.study, &error)) return;
            PyErr_SetString(PyExc_OSError, error.c_str());
            throw py::error_already_set();
          },
          py::arg("folder"));
  module->def("accuracy_study",
              &RunStudyOf,
              py::arg("scene"),
              py::arg("options"),
              py::arg("progress"),
              py::arg("stop"));
}

}  // namespace darboux
