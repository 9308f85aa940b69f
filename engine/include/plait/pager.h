// plait/pager.h: which blocks are in memory. See docs/paging.md.
//
// Invariants
//  1. Bytes of all frames, pinned or not, in transfer or not, never exceed the budget less what was
//     set aside.
//  2. A pinned block stays at one address until its last pin ends.
//  3. A block is in at most one frame. A frame is memory of the pager's, or, for a level in memory
//     and for one that is mapped and was opened for reading, where the block lies anyway. So all
//     pins of a block see the same bytes, whatever they were pinned for.
//  4. A dirty block leaves its frame only by way of its backend.
//  5. A block pinned for Access::kWrite is never read from its backend.
//  6. Bytes served are bytes whose checksum was verified since they came in (what never leaves
//     memory has none).
//  7. After a failed write the pager is in error: it reads, and refuses to write or flush. The
//     error itself reaches the first caller that is refused, the later ones are told of it.
//  8. A block that is being written is neither evicted nor pinned for writing; one that is being
//     read is neither evicted nor pinned.
//  9. No transfer, checksum or (de)compression happens under the pager's lock.
//
// States of a block
//
//   absent --pin--> reading --> pinned(n) <--pin/unpin--> resident --evict--> absent
//     |                ^           |                         ^  ^
//     +--pin(kWrite)---|-----------+   unpin, dirty: writing-+  |
//     +--prefetch--> reading ahead -----------------------------+
//
// pinned and resident are clean or dirty. In a session of EvictionPolicy::kWindow a dirty block
// whose last pin ends is queued for writing at once, and stays resident, clean; without I/O threads
// and under kClock it is written when it is evicted. A block that is being written may be pinned
// for reading.
#pragma once

#include <cstdint>
#include <memory>

#include "plait/session.h"

namespace plait {

/// Safe from several threads. Outlives its sessions and their pins.
class Pager {
 public:
  /// Blocks in flight each way: enough to keep a disk busy.
  static constexpr std::uint32_t kInFlight = 8;

  /// `io_threads` read ahead and write behind; with 0 every transfer happens in the caller.
  explicit Pager(std::uint64_t budget_bytes, int io_threads = 1);
  ~Pager();
  Pager(const Pager&) = delete;
  Pager& operator=(const Pager&) = delete;

  /// The level must outlive the pager or be detached. Errors: kOutOfMemory, for want of a thread
  /// too.
  void attach(LevelFile& level);
  /// Drops all its blocks; dirty ones are lost, so flush first. Waits for what is in flight.
  /// REQUIRES: none is pinned, and no other call of this pager at the same time.
  void detach(LevelFile& level);

  /// Errors: kOutOfMemory.
  Session open_session(const SessionOptions& options = {});

  /// Hands all dirty blocks to their backends; they stay resident. Waits for what is in flight.
  /// REQUIRES: nobody changes a pinned block meanwhile. Errors: as Session::pin() for writing.
  void flush();
  /// From now on nothing is written: pins for writing and flush() are refused with kBadState.
  void refuse_writes() noexcept;
  /// Forgets every block that is not pinned, without writing: for a store that is thrown away.
  void discard() noexcept;

  /// So much of the budget is not for frames from now on: others hold memory there. Frames that are
  /// taken already are not taken away.
  void set_aside(std::uint64_t bytes) noexcept;
  std::uint64_t budget_bytes() const noexcept;  ///< what is for frames
  /// Of all sessions, open or ended, together.
  PagingStatistics statistics() const;

  class Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plait
