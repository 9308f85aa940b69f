// Reader: patches and ranges of vertices hold the right records, from any backend and thread, and
// views are counted.
#include "plait/reader.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <numeric>
#include <random>
#include <set>
#include <thread>

#include "engine/execution/numbered_store.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Points of a patch whose record is not that of the vertex which the oracle has there.
std::uint64_t wrong_points(const PatchView& patch, const Expected& expected, int base_level) {
  const AttributeView<Wide> vertices = patch.attribute<Wide>("vertex");
  const std::int64_t step = kSize >> (patch.level() - base_level);
  std::uint64_t wrong = 0;
  for (std::int64_t j = 0; j <= patch.size(); ++j)
    for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
      const std::uint32_t vertex =
          expected.vertex({patch.face(), {kSize - (i + j) * step, i * step, j * step}});
      wrong += vertices.at(i, j).vertex != vertex;
    }
  return wrong;
}

/// The same triangle whichever corner comes first.
naive::Triangle from_smallest(naive::Triangle triangle) {
  std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  return triangle;
}

}  // namespace

TEST_CASE("Reader_EveryPatch_HasTheVerticesOfTheNaiveMesh") {
  const auto backend = GENERATE(as<std::string>(), "pread", "mmap", "uring", "compressed");
  const auto base_level = GENERATE(0, 1);
  for (const BaseMesh& base : {BaseMesh::build(torus_grid(3, 4)), BaseMesh::build(sheet(3, 3))}) {
    const OnDisk disk(backend, base, base_level);
    const Store store = disk.open();
    const Reader reader(store, {.attributes = {"vertex"}});
    for (int level = base_level; level <= base_level + kLevels; ++level)
      for (FaceId face = 0; face < base.face_count(); ++face) {
        const PatchView patch = reader.read_patch(face, level);
        CHECK(patch.size() == std::int64_t{1} << (level - base_level));
        CHECK(wrong_points(patch, disk.expected, base_level) == 0);
      }
  }
}

TEST_CASE("Reader_CopiesAndIndices_AreTheTrianglesOfTheNaiveMesh") {
  const BaseMesh base = BaseMesh::build(GENERATE(sheet(3, 2), torus_grid(3, 4)));
  const OnDisk disk("pread", base);
  const Store store = disk.open();
  const Reader reader(store);
  const auto indices = reader.patch_indices(kLevels);
  std::multiset<naive::Triangle> found, wanted;
  std::vector<FaceId> faces(base.face_count());
  std::iota(faces.begin(), faces.end(), FaceId{0});
  reader.for_each_patch(faces, kLevels, [&](const PatchView& patch) {
    std::vector<Wide> records(patch_vertex_count(patch.size()));
    patch.attribute<Wide>("vertex").copy_to(records);
    for (const auto& [a, b, c] : indices)
      found.insert(from_smallest({records[a].vertex, records[b].vertex, records[c].vertex}));
  });
  for (const naive::Triangle& triangle : disk.expected.triangles())
    wanted.insert(from_smallest(triangle));
  CHECK(found == wanted);
}

TEST_CASE("Reader_RecordsAsBytes_AreThoseOfTheType") {
  const BaseMesh base = BaseMesh::build(sheet(3, 2));
  const OnDisk disk("pread", base);
  const Store store = disk.open();
  const Reader reader(store);
  const PatchView patch = reader.read_patch(1, kLevels);
  const RecordView bytes = patch.records("vertex");
  CHECK(bytes.size() == patch.size());
  CHECK(bytes.record_bytes() == sizeof(Wide));
  CHECK(bytes.at(2, 3).data() ==
        reinterpret_cast<const std::byte*>(&patch.attribute<Wide>("vertex").at(2, 3)));
  CHECK_THROWS_AS(bytes.at(6, 3), Error);
  CHECK_THROWS_AS(patch.records("position"), Error);
  std::vector<Wide> typed(patch_vertex_count(patch.size())), untyped(typed.size());
  patch.attribute<Wide>("vertex").copy_to(typed);
  bytes.copy_to(std::as_writable_bytes(std::span(untyped)));
  CHECK(std::memcmp(typed.data(), untyped.data(), typed.size() * sizeof(Wide)) == 0);
  CHECK_THROWS_AS(bytes.copy_to(std::as_writable_bytes(std::span(untyped).subspan(1))), Error);
  std::uint64_t vertices = 0, wrong = 0;
  reader.for_each_block_of_bytes("vertex", kLevels, 3, 20,
                                 [&](std::uint64_t first, std::span<const std::byte> block) {
                                   CHECK(first == 3 + vertices);
                                   vertices += block.size() / sizeof(Wide);
                                   std::uint32_t vertex = 0;
                                   std::memcpy(&vertex, block.data(), sizeof(vertex));
                                   wrong += vertex != disk.expected.level(kLevels)[first].vertex;
                                 });
  CHECK(vertices == 20);
  CHECK(wrong == 0);
}

