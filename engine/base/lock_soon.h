// Takes a lock that other threads have only for about a microsecond.
#pragma once

#include <mutex>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

PLAIT_END_NAMESPACE
