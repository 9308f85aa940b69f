#include "maintenance/block_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool before(const BlockAddress& a, const BlockAddress& b) {
  return std::tie(a.attribute, a.level, a.block) < std::tie(b.attribute, b.level, b.block);
}

}  // namespace

void BlockRepair::run() {
  const auto any_open = [&] {
    for (std::size_t at = 0; at < damaged_.size(); ++at)
      if (is_open(at)) return true;
    return false;
  };
  if (!any_open()) return;
  Store& made = recomputed_.made();
  write(made, proven_by_seals(made));
  if (any_open()) write(made, proven_by_surroundings(made));
}

std::string BlockRepair::why_lost(const BlockAddress& block) const {
  if (needs_other_blocks(block))
    return "it is encoded from other blocks, and repair cannot encode it again";
  const std::string refusal = recomputed_.refusal(name(block.attribute));
  return refusal.empty() ? "what follows from the base mesh is not what it held" : refusal;
}

bool BlockRepair::needs_other_blocks(const BlockAddress& block) const {
  const LevelFile& level = store_.level_file(block.attribute, block.level);
  return level.backend->needs_base_records() || level.is_fixed;
}

PinnedBlock BlockRepair::made_block(Store& made, const BlockAddress& at) const {
  const LevelFile& file = made.level_file(made.attribute(name(at.attribute)), at.level);
  return made.open_session().pin(file, at.block);
}

void BlockRepair::progress(const char* phase, std::uint64_t done, std::uint64_t total) const {
  if (options_.proceed && !options_.proceed(phase, done, total))
    throw Error(ErrorCode::kCancelled, fmt::format("repair {}: cancelled", store_.path().native()));
}

std::vector<std::size_t> BlockRepair::proven_by_seals(Store& made) {
  std::vector<std::size_t> proven;
  for (std::size_t at = 0; at < damaged_.size(); ++at) {
    progress("compare", at, damaged_.size());
    if (!is_open(at)) continue;
    const BlockAddress& block = damaged_[at];
    const PinnedBlock pinned = made_block(made, block);
    if (proof_.stored_bytes(store_.level_file(block.attribute, block.level),
                            schema(block.attribute), block.block, pinned.bytes()))
      proven.push_back(at);
  }
  return proven;
}

std::vector<std::size_t> BlockRepair::proven_by_surroundings(Store& made) {
  std::vector<std::size_t> proven;
  for (AttributeId attribute = 0; attribute < store_.attributes().size(); ++attribute) {
    std::vector<std::size_t> open;
    for (std::size_t at = 0; at < damaged_.size(); ++at) {
      const BlockAddress& block = damaged_[at];
      if (block.attribute == attribute && is_open(at) &&
          store_.level_file(attribute, block.level).table[block.block].encoding ==
              BlockEncoding::kEncoded)
        open.push_back(at);
    }
    if (open.empty()) continue;
    const std::vector<int> levels = levels_of_another_codec(made, attribute);
    for (const std::size_t at : open)
      if (std::ranges::find(levels, damaged_[at].level) != levels.end()) proven.push_back(at);
  }
  return proven;
}

std::vector<int> BlockRepair::levels_of_another_codec(Store& made, AttributeId attribute) {
  const AttributeInfo& info = store_.attributes()[attribute];
  if (!std::ranges::equal(std::as_const(store_).base_bytes(attribute),
                          made.base_bytes(made.attribute(info.schema.name))))
    return {};
  std::vector<int> levels;
  for (int level = store_.base_level() + 1; level <= info.finest_level; ++level) {
    LevelFile& file = store_.level_file(attribute, level);
    bool differs = false;
    for (std::uint64_t block = 0; block < file.table.size(); ++block) {
      progress("compare everything", block, file.table.size());
      const BlockAddress at{attribute, level, block};
      if (std::ranges::binary_search(damaged_, at, before)) continue;
      const PinnedBlock expected = made_block(made, at);
      const PinnedBlock found = store_.open_session().pin(file, block, Access::kRead);
      if (!std::ranges::equal(expected.bytes(), found.bytes())) return {};
      if (!differs && file.table[block].encoding == BlockEncoding::kEncoded)
        differs = !proof_.stored_bytes(file, schema(attribute), block, found.bytes());
    }
    if (differs) levels.push_back(level);
  }
  return levels;
}

void BlockRepair::write(Store& made, const std::vector<std::size_t>& proven) {
  for (const std::size_t at : proven) {
    rebuilt_[at] = true;
    if (options_.dry_run) continue;
    const BlockAddress& block = damaged_[at];
    const PinnedBlock from = made_block(made, block);
    const PinnedBlock to = store_.open_session().pin(
        store_.level_file(block.attribute, block.level), block.block, Access::kOverwrite);
    std::ranges::copy(from.bytes(), to.bytes().begin());
  }
  // Nothing is on its way when block tables are read again.
  if (!options_.dry_run && !proven.empty()) store_.pager().flush();
}

PLAIT_END_NAMESPACE
