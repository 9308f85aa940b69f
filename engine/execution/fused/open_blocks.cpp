#include "execution/fused/open_blocks.h"

#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

OpenBlocks::OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels)
    : session_(StoreAccess::open_session(store)),
      level_count_(static_cast<std::size_t>(levels)),
      stays_in_memory_(store.backend_traits().in_memory) {
  for (const AttributeId attribute : attributes)
    for (int number = 1; number <= levels; ++number) {
      LevelFile& file = StoreAccess::level_file(
          store, attribute, level_number(BaseRelativeLevel(number), store.base_level()));
      levels_.emplace_back(file, Access::kOverwrite);
      std::vector<std::uint32_t>& to_fill = to_fill_.emplace_back();
      for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block)
        to_fill.push_back(static_cast<std::uint32_t>(file.geometry.slot_count(block)));
    }
}

void OpenBlocks::open(std::span<const EdgeId> edges) {
  for (PinnedLevel& level : levels_) {
    level.begin_step();
    for (const EdgeId edge : edges) level.need(edge);
  }
  PinnedLevel::pin_needed(session_, levels_);
}

void OpenBlocks::find_slots(std::size_t output, EdgeId edge, std::byte** slots) const {
  for (const PinnedLevel& level : std::span(levels_).subspan(output * level_count_, level_count_))
    *slots++ = level.slot(edge).bytes.data();
}

void OpenBlocks::close(std::span<const EdgeId> edges) {
  auto to_fill = to_fill_.begin();
  for (PinnedLevel& level : levels_) {
    const LevelGeometry& geometry = level.geometry();
    std::uint32_t* const of_block = (to_fill++)->data();
    for (const EdgeId edge : edges)
      if (--of_block[geometry.block_of(edge)] == 0) level.release(edge);
  }
}

PLAIT_END_NAMESPACE
