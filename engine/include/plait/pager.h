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
// pinned and resident are clean or dirty. Under EvictionPolicy::kWindow a dirty block whose last
// pin ends is queued for writing at once, and stays resident, clean; without I/O threads and under
// kClock it is written when it is evicted. A block that is being written may be pinned for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/backend.h"

namespace plait {

enum class Access : std::uint8_t {
  kRead,
  kWrite,   ///< all of it will be written: nothing is read
  kUpdate,  ///< read, then written
};

enum class EvictionPolicy : std::uint8_t {
  /// Evicts the block whose last edge lies furthest behind: all levels' windows cover the same
  /// edge range and move forward together (the paper's circular buffer).
  kWindow,
  /// Second chance, for random reads.
  kClock,
};

struct PagingStatistics {
  std::uint64_t blocks_read = 0, bytes_read = 0;        ///< raw bytes, by way of the backend
  std::uint64_t blocks_written = 0, bytes_written = 0;  ///< raw bytes
  std::uint64_t blocks_prefetched = 0, blocks_evicted = 0;
  std::uint64_t read_waits = 0, read_wait_ns = 0;    ///< callers that waited for a block
  std::uint64_t write_waits = 0, write_wait_ns = 0;  ///< callers that waited for a write
  std::uint64_t peak_frame_bytes = 0;
};

/// One level of one attribute, open. Not movable: backend and geometry point into it.
struct LevelFile {
  LevelGeometry geometry;
  BlockTable table;
  std::filesystem::path path;
  std::unique_ptr<Backend> backend;
  BackendTraits traits;
  std::string pipeline = "none";     ///< how the backend encodes blocks
  bool writable = true;              ///< false: opened for reading
  std::uint32_t pager_slot = kNoId;  ///< the pager's; nobody else's

  /// Whether no pass that writes to it is under way or was left half done: otherwise the level must
  /// not be committed. While nobody else works on the level.
  bool is_finished() const noexcept { return !left_unfinished && passes_under_way == 0; }
  bool left_unfinished = false;        ///< by UnfinishedLevels, PinnedBlock::abandon(), patches
  std::uint32_t passes_under_way = 0;  ///< counted by UnfinishedLevels
};

/// What a pass, or several that count only together, write to: from add() to finish() the levels
/// are unfinished, and if finish() is never called, because of an error say, they stay so until a
/// pass has overwritten them whole. The executors have one for each pass; who changes a level with
/// several passes, or by pins, keeps one around them. One thread.
class UnfinishedLevels {
 public:
  UnfinishedLevels() = default;
  ~UnfinishedLevels();
  UnfinishedLevels(const UnfinishedLevels&) = delete;
  UnfinishedLevels& operator=(const UnfinishedLevels&) = delete;
  /// `access` is what the pass does to the whole level; kRead: nothing happens. The level outlives
  /// this object.
  void add(LevelFile& level, Access access);
  void finish() noexcept;

 private:
  struct Added {
    LevelFile* level;
    Access access;
  };
  std::vector<Added> levels_;
};

class Pager;

/// Holds a block in its frame. Move-only; ends when destroyed. Must not outlive the pager.
class PinnedBlock {
 public:
  PinnedBlock() = default;
  ~PinnedBlock() { release(); }
  PinnedBlock(PinnedBlock&& other) noexcept;
  PinnedBlock& operator=(PinnedBlock&& other) noexcept;
  void release() noexcept;
  /// Ends the pin, too; what was stored into the block is not whole. With its last pin the block
  /// leaves the memory without being written, and its level stays unfinished. A pin for reading is
  /// only released.
  void abandon() noexcept;
  std::span<std::byte> bytes() const noexcept { return bytes_; }
  explicit operator bool() const noexcept { return pager_ != nullptr; }

 private:
  friend class Pager;
  Pager* pager_ = nullptr;
  std::uint32_t frame_ = kNoId;
  bool writes_ = false;
  std::span<std::byte> bytes_;
};

/// Safe from several threads; a pin waits for the transfers that it needs and for no others.
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

  /// Waits for what is on its way if all frames are taken. Errors: kBudget if they are all pinned;
  /// kIo, kNoSpace, kCorruption from the backend; kBadState for writing to a level that was opened
  /// for reading; kOutOfMemory; after a failed write that write's error, once, and kBadState from
  /// then on.
  PinnedBlock pin(LevelFile& level, std::uint64_t block, Access access);

  /// The block will be read soon: begins to read it if a frame is free or can be had without
  /// writing and without taking one from a block announced before, and keeps it until it was pinned
  /// or nothing else makes room. False: not now, ask again after the next pin. Without I/O threads
  /// nothing is read ahead.
  bool prefetch(LevelFile& level, std::uint64_t block) noexcept;

  /// Hands all dirty blocks to their backends; they stay resident. Waits for what is in flight.
  /// REQUIRES: nobody changes a pinned block meanwhile. Errors: as pin() for writing.
  void flush();
  /// From now on nothing is written: pin() for writing and flush() are refused with kBadState.
  void refuse_writes() noexcept;
  /// Forgets every block that is not pinned, without writing: for a store that is thrown away.
  void discard() noexcept;

  /// So much of the budget is not for frames from now on: others hold memory there. Frames that are
  /// taken already are not taken away.
  void set_aside(std::uint64_t bytes) noexcept;
  /// Also begins a new sweep: what is resident and not pinned counts as left behind. Of the budget
  /// `window_bytes` are for pins, and prefetch() leaves them alone.
  void set_policy(EvictionPolicy policy, std::uint64_t window_bytes = 0) noexcept;
  std::uint64_t budget_bytes() const noexcept;  ///< what is for frames
  PagingStatistics statistics() const;

 private:
  friend class PinnedBlock;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plait
