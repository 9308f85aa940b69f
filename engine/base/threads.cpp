#include "base/threads.h"

#include <fmt/format.h>
#include <pthread.h>

#include <atomic>
#include <csignal>
#include <cstddef>
#include <exception>
#include <initializer_list>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/caught.h"
#include "plait/error.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

sigset_t all_but_faults() noexcept {
  sigset_t signals;
  sigfillset(&signals);
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT})
    sigdelset(&signals, fault);
  return signals;
}

thread_local SignalsHeld* held_here = nullptr;

}  // namespace

SignalsHeld::SignalsHeld() noexcept : outer_(std::exchange(held_here, this)) {
  const sigset_t signals = all_but_faults();
  ::pthread_sigmask(SIG_BLOCK, &signals, &before_);
}

SignalsHeld::~SignalsHeld() {
  ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  held_here = outer_;
}

SignalsTaken::SignalsTaken() noexcept : held_(std::exchange(held_here, nullptr)) {
  if (held_ != nullptr) ::pthread_sigmask(SIG_SETMASK, &held_->before_, &blocked_);
}

SignalsTaken::~SignalsTaken() {
  if (held_ == nullptr) return;
  ::pthread_sigmask(SIG_SETMASK, &blocked_, nullptr);
  held_here = held_;
}

std::thread start_thread(std::string_view what, std::function<void()> work) {
  try {
    const SignalsHeld held;
    return std::thread(std::move(work));
  } catch (const std::system_error& failure) {
    refuse_thread(what, failure.code().message());
  }
}

void refuse_thread(std::string_view what, std::string_view reason) {
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("start {}: {}; the limits are ulimit -u and the pids of the container: "
                          "take fewer threads",
                          what, reason));
}

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
