// Which unpinned frame goes next.
#pragma once

#include "paging/frame.h"

namespace plait {

/// The frames of a session that may be evicted. One thread at a time (the pager's lock).
class Eviction {
 public:
  virtual ~Eviction() = default;
  /// The frame holds no pin any more; its block ends before edge `content.order`.
  virtual void insert(Frame& frame) noexcept = 0;
  virtual void erase(Frame& frame) noexcept = 0;
  /// The next to go, or nullptr; it stays until erased.
  virtual Frame* victim() noexcept = 0;
};

/// Window: the block that ends furthest behind. Since all levels share the edge order, their
/// windows cover the same edge range without any level being told its share.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override { frames_.insert(frame); }
  void erase(Frame& frame) noexcept override { frames_.erase(frames_.iterator_to(frame)); }
  Frame* victim() noexcept override { return frames_.empty() ? nullptr : &*frames_.begin(); }

 private:
  FrameOrder frames_;
};

/// Clock: a frame that came back since the hand last passed it is spared once.
class ClockEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override {
    frame.content.referenced = true;
    const auto position = ring_.insert(hand_, frame);
    if (hand_ == ring_.end()) hand_ = position;
  }
  void erase(Frame& frame) noexcept override {
    const auto position = ring_.iterator_to(frame);
    if (hand_ == position) ++hand_;
    ring_.erase(position);
  }
  Frame* victim() noexcept override {
    if (ring_.empty()) return nullptr;
    while (true) {
      if (hand_ == ring_.end()) hand_ = ring_.begin();
      if (!hand_->content.referenced) return &*hand_;
      hand_->content.referenced = false;
      ++hand_;
    }
  }

 private:
  FrameQueue ring_;
  FrameQueue::iterator hand_ = ring_.end();
};

}  // namespace plait
