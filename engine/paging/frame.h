// A frame: memory for one block, and the links of the lists that contain the frame. The links are
// members of the frame, so moving a frame between lists allocates no memory. So the end of a pin or
// of a transfer cannot fail.
#pragma once

#include <array>
#include <atomic>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/set.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>

#include "paging/io_queue.h"
#include "paging/pin_count.h"
#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using ListLink =
    boost::intrusive::list_member_hook<boost::intrusive::link_mode<boost::intrusive::auto_unlink>>;
using OrderLink =
    boost::intrusive::set_member_hook<boost::intrusive::link_mode<boost::intrusive::auto_unlink>>;

struct Frame;

/// The blocks that a transfer of another block needs.
struct FrameContext {
  std::array<Frame*, kMostContextBlocks> blocks{};  ///< pinned until the block is read or written
  std::array<std::span<const std::byte>, kMostContextBlocks> bytes;  ///< for Transfer::context
};

struct Frame {
  /// plait/extend/pager.h has a diagram. FrameTable::find() finds frames in all states except
  /// kVacant and kDetached.
  enum class State : std::uint8_t {
    kVacant,   ///< contains no block
    kClaimed,  ///< reserved for a block that is not read yet; the call that will read it has a pin
    kReading,  ///< the backend reads the block, for a pin or for a prefetch
    kClean,    ///< has the same bytes as the backend
    kDirty,    ///< changed and not yet written
    kWriting,  ///< the backend writes the block; it may be pinned for reading
    kWritingHeld,  ///< the same, but it is pinned for writing, so it may change again
    kStuck,        ///< dirty after a failed write: the only copy, which is not evicted
    kDetached,     ///< its read failed, or it was abandoned; vacant when its last pin ends
  };
  /// The members of a frame that are valid while it contains a block.
  struct Content {
    const LevelFile* level = nullptr;
    std::uint64_t block = 0;
    std::byte* memory = nullptr;
    std::uint64_t block_bytes = 0, frame_bytes = 0;
    State state = State::kVacant;
    bool addressed = false;     ///< its memory belongs to the backend
    bool announced = false;     ///< prefetched by its session, and not pinned since
    bool overwritten = false;   ///< the call that took the frame will fill it without a read
    std::uint32_t writers = 0;  ///< pins for writing
    /// The block ends before this edge; or, if it was last used as context, the block that needed
    /// it does.
    EdgeId order = 0;
    std::uint64_t kept_edges = 0;     ///< how far behind `order` a window keeps the block
    EdgeId needed_until = kNoId;      ///< the last edge that needs it: paging/needed_until.h
    SessionState* session = nullptr;  ///< the last one that used it, if that is still open
    std::size_t context_count = 0;    ///< blocks of Frame::context
    std::exception_ptr read_error;    ///< for the call that asked for the read
    std::chrono::steady_clock::time_point read_began;
  };

  // What a pin without the lock reads, in a cache line that nothing else changes.
  alignas(64) PinCount pins;                     ///< with those of frames that have it as context
  std::atomic<SessionState*> open_to = nullptr;  ///< whose threads may pin it while it is open

  alignas(64) Content content;
  std::uint32_t index = 0;
  QueuedTransfer transfer;
  /// Of 1.5 KiB. A frame has it from its first block on that needs others, because frames of small
  /// blocks are many.
  std::unique_ptr<FrameContext> context;
  ListLink in_list;    ///< of vacant frames; of a clock; or of frames that ended sessions left
  OrderLink in_order;  ///< of WindowEviction, or of prefetched frames
  OrderLink in_need;   ///< of WindowEviction too, if it is a context block
  ListLink to_write;   ///< of dirty frames whose write is queued
  bool waits_for_run = false;  ///< in that list, until the rest of its run is queued too
  ListLink in_session;         ///< of content.session
};

/// Whether the block's bytes are in the frame.
constexpr bool is_filled(Frame::State state) {
  return state >= Frame::State::kClean && state <= Frame::State::kStuck;
}
constexpr bool is_being_written(Frame::State state) {
  return state == Frame::State::kWriting || state == Frame::State::kWritingHeld;
}
constexpr bool is_on_its_way(Frame::State state) {
  return state == Frame::State::kReading || is_being_written(state);
}

/// Changes a frame's state. No other code does. Closes the frame, unless a block in that state may
/// be pinned for reading and nothing is to be done when its pin ends but to place it. REQUIRES:
/// may_become(frame.content.state, state).
void become(Frame& frame, Frame::State state) noexcept;
/// Whether the diagram has this arrow.
bool may_become(Frame::State from, Frame::State to) noexcept;
/// Marks a block as context of others. A window keeps it for a multiple of its own length, from the
/// last block on that needed it.
void keep_as_context(Frame& frame, EdgeId needed_until) noexcept;

template <ListLink Frame::*Link>
using FrameListBy =
    boost::intrusive::list<Frame, boost::intrusive::member_hook<Frame, ListLink, Link>,
                           boost::intrusive::constant_time_size<false>>;
using FrameList = FrameListBy<&Frame::in_list>;
using WriteList = FrameListBy<&Frame::to_write>;
using SessionFrames = FrameListBy<&Frame::in_session>;

struct EarlierEdge {
  bool operator()(const Frame& a, const Frame& b) const {
    if (a.content.order != b.content.order) return a.content.order < b.content.order;
    return a.index < b.index;
  }
};

/// Where a window is when it loses a frame, if it has room so long.
inline std::uint64_t leaves_at(const Frame& frame) noexcept {
  return frame.content.order + frame.content.kept_edges;
}

/// The order in which a window loses its frames.
struct LeavesEarlier {
  bool operator()(const Frame& a, const Frame& b) const {
    const std::uint64_t of_a = leaves_at(a), of_b = leaves_at(b);
    return of_a != of_b ? of_a < of_b : a.index < b.index;
  }
};

/// The order in which context blocks are needed for the last time.
struct NeededShorter {
  bool operator()(const Frame& a, const Frame& b) const {
    const EdgeId of_a = a.content.needed_until, of_b = b.content.needed_until;
    return of_a != of_b ? of_a < of_b : a.index < b.index;
  }
};

template <class Compare>
using FrameSet =
    boost::intrusive::set<Frame, boost::intrusive::member_hook<Frame, OrderLink, &Frame::in_order>,
                          boost::intrusive::compare<Compare>,
                          boost::intrusive::constant_time_size<false>>;
using FrameOrder = FrameSet<EarlierEdge>;
using FrameWindow = FrameSet<LeavesEarlier>;
using FramesByNeed =
    boost::intrusive::set<Frame, boost::intrusive::member_hook<Frame, OrderLink, &Frame::in_need>,
                          boost::intrusive::compare<NeededShorter>,
                          boost::intrusive::constant_time_size<false>>;

PLAIT_END_NAMESPACE
