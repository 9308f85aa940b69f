#include "compressed/level_coder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/default_arithmetic.h"
#include "compressed/codec_time.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Coding coding_of(const Pipeline& pipeline, const OpenPipeline& open) {
  return {pipeline.codec, std::min<std::size_t>(open.filters.size(), 2),
          scratch_bytes(open.filters), open.maker ? open.maker->scratch_bytes() : 0};
}

LevelCoder::LevelCoder(const LevelSpec& level, OpenPipeline pipeline,
                       std::span<const BlockTable* const> open_tables)
    : path_(level.path()),
      coding_(coding_of(level.pipeline, pipeline)),
      filters_(std::move(pipeline.filters)),
      context_(level, filters_, open_tables),
      maker_(std::move(pipeline.maker)),
      why_no_maker_(std::move(pipeline.why_no_maker)) {}

std::size_t LevelCoder::sources_of(std::uint64_t block, Needed needed) const noexcept {
  return maker_ ? maker_->sources(block, needed) : 0;
}

std::size_t LevelCoder::context(std::uint64_t block, Needed needed) const noexcept {
  std::array<ContextBlock, kMostContextBlocks> others;
  const std::size_t sources = sources_of(block, needed), count = context_.blocks_for(block, others);
  std::copy_n(others.begin(), count, needed.begin() + static_cast<std::ptrdiff_t>(sources));
  return sources + count;
}

std::size_t LevelCoder::read_context(std::uint64_t block, BlockEncoding encoding,
                                     Needed needed) const noexcept {
  switch (encoding) {
    case BlockEncoding::kPredicted:
      return sources_of(block, needed);
    case BlockEncoding::kEncoded:
      return context_.blocks_for(block, needed);
    default:
      return 0;
  }
}

bool LevelCoder::needs_base_records(BlockEncoding encoding,
                                    std::uint32_t attribute) const noexcept {
  switch (encoding) {
    case BlockEncoding::kPredicted:
      return maker_ && maker_->source_attribute() == attribute;
    case BlockEncoding::kEncoded:
      return context_.base_attribute() == attribute;
    default:
      return false;
  }
}

// The context of a transfer is that of context() or that of read_context(). So the sources are at
// its beginning, and what the filters need is at its end.
LevelCoder::Given LevelCoder::for_maker(std::uint64_t block, Given given) const {
  std::array<ContextBlock, kMostContextBlocks> needed;
  return given.first(std::min(given.size(), sources_of(block, needed)));
}

LevelCoder::Given LevelCoder::for_filters(std::uint64_t block, Given given) const {
  std::array<ContextBlock, kMostContextBlocks> needed;
  return given.last(std::min(given.size(), context_.blocks_for(block, needed)));
}

bool LevelCoder::makes(std::uint64_t block, Given given, std::span<const std::byte> raw) const {
  if (!maker_) return false;
  const Given sources = for_maker(block, given);
  const CodecTimer timer;
  return maker_->makes(block, sources, raw);
}

void LevelCoder::make(std::uint64_t block, Given given, std::span<std::byte> raw) const {
  if (!maker_)
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("read {}: block {} is predicted and cannot be made again: {}", path_.native(),
                    block,
                    why_no_maker_.empty() ? "its level has no stage `predicted`" : why_no_maker_));
  const Given sources = for_maker(block, given);
  const CodecTimer timer;
  maker_->make(block, sources, raw);
}

EncodedBlock LevelCoder::encode(BlockCoder& coder, std::uint64_t block, Given given,
                                std::span<const std::byte> raw) const {
  const DefaultArithmetic arithmetic;
  const Given context = for_filters(block, given);
  return coder.encode({filters_, {block, context, {}}, context_.seal(block, context)}, raw);
}

void LevelCoder::decode(BlockCoder& coder, std::uint64_t block, Given given,
                        std::span<const std::byte> stored, std::span<std::byte> raw) const {
  const DefaultArithmetic arithmetic;
  const Given context = for_filters(block, given);
  coder.decode({filters_, {block, context, {}}, context_.seal(block, context)}, stored, raw);
}

PLAIT_END_NAMESPACE
