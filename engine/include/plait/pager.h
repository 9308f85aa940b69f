// plait/pager.h: which blocks are in memory. See docs/paging.md.
//
// Invariants
//  1. Bytes of all frames, pinned or not, never exceed the budget.
//  2. A pinned block stays at one address until its last pin ends.
//  3. A block is in at most one frame.
//  4. A dirty block leaves its frame only by way of its backend.
//  5. A block pinned for Access::kWrite is never read from its backend.
//  6. Bytes served are bytes whose checksum was verified since they came in.
//  7. After a failed write the pager is in error: it reads, and refuses to write or flush.
//
// States of a block:  absent --pin--> pinned(n) <--pin/unpin--> resident --evict--> absent
//                     each of pinned and resident is clean or dirty; evicting a dirty one writes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

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
  std::uint64_t waits = 0, wait_ns = 0;  ///< pins that had to wait for a read or a write
  std::uint64_t peak_frame_bytes = 0;
};

/// One level of one attribute, open. Not movable: backend and geometry point into it.
struct LevelFile {
  LevelGeometry geometry;
  BlockTable table;
  std::filesystem::path path;
  std::unique_ptr<Backend> backend;
  bool writable = true;              ///< false: opened for reading, a mapping must not be touched
  std::uint32_t pager_slot = kNoId;  ///< the pager's; nobody else's
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
  std::span<std::byte> bytes() const noexcept { return bytes_; }
  explicit operator bool() const noexcept { return pager_ != nullptr; }

 private:
  friend class Pager;
  Pager* pager_ = nullptr;
  std::uint32_t frame_ = kNoId;
  std::span<std::byte> bytes_;
};

/// Safe from several threads; a pin that must do I/O holds the others up.
class Pager {
 public:
  explicit Pager(std::uint64_t budget_bytes);
  ~Pager();
  Pager(const Pager&) = delete;
  Pager& operator=(const Pager&) = delete;

  /// The level must outlive the pager or be detached.
  void attach(LevelFile& level);
  /// Drops all its blocks; dirty ones are lost, so flush first. REQUIRES: none is pinned.
  void detach(LevelFile& level);

  /// Errors: kBudget if no frame can be freed; kIo, kNoSpace, kCorruption from the backend;
  /// kBadState after a failed write.
  PinnedBlock pin(LevelFile& level, std::uint64_t block, Access access);

  /// Tells the backend that these blocks will be read soon.
  void prefetch(LevelFile& level, BlockRange blocks) noexcept;

  /// Hands all dirty blocks to their backends; they stay resident.
  void flush();
  /// Forgets every block that is not pinned, without writing: for a store that is thrown away.
  void discard() noexcept;

  /// Also begins a new sweep: what is resident and not pinned counts as left behind.
  void set_policy(EvictionPolicy policy);
  std::uint64_t budget_bytes() const noexcept;
  PagingStatistics statistics() const;

 private:
  friend class PinnedBlock;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plait
