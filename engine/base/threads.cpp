#include "base/threads.h"

#include <fmt/format.h>
#include <pthread.h>

#include <csignal>
#include <initializer_list>

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

/// A new thread has the mask of the thread that starts it.
class SignalsBlocked {
 public:
  SignalsBlocked() noexcept {
    const sigset_t signals = all_but_faults();
    ::pthread_sigmask(SIG_BLOCK, &signals, &before_);
  }
  ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

void block_signals() noexcept {
  const sigset_t signals = all_but_faults();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

std::thread start_thread(std::string_view what, std::function<void()> work) {
  try {
    const SignalsBlocked blocked;
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
