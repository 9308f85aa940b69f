// The blocks that one call pins, and the blocks that are needed to encode or decode them (their
// context).
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "paging/frame.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether blocks of `level` may be context of blocks of `other`.
inline bool comes_before(const LevelFile& level, const LevelFile& other) {
  const BlockTable &a = level.table, &b = other.table;
  return std::pair(a.attribute(), a.level()) < std::pair(b.attribute(), b.level());
}

class PinBatch {
 public:
  struct WantedBlock {
    const LevelFile* level = nullptr;
    std::uint64_t block = 0;
    Access access = Access::kRead;
    Frame* frame = nullptr;  ///< pinned once for this entry
    bool brings_in = false;  ///< this call took the frame, and must fill it
    std::size_t context_count = 0;
    std::size_t context = 0;  ///< index of the first entry of its context; the others follow it
    EdgeId order = 0;         ///< Frame::Content::order
  };

  explicit PinBatch(std::span<const BlockRequest> requests) : request_count_(requests.size()) {
    for (const BlockRequest& request : requests)
      entries_.push_back({.level = &request.level(),
                          .block = request.block(),
                          .access = request.access(),
                          .order = request.level().geometry.edge_after(request.block())});
  }

  std::size_t request_count() const { return request_count_; }
  std::size_t size() const { return entries_.size(); }
  WantedBlock& operator[](std::size_t at) { return entries_[at]; }
  auto begin() { return entries_.begin(); }
  auto end() { return entries_.end(); }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }

  /// Errors: std::bad_alloc.
  void add_context_of(std::size_t at, const LevelFile& level, std::uint64_t block) {
    if (entries_[at].context_count == 0) entries_[at].context = entries_.size();
    entries_.push_back({.level = &level, .block = block, .order = entries_[at].order});
    ++entries_[at].context_count;
  }
  /// Removes all entries of context blocks.
  void forget_context() noexcept {
    entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(request_count_), entries_.end());
    for (WantedBlock& entry : entries_) entry.context_count = 0;
  }
  /// The first entry for which `is` returns true, or nullptr.
  template <class Is>
  WantedBlock* first(Is is) {
    const auto found = std::ranges::find_if(entries_, is);
    return found == entries_.end() ? nullptr : &*found;
  }
  /// Whether an entry took this frame in order to overwrite the whole block.
  bool overwrites(const Frame& frame) const noexcept {
    for (const WantedBlock& entry : entries_)
      if (entry.frame == &frame && entry.brings_in && entry.access == Access::kOverwrite)
        return true;
    return false;
  }
  /// Bytes of frames that all entries need together.
  std::uint64_t frame_bytes() const noexcept;

 private:
  std::size_t request_count_;
  boost::container::small_vector<WantedBlock, 8> entries_;
};

PLAIT_END_NAMESPACE
