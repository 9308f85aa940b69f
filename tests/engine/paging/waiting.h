// tests/engine/paging/waiting.h: what the tests of the pager share: the size of a block, and
// whether another thread still waits.
#pragma once

#include <chrono>
#include <cstdint>
#include <future>

#include "support/eventually.h"

namespace plait::test {

inline constexpr std::uint64_t kBlockBytes = 4096;

/// Whether the call of another thread waits: all threads sleep, and it has no result.
template <class Result>
bool is_waiting(const std::future<Result>& future) {
  return eventually(other_threads_sleep) &&
         future.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
}

}  // namespace plait::test
