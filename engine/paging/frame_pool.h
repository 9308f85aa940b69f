// Memory for frames. The pool reuses the memory of freed frames by size, and returns it to the
// system only if another size needs it. On virtual machines, a new page costs more time than the
// disk transfer into it. So the pool keeps the pages of a frame, and the first thread that fills a
// frame touches its pages, without the pager's lock.
//
// Frames come from slabs, because each allocation of its own takes up to 4 KiB more, for which no
// budget counts. Slabs have huge pages where the budget has room for many of them: copies from
// pages of 4 KiB take up to twice the time, because a processor knows the addresses of few of them.
// A slab of huge pages may map a little more than its frames, so that its last page is huge too.
// This rest, at most one byte of 128, does not count in the budget. An idle frame of a slab gives
// its pages back where another size needs the memory. It is then bare. A slab whose frames are all
// bare is unmapped. (Of a huge page that other frames still use, Linux takes back a part not at
// once, but before it runs out of memory.)
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager's lock protects it.
class FramePool {
 public:
  explicit FramePool(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}
  ~FramePool();
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;

  static std::uint64_t frame_bytes(std::uint64_t block_bytes) {
    return (block_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

  /// Must be called before the first take() of this size. `bytes` is a value of frame_bytes().
  /// Errors: std::bad_alloc.
  void prepare(std::uint64_t bytes) { sizes_.try_emplace(bytes); }
  /// Memory for a frame, or nullptr if the budget has no room. Errors: std::bad_alloc.
  std::byte* take(std::uint64_t bytes);
  void give_back(std::byte* memory, std::uint64_t bytes) noexcept;
  /// Counts a frame whose memory belongs to a backend.
  bool reserve(std::uint64_t bytes) noexcept;
  void unreserve(std::uint64_t bytes) noexcept { used_bytes_ -= bytes; }

  /// Returns all idle memory. REQUIRES: no frame is in use.
  void release() noexcept;

  /// Reserves `bytes` of the budget for other memory than frames.
  void set_aside(std::uint64_t bytes) noexcept;
  /// Lends `bytes` more, or fewer, besides those that are set aside.
  void lend(std::int64_t bytes) noexcept;

  /// The part of the budget that is for frames.
  std::uint64_t budget_bytes() const {
    return budget_bytes_ - std::min(budget_bytes_, aside_bytes_ + lent_bytes_);
  }
  /// The whole budget of which `frame_bytes` are for frames. What a backend keeps for itself may
  /// grow with the budget, to a quarter of it.
  std::uint64_t needed_budget(std::uint64_t frame_bytes) const {
    const std::uint64_t bytes = frame_bytes + lent_bytes_;
    return aside_bytes_ == 0 ? bytes : std::max(bytes + aside_bytes_, (4 * bytes + 2) / 3);
  }
  /// The whole budget: no more memory can ever be used.
  std::uint64_t most_bytes() const { return budget_bytes_; }
  std::uint64_t used_bytes() const { return used_bytes_; }  ///< of frames in use
  std::uint64_t peak_bytes() const { return peak_bytes_; }

 private:
  static constexpr std::uint64_t kAlignment = 4096;
  /// A list link in the first bytes of an idle frame, so that giving memory back allocates nothing.
  struct Idle {
    Idle* next;
  };
  /// The frames of one size that nobody uses.
  struct Size {
    Idle* idle = nullptr;
    std::vector<std::byte*> fresh;  ///< of slabs, never used: idle, but not to be written to
    std::vector<std::byte*> bare;   ///< of slabs, without pages: not idle
    std::size_t in_slabs = 0;       ///< frames of this size that the slabs have
  };
  struct Slab {
    std::byte* memory;
    std::size_t bytes, frames, bare_frames;
    bool is_huge;
  };
  struct SlabShape {
    std::size_t frames = 0;
    std::size_t bytes = 0;        ///< mapped
    std::size_t other_bytes = 0;  ///< in pages that are not huge, or of no frame
  };

  bool may_use(std::uint64_t bytes) const { return used_bytes_ + bytes <= budget_bytes(); }
  /// Returns idle memory to the system until `bytes` fit into the budget.
  void make_room(std::uint64_t bytes) noexcept;
  static std::byte* pop(Idle*& list) noexcept;
  /// Maps a slab and returns its first frame, or nullptr if frames of this size are better taken
  /// one by one.
  std::byte* take_slab(Size& size, std::uint64_t bytes);
  /// The same for this slab. nullptr also if the budget has no room for it.
  std::byte* map_slab(Size& size, std::uint64_t bytes, const SlabShape& shape, bool is_huge);
  /// The slab of huge pages of at most `most_bytes` that has the fewest other bytes for each frame.
  /// No frame if none has a huge page.
  static SlabShape huge_slab(std::uint64_t frame_bytes, std::uint64_t most_bytes);
  /// The slab that has this frame, or slabs_.end().
  std::vector<Slab>::iterator slab_of(const std::byte* memory) noexcept;
  /// Gives the pages of an idle frame back to the system.
  void free_idle(Size& size, std::byte* memory, std::uint64_t bytes) noexcept;
  std::byte* take_bare(Size& size) noexcept;

  std::uint64_t budget_bytes_, aside_bytes_ = 0, lent_bytes_ = 0;
  std::uint64_t used_bytes_ = 0, idle_bytes_ = 0, peak_bytes_ = 0;
  std::map<std::uint64_t, Size> sizes_;  ///< those that were prepared
  std::vector<Slab> slabs_;              ///< by address
  std::size_t frames_in_huge_pages_ = 0;
};

PLAIT_END_NAMESPACE
