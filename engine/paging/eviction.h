// Which unpinned frame goes next.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "plait/pager.h"

namespace plait {

/// The frames that may be evicted. One thread at a time (the pager's lock).
class Eviction {
 public:
  virtual ~Eviction() = default;
  /// `frame` holds no pin any more; its block ends before edge `edge_after` (0: an earlier sweep
  /// left it, and it goes first). erase() is called with the same.
  virtual void insert(std::uint32_t frame, EdgeId edge_after) = 0;
  virtual void erase(std::uint32_t frame, EdgeId edge_after) = 0;
  /// The next to go, or kNoId; it stays in the set until erased.
  virtual std::uint32_t victim() = 0;
};

/// Window: the block that ends furthest behind. Since all levels share the edge order, their
/// windows cover the same edge range without any level being told its share.
class WindowEviction final : public Eviction {
 public:
  void insert(std::uint32_t frame, EdgeId edge_after) override {
    frames_.emplace(edge_after, frame);
  }
  void erase(std::uint32_t frame, EdgeId edge_after) override {
    frames_.erase({edge_after, frame});
  }
  std::uint32_t victim() override { return frames_.empty() ? kNoId : frames_.begin()->second; }

 private:
  std::set<std::pair<EdgeId, std::uint32_t>> frames_;
};

/// Clock: a frame that came back since the hand last passed it is spared once.
class ClockEviction final : public Eviction {
 public:
  void insert(std::uint32_t frame, EdgeId) override {
    if (frame >= where_.size()) where_.resize(frame + 1, Place{ring_.end(), false});
    where_[frame] = {ring_.insert(hand_, frame), true};
    if (hand_ == ring_.end()) hand_ = ring_.begin();
  }
  void erase(std::uint32_t frame, EdgeId) override {
    if (hand_ == where_[frame].position) ++hand_;
    ring_.erase(where_[frame].position);
  }
  std::uint32_t victim() override {
    if (ring_.empty()) return kNoId;
    while (true) {
      if (hand_ == ring_.end()) hand_ = ring_.begin();
      if (!where_[*hand_].referenced) return *hand_;
      where_[*hand_].referenced = false;
      ++hand_;
    }
  }

 private:
  using Ring = std::list<std::uint32_t>;
  struct Place {
    Ring::iterator position;
    bool referenced;
  };
  Ring ring_;
  Ring::iterator hand_ = ring_.end();
  std::vector<Place> where_;
};

inline std::unique_ptr<Eviction> make_eviction(EvictionPolicy policy) {
  if (policy == EvictionPolicy::kClock) return std::make_unique<ClockEviction>();
  return std::make_unique<WindowEviction>();
}

}  // namespace plait
