// Reading scenes and solving them.

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>

#include "solver/accuracy.h"
#include "solver/scene_reader.h"
#include "solver/shell_solver.h"
#include "tools/python/convert.h"
#include "tools/python/handle.h"
#include "tools/python/job.h"
#include "tools/python/module.h"
#include "tools/python/solver_options.h"

namespace py = pybind11;

namespace darboux {
namespace {

std::shared_ptr<SceneHandle> ReadSceneFile(const std::string& file, bool repair) {
  ReadOptions options;
  options.repair = repair;
  auto handle = std::make_shared<SceneHandle>();
  std::string error;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    ok = ReadScene(file, &handle->scene, &error, options);
  }
  if (!ok) throw MakeInputError(error);
  return handle;
}

std::shared_ptr<SceneHandle> ReadSceneText(const std::string& text,
                                           const std::string& label,
                                           const std::string& folder,
                                           bool repair,
                                           const py::dict& named) {
  const NamedData data = NamedDataOf(named);
  ReadOptions options;
  options.repair = repair;
  options.data = &data;
  auto handle = std::make_shared<SceneHandle>();
  std::string error;
  bool ok = false;
  {
    const py::gil_scoped_release release;
    ok = ParseSceneIn(folder, text, label, &handle->scene, &error, options);
  }
  if (!ok) throw MakeInputError(error);
  return handle;
}

void ReportLevels(const Progress& progress, AccuracyOptions* options) {
  options->on_level = [progress](const AccuracyLevel& level) {
    progress.Post([level] {
      return py::dict(py::arg("kind") = "level",
                      py::arg("divisions") = level.divisions,
                      py::arg("dof") = level.dof,
                      py::arg("theory") = ToString(level.theory),
                      py::arg("estimate") = level.estimate,
                      py::arg("seconds") = level.seconds);
    });
  };
}

std::shared_ptr<Solution> SolveHandle(const std::shared_ptr<SceneHandle>& handle,
                                      const py::dict& arguments,
                                      const py::object& progress,
                                      const py::object& stop,
                                      const std::shared_ptr<Solution>& start) {
  // All that the thread uses belongs to it: it may be left to itself.
  struct Task {
    Scene scene;
    SolverOptions options;
    AccuracyOptions accuracy_options;
    std::shared_ptr<Solution> solution = std::make_shared<Solution>();
    bool posed = false;
    std::string error;
  };
  const auto task = std::make_shared<Task>();
  task->scene = handle->scene;
  task->options = SolverOptionsOf(arguments);
  Override(arguments, &task->scene);
  if (start != nullptr) {
    const LoadStep& state = start->summary.steps[start->StepIndex(-1)];
    if (!state.displacements.allFinite()) {
      throw InputError("start: found a state that is not finite; allowed a finite one");
    }
    task->options.initial_displacements = state.displacements;
    if (start->problem->grasp() != nullptr) {
      task->options.initial_contact = start->problem->grasp()->state().multipliers;
    }
  }
  const auto work = [task, callback = &progress, reports = !progress.is_none()](Job* job) {
    task->options.stop = job->stop();
    if (reports) {
      const Progress events(callback, job);
      ReportProgress(events, &task->options);
      ReportLevels(events, &task->accuracy_options);
    }
    std::unique_ptr<ShellProblem> problem;
    Solution& solution = *task->solution;
    if (task->scene.model.accuracy) {
      task->posed = SolveToAccuracy(task->scene,
                                    task->options,
                                    task->accuracy_options,
                                    &problem,
                                    &solution.summary,
                                    &solution.accuracy.emplace(),
                                    &task->error);
    } else {
      task->posed = Solve(task->scene, task->options, &problem, &solution.summary, &task->error);
    }
    solution.problem = std::move(problem);
  };
  const std::shared_ptr<Solution> solution = RunToEnd<Solution>(
      task->solution, work, stop, [task](const Solution&) { return task->posed; });
  if (!task->posed) {
    const std::string option = "initial_displacements";
    if (task->error.compare(0, option.size(), option) == 0) {
      task->error = "start: found a result on another mesh: " + task->error;
    }
    throw MakeInputError(task->error);
  }
  return solution;
}

}  // namespace

void BindScene(py::module_* module) {
  py::class_<SceneHandle, std::shared_ptr<SceneHandle>>(*module, "SceneHandle")
      .def_property_readonly("name", [](const SceneHandle& self) { return self.scene.name; })
      .def_property_readonly("mended",
                             [](const SceneHandle& self) { return self.scene.surface.mended; })
      .def_property_readonly("has_causes", [](const SceneHandle& self) {
        return !self.scene.fingers.empty() || !self.scene.loads.empty();
      });
  module->def("read_scene", &ReadSceneFile, py::arg("file"), py::arg("repair"));
  module->def("parse_scene",
              &ReadSceneText,
              py::arg("text"),
              py::arg("label"),
              py::arg("folder"),
              py::arg("repair"),
              py::arg("data"));
  module->def("yaml_to_python", &YamlToPython, py::arg("text"));
  module->def("solve",
              &SolveHandle,
              py::arg("scene"),
              py::arg("options"),
              py::arg("progress"),
              py::arg("stop"),
              py::arg("start").none(true));
}

}  // namespace darboux
