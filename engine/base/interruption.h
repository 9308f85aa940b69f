// base/interruption.h: how a long step that knows nothing of progress hears that its caller does
// not want its result any more. A job says at its beginning who is asked; the step polls.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// While it exists, poll_interruption() of this thread asks `progress`, and that of workers in
/// loops of base/threads.h hears what it answered. One inside another stands for it meanwhile.
class Interruptible {
 public:
  /// `work` begins the message of the error. `progress` may be empty; it must outlive the object.
  /// It is asked at most once in the time `between`.
  Interruptible(std::string_view work, const ProgressCallback& progress,
                std::chrono::milliseconds between = std::chrono::milliseconds(50));
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  /// Passes on to `progress` and remembers what it was told: poll_interruption() tells that again.
  /// Valid as long as the object. Empty if `progress` is.
  ProgressCallback progress();

  /// That of this thread, or nullptr.
  static Interruptible* current() noexcept;

 private:
  friend class InterruptibleWorker;
  friend void poll_interruption();
  void ask();

  const std::string work_;
  const ProgressCallback& progress_;
  const std::chrono::milliseconds between_;
  std::string phase_;
  std::uint64_t done_ = 0, total_ = 0;
  std::chrono::steady_clock::time_point asked_;
  Interruptible* const outer_;
  std::atomic<bool> is_over_ = false;
  std::exception_ptr failure_;  ///< what ended it; set before is_over_
};

/// Lets a worker hear what the thread hears that has started it. Nothing for nullptr, and on that
/// thread itself.
class InterruptibleWorker {
 public:
  explicit InterruptibleWorker(Interruptible* of) noexcept;
  ~InterruptibleWorker();
  InterruptibleWorker(const InterruptibleWorker&) = delete;
  InterruptibleWorker& operator=(const InterruptibleWorker&) = delete;

 private:
  Interruptible* const before_;
  const bool was_worker_;
};

/// Asks the Interruptible of this thread, if it was not asked lately, whether the work shall go on.
/// No body of a loop of the program's own threads may call it (ParallelFor). Costs a look at the
/// clock: loops over small things call it once in a thousand turns (is_turn_to_poll). Errors:
/// kCancelled; what `progress` throws.
void poll_interruption();

constexpr bool is_turn_to_poll(std::uint64_t turn) noexcept { return (turn & 0x3ffu) == 0; }

PLAIT_END_NAMESPACE
