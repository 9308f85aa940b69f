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
  /// The frame to evict next, or nullptr. The frame stays in the policy until it is unlinked.
  virtual Frame* victim() noexcept = 0;
};

/// EvictionPolicy::kLayoutOrder: evicts the block whose last edge comes first in layout order. All
/// levels have the same edge order, so the windows of all levels cover the same edges, and no level
/// needs a share of its own. A block that was needed as context counts with the place of the
/// block that needed it, and stays for a multiple of its own number of edges after that: its
/// neighbours may lie far away in layout order, and reading it again costs as much as decoding all
/// that it needs.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override { frames_.insert(frame); }
  Frame* victim() noexcept override { return frames_.empty() ? nullptr : &*frames_.begin(); }

 private:
  FrameWindow frames_;
};

/// EvictionPolicy::kClock (second chance): a frame that was pinned again since the hand last passed
/// it is not evicted at the next pass. The first frame of the list is the next one that the hand
/// passes. A frame that the hand passes moves to the end.
class ClockEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override {
    frame.content.referenced = true;
    frames_.push_back(frame);
  }
  Frame* victim() noexcept override {
    if (frames_.empty()) return nullptr;
    while (frames_.front().content.referenced) {
      frames_.front().content.referenced = false;
      frames_.splice(frames_.end(), frames_, frames_.begin());
    }
    return &frames_.front();
  }

 private:
  FrameList frames_;
};

PLAIT_END_NAMESPACE
