// What the ring does when the kernel takes no request: io_uring_submit fails as the test says.
#include "uring/uring_ring.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <condition_variable>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "plait/extend/file.h"
#include "support/skip.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

std::atomic<int> failures_left = 0, error_of_submit = 0;

int submit_or_fail(io_uring* ring) {
  int left = failures_left;
  while (left > 0 && !failures_left.compare_exchange_weak(left, left - 1)) {
  }
  return left > 0 ? -error_of_submit.load() : ::io_uring_submit(ring);
}

void fail_submits(int error, int times) {
  error_of_submit = error;
  failures_left = times;
}

class Request final : public RingRequest {
 public:
  void completed(int result) noexcept override {
    const std::scoped_lock lock(mutex_);
    result_ = result;
    ++calls_;
    ended_.notify_all();
  }
  int wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return result_.has_value(); });
    return *result_;
  }
  int calls() {
    const std::scoped_lock lock(mutex_);
    return calls_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<int> result_;
  int calls_ = 0;
};

std::unique_ptr<UringRing> make_ring() {
  fail_submits(0, 0);
  try {
    return std::make_unique<UringRing>(submit_or_fail);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kNotSupported);
    skip(error.what());
    return nullptr;
  }
}

constexpr std::size_t kBytes = 4096;

struct Disk {
  TemporaryDirectory here;
  File file{here.path() / "file", OpenMode::kCreate};
};

/// A pipe whose read end waits until the kernel has refused another request.
int pipe_ends[2];
std::atomic<bool> read_completed = false;
std::atomic<int> refusals = 0;

/// Takes no request while the read of the pipe has not completed, as a kernel whose completion
/// queue is full; for good if that lasts.
int submit_after_the_pipe(io_uring* ring) {
  if (read_completed) return ::io_uring_submit(ring);
  if (++refusals > 2000) return -EPERM;
  constexpr char kByte = 1;
  if (refusals == 1 && ::write(pipe_ends[1], &kByte, 1) != 1) return -EPERM;
  return -EBUSY;
}

/// Reads the pipe.
class PipeRequest final : public RingRequest {
 public:
  void completed(int) noexcept override { read_completed = true; }
};

}  // namespace

TEST_CASE("UringRingSubmit_QueueFullUntilACompletionIsTaken_LetsItBeTaken") {
  fail_submits(0, 0);
  static bool piped = false;
  piped = false;
  std::unique_ptr<UringRing> ring;
  try {
    ring = std::make_unique<UringRing>(
        [](io_uring* of) { return piped ? submit_after_the_pipe(of) : ::io_uring_submit(of); });
  } catch (const Error& error) {
    skip(error.what());
    return;
  }
  REQUIRE(::pipe(pipe_ends) == 0);
  std::vector<std::byte> memory(1), other(kBytes, std::byte{3});
  PipeRequest pipe_request;
  ring->submit(UringRing::Operation::kRead, pipe_ends[0], 0, memory, pipe_request);
  piped = true;
  Disk disk;
  Request request;
  ring->submit(UringRing::Operation::kWrite, disk.file.descriptor(), 0, other, request);
  CHECK(request.wait() == static_cast<int>(kBytes));
  while (!read_completed) std::this_thread::yield();
  ring.reset();
  ::close(pipe_ends[0]);
  ::close(pipe_ends[1]);
}

TEST_CASE("UringRingSubmit_RefusedForGood_NeverTouchesTheMemory") {
  const std::unique_ptr<UringRing> ring = make_ring();
  if (!ring) return;
  Disk disk;
  disk.file.write_at(0, std::vector<std::byte>(kBytes, std::byte{1}));
  for (const int error : {ENOMEM, EPERM}) {
    std::vector<std::byte> refused(kBytes, std::byte{7}), taken(kBytes);
    // Freed as soon as it completed, as by a backend.
    auto request = std::make_unique<Request>();
    fail_submits(error, 1);
    ring->submit(UringRing::Operation::kRead, disk.file.descriptor(), 0, refused, *request);
    CHECK(request->wait() == -error);
    request.reset();
    // The next one hands over what is still in the queue.
    Request next;
    ring->submit(UringRing::Operation::kRead, disk.file.descriptor(), 0, taken, next);
    CHECK(next.wait() == static_cast<int>(kBytes));
    CHECK(taken == std::vector<std::byte>(kBytes, std::byte{1}));
    CHECK(refused == std::vector<std::byte>(kBytes, std::byte{7}));
  }
}

TEST_CASE("UringRingSubmit_RefusedMoreOftenThanTheQueueIsLong_CompletesEachWithAnError") {
  const std::unique_ptr<UringRing> ring = make_ring();
  if (!ring) return;
  Disk disk;
  disk.file.write_at(0, std::vector<std::byte>(kBytes, std::byte{1}));
  std::vector<std::byte> memory(kBytes);
  constexpr int kTimes = 600;
  fail_submits(ENOMEM, kTimes);
  for (int i = 0; i < kTimes && failures_left > 0; ++i) {
    Request request;
    ring->submit(UringRing::Operation::kRead, disk.file.descriptor(), 0, memory, request);
    REQUIRE(request.wait() < 0);
    if (i > 300) fail_submits(0, 0);
  }
  Request next;
  ring->submit(UringRing::Operation::kRead, disk.file.descriptor(), 0, memory, next);
  CHECK(next.wait() == static_cast<int>(kBytes));
}

TEST_CASE("UringRingSubmit_RefusedForTheMoment_IsOfferedAgainWhileOthersComplete") {
  const std::unique_ptr<UringRing> ring = make_ring();
  if (!ring) return;
  Disk disk;
  for (const int error : {EBUSY, EAGAIN, EINTR}) {
    constexpr std::uint64_t kThreads = 4, kEach = 50;
    std::array<std::vector<std::byte>, kThreads> memory;
    std::array<std::array<Request, kEach>, kThreads> requests;
    std::vector<std::thread> threads;
    fail_submits(error, 300);
    for (std::uint64_t i = 0; i < kThreads; ++i)
      threads.emplace_back([&, i] {
        memory[i].assign(kBytes, static_cast<std::byte>(i + 1));
        for (std::uint64_t k = 0; k < kEach; ++k)
          ring->submit(UringRing::Operation::kWrite, disk.file.descriptor(),
                       (i * kEach + k) * kBytes, memory[i], requests[i][k]);
        // The kernel cancels what a thread began that has ended since.
        for (Request& request : requests[i]) request.wait();
      });
    for (std::thread& thread : threads) thread.join();
    for (std::uint64_t i = 0; i < kThreads; ++i)
      for (std::uint64_t k = 0; k < kEach; ++k) {
        CHECK(requests[i][k].wait() == static_cast<int>(kBytes));
        CHECK(requests[i][k].calls() == 1);
      }
    std::vector<std::byte> back(kBytes);
    for (std::uint64_t k = 0; k < kThreads * kEach; ++k) {
      disk.file.read_at(k * kBytes, back);
      CHECK(back == memory[k / kEach]);
    }
  }
}

}  // namespace plait::test
