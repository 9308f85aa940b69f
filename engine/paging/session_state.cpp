#include "paging/session_state.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint32_t SessionState::caller() {
  const std::thread::id thread = std::this_thread::get_id();
  auto known = std::ranges::find(callers_, thread, &Caller::thread);
  if (known == callers_.end()) {
    // Reuses the entry of a thread that has no pins, because threads come and go.
    known = std::ranges::find(callers_, 0u, &Caller::pins);
    if (known == callers_.end()) known = callers_.insert(callers_.end(), Caller{});
    known->thread = thread;
  }
  return static_cast<std::uint32_t>(known - callers_.begin());
}

PLAIT_END_NAMESPACE
