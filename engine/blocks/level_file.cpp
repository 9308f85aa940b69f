#include "plait/detail/level_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

int most_run_log2(const LevelGeometry& geometry) noexcept {
  const std::uint64_t bytes = std::max<std::uint64_t>(geometry.max_block_bytes(), 1);
  const std::uint64_t blocks = std::min<std::uint64_t>(kRunBytes / bytes, kMostRunBlocks);
  return std::max(static_cast<int>(std::bit_width(blocks)) - 1, 0);
}

BlockRange run_of(const LevelFile& level, std::uint64_t block) noexcept {
  const std::uint64_t first = block >> level.run_log2 << level.run_log2;
  const std::uint64_t most = std::uint64_t{1} << level.run_log2;
  return {first, std::min(most, level.geometry.block_count() - first)};
}

bool needs_other_blocks(const LevelFile& level) noexcept {
  if (level.traits.in_memory || level.geometry.block_count() == 0) return false;
  std::array<ContextBlock, kMostContextBlocks> needed;
  return level.backend->context(0, needed) > 0;
}

void check_not_encoded_from_each_other(std::span<const LevelFile* const> written) {
  for (const LevelFile* const level : written) {
    if (level->traits.in_memory || level->geometry.block_count() == 0) continue;
    std::array<ContextBlock, kMostContextBlocks> needed;
    const std::size_t count = level->backend->context(0, needed);
    for (const ContextBlock& block : std::span(needed).first(count))
      for (const LevelFile* const other : written)
        if (other->table.attribute() == block.attribute && other->table.level() == block.level)
          throw Error(ErrorCode::kBadState,
                      fmt::format("write {}: it is encoded from {}, expected that no pass writes "
                                  "both; write coarser levels first, or take a pipeline without "
                                  "prediction",
                                  level->path.native(), other->path.native()));
  }
}

void check_not_fixed(const LevelFile& level) {
  if (level.is_fixed)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: expected a level that no other level is encoded from; "
                            "write to a new attribute, or convert the store to a pipeline "
                            "without prediction first (plait convert --compress fast)",
                            level.path.native()));
}

UnfinishedLevels::~UnfinishedLevels() {
  for (const Added& added : added_) {
    added.records->left_unfinished = true;
    --added.records->passes_under_way;
  }
}

void UnfinishedLevels::add(LevelFile& level, Access access) {
  if (access == Access::kRead) return;
  check_not_fixed(level);
  level.backend->advise({0, level.geometry.block_count()}, Advice::kOverwrite);
  add_base(level, access);
}

void UnfinishedLevels::add_base(WrittenRecords& records, Access access) {
  if (access == Access::kRead) return;
  added_.push_back({&records, access});
  records.first_missing_face = kNoId;
  ++records.passes_under_way;
}

void UnfinishedLevels::finish() noexcept {
  for (const Added& added : added_) {
    if (added.access == Access::kOverwrite) added.records->left_unfinished = false;
    --added.records->passes_under_way;
  }
  added_.clear();
}

PLAIT_END_NAMESPACE
