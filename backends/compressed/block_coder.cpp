#include "compressed/block_coder.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "plait/backends/pipeline.h"

namespace plait {

BlockCoder::BlockCoder(const std::string& pipeline, std::size_t component_bytes,
                       std::uint64_t max_raw_bytes)
    : pipeline_(pipeline),
      component_bytes_(component_bytes),
      codec_(make_codec(parse_pipeline(pipeline).codec)),
      filters_(make_filter_chain(parse_pipeline(pipeline).filter, component_bytes)),
      max_raw_bytes_(max_raw_bytes) {}

std::uint64_t BlockCoder::memory_bytes() const {
  return max_encoded_bytes(max_raw_bytes_) +
         std::min<std::size_t>(filters_.size(), 2) * max_raw_bytes_ +
         codec_->memory_bytes(max_raw_bytes_);
}

void BlockCoder::set_pipeline(const std::string& pipeline, std::size_t component_bytes) {
  if (pipeline == pipeline_ && component_bytes == component_bytes_) return;
  const PipelineParts parts = parse_pipeline(pipeline);
  FilterChain filters = make_filter_chain(parts.filter, component_bytes);
  if (pipeline != pipeline_) {
    codec_ = make_codec(parts.codec);
    pipeline_ = pipeline;
  }
  filters_ = std::move(filters);
  component_bytes_ = component_bytes;
  // A shorter chain needs no more memory than memory_bytes() says of it.
  for (std::size_t i = filters_.size(); i < std::size(filtered_); ++i) filtered_[i] = Buffer();
}

void BlockCoder::make_room() {
  for (std::size_t i = 0; i < std::min<std::size_t>(filters_.size(), 2); ++i)
    filtered_[i].resize(max_raw_bytes_);
  stored_.resize(max_encoded_bytes(max_raw_bytes_));
}

EncodedBlock BlockCoder::encode(std::span<const std::byte> raw) {
  make_room();
  std::span<const std::byte> source = raw;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    const std::span<std::byte> filtered(filtered_[i % 2].data(), raw.size());
    filters_[i]->encode(source, filtered);
    source = filtered;
  }
  const std::span<std::byte> target(stored_.data(), max_encoded_bytes(raw.size()));
  const auto stored_bytes = codec_->compress(source, target);
  if (!stored_bytes || *stored_bytes == 0) return {BlockEncoding::kRaw, raw};
  return {BlockEncoding::kEncoded, target.first(*stored_bytes)};
}

std::span<std::byte> BlockCoder::stored_buffer(std::uint64_t stored_bytes) {
  make_room();
  return std::span(stored_).first(stored_bytes);
}

void BlockCoder::decode(std::span<const std::byte> stored, std::span<std::byte> raw) {
  make_room();
  if (filters_.empty()) return codec_->decompress(stored, raw);
  std::size_t stage = filters_.size() - 1;
  std::span<std::byte> source(filtered_[stage % 2].data(), raw.size());
  codec_->decompress(stored, source);
  for (; stage > 0; --stage) {
    const std::span<std::byte> target(filtered_[(stage - 1) % 2].data(), raw.size());
    filters_[stage]->decode(source, target);
    source = target;
  }
  filters_[0]->decode(source, raw);
}

}  // namespace plait
