// backends/uring/uring_ring.h: the io_uring of one volume.
#pragma once

#include <liburing.h>

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <thread>

namespace plait {

/// What is told when a request has ended.
class RingRequest {
 public:
  /// Bytes moved, or a negative errno. In the ring's thread, or in submit() if the kernel took no
  /// request.
  virtual void completed(int result) noexcept = 0;

 protected:
  ~RingRequest() = default;
};

/// One submission queue that all levels of a store share, and one thread that waits for
/// completions. Safe from any thread.
///
/// No buffers are registered: frames come and go with the budget. What registering would save was
/// not measured.
class UringRing {
 public:
  /// io_uring_submit, or what a test puts in its place.
  using Submit = int (*)(io_uring*);

  /// Errors: kNotSupported if the kernel refuses io_uring.
  static void check_available();

  /// Errors: kNotSupported if the kernel refuses io_uring; kOutOfMemory for want of a thread.
  explicit UringRing(Submit with = ::io_uring_submit);
  ~UringRing();  ///< REQUIRES: nothing is on its way
  UringRing(const UringRing&) = delete;
  UringRing& operator=(const UringRing&) = delete;

  enum class Operation : std::uint8_t { kRead, kWrite };
  /// Begins one transfer, which may end short. Request and memory stay until it completed. What the
  /// kernel refuses for the moment only is offered again; what it refuses for good completes with
  /// the error, and the kernel never touches its memory.
  void submit(Operation operation, int descriptor, std::uint64_t offset,
              std::span<std::byte> memory, RingRequest& request) noexcept;

 private:
  void reap() noexcept;
  /// What the kernel gives back with a request that ends the thread.
  void* end_mark() noexcept { return this; }
  /// Hands the entry that was prepared last to the kernel, lets go of the lock between attempts.
  /// 0, or an errno: the entry does nothing then, whenever the kernel comes to take it.
  int hand_over(std::unique_lock<std::mutex>& lock, io_uring_sqe& entry) noexcept;

  io_uring ring_{};  ///< for the thread sanitizer: tools/dev/tsan/liburing.h
  Submit submit_;
  std::mutex mutex_;  ///< guards the submission side
  std::thread reaper_;
};

}  // namespace plait
