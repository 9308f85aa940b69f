// tools/interrupt.h: turns Ctrl-C and similar signals into a flag that long work checks. Only the
// program installs signal handlers. The library stops when its progress callback returns false.
#pragma once

namespace plait {

/// SIGINT, SIGTERM and SIGHUP set the flag; a second one ends the process at once. SIGPIPE and
/// SIGXFSZ are ignored, so that writing to a closed pipe, or beyond the largest file size, gives an
/// error.
void install_signal_handlers();
/// The signal that the process received, or 0. Safe from any thread.
int interrupt_signal() noexcept;
inline bool interrupted() noexcept { return interrupt_signal() != 0; }
/// Throws kCancelled if the process has received a signal.
void throw_if_interrupted();

/// While an object of this class exists, a signal ends the process at once, with the message and
/// the exit status of a cancelled run. It is for long steps before the program has made any file.
/// Only one object may exist at a time. The constructor throws as throw_if_interrupted() does.
class EndAtOnce {
 public:
  /// `json`: the error is also an object on standard output.
  explicit EndAtOnce(bool json);
  ~EndAtOnce();
  /// After this call a signal only sets the flag again.
  void end();
  EndAtOnce(const EndAtOnce&) = delete;
  EndAtOnce& operator=(const EndAtOnce&) = delete;
};

}  // namespace plait
