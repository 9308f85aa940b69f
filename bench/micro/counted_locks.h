// How often and how long threads wait for mutexes and have them, in a program that links
// counted_locks.cpp. That source has the functions of POSIX threads that the program and its
// libraries then call, so nothing else is built differently.
#pragma once

#include <cstdint>

namespace plait::bench {

/// Of all threads together. Times are in nanoseconds.
struct LockCounts {
  std::uint64_t locked = 0;     ///< times that a thread got a mutex
  std::uint64_t contended = 0;  ///< how many of them another thread had it first
  std::uint64_t waited_ns = 0;  ///< until a thread got a mutex that another one had
  std::uint64_t held_ns = 0;
  std::uint64_t slept_ns = 0;  ///< on condition variables
};

/// What has been counted since the last call.
LockCounts take_lock_counts();

}  // namespace plait::bench
