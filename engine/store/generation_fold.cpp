// Where the blocks of a level are in a new version. A fold moves blocks, so that the log is not
// much larger than what counts of it: the table of docs/durability.md says which and where to.
//
// No byte is overwritten that the newest version or a reader's version names, so neither a crash
// nor a reader finds anything changed. While the newest version has a block in the log, the block's
// place in the level's file is free for the next one.
#include <algorithm>
#include <optional>

#include "io/copy_range.h"
#include "plait/extend/file.h"
#include "store/generation_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void GenerationLevel::sync(bool durable) {
  if (volume_.has_former() && !new_.backend) {
    if (volume_.is_unread())
      leave_former_log(true);
    else if (4 * count_in_log() >= places_.size())
      make_new_file();
    else
      leave_former_log(false);
  }
  if (new_.backend) {
    fill_new_file();
    new_.backend->sync(durable);
  } else if (file_has_changed_) {
    file_.backend->sync(durable);
  }
}

void GenerationLevel::leave_former_log(bool to_level_file) {
  std::vector<std::byte> bytes(level_.geometry.max_block_bytes());
  std::optional<File> file;
  for (std::uint64_t block = 0; block < places_.size(); ++block) {
    const BlockPlace place = places_[block];
    if (!volume_.is_in_former(place)) continue;
    const std::span<std::byte> of_block =
        std::span(bytes).first(level_.geometry.block_bytes(block));
    volume_.log_at(place).read(log_offset(place), of_block);
    BlockEntry& entry = level_.table.entries()[block];
    if (to_level_file && !volume_.is_new(place)) {
      if (!file) file.emplace(level_.directory, file_.name, OpenMode::kReadWrite);
      entry.offset = level_.geometry.block_offset(block);
      entry.file = kLevelFile;
      file->write_at(entry.offset, of_block);
      places_[block] = kInLevelFile;
      file_has_changed_ = true;
    } else {
      const BlockPlace moved = volume_.append(of_block);
      places_[block] = moved;
      entry.offset = log_offset(moved);
    }
  }
}

void GenerationLevel::fill_new_file() {
  const LevelGeometry& geometry = level_.geometry;
  File target(level_.directory, new_.name, OpenMode::kReadWrite);
  const File source(level_.directory, file_.name, OpenMode::kRead);
  std::vector<std::byte> bytes(geometry.max_block_bytes());
  for (std::uint64_t block = 0; block < places_.size();) {
    const BlockPlace place = places_[block];
    const std::uint64_t begin = block++;
    if (place == kInNewFile || !is_stored(begin)) {
      places_[begin] = kInNewFile;
      continue;
    }
    if (is_in_log(place)) {
      const std::span<std::byte> of_block = std::span(bytes).first(geometry.block_bytes(begin));
      volume_.log_at(place).read(log_offset(place), of_block);
      target.write_at(geometry.block_offset(begin), of_block);
    } else {
      while (block < places_.size() && places_[block] == place && is_stored(block)) ++block;
      copy_range(source, target, geometry.block_offset(begin),
                 geometry.range_bytes(begin, block - begin));
    }
    for (std::uint64_t moved = begin; moved < block; ++moved) {
      places_[moved] = kInNewFile;
      BlockEntry& entry = level_.table.entries()[moved];
      entry.offset = geometry.block_offset(moved);
      entry.file = kLevelFile;
    }
  }
  level_.table.set_generation(new_.generation);
}

void GenerationLevel::add_changes(std::vector<ChangedBlock>& changes) const {
  for (const std::uint64_t block : changed_) {
    const BlockEntry& entry = level_.table[block];
    changes.push_back({level_.table.attribute(), static_cast<std::uint32_t>(level_.table.level()),
                       block, entry.offset, entry.checksum});
  }
}

void GenerationLevel::begin_version() {
  const bool is_known = is_in_log_alone();
  if (new_.backend) {
    for (std::atomic<BlockPlace>& place : places_) place = kInLevelFile;
    file_ = std::move(new_);
    new_ = {};
  }
  if (!is_known)
    for (std::uint64_t block = 0; block < committed_.size(); ++block)
      committed_[block] = is_stored(block);
  changed_.clear();
  all_will_change_ = false;
  file_has_changed_ = false;
}

PLAIT_END_NAMESPACE
