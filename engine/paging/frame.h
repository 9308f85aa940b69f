// A frame: memory that holds one block, and the links of the lists that it stands in. The links are
// part of the frame: to move a frame from list to list allocates nothing, so that what ends a pin
// or a transfer cannot fail.
#pragma once

#include <array>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/set.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>

#include "paging/io_queue.h"
#include "plait/pager.h"

namespace plait {

using ListLink =
    boost::intrusive::list_member_hook<boost::intrusive::link_mode<boost::intrusive::auto_unlink>>;
using OrderLink =
    boost::intrusive::set_member_hook<boost::intrusive::link_mode<boost::intrusive::auto_unlink>>;

struct Frame {
  /// plait/pager.h has the drawing. Every state but kVacant and kDetached is of a frame that the
  /// table of blocks names.
  enum class State : std::uint8_t {
    kVacant,       ///< holds no block
    kClaimed,      ///< is there for a block whose bytes are not; pinned by who will bring them in
    kReading,      ///< for pins, or ahead of them
    kClean,        ///< as the backend has it
    kDirty,        ///< was stored into
    kWriting,      ///< may be pinned for reading
    kWritingHeld,  ///< the same, but it is pinned for writing and may be dirty again
    kStuck,        ///< dirty, after a write that failed: the only copy, which stays
    kDetached,     ///< its read failed or it was abandoned: goes with its last pin
  };
  /// What a frame has while it holds a block.
  struct Content {
    const LevelFile* level = nullptr;
    std::uint64_t block = 0;
    std::byte* memory = nullptr;
    std::uint64_t block_bytes = 0, frame_bytes = 0;
    State state = State::kVacant;
    bool addressed = false;           ///< its memory is the backend's own
    bool announced = false;           ///< by its session, and not pinned since
    bool referenced = false;          ///< the clock's
    std::uint32_t pins = 0;           ///< with those of frames that have it as context
    std::uint32_t writers = 0;        ///< pins for writing, among these
    EdgeId order = 0;                 ///< the block ends before this edge
    SessionState* session = nullptr;  ///< the last that used it, while that is open
    std::array<Frame*, kMostContextBlocks> context{};  ///< held until it is read or written
    std::size_t context_count = 0;
    std::exception_ptr read_error;  ///< for the one that wanted it read
  };

  Content content;
  std::uint32_t index = 0;
  QueuedTransfer transfer;
  std::array<std::span<const std::byte>, kMostContextBlocks> context_bytes;  ///< the transfer's
  ListLink in_list;     ///< vacant; or may be evicted, in a clock or left by an ended session
  OrderLink in_order;   ///< may be evicted, in a window or announced
  ListLink to_write;    ///< waits for its write to begin
  ListLink in_session;  ///< of content.session
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

/// The only way to change a frame's state. REQUIRES: the drawing has an arrow.
void become(Frame& frame, Frame::State state) noexcept;
/// Whether the drawing has an arrow.
bool may_become(Frame::State from, Frame::State to) noexcept;

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

using FrameOrder =
    boost::intrusive::set<Frame, boost::intrusive::member_hook<Frame, OrderLink, &Frame::in_order>,
                          boost::intrusive::compare<EarlierEdge>,
                          boost::intrusive::constant_time_size<false>>;

}  // namespace plait
