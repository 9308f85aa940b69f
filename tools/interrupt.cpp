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
constexpr const char* kEndedAtOnce = "cancelled by a signal; no half-made file is left";

std::atomic<int> received_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

/// The text that the signal handler writes before it ends the process. nullptr: a signal does not
/// end the process.
struct LastWords {
  std::string to_errors, to_output;
};
std::atomic<const LastWords*> last_words{nullptr};
static_assert(std::atomic<const LastWords*>::is_always_lock_free);

/// Ignores errors, because the process ends and cannot report them.
void write_once(int descriptor, const std::string& text) noexcept {
  [[maybe_unused]] const ssize_t taken = ::write(descriptor, text.data(), text.size());
}

/// Calls only functions that a signal handler may call.
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
  // With SA_RESETHAND a second signal ends the process, also if the work does not check the flag.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal_number, nullptr, &before);
    // If the parent process ignores the signal (nohup), it stays ignored.
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
  // On a terminal the line may contain a progress bar.
  words.to_errors =
      std::string(::isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "") + error_line(kEndedAtOnce);
  words.to_output = json ? error_object(to_string(ErrorCode::kCancelled), kEndedAtOnce) : "";
  last_words = &words;
}

EndAtOnce::~EndAtOnce() { end(); }

void EndAtOnce::end() { last_words = nullptr; }

}  // namespace plait
