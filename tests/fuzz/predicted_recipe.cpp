// The stage `predicted` with any recipe, and tables with any entries. A recipe is refused by name,
// or makes nothing of the level, or makes exactly its blocks: the same ones twice, with memory that
// follows from the geometry of the level, and in no more than ten times the time of an honest
// recipe. A level whose table has such entries is refused, or each of its blocks is read whole, or
// reading it is refused.
//
// Input: mesh, precision, attribute, level, block; 2 x 24 bytes of table entries; then the recipe.
// An entry whose first byte is 0xff is that of the block which the recipe makes.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "bounded_work.h"
#include "input_bytes.h"
#include "oracle.h"
#include "plait/extend/block_maker.h"
#include "small_levels.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

/// What the honest recipe of a level needs, refined as often as a store can be.
struct Honest {
  std::uint64_t scratch_bytes = 0;
  std::map<std::uint64_t, double> seconds = {};  ///< [block]
  std::unique_ptr<BlockMaker> maker;
};

std::unique_ptr<SmallLevels>& surface(std::size_t mesh) {
  static std::map<std::size_t, std::unique_ptr<SmallLevels>> surfaces;
  auto& made = surfaces[mesh];
  if (!made)
    made = refined_levels(small_mesh(mesh % kSmallMeshes),
                          mesh < kSmallMeshes ? ComponentType::kFloat32 : ComponentType::kFloat64);
  return made;
}

std::unique_ptr<BlockMaker> open(const SmallLevels& levels, std::size_t attribute, int level,
                                 std::string_view recipe) {
  const FilterLevel known = levels.filter_level(attribute, level);
  return library_block_makers()->open(
      {recipe, known.schema, known.attribute, *known.geometry, *known.surroundings});
}

/// The blocks of other attributes from which a block is made.
std::vector<std::span<const std::byte>> sources_of(const BlockMaker& maker, SmallLevels& levels,
                                                   std::uint64_t block) {
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = maker.sources(block, needed);
  require(count <= kMostSourceBlocks);
  std::vector<std::span<const std::byte>> bytes;
  for (const ContextBlock& each : std::span(needed).first(count))
    bytes.push_back(levels.block(each.attribute, each.level, each.block));
  return bytes;
}

Honest& honest(std::size_t mesh, std::size_t attribute, int level) {
  static std::map<std::tuple<std::size_t, std::size_t, int>, Honest> all;
  Honest& made = all[{mesh, attribute, level}];
  if (made.maker) return made;
  const char* const precision = mesh < kSmallMeshes ? "float32" : "float64";
  made.maker =
      open(*surface(mesh), attribute, level,
           std::string("loop/") + (attribute == 0 ? "limit/" : "normal/") + precision + "/20");
  made.scratch_bytes = made.maker->scratch_bytes();
  return made;
}

void check_maker(const BlockMaker& maker, SourceBytes sources, Honest& of_level,
                 std::uint64_t block, std::size_t raw_bytes) {
  // The arithmetic of normals may be twice as wide as that of the honest recipe.
  require(maker.scratch_bytes() <= 3 * of_level.scratch_bytes + 4096);
  ExactBytes raw(raw_bytes), again(raw_bytes);
  require_memory(2 * maker.scratch_bytes(), [&] { maker.make(block, sources, raw.span()); });
  double& seconds = of_level.seconds[block];
  if (seconds == 0) seconds = fastest(5, [&] { of_level.maker->make(block, {}, again.span()); });
  require_time(seconds, [&] { maker.make(block, sources, again.span()); });
  require(std::ranges::equal(raw.span(), again.span()));
  require(maker.makes(block, sources, raw.span()));
  raw.span()[raw_bytes / 2] ^= std::byte{1};
  require(!maker.makes(block, sources, raw.span()));
}

/// A level file of some bytes, and its directory.
const std::filesystem::path& place() {
  static const test::TemporaryDirectory directory(test::Medium::kMemory);
  static const std::filesystem::path path = [] {
    File file(directory.path() / "level", OpenMode::kCreate);
    const std::vector<std::byte> bytes(8192, std::byte{0x28});
    file.write_at(0, bytes);
    file.close();
    return directory.path();
  }();
  return path;
}

/// A recipe that has a comma, a plus sign or the end of a string would be another pipeline.
bool is_one_stage(std::string_view recipe) {
  return !recipe.empty() && recipe.find_first_of(",+") == std::string_view::npos;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const std::size_t mesh = input.take_below(2 * kSmallMeshes), attribute = input.take_below(2);
  SmallLevels& levels = *surface(mesh);
  const int level = static_cast<int>(1 + input.take_below(SmallLevels::kFinest));
  const LevelGeometry& geometry = levels.geometry(attribute, level);
  const std::uint64_t block = input.take<std::uint8_t>() % geometry.block_count();
  std::array<std::array<std::byte, sizeof(BlockEntry)>, 2> entries;
  for (auto& entry : entries)
    for (std::byte& byte : entry) byte = input.take<std::byte>();
  std::string recipe(reinterpret_cast<const char*>(input.rest().data()), input.rest().size());
  // The description of a version has only printable characters (target version_description).
  for (char& each : recipe)
    if (each < ' ' || each > '~') each = '/';

  std::unique_ptr<BlockMaker> maker;
  const bool is_recipe = accepts({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported},
                                 [&] { maker = open(levels, attribute, level, recipe); });
  if (maker)
    check_maker(*maker, sources_of(*maker, levels, block), honest(mesh, attribute, level), block,
                geometry.block_bytes(block));
  if (!is_one_stage(recipe)) return 0;

  BlockTable table({}, static_cast<std::uint32_t>(attribute), level, geometry.block_count());
  for (std::uint64_t at = 0; at < table.size(); ++at) {
    const auto& bytes = entries[at % entries.size()];
    if (bytes.front() != std::byte{0xff}) {
      std::memcpy(&table.entries()[at], bytes.data(), sizeof(BlockEntry));
    } else {
      ExactBytes raw(geometry.block_bytes(at));
      if (maker) maker->make(at, sources_of(*maker, levels, at), raw.span());
      table.seal_predicted(at, raw.span());
    }
  }
  const FilterLevel known = levels.filter_level(attribute, level);
  const Directory directory(place());
  const auto volume = default_backends().find("compressed").open({});
  std::unique_ptr<Backend> opened;
  accepts({ErrorCode::kCorruption}, [&] {
    opened = volume->open_level({.directory = directory,
                                 .name = "level",
                                 .mode = OpenMode::kRead,
                                 .geometry = geometry,
                                 .table = table,
                                 .schema = known.schema,
                                 .pipeline = "predicted:" + recipe + "+shuffle,zstd:1",
                                 .surroundings = *known.surroundings});
  });
  if (!opened) return 0;
  ExactBytes raw(geometry.block_bytes(block));
  const bool was_read = accepts({ErrorCode::kCorruption, ErrorCode::kNotSupported}, [&] {
    opened->read({block, 1}, raw.span());
  });
  const BlockEntry& entry = table[block];
  if (was_read && entry.encoding == BlockEncoding::kNeverWritten)
    require(std::ranges::all_of(raw.span(), [](std::byte each) { return each == std::byte{0}; }));
  if (was_read && entry.encoding == BlockEncoding::kPredicted)
    require(maker && maker->makes(block, {}, raw.span()));
  if (entry.encoding == BlockEncoding::kPredicted && !(is_recipe && maker)) require(!was_read);
  return 0;
}
