#include "tune/block_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "plait/block_maker.h"
#include "plait/block_table.h"
#include "plait/error.h"
#include "tune/thread_time.h"

namespace plait::tune {
namespace {

/// The largest size that is stored: docs/format.md, "Level files". Blocks that save less stay raw.
std::uint64_t most_encoded_bytes(std::uint64_t raw_bytes) {
  return raw_bytes - (raw_bytes + 7) / 8;
}
/// What a stored block takes of a file: docs/format.md, "Level files".
std::uint64_t extent(std::uint64_t bytes) {
  constexpr std::uint64_t kAlignmentBytes = 512;
  return (bytes + kAlignmentBytes - 1) / kAlignmentBytes * kAlignmentBytes;
}
/// In front of blocks that are encoded from others: the seal of those.
constexpr std::size_t kSealBytes = 8;

/// Of the levels of an attribute; empty if no scheme makes them again.
std::string recipe_of(const PipelineRegistry& registry, const Store& store, AttributeId id) {
  const auto& [schema, finest] = store.attributes()[id];
  const BlockMakers* const makers = registry.block_makers();
  return makers == nullptr ? "" : makers->recipe(store.provenance(), schema, finest);
}

AttributeId number_of(const Store& store, const ContextBlock& block) {
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level >= block.level &&
        store.level_file(id, block.level).table.attribute() == block.attribute)
      return id;
  throw Error(ErrorCode::kNotFound,
              fmt::format("tune: no attribute has the number {}", block.attribute));
}

}  // namespace

/// The filters of one level, and the attributes that their context is in.
struct BlockTrials::Filtered {
  Pipeline pipeline;
  int level = 0;
  std::uint32_t number = 0;
};

struct BlockTrials::Block {
  std::uint64_t number = 0;
  std::span<const std::byte> raw;
  BlockTable& table;
};

BlockTrials::BlockTrials(const PipelineRegistry& registry, StoreBytes& bytes)
    : registry_(registry), bytes_(bytes) {}
BlockTrials::~BlockTrials() = default;

BlockTrials::Filtered& BlockTrials::filters_of(const BlockGrid& grid, const SamplePart& part,
                                               const std::string& pipeline) {
  // Codecs are made once for all, so only the filters count.
  const std::size_t comma = pipeline.find(',');
  const std::string chain = comma == std::string::npos ? "none" : pipeline.substr(0, comma);
  const std::string key =
      fmt::format("{} {} {} {}", part.attribute, part.level, grid.block_bytes(), chain);
  std::unique_ptr<Filtered>& kept = filters_[key];
  if (kept) return *kept;
  const Store& store = bytes_.store();
  auto made = std::make_unique<Filtered>();
  made->level = part.level;
  const std::string recipe = recipe_of(registry_, store, part.attribute);
  made->number = store.level_file(part.attribute, part.level).table.attribute();
  made->pipeline = registry_.make(
      with_recipe(chain + ",none", recipe),
      {store.attributes()[part.attribute].schema, &grid.geometry(part.attribute, part.level),
       made->number, part.level, &grid.surroundings()});
  made->pipeline.codec.reset();
  kept = std::move(made);
  return *kept;
}

Codec& BlockTrials::codec_of(const std::string& pipeline) {
  const std::size_t comma = pipeline.find(',');
  const std::string text = comma == std::string::npos ? pipeline : pipeline.substr(comma + 1);
  std::unique_ptr<Codec>& codec = codecs_[text];
  if (!codec) codec = registry_.make_codec(text);
  return *codec;
}

bool BlockTrials::needs_other_blocks(const BlockGrid& grid, const SamplePart& part,
                                     const std::string& pipeline) {
  const auto& filters = filters_of(grid, part, pipeline).pipeline.filters;
  return !filters.empty() && filters.front()->needs_other_blocks();
}

bool BlockTrials::is_made(const BlockGrid& grid, const SamplePart& part,
                          const std::string& pipeline) {
  const auto& maker = filters_of(grid, part, pipeline).pipeline.maker;
  if (!maker) return false;
  const LevelGeometry& geometry = grid.geometry(part.attribute, part.level);
  const auto raw = bytes_.read(part.attribute, part.level, part.offset, part.bytes);
  for (std::uint64_t done = 0; done < part.bytes;) {
    const std::uint64_t block = geometry.block_at(part.offset + done);
    const std::uint64_t bytes = geometry.block_bytes(block);
    if (maker->makes(block, raw.subspan(done, bytes))) return true;
    done += bytes;
  }
  return false;
}

void BlockTrials::gather_context(const BlockGrid& grid, const Filtered& filtered,
                                 std::uint64_t block) {
  context_.clear();
  if (filtered.pipeline.filters.empty()) return;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = filtered.pipeline.filters.front()->context(block, needed);
  for (const ContextBlock& other : std::span(needed).first(count)) {
    const AttributeId id = number_of(bytes_.store(), other);
    const LevelGeometry& geometry = grid.geometry(id, other.level);
    context_.push_back(bytes_.read(id, other.level, geometry.block_offset(other.block),
                                   geometry.block_bytes(other.block)));
  }
}

