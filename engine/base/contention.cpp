#include "base/contention.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint32_t this_thread_number() noexcept {
  static constinit std::atomic<std::uint32_t> last = 0;
  thread_local const std::uint32_t number = ++last;
  return number;
}

PLAIT_END_NAMESPACE
