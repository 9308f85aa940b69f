// plait/extend/session.h: sessions pin blocks. A reader, a sweep or a walk over patches opens a
// session on a pager. Every session has its own eviction policy, share of the budget and
// statistics, so that one session's sweep does not evict the blocks that another session's walk
// needs. See docs/paging.md.
//
// A frame belongs to the session that used it last. If a session needs a frame and none is free,
// the pager takes
//  1. a frame of a session that has ended, the oldest first;
//  2. otherwise a frame of the session that is furthest over its share; the policy of that session
//     chooses the frame. For this comparison, the caller's session counts with the frame that it
//     asks for.
// If all frames are busy, the caller waits until one is free: a transfer ends, or another session
// unpins a block. But the call fails with kBudget, instead of waiting, if no transfer is under way
// and every pin of another session
//  - is of a session in which a thread waits for a frame, or
//  - was made by a thread that waits for a frame, or by the caller's own thread.
// Example: two sessions hold half of the budget each, and both ask for more. The first one waits,
// and the second one gets kBudget. When the second one ends its pins, the first one continues.
// The caller never waits for pins of its own session, because the thread that would end them may be
// waiting for the caller.
//
// THREADS: A THREAD THAT HOLDS PINS WHICH ANOTHER THREAD MAY WAIT FOR MUST NOT ITSELF WAIT, OUTSIDE
// THE PAGER, FOR THAT OTHER THREAD. The pager cannot see such a wait. docs/threads.md has examples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/detail/level_file.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class EvictionPolicy : std::uint8_t {
  /// Evicts the block whose last edge comes first in layout order. So the windows of all levels
  /// cover the same edges and move forward together (the paper's circular buffer). A block from
  /// which others are decoded stays longer, until the window has passed the last block that needs
  /// it (docs/paging.md). Writes a dirty block as soon as it is unpinned. A session of this policy
  /// is for one pass over the edges.
  kLayoutOrder,
  /// Second chance, for random reads. Writes a dirty block when it is evicted.
  kClock,
};

/// Options of StoreAccess::open_session().
struct SessionOptions {
  EvictionPolicy policy = EvictionPolicy::kLayoutOrder;
  /// The part of the budget that the session can rely on. It is no limit: a session takes more
  /// while no other session needs it. 0: all sessions with 0 get equal parts of the rest of the
  /// budget.
  std::uint64_t share_bytes = 0;
  /// The part of the share that prefetch() does not use, so that it is free for pins.
  std::uint64_t window_bytes = 0;
  /// The session overwrites blocks and does not come back to them. On a backend with the trait
  /// `in_page_cache`, a block that it has written then leaves its frame when the session has 32 MiB
  /// of frames, however large the budget is: memory that is touched for the first time costs more
  /// than writing the block. Other sessions read such a block from the page cache. Test:
  /// session_test.cpp.
  bool only_writes = false;
};

/// Counts of what the pager did for a session, or for all sessions of a store.
struct PagingStatistics {
  std::uint64_t blocks_read = 0, bytes_read = 0;        ///< raw bytes, through the backend
  std::uint64_t blocks_written = 0, bytes_written = 0;  ///< raw bytes
  std::uint64_t blocks_prefetched = 0, blocks_evicted = 0;
  std::uint64_t read_waits = 0, read_wait_ns = 0;    ///< callers that waited for a block
  std::uint64_t write_waits = 0, write_wait_ns = 0;  ///< callers that waited for a write
  std::uint64_t peak_frame_bytes = 0;                ///< the most bytes of frames at one moment
};

class SessionState;
class SessionCaller;
struct Frame;

