// One call that pins blocks. A call takes all its frames before its first read begins. It frees
// them before it waits for other calls that may wait for it. So no two calls wait for each other.
// A call also waits for reads of other calls: at its end, when all its own reads have begun, and
// before it begins the read of a block that has context. Context blocks come earlier in the order
// of (level, attribute). A call that reads an earlier block waits only for blocks that come earlier
// still. So these waits end as well. The thread that computes a derived block (plait/derivation.h)
// pins others meanwhile, in calls inside the call. No call with frames waits for a derived block of
// another call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>

#include "paging/pager_implementation.h"
#include "paging/pin_batch.h"
#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Used while the pager's lock is held. The functions that release the lock say so.
class Pager::Implementation::PinCall {
 public:
  /// Errors: std::bad_alloc.
  PinCall(Implementation& pager, Lock& lock, SessionState& session,
          std::span<const BlockRequest> requests)
      : pager_(pager), lock_(lock), session_(session), requests_(requests), batch_(requests) {}

  /// Pins requests[i] in frames[i] for each i. After an error it has pinned none of them. Releases
  /// the lock while it waits. Errors: those of Session::pin_many; std::bad_alloc.
  void run(std::span<Frame*> frames);

 private:
  class UnderWay;

  // pin_call.cpp
  /// Takes a frame for each block of the batch, and adds the context blocks to the batch. Returns
  /// false if it had to wait and has no frames now.
  bool take_frames();
  void add_context(std::size_t at);
  /// Frees a frame, or waits until one may be free. Returns true if the batch still has its frames,
  /// false if it has freed them.
  bool make_room(const LevelFile& wanted_by);
  [[noreturn]] void refuse_room(std::uint64_t needed_bytes);
  /// Errors: kBadState for levels that are fixed, and after a failed write.
  void check_may_write();
  /// Writes the context blocks of a block that is about to be written, and fixes their levels.
  /// Releases the lock while it waits. Errors: kBadState if a context block is being changed; those
  /// of its write.
  void fix_context(std::size_t at);
  void add_writer(std::size_t at) noexcept;
  /// Frees the frames that the batch has taken.
  void let_go() noexcept;

  // bring_in.cpp
  /// Begins all reads, then waits for them. Returns false if the read of another call failed; then
  /// the call must start again. Errors: those of reads that this call began.
  bool bring_in();
  void read() noexcept;
  void read_with_context() noexcept;
  /// A block that `entry` is decoded with and that is not in memory; null if all of them are.
  Frame* absent_context(const PinBatch::Entry& entry) noexcept;
  void begin_read_with_context(const PinBatch::Entry& entry) noexcept;
  void fill_with_zeros() noexcept;
  /// Computes derived blocks, one after another. Each of them pins blocks in this thread, in a
  /// session of its own. These pins wait for other calls, but not for this one.
  void make_derived() noexcept;
  /// Computes one of them, with the lock released. Returns its error, or nullptr.
  std::exception_ptr make(const PinBatch::Entry& entry, Frame& frame) noexcept;
  /// Errors: kBadState if somebody is writing to what the level is computed from.
  static void check_may_make(const LevelFile& level);
  /// How many of the calls under way are calls of this thread.
  std::uint32_t calls_of_thread() const noexcept;
  /// Waits until another call has computed a derived block. The two functions may be called only
  /// while the batch has no frames: the other call needs more of them.
  void wait_for_makers() noexcept;
  /// The same for this block.
  void wait_until_made(const LevelFile& level, std::uint64_t block) noexcept;
  /// Whether this call claimed the frame.
  bool claimed(const Frame& frame) const noexcept;

  Implementation& pager_;
  Lock& lock_;
  SessionState& session_;
  std::span<const BlockRequest> requests_;
  PinBatch batch_;
  bool lacked_room_ = false;  ///< for a derived block, and another call may leave room
};

PLAIT_END_NAMESPACE
