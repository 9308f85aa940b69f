#include "maintenance/file_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "format/checksum.h"
#include "format/file_names.h"
#include "io/copy_range.h"
#include "maintenance/replace_file.h"
#include "maintenance/tables_from_levels.h"
#include "plait/error.h"
#include "store/left_overs.h"
#include "store/store_directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace fs = std::filesystem;
namespace {

constexpr char kImageName[] = "image";
constexpr std::uint64_t kRepairPageBytes = 4096;

/// A limit on the size of a file, because a forged table may put a block anywhere. No writer needs
/// more: blocks of at most three versions, none of them larger than raw, and gaps.
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
      case StoreFile::kFaceRecords:
        lose(file, "nothing else in the store says what it held");
        break;
      case StoreFile::kBlockTables:
        repair_tables(file);
        break;
      case StoreFile::kBaseRecords:
        repair_base_records(file);
        break;
      case StoreFile::kLevel:
        repair_level(file);
    }
}

void FileRepair::repair_tables(const DamagedFile& file) {
  if (proof_.backend().traits.compressed)
    return lose(file, "nothing else says where blocks are in a compressed level");
  if (check_.base.edge_count() == 0) return lose(file, "base.mesh is damaged too");
  const auto bytes = tables_from_levels(store_, check_, options_.progress);
  if (!bytes)
    return lose(file,
                "a level is damaged too, or has sparse files or blocks that were never written");
  put_in_place(file, *bytes);
}

void FileRepair::repair_base_records(const DamagedFile& file) {
  if (check_.base.edge_count() == 0)
    return lose(file, "base.mesh, from which they are made again, is damaged");
  const auto bytes = made_.base_records(file.attribute);
  if (!bytes) return lose(file, made_.refusal());
  if (!is_content_of(file, *bytes))
    return lose(file, "what follows from the base mesh is not what it held");
  put_in_place(file, *bytes);
}

void FileRepair::repair_level(const DamagedFile& file) {
  if (!file.expected_level)
    return lose(file, "base mesh or block tables, which say what it held, are damaged too");
  const LevelFile& level = *file.expected_level;
  const std::uint64_t bytes = repaired_bytes(level, proof_.backend().traits.compressed);
  if (bytes > most_file_bytes(level.geometry))
    return lose(file, fmt::format("the block table wants a file of {} bytes, expected at most {}",
                                  bytes, most_file_bytes(level.geometry)));
  const std::uint64_t lost = make_image(file);
  if (lost == 0) return put_level_in_place(file);
  const bool are_made =
      made_.block(MadeAgain::From::kBaseMesh, file.attribute, level.geometry, 0).has_value();
  lose(file, fmt::format("{} of its {} blocks: {}", lost, level.table.size(),
                         are_made ? "what follows from the base mesh is not what they held"
                                  : made_.refusal()));
}

std::uint64_t FileRepair::make_image(const DamagedFile& file) {
  const LevelFile& level = *file.expected_level;
  const AttributeSchema& schema = schema_of(file.attribute);
  File image = create_image();
  image.resize(repaired_bytes(level, proof_.backend().traits.compressed));
  Remains remains(Directory(store_), file.name);
  const std::string phase = "rebuild " + file.name;
  std::uint64_t lost = 0;
  for (std::uint64_t block = 0; block < level.table.size(); ++block) {
    if (options_.progress && !options_.progress({phase, block, level.table.size()}))
      throw Error(ErrorCode::kCancelled, fmt::format("repair {}: cancelled", store_.native()));
    const BlockEntry& entry = level.table[block];
    if (entry.file != file.file || entry.encoding == BlockEncoding::kNeverWritten ||
        entry.encoding == BlockEncoding::kPredicted)
      continue;  // no byte of it is in the file
    std::optional<std::span<const std::byte>> stored = remains.stored_bytes(level, block);
    if (!stored)
      if (const auto made =
              made_.block(MadeAgain::From::kBaseMesh, file.attribute, level.geometry, block))
        stored = proof_.stored_bytes(level, schema, block, *made);
    if (!stored)
      ++lost;
    else
      image.write_at(entry.offset, *stored);
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
      if (level.table[block].file == file.file)
        backend->read({block, 1}, std::span(content).first(level.geometry.block_bytes(block)));
    return std::nullopt;
  } catch (const Error& error) {
    // The blocks are encoded from blocks of other files. Their checksums are those of the table,
    // and more cannot be checked here.
    if (error.code() == ErrorCode::kNotSupported) return std::nullopt;
    if (error.code() != ErrorCode::kCorruption) throw;
    return error.what();
  }
}

void FileRepair::put_level_in_place(const DamagedFile& file) {
  // A file that the backend refuses must not replace the damaged one.
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
  scratch_.directory().remove(kImageName);  // left by a level that could not be rebuilt
  return {scratch_.directory(), kImageName, OpenMode::kCreate};
}

void FileRepair::put_in_place(const DamagedFile& file, std::span<const std::byte> bytes) {
  File image = create_image();
  image.write_at(0, bytes);
  image.close();
  put_in_place(file);
}

void FileRepair::put_in_place(const DamagedFile& file) {
  if (options_.dry_run)
    scratch_.directory().rename(kImageName, view(), file.name);
  else
    replace_file(store_, check_.sequence, file.name, scratch_.directory(), kImageName);
  report_.rebuilt_files.push_back({file.name, file.reason});
}

Directory& FileRepair::view() {
  if (!view_.is_open()) view_ = Directory::make(scratch_.directory().path_of(kRepairViewName));
  return view_;
}

std::filesystem::path FileRepair::make_view() {
  const Directory store(store_);
  for (const std::string& name : store.names())
    if (is_store_file_name(name) && name != kLockName && !view().contains(name))
      link_file(store, name, view());
  return view_.path();
}

void FileRepair::lose(const DamagedFile& file, const std::string& why) {
  report_.lost_files.push_back(
      {file.name, fmt::format("{}; it cannot be rebuilt: {}", file.reason, why)});
}

PLAIT_END_NAMESPACE
