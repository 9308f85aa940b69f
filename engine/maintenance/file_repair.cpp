#include "maintenance/file_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "maintenance/replace_file.h"
#include "maintenance/tables_from_levels.h"
#include "plait/error.h"
#include "store/checksum.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace fs = std::filesystem;
namespace {

constexpr char kImageName[] = "image";
constexpr std::uint64_t kRepairPageBytes = 4096;

/// More than any writer needs: blocks of three versions, none of them compressed, and as much
/// between them. A table that was forged may put a block anywhere.
std::uint64_t most_file_bytes(const LevelGeometry& geometry) {
  return 4 * (geometry.total_bytes() + geometry.block_count() * kRepairPageBytes);
}

/// docs/format.md, "Level files".
std::uint64_t repaired_bytes(const LevelFile& level, bool compressed) {
  if (!compressed)
    return (level.geometry.total_bytes() + kRepairPageBytes - 1) / kRepairPageBytes *
           kRepairPageBytes;
  std::uint64_t end = 0;
  for (const BlockEntry& entry : level.table.entries())
    end = std::max(end, entry.offset + entry.stored_bytes);
  return end;
}

/// REQUIRES: no level.
bool is_content_of(const DamagedFile& file, std::span<const std::byte> bytes) {
  return bytes.size() == file.expected_bytes && checksum_of(bytes) == file.expected_checksum;
}

/// What is left of a level's file.
class Remains {
 public:
  Remains(const Directory& store, const std::string& name) {
    try {
      file_ = File(store, name, OpenMode::kRead);
      bytes_ = file_.size();
    } catch (const Error& error) {  // not there, or no file
      if (error.code() != ErrorCode::kNotFound && error.code() != ErrorCode::kCorruption) throw;
    }
  }
  /// The block's stored bytes if they are whole, valid until the next call.
  std::optional<std::span<const std::byte>> stored_bytes(const LevelFile& level,
                                                         std::uint64_t block) {
    const BlockEntry& entry = level.table[block];
    if (entry.offset > bytes_ || entry.stored_bytes > bytes_ - entry.offset) return std::nullopt;
    stored_.resize(entry.stored_bytes);
    try {
      file_.read_at(entry.offset, stored_);
    } catch (const Error&) {
      return std::nullopt;  // a bad place on the disk
    }
    if (!level.table.matches(block, stored_)) return std::nullopt;
    return stored_;
  }

 private:
  File file_;
  std::uint64_t bytes_ = 0;
  std::vector<std::byte> stored_;
};

}  // namespace

void FileRepair::run() {
  for (const DamagedFile& file : check_.damaged) switch (file.kind) {
      case StoreFile::kDescription:
      case StoreFile::kBaseMesh:
        lose(file, "nothing else in the store says what it held");
        break;
      case StoreFile::kBlockTables:
        repair_tables(file);
        break;
      case StoreFile::kBaseRecords:
        if (const std::string refusal = recomputed_.refusal(file.attribute); !refusal.empty())
          lose(file, refusal);
        else if (!rebuild_base_records(file))
          lose(file, "what follows from the base mesh is not what it held");
        break;
      case StoreFile::kLevel:
        repair_level(file);
    }
}

void FileRepair::repair_tables(const DamagedFile& file) {
  if (proof_.backend().traits.compressed)
    return lose(file, "nothing else says where blocks are in a compressed level");
  if (check_.base.edge_count() == 0) return lose(file, "base.mesh is damaged too");
  const auto bytes =
      tables_from_levels(store_, check_, [&](std::uint64_t done, std::uint64_t total) {
        return !options_.proceed || options_.proceed("seal blocks", done, total);
      });
  if (!bytes) return lose(file, "a level is damaged too, or has blocks that were never written");
  put_in_place(file, *bytes);
}

bool FileRepair::rebuild_base_records(const DamagedFile& file) {
  Store& made = recomputed_.made();
  const std::span<const std::byte> bytes = made.base_bytes(made.attribute(file.attribute));
  if (!is_content_of(file, bytes)) return false;
  put_in_place(file, bytes);
  return true;
}

