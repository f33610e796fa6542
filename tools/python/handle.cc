#include "tools/python/handle.h"

namespace py = pybind11;

namespace darboux {

std::size_t Solution::StepIndex(int step) const {
  const int count = static_cast<int>(summary.steps.size());
  if (step >= -count && step < count)
    return static_cast<std::size_t>(step < 0 ? step + count : step);
  throw py::index_error("step: found " + std::to_string(step) + "; allowed " +
                        (count == 0 ? "none, as no load step was reached"
                                    : std::to_string(-count) + " to " + std::to_string(count - 1)));
}

const OutputMesh& Solution::mesh() const {
  MakeSites();
  return mesh_;
}

const std::vector<FieldSite>& Solution::sites() const {
  MakeSites();
  return sites_;
}

void Solution::MakeSites() const {
  std::call_once(made_, [this] {
    mesh_ = MakeOutputMesh(problem->surface());
    sites_.reserve(mesh_.points.size());
    for (const ElementPoint& at : mesh_.points) {
      sites_.push_back(MakeFieldSite(problem->surface(), at));
    }
  });
}

void Progress::Post(const MakeValues& make) const {
  job_->Post([callback = callback_, job = job_, make] {
    const py::object answer = (*callback)(**make());
    if (answer.ptr() == Py_False) job->RequestStop();
  });
}

void ReportProgress(const Progress& progress, SolverOptions* options) {
  options->on_step = [progress](const StepReport& report) {
    progress.Post([report] {
      return py::dict(py::arg("kind") = "step",
                      py::arg("step") = report.step,
                      py::arg("steps") = report.steps,
                      py::arg("load_factor") = report.load_factor,
                      py::arg("iterations") = report.iterations,
                      py::arg("energy") = report.energy,
                      py::arg("relative_gradient") = report.relative_gradient,
                      py::arg("max_displacement") = report.max_displacement,
                      py::arg("seconds") = report.seconds,
                      py::arg("converged") = report.converged);
    });
  };
  options->on_iteration = [progress](const IterationReport& report) {
    progress.Post([report] {
      return py::dict(py::arg("kind") = "iteration",
                      py::arg("method") = ToString(report.method),
                      py::arg("step") = report.step,
                      py::arg("steps") = report.steps,
                      py::arg("load_factor") = report.load_factor,
                      py::arg("iteration") = report.iteration,
                      py::arg("total") = report.total,
                      py::arg("energy") = report.energy,
                      py::arg("relative_gradient") = report.relative_gradient,
                      py::arg("seconds") = report.seconds);
    });
  };
}

}  // namespace darboux
