// The part of TBB that plait uses, written with std::thread. Only builds with the thread sanitizer
// use it.
//
// The distribution's libtbb is not instrumented, so the sanitizer does not see how its tasks
// synchronize. It would report every parallel loop as a race, and suppressions for that would also
// hide our own races. The preset "tsan" puts this folder before TBB's headers, so that the
// sanitizer reports only real races. This code makes the same promises as TBB, except for speed.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tbb {

/// The number of threads of a loop that this thread starts. task_arena sets it for the function
/// that it executes. The default is at least two, so that the sanitizer has something to check on a
/// small machine.
inline thread_local int concurrency =
    std::max(2, static_cast<int>(std::thread::hardware_concurrency()));

/// Calls body(i) for all i in [0, count), in any order, on up to `concurrency` threads. All calls
/// have ended on return. If a call throws, no further calls begin, and the first exception is
/// thrown here.
inline void call_for_all(std::size_t count, const std::function<void(std::size_t)>& body) {
  // Relaxed on purpose: taking a number must not order the memory accesses of two calls.
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const int outer_concurrency = concurrency;
  const auto work = [&] {
    concurrency = outer_concurrency;
    try {
      for (std::size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) body(i);
    } catch (...) {
      next.store(count, std::memory_order_relaxed);
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  const int wanted = static_cast<int>(std::min(count, static_cast<std::size_t>(concurrency)));
  for (int index = 1; index < wanted; ++index) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tbb
