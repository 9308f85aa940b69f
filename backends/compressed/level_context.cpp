#include "compressed/level_context.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The checksum of the words that stand for the context of a block.
class ContextSeal {
 public:
  void add(std::uint64_t word) { words_[count_++] = word; }
  std::uint64_t value() const { return XXH3_64bits(words_.data(), count_ * sizeof(words_[0])); }

 private:
  std::array<std::uint64_t, 2 * kMostContextBlocks + 1> words_{};
  std::size_t count_ = 0;
};

bool is_table_of(const BlockTable& table, const ContextBlock& block) {
  return table.attribute() == block.attribute && table.level() == block.level;
}

}  // namespace

LevelContext::LevelContext(const LevelSpec& level, const Filters& filters,
                           std::span<const BlockTable* const> open_tables)
    : path_(level.path()), filters_(filters) {
  for (const AttributeLevels& attribute : level.surroundings.attributes)
    if (attribute.number == base_attribute()) base_ = attribute.base;
  if (level.geometry.block_count() == 0) return;
  // All blocks need blocks of the same levels.
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = blocks_for(0, needed);
  for (const BlockTable* const table : open_tables)
    if (std::ranges::any_of(std::span(needed).first(count),
                            [&](const ContextBlock& block) { return is_table_of(*table, block); }))
      tables_.push_back(table);
}

std::size_t LevelContext::blocks_for(
    std::uint64_t block, std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
  return filters_.empty() ? 0 : filters_.front()->context(block, blocks);
}

std::uint32_t LevelContext::base_attribute() const noexcept {
  return filters_.empty() ? kNoId : filters_.front()->base_attribute();
}

const BlockTable& LevelContext::table_of(std::uint64_t block, const ContextBlock& needed) const {
  for (const BlockTable* const table : tables_)
    if (is_table_of(*table, needed)) return *table;
  throw Error(ErrorCode::kNotSupported,
              fmt::format("transfer {}: block {} needs level {} of attribute {}, which is not open",
                          path_.native(), block, needed.level, needed.attribute));
}

std::optional<std::uint64_t> LevelContext::seal(
    std::uint64_t block, std::span<const std::span<const std::byte>> given) const {
  if (!need_other_blocks(filters_)) return std::nullopt;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = blocks_for(block, needed);
  if (given.size() != count)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("transfer {}: block {} needs {} other blocks, found {}", path_.native(),
                            block, count, given.size()));
  ContextSeal seal;
  if (base_attribute() != kNoId) {
    std::call_once(base_sealed_, [&] { base_seal_ = XXH3_64bits(base_.data(), base_.size()); });
    seal.add(base_seal_);
  }
  for (const ContextBlock& other : std::span(needed).first(count)) {
    const BlockTable& table = table_of(block, other);
    seal.add((static_cast<std::uint64_t>(other.attribute) << 32) |
             static_cast<std::uint64_t>(other.level));
    seal.add(table[other.block].checksum);
  }
  return seal.value();
}

PLAIT_END_NAMESPACE
