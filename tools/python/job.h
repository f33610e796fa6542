#ifndef DARBOUX_TOOLS_PYTHON_JOB_H_
#define DARBOUX_TOOLS_PYTHON_JOB_H_

#include <pybind11/pybind11.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace darboux {

// Long work in a thread of its own, which knows nothing of Python. The calling thread waits without
// the interpreter's lock and takes it now and then: to look for signals (Ctrl-C), to see whether
// the caller's `stop` is set, and to call Python with what the work has posted. So Python code runs
// in the thread that asked for the work and nowhere else, other Python threads go on meanwhile, and
// any number of them can have work done at the same time.
class Job {
 public:
  // SolverOptions::stop of the work.
  const std::atomic<bool>* stop() const { return &stop_; }
  // From the work: what the calling thread is to do next time it has the interpreter's lock, never
  // after Run has returned. Must not own Python objects: where the work is abandoned, it is
  // destroyed without the lock.
  void Post(std::function<void()> event);
  // From an event: the work is to stop at the next chance.
  void RequestStop() { stop_ = true; }

  // Calls work(job), which must own all that it uses. `stop_requested` is None or has a method
  // is_set() (threading.Event).
  //
  // Throws what Python's signal handlers, stop_requested or events raised, as error_already_set;
  // before that the work is told to stop. *ended then says whether it has done so: it is waited for
  // kGraceS, or until another signal comes, and then left to itself. A factorisation cannot be
  // interrupted. What the work threw itself is thrown as std::bad_alloc or std::runtime_error.
  static void Run(const std::function<void(Job*)>& work,
                  const pybind11::object& stop_requested,
                  bool* ended);
  static constexpr double kGraceS = 5.0;

  // Waits for work that was left to itself. To be called before the interpreter ends, with its
  // lock.
  static void JoinAbandoned();

 private:
  // Waits for an event, the end or a short time. Returns whether the work has ended.
  bool Wait(double seconds);
  void HandleEvents();
  void End(const std::string& failure, bool out_of_memory);

  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> events_;  // mutex_, as all below
  bool ended_ = false;
  bool out_of_memory_ = false;
  std::string failure_;
};

}  // namespace darboux

#endif  // DARBOUX_TOOLS_PYTHON_JOB_H_
