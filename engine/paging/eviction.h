// Which unpinned frame of a session goes next. A frame leaves by its own links.
#pragma once

#include "paging/frame.h"

namespace plait {

/// The frames of a session that may be evicted. One thread at a time (the pager's lock).
class Eviction {
 public:
  virtual ~Eviction() = default;
  /// The frame holds no pin any more; its block ends before edge `content.order`.
  virtual void insert(Frame& frame) noexcept = 0;
  /// The next to go, or nullptr; it stays until it is unlinked.
  virtual Frame* victim() noexcept = 0;
};

/// Window: the block that ends furthest behind. Since all levels share the edge order, their
/// windows cover the same edge range without any level being told its share.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override { frames_.insert(frame); }
  Frame* victim() noexcept override { return frames_.empty() ? nullptr : &*frames_.begin(); }

 private:
  FrameOrder frames_;
};

/// Clock: a frame that came back since the hand last passed it is spared once. The hand stands
/// before the first frame; what it passes goes to the end.
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

}  // namespace plait
