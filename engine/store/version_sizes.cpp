#include "store/version_sizes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "format/base_mesh_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "io/machine.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/block_table.h"
#include "plait/extend/file.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Files up to this size are read even if they are sparse.
constexpr std::uint64_t kFreelyReadBytes = 256u << 20;
/// Larger files must have at least 1/64 of their bytes on the disk, or the right checksum: a copy
/// may make holes of records of zeros.
constexpr std::uint64_t kMostBytesForOneOnDisk = 64;
/// The most bytes of holes whose checksum is computed to learn that.
constexpr std::uint64_t kMostBytesForChecksum = std::uint64_t{4} << 30;

Error refusal(const std::filesystem::path& path, const std::string& reason) {
  return Error(ErrorCode::kCorruption, fmt::format("open {}: {}", path.native(), reason))
      .about(path);
}

/// Nothing for what is not there and for what is no regular file: its reader says so.
std::optional<std::uint64_t> size_of(const Directory& store, const std::string& name) {
  struct stat status {};
  if (::fstatat(store.descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0 ||
      !S_ISREG(status.st_mode))
    return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

void check_size(const Directory& store, const std::string& name, std::uint64_t expected) {
  if (const auto found = size_of(store, name); found && *found != expected)
    throw refusal(store.path_of(name), fmt::format("{} bytes, expected {}", *found, expected));
}

}  // namespace

void check_counts(const VersionDescription& description, const std::filesystem::path& path) {
  const std::uint64_t vertices = description.vertex_count, edges = description.edge_count,
                      faces = description.face_count, border = description.border_edge_count;
  // Each face has three edges, an edge in the border has one face and all others have two; each
  // vertex has a face.
  if (3 * faces + border != 2 * edges || border > edges || vertices > 3 * faces)
    throw refusal(path, fmt::format("no mesh has {} vertices, {} edges, {} of them in the border, "
                                    "and {} faces",
                                    vertices, edges, border, faces));
}

std::uint64_t block_tables_bytes(const VersionDescription& description,
                                 const std::filesystem::path& path) {
  // Those of levels in shards are files of their own.
  if (!description.shards.empty()) return 0;
  // A block has as many slots on a border as elsewhere.
  // Absent slots are in no block.
  const auto slots_of = [&](BaseRelativeLevel level) -> std::uint64_t {
    return description.depths
               ? description.depths->slots[static_cast<std::size_t>(level.refinements - 1)]
               : description.edge_count;
  };
  std::uint64_t blocks = 0;
  for (const AttributeRecord& attribute : description.attributes) {
    BaseRelativeLevel level(0);
    for (const LevelRecord& stored : attribute.levels) {
      ++level.refinements;
      try {
        blocks += LevelGeometry(SlotShapes(slots_of(level)), level, attribute.schema.record_bytes(),
                                block_bytes_of_level(stored.pipeline, level.refinements,
                                                     description.block_bytes))
                      .block_count();
      } catch (const Error& error) {
        throw refusal(path, fmt::format("attribute '{}': {}", attribute.schema.name, error.what()));
      }
    }
  }
  return blocks * sizeof(BlockEntry);
}

namespace {

/// Whoever opens a store has a number in memory for each shard of each level, so the tables of the
/// shards, which have more bytes, must be on the disk.
void refuse_shards_without_tables(const Directory& store, const VersionDescription& description,
                                  std::uint64_t sequence) {
  std::uint64_t levels = 0;
  for (const AttributeRecord& attribute : description.attributes) levels += attribute.levels.size();
  const auto shards = static_cast<std::uint32_t>(description.shards.size());
  const std::uint64_t bytes = levels * shards * sizeof(std::uint64_t);
  if (bytes <= kFreelyReadBytes) return;
  const std::uint64_t needed = bytes / kMostBytesForOneOnDisk;
  std::uint64_t there = 0;
  for (std::uint32_t shard = 0; shard < shards; ++shard) {
    const std::string name = tables_file_name(sequence, shard);
    if (size_of(store, name).value_or(0) > 0)
      there += bytes_on_disk(File(store, name, OpenMode::kRead), needed - there);
    if (there >= needed) return;
  }
  throw refusal(store.path_of(version_file_name(sequence)),
                fmt::format("it has {} levels in {} shards; of their block tables the disk has {}, "
                            "expected at least {}",
                            levels, shards, format_bytes(there), format_bytes(needed)));
}

/// Whether the base records of every attribute have their checksum, whatever the disk has of them.
bool have_checksums(const Directory& store, const VersionDescription& description,
                    std::uint64_t sequence) {
  return std::ranges::all_of(description.attributes, [&](const AttributeRecord& attribute) {
    const std::string name = base_file_name(attribute.number, sequence);
    return size_of(store, name).value_or(0) == attribute.base_bytes &&
           checksum_of(File(store, name, OpenMode::kRead)) == attribute.base_checksum;
  });
}

}  // namespace

void refuse_holes(const Directory& store, const VersionDescription& description,
                  std::uint64_t sequence) {
  refuse_shards_without_tables(store, description, sequence);
  std::vector<std::string> names = {kBaseMeshName, version_file_name(sequence)};
  if (store.contains(kBaseIndexName)) names.push_back(kBaseIndexName);
  if (description.depths) names.push_back(kDepthsName);
  std::uint64_t unpacked = 0;  // packed records take as much memory as others
  for (const AttributeRecord& attribute : description.attributes) {
    names.push_back(base_file_name(attribute.number, sequence));
    unpacked += description.vertex_count * attribute.schema.record_bytes() - attribute.base_bytes;
  }
  std::uint64_t bytes = unpacked;
  for (const std::string& name : names) bytes += size_of(store, name).value_or(0);
  if (bytes <= kFreelyReadBytes) return;
  const std::uint64_t needed = bytes / kMostBytesForOneOnDisk;
  std::uint64_t there = 0, most_holes = 0;
  std::string emptiest;
  for (const std::string& name : names) {
    if (size_of(store, name).value_or(0) == 0) continue;
    const File file(store, name, OpenMode::kRead);
    const std::uint64_t found = bytes_on_disk(file, needed - there);
    there += found;
    if (there >= needed) return;
    if (const std::uint64_t holes = file.size() - std::min(found, file.size());
        holes >= most_holes) {
      most_holes = holes;
      emptiest = name;
    }
  }
  if (unpacked > kFreelyReadBytes && unpacked / kMostBytesForOneOnDisk > there)
    throw refusal(store.path_of(version_file_name(sequence)),
                  fmt::format("packed base records of {}; of the files that are read whole, the "
                              "disk has {}, expected at least {}",
                              format_bytes(unpacked), format_bytes(there),
                              format_bytes(unpacked / kMostBytesForOneOnDisk)));
  const bool is_of_records = emptiest != kBaseMeshName && emptiest != kBaseIndexName &&
                             emptiest != kDepthsName && emptiest != version_file_name(sequence);
  if (is_of_records && bytes <= kMostBytesForChecksum &&
      have_checksums(store, description, sequence))
    return;
  throw refusal(store.path_of(emptiest),
                fmt::format("{} of it are a hole; of {} in the files that are read whole, the disk "
                            "has {}, expected at least {}",
                            format_bytes(most_holes), format_bytes(bytes), format_bytes(there),
                            format_bytes(needed)));
}

void check_base_sizes(const Directory& store, const VersionDescription& description,
                      std::uint64_t sequence) {
  for (const AttributeRecord& attribute : description.attributes)
    check_size(store, base_file_name(attribute.number, sequence), attribute.base_bytes);
  check_size(store, kBaseMeshName, description.base_mesh_bytes);
  if (description.depths) check_size(store, kDepthsName, description.face_count);
}

PLAIT_END_NAMESPACE