void BlockTrials::measure(const BlockGrid& grid, const SamplePart& part,
                          const std::string& pipeline, Outcome& outcome) {
  Filtered& filtered = filters_of(grid, part, pipeline);
  Codec& codec = codec_of(pipeline);
  bytes_.make_room();
  const auto whole = bytes_.read(part.attribute, part.level, part.offset, part.bytes);
  const LevelGeometry& geometry = grid.geometry(part.attribute, part.level);
  BlockTable table({}, filtered.number, part.level, geometry.block_count());
  Outcome visit;
  visit.visits = 1;
  const std::uint64_t first = geometry.block_at(part.offset);
  for (std::uint64_t block = first;
       block < geometry.block_count() && geometry.block_offset(block) < part.offset + part.bytes;
       ++block) {
    gather_context(grid, filtered, block);
    const Block one{
        block,
        whole.subspan(geometry.block_offset(block) - part.offset, geometry.block_bytes(block)),
        table};
    if (outcome.visits == 0 && block == first) {
      // The first time, memory is new, and tables of the codec are set up.
      Outcome ignored;
      run(filtered, codec, one, ignored);
    }
    run(filtered, codec, one, visit);
  }
  if (outcome.visits > 0) {
    visit.encode_seconds = std::min(visit.encode_seconds, outcome.encode_seconds);
    visit.decode_seconds = std::min(visit.decode_seconds, outcome.decode_seconds);
    visit.visits += outcome.visits;
  }
  outcome = visit;
}

void BlockTrials::run(Filtered& filtered, Codec& codec, const Block& block, Outcome& outcome) {
  const auto& filters = filtered.pipeline.filters;
  const std::span<const std::byte> raw = block.raw;
  const std::size_t seal = filters.empty()
                               ? 0
                               : (filters.front()->needs_other_blocks() ? kSealBytes : 0) +
                                     (filters.front()->keeps_note() ? 1 : 0);
  buffers_.resize(std::max(buffers_.size(), filters.size() + 1));
  for (auto& buffer : buffers_) buffer.resize(std::max(buffer.size(), raw.size()));
  encoded_.resize(std::max<std::size_t>(encoded_.size(), most_encoded_bytes(raw.size())));
  for (const auto& filter : filters)
    scratch_.resize(std::max(scratch_.size(), filter->scratch_bytes()));
  std::byte note{};
  const FilterBlock with{block.number, context_, scratch_, &note};

  const BlockMaker* const maker = filtered.pipeline.maker.get();
  double start = thread_seconds();
  const bool is_made = maker != nullptr && maker->makes(block.number, raw);
  if (is_made) {
    block.table.seal_predicted(block.number, raw);
    outcome.encode_seconds += thread_seconds() - start;
    const std::span<std::byte> to(buffers_.front().data(), raw.size());
    start = thread_seconds();
    maker->make(block.number, to);
    block.table.check(block.number, to, "tune");
    outcome.decode_seconds += thread_seconds() - start;
    outcome.raw_bytes += static_cast<double>(raw.size());
    outcome.stored_bytes += sizeof(BlockEntry);
    return;
  }
  std::span<const std::byte> from = raw;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    const std::span<std::byte> to(buffers_[i].data(), raw.size());
    filters[i]->encode(with, from, to);
    from = to;
  }
  std::optional<std::size_t> encoded;
  if (most_encoded_bytes(raw.size()) > seal)
    encoded =
        codec.compress(from, std::span(encoded_).first(most_encoded_bytes(raw.size()) - seal));
  const bool is_raw = !encoded || *encoded == 0;
  const std::span<const std::byte> stored =
      is_raw ? raw : std::span<const std::byte>(encoded_).first(*encoded);
  block.table.seal(block.number, 0, is_raw ? BlockEncoding::kRaw : BlockEncoding::kEncoded, stored);
  outcome.encode_seconds += thread_seconds() - start;

  start = thread_seconds();
  block.table.check(block.number, stored, "tune");
  std::span<std::byte> to(buffers_[filters.size()].data(), raw.size());
  if (!is_raw) {
    codec.decompress(stored, to);
    for (std::size_t i = filters.size(); i > 0; --i) {
      const std::span<const std::byte> source = to;
      to = {buffers_[i - 1].data(), raw.size()};
      filters[i - 1]->decode(with, source, to);
    }
  }
  outcome.decode_seconds += thread_seconds() - start;
  if (!is_raw && !std::ranges::equal(to, raw))
    throw Error(ErrorCode::kCorruption,
                fmt::format("tune: block {} of level {} decodes to other bytes", block.number,
                            filtered.level));
  outcome.raw_bytes += static_cast<double>(raw.size());
  outcome.stored_bytes +=
      static_cast<double>(sizeof(BlockEntry) + (is_raw ? raw.size() : extent(seal + *encoded)));
}

}  // namespace plait::tune
