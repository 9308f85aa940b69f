#include "store/generation_volume.h"

#include <algorithm>
#include <utility>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "store/generation_level.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The log of a tiny store may grow to this size: each new log is a version with files of its own.
constexpr std::uint64_t kLeastLogBytes = 128u << 10;

bool has_block_in_log(const BlockTable& table) {
  return std::ranges::find(table.entries(), kLogFile, &BlockEntry::file) != table.entries().end();
}

}  // namespace

GenerationVolume::GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store,
                                   std::uint64_t sequence, const LogPlace& log, bool writable)
    : inner_(std::move(inner)),
      store_(store),
      sequence_(sequence),
      is_described_(log.last_record == 0) {
  if (log.generation != 0)
    logs_[0] = std::make_unique<ChangeLog>(
        store, log.generation, writable ? OpenMode::kReadWrite : OpenMode::kRead, log.bytes);
}

GenerationVolume::~GenerationVolume() = default;

std::unique_ptr<Backend> GenerationVolume::open_level(const LevelSpec& level) {
  if (level.mode == OpenMode::kRead && !has_block_in_log(level.table))
    return inner_->open_level(level);
  return std::make_unique<GenerationLevel>(level, *this);
}

std::uint64_t GenerationVolume::most_bytes() const {
  return std::max(most_log_bytes_, kLeastLogBytes);
}

BlockPlace GenerationVolume::append(std::span<const std::byte> bytes) {
  unsigned to = 0;
  {
    const std::scoped_lock lock(making_);
    if (!logs_[current_]) {
      logs_[current_] = std::make_unique<ChangeLog>(store_, sequence_ + 1, OpenMode::kCreate, 0);
    } else if (const ChangeLog& log = *logs_[current_];
               !has_former() && log.committed() > 0 &&
               (is_described_ ? is_nearly_full(log) : log.end() >= most_bytes())) {
      logs_[1 - current_] =
          std::make_unique<ChangeLog>(store_, sequence_ + 1, OpenMode::kCreate, 0);
      current_ = 1 - current_;
    }
    to = current_;
  }
  return logs_[to]->append(bytes, most_bytes()) | kInLog | to;
}

bool GenerationVolume::is_unread() {
  // A reader that comes now opens the newest version. Only if that has a file of its own, the locks
  // tell whether a reader that is there has an older one.
  if (!is_unread_) is_unread_ = is_described_ && versions_being_read(store_, sequence_).empty();
  return *is_unread_;
}

bool GenerationVolume::is_small_commit() const {
  const ChangeLog* const log = logs_[current_].get();
  return log != nullptr && log->committed() > 0 && !is_nearly_full(*log) && !has_former() &&
         std::ranges::all_of(levels_, &GenerationLevel::is_in_log_alone);
}

LogPlace GenerationVolume::commit_changes(const LogPlace& before,
                                          std::span<const std::span<const std::byte>> pieces,
                                          std::vector<ChangedRecords> records, bool durable) {
  ChangeRecord record{
      sequence_ + 1, before.last_record, before.last_checksum, {}, std::move(records)};
  for (const GenerationLevel* const level : levels_) level->add_changes(record.blocks);
  ChangeLog& log = *logs_[current_];
  for (std::size_t at = 0; at < pieces.size(); ++at) {
    record.records[at].offset = log.append(pieces[at], most_log_bytes_);
    record.records[at].checksum = checksum_of(pieces[at]);
  }
  const std::vector<std::byte> bytes = encode_change_record(record);
  LogPlace place{log.generation(), 0, log.append(bytes, most_log_bytes_),
                 load<std::uint64_t>(bytes, bytes.size() - sizeof(std::uint64_t))};
  place.bytes = log.end();
  if (durable) log.sync();
  is_described_ = false;
  return place;
}

LogPlace GenerationVolume::finish_log(bool durable) {
  is_described_ = true;
  const bool is_needed =
      std::ranges::any_of(levels_, [](const GenerationLevel* level) { return level->uses_log(); });
  if (!is_needed) {
    for (auto& log : logs_) log.reset();
    return {};
  }
  ChangeLog& log = *logs_[current_];
  if (durable && log.has_changed()) log.sync();
  return {log.generation(), log.end(), 0, 0};
}

void GenerationVolume::begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
  inner_->begin_version(sequence, held);
  for (GenerationLevel* const level : levels_) level->begin_version();
  logs_[1 - current_].reset();
  if (logs_[current_]) logs_[current_]->commit();
  is_unread_.reset();
  sequence_ = sequence;
}

void GenerationVolume::roll_back() {
  is_unread_.reset();
  for (unsigned at = 0; at < logs_.size(); ++at) {
    if (!logs_[at]) continue;
    logs_[at]->roll_back();
    if (logs_[at]->committed() == 0)
      logs_[at].reset();
    else
      current_ = at;
  }
}

PLAIT_END_NAMESPACE
