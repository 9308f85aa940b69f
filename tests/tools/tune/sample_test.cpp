#include "tune/sample.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <set>
#include <tuple>

#include "plait/error.h"
#include "tools/tune/test_stores.h"

namespace plait::tune {
namespace {

using Place = std::tuple<AttributeId, int, std::uint64_t>;

std::vector<Place> places(const Sample& sample) {
  std::vector<Place> places;
  for (const auto& parts : sample.parts)
    for (const SamplePart& part : parts)
      places.emplace_back(part.attribute, part.level, part.offset);
  return places;
}

bool always() { return true; }

}  // namespace

TEST_CASE("Sample_OfASeed_IsTheSame") {
  const Store store = smooth_store(4);
  const BlockGrid grid(store, 4096);
  StoreBytes bytes(store, 1 << 20);
  const auto sample = [&](std::uint64_t seed) { return take_sample(bytes, grid, 8, seed, always); };
  CHECK(places(sample(1)) == places(sample(1)));
  CHECK(places(sample(1)) != places(sample(2)));
  CHECK(sample(7).seed == 7);
}

TEST_CASE("Sample_HasWholeBlocksOfAllAttributes_EachOnce") {
  const Store store = smooth_store(4);
  const BlockGrid grid(store, 4096);
  StoreBytes bytes(store, 1 << 20);
  const Sample sample = take_sample(bytes, grid, 8, 1, always);
  REQUIRE(sample.parts.size() == 2);
  for (const auto& parts : sample.parts) {
    CHECK(parts.size() >= 7);
    CHECK(parts.size() <= 9);
    for (const SamplePart& part : parts) {
      const LevelGeometry& geometry = grid.geometry(part.attribute, part.level);
      const std::uint64_t block = geometry.block_at(part.offset);
      CHECK(geometry.block_offset(block) == part.offset);
      CHECK(geometry.block_bytes(block) == part.bytes);
    }
  }
  const auto all = places(sample);
  CHECK(std::set(all.begin(), all.end()).size() == all.size());
  CHECK(!sample.is_whole[0]);
}

TEST_CASE("Sample_OfASmallStore_IsAllOfIt") {
  const Store store = smooth_store(2);
  const BlockGrid grid(store, 1 << 20);
  StoreBytes bytes(store, 1 << 20);
  const Sample sample = take_sample(bytes, grid, 8, 1, always);
  CHECK(sample.is_whole == std::vector<bool>{true, true});
  CHECK(sample.parts[0].size() == 2);  // one block a level
  CHECK(sample.parts[1].size() == 2);
}

TEST_CASE("Sample_IsByBytes") {
  // Of four levels, the finest one has three quarters of the bytes.
  const Store store = smooth_store(4);
  const BlockGrid grid(store, 4096);
  StoreBytes bytes(store, 1 << 20);
  int finest = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Sample sample = take_sample(bytes, grid, 8, seed, always);
    for (const SamplePart& part : sample.parts[0]) {
      finest += part.level == 4;
      ++all;
    }
  }
  CHECK(finest == Approx(0.75 * all).epsilon(0.08));
}

TEST_CASE("Sample_IsStratifiedByCompressibility") {
  // Half of the attribute's bytes are random. Whatever the seed, so is half of the sample, as far
  // as whole blocks can be.
  Store store = smooth_store(4);
  const AttributeId id = store.add_attribute({"half", ComponentType::kUint32, 1}, 4);
  std::mt19937_64 random(1);
  for (int level = 1; level <= 4; ++level) {
    LevelCursor cursor(store.open_session(), store.level_file(id, level), Access::kOverwrite);
    const auto edges = static_cast<EdgeId>(store.base().edge_count());
    for (EdgeId edge = 0; edge < edges; ++edge)
      for (std::byte& byte : cursor.slot(edge).bytes)
        byte = static_cast<std::byte>(edge < edges / 2 ? random() : 0);
  }
  const BlockGrid grid(store, 4096);
  StoreBytes bytes(store, 1 << 20);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    int hard = 0, count = 0;
    const Sample sample = take_sample(bytes, grid, 8, seed, always);
    for (const SamplePart& part : sample.parts[id]) {
      const auto raw = bytes.read(id, part.level, part.offset, part.bytes);
      hard += byte_entropy(raw, 4) > 4;
      ++count;
    }
    CAPTURE(seed, count);
    CHECK(hard >= 3);
    CHECK(hard <= 6);
  }
}

TEST_CASE("ByteEntropy_OfNothingAndOfNoise") {
  std::vector<std::byte> raw(1 << 16);
  CHECK(byte_entropy(raw, 12) == 0);
  CHECK(byte_entropy({}, 12) == 0);
  CHECK(byte_entropy(std::span(raw).first(12), 12) == 0);
  std::mt19937 random(1);
  for (std::byte& byte : raw) byte = static_cast<std::byte>(random());
  CHECK(byte_entropy(raw, 12) > 7.9);
}

TEST_CASE("StoreBytes_AcrossBlocks_AreThoseOfTheLevel") {
  const Store store = smooth_store(4, 4096);
  const LevelFile& file = store.level_file(0, 4);
  StoreBytes bytes(store, 0);
  std::vector<std::byte> expected;
  LevelCursor cursor(store.open_session(), file);
  for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) {
    const auto slot = cursor.slot(edge).bytes;
    expected.insert(expected.end(), slot.begin(), slot.end());
  }
  REQUIRE(file.geometry.block_count() > 3);
  for (const auto& [offset, count] :
       {std::pair<std::size_t, std::size_t>{0, expected.size()}, {5000, 9000}, {1, 1}, {4096, 0}}) {
    CAPTURE(offset, count);
    CHECK(std::ranges::equal(bytes.read(0, 4, offset, count),
                             std::span(expected).subspan(offset, count)));
    bytes.make_room();
  }
}

TEST_CASE("BlockGrid_OfTheStoresOwnSize_IsTheStores") {
  const Store store = smooth_store(4, 4096);
  const BlockGrid own(store, 4096), larger(store, 65536), largest(store, 1 << 30);
  CHECK(own.geometry(1, 4).block_count() == store.level_file(1, 4).geometry.block_count());
  CHECK(!own.same_blocks(larger));
  CHECK(largest.same_blocks(BlockGrid(store, 1 << 29)));
}

}  // namespace plait::tune
