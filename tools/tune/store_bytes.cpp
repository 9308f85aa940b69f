#include "tune/store_bytes.h"

#include <algorithm>
#include <cstring>

namespace plait::tune {

BlockGrid::BlockGrid(const Store& store, std::uint64_t block_bytes)
    : block_bytes_(block_bytes), first_level_(store.base_level() + 1) {
  surroundings_.mesh = store.base().topology();
  surroundings_.base_level = store.base_level();
  surroundings_.positions = store.base().positions();
  geometries_.resize(store.attributes().size());
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const auto& [schema, finest] = store.attributes()[id];
    std::vector<LevelGeometry>& levels = geometries_[id];
    for (int level = first_level_; level <= finest; ++level)
      levels.emplace_back(store.base().slot_shapes(), relative_to_base(level, store.base_level()),
                          schema.record_bytes(), block_bytes);
    if (levels.empty()) continue;
    AttributeLevels known{
        store.level_file(id, finest).table.attribute(), schema, store.base_bytes(id), {}};
    for (const LevelGeometry& geometry : levels) known.levels.push_back(&geometry);
    surroundings_.attributes.push_back(std::move(known));
  }
}

bool BlockGrid::same_blocks(const BlockGrid& other) const {
  return std::ranges::equal(
      geometries_, other.geometries_, [](const auto& levels, const auto& others) {
        return std::ranges::equal(levels, others, [](const auto& a, const auto& b) {
          return a.slots_per_block_log2() == b.slots_per_block_log2();
        });
      });
}

StoreBytes::StoreBytes(const Store& store, std::uint64_t most_kept_bytes)
    : store_(store),
      session_(store.open_session({.policy = EvictionPolicy::kClock})),
      most_kept_bytes_(most_kept_bytes) {}

std::span<const std::byte> StoreBytes::read(AttributeId attribute, int level, std::uint64_t offset,
                                            std::uint64_t count) {
  std::vector<std::byte>& bytes = kept_[{attribute, level, offset, count}];
  if (bytes.size() == count) return bytes;
  const LevelFile& file = store_.level_file(attribute, level);
  std::vector<std::byte> read(count);
  for (std::uint64_t done = 0; done < count;) {
    const std::uint64_t block = file.geometry.block_at(offset + done);
    const std::uint64_t inside = offset + done - file.geometry.block_offset(block);
    const PinnedBlock pinned = session_.pin(file, block);
    const auto from = pinned.bytes().subspan(inside);
    const std::uint64_t part = std::min<std::uint64_t>(from.size(), count - done);
    std::memcpy(read.data() + done, from.data(), part);
    done += part;
  }
  bytes = std::move(read);
  kept_bytes_ += count;
  bytes_read_ += count;
  return bytes;
}

void StoreBytes::make_room() {
  if (kept_bytes_ <= most_kept_bytes_) return;
  kept_.clear();
  kept_bytes_ = 0;
}

}  // namespace plait::tune
