#include "plait/extend/level_geometry.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "plait/error.h"
#include "plait/extend/edge_index.h"

namespace plait {
namespace {

/// A shape for every edge, at random.
std::vector<SlotShape> random_shapes(std::uint64_t edge_count, unsigned half_percent,
                                     unsigned absent_percent, std::mt19937& random) {
  std::vector<SlotShape> shapes;
  while (shapes.size() < edge_count) {
    const auto roll = random() % 100;
    shapes.push_back(roll < half_percent                    ? SlotShape::kHalf
                     : roll < half_percent + absent_percent ? SlotShape::kAbsent
                                                            : SlotShape::kWhole);
  }
  return shapes;
}

SlotShapes shapes_of(const std::vector<SlotShape>& shapes) {
  std::vector<EdgeId> half, absent;
  for (EdgeId edge = 0; edge < shapes.size(); ++edge) {
    if (shapes[edge] == SlotShape::kHalf) half.push_back(edge);
    if (shapes[edge] == SlotShape::kAbsent) absent.push_back(edge);
  }
  return {shapes.size(), EdgeSet(half), EdgeSet(absent)};
}

std::uint64_t bytes_of(SlotShape shape, const LevelGeometry& geometry) {
  const auto n = std::uint64_t{1} << (geometry.level().refinements - 1);
  const std::uint64_t records = shape == SlotShape::kWhole  ? n * n
                                : shape == SlotShape::kHalf ? n * (n + 1) / 2
                                                            : 0;
  return records * geometry.record_bytes();
}

/// Every answer of `geometry` against a walk over the edges that adds up bytes.
void check_against_walk(const LevelGeometry& geometry, const std::vector<SlotShape>& shapes) {
  const auto slots_per_block = std::uint64_t{1} << geometry.slots_per_block_log2();
  std::uint64_t offset = 0, slots = 0, block_begin = 0;
  EdgeId block_first = 0;
  for (EdgeId edge = 0; edge < shapes.size(); ++edge) {
    const Slot slot = geometry.slot(edge);
    REQUIRE(slot.offset == offset);
    REQUIRE(slot.bytes == bytes_of(shapes[edge], geometry));
    REQUIRE(slot.shape == shapes[edge]);
    offset += slot.bytes;
    if (geometry.block_count() != 0) {
      const std::uint64_t block = geometry.block_of(edge);
      REQUIRE(geometry.first_edge(block) <= edge);
      REQUIRE(edge < geometry.edge_after(block));
    }
    if (slot.shape == SlotShape::kAbsent) continue;
    const std::uint64_t block = slots / slots_per_block;
    REQUIRE(geometry.block_of(edge) == block);
    if (++slots % slots_per_block != 0 && slots != geometry.block_count() * slots_per_block)
      continue;
    // The slot is the last one of its block.
    REQUIRE(geometry.first_edge(block) == block_first);
    REQUIRE(geometry.block_offset(block) == block_begin);
    REQUIRE(geometry.block_bytes(block) == offset - block_begin);
    REQUIRE(geometry.block_bytes(block) > 0);
    REQUIRE(geometry.slot_count(block) == slots - block * slots_per_block);
    REQUIRE(geometry.block_bytes(block) <= geometry.max_block_bytes());
    block_first = edge + 1;
    block_begin = offset;
  }
  REQUIRE(geometry.block_count() == (slots + slots_per_block - 1) / slots_per_block);
  CHECK(geometry.total_bytes() == offset);
  CHECK(geometry.block_offset(geometry.block_count()) == offset);
  CHECK(geometry.range_bytes(0, geometry.block_count()) == offset);
  CHECK(geometry.first_edge(geometry.block_count()) == shapes.size());
  // The blocks' ranges of edges follow one another, and so do their bytes.
  for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
    REQUIRE(geometry.first_edge(block) < geometry.edge_after(block));
    REQUIRE(geometry.edge_after(block) == geometry.first_edge(block + 1));
    REQUIRE(geometry.block_offset(block) + geometry.block_bytes(block) ==
            geometry.block_offset(block + 1));
  }
}

bool refused(const SlotShapes& shapes, int level, std::size_t record_bytes) {
  try {
    [[maybe_unused]] const LevelGeometry geometry(shapes, BaseRelativeLevel(level), record_bytes,
                                                  1 << 20);
    return false;
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return true;
  }
}

bool refused(std::uint64_t edge_count, const std::vector<EdgeId>& half,
             const std::vector<EdgeId>& absent) {
  try {
    [[maybe_unused]] const SlotShapes shapes(edge_count, EdgeSet(half), EdgeSet(absent));
    return false;
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return true;
  }
}

}  // namespace

