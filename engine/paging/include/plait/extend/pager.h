// plait/extend/pager.h: the pager decides which blocks are in memory. See docs/paging.md.
//
// Invariants
//  1. The frames together, pinned or not, in transfer or not, never take more than the budget minus
//     the bytes that set_aside() reserves and those that a LentMemory has.
//  2. A pinned block stays at one address until its last pin ends.
//  3. A block is in at most one frame. So all pins of a block see the same bytes, however they were
//     pinned. A frame is memory of the pager. For a level in memory, and for a mapped level that
//     was opened for reading, the frame is the backend's own memory at the block's address. After a
//     failed read and after abandon(), a frame is detached: existing pins still have its memory,
//     but the block is absent.
//  4. A dirty block that was not abandoned leaves its frame only when the backend has written it.
//  5. The pager never reads a block from its backend to pin it for Access::kOverwrite.
//  6. Each block is verified against its checksum when it is read (except levels in memory, which
//     have no checksums).
//  7. After a failed write the pager is in error: it still reads, but refuses to write or flush.
//     The first caller that it refuses gets the error of the write, later callers get kBadState.
//  8. A block that is being written is not evicted, and no pin for writing begins.
//  9. No transfer, checksum or (de)compression runs while the pager's lock is held.
//  10. A failed pin changes nothing: it leaves no frame, no pin and no dirty block.
//  11. The blocks that are needed to encode or decode a block (Backend::context) are in frames
//      too, while the block is read, and from its first change until it is written.
//
// States of a frame (engine/paging/frame.h)
//
//   vacant --> claimed --> reading --> clean --> dirty --> writing --> clean
//                 |           |                    |           |
//                 |           |                    +--> stuck <+  a write failed
//                 +-----------+------> detached <--+
//
//   A pin of an absent block claims a frame. With Access::kOverwrite the frame becomes dirty;
//   otherwise the pager reads the block into it. The pager may evict a clean frame that has no pin;
//   the frame is then vacant. It must write a dirty frame first. When the last pin of a dirty block
//   ends, the pager queues the write at once. In a session of EvictionPolicy::kClock, and without
//   I/O threads, it writes the block when it needs the frame. A block that is being written can be
//   pinned for reading. A block that is pinned for writing while flush() writes it is dirty again
//   afterwards. A stuck block is the only copy of its bytes, so the pager does not evict it. A
//   detached frame becomes vacant when its last pin ends.
#pragma once

#include <cstdint>
#include <memory>

#include "plait/detail/namespace.h"
#include "plait/extend/session.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

/// Threads: shared (docs/threads.md). Must outlive its sessions and their pins.
class Pager {
 public:
  /// The number of reads, and of writes, that may be in flight: enough to keep a disk busy.
  static constexpr std::uint32_t kInFlight = 8;

  /// `io_threads` threads prefetch blocks and write dirty ones. With 0, each transfer runs in the
  /// thread that needs it.
  /// `events` hears of evictions and slow reads.
  explicit Pager(std::uint64_t budget_bytes, int io_threads = 1, StoreEvents events = {});
  ~Pager();
  Pager(const Pager&) = delete;
  Pager& operator=(const Pager&) = delete;

  /// The level must outlive the pager or be detached first. Errors: kOutOfMemory, also if a thread
  /// cannot be started.
  void attach(LevelFile& level);
  /// Drops all blocks of the level. Changes in dirty blocks are lost, so call flush() first. Waits
  /// for transfers in flight. REQUIRES: no block of the level is pinned, and no other thread calls
  /// this pager at the same time.
  void detach(LevelFile& level);

  /// Errors: kOutOfMemory.
  Session open_session(const SessionOptions& options = {});

  /// Writes all dirty blocks by their backends. The blocks stay resident. Waits for transfers in
  /// flight. REQUIRES: no thread changes a pinned block at the same time. Errors: as Session::pin()
  /// for writing.
  void flush();
  /// Waits until no write is in flight or queued. Blocks that are dirty stay dirty. Never throws.
  void wait_for_writes() noexcept;
  /// After this call the pager writes no block: pins for writing and flush() fail with kBadState.
  void refuse_writes() noexcept;
  /// Drops every block that is not pinned, without writing it. For a store that is discarded.
  void discard() noexcept;

  /// Reserves `bytes` of the budget for other memory than frames. Frames that are in use stay in
  /// use.
  void set_aside(std::uint64_t bytes) noexcept;
  /// Lends `bytes` more of the budget to other memory than frames, or fewer if it is negative: see
  /// LentMemory.
  void lend(std::int64_t bytes) noexcept;
  std::uint64_t budget_bytes() const noexcept;  ///< the part of the budget that is for frames
  /// The sum over all sessions, open or ended.
  PagingStatistics statistics() const;

  class Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// A part of the budget that a pass has for memory of its own, for as long as this object lives,
/// such as what its threads compute in. Frames that are in use stay in use. The pager must outlive
/// it. Pinned by tests/engine/paging/pager_test.cpp.
class LentMemory {
 public:
  LentMemory(Pager& pager, std::uint64_t bytes) noexcept
      : pager_(pager), bytes_(static_cast<std::int64_t>(bytes)) {
    pager_.lend(bytes_);
  }
  ~LentMemory() { pager_.lend(-bytes_); }
  std::uint64_t bytes() const noexcept { return static_cast<std::uint64_t>(bytes_); }
  LentMemory(const LentMemory&) = delete;
  LentMemory& operator=(const LentMemory&) = delete;

 private:
  Pager& pager_;
  std::int64_t bytes_;
};

PLAIT_END_NAMESPACE
