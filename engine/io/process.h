// io/process.h: tells a process from the processes that it forks.
//
// A forked process has copies of all objects, but not of the threads, and it shares open files and
// the ring of io_uring with its parent. So an object that has threads, locks or transfers remembers
// its process, and refuses to work in another one (docs/threads.md).
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_NAMESPACE

/// The process in which this object was made. Threads: shared.
class OwnProcess {
 public:
  OwnProcess() noexcept;

  /// False in every process that was forked since. Costs one load.
  bool is_current() const noexcept { return number_ == current().load(std::memory_order_relaxed); }
  /// Throws kBadState if the process is not the current one. `what` is what another process made.
  void check(std::string_view what) const {
    if (!is_current()) [[unlikely]]
      refuse(what);
  }

 private:
  [[noreturn]] static void refuse(std::string_view what);
  /// How often this process and its parents were forked.
  static std::atomic<std::uint32_t>& current() noexcept {
    static constinit std::atomic<std::uint32_t> number = 0;
    return number;
  }
  static void watch_forks() noexcept;

  std::uint32_t number_;
};

/// From this call on, processes that are forked do not inherit the lock (flock) of an open file:
/// `descriptor` leads to /dev/null there. Until release_lock(). Threads: shared. Errors:
/// std::bad_alloc.
void keep_lock_from_children(int descriptor);
/// Releases the lock, if the descriptor has one, also while a process that was forked a moment ago
/// still shares it. To be called before each close.
void release_lock(int descriptor) noexcept;

PLAIT_END_NAMESPACE
