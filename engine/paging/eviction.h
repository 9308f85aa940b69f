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
  /// The frame to evict next, or nullptr. It has no pins and is closed, so it stays without pins
  /// while the pager's lock is held. It stays in the policy until it is unlinked. Frames that were
  /// pinned without the lock leave the policy; they come back when their last pin ends.
  virtual Frame* victim() noexcept = 0;
};

/// EvictionPolicy::kLayoutOrder: evicts the block whose last edge comes first in layout order. All
/// levels have the same edge order, so the windows of all levels cover the same edges, and no level
/// needs a share of its own. A context block is ordered by the block that needed it last, plus
/// a multiple of its own length (paging/frame.cpp): its neighbours may lie far away in layout
/// order, and reading it again costs as much as decoding all that it needs.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override { frames_.insert(frame); }
  Frame* victim() noexcept override {
    while (!frames_.empty()) {
      Frame& first = *frames_.begin();
      if (first.pins.claim()) return &first;
      first.in_order.unlink();
    }
    return nullptr;
  }

 private:
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
  Frame* victim() noexcept override {
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
