#ifndef DARBOUX_SOLVER_FORKED_RUN_H_
#define DARBOUX_SOLVER_FORKED_RUN_H_

#include <atomic>
#include <functional>
#include <string>

namespace darboux {

// What became of a piece of work in a process of its own.
struct ForkedOutcome {
  enum class Status {
    kDone,       // `output` is what the work returned
    kCrashed,    // ended by a signal or with a status of its own; see message
    kStopped,    // *stop was set
    kTimeLimit,  // killed at the limit
    kNotStarted  // no process, or no pipe
  };
  Status status = Status::kNotStarted;
  std::string output;
  std::string message;     // why it is not kDone
  double memory_mb = 0.0;  // peak resident memory, what it shares with this process included
};

// Runs `work` in a child process (POSIX fork), so that its memory can be told and its crash is not
// ours, and waits for it. The calling process should have no other threads that hold locks. The
// child ends without destructors of statics and without flushing what it has not written.
// time_limit_s: 0 = none.
ForkedOutcome RunForked(const std::function<std::string()>& work,
                        double time_limit_s,
                        const std::atomic<bool>* stop);

}  // namespace darboux

#endif  // DARBOUX_SOLVER_FORKED_RUN_H_