TEST_CASE("LevelGeometry_RandomShapes_AgreesWithAWalkOverTheSlots") {
  std::mt19937 random(1);
  for (const std::uint64_t edge_count : {1u, 2u, 3u, 37u, 64u, 500u})
    for (const unsigned half_percent : {0u, 3u, 50u, 100u})
      for (const unsigned absent_percent : {0u, 40u, 95u})
        for (const int level : {1, 2, 3, 7})
          for (const std::size_t record_bytes : {1u, 12u, 24u})
            for (const std::uint64_t block_bytes : {0u, 4096u, 65536u, 1u << 20}) {
              const auto shapes = random_shapes(edge_count, half_percent, absent_percent, random);
              check_against_walk(
                  {shapes_of(shapes), BaseRelativeLevel(level), record_bytes, block_bytes}, shapes);
            }
}

TEST_CASE("LevelGeometry_BlockBytes_BoundTheSlotsOfABlock") {
  // Slots of 192 bytes: 16 records of 12.
  const auto slots_log2 = [](std::uint64_t edge_count, std::uint64_t block_bytes) {
    return LevelGeometry(SlotShapes(edge_count), BaseRelativeLevel(3), 12, block_bytes)
        .slots_per_block_log2();
  };
  CHECK(slots_log2(1000, 4096) == 4);  // 3072 bytes
  CHECK(slots_log2(1000, 3072) == 4);
  CHECK(slots_log2(1000, 3071) == 3);
  CHECK(slots_log2(1000, 0) == 0);
  CHECK(slots_log2(1000, 191) == 0);
  CHECK(slots_log2(1000, ~std::uint64_t{0}) == 10);  // no more than the level has
  CHECK(slots_log2(1024, ~std::uint64_t{0}) == 10);
  CHECK(slots_log2(1025, ~std::uint64_t{0}) == 11);
  CHECK(slots_log2(1, ~std::uint64_t{0}) == 0);

  const LevelGeometry one_block(SlotShapes(1000), BaseRelativeLevel(3), 12, 1 << 20);
  CHECK(one_block.block_count() == 1);
  CHECK(one_block.max_block_bytes() == 192000);
}

TEST_CASE("LevelGeometry_DeepestLevel_IsExact") {
  const std::vector<EdgeId> half = {0, 2};
  const LevelGeometry geometry(SlotShapes(3, EdgeSet(half)), BaseRelativeLevel(kMaxLevel), 24,
                               1 << 20);
  const std::uint64_t n = std::uint64_t{1} << 19;
  CHECK(geometry.slots_per_block_log2() == 0);
  CHECK(geometry.slot(1).offset == n * (n + 1) / 2 * 24);
  CHECK(geometry.slot(2).offset == n * (n + 1) / 2 * 24 + n * n * 24);
  CHECK(geometry.total_bytes() == n * (n + 1) * 24 + n * n * 24);
}

TEST_CASE("LevelGeometry_NoSlots_IsEmpty") {
  const std::vector<EdgeId> all = {0, 1, 2};
  for (const SlotShapes& shapes : {SlotShapes(), SlotShapes(3, {}, EdgeSet(all))}) {
    const LevelGeometry geometry(shapes, BaseRelativeLevel(1), 12, 4096);
    CHECK(geometry.block_count() == 0);
    CHECK(geometry.total_bytes() == 0);
  }
}

TEST_CASE("LevelGeometry_ArgumentsOutOfRange_AreRefused") {
  CHECK_FALSE(refused(SlotShapes(10), 1, 1));
  CHECK_FALSE(refused(SlotShapes(10), kMaxLevel, 2040));
  CHECK(refused(SlotShapes(10), 0, 12));
  CHECK(refused(SlotShapes(10), kMaxLevel + 1, 12));
  CHECK(refused(SlotShapes(10), -1, 12));
  CHECK(refused(SlotShapes(10), 3, 0));
  CHECK(refused(SlotShapes(kNoId), 1, 1));
  CHECK(refused(SlotShapes(kNoId - 1), kMaxLevel, 12));  // 2^32 slots of 2^38 records
  CHECK(refused(SlotShapes(10), kMaxLevel, ~std::size_t{0}));
}

TEST_CASE("SlotShapes_ImpossibleSets_AreRefused") {
  CHECK_FALSE(refused(4, {0, 3}, {1, 2}));
  CHECK(refused(2, {0, 2}, {}));  // an edge that is not there
  CHECK(refused(2, {}, {7}));
  CHECK(refused(200, {5, 130}, {6, 130}));  // half and absent
}

