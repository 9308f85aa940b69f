#include "interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include "console.h"
#include "plait/error.h"

namespace plait {
namespace {

constexpr const char* kCancelled = "cancelled by a signal";
constexpr const char* kEndedAtOnce = "cancelled by a signal; nothing is left half made";

std::atomic<int> received_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

/// What a signal that comes now writes before it ends the process; nullptr: it does not.
struct LastWords {
  std::string to_errors, to_output;
};
std::atomic<const LastWords*> last_words{nullptr};
static_assert(std::atomic<const LastWords*>::is_always_lock_free);

/// Whatever part of it is taken: nobody is left to be told of an error.
void write_once(int descriptor, const std::string& text) noexcept {
  [[maybe_unused]] const ssize_t taken = ::write(descriptor, text.data(), text.size());
}

/// Nothing here but what a signal handler may call.
extern "C" void receive_signal(int signal_number) {
  if (const LastWords* const words = last_words; words != nullptr) {
    write_once(STDERR_FILENO, words->to_errors);
    write_once(STDOUT_FILENO, words->to_output);
    ::_exit(kExitSignalBase + signal_number);
  }
  received_signal = signal_number;
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = receive_signal;
  // SA_RESETHAND lets a second signal end what does not listen.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal_number, nullptr, &before);
    // Ignored by whoever started us (nohup): stay so.
    if (before.sa_handler != SIG_IGN) sigaction(signal_number, &action, nullptr);
  }
  for (const int signal_number : {SIGPIPE, SIGXFSZ}) ::signal(signal_number, SIG_IGN);
}

int interrupt_signal() noexcept { return received_signal; }

void throw_if_interrupted() {
  if (interrupted()) throw Error(ErrorCode::kCancelled, kCancelled);
}

EndAtOnce::EndAtOnce(bool json) {
  throw_if_interrupted();
  static LastWords words;
  // On a terminal a progress bar may stand in the line.
  words.to_errors =
      std::string(::isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "") + error_line(kEndedAtOnce);
  words.to_output = json ? error_object(to_string(ErrorCode::kCancelled), kEndedAtOnce) : "";
  last_words = &words;
}

EndAtOnce::~EndAtOnce() { end(); }

void EndAtOnce::end() { last_words = nullptr; }

}  // namespace plait