TEST_CASE("Reader_RangesOfVertices_AreTheLevelInSlotOrder") {
  const auto backend = GENERATE(as<std::string>(), "pread", "compressed");
  const BaseMesh base = BaseMesh::build(sheet(3, 3));
  const OnDisk disk(backend, base);
  const Store store = disk.open();
  const Reader reader(store);
  for (int level = 0; level <= kLevels; ++level) {
    std::vector<Wide> expected = level == 0 ? std::vector<Wide>() : disk.expected.level(level);
    for (VertexId vertex = 0; level == 0 && vertex < base.vertex_count(); ++vertex)
      expected.push_back({vertex, {}});
    REQUIRE(reader.vertex_count(level) == expected.size());
    std::mt19937 random(7);
    for (int turn = 0; turn < 50; ++turn) {
      const std::uint64_t first = turn == 0 ? 0 : random() % (expected.size() + 1);
      const std::uint64_t count =
          turn == 0 ? expected.size() : random() % (expected.size() - first + 1);
      std::uint64_t next = first, wrong = 0;
      reader.for_each_block<Wide>("vertex", level, first, count,
                                  [&](std::uint64_t vertex, std::span<const Wide> records) {
                                    CHECK(vertex == next);
                                    for (const Wide& record : records)
                                      wrong += record.vertex != expected[next++].vertex;
                                  });
      CHECK(next == first + count);
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("Reader_RangeOfVertices_ReadsItsBlocksAheadAndNoOthers") {
  const BaseMesh base = BaseMesh::build(torus_grid(3, 4));
  const OnDisk disk("pread", base);
  const auto ignore = [](std::uint64_t, std::span<const Wide>) {};
  const auto blocks_of = [&](std::uint64_t vertices) {
    const Store store = disk.open();
    const Reader reader(store);
    reader.for_each_block<Wide>("vertex", kLevels, 0, vertices, ignore);
    return reader.statistics();
  };
  const std::uint64_t all = Reader(disk.open()).vertex_count(kLevels);
  const std::uint64_t every_block = blocks_of(all).blocks_read;
  REQUIRE(every_block > 8);
  CHECK(blocks_of(all).blocks_prefetched > 0);
  CHECK(blocks_of(all / 2).blocks_read <= every_block / 2 + 1);
  CHECK(blocks_of(1).blocks_read == 1);
  CHECK(blocks_of(1).blocks_prefetched == 0);
}

TEST_CASE("Reader_Threads_ReadTheSamePatchesInLittleMemory") {
  const auto backend = GENERATE(as<std::string>(), "pread", "mmap", "uring", "compressed");
  const auto policy = GENERATE(EvictionPolicy::kClock, EvictionPolicy::kLayoutOrder);
  const BaseMesh base = BaseMesh::build(torus_grid(6, 6));
  const OnDisk disk(backend, base);
  const Store store = disk.open(2 << 20);
  const Reader reader(store, {.policy = policy});
  std::atomic<std::uint64_t> wrong = 0;
  std::vector<std::thread> threads;
  for (unsigned number = 0; number < 8; ++number)
    threads.emplace_back([&, number] {
      std::mt19937 random(number);
      for (int turn = 0; turn < 60; ++turn) {
        const auto face = static_cast<FaceId>(random() % base.face_count());
        wrong +=
            wrong_points(reader.read_patch(face, 1 + int(random() % kLevels)), disk.expected, 0);
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(reader.view_count() == 0);
}

TEST_CASE("Reader_Views_AreCountedAndOutliveTheirStore") {
  const BaseMesh base = BaseMesh::build(torus_grid(3, 4));
  const OnDisk disk("pread", base);
  PatchView late;
  {
    Store store = disk.open();
    std::optional<Reader> reader(store);
    PatchView first = reader->read_patch(0, kLevels);
    late = reader->read_patch(1, kLevels);
    CHECK(reader->view_count() == 2);
    CHECK(names(error_of([&] { store.close(); }), {"close", "1 ", "2 open views"}));
    CHECK(error_of([&] { store.close(); }).code() == ErrorCode::kBusy);
    CHECK(wrong_points(first, disk.expected, 0) == 0);
    first = PatchView();
    CHECK(reader->view_count() == 1);
    reader.reset();
    CHECK(error_of([&] { store.close(); }).code() == ErrorCode::kBusy);
  }
  CHECK(wrong_points(late, disk.expected, 0) == 0);
  late = PatchView();
  Store store = disk.open();
  store.close();
}

TEST_CASE("Reader_ViewsUseUpTheBudget_IsAnErrorThatCountsThem") {
  const BaseMesh base = BaseMesh::build(torus_grid(6, 6));
  const OnDisk disk("pread", base);
  const Store store = disk.open(256 << 10);
  const Reader reader(store);
  std::vector<PatchView> views;
  const Error error = error_of([&] {
    for (FaceId face = 0; face < base.face_count(); ++face)
      views.push_back(reader.read_patch(face, kLevels));
  });
  CHECK(error.code() == ErrorCode::kBudget);
  CHECK(names(error, {std::to_string(views.size()) + " views of patches are open"}));
  CHECK(reader.view_count() == views.size());
  for (const PatchView& view : views) CHECK(wrong_points(view, disk.expected, 0) == 0);
  views.clear();
  CHECK(wrong_points(reader.read_patch(70, kLevels), disk.expected, 0) == 0);
}

TEST_CASE("Reader_WhatIsNotThere_IsRefusedInWords") {
  const BaseMesh base = BaseMesh::build(torus_grid(3, 4));
  const OnDisk disk("pread", base, 1);
  const Store store = disk.open();
  CHECK(error_of([&] { Reader(store, {.attributes = {"colour"}}); }).code() ==
        ErrorCode::kNotFound);
  const Reader reader(store);
  const auto refused = [](const auto& call, const std::vector<std::string>& words) {
    const Error error = error_of(call);
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, words));
  };
  refused([&] { reader.read_patch(24, 2); }, {"face 24", "below 24"});
  refused([&] { reader.read_patch(kNoId, 2); }, {"below 24"});
  refused([&] { reader.read_patch(0, 0); }, {"level 0", "1 to 4"});
  refused([&] { reader.read_patch(0, 5); }, {"level 5", "1 to 4"});
  refused([&] { reader.patch_indices(0); }, {"level 0"});
  refused([&] { reader.patch_indices(17); }, {"1 to 16"});
  const PatchView patch = reader.read_patch(0, 2);
  CHECK(error_of([&] { patch.attribute<float>("mass"); }).code() == ErrorCode::kNotFound);
  refused([&] { patch.attribute<float>("vertex"); }, {"uint32 x 32", "float32 x 1"});
  const AttributeView<Wide> vertices = patch.attribute<Wide>("vertex");
  for (const auto& [i, j] : {std::pair<std::int64_t, std::int64_t>{-1, 0}, {0, 3}, {2, 1}})
    refused([&] { vertices.at(i, j); }, {"face 0", "size 2"});
  std::vector<Wide> records(5);
  refused([&] { vertices.copy_to(records); }, {"6 records", "found 5"});
  const auto ignore = [](std::uint64_t, std::span<const Wide>) {};
  refused([&] { reader.for_each_block<Wide>("vertex", 2, 36, 1, ignore); }, {"below 36"});
  refused([&] { reader.for_each_block<Wide>("vertex", 2, 1, ~std::uint64_t{0}, ignore); },
          {"below 36"});
  refused([&] { reader.for_each_block<Wide>("vertex", 5, 0, 1, ignore); }, {"level 5"});
}
