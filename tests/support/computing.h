// tests/support/computing.h: the time that another process has computed, as a clock for tests that
// end processes in the middle of their work. It stands still while others have the processors.
#pragma once

#include <sys/wait.h>

#include <chrono>
#include <ctime>

#include "support/eventually.h"

namespace plait::test {

/// Waits until the child has computed for `time` more. False if it ends before.
inline bool computes_for(pid_t child, std::chrono::microseconds time) {
  clockid_t clock{};
  if (::clock_getcpuclockid(child, &clock) != 0) return false;
  const auto computed = [&] {
    timespec now{};
    ::clock_gettime(clock, &now);
    return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
  };
  const auto until = computed() + time;
  bool ended = false;
  const bool told = eventually([&] {
    siginfo_t state{};
    ::waitid(P_PID, static_cast<id_t>(child), &state, WEXITED | WNOHANG | WNOWAIT);
    ended = state.si_pid != 0;
    return ended || computed() >= until;
  });
  return told && !ended;
}

}  // namespace plait::test
