// The transfers in flight, the queue of writes, and the first failed write. This class does not use
// sessions or the table of frames.
#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string_view>

#include "paging/frame.h"
#include "paging/io_queue.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager's lock protects it. Functions with a parameter `lock` release it while the backend
/// works.
class Transfers {
 public:
  using Lock = std::unique_lock<std::mutex>;
  using Direction = Transfer::Direction;

  /// Backends call `listener` when a transfer has ended; the listener then calls ended().
  Transfers(int threads, TransferListener& listener) : listener_(listener), queue_(threads) {}
  /// REQUIRES: no transfer is in flight.
  ~Transfers() = default;

  /// Without threads, each transfer runs in the thread that begins it.
  bool has_threads() const { return queue_.has_threads(); }
  /// Errors: kOutOfMemory.
  void start_threads() { queue_.start_threads(); }

  /// Prepares the read of a claimed frame, with its context, and changes its state. The caller then
  /// calls submit() or start().
  void begin_read(Frame& frame) noexcept;
  /// Prepares the write of a dirty frame in the same way.
  void begin_write(Frame& frame) noexcept;
  /// Queues transfers for the I/O threads. REQUIRES: has_threads().
  void submit(const TransferRun& run) noexcept { queue_.submit(run); }
  void submit(Frame& frame) noexcept { submit(TransferRun(frame.transfer)); }
  /// Begins the transfers in this thread. If the backend has no threads of its own, they also end
  /// here.
  void start(Lock& lock, const TransferRun& run) noexcept;
  void start(Lock& lock, Frame& frame) noexcept { start(lock, TransferRun(frame.transfer)); }
  /// Begins the transfer in this thread if it is only queued, because this thread would otherwise
  /// wait for it.
  void help(Lock& lock, Frame& frame) noexcept;
  /// The same for the oldest queued transfer. Returns false if none is queued.
  bool help_any(Lock& lock, Direction direction) noexcept;
  /// Withdraws a transfer that no thread has begun: the frame is claimed or dirty again. Returns
  /// false if it has begun.
  bool withdraw(Frame& frame) noexcept;
  /// The listener's finished() calls this. The frame becomes clean, or dirty again; after a failed
  /// read it stays in State::kReading.
  void ended(Frame& frame, const std::exception_ptr& error) noexcept;

  std::uint32_t reads() const { return reads_; }    ///< reads in flight
  std::uint32_t writes() const { return writes_; }  ///< writes in flight
  /// Whether less is in flight than Pager::kInFlight runs. What cannot be a part of a run counts as
  /// one.
  bool may_begin(Direction direction) const noexcept;

  /// Queues the write of a dirty frame. It begins when its whole run is queued, so that the run
  /// goes out in one call, but then or earlier: see write_waiting().
  void queue_write(Frame& frame) noexcept;
  /// Cancels the write of a frame, if it is queued and has not begun.
  void cancel_write(Frame& frame) noexcept;
  /// Begins queued writes whose time has come, as far as may_begin() allows.
  void write_behind() noexcept;
  /// The time has come for the oldest write that waits for the rest of its run, and for what there
  /// is of that run. Returns false if none waits.
  bool write_waiting() noexcept;
  /// The most bytes of frames that may wait for the rest of their runs.
  void set_most_waiting(std::uint64_t bytes) noexcept { most_waiting_bytes_ = bytes; }

  /// Cancels queued writes after a failed write. The first refuse() throws `error`.
  void fail(std::exception_ptr error) noexcept;
  bool failed() const { return failed_; }
  /// Throws the error of fail() the first time, and kBadState after that.
  [[noreturn]] void refuse(std::string_view what);

 private:
  void begin(Frame& frame, Direction direction) noexcept;
  /// Moves what waits of the frame's run to the writes whose time has come.
  void write_run_of(Frame& frame) noexcept;
  /// What a transfer counts for in may_begin(), in bytes.
  static std::uint64_t weight(const Frame& frame) noexcept;
  std::uint64_t& in_flight(Direction direction) noexcept {
    return in_flight_bytes_[direction == Direction::kRead ? 0 : 1];
  }

  TransferListener& listener_;
  std::uint32_t reads_ = 0, writes_ = 0;
  std::array<std::uint64_t, 2> in_flight_bytes_{};  ///< by weight(): of reads, of writes
  WriteList to_write_;                              ///< whose time has come: oldest first
  WriteList waiting_;                               ///< for the rest of their runs: oldest first
  std::uint64_t waiting_bytes_ = 0, most_waiting_bytes_ = 0;
  bool failed_ = false;
  std::exception_ptr failure_;  ///< the error that refuse() has not thrown yet

  IoQueue queue_;  ///< last: its threads end first
};

PLAIT_END_NAMESPACE
