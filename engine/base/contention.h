// base/contention.h: how threads that change the same thing do not wait for each other.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Takes a lock that other threads have only for about a microsecond.

/// Tells the processor that the thread waits in a loop.
inline void pause_processor() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// A thread that sleeps is woken after some fifty microseconds. So this thread tries again for a
/// few microseconds first.
inline std::unique_lock<std::mutex> lock_soon(std::mutex& mutex) noexcept {
  constexpr int kTrials = 64;
  std::unique_lock<std::mutex> lock(mutex, std::try_to_lock);
  for (int trial = 0; trial < kTrials && !lock; ++trial) {
    pause_processor();
    static_cast<void>(lock.try_lock());
  }
  if (!lock) lock.lock();
  return lock;
}

// small numbers of threads, and a counter that has a part for each thread.

/// A number of the calling thread. No two threads have the same (until 2^32 have been started).
std::uint32_t this_thread_number() noexcept;

/// Threads that share something of which there are this number choose one by their number.
inline constexpr std::size_t kThreadParts = 16;
inline std::size_t this_thread_part() noexcept { return this_thread_number() % kThreadParts; }

/// A counter that many threads change and few read. Each thread changes a part in a cache line of
/// its own. Threads: shared; the value is exact when no other thread changes it.
class SplitCounter {
 public:
  void operator++() noexcept { ++of_this_thread(); }
  void operator--() noexcept { --of_this_thread(); }
  /// Another thread may have counted down what one has counted up, so only the sum has a meaning.
  operator std::uint64_t() const noexcept {
    std::uint64_t sum = 0;
    for (const Part& part : parts_) sum += part.count;
    return sum;
  }

 private:
  struct alignas(64) Part {
    std::atomic<std::uint64_t> count = 0;
  };
  std::atomic<std::uint64_t>& of_this_thread() noexcept { return parts_[this_thread_part()].count; }

  std::array<Part, kThreadParts> parts_;
};

PLAIT_END_NAMESPACE
