// tests/engine/paging/waiting.h: what the tests of the pager share: the size of a block, and
// whether another thread still waits.
#pragma once

#include <chrono>
#include <cstdint>
#include <future>

namespace plait::test {

inline constexpr std::uint64_t kBlockBytes = 4096;

template <class Result>
bool is_waiting(const std::future<Result>& future) {
  return future.wait_for(std::chrono::milliseconds(30)) == std::future_status::timeout;
}

}  // namespace plait::test
