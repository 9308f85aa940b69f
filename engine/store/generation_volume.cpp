#include "store/generation_volume.h"

#include <algorithm>
#include <utility>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "store/generation_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A log of a tiny store may have so many bytes: each new log is a version with files of its own.
constexpr std::uint64_t kLeastLogBytes = 64u << 10;

bool has_block_in_log(const BlockTable& table) {
  return std::ranges::find(table.entries(), kLogFile, &BlockEntry::file) != table.entries().end();
}

}  // namespace

GenerationVolume::GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store,
                                   std::uint64_t sequence, const LogPlace& log, bool writable)
    : inner_(std::move(inner)), store_(store), sequence_(sequence) {
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

BlockPlace GenerationVolume::append(std::span<const std::byte> bytes) {
  const std::uint64_t most = std::max(most_log_bytes_, kLeastLogBytes);
  unsigned to = 0;
  {
    const std::scoped_lock lock(making_);
    if (!logs_[current_]) {
      logs_[current_] = std::make_unique<ChangeLog>(store_, sequence_ + 1, OpenMode::kCreate, 0);
    } else if (!has_former() && logs_[current_]->committed() > 0 &&
               logs_[current_]->end() >= most) {
      logs_[1 - current_] =
          std::make_unique<ChangeLog>(store_, sequence_ + 1, OpenMode::kCreate, 0);
      current_ = 1 - current_;
    }
    to = current_;
  }
  return logs_[to]->append(bytes, most) | kInLog | to;
}

bool GenerationVolume::is_in_log_alone() const {
  const ChangeLog* const log = logs_[current_].get();
  return log != nullptr && log->committed() > 0 && !has_former() &&
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
  return place;
}

LogPlace GenerationVolume::finish_log(bool durable) {
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
  sequence_ = sequence;
}

void GenerationVolume::roll_back() {
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
