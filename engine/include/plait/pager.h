// plait/pager.h: which blocks are in memory. See docs/paging.md.
//
// Invariants
//  1. Bytes of all frames, pinned or not, in transfer or not, never exceed the budget less what was
//     set aside.
//  2. A pinned block stays at one address until its last pin ends.
//  3. A block is in at most one frame, so that all pins of a block see the same bytes, whatever
//  they
//     were pinned for. A frame is memory of the pager. For a level in memory, and for one that is
//     mapped and was opened for reading, it is the place where the block lies anyway. After a read
//     that failed and after abandon(), a frame is detached: whoever still pins it keeps it, and the
//     block is absent.
//  4. A dirty block that was not abandoned leaves its frame only by way of its backend.
//  5. A block pinned for Access::kWrite is never read from its backend.
//  6. Bytes served are bytes whose checksum was verified since they came in (what never leaves
//     memory has none).
//  7. After a failed write the pager is in error: it reads, and refuses to write or flush. The
//  first
//     caller that is refused gets the error itself, later ones get kBadState.
//  8. A block that is being written is neither evicted nor pinned for writing.
//  9. No transfer, checksum or (de)compression happens under the pager's lock.
// 10. A pin that fails leaves nothing behind: no frame, no pin, no dirty block.
// 11. While a block is read, and from its first store until it is written, the blocks that are
// needed
//     to code it (Backend::context) are in frames, too.
//
// States of a frame (engine/paging/frame.h)
//
//   vacant --> claimed --> reading --> clean --> dirty --> writing --> clean
//                 |           |                    |           |
//                 |           |                    +--> stuck <+  a write failed
//                 +-----------+------> detached <--+
//
//   A pin that finds the block absent claims a frame: under Access::kWrite the frame becomes dirty,
//   otherwise it is read. A clean frame that nobody pins may be evicted: then it is vacant. A dirty
//   one must be written before. When the last pin of a dirty block ends, its write is queued at
//   once; for a session of EvictionPolicy::kClock, and without I/O threads, the block is written
//   when its frame is needed. Who pins a block that is being written reads what is written. A block
//   that is pinned for writing while flush() writes it is dirty again afterwards. A stuck block is
//   the only copy of its bytes and stays. A detached frame is vacant when its last pin ends.
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
