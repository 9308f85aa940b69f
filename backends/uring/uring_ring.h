// backends/uring/uring_ring.h: the process's io_uring.
#pragma once

#include <liburing.h>

#include <cstddef>
#include <cstdint>
#include <memory>
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

/// One submission queue that all levels of all stores share, and one thread that waits for
/// completions. Safe from any thread.
///
/// No buffers are registered: frames come and go with the budget. What registering would save was
/// not measured.
class UringRing {
 public:
  /// The ring, made if there is none; it lives as long as somebody holds it.
  /// Errors: kNotSupported if the kernel refuses io_uring; std::system_error for want of a thread.
  static std::shared_ptr<UringRing> shared();

  UringRing();
  ~UringRing();  ///< REQUIRES: nothing is on its way
  UringRing(const UringRing&) = delete;
  UringRing& operator=(const UringRing&) = delete;

  enum class Operation : std::uint8_t { kRead, kWrite };
  /// Begins one transfer, which may end short. Request and memory stay until it completed.
  void submit(Operation operation, int descriptor, std::uint64_t offset,
              std::span<std::byte> memory, RingRequest& request) noexcept;

 private:
  void reap() noexcept;
  /// 0 or an errno.
  int push(Operation operation, int descriptor, std::uint64_t offset, std::span<std::byte> memory,
           RingRequest* request) noexcept;

  io_uring ring_{};   ///< for the thread sanitizer: tools/dev/tsan/liburing.h
  std::mutex mutex_;  ///< guards the submission side
  std::thread reaper_;
};

}  // namespace plait
