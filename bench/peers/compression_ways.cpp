#include "peers/compression_ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "micro/support.h"
#include "plait/compression.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/block_table.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/registry.h"

namespace plait::bench {
namespace {

using Bytes = std::vector<std::byte>;

/// Presets are for both attributes, and `normals` is for normals only; positions then take the
/// other filter that predicts across levels. Presets lose the stage `predicted`, because it is a
/// way of its own.
Pipeline pipeline_for(const std::string& name, const AttributeSchema& schema) {
  if (name.starts_with("normals") && schema.name != "normal") return "hierarchy,none";
  if (name.find(',') != std::string::npos || name.find(':') != std::string::npos || name == "lz4")
    return name;
  return preset_pipeline(name, schema).without_predicted_stage();
}

/// The entropy of bytes with these counts, in bytes.
double entropy(const std::array<std::uint64_t, 256>& counts) {
  double all = 0, bits = 0;
  for (const std::uint64_t count : counts) all += static_cast<double>(count);
  for (const std::uint64_t count : counts)
    if (count > 0) bits -= static_cast<double>(count) * std::log2(static_cast<double>(count) / all);
  return bits / 8;
}

FilterLevel filter_level_of(const MeasuredAttribute& attribute) {
  FilterLevel level;
  level.schema = attribute.schema;
  level.geometry = attribute.finest;
  level.attribute = attribute.number;
  level.level = attribute.level;
  level.surroundings = &attribute.surface->surroundings;
  return level;
}

/// A pipeline for the blocks of one attribute.
class Coder {
 public:
  Coder(const MeasuredAttribute& attribute, const Pipeline& pipeline) : attribute_(attribute) {
    pipeline_ = default_pipelines().open(pipeline, filter_level_of(attribute));
    filters_alone_ = pipeline.codec.name == "none" && !pipeline.filters.empty();
    const std::size_t most = attribute.finest->max_block_bytes();
    buffers_.assign(pipeline_.filters.size() + 1, Bytes(most));
    encoded_.resize(pipeline_.codec->bound(most));
    std::size_t scratch = 0;
    for (const auto& filter : pipeline_.filters)
      scratch = std::max(scratch, filter->scratch_bytes());
    scratch_.resize(scratch);
  }

  /// Encodes and decodes a block. Errors: kCorruption if other bytes come back.
  void run(std::uint64_t block, std::span<const std::byte> raw, Sizes& sizes, Times& times,
           std::vector<std::array<std::uint64_t, 256>>* counts) {
    std::vector<std::span<const std::byte>> context;
    std::array<ContextBlock, kMostContextBlocks> blocks;
    if (!pipeline_.filters.empty())
      for (std::size_t i = 0, n = pipeline_.filters[0]->context(block, blocks); i < n; ++i)
        context.push_back(attribute_.surface->bytes_of(blocks[i]));
    std::byte note{};
    const FilterBlock with{block, context, scratch_, &note};
    std::size_t stored = 0;
    times.encode += thread_seconds([&] {
      std::span<const std::byte> from = raw;
      for (std::size_t i = 0; i < pipeline_.filters.size(); ++i) {
        const std::span<std::byte> to(buffers_[i].data(), raw.size());
        pipeline_.filters[i]->encode(with, from, to);
        from = to;
      }
      stored = filters_alone_ ? raw.size()
                              : pipeline_.codec->compress(from, encoded_).value_or(raw.size());
    });
    if (counts != nullptr) {
      const Bytes& filtered = buffers_[pipeline_.filters.size() - 1];
      for (std::size_t i = 0; i < raw.size(); ++i)
        ++(*counts)[i / (raw.size() / counts->size())][std::to_integer<std::size_t>(filtered[i])];
    }
    times.decode += thread_seconds([&] {
      const std::size_t count = pipeline_.filters.size();
      std::span<std::byte> to(buffers_[count - (filters_alone_ ? 1 : 0)].data(), raw.size());
      if (!filters_alone_) pipeline_.codec->decompress(std::span(encoded_).first(stored), to);
      for (std::size_t i = count; i > 0; --i) {
        const std::span<const std::byte> from = to;
        to = {buffers_[filters_alone_ ? count : i - 1].data(), raw.size()};
        pipeline_.filters[i - 1]->decode(with, from, to);
      }
    });
    if (!std::ranges::equal(std::span(buffers_[filters_alone_ ? 1 : 0]).first(raw.size()), raw))
      throw Error(ErrorCode::kCorruption, "decode: other bytes came back");
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(std::min(stored, raw.size()));
  }

