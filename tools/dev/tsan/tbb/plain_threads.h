// The part of TBB that plait uses, written with std::thread, for the thread sanitizer alone.
//
// The distribution's libtbb is not instrumented, so the sanitizer does not see how its tasks hand
// over to each other: every parallel loop is reported as a race, and suppressions wide enough to
// silence that hide the races that are ours. The preset "tsan" puts this folder before TBB's
// headers, and what is left to report is real. It promises what TBB promises, but not its speed,
// and is used by no other build.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tbb {

/// Threads that a loop started here may use; task_arena sets it for what it executes. At least two
/// by default, or there would be nothing to look at on a small machine.
inline thread_local int concurrency =
    std::max(2, static_cast<int>(std::thread::hardware_concurrency()));

/// Which of a loop's threads this one is: 0 for the one that began it.
inline thread_local int thread_index = 0;

/// Calls body(i) for all i in [0, count), in any order, from as many threads as there may be. All
/// calls have ended on return. The first exception thrown is thrown on; calls not begun are left.
inline void call_for_all(std::size_t count, const std::function<void(std::size_t)>& body) {
  // Relaxed on purpose: drawing a number must not order one call's accesses before another's.
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const int outer_concurrency = concurrency;
  const auto work = [&](int index) {
    concurrency = outer_concurrency;
    const int outer_index = std::exchange(thread_index, index);
    try {
      for (std::size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) body(i);
    } catch (...) {
      next.store(count, std::memory_order_relaxed);
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
    thread_index = outer_index;
  };
  std::vector<std::thread> threads;
  const int wanted = static_cast<int>(std::min(count, static_cast<std::size_t>(concurrency)));
  for (int index = 1; index < wanted; ++index) threads.emplace_back(work, index);
  work(0);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tbb
