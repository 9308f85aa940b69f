#include "base/threads.h"

#include <fmt/format.h>
#include <pthread.h>

#include <csignal>
#include <initializer_list>
#include <utility>

#include "plait/error.h"

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

PLAIT_END_NAMESPACE
