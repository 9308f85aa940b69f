// A frame, and the lists that frames stand in. The links are part of the frame: to move one from
// list to list allocates nothing, so that what ends a pin or a transfer cannot fail.
#pragma once

#include <boost/intrusive/list.hpp>
#include <boost/intrusive/set.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>

#include "paging/io_queue.h"
#include "plait/pager.h"

namespace plait {

struct Frame {
  enum class State : std::uint8_t {
    kVacant,    ///< holds no block
    kReading,   ///< for a pin, or ahead of one
    kResident,  ///< nothing is on its way
    kWriting,
    kLeaving,  ///< evicted; its backend has not been told
  };
  /// Where a resident frame stands that nobody pins.
  enum class Standing : std::uint8_t {
    kNowhere,    ///< pinned; or its write failed, and it is the only copy
    kEvictable,  ///< in its session's eviction policy
    kLeft,       ///< left by a session that ended
    kAhead,      ///< was announced, and goes when nothing else makes room
    kToWrite,    ///< dirty, and will be written
  };
  /// What a frame has while it holds a block.
  struct Content {
    const LevelFile* level = nullptr;
    std::uint64_t block = 0;
    std::byte* memory = nullptr;
    std::uint64_t block_bytes = 0, frame_bytes = 0;
    std::uint32_t pins = 0;
    SessionState* session = nullptr;  ///< the last that used it, while that is open
    EdgeId order = 0;                 ///< among the frames of its standing
    State state = State::kVacant;
    Standing standing = Standing::kNowhere;
    bool addressed = false;         ///< its memory is the backend's own
    bool dirty = false;             ///< stored into since it came in, or since its write began
    bool announced = false;         ///< and not pinned since
    bool abandoned = false;         ///< is dropped with its last pin
    bool referenced = false;        ///< the clock's
    std::exception_ptr read_error;  ///< for the one that pinned it to read it
  };

  Content content;
  std::uint32_t index = 0;
  QueuedTransfer transfer;
  boost::intrusive::list_member_hook<> in_queue;
  boost::intrusive::set_member_hook<> in_order;
  boost::intrusive::list_member_hook<> in_session;
};

using SessionFrames = boost::intrusive::list<
    Frame,
    boost::intrusive::member_hook<Frame, boost::intrusive::list_member_hook<>, &Frame::in_session>,
    boost::intrusive::constant_time_size<false>>;

using FrameQueue = boost::intrusive::list<
    Frame,
    boost::intrusive::member_hook<Frame, boost::intrusive::list_member_hook<>, &Frame::in_queue>,
    boost::intrusive::constant_time_size<false>>;

struct EarlierEdge {
  bool operator()(const Frame& a, const Frame& b) const {
    if (a.content.order != b.content.order) return a.content.order < b.content.order;
    return a.index < b.index;
  }
};

using FrameOrder = boost::intrusive::set<
    Frame,
    boost::intrusive::member_hook<Frame, boost::intrusive::set_member_hook<>, &Frame::in_order>,
    boost::intrusive::compare<EarlierEdge>, boost::intrusive::constant_time_size<false>>;

}  // namespace plait
