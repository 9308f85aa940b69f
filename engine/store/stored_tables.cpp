// The block tables of a StoredVersion, with what the change log changes of them.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "format/change_record.h"
#include "format/checksum.h"
#include "format/version_file.h"
#include "plait/error.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_tables.h"
#include "store/stored_version.h"
#include "store/version_sizes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void StoredVersion::check_version_file() const {
  if (const std::uint64_t found = file_.size(); found != manifest_.version_bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", file_.path().native(), found,
                            manifest_.version_bytes))
        .about(file_.path());
  const std::uint64_t expected = block_tables_bytes(description_, file_.path());
  if (const std::uint64_t found =
          manifest_.version_bytes - block_tables_offset(description_bytes_.size());
      found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes of block tables, expected {}", file_.path().native(),
                            found, expected))
        .about(file_.path());
  if (!is_newest_) return;
  if (const std::uint64_t found = checksum_of(file_); found != manifest_.version_checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", file_.path().native(),
                            found, manifest_.version_checksum))
        .about(file_.path());
}

void StoredVersion::read_tables_into(std::span<StoredLevel> levels) const {
  check_version_file();
  if (shard_count() > 0) {
    read_shard_tables_later(store_, manifest_, description_, levels);
    return;
  }
  const std::uint64_t begin = block_tables_offset(description_bytes_.size());
  std::vector<std::byte> bytes(manifest_.version_bytes - begin);
  file_.read_at(begin, bytes);
  BlockTablesReader reader(bytes, file_.path());
  std::vector<BlockTable> tables;
  for (const StoredLevel& level : levels) {
    const std::vector<BlockEntry> entries =
        reader.next_level(level.geometry, has_log() ? manifest_.log.bytes : 0);
    BlockTable& table =
        tables.emplace_back(manifest_.uuid, level.number, level.level, entries.size());
    std::ranges::copy(entries, table.entries().begin());
    table.set_generation(level.record.generation);
  }
  reader.finish();
  enter_changes(levels, tables);
  for (std::size_t at = 0; at < levels.size(); ++at) levels[at].table = std::move(tables[at]);
}

void StoredVersion::check_shard_tables(std::span<const StoredLevel> levels,
                                       std::uint32_t shard) const {
  std::vector<LevelGeometry> geometries;
  for (const StoredLevel& level : levels) geometries.push_back(level.geometry.shard(shard));
  read_shard_tables(store_, tables_file_name(manifest_.sequence, shard), manifest_.uuid, shard,
                    description_.shards[shard].tables_checksum, geometries);
}

std::vector<std::byte> StoredVersion::version_file_with(
    std::span<const BlockTable* const> tables) const {
  return encode_version_file(description_bytes_, tables);
}

const std::vector<ChangeRecord>& StoredVersion::changes() const {
  if (changes_ || !has_log()) {
    static const std::vector<ChangeRecord> none;
    return changes_ ? *changes_ : none;
  }
  std::uint64_t entries = block_tables_bytes(description_, file_.path()) / sizeof(BlockEntry);
  for (const AttributeRecord& attribute : description_.attributes)
    entries += 1 + description_.vertex_count * attribute.schema.record_bytes() / kPieceBytes;
  return changes_.emplace(
      read_change_records(File(store_, log_name(), OpenMode::kRead), manifest_, entries));
}

void StoredVersion::enter_changes(std::span<const StoredLevel> levels,
                                  std::span<BlockTable> tables) const {
  for (const ChangeRecord& change : changes())
    for (const ChangedBlock& changed : change.blocks) {
      const auto level = std::ranges::find_if(levels, [&](const StoredLevel& one) {
        return one.number == changed.attribute && one.level == static_cast<int>(changed.level);
      });
      const std::filesystem::path path = store_.path_of(log_name());
      const auto refuse = [&] {
        return Error(ErrorCode::kCorruption,
                     fmt::format("open {}: version {} changes block {} of level {} of attribute "
                                 "{}, which the store does not have",
                                 path.native(), change.version, changed.block, changed.level,
                                 changed.attribute))
            .about(path, changed.offset);
      };
      if (level == levels.end() || changed.block >= level->geometry.block_count()) throw refuse();
      BlockTable& table = tables[static_cast<std::size_t>(level - levels.begin())];
      const std::uint64_t bytes = level->geometry.block_bytes(changed.block);
      if (bytes > manifest_.log.bytes - changed.offset) throw refuse();
      table.entries()[changed.block] = {changed.offset, static_cast<std::uint32_t>(bytes),
                                        BlockEncoding::kRaw, kLogFile, changed.checksum};
    }
}

PLAIT_END_NAMESPACE
