#include "uring/uring_ring.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>

#include "base/threads.h"
#include "io/descriptor.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The length of the queue. Each transfer is handed over at once, so the queue is never longer than
/// the number of threads that the kernel refuses at a time. If the queue of completions, which is
/// twice as long, is full, the kernel keeps further ones back. The kernel counts the memory of a
/// ring as locked, and with this length it is two pages.
constexpr unsigned kEntries = 16;
/// The most bytes that Linux moves in one call, rounded down to whole pages for O_DIRECT.
constexpr std::size_t kMaxTransferBytes = 0x7ffff000;
/// The pause before a submission is tried again, when the kernel has no room.
constexpr std::chrono::microseconds kPause{50};

/// What may have made the kernel refuse a ring.
std::string limit_of(int error) {
  rlimit limit{};
  switch (error) {
    case EPERM:
      return " (kernel.io_uring_disabled, or a filter of system calls, as containers have)";
    case ENOSYS:
      return " (an old kernel, or a filter of system calls, as containers have)";
    case ENOMEM:
      return ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY
                 ? fmt::format(" (locked memory: the limit RLIMIT_MEMLOCK, ulimit -l, is {} KiB)",
                               limit.rlim_cur / 1024)
                 : std::string();
    case EMFILE:
      return " (open files: the limit is RLIMIT_NOFILE, ulimit -n)";
    default:
      return {};
  }
}

/// Moves a request that does nothing through the ring: some filters of system calls allow a ring
/// and forbid its use. Returns 0 or a negative errno.
int try_out(io_uring& ring) {
  io_uring_sqe* const entry = ::io_uring_get_sqe(&ring);
  if (entry == nullptr) return -EBUSY;
  ::io_uring_prep_nop(entry);
  // A kernel that always says "again" is one that refuses.
  const auto attempt = [](const auto& call) {
    constexpr int kMostAttempts = 1000;
    int result = call();
    for (int i = 1; i < kMostAttempts && (result == -EINTR || result == -EAGAIN); ++i) {
      std::this_thread::sleep_for(kPause);
      result = call();
    }
    return result;
  };
  if (const int result = attempt([&] { return ::io_uring_submit(&ring); }); result < 0)
    return result;
  io_uring_cqe* completion = nullptr;
  if (const int result = attempt([&] { return ::io_uring_wait_cqe(&ring, &completion); });
      result < 0)
    return result;
  ::io_uring_cqe_seen(&ring, completion);
  return 0;
}

void set_up(io_uring& ring) {
  // The kernel takes back the locked memory of a closed ring a little later.
  constexpr int kAttempts = 12;
  std::chrono::microseconds pause = kPause;
  int result = 0;
  {
    const StandardStreamsTaken taken;
    for (int attempt = 0; attempt < kAttempts; ++attempt, pause *= 2) {
      result = ::io_uring_queue_init(kEntries, &ring, 0);
      if (result != -ENOMEM && result != -EAGAIN && result != -EINTR) break;
      std::this_thread::sleep_for(pause);
    }
  }
  if (result == 0) {
    result = try_out(ring);
    if (result < 0) ::io_uring_queue_exit(&ring);
  }
  if (result < 0)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open backend \"uring\": the kernel refuses io_uring: {}{}",
                            std::generic_category().message(-result), limit_of(-result)));
}

}  // namespace

void UringRing::check_available() {
  static std::atomic<bool> available = false;
  if (available) return;
  io_uring ring{};
  set_up(ring);
  ::io_uring_queue_exit(&ring);
  available = true;
}

UringRing::UringRing(Submit with) : submit_(with) {
  set_up(ring_);
  try {
    reaper_ = start_thread("the thread of io_uring", [this] { reap(); });
  } catch (const Error&) {
    ::io_uring_queue_exit(&ring_);
    throw;
  }
}

