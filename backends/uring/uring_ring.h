// backends/uring/uring_ring.h: the io_uring of one volume.
#pragma once

#include <liburing.h>
#include <sys/uio.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <thread>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The ring calls completed() when the request has ended.
class RingRequest {
 public:
  /// `result`: the number of bytes moved, or a negative errno. The ring's thread calls this; if the
  /// kernel refuses the request, submit() calls it.
  virtual void completed(int result) noexcept = 0;

 protected:
  ~RingRequest() = default;
};

/// One submission queue for all levels of a store, and one thread that waits for completions. Safe
/// from any thread.
///
/// No buffers are registered with the kernel, because the set of frames changes with the budget.
/// How much time registering would save was not measured.
class UringRing {
 public:
  /// io_uring_submit, or a replacement in a test.
  using Submit = int (*)(io_uring*);

  /// Throws kNotSupported if the kernel refuses io_uring; the message names the limit. Asks the
  /// kernel until it has said yes once.
  static void check_available();

  /// Errors: kNotSupported if the kernel refuses io_uring; kOutOfMemory if no thread can be
  /// started.
  explicit UringRing(Submit with = ::io_uring_submit);
  ~UringRing();  ///< REQUIRES: no transfer is in flight
  UringRing(const UringRing&) = delete;
  UringRing& operator=(const UringRing&) = delete;

  enum class Operation : std::uint8_t { kRead, kWrite };
  /// Begins one transfer, which may move fewer bytes than `memory` has. `request` and `memory` must
  /// live until completed() is called. If the kernel has no room at the moment, submit() tries
  /// again. If the kernel refuses the request for another reason, submit() calls completed() with
  /// the error, and the kernel never accesses the memory.
  void submit(Operation operation, int descriptor, std::uint64_t offset,
              std::span<std::byte> memory, RingRequest& request) noexcept;
  /// The same for several pieces of memory, one after another. `pieces` must live as long.
  void submit(Operation operation, int descriptor, std::uint64_t offset,
              std::span<const iovec> pieces, RingRequest& request) noexcept;

 private:
  /// `prepare(entry)` fills the entry.
  template <class Prepare>
  void submit_prepared(RingRequest& request, Prepare prepare) noexcept;
  void reap() noexcept;
  /// The user data of the request that ends the thread.
  void* end_mark() noexcept { return this; }
  /// Submits the entry that was prepared last. Releases the lock between attempts. Returns 0, or an
  /// errno; after an errno the entry does nothing when the kernel takes it.
  int hand_over(std::unique_lock<std::mutex>& lock, io_uring_sqe& entry) noexcept;

  io_uring ring_{};  ///< with the thread sanitizer see tools/dev/tsan/liburing.h
  Submit submit_;
  /// `is_refused_`: the kernel refuses io_uring since the ring was made. Then no request can end
  /// the thread, and `is_ending_` does.
  std::atomic<bool> is_refused_ = false, is_ending_ = false;
  std::mutex mutex_;  ///< guards the submission side
  std::thread reaper_;
};

PLAIT_END_NAMESPACE
