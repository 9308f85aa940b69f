#include "base/run_workers.h"

#include <fmt/format.h>

#include <exception>
#include <mutex>

#include "base/caught.h"
#include "base/threads.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

bool is_refusal(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Error& refusal) {
    return refusal.code() == ErrorCode::kBadState;
  } catch (...) {  // what is stored is an exception
    return false;
  }
}

}  // namespace

void run_workers(const ParallelFor& parallel_for, int count, std::string_view name,
                 const SharedWork& shared) {
  std::mutex failing, reporting;
  std::exception_ptr failure;
  const auto work = [&](int worker, const std::function<void()>& report) {
    try {
      shared.work(worker, report);
    } catch (...) {
      shared.stop();
      const std::scoped_lock lock(failing);
      // The first error that is no mere refusal stays: a refusal follows from the failed write of
      // another thread.
      if (failure && is_refusal(failure)) failure = nullptr;
      keep_first(failure);
    }
  };
  if (parallel_for && count > 1) {
    // The calling thread may have no part in the loop.
    const auto report = [&] {
      if (const std::unique_lock lock(reporting, std::try_to_lock); lock) shared.report();
    };
    call_workers(parallel_for, count, name, [&](int worker) { work(worker, report); });
  } else {
    JoinedThreads helpers;
    try {
      for (int i = 1; i < count; ++i)
        helpers.start(fmt::format("thread {} of {} of {}", i + 1, count, name),
                      [&, i] { work(i, [] {}); });
    } catch (...) {
      shared.stop();
      throw;
    }
    work(0, shared.report);
  }
  if (failure) std::rethrow_exception(failure);
}

PLAIT_END_NAMESPACE
