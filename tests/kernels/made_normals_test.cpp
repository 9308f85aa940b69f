// Normals that a store makes again from its positions: they take no bytes, have the bits of stored
// ones, and keep their positions from being changed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "maintenance/decoded_again.h"
#include "passes/surface_passes.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::made_normals_test {
namespace {

namespace fs = std::filesystem;
using Normal = Vector3<float>;

struct Surface {
  BaseMesh base;
  int levels = 3;
  int base_level = 0;
  ComponentType precision = ComponentType::kFloat32;
};

StoreOptions options_for(const std::string& backend) {
  StoreOptions options{.backend = backend,
                       .durability = Durability::kNone,
                       .block_bytes = 4096,
                       .budget_bytes = 16 << 20};
  if (backend == "compressed")
    options.pipeline_of = [](const AttributeSchema& schema) -> std::string {
      return schema.name == "normal" ? "predicted+shuffle,zstd:1" : "hierarchy+shuffle,zstd:1";
    };
  return options;
}

/// Positions that no scheme makes, and the normals of these positions, in memory.
Store displaced(const Surface& surface) {
  Store store = Store::create({}, surface.base, options_for("memory"), default_backends(),
                              {.base_level = surface.base_level});
  add_base_positions(store, surface.precision);
  subdivide(store, {.levels = surface.levels, .normals = true});
  const VisitOptions visit{.threads = 2};
  const AttributeId position = store.attribute("position");
  const AttributeId moved =
      StoreAccess::add_replacement(store, store.attributes()[position].schema);
  for (int level = store.base_level(); level < surface.levels; ++level) store.add_level(moved);
  add_noise(store, store.attributes()[moved].schema.name,
            1e-3 * box_of_positions(store, visit).diagonal(), 1, visit);
  StoreAccess::name_replacement(store, moved);
  Provenance provenance = store.provenance();
  provenance.scheme.clear();
  StoreAccess::set_provenance(store, provenance);
  make_normals(store, "position", "normal", visit);
  return store;
}

Surface torus(int levels = 3) { return {BaseMesh::build(torus_grid(9, 7)), levels}; }

/// A copy that makes the normals again.
Store made(const fs::path& path, Store& from) {
  Store store = Store::create(path, from.base(), options_for("compressed"), default_backends(),
                              from.provenance());
  copy_levels(from, store);
  store.commit();
  return store;
}

/// [encoding] how many blocks of the normals have it.
std::vector<std::uint64_t> encodings(Store& store) {
  StoreAccess::pager(store).flush();  // blocks on their way change the table
  std::vector<std::uint64_t> counts(4);
  const AttributeId normal = store.attribute("normal");
  for (int level = store.base_level() + 1; level <= store.finest_level(); ++level)
    for (const BlockEntry& entry : StoreAccess::level_file(store, normal, level).table.entries())
      ++counts[static_cast<std::size_t>(entry.encoding)];
  return counts;
}

std::uint64_t predicted(Store& store) {
  return encodings(store)[static_cast<std::size_t>(BlockEncoding::kPredicted)];
}

void flip_a_bit(const std::string& path, std::streamoff at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(at);
  const int byte = file.get();
  file.seekp(at);
  file.put(static_cast<char>(byte ^ 1));
}

}  // namespace

TEST_CASE("MadeNormals_OfSurfacesThatNoSchemeMakes_TakeNoBytesAndHaveTheBitsOfStoredOnes") {
  const std::vector<std::pair<std::string, Surface>> surfaces = [] {
    std::vector<std::pair<std::string, Surface>> all;
    all.emplace_back("torus", torus(3));
    all.emplace_back("one level", torus(1));
    all.emplace_back("with borders", Surface{BaseMesh::build(random_sheet(11, 80))});
    all.emplace_back("with a hub", Surface{BaseMesh::build(closed_fan(300)), 2});
    all.emplace_back("one face", Surface{BaseMesh::build(single_triangle()), 5});
    all.emplace_back("float64", torus(2));
    all.back().second.precision = ComponentType::kFloat64;
    all.emplace_back("rebased", Surface{BaseMesh::build(torus_grid(5, 4)), 3, 1});
    return all;
  }();
  for (const auto& [name, surface] : surfaces) {
    CAPTURE(name);
    Store expected = displaced(surface);
    const TemporaryDirectory directory(Medium::kMemory);
    const fs::path path = directory.path() / "s.plait";
    {
      Store store = made(path, expected);
      const std::vector<std::uint64_t> counts = encodings(store);
      CHECK(predicted(store) == counts[0] + counts[1] + counts[2] + counts[3]);
      const AttributeId normal = store.attribute("normal");
      for (int level = surface.base_level + 1; level <= surface.levels; ++level)
        CHECK(StoreAccess::level_file(store, normal, level).backend->stored_bytes() == 0);
    }
    Store store = Store::open(path, {.budget_bytes = 4 << 20}, default_backends());
    CHECK(digest(store).to_string() == digest(expected).to_string());
    for (int level = surface.base_level; level <= surface.levels; ++level)
      CHECK(digest(store, {.level = level}).to_string() ==
            digest(expected, {.level = level}).to_string());
    CHECK(verify(store).damaged_count == 0);
  }
}

