#include "store/rollback_journal.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plait/edge_index.h"
#include "plait/error.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kJournalMagic[] = "plaitjnl";
constexpr std::size_t kJournalHeaderBytes = 48, kHeaderChecksumOffset = 40;
constexpr std::size_t kRecordBytes = 40, kRecordChecksumOffset = 32;
/// How much of a block is put back at a time.
constexpr std::size_t kRollBackBytes = 1 << 20;

using Header = std::array<std::byte, kJournalHeaderBytes>;
using RecordHeader = std::array<std::byte, kRecordBytes>;

Header make_header(const StoreUuid& uuid, std::uint64_t sequence) {
  Header header{};
  const std::span<std::byte> bytes(header);
  std::memcpy(bytes.data(), kJournalMagic, 8);
  save(bytes, 8, std::uint32_t{1});
  std::ranges::copy(uuid, bytes.begin() + 16);
  save(bytes, 32, sequence);
  save(bytes, kHeaderChecksumOffset, checksum_of(bytes.first(kHeaderChecksumOffset)));
  return header;
}

std::uint64_t seed_of(const Header& header) {
  return load<std::uint64_t>(header, kHeaderChecksumOffset);
}

struct Record {
  std::uint32_t attribute = 0, level = 0;
  std::uint64_t block = 0, offset = 0, bytes = 0, checksum = 0;
};

RecordHeader encode(const Record& record) {
  RecordHeader header{};
  const std::span<std::byte> bytes(header);
  save(bytes, 0, record.attribute);
  save(bytes, 4, record.level);
  save(bytes, 8, record.block);
  save(bytes, 16, record.offset);
  save(bytes, 24, record.bytes);
  save(bytes, kRecordChecksumOffset, record.checksum);
  return header;
}

Record decode(const RecordHeader& header) {
  return {load<std::uint32_t>(header, 0),  load<std::uint32_t>(header, 4),
          load<std::uint64_t>(header, 8),  load<std::uint64_t>(header, 16),
          load<std::uint64_t>(header, 24), load<std::uint64_t>(header, kRecordChecksumOffset)};
}

/// Of a record's header and, part by part, its block; seeded by the journal's own checksum.
class RecordChecksum {
 public:
  RecordChecksum(std::uint64_t seed, const Record& record) : state_(XXH3_createState()) {
    if (!state_) throw Error(ErrorCode::kOutOfMemory, "journal: no memory for a checksum");
    XXH3_64bits_reset_withSeed(state_.get(), seed);
    const RecordHeader header = encode(record);
    add(std::span(header).first(kRecordChecksumOffset));
  }
  void add(std::span<const std::byte> part) {
    XXH3_64bits_update(state_.get(), part.data(), part.size());
  }
  std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

/// Calls visit(position, part) for each part of `bytes` bytes at `offset`. A part has at most as
/// many bytes as the buffer.
template <class Visit>
void for_each_part(const File& file, std::uint64_t offset, std::uint64_t bytes,
                   std::span<std::byte> buffer, Visit visit) {
  for (std::uint64_t done = 0; done < bytes;) {
    const std::uint64_t count = std::min<std::uint64_t>(buffer.size(), bytes - done);
    const std::span<std::byte> part = buffer.first(count);
    file.read_at(offset + done, part);
    visit(done, part);
    done += count;
  }
}

/// The record at `at` and where its block begins, unless the journal's whole part ends there.
std::optional<Record> read_record(const File& journal, std::uint64_t at, std::uint64_t size,
                                  std::uint64_t seed, std::span<std::byte> buffer) {
  if (size - at < kRecordBytes) return {};
  RecordHeader header;
  journal.read_at(at, header);
  const Record record = decode(header);
  if (record.bytes == 0 || record.bytes > size - at - kRecordBytes) return {};
  RecordChecksum checksum(seed, record);
  for_each_part(journal, at + kRecordBytes, record.bytes, buffer,
                [&](std::uint64_t, std::span<const std::byte> part) { checksum.add(part); });
  if (checksum.value() != record.checksum) return {};
  return record;
}

/// The level files that records are put back into, each opened when a record first names it.
class JournaledLevels {
 public:
  JournaledLevels(const Directory& store, std::span<const StoredLevel> levels) : store_(store) {
    for (const StoredLevel& level : levels)
      levels_[{level.number, static_cast<std::uint32_t>(level.level)}].stored = &level;
  }

  /// Errors: kCorruption for a block that is not the version's, or lies elsewhere.
  File& file_of(const Record& record) {
    const auto found = levels_.find({record.attribute, record.level});
    if (found == levels_.end()) throw refuse(record, "the version has no such level");
    const LevelGeometry& geometry = found->second.stored->geometry;
    const BlockTable& table = found->second.stored->table;
    if (record.block >= geometry.block_count())
      throw refuse(record, fmt::format("expected a block below {}", geometry.block_count()));
    if (record.offset != geometry.block_offset(record.block) ||
        record.bytes != geometry.block_bytes(record.block))
      throw refuse(record,
                   fmt::format("expected {} bytes at byte {}, found {} at {}",
                               geometry.block_bytes(record.block),
                               geometry.block_offset(record.block), record.bytes, record.offset));
    // Without entries where the tables are damaged: levels may be what they are made again from.
    if (table.size() > 0 && table[record.block].encoding != BlockEncoding::kRaw)
      throw refuse(record, "the version has nothing written there");
    File& file = found->second.file;
    if (!file.is_open()) {
      const std::string name = found->second.stored->file_name();
      if (!store_.contains(name)) throw refuse(record, "its file is not there");
      file = File(store_, name, OpenMode::kReadWrite);
    }
    if (const std::uint64_t size = file.size(); record.offset + record.bytes > size)
      throw refuse(record, fmt::format("expected {} bytes at byte {}, found a file of {} bytes",
                                       record.bytes, record.offset, size));
    return file;
  }

