// Which files of a level a new version has. A fold moves blocks so that a level keeps few files
// which are not much larger than the level:
//
//  blocks in the new file   in all sparse files   the version has
//  half of the level's      -                     the new file, to which all others are copied;
//  also
//                                                 if a pass was to write all blocks, and wrote few
//  fewer                    fewer than half       the files there are, and the new one
//  fewer                    half, or there are    the whole file, to which the older sparse blocks
//                           too many files        are copied, and the new one
//
// The last row overwrites places in the whole file. The committed version does not read its blocks
// there, because it has them in sparse files. While readers have older versions open, which may
// read these places, the older sparse blocks are copied to the new file instead.
#include <algorithm>
#include <optional>

#include "io/copy_range.h"
#include "plait/extend/file.h"
#include "store/generation_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void GenerationLevel::sync(bool durable) {
  if (new_.backend) {
    fold();
    enter_files();
    new_.backend->sync(durable);
  }
  files_.front().backend->sync(durable);
}

void GenerationLevel::fold() {
  const Home last_sparse = static_cast<Home>(files_.size() - 1);
  const bool is_due = holds_half(sparse_blocks()) || files_.size() > kMostSparseFiles;
  if (is_due && last_sparse > 0 && !new_is_whole())
    move_blocks(1, last_sparse, volume_.has_held_ ? new_home() : Home{0});
  if (new_is_whole()) move_blocks(0, last_sparse, new_home());
}

void GenerationLevel::move_blocks(Home first, Home last, Home to) {
  const LevelGeometry& geometry = level_.geometry;
  std::optional<File> target, source;
  std::optional<Home> open_source;
  for (std::uint64_t block = 0; block < home_.size();) {
    const Home from = home_[block];
    if (from < first || from > last || !is_stored(block)) {
      ++block;
      continue;
    }
    const std::uint64_t begin = block;
    while (block < home_.size() && home_[block] == from && is_stored(block)) ++block;
    if (!target) target.emplace(level_.directory, file_at(to).name, OpenMode::kReadWrite);
    if (open_source != from) source.emplace(level_.directory, file_at(from).name, OpenMode::kRead);
    open_source = from;
    copy_range(*source, *target, geometry.block_offset(begin),
               geometry.range_bytes(begin, block - begin));
    for (std::uint64_t moved = begin; moved < block; ++moved) note_written(moved, to);
  }
}

void GenerationLevel::enter_files() {
  std::vector<std::uint64_t> blocks(files_.size() + 1);
  for (std::uint64_t block = 0; block < home_.size(); ++block)
    if (is_stored(block)) ++blocks[home_[block]];
  new_.generation.blocks = new_is_whole() ? 0 : new_blocks_.load();
  std::vector<Generation> kept;
  kept_as_.assign(blocks.size(), kDropped);
  for (std::size_t home = 0; home < blocks.size(); ++home) {
    const bool is_whole = home == (new_is_whole() ? files_.size() : 0);
    if (blocks[home] == 0 && !is_whole) continue;
    kept_as_[home] = static_cast<Home>(kept.size());
    kept.push_back(file_at(static_cast<Home>(home)).generation);
  }
  level_.table.set_generations(std::move(kept));
  for (std::uint64_t block = 0; block < home_.size(); ++block)
    level_.table.entries()[block].file =
        is_stored(block) ? kept_as_[home_[block]] : std::uint16_t{0};
}

void GenerationLevel::begin_version() {
  if (new_.backend) {
    for (std::atomic<Home>& home : home_)
      home = kept_as_[home] == kDropped ? Home{0} : kept_as_[home];
    files_.push_back(std::move(new_));
    new_ = {};
    std::vector<OpenFile> kept;
    for (std::size_t home = 0; home < files_.size(); ++home)
      if (kept_as_[home] != kDropped) kept.push_back(std::move(files_[home]));
    files_ = std::move(kept);
    new_blocks_ = 0;
    has_room_ = false;
    all_will_change_ = false;
  }
  note_committed();
}

PLAIT_END_NAMESPACE
