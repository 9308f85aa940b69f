#include "execution/fused/open_blocks.h"

#include <span>

namespace plait {

OpenBlocks::OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels)
    : session_(store.open_session()),
      level_count_(static_cast<std::size_t>(levels)),
      stays_in_memory_(store.backend_traits().in_memory) {
  for (const AttributeId attribute : attributes)
    for (int number = 1; number <= levels; ++number) {
      Level& level = levels_.emplace_back();
      level.file =
          &store.level_file(attribute, level_number(BaseRelativeLevel(number), store.base_level()));
      const LevelGeometry& geometry = level.file->geometry;
      level.pins.resize(geometry.block_count());
      level.remaining.resize(geometry.block_count());
      for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
        level.offsets.push_back(geometry.block_offset(block));
        level.remaining[block] = geometry.edge_after(block) - geometry.first_edge(block);
      }
    }
}

OpenBlocks::~OpenBlocks() {
  for (Level& level : levels_)
    for (PinnedBlock& pin : level.pins) pin.abandon();
}

void OpenBlocks::open(EdgeId edge) {
  for (Level& level : levels_) {
    const std::uint64_t block = level.file->geometry.block_of(edge);
    if (!level.pins[block]) level.pins[block] = session_.pin(*level.file, block, Access::kWrite);
  }
}

void OpenBlocks::find_slots(std::size_t output, EdgeId edge, std::uint64_t border_rank,
                            std::byte** slots) const {
  for (const Level& level : std::span(levels_).subspan(output * level_count_, level_count_)) {
    const LevelGeometry& geometry = level.file->geometry;
    const std::uint64_t block = geometry.block_of(edge);
    *slots++ = level.pins[block].bytes().data() +
               (geometry.slot_offset(edge, border_rank) - level.offsets[block]);
  }
}

void OpenBlocks::close(EdgeId edge) {
  for (Level& level : levels_) {
    const std::uint64_t block = level.file->geometry.block_of(edge);
    if (--level.remaining[block] == 0) level.pins[block].release();
  }
}

}  // namespace plait