  void sync() {
    for (auto& [key, level] : levels_)
      if (level.file.is_open()) level.file.sync();
  }

 private:
  struct Level {
    const StoredLevel* stored = nullptr;
    File file;
  };

  Error refuse(const Record& record, const std::string& reason) const {
    return {ErrorCode::kCorruption,
            fmt::format("roll back {}: block {} of attribute {}, level {}: {}",
                        store_.path_of(kJournalName).native(), record.block, record.attribute,
                        record.level, reason)};
  }

  const Directory& store_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Level> levels_;
};

/// The journal, if there is one and it is of this version of this store.
std::optional<File> open_hot_journal(const Directory& store, const StoreUuid& uuid,
                                     std::uint64_t sequence) {
  std::optional<File> journal = open_if_present(store, kJournalName, OpenMode::kRead);
  if (!journal) return {};
  Header header{};
  if (journal->size() >= kJournalHeaderBytes) journal->read_at(0, header);
  if (header != make_header(uuid, sequence)) return {};
  return journal;
}

/// visit(record, where its block begins) for each record of the journal's whole part.
template <class Visit>
void for_each_record(const File& journal, std::uint64_t seed, Visit visit) {
  const std::uint64_t size = journal.size();
  std::vector<std::byte> buffer(kRollBackBytes);
  for (std::uint64_t at = kJournalHeaderBytes;;) {
    const std::optional<Record> record = read_record(journal, at, size, seed, buffer);
    if (!record) return;
    visit(*record, at + kRecordBytes);
    at += kRecordBytes + record->bytes;
  }
}

/// Returns how many blocks it put back.
std::uint64_t put_back(const File& journal, std::uint64_t seed, JournaledLevels& levels) {
  for_each_record(journal, seed,
                  [&](const Record& record, std::uint64_t) { levels.file_of(record); });
  std::uint64_t restored = 0;
  std::vector<std::byte> buffer(kRollBackBytes);
  for_each_record(journal, seed, [&](const Record& record, std::uint64_t begin) {
    File& level = levels.file_of(record);
    for_each_part(journal, begin, record.bytes, buffer,
                  [&](std::uint64_t done, std::span<const std::byte> part) {
                    level.write_at(record.offset + done, part);
                  });
    ++restored;
  });
  levels.sync();
  return restored;
}

}  // namespace

RollbackJournal::RollbackJournal(const Directory& store, const StoreUuid& uuid,
                                 std::uint64_t sequence, std::size_t buffer_bytes)
    : store_(store), uuid_(uuid), sequence_(sequence), buffer_bytes_(buffer_bytes) {}

void RollbackJournal::create() {
  store_.remove(kJournalName);
  File file(store_, kJournalName, OpenMode::kCreate);
  const Header header = make_header(uuid_, sequence_);
  file.write_at(0, header);
  store_.sync();
  file_ = std::move(file);
  seed_ = seed_of(header);
  end_ = kJournalHeaderBytes;
}

void RollbackJournal::keep(const std::string& name, const BlockTable& table,
                           const LevelGeometry& geometry, std::span<const std::uint64_t> blocks) {
  if (blocks.empty()) return;
  const std::scoped_lock lock(mutex_);
  if (!file_.is_open()) create();
  const File level_file(store_, name, OpenMode::kRead);
  buffer_.resize(buffer_bytes_);
  std::uint64_t end = end_;
  for (const std::uint64_t block : blocks) {
    Record record{table.attribute(), static_cast<std::uint32_t>(table.level()), block,
                  geometry.block_offset(block), geometry.block_bytes(block)};
    RecordChecksum checksum(seed_, record);
    for_each_part(level_file, record.offset, record.bytes, buffer_,
                  [&](std::uint64_t at, std::span<const std::byte> part) {
                    checksum.add(part);
                    file_.write_at(end + kRecordBytes + at, part);
                  });
    record.checksum = checksum.value();
    file_.write_at(end, encode(record));
    end += kRecordBytes + record.bytes;
  }
  file_.sync();
  end_ = end;
}

void RollbackJournal::begin_version(std::uint64_t sequence) {
  const std::scoped_lock lock(mutex_);
  sequence_ = sequence;
  if (!file_.is_open()) return;
  file_ = File();
  store_.remove_if_possible(kJournalName);
}

bool is_hot_journal(const Directory& store, const StoreUuid& uuid, std::uint64_t sequence) {
  return open_hot_journal(store, uuid, sequence).has_value();
}

std::uint64_t roll_back(const Directory& store, const StoreUuid& uuid, std::uint64_t sequence,
                        std::span<const StoredLevel> levels) {
  const std::optional<File> journal = open_hot_journal(store, uuid, sequence);
  if (!journal) return 0;
  JournaledLevels files(store, levels);
  const std::uint64_t restored = put_back(*journal, seed_of(make_header(uuid, sequence)), files);
  remove_journal(store);
  return restored;
}

void remove_journal(const Directory& store) {
  store.remove(kJournalName);
  store.sync();
}

PLAIT_END_NAMESPACE
