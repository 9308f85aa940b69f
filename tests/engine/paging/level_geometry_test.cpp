#include "plait/level_geometry.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "plait/edge_index.h"
#include "plait/error.h"

namespace plait {
namespace {

std::vector<EdgeId> random_borders(std::uint64_t edge_count, unsigned percent,
                                   std::mt19937& random) {
  std::vector<EdgeId> borders;
  for (EdgeId edge = 0; edge < edge_count; ++edge)
    if (random() % 100 < percent) borders.push_back(edge);
  return borders;
}

/// Every answer of `geometry` against a walk over the slots.
void check_against_walk(const LevelGeometry& geometry, const std::vector<EdgeId>& borders) {
  const auto slot_count = std::uint64_t{1} << geometry.slots_per_block_log2();
  std::uint64_t offset = 0, block_start = 0, block_count = 0;
  for (EdgeId edge = 0; edge < geometry.edge_count(); ++edge) {
    if (edge % slot_count == 0) {
      REQUIRE(geometry.block_offset(block_count) == offset);
      REQUIRE(geometry.first_edge(block_count) == edge);
      block_start = offset;
      ++block_count;
    }
    const bool border = std::find(borders.begin(), borders.end(), edge) != borders.end();
    const std::uint64_t bytes =
        slot_records(geometry.level().refinements, border) * geometry.record_bytes();
    REQUIRE(geometry.is_border(edge) == border);
    REQUIRE(geometry.slot_offset(edge) == offset);
    REQUIRE(geometry.slot_bytes(edge) == bytes);
    REQUIRE(geometry.block_of(edge) == block_count - 1);
    offset += bytes;
    if ((edge + 1) % slot_count == 0 || edge + 1 == geometry.edge_count()) {
      REQUIRE(geometry.edge_after(block_count - 1) == edge + 1);
      REQUIRE(geometry.block_bytes(block_count - 1) == offset - block_start);
      REQUIRE(geometry.block_bytes(block_count - 1) <= geometry.max_block_bytes());
    }
  }
  CHECK(geometry.block_count() == block_count);
  CHECK(geometry.total_bytes() == offset);
  CHECK(geometry.block_offset(block_count) == offset);
  CHECK(geometry.range_bytes(0, block_count) == offset);
}

bool refused(std::uint64_t edge_count, std::vector<EdgeId> borders, int level,
             std::size_t record_bytes) {
  try {
    LevelGeometry(edge_count, borders, BaseRelativeLevel(level), record_bytes, 1 << 20);
    return false;
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return true;
  }
}

}  // namespace

TEST_CASE("LevelGeometry_RandomBorders_AgreesWithAWalkOverTheSlots") {
  std::mt19937 random(1);
  for (const std::uint64_t edge_count : {1u, 2u, 3u, 37u, 64u, 500u})
    for (const unsigned percent : {0u, 3u, 50u, 100u})
      for (const int level : {1, 2, 3, 7})
        for (const std::size_t record_bytes : {1u, 12u, 24u})
          for (const std::uint64_t block_bytes : {0u, 4096u, 65536u, 1u << 20}) {
            const auto borders = random_borders(edge_count, percent, random);
            check_against_walk(
                {edge_count, borders, BaseRelativeLevel(level), record_bytes, block_bytes},
                borders);
          }
}

TEST_CASE("LevelGeometry_BlockBytes_BoundTheSlotsOfABlock") {
  // Slots of 192 bytes: 16 records of 12.
  const auto slots_log2 = [](std::uint64_t edge_count, std::uint64_t block_bytes) {
    return LevelGeometry(edge_count, {}, BaseRelativeLevel(3), 12, block_bytes)
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

  const LevelGeometry one_block(1000, {}, BaseRelativeLevel(3), 12, 1 << 20);
  CHECK(one_block.block_count() == 1);
  CHECK(one_block.max_block_bytes() == 192000);
}

TEST_CASE("LevelGeometry_DeepestLevel_IsExact") {
  const std::vector<EdgeId> borders = {0, 2};
  const LevelGeometry geometry(3, borders, BaseRelativeLevel(kMaxLevel), 24, 1 << 20);
  const std::uint64_t n = std::uint64_t{1} << 19;
  CHECK(geometry.slots_per_block_log2() == 0);
  CHECK(geometry.slot_offset(1) == n * (n + 1) / 2 * 24);
  CHECK(geometry.slot_offset(2) == n * (n + 1) / 2 * 24 + n * n * 24);
  CHECK(geometry.total_bytes() == n * (n + 1) * 24 + n * n * 24);
}

TEST_CASE("LevelGeometry_NoEdges_IsEmpty") {
  const LevelGeometry geometry(0, {}, BaseRelativeLevel(1), 12, 4096);
  CHECK(geometry.block_count() == 0);
  CHECK(geometry.total_bytes() == 0);
}

TEST_CASE("LevelGeometry_ArgumentsOutOfRange_AreRefused") {
  CHECK_FALSE(refused(10, {}, 1, 1));
  CHECK_FALSE(refused(10, {}, kMaxLevel, 2040));
  CHECK(refused(10, {}, 0, 12));
  CHECK(refused(10, {}, kMaxLevel + 1, 12));
  CHECK(refused(10, {}, -1, 12));
  CHECK(refused(10, {}, 3, 0));
  CHECK(refused(kNoId, {}, 1, 1));
  CHECK(refused(kNoId - 1, {}, kMaxLevel, 12));  // 2^32 slots of 2^38 records
  CHECK(refused(10, {}, kMaxLevel, ~std::size_t{0}));
  CHECK(refused(2, {0, 2}, 1, 1));  // a border edge that is not there
  CHECK(refused(2, {0, 1, 1}, 1, 1));
}

}  // namespace plait
