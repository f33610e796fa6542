#include "solver/iteration_log.h"

namespace darboux {

const char* ToString(IterationReport::Method method) {
  switch (method) {
    case IterationReport::Method::kLinear:
      return "linear";
    case IterationReport::Method::kMixed:
      return "mixed";
    case IterationReport::Method::kCeres:
      return "ceres";
    case IterationReport::Method::kConjugateGradient:
      return "cg";
    case IterationReport::Method::kPath:
      return "path";
  }
  return "";
}

void IterationLog::Record(IterationReport::Method method,
                          double load_factor,
                          int iteration,
                          double energy,
                          double relative_gradient) {
  report_.method = method;
  report_.load_factor = load_factor;
  report_.iteration = iteration;
  report_.energy = energy;
  report_.relative_gradient = relative_gradient;
  report_.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  history_->push_back(report_);
  ++report_.total;
  if (on_iteration_) on_iteration_(history_->back());
}

}  // namespace darboux
