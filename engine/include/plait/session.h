// plait/session.h: what a reader, a sweep or a walk over patches opens on a pager: it pins blocks.
// Every session has an eviction policy, a share of the budget and statistics of its own, so that
// one session's sweep does not throw out what another session's walk needs. See docs/paging.md.
//
// A frame belongs to the session that used it last. Whoever needs a frame while none is free takes
//  1. a frame that an ended session left, the oldest first;
//  2. a frame of the session that is furthest over its share, where the caller's session counts
//     with the frame that it asks for: the policy of that session chooses the frame.
// If all frames are busy, the caller waits for one to come free. It comes free when a transfer
// ends, or when another session unpins it. The caller does not wait but gets kBudget if no transfer
// is under way and every pin of another session
//  - is of a session of which a thread waits for a frame, or
//  - was made by a thread that waits for a frame, or by the caller's own thread.
// So two sessions that hold half the budget each and ask for more do not wait for each other: the
// first one waits, the second one gets kBudget, and when it lets go of its pins the first goes on.
// Pins of the caller's own session are never waited for: whoever would end them may be waiting for
// the caller. REQUIRES: nobody waits, outside the pager, for a thread that pins, while holding pins
// that this thread may have to wait for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/level_file.h"

namespace plait {

enum class EvictionPolicy : std::uint8_t {
  /// Evicts the block whose last edge lies furthest behind: the windows of all levels cover the
  /// same edge range and move forward together (the paper's circular buffer). Writes a dirty block
  /// as soon as it is unpinned.
  kWindow,
  /// Second chance, for random reads. Writes a dirty block when it is evicted.
  kClock,
};

struct SessionOptions {
  EvictionPolicy policy = EvictionPolicy::kWindow;
  /// The part of the budget that the session counts on. It is no limit: a session takes more while
  /// nobody else needs it. 0: the sessions that say 0 divide equally what the shares of the others
  /// leave.
  std::uint64_t share_bytes = 0;
  /// The part of the share that prefetch() leaves to pins.
  std::uint64_t window_bytes = 0;
};

struct PagingStatistics {
  std::uint64_t blocks_read = 0, bytes_read = 0;        ///< raw bytes, by way of the backend
  std::uint64_t blocks_written = 0, bytes_written = 0;  ///< raw bytes
  std::uint64_t blocks_prefetched = 0, blocks_evicted = 0;
  std::uint64_t read_waits = 0, read_wait_ns = 0;    ///< callers that waited for a block
  std::uint64_t write_waits = 0, write_wait_ns = 0;  ///< callers that waited for a write
  std::uint64_t peak_frame_bytes = 0;                ///< of the frames that it had at once
};

class SessionState;
struct Frame;

/// Holds a block in its frame. Move-only; ends when destroyed. It may outlive its session (nobody
/// waits for such a pin), but not the pager. One thread at a time; not only the one that pinned the
/// block.
class PinnedBlock {
 public:
  PinnedBlock() = default;
  ~PinnedBlock() { release(); }
  PinnedBlock(PinnedBlock&& other) noexcept;
  PinnedBlock& operator=(PinnedBlock&& other) noexcept;
  void release() noexcept { end(false); }
  /// Ends the pin, too; what was stored into the block is not whole. With its last pin the block
  /// leaves the memory without being written, and its level stays unfinished. A pin for reading is
  /// only released.
  void abandon() noexcept { end(true); }
  /// The block's records, at one address until the pin ends. REQUIRES: nothing is stored into a
  /// block that was pinned for reading.
  std::span<std::byte> bytes() const noexcept { return bytes_; }
  explicit operator bool() const noexcept { return session_ != nullptr; }

 private:
  friend class Session;
  PinnedBlock(SessionState& session, std::uint32_t caller, Frame& frame,
              LevelFile* written) noexcept;
  void end(bool abandoned) noexcept;

  SessionState* session_ = nullptr;
  Frame* frame_ = nullptr;
  LevelFile* written_ = nullptr;  ///< nullptr: pinned for reading
  std::span<std::byte> bytes_;
  std::uint32_t caller_ = 0;
};

/// A block and what it is wanted for.
class BlockRequest {
 public:
  BlockRequest(const LevelFile& level, std::uint64_t block) : level_(&level), block_(block) {}
  BlockRequest(LevelFile& level, std::uint64_t block, Access access)
      : level_(&level),
        written_(access == Access::kRead ? nullptr : &level),
        block_(block),
        access_(access) {}
  const LevelFile& level() const { return *level_; }
  LevelFile* written() const { return written_; }  ///< the same level, or nullptr for reading
  std::uint64_t block() const { return block_; }
  Access access() const { return access_; }

 private:
  const LevelFile* level_;
  LevelFile* written_ = nullptr;
  std::uint64_t block_;
  Access access_ = Access::kRead;
};

/// Move-only; ends when destroyed. Must not outlive the pager. Several sessions may be open at
/// once, and each may be called from several threads. A pin waits for the transfers that it needs,
/// and for room, and for nothing else.
class Session {
 public:
  /// Not open: may only be assigned to.
  Session() = default;
  ~Session() { end(); }
  Session(Session&& other) noexcept;
  Session& operator=(Session&& other) noexcept;

  /// Errors: kBudget with the bytes that are needed and those there are, see above; kIo, kNoSpace,
  /// kCorruption from the backend; kBadState for writing to a level that was opened for reading;
  /// kOutOfMemory; after a failed write that write's error, once, and kBadState from then on.
  PinnedBlock pin(LevelFile& level, std::uint64_t block, Access access);
  /// For reading.
  PinnedBlock pin(const LevelFile& level, std::uint64_t block);

  /// Pins requests[i] in pinned[i], whose former pin ends: all of them, or none after an error.
  /// All reads begin before the first of them is waited for. The same block may be asked for
  /// several times. REQUIRES: pinned.size() == requests.size(). Errors: as pin(); if several reads
  /// fail, the error of one of them.
  void pin_many(std::span<const BlockRequest> requests, std::span<PinnedBlock> pinned);

  /// The block will be read soon: begins to read it if a frame is free or can be had without
  /// writing and without taking one from a block announced before, and keeps it until it was pinned
  /// or nothing else makes room. False: not now, ask again after the next pin. Without I/O threads
  /// nothing is read ahead.
  bool prefetch(const LevelFile& level, std::uint64_t block) noexcept;

  /// Of this session alone.
  PagingStatistics statistics() const;
  explicit operator bool() const noexcept { return state_ != nullptr; }

 private:
  friend class Pager;
  explicit Session(SessionState& state) : state_(&state) {}
  PinnedBlock pin_one(const BlockRequest& request);
  void end() noexcept;
  SessionState* state_ = nullptr;
};

}  // namespace plait