  bool ends_with_shuffle(const Pipeline& pipeline) const {
    return !pipeline_.filters.empty() && pipeline.filters.back().name == "shuffle" &&
           !filters_alone_;
  }

 private:
  const MeasuredAttribute& attribute_;
  OpenPipeline pipeline_;
  std::vector<Bytes> buffers_;
  Bytes encoded_, scratch_;
  bool filters_alone_ = false;  ///< without a codec
};

}  // namespace

void run_pipeline(const MeasuredAttribute& attribute, const std::string& name, Sizes& sizes,
                  Times& times) {
  const Pipeline pipeline = pipeline_for(name, attribute.schema);
  Coder coder(attribute, pipeline);
  std::vector<std::array<std::uint64_t, 256>> counts(4);
  const bool planes = coder.ends_with_shuffle(pipeline);
  for (const std::uint64_t block : attribute.blocks)
    coder.run(block, attribute.bytes_of(block), sizes, times, planes ? &counts : nullptr);
  if (planes)
    for (const auto& plane : counts) sizes.entropy += entropy(plane);
}

void run_predicted(const MeasuredAttribute& attribute, Sizes& sizes, Times& times) {
  const std::string text =
      fmt::format("predicted:loop/{}/float32/{},none", attribute.schema.name, attribute.level);
  const OpenPipeline pipeline = default_pipelines().open(text, filter_level_of(attribute));
  Bytes back(attribute.finest->max_block_bytes());
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(block);
    const std::span<std::byte> made = std::span(back).first(raw.size());
    bool is_made = false;
    times.encode += thread_seconds([&] { is_made = pipeline.maker->makes(block, {}, raw); });
    times.decode += thread_seconds([&] { pipeline.maker->make(block, {}, made); });
    if (!is_made || !std::ranges::equal(made, raw))
      throw Error(ErrorCode::kCorruption, "predict: other bytes came back");
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += sizeof(BlockEntry);
  }
}

void run_peer(const MeasuredAttribute& attribute, const CompressionPeer& peer, Sizes& sizes,
              Times& times) {
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(block);
    const auto side = static_cast<std::size_t>(slot_side(attribute.level));
    const std::size_t records = raw.size() / 12;
    // Half slots have no rows of one length.
    const PeerBlock shape{raw, records % side == 0 ? side : 1,
                          records % side == 0 ? records / side : records};
    Bytes encoded, back(raw.size());
    times.encode += thread_seconds([&] { encoded = peer.encode(shape); });
    bool done = false;
    times.decode += thread_seconds([&] { done = peer.decode(encoded, shape, back); });
    if (!done || encoded.empty() || !std::ranges::equal(back, raw))
      throw Error(ErrorCode::kCorruption, fmt::format("{}: other bytes came back", peer.name));
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(std::min(encoded.size(), raw.size()));
  }
}

void run_copies(const MeasuredAttribute& attribute, Sizes& sizes, Times& times) {
  Bytes to(attribute.finest->max_block_bytes()), back(to.size());
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(block);
    times.encode += thread_seconds([&] { std::memcpy(to.data(), raw.data(), raw.size()); });
    times.decode += thread_seconds([&] { std::memcpy(back.data(), to.data(), raw.size()); });
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(raw.size());
  }
}

}  // namespace plait::bench
