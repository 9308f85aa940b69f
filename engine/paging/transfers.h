// What is on its way, what waits for that, and what has failed. Knows neither sessions nor which
// block goes where.
#pragma once

#include <cstdint>
#include <exception>
#include <mutex>
#include <string_view>

#include "paging/frame.h"
#include "paging/io_queue.h"

namespace plait {

/// One thread at a time (the pager's lock); those calls that take the lock let go of it meanwhile.
class Transfers {
 public:
  using Lock = std::unique_lock<std::mutex>;
  using Direction = Transfer::Direction;

  /// `listener` is told of every transfer that ended, and calls ended() then.
  Transfers(int threads, TransferListener& listener) : listener_(listener), queue_(threads) {}
  /// REQUIRES: nothing is on its way.
  ~Transfers() = default;

  /// With none, every transfer happens in the thread that begins it.
  bool has_threads() const { return queue_.has_threads(); }
  /// Errors: kOutOfMemory.
  void start_threads() { queue_.start_threads(); }

  /// The frame, claimed, is being read from now on, with the context that it holds. The transfer
  /// itself is for submit() or start() to begin.
  void begin_read(Frame& frame) noexcept;
  /// The frame, dirty, is being written from now on.
  void begin_write(Frame& frame) noexcept;
  /// To be carried out by the threads. REQUIRES: there are some.
  void submit(Frame& frame) noexcept { queue_.submit(frame.transfer); }
  /// Begins it in this thread; a backend without threads of its own also ends it here.
  void start(Lock& lock, Frame& frame) noexcept;
  /// Begins it here if it is only queued: whoever would have to wait for it can as well do it.
  void help(Lock& lock, Frame& frame) noexcept;
  /// The same with the oldest that is queued. False: there is none.
  bool help_any(Lock& lock, Direction direction) noexcept;
  /// Takes back what no thread has begun: the frame is claimed or dirty again. False: it is begun.
  bool withdraw(Frame& frame) noexcept;
  /// What a listener's finished() comes to: the frame is clean, dirty again, or, after a read that
  /// failed, still in State::kReading.
  void ended(Frame& frame, const std::exception_ptr& error) noexcept;

  std::uint32_t reads() const { return reads_; }    ///< that are on their way
  std::uint32_t writes() const { return writes_; }  ///< the same

  /// Waits, dirty, for its write to begin; until then to_write.unlink() takes it back.
  void queue_write(Frame& frame) noexcept { to_write_.push_back(frame); }
  /// Begins as many queued writes as may be on their way at once.
  void write_behind() noexcept;

  /// Nothing is written any more. `error`: what is thrown by the first refuse().
  void fail(std::exception_ptr error) noexcept;
  bool failed() const { return failed_; }
  /// Errors: the one that fail() was given, once; then kBadState.
  [[noreturn]] void refuse(std::string_view what);

 private:
  void begin(Frame& frame, Direction direction) noexcept;

  TransferListener& listener_;
  std::uint32_t reads_ = 0, writes_ = 0;
  WriteList to_write_;  ///< oldest first
  bool failed_ = false;
  std::exception_ptr failure_;  ///< not reported yet

  IoQueue queue_;  ///< last: its threads end first
};

}  // namespace plait
