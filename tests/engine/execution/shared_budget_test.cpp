// Stores that share a budget: their frames together stay below it, whatever their threads do, and
// the memory is where it is needed.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <random>
#include <thread>

#include "engine/execution/numbered_store.h"
#include "plait/extend/budget.h"
#include "plait/reader.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

namespace {

// All memory of frames is allocated with this alignment, and nothing else here is.
constexpr std::size_t kFrameAlignment = 4096;
std::atomic<std::uint64_t> frame_bytes = 0, most_frame_bytes = 0;

}  // namespace

void* operator new(std::size_t bytes, std::align_val_t alignment) {
  // The size is in front of the memory, because not every delete knows it.
  const auto step = static_cast<std::size_t>(alignment);
  auto* const memory =
      static_cast<std::byte*>(std::aligned_alloc(step, (bytes + step - 1) / step * step + step));
  if (!memory) throw std::bad_alloc();
  *reinterpret_cast<std::size_t*>(memory) = bytes;
  if (step == kFrameAlignment) {
    const std::uint64_t now = frame_bytes += bytes;
    std::uint64_t most = most_frame_bytes;
    while (now > most && !most_frame_bytes.compare_exchange_weak(most, now)) {
    }
  }
  return memory + step;
}
void operator delete(void* memory, std::align_val_t alignment) noexcept {
  if (!memory) return;
  const auto step = static_cast<std::size_t>(alignment);
  std::byte* const first = static_cast<std::byte*>(memory) - step;
  if (step == kFrameAlignment) frame_bytes -= *reinterpret_cast<std::size_t*>(first);
  std::free(first);
}
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept {
  operator delete(memory, alignment);
}

namespace plait::test {
namespace {

constexpr std::uint64_t kPart = 256 << 10;
constexpr FaceId kFaces = 288;  ///< 1.2 MB of records

BaseMesh mesh() { return BaseMesh::build(torus_grid(12, 12)); }

Store open(const OnDisk& disk, const std::shared_ptr<Budget>& budget,
           std::uint64_t part_bytes = kPart) {
  OpenOptions options;
  options.budget_bytes = part_bytes;
  options.budget = budget;
  return Store::open(disk.path, options, default_backends());
}

bool is_right(const PatchView& patch, const OnDisk& disk) {
  const AttributeView<Wide> vertices = patch.attribute<Wide>("vertex");
  const std::int64_t i = patch.size() / 2;
  return vertices.at(i, 1).vertex == disk.expected.vertex({patch.face(), {kSize - i - 1, i, 1}});
}

void read_all(const Reader& reader) {
  for (FaceId face = 0; face < kFaces; ++face) reader.read_patch(face, kLevels);
}

}  // namespace

TEST_CASE("Budget_SeveralStoresAndThreads_StayBelowIt") {
  const auto backend = GENERATE(as<std::string>(), "pread", "compressed");
  const OnDisk disk(backend, mesh());
  const std::uint64_t bytes = 2 << 20;
  const auto budget = std::make_shared<Budget>(bytes);
  const std::uint64_t before = frame_bytes;
  most_frame_bytes = before;
  std::atomic<std::uint64_t> wrong = 0;
  std::vector<std::thread> threads;
  for (unsigned number = 0; number < 4; ++number)
    threads.emplace_back([&, number] {
      std::mt19937 random(number);
      for (int turn = 0; turn < 4; ++turn) {  // stores come and go
        const Store store = open(disk, budget);
        const Reader reader(store);
        std::vector<std::thread> readers;
        for (unsigned second = 0; second < 2; ++second)
          readers.emplace_back([&, seed = random() + second] {
            std::mt19937 faces(seed);
            for (int count = 0; count < 40; ++count)
              wrong += !is_right(reader.read_patch(static_cast<FaceId>(faces() % kFaces), kLevels),
                                 disk);
          });
        for (std::thread& reading : readers) reading.join();
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(most_frame_bytes - before <= bytes);
  CHECK(most_frame_bytes - before > 2 * kPart);  // they have borrowed
  CHECK(frame_bytes == before);
  CHECK(budget->part_bytes() == 0);
  CHECK(budget->lent_bytes() == 0);
}

TEST_CASE("Budget_OneStoreAlone_BorrowsTheRestAndGivesItBack") {
  const OnDisk disk("pread", mesh());
  const auto budget = std::make_shared<Budget>(4 << 20);
  const Store first = open(disk, budget);
  const Reader reader(first);
  read_all(reader);
  const std::uint64_t alone = budget->lent_bytes();
  CHECK(alone > 0);
  {
    const std::uint64_t read = reader.statistics().blocks_read;
    read_all(reader);
    CHECK(reader.statistics().blocks_read == read);  // everything is in memory
  }
  const Store second = open(disk, budget, 7 << 19);
  CHECK(budget->part_bytes() == kPart + (7 << 19));
  CHECK(budget->lent_bytes() <= kPart);
  read_all(reader);
  read_all(Reader(second));
  CHECK(budget->lent_bytes() <= kPart);
}

TEST_CASE("Budget_PartsThatDoNotFit_AreRefusedInWords") {
  const OnDisk disk("pread", mesh());
  const auto budget = std::make_shared<Budget>(2 * kPart);
  const Store first = open(disk, budget);
  const auto refusal = [&](std::uint64_t part) {
    const Error error = error_of([&] { open(disk, budget, part); });
    CHECK(error.code() == ErrorCode::kBudget);
    return error;
  };
  CHECK(names(refusal(2 * kPart), {"524288 bytes of the shared budget", "found 262144 of 524288",
                                   "1 stores have parts of 262144"}));
  refusal(~std::uint64_t{0});
  CHECK(budget->part_bytes() == kPart);
  const Store second = open(disk, budget);
  refusal(64 << 10);
}

TEST_CASE("Budget_BorrowedAndPinned_IsRefusedUntilTheViewsEnd") {
  const OnDisk disk("pread", mesh());
  const auto budget = std::make_shared<Budget>(1 << 20);
  const Store first = open(disk, budget, 128 << 10);
  const Reader reader(first);
  std::vector<PatchView> views;
  const Error full = error_of([&] {
    for (FaceId face = 0; face < kFaces; ++face) views.push_back(reader.read_patch(face, kLevels));
  });
  CHECK(names(full, {"lends no more", "views of patches are open"}));
  CHECK(budget->lent_bytes() > (512 << 10));
  const Error error = error_of([&] { open(disk, budget); });
  CHECK(error.code() == ErrorCode::kBudget);
  CHECK(names(error, {"have borrowed"}));
  views.clear();
  const Store second = open(disk, budget);
  CHECK(budget->lent_bytes() <= (1 << 20) - kPart - (128 << 10));
  read_all(Reader(second));
  read_all(reader);
}

}  // namespace plait::test
