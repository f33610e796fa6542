#include "solver/forked_run.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <system_error>

namespace darboux {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPollMs = 50;  // How late *stop and the limit are seen.

std::string ErrnoText() { return std::generic_category().message(errno); }

[[noreturn]] void RunChild(const std::function<std::string()>& work, int to) {
  std::string output;
  int status = 0;
  try {
    output = work();
  } catch (const std::bad_alloc&) {
    status = 2;
  } catch (const std::exception&) {
    status = 1;
  }
  for (size_t done = 0; done < output.size();) {
    const ssize_t written = write(to, output.data() + done, output.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(1);
    done += static_cast<size_t>(written);
  }
  _exit(status);
}

}  // namespace

ForkedOutcome RunForked(const std::function<std::string()>& work,
                        double time_limit_s,
                        const std::atomic<bool>* stop) {
  ForkedOutcome outcome;
  int ends[2];
  if (pipe(ends) != 0) {
    outcome.message = "no pipe: " + ErrnoText();
    return outcome;
  }
  // Or what is buffered here would be written by both.
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) {
    outcome.message = "no process: " + ErrnoText();
    close(ends[0]);
    close(ends[1]);
    return outcome;
  }
  if (child == 0) {
    close(ends[0]);
    RunChild(work, ends[1]);
  }
  close(ends[1]);
  const Clock::time_point start = Clock::now();
  bool killed_for_stop = false, killed_for_time = false;
  char buffer[65536];
  while (true) {
    if (!killed_for_stop && stop != nullptr && stop->load()) {
      killed_for_stop = true;
      kill(child, SIGKILL);
    }
    if (!killed_for_time && time_limit_s > 0.0 &&
        std::chrono::duration<double>(Clock::now() - start).count() > time_limit_s) {
      killed_for_time = true;
      kill(child, SIGKILL);
    }
    pollfd waits{ends[0], POLLIN, 0};
    const int ready = poll(&waits, 1, kPollMs);
    if (ready < 0 && errno != EINTR) break;
    if (ready <= 0) continue;
    const ssize_t count = read(ends[0], buffer, sizeof(buffer));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    outcome.output.append(buffer, static_cast<size_t>(count));
  }
  close(ends[0]);
  int status = 0;
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  outcome.memory_mb = usage.ru_maxrss / 1024.0;  // kB on Linux
  if (killed_for_stop) {
    outcome.status = ForkedOutcome::Status::kStopped;
    outcome.message = "stopped";
  } else if (killed_for_time) {
    outcome.status = ForkedOutcome::Status::kTimeLimit;
    outcome.message = "time limit";
  } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    outcome.status = ForkedOutcome::Status::kDone;
  } else {
    outcome.status = ForkedOutcome::Status::kCrashed;
    outcome.message = WIFSIGNALED(status)
                          ? std::string("ended by the signal ") + strsignal(WTERMSIG(status))
                      : WEXITSTATUS(status) == 2 ? "out of memory"
                                                 : "ended by an exception";
  }
  return outcome;
}

}  // namespace darboux
