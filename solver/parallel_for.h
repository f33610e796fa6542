#ifndef DARBOUX_SOLVER_PARALLEL_FOR_H_
#define DARBOUX_SOLVER_PARALLEL_FOR_H_

#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

namespace darboux {

// Threads worth starting for `count` elements: one costs as much as a few hundred of them.
inline int ThreadsFor(int count, int num_threads) {
  constexpr int kElementsPerThread = 256;
  return std::clamp(count / kElementsPerThread, 1, std::max(num_threads, 1));
}

// Calls work(thread, begin, end) on equal shares of [0, count), one share on each of num_threads
// threads.
template <typename Work>
void ParallelFor(int num_threads, int count, const Work& work) {
  const auto bound = [&](int thread) {
    return static_cast<int>(static_cast<int64_t>(count) * thread / num_threads);
  };
  std::vector<std::thread> threads;
  for (int t = 1; t < num_threads; ++t) threads.emplace_back(work, t, bound(t), bound(t + 1));
  work(0, 0, bound(1));
  for (std::thread& thread : threads) thread.join();
}

}  // namespace darboux

#endif  // DARBOUX_SOLVER_PARALLEL_FOR_H_