void FileRepair::repair_level(const DamagedFile& file) {
  if (!file.expected_level)
    return lose(file, "base mesh or block tables, which say what it held, are damaged too");
  const LevelFile& level = *file.expected_level;
  const std::uint64_t bytes = repaired_bytes(level, proof_.backend().traits.compressed);
  if (bytes > most_file_bytes(level.geometry))
    return lose(file, fmt::format("the block table wants a file of {} bytes, expected at most {}",
                                  bytes, most_file_bytes(level.geometry)));
  const std::string refusal = recomputed_.refusal(file.attribute);
  const std::uint64_t lost = make_image(file, refusal.empty() ? &recomputed_.made() : nullptr);
  if (lost == 0) return put_level_in_place(file);
  lose(file, fmt::format("{} of its {} blocks: {}", lost, file.expected_level->table.size(),
                         refusal.empty() ? "what follows from the base mesh is not what they held"
                                         : refusal));
}

std::uint64_t FileRepair::make_image(const DamagedFile& file, Store* made) {
  const LevelFile& level = *file.expected_level;
  const AttributeSchema& schema = schema_of(file.attribute);
  File image = create_image();
  image.resize(repaired_bytes(level, proof_.backend().traits.compressed));
  Remains remains(Directory(store_), file.name);
  std::uint64_t lost = 0;
  for (std::uint64_t block = 0; block < level.table.size(); ++block) {
    if (options_.proceed && !options_.proceed("rebuild " + file.name, block, level.table.size()))
      throw Error(ErrorCode::kCancelled, fmt::format("repair {}: cancelled", store_.native()));
    if (level.table[block].encoding == BlockEncoding::kNeverWritten ||
        level.table[block].encoding == BlockEncoding::kPredicted)
      continue;  // no byte of it is in the file
    std::optional<std::span<const std::byte>> stored = remains.stored_bytes(level, block);
    PinnedBlock pinned;
    if (!stored && made != nullptr) {
      LevelFile& from = made->level_file(made->attribute(file.attribute), file.level);
      pinned = made->open_session().pin(from, block, Access::kRead);
      stored = proof_.stored_bytes(level, schema, block, pinned.bytes());
    }
    if (!stored)
      ++lost;
    else
      image.write_at(level.table[block].offset, *stored);
  }
  image.close();
  return lost;
}

std::optional<std::string> FileRepair::reason_against_image(const DamagedFile& file) {
  LevelFile& level = *file.expected_level;
  try {
    const std::unique_ptr<Volume> volume = proof_.open_volume();
    const std::unique_ptr<Backend> backend =
        volume->open_level({scratch_.directory(), kImageName, OpenMode::kRead, level.geometry,
                            level.table, schema_of(file.attribute), level.pipeline});
    std::vector<std::byte> content(level.geometry.max_block_bytes());
    for (std::uint64_t block = 0; block < level.table.size(); ++block)
      backend->read({block, 1}, std::span(content).first(level.geometry.block_bytes(block)));
    return std::nullopt;
  } catch (const Error& error) {
    // Blocks that are encoded from others have the checksums of their table; that is all that can
    // be said of this file alone.
    if (error.code() == ErrorCode::kNotSupported) return std::nullopt;
    if (error.code() != ErrorCode::kCorruption) throw;
    return error.what();
  }
}

void FileRepair::put_level_in_place(const DamagedFile& file) {
  // What the backend itself refuses would be damaged again.
  if (const std::optional<std::string> reason = reason_against_image(file))
    return lose(file, "what was made of it cannot be read: " + *reason);
  put_in_place(file);
}

const AttributeSchema& FileRepair::schema_of(const std::string& attribute) const {
  const auto info = std::ranges::find_if(
      check_.attributes, [&](const AttributeInfo& each) { return each.schema.name == attribute; });
  return info->schema;
}

File FileRepair::create_image() {
  scratch_.directory().remove(kImageName);  // of a level that could not be made whole
  return {scratch_.directory(), kImageName, OpenMode::kCreate};
}

void FileRepair::put_in_place(const DamagedFile& file, std::span<const std::byte> bytes) {
  if (!options_.dry_run) {
    File image = create_image();
    image.write_at(0, bytes);
    image.close();
  }
  put_in_place(file);
}

void FileRepair::put_in_place(const DamagedFile& file) {
  if (!options_.dry_run)
    replace_file(store_, check_.sequence, file.name, scratch_.directory(), kImageName);
  report_.rebuilt_files.push_back({file.name, file.reason});
}

void FileRepair::lose(const DamagedFile& file, const std::string& why) {
  report_.lost_files.push_back(
      {file.name, fmt::format("{}; it cannot be rebuilt: {}", file.reason, why)});
}

PLAIT_END_NAMESPACE
