#include "tools/progress.h"

#include <glog/logging.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>

#include "solver/time_left.h"
#include "tools/solver_flags.h"

namespace darboux {
namespace progress {
namespace {

using Clock = std::chrono::steady_clock;

class Output : public google::LogSink {
 public:
  static Output& Get() {
    static Output* const output = new Output;  // Never destroyed: glog may log until the end.
    return *output;
  }

  void Start(const char* tool, bool quiet, bool json) {
    tool_ = tool;
    quiet_ = quiet;
    json_ = json;
    is_terminal_ = isatty(STDERR_FILENO) != 0;
    if (!json) return;
    // glog's own lines would break the stream of objects.
    FLAGS_logtostderr = false;
    FLAGS_stderrthreshold = google::NUM_SEVERITIES;
    for (int severity = 0; severity < google::NUM_SEVERITIES; ++severity) {
      google::SetLogDestination(severity, "");
    }
    google::AddLogSink(this);
  }

  bool json() const { return json_; }
  bool quiet() const { return quiet_; }
  const char* tool() const { return tool_; }

  void Say(const char* event, const Json& fields, const std::string& text) {
    if (quiet_) return;
    Line(json_ ? Object(event, fields) : text);
  }

  void Error(const char* tool, const std::string& message, bool json) {
    Line(json ? Object("error", {{"message", message}}) : std::string(tool) + ": " + message);
  }

  void Live(const std::string& text) {
    if (quiet_ || json_) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    const double now = Seconds();
    constexpr double kPerLine = 0.1, kBetweenLines = 30.0;
    if (now - last_ < (is_terminal_ ? kPerLine : kBetweenLines)) return;
    last_ = now;
    if (is_terminal_) {
      std::fprintf(stderr, "\r\033[K%s", Fitting(text).c_str());
      std::fflush(stderr);
      live_ = true;
    } else {
      std::fprintf(stderr, "%s\n", text.c_str());
    }
  }

  void Clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ClearLocked();
  }

  // glog's.
  void send(google::LogSeverity severity,
            const char* /*full_filename*/,
            const char* base_filename,
            int line,
            const struct tm* /*time*/,
            const char* message,
            size_t length) override {
    if (severity < FLAGS_minloglevel) return;
    Line(Object(severity >= google::GLOG_ERROR     ? "library_error"
                : severity >= google::GLOG_WARNING ? "warning"
                                                   : "info",
                {{"message", std::string(message, length)},
                 {"source", std::string(base_filename) + ":" + std::to_string(line)}}));
  }

 private:
  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  std::string Object(const char* event, const Json& fields) const {
    Json object = {{"event", event}, {"t", std::round(Seconds() * 1e4) / 1e4}};
    object.update(fields);
    return object.dump(-1, ' ', false, Json::error_handler_t::replace);
  }

  void Line(const std::string& text) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ClearLocked();
    std::fprintf(stderr, "%s\n", text.c_str());
    std::fflush(stderr);
    last_ = Seconds();
  }

  void ClearLocked() {
    if (live_) std::fputs("\r\033[K", stderr);
    live_ = false;
  }

  // A line that wraps could not be taken back.
  static std::string Fitting(const std::string& text) {
    const char* const columns = std::getenv("COLUMNS");
    const int width = columns != nullptr ? std::atoi(columns) : 0;
    return text.substr(0, static_cast<size_t>(width > 10 ? width - 1 : 119));
  }

  const Clock::time_point start_ = Clock::now();
  const char* tool_ = "darboux";
  bool quiet_ = false, json_ = false, is_terminal_ = false;
  std::mutex mutex_;
  double last_ = 0.0;
  bool live_ = false;
};

// seconds_left: below 0 where not known.
Json Fields(const IterationReport& report, double seconds_left) {
  Json fields = {{"method", ToString(report.method)},
                 {"step", report.step},
                 {"steps", report.steps},
                 {"load_factor", report.load_factor},
                 {"iteration", report.iteration},
                 {"total", report.total},
                 {"energy", report.energy},
                 {"relative_gradient", report.relative_gradient},
                 {"seconds", report.seconds}};
  if (seconds_left >= 0.0) fields["seconds_left"] = seconds_left;
  return fields;
}

}  // namespace

bool AsksForJson(const std::vector<std::string>& words) {
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--") return false;
    if (words[i] == "--log=json" || words[i] == "-log=json") return true;
    if ((words[i] == "--log" || words[i] == "-log") && i + 1 < words.size()) {
      return words[i + 1] == "json";
    }
  }
  return false;
}

void Start(const char* tool, const char* version, const std::vector<std::string>& words) {
  Output::Get().Start(tool, FLAGS_quiet, FLAGS_log == "json");
  if (Output::Get().json()) {
    Say("start", {{"tool", tool}, {"version", version}, {"arguments", words}}, "");
  }
}

bool IsJson() { return Output::Get().json(); }

void Say(const char* event, const Json& fields, const std::string& text) {
  Output::Get().Say(event, fields, text);
}

void Live(const std::string& text) { Output::Get().Live(text); }

void Error(const char* tool, const std::string& message, bool json) {
  Output::Get().Error(tool, message, json);
}

void Error(const std::string& message) {
  Output::Get().Error(Output::Get().tool(), message, Output::Get().json());
}

int Done(int exit_status) {
  Output::Get().Clear();
  if (Output::Get().json()) Say("done", {{"exit_status", exit_status}}, "");
  return exit_status;
}

void Watch(bool whole_work, const std::string& prefix, SolverOptions* options) {
  if (Output::Get().quiet()) return;
  options->on_step = [](const StepReport& report) {
    char line[256];
    std::snprintf(line,
                  sizeof(line),
                  "step %d/%d  load %.4g  %d iterations  energy %.6e  gradient %.1e  "
                  "displacement %.4e  %.2f s%s",
                  report.step,
                  report.steps,
                  report.load_factor,
                  report.iterations,
                  report.energy,
                  report.relative_gradient,
                  report.max_displacement,
                  report.seconds,
                  report.converged ? "" : "  NOT CONVERGED");
    Say("step",
        {{"step", report.step},
         {"steps", report.steps},
         {"load_factor", report.load_factor},
         {"iterations", report.iterations},
         {"energy", report.energy},
         {"relative_gradient", report.relative_gradient},
         {"max_displacement", report.max_displacement},
         {"seconds", report.seconds},
         {"converged", report.converged}},
        line);
  };
  const auto time_left = std::make_shared<TimeLeft>(options->gradient_tolerance);
  options->on_iteration = [whole_work, prefix, time_left](const IterationReport& report) {
    double left = time_left->Update(report).value_or(-1.0);
    if (!whole_work) left = -1.0;
    if (Output::Get().json()) {
      Say("iteration", Fields(report, left), "");
      return;
    }
    char line[256];
    std::snprintf(line,
                  sizeof(line),
                  "%sstep %d/%d  load %.4g  iteration %d  gradient %.1e  energy %.6e  %s",
                  prefix.c_str(),
                  report.step,
                  report.steps,
                  report.load_factor,
                  report.iteration,
                  report.relative_gradient,
                  report.energy,
                  FormatDuration(report.seconds).c_str());
    std::string text = line;
    if (left >= 0.0) text += ", about " + FormatDuration(left) + " left";
    Live(text);
  };
}

std::string FormatDuration(double seconds) {
  if (!(seconds < 3.6e8)) return "years";
  const long whole = std::lround(std::max(0.0, seconds));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) {
    return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  }
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

}  // namespace progress
}  // namespace darboux
