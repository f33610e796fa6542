#include "tools/python/job.h"

#include <chrono>
#include <exception>
#include <new>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;

// How often signals are looked for.
constexpr double kPollS = 0.02;

// Threads that nobody waits for any more, and their jobs.
struct Abandoned {
  std::mutex mutex;
  std::vector<std::thread> threads;
};

Abandoned& TheAbandoned() {
  static Abandoned& abandoned = *new Abandoned;
  return abandoned;
}

}  // namespace

void Job::Post(std::function<void()> event) {
  const std::lock_guard<std::mutex> lock(mutex_);
  events_.push_back(std::move(event));
  changed_.notify_all();
}

bool Job::Wait(double seconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(
      lock, std::chrono::duration<double>(seconds), [this] { return ended_ || !events_.empty(); });
  return ended_;
}

void Job::HandleEvents() {
  std::deque<std::function<void()>> events;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    events.swap(events_);
  }
  for (const std::function<void()>& event : events) event();
}

void Job::End(const std::string& failure, bool out_of_memory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  failure_ = failure;
  out_of_memory_ = out_of_memory;
  ended_ = true;
  changed_.notify_all();
}

void Job::Run(const std::function<void(Job*)>& work,
              const py::object& stop_requested,
              bool* ended) {
  *ended = false;
  const auto job = std::make_shared<Job>();
  std::thread thread([job, work] {
    // The project throws nothing; the libraries below it do where memory ends.
    try {
      work(job.get());
      job->End("", false);
    } catch (const std::bad_alloc&) {
      job->End("out of memory; fewer divisions or points need less", true);
    } catch (const std::exception& exception) {
      job->End(std::string("internal error: ") + exception.what(), false);
    }
  });
  const auto wait = [&job](double seconds) {
    const py::gil_scoped_release release;
    return job->Wait(seconds);
  };
  const auto raise = [](int result) {
    if (result != 0) throw py::error_already_set();
  };
  const auto join = [&thread] {
    const py::gil_scoped_release release;
    thread.join();
  };
  try {
    while (!wait(kPollS)) {
      job->HandleEvents();
      raise(PyErr_CheckSignals());
      if (!stop_requested.is_none() && stop_requested.attr("is_set")().cast<bool>()) {
        job->stop_ = true;
      }
    }
    join();
    *ended = true;
    job->HandleEvents();
  } catch (...) {
    if (*ended) throw;
    // The last good state is worth a moment.
    job->stop_ = true;
    const Clock::time_point start = Clock::now();
    bool has_ended = false, again = false;
    while (!has_ended && !again &&
           std::chrono::duration<double>(Clock::now() - start).count() < kGraceS) {
      has_ended = wait(kPollS);
      {
        const std::lock_guard<std::mutex> lock(job->mutex_);
        job->events_.clear();  // Nobody wants to know any more.
      }
      if (PyErr_CheckSignals() != 0) {
        PyErr_Clear();  // The first one is on its way.
        again = true;
      }
    }
    if (has_ended) {
      join();
      *ended = true;
    } else {
      Abandoned& abandoned = TheAbandoned();
      const std::lock_guard<std::mutex> lock(abandoned.mutex);
      abandoned.threads.push_back(std::move(thread));
    }
    throw;
  }
  if (job->out_of_memory_) throw std::bad_alloc();
  if (!job->failure_.empty()) throw std::runtime_error(job->failure_);
}

void Job::JoinAbandoned() {
  const py::gil_scoped_release release;
  Abandoned& abandoned = TheAbandoned();
  const std::lock_guard<std::mutex> lock(abandoned.mutex);
  for (std::thread& thread : abandoned.threads) thread.join();
  abandoned.threads.clear();
}

}  // namespace darboux
