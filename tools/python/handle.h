#ifndef DARBOUX_TOOLS_PYTHON_HANDLE_H_
#define DARBOUX_TOOLS_PYTHON_HANDLE_H_

#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "solver/accuracy.h"
#include "solver/fields.h"
#include "solver/scene.h"
#include "solver/shell_problem.h"
#include "solver/shell_solver.h"
#include "tools/python/job.h"
#include "tools/python/module.h"

namespace darboux {

// A scene that has been read and checked.
struct SceneHandle {
  Scene scene;
};

// A solved scene, which nothing changes any more: may be used from several threads.
struct Solution {
  std::shared_ptr<const ShellProblem> problem;
  SolverSummary summary;
  std::optional<AccuracyReport> accuracy;

  const AccuracyReport* accuracy_or_null() const { return accuracy ? &*accuracy : nullptr; }
  // Index of a load step, counted from the end where it is negative, as Python does; IndexError.
  std::size_t StepIndex(int step) const;

  // Where fields are sampled: made at the first call.
  const OutputMesh& mesh() const;
  const std::vector<FieldSite>& sites() const;

 private:
  void MakeSites() const;
  mutable std::once_flag made_;
  mutable OutputMesh mesh_;
  mutable std::vector<FieldSite> sites_;
};

// Has `work` done as a Job and gives what it makes. Where Python interrupts it, what there is of
// the result by then is attached to the exception as `solution`.
template <typename T>
std::shared_ptr<T> RunToEnd(const std::shared_ptr<T>& result,
                            const std::function<void(Job*)>& work,
                            const pybind11::object& stop,
                            const std::function<bool(const T&)>& is_usable) {
  bool ended = false;
  try {
    Job::Run(work, stop, &ended);
  } catch (pybind11::error_already_set& error) {
    if (ended && is_usable(*result) && !error.value().is_none()) {
      // Exceptions of somebody else may refuse it.
      if (PyObject_SetAttrString(error.value().ptr(), "solution", pybind11::cast(result).ptr()) !=
          0) {
        PyErr_Clear();
      }
    }
    throw;
  }
  return result;
}

// What work needs and makes. Owned by the work too, which may be left to itself.
template <typename T>
struct Task {
  std::shared_ptr<T> result = std::make_shared<T>();
  bool posed = false;
  std::string error;  // where it is not
};

// RunToEnd of the work of a Task; InputError where it could not be posed.
template <typename TaskOfT>
auto RunTask(const std::shared_ptr<TaskOfT>& task,
             const std::function<void(Job*)>& work,
             const pybind11::object& stop) {
  using Result = typename decltype(task->result)::element_type;
  const std::shared_ptr<Result> result =
      RunToEnd<Result>(task->result, work, stop, [task](const Result&) { return task->posed; });
  if (!task->posed) throw MakeInputError(task->error);
  return result;
}

// Calls progress(**values) for each event; a False that it returns stops the job.
class Progress {
 public:
  // `callback` is None or outlives the job's run.
  Progress(const pybind11::object* callback, Job* job) : callback_(callback), job_(job) {}
  using MakeValues = std::function<pybind11::dict()>;
  // From the work, without Python's lock; `make` is called with it.
  void Post(const MakeValues& make) const;

 private:
  const pybind11::object* callback_;
  Job* job_;
};

// Events "step" and "iteration" of every solve with these options.
void ReportProgress(const Progress& progress, SolverOptions* options);

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_HANDLE_H_
