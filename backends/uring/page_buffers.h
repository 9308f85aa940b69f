// backends/uring/page_buffers.h: memory with the alignment of O_DIRECT, for blocks whose own memory
// is not aligned.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

#include "level_file.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The page buffers of one volume, all of one size. A buffer is made when a transfer first needs
/// it, and is then kept for the next transfer: fresh pages cost more than the transfer. A transfer
/// that finds no buffer waits until another transfer has ended. Safe from any thread.
class PageBuffers {
 public:
  /// More transfers in flight do not make a disk faster.
  static constexpr std::uint64_t kMostBuffers = 8;

  /// All buffers together take at most `most_bytes`, but there is always one.
  explicit PageBuffers(std::uint64_t most_bytes);

  /// From now on a buffer holds at least `bytes`, a multiple of kPageBytes. `often`: transfers need
  /// a buffer whatever memory the caller has, so there should be several buffers. A smaller buffer
  /// that is in use is freed when its user returns it.
  void make_room_for(std::uint64_t bytes, bool often);

  /// The most memory that the buffers together take; at most the constructor's `most_bytes`. 0
  /// while none is needed often: a single buffer for callers whose memory is not aligned is not
  /// counted.
  std::uint64_t memory_bytes() const noexcept;
  /// How many buffers there may be, and how large each one is.
  struct Room {
    bool often = false;
    std::uint64_t buffer_bytes = 0, count = 1;
  };
  Room room() const noexcept;
  /// What make_room_for() makes of it.
  Room with(Room room, std::uint64_t bytes, bool often) const noexcept;
  /// memory_bytes() with this room.
  std::uint64_t memory_of(const Room& room) const noexcept;
  std::uint64_t count() const noexcept;

  class Lease {
   public:
    Lease() = default;
    /// Waits for a buffer. Errors: std::bad_alloc.
    explicit Lease(PageBuffers& buffers) : buffers_(&buffers), buffer_(buffers.take()) {}
    ~Lease() {
      if (buffer_.memory) buffers_->give_back(std::move(buffer_));
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Lease(Lease&&) noexcept = default;
    Lease& operator=(Lease&&) noexcept = default;

    std::byte* get() const noexcept { return buffer_.memory.get(); }
    explicit operator bool() const noexcept { return buffer_.memory != nullptr; }

   private:
    friend class PageBuffers;
    struct Free {
      void operator()(std::byte* memory) const {
        ::operator delete(memory, std::align_val_t(kPageBytes));
      }
    };
    struct Buffer {
      std::unique_ptr<std::byte, Free> memory;
      std::uint64_t bytes = 0;
    };

    PageBuffers* buffers_ = nullptr;
    Buffer buffer_;
  };

 private:
  using Buffer = Lease::Buffer;
  Buffer take();
  void give_back(Buffer buffer) noexcept;

  std::uint64_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable given_back_;
  Room room_;
  std::uint64_t taken_ = 0;
  std::vector<Buffer> idle_;  ///< has room for kMostBuffers, so that give_back() cannot fail
};

PLAIT_END_NAMESPACE
