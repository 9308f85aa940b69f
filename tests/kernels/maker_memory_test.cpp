// What makers of blocks allocate in a call: never more than they say, because the store's budget
// pays for what they say.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "plait/extend/block_maker.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/test_meshes.h"

namespace {

std::atomic<std::int64_t> held = 0, most_held = 0;

constexpr std::size_t kHeader = 64;

void* counted(std::size_t bytes, std::size_t alignment) {
  const std::size_t header = alignment > kHeader ? alignment : kHeader;
  auto* const memory = static_cast<std::byte*>(
      std::aligned_alloc(header, (bytes + 2 * header - 1) / header * header));
  if (!memory) throw std::bad_alloc();
  *reinterpret_cast<std::size_t*>(memory) = bytes;
  const std::int64_t now = held += static_cast<std::int64_t>(bytes);
  std::int64_t most = most_held;
  while (now > most && !most_held.compare_exchange_weak(most, now)) {
  }
  return memory + header;
}
void uncounted(void* memory, std::size_t alignment) noexcept {
  if (!memory) return;
  std::byte* const first =
      static_cast<std::byte*>(memory) - (alignment > kHeader ? alignment : kHeader);
  held -= static_cast<std::int64_t>(*reinterpret_cast<std::size_t*>(first));
  std::free(first);
}

}  // namespace

// Also the form that does not throw: a sanitizer has one of its own, whose memory the operator
// delete below would not know.
void* operator new(std::size_t bytes) { return counted(bytes, kHeader); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return counted(bytes, kHeader);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { uncounted(memory, kHeader); }
void operator delete(void* memory) noexcept { uncounted(memory, kHeader); }
void operator delete(void* memory, std::size_t) noexcept { uncounted(memory, kHeader); }
void operator delete(void* memory, std::align_val_t alignment) noexcept {
  uncounted(memory, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept {
  uncounted(memory, static_cast<std::size_t>(alignment));
}

namespace plait::test {
namespace {

struct Levels {
  Levels(const IndexedMesh& mesh, int finest, std::string recipe, std::uint64_t block_bytes)
      : base(BaseMesh::build(mesh)), text(std::move(recipe)) {
    around.mesh = base.topology();
    around.positions = base.positions();
    for (int level = 1; level <= finest; ++level)
      geometries.push_back(std::make_unique<LevelGeometry>(
          base.geometry(BaseRelativeLevel(level), 12, block_bytes)));
    records.resize(base.vertex_count());
    AttributeLevels& source = around.attributes.emplace_back();
    source.schema = schema_of<Vector3<float>>("position");
    source.base = std::as_bytes(std::span(records));
    for (const auto& geometry : geometries) source.levels.push_back(geometry.get());
  }
  BaseMesh base;
  std::string text;
  LevelSurroundings around;
  std::vector<Vector3<float>> records;
  std::vector<std::unique_ptr<LevelGeometry>> geometries;
};

/// The most that making a block allocates, over what the maker says.
void check_scratch(const Levels& levels, const char* attribute) {
  for (std::size_t level = 1; level <= levels.geometries.size(); ++level) {
    Pipeline pipeline;
    pipeline.recipe = levels.text;
    const auto size = block_bytes_of_level(pipeline, static_cast<int>(level), 1 << 16);
    const LevelGeometry geometry =
        levels.base.geometry(BaseRelativeLevel(static_cast<int>(level)), 12, size);
    const auto maker = library_block_makers()->open(
        {levels.text, schema_of<Vector3<float>>(attribute), 1, geometry, levels.around});
    REQUIRE(maker);
    std::vector<std::byte> raw(geometry.max_block_bytes()), zeros(1 << 22);
    std::int64_t most = 0;
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
      std::array<ContextBlock, kMostContextBlocks> needed;
      const std::size_t count = maker->sources(block, needed);
      std::vector<std::span<const std::byte>> bytes;
      for (const ContextBlock& each : std::span(needed).first(count))
        bytes.push_back(std::span<const std::byte>(zeros).first(
            levels.geometries[static_cast<std::size_t>(each.level - 1)]->block_bytes(each.block)));
      const std::span<std::byte> to(raw.data(), geometry.block_bytes(block));
      const std::int64_t before = held;
      most_held = before;
      maker->make(block, bytes, to);
      most = std::max(most, most_held - before);
    }
    CAPTURE(levels.text, level, most, maker->scratch_bytes());
    CHECK(most > 0);
    CHECK(static_cast<std::uint64_t>(most) <= maker->scratch_bytes());
  }
}

}  // namespace

TEST_CASE("BlockMaker_MakingABlock_AllocatesAtMostWhatItSays") {
  for (const NamedMesh& named :
       {NamedMesh{"torus", torus_grid(9, 7)}, NamedMesh{"sheet", random_sheet(11, 80)},
        NamedMesh{"fan", closed_fan(200)}}) {
    CAPTURE(named.name);
    check_scratch({named.mesh, 4, "loop/position/float32/4", 1 << 16}, "position");
    check_scratch({named.mesh, 4, "loop/normal/float32/4", 1 << 16}, "normal");
    check_scratch({named.mesh, 5, "normals/position/5", 1 << 16}, "normal");
  }
}

}  // namespace plait::test
