#include "tools/python/module.h"

#include <glog/logging.h>

#include <cstddef>

#include "tools/python/job.h"

namespace py = pybind11;

namespace darboux {
namespace {

// Ceres logs by glog, whose complaint about a missing initialisation would be the first thing that
// a user sees. Another module of the process may have initialised it, to its own liking.
void InitialiseLogging() {
  if (google::IsGoogleLoggingInitialized()) return;
  FLAGS_logtostderr = true;  // No files in the folder for temporary ones.
  FLAGS_minloglevel = google::GLOG_ERROR;
  google::InitGoogleLogging("darboux");
}

}  // namespace

InputError MakeInputError(const std::string& message) {
  std::string text = message;
  for (const std::string label : {kSceneLabel, kCalibrationLabel}) {
    for (std::size_t at = text.find(label + ":"); at != std::string::npos;
         at = text.find(label + ":", at)) {
      const std::size_t digits = at + label.size() + 1;
      const std::size_t end = text.find_first_not_of("0123456789", digits);
      if (end == digits || end == std::string::npos || text.compare(end, 2, ": ") != 0) {
        at = digits;
        continue;
      }
      text.erase(at, end + 2 - at);
    }
  }
  // It speaks of a flag of the tools.
  const std::string flag = "--repair", argument = "repair=True";
  const std::size_t at = text.find(flag);
  if (at != std::string::npos) text.replace(at, flag.size(), argument);
  return InputError(text);
}

}  // namespace darboux

PYBIND11_MODULE(_darboux, module) {
  module.doc() = "Internals of the package darboux; nothing here is for direct use.";
  darboux::InitialiseLogging();
  py::register_exception<darboux::InputError>(module, "InputError", PyExc_ValueError);
  module.attr("version") = DARBOUX_VERSION;
  module.attr("scene_label") = darboux::kSceneLabel;
  module.attr("calibration_label") = darboux::kCalibrationLabel;
  module.def("join_abandoned", &darboux::Job::JoinAbandoned);
  darboux::BindScene(&module);
  darboux::BindSolution(&module);
  darboux::BindScan(&module);
  darboux::BindFit(&module);
  darboux::BindCalibration(&module);
  darboux::BindStudy(&module);
}
