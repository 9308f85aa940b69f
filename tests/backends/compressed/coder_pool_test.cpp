// How much memory the coders of a store take, and that they take no more.
#include "compressed/coder_pool.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "backends/conformance.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBlockBytes = 256 << 10;
constexpr int kThreads = 6;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryIsCounted = false;  // their allocators are not asked
#else
constexpr bool kMemoryIsCounted = true;
#endif

std::int64_t bytes_in_use() {
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
}

Filters filters_of(const std::string& pipeline, ComponentType type = ComponentType::kFloat32) {
  return default_pipelines().open(pipeline, {.schema = {.type = type}}).filters;
}

/// Every thread codes blocks of several sizes; false if one did not come back as it was.
bool code_in_threads(CoderPool& pool, const std::string& pipeline) {
  std::atomic<bool> same = true;
  std::vector<std::thread> threads;
  for (int number = 0; number < kThreads; ++number)
    threads.emplace_back([&, number] {
      for (const std::uint64_t bytes : {kBlockBytes, kBlockBytes / 2, std::uint64_t{20'000}}) {
        const auto raw = make_content(bytes, Content::kSmooth, static_cast<std::uint32_t>(number));
        std::vector<std::byte> back(bytes);
        const Filters filters = filters_of(
            pipeline, number % 2 == 0 ? ComponentType::kFloat32 : ComponentType::kFloat64);
        CoderPool::Lease coder(pool, {Pipeline(pipeline).codec, 1, number % 2 == 0 ? 0u : 8u});
        const EncodedBlock encoded = coder->encode({filters}, raw);
        if (encoded.encoding == BlockEncoding::kRaw) continue;
        const std::vector<std::byte> stored(encoded.bytes.begin(), encoded.bytes.end());
        coder->decode({filters}, stored, back);
        if (back != raw) same = false;
      }
    });
  for (std::thread& thread : threads) thread.join();
  return same;
}

}  // namespace

TEST_CASE("CoderPool_MoreThreadsThanMemoryFor_TakesWhatItSaysAndGivesItBack", "[threads]") {
  for (const char* codec :
       {"none", "lz4", "bitpack", "zstd:-5", "zstd:1", "zstd:3", "zstd:9", "zstd:19"}) {
    CAPTURE(codec);
    const std::string pipeline = std::string("shuffle,") + codec;
    VolumeSpec volume{~std::uint64_t{0}, 1};
    CoderPool one(default_pipelines(), volume);
    one.make_room_for({Pipeline(pipeline).codec, 1, 8}, kBlockBytes);
    CHECK(one.most_coders() == 1);
    const std::uint64_t coder_bytes = one.memory_bytes();

    volume.threads = kThreads;
    volume.most_scratch_bytes = 3 * coder_bytes + coder_bytes / 2;
    std::thread([] {}).join();
    const std::int64_t before = bytes_in_use();
    CoderPool pool(default_pipelines(), volume);
    pool.make_room_for({Pipeline(pipeline).codec, 1, 0}, kBlockBytes);
    pool.make_room_for({Pipeline(pipeline).codec, 1, 8}, kBlockBytes);
    CHECK(pool.most_coders() == 3);
    CHECK(pool.memory_bytes() == 3 * coder_bytes);
    CHECK(code_in_threads(pool, pipeline));
    constexpr std::int64_t kSmallThings = 64 << 10;
    const std::int64_t taken = bytes_in_use() - before;
    if (kMemoryIsCounted) {
      CHECK(taken <= static_cast<std::int64_t>(pool.memory_bytes()) + kSmallThings);
      CHECK(taken > static_cast<std::int64_t>(coder_bytes / 2));
    }
    pool.shrink();
    if (kMemoryIsCounted) CHECK(bytes_in_use() - before <= kSmallThings);
    CHECK(code_in_threads(pool, pipeline));
  }
}

TEST_CASE("CoderPool_CoderThatCannotBeMade_LeavesRoomForAnother") {
  CoderPool pool(default_pipelines(), {~std::uint64_t{0}, 1});
  const Coding coding{{"lz4"}};
  pool.make_room_for(coding, kBlockBytes);
  REQUIRE(pool.most_coders() == 1);
  CHECK_THROWS_AS(CoderPool::Lease(pool, {{"no-such-codec"}}), Error);
  const CoderPool::Lease coder(pool, coding);  // waits for good if the other one is still counted
}

TEST_CASE("CoderPool_LargerBlocksWhileACoderIsInUse_DoNotGetThatCoder") {
  CoderPool pool(default_pipelines(), {~std::uint64_t{0}, 2});
  const Coding coding{{"none"}, 1};
  pool.make_room_for(coding, 1000);
  {
    const CoderPool::Lease small(pool, coding);
    pool.make_room_for(coding, kBlockBytes);
  }
  CoderPool::Lease coder(pool, coding);
  CHECK(coder->max_raw_bytes() == kBlockBytes);
}

TEST_CASE("CoderPool_LevelsOfSeveralPipelines_ShareTheMemoryOfTheLargest") {
  const Coding small{{"lz4"}}, large{{"zstd", "19"}, 1};
  CoderPool alone(default_pipelines(), {~std::uint64_t{0}, 1});
  alone.make_room_for(large, kBlockBytes);
  CoderPool pool(default_pipelines(), {2 * alone.memory_bytes(), kThreads});
  pool.make_room_for(large, kBlockBytes);
  pool.make_room_for(small, kBlockBytes);
  CHECK(pool.memory_bytes() == 2 * alone.memory_bytes());
  const auto raw = make_content(kBlockBytes, Content::kZeros, 1);
  for (int round = 0; round < 3; ++round)
    for (const Coding& coding : {small, large}) {
      CAPTURE(coding.codec.to_text(), round);
      CoderPool::Lease coder(pool, coding), other(pool, large);
      const Filters filters = filters_of(coding.buffers > 0 ? "shuffle,none" : "none");
      const EncodedBlock encoded = coder->encode({filters}, raw);
      REQUIRE(encoded.encoding == BlockEncoding::kEncoded);
      BlockCoder fresh(default_pipelines().make_codec(coding.codec), kBlockBytes, coding.buffers,
                       coding.scratch_bytes);
      CHECK(std::ranges::equal(fresh.encode({filters}, raw).bytes, encoded.bytes));
    }
}

TEST_CASE("CoderPool_CodersOfSeveralCodings_AreNeverMoreThanThereIsMemoryFor", "[threads]") {
  static int alive = 0;
  class Counted final : public Codec {
   public:
    Counted() { ++alive; }
    ~Counted() override { --alive; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    std::size_t bound(std::size_t raw_bytes) const override { return raw_bytes; }
    std::size_t memory_bytes(std::size_t) const override { return 0; }
    std::optional<std::size_t> compress(std::span<const std::byte>, std::span<std::byte>) override {
      return std::nullopt;
    }
    void decompress(std::span<const std::byte>, std::span<std::byte>) override {}
  };
  PipelineRegistry registry;
  for (const char* name : {"one", "two"})
    registry.add(RegisteredCodec{name, "", [](auto) { return std::make_unique<Counted>(); }});
  const Coding one{{"one"}}, two{{"two"}};
  CoderPool alone(registry, {~std::uint64_t{0}, 1});
  alone.make_room_for(one, kBlockBytes);
  for (const std::size_t most : {std::size_t{1}, std::size_t{2}}) {
    CAPTURE(most);
    CoderPool pool(registry, {most * alone.memory_bytes(), kThreads});
    pool.make_room_for(one, kBlockBytes);
    pool.make_room_for(two, kBlockBytes);
    REQUIRE(pool.most_coders() == most);
    REQUIRE(alive == 0);
    for (int round = 0; round < 3; ++round)
      for (const Coding& coding : {one, two}) {
        {
          std::vector<std::unique_ptr<CoderPool::Lease>> taken;
          while (taken.size() < most)
            taken.push_back(std::make_unique<CoderPool::Lease>(pool, coding));
          CHECK(alive == static_cast<int>(most));
        }
        CHECK(alive == static_cast<int>(most));  // they wait for the next one
      }
    pool.shrink();
    CHECK(alive == 0);
  }
  // A level with larger coders leaves room for one, and two are in use.
  CoderPool pool(registry, {2 * alone.memory_bytes(), kThreads});
  pool.make_room_for(one, kBlockBytes);
  {
    const CoderPool::Lease first(pool, one), second(pool, one);
    pool.make_room_for({{"two"}, 0, static_cast<std::size_t>(alone.memory_bytes())}, kBlockBytes);
    REQUIRE(pool.most_coders() == 1);
  }
  CHECK(alive == 1);
}

TEST_CASE("CoderPool_LessMemoryThanOneCoderNeeds_HasOneAndSaysNoMoreThanIsAllowed", "[threads]") {
  const std::string pipeline = "shuffle,zstd:1";
  CoderPool pool(default_pipelines(), {1000, kThreads});
  pool.make_room_for({Pipeline(pipeline).codec, 1, 8}, kBlockBytes);
  CHECK(pool.most_coders() == 1);
  CHECK(pool.memory_bytes() == 1000);
  CHECK(code_in_threads(pool, pipeline));
}

TEST_CASE("Store_OfCompressedBlocks_SetsTheCodersMemoryAsideAndHasThreeQuartersForFrames") {
  const TemporaryDirectory place;
  StoreOptions options{
      .backend = "compressed", .pipeline = "shuffle,zstd:1", .block_bytes = kBlockBytes};
  for (const std::uint64_t budget : {std::uint64_t{1} << 20, std::uint64_t{64} << 20}) {
    options.budget_bytes = budget;
    Store store = Store::create(place.path() / std::to_string(budget),
                                BaseMesh::build(icosahedron()), options, default_backends());
    CHECK(StoreAccess::pager(store).budget_bytes() > budget - budget / 64);
    const AttributeId a = store.add_attribute(AttributeSchema{"a", ComponentType::kFloat32, 3});
    const AttributeId b = store.add_attribute(AttributeSchema{"b", ComponentType::kInt32, 3});
    for (int level = 1; level <= 8; ++level) store.add_level(a);
    const std::uint64_t for_one = StoreAccess::pager(store).budget_bytes();
    CHECK(for_one < budget);
    CHECK(for_one >= budget - budget / 4);
    for (int level = 1; level <= 8; ++level) store.add_level(b);
    CHECK(StoreAccess::pager(store).budget_bytes() == for_one);  // attributes and levels share them
  }
}

}  // namespace plait::test
