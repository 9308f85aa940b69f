#include "base/call_workers.h"

#include <fmt/format.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <vector>

#include "base/caught.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void call_workers(const ParallelFor& parallel_for, int count, std::string_view name,
                  const std::function<void(int)>& work) {
  std::vector<std::atomic<bool>> begun(static_cast<std::size_t>(count));
  std::atomic<int> ended = 0;
  std::atomic<bool> wrong_call = false;
  std::mutex mutex;
  std::exception_ptr failure;
  parallel_for(count, [&](int worker) {
    if (worker < 0 || worker >= count || begun[static_cast<std::size_t>(worker)].exchange(true)) {
      wrong_call = true;
      return;
    }
    try {
      work(worker);
    } catch (...) {
      const std::scoped_lock lock(mutex);
      keep_first(failure);
    }
    ++ended;
  });
  if (failure) std::rethrow_exception(failure);
  if (wrong_call)
    throw Error(ErrorCode::kBadState,
                fmt::format("{}: the program's parallel_for called a body twice, or with a number "
                            "that is not in [0, {})",
                            name, count));
  if (ended != count)
    throw Error(ErrorCode::kBadState,
                fmt::format("{}: the program's parallel_for ran {} bodies, expected {}", name,
                            ended.load(), count));
}

PLAIT_END_NAMESPACE
