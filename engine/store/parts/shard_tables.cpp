#include "store/parts/shard_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/version_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kShardMagic[] = "plaitshd";
constexpr std::uint32_t kShardFormat = 1;

/// The tables of all levels and shards of an open version.
class ShardTables {
 public:
  ShardTables(const Directory& store, const Manifest& manifest,
              const VersionDescription& description, std::span<const StoredLevel> levels)
      : store_(store),
        uuid_(manifest.uuid),
        version_(manifest.sequence),
        shards_(description.shards),
        is_read_(shards_.size()) {
    for (const StoredLevel& level : levels) {
      geometries_.push_back(level.geometry);
      // calloc gives pages of zeros, which take no memory before they are written.
      const std::uint64_t blocks = std::max<std::uint64_t>(level.geometry.block_count(), 1);
      entries_.emplace_back(static_cast<BlockEntry*>(std::calloc(blocks, sizeof(BlockEntry))));
      if (!entries_.back()) throw std::bad_alloc();
    }
  }

  std::uint64_t size(std::size_t level) const noexcept { return geometries_[level].block_count(); }
  BlockEntry* entries(std::size_t level) const noexcept { return entries_[level].get(); }

  void read_shard_of(std::size_t level, std::uint64_t block) {
    read(geometries_[level].shard_of_block(block));
  }
  void read_all() {
    for (std::uint32_t shard = 0; shard < shards_.size(); ++shard) read(shard);
  }

 private:
  struct Free {
    void operator()(BlockEntry* entries) const { std::free(entries); }
  };

  void read(std::uint32_t shard) {
    if (is_read_[shard].load(std::memory_order_acquire)) return;
    const std::scoped_lock lock(mutex_);
    if (is_read_[shard].load(std::memory_order_relaxed)) return;
    std::vector<LevelGeometry> alone;
    for (const LevelGeometry& geometry : geometries_) alone.push_back(geometry.shard(shard));
    const auto tables = read_shard_tables(store_, tables_file_name(version_, shard), uuid_, shard,
                                          shards_[shard].tables_checksum, alone);
    for (std::size_t level = 0; level < tables.size(); ++level)
      std::ranges::copy(tables[level],
                        entries_[level].get() + geometries_[level].first_block(shard));
    is_read_[shard].store(true, std::memory_order_release);
  }

  const Directory& store_;
  const StoreUuid uuid_;
  const std::uint64_t version_;
  const std::vector<ShardRecord> shards_;
  std::vector<LevelGeometry> geometries_;
  std::vector<std::unique_ptr<BlockEntry, Free>> entries_;
  std::mutex mutex_;
  std::vector<std::atomic<bool>> is_read_;
};

/// The table of one of the levels.
class EntriesOfLevel final : public StoredEntries {
 public:
  EntriesOfLevel(std::shared_ptr<ShardTables> tables, std::size_t level)
      : tables_(std::move(tables)), level_(level) {}
  std::uint64_t size() const noexcept override { return tables_->size(level_); }
  const BlockEntry& at(std::uint64_t block) override {
    tables_->read_shard_of(level_, block);
    return tables_->entries(level_)[block];
  }
  std::span<BlockEntry> all() override {
    tables_->read_all();
    return {tables_->entries(level_), tables_->size(level_)};
  }

 private:
  std::shared_ptr<ShardTables> tables_;
  std::size_t level_;
};

}  // namespace

std::vector<std::byte> encode_shard_tables(const StoreUuid& store, std::uint32_t shard,
                                           std::span<const BlockTable> tables) {
  std::vector<std::byte> bytes(kShardTablesHeaderBytes);
  std::memcpy(bytes.data(), kShardMagic, 8);
  save(std::span(bytes), 8, kShardFormat);
  save(std::span(bytes), 12, shard);
  std::ranges::copy(store, bytes.begin() + 16);
  for (const BlockTable& table : tables) {
    const auto entries = std::as_bytes(table.entries());
    bytes.insert(bytes.end(), entries.begin(), entries.end());
  }
  return bytes;
}

std::vector<std::vector<BlockEntry>> read_shard_tables(const Directory& store,
                                                       const std::string& name,
                                                       const StoreUuid& uuid, std::uint32_t shard,
                                                       std::uint64_t checksum,
                                                       std::span<const LevelGeometry> levels) {
  const File file(store, name, OpenMode::kRead);
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: {}", file.path().native(), reason))
        .about(file.path());
  };
  std::uint64_t expected = kShardTablesHeaderBytes;
  for (const LevelGeometry& level : levels) expected += level.block_count() * sizeof(BlockEntry);
  if (const std::uint64_t found = file.size(); found != expected)
    throw refuse(fmt::format("{} bytes, expected {}", found, expected));
  std::vector<std::byte> bytes(expected);
  file.read_at(0, bytes);
  if (std::memcmp(bytes.data(), kShardMagic, 8) != 0 ||
      load<std::uint32_t>(bytes, 8) != kShardFormat || load<std::uint32_t>(bytes, 12) != shard ||
      !std::ranges::equal(uuid, std::span<const std::byte>(bytes).subspan(16, uuid.size())))
    throw refuse(fmt::format("expected the block tables of shard {} of this store", shard));
  if (const std::uint64_t found = checksum_of(bytes); found != checksum)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, checksum));
  BlockTablesReader reader(std::span<const std::byte>(bytes).subspan(kShardTablesHeaderBytes),
                           file.path());
  std::vector<std::vector<BlockEntry>> tables;
  for (const LevelGeometry& level : levels) tables.push_back(reader.next_level(level));
  reader.finish();
  return tables;
}

void read_shard_tables_later(const Directory& store, const Manifest& manifest,
                             const VersionDescription& description, std::span<StoredLevel> levels) {
  const auto tables = std::make_shared<ShardTables>(store, manifest, description, levels);
  for (std::size_t at = 0; at < levels.size(); ++at) {
    levels[at].table = BlockTable(manifest.uuid, levels[at].number, levels[at].level,
                                  std::make_shared<EntriesOfLevel>(tables, at));
    levels[at].table.set_generation(levels[at].record.generation);
  }
}

PLAIT_END_NAMESPACE