TEST_CASE("LevelGeometry_InShards_BeginsABlockAtEachOfThem") {
  std::mt19937 random(5);
  for (const unsigned half_percent : {0u, 20u}) {
    const std::vector<SlotShape> shapes = random_shapes(300, half_percent, 0, random);
    for (const int level : {1, 3, 5})
      for (const std::uint64_t block_bytes : {4096u, 65536u}) {
        const LevelGeometry whole(shapes_of(shapes), BaseRelativeLevel(level), 12, block_bytes);
        const EdgeShards shards({0, 1, 2, 64, 65, 200, 299}, 300);
        const LevelGeometry cut = whole.in_shards(shards);
        const auto slots_per_block = std::uint64_t{1} << cut.slots_per_block_log2();
        std::uint64_t block = 0;
        for (std::uint32_t shard = 0; shard < shards.size(); ++shard) {
          CAPTURE(half_percent, level, block_bytes, shard);
          const LevelGeometry alone = cut.shard(shard);
          const EdgeId first = shards.first_edge(shard), after = shards.edge_after(shard);
          REQUIRE(cut.first_block(shard) == block);
          REQUIRE(alone.block_count() == (after - first + slots_per_block - 1) / slots_per_block);
          for (const int other : {1, 2, 5}) {
            const LevelGeometry of_other(shapes_of(shapes), BaseRelativeLevel(other), 12,
                                         block_bytes);
            REQUIRE(alone.total_bytes_at(BaseRelativeLevel(other)) ==
                    of_other.in_shards(shards).shard(shard).total_bytes());
          }
          std::uint64_t offset = 0;
          for (EdgeId edge = first; edge < after; ++edge) {
            REQUIRE(shards.shard_of(edge) == shard);
            // In the whole level, a slot is where it is without shards.
            REQUIRE(cut.slot(edge).offset == whole.slot(edge).offset);
            const Slot slot = alone.slot(edge);
            REQUIRE(slot.offset == offset);
            REQUIRE(slot.bytes == bytes_of(shapes[edge], whole));
            REQUIRE(slot.shape == shapes[edge]);
            offset += slot.bytes;
            const std::uint64_t number = (edge - first) / slots_per_block;
            REQUIRE(alone.block_of(edge) == number);
            REQUIRE(cut.block_of(edge) == block + number);
          }
          REQUIRE(alone.total_bytes() == offset);
          for (std::uint64_t number = 0; number < alone.block_count(); ++number) {
            const auto begin = static_cast<EdgeId>(first + number * slots_per_block);
            REQUIRE(alone.first_edge(number) == begin);
            REQUIRE(cut.first_edge(block + number) == begin);
            REQUIRE(cut.edge_after(block + number) == alone.edge_after(number));
            REQUIRE(cut.block_bytes(block + number) == alone.block_bytes(number));
            REQUIRE(cut.shard_of_block(block + number) == shard);
            REQUIRE(cut.block_at(cut.block_offset(block + number)) == block + number);
          }
          block += alone.block_count();
        }
        REQUIRE(cut.block_count() == block);
        REQUIRE(cut.first_block(shards.size()) == block);
        REQUIRE(cut.total_bytes() == whole.total_bytes());
      }
  }
}

TEST_CASE("LevelGeometry_InShardsWithAbsentSlots_GivesEachEdgeABlockThatHasIt") {
  std::mt19937 random(7);
  const EdgeShards shards({0, 1, 2, 64, 65, 200, 299}, 300);
  for (unsigned round = 0; round < 200; ++round) {
    std::vector<SlotShape> shapes = random_shapes(300, 20, 10 * (round % 10), random);
    for (std::uint32_t shard = 0; shard < shards.size(); ++shard)
      if (random() % 2 == 0)
        std::fill(shapes.begin() + shards.first_edge(shard),
                  shapes.begin() + shards.edge_after(shard), SlotShape::kAbsent);
    const LevelGeometry whole(shapes_of(shapes), BaseRelativeLevel(3), 12, 4096);
    const LevelGeometry cut = whole.in_shards(shards);
    if (cut.block_count() == 0) continue;
    CAPTURE(round);
    for (EdgeId edge = 0; edge < shapes.size(); ++edge) {
      const std::uint64_t block = cut.block_of(edge);
      REQUIRE(block < cut.block_count());
      REQUIRE(cut.first_edge(block) <= edge);
      REQUIRE(edge < cut.edge_after(block));
      if (shapes[edge] != SlotShape::kAbsent)
        REQUIRE(cut.shard_of_block(block) == shards.shard_of(edge));
    }
    REQUIRE(cut.first_edge(0) == 0);
    std::uint64_t offset = 0;
    for (std::uint64_t block = 0; block < cut.block_count(); ++block) {
      REQUIRE(cut.block_offset(block) == offset);
      REQUIRE(cut.block_bytes(block) > 0);
      offset += cut.block_bytes(block);
    }
    REQUIRE(offset == whole.total_bytes());
  }
}

TEST_CASE("EdgeShards_StartsThatDoNotAscendFromZero_AreRefused") {
  CHECK_THROWS_AS(EdgeShards({}, 10), Error);
  CHECK_THROWS_AS(EdgeShards({1, 2}, 10), Error);
  CHECK_THROWS_AS(EdgeShards({0, 3, 3}, 10), Error);
  CHECK_THROWS_AS(EdgeShards({0, 10}, 10), Error);
}

}  // namespace plait
