// Eviction policies: which unpinned frame of a session the pager evicts next. To remove a frame
// from a policy, unlink the frame's own links.
#pragma once

#include "paging/frame.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The frames of a session that may be evicted. The pager's lock protects it.
class Eviction {
 public:
  virtual ~Eviction() = default;
  /// Adds a frame that has no pin any more. Its place is `content.order`, and
  /// `content.kept_edges` behind that.
  virtual void insert(Frame& frame) noexcept = 0;
  /// The frame to evict next if somebody wants a frame of `wanted_bytes` (0: of no special size),
  /// or nullptr. It has no pins and is closed, so it stays without pins while the pager's lock is
  /// held. It stays in the policy until it is unlinked. Frames that were pinned without the lock
  /// leave the policy; they come back when their last pin ends.
  virtual Frame* victim(std::uint64_t wanted_bytes) noexcept = 0;
};

/// EvictionPolicy::kLayoutOrder: evicts the block whose last edge comes first in layout order. All
/// levels have the same edge order, so the windows of all levels cover the same edges, and no level
/// needs a share of its own. A context block is ordered by the block that needed it last, plus
/// a multiple of its own length (paging/frame.cpp): its neighbours may lie far away in layout
/// order, and reading it again costs as much as decoding all that it needs.
///
/// Among the first frames, one of the wanted size goes first: its memory serves the next block as
/// it is, where the system would clear the pages of another size.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override { frames_.insert(frame); }
  Frame* victim(std::uint64_t wanted_bytes) noexcept override {
    while (!frames_.empty()) {
      Frame& next = first_of(wanted_bytes);
      if (next.pins.claim()) return &next;
      next.in_order.unlink();
    }
    return nullptr;
  }

 private:
  static constexpr int kFirstFrames = 32;

  /// REQUIRES: there is a frame.
  Frame& first_of(std::uint64_t wanted_bytes) noexcept {
    auto frame = frames_.begin();
    for (int i = 0; i < kFirstFrames && frame != frames_.end(); ++i, ++frame)
      if (frame->content.frame_bytes == wanted_bytes) return *frame;
    return *frames_.begin();
  }

  FrameWindow frames_;
};

/// EvictionPolicy::kClock (second chance): a frame that was pinned again since the hand last passed
/// it is not evicted at the next pass. The first frame of the list is the next one that the hand
/// passes. A frame that the hand passes moves to the end. The hand goes round once at most, because
/// other threads may pin frames as fast as it passes them.
class ClockEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override {
    frame.pins.set_used();
    frames_.push_back(frame);
  }
  Frame* victim(std::uint64_t) noexcept override {
    const Frame* first_passed = nullptr;
    while (!frames_.empty()) {
      Frame& next = frames_.front();
      const bool was_passed = &next == first_passed;
      if (!was_passed && next.pins.take_used()) {
        if (!first_passed) first_passed = &next;
        frames_.splice(frames_.end(), frames_, frames_.begin());
        continue;
      }
      if (next.pins.claim()) return &next;
      if (was_passed) first_passed = nullptr;
      next.in_list.unlink();
    }
    return nullptr;
  }

 private:
  FrameList frames_;
};

PLAIT_END_NAMESPACE
