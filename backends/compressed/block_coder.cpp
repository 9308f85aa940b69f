#include "compressed/block_coder.h"

#include <algorithm>
#include <utility>

namespace plait {

BlockCoder::BlockCoder(const std::string& codec, std::string filter, std::size_t component_bytes,
                       std::uint64_t max_raw_bytes)
    : codec_(make_codec(codec)),
      filter_(std::move(filter)),
      component_bytes_(component_bytes),
      filters_(make_filter_chain(filter_, component_bytes)),
      max_raw_bytes_(max_raw_bytes) {}

std::uint64_t BlockCoder::memory_bytes() const {
  return max_encoded_bytes(max_raw_bytes_) +
         std::min<std::size_t>(filters_.size(), 2) * max_raw_bytes_ +
         codec_->memory_bytes(max_raw_bytes_);
}

void BlockCoder::set_component_bytes(std::size_t component_bytes) {
  if (component_bytes == component_bytes_) return;
  filters_ = make_filter_chain(filter_, component_bytes);
  component_bytes_ = component_bytes;
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
