#include "plait/extend/thread_count.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

int thread_count(int threads, std::string_view work) {
  constexpr int kMost = 1024;
  if (threads < 0 || threads > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} threads, expected 1 to {}, or 0 for all processors", work,
                            threads, kMost));
  if (threads > 0) return threads;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMost);
}

PLAIT_END_NAMESPACE
