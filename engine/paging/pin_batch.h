// Blocks that are pinned by one call, and the blocks that these are coded by.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "paging/frame.h"

namespace plait {

/// Whether blocks of `other` may be coded by blocks of `level`.
inline bool comes_before(const LevelFile& level, const LevelFile& other) {
  const BlockTable &a = level.table, &b = other.table;
  return std::pair(a.level(), a.attribute()) < std::pair(b.level(), b.attribute());
}

class PinBatch {
 public:
  struct Entry {
    const LevelFile* level = nullptr;
    std::uint64_t block = 0;
    Access access = Access::kRead;
    Frame* frame = nullptr;  ///< pinned once for this entry
    bool brings_in = false;  ///< this call took the frame, and brings the block's bytes in
    std::size_t context_count = 0;
    std::size_t context = 0;  ///< the first of its context, which stands together
  };

  explicit PinBatch(std::span<const BlockRequest> requests) : request_count_(requests.size()) {
    for (const BlockRequest& request : requests)
      entries_.push_back({&request.level(), request.block(), request.access()});
  }

  std::size_t request_count() const { return request_count_; }
  std::size_t size() const { return entries_.size(); }
  Entry& operator[](std::size_t at) { return entries_[at]; }
  auto begin() { return entries_.begin(); }
  auto end() { return entries_.end(); }

  /// Errors: std::bad_alloc.
  void add_context_of(std::size_t at, const LevelFile& level, std::uint64_t block) {
    if (entries_[at].context_count == 0) entries_[at].context = entries_.size();
    entries_.push_back({&level, block});
    ++entries_[at].context_count;
  }
  /// As it was before frames were taken.
  void forget_context() noexcept {
    entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(request_count_), entries_.end());
    for (Entry& entry : entries_) entry.context_count = 0;
  }
  /// The first for which `is` is true, or nullptr.
  template <class Is>
  Entry* first(Is is) {
    const auto found = std::ranges::find_if(entries_, is);
    return found == entries_.end() ? nullptr : &*found;
  }
  /// Whether an entry is to overwrite this block, which the batch takes into memory.
  bool overwrites(const Frame& frame) const noexcept {
    for (const Entry& entry : entries_)
      if (entry.frame == &frame && entry.brings_in && entry.access == Access::kWrite) return true;
    return false;
  }
  void read_before_writing(const Frame& frame) noexcept {
    for (Entry& entry : entries_)
      if (entry.frame == &frame && entry.access == Access::kWrite) entry.access = Access::kUpdate;
  }
  /// Bytes of frames that all of them take together.
  std::uint64_t frame_bytes() const noexcept;

 private:
  std::size_t request_count_;
  boost::container::small_vector<Entry, 8> entries_;
};

}  // namespace plait
