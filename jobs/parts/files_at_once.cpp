#include "parts/files_at_once.h"

#include <algorithm>
#include <atomic>

#include "base/run_workers.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void each_file_at_once(std::size_t count, std::string_view name,
                       const std::function<void(std::size_t)>& body,
                       const std::function<void(std::size_t)>& tell) {
  constexpr std::size_t kMostThreads = 32;
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> is_stopped = false, has_failed = false;
  const auto work = [&](int, const std::function<void()>& report) {
    while (!is_stopped) {
      try {
        report();
        const std::size_t at = next++;
        if (at >= count) return;
        body(at);
      } catch (...) {
        has_failed = true;
        throw;
      }
    }
  };
  const SharedWork shared{work,
                          [&] {
                            if (tell) tell(std::min(next.load(), count));
                          },
                          [&] { is_stopped = true; }};
  const auto run = [&](std::size_t threads) {
    run_workers({}, static_cast<int>(threads), name, shared);
  };
  try {
    run(std::min(kMostThreads, count));
  } catch (const Error& error) {
    // A thread could not be started, and those that were have ended their calls.
    if (error.code() != ErrorCode::kOutOfMemory || has_failed) throw;
    is_stopped = false;
    run(1);
  }
}

PLAIT_END_NAMESPACE