/// A pin: it keeps a block in its frame. Move-only. The destructor ends the pin. A pin may outlive
/// its session (no caller waits for such a pin), but not the pager. Threads: one at a time
/// (docs/threads.md).
class PinnedBlock {
 public:
  PinnedBlock() = default;
  ~PinnedBlock() { release(); }
  PinnedBlock(PinnedBlock&& other) noexcept;
  PinnedBlock& operator=(PinnedBlock&& other) noexcept;
  void release() noexcept { end(false); }
  /// The same for many pins of one pager, faster than one after another.
  static void release_all(std::span<PinnedBlock> pinned) noexcept;
  /// Ends a pin for writing whose changes are incomplete. When the last pin of the block ends, the
  /// pager drops the block without writing it, and the level stays unfinished. For a pin for
  /// reading this is release().
  void abandon() noexcept { end(true); }
  /// The block's records, at one address until the pin ends. REQUIRES: the caller does not change a
  /// block that it pinned for reading.
  std::span<std::byte> bytes() const noexcept { return bytes_; }
  explicit operator bool() const noexcept { return session_ != nullptr; }

 private:
  friend class Session;
  PinnedBlock(SessionState& session, SessionCaller& caller, Frame& frame,
              LevelFile* written) noexcept;
  void end(bool abandoned) noexcept;

  SessionState* session_ = nullptr;
  SessionCaller* caller_ = nullptr;
  Frame* frame_ = nullptr;
  LevelFile* written_ = nullptr;  ///< nullptr if pinned for reading
  std::span<std::byte> bytes_;
};

/// A block to pin, and how the caller will use it.
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

/// Move-only. The destructor ends the session. Must not outlive the pager. Several sessions may be
/// open at once. Threads: shared (docs/threads.md). A pin waits only for the transfers that
/// it needs, and for free frames.
class Session {
 public:
  /// A session that is not open. It may only be assigned to.
  Session() = default;
  ~Session() { end(); }
  Session(Session&& other) noexcept;
  Session& operator=(Session&& other) noexcept;

  /// Pins a block. Errors: kBudget (see above; the message names the needed and the available
  /// bytes); kIo, kNoSpace, kCorruption from the backend; kBadState for writing to a level that was
  /// opened for reading; kOutOfMemory. After a failed write, the first pin for writing that is
  /// refused gets the error of that write, and later ones get kBadState.
  PinnedBlock pin(LevelFile& level, std::uint64_t block, Access access);
  /// Pins a block for reading.
  PinnedBlock pin(const LevelFile& level, std::uint64_t block);

  /// Ends the pins in `pinned`, then pins the block of requests[i] in pinned[i] for each i. After
  /// an error no block is pinned. The call begins all reads before it waits for the first one.
  /// `requests` may name a block several times. REQUIRES: pinned.size() == requests.size(). Errors:
  /// as pin(); if several reads fail, the error of one of them.
  void pin_many(std::span<const BlockRequest> requests, std::span<PinnedBlock> pinned);

  /// Begins to read a block that the caller will soon pin for reading. It does so only if a frame
  /// is free, or if it can evict a clean block that is not itself prefetched and still unpinned. A
  /// prefetched block stays resident until it is pinned; the pager evicts it earlier only if no
  /// other frame can be freed. Returns false if the read cannot begin now: the caller may try again
  /// after the next pin. Without I/O threads, prefetch() reads nothing. In a session of
  /// EvictionPolicy::kLayoutOrder it also reads the blocks behind this one that can move in the
  /// same call, because the pass will come to them.
  bool prefetch(const LevelFile& level, std::uint64_t block) noexcept;

  /// The same for a block that is absent. A block in memory is only said to be in use, so it may be
  /// evicted before it is pinned, and threads that ask for the same blocks mostly take no lock. The
  /// caller will pin `count` blocks from `block` on, so those of them that can move in the same
  /// call are read too.
  bool read_ahead(const LevelFile& level, std::uint64_t block, std::uint64_t count = 1) noexcept;

  /// Blocks that were prefetched and not pinned since can be evicted as others, and reads that wait
  /// for an I/O thread are not begun.
  void end_prefetch() noexcept;

  /// The statistics of this session alone.
  PagingStatistics statistics() const;
  explicit operator bool() const noexcept { return state_ != nullptr; }

 private:
  friend class Pager;
  explicit Session(SessionState& state) : state_(&state) {}
  PinnedBlock pin_one(const BlockRequest& request);
  void end() noexcept;
  SessionState* state_ = nullptr;
};

PLAIT_END_NAMESPACE
