#include "interrupt.h"

#include <signal.h>

#include <atomic>

#include "plait/error.h"

namespace plait {
namespace {

std::atomic<int> received_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void remember_signal(int signal_number) { received_signal = signal_number; }

}  // namespace

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = remember_signal;
  // SA_RESETHAND lets a second signal end what does not listen.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal_number, nullptr, &before);
    // Ignored by whoever started us (nohup): stay so.
    if (before.sa_handler != SIG_IGN) sigaction(signal_number, &action, nullptr);
  }
  ::signal(SIGPIPE, SIG_IGN);
}

int interrupt_signal() noexcept { return received_signal; }

void throw_if_interrupted() {
  if (interrupted()) throw Error(ErrorCode::kCancelled, "cancelled by a signal");
}

}  // namespace plait
