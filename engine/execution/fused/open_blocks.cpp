#include "execution/fused/open_blocks.h"

#include <boost/container/small_vector.hpp>
#include <exception>
#include <utility>

#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Blocks, each with the number of the edges that have slots there.
class BlocksOfEdges {
 public:
  void add(std::uint64_t block) {
    // The edges of a group are close together, so there are few blocks, and the last one is likely.
    for (auto at = blocks_.rbegin(); at != blocks_.rend(); ++at)
      if (at->block == block) {
        ++at->edges;
        return;
      }
    blocks_.push_back({block, 1});
  }
  void clear() { blocks_.clear(); }
  auto begin() const { return blocks_.begin(); }
  auto end() const { return blocks_.end(); }

 private:
  struct Counted {
    std::uint64_t block;
    std::uint32_t edges;
  };
  boost::container::small_vector<Counted, 16> blocks_;
};

}  // namespace

OpenBlocks::OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels)
    : session_(StoreAccess::open_session(store, {.only_writes = true})),
      level_count_(static_cast<std::size_t>(levels)),
      stays_in_memory_(StoreAccess::backend_traits(store).in_memory),
      filled_(StoreAccess::block_filled(store)),
      exceptions_(std::uncaught_exceptions()) {
  for (const AttributeId attribute : attributes)
    for (int refinements = 1; refinements <= levels; ++refinements) {
      const int number = level_number(BaseRelativeLevel(refinements), store.base_level());
      LevelFile& file = StoreAccess::level_file(store, attribute, number);
      const std::uint64_t count = file.geometry.block_count();
      Level& level =
          levels_.emplace_back(Level{attribute, number, &file, std::make_unique<Block[]>(count)});
      for (std::uint64_t block = 0; block < count; ++block)
        level.blocks[block].to_fill = static_cast<std::uint32_t>(file.geometry.slot_count(block));
    }
}

OpenBlocks::~OpenBlocks() {
  if (std::uncaught_exceptions() <= exceptions_) return;
  for (const Level& level : levels_) {
    level.file->left_unfinished = true;
    for (Block& block : std::span(level.blocks.get(), level.file->geometry.block_count()))
      block.pinned.abandon();
  }
}

void OpenBlocks::open(std::span<const EdgeId> edges) {
  boost::container::small_vector<BlockRequest, 16> requests;
  boost::container::small_vector<Block*, 16> blocks;
  BlocksOfEdges absent;
  for (const Level& level : levels_) {
    absent.clear();
    const LevelGeometry& geometry = level.file->geometry;
    for (const EdgeId edge : edges)
      if (const std::uint64_t block = geometry.block_of(edge);
          level.blocks[block].start.load(std::memory_order_acquire) == 0)
        absent.add(block);
    for (const auto& [block, count] : absent) {
      requests.emplace_back(*level.file, block, Access::kOverwrite);
      blocks.push_back(&level.blocks[block]);
    }
  }
  if (requests.empty()) return;
  boost::container::small_vector<PinnedBlock, 16> pinned(requests.size());
  session_.pin_many({requests.data(), requests.size()}, {pinned.data(), pinned.size()});
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(pinned[i].bytes().data()) -
                                 requests[i].level().geometry.block_offset(requests[i].block());
    std::uintptr_t nobody = 0;
    if (blocks[i]->start.compare_exchange_strong(nobody, start, std::memory_order_acq_rel))
      blocks[i]->pinned = std::move(pinned[i]);
  }
}

void OpenBlocks::find_slots(std::size_t output, EdgeId edge, std::byte** slots) const {
  for (const Level& level : std::span(levels_).subspan(output * level_count_, level_count_)) {
    const LevelGeometry& geometry = level.file->geometry;
    const std::uintptr_t start =
        level.blocks[geometry.block_of(edge)].start.load(std::memory_order_relaxed);
    *slots++ = reinterpret_cast<std::byte*>(start + geometry.slot(edge).offset);
  }
}

void OpenBlocks::close(std::span<const EdgeId> edges) {
  BlocksOfEdges filled;
  for (const Level& level : levels_) {
    filled.clear();
    for (const EdgeId edge : edges) filled.add(level.file->geometry.block_of(edge));
    for (const auto& [number, count] : filled) {
      Block& block = level.blocks[number];
      if (block.to_fill.fetch_sub(count, std::memory_order_acq_rel) != count) continue;
      if (filled_) filled_(level.attribute, level.number, number, block.pinned.bytes());
      block.pinned.release();
    }
  }
}

PLAIT_END_NAMESPACE
