// tools/interrupt.h: Ctrl-C and its kin as a flag that long work asks about. Only the program
// installs handlers; the library is told through its `proceed` callbacks.
#pragma once

namespace plait {

/// SIGINT, SIGTERM and SIGHUP set the flag, a second one ends the process at once. SIGPIPE is
/// ignored, so that a closed pipe is an error of the write.
void install_signal_handlers();
/// The signal that came, or 0. Safe from any thread.
int interrupt_signal() noexcept;
inline bool interrupted() noexcept { return interrupt_signal() != 0; }
/// Errors: kCancelled once a signal came. For steps that take no callback.
void throw_if_interrupted();

}  // namespace plait
