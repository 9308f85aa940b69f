#include "paging/needed_until.h"

#include <algorithm>
#include <array>
#include <span>

#include "paging/pin_batch.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether the blocks of a finer level of the same attribute have the same edges.
bool is_like_a_finer_level(std::span<const NeededLevel> levels, const LevelFile& level) {
  return std::ranges::any_of(levels, [&](const NeededLevel& each) {
    const LevelFile& other = *each.level;
    return other.table.attribute() == level.table.attribute() &&
           other.table.level() > level.table.level() && needs_other_blocks(other) &&
           other.geometry.slots_per_block_log2() == level.geometry.slots_per_block_log2();
  });
}

void need(std::span<NeededLevel> levels, const ContextBlock& block, EdgeId until) {
  for (NeededLevel& each : levels) {
    if (each.level->table.attribute() != block.attribute ||
        each.level->table.level() != block.level ||
        block.block >= each.level->geometry.block_count())
      continue;
    each.until.resize(each.level->geometry.block_count());
    each.until[block.block] = std::max(each.until[block.block], until);
  }
}

}  // namespace

void find_needed_until(std::vector<NeededLevel>& levels) {
  std::ranges::sort(levels, [](const NeededLevel& a, const NeededLevel& b) {
    return comes_before(*a.level, *b.level);
  });
  // The last level first: then it is known how long its blocks are needed themselves.
  for (auto user = levels.rbegin(); user != levels.rend(); ++user) {
    const LevelFile& level = *user->level;
    if (!needs_other_blocks(level) || is_like_a_finer_level(levels, level)) continue;
    for (std::uint64_t block = 0; block < level.geometry.block_count(); ++block) {
      EdgeId until = level.geometry.edge_after(block);
      if (!user->until.empty()) until = std::max(until, user->until[block]);
      std::array<ContextBlock, kMostContextBlocks> needed;
      const std::size_t count = level.writable ? level.backend->context(block, needed)
                                               : level.backend->read_context(block, needed);
      for (const ContextBlock& context : std::span(needed).first(count))
        need(levels, context, until);
    }
  }
  // That nobody named a block proves nothing about levels that were not asked.
  for (NeededLevel& level : levels) std::ranges::replace(level.until, EdgeId{0}, kNoId);
}

PLAIT_END_NAMESPACE
