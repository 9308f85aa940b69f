// How many page buffers a volume has, how large they are, and that nobody gets a buffer that is too
// small.
#include "uring/page_buffers.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <optional>
#include <thread>
#include <vector>

namespace plait::test {
namespace {

constexpr std::uint64_t kBufferBytes = 16 * kPageBytes;

}  // namespace

TEST_CASE("PageBuffers_LevelsWhoseBlocksBeginOnPages_HaveOneBufferThatIsNotCounted") {
  PageBuffers buffers(100 * kBufferBytes);
  buffers.make_room_for(kBufferBytes, false);
  CHECK(buffers.count() == 1);
  CHECK(buffers.memory_bytes() == 0);
  const PageBuffers::Lease lease(buffers);
  std::memset(lease.get(), 1, kBufferBytes);
}

TEST_CASE("PageBuffers_LevelsWhoseBlocksSharePages_HaveAsManyAsTheMemoryAllows") {
  PageBuffers ample(100 * kBufferBytes), scarce(3 * kBufferBytes + 1), smallest(kPageBytes);
  for (PageBuffers* const buffers : {&ample, &scarce, &smallest}) {
    buffers->make_room_for(kBufferBytes, true);
    buffers->make_room_for(kPageBytes, false);
  }
  CHECK(ample.count() == PageBuffers::kMostBuffers);
  CHECK(ample.memory_bytes() == PageBuffers::kMostBuffers * kBufferBytes);
  CHECK(scarce.count() == 3);
  CHECK(scarce.memory_bytes() == 3 * kBufferBytes);
  CHECK(smallest.count() == 1);
  CHECK(smallest.memory_bytes() == kPageBytes);  // no more than it was allowed
}

TEST_CASE("PageBuffers_GivenBack_AreUsedAgain") {
  PageBuffers buffers(kBufferBytes);
  buffers.make_room_for(kBufferBytes, true);
  const std::byte* first = nullptr;
  {
    const PageBuffers::Lease lease(buffers);
    first = lease.get();
    CHECK(reinterpret_cast<std::uintptr_t>(first) % kPageBytes == 0);
  }
  CHECK(PageBuffers::Lease(buffers).get() == first);
}

TEST_CASE("PageBuffers_LargerBlocksWhileABufferIsInUse_DoNotGetThatBuffer") {
  PageBuffers buffers(100 * kBufferBytes);
  buffers.make_room_for(kPageBytes, true);
  { const PageBuffers::Lease small(buffers), other(buffers); }
  std::optional<PageBuffers::Lease> small(buffers);
  buffers.make_room_for(kBufferBytes, false);
  small.reset();
  std::vector<PageBuffers::Lease> all;
  for (std::uint64_t i = 0; i < buffers.count(); ++i) {
    all.emplace_back(buffers);
    std::memset(all.back().get(), 1, kBufferBytes);  // the address sanitizer looks on
    CHECK(all.back().get()[kBufferBytes - 1] == std::byte{1});
  }
}

TEST_CASE("PageBuffers_MoreThreadsThanBuffers_WaitAndEachHasItsOwn") {
  PageBuffers buffers(2 * kBufferBytes);
  buffers.make_room_for(kBufferBytes, true);
  std::atomic<int> under_way = 0, most = 0;
  std::atomic<bool> shared = false;
  std::vector<std::thread> threads;
  for (int number = 0; number < 6; ++number)
    threads.emplace_back([&, number] {
      for (int round = 0; round < 50; ++round) {
        const PageBuffers::Lease lease(buffers);
        const int now = ++under_way;
        int before = most;
        while (now > before && !most.compare_exchange_weak(before, now)) {
        }
        std::memset(lease.get(), number, kPageBytes);
        std::this_thread::yield();
        for (std::size_t i = 0; i < kPageBytes; ++i)
          if (lease.get()[i] != static_cast<std::byte>(number)) shared = true;
        --under_way;
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK_FALSE(shared);
  CHECK(most <= 2);
}

}  // namespace plait::test