TEST_CASE("MadeNormals_ReadByTwoThreadsInATightBudget_AreThoseThatWereStored", "[threads]") {
  Store expected = displaced(torus(4));
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  made(path, expected).close();
  const Store store = Store::open(path, {.budget_bytes = 2 << 20}, default_backends());
  const Reader reader(store, {.attributes = {"normal"}});
  const Reader stored(expected, {.attributes = {"normal"}});
  std::vector<int> wrong(2);
  const auto read = [&](std::size_t which) {
    const auto faces = static_cast<FaceId>(store.base().face_count());
    for (FaceId i = 0; i < faces; ++i) {
      const FaceId face = which == 0 ? i : faces - 1 - i;
      for (int level = 1; level <= 4; ++level) {
        const PatchView a = reader.read_patch(face, level), b = stored.read_patch(face, level);
        const auto found = a.attribute<Normal>("normal"), wanted = b.attribute<Normal>("normal");
        const std::int64_t size = std::int64_t{1} << level;
        for (std::int64_t y = 0; y <= size; ++y)
          for (std::int64_t x = 0; x + y <= size; ++x)
            if (!(found.at(x, y) == wanted.at(x, y))) ++wrong[which];
      }
    }
  };
  std::thread other(read, 1);
  read(0);
  other.join();
  CHECK(wrong[0] + wrong[1] == 0);
}

TEST_CASE("MadeNormals_ANormalOfAnotherProgram_IsStoredAndTheOthersAreMade") {
  Store expected = displaced(torus(3));
  const AttributeId normal = expected.attribute("normal");
  {
    const PinnedBlock pinned = StoreAccess::open_session(expected).pin(
        StoreAccess::level_file(expected, normal, 3), 0, Access::kUpdate);
    reinterpret_cast<Normal*>(pinned.bytes().data())->x += 1;
  }
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = made(directory.path() / "s.plait", expected);
  const std::vector<std::uint64_t> counts = encodings(store);
  CHECK(counts[0] + counts[1] + counts[2] == 1);
  CHECK(predicted(store) > 10);
  CHECK(digest(store).to_string() == digest(expected).to_string());
}

TEST_CASE("MadeNormals_TheirPositions_CannotBeChangedOrRemoved") {
  Store expected = displaced(torus(2));
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  made(path, expected).close();
  Store store = Store::open(path, {.writable = true}, default_backends());
  const AttributeId position = store.attribute("position");
  for (const int level : {1, 2}) {
    CHECK(code_of([&] {
            static_cast<void>(StoreAccess::open_session(store).pin(
                StoreAccess::level_file(store, position, level), 0, Access::kUpdate));
          }) == ErrorCode::kBadState);
  }
  CHECK(code_of([&] { store.base_records<Normal>(position); }) == ErrorCode::kBadState);
  CHECK(code_of([&] { store.remove_attribute(position); }) == ErrorCode::kBadState);
  // Without normals, positions can be changed again.
  store.remove_attribute(store.attribute("normal"));
  CHECK_NOTHROW(store.remove_attribute(position));
}

TEST_CASE("MadeNormals_StoredAgain_AreRawBlocksOrEncodedOnes") {
  Store expected = displaced(torus(3));
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = made(directory.path() / "s.plait", expected);
  recode_attribute(store, store.attribute("normal"), "shuffle,zstd:1", {.verify = true});
  CHECK(predicted(store) == 0);
  CHECK(digest(store).to_string() == digest(expected).to_string());
  recode_attribute(store, store.attribute("normal"), "predicted,zstd:1", {.verify = true});
  CHECK(predicted(store) > 10);
  CHECK(digest(store).to_string() == digest(expected).to_string());
  Store raw = Store::create({}, store.base(), options_for("memory"), default_backends());
  copy_levels(store, raw);
  CHECK(digest(raw).to_string() == digest(expected).to_string());
}

TEST_CASE("MadeNormals_OfPositionsThatAreDamaged_AreErrorsAndNeverOtherNormals") {
  Store expected = displaced(torus(3));
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  std::string file;
  std::uint64_t offset = 0;
  {
    Store store = made(path, expected);
    const LevelFile& level = StoreAccess::level_file(store, store.attribute("position"), 3);
    file = level.path;
    offset = level.table[0].offset;  // blocks are in the order in which their encoding ended
  }
  flip_a_bit(file, static_cast<std::streamoff>(offset) + 100);
  Store store = Store::open(path, {}, default_backends());
  const LevelFile& level = StoreAccess::level_file(store, store.attribute("normal"), 3);
  CHECK(code_of([&] { static_cast<void>(StoreAccess::open_session(store).pin(level, 0)); }) ==
        ErrorCode::kCorruption);
  CHECK(verify(store).damaged_count > 0);
}

