// What frames count: never more memory than there may be, and all that is free again.
#include <malloc.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include "paging/frame_pool.h"

namespace plait::test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryIsCounted = false;  // their allocators are not asked
#else
constexpr bool kMemoryIsCounted = true;
#endif

constexpr std::int64_t kSmallThings = 64 << 10;

std::int64_t held_bytes() {
  if (!kMemoryIsCounted) return 0;
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
}

struct ProcessBytes {
  std::int64_t mapped = 0, resident = 0;
};

ProcessBytes process_bytes() {
  ProcessBytes pages;
  std::ifstream("/proc/self/statm") >> pages.mapped >> pages.resident;
  const std::int64_t page = ::sysconf(_SC_PAGESIZE);
  return {pages.mapped * page, pages.resident * page};
}

/// Without free memory that the allocator keeps.
std::int64_t resident_bytes() {
  ::malloc_trim(0);
  return process_bytes().resident;
}

}  // namespace

TEST_CASE("FramePool_IdleFramesOfOneSize_MakeRoomForThoseOfAnother") {
  constexpr std::uint64_t kSmall = 64 << 10, kLarge = 1 << 20, kBudget = 4 << 20;
  FramePool pool(kBudget);
  pool.prepare(kSmall);
  pool.prepare(kLarge);
  const auto fill = [&](std::uint64_t bytes) {
    std::vector<std::byte*> frames;
    while (std::byte* const frame = pool.take(bytes)) frames.push_back(frame);
    CHECK(frames.size() * bytes == kBudget);
    for (std::byte* const frame : frames) pool.give_back(frame, bytes);
  };
  // Each frame that is aligned wastes some bytes.
  const std::int64_t before = held_bytes(), most = kBudget + kBudget / 8 + kSmallThings;
  for (int round = 0; round < 3; ++round) {
    fill(kSmall);
    CHECK(held_bytes() - before <= most);
    fill(kLarge);
    CHECK(held_bytes() - before <= most);
  }
  CHECK(pool.used_bytes() == 0);
  CHECK(pool.peak_bytes() == kBudget);
}

TEST_CASE("FramePool_FramesOfSlabs_AreApartAndMakeRoomForThoseOfAnotherSize") {
  struct Sizes {
    std::uint64_t budget, one, other;
  };
  // Two frames of the second budget's first size fill a huge page but for two pages.
  const Sizes of = GENERATE(Sizes{160 << 20, 768 << 10, (300 << 10) & ~4095u},
                            Sizes{34 << 20, 1020 << 10, (300 << 10) & ~4095u},
                            Sizes{64 << 20, 4 << 10, 12 << 10}, Sizes{16 << 20, 4 << 10, 12 << 10});
  FramePool pool(of.budget);
  pool.prepare(of.one);
  pool.prepare(of.other);
  const ProcessBytes before = process_bytes();
  const auto budget = static_cast<std::int64_t>(of.budget);
  const std::int64_t held_before = held_bytes(), most = budget + (4 << 20);
  const auto fill = [&](std::uint64_t bytes) {
    std::vector<std::byte*> frames;
    while (std::byte* const frame = pool.take(bytes)) {
      std::memset(frame, static_cast<int>(frames.size() % 251), bytes);
      frames.push_back(frame);
    }
    CHECK(frames.size() == of.budget / bytes);
    for (std::size_t at = 0; at < frames.size(); ++at)
      for (const std::uint64_t offset : {std::uint64_t{0}, bytes / 2, bytes - 1})
        REQUIRE(frames[at][offset] == static_cast<std::byte>(at % 251));
    if (kMemoryIsCounted) {
      CHECK(resident_bytes() - before.resident <= most);
      // Slabs of the other size are gone, and nothing is mapped beside a slab.
      CHECK(process_bytes().mapped - before.mapped <= most + (8 << 20));
      // Most frames are of slabs, which the allocator does not count.
      CHECK(held_bytes() - held_before < budget / 4);
    }
    for (std::byte* const frame : frames) pool.give_back(frame, bytes);
  };
  for (int round = 0; round < 2; ++round) {
    fill(of.one);
    fill(of.other);
  }
  CHECK(pool.used_bytes() == 0);
  CHECK(pool.peak_bytes() <= of.budget);
  pool.release();
  if (kMemoryIsCounted) CHECK(resident_bytes() - before.resident <= 4 << 20);
  std::byte* const again = pool.take(of.one);
  REQUIRE(again != nullptr);
  pool.give_back(again, of.one);
}

TEST_CASE("FramePool_FramesInAnyOrder_KeepTheirBytesWithinTheBudget") {
  constexpr std::uint64_t kBudget = 160 << 20;
  constexpr std::uint64_t kSizes[] = {4 << 10, 64 << 10, 300 << 10, 512 << 10, 5 << 20};
  FramePool pool(kBudget);
  for (const std::uint64_t bytes : kSizes) pool.prepare(bytes);
  std::mt19937 random(28);
  struct Taken {
    std::uint64_t bytes;
    std::byte content;
  };
  std::map<std::byte*, Taken> taken;
  std::uint64_t used = 0, taken_ever = 0;
  const std::int64_t before = resident_bytes();
  const auto check = [&](const std::byte* frame, const Taken& of) {
    for (std::uint64_t at = 0; at < of.bytes; at += 4096) REQUIRE(frame[at] == of.content);
    REQUIRE(frame[of.bytes - 1] == of.content);
  };
  const auto give_back = [&](std::map<std::byte*, Taken>::iterator which) {
    check(which->first, which->second);
    pool.give_back(which->first, which->second.bytes);
    used -= which->second.bytes;
    taken.erase(which);
  };
  for (int phase = 0; phase < 16; ++phase) {
    // Mostly one size, so that the others make room for it.
    const std::uint64_t usual = kSizes[random() % std::size(kSizes)];
    for (int step = 0; step < 300; ++step) {
      const std::uint64_t bytes = random() % 8 == 0 ? kSizes[random() % std::size(kSizes)] : usual;
      std::byte* const frame = pool.take(bytes);
      REQUIRE((frame != nullptr) == (used + bytes <= kBudget));
      if (!frame) break;
      const Taken now{bytes, static_cast<std::byte>(++taken_ever)};
      std::memset(frame, static_cast<int>(now.content), bytes);
      const auto [place, is_new] = taken.emplace(frame, now);
      REQUIRE(is_new);
      used += bytes;
      if (place != taken.begin())
        REQUIRE(std::prev(place)->first + std::prev(place)->second.bytes <= frame);
      if (std::next(place) != taken.end()) REQUIRE(frame + bytes <= std::next(place)->first);
      REQUIRE(pool.used_bytes() == used);
    }
    if (kMemoryIsCounted)
      CHECK(resident_bytes() - before <= static_cast<std::int64_t>(kBudget) + (8 << 20));
    const std::uint64_t kept = random() % 4 == 0 ? 0 : random() % (kBudget / 2);
    while (used > kept) {
      const auto at = static_cast<std::ptrdiff_t>(random() % taken.size());
      give_back(std::next(taken.begin(), at));
    }
  }
  while (!taken.empty()) give_back(taken.begin());
  pool.release();
  if (kMemoryIsCounted) CHECK(resident_bytes() - before <= 8 << 20);
}

}  // namespace plait::test