UringRing::~UringRing() {
  // Only a completion can end the thread's wait, so this submits a request that does nothing. No
  // transfer is in flight, so the queue has room as soon as the kernel takes its entries.
  std::unique_lock lock(mutex_);
  while (true) {
    if (io_uring_sqe* const entry = ::io_uring_get_sqe(&ring_)) {
      ::io_uring_prep_nop(entry);
      ::io_uring_sqe_set_data(entry, end_mark());
      if (hand_over(lock, *entry) == 0) break;
    }
    if (is_refused_) break;
    submit_(&ring_);
    std::this_thread::yield();
  }
  is_ending_ = true;
  lock.unlock();
  reaper_.join();
  ::io_uring_queue_exit(&ring_);
}

template <class Prepare>
void UringRing::submit_prepared(RingRequest& request, Prepare prepare) noexcept {
  std::unique_lock lock(mutex_);
  io_uring_sqe* entry = ::io_uring_get_sqe(&ring_);
  if (!entry) {  // the queue is full of entries that the kernel refused before
    submit_(&ring_);
    entry = ::io_uring_get_sqe(&ring_);
  }
  int error = EBUSY;
  if (entry) {
    prepare(entry);
    ::io_uring_sqe_set_data(entry, &request);
    error = hand_over(lock, *entry);
  }
  lock.unlock();
  if (error != 0) request.completed(-error);
}

void UringRing::submit(Operation operation, int descriptor, std::uint64_t offset,
                       std::span<std::byte> memory, RingRequest& request) noexcept {
  submit_prepared(request, [&](io_uring_sqe* entry) {
    const auto bytes = static_cast<unsigned>(std::min(memory.size(), kMaxTransferBytes));
    if (operation == Operation::kRead)
      ::io_uring_prep_read(entry, descriptor, memory.data(), bytes, offset);
    else
      ::io_uring_prep_write(entry, descriptor, memory.data(), bytes, offset);
  });
}

void UringRing::submit(Operation operation, int descriptor, std::uint64_t offset,
                       std::span<const iovec> pieces, RingRequest& request) noexcept {
  submit_prepared(request, [&](io_uring_sqe* entry) {
    const auto count = static_cast<unsigned>(pieces.size());
    if (operation == Operation::kRead)
      ::io_uring_prep_readv(entry, descriptor, pieces.data(), count, offset);
    else
      ::io_uring_prep_writev(entry, descriptor, pieces.data(), count, offset);
  });
}

int UringRing::hand_over(std::unique_lock<std::mutex>& lock, io_uring_sqe& entry) noexcept {
  const unsigned end = ring_.sq.sqe_tail;  // one past the entry, counted without wrapping
  const auto is_queued = [&] { return ring_.sq.sqe_tail - end < ::io_uring_sq_ready(&ring_); };
  while (true) {
    const int result = submit_(&ring_);
    // A submission submits all queued entries, so another thread may have submitted this one.
    if (!is_queued()) return 0;
    if (result == -EINTR) continue;
    if (result < 0 && result != -EAGAIN && result != -EBUSY) {
      // An entry cannot be removed from the queue. So it becomes one that does nothing.
      ::io_uring_prep_nop(&entry);
      ::io_uring_sqe_set_data(&entry, nullptr);
      return -result;
    }
    // The kernel has no room until the thread takes completions, and the thread needs the lock for
    // that.
    lock.unlock();
    std::this_thread::sleep_for(kPause);
    lock.lock();
    if (!is_queued()) return 0;
  }
}

void UringRing::reap() noexcept {
  while (true) {
    io_uring_cqe* completion = nullptr;
    if (const int result = ::io_uring_wait_cqe(&ring_, &completion); result != 0) {
      if (result == -EINTR) continue;
      // The kernel refuses to wait, as after a filter of system calls that the program has set
      // since. Completions come all the same.
      is_refused_ = true;
      if (is_ending_) return;
      std::this_thread::sleep_for(kPause);
      continue;
    }
    void* const data = ::io_uring_cqe_get_data(completion);
    const int result = completion->res;
    ::io_uring_cqe_seen(&ring_, completion);
    if (data == end_mark()) return;
    if (!data) continue;  // the kernel refused this entry before; submit() has reported it
    // All that the submitting thread did before submit() must be visible here. The kernel ensures
    // that, but a thread sanitizer sees only locks. So this takes the submitter's lock.
    { const std::scoped_lock lock(mutex_); }
    static_cast<RingRequest*>(data)->completed(result);
  }
}

PLAIT_END_NAMESPACE
