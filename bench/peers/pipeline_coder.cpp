#include <algorithm>
#include <array>
#include <memory>

#include "peers/coders.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/registry.h"

namespace plait::bench {
namespace {

class PipelineCoder {
 public:
  PipelineCoder(const RawSurface& surface, std::uint32_t attribute, const Pipeline& pipeline)
      : surface_(surface),
        filters_alone_(pipeline.codec.name == "none" && !pipeline.filters.empty()) {
    FilterLevel level;
    level.schema = surface.surroundings.attributes[attribute].schema;
    level.geometry = surface.surroundings.attributes[attribute].levels.back();
    level.attribute = attribute;
    level.level = surface.finest_level();
    level.surroundings = &surface.surroundings;
    pipeline_ = default_pipelines().open(pipeline, level);
    filtered_.assign(pipeline_.filters.size(),
                     std::vector<std::byte>(level.geometry->max_block_bytes()));
    std::size_t scratch = 0;
    for (const auto& filter : pipeline_.filters)
      scratch = std::max(scratch, filter->scratch_bytes());
    scratch_.resize(scratch);
  }

  std::size_t encode(const RawBlock& block, std::span<std::byte> to) {
    const FilterBlock with = filter_block(block.number);
    const std::size_t count = filtered_.size();
    std::span<const std::byte> from = block.raw;
    for (std::size_t i = 0; i < count; ++i) {
      const std::span<std::byte> into =
          filters_alone_ && i + 1 == count ? to.first(from.size()) : filtered(i, from.size());
      pipeline_.filters[i]->encode(with, from, into);
      from = into;
    }
    return filters_alone_ ? from.size() : pipeline_.codec->compress(from, to).value_or(0);
  }

  void decode(std::span<const std::byte> encoded, const RawBlock& block, std::span<std::byte> raw) {
    const FilterBlock with = filter_block(block.number);
    const auto after_decoding = [&](std::size_t filters) {
      return filters == 0 ? raw : filtered(filters - 1, raw.size());
    };
    std::span<const std::byte> from = encoded;
    if (!filters_alone_) {
      const std::span<std::byte> into = after_decoding(filtered_.size());
      pipeline_.codec->decompress(encoded, into);
      from = into;
    }
    for (std::size_t i = filtered_.size(); i > 0; --i) {
      const std::span<std::byte> into = after_decoding(i - 1);
      pipeline_.filters[i - 1]->decode(with, from, into);
      from = into;
    }
  }

 private:
  FilterBlock filter_block(std::uint64_t block) {
    if (pipeline_.filters.empty()) return {};
    std::array<ContextBlock, kMostContextBlocks> blocks;
    const std::size_t count = pipeline_.filters[0]->context(block, blocks);
    for (std::size_t i = 0; i < count; ++i) context_[i] = surface_.bytes_of(blocks[i]);
    return {block, std::span(context_).first(count), scratch_, &note_};
  }
  /// What filter `i` makes of a block.
  std::span<std::byte> filtered(std::size_t i, std::size_t bytes) {
    return std::span(filtered_[i]).first(bytes);
  }

  const RawSurface& surface_;
  bool filters_alone_;
  OpenPipeline pipeline_;
  std::vector<std::vector<std::byte>> filtered_;
  std::vector<std::byte> scratch_;
  std::array<std::span<const std::byte>, kMostContextBlocks> context_{};
  std::byte note_{};  ///< of the block that was encoded last
};

}  // namespace

Coder pipeline_coder(const RawSurface& surface, std::uint32_t attribute, const Pipeline& pipeline) {
  const auto coder = std::make_shared<PipelineCoder>(surface, attribute, pipeline);
  return {
      pipeline.to_text(),
      [coder](const RawBlock& block, std::span<std::byte> to) { return coder->encode(block, to); },
      [coder](std::span<const std::byte> encoded, const RawBlock& block, std::span<std::byte> raw) {
        coder->decode(encoded, block, raw);
        return true;
      }};
}

}  // namespace plait::bench
