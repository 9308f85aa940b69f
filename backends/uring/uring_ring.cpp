#include "uring/uring_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "plait/error.h"

namespace plait {
namespace {

/// Far more than any store keeps in flight; the kernel holds back what would overflow.
constexpr unsigned kEntries = 256;
/// Linux moves at most this much in one call, and O_DIRECT wants whole pages.
constexpr std::size_t kMaxTransferBytes = 0x7ffff000;
/// Between two attempts to hand over what the kernel has no room for.
constexpr std::chrono::microseconds kPause{50};

void set_up(io_uring& ring) {
  if (const int result = ::io_uring_queue_init(kEntries, &ring, 0); result < 0)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open backend \"uring\": the kernel refuses io_uring: {}",
                            std::generic_category().message(-result)));
}

}  // namespace

void UringRing::check_available() {
  io_uring ring{};
  set_up(ring);
  ::io_uring_queue_exit(&ring);
}

UringRing::UringRing(Submit with) : submit_(with) {
  set_up(ring_);
  try {
    reaper_ = std::thread([this] { reap(); });
  } catch (const std::system_error& failure) {
    ::io_uring_queue_exit(&ring_);
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("start the thread of io_uring: {}", failure.code().message()));
  }
}

UringRing::~UringRing() {
  // Nothing else can end the thread's wait. Nothing is in flight, so the queue has room as soon as
  // the kernel takes what is in it.
  std::unique_lock lock(mutex_);
  while (true) {
    if (io_uring_sqe* const entry = ::io_uring_get_sqe(&ring_)) {
      ::io_uring_prep_nop(entry);
      ::io_uring_sqe_set_data(entry, end_mark());
      if (hand_over(lock, *entry) == 0) break;
    }
    submit_(&ring_);
    std::this_thread::yield();
  }
  lock.unlock();
  reaper_.join();
  ::io_uring_queue_exit(&ring_);
}

void UringRing::submit(Operation operation, int descriptor, std::uint64_t offset,
                       std::span<std::byte> memory, RingRequest& request) noexcept {
  std::unique_lock lock(mutex_);
  io_uring_sqe* entry = ::io_uring_get_sqe(&ring_);
  if (!entry) {  // full of what the kernel refused
    submit_(&ring_);
    entry = ::io_uring_get_sqe(&ring_);
  }
  int error = EBUSY;
  if (entry) {
    const auto bytes = static_cast<unsigned>(std::min(memory.size(), kMaxTransferBytes));
    if (operation == Operation::kRead)
      ::io_uring_prep_read(entry, descriptor, memory.data(), bytes, offset);
    else
      ::io_uring_prep_write(entry, descriptor, memory.data(), bytes, offset);
    ::io_uring_sqe_set_data(entry, &request);
    error = hand_over(lock, *entry);
  }
  lock.unlock();
  if (error != 0) request.completed(-error);
}

int UringRing::hand_over(std::unique_lock<std::mutex>& lock, io_uring_sqe& entry) noexcept {
  const unsigned end = ring_.sq.sqe_tail;  // one past the entry, counted without wrapping
  const auto is_queued = [&] { return ring_.sq.sqe_tail - end < ::io_uring_sq_ready(&ring_); };
  while (true) {
    const int result = submit_(&ring_);
    // Whoever submits hands over all that is queued: another thread may have taken this entry
    // along.
    if (!is_queued()) return 0;
    if (result == -EINTR) continue;
    if (result < 0 && result != -EAGAIN && result != -EBUSY) {
      // An entry cannot be taken out of the queue. As one that does nothing it may stay.
      ::io_uring_prep_nop(&entry);
      ::io_uring_sqe_set_data(&entry, nullptr);
      return -result;
    }
    // The kernel has no room until completions are taken, and the thread that takes them wants the
    // lock.
    lock.unlock();
    std::this_thread::sleep_for(kPause);
    lock.lock();
    if (!is_queued()) return 0;
  }
}

void UringRing::reap() noexcept {
  while (true) {
    io_uring_cqe* completion = nullptr;
    if (::io_uring_wait_cqe(&ring_, &completion) != 0) continue;  // interrupted
    void* const data = ::io_uring_cqe_get_data(completion);
    const int result = completion->res;
    ::io_uring_cqe_seen(&ring_, completion);
    if (data == end_mark()) return;
    if (!data) continue;  // of an entry that the kernel refused at first
    // What the submitter did happened before: through the kernel in fact, and for all who reason
    // about locks through this one.
    { const std::scoped_lock lock(mutex_); }
    static_cast<RingRequest*>(data)->completed(result);
  }
}

}  // namespace plait
