// Memory for frames: recycled by size, handed back to the system only when another size needs it.
// On virtual machines a fresh page costs more than the disk transfer into it, so a frame's pages
// are touched once, by whoever fills it first and not under the pager's lock, and then kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

namespace plait {

/// One thread at a time (the pager's lock).
class FramePool {
 public:
  explicit FramePool(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}
  ~FramePool();
  FramePool(const FramePool&) = delete;
  FramePool& operator=(const FramePool&) = delete;

  static std::uint64_t frame_bytes(std::uint64_t block_bytes) {
    return (block_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

  /// Before the first take() of so many bytes, a frame_bytes() value. Errors: std::bad_alloc.
  void prepare(std::uint64_t bytes) { idle_.try_emplace(bytes, nullptr); }
  /// Memory for a frame, or nullptr if the budget has no room. Errors: std::bad_alloc.
  std::byte* take(std::uint64_t bytes);
  void give_back(std::byte* memory, std::uint64_t bytes) noexcept;
  /// Accounts for a frame whose memory is a backend's own.
  bool reserve(std::uint64_t bytes) noexcept;
  void unreserve(std::uint64_t bytes) noexcept { used_bytes_ -= bytes; }

  /// Of the budget so much is not for frames.
  void set_aside(std::uint64_t bytes) noexcept;

  /// What is for frames.
  std::uint64_t budget_bytes() const { return budget_bytes_ - aside_bytes_; }
  std::uint64_t most_bytes() const { return budget_bytes_; }  ///< if nothing were set aside
  std::uint64_t used_bytes() const { return used_bytes_; }    ///< in frames that are taken
  std::uint64_t peak_bytes() const { return peak_bytes_; }

 private:
  static constexpr std::uint64_t kAlignment = 4096;
  /// In the first bytes of an idle frame: to give one back allocates nothing.
  struct Idle {
    Idle* next;
  };
  bool make_room(std::uint64_t bytes) noexcept;
  static std::byte* pop(Idle*& list) noexcept;

  std::uint64_t budget_bytes_, aside_bytes_ = 0;
  std::uint64_t used_bytes_ = 0, idle_bytes_ = 0, peak_bytes_ = 0;
  std::map<std::uint64_t, Idle*> idle_;  ///< every size that was ever taken
};

}  // namespace plait
