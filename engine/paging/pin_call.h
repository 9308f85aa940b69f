// One call that pins blocks. A call takes all its frames before its first read begins. It frees
// them before it waits for other calls that may wait for it. So no two calls wait for each other.
// A call also waits for reads of other calls: at its end, when all its own reads have begun, and
// before it begins the read of a block that has context. Context blocks come earlier in the order
// of (attribute, level). A call that reads an earlier block waits only for blocks that come earlier
// still. So these waits end as well. Two calls that overwrite the same blocks may each have taken
// some of them; a call that overwrites a block does not wait for another one that does the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>

#include "paging/pager_implementation.h"
#include "paging/pin_batch.h"
#include "plait/detail/namespace.h"

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
  /// Writes the context blocks of all blocks that are about to be written, and fixes their levels.
  /// Releases the lock while it waits. Returns false if another call has meanwhile given up a frame
  /// that both have; then the call must start again. Errors: those of check_may_write(); kBadState
  /// if a context block is being changed; those of its write.
  bool fix_context();
  void fix_context_of(std::size_t at);
  void add_writer(std::size_t at) noexcept;
  /// Pins the context of an entry of the batch for the entry's frame.
  void pin_context(const PinBatch::WantedBlock& entry) noexcept;
  /// Frees the frames that the batch has taken.
  void free_frames() noexcept;

  // read_blocks.cpp
  /// Begins all reads, then waits for them. Returns false if the read of another call failed; then
  /// the call must start again. Errors: those of reads that this call began.
  bool read_blocks();
  /// Errors: std::bad_alloc, before it has begun any.
  void read();
  void read_with_context() noexcept;
  /// A block that `entry` is decoded with and that is not in memory; null if all of them are.
  Frame* absent_context(const PinBatch::WantedBlock& entry) noexcept;
  void begin_read_with_context(const PinBatch::WantedBlock& entry) noexcept;
  void fill_with_zeros() noexcept;

  Implementation& pager_;
  Lock& lock_;
  SessionState& session_;
  std::span<const BlockRequest> requests_;
  PinBatch batch_;
};

PLAIT_END_NAMESPACE
