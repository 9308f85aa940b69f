#include "uring/uring_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "plait/error.h"

namespace plait {
namespace {

/// Far more than any store keeps in flight; the kernel holds back what would overflow.
constexpr unsigned kEntries = 256;
/// Linux moves at most this much in one call, and O_DIRECT wants whole pages.
constexpr std::size_t kMaxTransferBytes = 0x7ffff000;

}  // namespace

std::shared_ptr<UringRing> UringRing::shared() {
  static std::mutex mutex;
  static std::weak_ptr<UringRing> known;
  const std::scoped_lock lock(mutex);
  std::shared_ptr<UringRing> ring = known.lock();
  if (!ring) {
    ring = std::make_shared<UringRing>();
    known = ring;
  }
  return ring;
}

UringRing::UringRing() {
  if (const int result = ::io_uring_queue_init(kEntries, &ring_, 0); result < 0)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open backend \"uring\": the kernel refuses io_uring: {}",
                            std::generic_category().message(-result)));
  try {
    reaper_ = std::thread([this] { reap(); });
  } catch (...) {
    ::io_uring_queue_exit(&ring_);
    throw;
  }
}

UringRing::~UringRing() {
  // Nothing else can end the thread's wait. That nothing is in flight leaves room for it.
  while (push(Operation::kRead, -1, 0, {}, nullptr) != 0) std::this_thread::yield();
  reaper_.join();
  ::io_uring_queue_exit(&ring_);
}

void UringRing::submit(Operation operation, int descriptor, std::uint64_t offset,
                       std::span<std::byte> memory, RingRequest& request) noexcept {
  if (const int error = push(operation, descriptor, offset, memory, &request); error != 0)
    request.completed(-error);
}

int UringRing::push(Operation operation, int descriptor, std::uint64_t offset,
                    std::span<std::byte> memory, RingRequest* request) noexcept {
  const std::scoped_lock lock(mutex_);
  io_uring_sqe* const entry = ::io_uring_get_sqe(&ring_);
  if (!entry) return EBUSY;
  const auto bytes = static_cast<unsigned>(std::min(memory.size(), kMaxTransferBytes));
  if (!request)
    ::io_uring_prep_nop(entry);
  else if (operation == Operation::kRead)
    ::io_uring_prep_read(entry, descriptor, memory.data(), bytes, offset);
  else
    ::io_uring_prep_write(entry, descriptor, memory.data(), bytes, offset);
  ::io_uring_sqe_set_data(entry, request);
  int result = 0;
  do {
    result = ::io_uring_submit(&ring_);
    // The entry is in the queue and cannot be taken out again: another attempt is all there is.
    if (result == -EAGAIN || result == -EBUSY) std::this_thread::yield();
  } while (result == -EINTR || result == -EAGAIN || result == -EBUSY);
  return result < 0 ? -result : 0;
}

void UringRing::reap() noexcept {
  while (true) {
    io_uring_cqe* entry = nullptr;
    if (::io_uring_wait_cqe(&ring_, &entry) != 0) continue;  // interrupted
    auto* const request = static_cast<RingRequest*>(::io_uring_cqe_get_data(entry));
    const int result = entry->res;
    ::io_uring_cqe_seen(&ring_, entry);
    if (!request) return;
    // What the submitter did happened before: through the kernel in fact, and for all who reason
    // about locks through this one.
    { const std::scoped_lock lock(mutex_); }
    request->completed(result);
  }
}

}  // namespace plait
