// The transfers in flight, the queue of writes, and the first failed write. This class does not use
// sessions or the table of frames.
#pragma once

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
  /// Queues the transfer for the I/O threads. REQUIRES: has_threads().
  void submit(Frame& frame) noexcept { queue_.submit(frame.transfer); }
  /// Begins the transfer in this thread. If the backend has no threads of its own, the transfer
  /// also ends here.
  void start(Lock& lock, Frame& frame) noexcept;
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

  /// Queues the write of a dirty frame. Until the write begins, to_write.unlink() cancels it.
  void queue_write(Frame& frame) noexcept { to_write_.push_back(frame); }
  /// Begins queued writes, until Pager::kInFlight writes are in flight.
  void write_behind() noexcept;

  /// Cancels queued writes after a failed write. The first refuse() throws `error`.
  void fail(std::exception_ptr error) noexcept;
  bool failed() const { return failed_; }
  /// Throws the error of fail() the first time, and kBadState after that.
  [[noreturn]] void refuse(std::string_view what);

 private:
  void begin(Frame& frame, Direction direction) noexcept;

  TransferListener& listener_;
  std::uint32_t reads_ = 0, writes_ = 0;
  WriteList to_write_;  ///< oldest first
  bool failed_ = false;
  std::exception_ptr failure_;  ///< the error that refuse() has not thrown yet

  IoQueue queue_;  ///< last: its threads end first
};

PLAIT_END_NAMESPACE
