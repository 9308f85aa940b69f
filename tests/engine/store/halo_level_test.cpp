#include "store/halo_level.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "plait/attribute.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::byte kFrozen{0x11}, kOwn{0x22};

/// A level of raw blocks, all of `kFrozen`.
struct FrozenLevel {
  TemporaryDirectory here{Medium::kMemory};
  Store store = Store::create(here.path() / "s.plait", BaseMesh::build(random_sheet(5, 60)),
                              {.backend = "pread", .block_bytes = 4096}, default_backends());
  LevelFile* level = nullptr;

  FrozenLevel() {
    const AttributeId id = store.add_attribute(schema_of<float>("x"), 4);
    level = &StoreAccess::level_file(store, id, 4);
    std::vector<std::byte> bytes(level->geometry.total_bytes(), kFrozen);
    level->backend->write({0, level->geometry.block_count()}, bytes);
  }
  std::byte at(const std::vector<std::byte>& block, EdgeId edge) const {
    const LevelGeometry& geometry = level->geometry;
    const Slot slot = geometry.slot(edge);
    const std::size_t first = slot.offset - geometry.block_offset(geometry.block_of(edge));
    for (std::size_t byte = 1; byte < slot.bytes; ++byte)
      CHECK(block[first + byte] == block[first]);
    return block[first];
  }
};

std::vector<std::byte> read(Backend& backend, const LevelGeometry& geometry, std::uint64_t block) {
  std::vector<std::byte> bytes(geometry.block_bytes(block));
  backend.read({block, 1}, bytes);
  return bytes;
}

}  // namespace

TEST_CASE("HaloLevel_SlotsOfItsEdges_AreItsOwnAndAllOthersThoseOfTheOtherLevel") {
  const FrozenLevel frozen;
  const LevelGeometry& geometry = frozen.level->geometry;
  REQUIRE(geometry.block_count() > 4);
  // A whole block, two edges of the next one, and one of the last.
  std::vector<EdgeId> edges;
  for (EdgeId edge = geometry.first_edge(1); edge < geometry.edge_after(1); ++edge)
    edges.push_back(edge);
  const std::uint64_t last = geometry.block_count() - 1;
  const EdgeId first = geometry.first_edge(2);
  for (const EdgeId edge : {first, first + 2, geometry.first_edge(last)}) edges.push_back(edge);
  const Directory directory(frozen.here.path());
  {
    HaloLevel level(directory, "halo", *frozen.level, edges);
    const std::vector<bool> partly = level.partly_written();
    for (std::uint64_t block = 0; block <= last; ++block) CHECK(partly[block] == (block != 1));
    for (std::uint64_t block = 0; block <= last; ++block)
      CHECK(read(level, geometry, block) ==
            std::vector<std::byte>(geometry.block_bytes(block), kFrozen));
    std::vector<std::byte> bytes(geometry.range_bytes(1, 2), kOwn);
    level.write({1, 2}, bytes);
    level.write({last, 1}, std::vector<std::byte>(geometry.block_bytes(last), kOwn));
    std::uint64_t own_bytes = 0;
    for (EdgeId edge = 0; edge < geometry.edge_count(); ++edge) {
      const bool is_own = std::ranges::find(edges, edge) != edges.end();
      own_bytes += is_own ? geometry.slot(edge).bytes : 0;
      CHECK(frozen.at(read(level, geometry, geometry.block_of(edge)), edge) ==
            (is_own ? kOwn : kFrozen));
    }
    CHECK(level.stored_bytes() == own_bytes);
    // The other level is as it was.
    CHECK(read(*frozen.level->backend, geometry, 1) ==
          std::vector<std::byte>(geometry.block_bytes(1), kFrozen));
    std::fstream file(frozen.here.path() / "halo", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(geometry.block_bytes(1)));
    file.put('\x55');
    file.close();
    CHECK(read(level, geometry, 1).front() == kOwn);
    const Error error = error_of([&] { read(level, geometry, 2); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK_THAT(error.what(), Catch::Contains("halo"));
  }
  CHECK_FALSE(std::filesystem::exists(frozen.here.path() / "halo"));
}

}  // namespace plait::test