TEST_CASE("MadeNormals_InABudgetThatCannotHoldTheirPositions_AreRefusedWithTheFigure") {
  Surface surface{BaseMesh::build(torus_grid(40, 30)), 3};
  Store expected = displaced(surface);
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  made(path, expected).close();
  Store store = Store::open(path, {.budget_bytes = 64 << 10, .io_threads = 0}, default_backends());
  const LevelFile& level = StoreAccess::level_file(store, store.attribute("normal"), 3);
  try {
    for (std::uint64_t block = 0; block < level.geometry.block_count(); ++block)
      static_cast<void>(StoreAccess::open_session(store).pin(level, block));
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBudget);
    CHECK(std::string(error.what()).find("bytes of frames are needed") != std::string::npos);
    return;
  }
  FAIL("every block fits with its positions");
}

TEST_CASE("MadeNormals_OfAllLevels_AreMadeFromPositionsThatAreReadFewTimes") {
  Store expected = displaced({BaseMesh::build(torus_grid(40, 30)), 4});
  const TemporaryDirectory directory(Medium::kMemory);
  StoreOptions options = options_for("compressed");
  options.budget_bytes = 2 << 20;
  options.io_threads = 0;
  Store store = Store::create(directory.path() / "s.plait", expected.base(), options,
                              default_backends(), expected.provenance());
  const AttributeId position = store.add_attribute(schema_of<Normal>("position"));
  copy_attribute(expected, expected.attribute("position"), store, position);
  const AttributeId normal = store.add_attribute(schema_of<Normal>("normal"));
  const std::uint64_t before = store.info().paging.blocks_read;
  copy_attribute(expected, expected.attribute("normal"), store, normal);
  std::uint64_t blocks = 0;
  for (int level = 1; level <= 4; ++level)
    blocks += StoreAccess::level_file(store, position, level).geometry.block_count();
  INFO(blocks);
  // One pass for each level takes more than four times as many.
  CHECK(store.info().paging.blocks_read - before < 2 * blocks);
  CHECK(digest(store).to_string() == digest(expected).to_string());
}

TEST_CASE("MadeNormals_DigestInLessThanThePositionsTake_ReadsEachBlockOnce") {
  Store expected = displaced({BaseMesh::build(torus_grid(40, 30)), 4});
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  StoreOptions options = options_for("compressed");
  options.block_bytes = 16 << 10;
  {
    Store store =
        Store::create(path, expected.base(), options, default_backends(), expected.provenance());
    copy_levels(expected, store);
    store.commit();
  }
  const Store store = Store::open(
      path, {.writable = false, .budget_bytes = 3 << 20, .io_threads = 0}, default_backends());
  std::uint64_t blocks = 0, position_bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = 1; level <= 4; ++level) {
      const LevelGeometry& geometry = StoreAccess::level_file(store, id, level).geometry;
      blocks += geometry.block_count();
      if (store.attributes()[id].schema.name == "position")
        position_bytes += geometry.total_bytes();
    }
  REQUIRE(position_bytes > 3 << 20);
  CHECK(digest(store).to_string() == digest(expected).to_string());
  CHECK(store.info().paging.blocks_read == blocks);
  const auto said_after_two = [&](std::uint64_t budget_bytes) {
    const Store read =
        Store::open(path, {.writable = false, .budget_bytes = budget_bytes, .io_threads = 0},
                    default_backends());
    for (int pass = 0; pass < 2; ++pass)
      CHECK(digest(read).to_string() == digest(expected).to_string());
    return decoded_again(read);
  };
  CHECK(said_after_two(64 << 20).empty());
  CHECK_THAT(said_after_two(1 << 20), Catch::Contains("each block was decoded 2."));
}

TEST_CASE("MadeNormals_OfAnAttributeThatComesLater_AreStored") {
  Store expected = displaced(torus(2));
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = Store::create(directory.path() / "s.plait", expected.base(),
                              options_for("compressed"), default_backends());
  const AttributeId normal = store.add_attribute(schema_of<Normal>("normal"));
  copy_attribute(expected, expected.attribute("normal"), store, normal);
  copy_attribute(expected, expected.attribute("position"), store,
                 store.add_attribute(schema_of<Normal>("position")));
  CHECK(predicted(store) == 0);
  CHECK(digest(store).to_string() == digest(expected).to_string());
}

}  // namespace plait::test::made_normals_test
