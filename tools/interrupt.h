// tools/interrupt.h: Ctrl-C and its kin as a flag that long work asks about. Only the program
// installs handlers; the library is told through its `proceed` callbacks.
#pragma once

namespace plait {

/// SIGINT, SIGTERM and SIGHUP set the flag, a second one ends the process at once. SIGPIPE and
/// SIGXFSZ are ignored, so that a closed pipe and a file as long as it may get are errors of the
/// write.
void install_signal_handlers();
/// The signal that came, or 0. Safe from any thread.
int interrupt_signal() noexcept;
inline bool interrupted() noexcept { return interrupt_signal() != 0; }
/// Errors: kCancelled once a signal came.
void throw_if_interrupted();

/// While one lives, a signal ends the process at once, with the words and the exit status of a
/// cancelled run: for long steps that have made nothing which would have to be removed. One at a
/// time; the constructor throws as throw_if_interrupted() does.
class EndAtOnce {
 public:
  /// `json`: the error is also an object on standard output.
  explicit EndAtOnce(bool json);
  ~EndAtOnce();
  /// From now on a signal only sets the flag again.
  void end();
  EndAtOnce(const EndAtOnce&) = delete;
  EndAtOnce& operator=(const EndAtOnce&) = delete;
};

}  // namespace plait
