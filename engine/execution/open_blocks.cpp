#include "execution/open_blocks.h"

namespace plait {

OpenBlocks::OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels)
    : store_(store),
      level_count_(levels),
      stays_in_memory_(store.backend_traits().direct && !store.backend_traits().durable) {
  for (const AttributeId attribute : attributes)
    for (int number = 1; number <= levels; ++number) {
      Level& level = levels_.emplace_back();
      level.file = &store.level_file(attribute, store.base_level() + number);
      const LevelGeometry& geometry = level.file->geometry;
      level.pins.resize(geometry.block_count());
      level.remaining.resize(geometry.block_count());
      for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
        level.remaining[block] = geometry.edge_after(block) - geometry.first_edge(block);
    }
}

void OpenBlocks::open(EdgeId edge) {
  for (Level& level : levels_) {
    const std::uint64_t block = level.file->geometry.block_of(edge);
    if (!level.pins[block])
      level.pins[block] = store_.pager().pin(*level.file, block, Access::kWrite);
  }
}

std::byte* OpenBlocks::slot(std::size_t output, int number, EdgeId edge) const {
  const Level& at = level(output, number);
  const LevelGeometry& geometry = at.file->geometry;
  const std::uint64_t block = geometry.block_of(edge);
  return at.pins[block].bytes().data() +
         (geometry.slot_offset(edge) - geometry.block_offset(block));
}

void OpenBlocks::close(EdgeId edge) {
  for (Level& level : levels_) {
    const std::uint64_t block = level.file->geometry.block_of(edge);
    if (--level.remaining[block] == 0) level.pins[block].release();
  }
}

}  // namespace plait
