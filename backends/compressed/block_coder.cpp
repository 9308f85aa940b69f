#include "compressed/block_coder.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

BlockCoder::BlockCoder(Pipeline pipeline, std::uint64_t max_raw_bytes)
    : pipeline_(std::move(pipeline)), max_raw_bytes_(max_raw_bytes) {}

std::uint64_t BlockCoder::memory_bytes() const {
  return max_encoded_bytes(max_raw_bytes_) +
         std::min<std::size_t>(pipeline_.filters.size(), 2) * max_raw_bytes_ +
         pipeline_.codec->memory_bytes(max_raw_bytes_);
}

void BlockCoder::make_room() {
  for (std::size_t i = 0; i < std::min<std::size_t>(pipeline_.filters.size(), 2); ++i)
    filtered_[i].resize(max_raw_bytes_);
  stored_.resize(max_encoded_bytes(max_raw_bytes_));
}

EncodedBlock BlockCoder::encode(std::span<const std::byte> raw) {
  make_room();
  std::span<const std::byte> source = raw;
  for (std::size_t i = 0; i < pipeline_.filters.size(); ++i) {
    const std::span<std::byte> filtered(filtered_[i % 2].data(), raw.size());
    pipeline_.filters[i]->encode(source, filtered);
    source = filtered;
  }
  const std::span<std::byte> target(stored_.data(), max_encoded_bytes(raw.size()));
  const auto stored_bytes = pipeline_.codec->compress(source, target);
  if (!stored_bytes || *stored_bytes == 0) return {BlockEncoding::kRaw, raw};
  return {BlockEncoding::kEncoded, target.first(*stored_bytes)};
}

std::span<std::byte> BlockCoder::stored_buffer(std::uint64_t stored_bytes) {
  make_room();
  return std::span(stored_).first(stored_bytes);
}

void BlockCoder::decode(std::span<const std::byte> stored, std::span<std::byte> raw) {
  make_room();
  if (pipeline_.filters.empty()) return pipeline_.codec->decompress(stored, raw);
  std::size_t stage = pipeline_.filters.size() - 1;
  std::span<std::byte> source(filtered_[stage % 2].data(), raw.size());
  pipeline_.codec->decompress(stored, source);
  for (; stage > 0; --stage) {
    const std::span<std::byte> target(filtered_[(stage - 1) % 2].data(), raw.size());
    pipeline_.filters[stage]->decode(source, target);
    source = target;
  }
  pipeline_.filters[0]->decode(source, raw);
}

PLAIT_END_NAMESPACE
