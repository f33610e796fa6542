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

}  // namespace darboux
