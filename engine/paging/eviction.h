// Eviction policies: which unpinned frame of a session the pager evicts next. To remove a frame
// from a policy, unlink the frame's own links.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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
/// order, and reading it again costs as much as decoding all that it needs. When the window has
/// passed the last block that needs it, it leaves before all others of its size.
///
/// A frame of the wanted size serves the next block as it is, where the system would take the pages
/// of another size and clear new ones. So of the frames that the window has passed, one of the
/// wanted size goes first, and those of other sizes when more of them have piled up than are soon
/// used again.
class WindowEviction final : public Eviction {
 public:
  void insert(Frame& frame) noexcept override {
    if (frame.content.kept_edges > 0) {
      context_.insert(frame);
      by_need_.insert(frame);
    } else {
      others_of(frame.content.frame_bytes).insert(frame);
      passed_ = frame.content.order;
    }
  }
  Frame* victim(std::uint64_t wanted_bytes) noexcept override {
    while (Frame* const next = next_of(wanted_bytes)) {
      if (next->pins.claim()) return next;
      next->in_order.unlink();
      next->in_need.unlink();
    }
    return nullptr;
  }

 private:
  static constexpr std::size_t kSizes = 8;
  static constexpr int kSpareFrames = 8;
  struct OfSize {
    std::uint64_t frame_bytes = 0;
    FrameWindow frames;
  };

  FrameWindow& others_of(std::uint64_t frame_bytes) noexcept {
    std::size_t at = 0;
    while (at + 1 < kSizes && others_[at].frame_bytes != 0 &&
           others_[at].frame_bytes != frame_bytes)
      ++at;
    others_[at].frame_bytes = frame_bytes;
    return others_[at].frames;
  }
  /// Whether the window has passed the frame at `place`, and so those before it.
  bool has_passed(const FrameWindow& frames, int place) const noexcept {
    auto frame = frames.begin();
    for (int i = 0; i < place && frame != frames.end(); ++i) ++frame;
    return frame != frames.end() && frame->content.order <= passed_;
  }
  Frame* next_of(std::uint64_t wanted_bytes) noexcept {
    Frame* const not_needed = !by_need_.empty() && by_need_.begin()->content.needed_until <= passed_
                                  ? &*by_need_.begin()
                                  : nullptr;
    if (not_needed && not_needed->content.frame_bytes == wanted_bytes) return not_needed;
    FrameWindow& wanted = others_of(wanted_bytes);
    if (has_passed(wanted, 0)) return &*wanted.begin();
    for (OfSize& each : others_)
      if (has_passed(each.frames, kSpareFrames)) return &*each.frames.begin();
    if (not_needed) return not_needed;
    Frame* first = context_.empty() ? nullptr : &*context_.begin();
    for (OfSize& each : others_)
      if (!each.frames.empty() && (!first || LeavesEarlier()(*each.frames.begin(), *first)))
        first = &*each.frames.begin();
    return first;
  }

  FrameWindow context_;
  FramesByNeed by_need_;  ///< the same
  /// By their size. If there are more sizes, they share the last window.
  std::array<OfSize, kSizes> others_;
  EdgeId passed_ = 0;  ///< the window has passed the blocks that end there
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
